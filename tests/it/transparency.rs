//! Ways to draw the lines of forests that need no order, held against every fragment in its place.

use super::grove::{frames, scene, with, world};
use spinney::raster::{Blend, Image, ProbedFragment};
use spinney::run::{Session, SessionOptions, Silent, World, transparency_looks};
use spinney::scene::{GroveBlend, GroveChoice, Scene};

fn blended(blend: GroveBlend, layers: u32) -> GroveChoice {
    GroveChoice {
        levels: 4,
        blend,
        layers,
        ..GroveChoice::TRUTH
    }
}

/// The first frame.
fn drawn(choice: GroveChoice, world: &World) -> Image {
    let scene = Scene {
        frames: 1,
        ..with(choice)
    };
    let frame = frames(&scene, world).swap_remove(0);
    frame.image
}

/// By how much the channels of a pixel differ at most.
fn apart(one: &Image, other: &Image, pixel: usize) -> u8 {
    let channels = |image: &Image| image.rgba.as_chunks::<4>().0[pixel];
    let pairs = channels(one).into_iter().zip(channels(other));
    let apart = pairs.map(|(a, b)| a.abs_diff(b));
    apart.fold(0, u8::max)
}

/// How many pixels differ.
fn wrong(one: &Image, other: &Image) -> usize {
    let pixels = 0..one.rgba.len() / 4;
    pixels.filter(|&pixel| apart(one, other, pixel) > 0).count()
}

/// The depths of the lines that show at some pixels.
fn lines_at(world: &World) -> Vec<(usize, Vec<f32>)> {
    let scene = with(blended(GroveBlend::Sorted, 1));
    let options = SessionOptions::exact(&scene).expect("names that are known");
    let mut session = Session::new(&scene, world, &options).expect("memory suffices");
    let image = session.frame(0).expect("a sound frame").image;
    let mut found = Vec::new();
    for y in (0..image.height).step_by(4) {
        for x in (0..image.width).step_by(2) {
            let fragments = session.probe([x, y]).expect("a sound pass");
            let depths = |blend: Blend| {
                let of = move |one: &&ProbedFragment| one.blend == blend;
                let depths = fragments.iter().filter(of);
                depths.filter_map(|one| one.depths[0]).collect::<Vec<f32>>()
            };
            let opaque = depths(Blend::Opaque).into_iter().fold(1.0, f32::min);
            let mut lines = depths(Blend::Sorted);
            lines.retain(|depth| *depth < opaque);
            found.push(((y * image.width + x) as usize, lines));
        }
    }
    found
}

/// Where one line shows there is no order to get wrong; where none shows, nothing.
#[test]
fn a_line_alone_is_blended_as_any_other() {
    let world = world(&scene());
    let truth = drawn(blended(GroveBlend::Sorted, 1), &world);
    let lines = lines_at(&world);
    let few = |count| lines.iter().filter(move |(_, lines)| lines.len() == count);
    let counts = [few(0).count(), few(1).count()];
    assert!(counts.iter().all(|count| *count > 0), "{counts:?}");
    for (blend, rounding) in [
        (GroveBlend::Peeled, 0),
        (GroveBlend::Weighted, 1),
        (GroveBlend::Moments, 1),
    ] {
        let image = drawn(blended(blend, 1), &world);
        for (pixel, _) in few(0) {
            assert_eq!(apart(&image, &truth, *pixel), 0, "{blend:?} at {pixel}");
        }
        for (pixel, _) in few(1) {
            let by = apart(&image, &truth, *pixel);
            assert!(by <= rounding, "{blend:?} at {pixel}: {by}");
        }
        // And more lines are another matter.
        assert!(wrong(&image, &truth) > 0, "{blend:?}");
    }
}

/// As many layers as there are lines, none of them equally deep, are the truth to the last bit.
#[test]
fn enough_layers_are_the_truth() {
    let world = world(&scene());
    let truth = drawn(blended(GroveBlend::Sorted, 1), &world);
    let lines = lines_at(&world);
    let mut last = usize::MAX;
    for layers in [1, 2, 4, 32] {
        let image = drawn(blended(GroveBlend::Peeled, layers), &world);
        let mut enough = 0;
        for (pixel, lines) in &lines {
            let mut depths = lines.clone();
            depths.sort_by(f32::total_cmp);
            depths.dedup();
            if depths.len() == lines.len() && lines.len() <= layers as usize {
                enough += 1;
                assert_eq!(apart(&image, &truth, *pixel), 0, "{layers} at {pixel}");
            }
        }
        assert!(enough > 100, "{enough} of {}", lines.len());
        let wrong = wrong(&image, &truth);
        assert!(wrong <= last, "{layers}: {wrong} of {last}");
        last = wrong;
    }
}

/// Fragments that are there or not: of another noise, but as dark as the truth.
#[test]
fn hashed_lines_are_as_dark_on_the_whole() {
    let world = world(&scene());
    let mean = |image: &Image| {
        let sum: u64 = image.rgba.iter().map(|&byte| u64::from(byte)).sum();
        sum as f64 / image.rgba.len() as f64
    };
    let truth = drawn(blended(GroveBlend::Sorted, 1), &world);
    let hashed = drawn(blended(GroveBlend::Hashed, 1), &world);
    assert!(wrong(&hashed, &truth) > 50);
    let off = (mean(&hashed) - mean(&truth)).abs();
    assert!(off < 0.5, "{off} of 255");
}

/// The study finds what the paper does: nothing wrong with the truth, most with instancing alone, and the
/// same picture whoever sorts.
#[test]
fn the_study_holds_ways_against_the_truth() {
    let scene = Scene {
        frames: 1,
        ..with(GroveChoice {
            levels: 4,
            ..GroveChoice::PAPER
        })
    };
    let world = world(&scene);
    let options = SessionOptions::exact(&scene).expect("names that are known");
    let looks = transparency_looks(&scene, &world, &options, &Silent).expect("memory suffices");
    let of = |name: &str| {
        let look = looks.iter().find(|look| look.way.name == name);
        look.unwrap_or_else(|| panic!("no way is named {name:?}"))
    };
    for look in &looks {
        let other_samples = look.way.samples != of("truth").way.samples;
        assert_eq!(look.image.rgba.len(), 4 * look.differences.len());
        assert!(look.errors(8) <= look.errors(0));
        if look.is_truth() {
            assert_eq!(look.errors(0), 0, "{}", look.way.name);
        } else if !other_samples && look.way.choice.blend != GroveBlend::Peeled {
            assert_ne!(look.image, of("truth").image, "{}", look.way.name);
        }
    }
    let (host, device) = (
        of("packed, one level, sorted"),
        of("the same, device sorts"),
    );
    assert_eq!(host.image, device.image);
    assert!(host.frame.readback.payload_bytes > device.frame.readback.payload_bytes);
    assert!(of("naive").errors(0) > of("all three, keeps depth").errors(0));
    assert_eq!([of("naive").passes, of("weighted").passes], [1, 1 + 2 + 1]);
    assert_eq!(of("peeled, 16 layers").passes, 1 + 16 + 1);
    let alone = Scene {
        grove: None,
        ..scene
    };
    let none = transparency_looks(&alone, &world, &options, &Silent).expect("nothing is drawn");
    assert!(none.is_empty());
}
