//! `spinney diff` as a user meets it: exit codes, words, JSON, folders.

use std::path::Path;

use serde_json::{Value, json};
use spinney::report::{Layer, LayerSamples, Picture, encode_exr};
use tempfile::TempDir;

use crate::program::{BROOM, shrub, spinney};

/// What a comparison prints, and its exit code.
fn diff(folder: &Path, arguments: &[&str]) -> (String, Option<i32>) {
    let output = spinney(folder, &[&["diff"], arguments].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.is_empty(), "{said}");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let widest = text.lines().map(|line| line.chars().count()).max();
    assert!(widest <= Some(80), "{text}");
    (text, output.status.code())
}

fn diff_json(folder: &Path, arguments: &[&str]) -> Value {
    let output = spinney(folder, &[&["diff", "--json"], arguments].concat());
    let value: Value = serde_json::from_slice(&output.stdout).expect("JSON on standard output");
    let code = if value["same"] == json!(true) { 0 } else { 1 };
    assert_eq!(output.status.code(), Some(code), "{value}");
    assert_eq!(value["schema"], "spinney.diff/1", "{value}");
    value
}

/// What is said of input that is refused.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = spinney(folder, &[&["diff"], arguments].concat());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(
        output.stdout.is_empty() && !said.contains("panicked"),
        "{said}"
    );
    assert!(
        !folder.join("out").exists(),
        "{arguments:?} left something behind"
    );
    said
}

/// Writes a grey picture with one pixel of another grey.
fn grey(folder: &Path, name: &str, size: [u32; 2], odd: usize, value: u8) {
    let [width, height] = size;
    let mut rgba = [100, 100, 100, 255].repeat((width * height) as usize);
    rgba[4 * odd + 1] = value;
    let picture = Picture::new(width, height, rgba).expect("filled");
    let png = picture.to_png().expect("a picture");
    std::fs::write(folder.join(name), png).expect("writable");
}

fn pictures() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    grey(folder.path(), "a.png", [16, 12], 0, 100);
    grey(folder.path(), "b.png", [16, 12], 35, 130);
    grey(folder.path(), "wide.png", [24, 8], 0, 100);
    folder
}

