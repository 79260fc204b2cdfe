//! From a primitive's accessors to triangles, whatever form they are stored in.

use super::accessor::{Elements, Reader, Wanted};
use super::error::Fault;
use super::material::alpha_mode;
use super::scene::Placed;
use crate::math::{DVec3, Vec2, Vec3, index_u32};
use crate::plant::import::mesh::{Part, compact, says_leaves};
use crate::plant::import::{Frame, ImportReport, ReportKind};
use gltf_json::accessor::{ComponentType, Type};
use gltf_json::material::AlphaMode;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};

/// The checked accessors of a primitive; nothing is read yet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface<'r> {
    pub(super) mode: Mode,
    pub(super) positions: Elements<'r>,
    pub(super) normals: Option<Elements<'r>>,
    pub(super) coordinates: Option<Elements<'r>>,
    pub(super) indices: Option<(Elements<'r>, usize)>,
}

/// Opens the accessors of a primitive; `None` if it has no positions.
pub(super) fn open<'r>(
    root: &Root,
    reader: &'r Reader<'_>,
    placed: &Placed,
    report: &mut ImportReport,
) -> Result<Option<Surface<'r>>, Fault> {
    let primitive = &root.meshes[placed.mesh].primitives[placed.primitive];
    let pointer = placed.pointer();
    let Checked::Valid(mode) = primitive.mode else {
        let message = "wanted a mode of 0 (points) to 6 (triangle fan)";
        return Err(Fault::new(format!("{pointer}/mode"), message));
    };
    let quantized = root.extensions_used.iter().any(|name| name == QUANTIZATION);
    let attribute = |semantic: Semantic, kind: Type, core: &'static [ComponentType]| {
        let label = semantic.to_string();
        let Some(index) = primitive.attributes.get(&Checked::Valid(semantic)) else {
            return Ok(None);
        };
        let components = if quantized { QUANTIZED } else { core };
        let wanted = Wanted { kind, components };
        let pointer = format!("{pointer}/attributes/{label}");
        reader.elements(index.value(), &pointer, &wanted).map(Some)
    };
    let Some(positions) = attribute(Semantic::Positions, Type::Vec3, FLOAT)? else {
        report.add(
            ReportKind::Dropped,
            1,
            pointer,
            "primitives without POSITION",
        );
        return Ok(None);
    };
    let normals = attribute(Semantic::Normals, Type::Vec3, FLOAT)?;
    let set = coordinate_set(root, placed.material);
    let coordinates = attribute(Semantic::TexCoords(set), Type::Vec2, COORDINATE)?;
    for (what, elements) in [("NORMAL", normals), ("TEXCOORD", coordinates)] {
        if let Some(elements) = elements
            && elements.count() < positions.count()
        {
            let message = format!(
                "{what} has {} elements, POSITION has {}",
                elements.count(),
                positions.count()
            );
            return Err(Fault::new(format!("{pointer}/attributes"), message));
        }
    }
    let indices = match primitive.indices.as_ref().map(Index::value) {
        None => None,
        Some(index) => {
            let pointer = format!("{pointer}/indices");
            Some((reader.elements(index, &pointer, &INDEX)?, index))
        }
    };
    note_unused(primitive, set, &pointer, report);
    Ok(Some(Surface {
        mode,
        positions,
        normals,
        coordinates,
        indices,
    }))
}

