//! Ties, order, clipping, attributes and counters.

use super::{Coordinates, Drawing, EXACT, Plain, QUICK, Quarter, batch, letters, render};
use spinney::math::{DVec3, Vec4};
use spinney::raster::{Batch, Blend, Key, Samples, Target, Topology, Work};

const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
const WHOLE: [[f32; 2]; 4] = [[0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 0.0]];

#[test]
fn the_nearer_wins_in_any_order() {
    for order in [[0.25, 0.5], [0.5, 0.25]] {
        let mut drawing = Drawing::new(4, 4);
        drawing.shape(&WHOLE, order[0], [order[0], 0.0, 0.0, 1.0]);
        drawing.shape(&WHOLE, order[1], [order[1], 0.0, 0.0, 1.0]);
        let (target, work) = drawing.render(Topology::QuadList, &Plain);
        assert_eq!(target.depth(1, 1), 0.25);
        assert_eq!(target.colour(1, 1).x, 0.25);
        assert_eq!((work.visible, work.covered), (16, 32));
    }
}

#[test]
fn equal_depths_go_to_the_least_key() {
    let key = |group, instance, vertex| Key {
        group,
        instance,
        vertex,
        triangle: 0,
    };
    let keys = [key(0, 7, 9), key(0, 8, 2), key(1, 0, 3), key(1, 0, 4)];
    let mut drawings = keys.map(|key| {
        let mut drawing = Drawing::new(4, 4);
        drawing.shape(&WHOLE, 0.5, RED);
        drawing.geometry.vertex_ids = (key.vertex..key.vertex + 4).collect();
        (drawing, key)
    });
    for turn in 0..4 {
        drawings.rotate_left(turn % 2 + 1);
        let batches: Vec<Batch<'_>> = drawings
            .iter()
            .map(|(drawing, key)| Batch {
                group: key.group,
                instance: key.instance,
                ..drawing.batch(Topology::QuadList, &Plain)
            })
            .collect();
        let mut together = Target::new(4, 4, Samples::One);
        render(&mut together, &batches, &EXACT);
        let mut one_by_one = Target::new(4, 4, Samples::Four);
        let mut visible = Vec::new();
        for batch in &batches {
            visible.push(render(&mut one_by_one, &[*batch], &QUICK).visible);
        }
        for target in [&together, &one_by_one] {
            // The upper right half is the second triangle of the quad.
            assert_eq!(target.key(0, 3), Some(keys[0]));
            let second = Key {
                triangle: 1,
                ..keys[0]
            };
            assert_eq!(target.key(3, 0), Some(second));
        }
        assert_eq!(visible[0], 64);
    }
}

#[test]
fn equal_keys_go_to_the_least_further_vertices() {
    for ids in [[4, 5], [5, 4]] {
        let mut drawing = Drawing::new(4, 4);
        drawing.shape(&WHOLE[..3], 0.5, [0.25, 0.0, 0.0, 1.0]);
        drawing.shape(&WHOLE[..3], 0.5, [0.5, 0.0, 0.0, 1.0]);
        drawing.geometry.vertex_ids = vec![1, 3, ids[0], 1, 3, ids[1]];
        let (target, _) = drawing.render(Topology::TriangleList, &Plain);
        let least = if ids[0] == 4 { 0.25 } else { 0.5 };
        assert_eq!(target.colour(1, 2).x, least);
    }
}

#[test]
fn equal_keys_go_to_the_first_submitted() {
    let mut drawing = Drawing::new(4, 4);
    drawing.shape(&WHOLE, 0.5, [0.5, 0.0, 0.0, 1.0]);
    drawing.shape(&WHOLE, 0.5, [1.0, 0.0, 0.0, 1.0]);
    drawing.geometry.vertex_ids = vec![0, 1, 2, 3, 0, 1, 2, 3];
    let (mut target, _) = drawing.render(Topology::QuadList, &Plain);
    assert_eq!(target.colour(1, 2).x, 0.5);
    drawing.geometry.flats[0] = 0.25;
    let again = [drawing.batch(Topology::QuadList, &Plain)];
    assert_eq!(render(&mut target, &again, &QUICK).visible, 0);
    assert_eq!(target.colour(1, 2).x, 0.5);
}

