//! What a session takes beside its scene, mostly as the scene says it.

use super::RunError;
use crate::gpu::{Card, Link};
use crate::models::{
    Extraction, Gather, Kind, LeafFormat, ModelOptions, Occlusion, Records, TrunkKind, Vertices,
};
use crate::raster::{Counters, Instructions, Options, TileSize};
use crate::scene::{self, ImageSize, ModelName, SampleCount, Scene};

/// What a session takes beside its scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SessionOptions {
    /// The model and mode.
    pub kind: Kind,
    /// Its choices.
    pub model: ModelOptions,
    /// The model and mode of trunks.
    pub trunk: TrunkKind,
    /// Pixels of a frame.
    pub size: ImageSize,
    /// Samples a pixel.
    pub samples: SampleCount,
    /// The link, for modelled times.
    pub link: Link,
    /// The card, for modelled times.
    pub card: Card,
    /// Tile size and counters of the rasterizer; they change no picture.
    pub raster: Options,
    /// Which instructions of this machine may be used; they change neither picture nor counter.
    pub instructions: Instructions,
}

impl SessionOptions {
    /// What the scene asks for, everything rasterized and counted: what references are made from.
    ///
    /// # Errors
    ///
    /// As [`of`](Self::of).
    pub fn exact(scene: &Scene) -> Result<Self, RunError> {
        let raster = Options {
            tile: TileSize::Side64,
            counters: Counters::Exact,
        };
        Self::of(scene, raster)
    }

    /// What the scene asks for.
    ///
    /// # Errors
    ///
    /// [`RunError::Name`] when the scene names a link, card or mode that does not exist.
    pub fn of(scene: &Scene, raster: Options) -> Result<Self, RunError> {
        let unknown = |key, what, found: &str, known: Vec<String>| RunError::Name {
            key,
            what,
            found: found.to_owned(),
            known: known.join(", "),
        };
        let (link, card) = (&scene.device.link, &scene.device.card);
        // The world is flat or bare already: its leaves are drawn as they are.
        let drawn = match scene.model.name {
            ModelName::Flattened | ModelName::Bare => ModelName::Full,
            name => name,
        };
        let (name, mode) = (drawn.name(), scene.model.mode.name());
        let modes = || {
            Kind::ALL
                .iter()
                .map(|kind| kind.names())
                .filter(|names| names.0 == name)
        };
        Ok(Self {
            kind: Kind::named(name, mode).ok_or_else(|| {
                let known = modes().map(|names| names.1.to_owned()).collect();
                unknown("model.mode", "mode", mode, known)
            })?,
            model: ModelOptions {
                extraction: match scene.model.extraction {
                    scene::Extraction::Single => Extraction::Single,
                    scene::Extraction::Batched => Extraction::Batched,
                },
                gather: match scene.model.gather {
                    scene::Gather::Single => Gather::Single,
                    scene::Gather::Regions => Gather::Regions,
                },
                format: LeafFormat {
                    records: match scene.model.records {
                        scene::RecordWidth::Wide => Records::Wide,
                        scene::RecordWidth::Compact => Records::Compact,
                    },
                    vertices: match scene.model.vertices {
                        scene::VertexFormat::Float => Vertices::Float,
                        scene::VertexFormat::Quantised => Vertices::Quantised,
                    },
                },
                occlusion: match scene.model.occlusion {
                    scene::Occlusion::None => Occlusion::None,
                    scene::Occlusion::TwoPhase => Occlusion::TwoPhase,
                },
                cards: scene.cards,
                painting: scene.painting,
            },
            trunk: TrunkKind {
                name: scene.model.trunk,
                mode: scene.model.trunk_mode,
            },
            size: scene.size,
            samples: scene.samples,
            link: Link::named(link).ok_or_else(|| {
                let known = Link::ALL
                    .iter()
                    .map(|link| link.name().to_owned())
                    .collect();
                unknown("device.link", "link", link, known)
            })?,
            card: Card::named(card).ok_or_else(|| {
                let known = Card::ALL
                    .iter()
                    .map(|card| card.name().to_owned())
                    .collect();
                unknown("device.card", "card", card, known)
            })?,
            raster,
            instructions: Instructions::Best,
        })
    }
}
