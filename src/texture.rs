// SPDX-License-Identifier: MIT OR Apache-2.0
//! The one thing that travels between modules: texels as `f32`, with what they mean.

/// How the texels are arranged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A table of `width` × `height` texels, one level. A one-dimensional table has height 1.
    Table,
    /// The sphere in one picture of `width` × `height` texels with a chain of mips; the meta's `projection` says how.
    Map,
    /// A table of `depth` slices of `width` × `height` texels, one level: a 3-D texture.
    Volume {
        /// Slices.
        depth: u32,
    },
    /// `layers` tables of `width` × `height` texels behind each other, one level, with nothing between them: an array
    /// texture. From 2; one layer is a [`Shape::Table`].
    Array {
        /// Layers.
        layers: u32,
    },
    /// Six square faces (+X −X +Y −Y +Z −Z, oriented as the Vulkan and KTX2 specifications say) with a chain of mips.
    Cube,
}

/// Texels as `f32`, and the facts that a file states about them.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// One table or several, picture of the sphere, or cube.
    pub shape: Shape,
    /// Width of level 0 in texels.
    pub width: u32,
    /// Height of level 0 in texels.
    pub height: u32,
    /// What each channel holds, e.g. `["scale", "bias"]`. At most four.
    pub channels: Vec<String>,
    /// Level by level: faces, slices or layers in order, rows from the top, texels from the left, channels interleaved.
    pub levels: Vec<Vec<f32>>,
    /// What the file says of itself: model, axes, errors. Written and read by every format.
    pub meta: Meta,
}

impl Shape {
    /// How many tables follow each other, of a volume or an array.
    pub fn slices(self) -> Option<u32> {
        match self {
            Shape::Table | Shape::Map | Shape::Cube => None,
            Shape::Volume { depth: slices } | Shape::Array { layers: slices } => Some(slices),
        }
    }

    /// Does it hold tables, one or several, and no light?
    pub fn is_table(self) -> bool {
        self == Shape::Table || self.slices().is_some()
    }
}

impl Texture {
    /// Pictures of a level that follow each other: 1, 6 of a cube, the slices of a volume, the layers of an array.
    pub fn faces(&self) -> u32 {
        self.shape.slices().unwrap_or(if self.shape == Shape::Cube { 6 } else { 1 })
    }

    /// Width and height of a level, at least 1.
    pub fn level_size(&self, level: usize) -> (u32, u32) {
        ((self.width >> level).max(1), (self.height >> level).max(1))
    }

    /// The channels of one texel.
    pub fn texel(&self, level: usize, face: u32, x: u32, y: u32) -> &[f32] {
        let (width, height) = self.level_size(level);
        let n = self.channels.len();
        let index = ((face as usize * height as usize + y as usize) * width as usize + x as usize) * n;
        &self.levels[level][index..index + n]
    }

    /// Number of `f32` values that a level must hold.
    pub fn level_len(&self, level: usize) -> usize {
        let (width, height) = self.level_size(level);
        self.faces() as usize * width as usize * height as usize * self.channels.len()
    }
}

/// Ordered key–value pairs. Keys are lower-case words joined by dots and dashes, values are text without line breaks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Meta(Vec<(String, String)>);

impl Meta {
    /// Pairs of which no two have the same key.
    pub(crate) fn of_distinct<'a>(pairs: impl Iterator<Item = (&'a str, &'a str)>) -> Meta {
        Meta(pairs.map(|(key, value)| (key.into(), value.into())).collect())
    }

    /// Sets a key; a key that exists keeps its place.
    pub fn set(&mut self, key: &str, value: impl ToString) {
        let value = value.to_string();
        debug_assert!(!value.contains('\n'), "metadata values are single lines");
        match self.0.iter_mut().find(|(k, _)| k == key) {
            Some((_, old)) => *old = value,
            None => self.0.push((key.into(), value)),
        }
    }

    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str())
    }

    /// All pairs but those of some keys.
    pub fn without(&self, keys: &[&str]) -> Meta {
        Meta(self.0.iter().filter(|(k, _)| !keys.contains(&k.as_str())).cloned().collect())
    }

    /// All pairs in the order in which they were set.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(k, v)| (k.as_str(), v.as_str()))
    }

    /// `true` when nothing is stated.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meta_keeps_order_and_replaces() {
        let mut meta = Meta::default();
        meta.set("table", "split-sum");
        meta.set("ndf", "ggx");
        meta.set("table", "albedo");
        assert_eq!(meta.iter().collect::<Vec<_>>(), [("table", "albedo"), ("ndf", "ggx")]);
        assert_eq!(meta.without(&["table", "axes"]).iter().collect::<Vec<_>>(), [("ndf", "ggx")]);
    }

    #[test]
    fn texel_indexing_is_face_row_column() {
        let levels = vec![(0..6 * 4 * 3).map(|i| i as f32).collect(), (0..18).map(|i| i as f32).collect()];
        let channels = ["r", "g", "b"].map(String::from).to_vec();
        let cube = Texture { shape: Shape::Cube, width: 2, height: 2, channels, levels, meta: Meta::default() };
        assert_eq!(cube.texel(0, 1, 1, 0), [15.0, 16.0, 17.0]);
        assert_eq!(cube.texel(1, 5, 0, 0), [15.0, 16.0, 17.0]);
        assert_eq!(cube.level_len(0), 72);
    }
}
