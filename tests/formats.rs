// SPDX-License-Identifier: MIT OR Apache-2.0
//! File formats: what is written is read back, damaged files end in errors, and a file appears whole or not at all.

#[path = "common/ktx2_strict.rs"]
mod ktx2_strict;

use std::fs;
use std::path::Path;

use brdf_baker::format::{
    Compression, Encoding, Format, Output, Pictures, Repr, Storage, choose, decode, encode, for_path, formats, named,
    rounding,
};
use brdf_baker::texture::{Meta, Shape, Texture};
use brdf_baker::{Error, Result};
use half::f16;

/// SplitMix64: enough for test values, the same on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// A value that the representation holds exactly, drawn from its bits: subnormals come as often as their share.
    fn exact(&mut self, repr: Repr) -> f32 {
        loop {
            let bits = self.next();
            let value = match repr {
                Repr::F16 => f16::from_bits(bits as u16).to_f32(),
                Repr::F32 => f32::from_bits(bits as u32),
                Repr::Unorm8 => f32::from(bits as u8) / 255.0,
                Repr::Unorm16 => f32::from(bits as u16) / 65535.0,
                Repr::Unorm10 => (bits % 1024) as f32 / 1023.0,
                // The floats of 10 bits are among those of 11 bits.
                Repr::B10g11r11 => f16::from_bits(((bits % (31 << 5)) << 5) as u16).to_f32(),
                Repr::Rgbe8 | Repr::Rgb9e5 => unreachable!("components share an exponent: see shared_texels"),
                _ => (bits >> 40) as f32 / (1 << 24) as f32,
            };
            if value.is_finite() {
                return value;
            }
        }
    }
}

/// Values that must be met whatever the dice say.
fn corners(repr: Repr) -> Vec<f32> {
    let mut values = vec![0.0, 1.0];
    match repr {
        Repr::F16 => {
            values.extend([65504.0, -65504.0, -0.0, 2.0_f32.powi(-24), 2.0_f32.powi(-14), 1023.0 / 1.6777216e7])
        }
        Repr::F32 => values.extend([f32::MAX, f32::MIN, -0.0, f32::from_bits(1), f32::MIN_POSITIVE, 0.1]),
        _ => {}
    }
    values
}

/// Does each value that is drawn come back as it was?
fn is_exact(repr: Repr) -> bool {
    !matches!(repr, Repr::Rgbd8 | Repr::Rgbm8 | Repr::Rgbp8 | Repr::Bc4 | Repr::Bc5 | Repr::Bc6h)
}

/// What a reader must find.
fn stored(written: &Texture, format: &dyn Format, encoding: Encoding) -> Texture {
    let mut stored = written.clone();
    let n = written.channels.len();
    if !format.holds_meta() {
        stored.meta = Meta::default();
        // DDS has the encoding's components, NumPy the channels that there are.
        let found = if format.name() == "DDS" { encoding.components } else { n };
        stored.channels = ["r", "g", "b", "a"][..found].iter().map(|c| c.to_string()).collect();
        stored.shape = match written.shape {
            Shape::Map => Shape::Table,
            // An array of numbers is an array of numbers.
            Shape::Array { layers } if format.name() == "NumPy" => Shape::Volume { depth: layers },
            other => other,
        };
    }
    for (i, level) in stored.levels.iter_mut().enumerate() {
        let pictures = Pictures::of(written, i);
        let bytes = encode(level, n, pictures, encoding).unwrap();
        assert_eq!(Some(bytes.len() as u64), encoding.level_bytes(pictures), "{}", encoding.name);
        *level = decode(&bytes, stored.channels.len(), pictures, encoding);
    }
    stored
}

/// Texels whose largest mantissa has its highest bit set.
fn shared_texels(random: &mut Random, texels: usize, channels: usize, repr: Repr) -> Vec<f32> {
    let (half, scales) = match repr {
        Repr::Rgbe8 => (128, [-8, -12, 0, 30, -60]),
        _ => (256, [-9, -12, 0, 7, -24]),
    };
    let mut values = Vec::new();
    for i in 0..texels {
        let scale = 2.0_f32.powi(scales[random.below(5)]);
        let largest = random.below(channels);
        for c in 0..channels {
            let mantissa = if c == largest { half + random.below(half) } else { random.below(2 * half) };
            values.push(if i < 2 { [0.0, 1.0][i] } else { mantissa as f32 * scale });
        }
    }
    // A long run of one texel exercises the run lengths.
    let run = values.len() / 2;
    let texel = values[..channels].to_vec();
    values[run / channels * channels..].chunks_mut(channels).for_each(|t| t.copy_from_slice(&texel));
    values
}

