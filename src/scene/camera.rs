//! The camera: a path sampled by frame number, and the matrices of one frame.

use crate::math::{Frustum, Mat4, Vec3, det};

use super::{ImageSize, SceneError};

/// A camera on a path; between its keys it moves linearly, before the first and after the last it
/// stands still.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    projection: Projection,
    near: f32,
    far: f32,
    path: Vec<CameraKey>,
}

/// How view space becomes an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// What is far is small.
    Perspective {
        /// The angle between the upper and lower edge of the image, in degrees.
        vertical_field_of_view: f32,
    },
    /// Everything keeps its size.
    Orthographic {
        /// What fits between the upper and lower edge of the image, in metres.
        height: f32,
    },
}

/// Where the camera is at one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraKey {
    /// The frame.
    pub frame: u32,
    /// Where it stands: world space, metres.
    pub eye: Vec3,
    /// What it looks at: world space, metres.
    pub target: Vec3,
}

impl Camera {
    /// A camera of checked parts.
    ///
    /// # Errors
    ///
    /// When a number is not finite, `0 < near < far` or the projection's range does not hold, the
    /// path is empty or does not ascend, or a key looks at where it stands.
    pub fn new(
        projection: Projection,
        near: f32,
        far: f32,
        path: Vec<CameraKey>,
    ) -> Result<Self, SceneError> {
        let wrong = |key, found: String, wanted: &str| {
            Err(SceneError::Value {
                key,
                found,
                wanted: wanted.to_owned(),
            })
        };
        match projection {
            Projection::Perspective {
                vertical_field_of_view: angle,
            } if !(angle > 0.0 && angle < 180.0) => {
                return wrong(
                    "camera.vertical_field_of_view",
                    angle.to_string(),
                    "an angle between 0 and 180 degrees",
                );
            }
            Projection::Orthographic { height } if !(height > 0.0 && height.is_finite()) => {
                return wrong("camera.height", height.to_string(), "a height above 0");
            }
            _ => {}
        }
        if !(near > 0.0 && near.is_finite()) {
            return wrong("camera.near", near.to_string(), "a distance above 0");
        }
        if !(far > near && far.is_finite()) {
            let wanted = format!("a distance above `near`, which is {near}");
            return wrong("camera.far", far.to_string(), &wanted);
        }
        if path.is_empty() {
            return wrong("camera.path", "no key".to_owned(), "at least one");
        }
        for key in &path {
            if (key.target - key.eye).try_normalize().is_none() {
                let wanted = "a point other than `eye`, finite and not too far";
                return wrong("camera.path.target", key.target.to_string(), wanted);
            }
        }
        if let Some(pair) = path.windows(2).find(|pair| pair[0].frame >= pair[1].frame) {
            let wanted = format!("more than {}, which comes before it", pair[0].frame);
            return wrong("camera.path.frame", pair[1].frame.to_string(), &wanted);
        }
        Ok(Self {
            projection,
            near,
            far,
            path,
        })
    }

    /// How view space becomes an image.
    #[must_use]
    pub fn projection(&self) -> Projection {
        self.projection
    }

    /// The distance of the near plane, in metres.
    #[must_use]
    pub fn near(&self) -> f32 {
        self.near
    }

    /// The distance of the far plane, in metres.
    #[must_use]
    pub fn far(&self) -> f32 {
        self.far
    }

    /// The keys, with ascending frames.
    #[must_use]
    pub fn path(&self) -> &[CameraKey] {
        &self.path
    }

