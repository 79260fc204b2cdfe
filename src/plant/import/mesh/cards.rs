//! Taking triangles apart into connected pieces, and telling which pieces are cards.

use crate::math::{DVec3, Vec2, Vec3, index_u32};
use std::collections::BTreeSet;

/// The connected pieces of a part.
#[derive(Debug, Default)]
pub(super) struct Pieces {
    /// Cards: four vertices in winding order; the triangles are 0-1-2 and 0-2-3.
    pub(super) cards: Vec<[u32; 4]>,
    /// All else, as triangles.
    pub(super) others: Vec<Vec<[u32; 3]>>,
    /// Triangles on the same three positions as an earlier one: the backs of two-sided leaves.
    pub(super) repeated: u64,
    /// Cards whose second triangle faced the other way.
    pub(super) turned: u64,
    /// A number for each vertex of the part, the same for equal positions.
    pub(super) places: Vec<u32>,
}

/// Splits triangles into pieces that share no position.
///
/// A piece is a card if, without repeated triangles, it is two triangles on four positions with a
/// common edge, whose ends have the same texture coordinate in both.
pub(super) fn split(positions: &[Vec3], coordinates: &[Vec2], triangles: &[[u32; 3]]) -> Pieces {
    let places = place_classes(positions);
    let mut pieces = Pieces::default();
    for piece in components(&places, triangles) {
        pieces.add(piece, positions, &places, coordinates);
    }
    pieces.places = places;
    pieces
}

impl Pieces {
    /// Splits pieces that are no cards further, where vertices are not shared although positions
    /// are: leaves that touch. A piece stays whole unless all of it becomes cards.
    pub(super) fn loosen(&mut self, positions: &[Vec3], coordinates: &[Vec2]) {
        let places = std::mem::take(&mut self.places);
        let mut own: Vec<u32> = (0..index_u32(positions.len())).collect();
        for piece in std::mem::take(&mut self.others) {
            // Only the vertices of this piece are classes of their own: cost follows its size.
            let mut vertices: Vec<u32> = piece.iter().flatten().copied().collect();
            vertices.sort_unstable();
            vertices.dedup();
            for (class, &vertex) in vertices.iter().enumerate() {
                own[vertex as usize] = index_u32(class);
            }
            let mut parts = Self::default();
            for part in components(&own, &piece) {
                parts.add(part, positions, &places, coordinates);
            }
            if parts.others.is_empty() {
                self.cards.append(&mut parts.cards);
                self.repeated += parts.repeated;
                self.turned += parts.turned;
            } else {
                self.others.push(piece);
            }
        }
        self.places = places;
    }

    fn add(
        &mut self,
        piece: Vec<[u32; 3]>,
        positions: &[Vec3],
        places: &[u32],
        coordinates: &[Vec2],
    ) {
        let before = piece.len();
        let mut kept = once(piece, places);
        if let Some(half) = front(&kept, positions, places) {
            kept.truncate(half);
        }
        self.repeated += (before - kept.len()) as u64;
        match card(&kept, places, coordinates) {
            Some((corners, turned)) => {
                self.cards.push(corners);
                self.turned += u64::from(turned);
            }
            None => self.others.push(kept),
        }
    }
}

/// The triangles without those on the same three positions as an earlier one.
fn once(mut triangles: Vec<[u32; 3]>, places: &[u32]) -> Vec<[u32; 3]> {
    let key = |triangle: &[u32; 3]| {
        let mut key = triangle.map(|vertex| places[vertex as usize]);
        key.sort_unstable();
        key
    };
    // Sorted, not in a tree: a trunk of millions of triangles is one piece.
    let mut order: Vec<([u32; 3], u32)> = triangles.iter().map(key).zip(0..).collect();
    order.sort_unstable();
    let twins = order.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    let mut repeated: Vec<u32> = twins.map(|pair| pair[1].1).collect();
    if repeated.is_empty() {
        return triangles;
    }
    repeated.sort_unstable();
    let mut number = 0_u32..;
    triangles.retain(|_| {
        let own = number.next().expect("the range does not end");
        repeated.binary_search(&own).is_err()
    });
    triangles
}

