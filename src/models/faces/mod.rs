//! Leaves of several faces: drawn beside the quads by every foliage model, always at full detail.
//!
//! ```text
//! Plant ─▶ FaceLeaves ─┐
//! any model of quads ──┴─▶ WithFaces ─▶ what the model sends, then the faces ─▶ one draw more an instance
//! ```
//!
//! A face is a triangle of its own: three vertices of 12 bytes, without indices, as the authors of
//! [GSS05](crate::references) count them (338,730 vertices for 112,910 faces). A leaf of ten faces takes
//! 360 bytes. With indices it would take 264 if it has twelve vertices; but then two faces of a leaf could
//! have the same key, and what shows where they touch would hang on the order of submission. Where on the
//! texture a corner lies follows from its number, as with quads, and costs nothing a leaf.
//!
//! Models with everything in host memory keep the faces there too, and every draw pulls them.
//!
//! **Invariant.** The vertices of faces are numbered behind those of quads, old and new, so the keys of
//! both are of one group and never equal.

mod leaves;
mod program;
mod surface;

pub use leaves::{FaceLeaf, FaceLeaves};
pub(super) use program::FaceProgram;

use std::sync::Arc;

use self::surface::FaceSurface;
use super::surface::LEAF_GROUP;
use super::{Change, Crown, Environment, Kind, Model, Resident, Shared, State, Storage};
use crate::gpu::{Command, Corners, Device, Draw, GpuError, MAX_SLOTS, Queue, Residency, Step};

/// The model with the faces of its plant beside it; the model itself where there are none.
pub(super) fn with_faces(model: Box<dyn Model>) -> Box<dyn Model> {
    if model.crown().faces().is_empty() {
        model
    } else {
        Box::new(WithFaces { quads: model })
    }
}

/// A model of quads, and all leaves of several faces.
///
/// Host memory: what the model of quads has; with everything there, the vertices of the faces after it.
/// Device memory: what the model of quads has, and else the vertices of the faces, once.
#[derive(Debug)]
struct WithFaces {
    quads: Box<dyn Model>,
}

impl WithFaces {
    fn residency(&self) -> Residency {
        match self.kind() {
            Kind::VdfHost | Kind::LodfHost => Residency::Host,
            _ => Residency::Device,
        }
    }
}

impl Model for WithFaces {
    fn kind(&self) -> Kind {
        self.quads.kind()
    }

    fn crown(&self) -> &Arc<Crown> {
        self.quads.crown()
    }

    fn drawn(&self, state: &State) -> Vec<u32> {
        self.quads.drawn(state)
    }

    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared>, GpuError> {
        let crown = self.crown();
        let textures = crown.faces().textures(crown.plant());
        if textures.len() > MAX_SLOTS {
            let what = format!(
                "leaves of several faces with {} textures (at most {MAX_SLOTS} fit; join them into an \
                 atlas)",
                textures.len()
            );
            return Err(GpuError::Unsupported { what });
        }
        let quads = self.quads.upload(device, environment)?;
        let surface = FaceSurface::upload(device, environment, crown, &textures, self.residency())?;
        Ok(Box::new(SharedWithFaces {
            quads,
            surface,
            corner_count: 3 * crown.faces().face_count(),
        }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        let mut bytes = self.quads.host_bytes();
        if self.residency() == Residency::Host {
            bytes.extend(self.crown().faces().vertex_bytes(self.crown().plant()));
        }
        bytes
    }

    fn storage(&self) -> Storage {
        let mut storage = self.quads.storage();
        let bytes = self.crown().faces().vertex_size();
        match self.residency() {
            Residency::Host => storage.host_bytes += bytes,
            Residency::Device => storage.shared_bytes += bytes,
        }
        storage
    }
}

#[derive(Debug)]
struct SharedWithFaces {
    quads: Box<dyn Shared>,
    surface: FaceSurface,
    corner_count: u32,
}

impl Shared for SharedWithFaces {
    fn instance(
        &self,
        device: &mut Device,
        state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let mut steps = self.surface.bind();
        steps.push(Step::Draw(Draw {
            source: Corners::Counted,
            first_corner: 0,
            corner_count: self.corner_count,
            instance: number,
            group: LEAF_GROUP,
        }));
        Ok(Box::new(ResidentWithFaces {
            quads: self.quads.instance(device, state, number)?,
            steps,
        }))
    }
}

#[derive(Debug)]
struct ResidentWithFaces {
    quads: Box<dyn Resident>,
    steps: Vec<Step>,
}

/// Faces never change: only [`draw`](Resident::draw) is not what the quads do.
impl Resident for ResidentWithFaces {
    fn state(&self) -> &State {
        self.quads.state()
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        self.quads.commit(queue, to)
    }

    fn price(&self, to: &State) -> u64 {
        self.quads.price(to)
    }

    fn cluster_price(&self, cluster: u32, collapses: u32) -> Option<u64> {
        self.quads.cluster_price(cluster, collapses)
    }

    fn follow(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        self.quads.follow(queue, to)
    }

    fn prepare(&self, commands: &mut Vec<Command>) {
        self.quads.prepare(commands);
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        self.quads.draw(steps);
        steps.extend_from_slice(&self.steps);
    }

    fn reveal(&self, commands: &mut Vec<Command>) {
        self.quads.reveal(commands);
    }

    fn draw_revealed(&self, steps: &mut Vec<Step>) {
        self.quads.draw_revealed(steps);
    }

    fn host_bytes(&self) -> u64 {
        self.quads.host_bytes()
    }
}
