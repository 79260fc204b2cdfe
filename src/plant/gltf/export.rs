//! Writing a plant as a GLB that any viewer draws and that comes back as the same plant.

use super::record::{
    Envelope, GroupRecord, PrototypeKind, QUAD_CORNERS, Record, SCHEMA, SkeletonRecord, TrunkRecord,
};
use super::{ExportError, container};
use crate::limits;
use crate::math::{Aabb, Digester, Vec2, Vec3, index_u32};
use crate::plant::{Branch, LeafGroup, Material, Mesh, Node, Plant, Prototype, Skeleton, Texture};
use gltf_json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Buffer, Target, View};
use gltf_json::image::MimeType;
use gltf_json::material::{
    AlphaCutoff, AlphaMode, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor,
};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Index, Root, texture};
use image::ImageEncoder as _;
use std::collections::BTreeMap;

/// A plant as a binary glTF 2.0 file; the same plant is always the same bytes.
///
/// Trunk and groups are nodes of their own: triangles, and needles as lines. Leaves are
/// double-sided and alpha-masked. What glTF cannot say (skeleton, owners, prototypes) is in
/// `extras.spinney` and in buffer views that it names; other programs ignore it.
///
/// # Errors
///
/// When the file would be larger than what can be read again.
pub fn export_glb(plant: &Plant) -> Result<Vec<u8>, ExportError> {
    let too_large = |bytes: u64| ExportError::TooLarge {
        plant: plant.name().to_owned(),
        bytes,
        limit: limits::PLANT_FILE_BYTES,
    };
    let groups = &plant.foliage().groups;
    if groups.len() > limits::WRITTEN_GROUPS {
        return Err(ExportError::TooManyGroups {
            plant: plant.name().to_owned(),
            groups: groups.len(),
            limit: limits::WRITTEN_GROUPS,
        });
    }
    let expected = least_bytes(plant);
    if expected > limits::PLANT_FILE_BYTES {
        return Err(too_large(expected));
    }
    let mut writer = Writer::default();
    let record = Record {
        schema: SCHEMA.to_owned(),
        name: plant.name().to_owned(),
        digest: plant.digest().to_string(),
        skeleton: plant.skeleton().map(|skeleton| writer.skeleton(skeleton)),
        trunk: plant.trunk().map(|trunk| writer.trunk(trunk)),
        groups: groups.iter().map(|group| writer.group(group)).collect(),
        hidden: writer.hidden.finish().to_string(),
    };
    let (root, binary) = writer.finish(plant.name(), Some(record));
    let json = to_json(&root);
    let bytes = json.len() as u64 + binary.len() as u64 + 64;
    if bytes > limits::PLANT_FILE_BYTES {
        return Err(too_large(bytes));
    }
    Ok(container::join(&json, &binary))
}

/// What the geometry takes, before anything is built.
fn least_bytes(plant: &Plant) -> u64 {
    let trunk = plant.trunk().map_or(0, |trunk| {
        32 * trunk.positions.len() as u64 + 4 * trunk.indices.len() as u64
    });
    let groups = plant.foliage().groups.iter().map(|group| {
        let triangles = group.prototype.triangles_per_leaf() as u64;
        20 * group.positions.len() as u64 + (12 * triangles + 4) * group.leaf_count() as u64
    });
    trunk + groups.sum::<u64>()
}

/// A document and its binary chunk, part by part.
pub(super) struct Writer<'p> {
    pub(super) root: Root,
    binary: Vec<u8>,
    hidden: Digester,
    nodes: Vec<Index<gltf_json::Node>>,
    textures: Vec<(&'p Texture, Index<texture::Texture>)>,
}

impl Default for Writer<'_> {
    fn default() -> Self {
        Self {
            root: Root::default(),
            binary: Vec::new(),
            hidden: Digester::new(SCHEMA),
            nodes: Vec::new(),
            textures: Vec::new(),
        }
    }
}

impl<'p> Writer<'p> {
    fn skeleton(&mut self, skeleton: &Skeleton) -> SkeletonRecord {
        let node = |node: &Node| {
            let [x, y, z] = node.position.to_array();
            [x, y, z, node.radius].map(f32::to_bits)
        };
        let branch = |branch: &Branch| {
            let bearer = branch.bearer.unwrap_or(u32::MAX);
            [bearer, branch.level, branch.first_node, branch.node_count]
        };
        SkeletonRecord {
            nodes: self.hide(skeleton.nodes.iter().flat_map(node)),
            branches: self.hide(skeleton.branches.iter().flat_map(branch)),
        }
    }

