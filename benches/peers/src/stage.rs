//! A dump on a device of spinney's, ready to be drawn again and again.

use std::path::Path;
use std::sync::Arc;

use spinney::gpu::{
    Blend, BufferDescriptor, BufferId, Card, Cause, Command, Corners, Device, DeviceDescriptor,
    Draw, GpuError, Ledger, Link, Load, Program, RenderPass, Residency, Step, TargetDescriptor,
    TargetId, TextureDescriptor, TextureFormat, TextureId, Usage,
};
use spinney::math::{Vec2, Vec4};
use spinney::raster::{Counters, Options, Samples, TileSize};
use spinney::report::Picture;

use crate::Fault;
use crate::dump::{Batch, Camera, Dump, Mode, Wrapping};
use crate::leaves::{INSTANCE_SLOT, LeafQuads, SURFACE_SLOT, Surface, Texturing, VIEW_SLOT};
use crate::lines::BlendedLines;
use crate::mesh::MeshTriangles;
use crate::texels::Texels;

/// Room for anything that is drawn here.
const MEMORY: u64 = 1 << 34;

const CAUSE: Cause = Cause::of("scene");

/// Everything on its device, and the pass that draws it.
#[derive(Debug)]
pub(crate) struct Stage {
    device: Device,
    target: TargetId,
    commands: Vec<Command>,
    /// Triangles or lines that a frame submits.
    pub(crate) primitives: u64,
    /// Whether these are lines.
    pub(crate) draws_lines: bool,
    /// Triangles among them that are submitted as quads.
    pub(crate) in_quads: u64,
    /// Pixels: width, height.
    pub(crate) size: [u32; 2],
}

/// What is drawn once for each instance.
pub(crate) struct Drawn<'a> {
    /// How.
    pub(crate) program: Arc<dyn Program>,
    /// The bytes of its vertices.
    pub(crate) vertices: &'a [u8],
    /// Corners; `None` counts up.
    pub(crate) indices: Option<&'a [u32]>,
    /// How many corners.
    pub(crate) corners: u32,
    /// The words of storage from [`SURFACE_SLOT`] on.
    pub(crate) storage: Vec<Vec<u32>>,
    /// The texture of slot 0.
    pub(crate) texture: Option<&'a Texels>,
    /// The matrices of the instances, 16 numbers each, columns first.
    pub(crate) instances: &'a [f32],
}

impl Stage {
    /// An empty stage.
    pub(crate) fn new(
        size: [u32; 2],
        clear: [f32; 4],
        counters: Counters,
    ) -> Result<Self, GpuError> {
        let mut device = Device::new(DeviceDescriptor {
            memory_bytes: MEMORY,
            link: Link::ALL[0],
            card: Card::ALL[0],
            raster: Options {
                tile: TileSize::Side64,
                counters,
            },
        });
        let target = device.create_target(&TargetDescriptor {
            label: "frame",
            width: size[0],
            height: size[1],
            samples: Samples::One,
        })?;
        let pass = RenderPass {
            label: "frame".to_owned(),
            target,
            load: Load::Clear {
                color: Vec4::from_array(clear),
                depth: 1.0,
            },
            steps: Vec::new(),
        };
        Ok(Self {
            device,
            target,
            commands: vec![Command::Render(pass)],
            primitives: 0,
            draws_lines: false,
            in_quads: 0,
            size,
        })
    }

    /// Sends a dump.
    pub(crate) fn of(folder: &Path, counters: Counters) -> Result<Self, Fault> {
        let dump = Dump::read(folder)?;
        let size = [dump.camera.width, dump.camera.height];
        let mut stage = Self::new(size, dump.clear, counters)?;
        let view = stage.buffer(
            "view",
            Usage::STORAGE,
            &bytes(&clip_from_world(&dump.camera)),
        )?;
        for batch in &dump.batches {
            stage.add(folder, batch, view)?;
        }
        Ok(stage)
    }

