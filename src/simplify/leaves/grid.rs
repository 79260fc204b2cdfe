//! Which leaves lie near a leaf: a uniform grid that widens as the foliage thins out.

use super::shape::Shape;
use crate::math::{DVec3, Vec3};

/// How many leaves a cell holds on average over the box when a grid is built.
///
/// Fewer make more empty cells to walk over, more make more leaves to look at that are too far away;
/// crowns leave most of their box empty.
const LEAVES_PER_CELL: f64 = 4.0;

/// A leaf and where it lies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Site {
    /// The least coordinates of what distance is measured from.
    pub(super) low: Vec3,
    /// The greatest coordinates.
    pub(super) high: Vec3,
    /// The leaf's number.
    pub(super) leaf: u32,
    /// The leaf itself: beside its place, it need not be fetched from elsewhere.
    pub(super) shape: Shape,
}

impl Site {
    /// A distance that two leaves keep at least: how far the furthest side of a box moves.
    pub(super) fn least_distance(&self, other: &Self) -> f32 {
        let low = (self.low - other.low).abs();
        let high = (self.high - other.high).abs();
        low.max(high).max_element()
    }

    /// The middle, which decides the cell. Middles are no further apart along any axis than the
    /// [least distance](Self::least_distance).
    fn middle(&self) -> DVec3 {
        0.5 * self.low.as_dvec3() + 0.5 * self.high.as_dvec3()
    }
}

/// Leaves by cells of equal size.
#[derive(Debug)]
pub(super) struct Grid {
    origin: DVec3,
    cell_size: f64,
    size: [usize; 3],
    cells: Vec<Vec<Site>>,
    count: usize,
    count_when_built: usize,
}

impl Grid {
    /// A grid over the middles' box.
    pub(super) fn new(sites: &[Site]) -> Self {
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for site in sites {
            low = low.min(site.middle());
            high = high.max(site.middle());
        }
        let extent = high - low;
        let longest = extent.max_element();
        let (origin, cell_size, size) = if longest > 0.0 {
            // Flat or thin foliage must not make cells beyond number.
            let solid = extent.max(DVec3::splat(longest / 256.0));
            let cells = (sites.len() as f64 / LEAVES_PER_CELL).max(1.0);
            let cell_size = libm::cbrt(solid.x / cells) * libm::cbrt(solid.y) * libm::cbrt(solid.z);
            let along = |length: f64| whole(length / cell_size) + 1;
            let size = [along(extent.x), along(extent.y), along(extent.z)];
            (low, cell_size, size)
        } else {
            (DVec3::ZERO, 1.0, [1; 3])
        };
        let mut grid = Self {
            origin,
            cell_size,
            size,
            cells: vec![Vec::new(); size[0] * size[1] * size[2]],
            count: 0,
            count_when_built: sites.len(),
        };
        for &site in sites {
            grid.insert(site);
        }
        grid
    }

    /// Adds a leaf, which may lie outside the box.
    pub(super) fn insert(&mut self, site: Site) {
        let index = self.index(self.cell(site.middle()));
        self.cells[index].push(site);
        self.count += 1;
    }

    /// Takes a leaf out; widens the cells when half are gone.
    pub(super) fn remove(&mut self, site: &Site) {
        let index = self.index(self.cell(site.middle()));
        let cell = &mut self.cells[index];
        if let Some(place) = cell.iter().position(|other| other.leaf == site.leaf) {
            cell.swap_remove(place);
            self.count -= 1;
        }
        if 2 * self.count < self.count_when_built {
            let sites: Vec<Site> = self.cells.iter().flatten().copied().collect();
            *self = Self::new(&sites);
        }
    }

    /// Shows the cells of one shell around the cell of `site`, without those where all leaves are
    /// beyond `reach` by [`Site::least_distance`]; `false` when no cell of this shell or a later one
    /// is left.
    ///
    /// Shell 0 is the site's cell, shell `r` all at `r` steps by the longest axis.
    pub(super) fn visit_shell(
        &self,
        site: &Site,
        shell: usize,
        reach: f32,
        mut visit: impl FnMut(&[Site]),
    ) -> bool {
        let middle = site.middle();
        let center = self.cell(middle);
        // A place outside the box counts as the nearest inside: that takes no two places further
        // apart, so nothing within reach is missed.
        let low = self.cell(middle - f64::from(reach));
        let high = self.cell(middle + f64::from(reach));
        let goes_on = (0..3)
            .any(|axis| center[axis] >= low[axis] + shell || center[axis] + shell <= high[axis]);
        if !goes_on {
            return false;
        }
        let range = |axis: usize| {
            let first = center[axis].saturating_sub(shell).max(low[axis]);
            let last = (center[axis] + shell).min(high[axis]);
            first..=last
        };
        let is_outer = |axis: usize, at: usize| at.abs_diff(center[axis]) == shell;
        for z in range(2) {
            for y in range(1) {
                if is_outer(2, z) || is_outer(1, y) {
                    for x in range(0) {
                        visit(&self.cells[self.index([x, y, z])]);
                    }
                    continue;
                }
                if center[0] >= low[0] + shell {
                    visit(&self.cells[self.index([center[0] - shell, y, z])]);
                }
                if center[0] + shell <= high[0] {
                    visit(&self.cells[self.index([center[0] + shell, y, z])]);
                }
            }
        }
        true
    }

    fn cell(&self, place: DVec3) -> [usize; 3] {
        let at = (place - self.origin) / self.cell_size;
        [
            whole(at.x).min(self.size[0] - 1),
            whole(at.y).min(self.size[1] - 1),
            whole(at.z).min(self.size[2] - 1),
        ]
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.size[1] + y) * self.size[0] + x
    }
}

/// The whole part of a number; 0 for what is less.
fn whole(value: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates, and callers clamp"
    )]
    let whole = value as usize;
    whole
}
