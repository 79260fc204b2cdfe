//! Image files as they are, channel by channel: PNG of 8 or 16 bits, EXR with any channels.

use std::io::Cursor;
use std::path::Path;

use exr::meta::MetaData;
use exr::prelude::{FlatSamples, ReadChannels as _, ReadLayers as _};
use image::DynamicImage;

use super::image::{PNG_SIGNATURE, is_deep, open_png, read_file, unsound, wrong_image};
use super::{LayerSamples, Picture, ReportError};
use crate::math::index_u32;

/// How EXR files begin.
const EXR_SIGNATURE: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

/// An image file.
#[derive(Debug, Clone, PartialEq)]
pub enum ImageFile {
    /// A PNG of up to 8 bits a channel.
    Picture(Picture),
    /// A PNG of 16 bits a channel, as channels `R`, `G`, `B`, `A` of encoded sRGB.
    Deep(Vec<Channel>),
    /// An EXR: the channels of all its parts, sorted by name.
    Exr(Vec<Channel>),
}

/// One channel of an image file.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// The name; in a file of several parts that of its part, if it has one, and a dot before it.
    pub name: String,
    /// What its samples are in the file.
    pub kind: SampleKind,
    /// The place of its first sample: x, y.
    pub origin: [i32; 2],
    /// Samples a row, rows.
    pub size: [u32; 2],
    /// The samples, row by row from the top, widened without loss.
    pub samples: LayerSamples,
}

/// What samples are in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleKind {
    /// Floats of 16 bits.
    F16,
    /// Floats of 32 bits.
    F32,
    /// Integers of 16 bits, 65,535 for 1.
    U16,
    /// Integers of 32 bits.
    U32,
}

impl SampleKind {
    /// The name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::F16 => "f16",
            Self::F32 => "f32",
            Self::U16 => "u16",
            Self::U32 => "u32",
        }
    }
}

impl ImageFile {
    /// The most samples of an EXR file, all channels together: 1 GiB of them.
    pub const MAX_SAMPLES: u64 = crate::limits::CHANNEL_SAMPLES;

    /// Reads a PNG or EXR file; what it begins with tells which it is.
    ///
    /// Of tiles with several levels of resolution the finest is read. Deep data and channels with
    /// fewer samples than pixels are refused.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, is neither, or exceeds the limits.
    pub fn read(path: &Path) -> Result<Self, ReportError> {
        Self::from_bytes(path, &read_file(path)?)
    }

    /// Reads a file that is in memory already; `file` names it in errors.
    ///
    /// # Errors
    ///
    /// As [`ImageFile::read`], once the file is read.
    pub fn from_bytes(file: &Path, bytes: &[u8]) -> Result<Self, ReportError> {
        Self::decode(bytes).map_err(|message| wrong_image(file, message))
    }

    /// Decodes an image file; says what is wrong with it.
    pub(super) fn decode(bytes: &[u8]) -> Result<Self, String> {
        if bytes.starts_with(EXR_SIGNATURE) {
            return Ok(Self::Exr(decode_exr(bytes)?));
        }
        if !bytes.starts_with(PNG_SIGNATURE) {
            return Err("neither a PNG nor an EXR file".to_owned());
        }
        let decoder = open_png(bytes)?;
        let deep = is_deep(&decoder);
        let image = DynamicImage::from_decoder(decoder).map_err(|error| unsound("PNG", &error))?;
        if deep {
            let image = image.into_rgba16();
            let size = [image.width(), image.height()];
            return Ok(Self::Deep(deep_channels(size, image.as_raw())));
        }
        let image = image.into_rgba8();
        let (width, height) = image.dimensions();
        let picture = Picture::new(width, height, image.into_raw());
        Ok(Self::Picture(picture.map_err(|error| error.to_string())?))
    }

    /// What the file is, in a word.
    #[must_use]
    pub fn format(&self) -> &'static str {
        match self {
            Self::Picture(_) => "PNG, 8 bits",
            Self::Deep(_) => "PNG, 16 bits",
            Self::Exr(_) => "EXR",
        }
    }
}

/// R, G, B, A from pixels of four samples each.
pub(super) fn deep_channels(size: [u32; 2], rgba: &[u16]) -> Vec<Channel> {
    let channel = |(place, name): (usize, &str)| {
        let samples = rgba.iter().skip(place).step_by(4);
        Channel {
            name: name.to_owned(),
            kind: SampleKind::U16,
            origin: [0; 2],
            size,
            samples: LayerSamples::U32(samples.map(|&sample| u32::from(sample)).collect()),
        }
    };
    ["R", "G", "B", "A"]
        .into_iter()
        .enumerate()
        .map(channel)
        .collect()
}

