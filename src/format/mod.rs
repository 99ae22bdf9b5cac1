// SPDX-License-Identifier: MIT OR Apache-2.0
//! File formats: one file each, and their registry.
//!
//! A [`Format`] turns a [`Texture`] into the bytes of a file and back, and touches no file itself. [`Output`] puts the
//! bytes in place: it is prepared before the work, so that a path that cannot be written is found first, and committed
//! after it, so that no reader ever sees half a file.
//!
//! Every format that [`Format::holds_meta`] carries the texture's [`Meta`]: a pair `table` → `split-sum` is stored under
//! the key `brdf-baker.table`. The names of the channels travel as the pair `channels`, which belongs to this module: it is
//! written from [`Texture::channels`] and does not show in the meta that is read back.

mod babylon;
mod dds;
mod encoding;
mod exr;
mod fingerprint;
pub mod harmonics;
mod hdr;
mod json;
mod ktx1;
mod ktx2;
mod leftover;
mod npy;
mod output;
pub mod picture;
mod png;
mod sh;
mod source;

use std::io::Read;
use std::ops::RangeInclusive;
use std::path::Path;

pub use self::babylon::BabylonEnv;
pub use self::dds::Dds;
pub(crate) use self::encoding::exp2i;
pub use self::encoding::{
    Compression, ENCODINGS, Effort, Encoding, Loss, Pictures, Repr, Rounding, Steps, Storage, Stored, decode, encode,
    rounding,
};
pub use self::exr::Exr;
pub use self::fingerprint::{Changed, Fingerprint, SHA256};
pub use self::hdr::Hdr;
pub use self::json::Json;
pub use self::ktx1::Ktx1;
pub use self::ktx2::Ktx2;
pub use self::npy::Npy;
pub use self::output::{Abandoned, Output, Written, abandon};
pub use self::png::Png;
pub(crate) use self::png::torn_palette;
pub use self::sh::sh_json;
pub use self::source::{C, C_HEADER, JAVASCRIPT, Language, PYTHON, RUST, TYPESCRIPT};

use crate::bake::atlas;
use crate::error::{Error, Result, nearest};
use crate::texture::{Meta, Shape, Texture};

/// A container that can be written and read back.
pub trait Format: Sync {
    /// The name shown to users: `KTX2`.
    fn name(&self) -> &'static str;
    /// The file extension that selects it, without the dot.
    fn extension(&self) -> &'static str;
    /// Can it hold more than one level?
    fn holds_mips(&self) -> bool;
    /// Can a table lie in it channel by channel, as its meta's `planes` says?
    fn holds_planes(&self) -> bool {
        false
    }
    /// Has it a place for metadata? Without it a file does not say what it holds.
    fn holds_meta(&self) -> bool {
        true
    }
    /// An error where it has its own idea of the size of a cube or map, and this is another.
    fn accepts(&self, _size: u32, _levels: u32) -> Result<()> {
        Ok(())
    }
    /// The encodings that it can hold for this shape; empty when it cannot hold the shape at all.
    fn encodings(&self, shape: Shape) -> Vec<Encoding>;
    /// What is written when the user names no encoding: half float where the container has it.
    fn default_encoding(&self, shape: Shape, channels: usize) -> Option<Encoding>;
    /// What it can do to its bytes.
    fn compressions(&self) -> &'static [Compression] {
        &[Compression::Plain]
    }
    /// The file's bytes, with the texture's meta. `path` names the file in an error, and an array in source code.
    fn to_bytes(&self, path: &Path, texture: &Texture, storage: Storage) -> Result<Vec<u8>>;
    /// The same with levels that were encoded before, in a container that holds them as they are.
    fn to_bytes_of_levels(
        &self,
        path: &Path,
        texture: &Texture,
        storage: Storage,
        _levels: Vec<Vec<u8>>,
    ) -> Result<Vec<u8>> {
        self.to_bytes(path, texture, storage)
    }
    /// The texture in a file that this tool wrote (others too where the container says enough), and its encoding.
    /// `path` only names the file in an error.
    fn parse(&self, path: &Path, bytes: &[u8]) -> Result<(Texture, Encoding)>;
    /// [`Format::parse`] on the content of a file.
    fn read(&self, path: &Path) -> Result<(Texture, Encoding)> {
        let bytes = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
        self.parse(path, &bytes)
    }
}

