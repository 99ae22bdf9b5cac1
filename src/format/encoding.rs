//! How a value is stored: components × representation.

use crate::error::{Error, Result, nearest};

/// How one component is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repr {
    /// IEEE 754 half float: 11 significant bits, largest value 65504.
    F16,
    /// IEEE 754 single float.
    F32,
    /// Unsigned integer over [0, 1], 8 bits.
    Unorm8,
    /// Unsigned integer over [0, 1], 16 bits.
    Unorm16,
    /// Radiance RGBE: 8-bit mantissas that share one exponent.
    Rgbe8,
}

/// A texel's encoding, named after Vulkan's formats in lower case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Encoding {
    /// The name used on the command line and in files.
    pub name: &'static str,
    /// Components a texel: 1, 2, 3 or 4. Components beyond the table's channels hold 0, a fourth one 1.
    pub components: usize,
    /// How each component is stored.
    pub repr: Repr,
}

/// Every encoding, in the order of their documentation.
pub const ENCODINGS: &[Encoding] = &[
    Encoding { name: "r16f", components: 1, repr: Repr::F16 },
    Encoding { name: "rg16f", components: 2, repr: Repr::F16 },
    Encoding { name: "rgba16f", components: 4, repr: Repr::F16 },
    Encoding { name: "r32f", components: 1, repr: Repr::F32 },
    Encoding { name: "rg32f", components: 2, repr: Repr::F32 },
    Encoding { name: "rgba32f", components: 4, repr: Repr::F32 },
    Encoding { name: "r8unorm", components: 1, repr: Repr::Unorm8 },
    Encoding { name: "rgb8unorm", components: 3, repr: Repr::Unorm8 },
    Encoding { name: "r16unorm", components: 1, repr: Repr::Unorm16 },
    Encoding { name: "rgb16unorm", components: 3, repr: Repr::Unorm16 },
    Encoding { name: "rgbe8", components: 3, repr: Repr::Rgbe8 },
];

impl Encoding {
    /// The encoding with this name.
    pub fn parse(name: &str) -> Result<Encoding> {
        ENCODINGS.iter().copied().find(|e| e.name == name).ok_or_else(|| {
            Error::usage(format!("unknown encoding '{name}'"), nearest(name, ENCODINGS.iter().map(|e| e.name)))
        })
    }
}