fn odd_meta() -> Meta {
    let mut meta = Meta::default();
    meta.set("table", "split-sum");
    meta.set("quotes", r#""double" 'single' `back` \ backslash"#);
    meta.set("equals", "a=b==c, # comment; % percent");
    meta.set("unicode", "α² ∫ f·l dω → é 漢字 🙂");
    meta.set("spaces", "  both ends  ");
    meta.set("empty", "");
    meta.set("axis.x-name_2", "n_dot_v edges 64");
    meta.set("long", "x".repeat(3000));
    meta
}

/// Nine colours, as an environment states them.
fn irradiance() -> String {
    (0..27).map(|i| format!("{:.8e}", 1.5 - 0.1 * f64::from(i))).collect::<Vec<_>>().join(" ")
}

fn texture(shape: Shape, (width, height): (u32, u32), channels: usize, repr: Repr, seed: u64) -> Texture {
    let mut random = Random(seed);
    let names = ["scale", "bias", "z", "w"][..channels].iter().map(|s| s.to_string()).collect();
    let mut texture = Texture { shape, width, height, channels: names, levels: vec![], meta: odd_meta() };
    let levels = if shape.is_table() { 1 } else { width.ilog2() as usize + 1 };
    if shape == Shape::Map {
        texture.meta.set("projection", if width == height { "octahedral" } else { "equirect" });
    }
    if shape == Shape::Cube {
        texture.meta.set("sh.irradiance", irradiance());
    }
    for level in 0..levels {
        let len = texture.level_len(level);
        let values = if matches!(repr, Repr::Rgbe8 | Repr::Rgb9e5) {
            shared_texels(&mut random, len / channels, channels, repr)
        } else {
            let mut values: Vec<f32> = (0..len).map(|_| random.exact(repr)).collect();
            values.iter_mut().zip(corners(repr)).for_each(|(to, v)| *to = v);
            values
        };
        texture.levels.push(values);
    }
    texture
}

fn by_name(name: &str) -> Encoding {
    Encoding::parse(name).unwrap()
}

fn path(format: &dyn Format) -> std::path::PathBuf {
    format!("lut.{}", format.extension()).into()
}

fn to_bytes(format: &dyn Format, texture: &Texture, encoding: Encoding) -> Result<Vec<u8>> {
    format.to_bytes(&path(format), texture, encoding.into())
}

fn parse(format: &dyn Format, bytes: &[u8]) -> Result<(Texture, Encoding)> {
    format.parse(&path(format), bytes)
}

fn sorted(meta: &Meta) -> Vec<(&str, &str)> {
    let mut pairs: Vec<_> = meta.iter().collect();
    pairs.sort_unstable();
    pairs
}

fn bits(levels: &[Vec<f32>]) -> Vec<Vec<u32>> {
    levels.iter().map(|level| level.iter().map(|v| v.to_bits()).collect()).collect()
}

/// What differs, or nothing.
fn difference(written: &Texture, read: &Texture) -> Option<&'static str> {
    if (written.shape, written.width, written.height) != (read.shape, read.width, read.height) {
        Some("size")
    } else if written.channels != read.channels {
        Some("channels")
    } else if sorted(&written.meta) != sorted(&read.meta) {
        Some("meta")
    } else if bits(&written.levels) != bits(&read.levels) {
        Some("values")
    } else {
        None
    }
}

/// Every format × shape × size × channels × encoding that is to be written.
fn combinations() -> Vec<(&'static dyn Format, Texture, Encoding)> {
    let mut all = Vec::new();
    for &format in formats() {
        for (shape, size) in [
            (Shape::Table, (16, 9)),
            (Shape::Table, (7, 5)),
            (Shape::Table, (130, 2)),
            (Shape::Table, (33, 1)),
            (Shape::Table, (1, 1)),
            (Shape::Table, (1, 6)),
            (Shape::Map, (8, 8)),
            (Shape::Map, (16, 8)),
            (Shape::Map, (6, 3)),
            (Shape::Cube, (8, 8)),
            (Shape::Cube, (1, 1)),
            (Shape::Cube, (5, 5)),
            (Shape::Volume { depth: 3 }, (4, 5)),
            (Shape::Volume { depth: 6 }, (3, 3)),
            (Shape::Array { layers: 2 }, (7, 5)),
            (Shape::Array { layers: 6 }, (4, 4)),
        ] {
            for encoding in format.encodings(shape) {
                for channels in 1..=encoding.components {
                    let mut texture = texture(shape, size, channels, encoding.repr, all.len() as u64);
                    if !format.holds_mips() {
                        texture.levels.truncate(1);
                    }
                    if format.accepts(texture.width, texture.levels.len() as u32).is_err() {
                        continue;
                    }
                    all.push((format, texture, encoding));
                }
            }
        }
    }
    all
}

#[test]
fn written_is_read_back_bit_by_bit() {
    let all = combinations();
    // Channels of every encoding, tables and arrays, volumes, and others.
    let (ktx2, exr, hdr, png) = (8 * 52 + 2 * 46 + 6 * 32, 16 * 14, 9 * 3, 6 * 25 + 3 * 9);
    let (dds, ktx1, env) = (8 * 43 + 2 * 37 + 3 * 23, 6 * 33 + 6 * 23, 2 * 3);
    let (npy, text) = (16 * 14, 13 * 14 + 6 * 13 * 24);
    assert_eq!(all.len(), ktx2 + exr + hdr + png + dds + ktx1 + env + npy + text, "a combination is missing");
    for (format, written, encoding) in all {
        let what =
            format!("{} {} {:?} {} channels", format.name(), encoding.name, written.shape, written.channels.len());
        let bytes = to_bytes(format, &written, encoding).unwrap_or_else(|e| panic!("{what}: {e}"));
        let (read, found) = parse(format, &bytes).unwrap_or_else(|e| panic!("{what}: {e}"));
        let loss = rounding(&written, encoding).unwrap();
        assert!(loss.most.max_abs == 0.0 || !is_exact(encoding.repr), "{what}: {loss:?}");
        assert_eq!(difference(&stored(&written, format, encoding), &read), None, "{what}");
        // Some store no components beyond the channels, so the narrowest encoding is found.
        let expected = match format.extension() {
            "exr" | "npy" | "json" | "rs" | "c" | "h" | "js" | "ts" | "py" => {
                Encoding::fitting(encoding.repr, written.channels.len()).unwrap()
            }
            _ => encoding,
        };
        assert_eq!(found, expected, "{what}");
    }
}