/// How many triangles make the front of a leaf whose back is divided along other diagonals: a flat polygon
/// of n corners is n − 2 triangles, and twice as many on the same corners show both of its sides.
fn front(triangles: &[[u32; 3]], positions: &[Vec3], places: &[u32]) -> Option<usize> {
    let corners = |triangles: &[[u32; 3]]| {
        let corners = triangles.iter().flatten();
        let corners: BTreeSet<u32> = corners.map(|&vertex| places[vertex as usize]).collect();
        corners
    };
    let half = triangles.len() / 2;
    if half < 2 || triangles.len() % 2 == 1 || half + 2 > MOST_CORNERS {
        return None;
    }
    let (front, back) = triangles.split_at(half);
    let same = corners(front);
    let is_flat = |side: &[[u32; 3]]| flatness(side, positions) > 0.9;
    let twice = same.len() == half + 2 && same == corners(back);
    (twice && is_flat(front) && is_flat(back)).then_some(half)
}

/// The most vertices of a leaf that is told from wood by its form alone.
const MOST_CORNERS: usize = 11;

/// How nearly triangles face one way: the length of their areas' sum as vectors over the sum of their
/// lengths. 1 for what is flat, 0.64 for a strip that is bent back by 180°, and for an open cone its radius
/// over its slant.
fn flatness(triangles: &[[u32; 3]], positions: &[Vec3]) -> f64 {
    let (mut sum, mut lengths) = (DVec3::ZERO, 0.0);
    for corners in triangles {
        let [a, b, c] = corners.map(|corner| positions[corner as usize].as_dvec3());
        let area = (b - a).cross(c - a);
        sum += area;
        lengths += area.length();
    }
    if lengths > 0.0 {
        sum.length() / lengths
    } else {
        0.0
    }
}

/// Whether a piece that is no card may be a leaf: at most 11 corners, no holes, not closed, and no tube.
///
/// A surface that can be shrunk to a point has Euler's number 1 (corners − edges + triangles); tubes that
/// are open at both ends have 0, closed ones 2. A twig that ends in a point has 1 too, but faces all ways.
pub(super) fn is_leaf(piece: &[[u32; 3]], positions: &[Vec3], places: &[u32]) -> bool {
    if piece.len() > 2 * MOST_CORNERS {
        return false;
    }
    let (mut corners, mut edges) = (BTreeSet::new(), BTreeSet::new());
    for triangle in piece {
        let [a, b, c] = triangle.map(|vertex| places[vertex as usize]);
        corners.extend([a, b, c]);
        edges.extend([
            (a.min(b), a.max(b)),
            (b.min(c), b.max(c)),
            (c.min(a), c.max(a)),
        ]);
    }
    corners.len() <= MOST_CORNERS
        && corners.len() + piece.len() == edges.len() + 1
        && flatness(piece, positions) > LEAF_FLATNESS
}

/// Above the open cones that twigs end in, unless they are shorter than three times their radius.
const LEAF_FLATNESS: f64 = 0.35;

/// The corners of a card, and whether its second triangle faced the other way.
fn card(triangles: &[[u32; 3]], places: &[u32], coordinates: &[Vec2]) -> Option<([u32; 4], bool)> {
    let &[first, second] = triangles else {
        return None;
    };
    let place = |vertex: u32| places[vertex as usize];
    let meets = |vertex: u32, other: &[u32; 3]| {
        let mut others = other.iter();
        others
            .find(|&&other| place(other) == place(vertex))
            .copied()
    };
    // The corner of the first triangle that the second lacks lies opposite the common edge.
    let lone: Vec<usize> = (0..3)
        .filter(|&c| meets(first[c], &second).is_none())
        .collect();
    let &[lone] = lone.as_slice() else {
        return None;
    };
    let far: Vec<usize> = (0..3)
        .filter(|&c| meets(second[c], &first).is_none())
        .collect();
    let &[far] = far.as_slice() else {
        return None;
    };
    let (start, end) = (first[(lone + 2) % 3], first[(lone + 1) % 3]);
    if place(start) == place(end) {
        return None;
    }
    for vertex in [start, end] {
        let twin = meets(vertex, &second)?;
        if coordinates[twin as usize] != coordinates[vertex as usize] {
            return None;
        }
    }
    // The second triangle runs start, end, far if it faces the same way.
    let turned = place(second[(far + 1) % 3]) != place(start);
    Some(([start, first[lone], end, second[far]], turned))
}

