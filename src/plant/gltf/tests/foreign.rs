//! What is found in foreign files.

use super::super::*;
use super::fixture::{CARD, Fixture, bark, counts, load};
use crate::limits;
use crate::math::{Vec2, Vec3};
use crate::plant::import::{ImportOptions, ReportKind, import};
use crate::plant::{LeafGroup, NO_BRANCH, Prototype, Texture};
use serde_json::json;

#[test]
fn cards_are_leaves_and_masked_bark_is_wood() {
    let mut fixture = Fixture::new();
    let (positions, indices) = bark();
    fixture.json["materials"][0]["alphaMode"] = json!("MASK");
    fixture.mesh(0, &positions, &[], &indices);
    fixture.cards(1, 3);
    let imported = fixture.import();
    assert_eq!(counts(&imported), (8, 3, 0));
    let plant = &imported.plant;
    assert_eq!(plant.name(), "tree");
    let trunk = plant.trunk().unwrap();
    assert_eq!(
        (trunk.positions.len(), trunk.material.name.as_str()),
        (8, "bark")
    );
    for (normal, position) in trunk.normals.iter().zip(&trunk.positions) {
        assert!(
            normal.dot(position.with_y(0.0)) > 0.9,
            "{normal} at {position} points outwards"
        );
    }
    let group = &plant.foliage().groups[0];
    let texture_corners = Prototype::WHOLE_IMAGE;
    assert_eq!(group.prototype, Prototype::Quad { texture_corners });
    assert_eq!(group.leaf(1), CARD.map(|corner| corner + 2.0 * Vec3::X));
    assert_eq!(group.owners, [NO_BRANCH; 3]);
    assert!((group.material.alpha_cutoff - 0.25).abs() < 1e-9);
    assert_eq!(imported.report.of_kind(ReportKind::Guessed).count(), 3);
}

#[test]
fn names_decide_where_they_are_given() {
    let mut fixture = Fixture::new();
    fixture.cards(0, 2);
    fixture.cards(1, 3);
    let glb = fixture.glb();
    assert_eq!(counts(&load(&glb, &[]).unwrap()), (4, 3, 0));
    for name in ["bark", "mesh 0", "mesh 0#0"] {
        assert_eq!(counts(&load(&glb, &[name]).unwrap()), (6, 2, 0), "{name}");
    }
    assert_eq!(counts(&load(&glb, &["bark", "leaf"]).unwrap()), (0, 5, 0));
    let error = load(&glb, &["bark", "leaves"]).unwrap_err().to_string();
    assert!(
        error.contains("is named \"leaves\"") && error.contains("\"leaf\""),
        "{error}"
    );
}

#[test]
fn mirrored_nodes_flip_the_winding_and_the_roles() {
    let mut fixture = Fixture::new();
    let (positions, indices) = bark();
    fixture.mesh(0, &positions, &[], &indices);
    fixture.cards(1, 1);
    fixture.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    fixture.json["nodes"][1]["scale"] = json!([-1, 1, 1]);
    let plant = fixture.import().plant;
    let trunk = plant.trunk().unwrap();
    assert!(
        trunk
            .normals
            .iter()
            .zip(&trunk.positions)
            .all(|(normal, position)| normal.dot(position.with_y(0.0)) > 0.9),
        "computed normals point outwards"
    );
    let group = &plant.foliage().groups[0];
    let mirrored = CARD.map(|corner| corner * Vec3::new(-1.0, 1.0, 1.0));
    assert_eq!(group.leaf(0), [1, 0, 3, 2].map(|corner| mirrored[corner]));
    let texture_corners = [1, 0, 3, 2].map(|corner| Prototype::WHOLE_IMAGE[corner]);
    assert_eq!(group.prototype, Prototype::Quad { texture_corners });
}

#[test]
fn one_group_for_each_part_of_the_texture() {
    let mut fixture = Fixture::new();
    fixture.cards(1, 2);
    let left_half = Prototype::WHOLE_IMAGE.map(|corner| corner * Vec2::new(0.5, 1.0));
    fixture.mesh(1, &CARD, &left_half, &[0, 1, 2, 0, 2, 3]);
    let groups = fixture.import().plant.foliage().groups.clone();
    let leaves: Vec<usize> = groups.iter().map(LeafGroup::leaf_count).collect();
    assert_eq!(leaves, [2, 1]);
    assert_eq!([&*groups[0].name, &*groups[1].name], ["leaf", "leaf 2"]);
}

