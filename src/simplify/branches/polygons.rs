//! From nodes that stay to prisms, prismoids, apexes, caps and lines.
//!
//! ```text
//!   edges      ≥ 3, the same     ≥ 3, different     ≥ 3 and 1          1 and 1
//!   internode  prism: quads      prismoid: quads    apex: a fan of     line
//!                                and triangles      triangles
//! ```

use super::connection::{ConnectionTable, Side};
use super::deviation::{Deviation, split, turned};
use super::edges::{EdgeTable, LEAST_EDGES};
use super::internode::radial;
use super::mesh::{BranchMesh, BranchVertex};
use super::skeletal::SkeletalVector;
use crate::math::{Vec2, Vec3, det, index_u32};

/// How branches become primitives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolygonOptions {
    /// The most edges of a circle (`H`), from 3 to [`MOST_EDGES`](super::MOST_EDGES). Where an error asks for more, the level's bound
    /// says so.
    pub most_edges: u32,
    /// How opaque lines are.
    pub line_alpha: LineAlpha,
    /// How many lines an internode has.
    pub line_normals: LineNormals,
    /// Which ends are closed.
    pub caps: Caps,
}

/// The opacity at a line's ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LineAlpha {
    /// `2 R / E3` ([ZBMJLDC17](crate::references), eq. 12): opaque where polygons begin, and too dark by as
    /// much as `E3` is shorter than a pixel.
    Paper,
    /// The part of a pixel's width that the wood covers, `2 R δ / ε`, where `ε` is the level's whole
    /// error and projects to `δ` pixels.
    Coverage {
        /// `δ`, in pixels.
        pixel_error: f32,
    },
    /// None yet: in its place stands the width `2 R` in metres, for who draws knows how wide a pixel is.
    Width,
}

/// The lines of one internode, by which it catches light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineNormals {
    /// One, with the frame's normal.
    One,
    /// Three at the same place with normals a third of a turn apart
    /// ([ZBMJLDC17](crate::references), section 5.5), each of such an opacity that together they are
    /// as opaque as one: `1 − (1−α)^⅓`. (The paper's three are opaque three times over.)
    Three,
}

/// Which ends of a branch are closed; where it ends in a line or an apex it is so anyway.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Caps {
    /// The tip; the base lies in the ground or in the wood that bears it.
    Tip,
    /// Both: every branch is a closed surface.
    Both,
}

impl LineAlpha {
    /// The width, in metres, from which on a line is opaque, at an error `E3` and a whole error `ε`.
    #[must_use]
    pub fn opaque_width(self, polygon: f32, epsilon: f32) -> f32 {
        match self {
            Self::Paper => polygon,
            Self::Coverage { pixel_error } => epsilon / pixel_error,
            // A metre, so that widths are told in metres.
            Self::Width => 1.0,
        }
    }
}

impl LineNormals {
    /// Cosine and sine of the angles at which the lines of an internode have their normals.
    #[must_use]
    pub fn angles(self) -> &'static [(f32, f32)] {
        const HALF_ROOT: f32 = 0.866_025_4;
        match self {
            Self::One => &[(1.0, 0.0)],
            Self::Three => &[(1.0, 0.0), (-0.5, HALF_ROOT), (-0.5, -HALF_ROOT)],
        }
    }

    /// How opaque each line is at a node of a radius, both in metres, so that all together are as opaque as
    /// their width is a part of what is `opaque`.
    #[must_use]
    pub fn alpha(self, radius: f32, opaque: f32) -> f32 {
        let width = 2.0 * radius;
        let alpha = if width < opaque {
            width / opaque
        } else if width > 0.0 {
            1.0
        } else {
            0.0
        };
        self.share(alpha)
    }

    /// How opaque each line is, so that all together are as opaque as this.
    #[must_use]
    pub fn share(self, alpha: f32) -> f32 {
        match self {
            Self::One => alpha,
            Self::Three => 1.0 - det::cbrt(1.0 - alpha),
        }
    }

    fn count(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Three => 3,
        }
    }
}

/// A node that stays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PolygonNode {
    pub(super) vector: SkeletalVector,
    /// From the branch's base, in metres.
    pub(super) along: f32,
    /// What merging moved the internode that ends here (`ψ`), in metres.
    pub(super) merged: f32,
}

/// What all polygons so far may deviate, and where the table did not reach.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Worst {
    /// Merging and polygons together, over all internodes, in metres.
    pub(super) surface: f32,
    /// The part of polygons between their end circles alone.
    pub(super) between: f32,
    /// Circles that should have more edges than the most.
    pub(super) clamped: u64,
}

