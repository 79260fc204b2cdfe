//! What impostors' textures take, and how they look: direct ones of several sizes, and indirect ones of
//! several maps, sprites and turns.
//!
//! ```text
//! leaves in planes ─────────────────────────────────▶ the reference
//!       └─ impostors in the same planes ─┬─ direct ──▶ error of textures, bytes
//!                                        └─ indirect ▶ the same
//! ```
//!
//! Impostors of leaves that lie in the impostors' planes differ from those by their textures alone. Where
//! such leaves overlap, nothing says which of them is nearer; so they are left a thousandth of the way before
//! or behind their planes on which they came, from the side that they came from.

use std::sync::Arc;

use super::RunError;
use super::progress::Progress;
use super::stand_ins::{Screen, StandInOptions, sphere_of};
use super::views::{Shot, corner_directions};
use super::world::{World, finest_planes, with_foliage};
use crate::gpu::GpuError;
use crate::models::{Crown, Kind, LeafMapFacts, Model, ModelOptions};
use crate::scene::{CardCounts, CardOptions, CardSides, SpriteScale};
use crate::simplify::flattened;

/// What an impostor's picture is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextureSetting {
    /// A texture of its own for each side.
    Direct {
        /// Its sides, in texels.
        side: u32,
    },
    /// The same of the front alone, which shows from behind too.
    FrontAlone {
        /// Its sides, in texels.
        side: u32,
    },
    /// A leaf distribution map, and sprites that all share ([GSS05](crate::references), § 2.3).
    Indirect {
        /// The map's sides, in texels.
        map: u32,
        /// Those of a sprite.
        sprite: u32,
        /// By how many angles sprites are turned.
        turns: u32,
        /// How large leaves are.
        scale: SpriteScale,
    },
}

impl TextureSetting {
    /// What is looked at: direct textures of the paper's 512 texels and of each half down to 32, of both
    /// sides; one of them of the front alone; and indirect ones of which map, sprites, turns and scale
    /// vary one at a time.
    #[must_use]
    pub fn usual() -> Vec<Self> {
        let mut all: Vec<Self> = [32, 64, 128, 256, 512]
            .map(|side| Self::Direct { side })
            .into();
        all.push(Self::FrontAlone { side: 256 });
        let indirect = |map, sprite, turns, scale| Self::Indirect {
            map,
            sprite,
            turns,
            scale,
        };
        let leaf = SpriteScale::Leaf;
        all.extend([
            indirect(16, 32, 32, leaf),
            indirect(8, 32, 32, leaf),
            indirect(32, 32, 32, leaf),
            indirect(64, 32, 32, leaf),
            indirect(16, 16, 32, leaf),
            indirect(16, 64, 32, leaf),
            indirect(16, 32, 8, leaf),
            indirect(16, 32, 128, leaf),
            indirect(16, 32, 32, SpriteScale::Global),
        ]);
        all
    }

    /// Such as `direct 256`, `direct 256, front alone` and `indirect 16, 32 sprites of 64`.
    #[must_use]
    pub fn label(self) -> String {
        match self {
            Self::Direct { side } => format!("direct {side}"),
            Self::FrontAlone { side } => format!("direct {side}, front alone"),
            Self::Indirect {
                map,
                sprite,
                turns,
                scale,
            } => {
                let scale = match scale {
                    SpriteScale::Global => ", one scale",
                    SpriteScale::Leaf => "",
                };
                format!("indirect {map}, {turns} sprites of {sprite}{scale}")
            }
        }
    }

    fn kind(self) -> Kind {
        match self {
            Self::Direct { .. } | Self::FrontAlone { .. } => Kind::Impostors,
            Self::Indirect { .. } => Kind::IndirectImpostors,
        }
    }

    fn cards(self, cards: CardOptions) -> CardOptions {
        match self {
            Self::Direct { side } => CardOptions {
                texture: side,
                sides: CardSides::Both,
                ..cards
            },
            Self::FrontAlone { side } => CardOptions {
                texture: side,
                sides: CardSides::Front,
                ..cards
            },
            Self::Indirect {
                map,
                sprite,
                turns,
                scale,
            } => CardOptions {
                map,
                layers: MOST_LEAVES,
                sprite_texture: sprite,
                sprites: turns,
                scale,
                ..cards
            },
        }
    }
}

