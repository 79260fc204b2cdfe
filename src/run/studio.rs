//! One model, of foliage or of wood, alone on a device of its own, drawn from wherever it is asked for.

use super::RunError;
use crate::gpu::{
    Card, Command, Device, DeviceDescriptor, GpuError, Ledger, Link, Load, RenderPass,
    TargetDescriptor, TargetId,
};
use crate::math::{Mat4, Vec3};
use crate::models::{Environment, Model, Placement, Resident, Shared, State, View};
use crate::raster::{Counters, Options, Samples, Target, TileSize, decode_srgb};

/// The sRGB colour behind a model that is looked at alone: a hazy sky.
pub const STUDIO_SKY: [u8; 3] = [185, 207, 228];

/// The device of a studio; memory has no bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct StudioOptions {
    /// Pixels of a picture's side.
    pub(super) side: u32,
    pub(super) link: Link,
    pub(super) card: Card,
    pub(super) counters: Counters,
}

/// One model in a state, of foliage without trunk or of wood without leaves, at the origin: square pictures of one sample a pixel, always
/// with the same sky and light, those of scenes which say nothing of them, so that what is found for one plant
/// can be held against what is found for another.
#[derive(Debug)]
pub(super) struct Studio<S = State> {
    device: Device,
    environment: Environment,
    pub(super) resident: Box<dyn Resident<S>>,
    target: TargetId,
    /// What the model and its instance sent.
    pub(super) initial: Ledger,
    /// What they hold on the device, in bytes.
    pub(super) resident_bytes: u64,
}

impl Studio {
    /// Makes a device and sends the model, an instance of it, and nothing else that is told.
    ///
    /// # Errors
    ///
    /// What the device refuses.
    pub(super) fn new(
        model: &dyn Model,
        state: &State,
        options: &StudioOptions,
    ) -> Result<Self, RunError> {
        Self::of(state, options, 0.0, |device, environment| {
            model.upload(device, environment)
        })
    }
}

impl<S> Studio<S> {
    /// As [`new`](Studio::new), of what `upload` sends to the device. A metre spans so many pixels where `w` of
    /// clip space is 1: it decides how much of a pixel a line covers.
    ///
    /// # Errors
    ///
    /// What the device refuses.
    pub(super) fn of(
        state: &S,
        options: &StudioOptions,
        pixels_per_metre: f32,
        upload: impl FnOnce(&mut Device, &Environment) -> Result<Box<dyn Shared<S>>, GpuError>,
    ) -> Result<Self, RunError> {
        let mut device = Device::new(DeviceDescriptor {
            memory_bytes: u64::MAX,
            link: options.link,
            card: options.card,
            raster: Options {
                tile: TileSize::Side64,
                counters: options.counters,
            },
        });
        let environment = Environment::new(&mut device, 1)?.seen_by(pixels_per_metre);
        environment.place(&mut device.queue(), 0, &Placement::IDENTITY)?;
        let without = device.resident_bytes();
        device.take_ledger();
        let shared = upload(&mut device, &environment)?;
        let resident = shared.instance(&mut device, state, 0)?;
        let initial = device.take_ledger();
        let resident_bytes = device.resident_bytes() - without;
        let target = device.create_target(&TargetDescriptor {
            label: "view",
            width: options.side,
            height: options.side,
            samples: Samples::One,
        })?;
        Ok(Self {
            device,
            environment,
            resident,
            target,
            initial,
            resident_bytes,
        })
    }

    /// Goes over to another state.
    ///
    /// # Errors
    ///
    /// None on this device.
    pub(super) fn show(&mut self, state: &S) -> Result<(), RunError> {
        self.resident.commit(&mut self.device.queue(), state)?;
        Ok(())
    }

    /// Goes over to another state, and tells what that sent.
    ///
    /// # Errors
    ///
    /// None on this device.
    pub(super) fn change_to(&mut self, state: &S) -> Result<Ledger, RunError> {
        self.device.take_ledger();
        self.show(state)?;
        Ok(self.device.take_ledger())
    }

    /// Draws pictures of another side from now on.
    ///
    /// # Errors
    ///
    /// When the device has no targets of that size.
    pub(super) fn resize(&mut self, side: u32) -> Result<(), RunError> {
        self.target = self.device.create_target(&TargetDescriptor {
            label: "view",
            width: side,
            height: side,
            samples: Samples::One,
        })?;
        self.device.take_ledger();
        Ok(())
    }

    /// Draws what a view shows, and tells what that took.
    ///
    /// # Errors
    ///
    /// None on this device.
    pub(super) fn draw(&mut self, clip_from_world: Mat4) -> Result<(&Target, Ledger), RunError> {
        let view = View {
            clip_from_world,
            to_light: Vec3::new(0.4, 0.8, 0.45).normalize(),
            light: Vec3::new(0.85, 0.82, 0.75),
            ambient: Vec3::new(0.25, 0.28, 0.32),
        };
        let mut queue = self.device.queue();
        self.environment.set_view(&mut queue, &view)?;
        let mut steps = Vec::new();
        self.resident.draw(&mut steps);
        self.resident.draw_lines(&mut steps);
        let load = Load::Clear {
            color: decode_srgb(STUDIO_SKY),
            depth: 1.0,
        };
        let pass = RenderPass {
            label: "view".to_owned(),
            target: self.target,
            load,
            steps,
        };
        let mut commands = Vec::new();
        self.resident.prepare(&mut commands);
        commands.push(Command::Render(pass));
        queue.submit(&commands)?;
        let ledger = self.device.take_ledger();
        Ok((self.device.inspect_target(self.target)?, ledger))
    }
}
