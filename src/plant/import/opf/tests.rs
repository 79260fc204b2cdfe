//! OPF documents and OPS tables, written piece by piece.

use crate::math::Vec3;
use crate::plant::import::{
    Format, ImportError, ImportOptions, Imported, Reading, ReportKind, Unit, import, import_bytes,
};
use crate::plant::{LeafGroup, NO_BRANCH, Prototype};

/// A reference cylinder of four sides, a card, and a bent leaf of five corners.
const TABLES: &str = r#"<meshBDD>
  <mesh Id="0" enableScale="true"><points>0 0.5 0 0 0 0.5 0 -0.5 0 0 0 -0.5
    1 0.5 0 1 0 0.5 1 -0.5 0 1 0 -0.5</points>
    <faces><face Id="0">0 1 5 4</face><face Id="1">1 2 6 5</face></faces></mesh>
  <mesh Id="7" enableScale="true"><points>0 -0.5 0 1 -0.5 0 1 0.5 0 0 0.5 0</points>
    <textureCoords>0 0 0 1 1 1 1 0</textureCoords><faces><face Id="0">0 1 2 3</face></faces></mesh>
  <mesh Id="8"><points>0 -0.5 0 1 -0.5 0 1 0.5 0 0 0.5 0 2 0 1</points>
    <faces><face Id="0">0 1 2 3</face><face Id="1">1 4 2</face></faces></mesh>
</meshBDD><materialBDD>
  <material Id="1"><diffuse>0 1 0 1</diffuse></material>
  <material Id="2"><diffuse>0.5 0.25 0 1</diffuse><texture>a.png</texture></material>
</materialBDD><shapeBDD>
  <shape Id="0"><name>stem</name><meshIndex>0</meshIndex><materialIndex>2</materialIndex></shape>
  <shape Id="1"><name>leaf</name><meshIndex>7</meshIndex><materialIndex>1</materialIndex></shape>
  <shape Id="2"><name>petal</name><meshIndex>8</meshIndex><materialIndex>9</materialIndex></shape>
</shapeBDD>"#;

/// An upright internode of 100 cm from a height on, and one that leans along x from a height on.
const UP: &str = "0 0 -1 0 0 1 0 0 100 0 0 ";
const ALONG: &str = "100 0 0 0 0 1 0 0 0 0 1 ";

fn geometry(shape: u32, matrix: &str, height: f32, [below, above]: [f32; 2]) -> String {
    format!(
        "<geometry class=\"Mesh\"><shapeIndex>{shape}</shapeIndex><mat>{matrix}{height}</mat>\
         <dUp>{above}</dUp><dDwn>{below}</dDwn></geometry>"
    )
}

fn entity(kind: &str, class: &str, scale: u32, content: &str) -> String {
    format!("<{kind} class=\"{class}\" scale=\"{scale}\" id=\"1\">{content}</{kind}>")
}

fn document(topology: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<opf version=\"2.0\" editable=\"true\">{TABLES}\n<topology class=\"Scene\" \
         scale=\"0\" id=\"1\">{topology}</topology></opf>"
    )
}

fn load(text: &str) -> Result<Imported, ImportError> {
    import_bytes(
        "plant.opf",
        text.as_bytes(),
        None,
        &ImportOptions::default(),
    )
}

fn read(topology: &str) -> Imported {
    load(&document(topology)).expect("sound")
}

fn error(text: &str) -> String {
    load(text).unwrap_err().to_string()
}

fn said(imported: &Imported) -> String {
    let entries: Vec<String> = imported
        .report
        .entries
        .iter()
        .map(ToString::to_string)
        .collect();
    entries.join("\n")
}

/// Bearer, and nodes as x, y, z, radius.
fn branches(imported: &Imported) -> Vec<(Option<u32>, Vec<[f32; 4]>)> {
    let skeleton = imported.plant.skeleton().expect("wood");
    let nodes = |branch| {
        let nodes = skeleton.nodes_of(branch).iter();
        nodes
            .map(|node| {
                let [x, y, z] = node.position.to_array();
                [x, y, z, node.radius].map(|number| (number * 1000.0).round() / 1000.0 + 0.0)
            })
            .collect()
    };
    let branches = skeleton.branches.iter();
    branches
        .map(|branch| (branch.bearer, nodes(branch)))
        .collect()
}

