//! Drawing.

use criterion::Criterion;
use spinney::math::Vec3;
use spinney::models::{Placement, TreeChange};
use spinney::raster::{Counters, Options, TileSize};
use spinney::run::{Session, SessionOptions, StandingTree, World};

use crate::yew;

/// A screen full of a yew: 96,320 triangles of leaves, and its trunk.
pub(crate) fn bench(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("raster");
    let (scene, world) = (yew::scene("full", "resident"), yew::world());
    for (name, counters) in [("visible", Counters::Visible), ("exact", Counters::Exact)] {
        let raster = Options {
            tile: TileSize::Side64,
            counters,
        };
        let options = SessionOptions::of(&scene, raster).expect("known names");
        let mut session = Session::new(&scene, &world, &options).expect("memory suffices");
        group.bench_function(format!("yew_{name}/1024x768"), |bencher| {
            bencher.iter(|| session.draw(0, TreeChange::default()));
        });
    }
    for trees in [1_u8, 10] {
        let world = row(trees);
        let raster = Options {
            tile: TileSize::Side64,
            counters: Counters::Visible,
        };
        let options = SessionOptions::of(&scene, raster).expect("known names");
        let mut session = Session::new(&scene, &world, &options).expect("memory suffices");
        group.bench_function(format!("yews_in_a_row_{trees}/1024x768"), |bencher| {
            bencher.iter(|| session.draw(0, TreeChange::default()));
        });
    }
    group.finish();
}

/// Yews behind one another, 7 m apart: the first hides most of the others. How frames grow up to 10⁸
/// triangles, and what a second thread does, is measured in `benches/peers`.
fn row(trees: u8) -> World {
    let crowns = yew::world().crowns;
    let standing = (0..trees).map(|tree| StandingTree {
        crown: 0,
        placement: Placement {
            position: Vec3::new(0.0, 0.0, -7.0 * f32::from(tree)),
            ..Placement::IDENTITY
        },
    });
    World::of(crowns, standing.collect())
}