#[test]
fn difference_sees_each_kind_of_fault() {
    let written = texture(Shape::Table, (4, 3), 2, Repr::F16, 1);
    let fault = |change: &dyn Fn(&mut Texture)| {
        let mut read = written.clone();
        change(&mut read);
        difference(&written, &read)
    };
    assert_eq!(fault(&|_| ()), None);
    assert_eq!(fault(&|t| (t.width, t.height) = (t.height, t.width)), Some("size"));
    assert_eq!(fault(&|t| t.shape = Shape::Cube), Some("size"));
    assert_eq!(fault(&|t| t.channels.swap(0, 1)), Some("channels"));
    assert_eq!(fault(&|t| t.meta.set("empty", " ")), Some("meta"));
    assert_eq!(fault(&|t| t.levels[0].rotate_right(2)), Some("values"));
    assert_eq!(fault(&|t| t.levels[0][0] = -0.0), Some("values"), "the sign of zero");
    assert_eq!(fault(&|t| t.levels[0][5] = f32::NAN), Some("values"));
}

#[test]
fn meta_that_a_container_cannot_carry_is_refused() {
    for &format in formats() {
        let Ok(encoding) = choose(format, Shape::Table, 1, None) else { continue };
        let plain = texture(Shape::Table, (2, 2), 1, Repr::Unorm8, 1);
        assert!(to_bytes(format, &plain, encoding).is_ok());
        for (key, value) in
            [("a", "bell \u{7}"), ("a", "nul \0"), ("A", ""), ("a b", ""), ("", ""), ("a=b", ""), ("channels", "x")]
        {
            let mut odd = plain.clone();
            odd.meta.set(key, value);
            let refused = to_bytes(format, &odd, encoding);
            assert!(matches!(refused, Err(Error::Usage { .. })), "{} {key:?} {value:?}", format.name());
        }
        for name in ["", "a,b", "a\nb"] {
            let mut odd = plain.clone();
            odd.channels = vec![name.into()];
            assert!(to_bytes(format, &odd, encoding).is_err(), "{} {name:?}", format.name());
        }
    }
}

#[test]
fn values_that_do_not_fit_are_refused() {
    let with = |value: f32| {
        let mut t = texture(Shape::Table, (4, 2), 2, Repr::Unorm8, 3);
        t.levels[0][5] = value;
        t
    };
    let error = |file: &str, encoding: &str, value: f32| {
        let format = for_path(Path::new(file)).unwrap();
        let result = format.to_bytes(Path::new(file), &with(value), by_name(encoding).into());
        result.err().map(|e| (e.to_string(), e.help().to_string()))
    };
    let (what, help) = error("out/lut.png", "rgb8unorm", 1.07).unwrap();
    assert_eq!(what, "cannot write 'out/lut.png': channel 'bias' reaches 1.07 but 8-bit PNG holds [0, 1]");
    assert_eq!(help, "write a .ktx2 or .exr file: their encoding rgba16f holds such values");
    assert_eq!(error("a.png", "rgb16unorm", 1.0), None);
    assert!(error("a.png", "rgb16unorm", -1e-6).unwrap().0.contains("reaches -0.000001 but 16-bit PNG holds [0, 1]"));
    assert!(error("a.hdr", "rgbe8", -0.5).unwrap().0.contains("reaches -0.5 but Radiance HDR holds"));
    assert!(error("a.hdr", "rgbe8", 3e38).is_some());
    for (file, encoding) in [("a.ktx2", "rg16f"), ("a.exr", "rg32f"), ("a.hdr", "rgbe8"), ("a.png", "rgb8unorm")] {
        assert!(error(file, encoding, f32::NAN).unwrap().0.contains("not a number"), "{file}");
        assert!(error(file, encoding, f32::NEG_INFINITY).unwrap().0.contains("infinite"), "{file}");
    }
    assert_eq!(error("a.ktx2", "rg16f", 1e6), None, "halves are clamped");
    assert_eq!(rounding(&with(1e6), by_name("rg16f")).unwrap().clamped, 1);
}

#[test]
fn sizes_that_do_not_match_are_refused() {
    let good = texture(Shape::Cube, (8, 8), 3, Repr::F16, 1);
    let fault = |change: &dyn Fn(&mut Texture)| {
        let mut t = good.clone();
        change(&mut t);
        ["ktx2", "exr"].map(|f| to_bytes(named(f).unwrap(), &t, by_name("rgba16f")).is_err())
    };
    assert_eq!(fault(&|_| ()), [false; 2]);
    assert_eq!(fault(&|t| t.levels[2].truncate(5)), [true; 2]);
    assert_eq!(fault(&|t| t.levels.push(vec![0.0; 18])), [true; 2], "a fifth level of 8 texels");
    assert_eq!(fault(&|t| t.levels.clear()), [true; 2]);
    assert_eq!(fault(&|t| t.height = 7), [true; 2]);
    assert_eq!(fault(&|t| t.shape = Shape::Table), [true; 2]);
    assert_eq!(fault(&|t| t.width = 0), [true; 2]);
}

/// One small file a format and shape, for damage.
fn small_files() -> Vec<(&'static dyn Format, Vec<u8>)> {
    let mut files = Vec::new();
    for &format in formats() {
        for (shape, size) in
            [(Shape::Table, (9, 4)), (Shape::Table, (5, 3)), (Shape::Map, (4, 2)), (Shape::Cube, (2, 2))]
        {
            let Ok(encoding) = choose(format, shape, 2, None) else { continue };
            let mut t = texture(shape, size, 2, encoding.repr, 7);
            t.meta = Meta::default();
            t.meta.set("table", "é split-sum");
            if shape == Shape::Map {
                t.meta.set("projection", "equirect");
            }
            if shape == Shape::Cube {
                t.meta.set("sh.irradiance", irradiance());
            }
            if !format.holds_mips() {
                t.levels.truncate(1);
            }
            files.push((format, to_bytes(format, &t, encoding).unwrap()));
        }
    }
    assert_eq!(files.len(), 4 * 4 + 10 * 3 + 1);
    files
}

