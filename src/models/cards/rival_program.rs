//! The programs that draw a whole crown as a few cards, turned by where the viewer is.
//!
//! The view alone decides: nothing is sent but that. Corners count four a card, the lower left first,
//! counter-clockwise as the viewer of the bake saw them.

use super::eye::Eye;
use super::impostors_set::CARD_ALPHA_CUTOFF;
use super::octahedral::{Dome, OctahedralFragment};
use super::rival_card::{RivalCard, Turn, nearest, turned};
use crate::gpu::{
    Bindings, Blend, Fragment, Geometry, Hulls, Kernel, Layout, MipMap, Pixel, Program, Topology,
    Transform, VertexCall, Wrap,
};
use crate::math::{Vec2, Vec3, Vec4, index_u32};
use crate::models::environment::{INSTANCE_SLOT, Placement, VIEW_SLOT, View, clip_from_plant};
use crate::models::shadow::Lighting;

/// The slot of the [cards](RivalCard).
pub(super) const CARD_SLOT: u32 = 2;
/// The slot of the colours' texture.
pub(super) const COLOUR_SLOT: u32 = 0;
/// The slot of the normals' texture.
pub(super) const NORMAL_SLOT: u32 = 1;

/// What is done with baked views.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    /// Each card shows one view.
    Pictures(Turn),
    /// The same, at the depth of what a texel shows.
    Relief(Turn),
    /// One card shows a blend of the three nearest views.
    Blended(Dome),
}

/// Draws a crown as cards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RivalProgram(pub(super) Shape);

impl Program for RivalProgram {
    fn layout(&self) -> Layout {
        let name = match self.0 {
            Shape::Pictures(Turn::Fixed) => "card",
            Shape::Pictures(Turn::Axial) => "axial-billboard",
            Shape::Pictures(Turn::Facing) => "facing-billboard",
            Shape::Pictures(Turn::Nearest) => "sprite",
            Shape::Relief(Turn::Fixed) => "deep-card",
            Shape::Relief(Turn::Axial) => "deep-axial-billboard",
            Shape::Relief(Turn::Facing) => "deep-facing-billboard",
            Shape::Relief(Turn::Nearest) => "deep-sprite",
            Shape::Blended(Dome::Hemisphere) => "hemi-octahedral-impostor",
            Shape::Blended(Dome::Sphere) => "octahedral-impostor",
        };
        Layout {
            name,
            version: 1,
            topology: Topology::QuadList,
            blend: Blend::Opaque,
            vertex_stride: 0,
            pulled_primitive_bytes: 4 * index_u32(RivalCard::WORDS),
            pulled_vertex_bytes: 0,
            storage_slots: CARD_SLOT + 1,
            texture_slots: NORMAL_SLOT + 1,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let storage = |slot: u32| call.bindings.storage(slot as usize);
        let view = View::read(storage(VIEW_SLOT));
        let placement =
            Placement::from_words(storage(INSTANCE_SLOT).f32s(8 * call.instance as usize));
        let stage = Stage {
            eye: Eye::of(&view.clip_from_world).of_plant(&placement),
            // Normals are the plant's own, so light is turned to them.
            to_light: placement.rotation.inverse() * view.to_light,
            view,
            placement,
        };
        let words = storage(CARD_SLOT);
        for corners in call.corners.as_chunks::<4>().0 {
            let number = corners[0] as usize / 4;
            match self.0 {
                Shape::Pictures(Turn::Nearest) | Shape::Relief(Turn::Nearest) => {
                    let cards = RivalCard::read_all(words);
                    let number = nearest(&cards, stage.eye);
                    if let Some(card) = cards.get(number) {
                        stage.emit(self.0, card, number, geometry);
                    }
                }
                Shape::Pictures(_) | Shape::Relief(_) => {
                    stage.emit(self.0, &RivalCard::read(words, number), number, geometry);
                }
                Shape::Blended(_) => stage.emit_blended(&RivalCard::read(words, 0), geometry),
            }
        }
    }

    fn hulls(&self) -> Option<&dyn Hulls> {
        Some(self)
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        let cards = RivalCard::read_all(bindings.storage(CARD_SLOT as usize));
        let colour = bindings.texture(COLOUR_SLOT as usize);
        let normal = bindings.texture(NORMAL_SLOT as usize);
        let lighting = Lighting::of(bindings);
        match self.0 {
            Shape::Pictures(_) => Box::new(CardFragment::<false> {
                cards,
                colour,
                normal,
                lighting,
            }),
            Shape::Relief(_) => Box::new(CardFragment::<true> {
                cards,
                colour,
                normal,
                lighting,
            }),
            Shape::Blended(dome) => Box::new(OctahedralFragment {
                dome,
                cards,
                colour,
                normal,
                alpha_cutoff: CARD_ALPHA_CUTOFF,
                lighting,
            }),
        }
    }
}

/// Boxes around the spheres in which cards turn.
impl Hulls for RivalProgram {
    fn slots(&self) -> Vec<u32> {
        vec![CARD_SLOT]
    }

