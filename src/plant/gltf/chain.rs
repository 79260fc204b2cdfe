//! Writing levels of detail: one after another in one file, or each in its own.

use super::export::{Writer, primitive};
use super::instances::{least_bytes, set_sampler};
use super::{ExportError, TextureRim, container};
use crate::limits;
use crate::math::{Vec3, index_u32};
use crate::plant::{Material, Mesh};
use gltf_json::accessor::Type;
use gltf_json::material::AlphaMode;
use gltf_json::mesh::{Mode, Semantic};
use gltf_json::{Index, Root};
use serde_json::{Value, json};

/// A level of detail: what shows at once.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainLevel {
    /// A name for whoever looks into the file.
    pub name: String,
    /// Its meshes and lines.
    pub parts: Vec<ChainPart>,
    /// From which share of the picture's height on, taken by the tree's sphere, it is fine enough: the
    /// threshold of `MSFT_screencoverage`.
    pub coverage: f32,
}

/// A part of a level.
#[derive(Debug, Clone, PartialEq)]
pub enum ChainPart {
    /// Triangles.
    Mesh {
        /// A name for whoever looks into the file.
        name: String,
        /// The triangles.
        mesh: Mesh,
        /// What lies beyond the rim of their texture.
        rim: TextureRim,
        /// From where they are seen.
        sides: Sides,
    },
    /// Lines of one pixel, blended.
    Lines {
        /// A name for whoever looks into the file.
        name: String,
        /// Both ends of each line, one after the other, in metres.
        ends: Vec<Vec3>,
        /// How opaque each end is.
        alphas: Vec<f32>,
        /// What they look like; its texture is not used.
        material: Material,
    },
}

/// From where triangles are seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sides {
    /// From where they are counter-clockwise alone.
    Front,
    /// From both sides.
    Both,
}

/// Levels of detail as a binary glTF 2.0 file; the same levels are always the same bytes.
///
/// A level is a node, its parts are nodes below it. The scene shows the first; if there are more, that node
/// names them with `MSFT_lod`, finest first, and its extras have `MSFT_screencoverage` with as many
/// thresholds as there are levels. Programs that do not know the extension show the first level. Lines carry
/// their opacity as `COLOR_0`. Images, and materials that are alike, are written once for all levels.
///
/// # Errors
///
/// When the file would be larger than what can be read again; `name` says of what.
pub fn export_chain(name: &str, levels: &[&ChainLevel]) -> Result<Vec<u8>, ExportError> {
    let too_large = |bytes: u64| ExportError::TooLarge {
        plant: name.to_owned(),
        bytes,
        limit: limits::PLANT_FILE_BYTES,
    };
    let parts = levels.iter().flat_map(|level| &level.parts);
    let expected = parts.map(ChainPart::least_bytes).sum();
    if expected > limits::PLANT_FILE_BYTES {
        return Err(too_large(expected));
    }
    let mut writer = Writer::default();
    let mut known = Vec::new();
    let mut nodes = Vec::new();
    for level in levels {
        let before = writer.root_count();
        for part in &level.parts {
            add(&mut writer, part, &mut known);
        }
        nodes.push(writer.gather(&level.name, before));
    }
    writer.keep_roots(1);
    let (root, binary) = writer.finish(name, None);
    let json = with_levels(&root, levels, &nodes).to_string().into_bytes();
    let bytes = json.len() as u64 + binary.len() as u64 + 64;
    if bytes > limits::PLANT_FILE_BYTES {
        return Err(too_large(bytes));
    }
    Ok(container::join(&json, &binary))
}

/// The document with its levels, whose extension its own type does not know.
fn with_levels(root: &Root, levels: &[&ChainLevel], nodes: &[usize]) -> Value {
    let mut document =
        serde_json::to_value(root).expect("names, numbers and lists have a JSON form");
    if let [finest, coarser @ ..] = nodes
        && !coarser.is_empty()
    {
        let coverages: Vec<f32> = levels.iter().map(|level| level.coverage).collect();
        document["nodes"][finest]["extensions"][LEVELS] = json!({ "ids": coarser });
        document["nodes"][finest]["extras"] = json!({ "MSFT_screencoverage": coverages });
        document["extensionsUsed"] = json!([LEVELS]);
    }
    document
}

const LEVELS: &str = "MSFT_lod";

impl ChainPart {
    /// What the geometry takes.
    fn least_bytes(&self) -> u64 {
        match self {
            Self::Mesh { mesh, .. } => least_bytes(mesh),
            Self::Lines { ends, .. } => 28 * ends.len() as u64,
        }
    }
}

/// How a material is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Look {
    Surface(TextureRim, Sides),
    Line,
}

/// Materials that are written already.
type Known<'p> = Vec<(&'p Material, Look, Index<gltf_json::Material>)>;

