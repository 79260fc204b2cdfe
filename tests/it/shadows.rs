//! Shadows: what they darken, what they cost, and whom they do not work for.

use std::path::Path;

use spinney::document::Document;
use spinney::gpu::Stream;
use spinney::models::{Kind, TERRAIN_GROUP, shows_foliage};
use spinney::raster::{Counters, Options, TileSize};
use spinney::run::{Frame, RunError, Session, SessionOptions, Silent, World};
use spinney::scene::{Scene, SceneError, SceneFile, to_toml};

const RASTER: Options = Options {
    tile: TileSize::Side32,
    counters: Counters::Visible,
};

/// A shrub on its ground with the light above it, with what a text adds.
fn text(added: &str) -> String {
    format!(
        "schema = \"spinney.scene/1\"\nsize = [64, 48]\n\
         [[tree]]\nspecies = \"scenes/species/pistacia_lentiscus.toml\"\n\
         [terrain]\nsize = 30\ncells = 4\namplitude = 0\n\
         [camera]\npath = [{{ eye = [0, 5, 9], target = [0, 1, 0] }}]\n\
         [light]\ndirection = [0.3, 1, 0]\n{added}\n"
    )
}

fn file(text: String) -> Result<SceneFile, SceneError> {
    SceneFile::parse(Document {
        file: "shrub.toml".to_owned(),
        text,
    })
}

fn scene(added: &str) -> Scene {
    file(text(added)).expect("a sound scene").scene
}

fn session<'w>(scene: &'w Scene, world: &'w World, kind: Kind) -> Result<Session<'w>, RunError> {
    let options = SessionOptions {
        kind,
        ..SessionOptions::of(scene, RASTER).expect("known names")
    };
    Session::new(scene, world, &options)
}

#[test]
fn shadows_darken_and_are_counted() {
    let (lit, shaded) = (scene(""), scene("[shadow]\nsize = 256\nextent = 9"));
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let world = World::build(&lit, folder, &Silent).expect("the species grows");
    let kind = Kind::LodfCluster;
    let draw = |scene: &Scene| -> [Frame; 2] {
        let mut session = session(scene, &world, kind).expect("memory suffices");
        [0, 0].map(|frame| session.frame(frame).expect("a frame"))
    };
    let ([lit_first, lit_again], [first, again]) = (draw(&lit), draw(&shaded));
    assert_eq!(first.image, again.image);

    // Light is taken away alone, and of the ground right below the crown most.
    let pixels = |frame: &Frame| frame.image.rgba.clone();
    let darker = pixels(&lit_first)
        .iter()
        .zip(&pixels(&first))
        .map(|(lit, shaded)| {
            assert!(shaded <= lit, "{shaded} where it was {lit}");
            u32::from(shaded < lit)
        })
        .sum::<u32>();
    assert!(darker > 300, "{darker} of {} bytes", 4 * 64 * 48);
    let mut session = session(&shaded, &world, kind).expect("memory suffices");
    session.frame(0).expect("a frame");
    let target = session.device().inspect_target(session.target());
    let target = target.expect("it exists");
    let ground = |x: u32, y: u32| {
        target
            .key(x, y)
            .is_some_and(|key| key.group == TERRAIN_GROUP)
    };
    // The ground before the eye lies in the light: it does not shade itself.
    for x in (0..64).filter(|&x| ground(x, 46)) {
        let at = 4 * (46 * 64 + x as usize);
        assert_eq!(pixels(&first)[at..at + 4], pixels(&lit_first)[at..at + 4]);
    }

    // One pass more: as many draws again, 128 B once, nothing while the camera stands.
    let bytes = |frame: &Frame| frame.ledger.stream(Stream::Upload).payload_bytes;
    assert_eq!(bytes(&first), bytes(&lit_first) + 128);
    assert_eq!(bytes(&again), bytes(&lit_again));
    assert_eq!(again.ledger.draws, 2 * lit_again.ledger.draws);
    assert_eq!(again.ledger.primitives, 2 * lit_again.ledger.primitives);
    assert!(again.ledger.visible_samples > lit_again.ledger.visible_samples);
    assert!(again.ledger.command_bytes > 2 * lit_again.ledger.command_bytes);
    let map = 4 * 256 * 256;
    let resident = |frame: &Frame| frame.ledger.resident_bytes;
    assert_eq!(resident(&first), resident(&lit_first) + map + 100 + 64);

    // All models cast the same shadows, but those that leave out what the camera does not see.
    for kind in [Kind::LodfStamps, Kind::LodfHost, Kind::VdfIndices] {
        let mut session = self::session(&shaded, &world, kind).expect("memory suffices");
        let frame = session.frame(0).expect("a frame");
        assert_eq!(frame.image_digest, first.image_digest, "{kind:?}");
    }
    let shaded = Scene {
        device: spinney::scene::DeviceChoice {
            card: "gtx770".to_owned(),
            ..shaded.device.clone()
        },
        ..shaded
    };
    let refused = self::session(&shaded, &world, Kind::LodfDevice);
    let message = refused.err().map(|error| error.to_string());
    let says = "[shadow] with lodf-device, which leaves out what the camera does not see, is not \
                supported by this version";
    assert_eq!(message.as_deref(), Some(says));
}

