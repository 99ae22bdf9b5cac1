// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which way the axes of a file point, for engines that turn or mirror directions before they look a map up.

use crate::error::{Error, Result};

/// A permutation of the axes, with signs: the direction (x, y, z) of a file shows the direction that its name spells.
/// `x,y,-z` shows at the file's +Z what the environment has at −Z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileAxes {
    /// Component i of the environment's direction is component `from[i]` of the file's, negated where `negative[i]`.
    from: [usize; 3],
    negative: [bool; 3],
}

impl Default for FileAxes {
    fn default() -> Self {
        FileAxes::IDENTITY
    }
}

impl FileAxes {
    /// The file shows every direction where it is.
    pub const IDENTITY: FileAxes = FileAxes { from: [0, 1, 2], negative: [false; 3] };

    /// The name used on the command line and in files, such as `x,y,-z`.
    pub fn name(&self) -> String {
        let part = |i: usize| format!("{}{}", if self.negative[i] { "-" } else { "" }, ["x", "y", "z"][self.from[i]]);
        [part(0), part(1), part(2)].join(",")
    }

    /// The axes with this name.
    pub fn parse(text: &str) -> Result<FileAxes> {
        let mut axes = FileAxes::IDENTITY;
        let mut seen = [false; 3];
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        for (i, part) in parts.iter().enumerate().take(3) {
            let (negative, letter) = part.strip_prefix('-').map_or((false, *part), |letter| (true, letter));
            if let Some(axis) = ["x", "y", "z"].iter().position(|name| *name == letter) {
                (axes.from[i], axes.negative[i]) = (axis, negative);
                seen[axis] = true;
            }
        }
        if parts.len() != 3 || seen != [true; 3] {
            return Err(Error::usage(
                format!("'{text}' does not name the three axes"),
                "name x, y and z once each, with or without a minus, e.g. --file-axes x,y,-z",
            ));
        }
        Ok(axes)
    }

    /// The matrix from directions of the file to the environment's.
    pub fn rows(&self) -> [[f64; 3]; 3] {
        std::array::from_fn(|i| {
            let mut row = [0.0; 3];
            row[self.from[i]] = if self.negative[i] { -1.0 } else { 1.0 };
            row
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for name in ["x,y,z", "x,y,-z", "-z,y,x", "-x,-y,-z"] {
            assert_eq!(FileAxes::parse(name).expect(name).name(), name);
        }
        for name in ["", "x,y", "x,y,y", "x,y,z,z", "x,y,w", "x,y,--z"] {
            assert!(FileAxes::parse(name).is_err(), "{name}");
        }
    }

    #[test]
    fn rows_carry_the_files_directions_to_the_environments() {
        let rows = FileAxes::parse("-z,y,x").expect("it is a name").rows();
        let d = [1.0, 2.0, 3.0];
        let shown: [f64; 3] = rows.map(|row| row.iter().zip(d).map(|(a, b)| a * b).sum());
        assert_eq!(shown, [-3.0, 2.0, 1.0]);
    }
}