    fn trunk(&mut self, trunk: &'p Mesh) -> TrunkRecord {
        let numbers = self.hide(material_numbers(&trunk.material));
        let has_alpha = trunk.material.alpha_cutoff > 0.0;
        let mode = if has_alpha {
            AlphaMode::Mask
        } else {
            AlphaMode::Opaque
        };
        let material = self.material(&trunk.material, mode);
        let node = (!trunk.positions.is_empty()).then(|| {
            let positions = self.positions(&trunk.positions);
            let normals = self.attribute(
                trunk.normals.iter().flat_map(|normal| normal.to_array()),
                Type::Vec3,
            );
            let coordinates = self.coordinates(&trunk.texture_coordinates);
            let indices = self.indices(trunk.indices.iter().copied());
            let mode = if indices.is_some() {
                Mode::Triangles
            } else {
                Mode::Points
            };
            let attributes = [
                (Semantic::Positions, positions),
                (Semantic::Normals, normals),
                (Semantic::TexCoords(0), coordinates),
            ];
            self.node("trunk", primitive(attributes, indices, material, mode))
        });
        TrunkRecord {
            node,
            material: material.value(),
            numbers,
        }
    }

    fn group(&mut self, group: &'p LeafGroup) -> GroupRecord {
        let (prototype, own, corners): (_, Vec<f32>, Vec<u32>) = match &group.prototype {
            Prototype::Quad { texture_corners } => {
                let numbers = texture_corners.iter().flat_map(|corner| corner.to_array());
                (
                    PrototypeKind::Quad,
                    numbers.collect(),
                    QUAD_CORNERS.to_vec(),
                )
            }
            Prototype::Faces {
                texture_coordinates,
                triangles,
            } => {
                let numbers = texture_coordinates
                    .iter()
                    .flat_map(|corner| corner.to_array());
                let corners = triangles.iter().flatten().copied().collect();
                (PrototypeKind::Faces, numbers.collect(), corners)
            }
            Prototype::Needle { diameter } => (PrototypeKind::Needle, vec![*diameter], Vec::new()),
        };
        let numbers = material_numbers(&group.material);
        let numbers = self.hide(numbers.into_iter().chain(own.iter().map(|n| n.to_bits())));
        let hidden_triangles: &[u32] = match prototype {
            PrototypeKind::Faces => &corners,
            PrototypeKind::Quad | PrototypeKind::Needle => &[],
        };
        let triangles = self.hide(hidden_triangles.iter().copied());
        let owners = self.hide(group.owners.iter().copied());
        let material = self.material(&group.material, AlphaMode::Mask);
        let node = (!group.positions.is_empty())
            .then(|| self.leaves(group, prototype, &own, &corners, material));
        GroupRecord {
            name: group.name.clone(),
            prototype,
            leaves: group.leaf_count(),
            node,
            material: material.value(),
            numbers,
            triangles,
            owners,
        }
    }

    /// The node that shows a group's leaves.
    fn leaves(
        &mut self,
        group: &LeafGroup,
        prototype: PrototypeKind,
        coordinates: &[f32],
        corners: &[u32],
        material: Index<gltf_json::Material>,
    ) -> usize {
        let positions = self.positions(&group.positions);
        if prototype == PrototypeKind::Needle {
            let mut attributes = vec![(Semantic::Positions, positions)];
            if group.material.texture.is_some() {
                // glTF wants coordinates for a texture; a needle is the image's middle line.
                let line = (0..group.leaf_count()).flat_map(|_| [0.5, 1.0, 0.5, 0.0]);
                let coordinates = self.attribute(line, Type::Vec2);
                attributes.push((Semantic::TexCoords(0), coordinates));
            }
            let shown = primitive(attributes, None, material, Mode::Lines);
            return self.node(&group.name, shown);
        }
        let leaves = 0..group.leaf_count();
        let all = leaves.clone().flat_map(|_| coordinates.iter().copied());
        let shown = self.attribute(all, Type::Vec2);
        let stride = index_u32(group.prototype.vertices_per_leaf());
        let indices = leaves.flat_map(|leaf| {
            let first = index_u32(leaf) * stride;
            corners.iter().map(move |corner| first + corner)
        });
        let indices = self.indices(indices);
        let mode = if indices.is_some() {
            Mode::Triangles
        } else {
            Mode::Points
        };
        let attributes = [
            (Semantic::Positions, positions),
            (Semantic::TexCoords(0), shown),
        ];
        self.node(&group.name, primitive(attributes, indices, material, mode))
    }

    /// Adds a buffer view that only the record names; `None` if there are no bytes.
    fn hide(&mut self, words: impl IntoIterator<Item = u32>) -> Option<usize> {
        let start = self.binary.len();
        let view = self.view(words.into_iter().flat_map(u32::to_le_bytes), None);
        self.hidden.bytes(&self.binary[start..]);
        view.map(|view| view.value())
    }

