//! Clusters of leaves between nested hulls.

use super::peel::{PeelUntil, peel};
use crate::math::{Vec3, index_u32};

/// How many shells, and where they end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShellOptions {
    /// How many hulls are kept, at least 1.
    pub hulls: u32,
    /// The innermost of them is the smallest that holds at least so many percent of the points, its
    /// own corners counted.
    pub core_percent: u32,
}

impl ShellOptions {
    /// 35 hulls down to a tenth of the leaves ([CQHCVL06](crate::references), sections 3.2 and 4.1).
    pub const PUBLISHED: Self = Self {
        hulls: 35,
        core_percent: 10,
    };
}

/// Points by the hulls between which they lie.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shells {
    /// How many hulls were asked for; where fewer could be peeled, all are used, and
    /// [`hulls`](Self::hulls) has fewer.
    pub asked: u32,
    /// The place of each kept hull among all that were peeled, 0 the largest.
    pub hulls: Vec<u32>,
    /// One list a shell, outermost first, of point numbers, ascending: what lies within a hull, its
    /// corners included, and not within the next. The last shell is all that the last hull holds.
    pub points: Vec<Vec<u32>>,
}

/// Parts points into shells.
///
/// Of the hulls `0..=m` that [`peel`] finds down to the core, hull `i` of `n` is number
/// `i·m / (n − 1)`, rounded: equally spaced from the largest to the smallest, both included. `n` hulls
/// make `n` shells, since the core counts as one. Points that are too few for any hull are one shell.
///
/// # Panics
///
/// When a coordinate is not finite; a [`Plant`](crate::plant::Plant)'s are.
#[must_use]
pub fn shells(points: &[Vec3], options: ShellOptions) -> Shells {
    let peeling = peel(points, PeelUntil::Percent(options.core_percent));
    let smallest = index_u32(peeling.layers.len().saturating_sub(1));
    let hulls = spaced(smallest, options.hulls.max(1));
    let mut layers = (0_u32..).zip(peeling.layers).peekable();
    let mut shells: Vec<Vec<u32>> = Vec::new();
    for place in 0..hulls.len() {
        let end = hulls.get(place + 1).copied().unwrap_or(u32::MAX);
        let mut shell = Vec::new();
        while let Some((_, layer)) = layers.next_if(|(layer, _)| *layer < end) {
            shell.extend(layer);
        }
        shells.push(shell);
    }
    let core = shells.last_mut().expect("there is at least one hull");
    core.extend(peeling.rest);
    for shell in &mut shells {
        shell.sort_unstable();
    }
    Shells {
        asked: options.hulls,
        hulls,
        points: shells,
    }
}

