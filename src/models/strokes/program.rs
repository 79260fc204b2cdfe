//! The program that paints: a stroke becomes a quad with a brush's picture on it.
//!
//! All of a stroke's looks are decided once a stroke: one stroke, one colour.

use super::brushes::{DABS, cell};
use super::fragment::paint_kernel;
use super::record::StrokeRecord;
use crate::gpu::{Bindings, Blend, Geometry, Kernel, Layout, Program, Topology, VertexCall, Words};
use crate::math::{Mat4, Stream, Vec2, Vec3, det, index_u32};
use crate::models::cards::Eye;
use crate::models::environment::{INSTANCE_SLOT, Placement, VIEW_SLOT, View};
use crate::scene::PaintLook;

/// The slot of the [painting](super::surface::header_bytes).
pub(super) const PAINTING_SLOT: u32 = 2;
/// The slot of the strokes, where they are on the device.
pub(super) const STROKE_SLOT: u32 = 3;
/// The slot of the [runs](super::order::run_words) that show.
pub(super) const RUN_SLOT: u32 = 4;
/// The slot of the order of places, a `u32` each.
pub(super) const ORDER_SLOT: u32 = 5;
/// The slot of the brush set.
pub(super) const BRUSH_SLOT: u32 = 0;
/// The slot of what is painted on.
pub(super) const GROUND_SLOT: u32 = 1;

/// Where a stroke comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    /// From the device: every four corners are the next of the order, whose place a run makes a number.
    Ranges,
    /// From host memory: vertices are strokes, and all four corners of a quad name the same one.
    Host,
}

/// Paints strokes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct StrokeProgram {
    pub(super) look: PaintLook,
    pub(super) source: Source,
}

