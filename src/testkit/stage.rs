//! Our own models on our own device, as [`DeviceModel`]s.

use super::device::{Change, Counted, DeviceModel, Picture, Reads, Resource};
use super::watch::Watch;
use crate::gpu::{
    Card, Device, DeviceDescriptor, GpuError, Link, Load, RenderPass, TargetDescriptor, TargetId,
};
use crate::math::{Mat4, Vec3, Vec4};
use crate::models::{
    Environment, Kind, Model, Placement, Resident, Shared, State, TrunkLevel, TrunkModel, View,
    frame_commands,
};
use crate::raster::{Counters, Options, Samples, TileSize};

/// A device with one instance of a model, seen from in front.
///
/// The view looks along −z at the cube from (−1.4, −1.4, −3) to (1.4, 1.4, 0), in parallel. Writes
/// are recorded from the start.
#[derive(Debug)]
pub struct Stage<S = State> {
    /// The device.
    pub device: Device,
    /// What is drawn into.
    pub target: TargetId,
    /// What all models of the device share.
    pub environment: Environment,
    /// The instance.
    pub resident: Box<dyn Resident<S>>,
    watch: Watch,
}

impl Stage {
    /// A device of 1 GiB on PCI Express 1.0 with a card that computes, with tiles of 32 pixels.
    #[must_use]
    pub fn descriptor() -> DeviceDescriptor {
        DeviceDescriptor {
            memory_bytes: 1 << 30,
            link: Link::named("pcie1x16").unwrap_or(Link::ALL[0]),
            card: Card::named("gtx770").unwrap_or(Card::ALL[0]),
            raster: Options {
                tile: TileSize::Side32,
                counters: Counters::Visible,
            },
        }
    }

    /// A fresh device with an instance in `state` and a square target of `side` pixels.
    ///
    /// # Errors
    ///
    /// [`GpuError::OutOfMemory`], or [`GpuError::Unsupported`] for foliage with too many textures.
    pub fn new(
        descriptor: DeviceDescriptor,
        model: &dyn Model,
        state: &State,
        side: u32,
    ) -> Result<Self, GpuError> {
        let upload =
            |device: &mut Device, environment: &Environment| model.upload(device, environment);
        Self::with((descriptor, model.kind()), upload, state, side)
    }

    /// The same with another resident, made of this one.
    pub(super) fn wrapped(self, wrap: impl FnOnce(Box<dyn Resident>) -> Box<dyn Resident>) -> Self {
        Self {
            resident: wrap(self.resident),
            ..self
        }
    }
}

impl Stage<TrunkLevel> {
    /// The same with a trunk.
    ///
    /// # Errors
    ///
    /// [`GpuError::OutOfMemory`].
    pub fn of_trunk(
        descriptor: DeviceDescriptor,
        model: &dyn TrunkModel,
        level: TrunkLevel,
        side: u32,
    ) -> Result<Self, GpuError> {
        let upload =
            |device: &mut Device, environment: &Environment| model.upload(device, environment);
        Self::with((descriptor, Kind::Full), upload, &level, side)
    }
}

impl<S> Stage<S> {
    fn with(
        (descriptor, kind): (DeviceDescriptor, Kind),
        upload: impl FnOnce(&mut Device, &Environment) -> Result<Box<dyn Shared<S>>, GpuError>,
        state: &S,
        side: u32,
    ) -> Result<Self, GpuError> {
        let mut device = Device::new(descriptor);
        device.record();
        let target = device.create_target(&TargetDescriptor {
            label: "frame",
            width: side,
            height: side,
            samples: Samples::One,
        })?;
        // As the view below maps a metre to 0.7 of half the side.
        let environment = Environment::of_kind(&mut device, 1, kind)?;
        let mut environment = environment.seen_by(0.35 * side as f32);
        if kind.selects() {
            environment.occlude(&mut device, target)?;
        }
        let view = View {
            clip_from_world: Mat4::from_scale(Vec3::new(0.7, 0.7, 0.3))
                * Mat4::from_translation(Vec3::new(0.0, 0.0, 1.6)),
            to_light: Vec3::new(0.6, 0.8, 0.0),
            light: Vec3::splat(0.8),
            ambient: Vec3::splat(0.3),
        };
        environment.set_view(&mut device.queue(), &view)?;
        environment.place(&mut device.queue(), 0, &Placement::IDENTITY)?;
        let shared = upload(&mut device, &environment)?;
        let resident = shared.instance(&mut device, state, 0)?;
        Ok(Self {
            watch: Watch::of(&device),
            device,
            target,
            environment,
            resident,
        })
    }

    fn draw(&mut self) -> Picture {
        let mut steps = Vec::new();
        self.resident.draw(&mut steps);
        let mut blended = Vec::new();
        self.resident.draw_lines(&mut blended);
        let load = Load::Clear {
            color: Vec4::new(0.1, 0.1, 0.2, 1.0),
            depth: 1.0,
        };
        let pass = RenderPass {
            label: "test".to_owned(),
            target: self.target,
            load,
            steps,
        };
        let residents = std::iter::once(&*self.resident);
        let commands = frame_commands(&self.environment, pass, blended, residents);
        self.device.queue().submit(&commands).expect("a sound pass");
        self.device.present(self.target).expect("the target exists")
    }
}

impl<S> DeviceModel<S> for Stage<S> {
    fn commit(&mut self, to: &S) {
        self.resident
            .commit(&mut self.device.queue(), to)
            .expect("a resident's own device");
    }

    fn resources(&self) -> Vec<Resource<'_>> {
        self.watch.resources(&self.device)
    }

    fn reads(&mut self) -> Reads {
        self.device.track_reads();
        self.draw();
        self.watch.reads(&self.device)
    }

    fn overwrite(&mut self, resource: usize, at: usize, bytes: &[u8]) {
        self.watch.overwrite(&mut self.device, resource, at, bytes);
    }

    fn log(&self) -> Option<Vec<Change<'_>>> {
        self.watch.log(&self.device)
    }

    fn counted(&mut self) -> Option<Counted> {
        self.watch.add(self.device.take_ledger());
        Some(self.watch.counted())
    }

    fn picture(&mut self) -> Option<Picture> {
        Some(self.draw())
    }
}
