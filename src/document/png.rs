//! What PNG decoders take on trust.

/// Checks the palette of a PNG file: the decoder that is used here expands each of its entries, and
/// panics at one that is cut off.
///
/// # Errors
///
/// What is wrong, when a palette before the pixels is none of 1 to 256 entries of three bytes.
pub fn check_png(bytes: &[u8]) -> Result<(), String> {
    // A signature, and then chunks: length, type, so many bytes, checksum.
    let mut rest = bytes.get(8..).unwrap_or_default();
    while let Some((head, after)) = rest.split_first_chunk::<8>() {
        let [a, b, c, d, kind @ ..] = *head;
        let length = u32::from_be_bytes([a, b, c, d]);
        if &kind == b"IDAT" {
            break;
        }
        if &kind == b"PLTE" && (length % 3 != 0 || !(3..=768).contains(&length)) {
            return Err(format!(
                "a palette of {length} bytes, wanted 1 to 256 entries of 3 bytes"
            ));
        }
        let next = usize::try_from(length)
            .ok()
            .and_then(|length| length.checked_add(4));
        rest = next.and_then(|next| after.get(next..)).unwrap_or_default();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_palette(bytes: u32) -> Vec<u8> {
        let mut file = b"\x89PNG\r\n\x1a\n\0\0\0\x01tEXt_0000".to_vec();
        file.extend(bytes.to_be_bytes());
        file.extend(b"PLTE");
        file.resize(file.len() + bytes as usize + 4, 0);
        file.extend(b"\0\0\0\0IDAT0000\0\0\0\x01PLTE");
        file
    }

    #[test]
    fn palettes_have_whole_entries() {
        for bytes in [3, 6, 768] {
            assert_eq!(check_png(&with_palette(bytes)), Ok(()));
        }
        for bytes in [0, 1, 49, 769, 771] {
            let said = check_png(&with_palette(bytes)).unwrap_err();
            assert!(said.contains(&format!("of {bytes} bytes")), "{said}");
        }
        for cut in 0..30 {
            _ = check_png(&with_palette(49)[..cut]);
        }
        let mut vast = with_palette(3);
        vast[8..12].copy_from_slice(&u32::MAX.to_be_bytes());
        assert_eq!(check_png(&vast), Ok(()));
    }
}
