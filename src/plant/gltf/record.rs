//! What glTF has no place for: skeleton, owners, prototypes, names, in `extras.spinney`.
//!
//! ```text
//! "extras": { "spinney": { "schema": "spinney.gltf/1", "name", "digest", "hidden",
//!     "skeleton": { "nodes", "branches" } | null,
//!     "trunk":    { "node", "material", "numbers" } | null,
//!     "groups": [ { "name", "prototype", "leaves", "node", "material",
//!                   "numbers", "triangles", "owners" } ] } }
//! ```
//!
//! `node` and `material` are glTF indices; the rest are buffer views, `null` where there would be no
//! byte. All numbers in them are little-endian, 4 bytes each: nodes are x, y, z, radius; branches
//! are bearer (2³² − 1 for none), level, first node, node count; owners are one number a leaf, as
//! in [`LeafGroup`](crate::plant::LeafGroup). `numbers` holds base colour and alpha cutoff, then
//! what the prototype states: texture coordinates, or a needle's diameter.
//!
//! What meshes show is read from the meshes. `digest` is that of the plant, `hidden` that of the
//! buffer views named here (domain `spinney.gltf/1`, each with its length, in the order above).

use serde::{Deserialize, Serialize};

pub(super) const SCHEMA: &str = "spinney.gltf/1";

/// Where a part of the record lies in the document.
pub(super) const POINTER: &str = "/extras/spinney";

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Envelope<T> {
    pub(super) spinney: Option<T>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Record {
    pub(super) schema: String,
    pub(super) name: String,
    pub(super) digest: String,
    pub(super) hidden: String,
    pub(super) skeleton: Option<SkeletonRecord>,
    pub(super) trunk: Option<TrunkRecord>,
    pub(super) groups: Vec<GroupRecord>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct SkeletonRecord {
    pub(super) nodes: Option<usize>,
    pub(super) branches: Option<usize>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct TrunkRecord {
    pub(super) node: Option<usize>,
    pub(super) material: usize,
    pub(super) numbers: Option<usize>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct GroupRecord {
    pub(super) name: String,
    pub(super) prototype: PrototypeKind,
    pub(super) leaves: usize,
    pub(super) node: Option<usize>,
    pub(super) material: usize,
    pub(super) numbers: Option<usize>,
    pub(super) triangles: Option<usize>,
    pub(super) owners: Option<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum PrototypeKind {
    Quad,
    Faces,
    Needle,
}

/// The corners of a quad leaf's two triangles.
pub(super) const QUAD_CORNERS: [u32; 6] = [0, 1, 2, 0, 2, 3];
