//! What a frame draws, for other renderers: its triangles, textures and camera.
//!
//! ```text
//! World + states ─┬─ leaves of each state ─┐
//!                 ├─ trunks at their level ├─▶ meshes at their places ─▶ .glb
//!                 └─ ground                ┘
//! View ─▶ camera JSON
//! ```

use super::{SessionOptions, World};
use crate::limits;
use crate::math::{Mat4, Vec2, Vec3, index_u32};
use crate::models::{Crown, Kind, Placement, State, TreeState, Trunk, TrunkLevel};
use crate::plant::gltf::{ExportError, InstancedMesh, MeshPlace, TextureRim, export_instances};
use crate::plant::{Material, Mesh};
use crate::scene::View;
use crate::simplify::{BranchLevel, BranchMesh};

/// A frame's triangles and camera as files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameExport {
    /// A binary glTF file, as of [`export_instances`].
    pub glb: Vec<u8>,
    /// The camera, as of [`camera_json`].
    pub camera: String,
}

/// What is drawn of a world in these states, one a tree, by a session of these options.
///
/// Trees of one plant that show the same leaves share a mesh, and so do trunks at the same level. A leaf is
/// four vertices of its own, as programs read them (quantised ones where they come to lie), with triangles
/// 0-1-2 and 0-2-3; its normal is that of its diagonals. Leaves of several faces are three vertices of their
/// own a face, with its normal. Trunks and ground have the vertices that their triangles use. Needles are
/// drawn by no model, and are not there either; nor are cards that stand for leaves.
///
/// # Errors
///
/// When the file would be larger than what is read again.
pub fn export_frame(
    name: &str,
    world: &World,
    options: &SessionOptions,
    view: &View,
    states: &[TreeState],
) -> Result<FrameExport, ExportError> {
    let mut crowds = Vec::new();
    for (tree, state) in world.trees.iter().zip(states) {
        let place = place(&tree.placement);
        let foliage = Shown::Leaves(tree.crown, &state.foliage);
        join(&mut crowds, foliage, place);
        if world.trunks[tree.crown].is_some() {
            // One without levels is whole, whatever level its foliage is at.
            let level = match options.trunk.has_levels() {
                true => Some(state.trunk),
                false => None,
            };
            join(&mut crowds, Shown::Trunk(tree.crown, level), place);
        }
    }
    check_size(name, world, options, &crowds)?;
    let mut meshes = Vec::new();
    for Crowd { shown, places } in crowds {
        match shown {
            Shown::Leaves(number, state) => {
                let crown = &world.crowns[number];
                let positions = options.model.format.vertices.positions(crown);
                let leaves = drawn(crown, options, state);
                let quads = leaf_meshes(crown, &positions, &leaves);
                meshes.extend(quads.chain(face_meshes(crown)).map(|(name, mesh)| {
                    let (rim, places) = (TextureRim::Clamp, places.clone());
                    InstancedMesh {
                        name,
                        mesh,
                        rim,
                        places,
                    }
                }));
            }
            Shown::Trunk(number, level) => {
                let Some(trunk) = world.trunks[number].as_ref() else {
                    continue;
                };
                let shown = level.and_then(|level| options.trunk.shown_step(trunk, level));
                let parts = match shown {
                    Some(step) => branch_meshes(trunk, &trunk.branch_level(step)),
                    None => vec![("trunk", trunk_mesh(trunk, level))],
                };
                let plant = world.crowns[number].plant().name();
                meshes.extend(parts.into_iter().map(|(part, mesh)| InstancedMesh {
                    name: format!("{plant} {part}"),
                    mesh,
                    rim: TextureRim::Repeat,
                    places: places.clone(),
                }));
            }
        }
    }
    meshes.extend(world.ground.iter().map(|mesh| InstancedMesh {
        name: "ground".to_owned(),
        mesh: Mesh::clone(mesh),
        rim: TextureRim::Repeat,
        places: vec![place(&Placement::IDENTITY)],
    }));
    Ok(FrameExport {
        glb: export_instances(name, &meshes)?,
        camera: camera_json(view),
    })
}

/// What many trees may show alike.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shown<'a> {
    /// The leaves of a plant, by its number.
    Leaves(usize, &'a State),
    /// The trunk of a plant at a level, or without levels.
    Trunk(usize, Option<TrunkLevel>),
}

