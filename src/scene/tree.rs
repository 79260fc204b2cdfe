//! A tree of a scene: where it comes from and where it stands.

use crate::math::{Digest, Mat4, Vec3, Vec4, det};
use crate::plant::import::{ImportOptions, Reading};

/// One tree.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    /// Where it comes from.
    pub source: PlantSource,
    /// The seed it grows from.
    pub seed: u64,
    /// Where the base of its trunk stands: world space, metres.
    pub at: Vec3,
    /// The turn about +Y in degrees, counter-clockwise seen from above.
    pub turn: f32,
    /// The factor on its size.
    pub scale: f32,
    /// What [`Plant::digest`](crate::plant::Plant::digest) must be; a run refuses another plant,
    /// and writes what it found to `scene.resolved.toml`.
    pub plant_digest: Option<Digest>,
}

/// Where a tree comes from; paths are relative to the scene file, with `/` between the parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PlantSource {
    /// Grown from a species file.
    Species(String),
    /// Imported.
    File {
        /// The file.
        path: String,
        /// Names of groups, objects, meshes or materials that are foliage; empty leaves it to the
        /// importer.
        foliage: Vec<String>,
        /// How the file is to be read where it does not say it, or says it wrongly.
        reading: Reading,
    },
}

impl Tree {
    /// What an importer is told of the tree's file; nothing where it has a species.
    #[must_use]
    pub fn import_options(&self) -> ImportOptions {
        let (foliage, reading) = match &self.source {
            PlantSource::Species(_) => (Vec::new(), Reading::default()),
            PlantSource::File {
                foliage, reading, ..
            } => (foliage.clone(), *reading),
        };
        ImportOptions {
            reading,
            foliage,
            seed: self.seed,
        }
    }

    /// The matrix from the plant's space to world space: scaled, then turned, then moved.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "rounded once, at the end")]
    pub fn world_from_plant(&self) -> Mat4 {
        // In double precision, so that quarter turns leave less than half an ulp of the wrong axis.
        let angle = f64::from(self.turn) * (std::f64::consts::PI / 180.0);
        let (sine, cosine) = (det::sin_f64(angle) as f32, det::cos_f64(angle) as f32);
        let scale = self.scale;
        Mat4::from_cols(
            Vec4::new(scale * cosine, 0.0, -scale * sine, 0.0),
            Vec4::new(0.0, scale, 0.0, 0.0),
            Vec4::new(scale * sine, 0.0, scale * cosine, 0.0),
            self.at.extend(1.0),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_is_scaled_turned_and_moved() {
        let tree = Tree {
            source: PlantSource::Species("a.toml".to_owned()),
            seed: 0,
            at: Vec3::new(10.0, 0.0, 0.0),
            turn: 90.0,
            scale: 2.0,
            plant_digest: None,
        };
        let world = tree.world_from_plant();
        // Counter-clockwise seen from above takes +X to −Z.
        let moved = world.transform_point3(Vec3::X);
        assert!(moved.distance(Vec3::new(10.0, 0.0, -2.0)) < 1e-6, "{moved}");
        assert_eq!(
            world.transform_point3(Vec3::Y),
            Vec3::new(10.0, 2.0, 0.0),
            "up stays up"
        );
    }
}
