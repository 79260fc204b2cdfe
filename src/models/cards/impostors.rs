//! Leaf cluster impostors: textured rectangles in the planes of leaf clusters, never turned to the
//! camera ([GSS05](crate::references)).
//!
//! ```text
//!  once a species                                 once an instance
//! records of all levels, 224 B an impostor ─┐     level, 4 B ─┐
//! colours and normals, an atlas each ───────┴─────────────────┴──▶ one draw
//! ```
//!
//! **Invariant.** Everything of all levels is resident; a change of level sends the level, 4 B.

use std::sync::Arc;

use super::atlas::Atlas;
use super::impostors_program::{
    COLOUR_SLOT, IMPOSTOR_SLOT, ImpostorProgram, ImpostorRecord, ImpostorTextures, LEVEL_SLOT,
    NORMAL_SLOT,
};
use super::impostors_set::{ImpostorSet, counts};
use crate::gpu::{
    BufferId, Cause, Corners, Device, Draw, GpuError, Ledger, Queue, Step, TextureDescriptor,
    TextureFormat, TextureId, Usage,
};
use crate::math::index_u32;
use crate::models::surface::filled;
use crate::models::{
    CARD_GROUP, CardLevel, Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared,
    State, Storage,
};

/// The model of impostors with a texture each.
///
/// Host memory: none once all is sent. Device memory: a [record](ImpostorRecord) an impostor, and two
/// textures with all their levels, colours and normals; an instance has its level, 4 bytes.
#[derive(Debug, Clone)]
pub(in crate::models) struct Impostors {
    crown: Arc<Crown>,
    program: ImpostorProgram,
    set: Result<Arc<ImpostorSet>, GpuError>,
}

impl Impostors {
    /// Clusters leaves and bakes their textures.
    pub(in crate::models) fn new(crown: Arc<Crown>, options: ModelOptions) -> Self {
        let set = ImpostorSet::of(crown.plant().foliage(), &options.cards);
        Self {
            crown,
            program: ImpostorProgram {
                outline: options.cards.outline,
                sides: options.cards.sides,
                textures: ImpostorTextures::Direct,
            },
            set: set.map(Arc::new),
        }
    }
}

/// What the program reads of each impostor.
fn records(set: &ImpostorSet) -> Vec<ImpostorRecord> {
    let cells = set.atlas.as_ref().map_or(&[][..], |atlas| &atlas.cells);
    let views = (cells.len() / set.impostors.len().max(1)).max(1);
    let impostors = set.impostors.iter().zip(&set.outlines);
    let records = impostors.zip(cells.chunks_exact(views));
    records
        .map(|((impostor, outline), cells)| {
            let (front, back) = (&cells[0], &cells[views - 1]);
            ImpostorRecord::of(impostor, outline, [front.least, back.least], front.sides)
        })
        .collect()
}

