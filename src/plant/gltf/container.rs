//! The outermost layer of a file: a GLB's header and chunks, or plain JSON.

use crate::plant::import::{ImportError, ImportReport, ReportKind};

/// The two parts of a glTF file.
#[derive(Debug)]
pub(super) struct Container<'a> {
    /// The document.
    pub(super) json: &'a [u8],
    /// Where the document begins in the file; 0 unless the file is binary.
    pub(super) json_offset: u64,
    /// The binary chunk, if there is one.
    pub(super) binary: Option<&'a [u8]>,
}

/// Splits a file into its parts; anything that does not begin like a GLB is taken as JSON.
pub(super) fn split<'a>(
    file: &str,
    bytes: &'a [u8],
    report: &mut ImportReport,
) -> Result<Container<'a>, ImportError> {
    let length = bytes.len() as u64;
    if !bytes.starts_with(MAGIC) {
        // The byte order mark is forbidden here, and common.
        let marked = bytes.starts_with(b"\xef\xbb\xbf");
        let json_offset = if marked { 3 } else { 0 };
        return Ok(Container {
            json: &bytes[usize::from(marked) * 3..],
            json_offset,
            binary: None,
        });
    }
    let fail = |offset: u64, message: String| ImportError::Binary {
        file: file.to_owned(),
        offset,
        message,
    };
    let word = |offset: usize, what: &str| {
        let word = bytes.get(offset..offset + 4).map(le_u32);
        word.ok_or_else(|| {
            let wanted = offset + 4;
            fail(
                length,
                format!("{what} ends at byte {wanted}, but the file has {length}; it is cut off"),
            )
        })
    };
    let version = word(4, "the GLB version")?;
    if version != 2 {
        return Err(fail(
            4,
            format!("GLB version {version}, wanted 2; convert the file to glTF 2.0"),
        ));
    }
    let declared = u64::from(word(8, "the GLB length")?);
    if declared > length {
        return Err(fail(
            8,
            format!("the header promises {declared} bytes, the file has {length}; it is cut off"),
        ));
    }
    let end = usize::try_from(declared).expect("no larger than the slice");
    report.add(
        ReportKind::Ignored,
        length - declared,
        format!("byte {declared}"),
        "bytes after the end that the GLB header states",
    );
    let mut json = None;
    let mut binary = None;
    let mut at = HEADER_BYTES;
    while at < end {
        let size = word(at, "a chunk's length")? as usize;
        let kind = word(at + 4, "a chunk's type")?;
        let start = at + 8;
        let room = end.saturating_sub(start);
        if size > room {
            return Err(fail(
                at as u64,
                format!("a chunk of {size} bytes in the {room} that are left; the file is cut off"),
            ));
        }
        let chunk = &bytes[start..start + size];
        match kind {
            JSON_CHUNK if json.is_none() => json = Some((start as u64, chunk)),
            BINARY_CHUNK if json.is_some() && binary.is_none() => binary = Some(chunk),
            _ if json.is_none() => {
                return Err(fail(
                    at as u64,
                    format!(
                        "the first chunk has type {kind:#010x}, wanted {JSON_CHUNK:#010x} (JSON)"
                    ),
                ));
            }
            _ => report.add(
                ReportKind::Ignored,
                1,
                format!("byte {at}"),
                "chunks of an unknown type",
            ),
        }
        // Chunks are padded to 4 bytes; lengths that are not multiples of it are tolerated.
        at = start + size.next_multiple_of(4).min(room);
    }
    let Some((json_offset, json)) = json else {
        return Err(fail(
            declared,
            format!("no JSON chunk in {declared} bytes; the file is cut off"),
        ));
    };
    Ok(Container {
        json,
        json_offset,
        binary,
    })
}

/// Joins a document and its binary chunk to a GLB.
pub(super) fn join(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let json_size = json.len().next_multiple_of(4);
    let binary_size = binary.len().next_multiple_of(4);
    let has_binary = !binary.is_empty();
    let total = HEADER_BYTES + 8 + json_size + if has_binary { 8 + binary_size } else { 0 };
    let mut out = Vec::with_capacity(total);
    let word = |out: &mut Vec<u8>, value: usize| {
        let value = crate::math::index_u32(value);
        out.extend_from_slice(&value.to_le_bytes());
    };
    out.extend_from_slice(MAGIC);
    word(&mut out, 2);
    word(&mut out, total);
    word(&mut out, json_size);
    out.extend_from_slice(&JSON_CHUNK.to_le_bytes());
    out.extend_from_slice(json);
    out.resize(HEADER_BYTES + 8 + json_size, b' ');
    if has_binary {
        word(&mut out, binary_size);
        out.extend_from_slice(&BINARY_CHUNK.to_le_bytes());
        out.extend_from_slice(binary);
        out.resize(total, 0);
    }
    out
}

const MAGIC: &[u8; 4] = b"glTF";
const HEADER_BYTES: usize = 12;
const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
const BINARY_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");

/// The little-endian value of four bytes.
pub(super) fn le_u32(bytes: &[u8]) -> u32 {
    u32::from_le_bytes(bytes.try_into().expect("callers slice four bytes"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_parts_split_again() {
        let glb = join(b"{}", &[1, 2, 3]);
        let mut report = ImportReport::default();
        let container = split("a.glb", &glb, &mut report).unwrap();
        assert_eq!(container.json, b"{}  ");
        assert_eq!(container.json_offset, 20);
        assert_eq!(container.binary, Some(&[1, 2, 3, 0][..]));
        assert_eq!(report, ImportReport::default());
    }

    #[test]
    fn a_chunk_past_the_end_is_named_with_both_numbers() {
        let mut glb = join(b"{}  ", &[1, 2, 3, 4]);
        glb[24] = 200;
        let error = split("a.glb", &glb, &mut ImportReport::default()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "a.glb: byte 24: a chunk of 200 bytes in the 4 that are left; the file is cut off"
        );
    }

    #[test]
    fn strange_chunks_and_tails_are_reported() {
        let mut glb = join(b"{}  ", &[1, 2, 3, 4]);
        glb[28..32].copy_from_slice(b"ODD\0");
        glb.extend_from_slice(b"tail");
        let mut report = ImportReport::default();
        let container = split("a.glb", &glb, &mut report).unwrap();
        assert_eq!(container.binary, None);
        assert_eq!(report.entries.len(), 2);
        assert_eq!(report.entries[0].count, 4);
    }
}
