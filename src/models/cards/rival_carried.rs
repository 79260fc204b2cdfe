//! Where a point of a card goes as the viewer moves: what its picture is held against.

use super::bake::ViewFrame;
use super::eye::Eye;
use super::octahedral::Dome;
use super::rival_card::{RivalCard, Turn, nearest, turned};
use super::rival_program::Shape;
use crate::math::DVec3;
use crate::models::Viewpoint;

/// Where the texel that shows at `point` from one viewpoint shows from another, in the plant's space;
/// `None` where it does not: its card is not drawn, or its view not among those that are blended.
///
/// A texel stays at its place on its card, whatever depth it is given, and the card turns. Of blended
/// views that of the greatest weight is followed, on the plane on which it is read.
pub(super) fn carried(
    cards: &[RivalCard],
    shape: Shape,
    vertex: u32,
    point: DVec3,
    [from, to]: [&Viewpoint; 2],
) -> Option<DVec3> {
    let [from, to] = [from, to].map(|viewpoint| Eye::of(&viewpoint.clip_from_plant));
    match shape {
        Shape::Pictures(turn) | Shape::Relief(turn) => {
            let number = vertex as usize / 4;
            let card = cards.get(number)?;
            if turn == Turn::Nearest && nearest(cards, to) != number {
                return None;
            }
            let before = Axes::of(&turned(&card.frame, turn, from));
            let after = Axes::of(&turned(&card.frame, turn, to));
            let [right, up] = before.seen(before.on_plane(from, point)?);
            Some(after.point([right, up]))
        }
        Shape::Blended(dome) => {
            let centre = cards.first()?.frame.origin;
            let around = |eye: Eye| around(dome, eye, centre.as_dvec3());
            let heaviest = around(from)
                .into_iter()
                .reduce(|a, b| if b.1 > a.1 { b } else { a })?;
            let remains = around(to)
                .iter()
                .any(|(view, weight)| *view == heaviest.0 && *weight > 0.0);
            let axes = Axes::of(&cards.get(heaviest.0)?.frame);
            axes.on_plane(from, point).filter(|_| remains)
        }
    }
}

/// The views around the direction from a centre to the viewer.
fn around(dome: Dome, eye: Eye, centre: DVec3) -> [(usize, f32); 3] {
    dome.around(match eye {
        Eye::At(eye) => (eye.as_dvec3() - centre).as_vec3(),
        Eye::Towards(toward) => toward,
    })
}

/// Where the ray from the viewer through a point meets the plane through another with a normal; nowhere
/// where it runs within.
pub(super) fn on_plane(eye: Eye, point: DVec3, [origin, normal]: [DVec3; 2]) -> Option<DVec3> {
    let along = match eye {
        Eye::At(eye) => eye.as_dvec3() - point,
        Eye::Towards(toward) => toward.as_dvec3(),
    };
    let slope = along.dot(normal);
    let met = point - along * ((point - origin).dot(normal) / slope);
    (slope != 0.0).then_some(met)
}

/// A frame in `f64`.
#[derive(Debug, Clone, Copy)]
struct Axes {
    origin: DVec3,
    right: DVec3,
    up: DVec3,
    toward: DVec3,
}

impl Axes {
    fn of(frame: &ViewFrame) -> Self {
        Self {
            origin: frame.origin.as_dvec3(),
            right: frame.right.as_dvec3(),
            up: frame.up.as_dvec3(),
            toward: frame.toward.as_dvec3(),
        }
    }

    /// Where the ray from the viewer through a point meets the plane through the origin.
    fn on_plane(&self, eye: Eye, point: DVec3) -> Option<DVec3> {
        on_plane(eye, point, [self.origin, self.toward])
    }

    fn seen(&self, point: DVec3) -> [f64; 2] {
        let point = point - self.origin;
        [point.dot(self.right), point.dot(self.up)]
    }

    fn point(&self, [right, up]: [f64; 2]) -> DVec3 {
        self.origin + self.right * right + self.up * up
    }
}

#[cfg(test)]
mod tests {
    use super::super::atlas::AtlasCell;
    use super::super::bake::Rectangle;
    use super::super::octahedral::directions_around;
    use super::*;
    use crate::math::{Vec2, Vec3, det};

    const CENTRE: Vec3 = Vec3::new(1.0, 2.0, 3.0);

    fn card(toward: Vec3) -> RivalCard {
        RivalCard {
            frame: ViewFrame::upright(CENTRE, toward),
            rectangle: Rectangle {
                least: Vec2::splat(-1.0),
                greatest: Vec2::splat(1.0),
            },
            cell: AtlasCell {
                least: Vec2::ZERO,
                sides: Vec2::ONE,
                depths: [-1.0, 1.0],
            },
        }
    }

    /// From 10 m away, level, so many degrees from +Z to +X.
    fn level(degrees: f32) -> Viewpoint {
        let (sine, cosine) = det::sin_cos(degrees.to_radians());
        let eye = CENTRE + 10.0 * Vec3::new(sine, 0.0, cosine);
        Viewpoint {
            eye,
            clip_from_plant: glam::camera::rh::proj::directx::perspective(0.5, 1.0, 0.1, 100.0)
                * glam::camera::rh::view::look_at_mat4(eye, CENTRE, Vec3::Y),
        }
    }

    /// Where a point half a metre to the right and up goes.
    fn goes(cards: &[RivalCard], shape: Shape, vertex: u32, to: f32) -> Option<Vec3> {
        let point = DVec3::new(1.5, 2.5, 3.0);
        let views = [&level(0.0), &level(to)];
        let moved = carried(cards, shape, vertex, point, views)?;
        Some(moved.as_vec3() - CENTRE)
    }

    #[test]
    fn billboards_turn_and_crossed_cards_stay() {
        let front = [card(Vec3::Z), card(Vec3::X)];
        for shape in [Shape::Pictures(Turn::Axial), Shape::Relief(Turn::Axial)] {
            let moved = goes(&front, shape, 0, 90.0).expect("it is still there");
            assert!(moved.distance(Vec3::new(0.0, 0.5, -0.5)) < 1e-5, "{moved}");
        }
        let stays = goes(&front, Shape::Pictures(Turn::Fixed), 0, 90.0);
        assert!(
            stays
                .expect("it is there")
                .distance(Vec3::new(0.5, 0.5, 0.0))
                < 1e-5
        );
    }

    #[test]
    fn sprites_go_where_another_comes_nearest() {
        let cards: Vec<RivalCard> = directions_around(8).map(card).collect();
        let sprites = Shape::Pictures(Turn::Nearest);
        assert!(goes(&cards, sprites, 0, 20.0).is_some());
        assert!(goes(&cards, sprites, 0, 25.0).is_none());
    }

    #[test]
    fn blended_views_are_followed_on_their_planes() {
        let cards: Vec<RivalCard> = Dome::Hemisphere.directions().map(card).collect();
        let blended = Shape::Blended(Dome::Hemisphere);
        // From +Z its own view shows alone, and what lies on its plane stays.
        let stays = goes(&cards, blended, 0, 5.0).expect("three views are near");
        assert!(stays.distance(Vec3::new(0.5, 0.5, 0.0)) < 1e-4, "{stays}");
        assert!(goes(&cards, blended, 0, 90.0).is_none());
    }
}
