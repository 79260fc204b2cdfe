//! Triangle meshes, and what surfaces look like.

use super::{PlantError, Texture};
use crate::limits;
use crate::math::{Digester, Vec2, Vec3, index_u32};

/// What a surface looks like.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// A name, for reports and export; not part of any digest.
    pub name: String,
    /// Linear colour that multiplies the texture's, with alpha.
    pub base_color: [f32; 4],
    /// The image, if the surface has one.
    pub texture: Option<Texture>,
    /// Texels with alpha below this are not there; 0 keeps all.
    pub alpha_cutoff: f32,
}

impl Material {
    /// A plain opaque surface of one linear colour.
    #[must_use]
    pub fn plain(name: impl Into<String>, color: [f32; 3]) -> Self {
        let [r, g, b] = color;
        Self {
            name: name.into(),
            base_color: [r, g, b, 1.0],
            texture: None,
            alpha_cutoff: 0.0,
        }
    }

    pub(super) fn check(&self, part: &str) -> Result<(), PlantError> {
        let numbers = self.base_color.iter().chain([&self.alpha_cutoff]);
        for (place, value) in numbers.enumerate() {
            if !value.is_finite() || *value < 0.0 {
                return Err(PlantError::Number {
                    part: part.to_owned(),
                    place,
                    value: value.to_string(),
                    wanted: "finite, not negative",
                });
            }
        }
        Ok(())
    }

    pub(super) fn digest_into(&self, digester: &mut Digester) {
        for channel in self.base_color {
            digester.f32(channel);
        }
        match &self.texture {
            None => _ = digester.u32(0),
            Some(texture) => texture.digest_into(digester.u32(1)),
        }
        digester.f32(self.alpha_cutoff);
    }
}

/// Indexed triangles with a normal and a texture coordinate at each vertex.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// World-space positions.
    pub positions: Vec<Vec3>,
    /// Unit normals, one a position.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, one a position; (0, 0) is the texture's top-left corner, and the
    /// texture repeats.
    pub texture_coordinates: Vec<Vec2>,
    /// Three vertex indices a triangle, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
    /// What it looks like.
    pub material: Material,
}

impl Mesh {
    /// How many triangles there are.
    #[must_use]
    pub fn triangle_count(&self) -> u32 {
        index_u32(self.indices.len() / 3)
    }

    pub(super) fn check(&self) -> Result<(), PlantError> {
        let part = || "trunk".to_owned();
        let count = self.positions.len();
        if count > limits::PLANT_VERTICES {
            let limit = limits::PLANT_VERTICES;
            return Err(PlantError::TooMany {
                part: part(),
                what: "vertices",
                found: count,
                limit,
            });
        }
        for (what, found, wanted) in [
            ("normals", self.normals.len(), count),
            ("texture coordinates", self.texture_coordinates.len(), count),
            ("indices", self.indices.len(), self.indices.len() / 3 * 3),
        ] {
            if found != wanted {
                return Err(PlantError::Length {
                    part: part(),
                    what,
                    found,
                    wanted,
                });
            }
        }
        for (place, &index) in self.indices.iter().enumerate() {
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
        for place in 0..count {
            let (position, normal) = (self.positions[place], self.normals[place]);
            let coordinate = self.texture_coordinates[place];
            if !position.is_finite() || !normal.is_finite() || !coordinate.is_finite() {
                return Err(PlantError::Number {
                    part: part(),
                    place,
                    value: format!("{position} {normal} {coordinate}"),
                    wanted: "finite",
                });
            }
        }
        self.material.check("trunk material")
    }

    pub(super) fn digest_into(&self, digester: &mut Digester) {
        digester.u64(self.positions.len() as u64);
        for position in &self.positions {
            digester.vec3(*position);
        }
        for normal in &self.normals {
            digester.vec3(*normal);
        }
        for coordinate in &self.texture_coordinates {
            digester.f32(coordinate.x).f32(coordinate.y);
        }
        digester.u64(self.indices.len() as u64);
        for &index in &self.indices {
            digester.u32(index);
        }
        self.material.digest_into(digester);
    }
}
