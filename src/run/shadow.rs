//! Where the light of a scene with shadows looks, and what leads from a frame's pixels to its map.

use super::RunError;
use super::world::World;
use crate::gpu::{Device, GpuError};
use crate::math::{Aabb, DMat4, DVec3, DVec4, Mat4, Vec3};
use crate::models::{Environment, Kind};
use crate::scene::{Scene, View};

/// The shadows of a session.
#[derive(Debug)]
pub(super) struct Shadows {
    asked: crate::scene::Shadow,
    /// To the right and upwards as the light sees it, and away from it.
    axes: [DVec3; 3],
    /// The least and the greatest coordinate along each axis of all that stands.
    range: [[f64; 2]; 3],
    /// What was sent last.
    sent: Option<(Mat4, Mat4)>,
}

/// What is added around all that stands, as a share of its size along each axis: what stands in for
/// leaves may reach a little farther than they.
const MARGIN: f64 = 0.05;

impl Shadows {
    /// The shadows that a scene asks for; makes their map.
    ///
    /// # Errors
    ///
    /// [`GpuError::OutOfMemory`], or [`GpuError::Unsupported`] for a kind that leaves out what the
    /// camera does not see.
    pub(super) fn new(
        scene: &Scene,
        world: &World,
        kind: Kind,
        device: &mut Device,
        environment: &mut Environment,
    ) -> Result<Option<Self>, RunError> {
        let Some(asked) = scene.shadow else {
            return Ok(None);
        };
        if kind.selects() {
            let what = format!(
                "[shadow] with {}, which leaves out what the camera does not see,",
                kind.label()
            );
            return Err(GpuError::Unsupported { what }.into());
        }
        environment.cast_shadows(device, asked.size)?;
        let axes = axes(scene.light.towards());
        let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        for point in corners(world) {
            for ([least, greatest], axis) in range.iter_mut().zip(axes) {
                let at = axis.dot(point.as_dvec3());
                *least = least.min(at);
                *greatest = greatest.max(at);
            }
        }
        for range in &mut range {
            let [least, greatest] = *range;
            // Where nothing stands there is nothing to see; a metre keeps numbers sound.
            let size = if greatest > least {
                greatest - least
            } else {
                1.0
            };
            let least = if least.is_finite() { least } else { 0.0 };
            *range = [least - MARGIN * size, least + (1.0 + MARGIN) * size];
        }
        Ok(Some(Self {
            asked,
            axes,
            range,
            sent: None,
        }))
    }

    /// Sends what a view changes.
    ///
    /// # Errors
    ///
    /// None on this session's own device.
    pub(super) fn send(
        &mut self,
        device: &mut Device,
        environment: &Environment,
        view: &View,
    ) -> Result<(), RunError> {
        let (light, side) = self.light(view);
        let matrix = self.map_from_pixel(view, &light, side);
        let (sent_light, sent_matrix) = self.sent.unzip();
        let mut queue = device.queue();
        if sent_light != Some(light) {
            environment.set_light(&mut queue, &light)?;
        }
        if sent_matrix != Some(matrix) {
            environment.set_shadow(&mut queue, &matrix)?;
        }
        self.sent = Some((light, matrix));
        Ok(())
    }

    /// World space to the clip space of the map, and the side of the square that it covers in metres.
    ///
    /// The square is the least around all that stands, or that before the eye: then its middle is the
    /// nearest whole texel to half its side along the view, so that the map does not swim.
    fn light(&self, view: &View) -> (Mat4, f64) {
        let [x, y, depth] = self.range;
        let whole = (x[1] - x[0]).max(y[1] - y[0]);
        let extent = self.asked.extent.map(f64::from);
        let side = extent.map_or(whole, |extent| extent.min(whole));
        let middle = if side < whole {
            let texel = side / f64::from(self.asked.size);
            let ahead = view.eye.as_dvec3() + view.direction.as_dvec3() * (0.5 * side);
            [0, 1].map(|axis| (self.axes[axis].dot(ahead) / texel).round() * texel)
        } else {
            [x, y].map(|[least, greatest]| 0.5 * (least + greatest))
        };
        let deep = 1.0 / (depth[1] - depth[0]);
        let rows = [
            (self.axes[0] * (2.0 / side)).extend(-middle[0] * 2.0 / side),
            (self.axes[1] * (2.0 / side)).extend(-middle[1] * 2.0 / side),
            (self.axes[2] * deep).extend(-depth[0] * deep),
            DVec4::W,
        ];
        let clip = DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
        (clip.as_mat4(), side)
    }

    /// What [`Environment::set_shadow`] wants: back from the frame's pixels to the world, and from there
    /// into the map, less the bias.
    fn map_from_pixel(&self, view: &View, light: &Mat4, side: f64) -> Mat4 {
        let [width, height] = view.viewport.map(f64::from);
        let size = f64::from(self.asked.size);
        let [_, _, depth] = self.range;
        let bias = f64::from(self.asked.bias) * (side / size) / (depth[1] - depth[0]);
        let clip_from_pixel = DMat4::from_cols(
            DVec4::new(2.0 / width, 0.0, 0.0, 0.0),
            DVec4::new(0.0, -2.0 / height, 0.0, 0.0),
            DVec4::new(0.0, 0.0, -1.0, 0.0),
            DVec4::new(-1.0, 1.0, 1.0, 1.0),
        );
        let map_from_clip = DMat4::from_cols(
            DVec4::new(0.5 * size, 0.0, 0.0, 0.0),
            DVec4::new(0.0, -0.5 * size, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 1.0, 0.0),
            DVec4::new(0.5 * size, 0.5 * size, -bias, 1.0),
        );
        let world_from_clip = view.clip_from_world.as_dmat4().inverse();
        (map_from_clip * light.as_dmat4() * world_from_clip * clip_from_pixel).as_mat4()
    }
}