#[test]
fn the_far_plane_does_not_show_over_a_cleared_target() {
    let mut drawing = Drawing::new(4, 4);
    drawing.shape(&WHOLE, 1.0, RED);
    let (target, work) = drawing.render(Topology::QuadList, &Plain);
    assert_eq!(target.key(0, 0), None);
    assert_eq!((work.visible, work.covered), (0, 16));
}

#[test]
fn targets_keep_depth_and_keys_between_calls() {
    let mut near = Drawing::new(4, 4);
    near.shape(&WHOLE, 0.25, RED);
    let mut far = Drawing::new(4, 4);
    far.shape(&WHOLE, 0.5, RED);
    let mut target = Target::new(4, 4, Samples::One);
    let first = render(
        &mut target,
        &[near.batch(Topology::QuadList, &Plain)],
        &QUICK,
    );
    let second = render(
        &mut target,
        &[far.batch(Topology::QuadList, &Plain)],
        &QUICK,
    );
    assert_eq!((first.visible, second.visible), (16, 0));
    target.clear(Vec4::ZERO, 1.0);
    let third = render(
        &mut target,
        &[far.batch(Topology::QuadList, &Plain)],
        &QUICK,
    );
    assert_eq!(third.visible, 16);
}

fn blended(depth: f32, colour: [f32; 4]) -> Drawing {
    let mut drawing = Drawing::new(4, 4);
    drawing.shape(&WHOLE, depth, colour);
    drawing
}

fn alpha(drawing: &Drawing) -> Batch<'_> {
    Batch {
        blend: Blend::Alpha,
        ..drawing.batch(Topology::QuadList, &Plain)
    }
}

#[test]
fn blending_keeps_submission_order_and_writes_no_depth() {
    let red = blended(0.1, [1.0, 0.0, 0.0, 0.5]);
    let green = blended(0.2, [0.0, 1.0, 0.0, 0.5]);
    for samples in [Samples::One, Samples::Four] {
        let mut target = Target::new(4, 4, samples);
        target.clear(Vec4::new(0.0, 0.0, 1.0, 1.0), 1.0);
        let work = render(&mut target, &[alpha(&red), alpha(&green)], &EXACT);
        assert_eq!(target.colour(2, 1), Vec4::new(0.25, 0.5, 0.25, 1.0));
        let (depth, key) = (target.depth(2, 1), target.key(2, 1));
        assert_eq!((depth, key), (1.0, None));
        assert_eq!(work.visible, 32 * samples.count() as u64);
        assert_eq!(work.covered, work.visible);

        target.clear(Vec4::new(0.0, 0.0, 1.0, 1.0), 1.0);
        render(&mut target, &[alpha(&green)], &QUICK);
        render(&mut target, &[alpha(&red)], &QUICK);
        assert_eq!(target.colour(2, 1), Vec4::new(0.5, 0.25, 0.25, 1.0));
    }
}

#[test]
fn blended_runs_meet_the_opaque_ones_before_them() {
    let wall = blended(0.5, [1.0, 1.0, 1.0, 1.0]);
    let before = blended(0.3, [0.0, 1.0, 0.0, 0.5]);
    let level = blended(0.5, [0.0, 0.0, 1.0, 0.5]);
    let behind = blended(0.7, [0.0, 0.0, 1.0, 0.5]);
    let nearer_wall = blended(0.2, [0.25, 0.0, 0.0, 1.0]);
    let opaque = |drawing| Drawing::batch(drawing, Topology::QuadList, &Plain);
    let mut target = Target::new(4, 4, Samples::One);
    let batches = [
        opaque(&wall),
        alpha(&before),
        alpha(&level),
        alpha(&behind),
        opaque(&nearer_wall),
    ];
    let work = render(&mut target, &batches[..4], &EXACT);
    assert_eq!(target.colour(0, 0), Vec4::new(0.5, 1.0, 0.5, 1.0));
    assert_eq!((work.visible, work.covered), (32, 64));

    let mut target = Target::new(4, 4, Samples::One);
    let work = render(&mut target, &batches, &QUICK);
    assert_eq!(target.colour(0, 0), Vec4::new(0.25, 0.0, 0.0, 1.0));
    // Each sample has one owner drawn by the call, however many runs it took, and one blend.
    assert_eq!(work.visible, 32);
}

