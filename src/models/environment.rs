//! What all models of one device share: programs, the view, and where instances stand.

use std::sync::Arc;

use super::branches::{LineProgram, Of, SkeletonProgram};
use super::expand_pass::ExpandPass;
use super::faces::FaceProgram;
use super::format::LeafFormat;
use super::leaf::{LeafProgram, LeafSource};
use super::pyramid_pass::{CELL_SLOT, PyramidPass, TARGET_SLOT, block_count, pyramid_size};
use super::reveal_pass::RevealPass;
use super::select_pass::SelectPass;
use super::shadow::ShadowMap;
use super::trunk::MeshProgram;
use super::{Criterion, Crown, Extent, Kind, Occlusion, State, select};
use crate::gpu::{
    Bindings, BufferDescriptor, BufferId, Cause, ComputePass, ComputeProgramId, ComputeStep,
    Device, GpuError, ProgramId, Queue, Residency, Step, TargetId, Transform, Usage,
};
use crate::math::{Mat4, Quat, Vec3};

/// Programs and buffers that are there once a device.
#[derive(Debug, Clone, Copy)]
pub struct Environment {
    /// By source, then by format.
    leaf: [[ProgramId; 4]; 3],
    pub(super) mesh: ProgramId,
    pub(super) face: ProgramId,
    pub(super) branch_lines: ProgramId,
    /// By what is expanded.
    pub(super) skeleton: [ProgramId; 4],
    view: BufferId,
    instances: BufferId,
    lens: Option<Lens>,
    occluders: Option<Occluders>,
    pub(super) shadow: Option<ShadowMap>,
    rooms: u32,
    /// See [`seen_by`](Self::seen_by).
    pub(super) pixels_per_metre: f32,
}

/// What devices that select by themselves need.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lens {
    pub(super) camera: BufferId,
    /// By [`Occlusion`].
    select: [ComputeProgramId; 2],
    pub(super) expand: ComputeProgramId,
}

impl Lens {
    /// The program that selects.
    pub(super) fn select(self, occlusion: Occlusion) -> ComputeProgramId {
        self.select[occlusion as usize]
    }
}

/// What devices need that leave out what is hidden.
#[derive(Debug, Clone, Copy)]
pub(super) struct Occluders {
    /// What is drawn into.
    pub(super) target: TargetId,
    /// Made of its depth.
    pub(super) pyramid: BufferId,
    make_pyramid: ComputeProgramId,
    /// Cells of the coarsest level.
    blocks: u32,
    pub(super) reveal: ComputeProgramId,
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

/// What detail is selected by, for devices that select by themselves.
///
/// | bytes | field       | type      | unit, space |
/// |------:|-------------|-----------|-------------|
/// | 0–11  | `eye`       | 3 × `f32` | m, world |
/// | 12–15 | `nearest`   | `f32`     | m, world |
/// | 16–19 | `farthest`  | `f32`     | m, world |
/// | 20–23 | `extent`    | `u32`     | 0 uniform, 1 variable |
///
/// Little-endian and unpadded, 24 bytes: what a new camera costs on the bus beside the view, which
/// every model sends and which the same device culls by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where the viewer stands.
    pub eye: Vec3,
    /// The papers' criterion, with distances in the world.
    pub criterion: Criterion,
}

impl Camera {
    const BYTES: u64 = 24;

    /// For those who do not look at it.
    pub(super) const AT_ORIGIN: Self = Self {
        eye: Vec3::ZERO,
        criterion: Criterion {
            nearest: 0.0,
            farthest: 1.0,
            extent: Extent::Uniform,
        },
    };

    /// The criterion in the space of a plant that stands there: its own space is scaled.
    #[must_use]
    pub fn criterion_for(&self, placement: &Placement) -> Criterion {
        Criterion {
            nearest: self.criterion.nearest / placement.scale,
            farthest: self.criterion.farthest / placement.scale,
            ..self.criterion
        }
    }

    /// The state of a plant that stands there.
    #[must_use]
    pub fn select(&self, crown: &Crown, placement: &Placement) -> State {
        let eye = placement.to_plant(self.eye);
        select(crown, self.criterion_for(placement), eye)
    }

    fn words(&self) -> [u32; 6] {
        let [x, y, z] = self.eye.to_array().map(f32::to_bits);
        let Criterion {
            nearest,
            farthest,
            extent,
        } = self.criterion;
        let extent = u32::from(extent == Extent::Variable);
        [x, y, z, nearest.to_bits(), farthest.to_bits(), extent]
    }

