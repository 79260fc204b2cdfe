//! Cards in place of leaves: what impostors show, and what they take.

use std::sync::Arc;

use spinney::math::{Mat4, Vec3, det, index_u32};
use spinney::models::{CardLevel, Crown, Kind, Model, ModelOptions, State, View};
use spinney::plant::{Foliage, LeafGroup, Material, NO_BRANCH, Plant, Prototype};
use spinney::raster::{Counters, Image, Instructions};
use spinney::scene::{CardCounts, CardDepth, CardOptions, CardOutline, CardSides, Transparency};
use spinney::simplify::{
    CollapseSequence, PlaneHierarchy, PlaneOptions, cluster_planes, flattened, leaf_sites,
};
use spinney::testkit::Stage;

use crate::support::{OPTIONS, StageExt, descriptor, random_crown};

/// Pixels of a picture's side.
const SIDE: u32 = 96;

/// A weight by which planes are parallel to leaves, also to two that lie one behind the other.
const WHATEVER_THE_DISTANCE: f32 = 1000.0;

fn options(levels: &[u32], texture: u32) -> ModelOptions {
    ModelOptions {
        cards: CardOptions {
            levels: CardCounts::new(levels).expect("descending"),
            texture,
            ..CardOptions::USUAL
        },
        ..OPTIONS
    }
}

/// A stage of a model of cards, seen along −z.
fn at(model: &dyn Model, level: u32) -> Stage {
    seen(Stage::on(
        descriptor(),
        model,
        &State::Cards(CardLevel(level)),
        SIDE,
    ))
}

/// The stage with a camera at z = 1.6 that looks along −z: depth is `0.3 (1.6 − z)`.
fn seen(mut stage: Stage) -> Stage {
    let view = View {
        clip_from_world: Mat4::from_scale(Vec3::new(0.7, 0.7, -0.3))
            * Mat4::from_translation(Vec3::new(0.0, 0.0, -1.6)),
        to_light: Vec3::new(0.48, 0.6, 0.64),
        light: Vec3::splat(0.8),
        ambient: Vec3::splat(0.3),
    };
    let mut queue = stage.device.queue();
    stage
        .environment
        .set_view(&mut queue, &view)
        .expect("its own device");
    stage
}

/// Leaves as leaves.
fn leaves(crown: &Arc<Crown>) -> Image {
    seen(Stage::at(Kind::Full, OPTIONS, crown, &State::FINEST, SIDE)).draw()
}

/// The crown with its leaves in the planes of so many clusters.
fn in_planes(crown: &Crown, count: u32) -> Arc<Crown> {
    let foliage = crown.plant().foliage();
    let sites = leaf_sites(foliage);
    let options = PlaneOptions::to(count);
    let clusters = cluster_planes(&sites, &options);
    let hierarchy = PlaneHierarchy::of(&sites, &clusters, options.orientation_weight);
    let foliage = flattened(foliage, &hierarchy.level(count));
    let plant = Plant::new("flat", None, None, foliage).expect("sound parts");
    Arc::new(Crown::new(Arc::new(plant), crown.sequence().clone()))
}

/// The mean difference of two pictures' channels, of 255.
fn difference(one: &Image, other: &Image) -> f64 {
    let pairs = one.rgba.iter().zip(&other.rgba);
    let sum: u64 = pairs.map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / one.rgba.len() as f64
}

/// Pixels of another colour.
fn changed(one: &Image, other: &Image) -> usize {
    let [one, other] = [one, other].map(|image| image.rgba.as_chunks::<4>().0);
    one.iter().zip(other).filter(|(a, b)| a != b).count()
}

/// An impostor is equivalent to its leaves moved into its plane: what is left is the texture, and goes
/// with its texels.
#[test]
fn impostors_come_near_to_flattened_leaves() {
    let crown = scattered_leaves(9, 0.2);
    let flat = leaves(&in_planes(&crown, 1));
    let found = [16, 64, 256].map(|texture| {
        let model = Kind::Impostors.model(&crown, options(&[1], texture));
        difference(&flat, &at(model.as_ref(), 0).draw())
    });
    assert!(found[0] > found[1] && found[1] > found[2], "{found:?}");
    assert!(found[2] < 0.2 * found[0], "{found:?}");
}

