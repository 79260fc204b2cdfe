//! Forests of patches in a session.

use std::sync::Arc;

use super::Session;
use crate::gpu::{Device, TargetId};
use crate::models::{Environment, Grove, GroveSample, GroveView, ResidentGrove, TreeState};
use crate::run::RunError;
use crate::run::world::World;
use crate::scene::{GroveChoice, View};
use crate::simplify::PrimitiveCounts;

/// Packs and sends the forests of patches.
pub(super) fn groves(
    world: &World,
    choice: GroveChoice,
    device: &mut Device,
    environment: &Environment,
    frame: TargetId,
) -> Result<Vec<ResidentGrove>, RunError> {
    let mut groves = Vec::with_capacity(world.groves.len());
    for grove in &world.groves {
        let samples = grove.samples.iter().filter_map(|sample| {
            let trunk = world.trunks[sample.crown].as_ref()?;
            Some(GroveSample {
                trunk: Arc::clone(trunk),
                placement: sample.placement,
            })
        });
        let samples: Vec<GroveSample> = samples.collect();
        let grove = Arc::new(Grove::new(&samples, grove.places.clone(), choice));
        groves.push(grove.upload(device, environment, frame)?);
    }
    Ok(groves)
}

impl Session<'_> {
    /// How many triangles and lines wood and needles show in a frame as it is committed.
    pub(super) fn wood(&self, frame: u32, states: &[TreeState]) -> [u64; 2] {
        let (mut triangles, mut lines) = (0, 0);
        let mut add = |times: u64, counts: &PrimitiveCounts| {
            triangles += times * (2 * counts.quads + counts.triangles);
            lines += times * counts.lines;
        };
        let trees = self.world.trees.iter().zip(&self.trunks);
        let mut meshes = 0;
        for ((tree, shown), state) in trees.zip(states) {
            // Those that strokes stand for are not drawn, those of groves are counted below.
            if let (Some(trunk), Some(shown)) = (&self.world.trunks[tree.crown], shown) {
                match shown.primitives() {
                    Some(counts) => add(1, &counts),
                    None => meshes += u64::from(self.trunk.triangle_count(trunk, state.trunk)),
                }
            }
        }
        let seen = grove_view(&self.scene.camera.at(frame, self.size));
        for grove in &self.groves {
            for (patches, counts) in grove.grove().shown(&seen) {
                add(u64::from(patches), &counts);
            }
        }
        [triangles + meshes, lines]
    }
}

/// How a frame's camera sees them.
pub(super) fn grove_view(seen: &View) -> GroveView {
    GroveView {
        clip_from_world: seen.clip_from_world,
        eye: seen.eye,
        focal_pixels: seen.pixels_per_metre_at_1m,
    }
}