/// The tables that turn nodes into polygons.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Polygons {
    pub(super) options: PolygonOptions,
    pub(super) edges: EdgeTable,
    connections: ConnectionTable,
    /// Cosine and sine of every corner of every polygon from three edges on.
    corners: Vec<Vec<(f32, f32)>>,
}

impl Polygons {
    pub(super) fn new(options: PolygonOptions) -> Self {
        let edges = EdgeTable::up_to(options.most_edges);
        let corners = (LEAST_EDGES..=edges.most()).map(|count| {
            let angle = |corner| std::f32::consts::TAU * corner as f32 / count as f32;
            let corners = (0..count).map(|corner: u32| det::sin_cos(angle(corner)));
            corners.map(|(sine, cosine)| (cosine, sine)).collect()
        });
        Self {
            options,
            connections: ConnectionTable::up_to(edges.most()),
            corners: corners.collect(),
            edges,
        }
    }

    /// How many primitives an internode has between circles of so many edges.
    pub(super) fn primitives(&self, start: u32, end: u32) -> u32 {
        match start.max(end) {
            1 => self.options.line_normals.count(),
            most => most,
        }
    }

    fn corners(&self, edges: u32) -> &[(f32, f32)] {
        &self.corners[(edges - LEAST_EDGES) as usize]
    }
}

/// Builds a mesh branch by branch.
#[derive(Debug)]
pub(super) struct Polygonizer<'a> {
    polygons: &'a Polygons,
    /// `E3`.
    error: f32,
    /// What a line of this width covers wholly.
    opaque: f32,
    pub(super) mesh: BranchMesh,
    pub(super) worst: Worst,
}

/// A node as far as it is drawn.
#[derive(Clone, Copy)]
struct Drawn {
    node: PolygonNode,
    /// Edges of its circle; 1 for a point.
    edges: u32,
    /// The first vertex of its ring, when it has one.
    ring: u32,
    /// The first vertex of its lines, when one ends here.
    lines: Option<u32>,
}

impl<'a> Polygonizer<'a> {
    /// For an error `E3` of polygons, at a level of the whole error `ε`.
    pub(super) fn new(polygons: &'a Polygons, error: f32, epsilon: f32) -> Self {
        let opaque = polygons.options.line_alpha.opaque_width(error, epsilon);
        Self {
            polygons,
            error,
            opaque,
            mesh: BranchMesh::default(),
            worst: Worst::default(),
        }
    }

    /// Adds a branch, given by the nodes that stay, from base to tip; at least two make a surface.
    pub(super) fn add(&mut self, nodes: &[PolygonNode]) {
        let [first, rest @ ..] = nodes else { return };
        if rest.is_empty() {
            return;
        }
        let mut start = self.drawn(first);
        if self.polygons.options.caps == Caps::Both {
            let tangent = first.vector.frame.tangent;
            self.cap(&start, -tangent, |here, next, middle| [next, here, middle]);
        }
        for node in rest {
            let mut end = self.drawn(node);
            let deviation = self.internode(&mut start, &mut end);
            let surface = node.merged + deviation.circles + deviation.between;
            let worst = &mut self.worst;
            worst.surface = worst.surface.max(surface);
            worst.between = worst.between.max(deviation.between);
            start = end;
        }
        let tangent = start.node.vector.frame.tangent;
        self.cap(&start, tangent, |here, next, middle| [here, next, middle]);
    }

    /// A node with its ring of corners, when it has one (eqs. A4 and A5, all the way around: the
    /// paper's angles end after half a turn).
    fn drawn(&mut self, node: &PolygonNode) -> Drawn {
        let edges = self.polygons.edges.edges(node.vector.radius, self.error);
        self.worst.clamped += u64::from(edges.clamped);
        let ring = index_u32(self.mesh.vertices.len());
        if edges.count >= LEAST_EDGES {
            for (corner, &(cosine, sine)) in (0_u32..).zip(self.polygons.corners(edges.count)) {
                let turns = 2.0 * corner as f32 / edges.count as f32;
                self.mesh.vertices.push(BranchVertex {
                    position: node.vector.position + node.vector.spoke(cosine, sine),
                    normal: radial(&node.vector, cosine, sine),
                    texture: Vec2::new((turns - 1.0).abs(), node.along),
                    alpha: 1.0,
                });
            }
        }
        Drawn {
            node: *node,
            edges: edges.count,
            ring,
            lines: None,
        }
    }

