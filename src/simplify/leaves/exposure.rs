//! How much of each leaf is seen from outside of its crown.

use rayon::prelude::*;

use crate::math::{DVec3, det};

/// Cells of the grid for each leaf, about.
///
/// Coarser grids take a slim crown for an even haze; much finer ones do worse for few leaves.
const CELLS_PER_LEAF: f64 = 4.0;

/// Boxes are taken to be at least this share of their longest side thick, so that flat and thin
/// foliage has cells of a size.
const LEAST_THICKNESS: f64 = 1.0 / 1024.0;

/// Points a side of the lattice by which a leaf's area is dealt out to cells.
const LATTICE: u32 = 4;

/// The share of a leaf's rectangle through which nothing is seen.
///
/// Masks of leaves leave about half of their images clear, but 1 does better than 0.5: FLIP at half the
/// leaves falls by a tenth for birches and by a fifth for a mastic, as what is well hidden then comes
/// first more surely. 2 is worse for slim and for dense crowns.
const OPACITY: f64 = 1.0;

/// One of each pair of opposite directions through the faces, edges and corners of a cube: they lead
/// from the middle of a cell to that of another.
const AXES: [[i8; 3]; 13] = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 0],
    [1, -1, 0],
    [1, 0, 1],
    [1, 0, -1],
    [0, 1, 1],
    [0, 1, -1],
    [1, 1, 1],
    [1, 1, -1],
    [1, -1, 1],
    [1, -1, -1],
];

/// How much of each leaf is seen, the mean over 26 directions, all from outside: from about 1 where
/// nothing is before it down to 0 for what lies deep inside.
///
/// ```text
///  eye ───▶ ┌───┬───┬───┬───┐   light that gets to a cell: e^−(τ of the cells before, and half its own)
///           │τ₀ │τ₁ │ ▰ │τ₃ │   τ = area of leaves in the cell · opacity · ½ · way / volume
///           └───┴───┴───┴───┘
/// ```
///
/// Leaves are taken for a haze in the cells of a grid, of which half the area is turned to the eye, as
/// foliage is in Beer's law ([MS53](crate::references)); only a leaf's own turn counts as it is. So
/// one exposure says what is seen of a leaf on the average of many like it, not whether a certain leaf
/// hides behind another. Two sweeps over the grid for each axis: linear in the number of leaves.
pub(super) fn exposures(leaves: &[[DVec3; 4]]) -> Vec<f32> {
    let Some(haze) = Haze::of(leaves) else {
        return vec![1.0; leaves.len()];
    };
    let seen: Vec<Vec<f32>> = AXES
        .par_iter()
        .map(|&axis| haze.seen_along(axis, leaves))
        .collect();
    // Turned at random, a leaf shows half of itself.
    let mean = 2.0 / (2 * AXES.len()) as f32;
    let of_leaf = |leaf: usize| mean * seen.iter().fold(0.0, |sum, seen| sum + seen[leaf]);
    (0..leaves.len()).map(of_leaf).collect()
}

/// A crown as a grid of haze.
#[derive(Debug)]
struct Haze {
    low: DVec3,
    /// The side of a cell.
    side: f64,
    counts: [usize; 3],
    /// What a way as long as a side through a cell takes of the light: `τ`.
    depths: Vec<f32>,
}

impl Haze {
    /// `None` when all leaves are in one point, or there are none.
    fn of(leaves: &[[DVec3; 4]]) -> Option<Self> {
        let points = || leaves.iter().flatten().copied();
        let low = points().fold(DVec3::INFINITY, DVec3::min);
        let extent = points().fold(DVec3::NEG_INFINITY, DVec3::max) - low;
        let longest = extent.max_element();
        if leaves.is_empty() || longest <= 0.0 {
            return None;
        }
        let solid = extent.max(DVec3::splat(LEAST_THICKNESS * longest));
        let wanted = CELLS_PER_LEAF * leaves.len() as f64;
        let side = libm::cbrt(solid.x / wanted) * libm::cbrt(solid.y) * libm::cbrt(solid.z);
        let mut haze = Self {
            low,
            side,
            counts: [0, 1, 2].map(|axis| whole(extent[axis] / side) + 1),
            depths: Vec::new(),
        };
        let mut areas = vec![0.0_f64; haze.counts.iter().product()];
        let share = 1.0 / f64::from(LATTICE * LATTICE);
        for &[a, b, c, d] in leaves {
            let area = 0.5 * (c - a).cross(d - b).length();
            for point in 0..LATTICE * LATTICE {
                let along = |step: u32| (f64::from(step) + 0.5) / f64::from(LATTICE);
                let (u, v) = (along(point % LATTICE), along(point / LATTICE));
                let at = (1.0 - v) * ((1.0 - u) * a + u * b) + v * ((1.0 - u) * d + u * c);
                areas[haze.cell(at)] += share * area;
            }
        }
        let of_area = |area: &f64| single(0.5 * OPACITY * (area / side / side));
        haze.depths = areas.iter().map(of_area).collect();
        Some(haze)
    }

