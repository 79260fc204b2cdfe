//! Leaf cluster impostors: textured rectangles in the planes of leaf clusters, never turned to the
//! camera ([GSS05](crate::references)).
//!
//! ```text
//!  once a species                                 once an instance
//! records of all levels, 240 B an impostor ─┐     level, 4 B ─┐
//! colours and normals, an atlas each ───────┴─────────────────┴──▶ one draw
//! ```
//!
//! **Invariant.** Everything of all levels is resident; a change of level sends the level, 4 B.

use std::sync::Arc;

use super::atlas::Atlas;
use super::eye::Eye;
use super::impostors_program::{
    COLOUR_SLOT, IMPOSTOR_SLOT, ImpostorProgram, ImpostorRecord, ImpostorTextures, LEVEL_SLOT,
    NORMAL_SLOT,
};
use super::impostors_set::{Impostor, ImpostorSet, counts};
use super::rival_carried::on_plane;
use crate::gpu::{
    BufferId, Cause, Corners, Device, Draw, GpuError, Key, Ledger, Queue, Step, TextureDescriptor,
    TextureFormat, TextureId, Usage,
};
use crate::math::{DVec3, Vec3, index_u32};
use crate::models::surface::filled;
use crate::models::{
    CARD_GROUP, CardLevel, Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared,
    State, Storage, Viewpoint,
};
use crate::scene::{CardDepth, Transparency};

/// The model of impostors with a texture each.
///
/// Host memory: none once all is sent; where impostors are blended, their centres. Device memory: a
/// [record](ImpostorRecord) an impostor, and two textures with all their levels, colours and normals; an
/// instance has its level, 4 bytes, and where impostors are blended their order, 16 bytes a quad, of which
/// the host keeps 4 an impostor.
#[derive(Debug, Clone)]
pub(in crate::models) struct Impostors {
    crown: Arc<Crown>,
    program: ImpostorProgram,
    set: Result<Arc<ImpostorSet>, GpuError>,
}

impl Impostors {
    /// Clusters leaves and bakes their textures.
    pub(in crate::models) fn new(crown: Arc<Crown>, options: ModelOptions) -> Self {
        let set = ImpostorSet::of(&crown, &options.cards);
        Self {
            crown,
            program: ImpostorProgram {
                outline: options.cards.outline,
                sides: options.cards.sides,
                depth: options.cards.depth,
                transparency: options.cards.transparency,
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
            ImpostorRecord::of(impostor, outline).in_cells([front, back])
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
            centres: centres(self.program, set),
            triangles: triangles(set),
            counts: counts(&set.impostors, set.levels),
        }))
    }

    /// The centres of impostors that are blended, 12 B each.
    fn host_bytes(&self) -> Vec<u8> {
        let set = self.set.as_ref().ok();
        let centres = set.and_then(|set| centres(self.program, set));
        let floats = centres
            .iter()
            .flat_map(|centres| centres.iter())
            .flat_map(Vec3::to_array);
        floats.flat_map(f32::to_le_bytes).collect()
    }

    fn storage(&self) -> Storage {
        let of_set = |set: &Arc<ImpostorSet>| {
            let records = 4 * (ImpostorRecord::WORDS * set.impostors.len()) as u64;
            records + set.atlas.as_ref().map_or(0, Atlas::bytes)
        };
        let set = self.set.as_ref().ok();
        let blended = set.and_then(|set| centres(self.program, set));
        let blended = blended.map_or(0, |centres| centres.len() as u64);
        let order = 16 * u64::from(self.program.quads()) * blended;
        Storage {
            host_bytes: 12 * blended,
            shared_bytes: set.map_or(0, of_set),
            instance_bytes: LEVEL_BYTES + order,
            instance_host_bytes: State::Cards(CardLevel::FINEST).host_bytes() + 4 * blended,
        }
    }

    /// Texels stay where they are in their planes; what relief adds is what they hide.
    fn carried(
        &self,
        state: &State,
        key: Key,
        point: DVec3,
        [from, _]: [&Viewpoint; 2],
    ) -> Option<DVec3> {
        let (Ok(set), CardDepth::Relief) = (&self.set, self.program.depth) else {
            return Some(point);
        };
        let impostor = set
            .impostors
            .get((key.vertex / 4 / self.program.quads()) as usize)?;
        let coarsest = CardLevel::at_share(1.0, set.levels);
        let [_, step] = level_of(state, coarsest).parts();
        let share = step as f32 / CardLevel::STEPS as f32;
        let plane = impostor.plane.between(&impostor.next, share);
        let eye = Eye::of(&from.clip_from_plant);
        let origin = plane.project(Vec3::ZERO).as_dvec3();
        on_plane(eye, point, [origin, plane.normal.as_dvec3()])
    }

    fn baked(&self) -> Option<&Ledger> {
        self.set.as_ref().ok().map(|set| &set.ledger)
    }
}

