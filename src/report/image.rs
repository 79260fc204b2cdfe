//! Images out and in: PNG for pictures, EXR for layers of data.

use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;

use exr::image::write::WritableImage as _;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer as ExrLayer,
    LayerAttributes, LineOrder, SmallVec, Text,
};
use image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageDecoder as _, ImageEncoder as _, Limits};

use super::ReportError;
use crate::document;
use crate::limits;

/// How PNG files begin.
pub(super) const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// A picture: sRGB colour with straight alpha, 8 bits a channel, rows top-down.
#[derive(Clone, PartialEq, Eq)]
pub struct Picture {
    width: u32,
    height: u32,
    rgba: Vec<u8>,
}

impl Picture {
    /// The largest width or height.
    pub const MAX_SIDE: u32 = limits::PICTURE_SIDE;

    /// The most pixels: 256 MiB of them.
    pub const MAX_PIXELS: u32 = limits::PICTURE_PIXELS;

    /// A picture of `width × height` pixels, four bytes each.
    ///
    /// # Errors
    ///
    /// When a side is 0 or above [`MAX_SIDE`](Self::MAX_SIDE), there are more than
    /// [`MAX_PIXELS`](Self::MAX_PIXELS), or the bytes do not fit.
    pub fn new(width: u32, height: u32, rgba: Vec<u8>) -> Result<Self, ReportError> {
        check_samples("picture", width, height, 4, rgba.len())?;
        Ok(Self {
            width,
            height,
            rgba,
        })
    }

    /// Reads a PNG file of 1 to 8 bits a channel: grey, indexed or colour, with or without alpha.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, is no such PNG, or exceeds the limits. With 16 bits a channel
    /// it is refused, since rounding could hide a difference.
    pub fn read(path: &Path) -> Result<Self, ReportError> {
        Self::from_png(path, &read_file(path)?)
    }

    /// Reads a PNG file that is in memory already; `file` names it in errors.
    ///
    /// # Errors
    ///
    /// As [`Picture::read`], once the file is read.
    pub fn from_png(file: &Path, bytes: &[u8]) -> Result<Self, ReportError> {
        Self::decode(bytes).map_err(|message| wrong_image(file, message))
    }

    /// Decodes a PNG of up to 8 bits a channel; says what is wrong with it.
    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let decoder = open_png(bytes)?;
        if is_deep(&decoder) {
            return Err("16 bits a channel, wanted 8".to_owned());
        }
        let image = DynamicImage::from_decoder(decoder).map_err(|error| unsound("PNG", &error))?;
        let rgba = image.into_rgba8();
        Ok(Self {
            width: rgba.width(),
            height: rgba.height(),
            rgba: rgba.into_raw(),
        })
    }

    /// Pixels a row.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The bytes R, G, B, A of each pixel, row by row from the top.
    #[must_use]
    pub fn rgba(&self) -> &[u8] {
        &self.rgba
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    ///
    /// As [`encode_png`].
    pub fn to_png(&self) -> Result<Vec<u8>, ReportError> {
        encode_png(self.width, self.height, &self.rgba)
    }

    /// The picture as a PNG file as small as it gets, for what is kept: without alpha where all of
    /// it is opaque, and with the slowest of settings.
    ///
    /// # Errors
    ///
    /// None for a picture.
    pub fn to_small_png(&self) -> Result<Vec<u8>, ReportError> {
        let pixels = self.rgba.as_chunks::<4>().0;
        let opaque = pixels.iter().all(|pixel| pixel[3] == 255);
        let (bytes, format) = if opaque {
            let rgb = pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
            (Cow::Owned(rgb), ExtendedColorType::Rgb8)
        } else {
            (Cow::Borrowed(&self.rgba), ExtendedColorType::Rgba8)
        };
        let mut png = Vec::new();
        PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::Adaptive)
            .write_image(&bytes, self.width, self.height, format)
            .map_err(|error| refused("PNG", &error))?;
        Ok(png)
    }
}