/// Something, and where it stands.
struct Crowd<'a> {
    shown: Shown<'a>,
    places: Vec<MeshPlace>,
}

fn join<'a>(crowds: &mut Vec<Crowd<'a>>, shown: Shown<'a>, place: MeshPlace) {
    match crowds.iter_mut().find(|crowd| crowd.shown == shown) {
        Some(crowd) => crowd.places.push(place),
        None => crowds.push(Crowd {
            shown,
            places: vec![place],
        }),
    }
}

fn place(placement: &Placement) -> MeshPlace {
    MeshPlace {
        position: placement.position,
        rotation: placement.rotation,
        scale: placement.scale,
    }
}

/// Refuses what would be far too large before it is built; the rest is counted once it is.
fn check_size(
    name: &str,
    world: &World,
    options: &SessionOptions,
    crowds: &[Crowd<'_>],
) -> Result<(), ExportError> {
    let bytes = |crowd: &Crowd<'_>| match crowd.shown {
        // Four vertices of 32 bytes, six indices.
        Shown::Leaves(number, state) => {
            let crown = &world.crowns[number];
            let leaves = match options.kind {
                Kind::LodfLiteral => crown.sequence().original_count(),
                _ => state.leaf_count(crown.clusters()),
            };
            // Three vertices and indices a face.
            152 * u64::from(leaves) + 108 * u64::from(crown.faces().face_count())
        }
        // Half a vertex a triangle, and three indices.
        Shown::Trunk(number, level) => world.trunks[number].as_ref().map_or(0, |trunk| {
            let level = level.unwrap_or(TrunkLevel::FINEST);
            28 * u64::from(options.trunk.triangle_count(trunk, level))
        }),
    };
    let bytes = crowds.iter().map(bytes).sum();
    if bytes > limits::PLANT_FILE_BYTES {
        return Err(ExportError::TooLarge {
            plant: name.to_owned(),
            bytes,
            limit: limits::PLANT_FILE_BYTES,
        });
    }
    Ok(())
}

/// The leaves that are drawn in a state.
fn drawn(crown: &std::sync::Arc<Crown>, options: &SessionOptions, state: &State) -> Vec<u32> {
    match options.kind {
        Kind::Full => (0..crown.sequence().original_count()).collect(),
        // What shows is not what should.
        Kind::LodfLiteral => options.kind.model(crown, options.model).drawn(state),
        _ => state.visible(crown.clusters()),
    }
}

/// A mesh for each group of a plant that some of the leaves belong to.
pub(super) fn leaf_meshes<'a>(
    crown: &'a Crown,
    positions: &'a [Vec3],
    leaves: &'a [u32],
) -> impl Iterator<Item = (String, Mesh)> + 'a {
    let mut first = 0;
    let groups = crown.plant().foliage().quad_groups();
    groups.filter_map(move |(group, texture_corners)| {
        let range = first..first + index_u32(group.positions.len());
        first = range.end;
        let sequence = crown.sequence();
        let of_group = leaves.iter().map(|&leaf| sequence.corners()[leaf as usize]);
        // Vertices that a collapse adds belong where the leaf does that is left of it.
        let of_group = of_group
            .filter(|corners| range.contains(&(4 * sequence.original_of_vertex(corners[0]))));
        let mut mesh = blank(&group.material);
        for corners in of_group {
            let quad = corners.map(|corner| positions[corner as usize]);
            let base = index_u32(mesh.positions.len());
            let normal = (quad[2] - quad[0]).cross(quad[3] - quad[1]);
            mesh.positions.extend(quad);
            // A leaf of no area has none; files want one.
            mesh.normals.extend([normal.normalize_or(Vec3::Y); 4]);
            mesh.texture_coordinates.extend(texture_corners);
            mesh.indices
                .extend([0, 1, 2, 0, 2, 3].map(|role| base + role));
        }
        let name = format!("{} {}", crown.plant().name(), group.name);
        (!mesh.indices.is_empty()).then_some((name, mesh))
    })
}

