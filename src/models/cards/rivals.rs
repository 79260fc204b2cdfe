//! What is used in place of leaf cluster impostors: a whole crown as a few pictures.
//!
//! | | views | how many cards show | nearer and farther |
//! |---|---|---|---|
//! | billboard, axial or facing | 1, from +Z | 1, turned to the viewer | all the same |
//! | sprites | 8 around | 1, the nearest, turned to the viewer | pops between views |
//! | depth billboard ([MO95](crate::references), [S05](crate::references)) | 1, from +Z | 1, turned | hides and is hidden texel by texel |
//! | crossed cards | 2, from +Z and +X | both, never turned | parallax of two planes |
//! | octahedral ([B18](crate::references)) | 8 × 8 on a hemisphere or sphere | 1, facing the viewer | blends three views |
//!
//! The first four are those that [GSS05](crate::references), § 1, names.
//!
//! **Invariant.** Everything is resident: nothing is sent when the viewer moves but the view.

use std::sync::Arc;

use super::atlas::Atlas;
use super::bake::{BakeOptions, BakeSites, BakeView, Rectangle, ViewFrame, bake};
use super::impostors::upload_atlas;
use super::impostors_set::CARD_ALPHA_CUTOFF;
use super::octahedral::{Dome, directions_around};
use super::rival_card::{RivalCard, Turn};
use super::rival_carried::carried;
use super::rival_program::{CARD_SLOT, COLOUR_SLOT, NORMAL_SLOT, RivalProgram, Shape};
use super::triangles::LeafTriangles;
use crate::gpu::{Cause, Corners, Device, Draw, GpuError, Key, Ledger, Queue, Step, Usage};
use crate::math::{Aabb, DVec3, Sphere, Vec2, Vec3, index_u32};
use crate::models::surface::filled;
use crate::models::{
    CARD_GROUP, CardLevel, Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared,
    State, Storage, Viewpoint,
};
use crate::plant::Foliage;

/// A crown as a few pictures.
///
/// Host memory: none once all is sent. Device memory: a [record](RivalCard) a view, and two textures
/// with all their levels, colours and normals.
#[derive(Debug, Clone)]
pub(in crate::models) struct Rival {
    crown: Arc<Crown>,
    kind: Kind,
    shape: Shape,
    /// What was baked, or why it could not be.
    pictures: Result<Arc<Pictures>, String>,
}

/// The views of a crown.
#[derive(Debug)]
pub(super) struct Pictures {
    pub(super) cards: Vec<RivalCard>,
    /// `None` where there are no leaves.
    pub(super) atlas: Option<Atlas>,
    /// What baking cost.
    pub(super) ledger: Ledger,
}

/// Which rival.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::models) enum RivalForm {
    /// One view, turned about the vertical axis.
    AxialBillboard,
    /// One view, turned to the viewer.
    FacingBillboard,
    /// One view with depth, turned about the vertical axis.
    DepthBillboard,
    /// Eight views around, of which the nearest shows.
    Sprites,
    /// Two upright cards at a right angle.
    CrossedCards,
    /// Views from above, of which three are blended.
    HemiOctahedral,
    /// Views from everywhere, of which three are blended.
    Octahedral,
}

/// Views around a crown, of which the nearest shows: [GSS05](crate::references) leaves their number
/// open.
const SPRITES: u32 = 8;

impl RivalForm {
    fn shape(self) -> Shape {
        match self {
            Self::AxialBillboard => Shape::Pictures(Turn::Axial),
            Self::FacingBillboard => Shape::Pictures(Turn::Facing),
            Self::DepthBillboard => Shape::Relief(Turn::Axial),
            Self::Sprites => Shape::Pictures(Turn::Nearest),
            Self::CrossedCards => Shape::Pictures(Turn::Fixed),
            Self::HemiOctahedral => Shape::Blended(Dome::Hemisphere),
            Self::Octahedral => Shape::Blended(Dome::Sphere),
        }
    }

    /// From where views are taken.
    fn directions(self) -> Vec<Vec3> {
        match self {
            Self::AxialBillboard | Self::FacingBillboard | Self::DepthBillboard => vec![Vec3::Z],
            Self::Sprites => directions_around(SPRITES).collect(),
            Self::CrossedCards => vec![Vec3::Z, Vec3::X],
            Self::HemiOctahedral => Dome::Hemisphere.directions().collect(),
            Self::Octahedral => Dome::Sphere.directions().collect(),
        }
    }
}

/// Pixels along each side of a texel of the bake.
const SUPERSAMPLING: u32 = 2;