/// An image file as bytes, if it is not too large.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>, ReportError> {
    document::read_file(path, limits::PICTURE_FILE_BYTES)
        .map_err(|error| wrong_image(path, error.to_string()))
}

pub(super) fn wrong_image(path: &Path, message: String) -> ReportError {
    ReportError::Image {
        file: path.to_owned(),
        message,
    }
}

pub(super) fn unsound(format: &str, error: &dyn std::fmt::Display) -> String {
    format!("no sound {format} file: {error}")
}

/// A decoder for a PNG file whose pixels are not too many; says what is wrong with it.
pub(super) fn open_png(bytes: &[u8]) -> Result<PngDecoder<Cursor<&[u8]>>, String> {
    if !bytes.starts_with(PNG_SIGNATURE) {
        return Err("no PNG file".to_owned());
    }
    document::check_png(bytes).map_err(|error| unsound("PNG", &error))?;
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(Picture::MAX_SIDE);
    limits.max_image_height = Some(Picture::MAX_SIDE);
    // Of the decoder's own buffers; the picture is checked below.
    limits.max_alloc = Some(u64::from(Picture::MAX_PIXELS) * 8);
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits)
        .map_err(|error| unsound("PNG", &error))?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if pixels > u64::from(Picture::MAX_PIXELS) {
        let limit = Picture::MAX_PIXELS;
        return Err(format!(
            "{width} × {height} pixels exceed the limit of {limit}"
        ));
    }
    Ok(decoder)
}

/// Whether a PNG file has 16 bits a channel.
pub(super) fn is_deep(decoder: &PngDecoder<Cursor<&[u8]>>) -> bool {
    let colour = decoder.color_type();
    colour.bytes_per_pixel() != colour.channel_count()
}

impl std::fmt::Debug for Picture {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "Picture({} × {})", self.width, self.height)
    }
}

/// RGBA bytes as a PNG file; the same bytes for the same picture, with one version of the encoder.
///
/// Deflate at level 1 with adaptive filters: of the settings that were tried the smallest files but
/// for the slowest, at a quarter of the time.
///
/// # Errors
///
/// When the bytes do not fill the picture or a side is out of range.
pub fn encode_png(width: u32, height: u32, rgba: &[u8]) -> Result<Vec<u8>, ReportError> {
    check_samples("picture", width, height, 4, rgba.len())?;
    let mut png = Vec::new();
    PngEncoder::new_with_quality(&mut png, CompressionType::Level(1), FilterType::Adaptive)
        .write_image(rgba, width, height, ExtendedColorType::Rgba8)
        .map_err(|error| refused("PNG", &error))?;
    Ok(png)
}

/// One channel of an EXR file.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// The name, as EXR has it: `R`, `Z`, `normal.X`, `instance`; 1 to 31 printable ASCII
    /// characters.
    pub name: String,
    /// One sample a pixel, row by row from the top.
    pub samples: LayerSamples,
}

/// The samples of a layer.
#[derive(Debug, Clone, PartialEq)]
pub enum LayerSamples {
    /// Measures, such as depth.
    F32(Vec<f32>),
    /// Names, such as the number of a leaf.
    U32(Vec<u32>),
}

impl LayerSamples {
    fn len(&self) -> usize {
        match self {
            Self::F32(samples) => samples.len(),
            Self::U32(samples) => samples.len(),
        }
    }
}

