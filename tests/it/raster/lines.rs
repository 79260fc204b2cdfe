//! Lines that are blended go a way of their own: against scalar instructions, against one pixel under the
//! microscope, and however they are cut into batches.

use proptest::prelude::*;

use super::{Drawing, EXACT, QUICK, contents};
use spinney::math::Vec4;
use spinney::raster::{
    Batch, Blend, Fragment, Instructions, Machine, Pixel, Samples, Target, Topology, Work, probe,
    render_on,
};

/// Eight bits of alpha and all that a fragment stage may know.
#[derive(Debug)]
struct Glass;

impl Fragment for Glass {
    const VARYINGS: usize = 3;
    const FLATS: usize = 1;
    const TESTS_ALPHA: bool = false;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn texels_shaded(&self) -> u64 {
        2
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let [u, v, t, ..] = *pixel.varyings;
        let steepness = pixel.derivative_x.x - pixel.derivative_y.y + pixel.derivative_x.y;
        let [x, y] = pixel.position;
        let place = (x % 4 + 4 * (y % 2)) as f32;
        let front = f32::from(u8::from(pixel.front));
        Vec4::new(
            u + steepness,
            v * pixel.depth + place,
            t + front,
            pixel.flats[0],
        )
    }
}

/// A colour that follows from what is interpolated, of which some is negative only where lines are uneven.
#[derive(Debug)]
struct Ink;

impl Fragment for Ink {
    const VARYINGS: usize = 3;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = false;
    const FROM_VARYINGS: bool = true;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let [u, v, t, ..] = *pixel.varyings;
        Vec4::new(u, v, u * v + t, t)
    }
}

/// The same lines, each with the depth, the `w` and the values of its first end at both.
fn even(lines: &[Ends]) -> Vec<Ends> {
    let even = |&(from, along, ends, values): &Ends| {
        let (end, values) = (ends[0].map(f32::abs), values[0].map(f32::abs));
        (from, along, [end, end], [values, values])
    };
    lines.iter().map(even).collect()
}

const SIDES: [u32; 2] = [150, 70];

/// A line: one end, the way to the other, depths, `w` and what is interpolated.
type Ends = ([f32; 2], [f32; 2], [[f32; 2]; 2], [[f32; 3]; 2]);

/// Lines from less than a sub-pixel to far beyond the guard band, some with an end behind the eye.
fn any_line() -> impl Strategy<Value = Ends> {
    let reach = prop_oneof![
        4 => Just(6.0_f32),
        2 => Just(0.01_f32),
        2 => Just(120.0_f32),
        1 => Just(1e6_f32),
    ];
    let along = (-1.0_f32..1.0, -1.0_f32..1.0, reach, any::<bool>())
        .prop_map(|(x, y, reach, straight)| [x * reach, if straight { 0.0 } else { y * reach }]);
    let depth = prop_oneof![6 => 0.0_f32..1.0, 1 => -0.5_f32..1.5];
    let w = prop_oneof![3 => Just(1.0_f32), 3 => 0.5_f32..4.0, 1 => -1.0_f32..1.0];
    let end = (depth, w).prop_map(|(depth, w)| [depth, w]);
    let value = -1.0_f32..1.0;
    let values = [value.clone(), value.clone(), value];
    (
        [-4.0_f32..154.0, -4.0_f32..74.0],
        along,
        [end.clone(), end],
        [values.clone(), values],
    )
}

fn drawing(lines: &[Ends]) -> Drawing {
    let mut drawing = Drawing::new(SIDES[0], SIDES[1]);
    for (number, (from, along, ends, values)) in lines.iter().enumerate() {
        let to = [from[0] + along[0], from[1] + along[1]];
        for (at, ([depth, w], values)) in [*from, to].into_iter().zip(ends.iter().zip(values)) {
            let [x, y] = [
                2.0 * at[0] / SIDES[0] as f32 - 1.0,
                1.0 - 2.0 * at[1] / SIDES[1] as f32,
            ];
            let clip = Vec4::new(x * w, y * w, depth * w, *w);
            drawing.clip_vertex(clip, values);
        }
        let first = u32::try_from(2 * number).expect("tests are small");
        // Every third line names its ends the other way round.
        let turned = u32::from(number % 3 == 2);
        drawing
            .geometry
            .corners
            .extend([first + turned, first + 1 - turned]);
        drawing
            .geometry
            .flats
            .push(0.25 + 0.5 * (number % 2) as f32);
    }
    drawing
}

/// The ground at depth 0.5 on the left.
fn ground() -> Drawing {
    let mut ground = Drawing::new(SIDES[0], SIDES[1]);
    let corners = [[0.0, 0.0], [0.0, 70.0], [75.0, 70.0], [75.0, 0.0]];
    ground.shape(&corners, 0.5, [0.25, 0.5, 0.75, 1.0]);
    ground
}

