//! Reading a plant exactly as it was written, by the record in its extras.

use super::accessor::{Elements, Reader};
use super::container::le_u32;
use super::placement::Placement;
use super::record::{
    Envelope, GroupRecord, POINTER, PrototypeKind, QUAD_CORNERS, Record, SCHEMA, SkeletonRecord,
    TrunkRecord,
};
use super::scene::Placed;
use super::surface::Surface;
use super::{Fault, Materials};
use crate::limits::{PLANT_FILE_BYTES, PLANT_LEAVES};
use crate::math::{Digester, Vec2, Vec3};
use crate::plant::import::{ImportReport, ReportKind};
use crate::plant::{Branch, Foliage, LeafGroup, Material, Mesh, Node, Plant, Prototype, Skeleton};
use gltf_json::Root;
use gltf_json::mesh::Mode;
use serde::Deserialize;
use serde_json::value::RawValue;
use std::collections::BTreeMap;

/// A document that may be one of ours, with its opened primitives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source<'r, 'a> {
    pub(super) root: &'a Root,
    pub(super) reader: &'r Reader<'a>,
    pub(super) placed: &'r [(Placed, Surface<'r>)],
}

/// The plant as it was written; `None`, with an entry in the report if there is a record at all,
/// where the record does not fit the document.
pub(super) fn read(
    source: &Source<'_, '_>,
    materials: &mut Materials<'_, '_>,
    report: &mut ImportReport,
) -> Option<Plant> {
    let record = record(source.root)?;
    // Entries of a failed attempt would be made again by the detection that follows.
    let mut attempt = report.clone();
    match read_record(record.get(), source, materials, &mut attempt) {
        Ok(plant) => {
            *report = attempt;
            report.native = true;
            Some(plant)
        }
        Err(fault) => {
            let message = format!("{}; leaves are looked for instead", fault.message);
            report.add(ReportKind::Edited, 1, fault.pointer, message);
            None
        }
    }
}

/// Whether a document has a record of the plant that it was made from.
pub(super) fn has_record(root: &Root) -> bool {
    record(root).is_some()
}

fn record(root: &Root) -> Option<Box<RawValue>> {
    let extras = root.extras.as_ref()?;
    let envelope: Envelope<Box<RawValue>> = serde_json::from_str(extras.get()).ok()?;
    envelope.spinney
}

fn read_record(
    json: &str,
    source: &Source<'_, '_>,
    materials: &mut Materials<'_, '_>,
    report: &mut ImportReport,
) -> Result<Plant, Fault> {
    #[derive(Deserialize)]
    struct Head {
        schema: String,
    }
    let unreadable = |error: serde_json::Error| Fault::new(POINTER, format!("unreadable: {error}"));
    let head: Head = serde_json::from_str(json).map_err(unreadable)?;
    if head.schema != SCHEMA {
        let message = format!("schema {:?}, wanted {SCHEMA:?}", head.schema);
        return Err(Fault::new(POINTER, message));
    }
    let record: Record = serde_json::from_str(json).map_err(unreadable)?;
    let mut reading = Reading {
        source,
        nodes: nodes_once(source, &record)?,
        hidden: Digester::new(SCHEMA),
        bytes_left: PLANT_FILE_BYTES,
    };
    let skeleton = match &record.skeleton {
        None => None,
        Some(skeleton) => Some(reading.skeleton(skeleton)?),
    };
    let trunk = match &record.trunk {
        None => None,
        Some(trunk) => Some(reading.trunk(trunk, materials, report)?),
    };
    let leaves = record
        .groups
        .iter()
        .fold(0_usize, |sum, group| sum.saturating_add(group.leaves));
    if leaves > PLANT_LEAVES {
        let message = format!("{leaves} leaves exceed the limit of {PLANT_LEAVES}");
        return Err(Fault::new(format!("{POINTER}/groups"), message));
    }
    let mut groups = Vec::new();
    for (index, group) in record.groups.iter().enumerate() {
        groups.push(reading.group(index, group, materials, report)?);
    }
    if reading.hidden.finish().to_string() != record.hidden {
        let message = "skeleton, owners or prototypes have changed since they were written";
        return Err(Fault::new(POINTER, message));
    }
    let plant = Plant::new(record.name, skeleton, trunk, Foliage { groups });
    let plant = plant.map_err(|error| Fault::new(POINTER, error.to_string()))?;
    let digest = plant.digest().to_string();
    if digest != record.digest {
        let message = format!(
            "digest {digest}, written as {}: taken as it is now",
            record.digest
        );
        report.add(ReportKind::Edited, 1, format!("{POINTER}/digest"), message);
    }
    report.trunk_triangles = plant
        .trunk()
        .map_or(0, |mesh| u64::from(mesh.triangle_count()));
    report.quad_leaves = plant.foliage().quad_count() as u64;
    report.other_leaves = plant.foliage().leaf_count() as u64 - report.quad_leaves;
    Ok(plant)
}

