//! Leaf cluster impostors with indirect textures: a small map of where leaves lie, and pictures of one
//! leaf, turned ([GSS05](crate::references), § 2.3).
//!
//! ```text
//! direct     a texture of all leaves, front and back       ─read─▶ colour
//! indirect   map ─read─▶ which leaves, where ─▶ sprites     ─read─▶ colour
//! ```
//!
//! **Invariant.** Every leaf is in the map wherever it shows: where a texel would have more leaves than
//! there is room for, uploading is refused with the number that it takes.

use std::sync::Arc;

use super::atlas::Atlas;
use super::bake::{Bake, BakeOptions, bake};
use super::impostors::{CardInstances, LEVEL_BYTES, upload_atlas};
use super::impostors_outline::{Outline, OutlineCorner};
use super::impostors_program::{
    COLOUR_SLOT, IMPOSTOR_SLOT, ImpostorProgram, ImpostorRecord, ImpostorTextures, NORMAL_SLOT,
};
use super::impostors_set::{CARD_ALPHA_CUTOFF, Impostor, SUPERSAMPLING, counts, planned};
use super::indirect_fragment::{
    LEAF_PLANE_SLOT, LEAF_SLOT, LIST_SLOT, MAP_SLOT, SPRITE_SLOT, leaf_plane_bytes,
    leaf_plane_size, sprite_bytes,
};
use super::indirect_map::{
    FloatTexels, LeafMap, LeafMapFacts, MOST_ENTRIES, MapSheet, corners, leaf_map,
};
use super::indirect_sprites::{SpriteTurns, in_frame, leaf_shapes};
use super::triangles::LeafTriangles;
use crate::gpu::{Cause, Device, GpuError, Ledger, Step, TextureDescriptor, TextureFormat, Usage};
use crate::math::{Vec2, index_u32};
use crate::models::surface::filled;
use crate::models::{
    CardLevel, Crown, Environment, Kind, Model, ModelOptions, Shared, State, Storage,
};
use crate::scene::{CardDepth, CardOptions, CardOutline, Transparency};

/// The model of impostors with indirect textures.
///
/// Host memory: none once all is sent. Device memory: a record and a leaf plane an impostor, the sprites'
/// places, textures of floats with all maps, their lists and leaves, and two of sprites with all their levels, colours and
/// normals; an instance has its level, 4 bytes.
#[derive(Debug, Clone)]
pub(in crate::models) struct IndirectImpostors {
    crown: Arc<Crown>,
    program: ImpostorProgram,
    levels: u32,
    parts: Result<Arc<Parts>, GpuError>,
}

/// What is sent.
#[derive(Debug)]
struct Parts {
    impostors: Vec<Impostor>,
    maps: Vec<LeafMap>,
    sheet: MapSheet,
    map_side: u32,
    facts: LeafMapFacts,
    sprites: Option<Atlas>,
    ledger: Ledger,
}

impl IndirectImpostors {
    /// Clusters leaves, finds where each lies, and bakes sprites. Of the options those of a picture each
    /// mean nothing here: outline, depth, transparency, texture.
    pub(in crate::models) fn new(crown: Arc<Crown>, options: ModelOptions) -> Self {
        let parts = Parts::of(&crown, &options.cards);
        Self {
            crown,
            program: ImpostorProgram {
                outline: CardOutline::Quad,
                sides: options.cards.sides,
                depth: CardDepth::Paper,
                transparency: Transparency::Test,
                textures: ImpostorTextures::Indirect,
            },
            levels: index_u32(options.cards.levels.as_slice().len()),
            parts: parts.map(Arc::new),
        }
    }
}

impl Parts {
    fn of(crown: &Crown, options: &CardOptions) -> Result<Self, GpuError> {
        let leaves = LeafTriangles::of(crown.plant().foliage());
        let impostors = planned(crown, &leaves, options);
        let shapes = leaf_shapes(&leaves);
        let turns = SpriteTurns::new(options.sprites);
        if index_u32(impostors.len()) > MapSheet::room(options.map) {
            let (count, side) = (impostors.len(), options.map);
            let what = format!("{count} maps of {side} × {side} texels, which fit no texture");
            return Err(GpuError::Unsupported { what });
        }
        let mut maps: Vec<LeafMap> = Vec::with_capacity(impostors.len());
        let mut room = MOST_ENTRIES;
        for impostor in &impostors {
            let map = leaf_map(impostor, (&shapes, &turns), options, room);
            let map = map.ok_or_else(|| {
                let side = options.map;
                let what = format!(
                    "leaf distribution maps of {side} × {side} texels with more than {MOST_ENTRIES} \
                     leaves in all their texels together"
                );
                GpuError::Unsupported { what }
            })?;
            room -= map.entries;
            maps.push(map);
        }
        let facts = LeafMapFacts::of(&maps);
        let most = facts.most_leaves;
        if most > options.layers {
            let (side, layers) = (options.map, options.layers);
            let what = format!(
                "a leaf distribution map of {side} × {side} texels with {most} leaves in a texel \
                 (there is room for {layers}: `cards.layers`)"
            );
            return Err(GpuError::Unsupported { what });
        }
        let views = turns.views(&leaves, &shapes, options.sprite_texture);
        let supersampling = SUPERSAMPLING;
        let Bake {
            views: baked,
            ledger,
        } = bake(&leaves, &views, BakeOptions { supersampling })?;
        let baked = baked.into_iter().zip(&views);
        let baked: Vec<_> = baked
            .map(|(baked, view)| in_frame(baked, &view.frame))
            .collect();
        let sprites = Atlas::of(&baked, CARD_ALPHA_CUTOFF);
        if sprites.is_none() && !baked.is_empty() {
            let what = format!("{} sprites, which fit no texture", baked.len());
            return Err(GpuError::Unsupported { what });
        }
        Ok(Self {
            sheet: MapSheet::of(&maps, options.map),
            map_side: options.map,
            facts,
            impostors,
            maps,
            sprites,
            ledger,
        })
    }

