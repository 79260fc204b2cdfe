//! A scene on a device, frame by frame.
//!
//! ```text
//! new: uploads ─▶ for each frame: detail (select, afford, commit) ─▶ draw ─▶ Frame
//! ```
//!
//! **Invariant.** Whatever a session sends goes through its device's queue, and what it creates has an
//! [`Owner`].

mod detail;
mod drawing;
mod groves;
mod owner;

use std::sync::Arc;

pub use owner::Owner;

use groves::{grove_view, groves};
use owner::Owners;

use super::RunError;
use super::frame::Frame;
use super::options::SessionOptions;
use super::selector::Selector;
use super::shadow::Shadows;
use super::views::Shot;
use super::world::World;
use crate::gpu::{
    Device, DeviceDescriptor, Ledger, ProbedFragment, ResourceId, TargetDescriptor, TargetId,
};
use crate::math::{Vec3, Vec4, index_u32};
use crate::models::{
    CARD_GROUP, Camera, Environment, Ground, Kind, LEAF_GROUP, Occlusion, Painting, Placement,
    Resident, ResidentGrove, Shared, TreeChange, TreeState, TrunkKind, TrunkLevel, View,
};
use crate::raster::{Image, Samples, decode_srgb};
use crate::scene::{ImageSize, SampleCount, Scene};

/// A scene on a device.
#[derive(Debug)]
pub struct Session<'w> {
    scene: &'w Scene,
    world: &'w World,
    kind: Kind,
    /// How many levels its cards have.
    card_levels: u32,
    /// What is painted of each plant, where the model paints.
    paintings: Vec<Option<Arc<Painting>>>,
    trunk: TrunkKind,
    selector: Selector,
    size: ImageSize,
    device: Device,
    environment: Environment,
    target: TargetId,
    ground: Option<Ground>,
    groves: Vec<ResidentGrove>,
    /// The trunk of every tree that has one.
    trunks: Vec<Option<Box<dyn Resident<TrunkLevel>>>>,
    residents: Vec<Box<dyn Resident>>,
    initial: Ledger,
    view: Option<View>,
    /// Where the viewer of the last view stands.
    eye: Vec3,
    deferred: Option<u64>,
    camera: Option<Camera>,
    owners: Owners,
    shadows: Option<Shadows>,
}

/// Which part of a frame is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::run) enum Layers {
    /// What is opaque.
    Polygons,
    /// What is blended, as if nothing were before it.
    Lines,
}

/// The target's label.
pub(in crate::run) const FRAME: &str = "frame";

/// Whether a session records what it sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Recorded {
    No,
    FromTheStart,
}

impl<'w> Session<'w> {
    /// Makes a device and sends everything for the first frame's states.
    ///
    /// # Errors
    ///
    /// What the device refuses, above all for lack of memory.
    pub fn new(
        scene: &'w Scene,
        world: &'w World,
        options: &SessionOptions,
    ) -> Result<Self, RunError> {
        Self::make(scene, world, options, Recorded::No, None)
    }

