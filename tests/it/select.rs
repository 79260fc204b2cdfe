//! How detail is chosen: budgets of leaves, errors in pixels, bands that hold, prices and budgets of
//! bytes.

use std::sync::OnceLock;

use proptest::prelude::{ProptestConfig, any, prop_assert, prop_assert_eq};
use spinney::math::{Stream, Vec3, index_u32, index_usize};
use spinney::models::{
    Band, ByDistance, ByScreenError, BySilhouette, Criterion, Crown, Extent, Gather, Importance,
    Kind, LeafFormat, ModelOptions, Placement, Sight, State, level_with, select, settle, spread,
    weights, within_pixels,
};
use spinney::raster::{Counters, Options, TileSize};
use spinney::run::{Frame, Session, SessionOptions, StandingTree, World};
use spinney::scene::{
    Camera, CameraKey, CriterionName, DetailKind, ImageSize, LeafAmount, Mode, ModelName,
    Projection, Scene,
};

use crate::support::{
    OPTIONS, Stage, StageExt as _, birch_scene, birches, properties, random_crown, random_state,
};

fn crown() -> &'static Crown {
    &birches().crowns[0]
}

/// A birch, seen from a place.
fn sight(eye: Vec3) -> Sight {
    let key = CameraKey {
        frame: 0,
        eye,
        target: crown().center(),
    };
    let projection = Projection::Perspective {
        vertical_field_of_view: 40.0,
    };
    let camera = Camera::new(projection, 0.1, 1000.0, vec![key]).expect("sound");
    let size = ImageSize::new(640, 480).expect("within limits");
    Sight::of(&camera.at(0, size), &Placement::IDENTITY)
}

/// A place outside the crown by a seed, and its distance from the middle.
fn place(seed: u64) -> (Vec3, f32) {
    let mut draws = Stream::new(seed, 0).draws();
    let direction = Vec3::new(draws.signed(), draws.signed(), draws.signed());
    let distance = 5.0 + 60.0 * draws.unit();
    let eye = crown().center() + direction.normalize_or(Vec3::X) * distance;
    (eye, distance)
}

fn criteria(eye: Vec3) -> [Box<dyn Importance>; 4] {
    [
        Box::new(ByDistance {
            nearest: 5.0,
            farthest: 50.0,
        }),
        Box::new(ByDistance::across(crown(), eye)),
        Box::new(ByScreenError),
        Box::new(BySilhouette),
    ]
}

/// The collapses in each cluster of a variable state.
fn counts(state: &State) -> Vec<u32> {
    state.counts(crown().clusters())
}

