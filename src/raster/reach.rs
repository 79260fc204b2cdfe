//! Where something may show, from what is known before it is made.

use super::frame::BLOCK_SIDE;
use super::source::Hull;
use super::view::{PixelBox, SUBPIXELS, View};
use super::{Topology, setup};

/// The pixels that primitives may cover, and how near they may be there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reach {
    pub(super) pixels: PixelBox,
    /// No sample that is covered is nearer; at least 0.
    pub(super) nearest: f32,
}

impl Reach {
    /// What two reach together.
    pub(super) fn and(self, other: Self) -> Self {
        let [a, b] = [self.pixels, other.pixels];
        Self {
            pixels: PixelBox {
                first: [0, 1].map(|axis| a.first[axis].min(b.first[axis])),
                last: [0, 1].map(|axis| a.last[axis].max(b.last[axis])),
            },
            nearest: self.nearest.min(other.nearest),
        }
    }
}

/// What is there already on a tile of a target with one sample a pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cover<'a> {
    /// The pixels of the tile.
    pub(super) pixels: PixelBox,
    /// The first pixel of the block.
    pub(super) origin: [i32; 2],
    /// The depths of the block.
    pub(super) depth: &'a [u32],
    /// Whether what is made is for this tile alone, so that what lies beside it need not be.
    pub(super) alone: bool,
}

impl Cover<'_> {
    /// Whether what is there in a pixel is nearer; where it lies beside the tile, whether that is nothing to
    /// it.
    #[inline(always)]
    pub(super) fn hides_pixel(&self, at: [i32; 2], nearest: f32) -> bool {
        let Self { pixels, origin, .. } = self;
        let within = |axis: usize| at[axis] >= pixels.first[axis] && at[axis] <= pixels.last[axis];
        if !within(0) || !within(1) {
            return self.alone;
        }
        let place = [0, 1].map(|axis| (at[axis] - origin[axis]).unsigned_abs());
        let depth = self.depth.get((place[1] * BLOCK_SIDE + place[0]) as usize);
        depth.is_some_and(|&depth| depth < nearest.max(0.0).to_bits())
    }

    /// Whether all that is there in some pixels is nearer, as far as the tile is asked.
    #[inline(always)]
    pub(super) fn hides(&self, pixels: PixelBox, nearest: f32) -> bool {
        match self.pixels.meet(pixels) {
            Some(met) if self.alone || met == pixels => self.hides_within(met, nearest),
            Some(_) => false,
            None => self.alone,
        }
    }

    /// The same of pixels that lie within the tile.
    #[inline(always)]
    pub(super) fn hides_within(&self, pixels: PixelBox, nearest: f32) -> bool {
        let nearest = nearest.max(0.0).to_bits();
        let side = BLOCK_SIDE as usize;
        let column = (pixels.first[0] - self.origin[0]).unsigned_abs() as usize;
        let row = (pixels.first[1] - self.origin[1]).unsigned_abs() as usize;
        let mut first = row * side + column;
        let right = (pixels.last[0] - pixels.first[0]).unsigned_abs() as usize;
        let down = (pixels.last[1] - pixels.first[1]).unsigned_abs() as usize;
        if right | down <= 1 {
            // Without a branch: all four, some of them the same.
            let Some(depth) = self.depth.get(first..=first + right + down * side) else {
                return false;
            };
            let [a, b] = [depth[0], depth[right]];
            let [c, d] = [depth[down * side], depth[right + down * side]];
            return a.max(b).max(c.max(d)) < nearest;
        }
        for _ in 0..=down {
            for &depth in &self.depth[first..=first + right] {
                if depth >= nearest {
                    return false;
                }
            }
            first += side;
        }
        true
    }
}

/// Below this `w` a hull may lie behind the eye, where projecting its corners says nothing.
pub(super) const LEAST_W: f64 = 1e-6;

/// More sub-pixels than snapping and `f64` move a vertex.
pub(super) const SNAP: f64 = 2.0;

