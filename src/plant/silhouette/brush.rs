//! Drawing in a leaf's own measure: lengths in shares of the leaf's length.

use tiny_skia::{FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform};

use crate::math::{Vec2, det};

/// A canvas over one leaf: x from `−width / 2` to `width / 2`, y from 0 at the base to 1 at the tip.
pub(super) struct Brush {
    pixmap: Pixmap,
    side: f32,
    /// The leaf's width as a share of its length.
    pub(super) width: f32,
    color: [u8; 3],
}

/// A blade's outline: half its width, as a share of the greatest, at a share of its length.
pub(super) type Outline = fn(f32) -> f32;

impl Brush {
    pub(super) fn new(side: u32, width: f32, color: [u8; 3]) -> Self {
        Self {
            pixmap: Pixmap::new(side, side).expect("a side is 64 or 128 texels"),
            side: side as f32,
            width,
            color,
        }
    }

    /// The image with straight alpha.
    pub(super) fn straight(&self) -> Vec<u8> {
        let straight = |texel: &tiny_skia::PremultipliedColorU8| {
            let color = texel.demultiply();
            [color.red(), color.green(), color.blue(), color.alpha()]
        };
        self.pixmap.pixels().iter().flat_map(straight).collect()
    }

    /// A blade from base to tip: two halves a little apart in brightness, a midrib and veins.
    pub(super) fn blade(&mut self, ends: [Vec2; 2], half_width: f32, outline: Outline, tone: f32) {
        let [base, tip] = ends;
        let along = tip - base;
        let across = along.perp().normalize_or_zero() * half_width;
        let edge = |share: f32, sign: f32| base + share * along + sign * outline(share) * across;
        let steps = (0..=BLADE_STEPS).map(|step| f32::from(step) / f32::from(BLADE_STEPS));
        for (sign, brightness) in [(1.0, 0.94), (-1.0, 1.06)] {
            let mut points = vec![base];
            points.extend(steps.clone().map(|share| edge(share, sign)));
            points.push(tip);
            let paint = self.paint(brightness * tone);
            self.fill(&points, &paint);
        }
        let rib = 0.04 * along.length();
        self.line(&[base, tip], 0.5 * rib, 1.25 * tone);
        for share in [0.2, 0.38, 0.56, 0.74] {
            for sign in [-1.0, 1.0] {
                let start = base + share * along;
                let end = start.lerp(edge(share + 0.14, sign), 0.85);
                self.line(&[start, end], 0.3 * rib, 1.12 * tone);
            }
        }
    }

    /// A stroke through points, `width` wide, with round ends.
    pub(super) fn line(&mut self, points: &[Vec2], width: f32, tone: f32) {
        let paint = self.paint(tone);
        self.stroke(points, width, &paint);
    }

    /// A stroke in another colour than the leaf's.
    pub(super) fn twig(&mut self, points: &[Vec2], width: f32, color: [u8; 3]) {
        let paint = paint_of(color);
        self.stroke(points, width, &paint);
    }

    fn paint(&self, tone: f32) -> Paint<'static> {
        paint_of(self.color.map(|channel| brightened(channel, tone)))
    }

    fn fill(&mut self, points: &[Vec2], paint: &Paint<'_>) {
        if let Some(path) = path_through(points) {
            let stretch = self.stretch();
            self.pixmap
                .fill_path(&path, paint, FillRule::Winding, stretch, None);
        }
    }

    fn stroke(&mut self, points: &[Vec2], width: f32, paint: &Paint<'_>) {
        let stroke = Stroke {
            width,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        if let Some(path) = path_through(points) {
            let stretch = self.stretch();
            self.pixmap
                .stroke_path(&path, paint, &stroke, stretch, None);
        }
    }

    /// From the leaf's measure to texels, which may be taller than wide on the leaf.
    fn stretch(&self) -> Transform {
        let side = self.side;
        Transform::from_row(side / self.width, 0.0, 0.0, -side, 0.5 * side, side)
    }
}

fn path_through(points: &[Vec2]) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (place, point) in points.iter().enumerate() {
        if place == 0 {
            builder.move_to(point.x, point.y);
        } else {
            builder.line_to(point.x, point.y);
        }
    }
    builder.finish()
}

/// Points on each side of a blade: teeth need several each.
const BLADE_STEPS: u16 = 72;

/// A point at a distance from another, in degrees from straight up, to the right.
pub(super) fn reach(from: Vec2, degrees: f32, length: f32) -> Vec2 {
    let (sine, cosine) = det::sin_cos(degrees.to_radians());
    from + length * Vec2::new(sine, cosine)
}

fn paint_of([red, green, blue]: [u8; 3]) -> Paint<'static> {
    let mut paint = Paint {
        anti_alias: true,
        ..Paint::default()
    };
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

fn brightened(channel: u8, tone: f32) -> u8 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to a byte's range first"
    )]
    let byte = (f32::from(channel) * tone).clamp(0.0, 255.0) as u8;
    byte
}
