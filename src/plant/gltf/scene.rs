//! From a document's nodes to a list of primitives, each with its place in the world.

use super::error::Fault;
use super::placement::Placement;
use crate::limits::PLACED_PRIMITIVES;
use crate::plant::import::mesh::{Names, listed, says_leaves};
use crate::plant::import::{ImportReport, ReportKind};
use gltf_json::Root;
use std::collections::BTreeSet;

/// One primitive of a mesh, where one node puts it.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    pub(super) node: usize,
    pub(super) mesh: usize,
    pub(super) primitive: usize,
    pub(super) placement: Placement,
    /// Whether one of the names that the user gave applies.
    pub(super) named: bool,
    /// Whether the name of its node or mesh says that it is leaves.
    pub(super) name_says: bool,
    pub(super) material: Option<usize>,
}

impl Placed {
    /// The JSON pointer of the primitive.
    pub(super) fn pointer(&self) -> String {
        format!("/meshes/{}/primitives/{}", self.mesh, self.primitive)
    }
}

/// All primitives of the default scene (or else the first, or else of all nodes), in the order of
/// a walk that visits parents before children and children as they are listed.
pub(super) fn place(
    root: &Root,
    names: &mut Names<'_>,
    report: &mut ImportReport,
) -> Result<Vec<Placed>, Fault> {
    let mut stack = scene_roots(root, report)?;
    stack.reverse();
    let mut visited = vec![false; root.nodes.len()];
    let mut placed = Vec::new();
    while let Some(step) = stack.pop() {
        let index = step.node;
        let Some(node) = root.nodes.get(index) else {
            return Err(Fault::index(
                step.pointer(),
                "node",
                index,
                root.nodes.len(),
            ));
        };
        if std::mem::replace(&mut visited[index], true) {
            let message =
                format!("reaches node {index} again: a cycle, or a node with two parents");
            return Err(Fault::new(step.pointer(), message));
        }
        let placement = step.placement.child(&Placement::of(node, index)?);
        let named = names.has(node.name.as_deref()) || step.named;
        if let Some(mesh) = node.mesh {
            // A skinned mesh is placed by its joints alone.
            let placement = if node.skin.is_some() {
                let message =
                    "skins: taken as modelled, without joints and without the node's place";
                report.add(
                    ReportKind::Ignored,
                    1,
                    format!("/nodes/{index}/skin"),
                    message,
                );
                Placement::IDENTITY
            } else {
                placement
            };
            let mesh = (mesh.value(), index);
            let hints = (named, says_leaves(node.name.as_deref()));
            place_mesh(root, mesh, placement, hints, names, &mut placed)?;
        }
        let children = node.children.as_deref().unwrap_or_default();
        for (place, child) in children.iter().enumerate().rev() {
            stack.push(Step {
                node: child.value(),
                parent: Some((index, place)),
                scene: step.scene,
                placement,
                named,
            });
        }
    }
    let skipped = visited.iter().filter(|&&visited| !visited).count();
    report.add(
        ReportKind::Dropped,
        skipped as u64,
        "/nodes",
        "nodes that do not belong to the scene",
    );
    Ok(placed)
}

fn place_mesh(
    root: &Root,
    (index, node): (usize, usize),
    placement: Placement,
    (named, name_says): (bool, bool),
    names: &mut Names<'_>,
    placed: &mut Vec<Placed>,
) -> Result<(), Fault> {
    let pointer = format!("/nodes/{node}/mesh");
    let Some(mesh) = root.meshes.get(index) else {
        return Err(Fault::index(pointer, "mesh", index, root.meshes.len()));
    };
    let named = names.has(mesh.name.as_deref()) || named;
    let name_says = says_leaves(mesh.name.as_deref()) || name_says;
    for (primitive, content) in mesh.primitives.iter().enumerate() {
        let material = content.material.map(|material| material.value());
        let material_name = match material.map(|material| (material, root.materials.get(material)))
        {
            None => None,
            Some((_, Some(material))) => material.name.as_deref(),
            Some((material, None)) => {
                let pointer = format!("/meshes/{index}/primitives/{primitive}/material");
                return Err(Fault::index(
                    pointer,
                    "material",
                    material,
                    root.materials.len(),
                ));
            }
        };
        let label = primitive_label(mesh.name.as_deref(), primitive);
        let named = names.has(material_name) || names.has(label.as_deref()) || named;
        if placed.len() == PLACED_PRIMITIVES {
            let message = format!(
                "places primitive number {}, but the limit is {PLACED_PRIMITIVES}; join meshes first",
                placed.len() + 1
            );
            return Err(Fault::new(pointer, message));
        }
        placed.push(Placed {
            node,
            mesh: index,
            primitive,
            placement,
            named,
            name_says,
            material,
        });
    }
    Ok(())
}

struct Step {
    node: usize,
    parent: Option<(usize, usize)>,
    scene: Option<(usize, usize)>,
    placement: Placement,
    named: bool,
}

impl Step {
    fn pointer(&self) -> String {
        match (self.parent, self.scene) {
            (Some((node, place)), _) => format!("/nodes/{node}/children/{place}"),
            (None, Some((scene, place))) => format!("/scenes/{scene}/nodes/{place}"),
            (None, None) => format!("/nodes/{}", self.node),
        }
    }
}

