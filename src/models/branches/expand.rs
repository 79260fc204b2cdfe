//! What a vertex stage makes of an internode: the polygons and lines that the host would make, vertex for
//! vertex.

use std::sync::LazyLock;

use crate::gpu::Geometry;
use crate::math::{Vec2, Vec3, det, index_u32};
use crate::models::environment::{Placement, View};
use crate::simplify::{
    BranchVertex, EdgeTable, LEAST_EDGES, LineAlpha, LineNormals, MOST_EDGES, Side, SkeletalVector,
    radial, sides,
};

/// `P_h` for all numbers of edges: constants of the program.
static EDGES: LazyLock<EdgeTable> = LazyLock::new(|| EdgeTable::up_to(MOST_EDGES));

/// A node as an internode's end.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    pub(super) vector: SkeletalVector,
    /// From the branch's base, in metres.
    pub(super) along: f32,
    /// The number of its ring's first corner; those of others count up.
    pub(super) ring: u32,
}

/// An internode of a level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ends {
    pub(super) start: End,
    pub(super) end: End,
    /// The number of its apex, when it has one; after it comes that of its cap.
    pub(super) apex: u32,
    /// Whether the branch ends here.
    pub(super) is_tip: bool,
}

/// How many edges a node's circle has.
pub(super) fn edges(radius: f32, error: f32, most: u32) -> u32 {
    EDGES.edges(radius, error).count.min(most.max(LEAST_EDGES))
}

impl Ends {
    /// Emits its polygons, if it has any, with the numbers that keep the order of the host's vertices.
    pub(super) fn polygons(
        &self,
        (error, most): (f32, u32),
        (view, placement): (&View, &Placement),
        geometry: &mut Geometry,
    ) {
        let count = |end: &End| edges(end.vector.radius, error, most);
        let counts = [count(&self.start), count(&self.end)];
        let mut emitter = Emitter {
            view,
            placement,
            geometry,
        };
        match counts {
            [1, 1] => {}
            [1, last] => {
                let ring = emitter.ring(&self.end, last);
                let normal = -self.start.vector.frame.tangent;
                let apex = emitter.point(&self.start, normal, self.apex);
                emitter.fan(ring, last, |here, next| [next, here, apex]);
                self.cap(&mut emitter, ring, last);
            }
            [first, 1] => {
                let ring = emitter.ring(&self.start, first);
                let normal = self.end.vector.frame.tangent;
                let apex = emitter.point(&self.end, normal, self.apex);
                emitter.fan(ring, first, |here, next| [here, next, apex]);
            }
            [first, last] => {
                let rings = [
                    emitter.ring(&self.start, first),
                    emitter.ring(&self.end, last),
                ];
                emitter.prismoid(rings, counts);
                self.cap(&mut emitter, rings[1], last);
            }
        }
    }

    fn cap(&self, emitter: &mut Emitter<'_>, ring: u32, count: u32) {
        if self.is_tip {
            let normal = self.end.vector.frame.tangent;
            let middle = emitter.point(&self.end, normal, self.apex + 1);
            emitter.fan(ring, count, |here, next| [here, next, middle]);
        }
    }

    /// The ends of its lines, one pair a normal; none where it has polygons. A line is opaque from `opaque`
    /// metres of width on, where it is the level that decides.
    pub(super) fn lines(
        &self,
        (error, most): (f32, u32),
        (normals, alpha, opaque): (LineNormals, LineAlpha, f32),
    ) -> impl Iterator<Item = [BranchVertex; 2]> {
        let ends = [self.start, self.end];
        let is_line = ends
            .iter()
            .all(|end| edges(end.vector.radius, error, most) == 1);
        let angles = if is_line { normals.angles() } else { &[] };
        angles.iter().map(move |&(cosine, sine)| {
            ends.map(|end| BranchVertex {
                position: end.vector.position,
                normal: radial(&end.vector, cosine, sine),
                texture: Vec2::new(0.5, end.along),
                alpha: match alpha {
                    LineAlpha::Width => 2.0 * end.vector.radius,
                    LineAlpha::Paper | LineAlpha::Coverage { .. } => {
                        normals.alpha(end.vector.radius, opaque)
                    }
                },
            })
        })
    }
}

/// Vertices and triangles as the program of meshes emits them.
struct Emitter<'a> {
    view: &'a View,
    placement: &'a Placement,
    geometry: &'a mut Geometry,
}

impl Emitter<'_> {
    fn vertex(&mut self, position: Vec3, normal: Vec3, texture: Vec2, id: u32) -> u32 {
        let world = self.placement.to_world(position);
        let normal = self.placement.rotation * normal;
        let geometry = &mut *self.geometry;
        let clip = self.view.clip_from_world * world.extend(1.0);
        geometry.clip.push(clip);
        let varyings = [texture.x, texture.y, normal.x, normal.y, normal.z];
        geometry.varyings.extend(varyings);
        geometry.vertex_ids.push(id);
        index_u32(geometry.clip.len() - 1)
    }

    /// The corners of a ring; the first one's place.
    fn ring(&mut self, end: &End, count: u32) -> u32 {
        let first = index_u32(self.geometry.clip.len());
        for corner in 0..count {
            let angle = std::f32::consts::TAU * corner as f32 / count as f32;
            let (sine, cosine) = det::sin_cos(angle);
            let turns = 2.0 * corner as f32 / count as f32;
            self.vertex(
                end.vector.position + end.vector.spoke(cosine, sine),
                radial(&end.vector, cosine, sine),
                Vec2::new((turns - 1.0).abs(), end.along),
                end.ring + corner,
            );
        }
        first
    }

    fn point(&mut self, end: &End, normal: Vec3, id: u32) -> u32 {
        let texture = Vec2::new(0.5, end.along);
        self.vertex(end.vector.position, normal, texture, id)
    }

    /// A triangle from every edge of a ring.
    fn fan(&mut self, ring: u32, count: u32, triangle: impl Fn(u32, u32) -> [u32; 3]) {
        for corner in 0..count {
            let next = (corner + 1) % count;
            let corners = triangle(ring + corner, ring + next);
            self.geometry.corners.extend(corners);
        }
    }

    /// The sides between two rings.
    fn prismoid(&mut self, rings: [u32; 2], counts: [u32; 2]) {
        let (few, many) = (counts[0].min(counts[1]), counts[0].max(counts[1]));
        // Which ring has the fewer edges.
        let coarse = usize::from(counts[0] != few);
        let corner = |ring: usize, corner: u32| rings[ring] + corner % counts[ring];
        for side in sides(few, many) {
            match side {
                Side::Quad { few, many } => {
                    let starts = if coarse == 0 {
                        [few, many]
                    } else {
                        [many, few]
                    };
                    let [a, b] = [0, 1].map(|step| corner(0, starts[0] + step));
                    let [d, c] = [0, 1].map(|step| corner(1, starts[1] + step));
                    self.geometry.corners.extend([a, b, c, a, c, d]);
                }
                Side::Triangle { few, many } => {
                    let [here, next] = [0, 1].map(|step| corner(1 - coarse, many + step));
                    let apex = corner(coarse, few);
                    self.geometry.corners.extend(if coarse == 0 {
                        [apex, next, here]
                    } else {
                        [here, next, apex]
                    });
                }
            }
        }
    }
}
