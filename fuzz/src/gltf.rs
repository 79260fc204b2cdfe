//! Plant files and PNG files.

use std::path::Path;

use spinney::plant::gltf::export_glb;
use spinney::plant::import::{ImportOptions, import_bytes};
use spinney::report::{ImageFile, Picture};

/// Plant files: a `.glb`, a `.gltf` that holds its buffers, or, which mutates best, a document and
/// binary bytes with a NUL byte between, which become a `.glb`.
pub fn gltf(bytes: &[u8]) {
    let assembled;
    let file = match bytes.iter().position(|&byte| byte == 0) {
        Some(end) if !bytes.starts_with(b"glTF") => {
            assembled = glb(&bytes[..end], &bytes[end + 1..]);
            &assembled
        }
        _ => bytes,
    };
    for foliage in [vec![], vec!["leaf".to_owned()]] {
        let options = ImportOptions {
            foliage,
            ..ImportOptions::default()
        };
        match import_bytes("fuzz.glb", file, None, &options) {
            Ok(imported) => {
                for entry in &imported.report.entries {
                    _ = entry.to_string();
                }
                returns(&imported.plant);
            }
            Err(error) => _ = error.to_string(),
        }
    }
}

/// What is imported can be written, and comes back the same.
pub(crate) fn returns(plant: &spinney::plant::Plant) {
    let Ok(file) = export_glb(plant) else {
        return;
    };
    let again = import_bytes("again.glb", &file, None, &ImportOptions::default());
    match again {
        Ok(again) => assert_eq!(
            again.plant.digest(),
            plant.digest(),
            "{:?}",
            again.report.entries
        ),
        Err(error) => panic!("written, and refused: {error}"),
    }
}

/// PNG files: as a picture of a report, and as the texture of a plant.
pub fn png(bytes: &[u8]) {
    if let Err(error) = ImageFile::from_bytes(Path::new("fuzz.png"), bytes) {
        _ = error.to_string();
    }
    match Picture::from_png(Path::new("fuzz.png"), bytes) {
        Ok(picture) => {
            let png = picture.to_png().expect("a picture can be written");
            let again = Picture::from_png(Path::new("again.png"), &png).expect("just written");
            assert_eq!(again, picture);
        }
        Err(error) => _ = error.to_string(),
    }
    gltf(&textured(bytes));
}

/// A card whose texture is an image.
fn textured(png: &[u8]) -> Vec<u8> {
    let mut binary = Vec::new();
    for number in [
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0_f32,
    ] {
        binary.extend(number.to_le_bytes());
    }
    for number in [0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0_f32] {
        binary.extend(number.to_le_bytes());
    }
    binary.extend([0, 1, 2, 0, 2, 3, 0, 0]);
    let image = binary.len();
    binary.extend(png);
    let json = serde_json::json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "indices": 2, "material": 0,
        }] }],
        "materials": [{ "name": "leaf", "alphaMode": "MASK",
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "textures": [{ "source": 0 }],
        "images": [{ "bufferView": 3, "mimeType": "image/png" }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2" },
            { "bufferView": 2, "componentType": 5121, "count": 6, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 32 },
            { "buffer": 0, "byteOffset": 80, "byteLength": 6 },
            { "buffer": 0, "byteOffset": image, "byteLength": png.len() },
        ],
        "buffers": [{ "byteLength": binary.len() }],
    });
    glb(json.to_string().as_bytes(), &binary)
}

/// A document and a binary chunk as a `.glb`.
pub(crate) fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut file = b"glTF\x02\0\0\0".to_vec();
    let word = |file: &mut Vec<u8>, value: usize| {
        let value = u32::try_from(value).expect("inputs of fuzzers are small");
        file.extend(value.to_le_bytes());
    };
    let (json_end, end) = (
        json.len().next_multiple_of(4),
        binary.len().next_multiple_of(4),
    );
    word(&mut file, 12 + 8 + json_end + 8 + end);
    word(&mut file, json_end);
    file.extend(b"JSON");
    file.extend(json);
    file.resize(20 + json_end, b' ');
    word(&mut file, end);
    file.extend(b"BIN\0");
    file.extend(binary);
    file.resize(28 + json_end + end, 0);
    file
}
