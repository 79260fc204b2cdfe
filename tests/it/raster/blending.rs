//! The ways in which fragments meet what is there, other than by order alone.

use super::{Drawing, Plain, render};
use super::{EXACT, QUICK};
use spinney::math::Vec4;
use spinney::raster::{Batch, Blend, Samples, Target, Topology};

const WHOLE: [[f32; 2]; 4] = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
const BLUE: Vec4 = Vec4::new(0.0, 0.0, 1.0, 1.0);

fn sheet(depth: f32, colour: [f32; 4]) -> Drawing {
    let mut drawing = Drawing::new(4, 4);
    drawing.shape(&WHOLE, depth, colour);
    drawing
}

fn red() -> Drawing {
    sheet(0.1, [1.0, 0.0, 0.0, 0.5])
}

fn green() -> Drawing {
    sheet(0.2, [0.0, 1.0, 0.0, 0.5])
}

/// What a pixel shows once these are drawn over blue, in this order.
fn seen(samples: Samples, blend: Blend, sheets: &[&Drawing]) -> (Target, u64) {
    let batches: Vec<Batch<'_>> = sheets
        .iter()
        .map(|sheet| Batch {
            blend,
            ..sheet.batch(Topology::QuadList, &Plain)
        })
        .collect();
    let mut target = Target::new(4, 4, samples);
    target.clear(BLUE, 1.0);
    let work = render(&mut target, &batches, &EXACT);
    (target, work.visible / samples.count() as u64)
}

#[test]
fn sorted_fragments_are_blended_from_far_to_near() {
    let (red, green) = (red(), green());
    let far_first = Vec4::new(0.5, 0.25, 0.25, 1.0);
    for samples in [Samples::One, Samples::Four] {
        for order in [[&red, &green], [&green, &red]] {
            let (target, visible) = seen(samples, Blend::Sorted, &order);
            assert_eq!(target.colour(2, 1), far_first);
            assert_eq!((target.depth(2, 1), target.key(2, 1)), (1.0, None));
            assert_eq!(visible, 32);
        }
    }
    // Equally deep ones keep their order.
    let level = sheet(0.1, [0.0, 1.0, 0.0, 0.5]);
    let (target, _) = seen(Samples::One, Blend::Sorted, &[&red, &level]);
    assert_eq!(target.colour(0, 0), Vec4::new(0.25, 0.5, 0.25, 1.0));
}

#[test]
fn sorting_is_of_a_run_and_what_is_opaque_hides() {
    let (red, green) = (red(), green());
    let wall = sheet(0.15, [1.0; 4]);
    let sorted = |drawing| Batch {
        blend: Blend::Sorted,
        ..Drawing::batch(drawing, Topology::QuadList, &Plain)
    };
    let batches = [
        sorted(&red),
        wall.batch(Topology::QuadList, &Plain),
        sorted(&green),
        sorted(&red),
    ];
    let mut target = Target::new(4, 4, Samples::One);
    target.clear(BLUE, 1.0);
    render(&mut target, &batches, &QUICK);
    assert_eq!(target.colour(1, 1), Vec4::new(1.0, 0.5, 0.5, 1.0));
}

#[test]
fn what_writes_depth_hides_what_comes_later() {
    let (red, green) = (red(), green());
    for samples in [Samples::One, Samples::Four] {
        let (target, visible) = seen(samples, Blend::AlphaAndDepth, &[&green, &red]);
        assert_eq!(target.colour(2, 1), Vec4::new(0.5, 0.25, 0.25, 1.0));
        assert_eq!((target.depth(2, 1), target.key(2, 1)), (0.1, None));
        assert_eq!(visible, 32);
        let (target, visible) = seen(samples, Blend::AlphaAndDepth, &[&red, &green]);
        assert_eq!(target.colour(2, 1), Vec4::new(0.5, 0.0, 0.5, 1.0));
        assert_eq!(visible, 16);
    }
    // Its depth is no opaque one's: the wall at the same depth does not win the tie by any key.
    let wall = sheet(0.1, [1.0; 4]);
    let (mut target, _) = seen(Samples::One, Blend::AlphaAndDepth, &[&red]);
    render(
        &mut target,
        &[wall.batch(Topology::QuadList, &Plain)],
        &QUICK,
    );
    assert_eq!(target.colour(0, 0), Vec4::new(0.5, 0.0, 0.5, 1.0));
}

#[test]
fn added_fragments_add_up_in_any_order() {
    let (red, green) = (red(), green());
    for order in [[&red, &green], [&green, &red]] {
        let (target, visible) = seen(Samples::Four, Blend::Add, &order);
        assert_eq!(target.colour(3, 3), Vec4::new(1.0, 1.0, 1.0, 2.0));
        assert_eq!(target.depth(3, 3), 1.0);
        assert_eq!(visible, 32);
    }
}
