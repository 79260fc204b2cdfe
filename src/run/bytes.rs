//! What every model of every plant sends along the axis of detail, counted without a picture.
//!
//! ```text
//! World ─▶ each plant alone ─▶ each model: upload, then N changes ─▶ bytes, transfers, times a link
//! ```
//!
//! **Invariant.** All that is counted here, a [walk with pictures](super::sweep()) of the plant counts
//! too: the same uploads, fetches, commands and vertices.

use super::RunError;
use super::options::SessionOptions;
use super::progress::Progress;
use super::session::{FRAME, Session};
use super::sweep::{Variant, finest, states_at, traffic_on};
use super::world::World;
use crate::gpu::{Ledger, Link, Stream, Traffic};
use crate::models::State;
use crate::raster::Counters;
use crate::scene::{Scene, Simplifier};

/// What to walk.
#[derive(Debug, Clone, PartialEq)]
pub struct ByteOptions {
    /// The models.
    pub variants: Vec<Variant>,
    /// How many steps there are from full detail to the coarsest, at least 1.
    pub steps: u32,
    /// The links by which wire bytes and times are modelled.
    pub links: Vec<Link>,
    /// The device; the model is each variant's, and nothing is drawn.
    pub session: SessionOptions,
}

/// What the models of one plant send.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlantBytes {
    /// The plant's name.
    pub name: String,
    /// Leaves at full detail.
    pub leaves: u64,
    /// Leaves at the coarsest: one a cluster.
    pub clusters: u64,
    /// The models, in the order asked for.
    pub models: Vec<ModelBytes>,
}

/// What one model of a plant sends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelBytes {
    /// The model.
    pub variant: Variant,
    /// Device memory in use at full detail, but for what is drawn into.
    pub resident_bytes: u64,
    /// What is sent before step 0, on each link.
    pub initial: Vec<Traffic>,
    /// Steps `0..=steps`, each with a frame; step 0 changes nothing.
    pub steps: Vec<StepBytes>,
}

/// What a change of detail and the frame after it send.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StepBytes {
    /// Leaves shown.
    pub leaves: u64,
    /// On each link.
    pub traffic: Vec<StepTraffic>,
    /// Of the command stream.
    pub command_bytes: u64,
    /// Vertices that are submitted.
    pub vertices: u64,
}

/// A step on a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StepTraffic {
    /// What the change of detail uploads: all but the view.
    pub upload: Traffic,
    /// What the frame's draws pull from host memory.
    pub fetch: Traffic,
}

impl StepTraffic {
    /// Adds another step.
    pub fn add(&mut self, other: &Self) {
        self.upload.add(&other.upload);
        self.fetch.add(&other.fetch);
    }
}

/// Walks every model of each plant of a world along the axis of detail as
/// [`sweep`](super::sweep()) does, the plant standing alone where its first tree stands.
///
/// # Errors
///
/// What the device refuses, above all for lack of memory.
pub fn bytes(
    scene: &Scene,
    world: &World,
    options: &ByteOptions,
    progress: &dyn Progress,
) -> Result<Vec<PlantBytes>, RunError> {
    let steps = u64::from(options.steps) + 1;
    let plants = (0..world.crowns.len()).map(|number| {
        let alone = world.plant_alone(number);
        let any_pruned = options.variants.iter().any(|variant| variant.pruned);
        let pruned = any_pruned.then(|| alone.simplified_by(Simplifier::Pruning));
        let crown = &world.crowns[number];
        let name = crown.plant().name();
        progress.begin(name, options.variants.len() as u64 * steps);
        let models = options.variants.iter();
        let models = models.map(|&variant| {
            let pruned = pruned.as_ref().filter(|_| variant.pruned);
            walk(scene, pruned.unwrap_or(&alone), options, variant, progress)
        });
        Ok(PlantBytes {
            name: name.to_owned(),
            leaves: crown.shown_leaves(&State::FINEST),
            clusters: u64::from(crown.sequence().root_count()),
            models: models.collect::<Result<_, RunError>>()?,
        })
    });
    plants.collect()
}

fn walk(
    scene: &Scene,
    world: &World,
    options: &ByteOptions,
    variant: Variant,
    progress: &dyn Progress,
) -> Result<ModelBytes, RunError> {
    let mut session_options = variant.session(&options.session);
    // Nothing is drawn of which more could be counted.
    session_options.raster.counters = Counters::Visible;
    let finest = finest(scene);
    let mut session = Session::new(&finest, world, &session_options)?;
    let initial = on_links(session.initial(), Stream::Upload, &options.links);
    let resident = session.device().resident_by_label().into_iter();
    let others = resident.filter(|(label, _)| label != FRAME);
    let resident_bytes = others.map(|(_, bytes)| bytes).sum();
    let kinds = (session_options.kind, session_options.trunk);
    let mut steps = Vec::new();
    for step in 0..=options.steps {
        let at = [step, options.steps];
        let states = states_at(scene, world, session_options.size, kinds, at);
        session.commit_states(&states)?;
        let leaves = session.leaf_count();
        let ledger = tally(&mut session)?;
        let [upload, fetch] =
            [Stream::Upload, Stream::Fetch].map(|s| on_links(&ledger, s, &options.links));
        let traffic = upload.into_iter().zip(fetch);
        steps.push(StepBytes {
            leaves,
            traffic: traffic
                .map(|(upload, fetch)| StepTraffic { upload, fetch })
                .collect(),
            command_bytes: ledger.command_bytes,
            vertices: ledger.vertices,
        });
        progress.step();
    }
    Ok(ModelBytes {
        variant,
        resident_bytes,
        initial,
        steps,
    })
}

/// The traffic of a stream but for the view's, on each link.
fn on_links(ledger: &Ledger, stream: Stream, links: &[Link]) -> Vec<Traffic> {
    let of = |link: &Link| traffic_on(ledger, Some(*link), stream);
    links.iter().map(of).collect()
}

/// What drawing the first frame as it is committed would count but samples, which nobody draws.
fn tally(session: &mut Session<'_>) -> Result<Ledger, RunError> {
    session.set_view(0)?;
    let commands = session.commands();
    session.device_mut().queue().tally(&commands)?;
    Ok(session.device_mut().take_ledger())
}