    /// Adds a buffer view; every one begins at a multiple of 4.
    fn view(
        &mut self,
        bytes: impl IntoIterator<Item = u8>,
        target: Option<Target>,
    ) -> Option<Index<View>> {
        let start = self.binary.len();
        self.binary.extend(bytes);
        let length = self.binary.len() - start;
        if length == 0 {
            return None;
        }
        let view = View {
            buffer: Index::new(0),
            byte_length: USize64::from(length),
            byte_offset: Some(USize64::from(start)),
            byte_stride: None,
            name: None,
            target: target.map(Checked::Valid),
            extensions: None,
            extras: None,
        };
        Some(self.root.push(view))
    }

    pub(super) fn attribute(
        &mut self,
        numbers: impl Iterator<Item = f32>,
        kind: Type,
    ) -> Index<Accessor> {
        let bytes = numbers.flat_map(f32::to_le_bytes);
        let view = self.view(bytes, Some(Target::ArrayBuffer));
        self.accessor(view, kind, ComponentType::F32)
    }

    /// Numbers of instances: no vertex buffer.
    pub(super) fn instances(
        &mut self,
        numbers: impl Iterator<Item = f32>,
        kind: Type,
    ) -> Index<Accessor> {
        let view = self.view(numbers.flat_map(f32::to_le_bytes), None);
        self.accessor(view, kind, ComponentType::F32)
    }

    fn accessor(
        &mut self,
        view: Option<Index<View>>,
        kind: Type,
        component: ComponentType,
    ) -> Index<Accessor> {
        let bytes = view.map_or(0, |view| self.root.buffer_views[view.value()].byte_length.0);
        let element = (component.size() * kind.multiplicity()) as u64;
        self.root.push(Accessor {
            buffer_view: view,
            byte_offset: None,
            count: USize64(bytes / element),
            component_type: Checked::Valid(GenericComponentType(component)),
            extensions: None,
            extras: None,
            type_: Checked::Valid(kind),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
        })
    }

    pub(super) fn positions(&mut self, positions: &[Vec3]) -> Index<Accessor> {
        let numbers = positions.iter().flat_map(|position| position.to_array());
        let index = self.attribute(numbers, Type::Vec3);
        let bounds = Aabb::of(positions.iter().copied());
        let accessor = &mut self.root.accessors[index.value()];
        accessor.min = Some(bounds.min.to_array().to_vec().into());
        accessor.max = Some(bounds.max.to_array().to_vec().into());
        index
    }

    pub(super) fn coordinates(&mut self, coordinates: &[Vec2]) -> Index<Accessor> {
        let numbers = coordinates
            .iter()
            .flat_map(|coordinate| coordinate.to_array());
        self.attribute(numbers, Type::Vec2)
    }

    pub(super) fn indices(
        &mut self,
        indices: impl Iterator<Item = u32>,
    ) -> Option<Index<Accessor>> {
        let bytes = indices.flat_map(u32::to_le_bytes);
        let view = self.view(bytes, Some(Target::ElementArrayBuffer))?;
        Some(self.accessor(Some(view), Type::Scalar, ComponentType::U32))
    }

    pub(super) fn node(&mut self, name: &str, primitive: Primitive) -> usize {
        let mesh = self.root.push(gltf_json::Mesh {
            extensions: None,
            extras: None,
            name: Some(name.to_owned()),
            primitives: vec![primitive],
            weights: None,
        });
        let node = self.root.push(gltf_json::Node {
            mesh: Some(mesh),
            name: Some(name.to_owned()),
            ..gltf_json::Node::default()
        });
        self.nodes.push(node);
        node.value()
    }

    /// How many nodes stand in the scene itself.
    pub(super) fn root_count(&self) -> usize {
        self.nodes.len()
    }

    /// Hangs the nodes of the scene from number `first` on below a new one.
    pub(super) fn gather(&mut self, name: &str, first: usize) -> usize {
        let children = self.nodes.split_off(first);
        let node = self.root.push(gltf_json::Node {
            children: (!children.is_empty()).then_some(children),
            name: Some(name.to_owned()),
            ..gltf_json::Node::default()
        });
        self.nodes.push(node);
        node.value()
    }

    /// Leaves only the first `count` nodes in the scene itself.
    pub(super) fn keep_roots(&mut self, count: usize) {
        self.nodes.truncate(count);
    }

    /// A material of one colour.
    pub(super) fn plain_material(
        &mut self,
        material: &Material,
        alpha_mode: AlphaMode,
    ) -> Index<gltf_json::Material> {
        self.material_with(material, alpha_mode, None)
    }