/// A stem of two internodes, of which the first bears a branch and the second a leaf; `nested` tells whether
/// the second is the first's child or its sibling.
fn stem(nested: bool) -> String {
    let leaf = geometry(1, "20 0 0 0 0 1 0 0 0 0 1 ", 150.0, [10.0, 30.0]);
    let leaf = entity("branch", "Leaf", 3, &leaf);
    let second = geometry(0, UP, 100.0, [8.0, 4.0]) + &leaf;
    let second = entity("follow", "Internode", 3, &second);
    let twig = entity(
        "decomp",
        "Internode",
        3,
        &geometry(0, ALONG, 100.0, [2.0, 2.0]),
    );
    let twig = entity("branch", "Axis", 2, &twig);
    let lateral = entity(
        "branch",
        "Internode",
        3,
        &geometry(0, ALONG, 100.0, [3.0, 2.0]),
    );
    let first =
        "<Length>1</Length><Width>0.1</Width>".to_owned() + &geometry(0, UP, 0.0, [10.0, 8.0]);
    let axis = if nested {
        entity("decomp", "Internode", 3, &(first + &lateral + &second))
    } else {
        entity("decomp", "Internode", 3, &(first + &lateral)) + &second
    };
    let axis = entity("decomp", "Axis", 2, &axis);
    entity(
        "decomp",
        "Individual",
        1,
        &(axis + if nested { "" } else { &twig }),
    )
}

#[test]
fn internodes_follow_as_children_or_as_siblings() {
    for nested in [true, false] {
        let imported = read(&stem(nested));
        assert_eq!(imported.report.format, Some(Format::Opf));
        let found = branches(&imported);
        assert_eq!(
            found[..2],
            [
                (
                    None,
                    vec![
                        [0.0, 0.0, 0.0, 0.05],
                        [0.0, 1.0, 0.0, 0.04],
                        [0.0, 2.0, 0.0, 0.02]
                    ]
                ),
                (Some(1), vec![[0.0, 1.0, 0.0, 0.015], [1.0, 1.0, 0.0, 0.01]]),
            ],
            "{nested}"
        );
        assert_eq!(found.len(), if nested { 2 } else { 3 });
        let trunk = imported.plant.trunk().expect("wood has a mesh");
        assert_eq!(trunk.material.name, "material 2");
        // sRGB 64 of 255 is 0.0513 linear.
        assert!((trunk.material.base_color[1] - 0.0513).abs() < 1e-4);
        let group = &imported.plant.foliage().groups[0];
        assert_eq!(
            (group.name.as_str(), group.owners.as_slice()),
            ("leaf", &[0][..])
        );
        assert!(matches!(group.prototype, Prototype::Quad { .. }));
        // Widened from 10 to 30 cm along its 20 cm; z up becomes y, y becomes −z.
        let wanted = [
            Vec3::new(0.0, 1.5, 0.05),
            Vec3::new(0.0, 1.5, -0.05),
            Vec3::new(0.2, 1.5, -0.15),
            Vec3::new(0.2, 1.5, 0.15),
        ];
        for wanted in wanted {
            let near = group
                .leaf(0)
                .iter()
                .any(|corner| corner.distance(wanted) < 1e-6);
            assert!(near, "{wanted} is not in {:?}", group.leaf(0));
        }
        let report = &imported.report;
        assert_eq!(
            [report.found("organs"), report.found("internodes")],
            if nested { [4, 3] } else { [5, 4] }
        );
        let said = said(&imported);
        assert!(said.contains("ignored: attributes of organs: their shape is told by mesh and matrix (2, first at line"), "{said}");
        assert!(
            said.contains("not understood: parts of materials other than colours and shininess"),
            "{said}"
        );
    }
}

#[test]
fn leaves_of_one_shape_are_one_group_and_other_meshes_are_leaves_too() {
    let leaf = |shape: u32, height: f32| {
        let geometry = geometry(shape, "20 0 0 0 0 20 0 0 0 0 20 ", height, [1.0, 1.0]);
        entity("branch", "Organ", 3, &geometry)
    };
    let imported = read(&[leaf(1, 0.0), leaf(2, 10.0), leaf(1, 20.0), leaf(2, 30.0)].concat());
    let groups = &imported.plant.foliage().groups;
    let counts: Vec<usize> = groups.iter().map(LeafGroup::leaf_count).collect();
    assert_eq!(counts, [2, 2]);
    assert_eq!(groups[1].prototype.triangles_per_leaf(), 3);
    // Not widened where the mesh does not say so.
    assert!(groups[1].leaf(0)[4].distance(Vec3::new(0.4, 0.3, 0.0)) < 1e-6);
    assert_eq!(groups[1].owners, [NO_BRANCH; 2]);
    assert_eq!(imported.plant.trunk(), None);
    let said = said(&imported);
    assert!(said.contains("guessed: organs that are no cylinders, but not called leaves: taken as foliage (2, first at line"), "{said}");
    assert!(
        said.contains("missing: materials that shapes name, but materialBDD lacks: white"),
        "{said}"
    );
    assert_eq!(
        (imported.report.quad_leaves, imported.report.other_leaves),
        (2, 2)
    );
}