    /// What the camera sees at a frame, in an image of that size.
    #[must_use]
    pub fn at(&self, frame: u32, size: ImageSize) -> View {
        let (eye, target) = self.placement(frame);
        // Eye and target may cross on their way from key to key.
        let direction = (target - eye).normalize_or(Vec3::NEG_Z);
        let view_from_world =
            glam::camera::rh::view::look_to_mat4(eye, direction, up_for(direction));
        let (width, height) = (size.width() as f32, size.height() as f32);
        let aspect = width / height;
        let (clip_from_view, pixels_per_metre_at_1m) = match self.projection {
            Projection::Perspective {
                vertical_field_of_view,
            } => {
                let angle = vertical_field_of_view * (std::f32::consts::PI / 180.0);
                (
                    glam::camera::rh::proj::directx::perspective(
                        angle, aspect, self.near, self.far,
                    ),
                    0.5 * height / det::tan(0.5 * angle),
                )
            }
            Projection::Orthographic { height: metres } => {
                let (x, y) = (0.5 * metres * aspect, 0.5 * metres);
                (
                    glam::camera::rh::proj::directx::orthographic(
                        -x, x, -y, y, self.near, self.far,
                    ),
                    height / metres,
                )
            }
        };
        View {
            eye,
            direction,
            view_from_world,
            world_from_view: rigid_inverse(&view_from_world, eye),
            clip_from_view,
            clip_from_world: clip_from_view * view_from_world,
            near: self.near,
            far: self.far,
            viewport: [size.width(), size.height()],
            projection: self.projection,
            pixels_per_metre_at_1m,
        }
    }

    /// Eye and target at a frame.
    fn placement(&self, frame: u32) -> (Vec3, Vec3) {
        let after = self.path.partition_point(|key| key.frame <= frame);
        let last = &self.path[self.path.len() - 1];
        match (after.checked_sub(1), self.path.get(after)) {
            (None, next) => {
                let key = next.unwrap_or(last);
                (key.eye, key.target)
            }
            (Some(_), None) => (last.eye, last.target),
            (Some(before), Some(next)) => {
                let key = &self.path[before];
                let share = (frame - key.frame) as f32 / (next.frame - key.frame) as f32;
                (
                    key.eye + (next.eye - key.eye) * share,
                    key.target + (next.target - key.target) * share,
                )
            }
        }
    }
}

/// What a camera sees at one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Where it stands: world space, metres.
    pub eye: Vec3,
    /// Where it looks: world space, length 1.
    pub direction: Vec3,
    /// World space to view space.
    pub view_from_world: Mat4,
    /// View space to world space.
    pub world_from_view: Mat4,
    /// View space to clip space, `0 ≤ z ≤ w`.
    pub clip_from_view: Mat4,
    /// World space to clip space: the product of the two.
    pub clip_from_world: Mat4,
    /// The distance of the near plane, in metres.
    pub near: f32,
    /// The distance of the far plane, in metres.
    pub far: f32,
    /// Width and height in pixels.
    pub viewport: [u32; 2],
    /// How view space becomes an image.
    pub projection: Projection,
    /// How many pixels a metre spans at a distance of 1 m along the view direction: `f_px` =
    /// height / (2 tan(angle / 2)); at any distance, for an orthographic camera.
    pub pixels_per_metre_at_1m: f32,
}

impl View {
    /// How many pixels a metre spans at a distance in metres; the near plane's for what is nearer.
    #[must_use]
    pub fn pixels_per_metre(&self, distance: f32) -> f32 {
        match self.projection {
            Projection::Perspective { .. } => self.pixels_per_metre_at_1m / distance.max(self.near),
            Projection::Orthographic { .. } => self.pixels_per_metre_at_1m,
        }
    }

    /// The planes that bound what is seen, in world space.
    #[must_use]
    pub fn frustum(&self) -> Frustum {
        Frustum::of(&self.clip_from_world)
    }
}

/// Below this sine of the angle to the vertical, +Y no longer says where up is.
const STEEPEST_SINE: f32 = 1e-6;

/// The up direction: +Y; looking straight down −Z and straight up +Z, as for a camera that looked
/// along −Z before it tilted.
fn up_for(direction: Vec3) -> Vec3 {
    let level = direction.x * direction.x + direction.z * direction.z;
    if level > STEEPEST_SINE * STEEPEST_SINE {
        Vec3::Y
    } else if direction.y < 0.0 {
        Vec3::NEG_Z
    } else {
        Vec3::Z
    }
}

