//! Fragments that move depth, and alpha that is coverage.

use super::determinism::{MACHINES, SAMPLES, SIZE, TILES, draw, draw_on, leaves, options};
use super::{Coordinates, Drawing, EXACT, QUICK, Quarter, contents};
use spinney::math::Vec4;
use spinney::raster::{
    Batch, Counters, Fragment, Key, Pixel, Samples, TileSize, Topology, Work, probe,
};

/// A leaf that is bent over its quad, by no number here and there; shows how deep it lies.
#[derive(Debug)]
struct Relief<const COVERAGE: bool> {
    bound: f32,
    height: f32,
}

impl<const COVERAGE: bool> Fragment for Relief<COVERAGE> {
    const VARYINGS: usize = 2;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = true;
    const COVERAGE: bool = COVERAGE;
    const MOVES_DEPTH: bool = true;

    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        Quarter.keeps(pixel)
    }

    fn alpha(&self, pixel: &Pixel<'_>) -> f32 {
        1.5 * (1.0 - pixel.varyings[0])
    }

    fn depth_offset(&self, pixel: &Pixel<'_>) -> f32 {
        let [x, y] = pixel.position;
        match (x + 3 * y) % 11 {
            0 => f32::NAN,
            1 => f32::NEG_INFINITY,
            _ => self.height * (pixel.varyings[0] - 0.3) * (pixel.varyings[1] + 0.1),
        }
    }

    fn nearer_by(&self) -> f32 {
        self.bound
    }

    fn texels_tested(&self) -> u64 {
        2
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        Vec4::new(pixel.depth, pixel.varyings[0], 0.25, 1.0)
    }
}

const RELIEF: Relief<false> = Relief {
    bound: 0.05,
    height: 0.3,
};
const COVERED: Relief<true> = Relief {
    bound: 0.02,
    height: -0.2,
};
/// Of which nothing is known before it is asked.
const BOUNDLESS: Relief<false> = Relief {
    bound: f32::INFINITY,
    height: 0.1,
};

#[test]
fn no_way_of_drawing_can_be_seen() {
    let (bent, covered, solid) = (leaves(250, 31), leaves(250, 32), leaves(150, 33));
    let boundless = leaves(60, 34);
    let batches = [
        bent.batch(Topology::QuadList, &RELIEF),
        Batch {
            group: 1,
            ..covered.batch(Topology::QuadList, &COVERED)
        },
        Batch {
            group: 2,
            ..solid.batch(Topology::QuadList, &Coordinates)
        },
        Batch {
            group: 3,
            ..boundless.batch(Topology::QuadList, &BOUNDLESS)
        },
    ];
    let mut turned = batches;
    turned.reverse();
    for samples in SAMPLES {
        let mut seen: Vec<(Vec<u32>, u64)> = Vec::new();
        let mut exact: Vec<Work> = Vec::new();
        for tile in TILES {
            for counters in [Counters::Visible, Counters::Exact] {
                for (machine, batches) in MACHINES.into_iter().zip([&batches, &turned]) {
                    let options = options(tile, counters);
                    let (target, work) = draw_on(machine, batches, samples, options);
                    seen.push((contents(&target), work.visible));
                    if counters == Counters::Exact {
                        exact.push(work);
                    }
                }
            }
        }
        assert!(seen.windows(2).all(|pair| pair[0] == pair[1]));
        assert!(exact.windows(2).all(|pair| pair[0] == pair[1]), "{exact:?}");
        let Work {
            visible,
            covered,
            alpha_killed,
            ..
        } = exact[0];
        assert!(visible > 5_000 && alpha_killed > 5_000, "{:?}", exact[0]);
        assert!(visible + alpha_killed < covered, "{:?}", exact[0]);
    }
}

