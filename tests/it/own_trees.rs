//! `build` and `compare` as somebody with a tree of their own uses them.

use std::path::Path;

use serde_json::Value;
use spinney::plant::import::{ImportOptions, import};

use crate::program::{shrub, spinney};

/// A small broom as a file of its own.
fn own_tree(folder: &Path) {
    std::fs::write(folder.join("shrub.toml"), shrub(300, 12)).expect("writable");
    let grown = spinney(folder, &["grow", "shrub.toml", "-o", "shrub.glb"]);
    assert!(
        grown.status.success(),
        "{}",
        String::from_utf8_lossy(&grown.stderr)
    );
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = spinney(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {said}");
    serde_json::from_slice(&output.stdout).expect("JSON on standard output")
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}

#[test]
fn built_levels_hold_what_they_say() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    own_tree(folder.path());
    let told = json(
        folder.path(),
        &[
            "build",
            "shrub.glb",
            "--levels",
            "3",
            "--texture",
            "32",
            "--json",
            "-o",
            "levels",
        ],
    );
    let levels = told["levels"].as_array().expect("a list");
    let of_chain = |chain: &str| -> Vec<&Value> {
        levels
            .iter()
            .filter(|level| level["chain"] == chain)
            .collect()
    };
    let leaves: Vec<u64> = of_chain("leaves")
        .iter()
        .map(|level| level["leaves"].as_u64().expect("a number"))
        .collect();
    assert_eq!(leaves, [300, 150, 75]);
    assert_eq!(of_chain("branches").len(), 3);
    assert_eq!(of_chain("impostors").len(), 3);
    let errors: Vec<f64> = of_chain("leaves")
        .iter()
        .map(|level| level["error_m"].as_f64().expect("a number"))
        .collect();
    assert!(
        errors.is_sorted() && errors[0] == 0.0 && errors[2] > 0.0,
        "{errors:?}"
    );
    for level in levels {
        // What other programs read is as much as is told.
        let file = level["file"].as_str().expect("a name");
        let path = folder.path().join("levels").join(file);
        assert_eq!(
            std::fs::metadata(&path).expect("it is there").len(),
            level["bytes"].as_u64().expect("a number")
        );
        let found = import(&path, &ImportOptions::default()).expect("it reads back");
        assert_eq!(
            found.report.found("triangles"),
            level["triangles"].as_u64().expect("a number"),
            "{file}"
        );
    }
    // The plant itself comes back as it was.
    let original = import(&folder.path().join("shrub.glb"), &ImportOptions::default());
    let again = import(
        &folder.path().join("levels/tree.glb"),
        &ImportOptions::default(),
    );
    assert_eq!(
        original.expect("sound").plant.digest(),
        again.expect("sound").plant.digest()
    );
}

#[test]
fn a_collapse_file_is_laid_out_as_documented() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    own_tree(folder.path());
    json(
        folder.path(),
        &[
            "build",
            "shrub.glb",
            "--levels",
            "1",
            "--texture",
            "8",
            "--json",
            "-o",
            "levels",
        ],
    );
    let bytes = std::fs::read(folder.path().join("levels/collapses.bin")).expect("written");
    assert_eq!(&bytes[..8], b"SPINNEYC");
    let length = word(&bytes, 8) as usize;
    assert_eq!((12 + length) % 4, 0);
    let header: Value = serde_json::from_slice(&bytes[12..12 + length]).expect("JSON");
    let leaves = usize::try_from(header["leaves"].as_u64().expect("a number")).expect("small");
    let collapses =
        usize::try_from(header["collapses"].as_u64().expect("a number")).expect("small");
    assert!(leaves == 300 && collapses > 200, "{header}");
    let array = |name: &str| -> Vec<u32> {
        let entry = &header["arrays"][name];
        let number = |key: &str| usize::try_from(entry[key].as_u64().expect("a number"));
        let (offset, count) = (
            number("offset").expect("small"),
            number("count").expect("small"),
        );
        let words = count * number("components").expect("small");
        (0..words)
            .map(|place| word(&bytes, offset + 4 * place))
            .collect()
    };
    // Each collapse takes two leaves that show, and brings one of their vertices or its own.
    let (old, corners, vertices) = (array("old"), array("corners"), array("vertices"));
    assert_eq!(corners.len(), 4 * (leaves + collapses));
    assert_eq!(
        (array("error").len(), array("cluster").len()),
        (collapses, leaves + collapses)
    );
    let mut shows = vec![true; leaves];
    for pair in old.chunks(2) {
        for &leaf in pair {
            assert!(
                std::mem::replace(&mut shows[leaf as usize], false),
                "leaf {leaf} is gone twice"
            );
        }
        shows.push(true);
    }
    assert_eq!(
        shows.iter().filter(|shows| **shows).count(),
        leaves - collapses
    );
    assert!(
        corners
            .iter()
            .all(|&vertex| 3 * (vertex as usize) < vertices.len())
    );
    // The last array ends where the file does.
    let error = &header["arrays"]["error"];
    let end = error["offset"].as_u64().expect("a number")
        + 4 * error["count"].as_u64().expect("a number");
    assert_eq!(end, bytes.len() as u64);
}