    fn records(&self) -> impl Iterator<Item = ImpostorRecord> + '_ {
        self.impostors
            .iter()
            .zip(&self.maps)
            .map(|(impostor, map)| {
                let corners = corners(&map.plane).into_iter();
                let corners = corners.map(|(position, coordinate)| OutlineCorner {
                    position,
                    coordinate,
                });
                let outline = Outline {
                    corners: corners.collect(),
                };
                ImpostorRecord::of(impostor, &outline)
            })
    }

    /// Bytes of all that lies on the device, but instances.
    fn bytes(&self) -> u64 {
        let Some(sprites) = &self.sprites else {
            return 0;
        };
        4 * (ImpostorRecord::WORDS * self.impostors.len()) as u64
            + leaf_plane_size(self.impostors.len())
            + 8 * sprites.cells.len() as u64
            + self.sheet.map.byte_count()
            + self.sheet.list.byte_count()
            + self.sheet.leaves.byte_count()
            + sprites.bytes()
    }

    fn send(
        &self,
        device: &mut Device,
        environment: &Environment,
        program: ImpostorProgram,
    ) -> Result<Vec<Step>, GpuError> {
        let Some(sprites) = &self.sprites else {
            return Ok(Vec::new());
        };
        let records: Vec<u8> = self
            .records()
            .flat_map(|record| record.to_bytes())
            .collect();
        let cell = sprites.cells.first().map_or(Vec2::ONE, |cell| cell.sides);
        let planes = self.maps.iter().map(|map| map.plane);
        let planes = leaf_plane_bytes(planes, (&self.sheet, self.map_side), cell);
        let places = sprite_bytes(sprites.cells.iter().map(|cell| cell.least));
        let cause = Cause::of("impostors");
        let mut steps: Vec<Step> = Vec::new();
        let program = device.create_program(Arc::new(program));
        steps.extend(environment.bind(program));
        for (slot, label, bytes) in [
            (IMPOSTOR_SLOT, "impostors", &records),
            (LEAF_PLANE_SLOT, "leaf planes", &planes),
            (SPRITE_SLOT, "sprite places", &places),
        ] {
            let buffer = filled(device, label, Usage::STORAGE, bytes, cause)?;
            steps.push(Step::Storage { slot, buffer });
        }
        let [colour, normal] = upload_atlas(device, sprites)?;
        let cause = Cause::of("texture");
        let mut send = |label, texels: &FloatTexels| {
            let texture = device.create_texture(&TextureDescriptor {
                label,
                format: TextureFormat::Float32,
                width: texels.size[0],
                height: texels.size[1],
                levels: 1,
            })?;
            let bytes = texels.bytes();
            device.queue().write_texture(texture, 0, &bytes, cause)?;
            Ok::<_, GpuError>(texture)
        };
        let map = send("leaf maps", &self.sheet.map)?;
        let list = send("leaf lists", &self.sheet.list)?;
        let leaves = send("leaf squares", &self.sheet.leaves)?;
        for (slot, texture) in [
            (COLOUR_SLOT, colour),
            (NORMAL_SLOT, normal),
            (MAP_SLOT, map),
            (LIST_SLOT, list),
            (LEAF_SLOT, leaves),
        ] {
            steps.push(Step::Texture { slot, texture });
        }
        Ok(steps)
    }
}

impl Model for IndirectImpostors {
    fn kind(&self) -> Kind {
        Kind::IndirectImpostors
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
        let parts = self.parts.as_ref().map_err(Clone::clone)?;
        let steps = parts.send(device, environment, self.program)?;
        let counts = counts(&parts.impostors, self.levels);
        Ok(Box::new(CardInstances {
            quads: self.program.quads(),
            triangles: counts.iter().map(|&count| 2 * u64::from(count)).collect(),
            counts,
            steps,
            centres: None,
        }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        Vec::new()
    }

    fn storage(&self) -> Storage {
        Storage {
            host_bytes: 0,
            shared_bytes: self.parts.as_ref().map_or(0, |parts| parts.bytes()),
            instance_bytes: LEVEL_BYTES,
            instance_host_bytes: State::Cards(CardLevel::FINEST).host_bytes(),
        }
    }

    fn leaf_maps(&self) -> Option<LeafMapFacts> {
        self.parts.as_ref().ok().map(|parts| parts.facts)
    }

    fn baked(&self) -> Option<&Ledger> {
        self.parts.as_ref().ok().map(|parts| &parts.ledger)
    }
}
