//! Oil: dabs that bristles have drawn, and canvas.

use super::brushes::{CELL, Form};
use super::pixels::{Plane, Sheet, smooth};
use crate::math::{Draws, Vec2};

/// A dab of a bristle brush: how light the paint is, how it is lit as a relief, and how thick it lies.
///
/// Each bristle is a streak of its own tone that begins near the rim of the dab; towards its end
/// some run dry, so that the end is ragged.
pub(super) fn dab(form: Form, draws: &mut Draws) -> [Plane; 3] {
    let [width, height] = CELL.map(|side| side as f32);
    let mut sheet = Sheet::new(CELL[0], CELL[1]);
    let (bristles, rounding, dryness) = match form {
        Form::Leaf => (24_u16, 0.24, 0.55),
        Form::Branch => (26, 0.12, 0.20),
    };
    let lean = 0.10 * draws.signed();
    let bow = 0.09 * draws.signed();
    // From the rims to the middle, so that the rims are ragged and the middle is one body.
    for pass in 0..3_u8 {
        for bristle in 0..bristles {
            let place = (f32::from(bristle) + 0.5 + 0.7 * draws.signed()) / f32::from(bristles);
            let offset = 1.84 * (place - 0.5);
            let round = rounding * (1.0 - (1.0 - offset * offset).max(0.0).sqrt());
            let begin = 0.05 + round + 0.12 * draws.unit();
            let dry = dryness * draws.unit() * draws.unit();
            let end = 0.96 - 0.8 * round - dry - 0.07 * draws.unit();
            let tone = 0.5 + 0.30 * draws.signed() * (0.6 + 0.4 * f32::from(pass));
            let thick = height * (0.020 + 0.030 * draws.unit());
            let opacity = if pass == 0 { 0.95 } else { 0.8 };
            if begin >= end || (pass > 0 && draws.unit() < 0.35) {
                continue;
            }
            let along = |share: f32| {
                let bent = bow * 4.0 * (share - 0.5) * (share - 0.5) + lean * (share - 0.5);
                let y = 0.5 + 0.43 * offset + bent;
                Vec2::new(width * share, height * y)
            };
            streak(&mut sheet, along, [begin, end], thick, tone, opacity);
        }
    }
    let [grey, cover] = sheet.planes();
    relief(&grey, &cover)
}

/// One bristle's streak: a thin polygon, thickest before its middle.
fn streak(
    sheet: &mut Sheet,
    along: impl Fn(f32) -> Vec2,
    [begin, end]: [f32; 2],
    thick: f32,
    tone: f32,
    opacity: f32,
) {
    const STEPS: u8 = 10;
    let half = |share: f32| thick * (0.25 + 3.0 * share * (1.0 - share)).min(1.0);
    let at = |step: u8| f32::from(step) / f32::from(STEPS);
    let point = |step: u8, side: f32| {
        along(begin + (end - begin) * at(step)) + Vec2::new(0.0, side * half(at(step)))
    };
    let forth = (0..=STEPS).map(|step| point(step, -1.0));
    let back = (0..=STEPS).rev().map(|step| point(step, 1.0));
    let points: Vec<Vec2> = forth.chain(back).collect();
    sheet.polygon(&points, tone, opacity);
}

/// Tone, light from above on the ridges, and thickness.
fn relief(grey: &Plane, cover: &Plane) -> [Plane; 3] {
    let height = cover.map(|x, y| cover.at(x, y) * (0.55 + grey.at(x, y)));
    let lit = height.map(|x, y| {
        let down = height.at(x, y + 1) - height.at(x, y - 1);
        let right = height.at(x + 1, y) - height.at(x - 1, y);
        0.5 + 0.55 * down + 0.25 * right
    });
    [grey.clone(), lit, cover.clone()]
}

/// Canvas primed and loosely covered: how high it lies, how it is lit, and how light the ground is.
pub(super) fn canvas(side: usize, draws: &mut Draws) -> [Plane; 3] {
    let threads = side / THREAD;
    let mut tone = |spread: f32| -> Vec<f32> {
        (0..threads)
            .map(|_| 1.0 + spread * draws.signed())
            .collect()
    };
    let (warp, weft) = (tone(0.35), tone(0.35));
    let clear = Plane::filled(side, side, 0.0);
    let height = clear.map(|x, y| {
        let [column, row] = [x, y].map(|at| at.unsigned_abs() / THREAD);
        let bump = |at: isize| {
            let share = (at.unsigned_abs() % THREAD) as f32 + 0.5;
            let from_middle = 2.0 * share / THREAD as f32 - 1.0;
            (1.0 - from_middle * from_middle).max(0.0).sqrt()
        };
        let (over, under) = if (column + row) % 2 == 0 {
            (
                bump(x) * warp[column % threads],
                bump(y) * weft[row % threads],
            )
        } else {
            (
                bump(y) * weft[row % threads],
                bump(x) * warp[column % threads],
            )
        };
        (0.72 * over + 0.28 * under).clamp(0.0, 1.0)
    });
    let ground = scumble(side, draws);
    let lit = height.map(|x, y| {
        let rise = height.around(x + 1, y + 1) - height.around(x - 1, y - 1);
        let brushed = ground.around(x, y + 1) - ground.around(x, y - 1);
        0.5 + 0.30 * rise + 0.55 * brushed
    });
    [height, lit, ground]
}

/// Texels of a thread's width.
const THREAD: usize = 4;

/// To the eight pictures around one that is repeated, and to itself.
const SHIFTS: [[[f32; 2]; 3]; 3] = [
    [[-1.0, -1.0], [0.0, -1.0], [1.0, -1.0]],
    [[-1.0, 0.0], [0.0, 0.0], [1.0, 0.0]],
    [[-1.0, 1.0], [0.0, 1.0], [1.0, 1.0]],
];

/// Broad strokes of a little more or less of the ground's colour, all over, as on a wall.
fn scumble(side: usize, draws: &mut Draws) -> Plane {
    let size = side as f32;
    let mut sheet = Sheet::new(side, side);
    sheet.fill(0.5);
    for _ in 0..420_u16 {
        let middle = size * Vec2::new(draws.unit(), draws.unit());
        let slope = 0.5 * draws.signed();
        let half = size * (0.06 + 0.07 * draws.unit());
        let tone = 0.5 + 0.30 * draws.signed();
        for bristle in 0..12_u8 {
            let offset = (f32::from(bristle) - 5.5) * size * 0.0042;
            let [begin, end] = [half, half].map(|half| half * (0.7 + 0.5 * draws.unit()));
            let tone = tone + 0.07 * draws.signed();
            let thick = size * 0.0032 * (0.6 + 0.8 * draws.unit());
            // Drawn again for each rim over which it may hang.
            for shift in SHIFTS.as_flattened() {
                let at = middle + size * Vec2::from_array(*shift);
                let along = |share: f32| {
                    let far = share * (begin + end) - begin;
                    at + Vec2::new(far, slope * far + offset)
                };
                streak(&mut sheet, along, [0.0, 1.0], thick, tone, 0.55);
            }
        }
    }
    let [grey, _] = sheet.planes();
    grey.map(|x, y| smooth(0.0, 1.0, grey.at(x, y)))
}
