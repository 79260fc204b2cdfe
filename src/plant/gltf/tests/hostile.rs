//! What is refused, and where the error points.

use super::fixture::{CARD, Fixture, counts, load};
use crate::math::{Vec2, Vec3};
use serde_json::json;

#[test]
fn hostile_values_are_refused_with_their_pointer() {
    let mut sound = Fixture::new();
    sound.cards(1, 2);
    assert_eq!(counts(&sound.import()), (0, 2, 0));
    for (pointer, value, wanted) in [
        (
            "/accessors/0/count",
            json!(4_000_000_000_u32),
            "/accessors/0/count: ",
        ),
        (
            "/accessors/0/count",
            json!(1_u64 << 60),
            "/accessors/0/count: ",
        ),
        ("/accessors/0/count", json!(-1), "tree.glb:1:"),
        (
            "/accessors/0/componentType",
            json!(5125),
            "/accessors/0/componentType: is 5125",
        ),
        (
            "/accessors/0/componentType",
            json!(77),
            "/accessors/0/componentType: wanted",
        ),
        (
            "/accessors/0/type",
            json!("VEC2"),
            "/accessors/0/type: is Vec2",
        ),
        (
            "/accessors/2/componentType",
            json!(5120),
            "/accessors/2/componentType: is 5120",
        ),
        (
            "/bufferViews/0/byteLength",
            json!(5000),
            "/bufferViews/0/byteLength: 5000",
        ),
        (
            "/bufferViews/0/byteOffset",
            json!(u32::MAX),
            "/bufferViews/0/byteLength: 96",
        ),
        (
            "/bufferViews/0/buffer",
            json!(1),
            "/bufferViews/0/buffer: names buffer 1",
        ),
        (
            "/meshes/0/primitives/0/indices",
            json!(9),
            "/indices: names accessor 9",
        ),
        (
            "/meshes/0/primitives/0/material",
            json!(9),
            "/material: names material 9",
        ),
        ("/meshes/0/primitives/0/mode", json!(9), "/mode: wanted"),
        ("/nodes/0/mesh", json!(9), "/nodes/0/mesh: names mesh 9"),
        (
            "/nodes/0/children",
            json!([0]),
            "/nodes/0/children/0: reaches node 0 again",
        ),
        (
            "/nodes/0/rotation",
            json!([0, 0, 0, 0]),
            "/nodes/0/rotation: ",
        ),
        (
            "/nodes/0/scale",
            json!([1e39, 1, 1]),
            "/nodes/0/scale: holds inf",
        ),
        (
            "/nodes/0/scale",
            json!([3e38, 1, 1]),
            "/attributes/POSITION: vertex ",
        ),
        (
            "/scenes/0/nodes/0",
            json!(5),
            "/scenes/0/nodes/0: names node 5",
        ),
        (
            "/asset/version",
            json!("1.0"),
            "/asset/version: version \"1.0\", wanted 2.0",
        ),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "/extensionsRequired/0: ",
        ),
        (
            "/materials/1/alphaCutoff",
            json!(-0.5),
            "/materials/1/alphaCutoff: is -0.5",
        ),
        (
            "/materials/1/alphaMode",
            json!("X"),
            "/materials/1/alphaMode: wanted",
        ),
    ] {
        let mut broken = Fixture {
            json: sound.json.clone(),
            bytes: sound.bytes.clone(),
        };
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let parent = broken.json.pointer_mut(parent).unwrap();
        match key.parse::<usize>() {
            Ok(index) if parent.is_array() => parent[index] = value,
            _ => parent[key] = value,
        }
        let error = broken.error();
        assert!(error.contains(wanted), "{pointer}: {error}");
    }
    let mut fixture = Fixture::new();
    fixture.mesh(0, &CARD, &[Vec2::ZERO; 3], &[0, 1, 2]);
    assert!(
        fixture
            .error()
            .contains("TEXCOORD has 3 elements, POSITION has 4")
    );
    let mut fixture = Fixture::new();
    fixture.mesh(0, &CARD, &[], &[0, 1, 4]);
    assert!(
        fixture
            .error()
            .contains("/accessors/1: entry 2 names vertex 4, but there are 4")
    );
    let mut fixture = Fixture::new();
    fixture.mesh(0, &[CARD[0], CARD[1], Vec3::NAN], &[], &[0, 1, 2]);
    assert!(fixture.error().contains("vertex 2 at [NaN, NaN, NaN]"));
}

#[test]
fn one_mesh_placed_too_often_is_refused_before_it_takes_memory() {
    let mut fixture = Fixture::new();
    // Without a view the positions cost nothing, so a small file can claim a lot.
    let accessor = json!({ "componentType": 5126, "count": 30_000_000, "type": "VEC3" });
    let position = fixture.push("accessors", accessor);
    for _ in 0..3 {
        fixture.primitive("m", &json!({ "attributes": { "POSITION": position } }));
    }
    let error = fixture.error();
    assert!(
        error.contains("60000000 triangle corners so far exceed the limit"),
        "{error}"
    );
}

#[test]
fn cut_off_at_every_byte_it_is_refused() {
    let mut fixture = Fixture::new();
    fixture.cards(1, 1);
    let glb = fixture.glb();
    for length in 0..glb.len() {
        let mut cut = glb[..length].to_vec();
        let error = load(&cut, &[]).unwrap_err().to_string();
        assert!(error.starts_with("tree.glb:"), "{length}: {error}");
        // With a header that admits the length, the chunks have to notice.
        if length >= 12 {
            cut[8..12].copy_from_slice(&u32::try_from(length).unwrap().to_le_bytes());
            let error = load(&cut, &[]).unwrap_err().to_string();
            assert!(error.starts_with("tree.glb:"), "{length}: {error}");
        }
    }
}