/// Impostors shade the ground where their leaves do, and one another: they stand where those are, and cast what
/// they show.
#[test]
fn impostors_shade_what_their_leaves_shade() {
    let cards = "[cards]\nlevels = [32]\ntexture = 128";
    let lit = scene(cards);
    let shaded = scene(&format!("{cards}\n[shadow]\nsize = 512\nextent = 9"));
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let world = World::build(&lit, folder, &Silent).expect("the species grows");
    // What each pixel shows, and whether it is darker for the shadows.
    let seen = |kind: Kind| -> Vec<(Option<u32>, bool)> {
        let mut before = session(&lit, &world, kind).expect("memory suffices");
        let before = before.frame(0).expect("a frame").image;
        let mut session = session(&shaded, &world, kind).expect("memory suffices");
        let after = session.frame(0).expect("a frame").image;
        let target = session.device().inspect_target(session.target());
        let target = target.expect("it exists");
        let pixels = before.rgba.as_chunks::<4>().0.iter();
        let pixels = pixels.zip(after.rgba.as_chunks::<4>().0).zip(0..);
        pixels
            .map(|((before, after), at)| {
                let key = target.key(at % 64, at / 64);
                (key.map(|key| key.group), before != after)
            })
            .collect()
    };
    let (leaves, cards) = (seen(Kind::LodfCluster), seen(Kind::Impostors));
    let ground = leaves.iter().zip(&cards).filter_map(|(leaf, card)| {
        let is_ground = leaf.0 == Some(TERRAIN_GROUP) && card.0 == leaf.0;
        is_ground.then_some([leaf.1, card.1])
    });
    let (mut either, mut both) = (0, 0);
    for dark in ground {
        either += u32::from(dark[0] || dark[1]);
        both += u32::from(dark[0] && dark[1]);
    }
    assert!(either > 40 && 10 * both > 9 * either, "{both} of {either}");
    // Of the crown a part lies in its own shadow, about as large as of the leaves.
    let [of_leaves, of_cards] = [&leaves, &cards].map(|seen| {
        let crown = seen
            .iter()
            .filter(|(group, _)| group.is_some_and(shows_foliage));
        let (mut all, mut dark) = (0, 0);
        for (_, is_dark) in crown {
            all += 1;
            dark += u32::from(*is_dark);
        }
        f64::from(dark) / f64::from(all)
    });
    println!("crown {of_cards} for {of_leaves}");
    assert!(of_leaves > 0.2 && (of_cards - of_leaves).abs() < 0.25);
}

#[test]
fn shadows_read_back_and_are_refused_where_they_cannot_be() {
    assert_eq!(scene("").shadow, None);
    let usual = scene("[shadow]").shadow.expect("it is asked for");
    assert_eq!((usual.size, usual.bias, usual.extent), (2048, 4.0, None));
    let asked = scene("[shadow]\nsize = 300\nbias = 0.5\nextent = 20");
    let again = file(to_toml(&asked)).expect("our own text").scene;
    assert_eq!(again, asked);
    assert_ne!(asked.digest(), scene("[shadow]").digest());
    assert_ne!(asked.digest(), scene("").digest());
    let refused = file(text("[shadow]\n[model]\nmode = \"device\"")).err();
    let message = refused.map(|error| error.to_string()).unwrap_or_default();
    let says = "`model.mode` \"device\" leaves out what the camera does not see";
    assert!(message.starts_with("shrub.toml:13:"), "{message}");
    assert!(message.contains(says), "{message}");
}
