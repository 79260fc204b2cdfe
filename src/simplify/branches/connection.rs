//! How two polygons with different numbers of edges are joined: a table made once.

use super::edges::LEAST_EDGES;
use crate::math::det;

/// One side of a prismoid: corners of the polygon with fewer edges, and of the one with more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// From edge to edge: the first corners of both; each edge goes on to the next corner.
    Quad {
        /// Of the polygon with fewer edges.
        few: u32,
        /// Of the one with more.
        many: u32,
    },
    /// From an edge of the polygon with more edges to a corner of the other.
    Triangle {
        /// The corner.
        few: u32,
        /// The edge's first corner.
        many: u32,
    },
}

/// The sides between two polygons, in the order of their angles.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Connection {
    /// As many quads as the one polygon has edges, and a triangle for each edge that the other has
    /// more.
    pub(super) sides: Vec<Side>,
    /// The greatest angle, in radians, between a corner of the polygon with more edges and the
    /// corner that it is joined with.
    pub(super) offset: f32,
    /// How much more than at the corners the angles between two joined edges may differ, in radians:
    /// see [`slack`].
    pub(super) slack: f32,
}

/// The connections of all pairs of polygons up to a greatest number of edges.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ConnectionTable {
    most: u32,
    connections: Vec<Connection>,
}

impl ConnectionTable {
    /// All pairs of 3 to `most` edges.
    pub(super) fn up_to(most: u32) -> Self {
        let most = most.max(LEAST_EDGES);
        let pairs = (LEAST_EDGES..=most)
            .flat_map(|many| (LEAST_EDGES..=many).map(move |few| connection(few, many)));
        Self {
            most,
            connections: pairs.collect(),
        }
    }

    /// The connection of two polygons, the one with fewer edges first; edges beyond the table
    /// count as its most.
    pub(super) fn between(&self, few: u32, many: u32) -> &Connection {
        let row = many.clamp(LEAST_EDGES, self.most) - LEAST_EDGES;
        let column = (few.clamp(LEAST_EDGES, self.most) - LEAST_EDGES).min(row);
        &self.connections[(row * (row + 1) / 2 + column) as usize]
    }
}

/// Every corner of the polygon with more edges meets the nearest corner of the other.
///
/// ```text
///   few = 3     0─────────────1─────────────2─────────────0
///               │ quad   ╱triangle│  quad  │ …
///   many = 5    0──────1──────2──────3──────4──────0
/// ```
///
/// So no triangle is thinner than the rings demand: its apex is never farther around than half an
/// edge of the polygon with fewer edges. As many quads are left as that has edges. Of `few` from 3 on, and
/// `many` at least that.
pub fn sides(few: u32, many: u32) -> impl Iterator<Item = Side> {
    (0..many).map(move |corner| {
        let (here, next) = (nearest(few, many, corner), nearest(few, many, corner + 1));
        if here == next {
            Side::Triangle {
                few: here % few,
                many: corner,
            }
        } else {
            Side::Quad {
                few: here,
                many: corner,
            }
        }
    })
}

/// The nearest corner, halves to the one before: the greatest j with 2 j many < 2 i few + many.
fn nearest(few: u32, many: u32, corner: u32) -> u32 {
    (2 * corner * few + many - 1) / (2 * many)
}

fn connection(few: u32, many: u32) -> Connection {
    let nearest = |corner| nearest(few, many, corner);
    let offsets = (0..=many).map(|corner| {
        // Of whole numbers of 1 / (few many), so that what is equal is exactly 0.
        let turns = (corner * few).abs_diff(nearest(corner) * many);
        std::f32::consts::TAU * turns as f32 / (few * many) as f32
    });
    Connection {
        sides: sides(few, many).collect(),
        offset: offsets.fold(0.0, f32::max),
        slack: if few == many { 0.0 } else { slack(few) },
    }
}

/// The most by which the angle of a point on an edge leaves the straight way from corner to corner.
///
/// At a share `(1 + x) / 2` of an edge of a polygon with `h` edges the angle is `atan(x tan w)` from
/// the edge's middle, `w = π/h`: more than `x w`, by the most where `x² = (tan w / w − 1) / tan² w`. Of
/// two joined edges the longer one leaves it more, to the same side.
fn slack(edges: u32) -> f32 {
    let half = std::f32::consts::PI / edges as f32;
    let tangent = det::tan(half);
    // Of many edges only rounding is left, of either sign.
    let x = ((tangent / half - 1.0).max(0.0) / (tangent * tangent)).sqrt();
    (det::atan2(x * tangent, 1.0) - x * half).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_as_many_quads_and_triangles_as_the_paper_counts() {
        let table = ConnectionTable::up_to(40);
        for many in 3..=40 {
            for few in 3..=many {
                let connection = table.between(few, many);
                let quads = connection
                    .sides
                    .iter()
                    .filter(|side| matches!(side, Side::Quad { .. }));
                assert_eq!(quads.count(), few as usize, "{few} to {many}");
                assert_eq!(connection.sides.len(), many as usize);
                let half_an_edge = std::f32::consts::PI / few as f32;
                assert!(connection.offset <= half_an_edge + 1e-6);
                assert_eq!(connection.offset == 0.0, few == many);
            }
        }
    }

    #[test]
    fn slack_is_the_most_that_angles_leave_the_straight_way() {
        for edges in [3_u8, 4, 7, 30].map(u32::from) {
            let half = std::f32::consts::PI / edges as f32;
            let tangent = det::tan(half);
            let most = (0_u16..=1000).fold(0.0, |most: f32, step| {
                let x = f32::from(step) / 1000.0;
                most.max(det::atan2(x * tangent, 1.0) - x * half)
            });
            assert!((slack(edges) - most).abs() < 1e-5, "{edges} edges");
        }
    }

    #[test]
    fn sides_go_around_without_a_gap() {
        let table = ConnectionTable::up_to(17);
        for many in 3..=17_u32 {
            for few in 3..=many {
                let (mut at_few, mut at_many) = (0, 0);
                for side in &table.between(few, many).sides {
                    let (Side::Quad { few: f, many: m } | Side::Triangle { few: f, many: m }) =
                        *side;
                    assert_eq!((f, m), (at_few % few, at_many));
                    at_many += 1;
                    at_few += u32::from(matches!(side, Side::Quad { .. }));
                }
                assert_eq!((at_few, at_many), (few, many));
            }
        }
    }
}
