//! What is written comes back.

use super::super::*;
use super::fixture::{CARD, Fixture, bark, load};
use crate::math::{Vec2, Vec3};
use crate::plant::import::{ImportReport, ReportKind};
use crate::plant::{
    Branch, Foliage, LeafGroup, Material, Mesh, NO_BRANCH, Node, Plant, Prototype, Skeleton,
    Texture,
};
use serde_json::{Value, json};

/// A plant with one of everything.
fn own() -> Plant {
    let texture = Texture::new(2, 1, vec![9, 8, 7, 255, 1, 2, 3, 0]).expect("eight bytes");
    let material = |name: &str| Material {
        name: name.to_owned(),
        base_color: [0.1, 2.5, 0.0, 1.0],
        texture: Some(texture.clone()),
        alpha_cutoff: 0.3,
    };
    let node = |y: f32| Node {
        position: Vec3::new(0.1, y, -0.0),
        radius: 0.1 / (1.0 + y),
    };
    let branch = |bearer: Option<u32>, first_node: u32| Branch {
        bearer,
        level: u32::from(bearer.is_some()),
        first_node,
        node_count: 2,
    };
    let skeleton = Skeleton {
        nodes: [0.0, 1.0, 0.7, 2.0].map(node).to_vec(),
        branches: vec![branch(None, 0), branch(Some(1), 2)],
    };
    let (positions, indices) = bark();
    let trunk = Mesh {
        normals: vec![Vec3::Y; positions.len()],
        texture_coordinates: vec![Vec2::splat(0.1); positions.len()],
        positions,
        indices,
        material: Material::plain("bark", [0.3, 0.2, 0.1]),
    };
    let group = |name: &str, prototype: Prototype, positions: &[Vec3], owners: &[u32]| LeafGroup {
        name: name.to_owned(),
        prototype,
        material: material(name),
        positions: positions.to_vec(),
        owners: owners.to_vec(),
    };
    let texture_corners = Prototype::WHOLE_IMAGE.map(|corner| corner * 0.3);
    let faces = Prototype::Faces {
        texture_coordinates: vec![Vec2::ZERO, Vec2::X, Vec2::ONE],
        triangles: vec![[0, 1, 2]],
    };
    let needle = Prototype::Needle { diameter: 0.001 };
    let quad = Prototype::Quad { texture_corners };
    let groups = vec![
        group(
            "leaves",
            quad.clone(),
            &[CARD, CARD.map(|corner| corner + Vec3::Z)].concat(),
            &[0, NO_BRANCH],
        ),
        group("faces", faces, &CARD[..3], &[1]),
        group("needles", needle, &CARD, &[1, 1]),
        group("none", quad, &[], &[]),
    ];
    Plant::new("own", Some(skeleton), Some(trunk), Foliage { groups }).expect("a sound plant")
}

#[test]
fn what_is_written_comes_back_and_others_can_read_it() {
    let plant = own();
    let glb = export_glb(&plant).unwrap();
    assert_eq!(glb, export_glb(&plant).unwrap());
    let imported = load(&glb, &[]).unwrap();
    assert!(imported.report.native, "{}", imported.report);
    assert_eq!(imported.report.entries, []);
    assert_eq!(imported.plant, plant);
    assert_eq!(imported.plant.digest(), plant.digest());
    // Another reader, which checks the whole document.
    let other = ::gltf::Gltf::from_slice(&glb).unwrap();
    assert_eq!(other.nodes().count(), 4);
    assert_eq!(other.images().count(), 1, "equal textures are written once");
}

#[test]
fn an_empty_plant_comes_back_too() {
    let plant = Plant::new("", None, None, Foliage::default()).unwrap();
    let imported = load(&export_glb(&plant).unwrap(), &[]).unwrap();
    assert_eq!(imported.plant, plant);
}

