//! Drawing.

use criterion::Criterion;
use spinney::models::TreeChange;
use spinney::raster::{Counters, Options, TileSize};
use spinney::run::{Session, SessionOptions};

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
    group.finish();
}