#[test]
fn every_truncation_is_an_error() {
    for (format, bytes) in small_files() {
        for len in 0..bytes.len() {
            let result = parse(format, &bytes[..len]);
            assert!(
                matches!(result, Err(Error::Input { .. })),
                "{}: the first {len} of {}",
                format.name(),
                bytes.len()
            );
        }
        assert!(parse(format, &bytes).is_ok(), "{}", format.name());
    }
}

#[test]
fn flipped_bytes_never_panic() {
    let mut random = Random(2024);
    for (format, bytes) in small_files() {
        let mut survived = 0;
        for round in 0..4000 {
            let mut damaged = bytes.clone();
            // One bit, one byte, or up to four bytes with the values that break length fields.
            for _ in 0..1 + random.below(4) * (round % 2) {
                let at = random.below(damaged.len());
                damaged[at] = match random.below(3) {
                    0 => damaged[at] ^ (1 << random.below(8)),
                    1 => random.next() as u8,
                    _ => [0, 1, 0x7f, 0x80, 0xff][random.below(5)],
                };
            }
            match parse(format, &damaged) {
                Ok((t, _)) => {
                    survived += 1;
                    (0..t.levels.len()).for_each(|i| assert_eq!(t.levels[i].len(), t.level_len(i)));
                }
                Err(Error::Input { .. }) => {}
                Err(other) => panic!("{}: {other}", format.name()),
            }
        }
        assert!(survived < 4000, "{}: no damage was noticed", format.name());
    }
}

fn set_u32(bytes: &mut [u8], at: usize, value: u32) {
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
}

fn find(bytes: &[u8], needle: &[u8]) -> usize {
    bytes.windows(needle.len()).position(|w| w == needle).expect("the file holds it")
}

#[test]
fn headers_that_claim_more_than_the_file_holds_are_refused() {
    let t = texture(Shape::Table, (16, 16), 1, Repr::Unorm8, 1);
    let refused = |format: &str, bytes: &[u8]| {
        let error = parse(named(format).unwrap(), bytes).expect_err(format).to_string();
        assert!(error.contains("more texels") || error.contains("its size"), "{format}: {error}");
    };

    let mut file = to_bytes(named("ktx2").unwrap(), &t, by_name("r16f")).unwrap();
    set_u32(&mut file, 20, u32::MAX);
    set_u32(&mut file, 24, u32::MAX);
    refused("ktx2", &file);

    let mut file = to_bytes(named("exr").unwrap(), &t, by_name("r16f")).unwrap();
    for window in ["dataWindow\0", "displayWindow\0"] {
        let at = find(&file, window.as_bytes()) + window.len() + "box2i\0".len() + 4;
        set_u32(&mut file, at + 8, 100_000);
        set_u32(&mut file, at + 12, 100_000);
    }
    refused("exr", &file);

    let file = to_bytes(named("hdr").unwrap(), &t, by_name("rgbe8")).unwrap();
    let at = find(&file, b"-Y 16 +X 16");
    refused("hdr", &[&file[..at], b"-Y 100000 +X 100000", &file[at + 11..]].concat());

    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 100_000, 100_000);
    encoder.set_depth(png::BitDepth::Sixteen);
    let mut writer = encoder.write_header().unwrap();
    writer.write_chunk(png::chunk::IDAT, &[0x78, 0x9c, 3, 0]).unwrap();
    drop(writer);
    refused("png", &file);
}

#[test]
fn same_texture_gives_the_same_bytes() {
    for (format, written, encoding) in combinations() {
        let [a, b] = [(); 2].map(|()| to_bytes(format, &written, encoding).unwrap());
        assert!(a == b, "{} {}", format.name(), encoding.name);
        let [a, b] = [a, b].map(|bytes| parse(format, &bytes).unwrap().0.meta);
        assert_eq!(a, b, "{}: the order of the pairs", format.name());
    }
}

#[test]
fn halves_are_clamped_in_every_container() {
    let mut t = texture(Shape::Table, (4, 4), 1, Repr::Unorm8, 1);
    t.levels[0][..4].copy_from_slice(&[1e6, -1e6, 65519.0, 65520.0]);
    for format in ["ktx2", "exr"].map(|name| named(name).unwrap()) {
        let (read, _) = parse(format, &to_bytes(format, &t, by_name("r16f")).unwrap()).unwrap();
        assert_eq!(read.levels[0][..4], [65504.0, -65504.0, 65504.0, 65504.0], "{}", format.name());
    }
    assert_eq!(rounding(&t, by_name("r16f")).unwrap().clamped, 4);
}

