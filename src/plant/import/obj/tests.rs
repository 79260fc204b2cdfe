//! OBJ files, written line by line.

use crate::limits;
use crate::math::{Vec2, Vec3};
use crate::plant::gltf::encode_png;
use crate::plant::import::{
    Format, ImportError, ImportOptions, Imported, Reading, ReportKind, Unit, UpAxis, import,
    import_bytes,
};
use crate::plant::{Prototype, Texture};

/// A trunk of four sides, 4 units high, open at both ends: eight positions, four quads.
const TRUNK: &str = "v 0.1 0 0.1\nv 0.1 0 -0.1\nv -0.1 0 -0.1\nv -0.1 0 0.1\n\
                     v 0.1 4 0.1\nv 0.1 4 -0.1\nv -0.1 4 -0.1\nv -0.1 4 0.1\n";
const SIDES: &str = "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// A leaf of four corners beside the trunk at a height, its numbers counted back.
fn leaf(height: f32, face: &str) -> String {
    let top = height + 0.5;
    format!("v 1 {height} 0\nv 1.5 {height} 0\nv 1.5 {top} 0\nv 1 {top} 0\n{face}\n")
}

const BACK: &str = "f -4 -3 -2 -1";

fn load(text: &str, options: &ImportOptions) -> Result<Imported, ImportError> {
    import_bytes("tree.obj", text.as_bytes(), None, options)
}

/// As it stands in the file: metres, y up.
fn plain(foliage: &[&str]) -> ImportOptions {
    ImportOptions {
        reading: Reading {
            format: None,
            up: Some(UpAxis::Y),
            unit: Some(Unit::M),
        },
        foliage: foliage.iter().map(|&name| name.to_owned()).collect(),
        ..ImportOptions::default()
    }
}

fn read(text: &str) -> Imported {
    load(text, &plain(&[])).expect("sound")
}

fn error(text: &str) -> String {
    load(text, &plain(&[])).unwrap_err().to_string()
}

fn counts(imported: &Imported) -> (u64, u64, u64) {
    let report = &imported.report;
    (
        report.trunk_triangles,
        report.quad_leaves,
        report.other_leaves,
    )
}

fn said(imported: &Imported) -> Vec<String> {
    let entries = imported.report.entries.iter();
    entries.map(ToString::to_string).collect()
}

#[test]
fn leaves_are_told_by_object_group_and_material() {
    for (bark, leaves) in [
        ("o trunk", "o my_leaves"),
        ("g trunk", "g crown foliage"),
        ("usemtl bark", "usemtl Leaf.001"),
        ("o tree_with_leaves\nusemtl bark", "usemtl leaf"),
    ] {
        let text = format!(
            "# a tree\n{TRUNK}{bark}\n{SIDES}{leaves}\n{}{}",
            leaf(2.0, BACK),
            leaf(3.0, BACK)
        );
        let imported = read(&text);
        assert_eq!(imported.report.format, Some(Format::Obj));
        assert_eq!(
            counts(&imported),
            (8, 2, 0),
            "{leaves}: {}",
            imported.report
        );
        assert_eq!(imported.report.found("faces"), 6);
        let plant = &imported.plant;
        assert_eq!(plant.name(), "tree");
        let group = &plant.foliage().groups[0];
        // Without texture coordinates no corner says where the base is: the first stays.
        assert_eq!(group.leaf(1)[2], Vec3::new(1.5, 3.5, 0.0));
        let trunk = plant.trunk().expect("wood");
        assert_eq!(trunk.positions[4], Vec3::new(0.1, 4.0, 0.1));
        for (normal, position) in trunk.normals.iter().zip(&trunk.positions) {
            assert!(
                normal.dot(position.with_y(0.0)) > 0.1,
                "{normal} points outwards"
            );
        }
        // Two rings of four.
        let skeleton = plant.skeleton().expect("a tube");
        assert_eq!(skeleton.nodes.len(), 2);
        assert!(
            skeleton.nodes[1]
                .position
                .distance(Vec3::new(0.0, 4.0, 0.0))
                < 1e-6
        );
        assert!((skeleton.nodes[1].radius - 0.02_f32.sqrt()).abs() < 1e-6);
    }
}