fn draw(
    batches: &[Batch<'_>],
    samples: Samples,
    machine: Machine,
    options: spinney::raster::Options,
) -> (Target, Vec<Work>) {
    let mut target = Target::new(SIDES[0], SIDES[1], samples);
    let works = render_on(machine, &mut target, batches, &options).works;
    (target, works)
}

/// What blending the probed fragments of a pixel gives, with one sample.
fn blended(batches: &[Batch<'_>], pixel: [u32; 2]) -> Vec4 {
    let (mut colour, mut ground) = (Vec4::ZERO, 1.0_f32);
    for fragment in probe(SIDES, Samples::One, batches, pixel) {
        let depth = fragment.depths[0].expect("one sample is covered");
        if depth >= ground {
            continue;
        }
        if fragment.blend == Blend::Opaque {
            (colour, ground) = (fragment.colour, depth);
            continue;
        }
        let alpha = fragment.colour.w;
        let factor = Vec4::new(alpha, alpha, alpha, 1.0);
        colour = fragment.colour * factor + colour * (1.0 - alpha);
    }
    colour
}

crate::support::properties! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn blended_lines_are_what_their_fragments_are(
        lines in prop::collection::vec(any_line(), 1..90),
    ) {
        let (drawing, ground) = (drawing(&lines), ground());
        let batches = [
            ground.batch(Topology::QuadList, &super::Plain),
            Batch { blend: Blend::Alpha, ..drawing.batch(Topology::LineList, &Glass) },
        ];
        let (target, works) = draw(&batches, Samples::One, Machine::THIS, EXACT);
        let linear = target.linear();
        let mut visible = 0;
        let bits = |colour: Vec4| colour.to_array().map(f32::to_bits);
        for (y, row) in (0..SIDES[1]).zip(linear.chunks(SIDES[0] as usize)) {
            for (x, colour) in (0..SIDES[0]).zip(row) {
                // All pixels of some rows, some of the others.
                if y % 8 < 2 || (x + y) % 5 == 0 {
                    prop_assert_eq!(bits(*colour), bits(blended(&batches, [x, y])), "{} {}", x, y);
                }
                visible += u64::from(bits(*colour) != [0; 4]);
            }
        }
        prop_assert!(visible <= works[0].visible + works[1].visible);
        prop_assert!(works[1].visible <= works[1].covered);
        prop_assert_eq!(works[1].texels, 2 * works[1].visible);
    }

    #[test]
    fn instructions_memory_tiles_and_counters_leave_no_trace_of_lines(
        lines in prop::collection::vec(any_line(), 1..160),
    ) {
        let (drawing, ground) = (drawing(&lines), ground());
        let batches = [
            ground.batch(Topology::QuadList, &super::Plain),
            Batch { blend: Blend::Alpha, ..drawing.batch(Topology::LineList, &Glass) },
        ];
        let scalar = Machine { instructions: Instructions::Scalar, ..Machine::THIS };
        let small = Machine { geometry_bytes: 0, ..Machine::THIS };
        for samples in [Samples::One, Samples::Four] {
            let (target, works) = draw(&batches, samples, Machine::THIS, EXACT);
            let expected = contents(&target);
            for machine in [Machine::THIS, scalar, small] {
                let (other, exact) = draw(&batches, samples, machine, EXACT);
                prop_assert_eq!(&exact, &works);
                prop_assert!(contents(&other) == expected);
                let (other, quick) = draw(&batches, samples, machine, QUICK);
                prop_assert_eq!(quick[1].visible, works[1].visible);
                prop_assert!(contents(&other) == expected);
            }
        }
    }

    #[test]
    fn lines_that_are_the_same_from_end_to_end_are_what_their_fragments_are(
        lines in prop::collection::vec(any_line(), 1..160),
        mixed in any::<bool>(),
    ) {
        let mut all = even(&lines);
        if mixed {
            all.extend(&lines[lines.len() / 2..]);
        }
        let (drawing, ground) = (drawing(&all), ground());
        let batches = [
            ground.batch(Topology::QuadList, &super::Plain),
            Batch { blend: Blend::Alpha, ..drawing.batch(Topology::LineList, &Ink) },
        ];
        let (target, works) = draw(&batches, Samples::One, Machine::THIS, EXACT);
        let linear = target.linear();
        let bits = |colour: Vec4| colour.to_array().map(f32::to_bits);
        for (y, row) in (0..SIDES[1]).zip(linear.chunks(SIDES[0] as usize)) {
            for (x, colour) in (0..SIDES[0]).zip(row) {
                if y % 8 < 2 || (x + y) % 5 == 0 {
                    prop_assert_eq!(bits(*colour), bits(blended(&batches, [x, y])), "{} {}", x, y);
                }
            }
        }
        let scalar = Machine { instructions: Instructions::Scalar, ..Machine::THIS };
        let small = Machine { geometry_bytes: 0, ..Machine::THIS };
        for machine in [scalar, small] {
            let (other, exact) = draw(&batches, Samples::One, machine, EXACT);
            prop_assert_eq!(&exact, &works);
            prop_assert!(contents(&other) == contents(&target));
        }
    }
}
