//! Impostors as meshes and an atlas, for other programs.

use super::atlas::AtlasCell;
use super::impostors_outline::OutlineCorner;
use super::impostors_set::{CARD_ALPHA_CUTOFF, ImpostorSet};
use crate::gpu::GpuError;
use crate::math::{Vec2, index_u32};
use crate::models::Crown;
use crate::plant::{Material, Mesh, Texture};
use crate::scene::{CardOptions, CardSides};

/// The impostors of a level as polygons.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpostorMesh {
    /// How many impostors there are.
    pub impostors: u32,
    /// Their polygons, fans of triangles in the plant's space; those that show the back are counter-clockwise
    /// seen from behind. All levels share one texture.
    pub mesh: Mesh,
    /// Whether the mesh has polygons of its own for the back.
    pub sides: CardSides,
}

/// The [leaf cluster impostors](crate::references) of a crown, a mesh a level, the finest first; none
/// without leaves that have triangles.
///
/// What crosses between levels as the camera moves is left out: the polygons lie in their own planes.
///
/// # Errors
///
/// [`GpuError`] where their pictures do not fit the device of the bake, or not one texture together.
pub fn impostor_meshes(
    crown: &Crown,
    options: &CardOptions,
) -> Result<Vec<ImpostorMesh>, GpuError> {
    let set = ImpostorSet::of(crown, options)?;
    let Some(atlas) = &set.atlas else {
        return Ok(Vec::new());
    };
    let [width, height] = atlas.size;
    let colour = Texture::new(width, height, atlas.colour[0].clone());
    let colour = colour.ok_or_else(|| GpuError::Unsupported {
        what: format!("an atlas of {width} × {height} texels as a texture"),
    })?;
    let material = Material {
        name: "impostors".to_owned(),
        base_color: [1.0; 4],
        texture: Some(colour),
        alpha_cutoff: CARD_ALPHA_CUTOFF,
    };
    let views = atlas.cells.len() / set.impostors.len().max(1);
    let level = |level: u32| {
        let mut mesh = Mesh {
            positions: Vec::new(),
            normals: Vec::new(),
            texture_coordinates: Vec::new(),
            indices: Vec::new(),
            material: material.clone(),
        };
        let mut impostors = 0;
        for (number, impostor) in set.impostors.iter().enumerate() {
            if impostor.level != level {
                continue;
            }
            impostors += 1;
            let corners = &set.outlines[number].corners;
            let cells = &atlas.cells[views * number..views * (number + 1)];
            for (cell, toward) in cells
                .iter()
                .zip([impostor.frame.toward, -impostor.frame.toward])
            {
                let faces_back = toward != impostor.frame.toward;
                polygon(corners, cell, atlas.size, faces_back, &mut mesh);
                let missing = mesh.positions.len() - mesh.normals.len();
                mesh.normals.extend(std::iter::repeat_n(toward, missing));
            }
        }
        ImpostorMesh {
            impostors,
            mesh,
            sides: options.sides,
        }
    };
    Ok((0..set.levels).map(level).collect())
}

/// Adds a convex polygon as a fan.
fn polygon(
    corners: &[OutlineCorner],
    cell: &AtlasCell,
    size: [u32; 2],
    faces_back: bool,
    mesh: &mut Mesh,
) {
    let first = index_u32(mesh.positions.len());
    let texel = Vec2::new(1.0 / size[0] as f32, 1.0 / size[1] as f32);
    for corner in corners {
        mesh.positions.push(corner.position);
        let coordinate = cell.clamped(corner.coordinate, texel);
        mesh.texture_coordinates.push(coordinate);
    }
    for second in 1..index_u32(corners.len()).saturating_sub(1) {
        let [a, b, c] = [0, second, second + 1].map(|corner| first + corner);
        mesh.indices
            .extend(if faces_back { [a, c, b] } else { [a, b, c] });
    }
}