/// The placed primitives by their node, if these are exactly the nodes that the record names, each
/// with one primitive that stays in its place.
fn nodes_once(source: &Source<'_, '_>, record: &Record) -> Result<BTreeMap<usize, usize>, Fault> {
    let mut nodes = BTreeMap::new();
    for (index, (placed, _)) in source.placed.iter().enumerate() {
        let pointer = format!("/nodes/{}", placed.node);
        if nodes.insert(placed.node, index).is_some() {
            return Err(Fault::new(
                pointer,
                "has more than the one primitive it was written with",
            ));
        }
        if placed.placement != Placement::IDENTITY {
            return Err(Fault::new(
                pointer,
                "was moved, turned or scaled since it was written",
            ));
        }
    }
    let trunk = record.trunk.iter().filter_map(|trunk| trunk.node);
    let groups = record.groups.iter().filter_map(|group| group.node);
    let mut named: Vec<usize> = trunk.chain(groups).collect();
    named.sort_unstable();
    if !named.iter().eq(nodes.keys()) {
        let message = format!(
            "names {} nodes, but the scene places {} others or not the same",
            named.len(),
            nodes.len()
        );
        return Err(Fault::new(POINTER, message));
    }
    Ok(nodes)
}

struct Reading<'s, 'r, 'a> {
    source: &'s Source<'r, 'a>,
    nodes: BTreeMap<usize, usize>,
    hidden: Digester,
    bytes_left: u64,
}

impl<'r> Reading<'_, 'r, '_> {
    /// Refuses to read more in all than the largest file holds: a record may name one view often.
    fn spend(&mut self, elements: usize, bytes: u64) -> Result<(), Fault> {
        let wanted = (elements as u64).saturating_mul(bytes);
        match self.bytes_left.checked_sub(wanted) {
            Some(left) => {
                self.bytes_left = left;
                Ok(())
            }
            None => {
                let message = format!("wants {wanted} bytes, {} are left", self.bytes_left);
                Err(Fault::new(POINTER, message))
            }
        }
    }

    /// The words of a buffer view that only the record names.
    fn words(&mut self, view: Option<usize>, pointer: &str) -> Result<Vec<u32>, Fault> {
        let bytes = match view {
            None => &[],
            Some(view) => self.source.reader.buffers().view(view, pointer)?.0,
        };
        self.spend(bytes.len(), 1)?;
        self.hidden.bytes(bytes);
        if bytes.len() % 4 != 0 {
            let message = format!("has {} bytes, wanted words of 4", bytes.len());
            return Err(Fault::new(pointer, message));
        }
        Ok(bytes.chunks_exact(4).map(le_u32).collect())
    }

    fn skeleton(&mut self, record: &SkeletonRecord) -> Result<Skeleton, Fault> {
        let pointer = format!("{POINTER}/skeleton");
        let nodes = self.words(record.nodes, &format!("{pointer}/nodes"))?;
        let branches = self.words(record.branches, &format!("{pointer}/branches"))?;
        if nodes.len() % 4 != 0 || branches.len() % 4 != 0 {
            return Err(Fault::new(pointer, "records of 16 bytes are cut off"));
        }
        let nodes = nodes.chunks_exact(4).map(|words| {
            let [x, y, z, radius] = [0, 1, 2, 3].map(|lane| f32::from_bits(words[lane]));
            Node {
                position: Vec3::new(x, y, z),
                radius,
            }
        });
        let branches = branches.chunks_exact(4).map(|words| Branch {
            bearer: (words[0] != u32::MAX).then_some(words[0]),
            level: words[1],
            first_node: words[2],
            node_count: words[3],
        });
        Ok(Skeleton {
            nodes: nodes.collect(),
            branches: branches.collect(),
        })
    }

