//! Reference files: how they are called, how large they may be, what they hold.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use super::outcome::FindingKind;
use crate::limits;
use crate::report::Picture;

/// The largest side of a reference picture, in pixels; [`KEYS`](crate::scene::KEYS) allows no scene
/// more.
pub const MAX_SIDE: u32 = limits::GOLDEN_SIDE;

/// The largest reference file, in bytes: what a repository can hold hundreds of.
pub const MAX_FILE_BYTES: u64 = limits::GOLDEN_BYTES;

/// The references of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct FrameFiles {
    /// The picture's path below the folder of references, with `/` between the parts.
    pub(super) picture_name: String,
    /// The table's.
    pub(super) table_name: String,
    /// Where the picture is.
    pub(super) picture: PathBuf,
    /// Where the table is.
    pub(super) table: PathBuf,
}

impl FrameFiles {
    pub(super) fn of(references: &Path, scene: &str, frame: u32) -> Self {
        let picture_name = format!("{scene}-{frame:04}.png");
        let table_name = format!("{scene}-{frame:04}.txt");
        Self {
            picture: references.join(&picture_name),
            table: references.join(&table_name),
            picture_name,
            table_name,
        }
    }
}

/// The scene whose reference a file would be, by its path below the folder of references.
pub(super) fn scene_of(name: &str) -> Option<&str> {
    let stem = name.strip_suffix(".png").or(name.strip_suffix(".txt"))?;
    let (scene, number) = stem.rsplit_once('-')?;
    let is_number = number.len() >= 4 && number.bytes().all(|byte| byte.is_ascii_digit());
    (is_number && !scene.is_empty() && !scene.ends_with('/')).then_some(scene)
}

/// Reads a reference picture.
pub(super) fn read_picture(file: &Path) -> Result<Picture, FindingKind> {
    let bytes = read(file)?;
    // Before it is decoded: few bytes can be many pixels.
    if let Some(size) = png_size(&bytes)
        && size.iter().any(|side| *side > MAX_SIDE)
    {
        return Err(FindingKind::Oversized {
            size: Some(size),
            bytes: bytes.len() as u64,
        });
    }
    Picture::read(file).map_err(|error| FindingKind::Unreadable(error.to_string()))
}

/// Reads a reference text.
pub(super) fn read_text(file: &Path) -> Result<String, FindingKind> {
    let bytes = read(file)?;
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        FindingKind::Unreadable(format!("not UTF-8 at byte {at}"))
    })
}

fn read(file: &Path) -> Result<Vec<u8>, FindingKind> {
    let wrong = |error: io::Error| match error.kind() {
        io::ErrorKind::NotFound => FindingKind::Missing,
        _ => FindingKind::Unreadable(format!("cannot read: {error}")),
    };
    let opened = File::open(file).map_err(wrong)?;
    let mut bytes = Vec::new();
    let most = opened.take(MAX_FILE_BYTES + 1);
    { most }.read_to_end(&mut bytes).map_err(wrong)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(FindingKind::Oversized {
            size: png_size(&bytes),
            bytes: fs::metadata(file).map_or(bytes.len() as u64, |metadata| metadata.len()),
        });
    }
    Ok(bytes)
}

/// Width and height of a PNG file, from its first chunk.
fn png_size(bytes: &[u8]) -> Option<[u32; 2]> {
    if !bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        return None;
    }
    let number = |at: usize| {
        let bytes: [u8; 4] = bytes.get(at..at + 4)?.try_into().ok()?;
        Some(u32::from_be_bytes(bytes))
    };
    Some([number(16)?, number(20)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::index_usize;

    #[test]
    fn references_are_known_by_their_names() {
        for (name, scene) in [
            ("a-0000.png", Some("a")),
            ("b/c/a-b-12345.txt", Some("b/c/a-b")),
            ("a-000.png", None),
            ("a-0000.jpg", None),
            ("a-00x0.png", None),
            ("-0000.png", None),
            ("b/-0000.png", None),
            ("digests.txt", None),
        ] {
            assert_eq!(scene_of(name), scene, "{name}");
        }
    }

    #[test]
    fn sizes_are_known_before_decoding() {
        let root = tempfile::tempdir().unwrap();
        let file = root.path().join("a.png");
        assert_eq!(read_picture(&file), Err(FindingKind::Missing));
        let png = |width: u32, height: u32| {
            let rgba = vec![255; 4 * (width * height) as usize];
            Picture::new(width, height, rgba)
                .unwrap()
                .to_small_png()
                .unwrap()
        };
        fs::write(&file, png(161, 2)).unwrap();
        let Err(FindingKind::Oversized { size, .. }) = read_picture(&file) else {
            panic!("161 pixels are too many");
        };
        assert_eq!(size, Some([161, 2]));
        fs::write(&file, png(160, 160)).unwrap();
        assert_eq!(read_picture(&file).map(|picture| picture.width()), Ok(160));
        let mut large = png(1, 1);
        large.resize(index_usize(MAX_FILE_BYTES) + 1, 0);
        fs::write(&file, large).unwrap();
        let large = Err(FindingKind::Oversized {
            size: Some([1, 1]),
            bytes: MAX_FILE_BYTES + 1,
        });
        assert_eq!(read_picture(&file), large);
    }
}
