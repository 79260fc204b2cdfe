//! Leaves, in groups that share a prototype and a material.

use super::{Material, PlantError};
use crate::limits;
use crate::math::{Aabb, Digester, Vec2, Vec3, index_u32};

/// What a leaf without a known branch names as its owner.
pub const NO_BRANCH: u32 = u32::MAX;

/// All leaves of a plant. Quad leaves are numbered through all groups in order; so are vertices.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Foliage {
    /// The groups, in order; collapses never join leaves of two groups.
    pub groups: Vec<LeafGroup>,
}

/// Leaves of one kind: one prototype, one material, one vertex layout.
#[derive(Debug, Clone, PartialEq)]
pub struct LeafGroup {
    /// A name, for reports and export; not part of any digest.
    pub name: String,
    /// What one leaf is made of.
    pub prototype: Prototype,
    /// What it looks like.
    pub material: Material,
    /// World-space vertices, [`Prototype::vertices_per_leaf`] a leaf, never shared by two leaves.
    pub positions: Vec<Vec3>,
    /// The branch of the skeleton that bears each leaf, or [`NO_BRANCH`]; one a leaf.
    pub owners: Vec<u32>,
}

/// What one leaf of a group is made of.
#[derive(Debug, Clone, PartialEq)]
pub enum Prototype {
    /// Four corners, two triangles 0-1-2 and 0-2-3. A corner's role is its vertex index modulo 4;
    /// role 0 is the left end of the leaf's base, 1 the right end, 2 right and 3 left at the tip.
    Quad {
        /// The texture coordinate of each role.
        texture_corners: [Vec2; 4],
    },
    /// A mesh of several faces.
    Faces {
        /// The texture coordinate of each vertex of one leaf.
        texture_coordinates: Vec<Vec2>,
        /// Three vertex indices a triangle, within one leaf.
        triangles: Vec<[u32; 3]>,
    },
    /// A needle: two vertices, base and tip.
    Needle {
        /// The thickness, in metres.
        diameter: f32,
    },
}

/// A group of leaves of several faces, and where they stand among all leaves with faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceGroup<'a> {
    /// Its place among all groups.
    pub number: usize,
    /// The *site* of its first leaf: leaves with triangles, quads and those of several faces, are
    /// numbered group by group.
    pub first_site: u32,
    /// The group.
    pub group: &'a LeafGroup,
    /// The texture coordinate of each vertex of one leaf.
    pub texture_coordinates: &'a [Vec2],
    /// Three vertex indices a face, within one leaf.
    pub triangles: &'a [[u32; 3]],
}

impl Prototype {
    /// The texture corners of a leaf that shows a whole image upright: base at the image's bottom.
    pub const WHOLE_IMAGE: [Vec2; 4] = [
        Vec2::new(0.0, 1.0),
        Vec2::new(1.0, 1.0),
        Vec2::new(1.0, 0.0),
        Vec2::new(0.0, 0.0),
    ];

    /// How many vertices one leaf has.
    #[must_use]
    pub fn vertices_per_leaf(&self) -> usize {
        match self {
            Self::Quad { .. } => 4,
            Self::Faces {
                texture_coordinates,
                ..
            } => texture_coordinates.len(),
            Self::Needle { .. } => 2,
        }
    }

    /// How many triangles one leaf has; none for a needle, which is a line.
    #[must_use]
    pub fn triangles_per_leaf(&self) -> usize {
        match self {
            Self::Quad { .. } => 2,
            Self::Faces { triangles, .. } => triangles.len(),
            Self::Needle { .. } => 0,
        }
    }
}

impl LeafGroup {
    /// How many leaves there are.
    #[must_use]
    pub fn leaf_count(&self) -> usize {
        self.owners.len()
    }

    /// How many of them have triangles: all, or none where they are needles.
    fn site_count(&self) -> usize {
        match self.prototype {
            Prototype::Quad { .. } | Prototype::Faces { .. } => self.leaf_count(),
            Prototype::Needle { .. } => 0,
        }
    }