#[test]
fn too_many_parts_of_a_texture_take_the_nearest() {
    let mut fixture = Fixture::new();
    let parts = u16::try_from(limits::MATERIAL_GROUPS).unwrap() + 1;
    // The last part is nearest to the one before it, which occurs twice, as all but it do.
    for part in (0..parts).chain(0..parts - 1) {
        let at = Vec2::new(f32::from(part), 0.0);
        let corners = Prototype::WHOLE_IMAGE.map(|corner| corner + at);
        fixture.mesh(1, &CARD, &corners, &[0, 1, 2, 0, 2, 3]);
    }
    let imported = fixture.import();
    let groups = &imported.plant.foliage().groups;
    assert_eq!(groups.len(), limits::MATERIAL_GROUPS);
    assert_eq!(groups.last().unwrap().leaf_count(), 3);
    assert_eq!(imported.report.of_kind(ReportKind::Merged).count(), 1);
}

#[test]
fn other_leaves_keep_their_faces_and_nothing_is_lost() {
    let mut fixture = Fixture::new();
    fixture.cards(1, 5);
    let point = Vec3::new(0.5, 2.0, 0.0);
    let house = [CARD[0], CARD[1], CARD[2], CARD[3], point];
    let uv = house.map(|corner| Vec2::new(corner.x, corner.y));
    let faces = [0, 1, 2, 0, 2, 3, 3, 2, 4];
    fixture.mesh(1, &house, &uv, &faces);
    fixture.mesh(1, &house, &uv, &faces);
    fixture.mesh(1, &CARD[..3], &uv[..3], &[0, 1, 2]);
    let imported = fixture.import();
    assert_eq!(counts(&imported), (0, 5, 3));
    let groups = &imported.plant.foliage().groups;
    let leaves: Vec<usize> = groups.iter().map(LeafGroup::leaf_count).collect();
    assert_eq!(leaves, [5, 2, 1]);
    assert_eq!(groups[1].prototype.triangles_per_leaf(), 3);
    assert_eq!(groups[2].prototype.triangles_per_leaf(), 1);
}

#[test]
fn strips_fans_and_bare_vertices_are_triangles() {
    let corners: Vec<f32> = CARD.iter().flat_map(|corner| corner.to_array()).collect();
    for (mode, indices, wanted) in [
        (5, Some([0, 1, 3, 2]), [0, 1, 3, 1, 2, 3]),
        (6, Some([0, 1, 2, 3]), [1, 2, 0, 2, 3, 0]),
        (6, None, [1, 2, 0, 2, 3, 0]),
    ] {
        for component in [5121, 5123, 5125] {
            let mut fixture = Fixture::new();
            let position = fixture.floats("VEC3", 3, &corners);
            let mut primitive = json!({ "attributes": { "POSITION": position }, "mode": mode });
            if let Some(indices) = indices {
                primitive["indices"] = json!(fixture.indices(component, &indices));
            }
            fixture.primitive("m", &primitive);
            let plant = fixture.import().plant;
            assert_eq!(plant.trunk().unwrap().indices, wanted, "mode {mode}");
        }
    }
}

#[test]
fn what_is_left_out_is_counted() {
    let mut fixture = Fixture::new();
    fixture.cards(1, 1);
    let corners: Vec<f32> = CARD.iter().flat_map(|corner| corner.to_array()).collect();
    let position = fixture.floats("VEC3", 3, &corners);
    fixture.primitive(
        "p",
        &json!({ "attributes": { "POSITION": position }, "mode": 0 }),
    );
    fixture.primitive("n", &json!({ "attributes": { "NORMAL": position } }));
    fixture.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(position);
    fixture.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": position }]);
    fixture.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": {} });
    fixture.json["nodes"][0]["skin"] = json!(0);
    fixture.json["skins"] = json!([{ "joints": [0] }]);
    fixture.json["images"] = json!([{ "uri": "leaf.png" }]);
    fixture.json["textures"] = json!([{ "source": 0 }]);
    fixture.json["materials"][1]["pbrMetallicRoughness"] =
        json!({ "baseColorTexture": { "index": 0 } });
    fixture.json["materials"][1]["alphaMode"] = json!("BLEND");
    let text = fixture.import().report.to_string();
    for wanted in [
        "dropped: points (4, first at /meshes/1/primitives/0)",
        "dropped: primitives without POSITION (at /meshes/2/primitives/0)",
        "ignored: vertex colours (at /meshes/0/primitives/0/attributes/COLOR_0)",
        "ignored: morph targets (at /meshes/0/primitives/0/targets)",
        "not understood: extension EXT_mesh_gpu_instancing (at /nodes/0/extensions/",
        "ignored: skins: ",
        "missing: image \"leaf.png\": names the file",
        "guessed: blended materials",
    ] {
        assert!(text.contains(wanted), "{wanted} is not in\n{text}");
    }
}

