//! Small triangles, drawn.

use super::{Drawing, EXACT, Plain, letters};
use spinney::raster::{Samples, Target, Topology};

const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];

fn triangles(width: u32, height: u32, corners: &[[[f32; 2]; 3]]) -> String {
    let mut drawing = Drawing::new(width, height);
    for triangle in corners {
        drawing.shape(triangle, 0.5, RED);
    }
    letters(&drawing.render(Topology::TriangleList, &Plain).0, 3)
}

#[test]
fn a_triangle_covers_the_centres_within() {
    // Its long side runs through the centres of the diagonal, and is neither a top nor a left edge.
    assert_eq!(
        triangles(4, 4, &[[[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]]]),
        "aaa.\n\
         aa..\n\
         a...\n\
         ....\n"
    );
    // The other way round it is a left edge.
    assert_eq!(
        triangles(4, 4, &[[[4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]]),
        "...a\n\
         ..aa\n\
         .aaa\n\
         aaaa\n"
    );
}

#[test]
fn winding_does_not_matter_to_coverage() {
    let corners = [[0.3, 0.2], [7.9, 3.1], [2.2, 7.7]];
    let [a, b, c] = corners;
    assert_eq!(triangles(8, 8, &[[a, b, c]]), triangles(8, 8, &[[a, c, b]]));
}

#[test]
fn centres_on_top_and_left_edges_are_covered_and_on_others_not() {
    // The corners are centres of pixels.
    let [a, b, c, d] = [[0.5, 0.5], [2.5, 0.5], [2.5, 2.5], [0.5, 2.5]];
    assert_eq!(
        triangles(4, 4, &[[a, b, c], [a, c, d]]),
        "aa..\n\
         ba..\n\
         ....\n\
         ....\n"
    );
}

#[test]
fn two_triangles_share_an_edge_without_a_gap_or_overlap() {
    // The first column of the diagonal belongs to the lower triangle, whose left … top edge it is.
    assert_eq!(
        triangles(
            4,
            4,
            &[
                [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]],
                [[0.0, 0.0], [4.0, 4.0], [0.0, 4.0]],
            ]
        ),
        "aaaa\n\
         baaa\n\
         bbaa\n\
         bbba\n"
    );
}

#[test]
fn slivers_between_centres_cover_nothing() {
    assert_eq!(
        triangles(2, 2, &[[[0.51, 0.0], [1.49, 0.0], [1.0, 2.0]]]),
        "..\n..\n"
    );
}

#[test]
fn a_fan_around_the_centre_covers_every_pixel_once() {
    let mut drawing = Drawing::new(8, 8);
    let rim = [
        [0.0, 0.0],
        [5.5, 0.0],
        [8.0, 0.0],
        [8.0, 2.5],
        [8.0, 8.0],
        [3.5, 8.0],
        [0.0, 8.0],
        [0.0, 4.5],
    ];
    for (index, &corner) in rim.iter().enumerate() {
        let next = rim[(index + 1) % rim.len()];
        drawing.shape(&[[4.5, 4.5], corner, next], 0.5, RED);
    }
    for samples in [Samples::One, Samples::Four] {
        let (_, work) = drawing.render_with(Topology::TriangleList, &Plain, samples, EXACT);
        assert_eq!(work.covered, 64 * samples.count() as u64);
        assert_eq!(work.visible, work.covered);
    }
}

#[test]
fn a_quad_covers_three_eighths_of_the_target() {
    // 96 of 256 columns, all rows, on borders of pixels.
    let mut drawing = Drawing::new(256, 100);
    drawing.shape(
        &[[32.0, 0.0], [32.0, 100.0], [128.0, 100.0], [128.0, 0.0]],
        0.5,
        RED,
    );
    for samples in [Samples::One, Samples::Four] {
        let (target, work) = drawing.render_with(Topology::QuadList, &Plain, samples, EXACT);
        let all = 256 * 100 * samples.count() as u64;
        assert_eq!(work.covered * 1000, all * 375);
        assert_eq!(work.visible, work.covered);
        let red = target.resolve();
        let painted = red.rgba.chunks(4).filter(|pixel| pixel[0] == 255).count();
        assert_eq!(painted * 1000, 256 * 100 * 375);
    }
}

#[test]
fn the_widest_targets_are_filled_to_the_rim() {
    for [width, height] in [[Target::MAX_SIDE, 2], [2, Target::MAX_SIDE]] {
        let [w, h] = [width as f32, height as f32];
        let mut drawing = Drawing::new(width, height);
        // Far beyond the rim, and cut at the guard band.
        drawing.shape(
            &[
                [-9.0 * w, -9.0 * h],
                [-9.0 * w, 10.0 * h],
                [10.0 * w, 10.0 * h],
                [10.0 * w, -9.0 * h],
            ],
            0.5,
            RED,
        );
        let (target, work) = drawing.render(Topology::QuadList, &Plain);
        assert_eq!(work.covered, 2 * u64::from(Target::MAX_SIDE));
        assert_eq!(work.visible, work.covered);
        assert_eq!(target.colour(width - 1, height - 1).x, 1.0);
    }
}

#[test]
fn four_samples_lie_on_the_rotated_grid() {
    // One sample after the other comes within as the right edge moves over a pixel's eighths.
    let share = |right: f32| {
        let mut drawing = Drawing::new(1, 1);
        drawing.shape(
            &[[0.0, 0.0], [0.0, 1.0], [right, 1.0], [right, 0.0]],
            0.5,
            RED,
        );
        let samples = Samples::Four;
        let (target, work) = drawing.render_with(Topology::QuadList, &Plain, samples, EXACT);
        assert_eq!(target.colour(0, 0).x, work.visible as f32 / 4.0);
        work.covered
    };
    let shares = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0].map(share);
    assert_eq!(shares, [0, 1, 1, 2, 2, 3, 3, 4]);
}

#[test]
fn lines_are_a_pixel_wide() {
    let mut drawing = Drawing::new(8, 6);
    drawing.shape(&[[1.0, 1.5], [6.0, 1.5]], 0.5, RED);
    drawing.shape(&[[6.5, 6.0], [6.5, 3.0]], 0.5, RED);
    drawing.shape(&[[0.0, 3.0], [3.0, 6.0]], 0.5, RED);
    let (target, work) = drawing.render(Topology::LineList, &Plain);
    assert_eq!(
        letters(&target, 2),
        "........\n\
         .aaaaa..\n\
         ........\n\
         c.....b.\n\
         .c....b.\n\
         ..c...b.\n"
    );
    assert_eq!(work.covered, work.visible);
}
