//! Pictures in files of other programs.

use crate::document::check_png;
use crate::limits::PLANT_TEXELS;
use crate::plant::Texture;

/// The texture in a PNG file of at most `texels_left` texels, or why there is none.
pub(in crate::plant) fn decode_png(bytes: &[u8], texels_left: u64) -> Result<Texture, String> {
    let format = image::guess_format(bytes);
    if format.as_ref().ok() != Some(&image::ImageFormat::Png) {
        let name = format.map_or("unknown".to_owned(), |format| format!("{format:?}"));
        return Err(format!("format {name}, wanted PNG; convert it"));
    }
    let reader = || {
        let format = image::ImageFormat::Png;
        let mut reader = image::ImageReader::with_format(std::io::Cursor::new(bytes), format);
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(Texture::MAX_SIDE);
        limits.max_image_height = Some(Texture::MAX_SIDE);
        limits.max_alloc = Some(8 * PLANT_TEXELS);
        reader.limits(limits);
        reader
    };
    let broken = |error: image::ImageError| format!("not a sound PNG: {error}");
    check_png(bytes).map_err(|error| format!("not a sound PNG: {error}"))?;
    let (width, height) = reader().into_dimensions().map_err(broken)?;
    let side = Texture::MAX_SIDE;
    if width > side || height > side {
        return Err(format!(
            "{width} × {height} texels exceed the limit of {side} × {side}"
        ));
    }
    let texels = u64::from(width) * u64::from(height);
    if texels > texels_left {
        return Err(format!(
            "{texels} texels more, but only {texels_left} of {PLANT_TEXELS} are left for this document"
        ));
    }
    let rgba = reader().decode().map_err(broken)?.into_rgba8();
    Texture::new(width, height, rgba.into_raw()).ok_or_else(|| format!("{width} × {height} texels"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_sound_png_of_a_fair_size_is_decoded() {
        let texture = Texture::new(2, 1, vec![1, 2, 3, 4, 5, 6, 7, 0]).unwrap();
        let png = crate::plant::gltf::encode_png(&texture);
        assert_eq!(decode_png(&png, 2).as_ref(), Ok(&texture));
        assert!(
            decode_png(&png, 1)
                .unwrap_err()
                .starts_with("2 texels more")
        );
        assert!(decode_png(&png[..png.len() - 20], 2).is_err());
        let jpeg = [0xff, 0xd8, 0xff, 0xe0];
        assert_eq!(
            decode_png(&jpeg, 9).unwrap_err(),
            "format Jpeg, wanted PNG; convert it"
        );
        assert!(
            decode_png(b"", 9)
                .unwrap_err()
                .starts_with("format unknown")
        );
    }

    #[test]
    fn a_png_that_claims_to_be_vast_is_refused_by_its_header() {
        let texture = Texture::new(1, 1, vec![0; 4]).unwrap();
        let mut png = crate::plant::gltf::encode_png(&texture);
        png[16..20].copy_from_slice(&70_000_u32.to_be_bytes());
        assert!(decode_png(&png, PLANT_TEXELS).is_err());
    }
}
