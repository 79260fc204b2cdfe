//! Arbaro's files become species, and what does not fit is said.

use super::*;
use crate::plant::{Plant, SpeciesFile};

fn document(params: &[(&str, &str)]) -> Document {
    let params: String = params
        .iter()
        .map(|(name, value)| format!("    <param name='{name}' value='{value}'/>\n"))
        .collect();
    Document {
        file: "tree.xml".to_owned(),
        text: format!(
            "<?xml version='1.0' ?>\n\n<arbaro>\n  <species name='small_willow'>\n    <!-- general -->\n{params}  \
             </species>\n</arbaro>\n"
        ),
    }
}

fn parse(params: &[(&str, &str)]) -> ArbaroSpecies {
    ArbaroSpecies::parse(&document(params)).expect("sound")
}

fn said(found: &ArbaroSpecies) -> Vec<String> {
    let entries = found.report.entries.iter();
    entries.map(ToString::to_string).collect()
}

fn error(params: &[(&str, &str)]) -> String {
    ArbaroSpecies::parse(&document(params))
        .unwrap_err()
        .to_string()
}

#[test]
fn parameters_keep_their_values() {
    let found = parse(&[
        ("Shape", "3"),
        ("Levels", "4"),
        ("Scale", "15.0"),
        ("ScaleV", "5.0"),
        ("BaseSize", "0.05"),
        ("Ratio", "0.03"),
        ("RatioPower", "2.0"),
        ("Flare", "0.75"),
        ("Lobes", "9"),
        ("LobeDepth", "0.03"),
        ("Leaves", "10"),
        ("LeafShape", "disc2"),
        ("LeafScale", "0.12"),
        ("LeafScaleX", "0.2"),
        ("LeafBend", "0.3"),
        ("AttractionUp", "-2.0"),
        ("PruneRatio", "1.0"),
        ("PrunePowerLow", "0.0010"),
        ("PruneWidth", "0.4"),
        ("PruneWidthPeak", "0.6"),
        ("0BaseSplits", "2"),
        ("1DownAngle", "20.0"),
        ("1Rotate", "-120.0"),
        ("1RotateV", "-30"),
        ("2CurveRes", "12"),
        ("3Branches", "150"),
        ("3Length", "0.1"),
    ]);
    let species = &found.species;
    assert_eq!(species.name, "small_willow");
    assert_eq!(
        (species.crown.shape, species.crown.levels),
        (Shape::Cylindrical, 4)
    );
    assert_eq!([species.crown.scale, species.crown.scale_v], [15.0, 5.0]);
    assert_eq!(species.crown.attraction_up, [0.0, 0.0, -2.0, -2.0]);
    let pruning = species.crown.pruning;
    assert_eq!(
        [
            pruning.ratio,
            pruning.width,
            pruning.width_peak,
            pruning.power_low,
            pruning.power_high
        ],
        [1.0, 0.4, 0.6, 0.001, 0.5]
    );
    let wood = species.wood;
    assert_eq!(
        [wood.ratio, wood.ratio_power, wood.flare],
        [0.03, 2.0, 0.75]
    );
    assert_eq!(
        (wood.lobes, wood.lobe_depth, wood.base_splits),
        (9, 0.03, 2)
    );
    assert_eq!([species.leaves.per_stem, species.leaves.bend], [10.0, 0.3]);
    let leaf = &species.foliage[0];
    assert_eq!(
        (leaf.length, leaf.width, leaf.blade),
        (0.12, 0.2, Blade::Flat)
    );
    let [trunk, first, second, third] = species.stems;
    assert_eq!(
        [first.down_angle, first.rotate, first.rotate_v],
        [20.0, -120.0, 30.0]
    );
    assert_eq!(
        (second.curve_res, third.branches, third.length),
        (12, 150.0, 0.1)
    );
    // What is not said is Arbaro's.
    assert_eq!(
        [trunk.length, trunk.down_angle, trunk.branches],
        [1.0, 0.0, 1.0]
    );
    assert_eq!(
        (second.length, second.down_angle, third.curve_res),
        (0.5, 30.0, 1)
    );
    assert_eq!(
        said(&found),
        [
            "guessed: LeafShape \"disc2\": an ellipse as an image on a flat leaf (at line 17, column 5)",
            "missing: parameters that are not given: Arbaro's defaults (66, first at line 1)",
        ]
    );
}

#[test]
fn what_has_no_counterpart_is_said_with_its_line() {
    let found = parse(&[
        ("Shape", "0"),
        ("Levels", "7"),
        ("ScaleV", "40"),
        ("RatioPower", "-1"),
        ("1BranchDist", "0.0"),
        ("LeafQuality", "0.5"),
        ("LeafStemLen", "0.5"),
        ("LeafDistrib", "3"),
        ("LeafShape", "sphere"),
        ("LeafScale", "0.05"),
        ("LeafScaleX", "0.02"),
        ("Smooth", "0.2"),
        ("Blossoms", "3"),
        ("Blossoms", "4"),
    ]);
    assert_eq!(found.species.crown.levels, 4);
    assert!((found.species.crown.scale_v - 9.99).abs() < 1e-5);
    assert_eq!(found.species.wood.ratio_power, 0.0);
    let Blade::Needle { diameter } = found.species.foliage[0].blade else {
        panic!("no needles");
    };
    assert!((diameter - 0.001).abs() < 1e-7);
    let said = said(&found).join("\n");
    for wanted in [
        "repaired: Blossoms is given again: the last counts (at line 19, column 5)",
        "not understood: Shape 0: stems at the top",
        "repaired: Levels is 7, beyond 1..=4: taken as 4 (at line 7, column 5)",
        "repaired: ScaleV is 40, beyond 0..=9.99",
        "repaired: RatioPower is -1, beyond 0..=10: taken as 0 (at line 9, column 5)",
        "not understood: nBranchDist below 1: branches lie evenly along their parent (at line 10",
        "not understood: LeafQuality: all leaves are there",
        "not understood: LeafStemLen: leaves sit on their stems",
        "not understood: LeafDistrib: leaves are spread as at 4",
        "guessed: LeafShape sphere, narrow: needles (at line 14",
        "ignored: Smooth: of Arbaro's own output",
        "not understood: parameter \"Blossoms\"",
    ] {
        assert!(said.contains(wanted), "{wanted} is not in\n{said}");
    }
}