properties! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    /// A budget of leaves is met exactly by every criterion, and a larger one takes no leaf away.
    #[test]
    fn budgets_of_leaves_are_exact_and_only_ever_add(
        seed in any::<u64>(),
        budget in 0_u32..9000,
        more in 1_u32..400,
    ) {
        let (crown, (eye, _)) = (crown(), place(seed));
        let sequence = crown.sequence();
        let exact = |leaves: u32| leaves.clamp(sequence.root_count(), sequence.original_count());
        for criterion in criteria(eye) {
            let states = [budget, budget + more].map(|leaves| {
                let state = spread(crown, leaves, &*criterion, &sight(eye));
                (state.leaf_count(crown.clusters()), exact(leaves), counts(&state))
            });
            for (shown, wanted, counts) in &states {
                prop_assert_eq!(shown, wanted, "{:?}", criterion);
                let clusters = crown.clusters().clusters.iter().zip(counts);
                for (cluster, &count) in clusters {
                    prop_assert!(count < cluster.original_count());
                }
            }
            let [(_, _, fewer), (_, _, more)] = states;
            prop_assert!(fewer.iter().zip(&more).all(|(fewer, more)| more <= fewer));
        }
    }

    /// No leaf is further off than permitted; one collapse more would be; more pixels and more
    /// distance never want more leaves.
    #[test]
    fn errors_in_pixels_are_kept_and_no_finer_than_need_be(
        seed in any::<u64>(),
        pixels in 0.05_f64..200.0,
        factor in 1.0_f64..4.0,
    ) {
        let (crown, (eye, distance)) = (crown(), place(seed));
        let sight_here = sight(eye);
        let state = within_pixels(crown, pixels, Extent::Variable, &sight_here);
        for ((cluster, count), bounds) in (0..).zip(counts(&state)).zip(crown.cluster_bounds()) {
            let curve = crown.errors().curve(cluster);
            let scale = sight_here.pixels_per_metre_at(bounds);
            prop_assert!(f64::from(curve[count as usize]) * scale <= pixels);
            let next = curve.get(count as usize + 1);
            prop_assert!(next.is_none_or(|&error| f64::from(error) * scale > pixels));
        }
        let visible = state.visible(crown.clusters());
        let originals = crown.sequence().original_count();
        for leaf in visible.into_iter().filter(|&leaf| leaf >= originals) {
            let cluster = crown.clusters().cluster_of_leaf[leaf as usize];
            let error = crown.errors().of_collapses()[(leaf - originals) as usize];
            let bounds = &crown.cluster_bounds()[cluster as usize];
            prop_assert!(f64::from(error) * sight_here.pixels_per_metre_at(bounds) <= pixels);
        }
        // Straight away from the eye, every point of the crown lies farther.
        let away = crown.center() + (eye - crown.center()) * ((distance + 20.0) / distance);
        for extent in [Extent::Uniform, Extent::Variable] {
            let here = within_pixels(crown, pixels, extent, &sight_here);
            let coarser = within_pixels(crown, pixels * factor, extent, &sight_here);
            let farther = within_pixels(crown, pixels, extent, &sight(away));
            for other in [&coarser, &farther] {
                let pairs = counts(other).into_iter().zip(counts(&here));
                prop_assert!(pairs.into_iter().all(|(other, here)| other >= here), "{:?}", extent);
            }
        }
        let uniform = within_pixels(crown, pixels, Extent::Uniform, &sight_here);
        let pairs = counts(&uniform).into_iter().zip(counts(&state));
        prop_assert!(pairs.into_iter().all(|(uniform, variable)| uniform <= variable));
    }

    /// What goes to and fro by less than the band changes nothing, and what stands is never further
    /// from what is wanted than the band: the law of distance, over the crown and by cluster.
    #[test]
    fn a_band_holds_what_goes_to_and_fro_within_it(seed in any::<u64>(), band in 0.001_f32..0.5) {
        let crown = crown();
        let (from, width) = (8.0, 30.0);
        let (eye, _) = place(seed);
        let toward = (eye - crown.center()).normalize_or(Vec3::X);
        let mut draws = Stream::new(seed, 9).draws();
        for extent in [Extent::Uniform, Extent::Variable] {
            let wanted = |eye: Vec3, shift: f32| {
                let nearest = from + shift * width;
                let law = Criterion { nearest, farthest: nearest + width, extent };
                select(crown, law, eye)
            };
            let settled = |present: &State, eye: Vec3| {
                let (finer, coarser) = (wanted(eye, band), wanted(eye, -band));
                settle(crown, present, wanted(eye, 0.0), &Band::Between { finer, coarser })
            };
            let mut present = wanted(eye, 0.0);
            for _ in 0..8 {
                let eye = crown.center() + toward * (70.0 * draws.unit());
                present = settled(&present, eye);
                let ranges = match extent {
                    Extent::Uniform => vec![crown.sequence().collapse_count(); 1],
                    Extent::Variable => crown.clusters().clusters.iter().map(|c| c.original_count() - 1).collect(),
                };
                let stands = |state: &State| match state {
                    State::Uniform { collapses } => vec![*collapses],
                    State::Variable { counts } => counts.clone(),
                    State::Cards(_) | State::Strokes(_) => Vec::new(),
                };
                let pairs = stands(&present).into_iter().zip(stands(&wanted(eye, 0.0)));
                for ((stands, wish), range) in pairs.zip(ranges) {
                    // Both are whole leaves.
                    let most = (f64::from(band) * f64::from(range)).ceil() + 1e-3;
                    prop_assert!(f64::from(stands.abs_diff(wish)) <= most);
                }
            }
            let swing = 0.99 * band * width;
            let eye = |side: f32| crown.center() + toward * (10.0 + 30.0 * draws_at(seed) + side * swing);
            let start = wanted(eye(draws_at(seed.wrapping_add(1))), 0.0);
            for turn in 0..6_u64 {
                prop_assert_eq!(&settled(&start, eye(draws_at(seed ^ (turn << 7)))), &start);
            }
        }
    }

    /// With a budget all clusters go over together, once enough leaves would stand elsewhere.
    #[test]
    fn budgets_stay_exact_within_a_band(seed in any::<u64>(), band in 0.0_f32..0.5, share in 0.0_f32..1.0) {
        let crown = random_crown(seed, 60, 9);
        let all = f64::from(crown.sequence().collapse_count());
        let mut present = random_state(&crown, seed);
        for step in 0..12 {
            let wanted = random_state(&crown, (seed ^ step).wrapping_add(1));
            let settled = settle(&crown, &present, wanted.clone(), &Band::Share(band * share));
            prop_assert!(settled == wanted || settled == present);
            let pairs = settled.counts(crown.clusters()).into_iter().zip(wanted.counts(crown.clusters()));
            let off: u32 = pairs.map(|(stands, wish)| stands.abs_diff(wish)).sum();
            prop_assert!(f64::from(off) <= f64::from(band * share) * all);
            present = settled;
        }
    }
}

