// SPDX-License-Identifier: MIT OR Apache-2.0
//! Checks a KTX2 file against the rules of the KTX 2.0 specification, byte by byte, without any KTX library.
//!
//! It knows the files that this tool writes: its formats, plain 2-D and 3-D textures and cubes, no supercompression or Zstandard.
//! Anything else is refused as well. Each message starts with the name of the rule, which the mutants are matched by.

/// What a VkFormat asks for.
struct Facts {
    type_size: u32,
    /// Texels along the side of a block, and its bytes.
    block: (u32, u32),
    color_model: u8,
    /// Bit offset, bit length, channel with qualifiers, lower, upper.
    samples: Vec<[u32; 5]>,
}

/// After the tables of the Khronos Data Format Specification 1.3.
fn facts(vk: u32) -> Option<Facts> {
    let (minus_one, one) = (0xbf80_0000, 0x3f80_0000);
    // R, G, B, A; floats are marked 0xc0.
    let plain = |bytes: u32, n: u32, float: bool| Facts {
        type_size: bytes,
        block: (1, bytes * n),
        color_model: 1,
        samples: (0..n)
            .map(|i| {
                let id = [0, 1, 2, 15][i as usize];
                let [kind, lower, upper] =
                    if float { [id + 0xc0, minus_one, one] } else { [id, 0, (1 << (8 * bytes)) - 1] };
                [8 * bytes * i, 8 * bytes, kind, lower, upper]
            })
            .collect(),
    };
    let packed =
        |samples: &[[u32; 5]]| Facts { type_size: 4, block: (1, 4), color_model: 1, samples: samples.to_vec() };
    let blocks = |bytes: u32, color_model: u8, samples: &[[u32; 5]]| Facts {
        type_size: 1,
        block: (4, bytes),
        color_model,
        samples: samples.to_vec(),
    };
    Some(match vk {
        9 => plain(1, 1, false),
        16 => plain(1, 2, false),
        37 => plain(1, 4, false),
        70 => plain(2, 1, false),
        77 => plain(2, 2, false),
        91 => plain(2, 4, false),
        76 => plain(2, 1, true),
        83 => plain(2, 2, true),
        97 => plain(2, 4, true),
        100 => plain(4, 1, true),
        103 => plain(4, 2, true),
        109 => plain(4, 4, true),
        64 => packed(&[[0, 10, 0, 0, 1023], [10, 10, 1, 0, 1023], [20, 10, 2, 0, 1023], [30, 2, 15, 0, 3]]),
        122 => packed(&[[0, 11, 0x80, 0, one], [11, 11, 0x81, 0, one], [22, 10, 0x82, 0, one]]),
        // Mantissas, each beside the exponent that they share.
        123 => packed(&[
            [0, 9, 0, 0, 8448],
            [27, 5, 0x20, 15, 31],
            [9, 9, 1, 0, 8448],
            [27, 5, 0x21, 15, 31],
            [18, 9, 2, 0, 8448],
            [27, 5, 0x22, 15, 31],
        ]),
        139 => blocks(8, 131, &[[0, 64, 0, 0, u32::MAX]]),
        141 => blocks(16, 132, &[[0, 64, 0, 0, u32::MAX], [64, 64, 1, 0, u32::MAX]]),
        143 => blocks(16, 133, &[[0, 128, 0x80, 0, one]]),
        _ => return None,
    })
}

pub const IDENTIFIER: [u8; 12] = [0xab, 0x4b, 0x54, 0x58, 0x20, 0x32, 0x30, 0xbb, 0x0d, 0x0a, 0x1a, 0x0a];

pub fn u32_at(bytes: &[u8], at: usize) -> Result<u32, String> {
    let field = at.checked_add(4).and_then(|end| bytes.get(at..end)).ok_or(format!("length: no field at {at}"))?;
    Ok(u32::from_le_bytes(field.try_into().unwrap()))
}

pub fn u64_at(bytes: &[u8], at: usize) -> Result<u64, String> {
    Ok(u64::from(u32_at(bytes, at)?) | u64::from(u32_at(bytes, at + 4)?) << 32)
}

fn rule(holds: bool, name: &str, detail: impl std::fmt::Display) -> Result<(), String> {
    if holds { Ok(()) } else { Err(format!("{name}: {detail}")) }
}

