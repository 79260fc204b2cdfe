//! The measure of parallax, on leaves of which it is known.

use std::sync::Arc;

use spinney::math::{Vec3, det};
use spinney::models::{CardLevel, Crown, Kind, ModelOptions, State};
use spinney::plant::{Foliage, LeafGroup, Material, NO_BRANCH, Plant, Prototype};
use spinney::report::{parallax_json, parallax_table, parallax_text};
use spinney::run::{
    FlowPixel, Parallax, ParallaxDistance, ParallaxOptions, ParallaxSubject, Silent, crown,
    parallax,
};
use spinney::scene::{CardCounts, CardOptions};

use crate::support::{OPTIONS, random_crown, with_faces};

fn subject(label: &str, kind: Kind, state: State, crown: Option<Arc<Crown>>) -> ParallaxSubject {
    ParallaxSubject {
        label: label.to_owned(),
        kind,
        model: OPTIONS,
        state,
        crown,
    }
}

/// A square leaf of `half` that faces 22.5° from +Z, so far behind the origin.
fn facing(half: f32, behind: f32) -> Arc<Crown> {
    let (sine, cosine) = det::sin_cos(22.5_f32.to_radians());
    let (outwards, right) = (Vec3::new(sine, 0.0, cosine), Vec3::new(cosine, 0.0, -sine));
    let at = |x: f32, y: f32| half * x * right + half * y * Vec3::Y - behind * outwards;
    let group = LeafGroup {
        name: "leaf".to_owned(),
        prototype: Prototype::Quad {
            texture_corners: Prototype::WHOLE_IMAGE,
        },
        material: Material::plain("leaf", [0.1, 0.4, 0.1]),
        positions: vec![at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)],
        owners: vec![NO_BRANCH],
    };
    let foliage = Foliage {
        groups: vec![group],
    };
    let plant = Plant::new("leaf", None, None, foliage).expect("sound parts");
    Arc::new(crown(plant, None))
}

const NEAR: ParallaxDistance = ParallaxDistance {
    name: "near",
    radii: 4.0,
};

fn measured(crown: &Arc<Crown>, subjects: &[ParallaxSubject], steps: u32) -> Parallax {
    let options = ParallaxOptions {
        side: 64,
        field_of_view: 45.0,
        steps,
        distances: vec![NEAR],
    };
    parallax(crown, subjects, OPTIONS, &options, &Silent).expect("memory suffices")
}

/// One step of 45°, as far sideways as the camera is away; all pixels of the leaf are equally deep.
#[test]
fn a_leaf_behind_moves_less_by_the_pinhole_formula() {
    let (leaf, behind) = (facing(1.0, 0.0), 0.7);
    let subjects = [
        subject("same", Kind::LodfSlots, State::FINEST, None),
        subject(
            "behind",
            Kind::Full,
            State::FINEST,
            Some(facing(2.0, behind)),
        ),
        subject("half", Kind::Full, State::FINEST, Some(facing(0.5, 0.0))),
    ];
    let found = measured(&leaf, &subjects, 1);
    let distance = 4.0 * 2.0_f64.sqrt();
    assert!((found.scales[0].metres - distance).abs() < 1e-6);
    assert!((found.scales[0].step - distance).abs() < 1e-6);
    let focal = 32.0 / det::tan_f64(22.5_f64.to_radians());
    let wanted = focal * distance * (1.0 / distance - 1.0 / (distance + f64::from(behind)));
    let [same, other, half] = &found.measures[..] else {
        panic!("three subjects from one distance");
    };
    assert_eq!(
        (same.missing, same.error.mean, same.error.most),
        (0, 0.0, 0.0)
    );
    assert_eq!(other.missing, 0);
    // Depths and corners are `f32`.
    assert!(
        (other.error.mean - wanted).abs() < 1e-2,
        "{} of {wanted}",
        other.error.mean
    );
    assert!((other.error.most - wanted).abs() < 1e-2);
    // A quarter of the pixels is still covered, as far as pixels are whole.
    let shown = 1.0 - half.missing as f64 / half.pixels as f64;
    assert!((shown - 0.25).abs() < 0.03, "{shown}");
    assert!(half.error.most < 1e-2, "it lies in the same plane");
    // The leaf's own centre is that of the foliage, beside which nothing moves.
    assert!(found.scales[0].parallax.most < 1e-2);
}

