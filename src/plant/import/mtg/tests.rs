//! Graphs of a few entities, read whole.

use crate::math::Vec3;
use crate::plant::import::{ImportOptions, Imported, Reading, Unit, import_bytes};
use crate::plant::{Plant, Skeleton};

const HEAD: &str = "CODE :\tFORM-A\t\t\n\nCLASSES:\t\nSYMBOL\tSCALE\tDECOMPOSITION\tINDEXATION\tDEFINITION\n\
    $\t0\tFREE\tFREE\tIMPLICIT\nP \t1\tFREE\tFREE\tEXPLICIT\nA\t2\tFREE\tFREE\tEXPLICIT\n\
    U\t3\tFREE\tFREE\tEXPLICIT\nE\t4\tFREE\tFREE\tEXPLICIT\nLeaf\t4\tFREE\tFREE\tEXPLICIT\n\n\
    DESCRIPTION :\nLEFT\tRIGHT\tRELTYPE\tMAX\nE\tE\t<\t1\n\nFEATURES:\t\nNAME\tTYPE\nXX\tREAL\n\nMTG:\t\n\n";

const NAMES: &str = "ENTITY-CODE\t\t\tXX\tYY \tZZ\tTopDia\tNFe\tleaf_area\tLength\tWidth\n";

fn options(unit: Unit) -> ImportOptions {
    ImportOptions {
        reading: Reading {
            unit: Some(unit),
            ..Reading::default()
        },
        ..ImportOptions::default()
    }
}

fn read(lines: &str, options: &ImportOptions) -> Result<Imported, String> {
    let text = format!("{HEAD}{NAMES}{lines}");
    import_bytes("a.mtg", text.as_bytes(), None, options).map_err(|error| error.to_string())
}

fn skeleton(plant: &Plant) -> &Skeleton {
    plant.skeleton().expect("wood has a skeleton")
}

/// Branches as bearer and nodes, each as x, y, z and radius in millimetres.
fn branches(plant: &Plant) -> Vec<(Option<u32>, Vec<[f32; 4]>)> {
    let rounded = |value: f32| (value * 10_000.0).round() / 10.0;
    let branches = skeleton(plant).branches.iter().map(|branch| {
        let nodes = skeleton(plant).nodes_of(branch).iter().map(|node| {
            let Vec3 { x, y, z } = node.position;
            [x, y, z, node.radius].map(rounded)
        });
        (branch.bearer, nodes.collect())
    });
    branches.collect()
}

fn said(imported: &Imported) -> Vec<String> {
    let entries = imported.report.entries.iter();
    entries.map(ToString::to_string).collect()
}

#[test]
fn steps_skips_and_parts_stand_where_they_should() {
    // A trunk of four, two of them between; a branch of its own base; a lateral at an interpolated node.
    let lines = "/P1/A1\t\t\t0\t0\t0\t4\n\
        ^/E1\t\t\t0\t0\t10\t4\n\
        ^<E2<<E4\t\t\t0\t0\t40\t2\n\
        \t+A2\t\t1\t0\t35\t1\n\
        \t^/E1\t\t11\t0\t35\t1\n\
        ^<E5\n\
        \t+E1\t\t0\t10\t50\t1\n\
        ^<E6\t\t\t0\t0\t60\t2\n";
    let imported = read(lines, &options(Unit::Cm)).unwrap();
    assert_eq!(
        branches(&imported.plant),
        [
            (
                None,
                vec![
                    [0.0, 0.0, 0.0, 20.0],
                    [0.0, 100.0, 0.0, 20.0],
                    [0.0, 200.0, 0.0, 16.7],
                    [0.0, 300.0, 0.0, 13.3],
                    // The second axis starts half way up the segment, as its own position says.
                    [0.0, 350.0, 0.0, 11.7],
                    [0.0, 400.0, 0.0, 10.0],
                    [0.0, 500.0, 0.0, 10.0],
                    [0.0, 600.0, 0.0, 10.0]
                ]
            ),
            (
                Some(4),
                vec![[10.0, 350.0, 0.0, 5.0], [110.0, 350.0, 0.0, 5.0]]
            ),
            (
                Some(6),
                vec![[0.0, 500.0, 0.0, 5.0], [0.0, 500.0, -100.0, 5.0]]
            ),
        ]
    );
    assert_eq!(imported.report.found("entities"), 11);
    assert_eq!(imported.report.found("segments"), 8);
    assert_eq!(
        said(&imported)[0],
        "guessed: positions between two that the file tells: at equal distances (3, first at line 25)"
    );
}