    fn add(&mut self, folder: &Path, batch: &Batch, view: BufferId) -> Result<(), Fault> {
        if batch.has("xy") {
            let (ends, colours) = (batch.bytes(folder, "xy")?, batch.bytes(folder, "rgba")?);
            let ends = ends
                .as_chunks::<8>()
                .0
                .iter()
                .zip(colours.as_chunks::<4>().0);
            let vertices: Vec<u8> = ends
                .flat_map(|(xy, rgba)| xy.iter().chain(rgba))
                .copied()
                .collect();
            let corners = u32::try_from(vertices.len() / 12)?;
            self.draws_lines = true;
            self.primitives += u64::from(corners / 2);
            return Ok(self.draw(
                view,
                &Drawn {
                    program: Arc::new(BlendedLines),
                    vertices: &vertices,
                    indices: None,
                    corners,
                    storage: Vec::new(),
                    texture: None,
                    instances: &[0.0; 16],
                },
            )?);
        }
        let texture = match batch.shape("tex") {
            &[layers, height, width, _] => Some(Texels::of(
                [layers, height, width],
                &batch.bytes(folder, "tex")?,
            )),
            _ => None,
        };
        let blend = match batch.mode {
            Mode::Opaque | Mode::Mask => Blend::Opaque,
            Mode::Blend => Blend::Alpha,
        };
        let instances = batch.floats(folder, "inst")?;
        let (positions, uv) = (batch.floats(folder, "pos")?, batch.floats(folder, "uv")?);
        let normals = batch.floats(folder, "nrm")?;
        let corners = batch.numbers(folder, "idx")?;
        let layers = match batch.has("layer") {
            true => batch.floats(folder, "layer")?,
            false => Vec::new(),
        };
        let cutoff = match batch.mode {
            Mode::Mask => batch.cutoff,
            Mode::Opaque | Mode::Blend => 0.0,
        };
        let clamps = texture.is_none() || batch.wrap == [Wrapping::Clamp; 2];
        let color = Vec4::from_array(batch.color);
        let count = (instances.len() / 16) as u64;
        self.primitives += count * (corners.len() / 3) as u64;
        // An opaque texture does not test alpha, which the program of leaves always does.
        let tests = texture.is_none() == (batch.mode == Mode::Opaque) || batch.mode == Mode::Blend;
        let quads = quads(&corners, &normals, &uv).filter(|_| clamps && tests);
        if let Some((quads, role_corners)) = quads {
            self.in_quads += count * 2 * (quads.len() / 4) as u64;
            let tiles = texture.as_ref().map_or([1, 1], |texels| texels.tiles);
            let [columns, rows] = tiles.map(|side| side as f32);
            let surface = Surface {
                color,
                cutoff,
                tiles: Vec2::new(columns, rows),
                tile_side: texture.as_ref().map_or(1.0, |texels| texels.width as f32) / columns,
                corners: role_corners,
            };
            let mut storage = vec![surface.words().into_iter().map(f32::to_bits).collect()];
            let texturing = match (&texture, tiles) {
                (None, _) => Texturing::None,
                (Some(_), [1, 1]) => Texturing::Whole,
                (Some(_), _) => {
                    // Vertices of a quad lie side by side, so every fourth vertex tells of one.
                    storage.push(
                        layers
                            .iter()
                            .step_by(4)
                            .map(|&layer| layer as u32)
                            .collect(),
                    );
                    Texturing::Tiles
                }
            };
            return Ok(self.draw(
                view,
                &Drawn {
                    program: Arc::new(LeafQuads { texturing, blend }),
                    vertices: &bytes(&positions),
                    indices: Some(&quads),
                    corners: u32::try_from(quads.len())?,
                    storage,
                    texture: texture.as_ref(),
                    instances: &instances,
                },
            )?);
        }
        if texture
            .as_ref()
            .is_some_and(|texels| texels.tiles != [1, 1])
        {
            return Err("several layers of a texture on triangles that are no quads".into());
        }
        let vertices = positions
            .as_chunks::<3>()
            .0
            .iter()
            .zip(normals.as_chunks::<3>().0);
        let vertices = vertices.zip(uv.as_chunks::<2>().0);
        let vertices: Vec<f32> = vertices
            .flat_map(|((position, normal), uv)| position.iter().chain(normal).chain(uv))
            .copied()
            .collect();
        let mut surface: Vec<u32> = color.to_array().map(f32::to_bits).to_vec();
        surface.extend([
            cutoff.to_bits(),
            u32::from(batch.wrap == [Wrapping::Repeat; 2]),
        ]);
        self.draw(
            view,
            &Drawn {
                program: Arc::new(MeshTriangles {
                    textured: texture.is_some(),
                    blend,
                }),
                vertices: &bytes(&vertices),
                indices: Some(&corners),
                corners: u32::try_from(corners.len())?,
                storage: vec![surface],
                texture: texture.as_ref(),
                instances: &instances,
            },
        )?;
        Ok(())
    }

    /// Sends what `drawn` needs, and adds a draw an instance over the same buffers.
    pub(crate) fn draw(&mut self, view: BufferId, drawn: &Drawn<'_>) -> Result<(), GpuError> {
        let mut steps = vec![Step::Program(
            self.device.create_program(Arc::clone(&drawn.program)),
        )];
        let vertices = self.buffer("vertices", Usage::VERTEX, drawn.vertices)?;
        steps.push(Step::Vertices(vertices));
        let source = match drawn.indices {
            None => Corners::Counted,
            Some(indices) => {
                let bytes: Vec<u8> = indices
                    .iter()
                    .flat_map(|index| index.to_le_bytes())
                    .collect();
                steps.push(Step::Indices(self.buffer(
                    "indices",
                    Usage::INDEX,
                    &bytes,
                )?));
                Corners::Indexed
            }
        };
        let placements = self.buffer("instances", Usage::STORAGE, &bytes(drawn.instances))?;
        for (slot, buffer) in [(VIEW_SLOT, view), (INSTANCE_SLOT, placements)] {
            steps.push(Step::Storage { slot, buffer });
        }
        for (slot, words) in (SURFACE_SLOT..).zip(&drawn.storage) {
            let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            let buffer = self.buffer("surface", Usage::STORAGE, &bytes)?;
            steps.push(Step::Storage { slot, buffer });
        }
        if let Some(texels) = drawn.texture {
            let texture = self.texture(texels)?;
            steps.push(Step::Texture { slot: 0, texture });
        }
        for (instance, _) in (0..).zip(drawn.instances.chunks_exact(16)) {
            steps.push(Step::Draw(Draw {
                source,
                first_corner: 0,
                corner_count: drawn.corners,
                instance,
                group: 0,
            }));
        }
        if let Command::Render(pass) = &mut self.commands[0] {
            pass.steps.extend(steps);
        }
        Ok(())
    }