/// A number for each vertex, the same for equal positions; −0 equals 0.
pub(in crate::plant) fn place_classes(positions: &[Vec3]) -> Vec<u32> {
    let key = |vertex: u32| {
        (positions[vertex as usize] + Vec3::ZERO)
            .to_array()
            .map(f32::to_bits)
    };
    let mut order: Vec<u32> = (0..index_u32(positions.len())).collect();
    order.sort_unstable_by_key(|&vertex| (key(vertex), vertex));
    let mut classes = vec![0; positions.len()];
    let mut class = 0;
    for (place, &vertex) in order.iter().enumerate() {
        if place > 0 && key(order[place - 1]) != key(vertex) {
            class += 1;
        }
        classes[vertex as usize] = class;
    }
    classes
}

/// Triangles grouped by which vertex classes they share, directly or through others; groups and
/// their triangles in the order in which they are met.
pub(in crate::plant) fn components(classes: &[u32], triangles: &[[u32; 3]]) -> Vec<Vec<[u32; 3]>> {
    let class = |vertex: u32| classes[vertex as usize];
    let most = triangles
        .iter()
        .flatten()
        .map(|&vertex| class(vertex))
        .max();
    let Some(most) = most else {
        return Vec::new();
    };
    let mut parents: Vec<u32> = (0..=most).collect();
    for &[a, b, c] in triangles {
        let mut a = find(&mut parents, class(a));
        for other in [b, c] {
            let other = find(&mut parents, class(other));
            let (low, high) = (a.min(other), a.max(other));
            parents[high as usize] = low;
            a = low;
        }
    }
    let mut groups: Vec<Vec<[u32; 3]>> = Vec::new();
    let mut group_of = vec![u32::MAX; parents.len()];
    for &triangle in triangles {
        let root = find(&mut parents, class(triangle[0])) as usize;
        if group_of[root] == u32::MAX {
            group_of[root] = index_u32(groups.len());
            groups.push(Vec::new());
        }
        groups[group_of[root] as usize].push(triangle);
    }
    groups
}

fn find(parents: &mut [u32], class: u32) -> u32 {
    let mut class = class;
    while parents[class as usize] != class {
        let above = parents[parents[class as usize] as usize];
        parents[class as usize] = above;
        class = above;
    }
    class
}

#[cfg(test)]
mod tests {
    use super::*;

    //   3 ── 2      A card: triangles 0-1-2 and 0-2-3.
    //   │  ╱ │
    //   0 ── 1
    const SQUARE: [Vec3; 4] = [
        Vec3::new(0.0, 0.0, 0.0),
        Vec3::new(1.0, 0.0, 0.0),
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(0.0, 1.0, 0.0),
    ];

    fn pieces(positions: &[Vec3], triangles: &[[u32; 3]]) -> Pieces {
        let coordinates: Vec<Vec2> = positions.iter().map(|p| Vec2::new(p.x, p.y)).collect();
        split(positions, &coordinates, triangles)
    }

    #[test]
    fn two_triangles_with_a_common_edge_are_a_card() {
        for triangles in [
            [[0, 1, 2], [0, 2, 3]],
            [[1, 2, 0], [3, 0, 2]],
            [[2, 3, 0], [0, 1, 2]],
        ] {
            let found = pieces(&SQUARE, &triangles);
            assert_eq!((found.cards.len(), found.turned), (1, 0));
            let [a, b, c, d] = found.cards[0];
            assert_eq!([b, c, d], [1, 2, 3].map(|step| (a + step) % 4));
            assert!(a % 2 == 0, "the diagonal stays");
        }
        let found = pieces(&SQUARE, &[[0, 1, 2], [0, 3, 2]]);
        assert_eq!(
            (found.cards.as_slice(), found.turned),
            (&[[0, 1, 2, 3]][..], 1)
        );
    }

    #[test]
    fn split_vertices_and_two_sides_are_the_same_card() {
        let mut positions = SQUARE.to_vec();
        positions.extend([SQUARE[0], SQUARE[2]]);
        positions[4].x = -0.0;
        let found = pieces(&positions, &[[0, 1, 2], [4, 5, 3]]);
        assert_eq!(found.cards, [[0, 1, 2, 3]]);
        let both = [[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]];
        let found = pieces(&SQUARE, &both);
        assert_eq!((found.cards.len(), found.repeated), (1, 2));
    }

