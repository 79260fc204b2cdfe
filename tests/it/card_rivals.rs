//! A whole crown as a few pictures: what rivals of impostors show, and what they take.

use std::sync::Arc;

use spinney::math::{Mat4, Quat, Vec3, det};
use spinney::models::{CardLevel, Crown, Kind, ModelOptions, Placement, State, View};
use spinney::plant::{Foliage, Plant};
use spinney::raster::Image;
use spinney::scene::CardOptions;
use spinney::simplify::CollapseSequence;
use spinney::testkit::Stage;

use crate::support::{OPTIONS, StageExt as _, descriptor, random_crown};

/// Pixels of a picture's side.
const SIDE: u32 = 96;

fn options(texture: u32) -> ModelOptions {
    ModelOptions {
        cards: CardOptions {
            texture,
            ..CardOptions::USUAL
        },
        ..OPTIONS
    }
}

/// Looks from +Z, as pictures were taken. (The stage's own view is a mirror, in which fronts are backs.)
fn from_in_front(stage: &mut Stage) {
    let view = View {
        clip_from_world: Mat4::from_scale(Vec3::new(0.7, 0.7, -0.3))
            * Mat4::from_translation(Vec3::new(0.0, 0.0, -1.6)),
        to_light: Vec3::new(0.6, 0.8, 0.0),
        light: Vec3::splat(0.8),
        ambient: Vec3::splat(0.3),
    };
    let environment = stage.environment;
    environment
        .set_view(&mut stage.device.queue(), &view)
        .expect("our device takes it");
}

/// The crown as a rival shows it, its pictures of so many texels a side.
fn stage(kind: Kind, crown: &Arc<Crown>, texture: u32) -> Stage {
    let model = kind.model(crown, options(texture));
    Stage::on(descriptor(), model.as_ref(), &State::FINEST, SIDE)
}

fn leaves(crown: &Arc<Crown>) -> Stage {
    Stage::at(Kind::Full, OPTIONS, crown, &State::FINEST, SIDE)
}

/// Turns the plant about the upright axis through the middle of its crown, by an angle in degrees.
fn turn(stage: &mut Stage, crown: &Crown, degrees: f32) {
    let (sine, cosine) = det::sin_cos(0.5 * degrees.to_radians());
    let rotation = Quat::from_xyzw(0.0, sine, 0.0, cosine);
    let middle = crown.plant().foliage().bounds().center();
    let placement = Placement {
        position: middle - rotation * middle,
        rotation,
        scale: 1.0,
    };
    let environment = stage.environment;
    environment
        .place(&mut stage.device.queue(), 0, &placement)
        .expect("there is room for one");
}

/// The mean difference of two pictures' channels, of 255.
fn difference(one: &Image, other: &Image) -> f64 {
    let pairs = one.rgba.iter().zip(&other.rgba);
    let sum: u64 = pairs.map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / one.rgba.len() as f64
}

/// All of them but one have a picture from +Z.
const FROM_IN_FRONT: [Kind; 6] = [
    Kind::AxialBillboard,
    Kind::FacingBillboard,
    Kind::DepthBillboard,
    Kind::Sprites,
    Kind::CrossedCards,
    Kind::HemiOctahedral,
];

/// From where a picture was taken it shows what is there, light and all: what is left is the texture, and
/// goes with its texels.
#[test]
fn from_its_own_side_a_picture_shows_the_leaves() {
    let crown = random_crown(5, 60, 3);
    let seen = |mut stage: Stage| {
        from_in_front(&mut stage);
        stage.draw()
    };
    let wanted = seen(leaves(&crown));
    for kind in FROM_IN_FRONT {
        let found = [8, 32, 128].map(|texture| {
            let picture = seen(stage(kind, &crown, texture));
            difference(&wanted, &picture)
        });
        assert!(
            found[0] > found[1] && found[1] > found[2],
            "{kind:?}: {found:?}"
        );
        assert!(found[2] < 0.2 * found[0], "{kind:?}: {found:?}");
    }
}

/// A billboard looks the same from everywhere; the others do not.
#[test]
fn billboards_look_the_same_from_all_sides() {
    let crown = random_crown(8, 40, 3);
    for kind in Kind::RIVALS {
        let mut stage = stage(kind, &crown, 64);
        let before = stage.draw();
        let changes = [45.0, 110.0, 180.0].map(|degrees| {
            turn(&mut stage, &crown, degrees);
            difference(&before, &stage.draw())
        });
        let is_billboard = kind.names().0 == "billboard";
        for change in changes {
            // What is turned is rounded, and what lies on an edge moves over it.
            assert_eq!(change < 0.5, is_billboard, "{kind:?}: {changes:?}");
        }
    }
}

/// Between two of the eight directions sprites do not change at all as the plant turns, but all at once
/// where another comes nearest; blended pictures change with every degree.
#[test]
fn sprites_pop_and_blends_do_not() {
    let crown = random_crown(8, 40, 3);
    let changes = |kind: Kind| {
        let mut stage = stage(kind, &crown, 64);
        let pictures: Vec<Image> = (0..10)
            .map(|step: i16| {
                turn(&mut stage, &crown, 18.0 + f32::from(step));
                stage.draw()
            })
            .collect();
        let pairs = pictures.windows(2);
        pairs
            .map(|pair| difference(&pair[0], &pair[1]))
            .collect::<Vec<f64>>()
    };
    let sprites = changes(Kind::Sprites);
    // From 22° to 23°.
    let pop = sprites[4];
    for (step, change) in sprites.iter().enumerate() {
        assert!(step == 4 || *change < 0.25 * pop, "{step}: {sprites:?}");
    }
    let blends = changes(Kind::Octahedral);
    assert!(
        blends.iter().all(|change| *change < 0.5 * pop),
        "{blends:?}"
    );
}

