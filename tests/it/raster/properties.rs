//! Properties of any triangles, sane or not.

use proptest::prelude::*;

use super::{Coordinates, Drawing, EXACT, Plain, QUICK, batch, render};
use spinney::math::Vec4;
use spinney::raster::{Samples, Target, Topology};

/// Floats of all kinds, with a taste for the limits.
fn any_float() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -4.0_f32..4.0,
        2 => any::<f32>(),
        1 => prop::sample::select(vec![
            0.0,
            -0.0,
            1.0,
            -1.0,
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            f32::MIN,
            f32::MIN_POSITIVE,
            1e-45,
            -1e-45,
            32768.0,
            1e20,
        ]),
    ]
}

fn any_vertex() -> impl Strategy<Value = (Vec4, [f32; 2])> {
    (
        [any_float(), any_float(), any_float(), any_float()],
        [any_float(), any_float()],
    )
        .prop_map(|(clip, uv)| (Vec4::from_array(clip), uv))
}

/// A place in sub-pixels, sometimes the centre of a pixel.
fn any_place() -> impl Strategy<Value = [i16; 2]> {
    let step = prop_oneof![
        -512_i16..4608,
        (-2_i16..18).prop_map(|pixel| 256 * pixel + 128)
    ];
    [step.clone(), step]
}

/// A place in pixels.
fn pixels(place: [i16; 2]) -> [f32; 2] {
    place.map(|subpixels| f32::from(subpixels) / 256.0)
}

crate::support::properties! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn no_vertex_makes_it_panic(
        vertices in prop::collection::vec(any_vertex(), 0..24),
        corners in prop::collection::vec(0_u32..26, 0..40),
        width in 0_u32..80,
        height in 0_u32..80,
    ) {
        let mut drawing = Drawing::new(width, height);
        for (clip, uv) in vertices {
            drawing.clip_vertex(clip, &uv);
        }
        drawing.geometry.corners = corners;
        for samples in [Samples::One, Samples::Four] {
            let topologies = [Topology::TriangleList, Topology::QuadList, Topology::LineList];
            for topology in topologies {
                let mut target = Target::new(width, height, samples);
                let batches = [batch(&drawing.geometry, topology, &Coordinates)];
                let exact = render(&mut target, &batches, &EXACT);
                prop_assert!(exact.visible <= exact.covered);
                for y in 0..height {
                    for x in 0..width {
                        prop_assert!((0.0..=1.0).contains(&target.depth(x, y)));
                    }
                }
                let mut quick = Target::new(width, height, samples);
                let work = render(&mut quick, &batches, &QUICK);
                prop_assert_eq!(work.visible, exact.visible);
                prop_assert_eq!(quick.resolve(), target.resolve());
            }
        }
    }

    #[test]
    fn coverage_is_the_top_left_rule(
        corners in [any_place(), any_place(), any_place()],
        samples in prop::sample::select(vec![Samples::One, Samples::Four]),
    ) {
        let mut drawing = Drawing::new(16, 16);
        drawing.shape(&corners.map(pixels), 0.5, [1.0; 4]);
        let (_, work) = drawing.render_with(Topology::TriangleList, &Plain, samples, EXACT);
        let mut expected = 0;
        for y in 0..16_i32 {
            for x in 0..16_i32 {
                for &[dx, dy] in samples.offsets() {
                    expected += u64::from(covers(corners, [x * 256 + dx, y * 256 + dy]));
                }
            }
        }
        prop_assert_eq!(work.covered, expected);
    }

    #[test]
    fn a_quad_cut_along_either_diagonal_covers_the_same(
        a in any_place(), b in any_place(), c in any_place(), d in any_place(),
    ) {
        prop_assume!(is_convex([a, b, c, d]));
        let covered = |triangles: [[[i16; 2]; 3]; 2]| {
            let mut drawing = Drawing::new(16, 16);
            for triangle in &triangles {
                drawing.shape(&triangle.map(pixels), 0.5, [1.0; 4]);
            }
            let (_, work) = drawing.render(Topology::TriangleList, &Plain);
            (work.covered, work.visible)
        };
        let one = covered([[a, b, c], [a, c, d]]);
        prop_assert_eq!(one, covered([[b, c, d], [b, d, a]]));
        prop_assert_eq!(one.0, one.1, "no sample twice");
    }
}

crate::support::properties! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Small triangles are decided in lanes, large ones pixel by pixel: a triangle in the middle of a
    /// target covers what it covers when one of its corners is moved out along an edge.
    #[test]
    fn large_triangles_cover_as_small_ones_do(
        a in any_place(), b in any_place(), c in any_place(), reach in 20_i32..40,
    ) {
        let count = |corners: [[i32; 2]; 3]| {
            let mut drawing = Drawing::new(16, 16);
            drawing.shape(&corners.map(|p| p.map(|p| p as f32 / 256.0)), 0.5, [1.0; 4]);
            let (_, work) = drawing.render(Topology::TriangleList, &Plain);
            work.covered
        };
        let [a, b, c] = [a, b, c].map(|place| place.map(i32::from));
        let far = [0, 1].map(|k| a[k] + (b[k] - a[k]) * reach);
        // The large triangle a, far, c is the small one and the rest of it, cut from c to b.
        prop_assert_eq!(count([a, far, c]), count([a, b, c]) + count([b, far, c]));
    }
}

/// The reference: crossing numbers of a ray to the right of a point, moved up and left by less than
/// anything, which is what the top-left rule amounts to.
fn covers(corners: [[i16; 2]; 3], point: [i32; 2]) -> bool {
    let corner = corners.map(|place| place.map(i64::from));
    let [px, py] = point.map(i64::from);
    let mut inside = false;
    for k in 0..3 {
        let ([ax, ay], [bx, by]) = (corner[k], corner[(k + 1) % 3]);
        // Rows: a point level with a corner counts as just below it.
        if (ay <= py) != (by <= py) {
            let ([ax, ay], [bx, by]) = if ay <= by {
                ([ax, ay], [bx, by])
            } else {
                ([bx, by], [ax, ay])
            };
            // The edge is to the right of the point, a point on it counts as right of the edge.
            inside ^= (bx - ax) * (py - ay) > (px - ax) * (by - ay);
        }
    }
    inside
}

fn is_convex(corners: [[i16; 2]; 4]) -> bool {
    let corners = corners.map(|place| place.map(i64::from));
    let turns = [0, 1, 2, 3].map(|k| {
        let [a, b, c] = [corners[k], corners[(k + 1) % 4], corners[(k + 2) % 4]];
        (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
    });
    turns.iter().all(|&turn| turn > 0) || turns.iter().all(|&turn| turn < 0)
}