/// Leaves that a texel of a map may name: as many as a scene can ask for.
const MOST_LEAVES: u32 = 256;

/// How something looks at one scale, from the [corners](corner_directions).
#[derive(Debug, Clone, PartialEq)]
pub struct TextureLook {
    /// What; `None` for the leaves themselves, in their planes, which come before all others of a scale.
    pub setting: Option<TextureSetting>,
    /// Which of the scales asked for.
    pub scale: usize,
    /// The pictures.
    pub shots: Vec<Shot>,
}

/// What textures take.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureCost {
    /// Which.
    pub setting: TextureSetting,
    /// Bytes sent for the model and one instance.
    pub upload_bytes: u64,
    /// Bytes that these hold on the device.
    pub resident_bytes: u64,
    /// What maps hold, where there are maps.
    pub maps: Option<LeafMapFacts>,
}

/// What is found of textures.
#[derive(Debug, Clone, PartialEq)]
pub enum TextureFound {
    /// What a setting takes; before its looks.
    Cost(TextureCost),
    /// How it looks.
    Look(TextureLook),
    /// What does not fit, and why.
    Refused(TextureSetting, String),
}

/// What is left of the way into the plane.
const LEFT: f32 = 1e-3;

/// The crown with every leaf all but in the plane of its cluster.
fn all_but_flattened(crown: &Crown, cards: &CardOptions) -> Crown {
    let plant = crown.plant();
    let level = finest_planes(plant, cards);
    let mut foliage = flattened(plant.foliage(), &level);
    let groups = foliage.groups.iter_mut().zip(&plant.foliage().groups);
    for (to, from) in groups {
        for (to, from) in to.positions.iter_mut().zip(&from.positions) {
            *to += LEFT * (*from - *to);
        }
    }
    with_foliage(plant, foliage).in_planes(level)
}

/// Looks at impostors with each of some textures, as many impostors as the scene's finest level has. Of
/// the scales asked for, the first two: further away, all show the same. Everything is of the world's
/// first plant; without one, nothing is found.
///
/// # Errors
///
/// What the device refuses, and what `take` answers.
pub fn texture_looks<E: From<RunError>>(
    world: &World,
    settings: &[TextureSetting],
    options: &StandInOptions,
    progress: &dyn Progress,
    mut take: impl FnMut(TextureFound) -> Result<(), E>,
) -> Result<(), E> {
    let Some(original) = world.crowns.first() else {
        return Ok(());
    };
    let mut cards = options.session.model.cards;
    let finest = cards.levels.as_slice().first();
    if let Some(levels) = finest.and_then(|&count| CardCounts::new(&[count])) {
        cards.levels = levels;
    }
    let sphere = sphere_of(original);
    let crown = Arc::new(all_but_flattened(original, &cards));
    progress.begin("textures", 1 + settings.len() as u64);
    let screen = Screen::new(options);
    let mut look = |setting: Option<TextureSetting>, model: &dyn Model| -> Result<(), E> {
        for (scale, view) in options.scales.iter().enumerate().take(2) {
            let mut camera = match (screen.camera(model, sphere, view.before), setting) {
                (Ok(camera), _) => camera,
                (Err(RunError::Gpu(GpuError::Unsupported { what })), Some(setting)) => {
                    return take(TextureFound::Refused(setting, what));
                }
                (Err(error), _) => return Err(error.into()),
            };
            if let (0, Some(setting)) = (scale, setting) {
                take(TextureFound::Cost(TextureCost {
                    setting,
                    upload_bytes: camera.studio.initial.upload.payload_bytes,
                    resident_bytes: camera.studio.resident_bytes,
                    maps: model.leaf_maps(),
                }))?;
            }
            let shots = corner_directions().into_iter();
            let shots = shots.map(|direction| Ok(camera.shot(direction)?.0));
            take(TextureFound::Look(TextureLook {
                setting,
                scale,
                shots: shots.collect::<Result<_, RunError>>()?,
            }))?;
        }
        Ok(())
    };
    let leaves = Kind::Full.model(&crown, options.session.model);
    look(None, leaves.as_ref())?;
    progress.step();
    for &setting in settings {
        let model = setting.kind().model(
            &crown,
            ModelOptions {
                cards: setting.cards(cards),
                ..options.session.model
            },
        );
        look(Some(setting), model.as_ref())?;
        progress.step();
    }
    Ok(())
}