#[test]
fn exit_codes_tell_whether_pictures_are_the_same() {
    let folder = pictures();
    let path = folder.path();
    let (text, code) = diff(path, &["a.png", "a.png"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("all 192 are equal"), "{text}");
    let (text, code) = diff(path, &["a.png", "b.png"]);
    assert_eq!(code, Some(1), "{text}");
    for part in ["1 of 192 pixels", "30 of 255 at (3, 2)", "x 3..=3, y 2..=2"] {
        assert!(text.contains(part), "{part:?} is not in {text}");
    }
    assert_eq!(
        diff(path, &["a.png", "b.png", "--tolerance", "29"]).1,
        Some(1)
    );
    assert_eq!(
        diff(path, &["a.png", "b.png", "--tolerance", "30"]).1,
        Some(0)
    );
    let (text, code) = diff(path, &["a.png", "wide.png", "--tolerance", "255"]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("24 × 8 pixels, expected 16 × 12"), "{text}");
}

#[test]
fn json_holds_every_measure() {
    let folder = pictures();
    let found = diff_json(folder.path(), &["a.png", "b.png", "--tolerance", "2"]);
    assert_eq!(found["kind"], "images");
    assert_eq!([&found["expected"], &found["actual"]], ["a.png", "b.png"]);
    let metrics = &found["look"]["metrics"];
    for (key, wanted) in [
        ("pixels", json!(192)),
        ("differing", json!(1)),
        ("unequal", json!(1)),
        ("largest", json!(30)),
        ("largest_at", json!([3, 2])),
        ("bounds", json!([3, 2, 3, 2])),
        ("mean", json!(30.0 / 576.0)),
        ("mean_square", json!(900.0 / 576.0)),
    ] {
        assert_eq!(metrics[key], wanted, "{key}");
    }
    assert_eq!(metrics["flip"]["largest_at"], json!([3, 2]));
    let same = diff_json(folder.path(), &["a.png", "a.png"]);
    let metrics = &same["look"]["metrics"];
    assert_eq!([&metrics["psnr_db"], &metrics["bounds"]], [&Value::Null; 2]);
    assert_eq!(metrics["ssim"], 1.0);
    assert_eq!(metrics["flip"]["mean"], 0.0);
    let sizes = diff_json(folder.path(), &["a.png", "wide.png"]);
    let wanted = json!({ "sizes": [[16, 12], [24, 8]], "metrics": null });
    assert_eq!(sizes["look"], wanted);
}

#[test]
fn wrong_input_is_named_with_its_fault() {
    let folder = pictures();
    let path = folder.path();
    let png = std::fs::read(path.join("a.png")).expect("just written");
    let exr = encode_exr(2, 1, vec![numbers("leaf", vec![1, 2])]).expect("an image");
    for (name, bytes) in [
        ("cut.png", &png[..png.len() / 2]),
        ("cut.exr", &exr[..exr.len() - 5]),
        ("leaf.exr", &exr),
        ("words.txt", b"a picture"),
    ] {
        std::fs::write(path.join(name), bytes).expect("writable");
    }
    std::fs::create_dir(path.join("folder")).expect("writable");
    for (other, said) in [
        ("none.png", "none.png: cannot read"),
        ("cut.png", "cut.png: no sound PNG file"),
        ("cut.exr", "cut.exr: no sound EXR file"),
        ("words.txt", "words.txt: neither a PNG nor an EXR file"),
        ("leaf.exr", "leaf.exr: no channels R, G, B or Y"),
        ("folder", "folder: a folder, wanted an image"),
    ] {
        for arguments in [["a.png", other], [other, "a.png"]] {
            let found = refused(path, &[&arguments[..], &["-o", "out"]].concat());
            assert!(found.contains(said), "{said:?} is not in {found}");
        }
    }
    for (arguments, said) in [
        (
            ["folder", "folder"],
            "folder: no whole run folder: no ledger.json",
        ),
        (["folder", "missing"], "no whole run folder"),
        (
            ["missing", "folder"],
            "missing: no whole run folder: no folder",
        ),
    ] {
        let found = refused(path, &[&arguments[..], &["-o", "out"]].concat());
        assert!(found.contains(said), "{said:?} is not in {found}");
    }
    refused(path, &["a.png", "b.png", "--tolerance", "256"]);
    refused(path, &["a.png"]);
}

fn numbers(name: &str, samples: Vec<u32>) -> Layer {
    Layer {
        name: name.to_owned(),
        samples: LayerSamples::U32(samples),
    }
}

fn floats(name: &str, samples: Vec<f32>) -> Layer {
    Layer {
        name: name.to_owned(),
        samples: LayerSamples::F32(samples),
    }
}

#[test]
fn exr_files_are_compared_channel_by_channel() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    let write = |name: &str, layers| {
        let file = encode_exr(2, 2, layers).expect("an image");
        std::fs::write(path.join(name), file).expect("writable");
    };
    let colour = |red: f32| {
        let even = |name| floats(name, vec![0.5; 4]);
        let red = floats("R", vec![0.5, 0.5, red, 0.5]);
        vec![red, even("G"), even("B")]
    };
    let leaves = |last| numbers("leaf", vec![1, 2, 3, last]);
    write("a.exr", [colour(0.5), vec![leaves(u32::MAX)]].concat());
    write("b.exr", [colour(0.25), vec![leaves(7)]].concat());
    write(
        "c.exr",
        [colour(0.5), vec![floats("depth", vec![0.0; 4])]].concat(),
    );
    assert_eq!(diff(path, &["a.exr", "a.exr"]).1, Some(0));
    let found = diff_json(path, &["a.exr", "b.exr"]);
    let told: Vec<Value> = (found["channels"].as_array().expect("channels").iter())
        .map(|channel| json!([channel["name"], channel["largest"], channel["largest_at"]]))
        .collect();
    let wanted = [
        json!(["B", 0.0, null]),
        json!(["G", 0.0, null]),
        json!(["R", 0.25, [0, 1]]),
        json!(["leaf", 4_294_967_288.0, [1, 1]]),
    ];
    assert_eq!(told, wanted);
    assert_eq!(found["look"]["metrics"]["differing"], 1);
    // No tolerance for data.
    assert_eq!(
        diff(path, &["a.exr", "b.exr", "--tolerance", "255"]).1,
        Some(1)
    );
    let (text, code) = diff(path, &["a.exr", "c.exr"]);
    assert_eq!(code, Some(1), "{text}");
    assert!(
        text.contains("only in the first: leaf\nonly in the second: depth\n"),
        "{text}"
    );

    // Linear 0.5 is byte 188.
    let rgba = [188, 188, 188, 255].repeat(4);
    let png = Picture::new(2, 2, rgba).and_then(|picture| picture.to_png());
    std::fs::write(path.join("a.png"), png.expect("a picture")).expect("writable");
    assert_eq!(diff(path, &["a.png", "c.exr"]).1, Some(0));
    assert_eq!(diff(path, &["b.exr", "a.png"]).1, Some(1));
}

