//! Ways to draw the lines of a forest of patches, held against every fragment in its place: Figures 10 to 13 of
//! [ZBMJLDC17](crate::references).
//!
//! ```text
//! scene with patches ─┬─ sorted by fragment ───────▶ truth ─┐
//!                     └─ each way, same primitives ─▶ look ─┴─▶ differences of intensity
//! ```
//!
//! What the paper's improvements put in order are levels and patches. The lines of a patch are drawn in the order of
//! its model: where they write depth, what lies behind one of them and comes later is lost, however patches are
//! sorted, and that is most of what is wrong.

use super::RunError;
use super::options::SessionOptions;
use super::progress::Progress;
use super::session::Session;
use super::world::World;
use crate::gpu::{Command, Ledger};
use crate::raster::Image;
use crate::scene::{GroveBlend, GroveChoice, GroveOrder, GrovePacking, SampleCount, Scene};

/// A way to draw a forest of patches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransparencyWay {
    /// A name for tables.
    pub name: &'static str,
    /// How it is drawn.
    pub choice: GroveChoice,
    /// Samples a pixel, of the truth that it is held against too.
    pub samples: SampleCount,
}

/// How a way looks, and what it takes.
#[derive(Debug, Clone, PartialEq)]
pub struct TransparencyLook {
    /// Which.
    pub way: TransparencyWay,
    /// The frame.
    pub image: Image,
    /// What the frame took.
    pub frame: Ledger,
    /// How many passes it was drawn in.
    pub passes: usize,
    /// By how much the intensity of each pixel differs from the truth, rows from the top.
    pub differences: Vec<u8>,
}

impl TransparencyLook {
    /// How many pixels differ by more than so much, of 255.
    #[must_use]
    pub fn errors(&self, above: u8) -> u64 {
        let differ = self.differences.iter().filter(|&&by| by > above);
        differ.count() as u64
    }

    /// Whether it is instancing without the improvements.
    #[must_use]
    pub fn is_naive(&self) -> bool {
        let choice = self.way.choice;
        let naive = GroveChoice {
            levels: choice.levels,
            ..GroveChoice::NAIVE
        };
        choice == naive
    }

    /// Whether it is what others are held against.
    #[must_use]
    pub fn is_truth(&self) -> bool {
        self.way.choice.blend == GroveBlend::Sorted
    }
}

/// The ways that are looked at for a forest: the truth; instancing as it was, then with one improvement after the
/// other; all three but one; with lines that leave depth as it is; and ways that need no order, those that live
/// on samples with four of them.
#[must_use]
pub fn transparency_ways(scene: GroveChoice) -> Vec<TransparencyWay> {
    let levels = scene.levels;
    let way = |name, choice| TransparencyWay {
        name,
        choice: GroveChoice { levels, ..choice },
        samples: SampleCount::One,
    };
    let (naive, paper) = (GroveChoice::NAIVE, GroveChoice::PAPER);
    let packed = GroveChoice {
        packing: GrovePacking::Patches,
        ..naive
    };
    let one_level = GroveChoice {
        levels_a_pass: 1,
        ..packed
    };
    let keeps_depth = |choice| GroveChoice {
        blend: GroveBlend::KeepsDepth,
        ..choice
    };
    let ordered = [
        way("truth", GroveChoice::TRUTH),
        way("naive", naive),
        way("packed", packed),
        way("packed, one level", one_level),
        way("packed, one level, sorted", paper),
        way(
            "the same, device sorts",
            GroveChoice {
                order: GroveOrder::Device,
                ..paper
            },
        ),
        way(
            "all but packing",
            GroveChoice {
                packing: GrovePacking::Samples,
                ..paper
            },
        ),
        way(
            "all but one level",
            GroveChoice {
                levels_a_pass: naive.levels_a_pass,
                ..paper
            },
        ),
        way("naive, keeps depth", keeps_depth(naive)),
        way("packed, keeps depth", keeps_depth(packed)),
        way("packed, one level, keeps depth", keeps_depth(one_level)),
        way("all three, keeps depth", keeps_depth(paper)),
    ];
    let unordered = |name, blend| {
        way(
            name,
            GroveChoice {
                blend,
                ..GroveChoice::TRUTH
            },
        )
    };
    let peeled = |name, layers| {
        let peeled = unordered(name, GroveBlend::Peeled);
        TransparencyWay {
            choice: GroveChoice {
                layers,
                ..peeled.choice
            },
            ..peeled
        }
    };
    let of_four = |way: TransparencyWay| TransparencyWay {
        samples: SampleCount::Four,
        ..way
    };
    let rivals = [
        unordered("hashed", GroveBlend::Hashed),
        unordered("weighted", GroveBlend::Weighted),
        unordered("moments", GroveBlend::Moments),
        peeled("peeled, 4 layers", 4),
        peeled("peeled, 16 layers", 16),
        of_four(way("truth, four samples", GroveChoice::TRUTH)),
        of_four(way("naive, four samples", naive)),
        of_four(unordered("coverage, four samples", GroveBlend::Coverage)),
        of_four(unordered("hashed, four samples", GroveBlend::Hashed)),
    ];
    ordered.into_iter().chain(rivals).collect()
}

