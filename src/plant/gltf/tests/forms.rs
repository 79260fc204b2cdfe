//! The forms that leaves have in foreign files, and the forms that numbers are stored in.

use super::fixture::{CARD, Fixture, bark, counts, load};
use crate::math::{DVec3, Vec2, Vec3};
use crate::plant::Prototype;
use crate::plant::import::{ImportOptions, Reading, ReportKind, Unit, UpAxis, import_bytes};
use serde_json::json;

/// A strip of `steps` pieces, bent over its length.
fn strip(steps: u16) -> (Vec<Vec3>, Vec<u32>) {
    let positions = (0..=steps).flat_map(|step| {
        let along = f32::from(step);
        [0.0, 1.0].map(|z| Vec3::new(along, 2.0 - 0.1 * along * along, z))
    });
    let indices = (0..u32::from(steps)).flat_map(|step| {
        let first = 2 * step;
        [0, 2, 3, 0, 3, 1].map(|corner| first + corner)
    });
    (positions.collect(), indices.collect())
}

#[test]
fn crossed_cards_are_two_leaves_each() {
    let mut fixture = Fixture::new();
    let crossing = CARD.map(|corner| Vec3::new(0.5, corner.y, corner.x - 0.5));
    let positions: Vec<Vec3> = CARD.into_iter().chain(crossing).collect();
    let uv: Vec<Vec2> = Prototype::WHOLE_IMAGE.repeat(2);
    fixture.mesh(1, &positions, &uv, &[0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7]);
    let imported = fixture.import();
    assert_eq!(counts(&imported), (0, 2, 0));
    assert_eq!(imported.plant.foliage().groups[0].leaf(1), crossing);
}

#[test]
fn bent_strips_are_leaves_and_tubes_as_small_are_not() {
    let mut fixture = Fixture::new();
    for steps in [2, 3] {
        for _ in 0..2 {
            let (positions, indices) = strip(steps);
            fixture.mesh(1, &positions, &[], &indices);
        }
    }
    // A leaf of five corners: a card with a tip.
    let house = [CARD[0], CARD[1], CARD[2], CARD[3], Vec3::new(0.5, 2.0, 0.5)];
    fixture.mesh(1, &house, &[], &[0, 1, 2, 0, 2, 3, 3, 2, 4]);
    let (positions, indices) = bark();
    fixture.json["materials"][0]["alphaMode"] = json!("MASK");
    fixture.mesh(0, &positions, &[], &indices);
    let imported = fixture.import();
    assert_eq!(counts(&imported), (8, 0, 5), "{}", imported.report);
    let guessed: Vec<String> = imported
        .report
        .of_kind(ReportKind::Guessed)
        .map(ToString::to_string)
        .collect();
    assert_eq!(
        guessed[..2],
        [
            "guessed: material \"bark\" has alpha and 0 of 8 triangles are cards: taken as wood (at /materials/0)",
            "guessed: material \"leaf\" has alpha and 23 of 23 triangles are cards or other small leaves: taken as \
             foliage (at /materials/1)",
        ]
    );
}

#[test]
fn opaque_leaves_are_told_by_name_or_form() {
    let mut fixture = Fixture::new();
    fixture.json["materials"][1] = json!({ "name": "Leaves" });
    let (positions, indices) = bark();
    fixture.mesh(0, &positions, &[], &indices);
    fixture.cards(1, 2);
    assert_eq!(counts(&fixture.import()), (8, 2, 0));
    // By the node's name, where materials say nothing.
    fixture.json["materials"][1] = json!({ "name": "green" });
    assert_eq!(counts(&fixture.import()), (12, 0, 0));
    fixture.json["nodes"][1]["name"] = json!("Foliage.001");
    assert_eq!(counts(&fixture.import()), (8, 2, 0));
    // By form, with nothing but positions.
    let mut fixture = Fixture::new();
    fixture.json["materials"] = json!([{}, {}]);
    let (mut positions, mut indices) = bark();
    for card in [0.0, 3.0, 6.0, 9.0] {
        let first = u32::try_from(positions.len()).unwrap();
        positions.extend(CARD.map(|corner| corner + Vec3::new(4.0 + card, 0.0, 0.0)));
        indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
    }
    fixture.mesh(0, &positions, &[], &indices);
    let imported = fixture.import();
    assert_eq!(counts(&imported), (8, 4, 0));
    assert_eq!(imported.plant.trunk().unwrap().positions.len(), 8);
    // Wood that is a tube has its skeleton back.
    let skeleton = imported.plant.skeleton().unwrap();
    assert_eq!(skeleton.nodes.len(), 2);
    assert_eq!(skeleton.nodes[1].position, 2.0 * Vec3::Y);
    assert!((skeleton.nodes[1].radius - 2.0_f32.sqrt()).abs() < 1e-6);
}