#[test]
fn openexr_names_channels_and_parts() {
    let t = texture(Shape::Cube, (4, 4), 3, Repr::F16, 1);
    let bytes = to_bytes(named("exr").unwrap(), &t, by_name("rgba16f")).unwrap();
    let headers = exr::prelude::MetaData::read_from_buffered(&bytes[..], true).unwrap().headers;
    let parts: Vec<_> = headers.iter().map(|h| h.own_attributes.layer_name.as_ref().unwrap().to_string()).collect();
    assert_eq!(parts, ["mip0", "mip1", "mip2"]);
    let channels: Vec<_> = headers[1].channels.list.iter().map(|c| c.name.to_string()).collect();
    assert_eq!(channels, ["B", "G", "R"]);
    assert_eq!((headers[1].layer_size.0, headers[1].layer_size.1), (2, 12));
    // The first part once more, through the reader's own idea of red, green and blue.
    use exr::prelude::{ReadChannels, ReadLayers};
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| vec![[0.0_f32; 3]; size.area()],
            |pixels: &mut Vec<[f32; 3]>, at, (r, g, b): (f32, f32, f32)| {
                pixels[at.flat_index_for_size(exr::prelude::Vec2(4, 24))] = [r, g, b]
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(&bytes))
        .unwrap();
    assert_eq!(image.layer_data.channel_data.pixels.as_flattened(), t.levels[0]);
}

#[test]
fn openexr_with_a_block_listed_twice_is_refused() {
    let t = texture(Shape::Table, (4, 40), 1, Repr::F16, 1);
    let mut bytes = to_bytes(named("exr").unwrap(), &t, by_name("r16f")).unwrap();
    // The table of three block offsets follows the header; the first offset points just behind it.
    let table = (8..bytes.len() - 8)
        .find(|at| ktx2_strict::u64_at(&bytes, *at) == Ok(*at as u64 + 24))
        .expect("three blocks of 16 rows");
    bytes.copy_within(table..table + 8, table + 8);
    assert!(parse(named("exr").unwrap(), &bytes).is_err());
}

#[test]
fn radiance_run_beyond_the_row_is_refused() {
    let file = |runs: &[u8]| [b"#?RADIANCE\n\n-Y 1 +X 8\n", &[2, 2, 0, 8][..], runs].concat();
    let sound = [128 + 8, 128, 128 + 8, 1, 128 + 8, 2, 128 + 8, 129];
    let (read, _) = parse(named("hdr").unwrap(), &file(&sound)).unwrap();
    assert_eq!(read.texel(0, 0, 7, 0), [1.0, 1.0 / 128.0, 1.0 / 64.0]);
    for (at, count) in [(0, 128 + 9), (6, 255), (2, 0)] {
        let mut runs = sound;
        runs[at] = count;
        assert!(parse(named("hdr").unwrap(), &file(&runs)).is_err(), "{count} at {at}");
    }
}

#[test]
fn radiance_files_read_the_same_in_the_image_crate() {
    for size in [(40, 6), (5, 3), (1, 1)] {
        let t = texture(Shape::Table, size, 3, Repr::Rgbe8, 11);
        let bytes = to_bytes(named("hdr").unwrap(), &t, by_name("rgbe8")).unwrap();
        let read = image::load_from_memory_with_format(&bytes, image::ImageFormat::Hdr).unwrap();
        assert_eq!(read.to_rgb32f().into_raw(), t.levels[0]);
    }
}

#[test]
fn radiance_rounds_to_nearest_within_the_stated_step() {
    let encoding = by_name("rgbe8");
    let mut random = Random(5);
    let mut t = texture(Shape::Table, (64, 64), 3, Repr::Unorm8, 1);
    t.levels[0]
        .iter_mut()
        .for_each(|v| *v = (random.next() as f32 / u64::MAX as f32) * 2.0_f32.powi(random.below(20) as i32));
    let (read, _) = parse(named("hdr").unwrap(), &to_bytes(named("hdr").unwrap(), &t, encoding).unwrap()).unwrap();
    let mut worst = 0.0_f64;
    for (a, b) in t.levels[0].chunks(3).zip(read.levels[0].chunks(3)) {
        let largest = f64::from(a.iter().fold(0.0_f32, |m, v| m.max(*v)));
        for (a, b) in a.iter().zip(b) {
            worst = worst.max((f64::from(*a) - f64::from(*b)).abs() / encoding.half_ulp_at(f64::from(*a), largest));
        }
    }
    assert!((0.99..=1.0).contains(&worst), "{worst}");
}

#[test]
fn png_states_linear_values_and_no_srgb() {
    let t = texture(Shape::Table, (4, 4), 1, Repr::Unorm8, 1);
    let bytes = to_bytes(named("png").unwrap(), &t, by_name("r8unorm")).unwrap();
    let gama = find(&bytes, b"gAMA");
    assert_eq!(bytes[gama + 4..gama + 8], 100_000_u32.to_be_bytes());
    assert!(!bytes.windows(4).any(|w| w == b"sRGB" || w == b"iCCP" || w == b"cICP"));
}

// KTX2, strictly.

fn ktx2(shape: Shape, encoding: &str, channels: usize) -> Vec<u8> {
    let encoding = by_name(encoding);
    let mut t = texture(shape, (8, 8), channels, encoding.repr, 9);
    t.meta.set("aaa", "first one");
    t.meta.set("aab", "secnd");
    to_bytes(named("ktx2").unwrap(), &t, encoding).unwrap()
}

#[test]
fn ktx2_files_obey_the_specification() {
    for shape in [Shape::Table, Shape::Cube] {
        for (encoding, channels) in
            [("r16f", 1), ("rg16f", 2), ("rgba16f", 4), ("rgba16f", 3), ("r32f", 1), ("rg32f", 2), ("rgba32f", 4)]
        {
            assert_eq!(ktx2_strict::check(&ktx2(shape, encoding, channels)), Ok(()), "{shape:?} {encoding}");
        }
    }
}

