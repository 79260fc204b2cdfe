//! Forests of patches in a session.

use std::sync::Arc;

use crate::gpu::{Device, TargetId};
use crate::models::{Environment, Grove, GroveSample, GroveView, ResidentGrove};
use crate::run::RunError;
use crate::run::world::World;
use crate::scene::{GroveChoice, View};

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

/// How a frame's camera sees them.
pub(super) fn grove_view(seen: &View) -> GroveView {
    GroveView {
        clip_from_world: seen.clip_from_world,
        eye: seen.eye,
        focal_pixels: seen.pixels_per_metre_at_1m,
    }
}
