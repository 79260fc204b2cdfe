//! Two image files, by everything that can be said of them.

use super::colour::srgb_byte;
use super::{ChannelDifferences, Difference, Flip, SizeMismatch, flip, ssim};
use crate::report::channels::deep_channels;
use crate::report::{Channel, ImageFile, LayerSamples, Picture, SampleKind};

/// What a comparison of two image files found.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageDifference {
    /// Channel by channel, unless both are compared as pictures.
    pub channels: Option<ChannelDifferences>,
    /// How they look, where there is a colour to look at.
    pub look: Option<LookDifference>,
}

/// What a comparison of two pictures found.
#[derive(Debug, Clone, PartialEq)]
pub struct LookDifference {
    /// The pictures compared: expected, actual.
    pub pictures: [Picture; 2],
    /// What was found, if they are of one size.
    pub found: Result<Metrics, SizeMismatch>,
}

/// All measures of two pictures of one size.
#[derive(Debug, Clone, PartialEq)]
pub struct Metrics {
    /// Pixel by pixel.
    pub difference: Difference,
    /// Structural similarity; none for pictures that are smaller than its window.
    pub ssim: Option<f64>,
    /// The difference that is seen.
    pub flip: Flip,
}

impl LookDifference {
    /// Compares two pictures.
    #[must_use]
    pub fn between(pictures: [Picture; 2], tolerance: u8) -> Self {
        let [expected, actual] = &pictures;
        let measure = || {
            Ok(Metrics {
                difference: Difference::between(expected, actual, tolerance)?,
                ssim: ssim(expected, actual)?,
                flip: flip(expected, actual)?,
            })
        };
        Self {
            found: measure(),
            pictures,
        }
    }

    /// Whether they are of one size, and no pixel differs by more than the tolerance.
    #[must_use]
    pub fn is_within(&self) -> bool {
        let found = self.found.as_ref();
        found.is_ok_and(|metrics| metrics.difference.is_within())
    }
}

impl ImageDifference {
    /// Compares two image files.
    ///
    /// | files | what decides | what is looked at |
    /// |---|---|---|
    /// | PNG of 8 bits, both | the pictures, with the tolerance | the same |
    /// | PNG, at least one of 16 bits | R, G, B, A at 16 bits, with 257 times the tolerance | bytes: `v / 257`, rounded |
    /// | EXR, both | all channels, exactly | R, G, B, or else Y |
    /// | PNG and EXR | the pictures, with the tolerance | the same |
    ///
    /// Colour of an EXR file is taken as linear with the primaries of sRGB, cut to [0, 1] and encoded
    /// to bytes; alpha is not looked at, since such colours are weighted by it: what is clear is
    /// seen before black.
    ///
    /// `None` where a PNG stands against an EXR without colour.
    #[must_use]
    pub fn between(expected: &ImageFile, actual: &ImageFile, tolerance: u8) -> Option<Self> {
        let channels = match (expected, actual) {
            (ImageFile::Exr(one), ImageFile::Exr(other)) => {
                Some(ChannelDifferences::between(one, other, 0.0))
            }
            (ImageFile::Exr(_), _) | (_, ImageFile::Exr(_)) => None,
            (ImageFile::Picture(_), ImageFile::Picture(_)) => None,
            _ => {
                let tolerance = 257.0 * f64::from(tolerance);
                let [one, other] = [expected, actual].map(deep);
                Some(ChannelDifferences::between(&one, &other, tolerance))
            }
        };
        let pictures = || Some([picture(expected)?, picture(actual)?]);
        let look = pictures().map(|pictures| LookDifference::between(pictures, tolerance));
        (channels.is_some() || look.is_some()).then_some(Self { channels, look })
    }

    /// Whether they are the same up to the tolerance.
    #[must_use]
    pub fn is_within(&self) -> bool {
        match (&self.channels, &self.look) {
            (Some(channels), _) => channels.is_within(),
            (None, Some(look)) => look.is_within(),
            (None, None) => false,
        }
    }
}

/// An image of PNG at 16 bits.
fn deep(image: &ImageFile) -> Vec<Channel> {
    match image {
        ImageFile::Picture(picture) => {
            let wide = picture.rgba().iter().map(|&byte| 257 * u16::from(byte));
            let size = [picture.width(), picture.height()];
            deep_channels(size, &wide.collect::<Vec<u16>>())
        }
        ImageFile::Deep(channels) | ImageFile::Exr(channels) => channels.clone(),
    }
}

/// An image as it is looked at.
fn picture(image: &ImageFile) -> Option<Picture> {
    match image {
        ImageFile::Picture(picture) => Some(picture.clone()),
        ImageFile::Deep(channels) => {
            let [red, green, blue, alpha] = ["R", "G", "B", "A"].map(|name| named(channels, name));
            gathered([red?, green?, blue?, alpha?])
        }
        ImageFile::Exr(channels) => {
            let [red, green, blue, grey] = ["R", "G", "B", "Y"].map(|name| named(channels, name));
            match (red, green, blue, grey) {
                (Some(red), Some(green), Some(blue), _) => gathered([red, green, blue]),
                (None, None, None, Some(grey)) => gathered([grey, grey, grey]),
                _ => None,
            }
        }
    }
}

fn named<'a>(channels: &'a [Channel], name: &str) -> Option<&'a Channel> {
    channels.iter().find(|channel| channel.name == name)
}

/// Channels of one size as a picture, opaque without the fourth.
fn gathered<const COUNT: usize>(channels: [&Channel; COUNT]) -> Option<Picture> {
    let [width, height] = channels.first()?.size;
    if channels
        .iter()
        .any(|channel| channel.size != [width, height])
    {
        return None;
    }
    let mut rgba = vec![255; 4 * width as usize * height as usize];
    for (place, channel) in channels.iter().enumerate() {
        let bytes = rgba.iter_mut().skip(place).step_by(4);
        match &channel.samples {
            LayerSamples::F32(samples) => {
                for (byte, sample) in bytes.zip(samples) {
                    *byte = srgb_byte(f64::from(*sample));
                }
            }
            LayerSamples::U32(samples) if channel.kind == SampleKind::U16 => {
                for (byte, sample) in bytes.zip(samples) {
                    *byte = u8::try_from((sample + 128) / 257).unwrap_or(u8::MAX);
                }
            }
            // Numbers, no colours.
            LayerSamples::U32(_) => return None,
        }
    }
    Picture::new(width, height, rgba).ok()
}