fn add<'p>(writer: &mut Writer<'p>, part: &'p ChainPart, known: &mut Known<'p>) {
    match part {
        ChainPart::Mesh {
            name,
            mesh,
            rim,
            sides,
        } if !mesh.indices.is_empty() => {
            let material = material(writer, &mesh.material, Look::Surface(*rim, *sides), known);
            let positions = writer.positions(&mesh.positions);
            let normals = mesh.normals.iter().flat_map(|normal| normal.to_array());
            let normals = writer.attribute(normals, Type::Vec3);
            let coordinates = writer.coordinates(&mesh.texture_coordinates);
            let indices = writer.indices(mesh.indices.iter().copied());
            let attributes = [
                (Semantic::Positions, positions),
                (Semantic::Normals, normals),
                (Semantic::TexCoords(0), coordinates),
            ];
            writer.node(
                name,
                primitive(attributes, indices, material, Mode::Triangles),
            );
        }
        ChainPart::Lines {
            name,
            ends,
            alphas,
            material: look,
        } if !ends.is_empty() => {
            let material = material(writer, look, Look::Line, known);
            let positions = writer.positions(ends);
            let colors = alphas
                .iter()
                .flat_map(|&alpha| [1.0, 1.0, 1.0, alpha.clamp(0.0, 1.0)]);
            let colors = writer.attribute(colors, Type::Vec4);
            let indices = writer.indices(0..index_u32(ends.len()));
            let attributes = [
                (Semantic::Positions, positions),
                (Semantic::Colors(0), colors),
            ];
            writer.node(name, primitive(attributes, indices, material, Mode::Lines));
        }
        ChainPart::Mesh { .. } | ChainPart::Lines { .. } => {}
    }
}

fn material<'p>(
    writer: &mut Writer<'p>,
    wanted: &'p Material,
    look: Look,
    known: &mut Known<'p>,
) -> Index<gltf_json::Material> {
    let is_same =
        |(other, as_look, _): &&(&Material, Look, _)| *other == wanted && *as_look == look;
    if let Some((_, _, index)) = known.iter().find(is_same) {
        return *index;
    }
    let mode = match look {
        Look::Line => AlphaMode::Blend,
        Look::Surface(..) if wanted.alpha_cutoff > 0.0 => AlphaMode::Mask,
        Look::Surface(..) => AlphaMode::Opaque,
    };
    let index = match look {
        Look::Line => writer.plain_material(wanted, mode),
        Look::Surface(..) => writer.material(wanted, mode),
    };
    if let Look::Surface(rim, sides) = look {
        writer.root.materials[index.value()].double_sided = sides == Sides::Both;
        set_sampler(writer, index, rim);
    }
    known.push((wanted, look, index));
    index
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;

    fn leaf(size: f32) -> Mesh {
        let corners = [(0.0, 0.0), (size, 0.0), (size, size), (0.0, size)];
        Mesh {
            positions: corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
            normals: vec![Vec3::Z; 4],
            texture_coordinates: vec![Vec2::ZERO; 4],
            indices: vec![0, 1, 2, 0, 2, 3],
            material: Material::plain("leaf", [0.1, 0.5, 0.1]),
        }
    }

    fn level(name: &str, size: f32, coverage: f32) -> ChainLevel {
        ChainLevel {
            name: name.to_owned(),
            coverage,
            parts: vec![
                ChainPart::Mesh {
                    name: "leaves".to_owned(),
                    mesh: leaf(size),
                    rim: TextureRim::Clamp,
                    sides: Sides::Both,
                },
                ChainPart::Lines {
                    name: "twigs".to_owned(),
                    ends: vec![Vec3::ZERO, Vec3::Y],
                    alphas: vec![1.0, 0.25],
                    material: Material::plain("bark", [0.2, 0.1, 0.0]),
                },
            ],
        }
    }

    fn document(glb: &[u8]) -> Value {
        let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
        serde_json::from_slice(&glb[20..20 + length]).unwrap()
    }

    #[test]
    fn the_first_level_names_the_others() {
        let levels = [
            level("lod0", 1.0, 0.5),
            level("lod1", 2.0, 0.25),
            level("lod2", 3.0, 0.0),
        ];
        let all: Vec<&ChainLevel> = levels.iter().collect();
        let chain = document(&export_chain("oak", &all).unwrap());
        assert_eq!(chain["extensionsUsed"], json!(["MSFT_lod"]));
        let shown = chain["scenes"][0]["nodes"].as_array().unwrap();
        assert_eq!(shown.len(), 1);
        let finest = &chain["nodes"][usize::try_from(shown[0].as_u64().unwrap()).unwrap()];
        assert_eq!(finest["name"], "lod0");
        assert_eq!(
            finest["extras"]["MSFT_screencoverage"],
            json!([0.5, 0.25, 0.0])
        );
        let ids = finest["extensions"]["MSFT_lod"]["ids"].as_array().unwrap();
        let named: Vec<&Value> = ids
            .iter()
            .map(|id| &chain["nodes"][usize::try_from(id.as_u64().unwrap()).unwrap()]["name"])
            .collect();
        assert_eq!(named, [&json!("lod1"), &json!("lod2")]);
        // Alike materials are shared: one for leaves, one for lines.
        assert_eq!(chain["materials"].as_array().unwrap().len(), 2);
        assert_eq!(chain["materials"][1]["alphaMode"], "BLEND");
    }

    #[test]
    fn a_level_alone_needs_no_extension() {
        let level = level("lod0", 1.0, 0.5);
        let glb = export_chain("oak", &[&level]).unwrap();
        let alone = document(&glb);
        assert_eq!(alone.get("extensionsUsed"), None);
        assert_eq!(alone["nodes"].as_array().unwrap().len(), 3);
        assert_eq!(glb, export_chain("oak", &[&level]).unwrap());
    }
}