/// Two leaves, one behind the other: impostors lie where they do, pictures of both do not.
#[test]
fn impostors_move_as_their_leaves_and_pictures_of_the_whole_do_not() {
    let [near, far] = [facing(1.0, -0.8), facing(1.6, 0.8)];
    let groups = [near, far].map(|one| one.plant().foliage().groups[0].clone());
    let foliage = Foliage {
        groups: groups.into(),
    };
    let plant = Plant::new("leaves", None, None, foliage).expect("sound parts");
    let both = Arc::new(crown(plant, None));
    let is_card = |kind: &Kind| !kind.shows_leaves() && !kind.paints();
    let subjects = Kind::ALL.into_iter().filter(is_card);
    let subjects: Vec<ParallaxSubject> = subjects
        .map(|kind| ParallaxSubject {
            model: ModelOptions {
                cards: CardOptions {
                    levels: CardCounts::new(&[2]).expect("one level"),
                    texture: 64,
                    ..CardOptions::USUAL
                },
                ..OPTIONS
            },
            ..subject(&kind.label(), kind, State::Cards(CardLevel::FINEST), None)
        })
        .collect();
    let found = measured(&both, &subjects, 8);
    let all = found.scales[0].parallax.mean;
    assert!(all > 0.2, "{all}");
    for measure in &found.measures {
        let (label, error) = (&measure.label, measure.error.mean);
        let lost = measure.missing as f64 / measure.pixels as f64;
        if label.starts_with("impostors") {
            assert!(
                error < 0.05 * all && lost < 0.05,
                "{label}: {error} of {all}, {lost} lost"
            );
        } else {
            assert!(error > 0.5 * all, "{label}: {error} of {all}");
        }
        // One of eight steps holds a change of sprites.
        assert!(label != "sprites-nearest" || lost > 0.1, "{lost}");
    }
}

#[test]
fn every_model_shows_the_flow_of_its_leaves() {
    let mixed = with_faces(&random_crown(5, 14, 3));
    let kinds = Kind::SOUND.map(|kind| subject(&kind.label(), kind, State::FINEST, None));
    let found = measured(&mixed, &kinds, 2);
    let scale = &found.scales[0];
    assert!(
        scale.parallax.mean > 1.0 && scale.parallax.most <= scale.most,
        "{scale:?}"
    );
    for measure in &found.measures {
        assert_eq!(
            (measure.missing, measure.error.most),
            (0, 0.0),
            "{}",
            measure.label
        );
        assert_eq!(measure.flow, scale.flow);
    }
    let moves = scale
        .flow
        .pixels
        .iter()
        .filter(|pixel| matches!(pixel, FlowPixel::Moves(_)));
    assert!(moves.count() > 100);
    // Fewer leaves, which lie elsewhere, are told as what they are.
    let coarsest = State::Uniform {
        collapses: mixed.sequence().collapse_count(),
    };
    let few = [subject("few", Kind::LodfStamps, coarsest, None)];
    let few = measured(&mixed, &few, 2);
    assert!(few.measures[0].error.mean > 0.0 || few.measures[0].missing > 0);
    assert_eq!(
        few,
        measured(
            &mixed,
            &[subject(
                "few",
                Kind::LodfHost,
                State::Uniform {
                    collapses: mixed.sequence().collapse_count(),
                },
                None
            )],
            2
        ),
        "models of the same leaves move alike"
    );
}

#[test]
fn what_is_told_has_every_model_and_distance() {
    let crown = random_crown(2, 9, 2);
    let one = [subject("full", Kind::Full, State::FINEST, None)];
    let found = [measured(&crown, &one, 1)];
    let table = parallax_table(&found[0]);
    assert_eq!(table.columns.len(), 4);
    assert_eq!(table.rows.len(), 2);
    assert!(parallax_text(&found, 100).contains("full"));
    let json: serde_json::Value = serde_json::from_str(&parallax_json(&found)).expect("JSON");
    assert_eq!(json["schema"], "spinney.parallax/1");
    let model = &json["plants"][0]["models"][0];
    assert_eq!(
        (&model["model"], &model["distances"][0]["missing"]),
        (&"full".into(), &0.into())
    );
}
