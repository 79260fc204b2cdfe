//! Painting the test tree of the painterly model.

use std::path::Path;

use criterion::Criterion;
use spinney::math::{Stream, Vec3};
use spinney::models::Painting;
use spinney::run::{Session, SessionOptions, Silent, World};
use spinney::scene::{PaintLook, PaintOptions, Scene};
use spinney::simplify::strokes::{PeelUntil, ShellOptions, peel, shells};

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
    for (name, points) in clouds() {
        group.bench_function(format!("peel_35_{name}/100000"), |bencher| {
            bencher.iter(|| peel(&points, PeelUntil::Hulls(35)));
        });
        group.bench_function(format!("shells_35_{name}/100000"), |bencher| {
            bencher.iter(|| shells(&points, ShellOptions::PUBLISHED));
        });
    }
    group.finish();
}

/// 100,000 points each: in a ball, in a box, and near the rim of a ball, as leaves are.
fn clouds() -> [(&'static str, Vec<Vec3>); 3] {
    const COUNT: usize = 100_000;
    let stream = Stream::new(1, 0);
    let within =
        |number: u64| Vec3::from_array([0, 1, 2].map(|axis| stream.signed(3 * number + axis)));
    let boxed: Vec<Vec3> = (0..).map(within).take(COUNT).collect();
    let in_ball = |least: f32| -> Vec<Vec3> {
        let points = (0..).map(within);
        let kept = points.filter(|point| (least..=1.0).contains(&point.length()));
        kept.take(COUNT).collect()
    };
    [
        ("ball", in_ball(0.0)),
        ("box", boxed),
        ("rim", in_ball(0.9)),
    ]
}