    /// The number of the cell of a point in the box.
    fn cell(&self, point: DVec3) -> usize {
        let at = (point - self.low) / self.side;
        let [x, y, z] = [0, 1, 2].map(|axis| whole(at[axis]).min(self.counts[axis] - 1));
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    /// What is seen of each leaf from both ends of an axis: its turn towards them times the light that
    /// gets there, added.
    fn seen_along(&self, axis: [i8; 3], leaves: &[[DVec3; 4]]) -> Vec<f32> {
        let light = self.light_from(axis);
        let back = self.light_from(axis.map(|step| -step));
        let [x, y, z] = axis.map(f64::from);
        let direction = DVec3::new(x, y, z).normalize();
        let seen = |&[a, b, c, d]: &[DVec3; 4]| {
            let cell = self.cell(0.25 * ((a + b) + (c + d)));
            let normal = (c - a).cross(d - b).normalize_or_zero();
            single(normal.dot(direction).abs()) * (light[cell] + back[cell])
        };
        leaves.iter().map(seen).collect()
    }

    /// The share of the light that gets to the middle of each cell from far away in a direction.
    fn light_from(&self, direction: [i8; 3]) -> Vec<f32> {
        let squares: f64 = direction.iter().map(|&step| f64::from(step * step)).sum();
        let way = single(squares.sqrt());
        let [across, up, deep] = self.counts;
        let mut before = vec![0.0_f32; self.depths.len()];
        for z in ordered(deep, direction[2]) {
            let from_z = next(z, direction[2], deep);
            for y in ordered(up, direction[1]) {
                let from_y = next(y, direction[1], up);
                let row = (z * up + y) * across;
                let (Some(from_z), Some(from_y)) = (from_z, from_y) else {
                    continue;
                };
                let from_row = (from_z * up + from_y) * across;
                for x in ordered(across, direction[0]) {
                    if let Some(from_x) = next(x, direction[0], across) {
                        let from = from_row + from_x;
                        before[row + x] = before[from] + way * self.depths[from];
                    }
                }
            }
        }
        let cells = before.iter().zip(&self.depths);
        let light = |(before, depth): (&f32, &f32)| det::exp(-(before + 0.5 * way * depth));
        cells.map(light).collect()
    }
}

/// The numbers below `count`, those first that lie furthest in the direction of `step`.
fn ordered(count: usize, step: i8) -> impl Iterator<Item = usize> {
    (0..count).map(move |place| if step > 0 { count - 1 - place } else { place })
}

/// The neighbour in the direction of `step`, if there is one.
fn next(place: usize, step: i8, count: usize) -> Option<usize> {
    let next = place.checked_add_signed(isize::from(step))?;
    (next < count).then_some(next)
}

/// The whole part of a number that is not negative.
fn whole(value: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates, and a box has about as many cells as wanted, at most 1024 a side for each leaf"
    )]
    let whole = value as usize;
    whole
}

/// Rounds to `f32`, to the largest finite number at most.
fn single(value: f64) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "rounds, and is clamped")]
    let rounded = value.min(f64::from(f32::MAX)) as f32;
    rounded
}

#[cfg(test)]
mod tests {
    use super::*;

    fn haze(counts: [usize; 3], depths: Vec<f32>) -> Haze {
        Haze {
            low: DVec3::ZERO,
            side: 1.0,
            counts,
            depths,
        }
    }

    /// Holds light against the sums of depths before it.
    fn assert_faded(light: &[f32], before: &[f32]) {
        let wanted: Vec<f32> = before.iter().map(|&sum| det::exp(-sum)).collect();
        let pairs = light.iter().zip(&wanted);
        assert!(
            pairs
                .clone()
                .all(|(light, wanted)| (light - wanted).abs() < 1e-6),
            "{light:?}, wanted {wanted:?}"
        );
        assert_eq!(light.len(), wanted.len());
    }

    #[test]
    fn light_fades_by_all_cells_before_and_half_its_own() {
        let column = haze([1, 1, 3], vec![1.0, 2.0, 4.0]);
        assert_faded(&column.light_from([0, 0, 1]), &[6.5, 5.0, 2.0]);
        assert_faded(&column.light_from([0, 0, -1]), &[0.5, 2.0, 5.0]);
        assert_faded(&column.light_from([1, 0, 0]), &[0.5, 1.0, 2.0]);
    }

    /// ```text
    /// z 1 │ 3 4
    ///   0 │ 1 2
    ///     └────
    ///   x   0 1
    /// ```
    #[test]
    fn ways_through_corners_are_longer() {
        let square = haze([2, 1, 2], vec![1.0, 2.0, 3.0, 4.0]);
        let before = [4.5, 1.0, 1.5, 2.0].map(|sum| 2.0_f32.sqrt() * sum);
        assert_faded(&square.light_from([1, 0, 1]), &before);
    }

    /// Squares of side 1 at whole places, turned along three axes in turn.
    fn block(side: u8) -> Vec<[DVec3; 4]> {
        let places = 0..u32::from(side).pow(3);
        let square = |place: u32| {
            let side = u32::from(side);
            let at = [place % side, place / side % side, place / side / side].map(f64::from);
            let (u, v) = [
                (DVec3::X, DVec3::Y),
                (DVec3::Y, DVec3::Z),
                (DVec3::Z, DVec3::X),
            ][place as usize % 3];
            let at = DVec3::from_array(at) - 0.5 * (u + v);
            [at, at + u, at + u + v, at + v]
        };
        places.map(square).collect()
    }

    #[test]
    fn what_lies_inside_is_seen_less_at_any_scale() {
        let leaves = block(9);
        let seen = exposures(&leaves);
        let middle = seen[9 * 9 * 4 + 9 * 4 + 4];
        assert!(middle < 0.2 * seen[0], "{middle} of {}", seen[0]);
        let scaled = exposures(
            &leaves
                .iter()
                .map(|leaf| leaf.map(|at| 1e30 * at))
                .collect::<Vec<_>>(),
        );
        for (one, other) in seen.iter().zip(scaled) {
            assert!((one - other).abs() < 1e-3, "{one} and {other}");
        }
    }

    #[test]
    fn leaves_in_one_point_are_all_seen() {
        assert_eq!(exposures(&[]), Vec::<f32>::new());
        assert_eq!(exposures(&[[DVec3::ONE; 4]; 3]), [1.0; 3]);
    }
}