/// The inverse of a rotation and translation whose inverse translation is `eye`.
fn rigid_inverse(view_from_world: &Mat4, eye: Vec3) -> Mat4 {
    Mat4::from_cols(
        view_from_world.row(0).with_w(0.0),
        view_from_world.row(1).with_w(0.0),
        view_from_world.row(2).with_w(0.0),
        eye.extend(1.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn size(width: u32, height: u32) -> ImageSize {
        ImageSize::new(width, height).expect("small")
    }

    fn key(frame: u32, eye: [f32; 3], target: [f32; 3]) -> CameraKey {
        CameraKey {
            frame,
            eye: eye.into(),
            target: target.into(),
        }
    }

    fn camera(path: Vec<CameraKey>) -> Camera {
        let projection = Projection::Perspective {
            vertical_field_of_view: 90.0,
        };
        Camera::new(projection, 1.0, 101.0, path).expect("sound")
    }

    #[test]
    fn perspective_is_its_closed_form() {
        // 90 degrees: at a distance of d the image's half height is d metres.
        let view = camera(vec![key(0, [0.0, 2.0, 5.0], [0.0, 2.0, 0.0])]).at(0, size(200, 100));
        let ndc = |point: [f32; 3]| view.clip_from_world.project_point3(point.into());
        let corner = ndc([8.0, 6.0, 1.0]);
        assert!(
            corner.distance(Vec3::new(1.0, 1.0, corner.z)) < 1e-6,
            "{corner}"
        );
        assert!(ndc([0.0, 2.0, 4.0]).z.abs() < 1e-6, "near plane");
        assert!((ndc([0.0, 2.0, -96.0]).z - 1.0).abs() < 1e-6, "far plane");
        // z_ndc = far (d - near) / (d (far - near)) at d = 2.
        assert!((ndc([0.0, 2.0, 3.0]).z - 101.0 / 200.0).abs() < 1e-6);
        assert!((view.pixels_per_metre_at_1m - 50.0).abs() < 1e-4);
        assert!((view.pixels_per_metre(4.0) - 12.5).abs() < 1e-4);
        assert!(
            (view.pixels_per_metre(0.0) - 50.0).abs() < 1e-4,
            "near plane"
        );
    }

    #[test]
    fn orthographic_is_its_closed_form() {
        let projection = Projection::Orthographic { height: 4.0 };
        let path = vec![key(0, [0.0, 0.0, 0.0], [0.0, 0.0, -1.0])];
        let view = Camera::new(projection, 1.0, 11.0, path)
            .expect("sound")
            .at(0, size(300, 100));
        for (point, wanted) in [
            ([6.0, 2.0, -1.0], [1.0, 1.0, 0.0]),
            ([-3.0, -1.0, -6.0], [-0.5, -0.5, 0.5]),
            ([0.0, 0.0, -11.0], [0.0, 0.0, 1.0]),
        ] {
            let found = view.clip_from_world.project_point3(point.into());
            assert!(found.distance(wanted.into()) < 1e-6, "{point:?}: {found}");
        }
        assert_eq!(view.pixels_per_metre(7.0), 25.0);
    }

    #[test]
    fn path_is_linear_between_keys_and_still_outside() {
        let camera = camera(vec![
            key(10, [0.0, 0.0, 8.0], [0.0, 0.0, 0.0]),
            key(14, [4.0, 0.0, 8.0], [0.0, 0.0, 0.0]),
            key(15, [4.0, 2.0, 8.0], [0.0, 0.0, 0.0]),
        ]);
        let eye = |frame| camera.at(frame, size(8, 8)).eye.to_array();
        assert_eq!(eye(0), [0.0, 0.0, 8.0]);
        assert_eq!(eye(10), [0.0, 0.0, 8.0]);
        assert_eq!(eye(11), [1.0, 0.0, 8.0]);
        assert_eq!(eye(14), [4.0, 0.0, 8.0]);
        assert_eq!(eye(15), [4.0, 2.0, 8.0]);
        assert_eq!(eye(u32::MAX), [4.0, 2.0, 8.0]);
    }

    #[test]
    fn straight_down_north_is_up_and_straight_up_south_is() {
        for (target, above) in [([0.0, -1.0, 0.0], Vec3::NEG_Z), ([0.0, 1.0, 0.0], Vec3::Z)] {
            let view = camera(vec![key(0, [0.0; 3], target)]).at(0, size(10, 10));
            assert!(view.clip_from_world.is_finite());
            let point = Vec3::from(target) * 2.0 + above * 0.5;
            let found = view.clip_from_world.project_point3(point);
            assert!(
                found.x.abs() < 1e-6 && (found.y - 0.25).abs() < 1e-6,
                "{found}"
            );
        }
    }

    #[test]
    fn crossing_eye_and_target_still_has_a_direction() {
        let camera = camera(vec![
            key(0, [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]),
            key(2, [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]),
        ]);
        let view = camera.at(1, size(4, 4));
        assert_eq!(view.direction, Vec3::NEG_Z);
        assert!(view.clip_from_world.is_finite());
    }

    #[test]
    fn world_from_view_undoes_view_from_world() {
        let view = camera(vec![key(0, [3.0, 4.0, 5.0], [-1.0, 2.0, 0.5])]).at(0, size(64, 48));
        let product = view.world_from_view * view.view_from_world;
        assert!(product.abs_diff_eq(Mat4::IDENTITY, 1e-5), "{product}");
    }

    #[test]
    fn matrices_are_pinned_to_the_bit() {
        let view = camera(vec![key(0, [3.0, 4.0, 5.0], [-1.0, 2.0, 0.5])]).at(0, size(64, 48));
        let mut digester = crate::math::Digester::new("test");
        for value in view.clip_from_world.to_cols_array() {
            digester.f32(value);
        }
        // Renew only when the formulas above change: the value must be the same on every machine.
        assert_eq!(
            digester
                .f32(view.pixels_per_metre_at_1m)
                .finish()
                .to_string(),
            "ecd2d4827014c96da54b48cdcc6d1c71403df5474f607e7ff4c12b7a8fe831fd"
        );
    }

    #[test]
    fn unsound_cameras_are_refused() {
        let perspective = |angle| Projection::Perspective {
            vertical_field_of_view: angle,
        };
        let still = vec![key(0, [0.0; 3], [1.0; 3])];
        let message = |projection, near, far, path| {
            Camera::new(projection, near, far, path)
                .expect_err("unsound")
                .to_string()
        };
        for (found, wanted) in [
            (
                message(perspective(180.0), 1.0, 2.0, still.clone()),
                "`camera.vertical_field_of_view`: found 180, wanted an angle between 0 and 180 degrees",
            ),
            (
                message(perspective(f32::NAN), 1.0, 2.0, still.clone()),
                "`camera.vertical_field_of_view`: found NaN, wanted an angle between 0 and 180 degrees",
            ),
            (
                message(perspective(45.0), 2.0, 2.0, still),
                "`camera.far`: found 2, wanted a distance above `near`, which is 2",
            ),
            (
                message(perspective(45.0), 1.0, 2.0, Vec::new()),
                "`camera.path`: found no key, wanted at least one",
            ),
            (
                message(
                    perspective(45.0),
                    1.0,
                    2.0,
                    vec![key(0, [1.0; 3], [1.0; 3])],
                ),
                "`camera.path.target`: found [1, 1, 1], wanted a point other than `eye`, finite and not too far",
            ),
            (
                message(
                    perspective(45.0),
                    1.0,
                    2.0,
                    vec![key(5, [0.0; 3], [1.0; 3]), key(5, [0.0; 3], [1.0; 3])],
                ),
                "`camera.path.frame`: found 5, wanted more than 5, which comes before it",
            ),
        ] {
            assert_eq!(found, wanted);
        }
    }
}