    fn bounds(&self, corners: &[u32], bindings: &Bindings<'_>) -> [Vec3; 2] {
        let words = bindings.storage(CARD_SLOT as usize);
        let around = |card: &RivalCard, room: f32| {
            let radius = Vec3::splat(room * card.radius());
            [card.frame.origin - radius, card.frame.origin + radius]
        };
        let join = |[a, b]: [Vec3; 2], [c, d]: [Vec3; 2]| [a.min(c), b.max(d)];
        let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        match self.0 {
            Shape::Blended(_) => {
                let room = MOST_WIDENING * ROUNDING;
                around(&RivalCard::read(words, 0), room)
            }
            Shape::Pictures(Turn::Nearest) | Shape::Relief(Turn::Nearest) => {
                let cards = RivalCard::read_all(words);
                let boxes = cards.iter().map(|card| around(card, ROUNDING));
                boxes.fold(none, join)
            }
            Shape::Pictures(_) | Shape::Relief(_) => {
                let corners = corners.as_chunks::<4>().0.iter();
                let cards = corners.map(|corners| RivalCard::read(words, corners[0] as usize / 4));
                let boxes = cards.map(|card| around(&card, ROUNDING));
                boxes.fold(none, join)
            }
        }
    }

    fn transform(&self, bindings: &Bindings<'_>, instance: u32) -> Transform {
        clip_from_plant(bindings, instance)
    }
}

/// Room for what `f32` rounds where cards are turned.
const ROUNDING: f32 = 1.001;

/// A card before a sphere, as the viewer sees it, is wider than the sphere, and up to so much wider it is
/// made: for a viewer who stands further than 2/√3 radii from its centre.
const MOST_WIDENING: f32 = 2.0;

/// What a draw's vertices share.
#[derive(Debug)]
struct Stage {
    /// In the plant's space.
    eye: Eye,
    to_light: Vec3,
    view: View,
    placement: Placement,
}

/// The corners of a card in texture coordinates.
const COORDINATES: [Vec2; 4] = [
    Vec2::new(0.0, 1.0),
    Vec2::new(1.0, 1.0),
    Vec2::new(1.0, 0.0),
    Vec2::new(0.0, 0.0),
];

impl Stage {
    /// A card that shows one view.
    fn emit(&self, shape: Shape, card: &RivalCard, number: usize, geometry: &mut Geometry) {
        let (turn, is_deep) = match shape {
            Shape::Pictures(turn) => (turn, false),
            Shape::Relief(turn) => (turn, true),
            Shape::Blended(_) => return,
        };
        let frame = turned(&card.frame, turn, self.eye);
        let to_light = match turn {
            // Light falls on what is seen of the one view as if the plant had been turned with it.
            Turn::Axial | Turn::Facing => card.frame.direction_from(&frame, self.to_light),
            // Views are of their own sides; of a card seen from behind the other sides of leaves show.
            Turn::Nearest => self.to_light,
            Turn::Fixed if self.eye.toward(frame.origin).dot(frame.toward) < 0.0 => -self.to_light,
            Turn::Fixed => self.to_light,
        };
        let clip = &self.view.clip_from_world;
        let ahead = self.placement.rotation * frame.toward * self.placement.scale;
        let ahead = *clip * ahead.extend(0.0);
        for coordinate in COORDINATES {
            let point = frame.point(card.rectangle.at(coordinate), 0.0);
            let at = self.push(point, geometry);
            geometry.varyings.extend(coordinate.to_array());
            if is_deep {
                geometry.varyings.extend([at.z, at.w]);
            }
        }
        Self::join(number, geometry);
        geometry.flats.extend(to_light.to_array());
        geometry.flats.push(f32::from_bits(index_u32(number)));
        if is_deep {
            geometry.flats.extend([ahead.z, ahead.w]);
        }
    }

    /// The card of blended views: faces the viewer and is as wide as the sphere around the crown seems.
    fn emit_blended(&self, card: &RivalCard, geometry: &mut Geometry) {
        let (centre, radius) = (card.frame.origin, card.rectangle.greatest.x);
        let toward = self.eye.toward(centre);
        let toward = if toward == Vec3::ZERO {
            Vec3::Y
        } else {
            toward
        };
        let (eye, scale, widening) = match self.eye {
            Eye::At(eye) => {
                let eye = eye - centre;
                let beyond = eye.length_squared() - radius * radius;
                let least = radius * radius / (MOST_WIDENING * MOST_WIDENING - 1.0);
                let widening = (1.0 + radius * radius / beyond.max(least)).sqrt();
                (eye, 1.0, widening.min(MOST_WIDENING))
            }
            Eye::Towards(toward) => (toward, 0.0, 1.0),
        };
        let frame = super::bake::ViewFrame::upright(centre, toward);
        for coordinate in COORDINATES {
            let seen = widening * card.rectangle.at(coordinate);
            let point = frame.point(seen, 0.0);
            self.push(point, geometry);
            let coordinate = card.rectangle.coordinate(seen);
            geometry.varyings.extend(coordinate.to_array());
            geometry.varyings.extend((point - centre).to_array());
        }
        Self::join(0, geometry);
        geometry.flats.extend(self.to_light.to_array());
        geometry.flats.extend(eye.to_array());
        geometry.flats.push(scale);
    }