/// Draws the first frame of a scene with patches in each way; nothing where no forest stands in patches.
///
/// # Errors
///
/// What the device refuses.
pub fn transparency_looks(
    scene: &Scene,
    world: &World,
    options: &SessionOptions,
    progress: &dyn Progress,
) -> Result<Vec<TransparencyLook>, RunError> {
    let Some(grove) = scene.grove else {
        return Ok(Vec::new());
    };
    let ways = transparency_ways(grove);
    progress.begin("transparency", ways.len() as u64);
    let mut looks: Vec<TransparencyLook> = Vec::with_capacity(ways.len());
    for way in ways {
        let scene = Scene {
            grove: Some(way.choice),
            ..scene.clone()
        };
        let options = SessionOptions {
            samples: way.samples,
            ..*options
        };
        let mut session = Session::new(&scene, world, &options)?;
        let frame = session.frame(0)?;
        let drawn = session.commands().into_iter();
        let passes = drawn.filter(|command| matches!(command, Command::Render(_)));
        let truth = looks
            .iter()
            .find(|look| look.is_truth() && look.way.samples == way.samples);
        let truth = truth.map_or(&frame.image, |look| &look.image);
        looks.push(TransparencyLook {
            way,
            differences: differences(truth, &frame.image),
            passes: passes.count(),
            image: frame.image,
            frame: frame.ledger,
        });
        progress.step();
    }
    Ok(looks)
}

/// By how much the intensities of two pictures of one size differ, pixel by pixel.
fn differences(one: &Image, other: &Image) -> Vec<u8> {
    let intensities = |image: &Image| {
        let pixels = image.rgba.as_chunks::<4>().0.iter().copied();
        pixels.map(intensity).collect::<Vec<u8>>()
    };
    let pairs = intensities(one).into_iter().zip(intensities(other));
    pairs.map(|(one, other)| one.abs_diff(other)).collect()
}

/// The weighted mean of the channels that ITU-R BT.601 calls luma, rounded to the nearest; of 255.
fn intensity([r, g, b, _]: [u8; 4]) -> u8 {
    let sum = 299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b);
    u8::try_from((sum + 500) / 1000).unwrap_or(u8::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intensities_are_weighted_means() {
        assert_eq!(intensity([255; 4]), 255);
        assert_eq!(intensity([0, 0, 0, 255]), 0);
        let pure = [[255, 0, 0, 0], [0, 255, 0, 0], [0, 0, 255, 0]].map(intensity);
        assert_eq!(pure, [76, 150, 29]);
    }

    #[test]
    fn errors_are_counted_above_a_bound() {
        let image = |greys: [u8; 3]| Image {
            width: 3,
            height: 1,
            rgba: greys
                .into_iter()
                .flat_map(|grey| [grey, grey, grey, 255])
                .collect(),
        };
        let look = TransparencyLook {
            way: transparency_ways(GroveChoice::PAPER)[1],
            differences: differences(&image([10, 20, 30]), &image([10, 12, 39])),
            image: image([10, 12, 39]),
            frame: Ledger::default(),
            passes: 1,
        };
        assert_eq!(look.differences, [0, 8, 9]);
        assert_eq!([look.errors(0), look.errors(8)], [2, 1]);
        assert!(!look.is_truth());
    }
}