/// Two squares, the red one nearer; their plane's front is on the side of the origin, where the green one
/// is nearer.
///
/// ```text
///  origin      front │ back
///    ·          green │ │ red      ◀─ camera
/// ```
#[test]
fn from_behind_leaves_lie_in_the_other_order() {
    let crown = pair();
    let seen = [CardSides::Both, CardSides::Front].map(|sides| {
        let mut options = options(&[1], 64);
        options.cards.sides = sides;
        options.cards.orientation_weight = WHATEVER_THE_DISTANCE;
        let model = Kind::Impostors.model(&crown, options);
        let picture = at(model.as_ref(), 0).draw();
        (is_red_then_green(&picture), model.storage().shared_bytes)
    });
    assert_eq!(seen[0].0, (true, false), "red is nearer");
    assert_eq!(seen[1].0, (false, true), "as from in front");
    assert!(seen[1].1 < seen[0].1 && seen[0].1 < 2 * seen[1].1);
}

/// What is trimmed off shows nothing, and fewer samples are covered.
#[test]
fn trimmed_impostors_show_the_same_and_cover_less() {
    let crown = random_crown(3, 40, 2);
    let drawn = [CardOutline::Quad, CardOutline::Trimmed].map(|outline| {
        let mut options = options(&[6], 128);
        options.cards.outline = outline;
        let model = Kind::Impostors.model(&crown, options);
        let mut descriptor = descriptor();
        descriptor.raster.counters = Counters::Exact;
        let state = State::Cards(CardLevel::FINEST);
        let mut stage = seen(Stage::on(descriptor, model.as_ref(), &state, SIDE));
        let picture = stage.draw();
        let work = stage.device.take_ledger().work;
        (picture, work.expect("exact counters").covered)
    });
    let [(quads, by_quads), (trimmed, by_trimmed)] = drawn;
    // Corners elsewhere round elsewhere.
    assert!(difference(&quads, &trimmed) < 0.1);
    assert!(by_trimmed < by_quads, "{by_trimmed} of {by_quads}");
}

/// Children that lie on their parent's plane show what the parent does, but for texels: the swap at the
/// end changes less than half a level's way does.
#[test]
fn going_over_to_the_next_level_does_not_pop() {
    let crown = random_crown(7, 80, 4);
    let model = Kind::Impostors.model(&crown, options(&[8, 4, 2], 256));
    let mut stage = at(model.as_ref(), 0);
    let mut shown = |level: u32| {
        let state = State::Cards(CardLevel(level));
        let mut queue = stage.device.queue();
        stage
            .resident
            .commit(&mut queue, &state)
            .expect("its own device");
        stage.draw()
    };
    let [start, almost, next] = [0, 255, 256].map(&mut shown);
    let (switch, way) = (changed(&almost, &next), changed(&start, &next));
    assert!(switch * 2 < way, "{switch} of {way} pixels");
    assert!(2.0 * difference(&almost, &next) < difference(&start, &next));
}

/// A change of level sends its 4 bytes, and storage is what lies there.
#[test]
fn impostors_take_and_send_what_they_say() {
    for (seed, kind) in [
        (0, Kind::Impostors),
        (1, Kind::Impostors),
        (2, Kind::IndirectImpostors),
    ] {
        let crown = random_crown(seed, 12, 2);
        let mut options = options(&[4, 2], 16);
        (options.cards.layers, options.cards.sprites) = (64, 4);
        let model = kind.model(&crown, options);
        let mut stage = at(model.as_ref(), 0);
        let storage = model.storage();
        assert_eq!(storage.host_bytes, model.host_bytes().len() as u64);
        let labels = [
            "impostors",
            "leaf planes",
            "sprite places",
            "leaf maps",
            "leaf lists",
            "leaf squares",
            "card colours",
            "card normals",
            "card level",
        ];
        let on_device = stage.device.resident_by_label();
        let held = on_device
            .iter()
            .filter(|(label, _)| labels.contains(&label.as_str()));
        let held: u64 = held.map(|(_, bytes)| bytes).sum();
        assert_eq!(held, storage.shared_bytes + storage.instance_bytes);
        stage.device.take_ledger();
        let to = State::Cards(CardLevel(100));
        assert_eq!(stage.resident.price(&to), 4);
        let change = stage.resident.commit(&mut stage.device.queue(), &to);
        assert_eq!(change.expect("its own device").host_records, 1);
        let ledger = stage.device.take_ledger();
        assert_eq!(
            (ledger.upload.transfers, ledger.upload.payload_bytes),
            (1, 4)
        );
        let past = State::Cards(CardLevel(u32::MAX));
        stage
            .resident
            .commit(&mut stage.device.queue(), &past)
            .expect("its own device");
        assert_eq!(*stage.resident.state(), State::Cards(CardLevel(256)));
        let baked = model.baked().expect("baked");
        assert!(baked.draws > 0);
    }
}