/// The centres of the rectangles, where impostors are blended.
fn centres(program: ImpostorProgram, set: &ImpostorSet) -> Option<Arc<[Vec3]>> {
    let centre = |one: &Impostor| {
        let middle = 0.5 * (one.rectangle.least + one.rectangle.greatest);
        one.frame.point(middle, 0.0)
    };
    let blends = program.transparency == Transparency::Blend;
    blends.then(|| set.impostors.iter().map(centre).collect())
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
    /// Where each lies, in the plant's space, if they are drawn from back to front.
    pub(super) centres: Option<Arc<[Vec3]>>,
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
        let order = if steps.is_empty() {
            None
        } else {
            steps.push(Step::Storage {
                slot: LEVEL_SLOT,
                buffer,
            });
            let order = match &self.centres {
                None => None,
                Some(centres) => {
                    let order = Order::of(device, Arc::clone(centres), self.quads)?;
                    steps.push(Step::Indices(order.indices));
                    Some(order)
                }
            };
            steps.push(Step::Draw(Draw {
                source: match order {
                    None => Corners::Counted,
                    Some(_) => Corners::Indexed,
                },
                first_corner: 0,
                corner_count: 4 * self.quads * self.counts.iter().sum::<u32>(),
                instance: number,
                group: CARD_GROUP,
            }));
            order
        };
        Ok(Box::new(ImpostorsResident {
            steps,
            buffer,
            coarsest: self.level(&State::Cards(CardLevel(u32::MAX))),
            triangles: self.triangles.clone(),
            counts: self.counts.clone(),
            state: State::Cards(level),
            order,
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
        State::Uniform { .. } | State::Variable { .. } | State::Strokes(_) => CardLevel::FINEST,
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
    order: Option<Order>,
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

    fn look_from(&mut self, queue: &mut Queue<'_>, eye: Vec3) -> Result<(), GpuError> {
        match &mut self.order {
            None => Ok(()),
            Some(order) => order.look_from(queue, eye),
        }
    }

    fn card_triangles(&self) -> u64 {
        let [level, _] = self.level().parts();
        self.triangles.get(level as usize).copied().unwrap_or(0)
    }

    fn host_bytes(&self) -> u64 {
        let order = self.order.as_ref().map_or(0, |order| order.order.len());
        self.state.host_bytes() + 4 * order as u64
    }
}

/// In which order an instance's impostors are drawn, where they are blended: from back to front by the
/// distance of their centres to the eye, of equals the lowest first.
///
/// Impostors cross each other, so no order is right everywhere; between two frames it changes at once.
#[derive(Debug)]
struct Order {
    centres: Arc<[Vec3]>,
    /// The corners of all quads, in this order.
    indices: BufferId,
    order: Vec<u32>,
    quads: u32,
}

impl Order {
    fn of(device: &mut Device, centres: Arc<[Vec3]>, quads: u32) -> Result<Self, GpuError> {
        let order: Vec<u32> = (0..index_u32(centres.len())).collect();
        let bytes = index_bytes(&order, quads);
        let indices = filled(device, "card order", Usage::INDEX, &bytes, ORDER)?;
        Ok(Self {
            centres,
            indices,
            order,
            quads,
        })
    }

    fn look_from(&mut self, queue: &mut Queue<'_>, eye: Vec3) -> Result<(), GpuError> {
        let distance = |number: &u32| self.centres[*number as usize].distance_squared(eye);
        let mut order: Vec<u32> = (0..index_u32(self.centres.len())).collect();
        order.sort_by(|a, b| distance(b).total_cmp(&distance(a)).then(a.cmp(b)));
        if order != self.order {
            queue.write(self.indices, 0, &index_bytes(&order, self.quads), ORDER)?;
            self.order = order;
        }
        Ok(())
    }
}

const ORDER: Cause = Cause::of("card-order");

/// The corners of impostors of so many quads each: 16 B a quad.
fn index_bytes(order: &[u32], quads: u32) -> Vec<u8> {
    let corners = order.iter().flat_map(|number| {
        let first = 4 * quads * number;
        first..first + 4 * quads
    });
    corners.flat_map(u32::to_le_bytes).collect()
}
