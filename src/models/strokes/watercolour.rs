//! Watercolour: washes with rims of pigment, and rough paper.

use super::brushes::{CELL, Form};
use super::pixels::{Plane, Sheet, smooth};
use crate::math::{Draws, Stream, Vec2, det};

/// A wash: how much pigment its rims have, how much of it has settled, and how far it covers.
///
/// Water carries pigment to the rim, where it dries first; where a second drop runs into the wash, it
/// pushes the pigment aside.
pub(super) fn dab(form: Form, draws: &mut Draws) -> [Plane; 3] {
    let [width, height] = CELL.map(|side| side as f32);
    let middle = Vec2::new(0.5 * width, 0.5 * height);
    let (reach, wobble, pointed) = match form {
        Form::Leaf => (Vec2::new(0.43 * width, 0.40 * height), 0.16, 0.25),
        Form::Branch => (Vec2::new(0.47 * width, 0.34 * height), 0.10, 0.0),
    };
    let outline = Outline::draw(draws, wobble, pointed, form);
    let cover = |scale: f32| {
        let mut sheet = Sheet::new(CELL[0], CELL[1]);
        sheet.polygon(&outline.points(middle, scale * reach), 1.0, 1.0);
        let [_, cover] = sheet.planes();
        cover
    };
    let (whole, inner, core) = (cover(1.0), cover(0.90), cover(0.62));
    // Some dabs are put on wet paper.
    let wet = draws.unit() < 0.30;
    let whole = if wet {
        whole.blurred(3, 2)
    } else {
        whole.blurred(1, 1)
    };
    let inner = inner.blurred(2, 2);
    let core = core.blurred(5, 2);
    let drop = Outline::draw(draws, 0.3, 0.0, Form::Leaf);
    let at = middle + Vec2::new(0.2 * width * draws.signed(), 0.12 * height * draws.signed());
    let bloom = |scale: f32| {
        let mut sheet = Sheet::new(CELL[0], CELL[1]);
        sheet.polygon(
            &drop.points(at, scale * Vec2::splat(0.24 * height)),
            1.0,
            1.0,
        );
        let [_, cover] = sheet.planes();
        cover.blurred(2, 1)
    };
    let (outside, inside) = (bloom(1.2), bloom(0.95));
    let (body, hollow, most) = match form {
        Form::Leaf => (0.40, 0.14, 0.30),
        Form::Branch => (0.46, 0.04, 0.10),
    };
    let blooms = if draws.unit() < 0.5 { most } else { 0.0 };
    let rim = match (form, wet) {
        (Form::Leaf, false) => 0.80,
        (Form::Leaf, true) => 0.30,
        (Form::Branch, _) => 0.22,
    };
    let clouds = Clouds::new(draws.below(u64::MAX), 5.0);
    let pigment = whole.map(|x, y| {
        let edge = (whole.at(x, y) - inner.at(x, y)).max(0.0);
        let pushed = outside.at(x, y) - 2.0 * inside.at(x, y) * outside.at(x, y);
        body + rim * edge - hollow * core.at(x, y)
            + blooms * pushed
            + 0.16 * (clouds.at(x as f32, y as f32) - 0.5)
    });
    let settled = whole.map(|x, y| clouds.at(2.6 * x as f32 + 31.0, 2.6 * y as f32));
    [pigment, settled, whole]
}

/// An outline around the origin: how far it is from there by angle, as a share.
struct Outline {
    shares: Vec<f32>,
}

impl Outline {
    const CORNERS: u16 = 40;