#[test]
fn one_object_a_leaf_is_told_by_form_and_quads_may_be_doubled() {
    let doubled = "f -4 -3 -2 -1\nf -3 -4 -1 -2";
    let bent = "v 3 1 0\nv 4 1 0\nv 4 2 0\nv 3 2 0\nv 4 3 1\nv 3 3 1\nf -6 -5 -4 -3\nf -3 -4 -2 -1";
    let hexagon = "v 5 1 0\nv 6 1 0\nv 7 2 0\nv 6 3 0\nv 5 3 0\nv 4 2 0\nf -6 -5 -4 -3 -2 -1";
    let text = format!(
        "o Cylinder.003\n{TRUNK}{SIDES}o Plane.000\n{}o Plane.001\n{}o Plane.002\n{bent}\no Plane.003\n{hexagon}\n",
        leaf(1.0, BACK),
        leaf(2.0, doubled),
    );
    let imported = read(&text);
    assert_eq!(counts(&imported), (8, 2, 1), "{}", imported.report);
    let groups = &imported.plant.foliage().groups;
    let faces: Vec<usize> = groups
        .iter()
        .map(|group| group.prototype.triangles_per_leaf())
        .collect();
    assert_eq!(
        faces,
        [2, 8],
        "those that occur once are one leaf of many faces"
    );
    assert_eq!(imported.plant.foliage().quad_count(), 2);
    let text = imported.report.to_string();
    for wanted in [
        "guessed: pieces of 3 to 11 corners that are no tubes: taken as leaves (4, first at line",
        "merged: triangles on top of others, as backs of two-sided leaves",
    ] {
        assert!(text.contains(wanted), "{wanted} is not in\n{text}");
    }
}

#[test]
fn one_object_for_all_comes_apart_by_form() {
    let leaves: String = [1.0, 1.6, 2.2, 2.8]
        .map(|height| leaf(height, BACK))
        .concat();
    let imported = read(&format!("o all\n{TRUNK}{SIDES}{leaves}"));
    assert_eq!(counts(&imported), (8, 4, 0));
    // Three are too few to be a crown: all is wood, and the names are told.
    let leaves: String = [1.0, 1.6, 2.2].map(|height| leaf(height, BACK)).concat();
    let imported = read(&format!("o all\n{TRUNK}{SIDES}{leaves}"));
    assert_eq!(counts(&imported), (14, 0, 0));
    let missing = imported
        .report
        .of_kind(ReportKind::Missing)
        .next()
        .expect("said");
    assert_eq!(
        missing.message,
        "no foliage found; it can be named: \"all\""
    );
}

#[test]
fn names_decide_where_they_are_given() {
    let text = format!(
        "o one\n{TRUNK}g stem low\nusemtl dark\n{SIDES}g stem high\nusemtl light\n{}",
        leaf(2.0, BACK)
    );
    for name in ["light", "high", "stem high"] {
        let imported = load(&text, &plain(&[name])).expect("sound");
        assert_eq!(counts(&imported), (8, 1, 0), "{name}");
    }
    assert_eq!(counts(&load(&text, &plain(&["one"])).expect("sound")).0, 0);
    assert_eq!(
        load(&text, &plain(&["crown"])).unwrap_err().to_string(),
        "tree.obj: nothing is named \"crown\"; there are: \"dark\", \"high\", \"light\", \"low\", \"one\", \
         \"stem\", \"stem high\", \"stem low\""
    );
}

#[test]
fn corners_have_coordinates_and_normals_or_not() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 2\nvn 0 0 0\n\
                v 5 0 0\nv 6 0 0\nv 6 2 0\ng leaf\nf 1/1 2/2 3/3 4/4\ng other\nf 5//1 6//2 7\n";
    let imported = read(text);
    let group = &imported.plant.foliage().groups[0];
    let Prototype::Quad { texture_corners } = group.prototype else {
        panic!("a card");
    };
    assert_eq!(
        texture_corners,
        Prototype::WHOLE_IMAGE,
        "v counts from the image's bottom"
    );
    let trunk = imported.plant.trunk().expect("wood");
    assert_eq!(trunk.normals, [Vec3::Z; 3]);
    assert_eq!(trunk.texture_coordinates, [Vec2::ZERO; 3]);
    let said = said(&imported).join("\n");
    assert!(
        said.contains("repaired: normals that are zero: computed from the triangles (at line 17)"),
        "{said}"
    );
}

