//! Models of a few cylinders in every layout, and what is wrong with others.

use crate::math::Vec3;
use crate::plant::Plant;
use crate::plant::import::{Format, ImportOptions, Imported, Reading, import_bytes};

/// A trunk of two cylinders and a branch in the middle of the first, 500 km from the survey's origin.
const TREE_QSM: &str = "radius (m)\tlength (m)\tstart_point\taxis_direction\tparent\textension\tbranch\t\
    branch_order\tposition_in_branch\tmad\tSurfCov\tadded\tUnmodRadius (m)\n\
    0.2\t2\t500000.1\t4000000.2\t300.5\t0\t0\t1\t0\t2\t1\t0\t1\t0\tNaN\t0\t0.2\n\
    0.1\t1\t500000.1\t4000000.2\t302.5\t0\t0\t1\t1\t0\t1\t0\t2\t0\t0\t0\t0.1\n\
    0.15\t0.5\t500000.1\t4000000.2\t301.5\t1\t0\t0\t1\t0\t2\t1\t1\t0\t0\t0\t0.15\n";

/// The same without a head, as before version 2.4: 15 columns, blanks between, in exponent form.
const OLD: &str = "  2.0e-01 2.0e+00 500000.1 4000000.2 300.5 0 0 1 0.0e+00 2.0e+00 0 0.2 1 0 1\n\
    \n\
    # a remark\n\
    0.1 1 500000.1 4000000.2 302.5 0 0 1 1 0 0 0.1 1 0 2\n\
    0.15 0.5 500000.1 4000000.2 301.5 1 0 0 1 0 0 0.15 2 1 1\n";

/// The same with ids from 0 and a gap, and names with blanks before them.
const SIMPLE_FOREST: &str = "type, ID, parentID, branchID, startX, startY, startZ, endX, endY, endZ, radius\r\n\
    a, 0, -1, 0, 500000.1, 4000000.2, 300.5, 500000.1, 4000000.2, 302.5, 0.2\r\n\
    a, 7, 0, 1, 500000.1, 4000000.2, 301.5, 500000.6, 4000000.2, 301.5, 0.15\r\n\
    \r\n\
    a, 8, 0, 0, 500000.1, 4000000.2, 302.5, 500000.1, 4000000.2, 303.5, 0.1\r\n";

/// The same by aRchi, quoted.
const ARCHI: &str = "\"startX\";\"startY\";\"startZ\";\"endX\";\"endY\";\"endZ\";\"cyl_ID\";\"parent_ID\";\
    \"extension_ID\";\"radius_cyl\";\"axis_ID\"\n\
    500000.1;4000000.2;300.5;500000.1;4000000.2;302.5;1;0;2;0.2;1\n\
    500000.1;4000000.2;302.5;500000.1;4000000.2;303.5;2;1;0;0.1;1\n\
    500000.1;4000000.2;301.5;500000.6;4000000.2;301.5;3;1;NA;0.15;2\n";

fn read(file: &str, format: Option<Format>, text: &str) -> Result<Imported, String> {
    let options = ImportOptions {
        reading: Reading {
            format,
            ..Reading::default()
        },
        ..ImportOptions::default()
    };
    import_bytes(file, text.as_bytes(), None, &options).map_err(|error| error.to_string())
}

/// Branches as bearer and nodes, each node as x, y, z and radius in tenths of millimetres.
fn branches(plant: &Plant) -> Vec<(Option<u32>, Vec<[i32; 4]>)> {
    #[expect(clippy::cast_possible_truncation, reason = "a few metres")]
    let tenths = |value: f32| (value * 10_000.0).round() as i32;
    let skeleton = plant.skeleton().expect("wood has a skeleton");
    let branches = skeleton.branches.iter().map(|branch| {
        let nodes = skeleton.nodes_of(branch).iter().map(|node| {
            let Vec3 { x, y, z } = node.position;
            [x, y, z, node.radius].map(tenths)
        });
        (branch.bearer, nodes.collect())
    });
    branches.collect()
}

