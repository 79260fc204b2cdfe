//! Writing what a frame draws: meshes, each with all the places where it stands.

use super::export::Writer;
use super::{ExportError, container};
use crate::limits;
use crate::math::{Quat, Vec3};
use crate::plant::Mesh;
use gltf_json::accessor::Type;
use gltf_json::material::AlphaMode;
use gltf_json::mesh::{Mode, Semantic};
use gltf_json::scene::UnitQuaternion;
use gltf_json::texture::{MagFilter, MinFilter, Sampler, WrappingMode};
use gltf_json::validation::Checked;
use gltf_json::{Index, Material, Root};
use serde_json::{Value, json};

/// A mesh, and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct InstancedMesh {
    /// A name for whoever looks into the file.
    pub name: String,
    /// The triangles, all of them seen from both sides.
    pub mesh: Mesh,
    /// What lies beyond the rim of its texture.
    pub rim: TextureRim,
    /// Where it stands; nowhere is left out.
    pub places: Vec<MeshPlace>,
}

/// What lies beyond the rim of a texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextureRim {
    /// The nearest texel, as on leaves.
    Clamp,
    /// The texture again, as on bark.
    Repeat,
}

/// Where a mesh stands: scaled, turned, then moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshPlace {
    /// Where its origin lies, in metres.
    pub position: Vec3,
    /// How it is turned.
    pub rotation: Quat,
    /// World metres a metre of the mesh.
    pub scale: f32,
}

/// Meshes at their places as a binary glTF 2.0 file; the same meshes are always the same bytes.
///
/// Positions, normals, texture coordinates and places are written as they are, in `f32`. A mesh that
/// stands at one place is a node there; one that stands at several is a node with
/// `EXT_mesh_gpu_instancing`, whose accessors `TRANSLATION`, `ROTATION` and `SCALE` have `f32` too
/// (programs that do not know it show one, at the origin). Materials are double-sided, in mode `MASK`
/// with their cutoff, or `OPAQUE` where that is 0; textures are embedded PNG of the largest level, from
/// which, with the cutoff, [`Texture::mips`](crate::plant::Texture::mips) makes the others; their sampler
/// asks for the nearest mip level, read bilinearly.
///
/// # Errors
///
/// When the file would be larger than what can be read again; `name` says of what.
pub fn export_instances(name: &str, meshes: &[InstancedMesh]) -> Result<Vec<u8>, ExportError> {
    let too_large = |bytes: u64| ExportError::TooLarge {
        plant: name.to_owned(),
        bytes,
        limit: limits::PLANT_FILE_BYTES,
    };
    let standing = || meshes.iter().filter(|mesh| !mesh.places.is_empty());
    let expected = standing().map(|mesh| least_bytes(&mesh.mesh)).sum();
    if expected > limits::PLANT_FILE_BYTES {
        return Err(too_large(expected));
    }
    let mut writer = Writer::default();
    let mut crowds = Vec::new();
    for standing in standing() {
        crowds.extend(add(&mut writer, standing));
    }
    let (root, binary) = writer.finish(name, None);
    let json = with_crowds(&root, &crowds).to_string().into_bytes();
    let bytes = json.len() as u64 + binary.len() as u64 + 64;
    if bytes > limits::PLANT_FILE_BYTES {
        return Err(too_large(bytes));
    }
    Ok(container::join(&json, &binary))
}

/// The document with the places of its crowds, whose extension its own type does not know.
fn with_crowds(root: &Root, crowds: &[Crowd]) -> Value {
    let mut document =
        serde_json::to_value(root).expect("names, numbers and lists have a JSON form");
    for Crowd { node, accessors } in crowds {
        let [translation, rotation, scale] = accessors;
        document["nodes"][node]["extensions"][INSTANCING] = json!({ "attributes": {
            "TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale,
        } });
    }
    if !crowds.is_empty() {
        document["extensionsUsed"] = json!([INSTANCING]);
    }
    document
}

const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// What the geometry of a mesh takes.
pub(super) fn least_bytes(mesh: &Mesh) -> u64 {
    32 * mesh.positions.len() as u64 + 4 * mesh.indices.len() as u64
}

/// A node that stands at several places.
struct Crowd {
    node: usize,
    /// The accessors of positions, rotations and scales.
    accessors: [usize; 3],
}

/// Adds a mesh with its node; answers the places, where the node itself is not at the only one.
fn add<'m>(writer: &mut Writer<'m>, standing: &'m InstancedMesh) -> Option<Crowd> {
    let InstancedMesh {
        name, mesh, places, ..
    } = standing;
    if mesh.indices.is_empty() {
        return None;
    }
    let mode = match mesh.material.alpha_cutoff > 0.0 {
        true => AlphaMode::Mask,
        false => AlphaMode::Opaque,
    };
    let material = writer.material(&mesh.material, mode);
    writer.root.materials[material.value()].double_sided = true;
    set_sampler(writer, material, standing.rim);
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
    let shown = super::export::primitive(attributes, indices, material, Mode::Triangles);
    let node = writer.node(name, shown);
    if let [place] = places[..] {
        let node = &mut writer.root.nodes[node];
        if place.position != Vec3::ZERO {
            node.translation = Some(place.position.to_array());
        }
        if place.rotation != Quat::IDENTITY {
            node.rotation = Some(UnitQuaternion(place.rotation.to_array()));
        }
        if place.scale != 1.0 {
            node.scale = Some([place.scale; 3]);
        }
        return None;
    }
    let positions = places.iter().flat_map(|place| place.position.to_array());
    let rotations = places.iter().flat_map(|place| place.rotation.to_array());
    let scales = places.iter().flat_map(|place| [place.scale; 3]);
    let accessors = [
        writer.instances(positions, Type::Vec3),
        writer.instances(rotations, Type::Vec4),
        writer.instances(scales, Type::Vec3),
    ];
    let accessors = accessors.map(|accessor| accessor.value());
    Some(Crowd { node, accessors })
}

/// Says how a material's texture is read. An image that is read in two ways has two textures.
pub(super) fn set_sampler(writer: &mut Writer<'_>, material: Index<Material>, rim: TextureRim) {
    let root = &mut writer.root;
    let base = &mut root.materials[material.value()].pbr_metallic_roughness;
    let Some(info) = &mut base.base_color_texture else {
        return;
    };
    let wrap = Checked::Valid(match rim {
        TextureRim::Clamp => WrappingMode::ClampToEdge,
        TextureRim::Repeat => WrappingMode::Repeat,
    });
    let mut known = root.samplers.iter();
    let known = known.position(|sampler| sampler.wrap_s == wrap);
    let sampler = Index::new(crate::math::index_u32(known.unwrap_or_else(|| {
        root.samplers.push(Sampler {
            mag_filter: Some(Checked::Valid(MagFilter::Linear)),
            min_filter: Some(Checked::Valid(MinFilter::LinearMipmapNearest)),
            wrap_s: wrap,
            wrap_t: wrap,
            ..Sampler::default()
        });
        root.samplers.len() - 1
    })));
    let texture = &mut root.textures[info.index.value()];
    match texture.sampler {
        None => texture.sampler = Some(sampler),
        Some(other) if other.value() == sampler.value() => {}
        Some(_) => {
            let mut again = texture.clone();
            again.sampler = Some(sampler);
            root.textures.push(again);
            info.index = Index::new(crate::math::index_u32(root.textures.len() - 1));
        }
    }
}
