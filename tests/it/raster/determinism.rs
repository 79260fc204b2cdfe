//! One scene drawn in many ways, to the same bits.

use super::{Coordinates, Drawing, Plain, Quarter, batch, contents};
use spinney::math::{Stream, Vec4};
use spinney::raster::{
    Batch, Blend, Counters, Geometry, Image, Instructions, Machine, Options, Samples, Target,
    TileSize, Topology, Work, render_on,
};

pub(super) const SIZE: [u32; 2] = [150, 101];

/// Leaves in space, some before the near plane, some huge, some level with others.
pub(super) fn leaves(count: u32, seed: u64) -> Drawing {
    let mut draws = Stream::new(seed, 0).draws();
    let mut drawing = Drawing::new(SIZE[0], SIZE[1]);
    for leaf in 0..count {
        let size = if leaf % 37 == 0 { 2.0 } else { 0.1 };
        let w = 1.5 + 1.2 * draws.signed();
        let middle = Vec4::new(draws.signed() * w, draws.signed() * w, 0.6 * w, w);
        let flat = leaf % 3 == 0;
        let mut arm = || {
            let tilt = if flat { 0.0 } else { 0.9 * draws.signed() };
            Vec4::new(draws.signed(), draws.signed(), tilt, tilt) * size
        };
        let (right, up) = (arm(), arm());
        for (sign_x, sign_y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let uv = [0.5 + 0.5 * sign_x, 0.5 + 0.5 * sign_y];
            let id = drawing.clip_vertex(middle + right * sign_x + up * sign_y, &uv);
            drawing.geometry.corners.push(id);
        }
    }
    drawing
}

