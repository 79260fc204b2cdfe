//! Where buffers and images lie: in the document as `data:`, or in files beside it.

use std::path::{Path, PathBuf};

/// The bytes of a `data:` URI; `None` if it is not one.
///
/// Only base64 is understood: nothing else is written by anything.
pub(super) fn decode_data(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let rest = uri.strip_prefix("data:")?;
    let Some((head, body)) = rest.split_once(',') else {
        return Some(Err("a data: URI without a comma".to_owned()));
    };
    if !head.ends_with(";base64") {
        let message = "a data: URI that is not base64; write it as ;base64".to_owned();
        return Some(Err(message));
    }
    Some(decode_base64(body))
}

/// The bytes that standard base64 stands for; padding may be missing, anything else may not.
pub(super) fn decode_base64(text: &str) -> Result<Vec<u8>, String> {
    let digits = text.trim_end_matches('=').as_bytes();
    let padding = text.len() - digits.len();
    if digits.len() % 4 == 1 || padding > 2 {
        let length = text.len();
        return Err(format!(
            "base64 of {length} characters, {padding} of them padding, is cut off"
        ));
    }
    let mut out = Vec::with_capacity(digits.len() / 4 * 3 + 2);
    for (group, chunk) in digits.chunks(4).enumerate() {
        let mut word = 0_u32;
        for (place, &digit) in chunk.iter().enumerate() {
            let value = match digit {
                b'A'..=b'Z' => digit - b'A',
                b'a'..=b'z' => digit - b'a' + 26,
                b'0'..=b'9' => digit - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => {
                    let at = group * 4 + place;
                    return Err(format!("byte {digit:#04x} at {at} is no base64 digit"));
                }
            };
            word |= u32::from(value) << (18 - 6 * place);
        }
        let bytes = word.to_be_bytes();
        out.extend_from_slice(&bytes[1..chunk.len()]);
    }
    Ok(out)
}

/// The file that a relative URI names, in `folder`.
pub(super) fn resolve(uri: &str, folder: Option<&Path>) -> Result<PathBuf, String> {
    let Some(folder) = folder else {
        return Err(format!("names the file {uri:?}, but no folder is known"));
    };
    relative_path(uri).map(|path| folder.join(path))
}

/// The relative path that a URI stands for, `%` sequences decoded.
pub(super) fn relative_path(uri: &str) -> Result<String, String> {
    let is_scheme = |scheme: &str| {
        scheme.len() > 1
            && scheme
                .chars()
                .all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    };
    let has_scheme = uri.split_once(':').is_some_and(|(head, _)| is_scheme(head));
    let decoded = percent_decode(uri);
    let Some(decoded) = decoded.filter(|path| !path.contains('\0')) else {
        return Err(format!("{uri:?} is not a valid relative path"));
    };
    let path = Path::new(&decoded);
    if has_scheme || path.is_absolute() || path.has_root() {
        return Err(format!(
            "{uri:?} is not a relative path; put the file beside the document"
        ));
    }
    Ok(decoded)
}

fn percent_decode(uri: &str) -> Option<String> {
    let mut out = Vec::with_capacity(uri.len());
    let mut bytes = uri.bytes();
    while let Some(byte) = bytes.next() {
        if byte == b'%' {
            let mut digit = || char::from(bytes.next()?).to_digit(16);
            let value = 16 * digit()? + digit()?;
            out.push(u8::try_from(value).ok()?);
        } else {
            out.push(byte);
        }
    }
    String::from_utf8(out).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_every_length() {
        for (text, bytes) in [
            ("", &b""[..]),
            ("Zg==", b"f"),
            ("Zg", b"f"),
            ("Zm8=", b"fo"),
            ("Zm9v", b"foo"),
            ("Zm9vYmE+", b"fooba>"),
        ] {
            assert_eq!(decode_base64(text).as_deref(), Ok(bytes), "{text}");
        }
        for text in ["Z", "Zm9vY", "Zm 9", "Zg=a", "Zg===", "Zä"] {
            assert!(decode_base64(text).is_err(), "{text}");
        }
    }

    #[test]
    fn data_uris_say_what_is_wrong() {
        assert_eq!(decode_data("tree.bin"), None);
        let bytes = decode_data("data:application/octet-stream;base64,Zm9v");
        assert_eq!(bytes, Some(Ok(b"foo".to_vec())));
        assert!(decode_data("data:text/plain,foo").is_some_and(|bytes| bytes.is_err()));
        assert!(decode_data("data:").is_some_and(|bytes| bytes.is_err()));
    }

    #[test]
    fn only_relative_paths_are_followed() {
        let folder = Some(Path::new("here"));
        let found = resolve("my%20tree.bin", folder);
        assert_eq!(found, Ok(Path::new("here").join("my tree.bin")));
        for uri in [
            "/etc/passwd",
            "file:///x",
            "https://a/b",
            "%2Fetc",
            "a%00b",
            "a%f",
        ] {
            assert!(resolve(uri, folder).is_err(), "{uri}");
        }
        assert!(resolve("tree.bin", None).is_err());
    }
}
