//! What all models of one device share: programs, the view, and where instances stand.

use std::sync::Arc;

use super::format::LeafFormat;
use super::leaf::{LeafProgram, LeafSource};
use super::trunk::MeshProgram;
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Device, GpuError, ProgramId, Queue, Residency, Step, Usage,
};
use crate::math::{Mat4, Quat, Vec3};

/// Programs and buffers that are there once a device.
#[derive(Debug, Clone, Copy)]
pub struct Environment {
    /// By source, then by format.
    leaf: [[ProgramId; 4]; 2],
    pub(super) mesh: ProgramId,
    view: BufferId,
    instances: BufferId,
}

/// What a frame is seen by.
///
/// | bytes | field             | type       | unit, space |
/// |------:|-------------------|------------|-------------|
/// | 0–63  | `clip_from_world` | 16 × `f32` | columns first |
/// | 64–75 | `to_light`        | 3 × `f32`  | unit vector towards the light, world |
/// | 76–87 | `light`           | 3 × `f32`  | linear colour of the directional light |
/// | 88–99 | `ambient`         | 3 × `f32`  | linear colour of light from everywhere |
///
/// Little-endian and unpadded, 100 bytes: what a new view costs on the bus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// From world space to clip space.
    pub clip_from_world: Mat4,
    /// Unit vector towards the light, in world space.
    pub to_light: Vec3,
    /// Linear colour of the directional light.
    pub light: Vec3,
    /// Linear colour of the light that comes from everywhere.
    pub ambient: Vec3,
}

/// Where an instance stands: scaled, turned about +Y, then moved.
///
/// On the device: the position (3 × `f32`), the scale (`f32`), the rotation as a quaternion
/// (4 × `f32`, scalar last): 32 bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Where the plant's origin stands, in world space.
    pub position: Vec3,
    /// The rotation.
    pub rotation: Quat,
    /// World metres a plant metre, above 0.
    pub scale: f32,
}

impl Placement {
    /// At the origin, as it is.
    pub const IDENTITY: Self = Self {
        position: Vec3::ZERO,
        rotation: Quat::IDENTITY,
        scale: 1.0,
    };
    /// Bytes on the device.
    pub const STRIDE: u64 = 32;

    /// A point of the plant in world space.
    #[must_use]
    pub fn to_world(&self, point: Vec3) -> Vec3 {
        self.rotation * (point * self.scale) + self.position
    }

    /// A world point in the plant's space.
    #[must_use]
    pub fn to_plant(&self, point: Vec3) -> Vec3 {
        self.rotation.inverse() * (point - self.position) / self.scale
    }

    fn words(&self) -> [f32; 8] {
        let ([x, y, z], [i, j, k, r]) = (self.position.to_array(), self.rotation.to_array());
        [x, y, z, self.scale, i, j, k, r]
    }

    pub(super) fn from_words([x, y, z, scale, i, j, k, r]: [f32; 8]) -> Self {
        let rotation = Quat::from_array([i, j, k, r]);
        Self {
            position: Vec3::new(x, y, z),
            rotation,
            scale,
        }
    }
}

impl View {
    const BYTES: u64 = 100;

    fn words(&self) -> impl Iterator<Item = f32> {
        self.clip_from_world
            .to_cols_array()
            .into_iter()
            .chain(self.to_light.to_array())
            .chain(self.light.to_array())
            .chain(self.ambient.to_array())
    }

    pub(super) fn read(words: crate::gpu::Words<'_>) -> Self {
        let vector = |first: usize| Vec3::from_array(words.f32s(first));
        Self {
            clip_from_world: Mat4::from_cols_array(&words.f32s(0)),
            to_light: vector(16),
            light: vector(19),
            ambient: vector(22),
        }
    }
}

/// The slot of the view in every program.
pub(super) const VIEW_SLOT: u32 = 0;
/// The slot of the placements in every program.
pub(super) const INSTANCE_SLOT: u32 = 1;

impl Environment {
    /// The program that draws leaves.
    pub(super) fn leaf(&self, program: LeafProgram) -> ProgramId {
        let mut formats = LeafFormat::ALL.iter();
        let formats = formats.position(|format| *format == program.format);
        let format = formats.expect("all formats are listed");
        self.leaf[program.source as usize][format]
    }

    /// Registers the programs and makes room for `instances` placements.
    ///
    /// # Errors
    ///
    /// [`GpuError::OutOfMemory`].
    pub fn new(device: &mut Device, instances: u32) -> Result<Self, GpuError> {
        let mut buffer = |label, size| {
            let (usage, residency) = (Usage::STORAGE, Residency::Device);
            device.create_buffer(&BufferDescriptor {
                label,
                size,
                usage,
                residency,
            })
        };
        let view = buffer("view", View::BYTES)?;
        let instances = buffer("placements", Placement::STRIDE * u64::from(instances))?;
        let leaf = [LeafSource::Indexed, LeafSource::Stamped].map(|source| {
            LeafFormat::ALL
                .map(|format| device.create_program(Arc::new(LeafProgram { source, format })))
        });
        Ok(Self {
            leaf,
            mesh: device.create_program(Arc::new(MeshProgram)),
            view,
            instances,
        })
    }

    /// Sends the view of a frame under the cause `view`.
    ///
    /// # Errors
    ///
    /// None on the device that this environment was made for.
    pub fn set_view(&self, queue: &mut Queue<'_>, view: &View) -> Result<(), GpuError> {
        let bytes: Vec<u8> = view.words().flat_map(f32::to_le_bytes).collect();
        queue.write(self.view, 0, &bytes, Cause::of("view"))
    }

    /// Sends where an instance stands under the cause `placement`.
    ///
    /// # Errors
    ///
    /// [`GpuError::Bounds`] when there is no room for `instance`.
    pub fn place(
        &self,
        queue: &mut Queue<'_>,
        instance: u32,
        placement: &Placement,
    ) -> Result<(), GpuError> {
        let bytes: Vec<u8> = placement
            .words()
            .into_iter()
            .flat_map(f32::to_le_bytes)
            .collect();
        let offset = Placement::STRIDE * u64::from(instance);
        queue.write(
            self.instances,
            offset,
            &bytes,
            Cause::numbered("placement", instance),
        )
    }

    /// Binds what every program of the models reads.
    pub(super) fn bind(&self, program: ProgramId) -> [Step; 3] {
        [
            Step::Program(program),
            Step::Storage {
                slot: VIEW_SLOT,
                buffer: self.view,
            },
            Step::Storage {
                slot: INSTANCE_SLOT,
                buffer: self.instances,
            },
        ]
    }
}
