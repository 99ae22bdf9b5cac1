// SPDX-License-Identifier: MIT OR Apache-2.0
//! How the bits of a block are laid out (Khronos Data Format Specification 1.3, the chapter on BPTC).

use std::sync::LazyLock;

use super::palette::{STEPS_OF_3_BITS, STEPS_OF_4_BITS};
use super::partition::PARTITIONS;

/// Endpoints of both regions: first of the first, second of the first, first of the second, second of the second.
pub const ENDS: usize = 4;

/// A mode: how many bits which endpoint has.
#[derive(Debug)]
pub struct Mode {
    /// Bits of the first endpoint's red, green and blue.
    pub bits: u32,
    /// Bits of the others: differences to the first where they are fewer, endpoints by themselves where they are as many.
    pub rest: [u32; 3],
    /// One region with indices of 4 bits, or two of 3 bits.
    pub regions: usize,
    /// The bits that tell the mode, and how many.
    head: (u32, u32),
    /// The endpoints' bits in the order of the file.
    fields: LazyLock<Vec<Bit>>,
}

impl Mode {
    /// What may lie between an endpoint and the first one, a channel at a time: least and most.
    pub fn reach(&self) -> [[i32; 2]; 3] {
        self.rest.map(|bits| match bits == self.bits {
            true => [-(1 << bits), 1 << bits],
            false => [-(1 << (bits - 1)), (1 << (bits - 1)) - 1],
        })
    }

    /// The steps of its indices.
    pub fn steps(&self) -> &'static [f32] {
        if self.regions == 2 { &STEPS_OF_3_BITS } else { &STEPS_OF_4_BITS }
    }

    /// The largest code.
    pub fn top(&self) -> i32 {
        (1 << self.bits) - 1
    }
}