#[test]
fn deep_pictures_are_compared_at_their_depth() {
    use image::{ExtendedColorType, ImageEncoder as _, codecs::png::PngEncoder};
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    // 200 · 257 and one more.
    for (name, value) in [("a.png", 51_400_u16), ("b.png", 51_401)] {
        let mut png = Vec::new();
        PngEncoder::new(&mut png)
            .write_image(&value.to_ne_bytes(), 1, 1, ExtendedColorType::L16)
            .expect("a picture");
        std::fs::write(path.join(name), png).expect("writable");
    }
    let shallow = Picture::new(1, 1, vec![200, 200, 200, 255]);
    let png = shallow.and_then(|picture| picture.to_png());
    std::fs::write(path.join("c.png"), png.expect("a picture")).expect("writable");
    let found = diff_json(path, &["a.png", "b.png"]);
    assert_eq!(found["channels"][0]["largest"], 1.0);
    assert_eq!(
        found["look"]["metrics"]["unequal"], 0,
        "at 8 bits nothing is seen"
    );
    assert_eq!(diff(path, &["a.png", "c.png"]).1, Some(0));
    assert_eq!(diff(path, &["c.png", "b.png"]).1, Some(1));
    assert_eq!(
        diff(path, &["c.png", "b.png", "--tolerance", "1"]).1,
        Some(0)
    );
}

#[test]
fn folders_hold_triptychs_maps_and_a_page() {
    let folder = pictures();
    let path = folder.path();
    let (_, code) = diff(path, &["a.png", "b.png", "-o", "out/d"]);
    assert_eq!(code, Some(1));
    let three = Picture::read(&path.join("out/d/triptych.png")).expect("a picture");
    assert_eq!([three.width(), three.height()], [52, 12]);
    for file in ["out/d/differing.png", "out/d/flip.png"] {
        let map = Picture::read(&path.join(file)).expect("a picture");
        assert_eq!([map.width(), map.height()], [16, 12]);
    }
    let page = std::fs::read_to_string(path.join("out/d/report.html")).expect("a page");
    for part in [
        "They differ.",
        "30 of 255 at (3, 2)",
        "a.png",
        "data:image/png",
    ] {
        assert!(page.contains(part), "{part}");
    }
    // Unequal sizes have a triptych, and no map.
    assert_eq!(diff(path, &["a.png", "wide.png", "-o", "out/d"]).1, Some(1));
    assert!(path.join("out/d/triptych.png").exists() && !path.join("out/d/flip.png").exists());
    // What cannot be written is exit code 4, and nothing is printed.
    let output = spinney(path, &["diff", "a.png", "b.png", "-o", "a.png/d"]);
    assert_eq!(output.status.code(), Some(4));
}

