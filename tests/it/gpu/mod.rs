//! The device keeps its word: what it refuses changes and counts nothing, what it does is counted
//! once, and where draw arguments lie does not show.

mod compute;
mod counting;
mod depth;
mod draws;
mod handles;
mod instances;
mod ranges;

use std::sync::Arc;

use proptest::prelude::{ProptestConfig, any, prop_assert_eq};
use spinney::gpu::{
    Bindings, Blend, BufferDescriptor, BufferId, Cause, Command, Corners, DepthMap, Device,
    DeviceDescriptor, Draw, DrawFromCounter, DrawIndirect, Fragment, Geometry, GpuError,
    IndirectRecord, Kernel, Layout, Ledger, Link, Load, Pixel, Program, ProgramId, Recording,
    Region, RenderPass, Residency, Step, Stream, TargetDescriptor, TargetId, TargetLayer,
    TextureDescriptor, TextureFormat, TextureId, Topology, Transfer, Usage, VertexCall,
};
use spinney::math::{Vec4, index_u32};
use spinney::raster::{Counters, Image, Options, Samples, TileSize};

use crate::laws::check_conservation;
use crate::support::descriptor;

const SIDE: u32 = 40;
const MEMORY: u64 = 1 << 20;
/// Quads in the vertex buffer.
const QUADS: u32 = 60;
const CAUSE: Cause = Cause::of("test");

/// Draws positions as they are, each primitive in a colour of its own.
#[derive(Debug)]
struct Flat(Layout);

const PUSHED: Layout = Layout {
    name: "pushed",
    version: 1,
    topology: Topology::QuadList,
    blend: Blend::Opaque,
    vertex_stride: 12,
    pulled_primitive_bytes: 0,
    pulled_vertex_bytes: 0,
    storage_slots: 0,
    texture_slots: 0,
};

impl Program for Flat {
    fn layout(&self) -> Layout {
        self.0
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let vertices = match self.0.vertex_stride {
            0 => call.bindings.storage(0),
            _ => call.bindings.vertices(),
        };
        for &corner in call.corners {
            let [x, y, z] = vertices.f32s(3 * corner as usize);
            geometry.corners.push(index_u32(geometry.clip.len()));
            geometry.clip.push(Vec4::new(x, y, z, 1.0));
            geometry.vertex_ids.push(corner);
        }
        let corners_per_primitive = match self.0.topology {
            Topology::TriangleList => 3,
            Topology::QuadList => 4,
            Topology::LineList => 2,
        };
        for primitive in call.corners.chunks(corners_per_primitive) {
            geometry.flats.push(primitive[0] as f32 / 256.0);
        }
    }

    fn fragment_stage<'a>(&self, _: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        Box::new(Grey)
    }
}

#[derive(Debug)]
struct Grey;

impl Fragment for Grey {
    const VARYINGS: usize = 0;
    const FLATS: usize = 1;
    const TESTS_ALPHA: bool = false;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        Vec4::new(pixel.flats[0], 0.5, 1.0 - pixel.flats[0], 1.0)
    }
}

/// All that a device holds.
#[derive(PartialEq)]
struct Seen {
    recording: Recording,
    buffers: Vec<Vec<u8>>,
    picture: Image,
    resident: Vec<(String, u64)>,
}

/// A device with one of everything.
struct Bench {
    device: Device,
    target: TargetId,
    texture: TextureId,
    vertices: BufferId,
    indices: BufferId,
    arguments: BufferId,
    counter: BufferId,
    /// In host memory, for any use.
    host: BufferId,
    pushed: ProgramId,
}

impl Bench {
    fn new(seed: u64) -> Self {
        let mut device = Device::new(DeviceDescriptor {
            memory_bytes: MEMORY,
            // Unlike others it is slower on the way back.
            link: Link::named("agp8x").expect("a known link"),
            raster: Options {
                tile: TileSize::Side32,
                counters: Counters::Exact,
            },
            ..descriptor()
        });
        device.record();
        let target = device
            .create_target(&TargetDescriptor {
                label: "picture",
                width: SIDE,
                height: SIDE,
                samples: Samples::One,
            })
            .expect("memory suffices");
        let texture = device
            .create_texture(&TextureDescriptor {
                label: "bark",
                format: TextureFormat::Srgb8,
                width: 4,
                height: 2,
                levels: 2,
            })
            .expect("memory suffices");
        let mut draws = spinney::math::Stream::new(seed, 0).draws();
        let quads = (0..QUADS).flat_map(|_| {
            let (x, y, z) = (draws.signed(), draws.signed(), draws.unit());
            [(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)]
                .into_iter()
                .flat_map(move |(right, up)| [x + right, y + up, z])
        });
        let vertex_bytes: Vec<u8> = quads.flat_map(f32::to_le_bytes).collect();
        let index_bytes = words((0..4 * QUADS).map(|corner| {
            // Quads from the last to the first.
            4 * (QUADS - 1 - corner / 4) + corner % 4
        }));
        let mut buffer = |label, usage, residency, bytes: &[u8]| {
            let size = bytes.len() as u64;
            let descriptor = BufferDescriptor {
                label,
                size,
                usage,
                residency,
            };
            let buffer = device.create_buffer(&descriptor).expect("memory suffices");
            let written = device.queue().write(buffer, 0, bytes, CAUSE);
            written.expect("within the buffer");
            buffer
        };
        let everything =
            Usage::VERTEX | Usage::INDEX | Usage::STORAGE | Usage::INDIRECT | Usage::COPY_SOURCE;
        let on_device = Residency::Device;
        let vertices = buffer(
            "vertices",
            Usage::VERTEX | Usage::STORAGE | Usage::COPY_SOURCE,
            on_device,
            &vertex_bytes,
        );
        Self {
            vertices,
            indices: buffer("indices", Usage::INDEX, on_device, &index_bytes),
            arguments: buffer("arguments", Usage::INDIRECT, on_device, &[0; 640]),
            counter: buffer("counter", Usage::INDIRECT, on_device, &[0; 4]),
            host: buffer("host", everything, Residency::Host, &vertex_bytes),
            pushed: device.create_program(Arc::new(Flat(PUSHED))),
            device,
            target,
            texture,
        }
    }