/// Half of all texels lie within two steps of the leaf that shows there, and nine tenths of those that
/// show one leaf and nothing else.
///
/// The others lie along the rims of leaves, which 60 leaves of a few pixels each have many of: a texel there,
/// and every smaller version of it, is as deep as the mean of all that it shows.
#[test]
fn depth_billboards_are_as_deep_as_the_leaves() {
    let crown = random_crown(5, 60, 3);
    let seen = |mut stage: Stage| {
        from_in_front(&mut stage);
        stage.draw();
        let target = stage.device.inspect_target(stage.target);
        let target = target.expect("the stage draws into it");
        let pixels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
        let pixel = |(x, y)| {
            let key = target.key(x, y)?;
            Some(((key.group, key.vertex / 4), target.depth(x, y)))
        };
        pixels.map(pixel).collect::<Vec<_>>()
    };
    let wanted = seen(leaves(&crown));
    // Whether all around a pixel is of the same leaf.
    let within = |pixel: usize| {
        let leaf = |pixel: usize| wanted.get(pixel).copied().flatten().map(|(leaf, _)| leaf);
        let rows = [
            pixel.wrapping_sub(SIDE as usize),
            pixel,
            pixel + SIDE as usize,
        ];
        let around = rows
            .into_iter()
            .flat_map(|row| [row.wrapping_sub(1), row, row + 1]);
        around.into_iter().all(|beside| leaf(beside) == leaf(pixel))
    };
    // How far depths are apart: half of all pixels, and nine tenths of those within a leaf, at most.
    let apart = |kind: Kind| {
        let found = seen(stage(kind, &crown, 512));
        let both = wanted.iter().zip(&found).enumerate();
        let mut apart: Vec<(f32, bool)> = both
            .filter_map(|(pixel, (a, b))| {
                Some(((a.as_ref()?.1 - b.as_ref()?.1).abs(), within(pixel)))
            })
            .collect();
        apart.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        assert!(apart.len() > 500, "{kind:?}: {} pixels", apart.len());
        let mut inner = apart.clone();
        inner.retain(|(_, within)| *within);
        [apart[apart.len() / 2].0, inner[inner.len() * 9 / 10].0]
    };
    // The stage is 1 / 0.3 m deep, and the crown about 2.5 m.
    let step = 0.3 * 2.5 / 255.0;
    let ([deep, within], [flat, _]) = (apart(Kind::DepthBillboard), apart(Kind::AxialBillboard));
    assert!(
        deep < 2.0 * step && within < 2.0 * step,
        "{deep}, {within} apart, a step is {step}"
    );
    assert!(flat > 20.0 * deep, "{deep} apart, a flat card {flat}");
}

/// Storage is what lies there, and one view more is what the next one costs.
#[test]
fn rivals_take_what_they_say() {
    let crown = random_crown(3, 12, 2);
    let bytes = Kind::RIVALS.map(|kind| {
        let model = kind.model(&crown, options(16));
        let stage = stage(kind, &crown, 16);
        let on_device = stage.device.resident_by_label();
        let cards = on_device
            .iter()
            .filter(|(label, _)| label.starts_with("card"));
        let held: u64 = cards.map(|(_, bytes)| bytes).sum();
        let storage = model.storage();
        assert_eq!(
            held,
            storage.shared_bytes + storage.instance_bytes,
            "{kind:?}"
        );
        assert_eq!(storage.host_bytes, model.host_bytes().len() as u64);
        let baked = model.baked().expect("all are baked");
        assert!(baked.readback.payload_bytes > 0 && baked.draws > 0);
        assert_eq!(stage.resident.price(&State::FINEST), 0);
        held
    });
    // A record, and 16 × 16 texels with their smaller versions, twice.
    let view = 88 + 2 * 4 * (256 + 64 + 16 + 4 + 1);
    assert_eq!(bytes, [1, 1, 1, 8, 2, 64, 64].map(|views| views * view));
}

/// No leaves, no cards, no error.
#[test]
fn a_bare_tree_has_no_cards() {
    let plant = Plant::new("bare", None, None, Foliage::default());
    let sequence = CollapseSequence::new(0, Vec::new(), Vec::new());
    let bare = Crown::new(Arc::new(plant.expect("sound")), sequence.expect("sound"));
    let bare = Arc::new(bare);
    for kind in Kind::RIVALS {
        let mut stage = stage(kind, &bare, 16);
        let empty = stage.draw();
        assert_eq!(stage.resident.card_triangles(), 0, "{kind:?}");
        assert!(empty.rgba.chunks(4).all(|pixel| pixel == &empty.rgba[..4]));
        assert_eq!(stage.resident.state(), &State::Cards(CardLevel::FINEST));
    }
}