#[test]
fn names_and_units_are_told() {
    let options = ImportOptions {
        reading: Reading {
            unit: Some(Unit::M),
            ..Reading::default()
        },
        foliage: vec!["Internode".to_owned()],
        ..ImportOptions::default()
    };
    let load = |options: &ImportOptions| {
        import_bytes("plant.opf", document(&stem(true)).as_bytes(), None, options)
    };
    let imported = load(&options).expect("sound");
    assert_eq!(imported.plant.foliage().leaf_count(), 4);
    assert!(imported.plant.bounds().max.y > 199.0);
    assert_eq!(imported.report.of_kind(ReportKind::Merged).count(), 1);
    let options = ImportOptions {
        foliage: vec!["Blade".to_owned()],
        ..ImportOptions::default()
    };
    assert_eq!(
        load(&options).unwrap_err().to_string(),
        "plant.opf: nothing is named \"Blade\"; there are: \"Internode\", \"Leaf\", \"leaf\", \"stem\""
    );
}

#[test]
fn deep_topologies_take_no_stack() {
    let depth = 50_000;
    let internode = |height: usize| {
        let matrix = format!("0 0 -1 0 0 1 0 0 1 0 0 {height}");
        format!(
            "<follow class=\"I\" scale=\"3\"><geometry><shapeIndex>0</shapeIndex><mat>{matrix}</mat><dUp>1</dUp></geometry>"
        )
    };
    let text: String = (0..depth).map(internode).collect();
    let imported = read(&(text + &"</follow>".repeat(depth)));
    let skeleton = imported.plant.skeleton().expect("wood");
    assert_eq!(
        (skeleton.branches.len(), skeleton.nodes.len()),
        (1, depth + 1)
    );
}

#[test]
fn what_is_wrong_is_named_with_line_and_column() {
    let organ = entity("decomp", "I", 3, &geometry(0, UP, 0.0, [1.0, 1.0]));
    let sound = document(&organ);
    load(&sound).expect("sound");
    for (old, new, wanted) in [
        ("<opf version", "<obf version", "plant.opf:"),
        ("</topology>", "", "plant.opf:18:"),
        ("Id=\"7\"", "", "plant.opf:6:3: a mesh without Id"),
        (
            "Id=\"7\"",
            "Id=\"x\"",
            "plant.opf:6:3: mesh has the Id \"x\", wanted a whole number",
        ),
        (
            "0 -0.5 0 1 -0.5",
            "0 -0.5 0 1",
            "points hold 11 numbers, wanted three a point",
        ),
        (
            "0 -0.5 0 1 -0.5",
            "0 -0.5 0 nan -0.5",
            "points holds \"nan\", wanted finite numbers",
        ),
        (
            "1 2 6 5",
            "1 2 6 8",
            "plant.opf:5:39: names point 8, but there are 8",
        ),
        ("1 2 6 5", "1 2 6 -1", "names point -1, but there are 8"),
        (
            "<meshIndex>7</meshIndex>",
            "",
            "plant.opf:15:3: a shape without meshIndex",
        ),
        (
            "<meshIndex>7",
            "<meshIndex>5",
            "names mesh 5, which is none of the 3 of meshBDD",
        ),
        (
            "<meshIndex>7",
            "<meshIndex>a",
            "meshIndex is \"a\", wanted a whole number",
        ),
        (
            "0 1 0 1</diffuse>",
            "0 1</diffuse>",
            "diffuse holds 2 numbers, wanted 3 or 4",
        ),
        (
            "<shapeIndex>0",
            "<shapeIndex>3",
            "names shape 3, which is none of the 3 of shapeBDD",
        ),
        (
            "<mat>0 0",
            "<mat>0",
            "mat holds 11 numbers, wanted 3 rows of 4",
        ),
        ("<dUp>1", "<dUp>", "dUp holds 0 numbers, wanted 1"),
        ("scale=\"3\"", "scale=\"three\"", "plant.opf:18:"),
    ] {
        let broken = sound.replacen(old, new, 1);
        assert_ne!(broken, sound, "{old}");
        let error = error(&broken);
        assert!(error.contains(wanted), "{old}: {error}");
    }
    let laughs = "<!DOCTYPE opf [<!ENTITY a \"ha\"><!ENTITY b \"&a;&a;&a;\">]><opf>&b;</opf>";
    assert!(
        error(laughs).contains("not an OPF document"),
        "{}",
        error(laughs)
    );
    let cut = &sound[..sound.len() / 2];
    assert!(error(cut).starts_with("plant.opf:"), "{}", error(cut));
    let far = document(&entity(
        "decomp",
        "I",
        3,
        &geometry(0, "1e300 0 0 1e300 0 1 0 0 1e300 0 0 ", 0.0, [1.0, 1.0]),
    ));
    let error = error(&far);
    assert!(error.contains("wanted a finite"), "{error}");
}

