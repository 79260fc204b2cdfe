//! How many edges a circle needs: comparisons with a table, no function of a float.

use crate::math::{det, index_u32};

/// The least edges of a polygon; fewer make a line.
pub const LEAST_EDGES: u32 = 3;

/// The most edges that a table goes up to: beyond, `P_h` is below 0.03 % of the radius.
pub const MOST_EDGES: u32 = 128;

/// From this share of the radius on an error makes a line of an internode: its diameter is no
/// longer than the error.
const LINE: f64 = 2.0;

/// The errors that polygons make, as shares of the radius, up to a greatest number of edges.
///
/// `P_h = 1 − cos(π/h)` is the sagitta of an edge ([ZBMJLDC17](crate::references), eq. 6). The paper's
/// eq. 7, a rounded quotient, stands on a knife's edge at every `P_h`, and eqs. 9 and 11 have gaps
/// for 4 and for `H` edges; here the number is the least whose `P_h` is no more than asked.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeTable {
    /// `P_3`, `P_4`, …, falling.
    sagittas: Vec<f64>,
}

/// How a circle is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edges {
    /// How many edges: 1 for a line, otherwise at least [`LEAST_EDGES`].
    pub count: u32,
    /// Whether more would be needed than the table has, so that the error is exceeded.
    pub clamped: bool,
}

impl EdgeTable {
    /// A table up to `most` edges (`H`), at least [`LEAST_EDGES`] and at most [`MOST_EDGES`].
    #[must_use]
    pub fn up_to(most: u32) -> Self {
        let edges = LEAST_EDGES..=most.clamp(LEAST_EDGES, MOST_EDGES);
        let sagitta = |edges: u32| 1.0 - det::cos_f64(std::f64::consts::PI / f64::from(edges));
        Self {
            sagittas: edges.map(sagitta).collect(),
        }
    }

    /// The most edges, `H`.
    #[must_use]
    pub fn most(&self) -> u32 {
        index_u32(self.sagittas.len()) + LEAST_EDGES - 1
    }

    /// The edges of a circle of this radius, both in metres (eq. 11, with its gaps closed).
    ///
    /// A point, of radius 0, is the end of a line at any error.
    #[must_use]
    pub fn edges(&self, radius: f32, error: f32) -> Edges {
        let (radius, error) = (f64::from(radius), f64::from(error).max(0.0));
        if error >= LINE * radius {
            return Edges {
                count: 1,
                clamped: false,
            };
        }
        let worse = self
            .sagittas
            .partition_point(|sagitta| sagitta * radius > error);
        let last = self.sagittas.len() - 1;
        Edges {
            count: index_u32(worse.min(last)) + LEAST_EDGES,
            clamped: worse > last,
        }
    }

    /// How far the middle of an edge lies from a circle of this radius, in metres: 0 for fewer than
    /// three edges, and for more than the table has that of its last.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a length again, rounded as lengths are"
    )]
    pub fn sagitta(&self, edges: u32, radius: f32) -> f32 {
        let Some(place) = edges.checked_sub(LEAST_EDGES) else {
            return 0.0;
        };
        let place = (place as usize).min(self.sagittas.len() - 1);
        (self.sagittas[place] * f64::from(radius)) as f32
    }
}

/// The number of edges that meets an error, as a share of the radius, exactly, were there parts of an
/// edge (eq. 8): the curve of which [`EdgeTable::edges`] are the steps above. For shares up to 2.
#[must_use]
pub fn fractional_edges(share: f64) -> f64 {
    std::f64::consts::PI / det::acos_f64((1.0 - share).clamp(-1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_papers_with_its_gaps_closed() {
        let table = EdgeTable::up_to(12);
        for (edges, wanted) in [
            (3, 0.5),
            (4, 0.292_893),
            (5, 0.190_983),
            (6, 0.133_975),
            (12, 0.034_074),
        ] {
            assert!((table.sagitta(edges, 1.0) - wanted).abs() < 1e-6);
        }
        let count = |error| table.edges(1.0, error).count;
        let wanted = [
            (2.0, 1),
            (1.999, 3),
            (0.5, 3),
            (0.499, 4),
            (0.2929, 4),
            (0.2928, 5),
            (0.0341, 12),
        ];
        for (error, edges) in wanted {
            assert_eq!(count(error), edges, "error {error}");
            assert!(!table.edges(1.0, error).clamped);
        }
        // Past the table, and at no error at all.
        for error in [0.034, 0.0, -1.0, f32::NAN] {
            let wanted = Edges {
                count: 12,
                clamped: true,
            };
            assert_eq!(table.edges(1.0, error), wanted, "error {error}");
        }
        assert_eq!(table.edges(0.0, 0.0).count, 1);
        assert_eq!(EdgeTable::up_to(0).most(), 3);
        assert_eq!(EdgeTable::up_to(u32::MAX).most(), MOST_EDGES);
    }

    #[test]
    fn steps_lie_above_their_curve() {
        let table = EdgeTable::up_to(64);
        for step in 1_u16..200 {
            let share = 0.0025 * f32::from(step);
            let curve = fractional_edges(f64::from(share));
            let edges = f64::from(table.edges(1.0, share).count);
            assert!(
                edges >= curve - 1e-9 && edges < curve + 1.0,
                "{share}: {edges}, {curve}"
            );
        }
        assert!((fractional_edges(2.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_threshold_itself_is_met_exactly() {
        // The very P_h: eq. 7 gives h + 1 for half of them.
        let table = EdgeTable::up_to(64);
        for edges in 3..=64 {
            let sagitta = 1.0 - det::cos_f64(std::f64::consts::PI / f64::from(edges));
            let error = table.sagitta(edges, 1.0);
            let found = table.edges(1.0, error).count;
            let wanted = if f64::from(error) >= sagitta {
                edges
            } else {
                edges + 1
            };
            assert_eq!(found, wanted.min(64));
        }
    }
}
