//! A wood of patches: a few samples of trees packed into one model a level, drawn at many places
//! ([ZBMJLDC17](crate::references), section 6).
//!
//! ```text
//!  once                                          every view                      every frame
//! samples ─at N errors─▶ levels of the patch     camera ─▶ cull: a list a level ─▶ polygons, then lines from far
//! places ───────────────────────────────────▶              └─ host sorts, or device ─┘       levels to near ones
//! ```
//!
//! On the device: 28 B a vertex of polygons, 32 B an end of a line, 4 B a corner, of all levels; 16 B a
//! material; 32 B a place; 4 B a place and level for the lists; 16 B for the arguments of each draw.
//!
//! | [order](GroveOrder) | what a view sends beside the camera (16 B) |
//! |---|---|
//! | none, device | nothing |
//! | host | reads the arguments and the lists back, sends the lists again: 8 B a patch in view and 16 B a draw |
//!
//! Blends that hash, or weigh by moments, are told the view's range too: 16 B. Those of [`veil`] draw lines into
//! targets of their own, between the polygons and the rest of the frame.
//!
//! A list holds numbers of patches, where the paper captures positions. Wood and needles show their colour
//! without texture: patches of several species are one draw.
//!
//! **Invariant.** What is on the device is a function of the samples, places and the last view; every way to
//! order or blend draws the same primitives.

mod composite;
mod cull;
mod hashed;
mod lines;
mod moments;
mod patch;
mod program;
mod veil;

use std::sync::Arc;

pub use patch::GroveSample;

use cull::{CAMERA_SLOT, Cull, LIST_SLOT, PLACE_SLOT, RECORD_SLOT, VIEW_SLOT, View};
use lines::{GroveLines, LineStage, RANGE_SLOT};
use patch::PatchLevels;
use program::{GrovePolygons, MATERIAL_SLOT};
use veil::Veil;

use super::branches::BRANCH_GROUP;
use super::environment::INSTANCE_SLOT;
use super::surface::filled;
use super::{Environment, Placement};
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Command, ComputePass, ComputeProgramId, ComputeStep,
    Corners, Device, DrawInstancedIndirect, GpuError, IndirectRecord, Load, ProgramId, RenderPass,
    Residency, Step, TargetId, Usage,
};
use crate::math::{Mat4, Vec3, index_u32};
use crate::scene::{GroveBlend, GroveChoice, GroveOrder, GrovePacking};
use crate::simplify::PrimitiveCounts;

/// Why what a grove begins with is sent.
const GROVE: Cause = Cause::of("grove");
/// Why lists cross the bus.
const ORDER: Cause = Cause::of("grove order");
/// Why its camera is sent.
const CAMERA: Cause = Cause::of("camera");

/// A wood of patches, made offline.
#[derive(Debug)]
pub struct Grove {
    levels: PatchLevels,
    places: Vec<Placement>,
    choice: GroveChoice,
    /// Of a level at the nearest point of a patch (`δ`).
    pixel_error: f32,
}

/// How a grove is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroveView {
    /// From world space to clip space.
    pub clip_from_world: Mat4,
    /// Where the viewer stands, in world space.
    pub eye: Vec3,
    /// How many pixels a metre spans a metre away.
    pub focal_pixels: f32,
}

impl Grove {
    /// Packs samples, which stand at their placements within a patch, into levels; the patches stand at
    /// `places`.
    #[must_use]
    pub fn new(samples: &[GroveSample], places: Vec<Placement>, choice: GroveChoice) -> Self {
        Self {
            levels: PatchLevels::of(samples, choice.levels),
            places,
            choice,
            pixel_error: samples
                .first()
                .map_or(1.0, |sample| sample.trunk.branch_choice().pixel_error),
        }
    }

    /// How many primitives each patch in view has, by level, and how many patches show there.
    #[must_use]
    pub fn shown(&self, view: &GroveView) -> Vec<(u32, PrimitiveCounts)> {
        let seen = self.seen(view);
        let lists = (0..self.levels.count()).map(|level| {
            let shown = (self.places.iter()).filter(|place| seen.level_of(place) == Some(level));
            (index_u32(shown.count()), self.levels.counts(level))
        });
        lists.collect()
    }

    /// How many patches there are.
    #[must_use]
    pub fn patch_count(&self) -> u32 {
        index_u32(self.places.len())
    }

    /// How many trees a patch has.
    #[must_use]
    pub fn sample_count(&self) -> u32 {
        self.levels.sample_count()
    }