fn zeros(bytes: &[u8], from: usize, to: usize) -> bool {
    from <= to && bytes.get(from..to).is_some_and(|gap| gap.iter().all(|b| *b == 0))
}

/// `Err` with the first rule that the file breaks.
pub fn check(file: &[u8]) -> Result<(), String> {
    rule(file.starts_with(&IDENTIFIER), "identifier", "the first twelve bytes")?;

    // Header fields.
    let field = |i: usize| u32_at(file, 12 + 4 * i);
    let (vk, type_size, width, height) = (field(0)?, field(1)?, field(2)?, field(3)?);
    let (depth, layers, faces, level_count, scheme) = (field(4)?, field(5)?, field(6)?, field(7)?, field(8)?);
    let facts = facts(vk).ok_or(format!("vkFormat: {vk}"))?;
    rule(type_size == facts.type_size, "typeSize", type_size)?;
    rule(width > 0 && height > 0, "size", format!("{width} × {height}"))?;
    rule(depth == 0 || (faces == 1 && level_count == 1), "pixelDepth", depth)?;
    rule(layers != 1 && (layers == 0 || (faces == 1 && depth == 0)), "layerCount", layers)?;
    rule(faces == 1 || faces == 6, "faceCount", faces)?;
    rule(faces == 1 || width == height, "cube square", format!("{width} × {height}"))?;
    let most = 32 - width.max(height).leading_zeros();
    rule((1..=most).contains(&level_count), "levelCount", level_count)?;
    rule(scheme == 0 || scheme == 2, "supercompressionScheme", scheme)?;

    // Index: sections follow each other without gaps.
    let (dfd, dfd_length) = (field(9)? as usize, field(10)? as usize);
    let (kvd, kvd_length) = (field(11)? as usize, field(12)? as usize);
    rule(dfd == 80 + 24 * level_count as usize, "dfdByteOffset", dfd)?;
    rule(u32_at(file, dfd)? as usize == dfd_length, "dfdTotalSize", "differs from dfdByteLength")?;
    rule(kvd == dfd + dfd_length && kvd.is_multiple_of(4), "kvdByteOffset", kvd)?;
    rule(kvd_length > 0, "kvdByteLength", "there must be a KTXwriter")?;
    rule(u64_at(file, 64)? == 0, "sgdByteOffset", "must be 0")?;
    rule(u64_at(file, 72)? == 0, "sgdByteLength", "must be 0")?;

    check_dfd(file, dfd, &facts, scheme)?;
    let kvd_end =
        kvd.checked_add(kvd_length).filter(|end| *end <= file.len()).ok_or("kvdByteLength: beyond the end")?;
    check_kvd(&file[kvd..kvd_end], faces, depth)?;

    // Levels: smallest first, each aligned, nothing but zeros between, nothing behind the largest.
    let (side, bytes) = facts.block;
    let alignment = match scheme {
        0 => (1..).map(|k| k * bytes as usize).find(|n| n.is_multiple_of(4)).unwrap(),
        _ => 1,
    };
    let mut end = kvd_end;
    for p in (0..level_count).rev() {
        let entry = 80 + 24 * p as usize;
        let (offset, length) = (u64_at(file, entry)?, u64_at(file, entry + 8)?);
        let blocks = |size: u32| u64::from((size >> p).max(1).div_ceil(side));
        let plain = blocks(width) * blocks(height) * u64::from(faces * depth.max(1) * layers.max(1) * bytes);
        rule(scheme != 0 || length == plain, "byteLength", format!("level {p}: {length}"))?;
        rule(u64_at(file, entry + 16)? == plain, "uncompressedByteLength", format!("level {p}"))?;
        rule(offset % alignment as u64 == 0, "level alignment", format!("level {p} at {offset}"))?;
        let start = end.next_multiple_of(alignment);
        rule(offset == start as u64, "level order", format!("level {p} at {offset}, not {start}"))?;
        rule(zeros(file, end, start), "mipPadding", format!("before level {p}"))?;
        end = start + length as usize;
    }
    rule(end == file.len(), "end of file", format!("{} bytes, levels end at {end}", file.len()))
}