    fn trunk(
        &mut self,
        record: &TrunkRecord,
        materials: &mut Materials<'_, '_>,
        report: &mut ImportReport,
    ) -> Result<Mesh, Fault> {
        let pointer = format!("{POINTER}/trunk");
        let numbers = self.words(record.numbers, &format!("{pointer}/numbers"))?;
        let (material, rest) =
            self.material(record.material, &numbers, &pointer, materials, report)?;
        if !rest.is_empty() {
            return Err(Fault::new(pointer, "has more numbers than a material"));
        }
        let mut mesh = Mesh {
            positions: Vec::new(),
            normals: Vec::new(),
            texture_coordinates: Vec::new(),
            indices: Vec::new(),
            material,
        };
        let Some(surface) = self.surface(record.node, record.material, &pointer)? else {
            return Ok(mesh);
        };
        let count = surface.positions.count();
        let (Some(normals), Some(coordinates)) = (surface.normals, surface.coordinates) else {
            return Err(Fault::new(pointer, "lacks normals or texture coordinates"));
        };
        if normals.count() != count || coordinates.count() != count {
            return Err(Fault::new(pointer, "has attributes of different lengths"));
        }
        self.spend(count, 32)?;
        mesh.positions = (0..count)
            .map(|vertex| surface.positions.vec3(vertex))
            .collect();
        mesh.normals = (0..count).map(|vertex| normals.vec3(vertex)).collect();
        mesh.texture_coordinates = (0..count).map(|vertex| coordinates.vec2(vertex)).collect();
        match (surface.mode, surface.indices) {
            (Mode::Points, None) => {}
            (Mode::Triangles, Some((indices, _))) => {
                self.spend(indices.count(), 4)?;
                mesh.indices = (0..indices.count())
                    .map(|place| indices.index(place))
                    .collect();
            }
            _ => {
                return Err(Fault::new(
                    pointer,
                    "has another kind of primitive than written",
                ));
            }
        }
        Ok(mesh)
    }

    fn group(
        &mut self,
        index: usize,
        record: &GroupRecord,
        materials: &mut Materials<'_, '_>,
        report: &mut ImportReport,
    ) -> Result<LeafGroup, Fault> {
        let pointer = format!("{POINTER}/groups/{index}");
        let fail = |message: String| Err(Fault::new(&pointer, message));
        let numbers = self.words(record.numbers, &format!("{pointer}/numbers"))?;
        let triangles = self.words(record.triangles, &format!("{pointer}/triangles"))?;
        let owners = self.words(record.owners, &format!("{pointer}/owners"))?;
        let (material, rest) =
            self.material(record.material, &numbers, &pointer, materials, report)?;
        let Some(prototype) = prototype(record.prototype, rest, &triangles) else {
            return fail(format!("has {} numbers for its prototype", rest.len()));
        };
        if owners.len() != record.leaves {
            return fail(format!(
                "has {} leaves and {} owners",
                record.leaves,
                owners.len()
            ));
        }
        let stride = prototype.vertices_per_leaf();
        let wanted = record.leaves.saturating_mul(stride);
        let mut positions = Vec::new();
        if let Some(surface) = self.surface(record.node, record.material, &pointer)? {
            let found = surface.positions.count();
            if found != wanted {
                return fail(format!("shows {found} vertices, wanted {wanted}"));
            }
            self.spend(found, 12)?;
            if !shows(&surface, &prototype, record.leaves) {
                return fail(
                    "shows other triangles or texture coordinates than written".to_owned(),
                );
            }
            positions = (0..found)
                .map(|vertex| surface.positions.vec3(vertex))
                .collect();
        } else if wanted != 0 {
            return fail(format!("shows nothing, wanted {wanted} vertices"));
        }
        Ok(LeafGroup {
            name: record.name.clone(),
            prototype,
            material,
            positions,
            owners,
        })
    }