static FORMATS: [&dyn Format; 15] = [
    &Ktx2,
    &Exr,
    &Hdr,
    &Png,
    &Dds,
    &Ktx1,
    &BabylonEnv,
    &Npy,
    &Json,
    &RUST,
    &C,
    &C_HEADER,
    &JAVASCRIPT,
    &TYPESCRIPT,
    &PYTHON,
];

/// Every format, in the order of their documentation.
pub fn formats() -> &'static [&'static dyn Format] {
    &FORMATS
}

/// The format that a path's extension selects, upper or lower case.
pub fn for_path(path: &Path) -> Result<&'static dyn Format> {
    match path.extension() {
        Some(extension) => named(&extension.to_string_lossy()),
        None => Err(Error::usage(
            format!("'{}' has no extension to tell its format", path.display()),
            format!("known are: {}", extensions().join(", ")),
        )),
    }
}

/// The format with this extension, upper or lower case.
pub fn named(extension: &str) -> Result<&'static dyn Format> {
    formats().iter().copied().find(|f| f.extension().eq_ignore_ascii_case(extension)).ok_or_else(|| {
        Error::usage(format!("unknown format '{extension}'"), nearest(&extension.to_lowercase(), extensions()))
    })
}

fn extensions() -> Vec<&'static str> {
    formats().iter().map(|f| f.extension()).collect()
}

/// The encoding to write: `wanted` if the format can hold it, the format's default if nothing is wanted.
pub fn choose(format: &dyn Format, shape: Shape, channels: usize, wanted: Option<Encoding>) -> Result<Encoding> {
    let able: Vec<Encoding> = format.encodings(shape).into_iter().filter(|e| e.components >= channels).collect();
    let names = || able.iter().map(|e| e.name).collect::<Vec<_>>().join(", ");
    let Some(default) = format.default_encoding(shape, channels) else {
        let others = formats().iter().filter(|f| f.default_encoding(shape, channels).is_some());
        let others: Vec<String> = others.map(|f| format!(".{}", f.extension())).collect();
        let thing = match shape {
            Shape::Cube => "a cube".into(),
            Shape::Map => "a picture of radiance".into(),
            Shape::Table => format!("a table of {channels} channels"),
            Shape::Volume { .. } => format!("a table over three axes of {channels} channels"),
            Shape::Array { .. } => format!("an array of tables of {channels} channels"),
        };
        let help = format!("formats that can: {}", others.join(", "));
        return Err(Error::usage(format!("{} cannot hold {thing}", format.name()), help));
    };
    match wanted {
        None => Ok(default),
        Some(wanted) if able.contains(&wanted) => Ok(wanted),
        Some(wanted) if format.encodings(shape).contains(&wanted) => {
            encoding::fits(channels, wanted)?;
            Ok(wanted)
        }
        Some(wanted) => Err(Error::usage(
            format!("{} does not hold encoding {}", format.name(), wanted.name),
            format!("known are: {}", names()),
        )),
    }
}

