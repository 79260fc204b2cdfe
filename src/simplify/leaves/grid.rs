//! Which leaves lie near a point: a uniform grid that thins out with the foliage.

use crate::math::Vec3;

/// How many leaves a cell holds on average when a grid is built. Fewer make more empty cells to
/// walk over, more make more leaves to look at that are too far away.
const LEAVES_PER_CELL: f32 = 2.0;

/// Points with their leaves, by cells of equal size.
#[derive(Debug)]
pub(super) struct Grid {
    origin: Vec3,
    cell_size: f32,
    size: [usize; 3],
    cells: Vec<Vec<Site>>,
    count: usize,
    count_when_built: usize,
}

/// A leaf by what is known of its place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Site {
    /// The least coordinates of what distance is measured from.
    pub(super) low: Vec3,
    /// The greatest coordinates.
    pub(super) high: Vec3,
    pub(super) leaf: u32,
}

impl Site {
    /// The middle, which decides the cell.
    fn point(&self) -> Vec3 {
        0.5 * self.low + 0.5 * self.high
    }

    /// A distance that two leaves keep at least: how far the furthest side of a box moves.
    pub(super) fn least_distance(&self, other: &Self) -> f32 {
        let low = (self.low - other.low).abs();
        let high = (self.high - other.high).abs();
        low.max(high).max_element()
    }
}

impl Grid {
    /// A grid over the sites' box; later ones must lie within.
    pub(super) fn new(sites: &[Site]) -> Self {
        let mut grid = Self {
            origin: Vec3::ZERO,
            cell_size: 1.0,
            size: [1; 3],
            cells: Vec::new(),
            count: 0,
            count_when_built: 0,
        };
        grid.build(sites);
        grid
    }

    fn build(&mut self, sites: &[Site]) {
        let least = sites
            .iter()
            .fold(Vec3::INFINITY, |least, site| least.min(site.point()));
        let most = sites
            .iter()
            .fold(Vec3::NEG_INFINITY, |most, site| most.max(site.point()));
        let extent = most - least;
        let longest = extent.max_element();
        self.origin = least;
        (self.cell_size, self.size) = if longest > 0.0 {
            // Flat or thin foliage must not make cells beyond number.
            let solid = extent.max(Vec3::splat(longest / 256.0));
            let volume = (solid.x / longest) * (solid.y / longest) * (solid.z / longest);
            let cells = sites.len() as f32 / LEAVES_PER_CELL;
            let cell_size = longest * libm::cbrtf(volume / cells.max(1.0));
            let along = |length: f32| whole(length / cell_size) + 1;
            let size = [along(extent.x), along(extent.y), along(extent.z)];
            (cell_size, size)
        } else {
            (1.0, [1; 3])
        };
        self.cells.clear();
        self.cells
            .resize_with(self.size[0] * self.size[1] * self.size[2], Vec::new);
        self.count = 0;
        self.count_when_built = sites.len();
        for &site in sites {
            self.insert(site);
        }
    }

    /// How many leaves it holds.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// Adds a leaf.
    pub(super) fn insert(&mut self, site: Site) {
        let index = self.index(self.cell(site.point()));
        self.cells[index].push(site);
        self.count += 1;
    }

    /// Takes a leaf out that was added at this very point; widens the cells when most are gone.
    pub(super) fn remove(&mut self, site: Site) {
        let index = self.index(self.cell(site.point()));
        let cell = &mut self.cells[index];
        if let Some(place) = cell.iter().position(|other| other.leaf == site.leaf) {
            cell.swap_remove(place);
            self.count -= 1;
        }
        if 2 * self.count < self.count_when_built {
            let sites: Vec<Site> = self.cells.iter().flatten().copied().collect();
            self.build(&sites);
        }
    }

    /// Shows the cells of one shell around the cell of `site` that sites at a
    /// [least distance](Site::least_distance) within `reach` may lie in; `false` when neither this shell nor a later one has such cells.
    ///
    /// Shell 0 is the point's cell, shell `r` all at `r` steps by the longest axis.
    pub(super) fn visit_shell(
        &self,
        site: &Site,
        shell: usize,
        reach: f32,
        mut visit: impl FnMut(&[Site]),
    ) -> bool {
        let point = site.point();
        let center = self.cell(point);
        // A point outside the grid counts as the nearest inside: that brings no two points further
        // apart, so nothing within reach is missed.
        let low = self.cell(point - reach);
        let high = self.cell(point + reach);
        let may_hold =
            |axis: usize| center[axis] >= low[axis] + shell || center[axis] + shell <= high[axis];
        if !(0..3).any(may_hold) {
            return false;
        }
        let range = |axis: usize| {
            let first = center[axis].saturating_sub(shell).max(low[axis]);
            let last = (center[axis] + shell).min(high[axis]);
            first..=last
        };
        let outer = |axis: usize, at: usize| at.abs_diff(center[axis]) == shell;
        for z in range(2) {
            for y in range(1) {
                if outer(2, z) || outer(1, y) {
                    for x in range(0) {
                        visit(&self.cells[self.index([x, y, z])]);
                    }
                } else {
                    if center[0] >= low[0] + shell {
                        visit(&self.cells[self.index([center[0] - shell, y, z])]);
                    }
                    if center[0] + shell <= high[0] {
                        visit(&self.cells[self.index([center[0] + shell, y, z])]);
                    }
                }
            }
        }
        true
    }

    fn cell(&self, point: Vec3) -> [usize; 3] {
        let at = (point - self.origin) / self.cell_size;
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

/// The whole part of a number, 0 for less than that.
fn whole(value: f32) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates, and callers clamp"
    )]
    let whole = value as usize;
    whole
}