/// Every mode, in the order of their numbers, which count from 1.
pub static MODES: [Mode; 14] = [
    Mode {
        bits: 10,
        rest: [5, 5, 5],
        regions: 2,
        head: (0b00, 2),
        fields: LazyLock::new(|| {
            bits(
                "g2:4 b2:4 b3:4 r0:0-9 g0:0-9 b0:0-9 r1:0-4 g3:4 g2:0-3 g1:0-4 b3:0 g3:0-3 b1:0-4 b3:1 b2:0-3 r2:0-4 \
                 b3:2 r3:0-4 b3:3",
            )
        }),
    },
    Mode {
        bits: 7,
        rest: [6, 6, 6],
        regions: 2,
        head: (0b01, 2),
        fields: LazyLock::new(|| {
            bits(
                "g2:5 g3:4 g3:5 r0:0-6 b3:0 b3:1 b2:4 g0:0-6 b2:5 b3:2 g2:4 b0:0-6 b3:3 b3:5 b3:4 r1:0-5 g2:0-3 \
                 g1:0-5 g3:0-3 b1:0-5 b2:0-3 r2:0-5 r3:0-5",
            )
        }),
    },
    Mode {
        bits: 11,
        rest: [5, 4, 4],
        regions: 2,
        head: (0b00010, 5),
        fields: LazyLock::new(|| {
            bits(
                "r0:0-9 g0:0-9 b0:0-9 r1:0-4 r0:10 g2:0-3 g1:0-3 g0:10 b3:0 g3:0-3 b1:0-3 b0:10 b3:1 b2:0-3 r2:0-4 \
                 b3:2 r3:0-4 b3:3",
            )
        }),
    },
    Mode {
        bits: 11,
        rest: [4, 5, 4],
        regions: 2,
        head: (0b00110, 5),
        fields: LazyLock::new(|| {
            bits(
                "r0:0-9 g0:0-9 b0:0-9 r1:0-3 r0:10 g3:4 g2:0-3 g1:0-4 g0:10 g3:0-3 b1:0-3 b0:10 b3:1 b2:0-3 r2:0-3 \
                 b3:0 b3:2 r3:0-3 g2:4 b3:3",
            )
        }),
    },
    Mode {
        bits: 11,
        rest: [4, 4, 5],
        regions: 2,
        head: (0b01010, 5),
        fields: LazyLock::new(|| {
            bits(
                "r0:0-9 g0:0-9 b0:0-9 r1:0-3 r0:10 b2:4 g2:0-3 g1:0-3 g0:10 b3:0 g3:0-3 b1:0-4 b0:10 b2:0-3 r2:0-3 \
                 b3:1 b3:2 r3:0-3 b3:4 b3:3",
            )
        }),
    },
    Mode {
        bits: 9,
        rest: [5, 5, 5],
        regions: 2,
        head: (0b01110, 5),
        fields: LazyLock::new(|| {
            bits(
                "r0:0-8 b2:4 g0:0-8 g2:4 b0:0-8 b3:4 r1:0-4 g3:4 g2:0-3 g1:0-4 b3:0 g3:0-3 b1:0-4 b3:1 b2:0-3 r2:0-4 \
                 b3:2 r3:0-4 b3:3",
            )
        }),
    },
    Mode {
        bits: 8,
        rest: [6, 5, 5],
        regions: 2,
        head: (0b10010, 5),
        fields: LazyLock::new(|| {
            bits(
                "r0:0-7 g3:4 b2:4 g0:0-7 b3:2 g2:4 b0:0-7 b3:3 b3:4 r1:0-5 g2:0-3 g1:0-4 b3:0 g3:0-3 b1:0-4 b3:1 \
                 b2:0-3 r2:0-5 r3:0-5",
            )
        }),
    },
    Mode {
        bits: 8,
        rest: [5, 6, 5],
        regions: 2,
        head: (0b10110, 5),
        fields: LazyLock::new(|| {
            bits(
                "r0:0-7 b3:0 b2:4 g0:0-7 g2:5 g2:4 b0:0-7 g3:5 b3:4 r1:0-4 g3:4 g2:0-3 g1:0-5 g3:0-3 b1:0-4 b3:1 \
                 b2:0-3 r2:0-4 b3:2 r3:0-4 b3:3",
            )
        }),
    },
    Mode {
        bits: 8,
        rest: [5, 5, 6],
        regions: 2,
        head: (0b11010, 5),
        fields: LazyLock::new(|| {
            bits(
                "r0:0-7 b3:1 b2:4 g0:0-7 b2:5 g2:4 b0:0-7 b3:5 b3:4 r1:0-4 g3:4 g2:0-3 g1:0-4 b3:0 g3:0-3 b1:0-5 \
                 b2:0-3 r2:0-4 b3:2 r3:0-4 b3:3",
            )
        }),
    },
    Mode {
        bits: 6,
        rest: [6, 6, 6],
        regions: 2,
        head: (0b11110, 5),
        fields: LazyLock::new(|| {
            bits(
                "r0:0-5 g3:4 b3:0 b3:1 b2:4 g0:0-5 g2:5 b2:5 b3:2 g2:4 b0:0-5 g3:5 b3:3 b3:5 b3:4 r1:0-5 g2:0-3 \
                 g1:0-5 g3:0-3 b1:0-5 b2:0-3 r2:0-5 r3:0-5",
            )
        }),
    },
    Mode {
        bits: 10,
        rest: [10, 10, 10],
        regions: 1,
        head: (0b00011, 5),
        fields: LazyLock::new(|| bits("r0:0-9 g0:0-9 b0:0-9 r1:0-9 g1:0-9 b1:0-9")),
    },
    Mode {
        bits: 11,
        rest: [9, 9, 9],
        regions: 1,
        head: (0b00111, 5),
        fields: LazyLock::new(|| bits("r0:0-9 g0:0-9 b0:0-9 r1:0-8 r0:10 g1:0-8 g0:10 b1:0-8 b0:10")),
    },
    Mode {
        bits: 12,
        rest: [8, 8, 8],
        regions: 1,
        head: (0b01011, 5),
        fields: LazyLock::new(|| bits("r0:0-9 g0:0-9 b0:0-9 r1:0-7 r0:11>10 g1:0-7 g0:11>10 b1:0-7 b0:11>10")),
    },
    Mode {
        bits: 16,
        rest: [4, 4, 4],
        regions: 1,
        head: (0b01111, 5),
        fields: LazyLock::new(|| bits("r0:0-9 g0:0-9 b0:0-9 r1:0-3 r0:15>10 g1:0-3 g0:15>10 b1:0-3 b0:15>10")),
    },
];