#[test]
fn what_is_no_arbaro_file_is_refused_with_its_place() {
    assert_eq!(
        error(&[("Levels", "3"), ("Scale", "tall")]),
        "tree.xml:7:5: Scale is \"tall\", wanted a finite number"
    );
    assert_eq!(
        error(&[("Scale", "inf")]),
        "tree.xml:6:5: Scale is \"inf\", wanted a finite number"
    );
    assert_eq!(
        error(&[("Shape", "9")]),
        "tree.xml:6:5: Shape is 9, wanted 0..=8"
    );
    assert_eq!(
        error(&[("Levels", "2.5")]),
        "tree.xml:6:5: Levels is \"2.5\", wanted a whole number"
    );
    let parse = |text: &str| {
        let text = text.to_owned();
        let file = "tree.xml".to_owned();
        ArbaroSpecies::parse(&Document { file, text })
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        parse("<arbaro><species><param name='Scale'/></species></arbaro>"),
        "tree.xml:1:18: a <param> without name or value, wanted both"
    );
    assert_eq!(
        parse("<arbaro/>"),
        "tree.xml:1:1: no <arbaro> with a <species> in it; it holds the parameters"
    );
    assert!(
        parse("<arbaro>\n<species>").starts_with("tree.xml:2:10: not an Arbaro file"),
        "{}",
        parse("<arbaro>\n<species>")
    );
    let laughs = "<!DOCTYPE a [<!ENTITY a \"ha\"><!ENTITY b \"&a;&a;\">]><arbaro>&b;</arbaro>";
    assert!(
        parse(laughs).contains("not an Arbaro file"),
        "{}",
        parse(laughs)
    );
    let deep = format!("<arbaro>{}", "<a>".repeat(200_000));
    assert!(parse(&deep).contains("not an Arbaro file"));
}

#[test]
fn species_files_know_them_by_content_and_ending() {
    let mut document = document(&[
        ("Shape", "1"),
        ("Levels", "2"),
        ("Leaves", "5"),
        ("Scale", "4"),
    ]);
    let grown = |document: &Document| -> Plant {
        let file = SpeciesFile::parse(document).expect("sound");
        assert!(matches!(file, SpeciesFile::Arbaro(_)));
        assert_eq!(file.latin(), "");
        assert_eq!(file.stop_leaves(), None);
        file.grow(3).expect("small")
    };
    let plant = grown(&document);
    assert!(plant.foliage().leaf_count() > 10);
    document.file = "tree.toml".to_owned();
    assert_eq!(grown(&document).digest(), plant.digest());
    assert_eq!(SpeciesFile::ending_of("A.XML"), "xml");
    // Written as a species, it grows the same.
    let found = ArbaroSpecies::parse(&document).expect("sound");
    let written = Document {
        file: "written.toml".to_owned(),
        text: found.species.to_toml(),
    };
    let read = SpeciesFile::parse(&written).expect("our own");
    assert_eq!(read.species(), Some(&found.species));
    assert_eq!(read.grow(3).expect("small").digest(), plant.digest());
}

#[test]
fn the_ends_of_all_ranges_are_a_species() {
    let keys = [
        "Levels",
        "Scale",
        "ScaleV",
        "BaseSize",
        "ZScale",
        "ZScaleV",
        "Ratio",
        "RatioPower",
        "Flare",
        "Lobes",
        "LobeDepth",
        "Leaves",
        "LeafScale",
        "LeafScaleX",
        "LeafBend",
        "AttractionUp",
        "PruneRatio",
        "PruneWidth",
        "PruneWidthPeak",
        "PrunePowerLow",
        "PrunePowerHigh",
        "0Scale",
        "0ScaleV",
        "0BaseSplits",
        "1Length",
        "1LengthV",
        "1Taper",
        "1SegSplits",
        "1SplitAngle",
        "1SplitAngleV",
        "1CurveRes",
        "1Curve",
        "1CurveBack",
        "1CurveV",
        "1DownAngle",
        "1DownAngleV",
        "1Rotate",
        "1RotateV",
        "1Branches",
    ];
    for end in ["-1e9", "1e9"] {
        let params = keys.map(|key| (key, end));
        let species = parse(&params).species;
        let file = "written.toml".to_owned();
        let text = species.to_toml();
        let read = Species::parse(&Document { file, text });
        assert_eq!(read, Ok(species), "{end}");
    }
}