    fn internode(&mut self, start: &mut Drawn, end: &mut Drawn) -> Deviation {
        let table = &self.polygons.edges;
        let radii = [&*start, &*end].map(|end| end.node.vector.radius);
        let sagitta = table
            .sagitta(start.edges, radii[0])
            .max(table.sagitta(end.edges, radii[1]));
        let point = |end: &Drawn, radius: f32| if end.edges == 1 { radius } else { 0.0 };
        let points = point(start, radii[0]).max(point(end, radii[1]));
        let circles = sagitta.max(points);
        let between = match (start.edges, end.edges) {
            (1, 1) => {
                self.line(start, end);
                0.0
            }
            (1, _) => {
                let apex = self.apex(start, -start.node.vector.frame.tangent);
                self.fan(end, apex, |here, next, apex| [next, here, apex]);
                0.0
            }
            (_, 1) => {
                let apex = self.apex(end, end.node.vector.frame.tangent);
                self.fan(start, apex, |here, next, apex| [here, next, apex]);
                0.0
            }
            _ => self.prismoid(start, end),
        };
        Deviation { circles, between }
    }

    /// The sides between two rings; what they may deviate between their circles.
    fn prismoid(&mut self, start: &Drawn, end: &Drawn) -> f32 {
        let (few, many) = (start.edges.min(end.edges), start.edges.max(end.edges));
        let starts_with_few = start.edges == few;
        let connection = self.polygons.connections.between(few, many);
        let corner = |ring: &Drawn, corner: u32| ring.ring + corner % ring.edges;
        let mut worst = 0.0_f32;
        for &side in &connection.sides {
            match side {
                Side::Quad { few, many } => {
                    let (low, high) = if starts_with_few {
                        (few, many)
                    } else {
                        (many, few)
                    };
                    let low = [low, low + 1].map(|place| corner(start, place));
                    let high = [high, high + 1].map(|place| corner(end, place));
                    let at = |vertex: u32| self.mesh.vertices[vertex as usize].position;
                    worst = worst.max(split(low.map(at), high.map(at)));
                    self.mesh.quads.push([low[0], low[1], high[1], high[0]]);
                }
                Side::Triangle { few, many } => {
                    let (fine, coarse) = if starts_with_few {
                        (end, start)
                    } else {
                        (start, end)
                    };
                    let edge = [many, many + 1].map(|place| corner(fine, place));
                    let apex = corner(coarse, few);
                    self.mesh.triangles.push(if starts_with_few {
                        [apex, edge[1], edge[0]]
                    } else {
                        [edge[0], edge[1], apex]
                    });
                }
            }
        }
        turned(&start.node.vector, &end.node.vector, connection) + worst
    }

    fn apex(&mut self, end: &Drawn, normal: Vec3) -> u32 {
        self.mesh.vertices.push(BranchVertex {
            position: end.node.vector.position,
            normal,
            texture: Vec2::new(0.5, end.node.along),
            alpha: 1.0,
        });
        index_u32(self.mesh.vertices.len() - 1)
    }

    fn cap(&mut self, end: &Drawn, normal: Vec3, triangle: impl Fn(u32, u32, u32) -> [u32; 3]) {
        if end.edges >= LEAST_EDGES {
            let middle = self.apex(end, normal);
            self.fan(end, middle, triangle);
        }
    }

    /// A triangle from every edge of a ring to a point.
    fn fan(&mut self, ring: &Drawn, point: u32, triangle: impl Fn(u32, u32, u32) -> [u32; 3]) {
        for corner in 0..ring.edges {
            let next = (corner + 1) % ring.edges;
            let triangle = triangle(ring.ring + corner, ring.ring + next, point);
            self.mesh.triangles.push(triangle);
        }
    }

    fn line(&mut self, start: &mut Drawn, end: &mut Drawn) {
        let [from, to] = [start, end].map(|end| {
            let first = match end.lines {
                Some(first) => first,
                None => self.line_end(&end.node),
            };
            end.lines = Some(first);
            first
        });
        let lines = 0..self.polygons.options.line_normals.count();
        self.mesh
            .lines
            .extend(lines.map(|line| [from + line, to + line]));
    }

    fn line_end(&mut self, node: &PolygonNode) -> u32 {
        let first = index_u32(self.mesh.vertices.len());
        let normals = self.polygons.options.line_normals;
        let alpha = match self.polygons.options.line_alpha {
            LineAlpha::Width => 2.0 * node.vector.radius,
            LineAlpha::Paper | LineAlpha::Coverage { .. } => {
                normals.alpha(node.vector.radius, self.opaque)
            }
        };
        let vertices = normals.angles().iter().map(|&(cosine, sine)| BranchVertex {
            position: node.vector.position,
            normal: radial(&node.vector, cosine, sine),
            texture: Vec2::new(0.5, node.along),
            alpha,
        });
        self.mesh.vertices.extend(vertices);
        first
    }
}