#[test]
fn alpha_tests_are_counted_exactly() {
    // A quarter of a disc in 8 × 8 pixels, and the same behind it; a pixel is in when its centre is.
    let inside: u64 = (0..64_u32)
        .filter(|i| (2 * (i % 8) + 1).pow(2) + (2 * (i / 8) + 1).pow(2) < 256)
        .count() as u64;
    let mut drawing = Drawing::new(8, 8);
    drawing.leaf([0.0, 0.0], [8.0, 8.0], 0.25);
    drawing.leaf([0.0, 0.0], [8.0, 8.0], 0.75);
    let (target, work) = drawing.render(Topology::QuadList, &Quarter);
    let killed = 64 - inside;
    assert_eq!(
        work,
        Work {
            visible: inside,
            covered: 128,
            alpha_killed: 2 * killed,
            texels: 3 * 128 + 5 * inside,
        }
    );
    assert_eq!(
        letters(&target, 4),
        "aaaaaaaa\n\
         aaaaaaaa\n\
         aaaaaaaa\n\
         aaaaaaa.\n\
         aaaaaaa.\n\
         aaaaaa..\n\
         aaaaa...\n\
         aaa.....\n"
    );
    let quick = drawing.render_with(Topology::QuadList, &Quarter, Samples::One, QUICK);
    let visible = Work {
        visible: inside,
        ..Work::default()
    };
    assert_eq!(quick.1, visible);
    assert_eq!(quick.0.resolve(), target.resolve());

    // Four samples: tested once a pixel and triangle, counted by samples.
    let (_, work) = drawing.render_with(Topology::QuadList, &Quarter, Samples::Four, EXACT);
    assert_eq!(work.covered, 4 * 128);
    assert_eq!(work.visible % 4, 0, "the diagonals cut no pixel's test");
}

#[test]
fn attributes_are_perspective_correct() {
    // A floor seen at a slant: varyings against the f64 solution of the projection.
    let corners = [
        (Vec4::new(-3.0, -1.0, 0.2, 1.0), [0.0, 0.0]),
        (Vec4::new(6.0, -2.0, 3.0, 5.0), [9.0, 0.0]),
        (Vec4::new(-4.0, 8.0, 7.0, 11.0), [0.0, 7.0]),
    ];
    let mut drawing = Drawing::new(64, 64);
    for (clip, uv) in corners {
        let id = drawing.clip_vertex(clip, &uv);
        drawing.geometry.corners.push(id);
    }
    let (target, work) = drawing.render(Topology::TriangleList, &Coordinates);
    assert!(work.visible > 500, "{work:?}");
    // Barycentric coordinates b of the point on the plane that projects to (x, y): Σ b (p − w s) = 0.
    let corner = |k: usize| corners[k].0.as_dvec4();
    for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
        if target.key(x, y).is_none() {
            continue;
        }
        let [sx, sy] = [
            (f64::from(x) + 0.5) / 32.0 - 1.0,
            1.0 - (f64::from(y) + 0.5) / 32.0,
        ];
        let row = |axis: usize, s: f64| {
            DVec3::from_array([0, 1, 2].map(|k| corner(k)[axis] - corner(k).w * s))
        };
        let b = row(0, sx).cross(row(1, sy));
        let b = b / (b.x + b.y + b.z);
        let [u, v]: [f64; 2] =
            [0, 1].map(|c| (0..3).map(|k| b[k] * f64::from(corners[k].1[c])).sum());
        let w: f64 = (0..3).map(|k| b[k] * corner(k).w).sum();
        let z: f64 = (0..3).map(|k| b[k] * corner(k).z).sum();
        let colour = target.colour(x, y).as_dvec4();
        let difference = (colour.x - u).abs().max((colour.y - v).abs());
        // Snapping moves corners by up to a 512th of a pixel, or 1 / 16,384 of the picture.
        assert!(difference < 0.02, "({x}, {y}): {colour} for {u}, {v}");
        assert!((colour.z - z / w).abs() < 1e-3, "({x}, {y}): {colour}");
    }
}