/// To the right, upwards, and away from a light in that direction.
fn axes(towards: Vec3) -> [DVec3; 3] {
    let towards = towards.as_dvec3();
    let up = if towards.y.abs() > 0.99 {
        DVec3::X
    } else {
        DVec3::Y
    };
    let right = up.cross(towards).normalize();
    [right, towards.cross(right), -towards]
}

/// The corners of the boxes of all that stands.
fn corners(world: &World) -> impl Iterator<Item = Vec3> {
    let trees = world.trees.iter().flat_map(|tree| {
        let crown = &world.crowns[tree.crown];
        let bounds = crown.bounds().union(crown.plant().bounds());
        corners_of(bounds).map(|corner| tree.placement.to_world(corner))
    });
    let ground = world.ground.iter();
    trees.chain(ground.flat_map(|mesh| mesh.positions.iter().copied()))
}

fn corners_of(bounds: Aabb) -> impl Iterator<Item = Vec3> {
    let some = if bounds.is_empty() { 0 } else { 8 };
    (0..some).map(move |corner| {
        let at = |axis: usize| [bounds.min[axis], bounds.max[axis]][corner >> axis & 1];
        Vec3::new(at(0), at(1), at(2))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::Placement;
    use crate::plant::{Foliage, Plant};
    use crate::run::{StandingTree, crown};
    use crate::scene::Shadow;
    use std::sync::Arc;

    /// The shadows of a box of 8 × 4 × 6 metres around the origin.
    fn shadows(towards: Vec3, extent: Option<f32>) -> Shadows {
        let axes = axes(towards);
        let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        let half = Vec3::new(4.0, 2.0, 3.0);
        for corner in corners_of(Aabb {
            min: -half,
            max: half,
        }) {
            for ([least, greatest], axis) in range.iter_mut().zip(axes) {
                let at = axis.dot(corner.as_dvec3());
                (*least, *greatest) = (least.min(at), greatest.max(at));
            }
        }
        Shadows {
            asked: Shadow {
                size: 256,
                bias: 0.0,
                extent,
            },
            axes,
            range,
            sent: None,
        }
    }

    fn view() -> View {
        let text = "schema = \"spinney.scene/1\"\nsize = [64, 48]\n[[tree]]\nspecies = \"a\"\n[camera]\n\
                    path = [{ eye = [9, 5, 12], target = [0, 1, 0] }]\n";
        let document = crate::document::Document {
            file: "scene".to_owned(),
            text: text.to_owned(),
        };
        let file = crate::scene::SceneFile::parse(document).unwrap();
        file.scene.camera.at(0, file.scene.size)
    }

    #[test]
    fn pixels_lead_to_where_the_light_sees_them() {
        let view = view();
        for towards in [Vec3::new(0.4, 1.0, 0.6), Vec3::Y, Vec3::new(-1.0, 0.1, 0.0)] {
            for extent in [None, Some(5.0)] {
                let shadows = shadows(towards.normalize(), extent);
                let (light, side) = shadows.light(&view);
                let matrix = shadows.map_from_pixel(&view, &light, side);
                for point in [
                    Vec3::ZERO,
                    Vec3::new(2.0, 1.0, -2.5),
                    Vec3::new(-3.0, -1.0, 1.0),
                ] {
                    let clip = view.clip_from_world * point.extend(1.0);
                    let ndc = clip / clip.w;
                    let pixel = [32.0 + 32.0 * ndc.x, 24.0 - 24.0 * ndc.y];
                    let place = matrix * glam::Vec4::new(pixel[0], pixel[1], 1.0 - ndc.z, 1.0);
                    let seen = light * point.extend(1.0);
                    let texel = [128.0 + 128.0 * seen.x, 128.0 - 128.0 * seen.y];
                    let found = [place.x / place.w, place.y / place.w, place.z / place.w];
                    assert!((found[0] - texel[0]).abs() < 0.02, "{found:?} {texel:?}");
                    assert!((found[1] - texel[1]).abs() < 0.02, "{found:?} {texel:?}");
                    assert!((found[2] - seen.z).abs() < 1e-4, "{found:?} {seen}");
                    if extent.is_none() {
                        assert!(seen.abs().max_element() <= 1.0 && seen.z >= 0.0, "{seen}");
                    }
                }
            }
        }
    }

    #[test]
    fn nearer_to_the_light_is_less_deep() {
        let shadows = shadows(Vec3::new(0.4, 1.0, 0.6).normalize(), None);
        let (light, _) = shadows.light(&view());
        let depth = |height: f32| (light * Vec3::new(0.0, height, 0.0).extend(1.0)).z;
        assert!(depth(1.0) < depth(0.0));
    }

    #[test]
    fn all_that_stands_has_corners() {
        let crown = Arc::new(crown(
            Plant::new("bare", None, None, Foliage::default()).unwrap(),
            None,
        ));
        let tree = StandingTree {
            crown: 0,
            placement: Placement::IDENTITY,
        };
        let world = World::of(vec![crown], vec![tree]);
        assert_eq!(corners(&world).count(), 0, "a plant without anything");
    }
}