    /// How many faces leaves of several faces have, over all leaves; other groups have none.
    fn face_count(&self) -> usize {
        match &self.prototype {
            Prototype::Faces { triangles, .. } => self.leaf_count().saturating_mul(triangles.len()),
            Prototype::Quad { .. } | Prototype::Needle { .. } => 0,
        }
    }

    /// The area of all leaves' triangles, one side of each, in m²; needles have none.
    #[must_use]
    pub fn area(&self) -> f64 {
        let triangles: &[[u32; 3]] = match &self.prototype {
            Prototype::Quad { .. } => &[[0, 1, 2], [0, 2, 3]],
            Prototype::Faces { triangles, .. } => triangles,
            Prototype::Needle { .. } => &[],
        };
        let leaves = self
            .positions
            .chunks_exact(self.prototype.vertices_per_leaf().max(1));
        let mut area = 0.0;
        for leaf in leaves {
            for corners in triangles {
                let [a, b, c] = corners.map(|corner| leaf[corner as usize].as_dvec3());
                area += (b - a).cross(c - a).length() / 2.0;
            }
        }
        area
    }

    /// The vertices of one leaf.
    ///
    /// # Panics
    ///
    /// When `leaf` is not below [`leaf_count`](Self::leaf_count).
    #[must_use]
    pub fn leaf(&self, leaf: usize) -> &[Vec3] {
        let stride = self.prototype.vertices_per_leaf();
        &self.positions[leaf * stride..(leaf + 1) * stride]
    }
}

impl Foliage {
    /// How many leaves all groups have together.
    #[must_use]
    pub fn leaf_count(&self) -> usize {
        self.groups.iter().map(LeafGroup::leaf_count).sum()
    }

    /// The groups of quad leaves: what is drawn and collapsed by the foliage models.
    pub fn quad_groups(&self) -> impl Iterator<Item = (&LeafGroup, &[Vec2; 4])> {
        self.groups
            .iter()
            .filter_map(|group| match &group.prototype {
                Prototype::Quad { texture_corners } => Some((group, texture_corners)),
                Prototype::Faces { .. } | Prototype::Needle { .. } => None,
            })
    }

    /// How many quad leaves there are.
    #[must_use]
    pub fn quad_count(&self) -> usize {
        self.quad_groups()
            .map(|(group, _)| group.leaf_count())
            .sum()
    }

    /// The vertices of all quad leaves: leaf `l` of the numbering through all quad groups has
    /// vertices `4 l .. 4 l + 4`.
    #[must_use]
    pub fn quad_vertices(&self) -> Vec<Vec3> {
        self.quad_groups()
            .flat_map(|(group, _)| group.positions.iter().copied())
            .collect()
    }

    /// The groups of leaves of several faces: drawn by the foliage models at full detail, whatever the
    /// level.
    pub fn face_groups(&self) -> impl Iterator<Item = FaceGroup<'_>> {
        let mut sites = 0;
        self.groups
            .iter()
            .enumerate()
            .filter_map(move |(number, group)| {
                let first_site = sites;
                sites += group.site_count();
                match &group.prototype {
                    Prototype::Faces {
                        texture_coordinates,
                        triangles,
                    } => Some(FaceGroup {
                        number,
                        first_site: index_u32(first_site),
                        group,
                        texture_coordinates,
                        triangles,
                    }),
                    Prototype::Quad { .. } | Prototype::Needle { .. } => None,
                }
            })
    }

    /// How many faces leaves of several faces have together.
    #[must_use]
    pub fn face_count(&self) -> usize {
        let faces = self.groups.iter().map(LeafGroup::face_count);
        faces.fold(0, usize::saturating_add)
    }

    /// The box around all leaves.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        Aabb::of(
            self.groups
                .iter()
                .flat_map(|group| group.positions.iter().copied()),
        )
    }

    pub(super) fn check(&self, branch_count: usize) -> Result<(), PlantError> {
        let found = self.leaf_count();
        if found > limits::PLANT_LEAVES {
            let part = "foliage".to_owned();
            return Err(PlantError::TooMany {
                part,
                what: "leaves",
                found,
                limit: limits::PLANT_LEAVES,
            });
        }
        let found = self.groups.iter().map(|group| group.positions.len()).sum();
        if found > limits::PLANT_VERTICES {
            let part = "foliage".to_owned();
            return Err(PlantError::TooMany {
                part,
                what: "vertices",
                found,
                limit: limits::PLANT_VERTICES,
            });
        }
        let found = self.face_count();
        if found > limits::PLANT_FACES {
            let part = "foliage".to_owned();
            return Err(PlantError::TooMany {
                part,
                what: "faces of leaves",
                found,
                limit: limits::PLANT_FACES,
            });
        }
        self.groups
            .iter()
            .try_for_each(|group| group.check(branch_count))
    }

    pub(super) fn digest_into(&self, digester: &mut Digester) {
        digester.u64(self.groups.len() as u64);
        for group in &self.groups {
            group.digest_into(digester);
        }
    }
}

