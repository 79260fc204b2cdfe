//! Which rows to draw for a wanted number of strokes: fine shells outside, coarse ones inside.

use std::ops::Range;

use super::levels::StrokeLevels;

/// A combination of two neighbouring rows ([CQHCVL06](crate::references), section 5.2, figure 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extraction {
    /// The finer of the two rows; the other is the next.
    pub fine_row: u32,
    /// Shells before this one, the outer ones, are drawn from the finer row, the others from the next.
    pub switch: u32,
    /// How many strokes that makes.
    pub strokes: u32,
}

impl Extraction {
    /// The row that a shell is drawn from.
    #[must_use]
    pub fn row_of(self, shell: u32) -> u32 {
        self.fine_row + u32::from(shell >= self.switch)
    }

    /// What is drawn, as runs of [`StrokeLevels::strokes`], outermost shell first.
    pub fn runs(self, levels: &StrokeLevels) -> impl Iterator<Item = Range<u32>> + '_ {
        (0..levels.shells()).flat_map(move |shell| levels.node(self.row_of(shell), shell))
    }
}

/// The combination that comes nearest to a number of strokes, the coarser of two as near.
///
/// The two rows are those whose totals are around the number. As the switch moves inwards, shells gain
/// strokes one after another, so the number is missed by no more than half of what one shell gains.
/// More strokes than the first row has, or fewer than the last, are that row.
#[must_use]
pub fn extract(levels: &StrokeLevels, wanted: u32) -> Extraction {
    let totals = levels.totals();
    let last = levels.rows() - 1;
    let whole = |row: u32| Extraction {
        fine_row: row,
        switch: levels.shells(),
        strokes: totals[row as usize],
    };
    // The coarsest row that has as many; totals never rise from row to row.
    let finer = (0..=last).rev().find(|row| totals[*row as usize] >= wanted);
    let Some(fine_row) = finer else {
        return whole(0);
    };
    if fine_row == last {
        return whole(last);
    }
    let mut strokes = totals[fine_row as usize + 1];
    let mut best = Extraction {
        fine_row,
        switch: 0,
        strokes,
    };
    for shell in 0..levels.shells() {
        strokes += levels.node_count(fine_row, shell) - levels.node_count(fine_row + 1, shell);
        if strokes.abs_diff(wanted) < best.strokes.abs_diff(wanted) {
            best = Extraction {
                fine_row,
                switch: shell + 1,
                strokes,
            };
        }
    }
    best
}

/// How many strokes to ask for at a distance: all up to `full_distance`, then as the area falls that
/// the crown covers, with the square of the distance. The paper gives no law; this one keeps the
/// number of strokes to a pixel.
#[must_use]
pub fn strokes_at(all: u32, full_distance: f32, distance: f32) -> u32 {
    if distance <= full_distance {
        return all;
    }
    let share = f64::from(full_distance) / f64::from(distance);
    crate::math::whole_u32((f64::from(all) * (share * share)).round())
}

#[cfg(test)]
mod tests {
    use super::super::collapse::CollapseThresholds;
    use super::super::leaf::LeafStroke;
    use super::super::levels::LevelOptions;
    use super::super::shells::{ShellOptions, shells};
    use super::*;
    use crate::math::{Stream, Vec3};
    use crate::plant::Stroke;

    fn levels(seed: u64, inward: f32) -> StrokeLevels {
        let mut draws = Stream::new(seed, 5).draws();
        let mut vector = move || Vec3::new(draws.signed(), draws.signed(), draws.signed());
        let strokes: Vec<LeafStroke> = (0..900)
            .map(|leaf| {
                let along = 0.1 * vector().normalize_or(Vec3::X);
                let stroke = Stroke {
                    center: vector(),
                    along,
                    across: 0.5 * along.any_orthogonal_vector(),
                };
                LeafStroke {
                    stroke,
                    group: leaf % 2,
                    leaves: 1,
                }
            })
            .collect();
        let centers: Vec<Vec3> = strokes.iter().map(|leaf| leaf.stroke.center).collect();
        let shells = shells(
            &centers,
            ShellOptions {
                hulls: 7,
                core_percent: 10,
            },
        );
        let thresholds = [(1.2, 40.0), (2.4, 60.0), (4.8, 80.0)];
        let thresholds = thresholds.map(|(distance, angle)| CollapseThresholds { distance, angle });
        let options = LevelOptions {
            thresholds: thresholds.to_vec(),
            most_at_once: 6,
            inward,
        };
        StrokeLevels::new(&strokes, &shells, &options)
    }

    #[test]
    fn every_row_stands_for_every_leaf_once() {
        for inward in [0.0, 1.0] {
            let levels = levels(1, inward);
            for row in 0..levels.rows() {
                let mut leaves = 0;
                let mut strokes = 0;
                for shell in 0..levels.shells() {
                    for run in levels.node(row, shell) {
                        strokes += run.end - run.start;
                        let run = run.start as usize..run.end as usize;
                        leaves += levels.strokes()[run]
                            .iter()
                            .map(|leaf| leaf.leaves)
                            .sum::<u32>();
                    }
                    if row > 0 {
                        assert!(levels.node_count(row, shell) <= levels.node_count(row - 1, shell));
                    }
                }
                assert_eq!((leaves, strokes), (900, levels.totals()[row as usize]));
            }
            assert_eq!(levels.totals()[0], 900);
            assert!(
                levels.totals().is_sorted_by(|a, b| a > b),
                "{:?}",
                levels.totals()
            );
            assert!(levels.implicit_bytes() < levels.copied_bytes());
        }
    }

    #[test]
    fn wider_thresholds_inside_leave_fewer_strokes_there() {
        let [even, inward] = [0.0, 2.0].map(|inward| levels(2, inward));
        assert_eq!(even.node_count(1, 0), inward.node_count(1, 0));
        let core = even.shells() - 1;
        assert!(inward.node_count(1, core) < even.node_count(1, core));
    }

    #[test]
    fn extraction_comes_within_half_a_shell_and_is_never_coarser_outside() {
        let levels = levels(3, 0.5);
        let totals = levels.totals();
        let gain = |row, shell| levels.node_count(row, shell) - levels.node_count(row + 1, shell);
        let gains = (0..3).flat_map(|row| (0..levels.shells()).map(move |shell| (row, shell)));
        let largest = gains.map(|(row, shell)| gain(row, shell)).max().unwrap();
        for wanted in (0..1000).step_by(7) {
            let found = extract(&levels, wanted);
            let drawn: u32 = found.runs(&levels).map(|run| run.end - run.start).sum();
            assert_eq!(drawn, found.strokes);
            let rows = (0..levels.shells()).map(|shell| found.row_of(shell));
            assert!(rows.is_sorted(), "{found:?}");
            let clamped = wanted.clamp(totals[3], totals[0]);
            assert!(
                2 * found.strokes.abs_diff(clamped) <= largest,
                "{wanted}: {found:?}"
            );
        }
        for (row, total) in (0_u32..).zip(totals) {
            let found = extract(&levels, *total);
            assert_eq!(found.strokes, *total, "row {row} is met");
        }
    }

    #[test]
    fn strokes_fall_with_the_square_of_the_distance() {
        let found = [0.0, 10.0, 20.0, 1e9].map(|distance| strokes_at(8748, 10.0, distance));
        assert_eq!(found, [8748, 8748, 2187, 0]);
    }
}