#[test]
fn coordinates_may_be_small_integers_and_positions_sparse() {
    let mut fixture = Fixture::new();
    // Zeros without a view, of which three are replaced.
    let indices = fixture.view(&[1, 2, 3]);
    let corners: Vec<u8> = CARD[1..]
        .iter()
        .flat_map(|corner| corner.to_array())
        .flat_map(f32::to_le_bytes)
        .collect();
    let values = fixture.view(&corners);
    let position = fixture.push(
        "accessors",
        json!({ "componentType": 5126, "count": 4, "type": "VEC3", "sparse": { "count": 3,
            "indices": { "bufferView": indices, "componentType": 5121 },
            "values": { "bufferView": values } } }),
    );
    let uv: Vec<u8> = [0, u16::MAX, u16::MAX, u16::MAX, u16::MAX, 0, 0, 0]
        .into_iter()
        .flat_map(u16::to_le_bytes)
        .collect();
    let view = fixture.view(&uv);
    let uv = fixture.push(
        "accessors",
        json!({ "bufferView": view, "componentType": 5123, "normalized": true, "count": 4,
            "type": "VEC2" }),
    );
    let colors = fixture.floats("VEC4", 4, &[7.5; 16]);
    let order = fixture.indices(5123, &[0, 1, 2, 0, 2, 3]);
    fixture.primitive(
        "m",
        &json!({ "attributes": { "POSITION": position, "TEXCOORD_0": uv, "COLOR_0": colors },
            "indices": order, "material": 1 }),
    );
    fixture.json["materials"][1]["pbrMetallicRoughness"] =
        json!({ "baseColorTexture": { "index": 0 } });
    fixture.json["textures"] = json!([{ "source": 0 }]);
    fixture.json["images"] = json!([{ "uri": "gone.png" }]);
    let imported = fixture.import();
    let group = &imported.plant.foliage().groups[0];
    assert_eq!(group.leaf(0), CARD);
    let texture_corners = Prototype::WHOLE_IMAGE;
    assert_eq!(group.prototype, Prototype::Quad { texture_corners });
    assert_eq!(group.material.texture, None);
    assert_eq!(imported.report.of_kind(ReportKind::Missing).count(), 1);
    assert_eq!(
        imported.report.of_kind(ReportKind::Ignored).count(),
        1,
        "{}",
        imported.report
    );
}

#[test]
fn trees_far_from_the_origin_come_to_it_in_64_bits() {
    let mut fixture = Fixture::new();
    let (positions, indices) = bark();
    fixture.mesh(0, &positions, &[], &indices);
    fixture.cards(1, 1);
    for node in [0, 1] {
        fixture.json["nodes"][node]["translation"] = json!([500_000.0, 300.0, -5_000_000.0]);
    }
    let imported = fixture.import();
    let trunk = imported.plant.trunk().unwrap();
    assert_eq!(trunk.positions, positions);
    assert_eq!(imported.plant.foliage().groups[0].leaf(0), CARD);
    let moved = imported.report.of_kind(ReportKind::Moved).next().unwrap();
    let at = DVec3::new(500_000.0, 300.0, -5_000_000.0);
    let [x, y, z] = at.to_array();
    assert_eq!(
        moved.message,
        format!("the tree is moved to the origin from {x}, {y}, {z} m")
    );
    // Near it, nothing moves.
    for node in [0, 1] {
        fixture.json["nodes"][node]["translation"] = json!([2.0, 0.0, 0.0]);
    }
    let imported = fixture.import();
    assert_eq!(imported.report.of_kind(ReportKind::Moved).count(), 0);
    assert_eq!(imported.plant.trunk().unwrap().positions[0].x, 3.0);
}

#[test]
fn axis_and_unit_are_overruled() {
    let mut fixture = Fixture::new();
    fixture.mesh(0, &CARD, &[], &[0, 1, 2]);
    let options = ImportOptions {
        reading: Reading {
            format: None,
            up: Some(UpAxis::Z),
            unit: Some(Unit::Cm),
        },
        ..ImportOptions::default()
    };
    let plant = import_bytes("tree.glb", &fixture.glb(), None, &options)
        .unwrap()
        .plant;
    let trunk = plant.trunk().unwrap();
    let wanted = [Vec3::ZERO, 0.01 * Vec3::X, Vec3::new(0.01, 0.0, -0.01)];
    assert_eq!(trunk.positions, wanted);
    assert_eq!(trunk.normals, [Vec3::Y; 3]);
    assert!(load(&fixture.glb(), &[]).is_ok());
}