#[test]
fn lines_go_on_and_faces_may_stand_before_their_points() {
    let text = "\u{feff}v 9 9 9\r\nf 2 \\\r\n 3 4\r\nv 0 0 0 \\\n\nv 1 0 0 0.5\nv 0 1 0 1 0 0\nvt 0.5\ns off\nl 1 2\np 1\n\
                f 1 2\nf 2 2 3\ncurv 0 1 1 2\nmg 1\n";
    let imported = read(text);
    let trunk = imported.plant.trunk().expect("wood");
    assert_eq!(trunk.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    let said = said(&imported).join("\n");
    for wanted in [
        "ignored: vertex colours (at line 7)",
        "ignored: weights of vertices (at line 6)",
        "dropped: lines (at line 10)",
        "dropped: points (at line 11)",
        "dropped: faces of fewer than three corners (at line 12)",
        "dropped: triangles that name a vertex twice",
        "dropped: lines that are not of a mesh: curves, surfaces and what is not known (at line 14)",
    ] {
        assert!(said.contains(wanted), "{wanted} is not in\n{said}");
    }
}

#[test]
fn what_is_wrong_is_named_with_line_and_column() {
    for (text, wanted) in [
        ("v 0 0\n", "tree.obj:1:1: v has 2 numbers, wanted 3"),
        (
            "v 0 0 0\nv 0 x 0\n",
            "tree.obj:2:5: \"x\", wanted a finite number",
        ),
        (
            "v 0 0 nan\n",
            "tree.obj:1:7: \"nan\", wanted a finite number",
        ),
        (
            "v 0 0 \u{e4}\n",
            "tree.obj:1:7: \"\u{e4}\", wanted a finite number",
        ),
        (
            "v 0 0 1e400\n",
            "tree.obj:1:7: \"1e400\", wanted a finite number",
        ),
        ("vt\n", "tree.obj:1:1: vt has 0 numbers, wanted 1"),
        ("vt 1e39\n", "tree.obj:1:4: 1e39, wanted at most"),
        ("vn 1 1\n", "tree.obj:1:1: vn has 2 numbers, wanted 3"),
        (
            "v 0 0 0\nf 1 2 1\n",
            "tree.obj:2:5: names vertex 2, but there are 1",
        ),
        (
            "v 0 0 0\nf 1 0 1\n",
            "tree.obj:2:5: names vertex 0, but there are 1",
        ),
        (
            "v 0 0 0\nf -2 1 1\n",
            "tree.obj:2:3: names vertex -2, but there are 1",
        ),
        (
            "v 0 0 0\nf 1/1 1 1\n",
            "tree.obj:2:3: names texture coordinate 1, but there are 0",
        ),
        (
            "v 0 0 0\nf 1//9223372036854775807 1 1\n",
            "tree.obj:2:3: names normal 9223372036854775807, but there are 0",
        ),
        (
            "v 0 0 0\nf -9223372036854775808 1 1\n",
            "tree.obj:2:3: names vertex -9223372036854775808, but there are 1",
        ),
        (
            "v 0 0 0\nf 1/2/3/4 1 1\n",
            "tree.obj:2:3: corner \"1/2/3/4\" has more than three numbers",
        ),
        (
            "v 0 0 0\nf /1 1 1\n",
            "tree.obj:2:3: corner \"/1\", wanted whole numbers between '/'",
        ),
        (
            "v 0 0 0\nf 1.0 1 1\n",
            "tree.obj:2:3: corner \"1.0\", wanted whole numbers between '/'",
        ),
        (
            "v 1e39 0 0\nv 0 0 0\nv 0 1 0\nf 1 2 3\n",
            "tree.obj:4:1: vertex 1 at [1000",
        ),
    ] {
        let error = error(text);
        assert!(error.starts_with(wanted), "{text:?}: {error}");
    }
    let empty = read("o nothing\n");
    assert_eq!(
        (empty.plant.trunk(), empty.plant.foliage().leaf_count()),
        (None, 0)
    );
}

#[test]
fn more_than_the_limits_is_refused_before_it_takes_memory() {
    // A fan of so many corners that its triangles pass the limit.
    let corners = usize::try_from(limits::PLACED_CORNERS / 3).expect("fits") + 3;
    let text = format!(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2{}\n",
        " 3".repeat(corners - 2)
    );
    assert_eq!(
        error(&text),
        format!(
            "tree.obj: {} triangle corners exceed the limit of {}; split or thin the tree",
            3 * (corners - 2),
            limits::PLACED_CORNERS
        )
    );
}

#[test]
fn a_tree_far_from_the_origin_keeps_its_tenths_of_millimetres() {
    let mut text = String::new();
    // Z up, in metres, as scanned trees are.
    for [x, y, z] in [
        [0.125, 0.0, 0.0],
        [0.0, 0.125, 0.0],
        [-0.125, -0.125, 0.0],
        [0.125, 0.0, 20.0003],
        [0.0, 0.125, 20.0003],
        [-0.125, -0.125, 20.0003],
    ] {
        text += &format!(
            "v {} {} {}\n",
            431_882.125 + x,
            5_412_345.25 + y,
            300.25 + z
        );
    }
    text += "f 1 2 5 4\nf 2 3 6 5\nf 3 1 4 6\n";
    let imported = load(&text, &ImportOptions::default()).expect("sound");
    let trunk = imported.plant.trunk().expect("wood");
    let tip = trunk.positions[3];
    assert!(tip.distance(Vec3::new(0.125, 20.0003, 0.0)) < 1e-5, "{tip}");
    let said = said(&imported).join("\n");
    for wanted in [
        "guessed: z is up",
        "guessed: lengths are in m: the tree is 20 units high",
        "moved: the tree is moved to the origin from 431882.125, 5412345.25, 300.25 m (at line 1)",
    ] {
        assert!(said.contains(wanted), "{wanted} is not in\n{said}");
    }
}

#[test]
fn materials_and_their_pictures_lie_beside_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.path().join(name), bytes).expect("writable");
    };
    std::fs::create_dir(folder.path().join("look")).expect("writable");
    let seen = Texture::new(2, 1, vec![10, 20, 30, 255, 40, 50, 60, 255]).expect("two texels");
    let mask = Texture::new(1, 1, vec![0, 0, 0, 255]).expect("a texel");
    let own = Texture::new(1, 1, vec![9, 9, 9, 0]).expect("a texel");
    write("look/leaf one.png", &encode_png(&seen));
    write("look/mask.png", &encode_png(&mask));
    write("look/own.png", &encode_png(&own));
    write(
        "look/my tree.mtl",
        b"Kd 1\nnewmtl blade\nKd 0.5 0.25 1\nKs 1\nmap_Kd leaf one.png\nmap_d -imfchan m mask.png\nnewmtl needle\n\
          map_Kd own.png\nd 0.5\nbump gone.png\nnewmtl bark\nKd -1 0 0\nmap_Kd gone.png\n",
    );
    let path = folder.path().join("oak.obj");
    let text = format!(
        "mtllib look/my tree.mtl\nmtllib a.mtl b.mtl\n{TRUNK}usemtl bark\n{SIDES}usemtl blade\n{}usemtl needle\n{}",
        leaf(2.0, BACK),
        leaf(3.0, BACK)
    );
    std::fs::write(&path, &text).expect("writable");
    let imported = import(&path, &plain(&[])).expect("sound");
    assert_eq!(counts(&imported), (8, 2, 0), "{}", imported.report);
    let [blade, needle] = imported.plant.foliage().groups.as_slice() else {
        panic!("two groups");
    };
    assert_eq!(blade.material.base_color, [0.5, 0.25, 1.0, 1.0]);
    let masked = blade.material.texture.as_ref().expect("a picture");
    assert_eq!(
        masked.rgba(),
        [10, 20, 30, 0, 40, 50, 60, 0],
        "black leaves out"
    );
    assert_eq!(needle.material.texture.as_ref(), Some(&own));
    assert!((needle.material.alpha_cutoff - 0.5).abs() < 1e-9);
    let trunk = imported.plant.trunk().expect("wood");
    assert_eq!(trunk.material.base_color, [1.0; 4]);
    assert_eq!(
        (trunk.material.name.as_str(), trunk.material.alpha_cutoff),
        ("bark", 0.0)
    );
    let said = said(&imported).join("\n");
    for wanted in [
        "dropped: colours of fewer than three numbers in \"look/my tree.mtl\" (2, first at line 1)",
        "missing: material library \"a.mtl\": ",
        "missing: material library \"b.mtl\": ",
        "repaired: colours that are no finite numbers of at least 0: white (at newmtl bark)",
        "ignored: materials that let light through everywhere (d below 1): opaque (at newmtl needle)",
        "ignored: pictures other than map_Kd and map_d (at newmtl needle)",
        "missing: picture \"look/gone.png\": ",
        "guessed: material \"blade\" has alpha and 2 of 2 triangles are cards: taken as foliage (at usemtl blade)",
    ] {
        assert!(said.contains(wanted), "{wanted} is not in\n{said}");
    }
    // Without its library the names still say what is what.
    let alone = read(&text);
    assert_eq!(counts(&alone), (10, 1, 0), "needles are leaves");
    let alone = read(&text.replace("blade", "leaf").replace("needle", "leaf b"));
    assert_eq!(counts(&alone), (8, 2, 0));
    let colors = alone
        .plant
        .foliage()
        .groups
        .iter()
        .map(|group| group.material.base_color);
    assert!(
        colors.into_iter().all(|[r, g, _, _]| g > r),
        "leaves are green"
    );
}

#[test]
fn a_library_that_is_not_understood_leaves_colours_to_guess() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(
        folder.path().join("t.mtl"),
        "newmtl bark\nKd red green blue\n",
    )
    .expect("writable");
    let path = folder.path().join("t.obj");
    std::fs::write(&path, format!("mtllib t.mtl\nusemtl bark\n{TRUNK}{SIDES}")).expect("writable");
    let said = said(&import(&path, &plain(&[])).expect("sound")).join("\n");
    assert!(
        said.contains("not understood: material library \"t.mtl\": material parse error"),
        "{said}"
    );
    assert!(
        said.contains(
            "missing: materials that no library holds: their colours are guessed (at usemtl bark)"
        ),
        "{said}"
    );
}
