//! What all instances of a painted plant share on the device, however its strokes come there.

use std::sync::Arc;

use super::backdrop::BackdropProgram;
use super::brushes::{Painted, brush_set};
use super::ground::ground;
use super::painting::Painting;
use super::program::{BRUSH_SLOT, GROUND_SLOT, PAINTING_SLOT, Source, StrokeProgram};
use crate::gpu::{
    BufferId, Cause, Corners, Device, Draw, GpuError, Step, TextureDescriptor, TextureFormat,
    TextureId, Usage,
};
use crate::math::index_u32;
use crate::models::Environment;
use crate::models::surface::{STROKE_GROUP, filled};

/// What the program reads of the painting as a whole.
///
/// | words | field          | type      | unit, space |
/// |------:|----------------|-----------|-------------|
/// | 0–2   | `center`       | 3 × `f32` | metres, plant: from where strokes face outwards |
/// | 3     | `leaf_scale`   | `f32`     |             |
/// | 4     | `branch_scale` | `f32`     |             |
/// | 5     | `grain`        | `f32`     | from 0 to 1 |
/// | 6–7   | `seed`         | `u64`     |             |
/// | 8 …   | `colours`      | 3 × `f32` | linear, a foliage group; then that of marked strokes and the bark's |
///
/// Little-endian and unpadded.
pub(super) fn header_bytes(painting: &Painting) -> Vec<u8> {
    let options = painting.options();
    let [x, y, z] = painting.center().to_array();
    let floats = [
        x,
        y,
        z,
        options.leaf_scale,
        options.branch_scale,
        options.grain,
    ];
    let mut bytes: Vec<u8> = floats.into_iter().flat_map(f32::to_le_bytes).collect();
    bytes.extend(options.seed.to_le_bytes());
    let colours = painting
        .colours()
        .iter()
        .flat_map(|colour| colour.to_array());
    bytes.extend(colours.flat_map(f32::to_le_bytes));
    bytes
}

/// Program, painting and pictures on the device.
#[derive(Debug, Clone)]
pub(super) struct PaintSurface {
    steps: Vec<Step>,
    /// Draws the ground behind everything.
    backdrop: Vec<Step>,
}

impl PaintSurface {
    pub(super) fn upload(
        device: &mut Device,
        environment: &Environment,
        painting: &Painting,
        source: Source,
    ) -> Result<Self, GpuError> {
        let options = painting.options();
        let header = header_bytes(painting);
        let cause = Cause::of("painting");
        let header = filled(device, "painting", Usage::STORAGE, &header, cause)?;
        let brushes = upload(device, "brushes", &brush_set(options.look))?;
        let ground = upload(device, "painted ground", &ground(options.look))?;
        let look = options.look;
        let textures = [(BRUSH_SLOT, brushes), (GROUND_SLOT, ground)];
        let bound = |steps: &mut Vec<Step>| {
            steps.push(Step::Storage {
                slot: PAINTING_SLOT,
                buffer: header,
            });
            let textures = textures.into_iter();
            steps.extend(textures.map(|(slot, texture)| Step::Texture { slot, texture }));
        };
        let program = device.create_program(Arc::new(StrokeProgram { look, source }));
        let mut steps: Vec<Step> = environment.bind(program).collect();
        bound(&mut steps);
        let program = device.create_program(Arc::new(BackdropProgram { look }));
        let mut backdrop: Vec<Step> = environment.bind(program).collect();
        bound(&mut backdrop);
        backdrop.push(Step::Draw(Draw {
            source: Corners::Counted,
            first_corner: 0,
            corner_count: 4,
            instance: 0,
            group: STROKE_GROUP,
        }));
        Ok(Self { steps, backdrop })
    }

    /// The steps that bind it, with buffers of the strokes' own.
    pub(super) fn bind(&self, storage: &[(u32, BufferId)]) -> Vec<Step> {
        let mut steps = self.steps.clone();
        let own = storage.iter();
        steps.extend(own.map(|&(slot, buffer)| Step::Storage { slot, buffer }));
        steps
    }

    /// The steps that draw the ground.
    pub(super) fn backdrop(&self) -> &[Step] {
        &self.backdrop
    }

    /// Bytes of all this.
    pub(super) fn size(painting: &Painting) -> u64 {
        let look = painting.options().look;
        let header = header_bytes(painting).len() as u64;
        header + brush_set(look).bytes() + ground(look).bytes()
    }
}

fn upload(device: &mut Device, label: &str, painted: &Painted) -> Result<TextureId, GpuError> {
    let [width, height] = painted.size;
    let texture = device.create_texture(&TextureDescriptor {
        label,
        format: TextureFormat::Linear8,
        width,
        height,
        levels: index_u32(painted.levels.len()),
    })?;
    for (level, bytes) in (0..).zip(&painted.levels) {
        let cause = Cause::of("texture");
        device.queue().write_texture(texture, level, bytes, cause)?;
    }
    Ok(texture)
}