/// A number from 0 to 1.
fn draws_at(seed: u64) -> f32 {
    Stream::new(seed, 11).draws().unit()
}

#[test]
fn steps_of_variable_detail_show_as_many_leaves_as_uniform_ones() {
    let (crown, (eye, _)) = (crown(), place(3));
    let all = crown.sequence().collapse_count();
    for step in [0, 1, 5, 9, 10] {
        let state = level_with(
            crown,
            step,
            10,
            &ByDistance::across(crown, eye),
            &sight(eye),
        );
        let done = index_u32(index_usize(u64::from(step) * u64::from(all) / 10));
        assert_eq!(state.collapse_count(), done, "step {step}");
    }
}

/// With two fifths of the leaves, the nearer half of the crown shows twice as many as the farther.
#[test]
fn criteria_put_leaves_where_they_say() {
    let crown = crown();
    let eye = crown.center() + Vec3::X * 15.0;
    let share = |criterion: &dyn Importance, side: &dyn Fn(Vec3) -> bool| {
        let leaves = crown.sequence().original_count() * 2 / 5;
        let state = spread(crown, leaves, criterion, &sight(eye));
        let clusters = crown.clusters().clusters.iter().zip(counts(&state));
        let on_side = clusters
            .zip(crown.cluster_centers())
            .filter(|(_, center)| side(**center))
            .map(|((cluster, count), _)| {
                (cluster.original_count() - count, cluster.original_count())
            });
        let (shown, there) = on_side.fold((0, 0), |(a, b), (c, d)| (a + c, b + d));
        f64::from(shown) / f64::from(there)
    };
    // Clusters that lie across the middle are on neither side.
    let quarter = 0.25 * 0.5 * crown.bounds().size().x;
    let near = |point: Vec3| point.x > crown.center().x + quarter;
    let far = |point: Vec3| point.x < crown.center().x - quarter;
    let distance = ByDistance::across(crown, eye);
    assert!(share(&distance, &near) > 2.0 * share(&distance, &far));
    let from = |metres: f32| {
        let eye = crown.center() + Vec3::X * metres;
        weights(crown, &ByScreenError, &sight(eye))
    };
    let mut nearer = from(12.0).into_iter().zip(from(24.0));
    assert!(nearer.all(|(near, far)| near >= far));
    let half = 0.5 * crown.bounds().size();
    let off_axis = |point: Vec3| {
        let at = (point - crown.center()) / half;
        at.y * at.y + at.z * at.z
    };
    let mut places: Vec<f32> = crown
        .cluster_centers()
        .iter()
        .map(|&at| off_axis(at))
        .collect();
    places.sort_by(f32::total_cmp);
    // The outer and the inner quarter of the clusters.
    let [inner, outer] = [1, 3].map(|quarters| places[quarters * places.len() / 4]);
    let rim = |point: Vec3| off_axis(point) >= outer;
    let middle = |point: Vec3| off_axis(point) < inner;
    let shares = [share(&BySilhouette, &rim), share(&BySilhouette, &middle)];
    assert!(shares[0] > 1.5 * shares[1], "{shares:?}");
}