/// An error when a channel's values do not fit: for the ranges that a table declares, before any work, and for the
/// values themselves before they are written. Halves are not refused: what exceeds 65504 is clamped and counted.
pub fn check_range(
    path: &Path,
    format: &dyn Format,
    encoding: Encoding,
    channel: &str,
    range: &RangeInclusive<f32>,
) -> Result<()> {
    let (min, max) = (*range.start(), *range.end());
    let held = encoding.repr.range();
    let refused = match encoding.repr {
        _ if min.is_nan() || max.is_nan() => Some("holds a value that is not a number".to_string()),
        _ if min.is_infinite() || max.is_infinite() => Some("holds an infinite value".to_string()),
        Repr::F16 | Repr::F32 => None,
        _ => [min, max].iter().find(|v| !held.contains(v)).map(|v| {
            let holder = match encoding.repr {
                Repr::Unorm8 => format!("8-bit {}", format.name()),
                Repr::Unorm16 => format!("16-bit {}", format.name()),
                Repr::Rgbe8 => format.name().into(),
                _ => encoding.name.into(),
            };
            format!("reaches {v} but {holder} holds [{}, {}]", held.start(), ShortFloat(*held.end()))
        }),
    };
    match refused {
        None => Ok(()),
        Some(reason) => {
            let help = if min.is_finite() && max.is_finite() {
                let fit = Encoding::fitting(Repr::F16, encoding.components).map_or("rgba16f", |e| e.name);
                format!("write a .ktx2 or .exr file: their encoding {fit} holds such values")
            } else {
                "this is a fault in the values, not in the file format".into()
            };
            Err(Error::usage(format!("cannot write '{}': channel '{channel}' {reason}", path.display()), help))
        }
    }
}

/// `1` as it is, `1.6947657e38` as `1.69e38`.
struct ShortFloat(f32);

impl std::fmt::Display for ShortFloat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0 < 1e6 { write!(f, "{}", self.0) } else { write!(f, "{:.2e}", self.0) }
    }
}

/// An error where the container cannot compress like this.
pub fn check_compression(format: &dyn Format, compression: Compression) -> Result<()> {
    if format.compressions().contains(&compression) {
        return Ok(());
    }
    let others: Vec<String> = formats()
        .iter()
        .filter(|f| f.compressions().contains(&compression))
        .map(|f| format!(".{}", f.extension()))
        .collect();
    let what = format!("{} is not compressed by {}", format.name(), compression.name());
    Err(Error::usage(what, format!("drop --compression, or write a {} file", others.join(" or "))))
}

/// States in a texture's meta what a file that stores it so must say of its texels: their fingerprint, and where no step
/// tells it, what they lost. The result is what [`Output::commit`] stores.
pub fn certify(texture: &mut Texture, storage: impl Into<Storage>) -> Result<Stored> {
    let storage = storage.into();
    let encoding = storage.encoding;
    let channels = texture.channels.len();
    let bytes = encoding::encoded(texture, storage)?;
    let fingerprint = if encoding.repr.is_measured() {
        let stored = encoding::decoded(&bytes, texture, encoding);
        Steps::state(&Rounding::between(texture, encoding.repr, &stored), &mut texture.meta);
        Fingerprint::of_levels(&stored, channels, encoding)?
    } else {
        match Fingerprint::of_bytes(&bytes, channels, encoding) {
            Some(fingerprint) => fingerprint,
            None => Fingerprint::of(texture, storage)?,
        }
    };
    fingerprint.state(&mut texture.meta);
    Ok(Stored { storage, levels: Some(bytes) })
}

