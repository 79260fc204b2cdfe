//! From pieces of foliage to groups of leaves that share a prototype and a material.

use super::cards::{self, Pieces};
use super::{Materials, Part};
use crate::limits::MATERIAL_GROUPS;
use crate::math::{Vec2, Vec3, index_u32};
use crate::plant::import::{ImportReport, ReportKind};
use crate::plant::{Foliage, LeafGroup, NO_BRANCH, Prototype};
use std::collections::BTreeMap;

/// Leaves as they are found, sorted by material and prototype.
#[derive(Debug, Default)]
pub(in crate::plant) struct Leaves {
    index: BTreeMap<(Option<usize>, Shape), usize>,
    kinds: Vec<Kind>,
}

/// A prototype in a form that has an order: texture coordinates by their bits.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Shape {
    Card([[u32; 2]; 4]),
    Faces(Vec<[u32; 2]>, Vec<[u32; 3]>),
}

/// All leaves of one material and prototype.
#[derive(Debug)]
struct Kind {
    material: Option<usize>,
    shape: Shape,
    positions: Vec<Vec3>,
    leaves: usize,
    place: String,
}

impl Leaves {
    /// Adds the pieces of one part.
    pub(super) fn add(&mut self, part: &Part, pieces: &Pieces, report: &mut ImportReport) {
        let place = &part.place;
        let mut new_diagonals = 0;
        for &card in &pieces.cards {
            let (corners, is_turned) = in_roles(card, &part.coordinates);
            new_diagonals += u64::from(is_turned);
            let shape = Shape::Card(corners.map(|corner| bits(part.coordinates[corner as usize])));
            self.push(part, shape, &corners);
        }
        for piece in &pieces.others {
            let (vertices, triangles) = own_vertices(part, piece);
            let coordinates = vertices
                .iter()
                .map(|&vertex| bits(part.coordinates[vertex as usize]))
                .collect();
            self.push(part, Shape::Faces(coordinates, triangles), &vertices);
        }
        report.quad_leaves += pieces.cards.len() as u64;
        for (kind, count, message) in [
            (
                ReportKind::Merged,
                pieces.repeated,
                "triangles on top of others, as backs of two-sided leaves: every leaf has two sides",
            ),
            (
                ReportKind::Repaired,
                pieces.turned,
                "cards whose two triangles face opposite ways",
            ),
            (
                ReportKind::Guessed,
                new_diagonals,
                "cards whose base is not an end of their diagonal: it lies at the texture's bottom, and the other \
                 diagonal divides them",
            ),
        ] {
            report.add(kind, count, place, message);
        }
    }

    fn push(&mut self, part: &Part, shape: Shape, vertices: &[u32]) {
        let material = part.material;
        let index = *self
            .index
            .entry((material, shape))
            .or_insert_with_key(|(_, shape)| {
                self.kinds.push(Kind {
                    material,
                    shape: shape.clone(),
                    positions: Vec::new(),
                    leaves: 0,
                    place: part.place.clone(),
                });
                self.kinds.len() - 1
            });
        let kind = &mut self.kinds[index];
        let positions = vertices
            .iter()
            .map(|&vertex| part.positions[vertex as usize]);
        kind.positions.extend(positions);
        kind.leaves += 1;
    }