#[test]
fn lines_hang_on_the_column_to_their_left_and_doubled_branches_chain() {
    let lines = "/P1\n\t/E1\t\t0\t0\t0\t1\n\t\t+E1\t0\t0\t1\t1\n\t\t^++E3\t0\t0\t3\t1\n\t^<E2\t\t0\t1\t0\t1\n";
    let imported = read(lines, &options(Unit::M)).unwrap();
    let bearers: Vec<_> = skeleton(&imported.plant)
        .branches
        .iter()
        .map(|branch| (branch.bearer, branch.level))
        .collect();
    assert_eq!(
        bearers,
        [(None, 0), (Some(0), 1), (Some(3), 2), (Some(5), 3)]
    );
}

#[test]
fn missing_positions_and_diameters_are_filled_and_said() {
    let lines = "/P1/E1\t\t\t0\t0\t0\n\
        ^<E2\t\t\t0\t0\t4\n\
        \t+E1\t\t1,5\t0\t4\n\
        \t+E2\t\t-1.5\tNA\t4\n\
        \t+E3\t\t-1.5e0\t0\t4\n\
        ^<E3\n";
    let imported = read(lines, &options(Unit::M)).unwrap();
    // Three tips of 2 mm, of which one has no position; the trunk has the area of three.
    assert_eq!(
        branches(&imported.plant),
        [
            (None, vec![[0.0, 0.0, 0.0, 4.0], [0.0, 4000.0, 0.0, 4.0]]),
            (
                Some(1),
                vec![[0.0, 4000.0, 0.0, 2.0], [1500.0, 4000.0, 0.0, 2.0]]
            ),
            (
                Some(1),
                vec![[0.0, 4000.0, 0.0, 2.0], [-1500.0, 4000.0, 0.0, 2.0]]
            ),
        ]
    );
    let said = said(&imported);
    assert!(
        said.iter().any(
            |line| line.starts_with("missing: entities without a position")
                && line.ends_with("(2, first at line 26)")
        ),
        "{said:?}"
    );
    assert!(
        said.iter().any(
            |line| line.starts_with("guessed: segments without a diameter")
                && line.ends_with("(4, first at line 23)")
        ),
        "{said:?}"
    );
}

#[test]
fn units_are_guessed_by_height_and_told_ones_win() {
    let tree = |height: &str, diameter: &str| {
        format!("/P1/E1\t\t\t0\t0\t0\t{diameter}\n^<E2\t\t\t0\t0\t{height}\t{diameter}\n")
    };
    for (height, diameter, metres, radius, unit) in [
        ("12", "0.4", 12.0, 0.2, "m"),
        ("900", "27", 9.0, 0.135, "cm"),
        // Millimetres beside centimetres, and beside metres.
        ("900", "270", 9.0, 0.135, "cm"),
        ("9", "270", 9.0, 0.135, "m"),
        ("9000", "270", 9.0, 0.135, "mm"),
    ] {
        let imported = read(&tree(height, diameter), &ImportOptions::default()).unwrap();
        let top = skeleton(&imported.plant).nodes[1];
        assert!((top.position.y - metres).abs() < 1e-5, "{height}: {top:?}");
        assert!((top.radius - radius).abs() < 1e-5, "{diameter}: {top:?}");
        let said = said(&imported);
        let wanted = format!("the unit {unit}, of a plant that measures {height}.0000 of them");
        assert!(said[0].contains(&wanted), "{said:?}");
    }
    let imported = read(&tree("900", "270"), &options(Unit::Mm)).unwrap();
    assert_eq!(skeleton(&imported.plant).nodes[1].position.y, 0.9);
    assert!(
        said(&imported)[0]
            .contains("diameters up to 270 of a plant that measures 900.0000: taken as 1/10"),
        "{:?}",
        said(&imported)
    );
}