    /// A material with the numbers that were written, unless someone has changed them, and the
    /// numbers that follow.
    fn material<'n>(
        &self,
        index: usize,
        numbers: &'n [u32],
        pointer: &str,
        materials: &mut Materials<'_, '_>,
        report: &mut ImportReport,
    ) -> Result<(Material, &'n [u32]), Fault> {
        let count = self.source.root.materials.len();
        if index >= count {
            return Err(Fault::index(
                format!("{pointer}/material"),
                "material",
                index,
                count,
            ));
        }
        let Some((own, rest)) = numbers.split_at_checked(5) else {
            return Err(Fault::new(pointer, "lacks the numbers of its material"));
        };
        let mut material = materials.material(Some(index), report)?;
        let [r, g, b, a] = &mut material.base_color;
        for (seen, &word) in [r, g, b, a].into_iter().zip(own) {
            // JSON holds what glTF allows, the numbers what the plant has.
            *seen = exact(*seen, f32::from_bits(word), 1.0);
        }
        let cutoff = f32::from_bits(own[4]);
        material.alpha_cutoff = exact(material.alpha_cutoff, cutoff, f32::INFINITY);
        Ok((material, rest))
    }

    fn surface(
        &self,
        node: Option<usize>,
        material: usize,
        pointer: &str,
    ) -> Result<Option<Surface<'r>>, Fault> {
        let Some(node) = node else {
            return Ok(None);
        };
        let index = self.nodes.get(&node);
        let index = *index.ok_or_else(|| Fault::new(pointer, "names a node that shows nothing"))?;
        let (placed, surface) = &self.source.placed[index];
        if placed.material != Some(material) {
            return Err(Fault::new(pointer, "shows another material than written"));
        }
        Ok(Some(*surface))
    }
}

/// The number that was written, if `seen` is what JSON made of it, clamped to `most`.
fn exact(seen: f32, written: f32, most: f32) -> f32 {
    let shown = written.min(most);
    if (seen - shown).abs() <= 1e-6 * shown {
        written
    } else {
        seen
    }
}

fn prototype(kind: PrototypeKind, numbers: &[u32], triangles: &[u32]) -> Option<Prototype> {
    let corner = |pair: &[u32]| Vec2::new(f32::from_bits(pair[0]), f32::from_bits(pair[1]));
    match (kind, numbers) {
        (PrototypeKind::Quad, &[_, _, _, _, _, _, _, _]) if triangles.is_empty() => {
            let corners = [0, 1, 2, 3].map(|role| corner(&numbers[2 * role..]));
            Some(Prototype::Quad {
                texture_corners: corners,
            })
        }
        (PrototypeKind::Needle, &[diameter]) if triangles.is_empty() => Some(Prototype::Needle {
            diameter: f32::from_bits(diameter),
        }),
        (PrototypeKind::Faces, _)
            if numbers.len().is_multiple_of(2) && triangles.len().is_multiple_of(3) =>
        {
            let triangles = triangles.chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
            Some(Prototype::Faces {
                texture_coordinates: numbers.chunks_exact(2).map(corner).collect(),
                triangles: triangles.collect(),
            })
        }
        _ => None,
    }
}

/// Whether a primitive shows `leaves` leaves of a prototype.
fn shows(surface: &Surface<'_>, prototype: &Prototype, leaves: usize) -> bool {
    let (coordinates, corners): (&[Vec2], Vec<u32>) = match prototype {
        Prototype::Quad { texture_corners } => (texture_corners, QUAD_CORNERS.to_vec()),
        Prototype::Faces {
            texture_coordinates,
            triangles,
        } => (
            texture_coordinates,
            triangles.iter().flatten().copied().collect(),
        ),
        Prototype::Needle { .. } => {
            return surface.mode == Mode::Lines && surface.indices.is_none();
        }
    };
    let stride = coordinates.len();
    let same_coordinates = |found: &Elements<'_>| {
        found.count() == leaves * stride
            && (0..found.count()).all(|vertex| {
                let bits = |corner: Vec2| corner.to_array().map(f32::to_bits);
                bits(found.vec2(vertex)) == bits(coordinates[vertex % stride])
            })
    };
    let same_corners = match (surface.mode, &surface.indices) {
        (Mode::Points, None) => corners.is_empty(),
        (Mode::Triangles, Some((indices, _))) => {
            indices.count() as u64 == leaves as u64 * corners.len() as u64
                && (0..indices.count()).all(|place| {
                    let (leaf, corner) = (place / corners.len(), place % corners.len());
                    indices.index(place) as usize == leaf * stride + corners[corner] as usize
                })
        }
        _ => false,
    };
    same_corners && surface.coordinates.as_ref().is_some_and(same_coordinates)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_numbers_win_unless_json_was_edited() {
        let written = 0.1_f32.next_up();
        assert_eq!(exact(0.1, written, 1.0).to_bits(), written.to_bits());
        assert!((exact(0.2, written, 1.0) - 0.2).abs() < 1e-9);
        assert!((exact(1.0, 7.5, 1.0) - 7.5).abs() < 1e-9);
        assert_eq!(exact(0.0, -0.0, 1.0).to_bits(), (-0.0_f32).to_bits());
    }
}
