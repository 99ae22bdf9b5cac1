//! Checks a KTX2 file against the rules of the KTX 2.0 specification, byte by byte, without any KTX library.
//!
//! It knows the files that this tool writes: the six float formats, plain 2-D textures and cubes, no supercompression.
//! Anything else is refused as well. Each message starts with the name of the rule, which the mutants are matched by.

/// VkFormat → components, bytes a component.
const FORMATS: [(u32, u32, u32); 6] = [(76, 1, 2), (83, 2, 2), (97, 4, 2), (100, 1, 4), (103, 2, 4), (109, 4, 4)];

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
    let Some(&(_, components, component_bytes)) = FORMATS.iter().find(|f| f.0 == vk) else {
        return Err(format!("vkFormat: {vk}"));
    };
    rule(type_size == component_bytes, "typeSize", type_size)?;
    rule(width > 0 && height > 0, "size", format!("{width} × {height}"))?;
    rule(depth == 0, "pixelDepth", depth)?;
    rule(layers == 0, "layerCount", layers)?;
    rule(faces == 1 || faces == 6, "faceCount", faces)?;
    rule(faces == 1 || width == height, "cube square", format!("{width} × {height}"))?;
    let most = 32 - width.max(height).leading_zeros();
    rule((1..=most).contains(&level_count), "levelCount", level_count)?;
    rule(scheme == 0, "supercompressionScheme", scheme)?;

    // Index: sections follow each other without gaps.
    let (dfd, dfd_length) = (field(9)? as usize, field(10)? as usize);
    let (kvd, kvd_length) = (field(11)? as usize, field(12)? as usize);
    rule(dfd == 80 + 24 * level_count as usize, "dfdByteOffset", dfd)?;
    rule(u32_at(file, dfd)? as usize == dfd_length, "dfdTotalSize", "differs from dfdByteLength")?;
    rule(kvd == dfd + dfd_length && kvd.is_multiple_of(4), "kvdByteOffset", kvd)?;
    rule(kvd_length > 0, "kvdByteLength", "there must be a KTXwriter")?;
    rule(u64_at(file, 64)? == 0, "sgdByteOffset", "must be 0")?;
    rule(u64_at(file, 72)? == 0, "sgdByteLength", "must be 0")?;

    check_dfd(file, dfd, components, component_bytes)?;
    let kvd_end =
        kvd.checked_add(kvd_length).filter(|end| *end <= file.len()).ok_or("kvdByteLength: beyond the end")?;
    check_kvd(&file[kvd..kvd_end], faces)?;

    // Levels: smallest first, each aligned, nothing but zeros between, nothing behind the largest.
    let texel = components * component_bytes;
    let alignment = (1..).map(|k| k * texel as usize).find(|n| n.is_multiple_of(4)).unwrap();
    let mut end = kvd_end;
    for p in (0..level_count).rev() {
        let entry = 80 + 24 * p as usize;
        let (offset, length) = (u64_at(file, entry)?, u64_at(file, entry + 8)?);
        let pixels = u64::from((width >> p).max(1)) * u64::from((height >> p).max(1));
        rule(length == pixels * u64::from(faces * texel), "byteLength", format!("level {p}: {length}"))?;
        rule(u64_at(file, entry + 16)? == length, "uncompressedByteLength", format!("level {p}"))?;
        rule(offset % alignment as u64 == 0, "level alignment", format!("level {p} at {offset}"))?;
        let start = end.next_multiple_of(alignment);
        rule(offset == start as u64, "level order", format!("level {p} at {offset}, not {start}"))?;
        rule(zeros(file, end, start), "mipPadding", format!("before level {p}"))?;
        end = start + length as usize;
    }
    rule(end == file.len(), "end of file", format!("{} bytes, levels end at {end}", file.len()))
}

fn check_dfd(file: &[u8], dfd: usize, components: u32, component_bytes: u32) -> Result<(), String> {
    let word = |i: usize| u32_at(file, dfd + 4 * i);
    let byte = |i: usize| file.get(dfd + i).copied().ok_or("length: descriptor cut short");
    let block = 24 + 16 * components;
    rule(word(0)? == 4 + block, "dfdTotalSize", word(0)?)?;
    rule(word(1)? == 0, "dfd vendorId and descriptorType", word(1)?)?;
    rule(word(2)? & 0xffff == 2, "dfd versionNumber", word(2)? & 0xffff)?;
    rule(word(2)? >> 16 == block, "dfd descriptorBlockSize", word(2)? >> 16)?;
    rule(byte(12)? == 1, "dfd colorModel", "must be RGBSDA")?;
    rule(byte(13)? == 1, "dfd colorPrimaries", "must be BT709")?;
    rule(byte(14)? == 1, "dfd transferFunction", "must be linear")?;
    rule(byte(15)? == 0, "dfd flags", "alpha must be straight")?;
    rule(word(4)? == 0, "dfd texelBlockDimension", "must be 1 × 1 × 1 × 1, stored less one")?;
    rule(word(5)? == components * component_bytes, "dfd bytesPlane0", word(5)?)?;
    rule(word(6)? == 0, "dfd bytesPlane4-7", word(6)?)?;
    for sample in 0..components {
        let at = 7 + 4 * sample as usize;
        let (bits, info) = (8 * component_bytes, word(at)?);
        rule(info & 0xffff == sample * bits, "dfd bitOffset", format!("sample {sample}"))?;
        rule(info >> 16 & 0xff == bits - 1, "dfd bitLength", format!("sample {sample}"))?;
        rule(info >> 24 & 0xf == [0, 1, 2, 15][sample as usize], "dfd channelType", format!("sample {sample}"))?;
        rule(info >> 28 == 0xc, "dfd qualifiers", format!("sample {sample} must be float and signed"))?;
        rule(word(at + 1)? == 0, "dfd samplePosition", format!("sample {sample}"))?;
        rule(word(at + 2)? == 0xbf80_0000, "dfd sampleLower", format!("sample {sample} must be -1.0"))?;
        rule(word(at + 3)? == 0x3f80_0000, "dfd sampleUpper", format!("sample {sample} must be 1.0"))?;
    }
    Ok(())
}

fn check_kvd(kvd: &[u8], faces: u32) -> Result<(), String> {
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
            "KTXorientation" => rule(faces == 1 && value == "rd", "KTXorientation", value)?,
            _ => rule(!key.to_ascii_lowercase().starts_with("ktx"), "reserved key", key)?,
        }
    }
    rule(at == kvd.len(), "kvdByteLength", "ends within a pair")?;
    rule(writer, "KTXwriter", "missing")
}
