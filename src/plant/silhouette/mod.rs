//! What leaves look like: small images with alpha, drawn from outlines.
//!
//! ```text
//!  outline, colour ─▶ Brush ─paths─▶ tiny-skia ─▶ straight alpha ─bleed─▶ Texture
//! ```
//!
//! A leaf's base lies at the middle of the image's lower edge and its tip at the upper edge; the
//! image is stretched over the leaf's quad, whose width and height the outlines know, so that they
//! keep their proportions. Texels that are not there carry the colour of the nearest that are:
//! filtering never darkens an edge.

mod brush;
mod outline;

use brush::Brush;

use super::Texture;
use crate::math::index_u32;

/// What a leaf's image shows.
///
/// One image may show a single blade or a whole spray: the papers count a spray on one quad as one
/// leaf.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Silhouette {
    /// A birch's: egg-shaped, pointed, with teeth.
    OvateSerrate,
    /// Three such leaves on a twig.
    BirchSprig,
    /// Entire, widest in the middle.
    Elliptic,
    /// Entire, widest above the middle, as a tupelo's.
    Obovate,
    /// Small egg-shaped leaves with few spines, alternating on a twig: a cork oak's.
    CorkOakSprig,
    /// An oak's leaf with round lobes.
    Lobed,
    /// Three lobed leaves on a twig.
    OakSprig,
    /// A rowan's: toothed leaflets in pairs, one at the end.
    Pinnate,
    /// A mastic's: few entire leaflets in pairs, none at the end.
    PinnateEntire,
    /// Narrow and pointed, as a willow's.
    Lanceolate,
    /// Long and pointed with coarse teeth, as a chestnut's.
    LanceolateSerrate,
    /// Narrow leaves in pairs on a twig: an olive's.
    OliveSprig,
    /// Nearly round with a short tip: an aspen's.
    Round,
    /// A yew's: side twigs with needles in two ranks.
    YewSpray,
    /// A juniper's: stiff needles on all sides of a twig.
    JuniperTuft,
    /// A cypress's: forked twigs clad in scales.
    CypressSpray,
    /// A broom's: slender green rods, hardly a leaf.
    Rush,
    /// A broom's rod in flower; the colour is the petals'.
    RushBlossom,
}

impl Silhouette {
    /// All of them.
    pub const ALL: [Self; 18] = [
        Self::OvateSerrate,
        Self::BirchSprig,
        Self::Elliptic,
        Self::Obovate,
        Self::CorkOakSprig,
        Self::Lobed,
        Self::OakSprig,
        Self::Pinnate,
        Self::PinnateEntire,
        Self::Lanceolate,
        Self::LanceolateSerrate,
        Self::OliveSprig,
        Self::Round,
        Self::YewSpray,
        Self::JuniperTuft,
        Self::CypressSpray,
        Self::Rush,
        Self::RushBlossom,
    ];

    /// The name in species files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::OvateSerrate => "ovate_serrate",
            Self::BirchSprig => "birch_sprig",
            Self::Elliptic => "elliptic",
            Self::Obovate => "obovate",
            Self::CorkOakSprig => "cork_oak_sprig",
            Self::Lobed => "lobed",
            Self::OakSprig => "oak_sprig",
            Self::Pinnate => "pinnate",
            Self::PinnateEntire => "pinnate_entire",
            Self::Lanceolate => "lanceolate",
            Self::LanceolateSerrate => "lanceolate_serrate",
            Self::OliveSprig => "olive_sprig",
            Self::Round => "round",
            Self::YewSpray => "yew_spray",
            Self::JuniperTuft => "juniper_tuft",
            Self::CypressSpray => "cypress_spray",
            Self::Rush => "rush",
            Self::RushBlossom => "rush_blossom",
        }
    }

    /// Texels a side: enough that single needles and teeth are seen at level 0.
    fn side(self) -> u32 {
        match self {
            Self::OvateSerrate
            | Self::Elliptic
            | Self::Obovate
            | Self::Lobed
            | Self::Lanceolate
            | Self::LanceolateSerrate
            | Self::Round => 64,
            Self::BirchSprig
            | Self::CorkOakSprig
            | Self::OakSprig
            | Self::Pinnate
            | Self::PinnateEntire
            | Self::OliveSprig
            | Self::YewSpray
            | Self::JuniperTuft
            | Self::CypressSpray
            | Self::Rush
            | Self::RushBlossom => 128,
        }
    }

    /// The image in a colour (sRGB), for a leaf whose width is `width` times its length, above 0.
    #[must_use]
    #[expect(clippy::missing_panics_doc, reason = "the sizes of our own images fit")]
    pub fn draw(self, color: [u8; 3], width: f32) -> Texture {
        let side = self.side();
        let mut brush = Brush::new(side, width, color);
        outline::paint(self, &mut brush);
        let rgba = bled(brush.straight(), side as usize);
        Texture::new(side, side, rgba).expect("the bytes are those of a square of this side")
    }
}