    /// A wobbly one, drawn out to a point at both ends as far as is said.
    fn draw(draws: &mut Draws, wobble: f32, pointed: f32, form: Form) -> Self {
        let waves: Vec<[f32; 3]> = (2..8_u8)
            .map(|waves| {
                let amount = wobble * draws.signed() / f32::from(waves).sqrt();
                [
                    f32::from(waves),
                    amount,
                    std::f32::consts::TAU * draws.unit(),
                ]
            })
            .collect();
        let shares = (0..Self::CORNERS).map(|corner| {
            let angle = std::f32::consts::TAU * f32::from(corner) / f32::from(Self::CORNERS);
            let wave = waves.iter().fold(0.0, |sum, [waves, amount, phase]| {
                sum + amount * det::sin(waves * angle + phase)
            });
            let cosine = det::cos(angle).abs();
            // Of a branch nearly a rectangle, of a leaf nearly an ellipse.
            let square = match form {
                Form::Branch => 1.0 + 0.22 * (1.0 - (2.0 * cosine * cosine - 1.0).abs()),
                Form::Leaf => 1.0 - pointed * (1.0 - cosine) * cosine,
            };
            (square * (1.0 + wave)).clamp(0.3, 1.15)
        });
        Self {
            shares: shares.collect(),
        }
    }

    fn points(&self, middle: Vec2, reach: Vec2) -> Vec<Vec2> {
        let corners = (0..Self::CORNERS).zip(&self.shares);
        let points = corners.map(|(corner, share)| {
            let angle = std::f32::consts::TAU * f32::from(corner) / f32::from(Self::CORNERS);
            let (sine, cosine) = det::sin_cos(angle);
            middle + share * reach * Vec2::new(cosine, sine)
        });
        points.collect()
    }
}

/// Smooth noise from 0 to 1.
struct Clouds {
    stream: Stream,
    size: f32,
}

impl Clouds {
    fn new(seed: u64, size: f32) -> Self {
        Self {
            stream: Stream::new(seed, 7),
            size,
        }
    }

    fn at(&self, x: f32, y: f32) -> f32 {
        self.repeated(x, y, u32::MAX)
    }

    /// The same, repeated after so many cells of the lattice.
    fn repeated(&self, x: f32, y: f32, cells: u32) -> f32 {
        let [x, y] = [x, y].map(|at| (at / self.size).max(0.0));
        let [(left, across), (above, down)] = [x, y].map(|at| {
            let cell = crate::math::whole_u32(f64::from(at));
            let rest = at - cell as f32;
            (cell, rest * rest * (3.0 - 2.0 * rest))
        });
        let value = |column: u32, row: u32| {
            let [column, row] = [column, row].map(|at| u64::from(at % cells));
            self.stream.unit(column + (row << 24))
        };
        let upper = value(left, above) + (value(left + 1, above) - value(left, above)) * across;
        let lower =
            value(left, above + 1) + (value(left + 1, above + 1) - value(left, above + 1)) * across;
        upper + (lower - upper) * down
    }
}

/// Rough paper: how high it lies, how it is lit, and how clean it is.
pub(super) fn paper(side: usize, draws: &mut Draws) -> [Plane; 3] {
    let clear = Plane::filled(side, side, 0.0);
    let mut octave = |size: f32| (Clouds::new(draws.below(u64::MAX), size), size);
    let octaves = [octave(8.0), octave(4.0), octave(2.0)];
    let (stains, stain_size) = octave(64.0);
    let cells = |size: f32| crate::math::whole_u32(f64::from(side as f32 / size)).max(1);
    let height = clear.map(|x, y| {
        let (x, y) = (x as f32, y as f32);
        let sum = octaves.iter().zip([0.5, 0.32, 0.18]);
        let sum = sum.fold(0.0, |sum, ((clouds, size), share)| {
            sum + share * clouds.repeated(x, y, cells(*size))
        });
        smooth(0.2, 0.8, sum)
    });
    let lit = height.map(|x, y| {
        let rise = height.around(x + 1, y + 1) - height.around(x - 1, y - 1);
        0.5 + 0.32 * rise
    });
    let clean = height.map(|x, y| stains.repeated(x as f32, y as f32, cells(stain_size)));
    [height, lit, clean]
}