    fn push(&self, point: Vec3, geometry: &mut Geometry) -> Vec4 {
        let world = self.placement.to_world(point);
        let at = self.view.clip_from_world * world.extend(1.0);
        geometry.clip.push(at);
        at
    }

    /// Makes a quad of the last four vertices.
    fn join(number: usize, geometry: &mut Geometry) {
        let first = index_u32(geometry.clip.len()) - 4;
        geometry.corners.extend(first..first + 4);
        let number = 4 * index_u32(number);
        geometry.vertex_ids.extend(number..number + 4);
    }
}

/// Textured, alpha-tested, lit by the normal of each texel; where `DEEP`, at the depth of each texel.
#[derive(Debug)]
struct CardFragment<'a, const DEEP: bool> {
    cards: Vec<RivalCard>,
    colour: Option<&'a MipMap>,
    normal: Option<&'a MipMap>,
    lighting: Lighting<'a>,
}

impl<const DEEP: bool> CardFragment<'_, DEEP> {
    #[inline(always)]
    fn card(&self, pixel: &Pixel<'_>) -> &RivalCard {
        // Constant over the quad, so the bits arrive as the vertex stage wrote them.
        &self.cards[pixel.flats[3].to_bits() as usize]
    }

    /// Where to read, and at which level.
    #[inline(always)]
    fn place(&self, texture: &MipMap, pixel: &Pixel<'_>) -> (Vec2, u32) {
        let cell = &self.card(pixel).cell;
        let (x, y) = (pixel.derivative_x, pixel.derivative_y);
        let level = texture.level_for(x * cell.sides, y * cell.sides);
        let (width, height) = texture.level_size(level);
        let texel = Vec2::new(1.0 / width as f32, 1.0 / height as f32);
        let coordinate = Vec2::new(pixel.varyings[0], pixel.varyings[1]);
        (cell.clamped(coordinate, texel), level)
    }
}

impl<const DEEP: bool> Fragment for CardFragment<'_, DEEP> {
    const VARYINGS: usize = if DEEP { 4 } else { 2 };
    const FLATS: usize = if DEEP { 6 } else { 4 };
    const TESTS_ALPHA: bool = true;
    const IN_LANES: bool = false;
    const MOVES_DEPTH: bool = DEEP;

    #[inline(always)]
    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        self.colour.is_some_and(|texture| {
            let (at, level) = self.place(texture, pixel);
            texture.alpha(at, level, Wrap::Clamp) >= CARD_ALPHA_CUTOFF
        })
    }

    /// The depth of the point so far in front of the card as the texel says, less that of the card.
    fn depth_offset(&self, pixel: &Pixel<'_>) -> f32 {
        let Some(texture) = self.normal.filter(|_| DEEP) else {
            return 0.0;
        };
        let (at, level) = self.place(texture, pixel);
        let nearness = texture.sample(at, level, Wrap::Clamp).w;
        let [farthest, nearest] = self.card(pixel).cell.depths;
        let offset = farthest + (nearest - farthest) * nearness;
        let (z, w) = (pixel.varyings[2], pixel.varyings[3]);
        let (moved_z, moved_w) = (z + offset * pixel.flats[4], w + offset * pixel.flats[5]);
        // What would lie behind the viewer stays where the card is.
        if moved_w > 0.0 && w > 0.0 {
            moved_z / moved_w - z / w
        } else {
            0.0
        }
    }

    fn texels_tested(&self) -> u64 {
        if DEEP { 8 } else { 4 }
    }

    fn texels_shaded(&self) -> u64 {
        8 + self.lighting.texels()
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let Some((colour, normals)) = self.colour.zip(self.normal) else {
            return Vec4::ZERO;
        };
        let (at, level) = self.place(colour, pixel);
        let albedo = colour.sample(at, level, Wrap::Clamp).truncate();
        let normal = 2.0 * normals.sample(at, level, Wrap::Clamp).truncate() - Vec3::ONE;
        let to_light = Vec3::new(pixel.flats[0], pixel.flats[1], pixel.flats[2]);
        let toward = normal.dot(to_light).max(0.0);
        (albedo * self.lighting.at(toward, pixel)).extend(1.0)
    }
}