/// A bit of an endpoint.
#[derive(Clone, Copy, Debug)]
struct Bit {
    channel: usize,
    end: usize,
    bit: u32,
}

/// From words of a channel, an endpoint and its bits: one, `0-9` from the lowest to the highest, `15>10` from the highest
/// to the lowest.
fn bits(fields: &str) -> Vec<Bit> {
    let of_field = |field: &str| {
        let (name, range) = field.split_once(':').expect("a field is an endpoint and its bits");
        let name = name.as_bytes();
        let channel = b"rgb".iter().position(|c| *c == name[0]).expect("red, green or blue");
        let end = usize::from(name[1] - b'0');
        let number = |text: &str| text.parse::<u32>().expect("a bit's number");
        let run: Vec<u32> = match (range.split_once('-'), range.split_once('>')) {
            (Some((low, high)), _) => (number(low)..=number(high)).collect(),
            (_, Some((high, low))) => (number(low)..=number(high)).rev().collect(),
            _ => vec![number(range)],
        };
        run.into_iter().map(move |bit| Bit { channel, end, bit }).collect::<Vec<_>>()
    };
    fields.split_whitespace().flat_map(of_field).collect()
}

/// What a block says.
#[derive(Clone, Copy, Debug)]
pub struct Content {
    /// One of [`MODES`].
    pub mode: &'static Mode,
    /// Which of [`PARTITIONS`]; 0 of one region.
    pub partition: usize,
    /// Codes of red, green and blue of every endpoint, within the mode's reach.
    pub ends: [[i32; 3]; ENDS],
    /// Index of every texel. Those of the anchors have a top bit of 0.
    pub indices: [u8; 16],
}

/// The bytes of a block.
pub fn pack(content: &Content) -> [u8; 16] {
    let mode = content.mode;
    let (mut word, mut at) = (0_u128, 0);
    let mut put = |value: u32, bits: u32| {
        word |= u128::from(value) << at;
        at += bits;
    };
    put(mode.head.0, mode.head.1);

    // Endpoints: a difference keeps its low bits, which is its two's complement.
    for bit in mode.fields.iter() {
        let code = content.ends[bit.end][bit.channel];
        let is_difference = bit.end > 0 && mode.rest[bit.channel] < mode.bits;
        let stored = if is_difference { code - content.ends[0][bit.channel] } else { code };
        put((stored >> bit.bit) as u32 & 1, 1);
    }

    // The partition and the indices.
    let mut anchors = [0, 0];
    if mode.regions == 2 {
        put(content.partition as u32, 5);
        anchors[1] = PARTITIONS[content.partition].anchor;
    }
    for (texel, index) in content.indices.iter().enumerate() {
        let bits = if mode.regions == 2 { 3 } else { 4 };
        put(u32::from(*index), bits - u32::from(anchors.contains(&texel)));
    }
    word.to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_of_a_block_is_used_once() {
        for (i, mode) in MODES.iter().enumerate() {
            let ends = 2 * mode.regions;
            let mut seen = std::collections::BTreeSet::new();
            for bit in mode.fields.iter() {
                let most = if bit.end == 0 { mode.bits } else { mode.rest[bit.channel] };
                assert!(bit.end < ends && bit.bit < most, "mode {}: {bit:?}", i + 1);
                assert!(seen.insert((bit.channel, bit.end, bit.bit)), "mode {}: {bit:?} twice", i + 1);
            }
            let codes = 3 * mode.bits + (ends as u32 - 1) * mode.rest.iter().sum::<u32>();
            assert_eq!(seen.len(), codes as usize, "mode {}", i + 1);
            let indices = if mode.regions == 2 { 5 + 16 * 3 - 2 } else { 16 * 4 - 1 };
            assert_eq!(mode.head.1 + codes + indices, 128, "mode {}", i + 1);
        }
    }

    #[test]
    fn partitions_hold_their_anchor_and_not_texel_0() {
        for partition in PARTITIONS {
            assert!(partition.second & 1 == 0 && partition.second >> partition.anchor & 1 == 1, "{partition:?}");
        }
    }
}