#[test]
fn what_is_probed_is_what_is_drawn() {
    let (bent, covered) = (leaves(120, 41), leaves(120, 42));
    let batches = [
        bent.batch(Topology::QuadList, &RELIEF),
        Batch {
            group: 1,
            ..covered.batch(Topology::QuadList, &COVERED)
        },
    ];
    let quick = options(TileSize::Side64, Counters::Visible);
    for samples in SAMPLES {
        let (target, _) = draw(&batches, samples, quick);
        let mut shown = 0;
        for (x, y) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))) {
            if (x + 5 * y) % 3 != 0 {
                continue;
            }
            let mut nearest: Option<(u32, Key)> = None;
            for fragment in probe(SIZE, samples, &batches, [x, y]) {
                if let (true, Some(depth)) = (fragment.kept, fragment.depths[0]) {
                    let this = (depth.to_bits(), fragment.key);
                    nearest = Some(nearest.map_or(this, |that| that.min(this)));
                }
            }
            // Nothing shows at the depth of the background.
            let nearest = nearest.filter(|(depth, _)| *depth < 1.0_f32.to_bits());
            assert_eq!(target.key(x, y), nearest.map(|(_, key)| key), "{x}, {y}");
            if let Some((depth, _)) = nearest {
                assert_eq!(target.depth(x, y).to_bits(), depth, "{x}, {y}");
                shown += 1;
            }
        }
        assert!(shown > 500, "{shown} pixels");
    }
}

/// Moves all of it by so much, at most so far to the eye; its alpha grows from left to right.
#[derive(Debug)]
struct Shift<const COVERAGE: bool> {
    by: f32,
    bound: f32,
}

impl<const COVERAGE: bool> Fragment for Shift<COVERAGE> {
    const VARYINGS: usize = 2;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = false;
    const COVERAGE: bool = COVERAGE;
    const MOVES_DEPTH: bool = true;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn alpha(&self, pixel: &Pixel<'_>) -> f32 {
        pixel.varyings[0]
    }

    fn depth_offset(&self, _: &Pixel<'_>) -> f32 {
        self.by
    }

    fn nearer_by(&self) -> f32 {
        self.bound
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        Vec4::new(pixel.depth, 0.0, 0.0, 1.0)
    }
}

#[test]
fn a_fragment_shows_where_it_has_moved_to() {
    let mut wall = Drawing::new(8, 8);
    wall.leaf([0.0, 0.0], [8.0, 8.0], 0.5);
    let mut card = Drawing::new(8, 8);
    card.leaf([0.0, 0.0], [4.0, 8.0], 0.75);
    let far = f32::INFINITY;
    for (by, bound, depth) in [
        (-0.5, far, 0.25),
        (-0.5, 0.375, 0.375),
        (-0.5, 0.25, 0.5),
        (-0.5, 0.125, 0.5),
        (0.125, far, 0.5),
        (-9.0, far, 0.0),
        (f32::NAN, far, 0.5),
        (-0.5, f32::NAN, 0.5),
    ] {
        let moved = Shift::<false> { by, bound };
        for samples in SAMPLES {
            for options in [QUICK, EXACT] {
                let batches = [
                    wall.batch(Topology::QuadList, &Coordinates),
                    Batch {
                        group: 1,
                        ..card.batch(Topology::QuadList, &moved)
                    },
                ];
                let mut target = spinney::raster::Target::new(8, 8, samples);
                let work = super::render(&mut target, &batches, &options);
                assert_eq!(target.depth(1, 1), depth, "{by} {bound}");
                let group = target.key(1, 1).map(|key| key.group);
                assert_eq!(group, Some(u32::from(depth < 0.5)), "{by} {bound}");
                if depth < 0.5 {
                    assert_eq!(target.colour(1, 1).x, depth, "{by} {bound}");
                }
                assert_eq!(target.depth(6, 1), 0.5);
                assert_eq!(work.visible, 64 * samples.count() as u64);
            }
        }
    }
}

#[test]
fn samples_drop_out_as_alpha_falls() {
    // Alpha 1/16, 3/16, 5/16 … 15/16 from left to right.
    let mut card = Drawing::new(8, 4);
    card.leaf([0.0, 0.0], [8.0, 4.0], 0.75);
    let covered = Shift::<true> {
        by: -0.25,
        bound: 1.0,
    };
    let four = card.render_with(Topology::QuadList, &covered, Samples::Four, EXACT);
    let shares: Vec<f32> = (0..8).map(|x| 4.0 * four.0.colour(x, 2).w).collect();
    assert_eq!(shares, [0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0]);
    assert_eq!(four.1.visible, 4 * 16);
    assert_eq!((four.1.covered, four.1.alpha_killed), (4 * 32, 4 * 16));
    assert_eq!(
        four.0.depth(1, 2),
        0.5,
        "the first sample is the first to come"
    );
    let one = card.render_with(Topology::QuadList, &covered, Samples::One, QUICK);
    let there: Vec<f32> = (0..8).map(|x| one.0.colour(x, 2).w).collect();
    assert_eq!(there, [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
}
