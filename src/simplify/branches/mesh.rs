//! What a level of branches is made of: quads, triangles and lines over shared vertices.

use crate::math::{Vec2, Vec3};

/// A corner of a polygon, or an end of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchVertex {
    /// In metres, world space.
    pub position: Vec3,
    /// A unit vector outwards: of a ring that of eq. A5, of an apex or a cap along the axis, of a
    /// line one across it.
    pub normal: Vec3,
    /// Across: once up and down again around a ring, so that no vertex is doubled, ½ on a line.
    /// Along: metres from the branch's base.
    pub texture: Vec2,
    /// The opacity: 1 on polygons, less on lines.
    pub alpha: f32,
}

/// Branches, or needles, as primitives; each kind is counted as the paper counts it.
///
/// A quad is drawn as the triangles 0-1-2 and 0-2-3. All polygons are counter-clockwise seen from
/// outside. Every branch has vertices of its own, so that branches run into each other where they
/// meet. Vertices follow in the order of branches, so do the primitives of each kind.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BranchMesh {
    /// The vertices of all primitives.
    pub vertices: Vec<BranchVertex>,
    /// Four vertices a quad: sides of prisms and prismoids.
    pub quads: Vec<[u32; 4]>,
    /// Three vertices a triangle: sides of prismoids, apexes, caps.
    pub triangles: Vec<[u32; 3]>,
    /// Two vertices a line.
    pub lines: Vec<[u32; 2]>,
}

/// How many primitives of each kind there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, serde::Serialize)]
pub struct PrimitiveCounts {
    /// Quads.
    pub quads: u64,
    /// Triangles that are no part of a quad.
    pub triangles: u64,
    /// Lines.
    pub lines: u64,
}

impl PrimitiveCounts {
    /// All of them, a quad as one: what the paper's figures count.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.quads + self.triangles + self.lines
    }
}

impl BranchMesh {
    /// How many primitives of each kind there are.
    #[must_use]
    pub fn counts(&self) -> PrimitiveCounts {
        PrimitiveCounts {
            quads: self.quads.len() as u64,
            triangles: self.triangles.len() as u64,
            lines: self.lines.len() as u64,
        }
    }

    /// All triangles that are drawn: two a quad, then those that are none of a quad.
    pub fn drawn_triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        let quads = self.quads.iter();
        quads
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .chain(self.triangles.iter().copied())
    }
}
