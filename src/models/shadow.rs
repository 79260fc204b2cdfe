//! Shadows: what the light sees is drawn into a map first, and fragment stages look themselves up in it.
//!
//! ```text
//!  steps of the frame, the view exchanged for the light's ─▶ pass "shadow" ─▶ map of depths
//!  pixel and depth ─matrix─▶ place and depth in the map ─▶ 2 × 2 comparisons ─▶ share that is lit
//! ```
//!
//! **Invariant.** Without a map no step, byte or picture differs from what it was without this module.

use super::environment::{Environment, VIEW_SLOT, View};
use crate::gpu::{
    Bindings, BufferDescriptor, BufferId, Cause, DepthMap, Device, GpuError, Load, MAX_SLOTS,
    Pixel, Queue, RenderPass, Residency, Samples, Step, TargetDescriptor, TargetId, Usage,
};
use crate::math::{Mat4, Vec3, Vec4};

/// The slot of the matrix that leads to the map, in every program: the last one.
const MATRIX_SLOT: u32 = 15;
/// The slot of the map among depths.
const MAP_SLOT: u32 = 0;

/// Bytes of a matrix.
const MATRIX_BYTES: u64 = 64;

/// Why the matrices are sent.
const SHADOW: Cause = Cause::of("shadow");

/// What a device with shadows has.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShadowMap {
    map: TargetId,
    /// What stands in for the view when the light looks; all but the matrix are zeros.
    light_view: BufferId,
    matrix: BufferId,
}

impl Environment {
    /// Adds a map of shadows of so many texels a side, 4 B each. Models that are uploaded from then on
    /// read it, and [`frame_commands`](super::frame_commands) draw it before the frame.
    ///
    /// # Errors
    ///
    /// [`GpuError::OutOfMemory`].
    pub fn cast_shadows(&mut self, device: &mut Device, size: u32) -> Result<(), GpuError> {
        let map = device.create_depth_target(&TargetDescriptor {
            label: "shadow map",
            width: size,
            height: size,
            samples: Samples::One,
        })?;
        let mut buffer = |label, size| {
            device.create_buffer(&BufferDescriptor {
                label,
                size,
                usage: Usage::STORAGE,
                residency: Residency::Device,
            })
        };
        self.shadow = Some(ShadowMap {
            map,
            light_view: buffer("light view", View::BYTES)?,
            matrix: buffer("shadow matrix", MATRIX_BYTES)?,
        });
        Ok(())
    }

    /// The map of shadows, if there is one.
    #[must_use]
    pub fn shadow_map(&self) -> Option<TargetId> {
        self.shadow.map(|shadow| shadow.map)
    }

    /// Sends where the light sees what: world space to the clip space of the map, 64 B under the cause
    /// `shadow`.
    ///
    /// # Errors
    ///
    /// None on the device that this environment was made for.
    pub fn set_light(&self, queue: &mut Queue<'_>, clip: &Mat4) -> Result<(), GpuError> {
        let buffer = self.shadow.map(|shadow| shadow.light_view);
        send(queue, buffer, clip)
    }

    /// Sends what leads to the map: from column and row of a pixel's centre, 1 − its depth, and 1, to
    /// columns and rows of the map in texels and the depth that is compared there, times what comes
    /// last; 64 B under the cause `shadow`.
    ///
    /// That depth is near 1 and its complement exact, so that far points lose no bits.
    ///
    /// # Errors
    ///
    /// None on the device that this environment was made for.
    pub fn set_shadow(&self, queue: &mut Queue<'_>, matrix: &Mat4) -> Result<(), GpuError> {
        let buffer = self.shadow.map(|shadow| shadow.matrix);
        send(queue, buffer, matrix)
    }

    /// The steps that bind the map, where there is one.
    pub(super) fn shadow_steps(&self) -> impl Iterator<Item = Step> + use<> {
        let steps = self.shadow.map(|shadow| {
            [
                Step::Storage {
                    slot: MATRIX_SLOT,
                    buffer: shadow.matrix,
                },
                Step::Depth {
                    slot: MAP_SLOT,
                    target: shadow.map,
                },
            ]
        });
        steps.into_iter().flatten()
    }

    /// The pass that draws into the map what another pass draws.
    pub(super) fn shadow_pass(&self, pass: &RenderPass) -> Option<RenderPass> {
        let shadow = self.shadow?;
        let step = |step: &Step| match *step {
            Step::Storage {
                slot: VIEW_SLOT, ..
            } => Some(Step::Storage {
                slot: VIEW_SLOT,
                buffer: shadow.light_view,
            }),
            Step::Storage {
                slot: MATRIX_SLOT, ..
            }
            | Step::Depth { .. } => None,
            step => Some(step),
        };
        Some(RenderPass {
            label: "shadow".to_owned(),
            target: shadow.map,
            load: Load::Clear {
                color: Vec4::ZERO,
                depth: 1.0,
            },
            steps: pass.steps.iter().filter_map(step).collect(),
        })
    }
}