pub(super) fn draw(batches: &[Batch<'_>], samples: Samples, options: Options) -> (Target, Work) {
    draw_on(Machine::THIS, batches, samples, options)
}

pub(super) fn draw_on(
    machine: Machine,
    batches: &[Batch<'_>],
    samples: Samples,
    options: Options,
) -> (Target, Work) {
    let mut target = Target::new(SIZE[0], SIZE[1], samples);
    target.clear(Vec4::new(0.1, 0.2, 0.3, 1.0), 1.0);
    let rendered = render_on(machine, &mut target, batches, &options);
    (target, Work::total(&rendered.works))
}

pub(super) fn options(tile: TileSize, counters: Counters) -> Options {
    Options { tile, counters }
}

/// With the best instructions and room, with none of both.
pub(super) const MACHINES: [Machine; 2] = [
    Machine::THIS,
    Machine {
        geometry_bytes: 0,
        instructions: Instructions::Scalar,
    },
];
pub(super) const TILES: [TileSize; 2] = [TileSize::Side32, TileSize::Side64];
pub(super) const SAMPLES: [Samples; 2] = [Samples::One, Samples::Four];

#[test]
fn threads_tiles_and_counters_leave_no_trace() {
    for blend in [
        Blend::Alpha,
        Blend::AlphaAndDepth,
        Blend::Sorted,
        Blend::Add,
    ] {
        leave_no_trace(blend);
    }
}

fn leave_no_trace(blend: Blend) {
    let (tested, glass, solid) = (leaves(700, 1), leaves(150, 2), leaves(100, 3));
    let batches = [
        tested.batch(Topology::QuadList, &Quarter),
        Batch {
            blend,
            group: 1,
            ..glass.batch(Topology::QuadList, &Quarter)
        },
        Batch {
            group: 2,
            ..solid.batch(Topology::QuadList, &Coordinates)
        },
    ];
    for samples in SAMPLES {
        let mut seen: Vec<(Vec<u32>, u64)> = Vec::new();
        let mut exact: Vec<Work> = Vec::new();
        for threads in [1, 2, 7] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("threads can be had");
            for tile in TILES {
                for counters in [Counters::Visible, Counters::Exact] {
                    for machine in MACHINES {
                        let options = options(tile, counters);
                        let (target, work) =
                            pool.install(|| draw_on(machine, &batches, samples, options));
                        seen.push((contents(&target), work.visible));
                        if counters == Counters::Exact {
                            exact.push(work);
                        }
                    }
                }
            }
        }
        assert!(seen.windows(2).all(|pair| pair[0] == pair[1]), "{blend:?}");
        assert!(exact.windows(2).all(|pair| pair[0] == pair[1]), "{exact:?}");
        assert!(
            exact[0].alpha_killed > 0 && exact[0].visible > 10_000,
            "{blend:?}"
        );
    }
}

#[test]
fn opaque_batches_commute_and_may_be_split() {
    let drawing = leaves(400, 4);
    let corners = &drawing.geometry.corners;
    for samples in SAMPLES {
        let whole = draw(
            &[drawing.batch(Topology::QuadList, &Quarter)],
            samples,
            options(TileSize::Side64, Counters::Exact),
        );
        for piece in [1_usize, 7, 150] {
            let mut parts: Vec<Geometry> = corners
                .chunks(4 * piece)
                .map(|corners| Geometry {
                    corners: corners.to_vec(),
                    ..drawing.geometry.clone()
                })
                .collect();
            for turn in 0..2 {
                if turn == 1 {
                    parts.reverse();
                }
                let batches: Vec<Batch<'_>> = parts
                    .iter()
                    .map(|part| batch(part, Topology::QuadList, &Quarter))
                    .collect();
                let split = draw(
                    &batches,
                    samples,
                    options(TileSize::Side32, Counters::Exact),
                );
                assert_eq!(split.1, whole.1);
                assert_eq!(contents(&split.0), contents(&whole.0));
            }
        }
    }
}

#[test]
fn quads_lists_and_turned_lists_are_the_same() {
    let drawing = leaves(300, 5);
    let quick = options(TileSize::Side64, Counters::Visible);
    let list = |turn: usize| Geometry {
        corners: drawing
            .geometry
            .corners
            .chunks(4)
            .flat_map(|q| {
                let mut triangles = [[q[0], q[1], q[2]], [q[0], q[2], q[3]]];
                triangles.iter_mut().for_each(|t| t.rotate_left(turn));
                triangles.concat()
            })
            .collect(),
        ..drawing.geometry.clone()
    };
    for samples in SAMPLES {
        let quads = [drawing.batch(Topology::QuadList, &Quarter)];
        let quads = draw(&quads, samples, quick).0;
        for turn in 0..3 {
            let geometry = list(turn);
            let triangles = [batch(&geometry, Topology::TriangleList, &Quarter)];
            let triangles = draw(&triangles, samples, quick).0;
            // Keys name corners as submitted; nothing else may differ.
            assert_eq!(triangles.linear(), quads.linear(), "turned by {turn}");
            assert_eq!(triangles.resolve(), quads.resolve());
        }
    }
}

/// To renew the digest: it may change only when the rule book of `raster` does, in the same commit.
#[test]
fn one_picture_is_pinned() {
    let (tested, glass) = (leaves(500, 6), leaves(60, 7));
    let mut frame = Drawing::new(SIZE[0], SIZE[1]);
    frame.shape(&[[2.0, 2.0], [148.0, 99.0]], 0.0, [1.0, 0.5, 0.0, 1.0]);
    let batches = [
        tested.batch(Topology::QuadList, &Quarter),
        Batch {
            blend: Blend::Alpha,
            ..glass.batch(Topology::QuadList, &Quarter)
        },
        frame.batch(Topology::LineList, &Plain),
    ];
    let picture = |samples| -> Image {
        let quick = options(TileSize::Side64, Counters::Visible);
        draw(&batches, samples, quick).0.resolve()
    };
    let digests = SAMPLES.map(|samples| picture(samples).digest().to_string());
    assert_eq!(
        digests,
        [
            "0d66db9983eeb4444007d9d691084947257116f5abb9c0d4839629443db7d615",
            "6a2f3cd8081a1b24ba157219144b938b9a015bbcdade939467d9b877b3baa0aa",
        ]
    );
}