/// Carries colour outwards into texels that are hardly there, ring by ring; alpha stays.
fn bled(mut rgba: Vec<u8>, side: usize) -> Vec<u8> {
    // At low alpha, premultiplied bytes have lost their colour to rounding.
    let mut known: Vec<bool> = rgba.chunks_exact(4).map(|texel| texel[3] >= 96).collect();
    while known.contains(&false) && known.contains(&true) {
        let before = known.clone();
        for at in 0..side * side {
            if before[at] {
                continue;
            }
            let around: Vec<usize> = neighbours(at, side)
                .filter(|&texel| before[texel])
                .collect();
            let count = index_u32(around.len());
            for channel in 4 * at..4 * at + 3 {
                let sum = around.iter().fold(count / 2, |sum, neighbour| {
                    sum + u32::from(rgba[4 * neighbour + channel % 4])
                });
                if let Some(mean) = sum.checked_div(count) {
                    rgba[channel] = u8::try_from(mean).expect("a mean of bytes is a byte");
                    known[at] = true;
                }
            }
        }
    }
    rgba
}

/// The up to eight texels around one.
fn neighbours(at: usize, side: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (at % side, at / side);
    let rows = y.saturating_sub(1)..=(y + 1).min(side - 1);
    rows.flat_map(move |row| {
        let columns = x.saturating_sub(1)..=(x + 1).min(side - 1);
        columns.map(move |column| row * side + column)
    })
    .filter(move |&neighbour| neighbour != at)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coverage(rgba: &[u8]) -> f32 {
        let passing = rgba.chunks_exact(4).filter(|texel| texel[3] >= 128).count();
        passing as f32 / (rgba.len() / 4) as f32
    }

    #[test]
    fn names_read_back() {
        #[derive(serde::Deserialize)]
        struct Line {
            silhouette: Silhouette,
        }
        for silhouette in Silhouette::ALL {
            let line: Line =
                toml::from_str(&format!("silhouette = {:?}", silhouette.name())).unwrap();
            assert_eq!(line.silhouette, silhouette);
        }
    }

    #[test]
    fn every_image_shows_something_and_its_mips_keep_showing_it() {
        for silhouette in Silhouette::ALL {
            let texture = silhouette.draw([80, 120, 50], 0.7);
            let levels = texture.mips(0.5);
            let whole = coverage(&levels[0]);
            let name = silhouette.name();
            assert!((0.1..0.9).contains(&whole), "{name} covers {whole}");
            for level in &levels[1..levels.len() - 2] {
                let (found, step) = (coverage(level), 4.0 / level.len() as f32);
                assert!(
                    (found - whole).abs() < 0.01 + step,
                    "{name}: {found} of {whole}"
                );
            }
        }
    }

    #[test]
    fn what_is_not_there_has_the_colour_of_what_is() {
        // A yellow leaf: without bleeding, empty texels would be black.
        let texture = Silhouette::Elliptic.draw([250, 240, 20], 0.5);
        let corner = &texture.rgba()[..4];
        assert!(
            corner[3] == 0 && corner[0] > 150 && corner[1] > 150,
            "{corner:?}"
        );
    }
}
