//! Worlds whose leaves lie in the planes of their clusters.

use spinney::models::Kind;
use spinney::raster::{Counters, Options, TileSize};
use spinney::run::SessionOptions;
use spinney::scene::{CardCounts, CardOptions, Mode, ModelName};
use spinney::simplify::{PlaneOptions, cluster_planes, flattened, leaf_sites};

use crate::support::{birch_scene, birches};

fn cards(count: u32) -> CardOptions {
    CardOptions {
        levels: CardCounts::new(&[count]).expect("a few"),
        ..CardOptions::USUAL
    }
}

#[test]
fn a_world_is_flattened_plant_by_plant() {
    let world = birches();
    let flat = world.flattened(&cards(32));
    assert_eq!(flat.trees, world.trees);
    assert_eq!(flat.plants, world.plants);
    assert_eq!(flat.crowns.len(), world.crowns.len());
    for (flat, crown) in flat.crowns.iter().zip(&world.crowns) {
        let foliage = crown.plant().foliage();
        // What a scene says nothing of is what measured best.
        let clusters = cluster_planes(&leaf_sites(foliage), &PlaneOptions::to(32));
        assert_eq!(clusters.planes.len(), 32);
        let wanted = flattened(foliage, &clusters.into());
        assert_eq!(flat.plant().foliage(), &wanted);
        assert_eq!(flat.plant().trunk(), crown.plant().trunk());
        assert_eq!(flat.sequence().collapse_count(), 0);
        let leaves = crown.sequence().original_count();
        assert_eq!(flat.sequence().original_count(), leaves);
    }
}

/// More planes bring leaves nearer to where they were.
#[test]
fn leaves_are_moved_less_by_more_planes() {
    let world = birches();
    let mean = |count: u32| {
        let flat = world.flattened(&cards(count));
        let pairs = flat.crowns.iter().zip(&world.crowns);
        let moved = pairs.flat_map(|(flat, crown)| {
            let vertices = flat.original_vertices().iter();
            let ways = vertices.zip(crown.original_vertices());
            ways.map(|(flat, vertex)| f64::from(flat.distance(*vertex)))
        });
        let count = moved.clone().count();
        moved.sum::<f64>() / count as f64
    };
    let means = [1, 8, 64].map(mean);
    assert!(
        means.is_sorted_by(|fewer, more| *fewer > 1.5 * more),
        "{means:?}"
    );
}

/// There is no model of flat leaves: the world is flat, and its leaves are drawn.
#[test]
fn flat_leaves_are_drawn_like_any() {
    let mut scene = birch_scene();
    (scene.model.name, scene.model.mode) = (ModelName::Flattened, Mode::Resident);
    let raster = Options {
        tile: TileSize::Side64,
        counters: Counters::Visible,
    };
    let options = SessionOptions::of(&scene, raster).expect("known names");
    assert_eq!(options.kind, Kind::Full);
}