    pub(super) fn from_words([x, y, z, nearest, farthest, extent]: [u32; 6]) -> Self {
        Self {
            eye: Vec3::from_array([x, y, z].map(f32::from_bits)),
            criterion: Criterion {
                nearest: f32::from_bits(nearest),
                farthest: f32::from_bits(farthest),
                extent: if extent == 0 {
                    Extent::Uniform
                } else {
                    Extent::Variable
                },
            },
        }
    }
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

    /// The same as a matrix, columns first, as exactly as `f64` has it.
    fn columns(&self) -> [[f64; 4]; 4] {
        let [i, j, k, r] = self.rotation.to_array().map(f64::from);
        let (imaginary, scale) = ([i, j, k], f64::from(self.scale));
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let column = |axis: usize| {
            let mut v = [0.0; 3];
            v[axis] = scale;
            let cross = [
                j * v[2] - k * v[1],
                k * v[0] - i * v[2],
                i * v[1] - j * v[0],
            ];
            let along = 2.0 * dot(v, imaginary);
            let kept = r * r - dot(imaginary, imaginary);
            let at = |row: usize| v[row] * kept + imaginary[row] * along + cross[row] * 2.0 * r;
            [at(0), at(1), at(2), 0.0]
        };
        let [x, y, z] = self.position.to_array().map(f64::from);
        [column(0), column(1), column(2), [x, y, z, 1.0]]
    }

    fn words(&self) -> [f32; 8] {
        let ([x, y, z], [i, j, k, r]) = (self.position.to_array(), self.rotation.to_array());
        [x, y, z, self.scale, i, j, k, r]
    }

    /// As it lies on the device.
    pub(super) fn to_bytes(self) -> [u8; 32] {
        let mut bytes = [0; 32];
        for (four, word) in bytes.chunks_exact_mut(4).zip(self.words()) {
            four.copy_from_slice(&word.to_le_bytes());
        }
        bytes
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
    pub(super) const BYTES: u64 = 100;

    fn words(&self) -> impl Iterator<Item = f32> {
        self.clip_from_world
            .to_cols_array()
            .into_iter()
            .chain(self.to_light.to_array())
            .chain(self.light.to_array())
            .chain(self.ambient.to_array())
    }

    /// The matrix, from the first words.
    pub(super) fn read_matrix(words: [f32; 16]) -> Mat4 {
        Mat4::from_cols_array(&words)
    }

    pub(super) fn read(words: crate::gpu::Words<'_>) -> Self {
        let vector = |first: usize| Vec3::from_array(words.f32s(first));
        Self {
            clip_from_world: Self::read_matrix(words.f32s(0)),
            to_light: vector(16),
            light: vector(19),
            ambient: vector(22),
        }
    }
}

/// What takes points of a plant to clip space, for programs with the view and the placements in their
/// slots that compute `clip_from_world · (placement · point)` in `f32`.
pub(super) fn clip_from_plant(bindings: &Bindings<'_>, instance: u32) -> Transform {
    let view = View::read(bindings.storage(VIEW_SLOT as usize));
    let placements = bindings.storage(INSTANCE_SLOT as usize);
    let placement = Placement::from_words(placements.f32s(8 * instance as usize));
    let clip = view.clip_from_world.to_cols_array_2d();
    let clip = clip.map(|column| column.map(f64::from));
    Transform::of_columns(clip, placement.columns())
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
        let leaf = [
            LeafSource::Indexed,
            LeafSource::Stamped,
            LeafSource::Windowed,
        ]
        .map(|source| {
            LeafFormat::ALL
                .map(|format| device.create_program(Arc::new(LeafProgram { source, format })))
        });
        Ok(Self {
            leaf,
            mesh: device.create_program(Arc::new(MeshProgram)),
            face: device.create_program(Arc::new(FaceProgram)),
            branch_lines: device.create_program(Arc::new(LineProgram)),
            skeleton: [
                Of::WoodPolygons,
                Of::WoodLines,
                Of::NeedlePolygons,
                Of::NeedleLines,
            ]
            .map(|of| device.create_program(Arc::new(SkeletonProgram(of)))),
            view,
            instances,
            lens: None,
            occluders: None,
            shadow: None,
            rooms: 1,
            pixels_per_metre: 0.0,
        })
    }

    /// The same with what models of a kind need beside: for those that [select by
    /// themselves](Kind::selects) the camera, and their programs.
    ///
    /// # Errors
    ///
    /// [`GpuError::OutOfMemory`], or [`GpuError::NoCompute`] on a card that cannot run that program.
    pub fn of_kind(device: &mut Device, instances: u32, kind: Kind) -> Result<Self, GpuError> {
        let mut environment = Self::new(device, instances)?;
        if kind.selects() {
            environment.lens = Some(Lens {
                select: [
                    device.create_compute_program(Arc::new(SelectPass(Occlusion::None)))?,
                    device.create_compute_program(Arc::new(SelectPass(Occlusion::TwoPhase)))?,
                ],
                expand: device.create_compute_program(Arc::new(ExpandPass))?,
                camera: device.create_buffer(&BufferDescriptor {
                    label: "camera",
                    size: Camera::BYTES,
                    usage: Usage::STORAGE,
                    residency: Residency::Device,
                })?,
            });
        }
        Ok(environment)
    }

