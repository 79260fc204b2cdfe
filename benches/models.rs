//! Changing detail, and sending a model to a fresh device.

use criterion::Criterion;
use spinney::gpu::Card;
use spinney::models::Kind;
use spinney::raster::{Counters, Options, TileSize};
use spinney::run::{Session, SessionOptions};

use crate::yew;

/// For each model and mode of a yew: a twentieth of the axis of detail there and back, and the
/// upload of everything.
pub(crate) fn bench(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("models");
    let world = yew::world();
    for kind in Kind::SOUND {
        let (name, mode) = kind.names();
        let scene = yew::scene(name, mode);
        let raster = Options {
            tile: TileSize::Side64,
            counters: Counters::Visible,
        };
        let options = SessionOptions {
            // One that every mode runs on.
            card: Card::named("gtx770").expect("a known card"),
            ..SessionOptions::of(&scene, raster).expect("known names")
        };
        let label = kind.label();
        group.bench_function(format!("upload_{label}/48160"), |bencher| {
            bencher.iter(|| Session::new(&scene, &world, &options));
        });
        if kind.has_levels() {
            let mut session = Session::new(&scene, &world, &options).expect("memory suffices");
            let mut frame = 0;
            group.bench_function(format!("commit_{label}/2376"), |bencher| {
                bencher.iter(|| {
                    frame = 1 - frame;
                    session.skip(frame)
                });
            });
        }
    }
    group.finish();
}
