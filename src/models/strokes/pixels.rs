//! Small pictures as they are painted: values with coverage, drawn by tiny-skia and reckoned with here.

use tiny_skia::{FillRule, Paint, Path, PathBuilder, Pixmap, Rect, Transform};

use crate::math::{Vec2, index_u32};

/// One value a texel, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) values: Vec<f32>,
}

impl Plane {
    pub(super) fn filled(width: usize, height: usize, value: f32) -> Self {
        Self {
            width,
            height,
            values: vec![value; width * height],
        }
    }

    /// The value at a texel; beyond the rim the nearest.
    pub(super) fn at(&self, x: isize, y: isize) -> f32 {
        let within = |at: isize, size: usize| at.clamp(0, size.cast_signed() - 1).unsigned_abs();
        self.values[within(y, self.height) * self.width + within(x, self.width)]
    }

    /// The value at a texel of the picture repeated.
    pub(super) fn around(&self, x: isize, y: isize) -> f32 {
        let within = |at: isize, size: usize| at.rem_euclid(size.cast_signed()).unsigned_abs();
        self.values[within(y, self.height) * self.width + within(x, self.width)]
    }

    /// Every texel anew, from its column and row.
    pub(super) fn map(&self, value: impl Fn(isize, isize) -> f32) -> Self {
        let rows = 0..self.height.cast_signed();
        let texels = rows.flat_map(|y| (0..self.width.cast_signed()).map(move |x| (x, y)));
        Self {
            values: texels.map(|(x, y)| value(x, y)).collect(),
            ..*self
        }
    }

    /// The mean over squares of `2 · reach + 1` texels a side, as often as `times`.
    pub(super) fn blurred(&self, reach: isize, times: usize) -> Self {
        let mut plane = self.clone();
        let share = 1.0 / (2 * reach + 1) as f32;
        for _ in 0..times {
            for [across, down] in [[1, 0], [0, 1]] {
                plane = plane.map(|x, y| {
                    let window = -reach..=reach;
                    window.fold(0.0, |sum, by| {
                        sum + plane.at(x + across * by, y + down * by)
                    }) * share
                });
            }
        }
        plane
    }
}

/// A sheet that tiny-skia paints on, in greys.
pub(super) struct Sheet {
    pixmap: Pixmap,
}

impl Sheet {
    /// Clear, of at least one texel.
    pub(super) fn new(width: usize, height: usize) -> Self {
        let sides = [width, height].map(|side| index_u32(side.max(1)));
        Self {
            pixmap: Pixmap::new(sides[0], sides[1])
                .expect("a brush's sides are some hundred texels"),
        }
    }

    /// Fills a polygon with a grey, from 0 to 1, as far as `opacity` says.
    pub(super) fn polygon(&mut self, points: &[Vec2], grey: f32, opacity: f32) {
        let Some(path) = closed(points) else {
            return;
        };
        let (paint, rule) = (paint(grey, opacity), FillRule::Winding);
        self.pixmap
            .fill_path(&path, &paint, rule, Transform::identity(), None);
    }

    /// Fills everything.
    pub(super) fn fill(&mut self, grey: f32) {
        let (width, height) = (self.pixmap.width() as f32, self.pixmap.height() as f32);
        if let Some(rect) = Rect::from_xywh(0.0, 0.0, width, height) {
            self.pixmap
                .fill_rect(rect, &paint(grey, 1.0), Transform::identity(), None);
        }
    }

    /// The greys, 0 where nothing is, and the coverage.
    pub(super) fn planes(&self) -> [Plane; 2] {
        let (width, height) = (self.pixmap.width() as usize, self.pixmap.height() as usize);
        let texels = self.pixmap.pixels();
        let plane = |values: Vec<f32>| Plane {
            width,
            height,
            values,
        };
        let greys = texels.iter().map(|texel| texel.demultiply().red());
        let covers = texels.iter().map(|texel| texel.alpha());
        [
            plane(greys.map(|grey| f32::from(grey) / 255.0).collect()),
            plane(covers.map(|cover| f32::from(cover) / 255.0).collect()),
        ]
    }
}

fn paint(grey: f32, opacity: f32) -> Paint<'static> {
    let mut paint = Paint::default();
    let [grey, opacity] = [grey, opacity].map(byte);
    paint.set_color_rgba8(grey, grey, grey, opacity);
    paint.anti_alias = true;
    paint
}

fn closed(points: &[Vec2]) -> Option<Path> {
    let (first, rest) = points.split_first()?;
    let mut path = PathBuilder::new();
    path.move_to(first.x, first.y);
    for point in rest {
        path.line_to(point.x, point.y);
    }
    path.close();
    path.finish()
}

/// From 0 to 1 to a byte, rounded.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "kept within the type's range first"
)]
pub(super) fn byte(value: f32) -> u8 {
    (255.0 * value.clamp(0.0, 1.0) + 0.5) as u8
}

/// Smooth from 0 below `from` to 1 above `to`.
pub(super) fn smooth(from: f32, to: f32, value: f32) -> f32 {
    let share = ((value - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}
