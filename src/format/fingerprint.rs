// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a file says of its texels, so that a change to them is found and, where one texel changed, named.
//!
//! **What is hashed.** The texels as they are stored: level 0 first, faces in order, rows from the top, texels from the
//! left; of each texel the components that hold channels, in the representation of the encoding, little endian (of
//! [`Repr::Rgbe8`] all four bytes). Where components share bits or texels share blocks, it is the channels' decoded values
//! as single floats. Headers, compression and components that only fill a texel are left out, so that the same values
//! have the same hash in every container that holds their representation.
//!
//! **`texels.sha256`** is the SHA-256 of these bytes, as 64 hexadecimal digits.
//!
//! **`texels.sums`** finds the place. With v_i = `mixed`(i, texel i), i from 1, and p = 2^61 − 1, it is Σ v_i mod p and
//! Σ i v_i mod p, as 16 hexadecimal digits each. One changed texel moves its v_i by some d, so the sums move by d and i d,
//! and their quotient is i. Several changes move them by unrelated amounts, even where equal texels changed alike, since
//! v_i depends on i: the quotient is then an index only by a chance of (number of texels)/p.

use sha2::{Digest, Sha256};

use super::encoding::{Pictures, Storage, encode, fits, stored};
use super::{Encoding, Repr};
use crate::error::{Error, Result};
use crate::texture::{Meta, Texture};

/// The key of the hash.
pub const SHA256: &str = "texels.sha256";
/// The key of the sums.
pub const SUMS: &str = "texels.sums";

/// 2^61 − 1, a prime.
const P: u64 = (1 << 61) - 1;
/// Texels that are encoded at a time.
const CHUNK: usize = 1 << 14;

/// See the module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fingerprint {
    /// 64 hexadecimal digits.
    pub sha256: String,
    /// Σ v_i and Σ i v_i modulo 2^61 − 1.
    pub sums: [u64; 2],
}

/// Which texels differ from those that a fingerprint was taken of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Changed {
    /// This one, counted from 0 over all levels.
    One(u64),
    /// More than one.
    Several,
}

impl Fingerprint {
    /// Of a texture as a file will store it; an error where its texels do not fit.
    pub fn of(texture: &Texture, storage: impl Into<Storage>) -> Result<Fingerprint> {
        let storage = storage.into();
        if is_plain(storage.encoding) {
            return Self::of_stored(texture, storage.encoding);
        }
        Self::of_levels(&stored(texture, storage)?, texture.channels.len(), storage.encoding)
    }

    /// Of a texture that was read from a file.
    pub fn of_stored(texture: &Texture, encoding: Encoding) -> Result<Fingerprint> {
        fits(texture.channels.len(), encoding)?;
        Self::of_levels(&texture.levels, texture.channels.len(), encoding)
    }

    /// Of levels as a reader finds them.
    pub(super) fn of_levels(levels: &[Vec<f32>], channels: usize, encoding: Encoding) -> Result<Fingerprint> {
        let plain = match encoding.repr {
            Repr::Rgbe8 => encoding,
            _ if is_plain(encoding) => Encoding { components: channels, ..encoding },
            _ => Encoding { components: channels, repr: Repr::F32, ..encoding },
        };
        let mut taking = Taking::default();
        for level in levels {
            for values in level.chunks(CHUNK * channels) {
                let pictures = Pictures { width: (values.len() / channels) as u32, height: 1, count: 1 };
                taking.add(encode(values, channels, pictures, plain)?, plain.unit_bytes());
            }
        }
        Ok(taking.done())
    }

    /// Of levels as a file stores them; `None` of an encoding whose bytes are not what is hashed.
    pub(super) fn of_bytes(levels: &[Vec<u8>], channels: usize, encoding: Encoding) -> Option<Fingerprint> {
        if !is_plain(encoding) {
            return None;
        }
        let unit = encoding.unit_bytes();
        let used = if encoding.repr == Repr::Rgbe8 { unit } else { unit / encoding.components * channels };
        let mut taking = Taking::default();
        for bytes in levels.iter().flat_map(|level| level.chunks(CHUNK * unit)) {
            taking.add(without_filling(bytes, unit, used), used);
        }
        Some(taking.done())
    }

    /// Puts it into a file's meta.
    pub fn state(&self, meta: &mut Meta) {
        meta.set(SHA256, &self.sha256);
        meta.set(SUMS, format!("{:016x} {:016x}", self.sums[0], self.sums[1]));
    }

