// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which roughness a mip holds: one law per family of engines. A shader that looks a map up inverts it.

use crate::error::{Error, Result, nearest};

/// How roughness runs over the mips m = 0..=M of a map whose mip 0 has faces of `size` texels.
///
/// Mip 0 always holds radiance itself, roughness 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RoughnessLaw {
    /// roughness = m/M: Bevy, Godot, glTF viewers.
    Linear,
    /// roughness = 1 − √(1 − m/M), finer steps where reflections are sharp: Filament, three.js.
    Quadratic,
    /// alpha = 2^(m/0.8)/size, at most 1: the footprint of a texel, as Babylon.js has it.
    Babylon,
    /// m = 6 · roughness (1.7 − 0.7 roughness), whatever M: Unity, whose shaders count six steps.
    Unity,
    /// roughness = 2^((1 − (M − m))/1.2), at most 1: Unreal Engine, whose last mip but one is the roughest.
    Unreal,
    /// alpha = t² up to t = m/M = ½, then 2(t − 3/8), at most 1: MaterialX.
    Materialx,
    /// roughness = 2m/11 and 1 at mip 6: specular powers 2^(11 − 2m), as PlayCanvas' atlas has it.
    Playcanvas,
}

impl RoughnessLaw {
    /// All laws, in the order of their documentation.
    pub const ALL: [RoughnessLaw; 7] = [
        RoughnessLaw::Linear,
        RoughnessLaw::Quadratic,
        RoughnessLaw::Babylon,
        RoughnessLaw::Unity,
        RoughnessLaw::Unreal,
        RoughnessLaw::Materialx,
        RoughnessLaw::Playcanvas,
    ];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            RoughnessLaw::Linear => "linear",
            RoughnessLaw::Quadratic => "quadratic",
            RoughnessLaw::Babylon => "babylon",
            RoughnessLaw::Unity => "unity",
            RoughnessLaw::Unreal => "unreal",
            RoughnessLaw::Materialx => "materialx",
            RoughnessLaw::Playcanvas => "playcanvas",
        }
    }

    /// The law with this name.
    pub fn parse(name: &str) -> Result<Self> {
        let known = || Self::ALL.iter().map(|l| l.name());
        Self::ALL
            .into_iter()
            .find(|l| l.name() == name)
            .ok_or_else(|| Error::usage(format!("unknown roughness law '{name}'"), nearest(name, known())))
    }

    /// The law in words, for lists: the level of detail that a shader looks up.
    pub fn about(self) -> &'static str {
        match self {
            RoughnessLaw::Linear => "lod = roughness * M",
            RoughnessLaw::Quadratic => "lod = roughness * (2 - roughness) * M",
            RoughnessLaw::Babylon => "lod = 0.8 * log2(size * alpha)",
            RoughnessLaw::Unity => "lod = 6 * roughness * (1.7 - 0.7 * roughness)",
            RoughnessLaw::Unreal => "lod = M - 1 + 1.2 * log2(roughness)",
            RoughnessLaw::Materialx => "lod = M * (alpha < 0.25 ? sqrt(alpha) : alpha / 2 + 0.375)",
            RoughnessLaw::Playcanvas => "lod = 5.5 * roughness",
        }
    }

    /// Perceptual roughness of mip `m` of 0..=`last`, in [0, 1].
    pub fn roughness(self, m: u32, last: u32, size: u32) -> f64 {
        if m == 0 {
            return 0.0;
        }
        let (mip, x) = (f64::from(m), f64::from(m) / f64::from(last));
        let roughness = match self {
            RoughnessLaw::Linear => x,
            // 1 − √(1 − x) without cancellation.
            RoughnessLaw::Quadratic => x / (1.0 + (1.0 - x).sqrt()),
            RoughnessLaw::Babylon => ((mip / 0.8).exp2() / f64::from(size)).sqrt(),
            RoughnessLaw::Unity if m >= 6 => 1.0,
            RoughnessLaw::Unity => (1.7 - (2.89 - 2.8 * mip / 6.0).sqrt()) / 1.4,
            RoughnessLaw::Unreal => ((1.0 - f64::from(last - m)) / 1.2).exp2(),
            RoughnessLaw::Materialx if x < 0.5 => x,
            RoughnessLaw::Materialx => (2.0 * (x - 0.375)).sqrt(),
            RoughnessLaw::Playcanvas if m >= 6 => 1.0,
            RoughnessLaw::Playcanvas => 2.0 * mip / 11.0,
        };
        roughness.min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_rise_from_0_to_1() {
        for law in RoughnessLaw::ALL {
            let all: Vec<f64> = (0..=8).map(|m| law.roughness(m, 8, 256)).collect();
            assert_eq!((all[0], all[8]), (0.0, 1.0), "{law:?}");
            assert!(all.windows(2).all(|pair| pair[0] <= pair[1]), "{law:?}: {all:?}");
            assert_eq!(RoughnessLaw::parse(law.name()).expect("its own name"), law);
        }
    }

    #[test]
    fn shaders_look_up_the_mip_that_holds_a_roughness() {
        // The levels of detail as the engines compute them, of a map with mips 0..=8 and faces of 256 texels.
        let lod = |law, r: f64| match law {
            RoughnessLaw::Linear => 8.0 * r,
            RoughnessLaw::Quadratic => 8.0 * r * (2.0 - r),
            RoughnessLaw::Babylon => 0.8 * (256.0 * r * r).log2(),
            RoughnessLaw::Unity => 6.0 * r * (1.7 - 0.7 * r),
            RoughnessLaw::Unreal => 8.0 - (1.0 - 1.2 * r.log2()),
            RoughnessLaw::Materialx if r * r < 0.25 => 8.0 * r,
            RoughnessLaw::Materialx => 8.0 * (r * r / 2.0 + 0.375),
            RoughnessLaw::Playcanvas => 5.5 * r,
        };
        for law in RoughnessLaw::ALL {
            for m in 1..=5 {
                let back = lod(law, law.roughness(m, 8, 256));
                assert!((back - f64::from(m)).abs() < 1e-12, "{law:?}: mip {m} is looked up at {back}");
            }
        }
    }
}
