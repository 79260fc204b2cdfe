//! glTF: what is written comes back; damaged files never panic.

use proptest::collection::vec;
use proptest::prelude::*;
use spinney::math::{Vec2, Vec3};
use spinney::plant::gltf::export_glb;
use spinney::plant::import::{ImportOptions, import_bytes};
use spinney::plant::{
    Branch, Foliage, LeafGroup, Material, Mesh, NO_BRANCH, Node, Plant, Prototype, Skeleton,
    Texture,
};

fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        Just(0.0),
        Just(-0.0),
        -10.0_f32..10.0,
        -1e30_f32..1e30,
        Just(f32::MIN_POSITIVE / 8.0)
    ]
}

fn positive() -> impl Strategy<Value = f32> {
    number().prop_map(f32::abs)
}

fn point() -> impl Strategy<Value = Vec3> {
    [number(), number(), number()].prop_map(Vec3::from_array)
}

fn corner() -> impl Strategy<Value = Vec2> {
    [number(), number()].prop_map(Vec2::from_array)
}

fn texture() -> impl Strategy<Value = Texture> {
    (1_u32..4, 1_u32..4).prop_flat_map(|(width, height)| {
        let bytes = 4 * (width * height) as usize;
        vec(any::<u8>(), bytes).prop_map(move |rgba| {
            Texture::new(width, height, rgba).expect("as many bytes as the size asks for")
        })
    })
}

fn material() -> impl Strategy<Value = Material> {
    let channels = [positive(), positive(), positive(), positive()];
    let texture = proptest::option::of(texture());
    (".{0,6}", channels, texture, positive()).prop_map(
        |(name, base_color, texture, alpha_cutoff)| Material {
            name,
            base_color,
            texture,
            alpha_cutoff,
        },
    )
}

fn prototype() -> impl Strategy<Value = Prototype> {
    let quad = [corner(), corner(), corner(), corner()];
    let faces = (0_usize..6).prop_flat_map(|count| {
        let most = u32::try_from(count).expect("at most 5");
        let index = 0..most.max(1);
        let triangles = vec(
            [index.clone(), index.clone(), index],
            0..if count == 0 { 1 } else { 4 },
        );
        (vec(corner(), count), triangles)
    });
    prop_oneof![
        quad.prop_map(|texture_corners| Prototype::Quad { texture_corners }),
        faces.prop_map(|(texture_coordinates, triangles)| Prototype::Faces {
            texture_coordinates,
            triangles
        }),
        positive().prop_map(|diameter| Prototype::Needle { diameter }),
    ]
}

fn group(branches: u32) -> impl Strategy<Value = LeafGroup> {
    let owner = prop_oneof![Just(NO_BRANCH), 0..branches.max(1)]
        .prop_map(move |owner| if branches == 0 { NO_BRANCH } else { owner });
    (".{0,6}", prototype(), material(), vec(owner, 0..5)).prop_flat_map(
        |(name, prototype, material, owners)| {
            let count = owners.len() * prototype.vertices_per_leaf();
            vec(point(), count).prop_map(move |positions| LeafGroup {
                name: name.clone(),
                prototype: prototype.clone(),
                material: material.clone(),
                positions,
                owners: owners.clone(),
            })
        },
    )
}

fn skeleton() -> impl Strategy<Value = Skeleton> {
    let nodes = vec((point(), positive()), 1..4);
    vec((nodes, any::<u32>(), 0_u32..9), 0..4).prop_map(|branches| {
        let mut skeleton = Skeleton::default();
        for (nodes, bearer, level) in branches {
            let first_node = u32::try_from(skeleton.nodes.len()).expect("at most 12");
            skeleton.branches.push(Branch {
                bearer: bearer.checked_rem(first_node),
                level,
                first_node,
                node_count: u32::try_from(nodes.len()).expect("at most 3"),
            });
            let nodes = nodes.into_iter();
            skeleton
                .nodes
                .extend(nodes.map(|(position, radius)| Node { position, radius }));
        }
        skeleton
    })
}

fn trunk() -> impl Strategy<Value = Mesh> {
    let vertices = vec((point(), point(), corner()), 0..7);
    (vertices, vec(any::<[u32; 3]>(), 0..5), material()).prop_map(
        |(vertices, triangles, material)| {
            let count = u32::try_from(vertices.len()).expect("at most 6");
            let indices = triangles.into_iter().flatten();
            Mesh {
                positions: vertices.iter().map(|vertex| vertex.0).collect(),
                normals: vertices.iter().map(|vertex| vertex.1).collect(),
                texture_coordinates: vertices.iter().map(|vertex| vertex.2).collect(),
                indices: indices
                    .filter_map(|index| index.checked_rem(count))
                    .collect(),
                material,
            }
        },
    )
}

fn plant() -> impl Strategy<Value = Plant> {
    let skeleton = proptest::option::of(skeleton());
    (".{0,6}", skeleton, proptest::option::of(trunk())).prop_flat_map(|(name, skeleton, trunk)| {
        let branches = skeleton
            .as_ref()
            .map_or(0, |skeleton| skeleton.branches.len());
        let branches = u32::try_from(branches).expect("at most 3");
        vec(group(branches), 0..5).prop_map(move |groups| {
            let (name, skeleton, trunk) = (name.clone(), skeleton.clone(), trunk.clone());
            Plant::new(name, skeleton, trunk, Foliage { groups }).expect("sound by construction")
        })
    })
}

