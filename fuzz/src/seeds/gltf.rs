//! Plant files as other programs write them: a document each for the ways in which glTF says a mesh.

use serde_json::{Value, json};

/// Documents with binary bytes, a NUL byte between, and plain ones.
pub(super) fn foreign() -> Vec<(String, Vec<u8>)> {
    let binary = binary();
    let mut seeds = Vec::new();
    for (name, primitive, edit) in kinds() {
        let mut document = document(&primitive, binary.len());
        merge(&mut document, edit);
        let text = document.to_string();
        seeds.push((name.to_owned(), [text.as_bytes(), b"\0", &binary].concat()));
        if name == "card" {
            seeds.push((
                "card.glb".to_owned(),
                crate::gltf::glb(text.as_bytes(), &binary),
            ));
            let mut inline = document.clone();
            inline["buffers"][0]["uri"] = json!(format!(
                "data:application/octet-stream;base64,{}",
                base64(&binary)
            ));
            seeds.push(("card.gltf".to_owned(), inline.to_string().into_bytes()));
        }
    }
    seeds
}

/// Names, primitives, and what else the document says.
fn kinds() -> Vec<(&'static str, Value, Value)> {
    let flat = json!({ "POSITION": 0 });
    let mapped = json!({ "POSITION": 0, "TEXCOORD_0": 1, "NORMAL": 3 });
    let drawn = |mode: u32| json!({ "attributes": flat, "mode": mode, "material": 0 });
    vec![
        (
            "card",
            json!({ "attributes": mapped, "indices": 2, "material": 1 }),
            json!({}),
        ),
        (
            "unindexed",
            json!({ "attributes": flat, "mode": 4 }),
            json!({}),
        ),
        ("strip", drawn(5), json!({})),
        ("fan", drawn(6), json!({})),
        ("points", drawn(0), json!({})),
        ("lines", drawn(1), json!({})),
        (
            "sparse",
            json!({ "attributes": { "POSITION": 5 }, "indices": 4 }),
            json!({}),
        ),
        (
            "quantized",
            json!({ "attributes": { "POSITION": 6, "TEXCOORD_0": 7 }, "indices": 2, "material": 1 }),
            json!({ "extensionsUsed": ["KHR_mesh_quantization"],
                "extensionsRequired": ["KHR_mesh_quantization"] }),
        ),
        (
            "placed",
            json!({ "attributes": mapped, "indices": 2, "material": 1 }),
            json!({ "nodes": [
                { "children": [1, 2], "scale": [1, -2, 0.5], "name": "root" },
                { "mesh": 0, "translation": [1, 2, 3], "rotation": [0, 0.6, 0, 0.8], "name": "leaf" },
                { "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1] },
            ] }),
        ),
        (
            "material",
            json!({ "attributes": mapped, "indices": 2, "material": 0,
                "targets": [{ "POSITION": 0 }], "extras": { "a": [1, { "b": null }] } }),
            json!({ "materials": [{ "name": "leaf", "alphaMode": "BLEND", "doubleSided": true,
                "emissiveFactor": [0, 1, 0], "normalTexture": { "index": 0 },
                "extensions": { "KHR_materials_unlit": {} },
                "pbrMetallicRoughness": { "baseColorFactor": [0.2, 0.5, 0.1, 0.75],
                    "baseColorTexture": { "index": 0, "texCoord": 0 }, "metallicFactor": 0 } }],
                "textures": [{ "source": 0, "sampler": 0 }], "samplers": [{ "magFilter": 9728 }],
                "images": [{ "uri": "data:image/png;base64,iVBORw0KGgo=" }],
                "cameras": [{ "type": "perspective",
                    "perspective": { "yfov": 1, "znear": 0.1 } }],
                "skins": [{ "joints": [0] }] }),
        ),
    ]
}

fn document(primitive: &Value, bytes: usize) -> Value {
    let float = |view: usize, count: u32, kind: &str| json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind });
    json!({
        "asset": { "version": "2.0", "generator": "seed" }, "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "leaf" }],
        "meshes": [{ "name": "M", "primitives": [primitive] }],
        "materials": [{ "name": "bark" },
            { "name": "leaf", "alphaMode": "MASK", "alphaCutoff": 0.3 }],
        "accessors": [
            float(0, 8, "VEC3"),
            float(1, 8, "VEC2"),
            { "bufferView": 2, "componentType": 5123, "count": 12, "type": "SCALAR" },
            float(0, 8, "VEC3"),
            { "bufferView": 2, "byteOffset": 2, "componentType": 5121, "count": 3, "type": "SCALAR" },
            { "count": 4, "componentType": 5126, "type": "VEC3", "sparse": { "count": 2,
                "indices": { "bufferView": 2, "componentType": 5123 },
                "values": { "bufferView": 0 } } },
            { "bufferView": 3, "componentType": 5122, "normalized": true, "count": 8, "type": "VEC3" },
            { "bufferView": 3, "byteOffset": 2, "componentType": 5121, "count": 8, "type": "VEC2" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 96 },
            { "buffer": 0, "byteOffset": 96, "byteLength": 64 },
            { "buffer": 0, "byteOffset": 160, "byteLength": 24 },
            { "buffer": 0, "byteOffset": 0, "byteLength": 96, "byteStride": 8 },
        ],
        "buffers": [{ "byteLength": bytes }],
    })
}

/// Two cards beside each other: corners, texture coordinates, indices.
fn binary() -> Vec<u8> {
    let mut bytes = Vec::new();
    for x in [0.0, 2.0] {
        for corner in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0_f32]] {
            for number in [x + corner[0], corner[1], 0.0] {
                bytes.extend(number.to_le_bytes());
            }
        }
    }
    for _ in 0..2 {
        for number in [0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0_f32] {
            bytes.extend(number.to_le_bytes());
        }
    }
    for first in [0, 4] {
        for corner in [0, 1, 2, 0, 2, 3_u16] {
            bytes.extend((first + corner).to_le_bytes());
        }
    }
    bytes
}

/// Puts what `edit` says in the place of what `document` says.
fn merge(document: &mut Value, edit: Value) {
    if let (Some(document), Value::Object(edit)) = (document.as_object_mut(), edit) {
        document.extend(edit);
    }
}

fn base64(bytes: &[u8]) -> String {
    let letters = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let at = |index: usize| u32::from(three.get(index).copied().unwrap_or(0));
        let word = at(0) << 16 | at(1) << 8 | at(2);
        for place in 0..4 {
            let letter = (word >> (18 - 6 * place) & 63) as usize;
            text.push(if place <= three.len() {
                char::from(letters[letter])
            } else {
                '='
            });
        }
    }
    text
}