/// Layers as an EXR file: one part, channels sorted by name, scan lines, ZIP16 (lossless).
///
/// # Errors
///
/// When a layer does not fill the image, a side is out of range, or a name is no channel's, or
/// another's too.
pub fn encode_exr(width: u32, height: u32, layers: Vec<Layer>) -> Result<Vec<u8>, ReportError> {
    let mut channels: Vec<AnyChannel<FlatSamples>> = Vec::with_capacity(layers.len());
    for layer in layers {
        check_samples(&layer.name, width, height, 1, layer.samples.len())?;
        let plain = layer.name.bytes().all(|byte| byte.is_ascii_graphic());
        let name = Text::new_or_none(&layer.name)
            .filter(|_| plain && (1..=31).contains(&layer.name.len()))
            .filter(|name| channels.iter().all(|channel| channel.name != *name));
        let Some(name) = name else {
            return Err(ReportError::LayerName { name: layer.name });
        };
        let samples = match layer.samples {
            LayerSamples::F32(samples) => FlatSamples::F32(samples),
            LayerSamples::U32(samples) => FlatSamples::U32(samples),
        };
        channels.push(AnyChannel::new(name, samples));
    }
    if channels.is_empty() {
        return Err(refused("EXR", &"no layer"));
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = ExrLayer::new(
        (width as usize, height as usize),
        LayerAttributes::default(),
        encoding,
        AnyChannels::sort(SmallVec::from_vec(channels)),
    );
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut file)
        .map_err(|error| refused("EXR", &error))?;
    Ok(file.into_inner())
}

fn refused(format: &'static str, message: &dyn std::fmt::Display) -> ReportError {
    ReportError::Encode {
        format,
        message: message.to_string(),
    }
}