#[test]
fn the_near_plane_cuts_where_it_should() {
    // A strip along x with w = 1 whose depth runs from −1 to 1: the left half is cut away.
    let mut drawing = Drawing::new(16, 4);
    for (x, y, z) in [
        (-1.0, 1.0, -1.0),
        (-1.0, -1.0, -1.0),
        (1.0, -1.0, 1.0),
        (1.0, 1.0, 1.0),
    ] {
        let id = drawing.clip_vertex(Vec4::new(x, y, z, 1.0), &[x, y]);
        drawing.geometry.corners.push(id);
    }
    let (target, work) = drawing.render(Topology::QuadList, &Coordinates);
    assert_eq!(work.covered, 32);
    for x in 8..16 {
        let expected = (x as f32 + 0.5) / 8.0 - 1.0;
        assert!((target.depth(x, 2) - expected).abs() < 1e-6);
        assert!((target.colour(x, 2).x - expected).abs() < 1e-6);
    }
}

#[test]
fn a_ground_that_passes_below_the_eye_fills_the_lower_half() {
    // y = −1, w = z from −10 to 1000: the horizon is at half the height.
    let mut drawing = Drawing::new(64, 64);
    for (x, z) in [
        (-9000.0, -10.0),
        (9000.0, -10.0),
        (9000.0, 1000.0),
        (-9000.0, 1000.0),
    ] {
        let clip = Vec4::new(x, -1.0, z - 0.1, z);
        let id = drawing.clip_vertex(clip, &[x, z]);
        drawing.geometry.corners.push(id);
    }
    for samples in [Samples::One, Samples::Four] {
        let (target, work) = drawing.render_with(Topology::QuadList, &Coordinates, samples, EXACT);
        assert_eq!(work.covered, 64 * 32 * samples.count() as u64);
        assert_eq!(work.visible, work.covered);
        for y in 32..64 {
            // Two triangles, both seen from above, which is their front.
            let distance = 1.0 / ((y as f32 + 0.5) / 32.0 - 1.0);
            let seen = target.colour(31, y).y;
            assert!((seen / distance - 1.0).abs() < 0.02, "{seen} at {distance}");
        }
    }
}

#[test]
fn fronts_are_counter_clockwise_with_y_upwards() {
    let mut drawing = Drawing::new(8, 4);
    drawing.leaf([0.0, 0.0], [4.0, 4.0], 0.5);
    drawing.leaf([8.0, 0.0], [4.0, 4.0], 0.5);
    let (target, _) = drawing.render(Topology::QuadList, &Coordinates);
    assert_ne!(target.colour(1, 1), Vec4::ONE, "down, then right: a front");
    assert_eq!(target.colour(6, 1), Vec4::ONE, "mirrored: a back");
}

#[test]
fn derivatives_are_those_of_the_varyings() {
    let mut drawing = Drawing::new(8, 8);
    drawing.leaf([0.0, 0.0], [8.0, 4.0], 0.5);
    let (target, _) = drawing.render(Topology::QuadList, &Quarter);
    // du/dx = 1/8 and dv/dy = 1/4; the colour shows du/dx + 2 dv/dy.
    assert_eq!(target.colour(1, 1).z, 0.625);
}

#[test]
fn corners_without_a_vertex_draw_nothing() {
    let mut drawing = Drawing::new(4, 4);
    drawing.shape(&WHOLE, 0.5, RED);
    drawing.geometry.corners = vec![0, 1, 9, 3, 0, 1];
    drawing.geometry.flats = vec![0.0; 12];
    for topology in [
        Topology::TriangleList,
        Topology::QuadList,
        Topology::LineList,
    ] {
        let mut target = Target::new(4, 4, Samples::One);
        render(
            &mut target,
            &[batch(&drawing.geometry, topology, &Plain)],
            &EXACT,
        );
    }
}