#[test]
fn every_ktx2_of_the_round_trip_obeys_the_specification() {
    let mut count = 0;
    for (format, written, encoding) in combinations().into_iter().filter(|c| c.0.name() == "KTX2") {
        for compression in Compression::ALL {
            let storage = Storage { compression, ..encoding.into() };
            let bytes = format.to_bytes(&path(format), &written, storage).unwrap();
            assert_eq!(ktx2_strict::check(&bytes), Ok(()), "{}", encoding.name);
            count += 1;
        }
    }
    assert_eq!(count, 2 * (8 * 52 + 2 * 46 + 6 * 32));
}

#[test]
fn ktx2_compressed_levels_are_smaller_and_the_same() {
    let ktx2 = named("ktx2").unwrap();
    for name in ["rg16f", "rgb9e5", "bc5"] {
        let encoding = by_name(name);
        let mut t = texture(Shape::Table, (64, 64), 2, encoding.repr, 5);
        t.levels[0].iter_mut().enumerate().for_each(|(i, v)| *v = (i / 512) as f32 / 16.0);
        let [plain, packed] = Compression::ALL
            .map(|compression| ktx2.to_bytes(&path(ktx2), &t, Storage { compression, ..encoding.into() }).unwrap());
        assert!(packed.len() < plain.len() / 2, "{name}: {} of {}", packed.len(), plain.len());
        let [plain, packed] = [plain, packed].map(|bytes| parse(ktx2, &bytes).unwrap());
        assert_eq!(difference(&plain.0, &packed.0), None, "{name}");
        assert_eq!(plain.1, packed.1);
    }
    let exr = named("exr").unwrap();
    let zstd = Storage { compression: Compression::Zstd, ..by_name("rg16f").into() };
    let error = exr.to_bytes(&path(exr), &texture(Shape::Table, (4, 4), 2, Repr::F16, 1), zstd).unwrap_err();
    assert_eq!(error.to_string(), "OpenEXR is not compressed by zstd");
    assert_eq!(error.help(), "drop --compression, or write a .ktx2 file");
}

/// Key/value section as its pairs, each with length and padding.
fn kvd_entries(file: &[u8]) -> (usize, Vec<Vec<u8>>) {
    let start = ktx2_strict::u32_at(file, 56).unwrap() as usize;
    let end = start + ktx2_strict::u32_at(file, 60).unwrap() as usize;
    let mut at = start;
    let mut entries = Vec::new();
    while at < end {
        let len = 4 + (ktx2_strict::u32_at(file, at).unwrap() as usize).next_multiple_of(4);
        entries.push(file[at..at + len].to_vec());
        at += len;
    }
    (start, entries)
}

/// The same file with its pairs in another order.
fn reorder(file: &mut [u8], change: impl Fn(&mut Vec<Vec<u8>>)) {
    let (start, mut entries) = kvd_entries(file);
    change(&mut entries);
    let section = entries.concat();
    file[start..start + section.len()].copy_from_slice(&section);
}