#[test]
fn all_layouts_of_one_tree_give_one_skeleton() {
    // The branch starts in the middle of the first cylinder: there it gets a node.
    let wanted = [
        (
            None,
            vec![
                [0, 0, 0, 2000],
                [0, 10_000, 0, 1500],
                [0, 20_000, 0, 1000],
                [0, 30_000, 0, 1000],
            ],
        ),
        (Some(1), vec![[0, 10_000, 0, 1500], [5000, 10_000, 0, 1500]]),
    ];
    let commas = TREE_QSM.replace('\t', ",");
    let blanks = TREE_QSM.replace('\t', "  ");
    // Programs also end lines with a separator.
    let ended = TREE_QSM.replace('\n', "\t\n");
    let headless_ended = ended.split_once('\n').expect("a head").1;
    let headless = TREE_QSM.split_once('\n').expect("a head").1;
    let mut lines = TREE_QSM.lines();
    let head = lines.next().expect("a head").replace("radius (m)\t", "") + "\tradius";
    let turned = lines.map(|line| {
        let (radius, rest) = line.split_once('\t').expect("cells");
        format!("{rest}\t{radius}\n")
    });
    let turned = format!("{head}\n{}", turned.collect::<String>());
    let single = TREE_QSM
        .replace("start_point", "start_x\tstart_y\tstart_z")
        .replace("axis_direction", "axis_1\taxis_2\taxis_3");
    for (text, format) in [
        (TREE_QSM, Format::TreeQsm),
        (&commas, Format::TreeQsm),
        (&blanks, Format::TreeQsm),
        (headless, Format::TreeQsm),
        (&ended, Format::TreeQsm),
        (headless_ended, Format::TreeQsm),
        (&turned, Format::TreeQsm),
        (&single, Format::TreeQsm),
        (OLD, Format::TreeQsm),
        (SIMPLE_FOREST, Format::SimpleForest),
        (ARCHI, Format::Archi),
    ] {
        let imported = read("tree.txt", Some(format), text).expect(text);
        assert_eq!(branches(&imported.plant), wanted, "{text}");
        let report = imported.report;
        assert_eq!(report.found("cylinders"), 3);
        assert_eq!(imported.plant.name(), "tree");
        let said: Vec<String> = report.entries.iter().map(ToString::to_string).collect();
        let base = "the tree is moved to the origin from 500000.1, 4000000.2, 300.5 m";
        assert!(said[0].contains(base), "{said:?}");
        assert_eq!(said.len(), 2, "{said:?}");
        let trunk = imported.plant.trunk().expect("tubes").triangle_count();
        assert_eq!(report.trunk_triangles, u64::from(trunk));
    }
    for (text, format) in [
        (TREE_QSM, Format::TreeQsm),
        (SIMPLE_FOREST, Format::SimpleForest),
        (ARCHI, Format::Archi),
    ] {
        let guessed = read("tree.txt", None, text).expect("known by its content");
        assert_eq!(guessed.report.format, Some(format));
    }
}

#[test]
fn a_treefile_keeps_every_tip_and_its_trees_are_stems() {
    let text = "# a comment\nheight, x,y,z,radius,parent_id,red\n\
        3.0, 10,20,1,0.3,-1,255, 10,20,2,0.2,0,255, 10,21,2,0.1,1,0, 10,20,4,0.18,1,0\n\
        1.5, 12,20,1.5,0,-1,9, 12,20,3,0.1,0,9, \n";
    let imported = read("wood.txt", None, text).unwrap();
    assert_eq!(
        branches(&imported.plant),
        [
            (
                None,
                vec![[0, 0, 0, 3000], [0, 10_000, 0, 2000], [0, 30_000, 0, 1800]]
            ),
            // A base without a radius has its first cylinder's.
            (
                None,
                vec![[20_000, 5000, 0, 1000], [20_000, 20_000, 0, 1000]]
            ),
            (
                Some(1),
                vec![[0, 10_000, 0, 1000], [0, 10_000, -10_000, 1000]]
            ),
        ]
    );
    assert_eq!(imported.report.found("trees"), 2);
    assert_eq!(imported.report.found("nodes"), 6);
    let said = imported.report.to_string();
    assert!(
        said.contains(
            "merged: stems that no other bears: one plant of several stems (2, first at line 4)"
        ),
        "{said}"
    );
    // Early versions name the fields in the comment.
    let old = "# tree file: x,y,z,radius,parent_id\n0,0,0,0.3,-1, 0,0,1,0.2,0\n";
    let imported = read("wood.txt", None, old).unwrap();
    assert_eq!(
        branches(&imported.plant),
        [(None, vec![[0, 0, 0, 3000], [0, 10_000, 0, 2000]])]
    );
}

#[test]
fn what_ids_and_axes_have_wrong_is_set_right_and_said() {
    let text = "cyl_ID,parent_ID,startX,startY,startZ,endX,endY,endZ,radius_cyl\n\
        5,99,0,0,0,0,0,1,0.1\n\
        6,5,0,0,1,0,0,2,0.1\n\
        6,5,0,0,1,1,0,1,0.05\n\
        9,9,3,0,0,3,0,1,0.1\n\
        10,NA,5,0,0,5,0,1,0.1\n";
    let report = read("tree.csv", None, text).unwrap().report;
    let said = report.to_string();
    for line in [
        "repaired: numbers that stand twice: parents mean the first (at line 4)",
        "repaired: parents that are not there: their children become roots (at line 2)",
        "repaired: parents that lead in a circle: one of each becomes a root (at line 5)",
        "merged: stems that no other bears: one plant of several stems (3, first at line 5)",
    ] {
        assert!(said.contains(line), "{line}\n{said}");
    }
    let long = TREE_QSM.replace("\t1\t0\t0\t1\t0\t2", "\t2\t0\t0\t1\t0\t2");
    let said = read("tree.txt", None, &long).unwrap().report.to_string();
    assert!(
        said.contains("repaired: axes that are not of length 1: taken as directions (at line 4)"),
        "{said}"
    );
}