#[test]
fn leaves_come_as_numbers_areas_and_entities() {
    let lines = "/P1/E1\t\t\t0\t0\t0\t2\n\
        ^<E2\t\t\t0\t0\t40\t2\t3\n\
        ^<E3\t\t\t0\t0\t80\t2\t2\t50\n\
        \t+Leaf1\t\t\t\t\t\t\t\t6\t4\n\
        \t+Leaf2\t\t30\t0\t80\n";
    let imported = read(lines, &options(Unit::Cm)).unwrap();
    let group = &imported.plant.foliage().groups[0];
    assert_eq!(group.leaf_count(), 7);
    assert_eq!(group.owners, [0; 7]);
    // The leaf with a size has it; the one with a tip reaches it.
    let leaf = group.leaf(5);
    assert!((leaf[0].distance(leaf[1]) - 0.04).abs() < 1e-6);
    assert!((leaf[0].distance(leaf[3]) - 0.06).abs() < 1e-6);
    let tip = 0.5 * (group.leaf(6)[2] + group.leaf(6)[3]);
    assert!(tip.distance(Vec3::new(0.3, 0.8, 0.0)) < 1e-6, "{tip}");
    // Leaves stand on the segment that ends at their entity.
    for (leaf, heights) in [(0, 0.0..0.4), (2, 0.0..0.4), (3, 0.4..0.8), (4, 0.4..0.8)] {
        let height = group.leaf(leaf)[0].y;
        assert!(heights.contains(&height), "leaf {leaf} at {height}");
    }
    let said = said(&imported).join("\n");
    for line in [
        "leaf areas up to 50: taken as 1e-4 m² each",
        "entities of the class \"Leaf\": taken as leaves (2, first at line 26)",
        "0.08 m long, placed along their nodes by the golden angle and the seed 1 (3, first at line 24)",
        "of their share of the area, placed along",
    ] {
        assert!(said.contains(line), "{line}\n{said}");
    }
    // Classes that are named, and none that is not there.
    let named = |name: &str| ImportOptions {
        foliage: vec![name.to_owned()],
        ..options(Unit::Cm)
    };
    let leaves = read(lines, &named("Leaf"))
        .unwrap()
        .plant
        .foliage()
        .leaf_count();
    assert_eq!(leaves, 7);
    assert_eq!(
        read(lines, &named("leaf")).unwrap_err(),
        "a.mtg: nothing is named \"leaf\"; there are: P, E, Leaf"
    );
}

#[test]
fn errors_name_file_line_column_and_both_numbers() {
    for (lines, wanted) in [
        (
            "^/E1\n",
            "a.mtg:23:1: ^ goes on from nothing: no entity above it in column 0 of tabs",
        ),
        ("/P1\n\t <E1^\n", "a.mtg:24:6: \"^\", wanted one of / < +"),
        (
            "/P1\t\t\tlow\t0\t0\n",
            "a.mtg:23:7: XX is \"low\", wanted a number from -150000000000 to 150000000000; set it right, or \
             take the line out",
        ),
        (
            "/P1/E1\t\t\t0\t0\t0\t-2\n",
            "a.mtg:23:16: TopDia is \"-2\", wanted a number from 0 to 150000000000; set it right, or take the \
             line out",
        ),
        (
            "/P1\n\t\t\t0\t0\t0\n",
            "a.mtg:24:4: features without an entity in the 3 columns left of them",
        ),
        (
            "/E1<<E4000000000\t\t\t0\t0\t0\n",
            "a.mtg: 3999999998 entities between two of a line exceed the limit of 10000; split or thin the tree",
        ),
        ("/P1/E1\n", "a.mtg:1:1: 2 entities, and none has a position"),
        (
            "",
            "a.mtg:1:1: no entities, wanted a section MTG: with a line of names and lines of entities",
        ),
    ] {
        assert_eq!(read(lines, &ImportOptions::default()).unwrap_err(), wanted);
    }
    let topology = format!("{HEAD}TOPO\t\tdiabase\tXX\tZZ\n/P1\n");
    let error = import_bytes(
        "a.mtg",
        topology.as_bytes(),
        None,
        &ImportOptions::default(),
    );
    assert_eq!(
        error.unwrap_err().to_string(),
        "a.mtg:22:1: 2 of the columns XX, YY and ZZ, wanted 3: without positions there is no shape; digitize the \
         plant, or compute them"
    );
}

#[test]
fn latin_texts_and_unknown_classes_are_read() {
    let text = format!("{HEAD}{NAMES}/P1/Hé1\t\t\t0\t0\t0\t1\n^<Hé2\t\t\t0\t0\t9\t1\n");
    let latin: Vec<u8> = text
        .chars()
        .map(|c| u8::try_from(u32::from(c)).expect("Latin-1"))
        .collect();
    let imported = import_bytes("a.mtg", &latin, None, &options(Unit::M)).unwrap();
    assert_eq!(skeleton(&imported.plant).nodes.len(), 2);
    assert_eq!(
        said(&imported)[0],
        "not understood: classes that CLASSES does not list: read as any other (at line 23)"
    );
}
