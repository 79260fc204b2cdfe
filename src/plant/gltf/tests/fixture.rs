//! Foreign files, written piece by piece.

use super::super::*;
use crate::math::{Vec2, Vec3};
use crate::plant::Prototype;
use crate::plant::import::{ImportError, ImportOptions, Imported, import_bytes};
use serde_json::{Value, json};

/// A document under construction, with one buffer.
pub(super) struct Fixture {
    pub(super) json: Value,
    pub(super) bytes: Vec<u8>,
}

impl Fixture {
    /// A scene with a node for each mesh of one primitive that [`mesh`](Self::mesh) adds.
    pub(super) fn new() -> Self {
        Self {
            json: json!({
                "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }],
                "nodes": [], "meshes": [], "accessors": [], "bufferViews": [],
                "materials": [
                    { "name": "bark" },
                    { "name": "leaf", "alphaMode": "MASK", "alphaCutoff": 0.25 },
                ],
            }),
            bytes: Vec::new(),
        }
    }

    pub(super) fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list]
            .as_array_mut()
            .expect("a list of the fixture");
        list.push(value);
        list.len() - 1
    }

    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        self.push("bufferViews", view)
    }

    pub(super) fn floats(&mut self, kind: &str, lanes: usize, numbers: &[f32]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let count = numbers.len() / lanes;
        let accessor =
            json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind });
        self.push("accessors", accessor)
    }

    pub(super) fn indices(&mut self, component: u32, indices: &[u32]) -> usize {
        let bytes = indices.iter().flat_map(|index| {
            let size = match component {
                5121 => 1,
                5123 => 2,
                _ => 4,
            };
            index.to_le_bytes()[..size].to_vec()
        });
        let view = self.view(&bytes.collect::<Vec<u8>>());
        let count = indices.len();
        let accessor = json!({ "bufferView": view, "componentType": component, "count": count,
            "type": "SCALAR" });
        self.push("accessors", accessor)
    }

    pub(super) fn primitive(&mut self, name: &str, primitive: &Value) {
        let mesh = self.push("meshes", json!({ "name": name, "primitives": [primitive] }));
        let node = self.push("nodes", json!({ "mesh": mesh }));
        self.json["scenes"][0]["nodes"]
            .as_array_mut()
            .expect("the scene's list")
            .push(json!(node));
    }

    pub(super) fn mesh(
        &mut self,
        material: usize,
        positions: &[Vec3],
        uv: &[Vec2],
        indices: &[u32],
    ) {
        let positions: Vec<f32> = positions.iter().flat_map(|p| p.to_array()).collect();
        let uv: Vec<f32> = uv.iter().flat_map(|p| p.to_array()).collect();
        let positions = self.floats("VEC3", 3, &positions);
        let mut attributes = json!({ "POSITION": positions });
        if !uv.is_empty() {
            attributes["TEXCOORD_0"] = json!(self.floats("VEC2", 2, &uv));
        }
        let indices = self.indices(5123, indices);
        let name = format!("mesh {material}");
        self.primitive(
            &name,
            &json!({ "attributes": attributes, "indices": indices, "material": material }),
        );
    }

    /// Cards in a row, each with the whole image.
    pub(super) fn cards(&mut self, material: usize, count: usize) {
        let mut positions = Vec::new();
        let mut uv = Vec::new();
        let mut indices = Vec::new();
        for (card, x) in (0..count).zip([0.0, 2.0, 4.0, 6.0, 8.0]) {
            positions.extend(CARD.map(|corner| corner + x * Vec3::X));
            uv.extend(Prototype::WHOLE_IMAGE);
            let first = 4 * u32::try_from(card).expect("few cards");
            indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
        }
        self.mesh(material, &positions, &uv, &indices);
    }

    pub(super) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        container::join(json.to_string().as_bytes(), &self.bytes)
    }

    pub(super) fn import(&self) -> Imported {
        load(&self.glb(), &[]).expect("the fixture is sound")
    }

    pub(super) fn error(&self) -> String {
        load(&self.glb(), &[])
            .expect_err("the fixture is broken")
            .to_string()
    }
}

pub(super) const CARD: [Vec3; 4] = [
    Vec3::new(0.0, 0.0, 0.0),
    Vec3::new(1.0, 0.0, 0.0),
    Vec3::new(1.0, 1.0, 0.0),
    Vec3::new(0.0, 1.0, 0.0),
];

/// An open box of four quads around the y axis, with shared vertices: a piece of bark.
pub(super) fn bark() -> (Vec<Vec3>, Vec<u32>) {
    let ring = [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)];
    let positions = [0.0, 2.0]
        .iter()
        .flat_map(|&y| ring.map(|(x, z)| Vec3::new(x, y, z)));
    let indices = (0..4).flat_map(|side| {
        let next = (side + 1) % 4;
        [side, next, next + 4, side, next + 4, side + 4]
    });
    (positions.collect(), indices.collect())
}

pub(super) fn load(bytes: &[u8], names: &[&str]) -> Result<Imported, ImportError> {
    let options = ImportOptions {
        foliage: names.iter().map(|&name| name.to_owned()).collect(),
        ..ImportOptions::default()
    };
    import_bytes("tree.glb", bytes, None, &options)
}

pub(super) fn counts(imported: &Imported) -> (u64, u64, u64) {
    let report = &imported.report;
    (
        report.trunk_triangles,
        report.quad_leaves,
        report.other_leaves,
    )
}