impl Program for StrokeProgram {
    fn layout(&self) -> Layout {
        let (name, stride, pulled, slots) = match (self.look, self.source) {
            // The order, a run, and the stroke.
            (PaintLook::Oil, Source::Ranges) => ("oil-stroke", 0, 12, ORDER_SLOT),
            (PaintLook::Watercolour, Source::Ranges) => ("wash-stroke", 0, 12, ORDER_SLOT),
            (PaintLook::Oil, Source::Host) => {
                ("oil-stroke-fetched", StrokeRecord::STRIDE, 0, PAINTING_SLOT)
            }
            (PaintLook::Watercolour, Source::Host) => (
                "wash-stroke-fetched",
                StrokeRecord::STRIDE,
                0,
                PAINTING_SLOT,
            ),
        };
        Layout {
            name,
            version: 1,
            topology: Topology::QuadList,
            blend: Blend::Alpha,
            vertex_stride: stride,
            pulled_primitive_bytes: if pulled > 0 {
                pulled + StrokeRecord::STRIDE
            } else {
                0
            },
            pulled_vertex_bytes: 0,
            storage_slots: slots + 1,
            texture_slots: GROUND_SLOT + 1,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let stage = Stage::new(self.look, call);
        match self.source {
            Source::Host => {
                let quads = call.corners.as_chunks::<4>().0.iter();
                for (corners, places) in quads.zip(call.places.as_chunks::<4>().0) {
                    let record = StrokeRecord::read(call.vertices, places[0] as usize);
                    stage.emit(&record, corners[0], geometry);
                }
            }
            Source::Ranges => {
                let storage = |slot: u32| call.bindings.storage(slot as usize);
                let (strokes, order) = (storage(STROKE_SLOT), storage(ORDER_SLOT));
                let runs = storage(RUN_SLOT);
                let run_count = runs.u32(0) as usize;
                for corners in call.corners.as_chunks::<4>().0 {
                    let place = order.u32(corners[0] as usize / 4);
                    if let Some(number) = stroke_at(runs, run_count, place) {
                        let record = StrokeRecord::read(strokes, number as usize);
                        stage.emit(&record, number, geometry);
                    }
                }
            }
        }
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        let grain = bindings.storage(PAINTING_SLOT as usize).f32(5);
        paint_kernel(self.look, grain, bindings)
    }
}

/// The number of the stroke at a place: that of the first run that ends after it.
fn stroke_at(runs: Words<'_>, count: usize, place: u32) -> Option<u32> {
    let (mut low, mut high) = (0, count);
    while low < high {
        let middle = usize::midpoint(low, high);
        if runs.u32(1 + 2 * middle) <= place {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    (low < count).then(|| place.wrapping_add(runs.u32(2 + 2 * low)))
}

/// What the vertex stage knows before it sees a stroke.
struct Stage<'a> {
    look: PaintLook,
    clip: Mat4,
    placement: Placement,
    /// In the plant's space.
    eye: Eye,
    to_light: Vec3,
    light: Vec3,
    ambient: Vec3,
    center: Vec3,
    scales: [f32; 2],
    numbers: Stream,
    painting: Words<'a>,
    bark: u32,
}

/// Where numbers come from that decide how a stroke looks.
const STREAM: u64 = 0x7374_726f;

/// The part of a leaf's length that is seen at least: painters do not foreshorten a dab away.
const LEAST_SEEN: f32 = 0.55;

/// Half the width of the finest brush, by the distance from the eye: of an image of 600 rows that spans 45
/// degrees, nearly a pixel. Finer twigs would be dots and gaps.
const FINEST: f32 = 0.001_2;

/// How much longer a branch's dab is than its piece, so that dabs run into each other.
const OVERLAP: f32 = 1.5;

impl<'a> Stage<'a> {
    fn new(look: PaintLook, call: &VertexCall<'a>) -> Self {
        let storage = |slot: u32| call.bindings.storage(slot as usize);
        let view = View::read(storage(VIEW_SLOT));
        let placement =
            Placement::from_words(storage(INSTANCE_SLOT).f32s(8 * call.instance as usize));
        let painting = storage(PAINTING_SLOT);
        let [x, y, z, leaf, branch] = painting.f32s(0);
        let [low, high] = painting.u32s(6);
        Self {
            look,
            clip: view.clip_from_world,
            placement,
            eye: Eye::of(&view.clip_from_world).of_plant(&placement),
            to_light: placement.rotation.inverse() * view.to_light,
            light: view.light,
            ambient: view.ambient,
            center: Vec3::new(x, y, z),
            scales: [leaf, branch],
            numbers: Stream::new(u64::from(high) << 32 | u64::from(low), STREAM),
            painting,
            bark: index_u32(painting.len().saturating_sub(8) / 3).saturating_sub(1),
        }
    }

    /// Emits the quad of a stroke, turned to the viewer about its axis.
    fn emit(&self, record: &StrokeRecord, number: u32, geometry: &mut Geometry) {
        let chance = self.numbers.child(number.into());
        let is_wood = record.material >= self.bark;
        let toward = self.eye.toward(record.stroke.center);
        let [along, across] = if is_wood {
            self.wood(record, toward)
        } else {
            self.leaf(record, toward, chance)
        };
        let dab = index_u32(crate::math::index_usize(chance.below(0, DABS.into())));
        let [first, sides] = cell(if is_wood { DABS + dab } else { dab });
        let mirrored = [chance.u64(1) & 1 == 1, chance.u64(1) & 2 == 2];
        let at = |right: bool, far: bool| {
            let share = |far: bool, mirrored: bool| if far == mirrored { 0.0 } else { 1.0 };
            first + sides * Vec2::new(share(far, mirrored[0]), share(right, mirrored[1]))
        };
        let center = record.stroke.center;
        let quad = [
            (center - along - across, at(false, false)),
            (center - along + across, at(true, false)),
            (center + along + across, at(true, true)),
            (center + along - across, at(false, true)),
        ];
        let from = index_u32(geometry.clip.len());
        for (point, coordinate) in quad {
            let world = self.placement.to_world(point);
            geometry.clip.push(self.clip * world.extend(1.0));
            geometry.varyings.extend(coordinate.to_array());
        }
        geometry.corners.extend(from..from + 4);
        let id = 4_u32.wrapping_mul(number);
        geometry
            .vertex_ids
            .extend((0..4).map(|corner| id.wrapping_add(corner)));
        let (colour, thickness) = self.paint(record, is_wood, toward, chance);
        geometry.flats.extend(colour.to_array());
        geometry.flats.push(thickness);
        geometry.flats.extend(first.to_array());
    }

    /// A branch lies where it lies, and is as wide from all sides.
    fn wood(&self, record: &StrokeRecord, toward: Vec3) -> [Vec3; 2] {
        let stroke = &record.stroke;
        let finest = match self.eye {
            Eye::At(eye) => FINEST * eye.distance(stroke.center),
            Eye::Towards(_) => 0.0,
        };
        let width = (self.scales[1] * stroke.across.length()).max(finest);
        let along = OVERLAP * stroke.along;
        let seen = toward
            .cross(along)
            .normalize_or(stroke.across.normalize_or_zero());
        [along, width * seen]
    }

    /// A leaf's axis as it is seen, no shorter than a painter would have it, a little turned; across it the
    /// leaf's width.
    fn leaf(&self, record: &StrokeRecord, toward: Vec3, chance: Stream) -> [Vec3; 2] {
        let stroke = &record.stroke;
        let size = self.scales[0] * (0.72 + 0.60 * chance.unit(2));
        let length = stroke.along.length();
        let mut seen = stroke.along - stroke.along.dot(toward) * toward;
        if seen.length() < LEAST_SEEN * length {
            let least = LEAST_SEEN * length;
            let across = stroke.across - stroke.across.dot(toward) * toward;
            seen = least * seen.normalize_or(across.normalize_or_zero());
        }
        let beside = toward.cross(seen);
        let (sine, cosine) = det::sin_cos(0.45 * chance.signed(3));
        let along = cosine * seen + sine * beside;
        let width = 0.85 * stroke.across.length().max(0.22 * length);
        let across = toward.cross(along).normalize_or_zero();
        [size * along, size * width * across]
    }

    /// The linear colour of a stroke, and how thickly it is put on.
    fn paint(
        &self,
        record: &StrokeRecord,
        is_wood: bool,
        toward: Vec3,
        chance: Stream,
    ) -> (Vec3, f32) {
        let material = record.material.min(self.bark) as usize;
        let own = Vec3::from_array(self.painting.f32s(8 + 3 * material));
        let stroke = &record.stroke;
        let outwards = (stroke.center - self.center).normalize_or(Vec3::Y);
        let normal = if is_wood {
            let about = stroke.along.normalize_or_zero();
            let facing = (toward - toward.dot(about) * about).normalize_or(toward);
            let side = about.cross(facing);
            // What is lit from one side shows half of that.
            (facing + self.to_light.dot(side).signum() * 0.6 * side).normalize_or_zero()
        } else {
            let own = stroke.normal();
            // Leaves show the side that the viewer sees; a crown's masses show where they bulge.
            let own = own * own.dot(toward).signum();
            (1.5 * outwards + 0.6 * own + 0.35 * Vec3::Y).normalize_or(Vec3::Y)
        };
        let lit = 0.5 + 0.5 * normal.dot(self.to_light);
        // Light that has to come through the crown.
        let open = if is_wood { 0.75 } else { record.outside };
        let lit = (lit * (0.30 + 0.70 * open) + 0.14 * chance.signed(4)).clamp(0.0, 1.0);
        let steps = Tones::of(self.look).mix(own, lit, is_wood, chance);
        let sky = self.ambient * (0.55 + 0.45 * open);
        let light = sky + self.light * (lit * lit * (3.0 - 2.0 * lit));
        let thickness = match self.look {
            PaintLook::Oil => 0.90 + 0.10 * chance.unit(5),
            // The lighter a place, the more water.
            PaintLook::Watercolour => {
                let water = if is_wood { 0.80 } else { 0.66 - 0.40 * lit };
                water + 0.10 * chance.signed(5)
            }
        };
        let colour = match self.look {
            PaintLook::Oil => steps * light,
            // Pigment is lit by the paper behind it.
            PaintLook::Watercolour => steps * (0.45 + 0.55 * light),
        };
        (colour, thickness)
    }
}

/// How a look turns a plant's colours into paint.
struct Tones {
    /// By how much brighter.
    gain: f32,
    /// Towards what light parts turn, and dark ones, and by how much.
    warm: [Vec3; 2],
    cool: [Vec3; 2],
    /// How far hues and values vary from stroke to stroke.
    spread: f32,
}

impl Tones {
    fn of(look: PaintLook) -> Self {
        match look {
            PaintLook::Oil => Self {
                gain: 1.25,
                warm: [Vec3::new(1.35, 1.06, 0.55), Vec3::new(0.055, 0.036, 0.004)],
                cool: [Vec3::new(0.50, 0.62, 0.95), Vec3::new(0.006, 0.008, 0.022)],
                spread: 0.34,
            },
            PaintLook::Watercolour => Self {
                gain: 1.25,
                warm: [Vec3::new(1.35, 1.08, 0.45), Vec3::new(0.10, 0.075, 0.0)],
                cool: [Vec3::new(0.42, 0.62, 0.95), Vec3::new(0.0, 0.008, 0.03)],
                spread: 0.32,
            },
        }
    }

    /// The paint for a colour in this light.
    fn mix(&self, own: Vec3, lit: f32, is_wood: bool, chance: Stream) -> Vec3 {
        let value = 1.0 + self.spread * chance.signed(6);
        let hue = self.spread * chance.signed(7);
        let mut paint = own * self.gain * value;
        paint *= Vec3::new(1.0 + hue, 1.0, 1.0 - hue);
        let [times, plus] = self.warm;
        let warm = paint * times + if is_wood { Vec3::ZERO } else { plus };
        let [times, plus] = self.cool;
        let cool = paint * times + plus;
        let mut mixed = cool + (warm - cool) * lit;
        // Here and there a touch of another colour, as a palette has it: ochre in the light, violet in
        // the shade.
        if !is_wood && chance.unit(8) < 0.07 {
            let touch = if lit > 0.5 {
                Vec3::new(0.62, 0.42, 0.10)
            } else {
                Vec3::new(0.12, 0.08, 0.20)
            };
            mixed += (touch - mixed) * 0.45;
        }
        mixed.max(Vec3::ZERO)
    }
}