/// Leaves of one size that lie in planes show through a map as they do in a picture, but for the turn of
/// sprites, and the more of them the nearer.
#[test]
fn maps_come_near_to_pictures() {
    let crown = leaves_in_a_plane(24);
    let flat = leaves(&crown);
    let found = [4, 16, 64].map(|sprites| {
        let mut options = options(&[1], 64);
        options.cards.sprites = sprites;
        options.cards.layers = 64;
        let model = Kind::IndirectImpostors.model(&crown, options);
        difference(&flat, &at(model.as_ref(), 0).draw())
    });
    assert!(found[0] > found[1] && found[1] > found[2], "{found:?}");
    assert!(found[2] < 0.25 * found[0], "{found:?}");
}

/// Where a texel of a map would have to hold more leaves than it has room for, none is lost: it is refused.
#[test]
fn maps_without_room_are_refused() {
    let crown = leaves_in_a_plane(24);
    let mut options = options(&[1], 64);
    (options.cards.map, options.cards.layers) = (8, 1);
    let model = Kind::IndirectImpostors.model(&crown, options);
    let refused = Stage::new(descriptor(), model.as_ref(), &State::FINEST, SIDE);
    let message = refused.expect_err("several leaves overlap").to_string();
    assert!(
        message.contains("there is room for 1: `cards.layers`"),
        "{message}"
    );
}

/// A red square at z = 0.6 and a green one at 0.4.
fn pair() -> Arc<Crown> {
    let square = |z: f32, color: [f32; 3]| {
        let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
        LeafGroup {
            name: "square".to_owned(),
            prototype: Prototype::Quad {
                texture_corners: Prototype::WHOLE_IMAGE,
            },
            material: Material::plain("leaf", color),
            positions: corners.map(|(x, y)| Vec3::new(x, y, z)).to_vec(),
            owners: vec![NO_BRANCH],
        }
    };
    let groups = vec![square(0.6, [0.9, 0.0, 0.0]), square(0.4, [0.0, 0.9, 0.0])];
    let plant = Plant::new("pair", None, None, Foliage { groups }).expect("sound parts");
    let corners = vec![[0, 1, 2, 3], [4, 5, 6, 7]];
    let sequence = CollapseSequence::new(2, corners, Vec::new()).expect("sound");
    Arc::new(Crown::new(Arc::new(plant), sequence))
}

/// So many rows and columns of squares that do not overlap, each turned and moved out of the plane z = 0
/// by up to `off`.
fn scattered_leaves(side: u32, off: f32) -> Arc<Crown> {
    let mut positions = Vec::new();
    for leaf in 0..side * side {
        let [column, row] = [leaf % side, leaf / side].map(|at| at as f32 / side as f32 - 0.45);
        let (turn, tilt) = (1.7 * leaf as f32, 0.3 * det::sin(2.3 * leaf as f32));
        let along = Vec3::new(det::cos(turn), det::sin(turn), tilt).normalize();
        let across = Vec3::Z.cross(along).normalize();
        let [along, across] = [along, across].map(|axis| axis * 0.6 / side as f32);
        let z = off * det::sin(5.1 * leaf as f32);
        let centre = Vec3::new(2.0 * column, 2.0 * row, z);
        positions.extend([
            centre - along - across,
            centre + along - across,
            centre + along + across,
            centre - along + across,
        ]);
    }
    of_quads(positions)
}

/// Long leaves of one size in the plane z = 0, turned all ways.
fn leaves_in_a_plane(count: u32) -> Arc<Crown> {
    let mut positions = Vec::new();
    for leaf in 0..count {
        let angle = 2.4 * leaf as f32;
        let along = Vec3::new(det::cos(angle), det::sin(angle), 0.0);
        let radius = 0.18 * (leaf as f32).sqrt();
        // One behind the other, as seen from both sides.
        let centre = radius * along + 1e-3 * leaf as f32 * Vec3::Z;
        let (along, across) = (0.25 * along, 0.06 * Vec3::Z.cross(along));
        positions.extend([
            centre - along - across,
            centre + along - across,
            centre + along + across,
            centre - along + across,
        ]);
    }
    of_quads(positions)
}