    fn seen(&self, view: &GroveView) -> View {
        View {
            clip_from_world: view.clip_from_world,
            eye: view.eye,
            bounds: self.levels.bounds(),
            reach: self.reach(view),
            errors: self.levels.errors().to_vec(),
        }
    }

    /// The nearest and the farthest depth, along the view in metres, of the balls around patches in sight.
    fn range(&self, view: &GroveView) -> [f32; 2] {
        /// Nothing nearer is told apart.
        const NEAREST: f32 = 0.1;
        let seen = self.seen(view);
        let along = view.clip_from_world.row(3);
        let bounds = self.levels.bounds();
        let shown = self
            .places
            .iter()
            .filter(|place| seen.level_of(place).is_some());
        let none = [f32::INFINITY, NEAREST];
        let [nearest, farthest] = shown.fold(none, |[nearest, farthest], place| {
            let middle = along.dot(place.to_world(bounds.center()).extend(1.0));
            let reach = 0.5 * place.scale * bounds.min.distance(bounds.max);
            let reach = reach * along.truncate().length();
            [nearest.min(middle - reach), farthest.max(middle + reach)]
        });
        let nearest = nearest.clamp(NEAREST, farthest.max(NEAREST));
        [nearest, farthest.max(2.0 * nearest)]
    }

    /// How far away an error of a metre may be seen: metres a metre.
    fn reach(&self, view: &GroveView) -> f32 {
        view.focal_pixels / self.pixel_error
    }

    /// Sends all of it, to be drawn into a frame.
    ///
    /// # Errors
    ///
    /// [`GpuError::OutOfMemory`], or [`GpuError::NoCompute`] on a card that cannot cull.
    pub fn upload(
        self: &Arc<Self>,
        device: &mut Device,
        environment: &Environment,
        frame: TargetId,
    ) -> Result<ResidentGrove, GpuError> {
        let patches = self.patch_count();
        let (levels, parts) = (self.levels.count(), self.parts());
        let blend = self.choice.blend;
        let line_stage = match blend {
            GroveBlend::WritesDepth => Some(LineStage::WritesDepth),
            GroveBlend::KeepsDepth => Some(LineStage::KeepsDepth),
            GroveBlend::Sorted => Some(LineStage::Sorted),
            GroveBlend::Hashed => Some(LineStage::Hashed),
            GroveBlend::Coverage => Some(LineStage::Coverage),
            GroveBlend::Peeled | GroveBlend::Weighted | GroveBlend::Moments => None,
        };
        let programs = Programs {
            polygons: device.create_program(Arc::new(GrovePolygons)),
            lines: line_stage.map(|stage| device.create_program(Arc::new(GroveLines { stage }))),
            cull: device.create_compute_program(Arc::new(Cull {
                patches,
                parts,
                sorts: self.choice.order == GroveOrder::Device,
            }))?,
        };
        let bytes = self.levels.bytes();
        let places: Vec<u8> = self
            .places
            .iter()
            .flat_map(|place| place.to_bytes())
            .collect();
        let mut send = |label, usage, bytes: &[u8]| filled(device, label, usage, bytes, GROVE);
        let vertices = send("grove vertices", Usage::VERTEX, &bytes.vertices)?;
        let indices = send("grove indices", Usage::INDEX, &bytes.indices)?;
        let line_vertices = send("grove line vertices", Usage::VERTEX, &bytes.line_vertices)?;
        let line_indices = send("grove line indices", Usage::INDEX, &bytes.line_indices)?;
        let materials = send("grove materials", Usage::STORAGE, &bytes.materials)?;
        let places = send("grove places", Usage::STORAGE, &places)?;
        let table = send("grove levels", Usage::STORAGE, &self.levels.table_bytes())?;
        let records = device.create_buffer(&BufferDescriptor {
            label: "grove arguments",
            size: 32 * u64::from(parts) * levels as u64,
            usage: Usage::INDIRECT | Usage::STORAGE | Usage::COPY_SOURCE,
            residency: Residency::Device,
        })?;
        let lists = device.create_buffer(&BufferDescriptor {
            label: "grove lists",
            size: 4 * u64::from(patches) * levels as u64,
            usage: Usage::VERTEX | Usage::STORAGE | Usage::COPY_SOURCE,
            residency: Residency::Device,
        })?;
        device
            .queue()
            .write(records, 0, &self.record_bytes(), GROVE)?;
        let camera = device.create_buffer(&BufferDescriptor {
            label: "grove camera",
            size: 16,
            usage: Usage::STORAGE,
            residency: Residency::Device,
        })?;
        let range = match blend {
            GroveBlend::Hashed | GroveBlend::Moments => {
                Some(device.create_buffer(&BufferDescriptor {
                    label: "grove range",
                    size: 16,
                    usage: Usage::STORAGE,
                    residency: Residency::Device,
                })?)
            }
            _ => None,
        };
        Ok(ResidentGrove {
            veil: Veil::new(device, self.choice, frame)?,
            range,
            grove: Arc::clone(self),
            environment: *environment,
            programs,
            polygons: [vertices, indices],
            lines: [line_vertices, line_indices],
            materials,
            places,
            table,
            records,
            lists,
            camera,
        })
    }

