//! EXR layers of a frame: what the picture shows, as data.

use super::super::{Layer, LayerSamples};
use crate::math::Vec3;
use crate::models::{Kind, LEAF_GROUP, ModelOptions, TERRAIN_GROUP};
use crate::run::{Frame, Session, World};

/// What stands in the layers `instance` and `leaf` where there is none.
pub const NO_NUMBER: u32 = u32::MAX;

/// The layers of the frame that the session drew last.
///
/// | layer | sample | meaning |
/// |---|---|---|
/// | `R`, `G`, `B` | `f32` | linear colour, the mean of a pixel's samples |
/// | `depth` | `f32` | from 0 (near) to 1 (far), as the depth test sees it, at the first sample |
/// | `instance` | `u32` | the tree, in the order of the scene, at the first sample; [`NO_NUMBER`] for background |
/// | `leaf` | `u32` | the leaf in the crown's sequence: originals first, then the new leaf of each collapse, then leaves of several faces; equal in all models and modes; [`NO_NUMBER`] for trunk and background |
/// | `normal.X`, `.Y`, `.Z` | `f32` | of a leaf: the unit normal that its diagonals give, or of its face, in world space, not turned to the viewer; 0 elsewhere |
///
/// `kind` and `options` are the session's.
///
/// # Panics
///
/// Never: a session keeps its target.
#[must_use]
pub fn frame_layers(
    session: &Session<'_>,
    world: &World,
    kind: Kind,
    options: ModelOptions,
    frame: &Frame,
) -> Vec<Layer> {
    let target = session.device().inspect_target(session.target());
    let target = target.expect("a session keeps its target");
    let colours = target.linear();
    let columns = 0..target.width();
    let places: Vec<[u32; 2]> = (0..target.height())
        .flat_map(|y| columns.clone().map(move |x| [x, y]))
        .collect();
    let keys: Vec<_> = places.iter().map(|&[x, y]| target.key(x, y)).collect();
    let depth = places.iter().map(|&[x, y]| target.depth(x, y)).collect();
    let instance = keys
        .iter()
        .map(|key| key.filter(|key| key.group != TERRAIN_GROUP))
        .map(|key| key.map_or(NO_NUMBER, |key| key.instance));

    let mut leaves = vec![NO_NUMBER; keys.len()];
    let mut normals = vec![Vec3::ZERO; keys.len()];
    // Tree by tree, so that only one table from vertices to leaves is held at a time.
    let mut shown: Vec<(u32, u32, usize)> = keys
        .iter()
        .enumerate()
        .filter_map(|(pixel, key)| key.map(|key| (key, pixel)))
        .filter(|(key, _)| key.group == LEAF_GROUP)
        .map(|(key, pixel)| (key.instance, key.vertex, pixel))
        .collect();
    shown.sort_unstable();
    for pixels in shown.chunk_by(|a, b| a.0 == b.0) {
        let Some(&(number, ..)) = pixels.first() else {
            continue;
        };
        let tree = world.trees.get(number as usize).zip(
            frame
                .states
                .get(number as usize)
                .map(|state| &state.foliage),
        );
        let Some((tree, state)) = tree else { continue };
        let crown = &world.crowns[tree.crown];
        let corners = crown.sequence().corners();
        let drawn = match kind {
            // What shows is not what should.
            Kind::LodfLiteral => kind.model(crown, options).drawn(state),
            _ => state.visible(crown.clusters()),
        };
        let mut table: Vec<(u32, u32)> = drawn
            .into_iter()
            .map(|leaf| (corners[leaf as usize][0], leaf))
            .collect();
        table.sort_unstable();
        for &(_, vertex, pixel) in pixels {
            let (plant, faces) = (crown.plant(), crown.faces());
            if let Some(face) = faces.of_vertex(vertex) {
                let [a, b, c] = faces.corners(plant, &face).unwrap_or_default();
                let [a, b, c] = [a, b, c].map(|corner| tree.placement.to_world(corner));
                leaves[pixel] = crown.sequence().record_count() + face.number;
                normals[pixel] = (b - a).cross(c - a).normalize_or_zero();
                continue;
            }
            let found = table.partition_point(|entry| entry.0 < vertex);
            let Some(&(_, leaf)) = table.get(found).filter(|entry| entry.0 == vertex) else {
                continue;
            };
            let world = corners[leaf as usize]
                .map(|corner| tree.placement.to_world(crown.vertices()[corner as usize]));
            leaves[pixel] = leaf;
            normals[pixel] = (world[2] - world[0])
                .cross(world[3] - world[1])
                .normalize_or_zero();
        }
    }

    let floats = |name: &str, samples: Vec<f32>| Layer {
        name: name.to_owned(),
        samples: LayerSamples::F32(samples),
    };
    let numbers = |name: &str, samples: Vec<u32>| Layer {
        name: name.to_owned(),
        samples: LayerSamples::U32(samples),
    };
    vec![
        floats("R", colours.iter().map(|colour| colour.x).collect()),
        floats("G", colours.iter().map(|colour| colour.y).collect()),
        floats("B", colours.iter().map(|colour| colour.z).collect()),
        floats("depth", depth),
        numbers("instance", instance.collect()),
        numbers("leaf", leaves),
        floats("normal.X", normals.iter().map(|normal| normal.x).collect()),
        floats("normal.Y", normals.iter().map(|normal| normal.y).collect()),
        floats("normal.Z", normals.iter().map(|normal| normal.z).collect()),
    ]
}