properties! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    /// The price of a change is what the ledger then has, for every kind and from any state; what
    /// clusters cost each adds up where they say so.
    #[test]
    fn prices_are_what_the_ledger_says(seed in any::<u64>(), leaves in 2_u32..24, roots in 1_u32..5) {
        let crown = random_crown(seed, leaves, roots);
        let gather = if seed & 1 == 0 { Gather::Single } else { Gather::Regions };
        let format = LeafFormat::ALL[index_usize(seed >> 1 & 3)];
        for kind in Kind::LEAVES {
            let options = ModelOptions { gather, format, ..OPTIONS };
            let mut stage = Stage::at(kind, options, &crown, &State::FINEST, 4);
            stage.device.take_ledger();
            for step in 0..14 {
                let to = random_state(&crown, seed.wrapping_add(step));
                let price = stage.resident.price(&to);
                let before = stage.resident.state().clone();
                let each: Option<Vec<u64>> = (0..)
                    .zip(to.counts(crown.clusters()))
                    .map(|(cluster, count)| stage.resident.cluster_price(cluster, count))
                    .collect();
                crate::support::DeviceModel::commit(&mut stage, &to);
                prop_assert_eq!(stage.device.take_ledger().upload.payload_bytes, price, "{:?}", kind);
                prop_assert_eq!(stage.resident.price(&to), 0);
                let variable = |state: &State| matches!(state, State::Variable { .. });
                if let Some(each) = each.filter(|_| variable(&before) && variable(&to)) {
                    prop_assert_eq!(each.iter().sum::<u64>(), price, "{:?}", kind);
                }
            }
        }
    }
}

/// Two crowns of random leaves where the birches stand, and the birches' camera: quick to draw.
fn small_world() -> World {
    let tree = |crown, x: f32| StandingTree {
        crown,
        placement: Placement {
            position: Vec3::new(x, 3.5, 0.0),
            ..Placement::IDENTITY
        },
    };
    World::of(
        vec![random_crown(1, 300, 12), random_crown(2, 80, 5)],
        vec![tree(0, 0.0), tree(1, 2.0), tree(0, -3.0)],
    )
}

/// The birches with another model.
fn scene(change: impl Fn(&mut Scene)) -> Scene {
    let mut scene = birch_scene();
    change(&mut scene);
    scene
}

/// All frames of a scene in a small picture.
fn frames(scene: &Scene, world: &World) -> Vec<Frame> {
    let raster = Options {
        tile: TileSize::Side64,
        counters: Counters::Visible,
    };
    let mut options = SessionOptions::of(scene, raster).expect("known names");
    options.size = ImageSize::new(8, 6).expect("small");
    let mut session = Session::new(scene, world, &options).expect("memory suffices");
    (0..scene.frames)
        .map(|frame| session.frame(frame).expect("our device draws"))
        .collect()
}

/// Payload of uploads but for the view's.
fn sent(frame: &Frame) -> u64 {
    let view = frame.ledger.by_cause.get("view");
    frame.ledger.upload.payload_bytes - view.map_or(0, |share| share.payload_bytes)
}

fn modes() -> &'static [(ModelName, Mode)] {
    static MODES: OnceLock<Vec<(ModelName, Mode)>> = OnceLock::new();
    MODES.get_or_init(|| {
        let names = ModelName::ALL.iter().filter(|name| name.shows_leaves());
        let of = |name: &ModelName| {
            name.modes()
                .iter()
                .map(|mode| (*name, *mode))
                .collect::<Vec<_>>()
        };
        names.flat_map(of).collect()
    })
}