    fn program(&mut self, layout: Layout) -> ProgramId {
        self.device.create_program(Arc::new(Flat(layout)))
    }

    fn pass(&self, steps: impl IntoIterator<Item = Step>) -> Command {
        Command::Render(RenderPass {
            label: "pass".to_owned(),
            target: self.target,
            load: Load::Clear {
                color: Vec4::ZERO,
                depth: 1.0,
            },
            steps: steps.into_iter().collect(),
        })
    }

    /// A pass that binds the usual things, then does `steps`.
    fn bound(&self, steps: impl IntoIterator<Item = Step>) -> Command {
        let bind = [
            Step::Program(self.pushed),
            Step::Vertices(self.vertices),
            Step::Indices(self.indices),
        ];
        self.pass(bind.into_iter().chain(steps))
    }

    fn submit(&mut self, command: Command) -> Result<(), GpuError> {
        self.device.queue().submit(&[command])
    }

    /// What is seen and counted after a command.
    fn shown(&mut self, command: Command) -> (Image, Vec<Option<u32>>, Ledger) {
        self.device.take_ledger();
        self.submit(command).expect("a sound pass");
        let image = self.device.present(self.target).expect("it exists");
        let target = self.device.inspect_target(self.target).expect("it exists");
        let pixels = (0..SIDE * SIDE).map(|pixel| target.key(pixel % SIDE, pixel / SIDE));
        let keys = pixels.map(|key| key.map(|key| key.vertex)).collect();
        (image, keys, self.device.take_ledger())
    }

    fn everything(&self) -> Seen {
        let device = &self.device;
        let bytes = |(buffer, _)| device.inspect_buffer(buffer).expect("it lives").to_vec();
        Seen {
            recording: device.recording().expect("from the start").clone(),
            buffers: device.buffers().map(bytes).collect(),
            picture: device.present(self.target).expect("it exists"),
            resident: device.resident_by_label(),
        }
    }

    /// Asks for what must be refused: the message, after a look at everything.
    #[track_caller]
    fn refused<T>(&mut self, ask: impl FnOnce(&mut Self) -> Result<T, GpuError>) -> String {
        let held = self.device.take_ledger();
        let before = self.everything();
        let Err(error) = ask(self) else {
            panic!("this must be refused");
        };
        let after = self.everything();
        assert!(before == after, "{error}: something changed");
        let ledger = self.device.take_ledger();
        let nothing = Ledger {
            resident_bytes: held.resident_bytes,
            peak_bytes: held.peak_bytes,
            ..Ledger::default()
        };
        assert_eq!(ledger, nothing, "{error}: something was counted");
        error.to_string()
    }
}

fn words(words: impl IntoIterator<Item = u32>) -> Vec<u8> {
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

fn draw(source: Corners, first_corner: u32, corner_count: u32) -> Step {
    Step::Draw(Draw {
        source,
        first_corner,
        corner_count,
        instance: 3,
        group: 5,
    })
}

fn indirect(source: Corners, arguments: BufferId, offset: u64, count: u32) -> Step {
    Step::DrawIndirect(DrawIndirect {
        source,
        arguments,
        offset,
        count,
        group: 5,
    })
}

fn from_counter(source: Corners, counter: BufferId, offset: u64, end: u32) -> Step {
    Step::DrawFromCounter(DrawFromCounter {
        source,
        counter,
        offset,
        scale: 8,
        end,
        instance: 3,
        group: 5,
    })
}

fn buffer_of(label: &str, size: u64, residency: Residency) -> BufferDescriptor<'_> {
    BufferDescriptor {
        label,
        size,
        usage: Usage::STORAGE,
        residency,
    }
}

const VERTEX_BYTES: u64 = 48 * QUADS as u64;