/// A mesh for each group of leaves of several faces.
pub(super) fn face_meshes(crown: &Crown) -> impl Iterator<Item = (String, Mesh)> + '_ {
    let groups = crown.plant().foliage().face_groups();
    groups.filter_map(|found| {
        let mut mesh = blank(&found.group.material);
        for leaf in 0..found.group.leaf_count() {
            let vertices = found.group.leaf(leaf);
            for triangle in found.triangles {
                let base = index_u32(mesh.positions.len());
                let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
                mesh.positions.extend([a, b, c]);
                let normal = (b - a).cross(c - a);
                mesh.normals.extend([normal.normalize_or(Vec3::Y); 3]);
                let coordinate = |vertex: u32| found.texture_coordinates[vertex as usize];
                mesh.texture_coordinates.extend(triangle.map(coordinate));
                mesh.indices.extend([0, 1, 2].map(|corner| base + corner));
            }
        }
        let name = format!("{} {}", crown.plant().name(), found.group.name);
        (!mesh.indices.is_empty()).then_some((name, mesh))
    })
}

/// The triangles of a trunk, with the vertices that they use.
pub(super) fn trunk_mesh(trunk: &Trunk, level: Option<TrunkLevel>) -> Mesh {
    let mesh = trunk.mesh();
    let corners: Vec<u32> = match level {
        None => mesh.indices.clone(),
        Some(level) => {
            let triangles = trunk.collapses().triangles_after(level.collapses());
            let order = trunk.collapses().order();
            triangles
                .flat_map(|(_, corners)| corners.map(|vertex| order[vertex as usize]))
                .collect()
        }
    };
    let mut used = corners.clone();
    used.sort_unstable();
    used.dedup();
    let mut small = blank(&mesh.material);
    for &vertex in &used {
        let vertex = vertex as usize;
        small.positions.push(mesh.positions[vertex]);
        small.normals.push(mesh.normals[vertex]);
        let coordinate: Vec2 = mesh.texture_coordinates[vertex];
        small.texture_coordinates.push(coordinate);
    }
    let number = |corner: &u32| index_u32(used.partition_point(|vertex| vertex < corner));
    small.indices = corners.iter().map(number).collect();
    small
}

/// The polygons of branches and of needles at an error; what are lines cannot be told as triangles.
pub(super) fn branch_meshes(trunk: &Trunk, level: &BranchLevel) -> Vec<(&'static str, Mesh)> {
    let bark = &trunk.mesh().material;
    let needles = trunk.needle_material().unwrap_or(bark);
    let parts = [
        ("branches", &level.branches, bark),
        ("needles", &level.needles, needles),
    ];
    let mesh = |(name, branches, material): (_, &BranchMesh, _)| {
        let mut mesh = blank(material);
        mesh.indices = branches.drawn_triangles().flatten().collect();
        for vertex in &branches.vertices {
            mesh.positions.push(vertex.position);
            mesh.normals.push(vertex.normal);
            mesh.texture_coordinates.push(vertex.texture);
        }
        (name, mesh)
    };
    let meshes = parts.into_iter().map(mesh);
    meshes
        .filter(|(_, mesh)| !mesh.indices.is_empty())
        .collect()
}

fn blank(material: &Material) -> Mesh {
    Mesh {
        positions: Vec::new(),
        normals: Vec::new(),
        texture_coordinates: Vec::new(),
        indices: Vec::new(),
        material: material.clone(),
    }
}

/// A camera as JSON: `width` and `height` in pixels, `view` (world to view space) and `proj` (view to
/// clip space) as 16 numbers each, columns first.
///
/// Clip space is OpenGL's, as other programs want it: `−w ≤ z ≤ w`. Ours has `0 ≤ z ≤ w`, so `proj`
/// has `2 z − w` for `z`. Every number reads back as the `f32` that it is.
#[must_use]
pub fn camera_json(view: &View) -> String {
    let [width, height] = view.viewport;
    let mut proj = view.clip_from_view;
    for column in 0..4 {
        let column = proj.col_mut(column);
        column.z = 2.0 * column.z - column.w;
    }
    let numbers = |matrix: Mat4| matrix.to_cols_array().map(f64::from);
    let camera = serde_json::json!({
        "width": width,
        "height": height,
        "view": numbers(view.view_from_world),
        "proj": numbers(proj),
    });
    format!("{camera:#}\n")
}