fn check_dfd(file: &[u8], dfd: usize, facts: &Facts, scheme: u32) -> Result<(), String> {
    let word = |i: usize| u32_at(file, dfd + 4 * i);
    let byte = |i: usize| file.get(dfd + i).copied().ok_or("length: descriptor cut short");
    let block = 24 + 16 * facts.samples.len() as u32;
    let (side, bytes) = facts.block;
    rule(word(0)? == 4 + block, "dfdTotalSize", word(0)?)?;
    rule(word(1)? == 0, "dfd vendorId and descriptorType", word(1)?)?;
    rule(word(2)? & 0xffff == 2, "dfd versionNumber", word(2)? & 0xffff)?;
    rule(word(2)? >> 16 == block, "dfd descriptorBlockSize", word(2)? >> 16)?;
    rule(byte(12)? == facts.color_model, "dfd colorModel", byte(12)?)?;
    rule(byte(13)? == 1, "dfd colorPrimaries", "must be BT709")?;
    rule(byte(14)? == 1, "dfd transferFunction", "must be linear")?;
    rule(byte(15)? == 0, "dfd flags", "alpha must be straight")?;
    rule(word(4)? == (side - 1) * 0x101, "dfd texelBlockDimension", "must be the block's, stored less one")?;
    // Compressed levels have no size of a texel.
    rule(word(5)? == if scheme == 0 { bytes } else { 0 }, "dfd bytesPlane0", word(5)?)?;
    rule(word(6)? == 0, "dfd bytesPlane4-7", word(6)?)?;
    for (i, [offset, bits, kind, lower, upper]) in facts.samples.iter().copied().enumerate() {
        let at = 7 + 4 * i;
        let info = word(at)?;
        rule(info & 0xffff == offset, "dfd bitOffset", format!("sample {i}"))?;
        rule(info >> 16 & 0xff == bits - 1, "dfd bitLength", format!("sample {i}"))?;
        rule(info >> 24 & 0xf == kind & 0xf, "dfd channelType", format!("sample {i}"))?;
        rule(info >> 28 == kind >> 4, "dfd qualifiers", format!("sample {i}"))?;
        rule(word(at + 1)? == 0, "dfd samplePosition", format!("sample {i}"))?;
        rule(word(at + 2)? == lower, "dfd sampleLower", format!("sample {i}"))?;
        rule(word(at + 3)? == upper, "dfd sampleUpper", format!("sample {i}"))?;
    }
    Ok(())
}

fn check_kvd(kvd: &[u8], faces: u32, depth: u32) -> Result<(), String> {
    let mut at = 0;
    let mut last: Option<String> = None;
    let mut writer = false;
    while at < kvd.len() {
        let length = u32_at(kvd, at)? as usize;
        rule(length >= 2, "keyAndValueByteLength", length)?;
        let pair = kvd.get(at + 4..at + 4 + length).ok_or("keyAndValueByteLength: beyond the section")?;
        let end = at + 4 + length;
        at = end.next_multiple_of(4);
        rule(zeros(kvd, end, at), "valuePadding", format!("at {end}"))?;

        let nul = pair.iter().position(|b| *b == 0).ok_or("key NUL: missing")?;
        let key = std::str::from_utf8(&pair[..nul]).map_err(|_| "key UTF-8: broken")?;
        rule(!key.is_empty() && !key.starts_with('\u{feff}'), "key", "empty, or with a byte order mark")?;
        if let Some(last) = &last {
            rule(last.as_str() != key, "key twice", key)?;
            rule(last.chars().lt(key.chars()), "key order", format!("{last} before {key}"))?;
        }
        last = Some(key.into());

        let value = std::str::from_utf8(&pair[nul + 1..]).map_err(|_| format!("value UTF-8: of {key}"))?;
        rule(value.ends_with('\0'), "value NUL", format!("of {key}"))?;
        let value = value.trim_end_matches('\0');
        match key {
            "KTXwriter" => {
                writer = true;
                rule(value.starts_with("brdf-baker "), "KTXwriter", value)?;
            }
            "KTXorientation" => {
                let expected = if depth > 0 { "rdi" } else { "rd" };
                rule(faces == 1 && value == expected, "KTXorientation", value)?;
            }
            _ => rule(!key.to_ascii_lowercase().starts_with("ktx"), "reserved key", key)?,
        }
    }
    rule(at == kvd.len(), "kvdByteLength", "ends within a pair")?;
    rule(writer, "KTXwriter", "missing")
}