impl Pictures {
    /// Bakes the views of a form, each of `side` × `side` texels.
    fn of(foliage: &Foliage, form: RivalForm, side: u32) -> Result<Self, String> {
        let leaves = LeafTriangles::of(foliage);
        let corners: Vec<Vec3> = leaves.corners(0..leaves.site_count()).collect();
        let directions = if corners.is_empty() {
            Vec::new()
        } else {
            form.directions()
        };
        let centre = Aabb::of(corners.iter().copied()).center();
        let radius = Vec2::splat(Sphere::of(&corners).radius);
        let view = |direction: Vec3| {
            let frame = ViewFrame::upright(centre, direction);
            let rectangle = match form.shape() {
                // Blended views are of one size.
                Shape::Blended(_) => Rectangle {
                    least: -radius,
                    greatest: radius,
                },
                Shape::Pictures(_) | Shape::Relief(_) => {
                    Rectangle::around(&frame, corners.iter().copied())
                }
            };
            BakeView {
                sites: BakeSites::All,
                frame,
                rectangle,
                size: [side, side],
            }
        };
        let views: Vec<BakeView> = directions.into_iter().map(view).collect();
        let options = BakeOptions {
            supersampling: SUPERSAMPLING,
        };
        let baked = bake(&leaves, &views, options).map_err(|error| error.to_string())?;
        let atlas = Atlas::of(&baked.views, CARD_ALPHA_CUTOFF);
        if atlas.is_none() && !views.is_empty() {
            let count = views.len();
            return Err(format!(
                "an atlas of {count} views of {side} × {side} texels"
            ));
        }
        let cells = atlas.iter().flat_map(|atlas| &atlas.cells);
        let cards = views.iter().zip(cells).map(|(view, cell)| RivalCard {
            frame: view.frame,
            rectangle: view.rectangle,
            cell: *cell,
        });
        Ok(Self {
            cards: cards.collect(),
            atlas,
            ledger: baked.ledger,
        })
    }

    fn record_bytes(&self) -> u64 {
        4 * (RivalCard::WORDS * self.cards.len()) as u64
    }
}

impl Rival {
    /// Bakes the pictures of a crown.
    pub(in crate::models) fn new(
        crown: Arc<Crown>,
        kind: Kind,
        form: RivalForm,
        options: ModelOptions,
    ) -> Self {
        let pictures = Pictures::of(crown.plant().foliage(), form, options.cards.texture);
        Self {
            crown,
            kind,
            shape: form.shape(),
            pictures: pictures.map(Arc::new),
        }
    }

    /// How many cards are drawn.
    fn shown(&self, pictures: &Pictures) -> u32 {
        let cards = index_u32(pictures.cards.len());
        match self.shape {
            Shape::Pictures(Turn::Nearest) | Shape::Relief(Turn::Nearest) | Shape::Blended(_) => {
                cards.min(1)
            }
            Shape::Pictures(_) | Shape::Relief(_) => cards,
        }
    }
}

impl Model for Rival {
    fn kind(&self) -> Kind {
        self.kind
    }

    fn crown(&self) -> &Arc<Crown> {
        &self.crown
    }

    fn drawn(&self, _state: &State) -> Vec<u32> {
        Vec::new()
    }

    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared>, GpuError> {
        let pictures = self
            .pictures
            .as_ref()
            .map_err(|what| GpuError::Unsupported { what: what.clone() })?;
        let mut steps = Vec::new();
        if let Some(atlas) = &pictures.atlas {
            let cards = pictures.cards.iter();
            let bytes: Vec<u8> = cards.flat_map(|card| card.to_bytes()).collect();
            let cause = Cause::of("cards");
            let buffer = filled(device, "cards", Usage::STORAGE, &bytes, cause)?;
            let [colour, normal] = upload_atlas(device, atlas)?;
            let program = device.create_program(Arc::new(RivalProgram(self.shape)));
            steps.extend(environment.bind(program));
            let slot = CARD_SLOT;
            steps.push(Step::Storage { slot, buffer });
            for (slot, texture) in [(COLOUR_SLOT, colour), (NORMAL_SLOT, normal)] {
                steps.push(Step::Texture { slot, texture });
            }
        }
        Ok(Box::new(RivalShared {
            steps,
            cards: self.shown(pictures),
        }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        Vec::new()
    }

    fn storage(&self) -> Storage {
        let of_pictures = |pictures: &Arc<Pictures>| {
            pictures.record_bytes() + pictures.atlas.as_ref().map_or(0, Atlas::bytes)
        };
        Storage {
            host_bytes: 0,
            shared_bytes: self.pictures.as_ref().map_or(0, of_pictures),
            instance_bytes: 0,
            instance_host_bytes: 0,
        }
    }

    fn baked(&self) -> Option<&Ledger> {
        self.pictures.as_ref().ok().map(|pictures| &pictures.ledger)
    }

    fn carried(
        &self,
        _state: &State,
        key: Key,
        point: DVec3,
        views: [&Viewpoint; 2],
    ) -> Option<DVec3> {
        let pictures = self.pictures.as_ref().ok()?;
        carried(&pictures.cards, self.shape, key.vertex, point, views)
    }
}

/// What all instances share.
#[derive(Debug)]
struct RivalShared {
    /// Binds it; empty where there are no cards.
    steps: Vec<Step>,
    cards: u32,
}

impl Shared for RivalShared {
    fn instance(
        &self,
        _device: &mut Device,
        _state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let mut steps = self.steps.clone();
        if self.cards > 0 {
            steps.push(Step::Draw(Draw {
                source: Corners::Counted,
                first_corner: 0,
                corner_count: 4 * self.cards,
                instance: number,
                group: CARD_GROUP,
            }));
        }
        Ok(Box::new(RivalResident {
            steps,
            cards: self.cards,
        }))
    }
}

#[derive(Debug)]
struct RivalResident {
    steps: Vec<Step>,
    cards: u32,
}

impl Resident for RivalResident {
    fn state(&self) -> &State {
        &State::Cards(CardLevel::FINEST)
    }

    fn commit(&mut self, _queue: &mut Queue<'_>, _to: &State) -> Result<Change, GpuError> {
        Ok(Change::default())
    }

    fn price(&self, _to: &State) -> u64 {
        0
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.steps);
    }

    fn card_triangles(&self) -> u64 {
        2 * u64::from(self.cards)
    }

    fn host_bytes(&self) -> u64 {
        0
    }
}