#[test]
fn errors_name_file_line_column_and_both_numbers() {
    let cut = TREE_QSM.replace("\t0\t0\t0.1\n", "\n");
    let word = TREE_QSM.replace("302.5", "high");
    let negative = SIMPLE_FOREST.replace("0.15", "-0.15");
    let endless = SIMPLE_FOREST.replace("301.5, 0.15", "inf, 0.15");
    let nan = TREE_QSM.replace("0.15\t0.5", "NaN\t0.5");
    let half = TREE_QSM.replace("\t1\t0\t1\t0\t2\t0", "\t1.5\t0\t1\t0\t2\t0");
    let nameless = ARCHI.replace("radius_cyl", "thickness");
    let quoted = ARCHI.replace("500000.1;4000000.2;301.5", "\"500000.1\";x;301.5");
    let treefile = "x,y,z,radius,parent_id\n0,0,0,0.2,-1, 0,0,1,0.1\n";
    let treefile_word = "x,y,z,radius,parent_id\n0,0,0,0.2,-1, 0,up,1,0.1,0\n";
    for (format, text, wanted) in [
        (
            Format::TreeQsm,
            cut.as_str(),
            "a.x:3:49: 14 columns, wanted 17",
        ),
        (
            Format::TreeQsm,
            &word,
            "a.x:3:26: start z is \"high\", wanted a number from -150000000000 to 150000000000; set it right, \
             or take the line out",
        ),
        (
            Format::SimpleForest,
            &negative,
            "a.x:3:69: radius is \"-0.15\", wanted a number from 0 to 150000000000; set it right, or take the \
             line out",
        ),
        (
            Format::SimpleForest,
            &endless,
            "a.x:3:62: end z is \"inf\", wanted a number from -150000000000 to 150000000000; set it right, or \
             take the line out",
        ),
        (
            Format::TreeQsm,
            &nan,
            "a.x:4:1: radius is \"NaN\", wanted a number from 0 to 150000000000; set it right, or take the \
             line out",
        ),
        (
            Format::TreeQsm,
            &half,
            "a.x:3:38: the parent's number is \"1.5\", wanted a whole number",
        ),
        (
            Format::TreeQsm,
            "1 2 3 4 5 6 7 8 9 10 11 12 13 14\n",
            "a.x:1:1: 14 columns without names, wanted 17, or 15 of versions before 2.4; add the line of names",
        ),
        (
            Format::Archi,
            &nameless,
            "a.x:1:1: no column \"radius\" among 11 of the line of names; there are: startx, starty, startz, \
             endx, endy, endz, cylid, parentid, extensionid, thickness, axisid",
        ),
        (
            Format::Archi,
            &quoted,
            "a.x:4:12: start y is \"x\", wanted a number from -150000000000 to 150000000000; set it right, or \
             take the line out",
        ),
        (
            Format::TreeQsm,
            "",
            "a.x:1:1: no cylinders, wanted at least one line of them",
        ),
        (
            Format::SimpleForest,
            "ID,parentID,startX,startY,startZ,endX,endY,endZ,radius\n",
            "a.x:1:1: no cylinders, wanted at least one line of them",
        ),
        (
            Format::Treefile,
            treefile,
            "a.x:2:21: 9 values, wanted 0 of the tree and 5 of each node",
        ),
        (
            Format::Treefile,
            treefile_word,
            "a.x:2:17: y is \"up\", wanted a number from -150000000000 to 150000000000; set it right, or take \
             the line out",
        ),
        (
            Format::Treefile,
            "x,y,z,radius\n0,0,0,0.2\n",
            "a.x:1:1: 4 fields without parent_id behind x,y,z,radius: trunks have no wood to read; extract \
             trees",
        ),
        (
            Format::Treefile,
            "0,0,0,0.2,-1\n",
            "a.x:1:1: a tree before the line of fields, wanted \"x,y,z,radius,parent_id,…\"",
        ),
        (
            Format::Treefile,
            "# nothing\n",
            "a.x:1:1: no trees, wanted a line of fields and at least one of nodes",
        ),
    ] {
        assert_eq!(read("a.x", Some(format), text).unwrap_err(), wanted);
    }
    let latin = import_bytes(
        "a.x",
        b"radius,parent,extension\n\xe9",
        None,
        &ImportOptions::default(),
    );
    assert_eq!(latin.unwrap_err().to_string(), "a.x:2:1: not UTF-8");
    let options = ImportOptions {
        foliage: vec!["leaf".to_owned()],
        ..ImportOptions::default()
    };
    let named = import_bytes("a.x", OLD.as_bytes(), None, &options);
    assert_eq!(
        named.unwrap_err().to_string(),
        "a.x: nothing is named \"leaf\"; there are: no leaves in this format"
    );
}
