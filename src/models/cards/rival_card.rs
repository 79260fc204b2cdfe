//! The cards of models that show a whole crown as a few pictures, and how they turn to the viewer.

use super::atlas::AtlasCell;
use super::bake::{Rectangle, ViewFrame};
use super::eye::Eye;
use crate::gpu::Words;
use crate::math::{Vec2, Vec3};

/// How cards stand to the viewer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Turn {
    /// Not at all: each card stays where it was baked.
    Fixed,
    /// One card, turned about its vertical axis: what is usual for trees, which stand upright
    /// ([AHH18](crate::references), § 13.6.2, axial billboards).
    Axial,
    /// One card, turned about its centre ([AHH18](crate::references), § 13.6.2, world-oriented
    /// billboards): what is usual for what has no up, and for views from above.
    Facing,
    /// Of several cards the one whose view was baked from nearest to where the viewer is, turned about
    /// its vertical axis.
    Nearest,
}

/// A card as programs read it: a baked view and where it lies in the atlas.
///
/// | words | field       | type      | unit, space |
/// |------:|-------------|-----------|-------------|
/// | 0–11  | `frame`     | 4 × 3 × `f32` | origin (m), right, up, toward the viewer of the bake; plant |
/// | 12–15 | `rectangle` | 2 × 2 × `f32` | lower left and upper right corner, m from the origin |
/// | 16–19 | `cell`      | 2 × 2 × `f32` | upper left corner and sides, texture |
/// | 20–21 | `depths`    | 2 × `f32` | offsets of depths 0 and 255, m towards the viewer of the bake |
///
/// Little-endian and unpadded, 88 bytes a card.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RivalCard {
    pub(super) frame: ViewFrame,
    pub(super) rectangle: Rectangle,
    pub(super) cell: AtlasCell,
}

impl RivalCard {
    pub(super) const WORDS: usize = 22;

    pub(super) fn to_bytes(self) -> Vec<u8> {
        let ViewFrame {
            origin,
            right,
            up,
            toward,
        } = self.frame;
        let (rectangle, cell) = (self.rectangle, self.cell);
        let frame = [origin, right, up, toward].map(|vector| vector.to_array());
        let places = [rectangle.least, rectangle.greatest, cell.least, cell.sides];
        let places = places.map(|place| place.to_array());
        let floats = frame.as_flattened().iter().chain(places.as_flattened());
        let floats = floats.chain(&cell.depths);
        floats.flat_map(|value| value.to_le_bytes()).collect()
    }

    pub(super) fn read(words: Words<'_>, number: usize) -> Self {
        let first = Self::WORDS * number;
        let vector = |word: usize| Vec3::from_array(words.f32s(first + word));
        let place = |word: usize| Vec2::from_array(words.f32s(first + word));
        Self {
            frame: ViewFrame {
                origin: vector(0),
                right: vector(3),
                up: vector(6),
                toward: vector(9),
            },
            rectangle: Rectangle {
                least: place(12),
                greatest: place(14),
            },
            cell: AtlasCell {
                least: place(16),
                sides: place(18),
                depths: words.f32s(first + 20),
            },
        }
    }

    /// All cards of a buffer.
    pub(super) fn read_all(words: Words<'_>) -> Vec<Self> {
        let count = words.len() / Self::WORDS;
        (0..count).map(|number| Self::read(words, number)).collect()
    }

    /// How far from the frame's origin a corner of the card lies at most, in metres.
    pub(super) fn radius(&self) -> f32 {
        let Rectangle { least, greatest } = self.rectangle;
        least.abs().max(greatest.abs()).length()
    }
}

/// The frame of a card as it stands to a viewer. Where the viewer is right above or below what turns
/// about its axis, or at what turns about its centre, it stands as it was baked.
pub(super) fn turned(frame: &ViewFrame, turn: Turn, eye: Eye) -> ViewFrame {
    let seen_from = eye.toward(frame.origin);
    let toward = match turn {
        Turn::Fixed => Vec3::ZERO,
        Turn::Axial | Turn::Nearest => Vec3::new(seen_from.x, 0.0, seen_from.z).normalize_or_zero(),
        Turn::Facing => seen_from,
    };
    if toward == Vec3::ZERO {
        return *frame;
    }
    ViewFrame::upright(frame.origin, toward)
}