/// `wanted` numbers from 0 to `last`, equally spaced; all of them where there are no more.
fn spaced(last: u32, wanted: u32) -> Vec<u32> {
    if last < wanted {
        return (0..=last).collect();
    }
    let gaps = u64::from(wanted - 1);
    let place = |hull: u32| match gaps {
        0 => 0,
        gaps => (u64::from(hull) * u64::from(last) + gaps / 2) / gaps,
    };
    let places = (0..wanted).map(place);
    places
        .map(|place| u32::try_from(place).expect("no place is past the last"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::grid::Grid;
    use super::super::hull::HullFinder;
    use super::*;
    use crate::math::Stream;

    pub(crate) fn ball(count: usize, seed: u64) -> Vec<Vec3> {
        let mut draws = Stream::new(seed, 3).draws();
        let mut points = Vec::new();
        while points.len() < count {
            let point = Vec3::new(draws.signed(), draws.signed(), draws.signed());
            if point.length_squared() < 1.0 {
                points.push(10.0 * point);
            }
        }
        points
    }

    #[test]
    fn hulls_are_spaced_from_the_largest_to_the_smallest() {
        assert_eq!(spaced(8, 5), [0, 2, 4, 6, 8]);
        assert_eq!(spaced(9, 4), [0, 3, 6, 9]);
        assert_eq!(spaced(3, 4), [0, 1, 2, 3]);
        assert_eq!(spaced(2, 35), [0, 1, 2]);
        assert_eq!(spaced(7, 1), [0]);
        assert_eq!(spaced(0, 35), [0]);
    }

    #[test]
    fn the_core_holds_a_tenth_and_the_next_hull_would_not() {
        let points = ball(3000, 1);
        let shells = shells(&points, ShellOptions::PUBLISHED);
        assert!(shells.points.len() <= 35, "{:?}", shells.hulls);
        let core = *shells.hulls.last().unwrap() as usize;
        let all = peel(&points, PeelUntil::Over);
        let within =
            |hull: usize| points.len() - all.layers[..hull].iter().map(Vec::len).sum::<usize>();
        assert!(within(core) >= 300, "{}", within(core));
        assert!(within(core + 1) < 300, "{}", within(core + 1));
        assert_eq!(shells.points.last().unwrap().len(), within(core));
    }

    #[test]
    fn shells_part_the_points_and_lie_within_the_hulls_before_them() {
        for seed in 0..4 {
            let mut points = ball(400, seed);
            // Half of the clouds lie on a lattice, so that faces hold many points, and copies abound.
            if seed % 2 == 1 {
                points
                    .iter_mut()
                    .for_each(|point| *point = (0.3 * *point).round());
            }
            let options = ShellOptions {
                hulls: 5,
                core_percent: 10,
            };
            let shells = shells(&points, options);
            let mut all: Vec<u32> = shells.points.concat();
            all.sort_unstable();
            assert_eq!(all, (0..400).collect::<Vec<u32>>());
            let grid = Grid::new(&points);
            let mut place = vec![0; points.len()];
            for point in 0..index_u32(grid.len()) {
                for &original in grid.originals(point) {
                    place[original as usize] = point;
                }
            }
            let places = |shell: &[u32]| -> Vec<u32> {
                let mut places: Vec<u32> =
                    shell.iter().map(|point| place[*point as usize]).collect();
                places.sort_unstable();
                places.dedup();
                places
            };
            let mut finder = HullFinder::new(&grid);
            for pair in shells.points.windows(2) {
                let around = finder.triangles(&places(&pair[0]));
                assert!(!around.is_empty(), "seed {seed}");
                for point in places(&pair[1]) {
                    let inside = around
                        .iter()
                        .all(|corners| grid.side(*corners, point).is_le());
                    assert!(inside, "seed {seed}: {point}");
                }
            }
        }
    }

    #[test]
    fn sets_without_space_have_shells_too() {
        let line: Vec<Vec3> = (0..20_u8)
            .map(|x| Vec3::new(f32::from(x), 0.0, 0.0))
            .collect();
        let found = shells(
            &line,
            ShellOptions {
                hulls: 3,
                core_percent: 10,
            },
        );
        // Ten pairs of ends less the last, which is the hull that holds exactly a tenth.
        assert_eq!(found.hulls, [0, 4, 8]);
        assert_eq!(found.points[2], [8, 9, 10, 11]);
        let same = shells(&[Vec3::ONE; 50], ShellOptions::PUBLISHED);
        assert_eq!((same.asked, same.points.len()), (35, 1));
        assert_eq!(same.points[0].len(), 50);
        let none = shells(&[], ShellOptions::PUBLISHED);
        assert_eq!(none.points, [[0_u32; 0]]);
        let square: Vec<Vec3> = (0..100_u8)
            .map(|at| Vec3::new(f32::from(at % 10), 2.0, f32::from(at / 10)))
            .collect();
        let flat = shells(
            &square,
            ShellOptions {
                hulls: 4,
                core_percent: 0,
            },
        );
        assert_eq!(
            flat.points[0].len() % 4,
            0,
            "corners of a square, and copies of them"
        );
        assert_eq!(flat.points.concat().len(), 100);
    }
}