#[test]
fn runs_are_compared_frame_by_frame_and_field_by_field() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    std::fs::write(path.join("shrub.toml"), shrub(200, 90)).expect("writable");
    std::fs::write(path.join("scene.toml"), BROOM).expect("writable");
    let farther = BROOM.replace("40.0]", "80.0]");
    std::fs::write(path.join("far.toml"), farther).expect("writable");
    for (scene, out) in [
        (&["run", "scene.toml", "-o", "a", "--layers"][..], "1"),
        (&["run", "scene.toml", "-o", "b", "--layers"], "2"),
        (&["run", "far.toml", "-o", "c", "--layers"], "2"),
        (&["run", "scene.toml", "-o", "d", "--frames", "0..2"], "2"),
    ] {
        let output = spinney(path, &[scene, &["--quiet", "--threads", out]].concat());
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    let (text, code) = diff(path, &["a", "b"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains(" equal, 0 not"), "{text}");

    let found = diff_json(path, &["a", "c", "-o", "out"]);
    assert_eq!(
        [&found["kind"], &found["compared"]],
        [&json!("runs"), &json!(3)]
    );
    let names = |list: &Value| -> Vec<String> {
        let list = list.as_array().expect("a list").iter();
        list.map(|entry| entry["name"].as_str().expect("a name").to_owned())
            .collect()
    };
    // The camera starts at the same place.
    let frames = found["frames"].as_array().expect("frames");
    let numbers: Vec<&Value> = frames.iter().map(|frame| &frame["frame"]).collect();
    assert_eq!(numbers, [1, 2]);
    assert!(names(&frames[0]["ledger"]).contains(&"upload.payload_bytes".to_owned()));
    assert!(!names(&frames[0]["ledger"]).contains(&"image_digest".to_owned()));
    assert!(names(&found["totals"]).contains(&"leaves".to_owned()));
    assert_eq!(names(&found["head"]), ["scene", "scene_digest"]);
    assert!(names(&found["files"]).contains(&"frame-0001.exr".to_owned()));
    for file in ["frame-0001.png", "frame-0002-flip.png", "report.html"] {
        assert!(path.join("out").join(file).exists(), "{file}");
    }
    assert!(!path.join("out/frame-0000.png").exists());
    let page = std::fs::read_to_string(path.join("out/report.html")).expect("a page");
    // Of each of two frames expected, actual, differing, and the map.
    assert_eq!(page.matches("<img").count(), 8);

    let (text, code) = diff(path, &["a", "d"]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("only in the first: frames 2\n"), "{text}");
    assert!(text.contains("frame-0000.exr"), "{text}");

    // A picture that is gone, a ledger that is cut, a ledger of another kind.
    let ledger = std::fs::read_to_string(path.join("b/ledger.json")).expect("a ledger");
    std::fs::write(path.join("b/ledger.json"), &ledger[..200]).expect("writable");
    let said = spinney(path, &["diff", "a", "b"]);
    assert_eq!(said.status.code(), Some(2));
    let said = String::from_utf8_lossy(&said.stderr).into_owned();
    assert!(
        said.contains("b: no whole run folder: ledger.json: "),
        "{said}"
    );
    std::fs::write(
        path.join("b/ledger.json"),
        ledger.replace("ledger/1", "ledger/9"),
    )
    .expect("writable");
    let said = spinney(path, &["diff", "a", "b"]);
    assert!(String::from_utf8_lossy(&said.stderr).contains("spinney.ledger/9"));
    std::fs::write(path.join("b/ledger.json"), ledger).expect("writable");
    std::fs::remove_file(path.join("b/frame-0001.png")).expect("writable");
    let said = spinney(path, &["diff", "b", "a"]);
    assert_eq!(said.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&said.stderr).contains("no frame-0001.png"));
}