/// What every writer checks first: the encoding, the lengths, the ranges and the meta.
fn check(path: &Path, format: &dyn Format, texture: &Texture, storage: Storage) -> Result<()> {
    let encoding = storage.encoding;
    choose(format, texture.shape, texture.channels.len(), Some(encoding))?;
    check_compression(format, storage.compression)?;
    let cannot = |what: &str| Error::usage(format!("cannot write '{}': {what}", path.display()), "");

    // Sizes: the writers index by them.
    let levels = texture.levels.len();
    let full_chain = 32 - texture.width.max(texture.height).leading_zeros() as usize;
    let shape_holds = match texture.shape {
        Shape::Table => levels == 1,
        Shape::Volume { depth } => levels == 1 && depth > 0,
        Shape::Array { layers } => levels == 1 && layers > 1,
        Shape::Map => (1..=full_chain).contains(&levels) && is_map(&texture.meta),
        Shape::Cube => texture.width == texture.height && (1..=full_chain).contains(&levels),
    };
    if texture.width == 0 || texture.height == 0 || !shape_holds {
        let size = format!("{} × {}, {levels} levels", texture.width, texture.height);
        return Err(cannot(&format!("a {:?} cannot have this size: {size}", texture.shape)));
    }
    if levels > 1 && !format.holds_mips() {
        let help = "use --mips 1, or write a .ktx2 or .exr file";
        let what = format!("cannot write '{}': {} holds one level, not {levels}", path.display(), format.name());
        return Err(Error::usage(what, help));
    }
    format.accepts(texture.width, levels as u32)?;
    if let Some(level) = (0..levels).find(|&i| texture.levels[i].len() != texture.level_len(i)) {
        return Err(cannot(&format!("level {level} holds the wrong number of values")));
    }

    // Names and meta: every container must be able to carry them, so the strictest sets the rule.
    if let Some(name) = texture.channels.iter().find(|n| n.is_empty() || n.contains([',', '=']) || !is_line(n)) {
        return Err(cannot(&format!("'{}' cannot name a channel", name.escape_debug())));
    }
    for (key, value) in texture.meta.iter() {
        let is_key = (1..=64).contains(&key.len())
            && key.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b"._-".contains(&b));
        if !is_key || [CHANNELS, ENCODING, FORMULA, TEXELS].contains(&key) {
            return Err(cannot(&format!("'{}' cannot be a metadata key", key.escape_debug())));
        }
        if !is_line(value) {
            return Err(cannot(&format!("the metadata value of '{key}' holds a control character")));
        }
    }

    // Values, level by level.
    let n = texture.channels.len();
    for (c, channel) in texture.channels.iter().enumerate() {
        let mut values = texture.levels.iter().flat_map(|level| level.iter().skip(c).step_by(n));
        let range =
            values.try_fold(
                (f32::MAX, f32::MIN),
                |(low, high), &v| {
                    if v.is_nan() { Err(v) } else { Ok((low.min(v), high.max(v))) }
                },
            );
        let (low, mut high) = range.unwrap_or((f32::NAN, f32::NAN));
        // Suns exceed what small encodings hold: their texels are clamped and counted, and the bake says so.
        if !texture.shape.is_table() && high.is_finite() {
            high = high.min(*encoding.repr.range().end());
        }
        check_range(path, format, encoding, channel, &(low..=high))?;
    }
    Ok(())
}

/// Halves and singles, of one, two or four components.
fn floats() -> Vec<Encoding> {
    ENCODINGS.iter().copied().filter(|e| matches!(e.repr, Repr::F16 | Repr::F32)).collect()
}

/// JSON with nothing but ASCII.
fn ascii(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        if c.is_ascii() {
            out.push(c);
        } else {
            c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| out += &format!("\\u{unit:04x}"));
        }
    }
    out
}

/// Does the meta say that the texels are a picture of the sphere?
fn is_map(meta: &Meta) -> bool {
    meta.get("projection").is_some_and(|name| matches!(name, "equirect" | "octahedral" | atlas::NAME))
}

fn is_line(text: &str) -> bool {
    !text.chars().any(char::is_control)
}

/// What comes before a key of ours in a file.
const PREFIX: &str = "brdf-baker.";
/// The key that carries the names of the channels.
const CHANNELS: &str = "channels";
/// The key of an encoding that a container cannot tell by itself: bytes that need a formula.
const ENCODING: &str = "encoding";
/// The key of that formula.
const FORMULA: &str = "encoding.decode";
/// The key of a size that a container has no other place for.
const TEXELS: &str = "texels";
/// Key of the channels of a table that lies plane by plane in source code.
pub const PLANES: &str = "planes";
/// What files name as their writer.
const WRITER: &str = concat!("brdf-baker ", env!("CARGO_PKG_VERSION"));