/// Of several cards the one that was baked from nearest to where the viewer is, by the angle about the
/// vertical axis; of equals the first.
pub(super) fn nearest(cards: &[RivalCard], eye: Eye) -> usize {
    let mut best = (0, f32::NEG_INFINITY);
    for (number, card) in cards.iter().enumerate() {
        let seen_from = eye.toward(card.frame.origin);
        let cosine = seen_from.x * card.frame.toward.x + seen_from.z * card.frame.toward.z;
        if cosine > best.1 {
            best = (number, cosine);
        }
    }
    best.0
}

impl ViewFrame {
    /// The right-handed frame that looks at `origin` from a direction, a unit vector, with its `up` as
    /// near to +Y as can be; right above or below, `right` is +X.
    pub(super) fn upright(origin: Vec3, toward: Vec3) -> Self {
        let right = Vec3::Y.cross(toward).normalize_or_zero();
        let right = if right == Vec3::ZERO { Vec3::X } else { right };
        Self {
            origin,
            right,
            up: toward.cross(right),
            toward,
        }
    }

    /// A direction that this frame sees as `other` sees the given one.
    pub(super) fn direction_from(&self, other: &Self, direction: Vec3) -> Vec3 {
        self.right * other.right.dot(direction)
            + self.up * other.up.dot(direction)
            + self.toward * other.toward.dot(direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::cards::octahedral::directions_around;

    const FRONT: ViewFrame = ViewFrame {
        origin: Vec3::new(1.0, 2.0, 3.0),
        right: Vec3::X,
        up: Vec3::Y,
        toward: Vec3::Z,
    };

    fn card(toward: Vec3) -> RivalCard {
        RivalCard {
            frame: ViewFrame::upright(Vec3::new(1.0, 2.0, 3.0), toward),
            rectangle: Rectangle {
                least: Vec2::new(-1.0, -2.0),
                greatest: Vec2::new(3.0, 4.0),
            },
            cell: AtlasCell {
                least: Vec2::ZERO,
                sides: Vec2::ONE,
                depths: [-1.0, 1.0],
            },
        }
    }

    #[test]
    fn cards_turn_to_the_viewer() {
        let eye = Eye::At(Vec3::new(11.0, 12.0, 3.0));
        assert_eq!(turned(&FRONT, Turn::Fixed, eye), FRONT);
        let axial = turned(&FRONT, Turn::Axial, eye);
        assert!(axial.right.distance(Vec3::NEG_Z) < 1e-6 && axial.up.distance(Vec3::Y) < 1e-6);
        let facing = turned(&FRONT, Turn::Facing, eye);
        assert_eq!(facing.toward, eye.toward(FRONT.origin));
        assert!(facing.right.cross(facing.up).distance(facing.toward) < 1e-6);
        let above = Eye::Towards(Vec3::Y);
        assert_eq!(turned(&FRONT, Turn::Axial, above), FRONT);
        assert_eq!(turned(&FRONT, Turn::Facing, above).right, Vec3::X);
        // What is on the card's right stays there.
        let moved = axial.direction_from(&FRONT, Vec3::X);
        assert_eq!(moved, Vec3::NEG_Z);
    }

    #[test]
    fn the_nearest_of_eight_shows() {
        let cards: Vec<RivalCard> = directions_around(8).map(card).collect();
        assert_eq!(cards.len(), 8);
        for (number, card) in cards.iter().enumerate() {
            let aside = card.frame.toward + 0.4 * card.frame.right + Vec3::Y;
            assert_eq!(nearest(&cards, Eye::Towards(aside.normalize())), number);
        }
        assert_eq!(card(Vec3::Z).radius(), 5.0);
        assert_eq!(card(Vec3::Z).to_bytes().len(), 4 * RivalCard::WORDS);
    }
}
