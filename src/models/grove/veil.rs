//! Lines that are drawn into targets of their own first, and then over the frame.
//!
//! | blend | passes over the lines | targets, 8 B a pixel | then over the frame |
//! |---|---|---|---|
//! | peeled | one a layer, each the nearest behind the last ([E01](crate::references)) | one a layer | a quad a layer, from far to near |
//! | weighted | colours, what shines through ([MB13](crate::references)) | two | one quad |
//! | moments | absorbances, their moments, colours ([MKKP18](crate::references)) | three | one quad |
//!
//! A pass draws into one target here: on cards that draw into several at once the second of the weighted and of
//! the moments come for free. Targets have one sample a pixel and channels of 32 bits, which are counted as the
//! device counts all: 4 B of colour and 4 B of depth. What lies behind the polygons is left out by the depth of
//! the frame's first sample.

use super::composite::{Composite, CompositeKind};
use super::lines::{GroveLines, LineStage, RANGE_SLOT, line_colour};
use super::moments::{absorbance, powers, transmittance, warped};
use crate::gpu::{
    Bindings, ColourMap, Corners, DepthMap, Device, Draw, Fragment, GpuError, Pixel, ProgramId,
    Samples, Step, TargetDescriptor, TargetId,
};
use crate::math::{Vec3, Vec4};
use crate::models::branches::BRANCH_GROUP;
use crate::models::shadow::Lighting;
use crate::scene::{GroveBlend, GroveChoice};

/// The slot of the frame's depth, among depths; the first is that of shadows.
const FRAME_SLOT: u32 = 1;
/// The slot of the depth of what was peeled before.
const PEELED_SLOT: u32 = 2;
/// The slot of sums of moments, among colours.
const MOMENT_SLOT: u32 = 0;
/// The slot of sums of absorbances.
const ABSORBED_SLOT: u32 = 1;

/// What lines are drawn through on their way to the frame; nothing where they are drawn into it.
#[derive(Debug, Default)]
pub(super) struct Veil {
    pub(super) passes: Vec<VeilPass>,
    /// What is drawn over the frame then: the program, and the targets that it reads.
    shown: Vec<(ProgramId, Vec<TargetId>)>,
}

/// A pass over all lines.
#[derive(Debug)]
pub(super) struct VeilPass {
    pub(super) label: &'static str,
    pub(super) target: TargetId,
    /// What is there before.
    pub(super) clear: Vec4,
    pub(super) program: ProgramId,
    /// What it reads beside the frame's depth.
    pub(super) reads: Vec<Step>,
}

impl Veil {
    /// What a choice needs of a device whose frame has this target.
    pub(super) fn new(
        device: &mut Device,
        choice: GroveChoice,
        frame: TargetId,
    ) -> Result<Self, GpuError> {
        let frame = device.inspect_target(frame)?;
        let (width, height) = (frame.width(), frame.height());
        let mut pass = |label, stage, clear, reads| {
            let target = device.create_target(&TargetDescriptor {
                label,
                width,
                height,
                samples: Samples::One,
            })?;
            let program = device.create_program(std::sync::Arc::new(GroveLines { stage }));
            Ok::<_, GpuError>(VeilPass {
                label,
                target,
                clear,
                program,
                reads,
            })
        };
        let colour = |slot, target| Step::Colour { slot, target };
        let mut passes: Vec<VeilPass> = Vec::new();
        let kind = match choice.blend {
            GroveBlend::Peeled => {
                for _ in 0..choice.layers {
                    let peeled = passes.last().map(|last| Step::Depth {
                        slot: PEELED_SLOT,
                        target: last.target,
                    });
                    let reads = peeled.into_iter().collect();
                    passes.push(pass("grove layer", LineStage::Peel, Vec4::ZERO, reads)?);
                }
                CompositeKind::Layer
            }
            GroveBlend::Weighted => {
                passes.push(pass("grove sums", LineStage::Weigh, Vec4::ZERO, vec![])?);
                passes.push(pass("grove light", LineStage::Reveal, Vec4::ONE, vec![])?);
                CompositeKind::Weighted
            }
            GroveBlend::Moments => {
                let absorbed = pass("grove absorbed", LineStage::Absorb, Vec4::ZERO, vec![])?;
                let moments = pass("grove moments", LineStage::Gather, Vec4::ZERO, vec![])?;
                let reads = vec![
                    colour(MOMENT_SLOT, moments.target),
                    colour(ABSORBED_SLOT, absorbed.target),
                ];
                let sums = pass("grove sums", LineStage::Reconstruct, Vec4::ZERO, reads)?;
                passes.extend([absorbed, moments, sums]);
                CompositeKind::Moments
            }
            GroveBlend::WritesDepth
            | GroveBlend::KeepsDepth
            | GroveBlend::Sorted
            | GroveBlend::Hashed
            | GroveBlend::Coverage => return Ok(Self::default()),
        };
        let targets: Vec<TargetId> = passes.iter().map(|pass| pass.target).collect();
        let program = device.create_program(std::sync::Arc::new(Composite { kind }));
        let shown = match kind {
            CompositeKind::Layer => targets
                .into_iter()
                .rev()
                .map(|layer| (program, vec![layer]))
                .collect(),
            CompositeKind::Weighted => vec![(program, targets)],
            CompositeKind::Moments => vec![(program, vec![targets[2], targets[0]])],
        };
        Ok(Self { passes, shown })
    }

