//! Painting the test tree of the painterly model.

use std::path::Path;

use criterion::Criterion;
use spinney::models::Painting;
use spinney::run::{Session, SessionOptions, Silent, World};
use spinney::scene::{PaintLook, PaintOptions, Scene};

/// Hulls, rows and branches of the tree, and a frame of all its strokes in each look and mode, from a
/// camera that goes to and fro, so that strokes are sorted anew.
pub(crate) fn bench(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("strokes");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/golden/strokes");
    let scene = |name: &str| {
        let path = folder.join(format!("{name}.toml"));
        let scene = Scene::read(&path).expect("a shipped scene");
        let world = World::build(&scene, &folder, &Silent).expect("it grows");
        (scene, world)
    };
    let (_, world) = scene("ternary_oil");
    let plant = &world.plants[0];
    group.bench_function("simplify/8748", |bencher| {
        bencher.iter(|| Painting::of(plant, &PaintOptions::USUAL));
    });
    for name in ["ternary_oil", "ternary_watercolour", "ternary_host"] {
        let (scene, world) = scene(name);
        let options = SessionOptions::exact(&scene).expect("known names");
        let mut session = Session::new(&scene, &world, &options).expect("memory suffices");
        let look = PaintLook::name(scene.painting.look);
        let mode = scene.model.mode.name();
        let mut frame = 0;
        group.bench_function(format!("frame_{look}_{mode}/43187"), |bencher| {
            bencher.iter(|| {
                frame = 1 - frame;
                session.frame(frame)
            });
        });
    }
    group.finish();
}