    pub(super) fn material(
        &mut self,
        material: &'p Material,
        alpha_mode: AlphaMode,
    ) -> Index<gltf_json::Material> {
        let texture = material.texture.as_ref().map(|image| texture::Info {
            index: self.texture(image, &material.name),
            tex_coord: 0,
            extensions: None,
            extras: None,
        });
        self.material_with(material, alpha_mode, texture)
    }

    fn material_with(
        &mut self,
        material: &Material,
        alpha_mode: AlphaMode,
        texture: Option<texture::Info>,
    ) -> Index<gltf_json::Material> {
        // What glTF allows; the exact numbers are in the record.
        let base_color = material.base_color.map(|channel| channel.min(1.0));
        let is_leaf = alpha_mode == AlphaMode::Mask;
        self.root.push(gltf_json::Material {
            name: Some(material.name.clone()),
            alpha_mode: Checked::Valid(alpha_mode),
            alpha_cutoff: is_leaf.then_some(AlphaCutoff(material.alpha_cutoff)),
            double_sided: is_leaf,
            pbr_metallic_roughness: PbrMetallicRoughness {
                base_color_factor: PbrBaseColorFactor(base_color),
                base_color_texture: texture,
                metallic_factor: StrengthFactor(0.0),
                ..PbrMetallicRoughness::default()
            },
            ..gltf_json::Material::default()
        })
    }

    /// The texture of an image; equal images are written once.
    fn texture(&mut self, image: &'p Texture, name: &str) -> Index<texture::Texture> {
        let known = self.textures.iter().find(|(known, _)| *known == image);
        if let Some((_, index)) = known {
            return *index;
        }
        let view = self.view(encode_png(image), None);
        while !self.binary.len().is_multiple_of(4) {
            self.binary.push(0);
        }
        let source = self.root.push(gltf_json::Image {
            buffer_view: view,
            mime_type: Some(MimeType("image/png".to_owned())),
            name: Some(name.to_owned()),
            uri: None,
            extensions: None,
            extras: None,
        });
        let index = self.root.push(texture::Texture {
            name: None,
            sampler: None,
            source,
            extensions: None,
            extras: None,
        });
        self.textures.push((image, index));
        index
    }

    /// The document, whose scene has that name, and its binary chunk; a record is kept in extras.
    pub(super) fn finish(mut self, name: &str, record: Option<Record>) -> (Root, Vec<u8>) {
        if !self.binary.is_empty() {
            self.root.buffers.push(Buffer {
                byte_length: USize64::from(self.binary.len()),
                name: None,
                uri: None,
                extensions: None,
                extras: None,
            });
        }
        // A scene must have a node; without a scene nothing is shown either.
        if !self.nodes.is_empty() {
            let scene = self.root.push(gltf_json::Scene {
                extensions: None,
                extras: None,
                name: Some(name.to_owned()),
                nodes: self.nodes,
            });
            self.root.scene = Some(scene);
        }
        self.root.asset.generator = Some(concat!("spinney ", env!("CARGO_PKG_VERSION")).to_owned());
        if record.is_some() {
            let extras = serde_json::value::to_raw_value(&Envelope { spinney: record });
            self.root.extras = Some(extras.expect("names, numbers and lists have a JSON form"));
        }
        (self.root, self.binary)
    }
}

fn to_json(root: &Root) -> Vec<u8> {
    root.to_vec()
        .expect("names, numbers and lists have a JSON form")
}

fn material_numbers(material: &Material) -> Vec<u32> {
    let numbers = material.base_color.iter().chain([&material.alpha_cutoff]);
    numbers.map(|number| number.to_bits()).collect()
}

pub(super) fn primitive(
    attributes: impl IntoIterator<Item = (Semantic, Index<Accessor>)>,
    indices: Option<Index<Accessor>>,
    material: Index<gltf_json::Material>,
    mode: Mode,
) -> Primitive {
    let attributes = attributes.into_iter();
    let attributes: BTreeMap<_, _> = attributes
        .map(|(semantic, index)| (Checked::Valid(semantic), index))
        .collect();
    Primitive {
        attributes,
        extensions: None,
        extras: None,
        indices,
        material: Some(material),
        mode: Checked::Valid(mode),
        targets: None,
    }
}

/// A texture as a PNG file, texel for texel.
pub(in crate::plant) fn encode_png(texture: &Texture) -> Vec<u8> {
    let mut bytes = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    let (width, height) = (texture.width(), texture.height());
    encoder
        .write_image(
            texture.rgba(),
            width,
            height,
            image::ExtendedColorType::Rgba8,
        )
        .expect("a texture has the bytes its size asks for, and memory takes them all");
    bytes
}