    /// The groups, in the order in which their first leaves were met. Of each material, cards of
    /// rare texture quadrilaterals take the nearest frequent one, and other shapes that occur once
    /// or are rare become one leaf of many faces.
    ///
    /// # Errors
    ///
    /// As [`Materials::read`].
    pub(super) fn into_foliage<M: Materials>(
        mut self,
        materials: &mut M,
        report: &mut ImportReport,
    ) -> Result<Foliage, M::Fault> {
        let mut by_material: BTreeMap<Option<usize>, [Vec<usize>; 2]> = BTreeMap::new();
        for (index, kind) in self.kinds.iter().enumerate() {
            let is_faces = matches!(kind.shape, Shape::Faces(..));
            by_material.entry(kind.material).or_default()[usize::from(is_faces)].push(index);
        }
        for [cards, faces] in by_material.into_values() {
            self.limit_cards(cards, report);
            self.limit_faces(faces, report);
        }
        let mut names: BTreeMap<String, u32> = BTreeMap::new();
        let mut groups = Vec::new();
        for kind in self.kinds.into_iter().filter(|kind| kind.leaves > 0) {
            let material = materials.read(kind.material, report)?;
            let number = names.entry(material.name.clone()).or_insert(0);
            *number += 1;
            let name = match *number {
                1 => material.name.clone(),
                number => format!("{} {number}", material.name),
            };
            let prototype = match kind.shape {
                Shape::Card(corners) => Prototype::Quad {
                    texture_corners: corners.map(value),
                },
                Shape::Faces(coordinates, triangles) => {
                    report.other_leaves += kind.leaves as u64;
                    Prototype::Faces {
                        texture_coordinates: coordinates.into_iter().map(value).collect(),
                        triangles,
                    }
                }
            };
            groups.push(LeafGroup {
                name,
                prototype,
                material,
                positions: kind.positions,
                owners: vec![NO_BRANCH; kind.leaves],
            });
        }
        Ok(Foliage { groups })
    }

    fn limit_cards(&mut self, mut cards: Vec<usize>, report: &mut ImportReport) {
        if cards.len() <= MATERIAL_GROUPS {
            return;
        }
        self.most_leaves_first(&mut cards);
        let rare = cards.split_off(MATERIAL_GROUPS);
        for index in rare {
            let own = self.kinds[index].corners();
            let mut nearest = (f32::INFINITY, cards[0]);
            for &kept in &cards {
                let other = self.kinds[kept].corners();
                let distance = (0..4).fold(0.0, |sum: f32, role| {
                    sum + own[role].distance_squared(other[role])
                });
                if distance < nearest.0 {
                    nearest = (distance, kept);
                }
            }
            let (moved, count, place) = self.kinds[index].take();
            let message = format!(
                "cards that show a rare part of their texture (beyond {MATERIAL_GROUPS} \
                 parts a material): they show the nearest frequent part"
            );
            report.add(ReportKind::Merged, count as u64, place, message);
            let kept = &mut self.kinds[nearest.1];
            kept.positions.extend(moved);
            kept.leaves += count;
        }
    }

    fn limit_faces(&mut self, mut faces: Vec<usize>, report: &mut ImportReport) {
        self.most_leaves_first(&mut faces);
        let is_kept = |(place, index): (usize, &usize)| {
            place < MATERIAL_GROUPS && self.kinds[*index].leaves > 1
        };
        let kept = faces
            .iter()
            .enumerate()
            .filter(|&pair| is_kept(pair))
            .count();
        let mut rare = faces.split_off(kept);
        for &index in &faces {
            let kind = &self.kinds[index];
            let message = "foliage that is no cards: leaves of several faces, drawn as they are";
            report.add(
                ReportKind::Guessed,
                kind.leaves as u64,
                &kind.place,
                message,
            );
        }
        // The order of the file, not of frequency.
        rare.sort_unstable();
        let Some(&first) = rare.first() else {
            return;
        };
        let material = self.kinds[first].material;
        let mut positions = Vec::new();
        let mut all_coordinates = Vec::new();
        let mut all_triangles = Vec::new();
        for index in rare {
            let Shape::Faces(coordinates, triangles) = self.kinds[index].shape.clone() else {
                continue;
            };
            let (moved, count, place) = self.kinds[index].take();
            for _ in 0..count {
                let offset = index_u32(all_coordinates.len());
                all_coordinates.extend_from_slice(&coordinates);
                let shifted = triangles.iter().map(|corners| corners.map(|c| c + offset));
                all_triangles.extend(shifted);
            }
            positions.extend(moved);
            let message = "pieces of foliage of a shape that does not recur: one leaf of many faces \
                           a material, drawn as it is";
            report.add(ReportKind::Merged, count as u64, place, message);
        }
        let place = self.kinds[first].place.clone();
        self.kinds.push(Kind {
            material,
            shape: Shape::Faces(all_coordinates, all_triangles),
            positions,
            leaves: 1,
            place,
        });
    }