impl Model for Impostors {
    fn kind(&self) -> Kind {
        Kind::Impostors
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
        let set = self.set.as_ref().map_err(Clone::clone)?;
        let records = records(set);
        let bytes: Vec<u8> = records.iter().flat_map(ImpostorRecord::to_bytes).collect();
        let mut steps = Vec::new();
        if let Some(atlas) = &set.atlas {
            let cause = Cause::of("impostors");
            let records = filled(device, "impostors", Usage::STORAGE, &bytes, cause)?;
            let [colour, normal] = upload_atlas(device, atlas)?;
            let program = device.create_program(Arc::new(self.program));
            steps.extend(environment.bind(program));
            steps.push(Step::Storage {
                slot: IMPOSTOR_SLOT,
                buffer: records,
            });
            steps.push(Step::Texture {
                slot: COLOUR_SLOT,
                texture: colour,
            });
            steps.push(Step::Texture {
                slot: NORMAL_SLOT,
                texture: normal,
            });
        }
        Ok(Box::new(CardInstances {
            steps,
            quads: self.program.quads(),
            triangles: triangles(set),
            counts: counts(&set.impostors, set.levels),
        }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        Vec::new()
    }

    fn storage(&self) -> Storage {
        let of_set = |set: &Arc<ImpostorSet>| {
            let records = 4 * (ImpostorRecord::WORDS * set.impostors.len()) as u64;
            records + set.atlas.as_ref().map_or(0, Atlas::bytes)
        };
        Storage {
            host_bytes: 0,
            shared_bytes: self.set.as_ref().map_or(0, of_set),
            instance_bytes: LEVEL_BYTES,
            instance_host_bytes: State::Cards(CardLevel::FINEST).host_bytes(),
        }
    }

    fn baked(&self) -> Option<&Ledger> {
        self.set.as_ref().ok().map(|set| &set.ledger)
    }
}

/// Bytes of an instance on the device.
pub(super) const LEVEL_BYTES: u64 = 4;

/// Triangles of the impostors of each level.
fn triangles(set: &ImpostorSet) -> Vec<u64> {
    let mut triangles = vec![0; set.levels as usize];
    for (impostor, outline) in set.impostors.iter().zip(&set.outlines) {
        triangles[impostor.level as usize] += outline.corners.len() as u64 - 2;
    }
    triangles
}

/// Sends an atlas as two textures: colours, normals.
pub(super) fn upload_atlas(device: &mut Device, atlas: &Atlas) -> Result<[TextureId; 2], GpuError> {
    let mut send = |label, format, levels: &[Vec<u8>]| {
        let texture = device.create_texture(&TextureDescriptor {
            label,
            format,
            width: atlas.size[0],
            height: atlas.size[1],
            levels: index_u32(levels.len()),
        })?;
        for (level, bytes) in (0..).zip(levels) {
            let cause = Cause::of("texture");
            device.queue().write_texture(texture, level, bytes, cause)?;
        }
        Ok(texture)
    };
    Ok([
        send("card colours", TextureFormat::Srgb8, &atlas.colour)?,
        send("card normals", TextureFormat::Linear8, &atlas.normals)?,
    ])
}

/// What all instances of impostors share, whatever their textures.
#[derive(Debug)]
pub(super) struct CardInstances {
    /// Binds it; empty where there are no impostors.
    pub(super) steps: Vec<Step>,
    /// Quads that each is drawn as.
    pub(super) quads: u32,
    /// Triangles drawn at each level.
    pub(super) triangles: Vec<u64>,
    /// Impostors of each level.
    pub(super) counts: Vec<u32>,
}

impl Shared for CardInstances {
    fn instance(
        &self,
        device: &mut Device,
        state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let level = self.level(state);
        let bytes = level.0.to_le_bytes();
        let cause = Cause::of("card-level");
        let buffer = filled(device, "card level", Usage::STORAGE, &bytes, cause)?;
        let mut steps = self.steps.clone();
        if !steps.is_empty() {
            steps.push(Step::Storage {
                slot: LEVEL_SLOT,
                buffer,
            });
            steps.push(Step::Draw(Draw {
                source: Corners::Counted,
                first_corner: 0,
                corner_count: 4 * self.quads * self.counts.iter().sum::<u32>(),
                instance: number,
                group: CARD_GROUP,
            }));
        }
        Ok(Box::new(ImpostorsResident {
            steps,
            buffer,
            coarsest: self.level(&State::Cards(CardLevel(u32::MAX))),
            triangles: self.triangles.clone(),
            counts: self.counts.clone(),
            state: State::Cards(level),
        }))
    }
}

impl CardInstances {
    /// The level of a state: the finest of one that shows leaves, and never past the coarsest.
    fn level(&self, state: &State) -> CardLevel {
        level_of(
            state,
            CardLevel::at_share(1.0, index_u32(self.counts.len())),
        )
    }
}

fn level_of(state: &State, coarsest: CardLevel) -> CardLevel {
    match state {
        State::Cards(level) => (*level).min(coarsest),
        State::Uniform { .. } | State::Variable { .. } => CardLevel::FINEST,
    }
}

#[derive(Debug)]
struct ImpostorsResident {
    steps: Vec<Step>,
    buffer: BufferId,
    coarsest: CardLevel,
    triangles: Vec<u64>,
    counts: Vec<u32>,
    state: State,
}

impl ImpostorsResident {
    fn level(&self) -> CardLevel {
        level_of(&self.state, self.coarsest)
    }
}

impl Resident for ImpostorsResident {
    fn state(&self) -> &State {
        &self.state
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        let (from, to) = (self.level(), level_of(to, self.coarsest));
        if from == to {
            return Ok(Change::default());
        }
        queue.write(self.buffer, 0, &to.0.to_le_bytes(), Cause::of("card-level"))?;
        self.state = State::Cards(to);
        let [level, _] = to.parts();
        Ok(Change {
            clusters_touched: self.counts.get(level as usize).copied().unwrap_or(0),
            host_records: 1,
            ..Change::default()
        })
    }

    fn price(&self, to: &State) -> u64 {
        LEVEL_BYTES * u64::from(level_of(to, self.coarsest) != self.level())
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.steps);
    }

    fn card_triangles(&self) -> u64 {
        let [level, _] = self.level().parts();
        self.triangles.get(level as usize).copied().unwrap_or(0)
    }

    fn host_bytes(&self) -> u64 {
        self.state.host_bytes()
    }
}