/// The pairs to write, with the channels, with the encoding where it needs words, and with the prefix.
fn pairs(texture: &Texture, encoding: Encoding) -> Vec<(String, String)> {
    let channels = std::iter::once((CHANNELS, texture.channels.join(",")));
    let formula = encoding.formula().into_iter();
    let formula = formula.flat_map(|formula| [(ENCODING, encoding.name.into()), (FORMULA, formula.into())]);
    let meta = texture.meta.iter().map(|(k, v)| (k, v.to_string()));
    channels.chain(formula).chain(meta).map(|(k, v)| (format!("{PREFIX}{k}"), v)).collect()
}

/// The encoding of texels that are stored as `container` says: that, or one that such bytes carry.
fn stated_encoding<'a>(
    path: &Path,
    container: Encoding,
    mut pairs: impl Iterator<Item = (&'a str, &'a str)>,
) -> Result<Encoding> {
    let Some((_, name)) = pairs.find(|(key, _)| key.strip_prefix(PREFIX) == Some(ENCODING)) else {
        return Ok(container);
    };
    match Encoding::parse(name) {
        Ok(stated) if stated.formula().is_some() && container.name == "rgba8unorm" => Ok(stated),
        _ => Err(Error::input(path, format!("it states the encoding {name}, but holds {}", container.name), "")),
    }
}

/// The reverse of [`pairs`]: the channels, `default` where the file does not name them, and the meta.
fn from_pairs<'a>(
    path: &Path,
    pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    default: &[&str],
    components: usize,
) -> Result<(Vec<String>, Meta)> {
    let mut meta = Meta::default();
    let mut channels: Vec<String> = default.iter().map(|s| s.to_string()).collect();
    for (key, value) in pairs.into_iter().filter_map(|(k, v)| Some((k.strip_prefix(PREFIX)?, v))) {
        // A damaged or foreign file may hold what we would not write.
        if !is_line(value) {
            return Err(Error::input(path, format!("the metadata value of '{key}' holds a control character"), ""));
        }
        match key {
            CHANNELS => channels = value.split(',').map(String::from).collect(),
            ENCODING | FORMULA | TEXELS => {}
            key => meta.set(key, value),
        }
    }
    if !(1..=components).contains(&channels.len()) {
        let what = format!("it names {} channels but a texel has {components} components", channels.len());
        return Err(Error::input(path, what, ""));
    }
    Ok((channels, meta))
}

/// What deflate makes of a byte at best.
pub(crate) const DEFLATE_RATIO: u64 = 1032;
/// What Zstandard makes of a byte at best: four bytes may stand for a block of 128 KiB.
pub(crate) const ZSTD_RATIO: u64 = 1 << 15;

/// Refuses a size that the file cannot hold even at the container's best compression, before memory is taken for it.
pub(crate) fn plausible(path: &Path, decoded_bytes: Option<u64>, file_bytes: u64, best_ratio: u64) -> Result<()> {
    match decoded_bytes {
        Some(size) if size / best_ratio <= file_bytes => Ok(()),
        _ => Err(Error::input(
            path,
            "its header states more texels than the file can hold",
            "it is damaged or cut short: fetch or export it again",
        )),
    }
}