    /// Into how many draws a level of the patch falls.
    fn parts(&self) -> u32 {
        match self.choice.packing {
            GrovePacking::Patches => 1,
            GrovePacking::Samples => self.levels.sample_count(),
        }
    }

    /// The arguments of all draws, of no instance yet: by level, of each part polygons, then lines.
    fn record_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for level in 0..self.levels.count() {
            for part in 0..self.parts() {
                let ranges = match self.choice.packing {
                    GrovePacking::Patches => self.levels.whole(level),
                    GrovePacking::Samples => self.levels.sample(level, part),
                };
                for corners in ranges {
                    let record = IndirectRecord {
                        corner_count: corners.end - corners.start,
                        instances: 0,
                        first_corner: corners.start,
                        instance: index_u32(level) * self.patch_count(),
                    };
                    bytes.extend(record.to_bytes());
                }
            }
        }
        bytes
    }
}

#[derive(Debug, Clone, Copy)]
struct Programs {
    polygons: ProgramId,
    /// Where they are drawn into the frame.
    lines: Option<ProgramId>,
    cull: ComputeProgramId,
}

/// A grove on a device.
#[derive(Debug)]
pub struct ResidentGrove {
    grove: Arc<Grove>,
    environment: Environment,
    programs: Programs,
    polygons: [BufferId; 2],
    lines: [BufferId; 2],
    materials: BufferId,
    places: BufferId,
    table: BufferId,
    records: BufferId,
    lists: BufferId,
    camera: BufferId,
    /// Of the view, where a blend asks for it.
    range: Option<BufferId>,
    veil: Veil,
}

impl ResidentGrove {
    /// What it is made of.
    #[must_use]
    pub fn grove(&self) -> &Grove {
        &self.grove
    }

    /// Culls for a view, which the environment has been sent already, chooses levels and puts patches in
    /// order.
    ///
    /// # Errors
    ///
    /// None on the device that it was uploaded to.
    pub fn look(&self, device: &mut Device, view: &GroveView) -> Result<(), GpuError> {
        let [x, y, z] = view.eye.to_array();
        let words = [x, y, z, self.grove.reach(view)];
        let bytes: Vec<u8> = words.into_iter().flat_map(f32::to_le_bytes).collect();
        let mut queue = device.queue();
        queue.write(self.camera, 0, &bytes, CAMERA)?;
        if let Some(range) = self.range {
            let [nearest, farthest] = self.grove.range(view);
            let words = [view.focal_pixels, nearest, farthest, 0.0];
            let bytes: Vec<u8> = words.into_iter().flat_map(f32::to_le_bytes).collect();
            queue.write(range, 0, &bytes, CAMERA)?;
        }
        let storage = |slot, buffer| ComputeStep::Storage { slot, buffer };
        queue.submit(&[Command::Compute(ComputePass {
            label: "grove".to_owned(),
            steps: vec![
                ComputeStep::Program(self.programs.cull),
                storage(VIEW_SLOT, self.environment.view_buffer()),
                storage(PLACE_SLOT, self.places),
                storage(CAMERA_SLOT, self.camera),
                storage(cull::TABLE_SLOT, self.table),
                storage(LIST_SLOT, self.lists),
                storage(RECORD_SLOT, self.records),
                ComputeStep::Dispatch {
                    groups: index_u32(self.grove.levels.count()),
                },
            ],
        })])?;
        if self.grove.choice.order == GroveOrder::Host {
            self.sort_on_host(device, view.eye)?;
        }
        Ok(())
    }