#[test]
fn strict_checker_rejects_a_mutant_of_each_rule() {
    type Mutation = Box<dyn Fn(&mut Vec<u8>)>;
    let word = |at: usize, value: u32| -> Mutation { Box::new(move |f| set_u32(f, at, value)) };
    let add = |at: usize, more: u32| -> Mutation {
        Box::new(move |f| {
            let value = ktx2_strict::u32_at(f, at).unwrap() + more;
            set_u32(f, at, value);
        })
    };
    let replace = |from: &'static str, to: &'static str| -> Mutation {
        assert_eq!(from.len(), to.len());
        Box::new(move |f| {
            let at = find(f, from.as_bytes());
            f[at..at + to.len()].copy_from_slice(to.as_bytes());
        })
    };
    let at_dfd = |offset: usize, value: u8| -> Mutation {
        Box::new(move |f| {
            let dfd = ktx2_strict::u32_at(f, 48).unwrap() as usize;
            assert_ne!(f[dfd + offset], value, "not a mutation");
            f[dfd + offset] = value;
        })
    };
    let level0 = 80;
    let mutants: Vec<(&str, Mutation)> = vec![
        ("identifier", Box::new(|f| f[11] = b'\r')),
        ("vkFormat", word(12, 90)),
        ("typeSize", word(16, 1)),
        ("size", word(20, 0)),
        ("size", word(24, 0)),
        ("pixelDepth", word(28, 1)),
        ("layerCount", word(32, 1)),
        ("faceCount", word(36, 2)),
        ("cube square", word(24, 4)),
        ("levelCount", word(40, 0)),
        ("levelCount", word(40, 5)),
        ("supercompressionScheme", word(44, 1)),
        ("dfdByteOffset", word(48, 84)),
        ("dfdTotalSize", word(52, 4)),
        ("kvdByteOffset", add(56, 4)),
        ("kvdByteLength", word(60, 0)),
        ("kvdByteLength", word(60, u32::MAX)),
        ("sgdByteOffset", word(64, 8)),
        ("sgdByteLength", word(72, 8)),
        ("byteLength", word(level0 + 8, 8)),
        ("uncompressedByteLength", word(level0 + 16, 0)),
        ("level alignment", add(level0, 4)),
        ("level order", add(level0, 8)),
        (
            "level order",
            // Two levels of a whole file swapped: the largest first, everything else as it should be.
            Box::new(move |f| {
                let (size0, size1) = (8 * 8 * 6 * 8, 4 * 4 * 6 * 8);
                let at = f.len() - size0 - size1;
                f[at..].rotate_left(size1);
                set_u32(f, level0, at as u32);
                set_u32(f, level0 + 24, (at + size0) as u32);
            }),
        ),
        (
            "mipPadding",
            Box::new(move |f| {
                let end = (ktx2_strict::u32_at(f, 56).unwrap() + ktx2_strict::u32_at(f, 60).unwrap()) as usize;
                let smallest = ktx2_strict::u32_at(f, level0 + 3 * 24).unwrap() as usize;
                assert!(end < smallest, "the file has no padding to spoil");
                f[smallest - 1] = 1;
            }),
        ),
        ("end of file", Box::new(|f| f.push(0))),
        ("end of file", Box::new(|f| f.truncate(f.len() - 1))),
        ("dfd vendorId and descriptorType", at_dfd(4, 1)),
        ("dfd versionNumber", at_dfd(8, 1)),
        ("dfd descriptorBlockSize", at_dfd(10, 24)),
        ("dfd colorModel", at_dfd(12, 0)),
        ("dfd colorPrimaries", at_dfd(13, 0)),
        ("dfd transferFunction", at_dfd(14, 2)),
        ("dfd flags", at_dfd(15, 1)),
        ("dfd texelBlockDimension", at_dfd(16, 1)),
        ("dfd bytesPlane0", at_dfd(20, 4)),
        ("dfd bytesPlane4-7", at_dfd(24, 1)),
        ("dfd bitOffset", at_dfd(28 + 16, 8)),
        ("dfd bitLength", at_dfd(28 + 2, 16)),
        ("dfd channelType", at_dfd(28 + 48 + 3, 0xc3)),
        ("dfd qualifiers", at_dfd(28 + 3, 0x80)),
        ("dfd samplePosition", at_dfd(28 + 4, 128)),
        ("dfd sampleLower", at_dfd(28 + 11, 0)),
        ("dfd sampleUpper", at_dfd(28 + 16 + 15, 0x40)),
        (
            "keyAndValueByteLength",
            Box::new(|f| {
                let (start, _) = kvd_entries(f);
                set_u32(f, start, 1);
            }),
        ),
        (
            "valuePadding",
            Box::new(|f| {
                let (mut at, entries) = kvd_entries(f);
                let padded =
                    entries.iter().position(|e| !u32::from_le_bytes(e[..4].try_into().unwrap()).is_multiple_of(4));
                entries[..=padded.expect("a pair has padding")].iter().for_each(|e| at += e.len());
                f[at - 1] = 1;
            }),
        ),
        (
            "key NUL",
            Box::new(|f| {
                // The last pair, every byte of it.
                let (start, entries) = kvd_entries(f);
                let end = start + entries.concat().len();
                let last = entries.last().unwrap();
                let length = u32::from_le_bytes(last[..4].try_into().unwrap()) as usize;
                let at = end - last.len() + 4;
                f[at..at + length].fill(b'x');
            }),
        ),
        (
            "key UTF-8",
            Box::new(|f| {
                let at = find(f, b"brdf-baker.aab");
                f[at + 13] = 0xff;
            }),
        ),
        (
            "key: ",
            Box::new(|f| {
                let at = find(f, b"KTXwriter");
                f[at] = 0;
            }),
        ),
        ("key order", Box::new(|f| reorder(f, |entries| entries.swap(1, 2)))),
        ("key twice", replace("brdf-baker.aab", "brdf-baker.aaa")),
        (
            "value UTF-8",
            Box::new(|f| {
                let at = find(f, b"secnd");
                f[at] = 0xff;
            }),
        ),
        ("value NUL", replace("secnd\0", "second")),
        ("KTXwriter", replace("KTXwriter\0brdf", "KTXwriter\0bdrf")),
        // The sort order is kept: an upper-case name before all of ours.
        ("KTXwriter: missing", replace("KTXwriter", "KUXwriter")),
        ("reserved key", replace("KTXwriter", "KTXwrites")),
    ];

    // A cube of four halves: it has mips, padding and all samples.
    let sound = ktx2(Shape::Cube, "rgba16f", 4);
    assert_eq!(ktx2_strict::check(&sound), Ok(()));
    for (rule, mutate) in mutants {
        let mut mutant = sound.clone();
        mutate(&mut mutant);
        assert_ne!(mutant, sound, "{rule}: the mutant is no mutant");
        let broken = ktx2_strict::check(&mutant).expect_err(rule);
        assert!(broken.starts_with(rule), "expected '{rule}', found '{broken}'");
    }

    let mut table = ktx2(Shape::Table, "r16f", 1);
    replace("KTXorientation\0rd", "KTXorientation\0ru")(&mut table);
    assert_eq!(ktx2_strict::check(&table), Err("KTXorientation: ru".into()));
}

#[test]
fn ktx2_of_others_is_read_without_meta() {
    let t = texture(Shape::Cube, (4, 4), 3, Repr::F16, 4);
    let mut bytes = to_bytes(named("ktx2").unwrap(), &t, by_name("rgba16f")).unwrap();
    reorder(&mut bytes, |entries| {
        for entry in entries.iter_mut().filter(|e| e[4..].starts_with(b"brdf-baker.")) {
            entry[4] = b'x';
        }
    });
    let (read, encoding) = parse(named("ktx2").unwrap(), &bytes).unwrap();
    assert_eq!((encoding.name, read.shape, read.levels.len()), ("rgba16f", Shape::Cube, 3));
    assert_eq!(read.channels, ["r", "g", "b", "a"]);
    assert!(read.meta.is_empty());
    assert_eq!(read.texel(1, 5, 1, 0)[..3], *t.texel(1, 5, 1, 0));
    assert_eq!(read.texel(1, 5, 1, 0)[3], 1.0);
}