impl Surface<'_> {
    /// How many triangle corners the primitive has.
    pub(super) fn corner_count(&self) -> u64 {
        let count = self.element_count() as u64;
        match self.mode {
            Mode::Triangles => count / 3 * 3,
            Mode::TriangleStrip | Mode::TriangleFan => 3 * count.saturating_sub(2),
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => 0,
        }
    }

    /// How many vertices are named, by indices or one after the other.
    pub(super) fn element_count(&self) -> usize {
        self.indices
            .map_or(self.positions.count(), |(indices, _)| indices.count())
    }

    /// Hands every vertex that the primitive names to a function, in world space. Indices out of range are
    /// left out: they are refused where triangles are read.
    pub(super) fn visit(&self, placed: &Placed, take: &mut dyn FnMut(DVec3)) {
        if self.corner_count() == 0 {
            return;
        }
        for place in 0..self.element_count() {
            let vertex = self
                .indices
                .map_or(place, |(indices, _)| indices.index(place) as usize);
            if vertex < self.positions.count() {
                take(placed.placement.point64(self.positions.vec3(vertex)));
            }
        }
    }

    /// Reads the triangles of a placed primitive.
    pub(super) fn load(
        &self,
        root: &Root,
        placed: &Placed,
        frame: &Frame,
        report: &mut ImportReport,
    ) -> Result<Part, Fault> {
        let pointer = placed.pointer();
        let mut triangles = self.triangles(&pointer, report)?;
        if placed.placement.mirrors() {
            for triangle in &mut triangles {
                triangle.swap(1, 2);
            }
        }
        let (vertices, triangles) = compact(triangles);
        let mut positions = Vec::with_capacity(vertices.len());
        let mut normals = Vec::with_capacity(vertices.len());
        let mut coordinates = Vec::with_capacity(vertices.len());
        let normal_matrix = placed.placement.normal_matrix();
        let mut bad_normals = 0;
        for &vertex in &vertices {
            let vertex = vertex as usize;
            let local = self.positions.vec3(vertex);
            let position = frame.point(placed.placement.point64(local));
            if !position.is_finite() {
                let message = format!(
                    "vertex {vertex} at {local} lies at {position} in the world, wanted finite numbers"
                );
                return Err(Fault::new(
                    format!("{pointer}/attributes/POSITION"),
                    message,
                ));
            }
            positions.push(position);
            let normal = self.normals.map_or(Vec3::ZERO, |normals| {
                let normal = normal_matrix * normals.vec3(vertex).as_dvec3();
                let unit = frame.direction(normal.normalize_or_zero());
                bad_normals += u64::from(unit == Vec3::ZERO);
                unit
            });
            normals.push(normal);
            let coordinate = self
                .coordinates
                .map_or(Vec2::ZERO, |coordinates| coordinates.vec2(vertex));
            if !coordinate.is_finite() {
                let message = format!("vertex {vertex} has {coordinate}, wanted finite numbers");
                return Err(Fault::new(
                    format!("{pointer}/attributes/TEXCOORD_0"),
                    message,
                ));
            }
            coordinates.push(coordinate);
        }
        let message = "normals that are zero or not finite: computed from the triangles";
        let at = format!("{pointer}/attributes/NORMAL");
        report.add(ReportKind::Repaired, bad_normals, at, message);
        let material = placed.material.and_then(|index| root.materials.get(index));
        Ok(Part {
            place: pointer,
            material: placed.material,
            named: placed.named,
            has_alpha: match placed.material {
                Some(material) => alpha_mode(root, material)? != AlphaMode::Opaque,
                None => false,
            },
            material_says: says_leaves(material.and_then(|material| material.name.as_deref())),
            name_says: placed.name_says,
            positions,
            normals,
            coordinates,
            triangles,
        })
    }

    /// The primitive's triangles by vertex index, in range, none with the same vertex twice.
    fn triangles(&self, pointer: &str, report: &mut ImportReport) -> Result<Vec<[u32; 3]>, Fault> {
        let count = self.element_count();
        let vertex = |place: usize| -> Result<u32, Fault> {
            let Some((indices, accessor)) = self.indices else {
                return Ok(index_u32(place));
            };
            let found = indices.index(place);
            let vertices = self.positions.count();
            if found as usize >= vertices {
                let message =
                    format!("entry {place} names vertex {found}, but there are {vertices}");
                return Err(Fault::new(format!("/accessors/{accessor}"), message));
            }
            Ok(found)
        };
        let mut triangles = Vec::new();
        let mut push = |corners: [usize; 3]| -> Result<(), Fault> {
            let [a, b, c] = corners;
            triangles.push([vertex(a)?, vertex(b)?, vertex(c)?]);
            Ok(())
        };
        match self.mode {
            Mode::Triangles => {
                for first in (0..count / 3).map(|triangle| 3 * triangle) {
                    push([first, first + 1, first + 2])?;
                }
                let message = "indices left over after the last whole triangle";
                let left = (count % 3) as u64;
                report.add(ReportKind::Dropped, left, pointer, message);
            }
            // glTF 2.0, section 3.7.2.1: the winding alternates.
            Mode::TriangleStrip => {
                for first in 0..count.saturating_sub(2) {
                    let odd = first % 2;
                    push([first, first + 1 + odd, first + 2 - odd])?;
                }
            }
            Mode::TriangleFan => {
                for first in 0..count.saturating_sub(2) {
                    push([first + 1, first + 2, 0])?;
                }
            }
            Mode::Points => {
                report.add(ReportKind::Dropped, count as u64, pointer, "points");
            }
            Mode::Lines | Mode::LineLoop | Mode::LineStrip => {
                let message = "ends of lines";
                report.add(ReportKind::Dropped, count as u64, pointer, message);
            }
        }
        let before = triangles.len();
        triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        let flat = (before - triangles.len()) as u64;
        let message = "triangles that name a vertex twice";
        report.add(ReportKind::Dropped, flat, pointer, message);
        Ok(triangles)
    }
}

/// The extension that allows small integers for positions and normals.
pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";

const FLOAT: &[ComponentType] = &[ComponentType::F32];
const COORDINATE: &[ComponentType] = &[ComponentType::F32, ComponentType::U8, ComponentType::U16];
const QUANTIZED: &[ComponentType] = &[
    ComponentType::F32,
    ComponentType::I8,
    ComponentType::U8,
    ComponentType::I16,
    ComponentType::U16,
];
const INDEX: Wanted = Wanted {
    kind: Type::Scalar,
    components: &[ComponentType::U8, ComponentType::U16, ComponentType::U32],
};

/// Which set of texture coordinates a material's base colour uses.
fn coordinate_set(root: &Root, material: Option<usize>) -> u32 {
    let material = material.and_then(|material| root.materials.get(material));
    let texture = material.and_then(|m| m.pbr_metallic_roughness.base_color_texture.as_ref());
    texture.map_or(0, |texture| texture.tex_coord)
}

fn note_unused(primitive: &Primitive, set: u32, pointer: &str, report: &mut ImportReport) {
    for semantic in primitive.attributes.keys() {
        let message = match semantic {
            Checked::Valid(Semantic::Positions | Semantic::Normals) => continue,
            Checked::Valid(Semantic::TexCoords(found)) if *found == set => continue,
            Checked::Valid(Semantic::TexCoords(_)) => {
                "texture coordinates that the colour does not use"
            }
            Checked::Valid(Semantic::Colors(_)) => "vertex colours",
            Checked::Valid(Semantic::Tangents) => "tangents",
            Checked::Valid(Semantic::Joints(_) | Semantic::Weights(_)) => {
                "joints and weights of skins"
            }
            Checked::Valid(Semantic::Extras(_)) | Checked::Invalid => {
                "attributes of unknown meaning"
            }
        };
        let place = format!("{pointer}/attributes/{}", semantic.to_string());
        report.add(ReportKind::Ignored, 1, place, message);
    }
    let targets = primitive.targets.as_ref().map_or(0, Vec::len) as u64;
    let place = format!("{pointer}/targets");
    report.add(ReportKind::Ignored, targets, place, "morph targets");
}
