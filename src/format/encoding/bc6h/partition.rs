// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ways to split a block into two regions: the first 32 two-subset partitions of BPTC (Khronos Data Format
//! Specification 1.3; OpenGL's `ARB_texture_compression_bptc` has the same).

/// A split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Partition {
    /// Bit t is set where texel t, in rows from the top left, belongs to the second region.
    pub second: u16,
    /// The texel of the second region whose index is stored without its top bit, which is 0. Of the first region it is
    /// texel 0.
    pub anchor: usize,
}

/// Every split, in the order of their numbers.
pub static PARTITIONS: [Partition; 32] = [
    at(0xcccc, 15),
    at(0x8888, 15),
    at(0xeeee, 15),
    at(0xecc8, 15),
    at(0xc880, 15),
    at(0xfeec, 15),
    at(0xfec8, 15),
    at(0xec80, 15),
    at(0xc800, 15),
    at(0xffec, 15),
    at(0xfe80, 15),
    at(0xe800, 15),
    at(0xffe8, 15),
    at(0xff00, 15),
    at(0xfff0, 15),
    at(0xf000, 15),
    at(0xf710, 15),
    at(0x008e, 2),
    at(0x7100, 8),
    at(0x08ce, 2),
    at(0x008c, 2),
    at(0x7310, 8),
    at(0x3100, 8),
    at(0x8cce, 15),
    at(0x088c, 2),
    at(0x3110, 8),
    at(0x6666, 2),
    at(0x366c, 2),
    at(0x17e8, 8),
    at(0x0ff0, 8),
    at(0x718e, 2),
    at(0x399c, 2),
];

const fn at(second: u16, anchor: usize) -> Partition {
    Partition { second, anchor }
}