    /// What a file's meta states; `None` where it states nothing, an error where that is no fingerprint.
    pub fn stated(meta: &Meta) -> Result<Option<Fingerprint>> {
        let (Some(sha256), Some(sums)) = (meta.get(SHA256), meta.get(SUMS)) else {
            return match meta.get(SHA256).or(meta.get(SUMS)) {
                None => Ok(None),
                Some(_) => {
                    Err(Error::usage(format!("the file states only one of {SHA256} and {SUMS}"), "bake it again"))
                }
            };
        };
        let number = |text: &str| u64::from_str_radix(text, 16).ok().filter(|n| *n < P);
        match sums.split_once(' ').map(|(a, b)| (number(a), number(b))) {
            Some((Some(a), Some(b))) => Ok(Some(Fingerprint { sha256: sha256.into(), sums: [a, b] })),
            _ => Err(Error::usage(format!("the file's {SUMS} is '{sums}', not two numbers"), "bake it again")),
        }
    }

    /// What changed since `stated` was taken, of `texels` texels; `None` where nothing did.
    pub fn changed_since(&self, stated: &Fingerprint, texels: u64) -> Option<Changed> {
        if self == stated {
            return None;
        }
        let [moved, moved_by_index] = [0, 1].map(|i| (self.sums[i] + P - stated.sums[i]) % P);
        // 0 has no inverse: its power is 0, and no index.
        let index = times(moved_by_index, power(moved, P - 2));
        Some(if (1..=texels).contains(&index) { Changed::One(index - 1) } else { Changed::Several })
    }
}

/// A fingerprint that is being taken.
#[derive(Default)]
struct Taking {
    hash: Sha256,
    sums: [u64; 2],
    index: u64,
}

impl Taking {
    /// At most [`CHUNK`] texels of `unit` bytes.
    fn add(&mut self, mut bytes: Vec<u8>, unit: usize) {
        self.hash.update(&bytes);
        // CHUNK values below 2^61, each times an index below 2^46: no more than 2^122 with room to spare.
        let mut sums = self.sums.map(u128::from);
        for halves in halves_of(&mut bytes, unit) {
            self.index += 1;
            let value = mixed(self.index, halves);
            sums[0] += u128::from(value);
            sums[1] += u128::from(self.index) * u128::from(value);
        }
        self.sums = sums.map(reduced);
    }

    fn done(self) -> Fingerprint {
        let sha256 = self.hash.finalize().iter().map(|b| format!("{b:02x}")).collect();
        Fingerprint { sha256, sums: self.sums }
    }
}

/// Texels of `unit` bytes without what only fills them up after the first `used`.
fn without_filling(bytes: &[u8], unit: usize, used: usize) -> Vec<u8> {
    // Copies of a known length are quick.
    fn cut<const UNIT: usize, const USED: usize>(bytes: &[u8]) -> Vec<u8> {
        let texels = bytes.as_chunks::<UNIT>().0.iter();
        texels.map(|texel| *texel.first_chunk().expect("a part of it")).collect::<Vec<[u8; USED]>>().into_flattened()
    }
    match (unit, used) {
        (8, 6) => cut::<8, 6>(bytes),
        (16, 12) => cut::<16, 12>(bytes),
        _ => bytes.chunks_exact(unit).flat_map(|texel| &texel[..used]).copied().collect(),
    }
}

/// Does encoding what was decoded give the same bytes again, component by component?
fn is_plain(encoding: Encoding) -> bool {
    matches!(encoding.repr, Repr::F16 | Repr::F32 | Repr::Unorm8 | Repr::Unorm16 | Repr::Rgbe8)
}

/// Texels of `unit` bytes, at most 16, filled up with zeros, as two words each. Appends to `bytes`, so that words may be
/// read beyond the last texel.
fn halves_of(bytes: &mut Vec<u8>, unit: usize) -> impl Iterator<Item = [u64; 2]> {
    let texels = bytes.len() / unit;
    bytes.extend([0; 16]);
    let mask = |bytes: usize| u64::MAX.checked_shr(64 - 8 * bytes.min(8) as u32).unwrap_or(0);
    let masks = [mask(unit), mask(unit.saturating_sub(8))];
    let bytes = &*bytes;
    (0..texels).map(move |i| {
        let word = |at: usize| bytes[at..].first_chunk().map_or(0, |word| u64::from_le_bytes(*word));
        [word(i * unit) & masks[0], word(i * unit + 8) & masks[1]]
    })
}