impl View {
    /// Where the vertices within a hull may show; `None` for nowhere.
    ///
    /// Projected, a box lies between its projected corners as long as all lie before the eye, and a
    /// quotient whose terms are off by so much is greatest or least at a corner too.
    pub(super) fn reach(&self, hull: &Hull, topology: Topology) -> Option<Reach> {
        let anywhere = Reach {
            pixels: self.shown(),
            nearest: 0.0,
        };
        let [mut least, mut greatest] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        let (mut nearest, mut farthest, mut outermost_w) =
            (f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY);
        let mut before_the_eye = true;
        let [slack_x, slack_y, slack_z, slack_w] = hull.slack;
        for corner in 0..8 {
            let point: [f64; 3] =
                std::array::from_fn(|axis| hull.corners[corner >> axis & 1][axis]);
            let [x, y, z, w]: [f64; 4] = std::array::from_fn(|row| {
                let [a, b, c, d] = hull.clip.map(|column| column[row]);
                a * point[0] + b * point[1] + c * point[2] + d
            });
            outermost_w = outermost_w.max(w + slack_w);
            // Not `<=`: what is no number may be anywhere.
            before_the_eye &= w - slack_w > LEAST_W;
            let [small, large] = [1.0 / (w + slack_w), 1.0 / (w - slack_w)];
            let up = |value: f64| value * if value > 0.0 { large } else { small };
            let down = |value: f64| value * if value > 0.0 { small } else { large };
            for (axis, (at, slack)) in [(x, slack_x), (y, slack_y)].into_iter().enumerate() {
                least[axis] = least[axis].min(down(at - slack));
                greatest[axis] = greatest[axis].max(up(at + slack));
            }
            nearest = nearest.min(down(z - slack_z));
            farthest = farthest.max(up(z + slack_z));
        }
        if outermost_w < 0.0 {
            return None;
        }
        let numbers = [least, greatest].concat();
        if !before_the_eye || !numbers.iter().all(|number| number.is_finite()) {
            return Some(anywhere);
        }
        if nearest > 1.0 + f64::from(setup::DEPTH_ERROR) || farthest < 0.0 {
            return None;
        }
        // A line is half a pixel wider on each side than the vertices that it joins.
        let more = SNAP
            + match topology {
                Topology::LineList => f64::from(SUBPIXELS),
                Topology::TriangleList | Topology::QuadList => 0.0,
            };
        let [width, height] = self.half();
        let x = [least[0], greatest[0]].map(|x| width + x * width);
        let y = [greatest[1], least[1]].map(|y| height - y * height);
        let rim =
            |[from, to]: [f64; 2]| [super::view::snap(from - more), super::view::snap(to + more)];
        Some(Reach {
            pixels: self.pixels(rim(x), rim(y))?,
            nearest: below(nearest),
        })
    }
}

/// A depth that is less, by more than rounding to `f32` and across a triangle moves it.
#[expect(
    clippy::cast_possible_truncation,
    reason = "rounds by less than what was taken off before"
)]
fn below(depth: f64) -> f32 {
    (depth - 2.0 * f64::from(setup::DEPTH_ERROR)).max(0.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Samples;

    const IDENTITY: [[f64; 4]; 4] = [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ];

    fn reach(corners: [[f64; 3]; 2], clip: [[f64; 4]; 4], slack: f64) -> Option<Reach> {
        let view = View::new(64, 32, Samples::One);
        let slack = [slack; 4];
        view.reach(
            &Hull {
                corners,
                clip,
                slack,
            },
            Topology::QuadList,
        )
    }

    #[test]
    fn a_box_shows_where_its_corners_do() {
        let found = reach([[-0.5, -0.5, 0.25], [0.5, 0.75, 0.5]], IDENTITY, 0.0);
        let found = found.expect("it lies in the middle");
        assert_eq!(found.pixels.first, [16, 4]);
        assert_eq!(found.pixels.last, [47, 23]);
        assert!(found.nearest < 0.25 && found.nearest > 0.249_99);
        let slack = reach([[-0.5, -0.5, 0.25], [0.5, 0.75, 0.5]], IDENTITY, 0.125);
        let wider = slack.expect("it lies in the middle");
        assert!(wider.pixels.first[0] < 12 && wider.nearest < 0.125);
    }

    #[test]
    fn what_is_beside_before_or_behind_shows_nowhere() {
        for corners in [
            [[1.5, 0.0, 0.5], [2.0, 0.0, 0.5]],
            [[0.0, -3.0, 0.5], [0.0, -1.5, 0.5]],
            [[0.0, 0.0, 1.5], [0.0, 0.0, 2.0]],
            [[0.0, 0.0, -1.5], [0.0, 0.0, -0.5]],
        ] {
            assert_eq!(reach(corners, IDENTITY, 0.0), None, "{corners:?}");
        }
        // w = z: a box around the eye may be anywhere, one behind it nowhere.
        let mut clip = IDENTITY;
        clip[2][3] = 1.0;
        clip[3][3] = 0.0;
        let around = reach([[-1.0; 3], [1.0; 3]], clip, 0.0).expect("around the eye");
        assert_eq!(around.pixels.last, [63, 31]);
        assert_eq!(around.nearest, 0.0);
        assert_eq!(
            reach([[-1.0, -1.0, -2.0], [1.0, 1.0, -1.0]], clip, 0.0),
            None
        );
        let absurd = reach([[f64::NAN; 3], [1.0; 3]], IDENTITY, 0.0);
        assert_eq!(absurd.map(|found| found.nearest), Some(0.0));
    }
}