#[test]
fn ktx2_that_is_not_ours_to_read_is_named() {
    let sound = ktx2(Shape::Table, "r16f", 1);
    let error = |at: usize, value: u32| {
        let mut bytes = sound.clone();
        set_u32(&mut bytes, at, value);
        parse(named("ktx2").unwrap(), &bytes).unwrap_err().to_string()
    };
    assert_eq!(error(12, 131), "cannot use 'lut.ktx2': its texels have VkFormat 131");
    assert_eq!(error(32, 3), "cannot use 'lut.ktx2': level 0 has 128 bytes, which is not its size");
    let mut cubes = ktx2(Shape::Cube, "rgba16f", 4);
    set_u32(&mut cubes, 32, 3);
    let error_of_cubes = parse(named("ktx2").unwrap(), &cubes).unwrap_err().to_string();
    assert!(error_of_cubes.ends_with("an array of such or a 3-D texture, nor a plain cube"), "{error_of_cubes}");
    // An array of one layer is a table.
    let mut one = sound.clone();
    set_u32(&mut one, 32, 1);
    assert_eq!(parse(named("ktx2").unwrap(), &one).unwrap().0, parse(named("ktx2").unwrap(), &sound).unwrap().0);
    assert_eq!(error(44, 1), "cannot use 'lut.ktx2': its levels are compressed by BasisLZ");
    assert!(error(44, 2).starts_with("cannot use 'lut.ktx2': its level 0 is not sound Zstandard data"));
    assert!(error(0, 0).starts_with("cannot use 'lut.ktx2': it is not a sound KTX2 file"));
}

// Output.

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn output_is_whole_and_reports_size_and_rounding() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lut.ktx2");
    let mut t = texture(Shape::Table, (8, 8), 2, Repr::F16, 1);
    t.levels[0][3] = 1.0 + 1.0 / 4096.0;
    t.levels[0][4] = 1e9;
    let output = Output::prepare(&path).unwrap();
    assert!(!path.exists(), "nothing shows before the end");
    let written = output.commit(for_path(&path).unwrap(), &t, by_name("rg16f")).unwrap();
    assert_eq!(names(folder.path()), ["lut.ktx2"]);
    assert_eq!(written.bytes, fs::metadata(&path).unwrap().len());
    assert_eq!((written.rounding.most.max_abs, written.rounding.clamped), (1.0 / 4096.0, 1));
    let (read, _) = for_path(&path).unwrap().read(&path).unwrap();
    assert_eq!(read.levels[0][4], 65504.0);
}

#[test]
fn output_leaves_nothing_behind_on_failure_and_keeps_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lut.png");
    fs::write(&path, "old").unwrap();

    let output = Output::prepare(&path).unwrap();
    assert_eq!(names(folder.path()).len(), 2, "a temporary file proves that the folder can be written");
    drop(output);
    assert_eq!(names(folder.path()), ["lut.png"], "a cancel drops the output");

    let mut t = texture(Shape::Table, (4, 4), 1, Repr::Unorm8, 1);
    t.levels[0][0] = 2.0;
    let output = Output::prepare(&path).unwrap();
    assert!(output.commit(for_path(&path).unwrap(), &t, by_name("r8unorm")).is_err());
    assert_eq!(names(folder.path()), ["lut.png"]);
    assert_eq!(fs::read(&path).unwrap(), b"old");

    t.levels[0][0] = 1.0;
    let output = Output::prepare(&path).unwrap();
    output.commit(for_path(&path).unwrap(), &t, by_name("r8unorm")).unwrap();
    assert_eq!(names(folder.path()), ["lut.png"]);
    assert_eq!(fs::read(&path).unwrap()[1..4], *b"PNG");
}

#[test]
fn output_finds_an_impossible_path_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let error = |path: &Path| {
        let error = Output::prepare(path).expect_err("it cannot be written");
        (error.to_string(), error.help().to_string())
    };
    let (what, help) = error(folder.path());
    assert!(what.starts_with(&format!("cannot write '{}'", folder.path().display())), "{what}");
    assert_eq!(help, "name a file, not a folder");
    let (what, help) = error(&folder.path().join("no/such/lut.ktx2"));
    assert!(what.contains("no/such/lut.ktx2"), "{what}");
    assert_eq!(help, "create the folder first");
    fs::write(folder.path().join("file"), "").unwrap();
    error(&folder.path().join("file/lut.ktx2"));
    error(Path::new(""));
    error(Path::new("/"));

    let protected = folder.path().join("protected.exr");
    fs::write(&protected, "keep").unwrap();
    let mut permissions = fs::metadata(&protected).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&protected, permissions).unwrap();
    assert!(error(&protected).1.contains("permissions"));
    assert_eq!(names(folder.path()), ["file", "protected.exr"]);
}

#[cfg(unix)]
#[test]
fn output_keeps_the_umask_links_and_devices() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let (plain, path, link) =
        (folder.path().join("plain"), folder.path().join("lut.hdr"), folder.path().join("link.hdr"));
    fs::write(&plain, "").unwrap();
    symlink("lut.hdr", &link).unwrap();
    fs::write(&path, "old").unwrap();
    let t = texture(Shape::Table, (4, 4), 3, Repr::Rgbe8, 1);
    Output::prepare(&link).unwrap().commit(named("hdr").unwrap(), &t, by_name("rgbe8")).unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode(&path), mode(&plain), "as any new file");
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink(), "the link stays a link");
    assert!(fs::read(&path).unwrap().starts_with(b"#?RADIANCE"));

    let error = Output::prepare(Path::new("/dev/null")).unwrap_err();
    assert_eq!(error.to_string(), "'/dev/null' is not a regular file");
}