#[test]
fn compared_schemes_are_as_coarse_as_is_allowed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    own_tree(folder.path());
    let compare = |tolerance: &str| {
        json(
            folder.path(),
            &[
                "compare",
                "shrub.glb",
                "--texture",
                "16",
                "--side",
                "64",
                "--distances",
                "3",
                "--tolerance",
                tolerance,
                "--json",
                "-o",
                "compared",
            ],
        )
    };
    let strict = compare("0");
    let loose = compare("0.2");
    let scheme = |told: &Value, name: &str| -> Value {
        let schemes = told["schemes"].as_array().expect("a list");
        let found = schemes.iter().find(|scheme| scheme["scheme"] == name);
        found
            .unwrap_or_else(|| panic!("{name} is compared"))
            .clone()
    };
    let numbers = |scheme: &Value, key: &str| -> Vec<f64> {
        let steps = scheme["distances"].as_array().expect("a list");
        steps
            .iter()
            .map(|step| step[key].as_f64().expect("a number"))
            .collect()
    };
    for name in [
        "lodf-cluster",
        "lodf-stamps",
        "vdf-host",
        "lodf-stamps-pruned",
    ] {
        let found = scheme(&strict, name);
        assert_eq!(found["worst_flip"], 0.0, "{name}");
        let found = scheme(&loose, name);
        assert!(
            numbers(&found, "flip").iter().all(|&flip| flip <= 0.2),
            "{name}"
        );
        let leaves = numbers(&found, "leaves");
        assert!(
            leaves.iter().all(|&leaves| leaves < 300.0),
            "{name}: {leaves:?}"
        );
    }
    // Modes of a model show the same leaves; what they send differs.
    let [cluster, stamps] = ["lodf-cluster", "lodf-stamps"].map(|name| scheme(&loose, name));
    assert_eq!(numbers(&cluster, "leaves"), numbers(&stamps, "leaves"));
    assert!(
        numbers(&stamps, "change_payload_bytes")
            .iter()
            .all(|&bytes| bytes <= 4.0)
    );
    let full = scheme(&loose, "full");
    assert_eq!(numbers(&full, "leaves"), [300.0; 3]);
    // Wood has schemes of its own: a mesh's levels are the same wherever its triangles lie.
    let wood = |told: &Value, name: &str| -> Value {
        let schemes = told["wood_schemes"].as_array().expect("a list");
        let found = schemes.iter().find(|scheme| scheme["scheme"] == name);
        found
            .unwrap_or_else(|| panic!("{name} is compared"))
            .clone()
    };
    for name in ["lodstrips-device", "lodstrips-host", "lodstrips-cut-device"] {
        // Strips have their triangles in an order of their own, which decides where two are as near: a pixel
        // or two, of the hundred or so of the tree at the farthest.
        let flip = wood(&strict, name)["worst_flip"].as_f64();
        assert!(flip.is_some_and(|flip| flip < 5e-3), "{name}: {flip:?}");
        let found = wood(&loose, name);
        let flips = numbers(&found, "flip");
        assert!(flips.iter().all(|&flip| flip <= 0.2), "{name}: {flips:?}");
        // Fewer at every distance; how many fewer farther off is noise in pictures of so few pixels.
        let primitives = numbers(&found, "primitives");
        let full = numbers(&wood(&loose, "full"), "primitives");
        let mut pairs = primitives.iter().zip(&full);
        assert!(
            pairs.all(|(found, full)| found < full),
            "{name}: {primitives:?}"
        );
    }
    let [fine, coarse] =
        [&strict, &loose].map(|told| numbers(&wood(told, "branches-mesh"), "primitives"));
    assert!(
        coarse[0] > 0.0 && coarse[0] < fine[0],
        "{coarse:?}, {fine:?}"
    );
    let said = loose["advice"].to_string();
    assert!(
        said.contains("For the leaves take ") && said.contains("For the wood take "),
        "{said}"
    );
    assert!(!loose["advice"].as_array().expect("a list").is_empty());
    let page = std::fs::read_to_string(folder.path().join("compared/report.html"));
    assert!(page.expect("written").contains("lodf-stamps"));
}

#[test]
fn what_is_no_tree_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("tree.xyz"), "1 2 3\n").expect("writable");
    for command in ["build", "compare", "inspect"] {
        let output = spinney(folder.path(), &[command, "tree.xyz"]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{command}: {said}");
        assert!(
            said.contains("tree.xyz: neither its content nor the ending"),
            "{said}"
        );
        assert!(!folder.path().join("out").exists(), "{command}");
    }
}

#[test]
fn a_tree_without_leaves_has_schemes_of_wood_alone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let cylinders = "radius,length,startX,startY,startZ,endX,endY,endZ,ID,parentID\n\
        0.1,1,0,0,0,0,0,1,0,-1\n0.08,1,0,0,1,0,0.1,2,1,0\n0.03,1,0,0,1,0.8,0.1,1.5,2,0\n";
    std::fs::write(folder.path().join("tree.csv"), cylinders).expect("writable");
    let arguments = [
        "compare",
        "tree.csv",
        "--side",
        "32",
        "--distances",
        "2",
        "--json",
        "-o",
        "c",
    ];
    let told = json(folder.path(), &arguments);
    assert_eq!(told["schemes"], serde_json::json!([]));
    assert!(
        told["wood_schemes"].as_array().expect("a list").len() > 8,
        "{told}"
    );
    let advice = told["advice"].as_array().expect("a list");
    assert!(
        advice[0]
            .as_str()
            .expect("a text")
            .starts_with("For the wood take "),
        "{advice:?}"
    );
    for written in [
        "report.html",
        "wood.csv",
        "plots/wood.svg",
        "sheets/wood.png",
    ] {
        assert!(folder.path().join("c").join(written).is_file(), "{written}");
    }
    assert!(!folder.path().join("c/leaves.csv").exists());
    json(folder.path(), &["build", "tree.csv", "--json", "-o", "b"]);
}
