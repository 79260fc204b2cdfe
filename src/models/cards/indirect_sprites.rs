//! Sprites: pictures of one leaf of each kind, turned by steps, from its front and from its back.

use super::bake::{BakeSites, BakeView, Rectangle, ViewFrame};
use super::bake_resolve::{BakedView, byte};
use super::triangles::LeafTriangles;
use crate::math::{Vec2, Vec3, det, index_u32};

/// A leaf as a map has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LeafShape {
    /// Its kind: the number of its group.
    pub(super) kind: u32,
    /// The mean of its triangles' corners, in the plant's space.
    pub(super) centre: Vec3,
    /// Along the first edge of its first triangle, of unit length.
    pub(super) axis: Vec3,
    /// The normal of its first triangle, of unit length.
    pub(super) normal: Vec3,
    /// How far its farthest corner lies from the centre, in metres.
    pub(super) reach: f32,
}

/// The shapes of all leaf sites.
pub(super) fn leaf_shapes(leaves: &LeafTriangles) -> Vec<LeafShape> {
    (0..leaves.site_count())
        .map(|site| leaf_shape(leaves, site))
        .collect()
}

fn leaf_shape(leaves: &LeafTriangles, site: u32) -> LeafShape {
    let triangles = leaves.of_site(site);
    let corners = || triangles.iter().flat_map(|triangle| triangle.positions);
    let count = (3 * triangles.len()).max(1) as f32;
    let centre = corners().fold(Vec3::ZERO, |sum, corner| sum + corner) / count;
    let first = triangles.first();
    let normal = first.map_or(Vec3::Y, |triangle| {
        let [a, b, c] = triangle.positions;
        (b - a).cross(c - a).normalize_or(Vec3::Y)
    });
    let axis = first.map_or(Vec3::X, |triangle| {
        let [a, b, _] = triangle.positions;
        (b - a).normalize_or(normal.any_orthonormal_vector())
    });
    LeafShape {
        kind: first.map_or(0, |triangle| triangle.group),
        centre,
        axis,
        normal,
        reach: corners().fold(0.0, |most: f32, corner| most.max(corner.distance(centre))),
    }
}

/// By which angles sprites are turned.
///
/// Sprite `(kind · 2 + face) · steps + step` shows a leaf of that kind from its front (face 0) or back
/// (1), with its [axis](LeafShape::axis) turned counter-clockwise by `step / steps` of a full turn from
/// where columns go. A leaf is off its sprite by half a step at the most.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SpriteTurns {
    /// The directions of the axis, step by step.
    directions: Vec<Vec2>,
}

impl SpriteTurns {
    pub(super) fn new(steps: u32) -> Self {
        let direction = |step: u32| {
            let (sin, cos) = det::sin_cos(std::f32::consts::TAU * step as f32 / steps as f32);
            Vec2::new(cos, sin)
        };
        Self {
            directions: (0..steps.max(1)).map(direction).collect(),
        }
    }

    /// The sprite that shows a leaf best in a frame, the first of equals; and the cosine of the angle
    /// between both. A leaf seen along its axis has step 0.
    pub(super) fn nearest(&self, leaf: &LeafShape, frame: &ViewFrame) -> (u32, f32) {
        let seen = Vec2::new(leaf.axis.dot(frame.right), leaf.axis.dot(frame.up));
        let seen = seen.normalize_or(Vec2::X);
        let mut best = (0, f32::NEG_INFINITY);
        for (step, direction) in (0..).zip(&self.directions) {
            let cosine = seen.dot(*direction);
            if cosine > best.1 {
                best = (step, cosine);
            }
        }
        let face = u32::from(leaf.normal.dot(frame.toward) < 0.0);
        let sprite = (2 * leaf.kind + face) * index_u32(self.directions.len()) + best.0;
        (sprite, best.1.min(1.0))
    }

    /// What is baked, in the order of sprites: of each kind the leaf of median reach, the first of
    /// equals, in the square that holds it however it is turned.
    pub(super) fn views(
        &self,
        leaves: &LeafTriangles,
        shapes: &[LeafShape],
        texture: u32,
    ) -> Vec<BakeView> {
        let mut views = Vec::new();
        for (kind, _) in (0..).zip(leaves.groups()) {
            let mut of_kind: Vec<u32> = (0..leaves.site_count())
                .filter(|&site| shapes[site as usize].kind == kind)
                .collect();
            of_kind.sort_by(|&a, &b| {
                let reach = |site: u32| shapes[site as usize].reach;
                reach(a).total_cmp(&reach(b)).then(a.cmp(&b))
            });
            let median = of_kind.get(of_kind.len() / 2).copied();
            for face in [1.0, -1.0] {
                for direction in &self.directions {
                    views.push(view(shapes, median, face, *direction, texture));
                }
            }
        }
        views
    }
}

fn view(
    shapes: &[LeafShape],
    site: Option<u32>,
    face: f32,
    direction: Vec2,
    texture: u32,
) -> BakeView {
    let shape = site.and_then(|site| shapes.get(site as usize));
    let [centre, axis, normal] = shape.map_or([Vec3::ZERO, Vec3::X, Vec3::Z], |shape| {
        [shape.centre, shape.axis, shape.normal]
    });
    let toward = face * normal;
    let across = toward.cross(axis);
    let reach = shape.map_or(1.0, |shape| shape.reach);
    BakeView {
        sites: BakeSites::Listed(site.into_iter().collect()),
        frame: ViewFrame {
            origin: centre,
            right: direction.x * axis - direction.y * across,
            up: direction.y * axis + direction.x * across,
            toward,
        },
        rectangle: Rectangle {
            least: Vec2::splat(-reach),
            greatest: Vec2::splat(reach),
        },
        size: [texture; 2],
    }
}

/// A baked view with its normals along the axes of its frame in place of the plant's: right, up, toward.
pub(super) fn in_frame(mut view: BakedView, frame: &ViewFrame) -> BakedView {
    for texel in view.normals.as_chunks_mut::<4>().0 {
        let [x, y, z, _] = texel.map(|byte| (f32::from(byte) - 127.5) / 127.5);
        let normal = Vec3::new(x, y, z);
        let axes = [frame.right, frame.up, frame.toward];
        for (channel, axis) in texel.iter_mut().zip(axes) {
            *channel = byte(127.5 * normal.dot(axis) + 127.5);
        }
    }
    view
}
