//! A small trunk for tests.

use std::sync::Arc;

use super::Trunk;
use crate::math::{Vec2, Vec3, index_u32};
use crate::plant::{Foliage, Material, Mesh, Plant};

/// A bent tube of `rings` rings with `edges` corners each, closed by a fan; all of it may go.
pub(super) fn branch(rings: u32, edges: u32) -> Trunk {
    let mut mesh = Mesh {
        positions: Vec::new(),
        normals: Vec::new(),
        texture_coordinates: Vec::new(),
        indices: Vec::new(),
        material: Material {
            name: "bark".to_owned(),
            base_color: [0.5, 0.4, 0.3, 1.0],
            texture: None,
            alpha_cutoff: 0.0,
        },
    };
    let mut vertex = |position: Vec3, normal: Vec3| {
        mesh.positions.push(position);
        mesh.normals.push(normal);
        mesh.texture_coordinates
            .push(Vec2::new(position.x, position.y));
    };
    for ring in 0..rings {
        let height = ring as f32 / rings as f32;
        let radius = 0.3 - 0.2 * height;
        for edge in 0..edges {
            let angle = std::f32::consts::TAU * edge as f32 / edges as f32;
            let (sine, cosine) = crate::math::det::sin_cos(angle);
            let out = Vec3::new(cosine, 0.0, sine);
            vertex(Vec3::new(height * height, height, 0.0) + radius * out, out);
        }
    }
    vertex(Vec3::new(1.0, 1.0, 0.0), Vec3::Y);
    for ring in 1..rings {
        for edge in 0..edges {
            let next = (edge + 1) % edges;
            let (below, above) = ((ring - 1) * edges, ring * edges);
            let [a, b, c, d] = [below + edge, below + next, above + next, above + edge];
            mesh.indices.extend([a, d, c, a, c, b]);
        }
    }
    let tip = index_u32(mesh.positions.len()) - 1;
    for edge in 0..edges {
        let last = (rings - 1) * edges;
        mesh.indices
            .extend([last + edge, tip, last + (edge + 1) % edges]);
    }
    let plant = Plant::new("branch", None, Some(mesh), Foliage::default()).expect("sound parts");
    Trunk::of(&Arc::new(plant), Some(0)).expect("it has a trunk")
}