#[test]
fn budgets_of_bytes_are_never_exceeded_and_spent_as_far_as_they_reach() {
    let world = small_world();
    for &(name, mode) in modes() {
        for detail in [DetailKind::Uniform, DetailKind::Variable] {
            let free = scene(|scene| {
                (scene.model.name, scene.model.mode, scene.model.detail) = (name, mode, detail);
            });
            let unlimited = frames(&free, &world);
            assert!(unlimited.iter().all(|frame| frame.deferred.is_none()));
            let most = unlimited.iter().map(sent).max().unwrap_or(0);
            for budget in [1, 40, 400, most / 3 + 1, most.max(1)] {
                let mut limited = free.clone();
                limited.model.budget_bytes = Some(budget);
                let drawn = frames(&limited, &world);
                let case = format!("{name:?} {mode:?} {detail:?} with {budget}");
                for (frame, free) in drawn.iter().zip(&unlimited) {
                    assert!(sent(frame) <= budget, "{case}: {}", sent(frame));
                    let late = frame.states != free.states;
                    assert!(!late || frame.deferred > Some(0), "{case}");
                    // One that suffices for all changes nothing; but a device that selects by itself
                    // needs to be told what to show once there is a budget.
                    assert!(!late || budget < most || mode == Mode::Device, "{case}");
                }
                // The camera rests in frame 5.
                if budget == 400 && mode == Mode::Slots && detail == DetailKind::Variable {
                    let [before, resting] = [4, 5].map(|frame: usize| drawn[frame].deferred);
                    assert!(resting < before && sent(&drawn[5]) > 300, "{case}");
                }
                if budget == 1 && most > 0 {
                    let begun = &drawn[0].states;
                    assert!(drawn.iter().all(|frame| frame.states == *begun), "{case}");
                }
            }
        }
    }
}

/// A camera that swings less than the band: nothing is ever sent again.
#[test]
fn a_camera_that_swings_within_the_band_flips_nothing() {
    let swinging = |hysteresis| {
        scene(|scene| {
            let path = (0..10_u8).map(|frame| CameraKey {
                frame: u32::from(frame),
                eye: Vec3::new(0.5, 3.5, if frame % 2 == 0 { 18.0 } else { 19.0 }),
                target: Vec3::new(0.8, 3.6, 0.0),
            });
            let projection = scene.camera.projection();
            scene.camera = Camera::new(projection, 0.1, 100.0, path.collect()).expect("sound");
            scene.frames = 10;
            scene.model.hysteresis = hysteresis;
        })
    };
    for detail in [DetailKind::Uniform, DetailKind::Variable] {
        for criterion in [CriterionName::Paper, CriterionName::Distance] {
            let with = |hysteresis| {
                let mut scene = swinging(hysteresis);
                (scene.model.detail, scene.model.criterion) = (detail, criterion);
                frames(&scene, birches())
            };
            let flips = |frames: &[Frame]| frames.iter().filter(|frame| sent(frame) > 0).count();
            assert_eq!(flips(&with(0.0)), 9, "{detail:?} {criterion:?}");
            // A metre is a twenty-fifth of the way from `d_min` to `d_max`; within a budget, leaves
            // also move from cluster to cluster.
            let band = if criterion == CriterionName::Paper {
                0.06
            } else {
                0.3
            };
            assert_eq!(flips(&with(band)), 0, "{detail:?} {criterion:?}");
        }
    }
}

#[test]
fn a_scene_says_how_many_leaves_show() {
    let originals = u64::from(crown().sequence().original_count());
    let shown = |amount, detail| {
        let scene = scene(|scene| {
            (scene.model.amount, scene.model.detail) = (Some(amount), detail);
        });
        let drawn = frames(&scene, birches());
        drawn.iter().map(|frame| frame.leaves).collect::<Vec<_>>()
    };
    for detail in [DetailKind::Uniform, DetailKind::Variable] {
        assert_eq!(shown(LeafAmount::Budget(1234), detail), [2468; 7]);
        assert_eq!(
            shown(LeafAmount::Share(0.5), detail),
            [2 * (originals / 2); 7]
        );
        let roots = 2 * u64::from(crown().sequence().root_count());
        assert_eq!(shown(LeafAmount::Share(0.0), detail), [roots; 7]);
        let by_error = shown(LeafAmount::PixelError(40.0), detail);
        assert!(
            by_error[0] >= by_error[4] && by_error[4] > by_error[6] - 1,
            "{by_error:?}"
        );
    }
}