fn check_samples(
    what: &str,
    width: u32,
    height: u32,
    each: usize,
    found: usize,
) -> Result<(), ReportError> {
    let sides = 1..=Picture::MAX_SIDE;
    let pixels = u64::from(width) * u64::from(height);
    let wanted = if !sides.contains(&width) || !sides.contains(&height) {
        format!("sides from 1 to {}", Picture::MAX_SIDE)
    } else if pixels > u64::from(Picture::MAX_PIXELS) {
        format!("at most {} pixels", Picture::MAX_PIXELS)
    } else if found as u64 != pixels * each as u64 {
        format!("{}", pixels * each as u64)
    } else {
        return Ok(());
    };
    Err(ReportError::Samples {
        what: what.to_owned(),
        found,
        width,
        height,
        wanted,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Digester, Stream};

    /// Smooth, noisy and transparent parts.
    fn example() -> Picture {
        let noise = Stream::new(1, 0);
        let rgba = (0..32 * 24_u32).flat_map(|pixel| {
            let (x, y) = (pixel % 32, pixel / 32);
            let grain = noise.below(u64::from(pixel), 16);
            [8 * x, 10 * y, x * y % 256, 255 - 8 * y]
                .map(|value| u8::try_from(u64::from(value) ^ grain).expect("below 256"))
        });
        Picture::new(32, 24, rgba.collect()).expect("filled")
    }

    #[test]
    fn png_reads_back_and_is_the_same_every_time() {
        let picture = example();
        let png = picture.to_png().unwrap();
        assert_eq!(Picture::decode(&png).unwrap(), picture);
        assert_eq!(picture.to_png().unwrap(), png);
        // Renew with the encoder's version: files differ then, pictures do not.
        assert_eq!(
            Digester::new("png").raw(&png).finish().to_string(),
            "107e0dc298ad9c8ffb4ccac71a7786219535f47245442c1d298b509d98f953bb"
        );
    }

    #[test]
    fn small_png_files_say_the_same() {
        let clear = example();
        let solid = clear.rgba().as_chunks::<4>().0.iter();
        let solid = solid.flat_map(|&[r, g, b, _]| [r, g, b, 255]).collect();
        let solid = Picture::new(32, 24, solid).unwrap();
        for (picture, colour_type) in [(clear, 6), (solid, 2)] {
            let png = picture.to_small_png().unwrap();
            assert_eq!(png[25], colour_type);
            assert_eq!(Picture::decode(&png).unwrap(), picture);
        }
    }

    #[test]
    fn unsound_png_files_are_refused() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("a.png");
        let message = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            let error = Picture::read(&path).unwrap_err();
            assert!(!error.is_write());
            let text = error.to_string();
            text.strip_prefix(&format!("{}: ", path.display()))
                .unwrap()
                .to_owned()
        };
        assert_eq!(message(b"GIF89a"), "no PNG file");
        let png = example().to_png().unwrap();
        assert!(message(&png[..png.len() / 2]).starts_with("no sound PNG file: "));
        let mut damaged = png.clone();
        damaged[60] ^= 1;
        assert!(message(&damaged).starts_with("no sound PNG file: "));
        // A header that asks for 65535 × 65535 pixels, with its checksum right.
        let mut huge = png[..33].to_vec();
        huge[16..24].copy_from_slice(&[0, 0, 255, 255, 0, 0, 255, 255]);
        let checksum = crc(&huge[12..29]).to_be_bytes();
        huge[29..33].copy_from_slice(&checksum);
        huge.extend_from_slice(&png[33..]);
        assert_eq!(
            message(&huge),
            "65535 × 65535 pixels exceed the limit of 67108864"
        );
        let mut deep = Vec::new();
        PngEncoder::new(&mut deep)
            .write_image(&[0, 1], 1, 1, ExtendedColorType::L16)
            .unwrap();
        assert_eq!(message(&deep), "16 bits a channel, wanted 8");
        std::fs::remove_file(&path).unwrap();
        assert!(
            Picture::read(&path)
                .unwrap_err()
                .to_string()
                .contains("cannot read: ")
        );
    }

    /// The checksum of PNG chunks, bit by bit.
    fn crc(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0, |crc, byte| {
            (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
                (crc >> 1) ^ (0xedb8_8320 * (crc & 1))
            })
        })
    }

    #[test]
    fn grey_png_files_become_colour() {
        let mut grey = Vec::new();
        PngEncoder::new(&mut grey)
            .write_image(&[7, 9], 2, 1, ExtendedColorType::L8)
            .unwrap();
        let picture = Picture::decode(&grey).unwrap();
        assert_eq!(picture.rgba(), [7, 7, 7, 255, 9, 9, 9, 255]);
    }

    #[test]
    fn samples_must_fill_the_image() {
        let error = encode_png(2, 2, &[0; 15]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "picture: 15 samples for 2 × 2 pixels, wanted 16"
        );
        assert!(encode_png(0, 2, &[]).is_err());
        assert!(Picture::new(65_536, 1, vec![0; 65_536 * 4]).is_err());
    }

    fn layer(name: &str, samples: LayerSamples) -> Layer {
        Layer {
            name: name.to_owned(),
            samples,
        }
    }

    #[test]
    fn exr_layers_read_back_to_the_bit() {
        use exr::prelude::{ReadChannels as _, ReadLayers as _};
        let depth: Vec<f32> = (0..48_u8).map(|index| f32::from(index) / 7.0).collect();
        let leaves: Vec<u32> = (0..48).map(|index| u32::MAX - index * 7).collect();
        let layers = vec![
            layer("leaf", LayerSamples::U32(leaves.clone())),
            layer("Z", LayerSamples::F32(depth.clone())),
        ];
        let file = encode_exr(8, 6, layers.clone()).unwrap();
        assert_eq!(encode_exr(8, 6, layers).unwrap(), file);
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(&file))
            .unwrap();
        let channels = &image.layer_data.channel_data.list;
        assert_eq!(channels.len(), 2);
        assert_eq!(channels[0].name, Text::from("Z"));
        assert_eq!(channels[0].sample_data, FlatSamples::F32(depth));
        assert_eq!(channels[1].sample_data, FlatSamples::U32(leaves));
        assert_eq!(
            Digester::new("exr").raw(&file).finish().to_string(),
            "a9f43d8392e6fcf7a1b962f7e89239b64400f38b4dced03a17516642dcb852ba"
        );
    }

    #[test]
    fn unsound_layers_are_refused() {
        let one = || LayerSamples::F32(vec![0.0]);
        for layers in [
            vec![],
            vec![layer("", one())],
            vec![layer("a b", one())],
            vec![layer("Z", one()), layer("Z", one())],
            vec![layer(&"Z".repeat(32), one())],
            vec![layer("Z", LayerSamples::U32(vec![0, 0]))],
        ] {
            assert!(encode_exr(1, 1, layers).is_err());
        }
    }
}