fn send(queue: &mut Queue<'_>, buffer: Option<BufferId>, matrix: &Mat4) -> Result<(), GpuError> {
    let Some(buffer) = buffer else {
        return Ok(());
    };
    let floats = matrix.to_cols_array().into_iter();
    let bytes: Vec<u8> = floats.flat_map(f32::to_le_bytes).collect();
    queue.write(buffer, 0, &bytes, SHADOW)
}

/// The light of a frame as fragment stages know it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lighting<'a> {
    light: Vec3,
    ambient: Vec3,
    shadow: Option<ShadowLookup<'a>>,
}

impl<'a> Lighting<'a> {
    /// With what is bound.
    pub(super) fn of(bindings: &Bindings<'a>) -> Self {
        let view = View::read(bindings.storage(VIEW_SLOT as usize));
        Self {
            light: view.light,
            ambient: view.ambient,
            shadow: ShadowLookup::of(bindings),
        }
    }

    /// The linear light on a surface at a pixel; `toward` is the cosine between its normal and the way
    /// to the light, 0 where it faces away.
    #[inline(always)]
    pub(super) fn at(&self, toward: f32, pixel: &Pixel<'_>) -> Vec3 {
        let toward = match &self.shadow {
            Some(shadow) if toward > 0.0 => toward * shadow.lit(pixel),
            _ => toward,
        };
        self.ambient + self.light * toward
    }

    /// Texels that one [`at`](Self::at) reads.
    pub(super) fn texels(&self) -> u64 {
        self.shadow.map_or(0, |_| ShadowLookup::TEXELS)
    }
}

/// How a fragment stage finds what lies in shadow.
#[derive(Debug, Clone, Copy)]
struct ShadowLookup<'a> {
    map: DepthMap<'a>,
    matrix: Mat4,
}

impl<'a> ShadowLookup<'a> {
    /// Texels that one [`lit`](Self::lit) reads.
    const TEXELS: u64 = 4;

    /// With what is bound, where a map is.
    fn of(bindings: &Bindings<'a>) -> Option<Self> {
        let map = bindings.depth(MAP_SLOT as usize)?;
        let matrix = bindings.storage(MATRIX_SLOT as usize).f32s(0);
        Some(Self {
            map,
            matrix: View::read_matrix(matrix),
        })
    }

    /// The share of a pixel that the light reaches, by its centre: each of the four texels around its
    /// place in the map says yes where nothing nearer lies, and is weighed bilinearly, first along x,
    /// then along y, as `a + (b − a) · t`. Beside the map all is lit.
    fn lit(&self, pixel: &Pixel<'_>) -> f32 {
        let [x, y] = pixel.position.map(|at| at as f32 + 0.5);
        let place = self.matrix * Vec4::new(x, y, 1.0 - pixel.depth, 1.0);
        let [x, y, depth] = [place.x, place.y, place.z].map(|at| at / place.w);
        let (left, across) = texel_before(x);
        let (above, down) = texel_before(y);
        let lit = |right: i32, below: i32| self.reaches(left + right, above + below, depth);
        let upper = lit(0, 0) + (lit(1, 0) - lit(0, 0)) * across;
        let lower = lit(0, 1) + (lit(1, 1) - lit(0, 1)) * across;
        upper + (lower - upper) * down
    }

    /// 1 where the light reaches a depth at a texel, else 0.
    fn reaches(&self, x: i32, y: i32, depth: f32) -> f32 {
        let [width, height] = self.map.size();
        let texel = [x, y].map(u32::try_from);
        let [Ok(x), Ok(y)] = texel else {
            return 1.0;
        };
        let hidden = x < width && y < height && self.map.depth([x, y]) < depth;
        if hidden { 0.0 } else { 1.0 }
    }
}

/// The texel whose centre lies before a place, and how far the place is from there to the next; of no
/// number, and far beyond any map, some texel.
#[expect(
    clippy::cast_possible_truncation,
    reason = "rounds down, saturating where places are absurd"
)]
fn texel_before(place: f32) -> (i32, f32) {
    let from_centre = (place - 0.5).clamp(-2.0, 1e6);
    let cut = from_centre as i32;
    let floor = cut - i32::from(from_centre < cut as f32);
    let rest = from_centre - floor as f32;
    (floor, if rest > 0.0 { rest } else { 0.0 })
}

const _: () = assert!(MATRIX_SLOT as usize == MAX_SLOTS - 1, "the last slot");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lie_between_the_centres_of_texels() {
        assert_eq!(texel_before(0.5), (0, 0.0));
        assert_eq!(texel_before(1.75), (1, 0.25));
        assert_eq!(texel_before(0.25), (-1, 0.75));
        assert_eq!(texel_before(-1e30).0, -2);
        assert_eq!(texel_before(f32::NAN), (0, 0.0));
    }
}
