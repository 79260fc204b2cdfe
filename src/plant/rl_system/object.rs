//! What a rule may instantiate: leaves, flowers and fruit, as geometry and as strokes.

use crate::math::{Vec2, Vec3, det, index_u32};
use crate::plant::texture::linear_of_srgb;
use crate::plant::{LeafGroup, Material, Prototype, Silhouette, Stroke};

/// A kind of organ that a rule puts at the turtle's place.
///
/// Its own space has the base at the origin, +Y along the turtle's heading and +Z to the upper side; it
/// is 1 long.
#[derive(Debug, Clone, PartialEq)]
pub struct Object {
    /// Its name in the grammar.
    pub name: String,
    /// What it is.
    pub form: ObjectForm,
    /// The width as a share of the length; a petal's of a flower.
    pub width: f32,
    /// sRGB.
    pub color: [u8; 3],
}

/// What an organ is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ObjectForm {
    /// A quad with an image; one stroke.
    Leaf(Silhouette),
    /// So many petals around the heading, each a quad with an image and a stroke.
    Flower(Silhouette, u32),
    /// A body of eight faces; three strokes through its axis, one every 60 degrees.
    Fruit,
}

/// An organ in its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedObject {
    /// Which kind, as a place in [`RlSystem::objects`](super::RlSystem::objects).
    pub object: u32,
    /// The branch that bears it, or [`NO_BRANCH`](crate::plant::NO_BRANCH).
    pub branch: u32,
    /// Where it begins.
    pub base: Vec3,
    /// Its right, of unit length.
    pub side: Vec3,
    /// Its direction, of unit length and at a right angle to the side.
    pub heading: Vec3,
    /// Its length in metres.
    pub size: f32,
}

impl PlacedObject {
    /// A direction or offset of the organ's own space, in the plant's.
    fn turned(&self, vector: Vec3) -> Vec3 {
        let normal = self.side.cross(self.heading);
        self.size * (vector.x * self.side + vector.y * self.heading + vector.z * normal)
    }

    /// A stroke of the organ's own space, in the plant's.
    #[must_use]
    pub fn stroke(&self, own: Stroke) -> Stroke {
        Stroke {
            center: self.base + self.turned(own.center),
            along: self.turned(own.along),
            across: self.turned(own.across),
        }
    }
}

/// How far petals are raised from the plane across the heading, in degrees.
const PETAL_RISE: f32 = 25.0;

/// Texels whose alpha is below this are not there, as in all foliage that grows.
const ALPHA_CUTOFF: f32 = 0.5;

impl Object {
    /// The cloud of strokes of which it is painted, in its own space ([CQHCVL06](crate::references),
    /// section 2).
    #[must_use]
    pub fn strokes(&self) -> Vec<Stroke> {
        let upright = |across: Vec3| Stroke {
            center: 0.5 * Vec3::Y,
            along: 0.5 * Vec3::Y,
            across: 0.5 * self.width * across,
        };
        match self.form {
            ObjectForm::Leaf(_) => vec![upright(Vec3::X)],
            ObjectForm::Flower(_, petals) => {
                (0..petals).map(|petal| self.petal(petal, petals)).collect()
            }
            ObjectForm::Fruit => [0.0, 60.0, 120.0]
                .map(|angle: f32| {
                    let (sine, cosine) = det::sin_cos(angle.to_radians());
                    upright(Vec3::new(cosine, 0.0, sine))
                })
                .to_vec(),
        }
    }

    fn petal(&self, petal: u32, petals: u32) -> Stroke {
        let (sine, cosine) = det::sin_cos(std::f32::consts::TAU * petal as f32 / petals as f32);
        let (rise, out) = det::sin_cos(PETAL_RISE.to_radians());
        let along = 0.5 * Vec3::new(out * cosine, rise, out * sine);
        Stroke {
            center: along,
            along,
            across: 0.5 * self.width * Vec3::new(sine, 0.0, -cosine),
        }
    }

    /// The vertices of one, in its own space.
    fn vertices(&self) -> Vec<Vec3> {
        if let ObjectForm::Fruit = self.form {
            let half = 0.5 * self.width;
            let ring = [(half, 0.0), (0.0, half), (-half, 0.0), (0.0, -half)];
            let ring = ring.map(|(x, z)| Vec3::new(x, 0.5, z));
            return [&[Vec3::ZERO, Vec3::Y], &ring[..]].concat();
        }
        let strokes = self.strokes();
        strokes.iter().flat_map(Stroke::corners).collect()
    }

    fn prototype(&self) -> Prototype {
        match self.form {
            ObjectForm::Leaf(_) => Prototype::Quad {
                texture_corners: Prototype::WHOLE_IMAGE,
            },
            ObjectForm::Flower(_, petals) => Prototype::Faces {
                texture_coordinates: Prototype::WHOLE_IMAGE.repeat(petals as usize),
                triangles: (0..petals)
                    .flat_map(|petal| {
                        [[0, 1, 2], [0, 2, 3]].map(|face| face.map(|v| v + 4 * petal))
                    })
                    .collect(),
            },
            ObjectForm::Fruit => Prototype::Faces {
                texture_coordinates: [1.0, 0.0, 0.5, 0.5, 0.5, 0.5]
                    .map(|y| Vec2::new(0.5, y))
                    .to_vec(),
                triangles: (0..4)
                    .flat_map(|side| {
                        let (here, next) = (2 + side, 2 + (side + 1) % 4);
                        [[0, here, next], [1, next, here]]
                    })
                    .collect(),
            },
        }
    }

    /// All organs of this kind, the `number`th, as leaves of a foliage.
    pub(super) fn group(&self, number: usize, placed: &[PlacedObject]) -> LeafGroup {
        let texture = match self.form {
            ObjectForm::Leaf(image) | ObjectForm::Flower(image, _) => {
                Some(image.draw(self.color, self.width))
            }
            ObjectForm::Fruit => None,
        };
        let material = match texture {
            None => Material::plain(self.name.clone(), self.color.map(linear_of_srgb)),
            Some(texture) => Material {
                name: self.name.clone(),
                base_color: [1.0; 4],
                texture: Some(texture),
                alpha_cutoff: ALPHA_CUTOFF,
            },
        };
        let own = self.vertices();
        let (mut positions, mut owners) = (Vec::new(), Vec::new());
        for place in placed
            .iter()
            .filter(|place| place.object == index_u32(number))
        {
            positions.extend(own.iter().map(|vertex| place.base + place.turned(*vertex)));
            owners.push(place.branch);
        }
        LeafGroup {
            name: self.name.clone(),
            prototype: self.prototype(),
            material,
            positions,
            owners,
        }
    }
}