    fn most_leaves_first(&self, kinds: &mut [usize]) {
        kinds.sort_unstable_by_key(|&index| (std::cmp::Reverse(self.kinds[index].leaves), index));
    }
}

impl Kind {
    fn corners(&self) -> [Vec2; 4] {
        match &self.shape {
            Shape::Card(corners) => corners.map(value),
            Shape::Faces(..) => [Vec2::ZERO; 4],
        }
    }

    fn take(&mut self) -> (Vec<Vec3>, usize, String) {
        let positions = std::mem::take(&mut self.positions);
        (
            positions,
            std::mem::take(&mut self.leaves),
            self.place.clone(),
        )
    }
}

/// The prototype of a mesh that leaves share, and which of its vertices each of the prototype's is.
pub(in crate::plant) fn prototype_of(
    positions: &[Vec3],
    coordinates: &[Vec2],
    triangles: &[[u32; 3]],
) -> (Prototype, Vec<u32>) {
    let pieces = cards::split(positions, coordinates, triangles);
    if let ([card], []) = (pieces.cards.as_slice(), pieces.others.as_slice()) {
        let (corners, _) = in_roles(*card, coordinates);
        let texture_corners = corners.map(|corner| coordinates[corner as usize]);
        return (Prototype::Quad { texture_corners }, corners.to_vec());
    }
    let (vertices, triangles) = super::compact(triangles.to_vec());
    let texture_coordinates = vertices.iter().map(|&v| coordinates[v as usize]).collect();
    let prototype = Prototype::Faces {
        texture_coordinates,
        triangles,
    };
    (prototype, vertices)
}

/// The corners of a card, from the left end of its base in winding order, and whether that changes
/// which corners the diagonal joins.
///
/// The base is the side with the greatest mean v, at the bottom of the image. Where two sides tie,
/// the diagonal stays.
fn in_roles(card: [u32; 4], coordinates: &[Vec2]) -> ([u32; 4], bool) {
    let corner = |index: usize| card[index % 4];
    let height = |first: usize| {
        let v = |index: usize| coordinates[corner(index) as usize].y;
        v(first) + v(first + 1)
    };
    let mut base = 0;
    for first in [2, 1, 3] {
        if height(first) > height(base) {
            base = first;
        }
    }
    ([0, 1, 2, 3].map(|role| corner(base + role)), base % 2 == 1)
}

/// The vertices of a piece, without twins in position and texture, in the order in which its
/// triangles name them, and the triangles in these numbers.
fn own_vertices(part: &Part, piece: &[[u32; 3]]) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut numbers = BTreeMap::new();
    let mut vertices = Vec::new();
    let triangles = piece
        .iter()
        .map(|triangle| {
            triangle.map(|vertex| {
                let position = part.positions[vertex as usize] + Vec3::ZERO;
                let coordinate = bits(part.coordinates[vertex as usize]);
                let key = (position.to_array().map(f32::to_bits), coordinate);
                *numbers.entry(key).or_insert_with(|| {
                    vertices.push(vertex);
                    index_u32(vertices.len() - 1)
                })
            })
        })
        .collect();
    (vertices, triangles)
}

fn bits(coordinate: Vec2) -> [u32; 2] {
    coordinate.to_array().map(f32::to_bits)
}

fn value(bits: [u32; 2]) -> Vec2 {
    Vec2::from_array(bits.map(f32::from_bits))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roles_begin_at_the_bottom_of_the_image() {
        let whole = Prototype::WHOLE_IMAGE;
        assert_eq!(in_roles([0, 1, 2, 3], &whole), ([0, 1, 2, 3], false));
        assert_eq!(in_roles([2, 3, 0, 1], &whole), ([0, 1, 2, 3], false));
        assert_eq!(in_roles([1, 2, 3, 0], &whole), ([0, 1, 2, 3], true));
        // Seen from behind, the base's left end is at the image's right.
        assert_eq!(in_roles([3, 2, 1, 0], &whole), ([1, 0, 3, 2], false));
        let none = [Vec2::ZERO; 4];
        assert_eq!(in_roles([3, 2, 1, 0], &none), ([3, 2, 1, 0], false));
    }
}