#[test]
fn a_foreign_plant_is_the_same_from_its_first_import_on() {
    let mut fixture = Fixture::new();
    let (positions, indices) = bark();
    fixture.mesh(0, &positions, &[], &indices);
    fixture.cards(1, 3);
    fixture.mesh(1, &CARD[..3], &[], &[0, 1, 2]);
    fixture.json["nodes"][1]["rotation"] = json!([0.1, 0.2, 0.3, 0.9]);
    let first = fixture.import().plant;
    let again = load(&export_glb(&first).unwrap(), &[]).unwrap();
    assert!(again.report.native, "{}", again.report);
    assert_eq!(again.plant.digest(), first.digest());
}

#[test]
fn names_win_over_the_record_and_that_is_said() {
    let imported = load(&export_glb(&own()).unwrap(), &["leaves"]).unwrap();
    assert!(!imported.report.native && imported.plant.skeleton().is_none());
    assert_eq!(imported.report.quad_leaves, 2);
    let mut dropped = imported.report.of_kind(ReportKind::Dropped);
    assert!(dropped.any(|entry| entry.place == "/extras/spinney"));
}

/// The written file with its JSON changed.
fn edited(edit: impl Fn(&mut Value)) -> Vec<u8> {
    let glb = export_glb(&own()).expect("a small plant");
    let parts = container::split("own.glb", &glb, &mut ImportReport::default());
    let parts = parts.expect("our own file");
    let mut json: Value = serde_json::from_slice(parts.json).expect("our own JSON");
    edit(&mut json);
    container::join(
        json.to_string().as_bytes(),
        parts.binary.expect("our own bytes"),
    )
}

#[test]
fn small_edits_are_taken_and_reported() {
    let glb = edited(|json| {
        json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][0] = json!(0.75);
    });
    let imported = load(&glb, &[]).unwrap();
    assert!(imported.report.native, "{}", imported.report);
    assert_eq!(imported.report.of_kind(ReportKind::Edited).count(), 1);
    let trunk = imported.plant.trunk().unwrap();
    assert!((trunk.material.base_color[0] - 0.75).abs() < 1e-9);
    assert_eq!(imported.plant.skeleton(), own().skeleton());
}

#[test]
fn edits_that_break_the_record_fall_back_to_detection() {
    type Edit = fn(&mut Value);
    let edits: [(&str, Edit); 8] = [
        ("/nodes/1", |json| {
            json["nodes"][1]["translation"] = json!([0, 1, 0]);
        }),
        ("/extras/spinney", |json| {
            json["scenes"][0]["nodes"] = json!([0, 1]);
        }),
        ("/extras/spinney", |json| {
            json["extras"]["spinney"]["schema"] = json!("other/9");
        }),
        ("/extras/spinney", |json| {
            json["extras"]["spinney"]["groups"] = json!(3);
        }),
        ("/extras/spinney/groups/0", |json| {
            json["extras"]["spinney"]["groups"][0]["leaves"] = json!(7);
        }),
        ("/extras/spinney/groups/0/owners", |json| {
            json["extras"]["spinney"]["groups"][0]["owners"] = json!(999);
        }),
        ("/extras/spinney", |json| {
            let other = json["extras"]["spinney"]["groups"][2]["owners"].clone();
            json["extras"]["spinney"]["groups"][0]["owners"] = other;
        }),
        ("/extras/spinney/groups/0", |json| {
            let corners = json["meshes"][1]["primitives"][0]["attributes"]["POSITION"].clone();
            let accessor = corners.as_u64().expect("an index");
            json["accessors"][usize::try_from(accessor).expect("small")]["count"] = json!(4);
        }),
    ];
    for (number, (place, edit)) in edits.into_iter().enumerate() {
        let imported = load(&edited(edit), &[]);
        if number == 7 {
            // Now the indices pass the end of the positions, for any reader.
            assert!(
                imported.unwrap_err().to_string().contains("names vertex"),
                "{number}"
            );
            continue;
        }
        let imported = imported.unwrap();
        let edits: Vec<_> = imported.report.of_kind(ReportKind::Edited).collect();
        assert_eq!(edits.len(), 1, "{number}: {}", imported.report);
        assert_eq!(edits[0].place, place, "{number}: {}", imported.report);
        assert!(!imported.report.native, "{number}");
    }
}
