// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a table of the split sum holds in its channels.

/// Where scale, bias and the tint of F82 are in a texel. Of scale, bias and their sum, the albedo, two are enough.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Parts {
    scale: Option<usize>,
    bias: Option<usize>,
    albedo: Option<usize>,
    f82: Option<usize>,
}

impl Parts {
    /// By the names of the channels; `None` where they do not say scale and bias.
    pub fn of(channels: &[impl AsRef<str>]) -> Option<Parts> {
        let at = |name: &str| channels.iter().position(|c| c.as_ref() == name);
        let parts = Parts { scale: at("scale"), bias: at("bias"), albedo: at("albedo"), f82: at("f82") };
        let known = [parts.scale, parts.bias, parts.albedo].into_iter().flatten().count();
        (known >= 2).then_some(parts)
    }

    /// Is there a tint?
    pub fn tinted(&self) -> bool {
        self.f82.is_some()
    }

    /// Scale, bias, and the tint or 0.
    pub fn of_texel(&self, texel: &[f32]) -> [f32; 3] {
        let at = |place: Option<usize>| place.map(|i| texel[i]);
        let (scale, bias, albedo) = (at(self.scale), at(self.bias), at(self.albedo).unwrap_or(0.0));
        let f82 = at(self.f82).unwrap_or(0.0);
        match (scale, bias) {
            (Some(scale), Some(bias)) => [scale, bias, f82],
            (Some(scale), None) => [scale, albedo - scale, f82],
            (None, bias) => [albedo - bias.unwrap_or(0.0), bias.unwrap_or(0.0), f82],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_of_three_are_enough() {
        let of = |names: &[&str], texel: &[f32]| Parts::of(names).map(|parts| parts.of_texel(texel));
        assert_eq!(of(&["bias", "scale"], &[0.25, 0.5]), Some([0.5, 0.25, 0.0]));
        assert_eq!(of(&["bias", "albedo", "f82"], &[0.25, 0.75, 0.03]), Some([0.5, 0.25, 0.03]));
        assert_eq!(of(&["scale", "albedo"], &[0.5, 0.75]), Some([0.5, 0.25, 0.0]));
        assert_eq!(of(&["albedo", "f82"], &[0.75, 0.03]), None);
        assert!(Parts::of(&["scale", "bias", "f82"]).is_some_and(|parts| parts.tinted()));
    }
}