/// A small plant with a texture, a skeleton and two kinds of leaf.
fn sample() -> Plant {
    let texture = Texture::new(2, 2, (0..16).collect()).expect("sixteen bytes");
    let material = Material {
        texture: Some(texture),
        alpha_cutoff: 0.5,
        ..Material::plain("leaf", [0.2, 0.4, 0.1])
    };
    let corners = Prototype::WHOLE_IMAGE.map(|corner| corner.extend(0.0));
    let node = |y: f32| Node {
        position: y * Vec3::Y,
        radius: 0.1,
    };
    let branch = Branch {
        bearer: None,
        level: 0,
        first_node: 0,
        node_count: 2,
    };
    let group = |prototype: Prototype| LeafGroup {
        name: "leaves".to_owned(),
        prototype,
        material: material.clone(),
        positions: corners.to_vec(),
        owners: vec![0; 1],
    };
    let quad = group(Prototype::Quad {
        texture_corners: Prototype::WHOLE_IMAGE,
    });
    let mut needles = group(Prototype::Needle { diameter: 0.001 });
    needles.owners = vec![0, NO_BRANCH];
    let skeleton = Skeleton {
        nodes: vec![node(0.0), node(1.0)],
        branches: vec![branch],
    };
    let trunk = Mesh {
        positions: corners.to_vec(),
        normals: vec![Vec3::Z; 4],
        texture_coordinates: Prototype::WHOLE_IMAGE.to_vec(),
        indices: vec![0, 1, 2, 0, 2, 3],
        material: Material::plain("bark", [0.3, 0.2, 0.1]),
    };
    let groups = vec![quad, needles];
    Plant::new("sample", Some(skeleton), Some(trunk), Foliage { groups }).expect("a sound plant")
}

crate::support::properties! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn what_is_written_comes_back(plant in plant()) {
        let glb = export_glb(&plant).expect("small plants fit");
        prop_assert_eq!(glb.len() % 4, 0);
        let imported = import_bytes("a.glb", &glb, None, &ImportOptions::default());
        let imported = imported.expect("what is written can be read");
        prop_assert!(imported.report.native, "{}", imported.report);
        prop_assert_eq!(imported.plant.digest(), plant.digest());
        prop_assert_eq!(export_glb(&imported.plant).expect("again"), glb);
    }

    #[test]
    fn without_the_extras_the_file_is_read_like_any_other(plant in plant()) {
        let glb = export_glb(&plant).expect("small plants fit");
        let text = b"\"spinney\":";
        let at = glb.windows(text.len()).position(|window| window == text).expect("our extras");
        let mut foreign = glb;
        foreign[at + 1] = b'S';
        let imported = import_bytes("a.glb", &foreign, None, &ImportOptions::default());
        let imported = imported.expect("a sound file");
        prop_assert!(!imported.report.native);
        let first = export_glb(&imported.plant).expect("small plants fit");
        let again = import_bytes("a.glb", &first, None, &ImportOptions::default());
        prop_assert_eq!(again.expect("ours").plant.digest(), imported.plant.digest());
    }
}

crate::support::properties! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn damaged_files_are_refused_or_read_but_never_panic(
        bytes in vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        words in vec((any::<prop::sample::Index>(), any::<u32>()), 0..2),
        cut in proptest::option::weighted(0.2, any::<prop::sample::Index>()),
        named in any::<bool>(),
    ) {
        let mut glb = export_glb(&sample()).expect("a small plant");
        for (index, byte) in bytes {
            let at = index.index(glb.len());
            glb[at] = byte;
        }
        for (index, word) in words {
            let at = index.index(glb.len() / 4) * 4;
            glb[at..at + 4].copy_from_slice(&word.to_le_bytes());
        }
        if let Some(cut) = cut {
            glb.truncate(cut.index(glb.len()));
        }
        let foliage = if named { vec!["leaf".to_owned()] } else { Vec::new() };
        let options = ImportOptions { foliage, ..ImportOptions::default() };
        let imported = import_bytes("a.glb", &glb, None, &options);
        if let Ok(imported) = imported {
            prop_assert!(export_glb(&imported.plant).is_ok());
        }
    }

    #[test]
    fn damaged_digits_are_refused_or_read_but_never_panic(
        digits in vec((any::<prop::sample::Index>(), b'0'..=b'9'), 1..4),
    ) {
        // Bytes at random seldom leave the JSON readable; digits for digits always do.
        let mut glb = export_glb(&sample()).expect("a small plant");
        let size = u32::from_le_bytes([glb[12], glb[13], glb[14], glb[15]]) as usize;
        let places: Vec<usize> = (20..20 + size).filter(|&at| glb[at].is_ascii_digit()).collect();
        for (index, digit) in digits {
            glb[places[index.index(places.len())]] = digit;
        }
        let imported = import_bytes("a.glb", &glb, None, &ImportOptions::default());
        if let Err(error) = imported {
            prop_assert!(error.to_string().starts_with("a.glb:"), "{}", error);
        }
    }
}
