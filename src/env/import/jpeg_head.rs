// SPDX-License-Identifier: MIT OR Apache-2.0
//! The segments of a JPEG before its first scan, as ISO/IEC 10918-1 (B.1, B.2.2) lays them out: how a picture's components are sampled.
//!
//! The decoder takes more than the standard allows, and meets an assertion where a component is sampled finer than the first.

/// Why a picture with these bytes is not one that the decoder can be trusted with; nothing where it is.
pub fn refusal(bytes: &[u8]) -> Option<String> {
    let Some(components) = components(bytes) else {
        return Some("what lies before its pixels is not a chain of segments".into());
    };
    let [first, others @ ..] = components.as_slice() else { return Some("it has no components".into()) };
    let divides = |other: &[u8; 2]| (0..2).all(|axis| other[axis] != 0 && first[axis].is_multiple_of(other[axis]));
    let is_alike = others.len() < 2 || others[0] == others[1];
    if divides(first) && others.iter().all(divides) && is_alike {
        return None;
    }
    let factors: Vec<String> = components.iter().map(|[h, v]| format!("{h}x{v}")).collect();
    Some(format!(
        "its components are sampled {}, not in whole parts of the first and the two of colour alike",
        factors.join(", ")
    ))
}

/// Samples across and down that each component has in a block, from the frame's header.
fn components(bytes: &[u8]) -> Option<Vec<[u8; 2]>> {
    let mut found = None;
    let mut rest = bytes.strip_prefix(&[0xff, 0xd8])?;
    loop {
        let fill = rest.iter().take_while(|&&byte| byte == 0xff).count();
        let (marker, after) = rest[fill..].split_first().filter(|_| fill > 0)?;
        let length = usize::from(u16::from_be_bytes(*after.first_chunk()?));
        let segment = after.get(2..length)?;
        match marker {
            // Start of scan.
            0xda => return found,
            // Start of frame: all codes of c0 to cf but those of tables and of what is reserved.
            0xc0..=0xcf if ![0xc4, 0xc8, 0xcc].contains(marker) => {
                // Precision, two bytes each of height and width, how many components; then three bytes each.
                let (head, each) = segment.split_at_checked(6)?;
                let factors: Vec<_> = each.chunks_exact(3).map(|c| [c[1] >> 4, c[1] & 15]).collect();
                if found.is_some() || each.len() != 3 * usize::from(head[5]) {
                    return None;
                }
                found = Some(factors);
            }
            // Marks that stand alone, which have no place here.
            0x00..=0x01 | 0xd0..=0xd9 => return None,
            _ => {}
        }
        rest = &after[length..];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture's segments up to its scan.
    fn head(factors: &[u8]) -> Vec<u8> {
        let mut bytes = vec![0xff, 0xd8, 0xff, 0xe0, 0, 4, 1, 2];
        bytes.extend([0xff, 0xff, 0xc2, 0, 8 + 3 * factors.len() as u8, 8, 0, 4, 0, 8, factors.len() as u8]);
        bytes.extend(factors.iter().flat_map(|&f| [1, f, 0]));
        bytes.extend([0xff, 0xda, 0, 2]);
        bytes
    }

    #[test]
    fn pictures_as_encoders_make_them_pass() {
        // Grey; 4:4:4, also in larger blocks; 4:2:2; 4:2:0; 4:4:0; 4:1:1; CMYK whose black is as fine as its first.
        let known: [&[u8]; 9] = [
            &[0x11],
            &[0x22],
            &[0x11, 0x11, 0x11],
            &[0x22, 0x22, 0x22],
            &[0x21, 0x11, 0x11],
            &[0x22, 0x11, 0x11],
            &[0x12, 0x11, 0x11],
            &[0x41, 0x11, 0x11],
            &[0x22, 0x11, 0x11, 0x22],
        ];
        for factors in known {
            assert_eq!(refusal(&head(factors)), None, "{factors:x?}");
        }
    }

    #[test]
    fn components_finer_than_the_first_are_named() {
        let said = refusal(&head(&[0x11, 0x22, 0x11])).unwrap();
        assert!(said.contains("1x1, 2x2, 1x1"), "{said}");
        for factors in [[0x22, 0x11, 0x12], [0x21, 0x12, 0x12], [0x11, 0x10, 0x10], [0x32, 0x21, 0x21]] {
            assert!(refusal(&head(&factors)).is_some(), "{factors:x?}");
        }
    }

    #[test]
    fn broken_chains_are_refused() {
        let whole = head(&[0x11, 0x11, 0x11]);
        for end in 0..whole.len() {
            assert!(refusal(&whole[..end]).is_some(), "{end} bytes");
        }
        let mut between = whole.clone();
        between.insert(8, 0);
        assert!(refusal(&between).is_some());
        // Two frames.
        let frame = whole[8..whole.len() - 4].to_vec();
        let twice = [&whole[..8], &frame, &frame, &[0xff, 0xda, 0, 2]].concat();
        assert!(refusal(&twice).is_some());
    }
}
