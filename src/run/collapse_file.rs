//! A crown's collapses as bytes, for programs in any language.
//!
//! | bytes | what |
//! |---|---|
//! | 0–7 | `SPINNEYC` |
//! | 8–11 | `n`, the length of the header: `u32` |
//! | 12 to 12 + n | the header: JSON in UTF-8, with spaces at its end so that 12 + n is a multiple of 4 |
//! | from there on | the arrays that the header names, one after the other |
//!
//! All numbers are little-endian, 4 bytes each. The header:
//!
//! ```text
//! { "schema": "spinney.collapses/1", "name", "leaves", "collapses", "digest",
//!   "arrays": { NAME: { "offset", "count", "components", "type": "f32" | "u32" } },
//!   "groups": [ { "name", "first_leaf", "leaves", "texture_corners": [[u, v] × 4], "base_color", "alpha_cutoff" } ] }
//! ```
//!
//! `offset` counts bytes from the file's start, `count` elements of so many components. The arrays:
//!
//! | array | components | what |
//! |---|---|---|
//! | `vertices` | 3 × `f32` | metres, +Y up |
//! | `corners` | 4 × `u32` | the vertices of each leaf, by role; the original leaves, then one a collapse |
//! | `old` | 2 × `u32` | the leaves that each collapse takes away; it brings leaf `leaves` + its number |
//! | `cluster` | `u32` | the cluster of each leaf |
//! | `error` | `f32` | how far the leaf that a collapse brings may lie from those under it, in metres |
//!
//! After `c` collapses show those leaves below `leaves + c` that none of the first `c` collapses takes away.

use serde_json::{Map, Value, json};

use crate::models::Crown;

/// The first bytes of the file.
const MAGIC: &[u8; 8] = b"SPINNEYC";

/// The value of `schema` in the header.
pub const COLLAPSE_SCHEMA: &str = "spinney.collapses/1";

/// The collapses of a crown's quad leaves; the same crown is always the same bytes.
#[must_use]
pub fn collapse_file(crown: &Crown) -> Vec<u8> {
    let sequence = crown.sequence();
    let vertices = crown.vertices().iter().flat_map(|vertex| vertex.to_array());
    let corners = sequence.corners().iter().flatten().copied();
    let old = sequence
        .collapses()
        .iter()
        .flat_map(|collapse| collapse.old);
    let clusters = crown.clusters().cluster_of_leaf.iter().copied();
    let errors = crown.errors().of_collapses().iter().copied();
    let arrays = [
        Array::new("vertices", 3, "f32", vertices.map(f32::to_bits)),
        Array::new("corners", 4, "u32", corners),
        Array::new("old", 2, "u32", old),
        Array::new("cluster", 1, "u32", clusters),
        Array::new("error", 1, "f32", errors.map(f32::to_bits)),
    ];
    let mut first_leaf = 0;
    let groups = crown.plant().foliage().quad_groups();
    let groups: Vec<Value> = groups
        .map(|(group, texture_corners)| {
            let entry = json!({
                "name": group.name,
                "first_leaf": first_leaf,
                "leaves": group.leaf_count(),
                "texture_corners": texture_corners.map(|corner| corner.to_array()),
                "base_color": group.material.base_color,
                "alpha_cutoff": group.material.alpha_cutoff,
            });
            first_leaf += group.leaf_count();
            entry
        })
        .collect();
    let header = |start: usize| {
        let mut offset = start;
        let mut named = Map::new();
        for array in &arrays {
            let count = array.words.len() / array.components;
            let entry = json!({
                "offset": offset, "count": count, "components": array.components, "type": array.kind,
            });
            named.insert(array.name.to_owned(), entry);
            offset += 4 * array.words.len();
        }
        let mut text = json!({
            "schema": COLLAPSE_SCHEMA,
            "name": crown.plant().name(),
            "leaves": sequence.original_count(),
            "collapses": sequence.collapse_count(),
            "digest": sequence.digest().to_string(),
            "arrays": named,
            "groups": groups,
        })
        .to_string();
        while !(12 + text.len()).is_multiple_of(4) {
            text.push(' ');
        }
        text
    };
    // Offsets are part of the header whose length they follow from: they settle, since they only grow.
    let mut start = 0;
    let header = loop {
        let text = header(start);
        if 12 + text.len() == start {
            break text;
        }
        start = 12 + text.len();
    };
    let mut bytes = MAGIC.to_vec();
    bytes.extend(crate::math::index_u32(header.len()).to_le_bytes());
    bytes.extend(header.as_bytes());
    for array in &arrays {
        bytes.extend(array.words.iter().flat_map(|word| word.to_le_bytes()));
    }
    bytes
}

struct Array {
    name: &'static str,
    components: usize,
    kind: &'static str,
    words: Vec<u32>,
}

impl Array {
    fn new(
        name: &'static str,
        components: usize,
        kind: &'static str,
        words: impl Iterator<Item = u32>,
    ) -> Self {
        Self {
            name,
            components,
            kind,
            words: words.collect(),
        }
    }
}
