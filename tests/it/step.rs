//! `spinney step`: levels as they are asked for, each with its picture and what it took.

use std::io::Write as _;
use std::path::Path;
use std::process::{Output, Stdio};

use serde_json::Value;
use spinney::report::Picture;
use tempfile::TempDir;

use crate::program::{BROOM, program, shrub, spinney};

fn broom() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text);
    write("scene.toml", BROOM).expect("writable");
    write("shrub.toml", &shrub(400, 40)).expect("writable");
    folder
}

fn told(folder: &Path, arguments: &[&str], lines: &[u8]) -> Output {
    let mut program = program(folder, arguments);
    program.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = program.stderr(Stdio::piped()).spawn().expect("starts");
    let mut input = child.stdin.take().expect("piped");
    // What is refused before it reads has closed the pipe.
    _ = input.write_all(lines);
    drop(input);
    child.wait_with_output().expect("ends")
}

/// The answers to lines.
fn answers(folder: &Path, arguments: &[&str], lines: &str) -> Vec<Value> {
    let output = told(folder, arguments, lines.as_bytes());
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{errors}");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let lines = text.lines();
    lines
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect()
}

#[test]
fn levels_are_those_of_a_sweep_and_send_what_it_sends() {
    let folder = broom();
    let way = "0\n0.5\n1\n";
    let models = ["lodf-slots-gathered", "lodf-stamps", "vdf-indices"];
    let asked: String = models
        .iter()
        .map(|label| format!("model {label}\n{way}"))
        .collect();
    let said = answers(folder.path(), &["step", "scene.toml"], &asked);
    assert_eq!(said.len(), 1 + 4 * models.len());
    let sweep = spinney(
        folder.path(),
        &[
            "sweep",
            "scene.toml",
            "--steps",
            "2",
            "--models",
            &models.join(","),
            "--json",
            "--counters",
            "visible",
        ],
    );
    assert_eq!(sweep.status.code(), Some(0));
    let sweep: Value = serde_json::from_slice(&sweep.stdout).expect("JSON");
    for (number, label) in models.iter().enumerate() {
        let [begun, steps @ ..] = &said[1 + 4 * number..][..4] else {
            panic!("four answers a model")
        };
        let model = &sweep["models"][number];
        assert_eq!(begun["schema"], "spinney.step/1");
        assert_eq!(begun["model"], *label);
        assert_eq!(begun["leaves"], 400);
        assert_eq!(begun["initial"]["upload"], model["initial"]["upload"]);
        for (step, wanted) in steps.iter().zip(model["steps"].as_array().expect("steps")) {
            for key in [
                "level",
                "leaves",
                "triangles",
                "collapses",
                "upload",
                "fetch",
                "image_digest",
            ] {
                assert_eq!(step[key], wanted[key], "{label}, {key}");
            }
        }
    }
}

#[test]
fn what_means_nothing_is_answered_and_changes_nothing() {
    let folder = broom();
    let lines = "0.5\nfine\n1.5\n\n0.5 3\nmodel oak\nmodel lodf-device\nmodel lodf-slots-pruned\n\
                 0.5\nmodel full\n0.5 2";
    let said = answers(folder.path(), &["step", "scene.toml"], lines);
    assert_eq!(said.len(), 12);
    for (number, parts) in [
        (2, ["fine", "0.25"]),
        (3, ["1.5", "0.25"]),
        (4, ["\"\"", "0.25"]),
        (5, ["\"3\"", "0..3"]),
        (6, ["oak", "impostors-direct"]),
        (7, ["lodf-device", "gtx770"]),
        (8, ["pruned", "model.simplifier"]),
    ] {
        let error = said[number]["error"].as_str().expect("an error");
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        assert_eq!(said[number]["line"], number);
    }
    // The level stands already: it is drawn and sends nothing.
    assert_eq!(said[9]["image_digest"], said[1]["image_digest"]);
    assert_eq!(said[9]["upload"]["payload_bytes"], 0);
    assert_eq!(said[10]["model"], "full");
    // Nothing of detail; the view of another frame.
    let by_cause = said[11]["by_cause"].as_object().expect("causes");
    assert_eq!(by_cause.keys().collect::<Vec<_>>(), ["view"]);
    assert_eq!(said[11]["frame"], 2);
    assert_eq!(said[11]["leaves"], 400);
}

#[test]
fn bytes_that_are_no_text_are_answered_too() {
    let folder = broom();
    let mut lines = b"\xff\xfe\n".to_vec();
    lines.extend(vec![b'0'; 1 << 20]);
    lines.extend(b"\n0");
    let output = told(folder.path(), &["step", "scene.toml"], &lines);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let said: Vec<&str> = text.lines().collect();
    assert_eq!(said.len(), 4);
    assert!(said[1].contains("UTF-8") && said[2].contains("1024 bytes"));
    assert!(said[3].contains("\"level\":0"));
}

#[test]
fn the_picture_of_each_answer_is_in_its_file() {
    let folder = broom();
    let file = |name: &str| folder.path().join("pictures").join(name);
    answers(
        folder.path(),
        &["step", "scene.toml", "-o", "pictures/now.png"],
        "0\n1\n",
    );
    answers(
        folder.path(),
        &["step", "scene.toml", "-o", "pictures/now.rgba"],
        "1\n",
    );
    let png = Picture::read(&file("now.png")).expect("a picture");
    assert_eq!((png.width(), png.height()), (64, 48));
    let rows = std::fs::read(file("now.rgba")).expect("rows");
    assert_eq!(png.rgba(), rows);
    // Nothing hidden stays beside them.
    let beside = std::fs::read_dir(folder.path().join("pictures")).expect("a folder");
    assert_eq!(beside.count(), 2);
    for name in ["now.jpg", "now"] {
        let output = told(folder.path(), &["step", "scene.toml", "-o", name], b"0\n");
        assert_eq!(output.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&output.stderr).contains(".rgba"));
    }
    std::fs::create_dir(file("folder.png")).expect("a folder");
    let arguments = ["step", "scene.toml", "-o", "pictures/folder.png"];
    let output = told(folder.path(), &arguments, b"0\n");
    assert_eq!(output.status.code(), Some(4));
}