/// A crown of quads of one colour.
fn of_quads(positions: Vec<Vec3>) -> Arc<Crown> {
    let count = index_u32(positions.len() / 4);
    let group = LeafGroup {
        name: "leaves".to_owned(),
        prototype: Prototype::Quad {
            texture_corners: Prototype::WHOLE_IMAGE,
        },
        material: Material::plain("leaf", [0.2, 0.6, 0.1]),
        owners: vec![NO_BRANCH; positions.len() / 4],
        positions,
    };
    let corners = (0..count).map(|leaf| [4 * leaf, 4 * leaf + 1, 4 * leaf + 2, 4 * leaf + 3]);
    let sequence = CollapseSequence::new(count, corners.collect(), Vec::new());
    let groups = vec![group];
    let plant = Plant::new("quads", None, None, Foliage { groups }).expect("sound parts");
    Arc::new(Crown::new(Arc::new(plant), sequence.expect("sound")))
}

/// With relief a texel is as deep as the leaf that it shows; without, as the plane.
#[test]
fn relief_has_the_depth_of_leaves() {
    let crown = pair();
    let depths = [CardDepth::Paper, CardDepth::Relief].map(|depth| {
        let mut options = options(&[1], 64);
        options.cards.depth = depth;
        options.cards.orientation_weight = WHATEVER_THE_DISTANCE;
        let mut stage = at(Kind::Impostors.model(&crown, options).as_ref(), 0);
        stage.draw();
        let target = stage.device.inspect_target(stage.target).expect("there");
        target.depth(SIDE / 2, SIDE / 2)
    });
    // The plane lies at z = 0.5, the red square at 0.6; 255 steps of depth lie between both.
    assert!((depths[0] - 0.33).abs() < 1e-4, "{depths:?}");
    assert!((depths[1] - 0.30).abs() < 1e-3, "{depths:?}");
}

/// Eight pixels at a time keep what one at a time does.
#[test]
fn pictures_do_not_depend_on_instructions() {
    let crown = random_crown(6, 40, 2);
    for texture in [8, 128] {
        let model = Kind::Impostors.model(&crown, options(&[5, 2], texture));
        let [best, scalar] = [Instructions::Best, Instructions::Scalar].map(|instructions| {
            let mut stage = at(model.as_ref(), 77);
            stage.device.limit_instructions(instructions);
            stage.draw()
        });
        assert_eq!(best, scalar);
    }
}

/// Blended impostors are sent in order once a change of it, and the last drawn is on top; of one sample
/// coverage is the alpha test.
#[test]
fn transparency_has_three_ways() {
    let of = |transparency| {
        let mut options = options(&[2], 32);
        options.cards.transparency = transparency;
        let model = Kind::Impostors.model(&pair(), options);
        (at(model.as_ref(), 0), model.storage())
    };
    let [test, covered] = [Transparency::Test, Transparency::Coverage].map(|way| of(way).0.draw());
    assert_eq!(test, covered);
    let (mut blended, storage) = of(Transparency::Blend);
    assert_eq!(
        (storage.host_bytes, storage.instance_bytes),
        (12 * 2, 4 + 16 * 2)
    );
    let mut look_from = |z: f32| {
        blended.device.take_ledger();
        let mut queue = blended.device.queue();
        let eye = Vec3::new(0.0, 0.0, z);
        let looked = blended.resident.look_from(&mut queue, eye);
        looked.expect("its own device");
        let picture = blended.draw();
        let ledger = blended.device.take_ledger();
        (ledger.upload.payload_bytes, is_red_then_green(&picture))
    };
    assert_eq!(look_from(9.0).1, (true, false));
    assert_eq!(look_from(9.0), (0, (true, false)));
    assert_eq!(look_from(-9.0), (16 * 2, (false, true)));
}

/// Whether the middle of a picture is red, and whether it is green.
fn is_red_then_green(picture: &Image) -> (bool, bool) {
    let middle = 4 * (SIDE * SIDE / 2 + SIDE / 2) as usize;
    (picture.rgba[middle] > 90, picture.rgba[middle + 1] > 90)
}

/// No leaves, no cards, no error.
#[test]
fn a_bare_tree_has_no_impostors() {
    let plant = Plant::new("bare", None, None, Foliage::default());
    let sequence = CollapseSequence::new(0, Vec::new(), Vec::new());
    let crown = Crown::new(Arc::new(plant.expect("sound")), sequence.expect("sound"));
    let model = Kind::Impostors.model(&Arc::new(crown), options(&[4, 2], 16));
    let mut stage = at(model.as_ref(), 0);
    let empty = stage.draw();
    assert_eq!(stage.resident.card_triangles(), 0);
    assert!(empty.rgba.chunks(4).all(|pixel| pixel == &empty.rgba[..4]));
}