#[test]
fn buffers_and_images_lie_in_the_document_or_beside_it() {
    let texture = Texture::new(1, 2, vec![1, 2, 3, 4, 5, 6, 7, 0]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut fixture = Fixture::new();
    fixture.cards(1, 1);
    fixture.json["materials"][1]["pbrMetallicRoughness"] =
        json!({ "baseColorTexture": { "index": 0 } });
    fixture.json["textures"] = json!([{ "source": 0 }]);
    let path = folder.path().join("birch.gltf");
    std::fs::write(folder.path().join("my tree.bin"), &fixture.bytes).unwrap();
    let png = encode_png(&texture);
    std::fs::write(folder.path().join("leaf.png"), &png).unwrap();
    let data = |bytes: &[u8]| format!("data:;base64,{}", base64(bytes));
    let mut digests = Vec::new();
    for (buffer, image) in [
        ("my%20tree.bin".to_owned(), "leaf.png".to_owned()),
        (data(&fixture.bytes), data(&png)),
    ] {
        fixture.json["buffers"] = json!([{ "uri": buffer, "byteLength": fixture.bytes.len() }]);
        fixture.json["images"] = json!([{ "uri": image }]);
        std::fs::write(&path, fixture.json.to_string()).unwrap();
        let imported = import(&path, &ImportOptions::default()).unwrap();
        let group = &imported.plant.foliage().groups[0];
        assert_eq!(group.material.texture.as_ref(), Some(&texture));
        digests.push(imported.plant.digest());
    }
    assert_eq!(digests[0], digests[1]);
    std::fs::write(folder.path().join("my tree.bin"), b"short").unwrap();
    let missing = import(folder.path(), &ImportOptions::default()).unwrap_err();
    assert!(
        missing.to_string().contains("not a regular file"),
        "{missing}"
    );
}

/// The reverse of the decoder, by long arithmetic over whole groups.
fn base64(bytes: &[u8]) -> String {
    let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let groups = bytes.chunks(3).map(|chunk| {
        let mut word = [0; 4];
        word[1..=chunk.len()].copy_from_slice(chunk);
        let word = u32::from_be_bytes(word);
        let text = [18, 12, 6, 0].map(|shift| char::from(digits[(word >> shift) as usize % 64]));
        text[..=chunk.len()].iter().collect::<String>()
    });
    groups.collect()
}

#[test]
fn wood_of_several_materials_takes_the_one_it_mostly_has() {
    let mut fixture = Fixture::new();
    let (positions, indices) = bark();
    fixture.json["materials"][1] = json!({ "name": "moss" });
    fixture.mesh(1, &CARD, &[], &[0, 1, 2]);
    fixture.mesh(0, &positions, &[], &indices);
    let imported = fixture.import();
    let trunk = imported.plant.trunk().unwrap();
    assert_eq!((trunk.positions.len(), trunk.triangle_count()), (11, 9));
    assert_eq!(trunk.material.name, "bark");
    let merged: Vec<_> = imported.report.of_kind(ReportKind::Merged).collect();
    assert_eq!((merged.len(), merged[0].count), (1, 1));
    assert_eq!(merged[0].place, "/meshes/0/primitives/0");
}

#[test]
fn small_integers_are_positions_only_where_the_extension_says_so() {
    let mut fixture = Fixture::new();
    let view = fixture.view(&[0, 0, 0, 0, 4, 0, 0, 0, 0, 4, 0, 0]);
    fixture.json["bufferViews"][view]["byteStride"] = json!(4);
    let accessor = json!({ "bufferView": view, "componentType": 5120, "count": 3, "type": "VEC3" });
    let position = fixture.push("accessors", accessor);
    fixture.primitive("m", &json!({ "attributes": { "POSITION": position } }));
    assert!(
        fixture
            .error()
            .contains("/accessors/0/componentType: is 5120")
    );
    fixture.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    fixture.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let plant = fixture.import().plant;
    let wanted = [Vec3::ZERO, 4.0 * Vec3::X, 4.0 * Vec3::Y];
    assert_eq!(plant.trunk().unwrap().positions, wanted);
    assert_eq!(plant.trunk().unwrap().normals, [Vec3::Z; 3]);
}