    /// Adds what models need that [leave out what is hidden](Occlusion::TwoPhase) in a target: the
    /// pyramid of its depth, and their programs. Only into that target can they be drawn.
    ///
    /// # Errors
    ///
    /// [`GpuError::OutOfMemory`], [`GpuError::Unknown`] where there is no such target, or
    /// [`GpuError::NoCompute`] on a card that cannot run those programs.
    pub fn occlude(&mut self, device: &mut Device, target: TargetId) -> Result<(), GpuError> {
        let found = device.inspect_target(target)?;
        let size = [found.width(), found.height()];
        self.occluders = Some(Occluders {
            target,
            pyramid: device.create_buffer(&BufferDescriptor {
                label: "depth pyramid",
                size: pyramid_size(size),
                usage: Usage::STORAGE,
                residency: Residency::Device,
            })?,
            make_pyramid: device.create_compute_program(Arc::new(PyramidPass))?,
            blocks: block_count(size),
            reveal: device.create_compute_program(Arc::new(RevealPass))?,
        });
        Ok(())
    }

    /// What every program reads the view from.
    pub(super) fn view_buffer(&self) -> BufferId {
        self.view
    }

    pub(super) fn occluders(&self) -> Result<Occluders, GpuError> {
        self.occluders.ok_or_else(|| GpuError::Unsupported {
            what: "a model that leaves out what is hidden where no target's depth is looked at"
                .to_owned(),
        })
    }

    /// The pass that makes the pyramid of what was drawn so far.
    pub(super) fn pyramid_pass(&self) -> Option<ComputePass> {
        let occluders = self.occluders?;
        let (target, buffer) = (occluders.target, occluders.pyramid);
        Some(ComputePass {
            label: "pyramid".to_owned(),
            steps: vec![
                ComputeStep::Program(occluders.make_pyramid),
                ComputeStep::Depth {
                    slot: TARGET_SLOT,
                    target,
                },
                ComputeStep::Storage {
                    slot: CELL_SLOT,
                    buffer,
                },
                ComputeStep::Dispatch {
                    groups: occluders.blocks,
                },
            ],
        })
    }

    /// The same for models of which there will be so many instances each: those that share buffers
    /// make rooms for as many at once. Without it they make them one at a time.
    #[must_use]
    pub fn with_rooms(self, instances: u32) -> Self {
        Self {
            rooms: instances,
            ..self
        }
    }

    /// The same for views in which a metre spans so many pixels where `w` of clip space is 1: models with lines
    /// that are uploaded then know how much of a pixel these cover.
    #[must_use]
    pub fn seen_by(self, pixels_per_metre: f32) -> Self {
        Self {
            pixels_per_metre,
            ..self
        }
    }

    /// How many instances a model makes rooms for at once.
    pub(super) fn rooms(&self) -> u32 {
        self.rooms
    }

    /// Whether there are models that look at the camera.
    #[must_use]
    pub fn has_camera(&self) -> bool {
        self.lens.is_some()
    }

    pub(super) fn lens(&self) -> Result<Lens, GpuError> {
        self.lens.ok_or_else(|| GpuError::Unsupported {
            what: "a model that selects by itself in an environment without a camera".to_owned(),
        })
    }

    /// The view, then the placements.
    pub(super) fn shared_buffers(&self) -> [BufferId; 2] {
        [self.view, self.instances]
    }

    /// Sends the camera of a frame under the cause `camera`; where no model looks at it, nothing.
    ///
    /// # Errors
    ///
    /// None on the device that this environment was made for.
    pub fn set_camera(&self, queue: &mut Queue<'_>, camera: &Camera) -> Result<(), GpuError> {
        let Some(lens) = self.lens else {
            return Ok(());
        };
        let words = camera.words().into_iter();
        let bytes: Vec<u8> = words.flat_map(u32::to_le_bytes).collect();
        queue.write(lens.camera, 0, &bytes, Cause::of("camera"))
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
    pub(super) fn bind(&self, program: ProgramId) -> impl Iterator<Item = Step> + use<> {
        let steps = [
            Step::Program(program),
            Step::Storage {
                slot: VIEW_SLOT,
                buffer: self.view,
            },
            Step::Storage {
                slot: INSTANCE_SLOT,
                buffer: self.instances,
            },
        ];
        steps.into_iter().chain(self.shadow_steps())
    }
}