    pub(crate) fn buffer(
        &mut self,
        label: &str,
        usage: Usage,
        bytes: &[u8],
    ) -> Result<BufferId, GpuError> {
        let buffer = self.device.create_buffer(&BufferDescriptor {
            label,
            size: bytes.len() as u64,
            usage,
            residency: Residency::Device,
        })?;
        self.device.queue().write(buffer, 0, bytes, CAUSE)?;
        Ok(buffer)
    }

    fn texture(&mut self, texels: &Texels) -> Result<TextureId, GpuError> {
        let texture = self.device.create_texture(&TextureDescriptor {
            label: "texture",
            format: TextureFormat::Srgb8,
            width: texels.width,
            height: texels.height,
            levels: u32::try_from(texels.levels.len()).expect("there are few levels"),
        })?;
        for (level, bytes) in (0..).zip(&texels.levels) {
            self.device
                .queue()
                .write_texture(texture, level, bytes, CAUSE)?;
        }
        Ok(texture)
    }

    /// Draws a frame: what is timed.
    pub(crate) fn frame(&mut self) -> Result<(), GpuError> {
        self.device.queue().submit(&self.commands)
    }

    /// What was counted since the last call.
    pub(crate) fn ledger(&mut self) -> Ledger {
        self.device.take_ledger()
    }

    /// The frame, its linear colours as bytes that mean themselves: what the peers' targets hold.
    pub(crate) fn picture(&self) -> Result<Picture, Fault> {
        let linear = self.device.inspect_target(self.target)?.linear();
        let byte = |channel: f32| (channel.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        let rgba = linear.iter().flat_map(|color| {
            let [r, g, b, _] = color.to_array().map(byte);
            [r, g, b, 255]
        });
        Ok(Picture::new(self.size[0], self.size[1], rgba.collect())?)
    }

    /// How many pixels show anything opaque.
    pub(crate) fn covered_pixels(&self) -> Result<u32, GpuError> {
        Ok(self.device.inspect_target(self.target)?.pixels_showing(0))
    }
}

/// The quads of triangles that come in pairs 0-1-2 and 0-2-3, whose four vertices lie side by side,
/// have one normal, and the same four texture coordinates in every quad; with those coordinates.
fn quads(corners: &[u32], normals: &[f32], uv: &[f32]) -> Option<(Vec<u32>, [Vec2; 4])> {
    let pairs = corners.as_chunks::<6>();
    if !pairs.1.is_empty() || corners.is_empty() {
        return None;
    }
    let (normals, uv) = (normals.as_chunks::<3>().0, uv.as_chunks::<2>().0);
    let mut quads = Vec::with_capacity(4 * pairs.0.len());
    let first = uv.first_chunk::<4>()?;
    for &[a, b, c, d, e, f] in pairs.0 {
        let at = a as usize;
        let is_quad = a.is_multiple_of(4) && [b, c, d, e, f] == [a + 1, a + 2, a, a + 2, a + 3];
        let four = normals.get(at..at + 4)?;
        let is_flat = four.iter().all(|normal| *normal == four[0]);
        if !is_quad || !is_flat || uv.get(at..at + 4)? != first {
            return None;
        }
        quads.extend([a, b, c, f]);
    }
    Some((quads, first.map(Vec2::from_array)))
}

/// From the world to clip space with z from 0 to 1: `z' = (z + w) / 2` of OpenGL's.
pub(crate) fn clip_from_world(camera: &Camera) -> [f32; 16] {
    let mut half = [0.0; 16];
    for (place, value) in [(0, 1.0), (5, 1.0), (10, 0.5), (14, 0.5), (15, 1.0)] {
        half[place] = value;
    }
    let clip = product(&product(&half, &camera.proj), &camera.view);
    clip.map(|value| value as f32)
}

/// The product of two matrices, columns first.
fn product(left: &[f64; 16], right: &[f64; 16]) -> [f64; 16] {
    std::array::from_fn(|place| {
        let (column, row) = (place / 4, place % 4);
        (0..4)
            .map(|k| left[4 * k + row] * right[4 * column + k])
            .sum()
    })
}

pub(crate) fn bytes(floats: &[f32]) -> Vec<u8> {
    floats
        .iter()
        .flat_map(|float| float.to_le_bytes())
        .collect()
}