#[test]
fn scenes_are_plants_of_several_roots() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("opf")).expect("writable");
    std::fs::write(
        folder.path().join("opf/my plant.opf"),
        document(&stem(true)),
    )
    .expect("writable");
    let scene = |rows: &str| {
        let path = folder.path().join("scene.ops");
        let text = format!(
            "# T xOrigin yOrigin zOrigin xSize ySize flat\nT 0 0 0 2 1 flat\n#[Archimed] plant\n{rows}"
        );
        std::fs::write(&path, text).expect("writable");
        import(&path, &ImportOptions::default())
    };
    let imported = scene(
        "1\t1\topf/my plant.opf\t0\t0\t0\t1\t0\t0\t0\n1\t2\topf\\my plant.opf\t2\t1\t0\t0.5\t0\t0\t90\n\
         1\t3\topf/my plant.opf\t4\t0\t0\t1\t90\t90\t0\n1\t4\trock.gwa\t0\t0\t0\t1\n",
    )
    .expect("sound");
    assert_eq!(imported.report.format, Some(Format::Ops));
    let skeleton = imported.plant.skeleton().expect("wood");
    assert_eq!(skeleton.roots().count(), 3);
    let tip = |root: usize| {
        let branch = skeleton.roots().nth(root).expect("three");
        skeleton.nodes_of(branch)[2].position
    };
    assert!(
        tip(0).distance(Vec3::new(0.0, 2.0, 0.0)) < 1e-5,
        "{}",
        tip(0)
    );
    assert!(
        tip(1).distance(Vec3::new(2.0, 1.0, -1.0)) < 1e-5,
        "{}",
        tip(1)
    );
    // Leans to the azimuth of y, which is −z here.
    assert!(
        tip(2).distance(Vec3::new(4.0, 0.0, -2.0)) < 1e-5,
        "{}",
        tip(2)
    );
    assert_eq!(imported.plant.foliage().leaf_count(), 3);
    let said = said(&imported);
    for wanted in [
        "ignored: the extent of the ground (at line 2)",
        "guessed: angles are in degrees: the greatest is 90 (at line 5)",
        "not understood: objects that are no OPF files (at line 7)",
        "merged: stems that no other bears: one plant of several stems (3",
    ] {
        assert!(said.contains(wanted), "{wanted} is not in\n{said}");
    }
    let radians = scene("1\t1\topf/my plant.opf\t0\t0\t0\t1\t0\t1.5707963\t0\n").expect("sound");
    let nodes = &radians.plant.skeleton().expect("wood").nodes;
    assert!(
        nodes[2].position.distance(Vec3::new(2.0, 0.0, 0.0)) < 1e-5,
        "{nodes:?}"
    );
}

#[test]
fn scenes_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("broken.opf"), "<opf>\n<topology>").expect("writable");
    let scene = |rows: &str| {
        let path = folder.path().join("scene.ops");
        std::fs::write(&path, rows).expect("writable");
        let error = import(&path, &ImportOptions::default())
            .unwrap_err()
            .to_string();
        error.replace(&folder.path().display().to_string(), "")
    };
    for (rows, wanted) in [
        ("", "/scene.ops:1:1: no plant in the table"),
        (
            "T 0 0 0 1 1 flat\n1 1 a.opf\n",
            "/scene.ops:2:1: 3 columns, wanted 10: scene, plant, file",
        ),
        (
            "1 1 a.opf 0 0 x 1\n",
            "/scene.ops:1:1: column 6 is \"x\", wanted a finite number",
        ),
        (
            "\n1 1 a.opf 0 0 0 1\n",
            "/scene.ops:2:1: the plant \"a.opf\" is not there: cannot read",
        ),
        ("1 1 /a.opf 0 0 0 1\n", "is not a relative path"),
        (
            "1 1 broken.opf 0 0 0 1\n",
            "broken.opf:2:11: not an OPF document",
        ),
    ] {
        let error = scene(rows);
        assert!(error.contains(wanted), "{rows:?}: {error}");
    }
}