    #[test]
    fn strips_lone_triangles_and_split_textures_are_no_cards() {
        let found = pieces(&SQUARE, &[[0, 1, 2]]);
        assert_eq!((found.cards.len(), found.others.len()), (0, 1));
        let mut positions = SQUARE.to_vec();
        positions.push(Vec3::new(0.0, 2.0, 0.0));
        let found = pieces(&positions, &[[0, 1, 2], [0, 2, 3], [3, 2, 4]]);
        assert_eq!((found.cards.len(), found.others.len()), (0, 1));
        let mut positions = SQUARE.to_vec();
        positions.extend([SQUARE[0], SQUARE[2]]);
        let mut coordinates: Vec<Vec2> = positions.iter().map(|p| Vec2::new(p.x, p.y)).collect();
        coordinates[4] = Vec2::splat(9.0);
        let found = split(&positions, &coordinates, &[[0, 1, 2], [4, 5, 3]]);
        assert_eq!((found.cards.len(), found.others.len()), (0, 1));
    }

    #[test]
    fn backs_along_the_other_diagonal_are_the_same_card() {
        let both = [[0, 1, 2], [0, 2, 3], [1, 0, 3], [1, 3, 2]];
        let found = pieces(&SQUARE, &both);
        assert_eq!(found.cards, [[0, 1, 2, 3]]);
        assert_eq!((found.repeated, found.turned), (2, 0));
        // A tetrahedron has as many triangles on as many corners, but two of them face different ways.
        let mut solid = SQUARE;
        solid[3] = Vec3::new(0.5, 0.5, 1.0);
        let found = pieces(&solid, &both);
        assert_eq!((found.cards.len(), found.others[0].len()), (0, 4));
    }

    #[test]
    fn leaves_are_told_from_twigs_by_their_form() {
        let may_be = |positions: &[Vec3], triangles: &[[u32; 3]]| {
            is_leaf(triangles, positions, &place_classes(positions))
        };
        assert!(may_be(&SQUARE, &[[0, 1, 2], [0, 2, 3]]));
        // A strip of 8 corners that is bent over its whole length by 135°.
        let bent: Vec<Vec3> = [(0.0, 0.0), (0.0, 1.0), (0.7, 1.7), (1.4, 1.0)]
            .iter()
            .flat_map(|&(x, y)| [0.0, 1.0].map(|z| Vec3::new(x, y, z)))
            .collect();
        let strip: Vec<[u32; 3]> = (0..3)
            .flat_map(|step| [[0, 1, 3], [0, 3, 2]].map(|t| t.map(|corner| corner + 2 * step)))
            .collect();
        assert!(may_be(&bent, &strip));
        // A twig of three sides that ends in a point, and a tube that is open at both ends.
        let twig = [
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::new(-0.5, 0.0, 0.9),
            Vec3::new(-0.5, 0.0, -0.9),
            Vec3::new(0.0, 9.0, 0.0),
        ];
        assert!(!may_be(&twig, &[[1, 0, 3], [2, 1, 3], [0, 2, 3]]));
        let tube: Vec<Vec3> = twig[..3].iter().flat_map(|&p| [p, p + Vec3::Y]).collect();
        let sides = [
            [0, 2, 3],
            [0, 3, 1],
            [2, 4, 5],
            [2, 5, 3],
            [4, 0, 1],
            [4, 1, 5],
        ];
        assert!(!may_be(&tube, &sides));
        // Twelve corners are too many.
        let fan: Vec<[u32; 3]> = (1..11).map(|corner| [0, corner, corner + 1]).collect();
        let round: Vec<Vec3> = (0..12_u8)
            .map(|n| Vec3::new(f32::from(n), f32::from(n * n), 0.0))
            .collect();
        assert!(!may_be(&round, &fan));
        assert!(may_be(&round, &fan[..9]));
    }

    #[test]
    fn cards_that_touch_come_apart_only_when_asked() {
        let mut positions = SQUARE.to_vec();
        positions.extend(SQUARE.map(|corner| corner + Vec3::X));
        let coordinates = vec![Vec2::ZERO; 8];
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let mut found = split(&positions, &coordinates, &triangles);
        assert_eq!((found.cards.len(), found.others.len()), (0, 1));
        found.loosen(&positions, &coordinates);
        assert_eq!(found.cards, [[0, 1, 2, 3], [4, 5, 6, 7]]);
        assert!(found.others.is_empty());
    }
}