/// A number below [`P`] that looks drawn at random for every index and texel, given as two words.
fn mixed(index: u64, halves: [u64; 2]) -> u64 {
    // The finaliser of SplitMix64 (Steele et al. 2014), a bijection.
    let mix = |z: u64| {
        let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    reduced(halves.iter().fold(mix(index), |state, half| mix(state ^ half)).into())
}

/// A number below 2^122 modulo [`P`]: 2^61 is 1, so that the upper bits add to the lower ones.
fn reduced(number: u128) -> u64 {
    let sum = (number as u64 & P) + (number >> 61) as u64;
    if sum < P { sum } else { sum - P }
}

/// a · b modulo [`P`].
fn times(a: u64, b: u64) -> u64 {
    reduced(u128::from(a) * u128::from(b))
}

/// base^exponent modulo [`P`]; with the exponent P − 2 the inverse (Fermat).
fn power(base: u64, mut exponent: u64) -> u64 {
    let (mut result, mut square) = (1, base);
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = times(result, square);
        }
        square = times(square, square);
        exponent >>= 1;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Shape;

    fn texture() -> Texture {
        let levels = vec![(0..2 * 30_000).map(|i| (i as f32).sin()).collect()];
        let channels = ["a", "b"].map(String::from).to_vec();
        Texture { shape: Shape::Table, width: 300, height: 100, channels, levels, meta: Meta::default() }
    }

    fn next_up(value: &mut f32, ulps: u32) {
        *value = f32::from_bits(value.to_bits() + ulps);
    }

    #[test]
    fn sha256_is_that_of_the_stored_bytes() {
        let channels = vec!["a".to_string()];
        let (width, height, meta) = (1, 1, Meta::default());
        let one = Texture { shape: Shape::Table, width, height, channels, levels: vec![vec![1.0]], meta };
        let found = Fingerprint::of(&one, Encoding::parse("r16f").unwrap()).unwrap();
        // `printf '\000\074' | sha256sum`
        assert_eq!(found.sha256, "505114fe537172ea35e17ca1a7516edac516a89b31f983f7c6387d5d2bb462aa");
        assert_eq!(found.sums, [mixed(1, [0x3c00, 0]); 2]);
    }

    #[test]
    fn one_changed_texel_is_named_and_two_are_not() {
        for name in ["rg32f", "rgba32f"] {
            let encoding = Encoding::parse(name).unwrap();
            let stated = Fingerprint::of(&texture(), encoding).unwrap();
            let changed = |edit: &dyn Fn(&mut Vec<f32>)| {
                let mut texture = texture();
                edit(&mut texture.levels[0]);
                Fingerprint::of(&texture, encoding).unwrap().changed_since(&stated, 30_000)
            };
            assert_eq!(changed(&|_| ()), None);
            for texel in [0, 1, 16_383, 16_384, 29_999] {
                let one = changed(&|level| next_up(&mut level[2 * texel + 1], 1));
                assert_eq!(one, Some(Changed::One(texel as u64)), "{name}, texel {texel}");
            }
            let two = changed(&|level| [100, 300].iter().for_each(|i| next_up(&mut level[*i], 2)));
            assert_eq!(two, Some(Changed::Several));
            let alike = changed(&|level| level[..400].fill(0.5));
            assert_eq!(alike, Some(Changed::Several));
            assert_eq!(changed(&|level| level.rotate_right(2 * 300)), Some(Changed::Several), "rows shifted by one");
            assert_eq!(changed(&|level| level.swap(40, 42)), Some(Changed::Several), "sums that differ in one only");
        }
    }

    #[test]
    fn what_is_stated_comes_back_or_is_refused() {
        let found = Fingerprint::of(&texture(), Encoding::parse("rg16f").unwrap()).unwrap();
        let mut meta = Meta::default();
        assert_eq!(Fingerprint::stated(&meta).unwrap(), None);
        found.state(&mut meta);
        assert_eq!(Fingerprint::stated(&meta).unwrap(), Some(found));
        meta.set(SUMS, "12 x");
        assert!(Fingerprint::stated(&meta).unwrap_err().to_string().contains("not two numbers"));
    }
}
