//! Our own models on our own device, as [`DeviceModel`]s.

use super::contents::Contents;
use super::device::{Change, Counted, DeviceModel, Itemised, Picture, Reads, Resource};
use crate::gpu::{
    Card, Command, Device, DeviceDescriptor, GpuError, Ledger, Link, Load, RenderPass, ResourceId,
    Share, Stream, TargetDescriptor, TargetId,
};
use crate::math::{Mat4, Vec3, Vec4, index_usize};
use crate::models::{
    Environment, Kind, Model, Placement, Resident, Shared, State, TrunkLevel, TrunkModel, View,
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
    /// What [`DeviceModel::counted`] took from the device so far.
    counted: Ledger,
    contents: Contents,
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
        let environment = Environment::of_kind(&mut device, 1, kind)?;
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
        let target = device.create_target(&TargetDescriptor {
            label: "frame",
            width: side,
            height: side,
            samples: Samples::One,
        })?;
        Ok(Self {
            contents: Contents::of(&device),
            device,
            target,
            environment,
            resident,
            counted: Ledger::default(),
        })
    }

    fn draw(&mut self) -> Picture {
        let mut steps = Vec::new();
        self.resident.draw(&mut steps);
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
        let mut commands = Vec::new();
        self.resident.prepare(&mut commands);
        commands.push(Command::Render(pass));
        self.device.queue().submit(&commands).expect("a sound pass");
        self.device.present(self.target).expect("the target exists")
    }

    /// The number of the transfer that brought each recorded write: of those that were counted, as
    /// many as the ledger says that the transfer had ranges; of others, one each.
    fn transfers_of_writes(&self) -> impl Iterator<Item = u64> + '_ {
        let transfers = self.counted.transfers.iter();
        let uploads = transfers.filter(|transfer| transfer.stream == Stream::Upload);
        let ranges = uploads.map(|transfer| index_usize(transfer.ranges));
        let ranges = ranges.chain(std::iter::repeat(1));
        (0..)
            .zip(ranges)
            .flat_map(|(number, ranges)| std::iter::repeat_n(number, ranges))
    }
}

impl<S> DeviceModel<S> for Stage<S> {
    fn commit(&mut self, to: &S) {
        self.resident
            .commit(&mut self.device.queue(), to)
            .expect("a resident's own device");
    }

    fn resources(&self) -> Vec<Resource<'_>> {
        self.contents.resources(&self.device)
    }

    fn reads(&mut self) -> Reads {
        self.device.track_reads();
        self.draw();
        let reads = self.device.reads().expect("tracked just before");
        let mut ranges = Vec::new();
        for buffer in reads.buffers() {
            let number = self.contents.number(ResourceId::Buffer(buffer));
            // Also what is bound and not read at all counts as known.
            ranges.push((number, 0..0));
            let read = reads.ranges(buffer).into_iter();
            ranges.extend(read.map(|r| (number, index_usize(r.start)..index_usize(r.end))));
        }
        let mut primitives: Vec<_> = reads.fetched.iter().collect();
        primitives.sort();
        let fetched = primitives.into_iter().map(|primitive| {
            let key = [primitive.group, primitive.instance, primitive.vertex];
            let key = key.into_iter().flat_map(u32::to_le_bytes);
            key.chain(primitive.bytes.iter().copied()).collect()
        });
        Reads {
            ranges,
            fetched: fetched.collect(),
        }
    }

    fn overwrite(&mut self, resource: usize, at: usize, bytes: &[u8]) {
        let Some(ResourceId::Buffer(buffer)) = self.contents.id(resource) else {
            return;
        };
        // The device knows fillers only: runs of one byte.
        let mut start = 0;
        for run in bytes.chunk_by(|a, b| a == b) {
            let from = (at + start) as u64;
            let range = from..from + run.len() as u64;
            self.device
                .poison(buffer, range, run[0])
                .expect("within the buffer");
            start += run.len();
        }
    }

    fn log(&self) -> Option<Vec<Change<'_>>> {
        self.contents.log(&self.device, self.transfers_of_writes())
    }

    fn counted(&mut self) -> Option<Counted> {
        let taken = self.device.take_ledger();
        self.counted.add(&taken);
        self.counted.transfers.extend(taken.transfers);
        Some(counted(&self.counted))
    }

    fn picture(&mut self) -> Option<Picture> {
        Some(self.draw())
    }
}

/// The uploads of a ledger, as totals and itemised. Shares are of all streams; those that are no
/// uploads are taken off.
fn counted(ledger: &Ledger) -> Counted {
    let (upload, fetch, readback) = (&ledger.upload, &ledger.fetch, &ledger.readback);
    let others = [
        fetch.transfers + readback.transfers,
        fetch.payload_bytes + readback.payload_bytes,
    ];
    let shares = |by, shares: &mut dyn Iterator<Item = &Share>| {
        let sums = shares.fold([0, 0], |[transfers, bytes], share| {
            [transfers + share.transfers, bytes + share.payload_bytes]
        });
        Itemised {
            by,
            transfers: sums[0].saturating_sub(others[0]),
            payload_bytes: sums[1].saturating_sub(others[1]),
        }
    };
    let transfers = ledger.transfers.iter();
    let uploads = transfers.filter(|transfer| transfer.stream == Stream::Upload);
    let list = uploads.fold([0, 0], |[count, bytes], transfer| {
        [count + 1, bytes + transfer.payload_bytes]
    });
    Counted {
        transfers: upload.transfers,
        payload_bytes: upload.payload_bytes,
        itemised: vec![
            Itemised {
                by: "by transfer",
                transfers: list[0],
                payload_bytes: list[1],
            },
            shares("by cause", &mut ledger.by_cause.values()),
            shares("by buffer", &mut ledger.by_buffer.values()),
        ],
    }
}