/// The content of a Zstandard frame that holds `size_bytes`; at most one byte more, which is enough to refuse the rest.
pub(crate) fn unzstd(from: impl Read, size_bytes: u64) -> Result<Vec<u8>, String> {
    // The window is memory that a frame asks for in its first bytes. Every decoder must grant 8 MiB (RFC 8878, 3.1.1.1.2).
    let window = size_bytes.next_power_of_two().max(8 << 20);
    let decoder = ruzstd::decoding::StreamingDecoder::new_with_max_window_size(from, window);
    let decoder = decoder.map_err(|e| e.to_string())?;
    let mut out = vec![];
    decoder.take(size_bytes.saturating_add(1)).read_to_end(&mut out).map_err(|e| e.to_string())?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn format_follows_the_extension() {
        assert_eq!(for_path(Path::new("a/lut.KTX2")).unwrap().name(), "KTX2");
        assert_eq!(for_path(Path::new("lut.exr")).unwrap().name(), "OpenEXR");
        let error = for_path(Path::new("lut.pgn")).err().unwrap();
        assert_eq!(error.to_string(), "unknown format 'pgn'");
        assert!(error.help().starts_with("did you mean 'png'? known are: ktx2, exr, hdr, png, "), "{}", error.help());
        assert!(for_path(Path::new("lut")).err().unwrap().help().starts_with("known are: ktx2, exr, hdr, png, dds"));
    }

    #[test]
    fn choose_takes_the_default_or_says_what_fits() {
        let default = |f: &dyn Format, s, n| choose(f, s, n, None).map(|e| e.name).map_err(|e| e.help().to_string());
        assert_eq!(default(&Ktx2, Shape::Table, 1), Ok("r16f"));
        assert_eq!(default(&Ktx2, Shape::Table, 3), Ok("rgba16f"));
        assert_eq!(default(&Exr, Shape::Cube, 3), Ok("rgba16f"));
        assert_eq!(default(&Hdr, Shape::Table, 2), Ok("rgbe8"));
        assert_eq!(default(&Png, Shape::Table, 1), Ok("r16unorm"));
        assert_eq!(default(&Png, Shape::Table, 2), Ok("rgb16unorm"));
        assert_eq!(default(&Png, Shape::Table, 4), Ok("rgba16unorm"));
        assert_eq!(default(&Png, Shape::Map, 3), Ok("rgbd8"));
        assert_eq!(
            default(&Hdr, Shape::Table, 4),
            Err("formats that can: .ktx2, .exr, .png, .dds, .ktx, .npy, .json, .rs, .c, .h, .js, .ts, .py".into())
        );
        assert_eq!(default(&Hdr, Shape::Cube, 3), Err("formats that can: .ktx2, .exr, .dds, .ktx, .env, .npy".into()));
        let wrong = choose(&Ktx2, Shape::Table, 2, Encoding::parse("rgbe8").ok()).unwrap_err();
        assert_eq!(wrong.to_string(), "KTX2 does not hold encoding rgbe8");
        assert!(wrong.help().starts_with("known are: rg16f, rgba16f, rg32f, rgba32f, rg8unorm, "), "{}", wrong.help());
        let narrow = choose(&Ktx2, Shape::Table, 2, Encoding::parse("r16f").ok()).unwrap_err();
        assert_eq!(narrow.help(), "use rg16f");
    }

    #[test]
    fn range_error_names_channel_value_and_way_out() {
        let e = |name| Encoding::parse(name).unwrap();
        let path = Path::new("lut.png");
        let error = check_range(path, &Png, e("rgb8unorm"), "B", &(0.0..=1.07)).unwrap_err();
        assert_eq!(error.to_string(), "cannot write 'lut.png': channel 'B' reaches 1.07 but 8-bit PNG holds [0, 1]");
        assert_eq!(error.help(), "write a .ktx2 or .exr file: their encoding rgba16f holds such values");
        let error = check_range(Path::new("a.hdr"), &Hdr, e("rgbe8"), "x", &(-0.5..=1.0)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "cannot write 'a.hdr': channel 'x' reaches -0.5 but Radiance HDR holds [0, 1.69e38]"
        );
        assert!(check_range(path, &Png, e("r16unorm"), "x", &(0.0..=1.0)).is_ok());
        assert!(check_range(path, &Ktx2, e("r16f"), "x", &(-1.0..=1e6)).is_ok(), "halves are clamped and counted");
        assert!(check_range(path, &Ktx2, e("r32f"), "x", &(0.0..=f32::INFINITY)).is_err());
        assert!(check_range(path, &Ktx2, e("r32f"), "x", &(f32::NAN..=f32::NAN)).is_err());
    }
}