    /// Reads what shows back, sorts it from far to near, and sends it again
    /// ([ZBMJLDC17](crate::references), section 6.2, third improvement).
    fn sort_on_host(&self, device: &mut Device, eye: Vec3) -> Result<(), GpuError> {
        let patches = u64::from(self.grove.patch_count());
        let stride = 32 * u64::from(self.grove.parts());
        for level in 0..self.grove.levels.count() as u64 {
            let mut queue = device.queue();
            let record = queue.read(self.records, stride * level, IndirectRecord::STRIDE, ORDER)?;
            let count = record
                .as_chunks::<4>()
                .0
                .get(1)
                .copied()
                .unwrap_or_default();
            let count = u64::from(u32::from_le_bytes(count));
            if count < 2 {
                continue;
            }
            let from = 4 * patches * level;
            let bytes = queue.read(self.lists, from, 4 * count, ORDER)?;
            let numbers = bytes.as_chunks::<4>().0.iter();
            let mut numbers: Vec<u32> = numbers.map(|four| u32::from_le_bytes(*four)).collect();
            let places = &self.grove.places;
            cull::sort_far_to_near(&mut numbers, |number| {
                places[number as usize].position.distance(eye)
            });
            let bytes: Vec<u8> = numbers.into_iter().flat_map(u32::to_le_bytes).collect();
            queue.write(self.lists, from, &bytes, ORDER)?;
        }
        Ok(())
    }

    /// Adds the steps that draw polygons: opaque, so in any order.
    pub fn draw(&self, steps: &mut Vec<Step>) {
        self.bind(self.programs.polygons, self.polygons, steps);
        for level in 0..self.grove.levels.count() {
            for part in 0..self.grove.parts() {
                steps.push(self.step(level, part, 0));
            }
        }
    }

    /// Adds the steps that draw lines into the frame, in the order of the options, or what came of
    /// [passes](Self::line_passes).
    pub fn draw_lines(&self, steps: &mut Vec<Step>) {
        match self.programs.lines {
            Some(program) => self.lines_of(program, steps),
            None => self.veil.show(steps),
        }
    }

    /// The passes that draw lines into targets of their own, once the polygons are in the frame and before
    /// [`draw_lines`](Self::draw_lines).
    #[must_use]
    pub fn line_passes(&self, frame: TargetId) -> Vec<Command> {
        let passes = self.veil.passes.iter().map(|pass| {
            let mut steps = Vec::new();
            pass.bind(frame, &mut steps);
            self.lines_of(pass.program, &mut steps);
            Command::Render(RenderPass {
                label: pass.label.to_owned(),
                target: pass.target,
                load: Load::Clear {
                    color: pass.clear,
                    depth: 1.0,
                },
                steps,
            })
        });
        passes.collect()
    }

    fn lines_of(&self, program: ProgramId, steps: &mut Vec<Step>) {
        self.bind(program, self.lines, steps);
        let range = self.range.map(|buffer| Step::Storage {
            slot: RANGE_SLOT,
            buffer,
        });
        steps.extend(range);
        let parts = self.grove.parts();
        for levels in self.passes() {
            match self.grove.choice.packing {
                // Sample after sample, each at all levels of the pass.
                GrovePacking::Samples => {
                    for part in 0..parts {
                        steps.extend(levels.iter().map(|&level| self.step(level, part, 1)));
                    }
                }
                GrovePacking::Patches => {
                    steps.extend(levels.iter().map(|&level| self.step(level, 0, 1)));
                }
            }
        }
    }

    /// The levels of each pass: a few at a time from near to far, or one at a time from far to near.
    fn passes(&self) -> Vec<Vec<usize>> {
        let levels: Vec<usize> = (0..self.grove.levels.count()).collect();
        let together = self.grove.choice.levels_a_pass.max(1) as usize;
        let passes = levels.chunks(together).map(<[usize]>::to_vec);
        if together == 1 {
            passes.rev().collect()
        } else {
            passes.collect()
        }
    }

    fn bind(&self, program: ProgramId, [vertices, indices]: [BufferId; 2], steps: &mut Vec<Step>) {
        steps.extend(self.environment.bind(program));
        let storage = |slot, buffer| Step::Storage { slot, buffer };
        steps.extend([
            storage(INSTANCE_SLOT, self.places),
            storage(MATERIAL_SLOT, self.materials),
            Step::Vertices(vertices),
            Step::Indices(indices),
        ]);
    }

    /// Draws polygons (0) or lines (1) of a part of a level.
    fn step(&self, level: usize, part: u32, what: u64) -> Step {
        let parts = u64::from(self.grove.parts());
        let record = 2 * (parts * level as u64 + u64::from(part)) + what;
        Step::DrawInstancedIndirect(DrawInstancedIndirect {
            source: Corners::Indexed,
            arguments: self.records,
            offset: IndirectRecord::STRIDE * record,
            instances: self.lists,
            group: BRANCH_GROUP,
        })
    }
}