    /// Adds the steps that draw what came of the passes over the frame.
    pub(super) fn show(&self, steps: &mut Vec<Step>) {
        for (program, targets) in &self.shown {
            steps.push(Step::Program(*program));
            let slots = (0..).zip(targets);
            steps.extend(slots.map(|(slot, &target)| Step::Colour { slot, target }));
            steps.push(Step::Draw(Draw {
                source: Corners::Counted,
                first_corner: 0,
                corner_count: 4,
                instance: 0,
                group: BRANCH_GROUP,
            }));
        }
    }
}

impl VeilPass {
    /// The steps that bind what it reads.
    pub(super) fn bind(&self, frame: TargetId, steps: &mut Vec<Step>) {
        steps.push(Step::Depth {
            slot: FRAME_SLOT,
            target: frame,
        });
        steps.extend(&self.reads);
    }
}

/// A line's fragment on its way to a target that is not the frame.
#[derive(Debug)]
pub(super) struct VeilFragment<'a> {
    stage: LineStage,
    lighting: Lighting<'a>,
    frame: Option<DepthMap<'a>>,
    peeled: Option<DepthMap<'a>>,
    moments: Option<ColourMap<'a>>,
    absorbed: Option<ColourMap<'a>>,
    /// The nearest and the farthest depth, in metres.
    range: [f32; 2],
}

impl<'a> VeilFragment<'a> {
    pub(super) fn new(stage: LineStage, bindings: &Bindings<'a>) -> Self {
        let [_, nearest, farthest] = bindings.storage(RANGE_SLOT as usize).f32s(0);
        Self {
            stage,
            lighting: Lighting::of(bindings),
            frame: bindings.depth(FRAME_SLOT as usize),
            peeled: bindings.depth(PEELED_SLOT as usize),
            moments: bindings.colour(MOMENT_SLOT as usize),
            absorbed: bindings.colour(ABSORBED_SLOT as usize),
            range: [nearest, farthest],
        }
    }

    /// The share of light that reaches a depth, as moments have it.
    fn light(&self, position: [u32; 2], depth: f32) -> f32 {
        let (Some(moments), Some(absorbed)) = (self.moments, self.absorbed) else {
            return 1.0;
        };
        let total = absorbed.colour(position).w;
        transmittance(total, moments.colour(position), warped(depth, self.range))
    }
}

impl Fragment for VeilFragment<'_> {
    /// Colour, opacity, light, depth in metres.
    const VARYINGS: usize = 6;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = true;
    const IN_LANES: bool = false;

    /// Whether it lies before the polygons, and behind what was peeled.
    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        let shows = self
            .frame
            .is_none_or(|frame| pixel.depth < frame.depth(pixel.position));
        shows
            && self
                .peeled
                .is_none_or(|peeled| pixel.depth > peeled.depth(pixel.position))
    }

    fn texels_tested(&self) -> u64 {
        u64::from(self.frame.is_some()) + u64::from(self.peeled.is_some())
    }

    fn texels_shaded(&self) -> u64 {
        match self.stage {
            LineStage::Reconstruct => self.lighting.texels() + 2,
            LineStage::Peel | LineStage::Weigh => self.lighting.texels(),
            _ => 0,
        }
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let [_, _, _, alpha, _, depth, ..] = *pixel.varyings;
        let weighted = |weight: f32| {
            let colour = line_colour(&self.lighting, pixel).truncate();
            (colour * (alpha * weight)).extend(alpha * weight)
        };
        match self.stage {
            LineStage::Weigh => weighted(weight(depth, alpha)),
            LineStage::Reveal => Vec3::ZERO.extend(alpha),
            LineStage::Absorb => Vec3::ZERO.extend(absorbance(alpha)),
            LineStage::Gather => powers(warped(depth, self.range)) * absorbance(alpha),
            LineStage::Reconstruct => weighted(self.light(pixel.position, depth)),
            _ => line_colour(&self.lighting, pixel),
        }
    }
}

/// How much a fragment counts that lies so many metres away ([MB13](crate::references), eq. 9: for scenes as deep
/// as some hundred metres).
fn weight(depth: f32, alpha: f32) -> f32 {
    let far = depth / 200.0;
    let falling = 0.03 / (1e-5 + far * far * far * far);
    alpha * falling.clamp(1e-2, 3e3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearer_and_denser_fragments_count_for_more() {
        assert!((weight(0.0, 0.5) - 1500.0).abs() < 0.01);
        assert_eq!(weight(1e4, 1.0).to_bits(), 1e-2_f32.to_bits());
        assert!((weight(200.0, 1.0) - 0.03 / 1.00001).abs() < 1e-6);
        assert!(weight(50.0, 0.5) > weight(60.0, 0.5));
    }
}