    /// As [`new`](Self::new), with every byte recorded from the first on: see
    /// [`Device::recording`].
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new).
    pub fn recorded(
        scene: &'w Scene,
        world: &'w World,
        options: &SessionOptions,
    ) -> Result<Self, RunError> {
        Self::make(scene, world, options, Recorded::FromTheStart, None)
    }

    /// As [`recorded`](Self::recorded), with every tree in a given state, as if it had never stood in
    /// another: what a session that came there by any way is held against.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new).
    pub fn standing(
        scene: &'w Scene,
        world: &'w World,
        options: &SessionOptions,
        states: &[TreeState],
    ) -> Result<Self, RunError> {
        let recorded = Recorded::FromTheStart;
        Self::make(scene, world, options, recorded, Some(states))
    }

    fn make(
        scene: &'w Scene,
        world: &'w World,
        options: &SessionOptions,
        recorded: Recorded,
        dictated: Option<&[TreeState]>,
    ) -> Result<Self, RunError> {
        let mut device = Device::new(DeviceDescriptor {
            memory_bytes: scene.device.memory,
            link: options.link,
            card: options.card,
            raster: options.raster,
        });
        device.limit_instructions(options.instructions);
        if recorded == Recorded::FromTheStart {
            device.record();
        }
        let target = device.create_target(&TargetDescriptor {
            label: FRAME,
            width: options.size.width(),
            height: options.size.height(),
            samples: match options.samples {
                SampleCount::One => Samples::One,
                SampleCount::Four => Samples::Four,
            },
        })?;
        let trees = index_u32(world.trees.len());
        // The ground is placed after all trees.
        let placed = trees + u32::from(world.ground.is_some());
        let environment = Environment::of_kind(&mut device, placed, options.kind)?;
        let view = scene.camera.at(0, options.size);
        let mut environment = environment.seen_by(view.pixels_per_metre_at_1m);
        if options.kind.selects() && options.model.occlusion == Occlusion::TwoPhase {
            environment.occlude(&mut device, target)?;
        }
        let shadows = Shadows::new(scene, world, options.kind, &mut device, &mut environment)?;
        let ground = match &world.ground {
            None => None,
            Some(mesh) => {
                environment.place(&mut device.queue(), trees, &Placement::IDENTITY)?;
                Some(Ground::upload(&mut device, &environment, mesh, trees)?)
            }
        };
        let groves = match (scene.grove, options.trunk.has_errors()) {
            (Some(choice), true) => groves(world, choice, &mut device, &environment, target)?,
            _ => Vec::new(),
        };
        let mut owners = Owners::default();
        owners.claim(&device, Owner::Scene);
        let mut trunks = Vec::new();
        let mut shared: Vec<Box<dyn Shared>> = Vec::new();
        let mut paintings: Vec<Option<Arc<Painting>>> = Vec::new();
        for (number, crown) in world.crowns.iter().enumerate() {
            let model = options.kind.model(crown, options.model);
            let painting = model.painting().map(Arc::clone);
            let trunk = world.trunks[number].as_ref();
            let trunk = trunk.filter(|_| !paints_trunk(painting.as_ref()));
            paintings.push(painting);
            let trunk = trunk.map(|trunk| options.trunk.model(trunk, options.model));
            let uploaded = trunk.map(|trunk| trunk.upload(&mut device, &environment));
            trunks.push(uploaded.transpose()?);
            let standing = world.trees.iter().filter(|tree| tree.crown == number);
            let rooms = index_u32(standing.count());
            shared.push(model.upload(&mut device, &environment.with_rooms(rooms))?);
            owners.claim(&device, Owner::Plant(number));
        }
        let mut session = Self {
            scene,
            world,
            kind: options.kind,
            card_levels: options.kind.card_levels(&options.model.cards),
            paintings,
            trunk: options.trunk,
            // Also where foliage has no levels: trunks follow the axis that it would be on.
            selector: Selector::new(Kind::LodfHost, &scene.model),
            size: options.size,
            device,
            environment,
            target,
            ground,
            groves,
            trunks: Vec::new(),
            residents: Vec::new(),
            initial: Ledger::default(),
            view: None,
            eye: Vec3::ZERO,
            deferred: None,
            camera: None,
            owners,
            shadows,
        };
        let states = dictated.map_or_else(|| session.select(0), <[_]>::to_vec);
        for ((number, tree), state) in (0..).zip(&world.trees).zip(&states) {
            environment.place(&mut session.device.queue(), number, &tree.placement)?;
            let device = &mut session.device;
            let in_grove = !session.groves.is_empty() && world.is_in_grove(number as usize);
            let trunk = trunks[tree.crown].as_ref().filter(|_| !in_grove);
            let trunk = trunk.map(|trunk| trunk.instance(device, &state.trunk, number));
            session.trunks.push(trunk.transpose()?);
            session.owners.claim(&session.device, Owner::Tree(number));
            let resident =
                shared[tree.crown].instance(&mut session.device, &state.foliage, number)?;
            session.residents.push(resident);
            // Trees that the device selects for lie in buffers of all.
            let in_buffers_of_all = options.kind.selects();
            let owner = if in_buffers_of_all {
                Owner::Plant(tree.crown)
            } else {
                Owner::Tree(number)
            };
            session.owners.claim(&session.device, owner);
        }
        // What selects by itself stands as its first frame begins.
        if dictated.is_none() && session.selecting_camera(0).is_some() {
            session.commit(0)?;
        }
        session.initial = session.device.take_ledger();
        Ok(session)
    }

    /// What was sent before the first frame.
    #[must_use]
    pub fn initial(&self) -> &Ledger {
        &self.initial
    }

    /// [`Device::limit_geometry`].
    pub fn limit_geometry(&mut self, bytes: u64) {
        self.device.limit_geometry(bytes);
    }

    /// The device.
    #[must_use]
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// The device, for tests that track what it reads or overwrite what it does not.
    pub fn device_mut(&mut self) -> &mut Device {
        &mut self.device
    }

    /// What a buffer or texture belongs to; those that the session did not make, to the scene.
    #[must_use]
    pub fn owner(&self, resource: ResourceId) -> Owner {
        self.owners.of(resource)
    }

    /// Forgets what was recorded and records on.
    pub fn record(&mut self) {
        self.device.record();
    }

    /// The target that frames are drawn into.
    #[must_use]
    pub fn target(&self) -> TargetId {
        self.target
    }

    /// Draws a frame as it is committed.
    ///
    /// # Errors
    ///
    /// None on this session's own device.
    pub fn draw(&mut self, frame: u32, change: TreeChange) -> Result<Frame, RunError> {
        self.set_view(frame)?;
        let ground = self.ground.as_ref().map_or(0, Ground::triangle_count);
        let states = self.states();
        let leaves = self.leaf_count();
        let cards: u64 = self.residents.iter().map(|one| one.card_triangles()).sum();
        let strokes: u64 = self.residents.iter().map(|one| one.strokes()).sum();
        let trees = self.world.trees.iter().zip(&states);
        let leaf_triangles: u64 = trees
            .map(|(tree, state)| self.world.crowns[tree.crown].shown_triangles(&state.foliage))
            .sum();
        let [trunk_triangles, lines] = self.wood(frame, &states);
        let commands = self.commands();
        self.device.queue().submit(&commands)?;
        let image = self.device.present(self.target)?;
        Ok(Frame {
            frame,
            eye: self.scene.camera.at(frame, self.size).eye,
            image_digest: image.digest(),
            image,
            leaves,
            lines,
            strokes,
            triangles: leaf_triangles + cards + 2 * strokes + trunk_triangles + u64::from(ground),
            trunk_triangles,
            change: change.foliage,
            trunk_change: change.trunk,
            ledger: self.device.take_ledger(),
            states,
            deferred: self.deferred.take(),
            popping: None,
        })
    }

    /// Leaves that are shown as it is committed.
    pub(in crate::run) fn leaf_count(&self) -> u64 {
        let trees = self.world.trees.iter().zip(&self.residents);
        let leaves = trees
            .map(|(tree, resident)| self.world.crowns[tree.crown].shown_leaves(resident.state()));
        leaves.sum()
    }

    /// The state of every tree as it is committed.
    #[must_use]
    pub fn states(&self) -> Vec<TreeState> {
        let trees = self.trunks.iter().zip(&self.residents);
        let state = |(trunk, foliage): (&Option<Box<dyn Resident<TrunkLevel>>>, &Box<_>)| {
            let foliage: &dyn Resident = &**foliage;
            TreeState {
                foliage: foliage.state().clone(),
                trunk: trunk
                    .as_ref()
                    .map_or(TrunkLevel::FINEST, |trunk| *trunk.state()),
            }
        };
        trees.map(state).collect()
    }

    /// The linear colour behind everything.
    #[must_use]
    pub fn background(&self) -> Vec4 {
        decode_srgb(self.scene.background)
    }

    /// The forests of patches that are drawn at once.
    #[must_use]
    pub fn groves(&self) -> &[ResidentGrove] {
        &self.groves
    }

    /// What is painted of a plant, where the model paints.
    #[must_use]
    pub fn painting(&self, crown: usize) -> Option<&Arc<Painting>> {
        self.paintings.get(crown)?.as_ref()
    }

    /// Whether strokes take the place of a plant's trunk.
    fn paints_trunk(&self, crown: usize) -> bool {
        paints_trunk(self.painting(crown))
    }

    /// Every fragment of the frame that was drawn last at one of its pixels, in the order of
    /// submission: what shows, what it hides, and what the alpha test killed.
    ///
    /// # Errors
    ///
    /// None on this session's own device.
    pub fn probe(&self, pixel: [u32; 2]) -> Result<Vec<ProbedFragment>, RunError> {
        let mut pass = self.pass();
        for resident in &self.residents {
            resident.draw_revealed(&mut pass.steps);
        }
        pass.steps.extend(self.blended());
        Ok(self.device.probe(&pass, pixel)?)
    }

    /// Commits and draws one frame.
    ///
    /// # Errors
    ///
    /// None on this session's own device.
    pub fn frame(&mut self, frame: u32) -> Result<Frame, RunError> {
        let change = self.commit(frame)?;
        self.draw(frame, change)
    }

    /// Goes over to a level from 0 to 1, as [`at_level`](Self::at_level) has it, and draws a frame there.
    ///
    /// # Errors
    ///
    /// None on this session's own device.
    pub fn frame_at(&mut self, frame: u32, level: f32) -> Result<Frame, RunError> {
        let states = self.at_level(frame, level);
        self.frame_of(frame, &states)
    }

    /// Sends the view of a frame, as drawing it would, and drops what was counted.
    pub(in crate::run) fn forget(&mut self, frame: u32) -> Result<(), RunError> {
        self.set_view(frame)?;
        self.device.take_ledger();
        Ok(())
    }

    /// Commits a frame without drawing it and drops what that cost from the ledger.
    ///
    /// # Errors
    ///
    /// None on this session's own device.
    pub fn skip(&mut self, frame: u32) -> Result<(), RunError> {
        self.commit(frame)?;
        self.forget(frame)
    }

    /// Sends the view of a frame, if it is another than the last.
    pub(in crate::run) fn set_view(&mut self, frame: u32) -> Result<(), RunError> {
        let light = &self.scene.light;
        let seen = self.scene.camera.at(frame, self.size);
        if let Some(shadows) = &mut self.shadows {
            shadows.send(&mut self.device, &self.environment, &seen)?;
        }
        let view = View {
            clip_from_world: seen.clip_from_world,
            to_light: light.towards(),
            light: light.color,
            ambient: light.ambient,
        };
        if self.view != Some(view) {
            self.environment.set_view(&mut self.device.queue(), &view)?;
            self.view = Some(view);
            for grove in &self.groves {
                grove.look(&mut self.device, &grove_view(&seen))?;
            }
        }
        let eye = seen.eye;
        self.eye = eye;
        for (tree, resident) in self.world.trees.iter().zip(&mut self.residents) {
            resident.look_from(&mut self.device.queue(), tree.placement.to_plant(eye))?;
        }
        Ok(())
    }

    /// What a frame's camera sees as it is committed, counted by nobody.
    ///
    /// # Errors
    ///
    /// None on this session's own device.
    pub fn shot(&mut self, frame: u32) -> Result<Shot, RunError> {
        self.set_view(frame)?;
        let commands = self.commands();
        self.device.queue().submit(&commands)?;
        self.device.take_ledger();
        Ok(Shot::of(self.device.inspect_target(self.target)?))
    }

    /// Commits states, one a tree, and draws a frame with them.
    pub(in crate::run) fn frame_of(
        &mut self,
        frame: u32,
        states: &[TreeState],
    ) -> Result<Frame, RunError> {
        let change = self.commit_states(states)?;
        self.draw(frame, change)
    }

    /// A frame as it is committed of which only some is drawn, counted by nobody.
    pub(in crate::run) fn layers(&mut self, frame: u32, layers: Layers) -> Result<Image, RunError> {
        self.set_view(frame)?;
        let (mut pass, mut blended) = (self.pass(), self.blended());
        match layers {
            Layers::Polygons => blended.clear(),
            Layers::Lines => pass.steps.clear(),
        }
        let commands = self.assembled(pass, blended);
        self.device.queue().submit(&commands)?;
        let image = self.device.present(self.target)?;
        self.device.take_ledger();
        Ok(image)
    }

    /// What the frame that was drawn last shows.
    ///
    /// # Errors
    ///
    /// None on this session's own device.
    pub fn drawn(&self) -> Result<Shot, RunError> {
        Ok(Shot::of(self.device.inspect_target(self.target)?))
    }

    /// How many pixels show a leaf, or a card in place of some, by their first sample.
    #[must_use]
    pub fn covered_pixels(&self) -> u64 {
        let target = self.device.inspect_target(self.target);
        let groups = [LEAF_GROUP, CARD_GROUP].into_iter();
        target.map_or(0, |target| {
            groups
                .map(|group| u64::from(target.pixels_showing(group)))
                .sum()
        })
    }
}

/// Whether strokes take the place of the trunk of what is painted.
fn paints_trunk(painting: Option<&Arc<Painting>>) -> bool {
    painting.is_some_and(|painting| painting.paints_trunk())
}