impl LeafGroup {
    fn check(&self, branch_count: usize) -> Result<(), PlantError> {
        let part = || format!("foliage group {:?}", self.name);
        let wanted = self.leaf_count() * self.prototype.vertices_per_leaf();
        let found = self.positions.len();
        if found != wanted {
            return Err(PlantError::Length {
                part: part(),
                what: "vertices",
                found,
                wanted,
            });
        }
        if let Prototype::Faces {
            texture_coordinates,
            triangles,
        } = &self.prototype
        {
            let count = texture_coordinates.len();
            for (place, &index) in triangles.iter().flatten().enumerate() {
                if index as usize >= count {
                    let index = u64::from(index);
                    return Err(PlantError::Index {
                        part: part(),
                        place,
                        what: "vertex",
                        index,
                        count,
                    });
                }
            }
        }
        for (place, &owner) in self.owners.iter().enumerate() {
            if owner != NO_BRANCH && owner as usize >= branch_count {
                let (index, count) = (u64::from(owner), branch_count);
                return Err(PlantError::Index {
                    part: part(),
                    place,
                    what: "branch",
                    index,
                    count,
                });
            }
        }
        if let Some(place) = self
            .positions
            .iter()
            .position(|position| !position.is_finite())
        {
            let value = self.positions[place].to_string();
            return Err(PlantError::Number {
                part: part(),
                place,
                value,
                wanted: "finite",
            });
        }
        let coordinates = self.prototype.coordinates();
        if let Some(place) = coordinates.iter().position(|corner| !corner.is_finite()) {
            let value = coordinates[place].to_string();
            return Err(PlantError::Number {
                part: part(),
                place,
                value,
                wanted: "finite",
            });
        }
        self.material.check(&part())
    }

    fn digest_into(&self, digester: &mut Digester) {
        match &self.prototype {
            Prototype::Quad { .. } => _ = digester.u32(0),
            Prototype::Faces { triangles, .. } => {
                digester.u32(1).u64(triangles.len() as u64);
                for &index in triangles.iter().flatten() {
                    digester.u32(index);
                }
            }
            Prototype::Needle { diameter } => _ = digester.u32(2).f32(*diameter),
        }
        let coordinates = self.prototype.coordinates();
        digester.u32(index_u32(coordinates.len()));
        for corner in coordinates {
            digester.f32(corner.x).f32(corner.y);
        }
        self.material.digest_into(digester);
        digester.u64(self.positions.len() as u64);
        for position in &self.positions {
            digester.vec3(*position);
        }
        digester.u64(self.owners.len() as u64);
        for &owner in &self.owners {
            digester.u32(owner);
        }
    }
}

impl Prototype {
    fn coordinates(&self) -> &[Vec2] {
        match self {
            Self::Quad { texture_corners } => texture_corners,
            Self::Faces {
                texture_coordinates,
                ..
            } => texture_coordinates,
            Self::Needle { .. } => &[],
        }
    }
}