fn decode_exr(bytes: &[u8]) -> Result<Vec<Channel>, String> {
    let wrong = |error: exr::error::Error| unsound("EXR", &error);
    let head = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(wrong)?;
    let mut samples = 0_u64;
    for header in &head.headers {
        if header.deep {
            return Err("deep data, wanted one sample a pixel".to_owned());
        }
        let [width, height] = [header.layer_size.x(), header.layer_size.y()];
        let sides = 1..=Picture::MAX_SIDE as usize;
        let pixels = width as u64 * height as u64;
        if !sides.contains(&width)
            || !sides.contains(&height)
            || pixels > u64::from(Picture::MAX_PIXELS)
        {
            let limit = Picture::MAX_PIXELS;
            return Err(format!(
                "{width} × {height} pixels exceed the limit of {limit}"
            ));
        }
        for channel in &header.channels.list {
            if channel.sampling.x() != 1 || channel.sampling.y() != 1 {
                return Err(format!(
                    "channel {} has fewer samples than pixels",
                    channel.name
                ));
            }
            samples += pixels;
        }
    }
    if samples > ImageFile::MAX_SAMPLES {
        let limit = ImageFile::MAX_SAMPLES;
        return Err(format!("{samples} samples exceed the limit of {limit}"));
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(wrong)?;
    let mut channels = Vec::new();
    let is_alone = image.layer_data.len() == 1;
    for layer in image.layer_data {
        let part = layer.attributes.layer_name.filter(|_| !is_alone);
        let part = part.map_or(String::new(), |name| format!("{name}."));
        let position = layer.attributes.layer_position;
        for channel in layer.channel_data.list {
            let (kind, samples) = match channel.sample_data {
                FlatSamples::F16(samples) => {
                    let wide = samples.into_iter().map(f32::from).collect();
                    (SampleKind::F16, LayerSamples::F32(wide))
                }
                FlatSamples::F32(samples) => (SampleKind::F32, LayerSamples::F32(samples)),
                FlatSamples::U32(samples) => (SampleKind::U32, LayerSamples::U32(samples)),
            };
            channels.push(Channel {
                name: format!("{part}{}", channel.name),
                kind,
                origin: [position.x(), position.y()],
                size: [layer.size.x(), layer.size.y()].map(index_u32),
                samples,
            });
        }
    }
    channels.sort_by(|one, other| one.name.cmp(&other.name));
    let twice = channels
        .windows(2)
        .find(|pair| pair[0].name == pair[1].name);
    match twice {
        Some(pair) => Err(format!("two channels are called {}", pair[0].name)),
        None => Ok(channels),
    }
}

#[cfg(test)]
mod tests {
    use exr::prelude::{
        AnyChannel, AnyChannels, Blocks, Compression, Encoding, Image, Layer, LayerAttributes,
        LineOrder, SmallVec, Text, Vec2, WritableImage as _, f16,
    };

    use super::*;

    fn part(name: &str, samples: FlatSamples) -> Layer<AnyChannels<FlatSamples>> {
        let encoding = Encoding {
            compression: Compression::ZIP1,
            blocks: Blocks::Tiles(Vec2(2, 2)),
            line_order: LineOrder::Increasing,
        };
        let channel = AnyChannel::new(Text::from("Z"), samples);
        Layer::new(
            (3, 1),
            LayerAttributes::named(name).with_position(Vec2(-4, 5)),
            encoding,
            AnyChannels::sort(SmallVec::from_vec(vec![channel])),
        )
    }

    fn written(parts: Vec<Layer<AnyChannels<FlatSamples>>>) -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        let attributes = exr::prelude::ImageAttributes::with_size((3, 1));
        Image::from_layers(attributes, SmallVec::from_vec(parts))
            .write()
            .non_parallel()
            .to_buffered(&mut file)
            .expect("a file");
        file.into_inner()
    }

    #[test]
    fn parts_name_their_channels_and_halves_become_wide() {
        let halves = [0.5, -0.0, 65504.0].map(f16::from_f32).to_vec();
        let one = part("near", FlatSamples::F16(halves));
        let other = part("far", FlatSamples::U32(vec![1, 2, u32::MAX]));
        let file = written(vec![one.clone(), other]);
        let ImageFile::Exr(channels) = ImageFile::decode(&file).unwrap() else {
            panic!("an EXR file");
        };
        let names: Vec<_> = channels
            .iter()
            .map(|channel| channel.name.as_str())
            .collect();
        assert_eq!(names, ["far.Z", "near.Z"]);
        assert_eq!(channels[0].samples, LayerSamples::U32(vec![1, 2, u32::MAX]));
        assert_eq!(channels[1].kind, SampleKind::F16);
        assert_eq!(
            channels[1].samples,
            LayerSamples::F32(vec![0.5, -0.0, 65504.0])
        );
        assert_eq!((channels[1].origin, channels[1].size), ([-4, 5], [3, 1]));
        // A part that is alone does not name them.
        let ImageFile::Exr(channels) = ImageFile::decode(&written(vec![one])).unwrap() else {
            panic!("an EXR file");
        };
        assert_eq!(channels[0].name, "Z");
    }

    #[test]
    fn unsound_exr_files_are_refused() {
        let file = written(vec![part("Z", FlatSamples::F32(vec![0.0; 3]))]);
        for length in [5, 20, 100, file.len() / 2, file.len() - 1] {
            assert!(ImageFile::decode(&file[..length]).is_err(), "{length}");
        }
        // The window of the data, in the header: its right end goes far out.
        let key = b"dataWindow\0box2i\0";
        let at = file.windows(key.len()).position(|bytes| bytes == key);
        let right = at.expect("every file has it") + key.len() + 4 + 8;
        let mut wide = file;
        wide[right..right + 4].copy_from_slice(&2_000_000_000_i32.to_le_bytes());
        let error = ImageFile::decode(&wide).unwrap_err();
        assert!(
            error.contains("exceed the limit") || error.contains("no sound"),
            "{error}"
        );
        assert_eq!(
            ImageFile::decode(b"P6").unwrap_err(),
            "neither a PNG nor an EXR file"
        );
    }
}