fn scene_roots(root: &Root, report: &mut ImportReport) -> Result<Vec<Step>, Fault> {
    let step = |node: usize, scene: Option<(usize, usize)>| Step {
        node,
        parent: None,
        scene,
        placement: Placement::IDENTITY,
        named: false,
    };
    let scene = root.scene.map(|scene| scene.value());
    if let Some(index) = scene
        && index >= root.scenes.len()
    {
        return Err(Fault::index("/scene", "scene", index, root.scenes.len()));
    }
    if root.scenes.len() > 1 {
        let message = "scenes other than the default one";
        report.add(
            ReportKind::Dropped,
            root.scenes.len() as u64 - 1,
            "/scenes",
            message,
        );
    }
    let index = scene.unwrap_or(0);
    let Some(scene) = root.scenes.get(index) else {
        let mut is_child = vec![false; root.nodes.len()];
        for child in root
            .nodes
            .iter()
            .flat_map(|node| node.children.iter().flatten())
        {
            if let Some(is_child) = is_child.get_mut(child.value()) {
                *is_child = true;
            }
        }
        let roots = (0..root.nodes.len()).filter(|&node| !is_child[node]);
        let message = "no scene: all nodes without a parent are taken";
        report.add(
            ReportKind::Guessed,
            root.nodes.len() as u64,
            "/nodes",
            message,
        );
        return Ok(roots.map(|node| step(node, None)).collect());
    };
    let nodes = scene.nodes.iter().enumerate();
    Ok(nodes
        .map(|(place, node)| step(node.value(), Some((index, place))))
        .collect())
}

/// The names that a document has, for the user to choose from.
pub(super) fn known_names(root: &Root) -> String {
    let nodes = root.nodes.iter().filter_map(|node| node.name.clone());
    let meshes = root.meshes.iter().filter_map(|mesh| mesh.name.clone());
    let materials = root
        .materials
        .iter()
        .filter_map(|material| material.name.clone());
    let primitives = root.meshes.iter().filter(|mesh| mesh.primitives.len() > 1);
    let primitives = primitives.flat_map(|mesh| {
        let count = mesh.primitives.len();
        (0..count).filter_map(|index| primitive_label(mesh.name.as_deref(), index))
    });
    let names: BTreeSet<String> = nodes
        .chain(meshes)
        .chain(materials)
        .chain(primitives)
        .collect();
    listed(&names)
}

fn primitive_label(mesh: Option<&str>, index: usize) -> Option<String> {
    mesh.map(|mesh| format!("{mesh}#{index}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec3, Vec3};

    fn walk(json: &str, names: &[&str]) -> Result<Vec<Placed>, Fault> {
        let json = format!(r#"{{"asset":{{"version":"2.0"}},{json}}}"#);
        let root = Root::from_str(&json).unwrap();
        let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
        place(&root, &mut Names::new(&names), &mut ImportReport::default())
    }

    const MESHES: &str =
        r#""meshes":[{"name":"m","primitives":[{"attributes":{}},{"attributes":{}}]}]"#;

    #[test]
    fn matrices_multiply_down_the_tree() {
        let json = format!(
            r#"{MESHES},"nodes":[{{"translation":[1,0,0],"children":[1]}},
            {{"scale":[2,2,2],"translation":[0,3,0],"mesh":0}}],"scenes":[{{"nodes":[0]}}]"#
        );
        let placed = walk(&json, &[]).unwrap();
        assert_eq!(placed.len(), 2);
        let point = placed[0].placement.point64(Vec3::ONE);
        assert_eq!(point, DVec3::new(3.0, 5.0, 2.0));
        assert_eq!(placed[1].pointer(), "/meshes/0/primitives/1");
    }

    #[test]
    fn cycles_and_bad_indices_are_named() {
        for (nodes, pointer) in [
            (r#"{"children":[0]}"#, "/nodes/0/children/0"),
            (
                r#"{"children":[1]},{"children":[2]},{"children":[1]}"#,
                "/nodes/2/children/0",
            ),
            (r#"{"children":[1,1]},{}"#, "/nodes/0/children/1"),
            (r#"{"children":[7]}"#, "/nodes/0/children/0"),
            (r#"{"mesh":1}"#, "/nodes/0/mesh"),
        ] {
            let json = format!(r#"{MESHES},"nodes":[{nodes}],"scenes":[{{"nodes":[0]}}]"#);
            assert_eq!(walk(&json, &[]).unwrap_err().pointer, pointer);
        }
        let json = r#""nodes":[{}],"scenes":[{"nodes":[0]}],"scene":3"#;
        assert_eq!(walk(json, &[]).unwrap_err().pointer, "/scene");
    }

    #[test]
    fn a_deep_chain_takes_no_stack() {
        let links: Vec<String> = (1..20_000)
            .map(|n| format!(r#"{{"children":[{n}]}}"#))
            .collect();
        let json = format!(
            r#"{MESHES},"nodes":[{},{{"mesh":0}}],"scenes":[{{"nodes":[0]}}]"#,
            links.join(",")
        );
        assert_eq!(walk(&json, &[]).unwrap().len(), 2);
    }

    #[test]
    fn names_of_nodes_reach_down_and_primitives_have_labels() {
        let json = format!(
            r#"{MESHES},"nodes":[{{"name":"crown","children":[1]}},{{"mesh":0}}],
            "scenes":[{{"nodes":[0]}}]"#
        );
        let named = |names: &[&str]| {
            let placed = walk(&json, names).unwrap();
            [placed[0].named, placed[1].named]
        };
        assert_eq!(named(&["crown"]), [true, true]);
        assert_eq!(named(&["m#1"]), [false, true]);
        assert_eq!(named(&["x"]), [false, false]);
    }
}
