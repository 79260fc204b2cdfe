//! `spinney golden` in a stranger's repository: what is told, written, and refused.

use std::path::Path;
use std::process::{Command, Output};

use spinney::golden::{Case, FindingKind, Goldens, Selection, Unused};
use spinney::report::Picture;
use spinney::run::Silent;
use tempfile::TempDir;

/// Sixty leaves on nine twigs.
const BROOM: &str = r##"schema = "spinney.species/1"
name = "broom"
leaf_count = 60
stop_leaves = 6

[crown]
levels = 2
scale = 6.0

[stems]
branches = [1.0, 9.0, 0.0, 0.0]

[leaves]
per_stem = 8.0

[[foliage]]
silhouette = "pinnate_entire"
length = 0.9
color = "#3f6b33"
"##;

const SCENE: &str = r#"schema = "spinney.scene/1"
size = [64, 48]
frames = 3

[[tree]]
species = "../broom.toml"

[camera]
path = [
    { frame = 0, eye = [0.0, 4.0, 12.0], target = [0.0, 4.0, 0.0] },
    { frame = 2, eye = [0.0, 4.0, 40.0], target = [0.0, 4.0, 0.0] },
]

[model]
mode = "slots"
"#;

/// The line of `[golden]` in the scene.
const LINE: usize = 17;

/// A repository with a species and the scene `trees/a`, whose frames 0 and 2 are kept.
struct Repository(TempDir);

impl Repository {
    fn new() -> Self {
        let repository = Self(tempfile::tempdir().expect("a temporary folder"));
        repository.put("scenes/broom.toml", BROOM);
        repository.scene("trees/a", "frames = [0, 2]");
        repository
    }

    /// A repository whose references are what its scene shows.
    fn blessed() -> Self {
        let repository = Self::new();
        let (code, told) = repository.told(&["golden", "bless"]);
        assert_eq!(code, 0, "{told}");
        repository
    }

    fn put(&self, name: &str, text: &str) {
        let file = self.0.path().join(name);
        std::fs::create_dir_all(file.parent().expect("a folder")).expect("writable");
        std::fs::write(file, text).expect("writable");
    }

    fn scene(&self, name: &str, golden: &str) {
        let text = format!("{SCENE}\n[golden]\nsize = [48, 36]\n{golden}\n");
        self.put(&format!("scenes/{name}.toml"), &text);
    }

    fn replace(&self, name: &str, from: &str, to: &str) {
        let text = self.text(name);
        assert!(text.contains(from), "{name} says {from:?}");
        self.put(name, &text.replacen(from, to, 1));
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.path().join(name)).expect("a text")
    }

    fn has(&self, name: &str) -> bool {
        self.0.path().join(name).exists()
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.run_in(arguments, "")
    }

    /// Runs the program as if `CI` had a value.
    fn run_in(&self, arguments: &[&str], ci: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_spinney"))
            // What is built must not come from another build.
            .env_remove("XDG_CACHE_HOME")
            .env_remove("HOME")
            .args(arguments)
            .current_dir(self.0.path())
            .env("CI", ci)
            .output()
            .expect("the program starts")
    }

    /// The exit code and standard output, in which no path of this machine may be.
    fn told(&self, arguments: &[&str]) -> (i32, String) {
        let output = self.run(arguments);
        let text = String::from_utf8(output.stdout).expect("UTF-8");
        let wrong = String::from_utf8(output.stderr).expect("UTF-8");
        let root = self.0.path().to_str().expect("a text");
        assert!(!format!("{text}{wrong}").contains(root), "{text}{wrong}");
        (output.status.code().expect("an exit code"), text)
    }

    fn check(&self) -> (i32, String) {
        self.told(&["golden", "check"])
    }

    fn goldens(&self) -> Goldens {
        Goldens {
            scenes: self.0.path().join("scenes"),
            references: self.0.path().join("golden"),
        }
    }
}

#[test]
fn what_was_blessed_is_the_same() {
    let repository = Repository::new();
    let (code, told) = repository.check();
    assert_eq!(code, 1);
    assert_eq!(
        told,
        "trees/a: frame 0: picture: missing; ledger: missing\n\
         trees/a: frame 2: picture: missing; ledger: missing\n\
         1 scene, 2 frames: 4 missing, 0 scenes the same\ntarget/golden/report.html\n"
    );
    let (code, told) = repository.told(&["golden", "bless"]);
    assert_eq!(code, 0);
    assert_eq!(
        told,
        "golden/trees/a-0000.png: added\ngolden/trees/a-0000.txt: added\n\
         golden/trees/a-0002.png: added\ngolden/trees/a-0002.txt: added\n\
         1 scene, 2 frames; 4 added\n"
    );
    let same = "1 scene, 2 frames: all the same\ntarget/golden/report.html\n";
    assert_eq!(repository.check(), (0, same.to_owned()));
    let nothing = "1 scene, 2 frames; nothing to bless\n".to_owned();
    assert_eq!(repository.told(&["golden", "bless"]), (0, nothing));
    // A checkout with other line ends is no difference.
    let table = repository.text("golden/trees/a-0000.txt");
    repository.put("golden/trees/a-0000.txt", &table.replace('\n', "\r\n"));
    assert_eq!(repository.check().0, 0);
}

#[test]
fn one_leaf_less_is_told_shown_and_blessed() {
    let repository = Repository::blessed();
    let twice = [0, 1].map(|_| {
        repository.replace("scenes/broom.toml", "8.0\n", "8.0\nomit = [7]\n");
        let found = repository.told(&[
            "golden",
            "check",
            "--annotate",
            "github",
            "--junit",
            "out/golden.xml",
        ]);
        let page = repository.text("target/golden/report.html");
        repository.replace("scenes/broom.toml", "8.0\nomit = [7]\n", "8.0\n");
        (found, page, repository.text("out/golden.xml"))
    });
    assert_eq!(twice[0], twice[1]);
    let ((code, told), page, junit) = &twice[0];
    assert_eq!(*code, 1);
    let lines: Vec<&str> = told.lines().collect();
    let message = "frame 0: picture: 3 of 1,728 pixels differ, by up to 205 of 255 at (19, 21), \
                   x 19..=21, y 20..=21; ledger: leaves 52 → 51 (-1), triangles 650 → 648 (-2), ";
    let annotation = format!(
        "::error file=scenes/trees/a.toml,line={LINE},title=trees/a is not as its reference::{message}"
    );
    assert!(lines[0].starts_with(&annotation), "{told}");
    assert!(lines[0].contains(" more%0Aframe 2: picture: "), "{told}");
    assert!(
        lines[1].starts_with(&format!("trees/a: {message}")),
        "{told}"
    );
    assert!(
        lines[2].starts_with("trees/a: frame 2: picture: 12 of 1,728 pixels differ, "),
        "{told}"
    );
    assert_eq!(
        lines[3..],
        [
            "1 scene, 2 frames: 4 differ, 0 scenes the same",
            "target/golden/report.html"
        ]
    );
    let triptych = Picture::read(&repository.0.path().join("target/golden/trees/a-0000.png"));
    let triptych = triptych.expect("a picture");
    assert_eq!((triptych.width(), triptych.height()), (3 * 48 + 4, 36));
    assert_eq!(page.matches("<img ").count(), 2);
    for part in [
        "Goldens: 1 of 1 scenes is not the same",
        "Expected | differing | actual",
        "<td>leaves</td>",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(
        !page.contains("src=\"http") && !page.contains("href="),
        "it opens offline"
    );
    for part in [
        "<testsuites name=\"spinney golden\" tests=\"2\" failures=\"2\" errors=\"0\" time=\"0\">",
        "<testsuite name=\"trees\" tests=\"2\" failures=\"2\" errors=\"0\" time=\"0\" skipped=\"0\">",
        "<testcase classname=\"trees/a\" name=\"frame 0\" time=\"0\">",
        "\n  leaves 52 → 51 (-1)\n",
    ] {
        assert!(junit.contains(part), "{part} is not in {junit}");
    }

    repository.replace("scenes/broom.toml", "8.0\n", "8.0\nomit = [7]\n");
    let (code, told) = repository.told(&["golden", "bless", "--only", "trees"]);
    assert_eq!(code, 0);
    assert!(
        told.starts_with(
            "golden/trees/a-0000.png: replaced: 3 of 1,728 pixels differ, by up to 205 of 255"
        ),
        "{told}"
    );
    assert!(told.ends_with("1 scene, 2 frames; 4 replaced\n"), "{told}");
    assert_eq!(repository.check().0, 0);
}

#[test]
fn a_tolerance_passes_with_its_reason_and_no_further() {
    let repository = Repository::blessed();
    repository.replace("scenes/broom.toml", "#3f6b33", "#416b33");
    assert_eq!(repository.check().0, 1);
    let tolerance = |most: u8| {
        let golden = format!("frames = [0, 2]\ntolerance = {most}\nreason = \"paint, still wet\"");
        repository.scene("trees/a", &golden);
    };
    tolerance(3);
    let (code, told) = repository.check();
    assert_eq!(code, 0, "{told}");
    assert!(
        told.contains("within the tolerance of 3 (paint, still wet)"),
        "{told}"
    );
    assert!(
        told.contains("\n1 scene, 2 frames, 2 of them within a tolerance: all the same\n"),
        "{told}"
    );
    let page = repository.text("target/golden/report.html");
    assert!(page.contains("paint, still wet"), "{page}");
    repository.replace("scenes/broom.toml", "#416b33", "#7f6b33");
    let (code, told) = repository.check();
    assert_eq!(code, 1);
    assert!(
        told.contains("pixels differ by more than 3, by up to "),
        "{told}"
    );
    // The ledger has no tolerance.
    tolerance(255);
    assert_eq!(repository.check().0, 0);
    repository.replace("golden/trees/a-0000.txt", "  52\n", "  62\n");
    let (code, told) = repository.check();
    assert_eq!(code, 1);
    assert!(told.contains("ledger: leaves 62 → 52 (-10)"), "{told}");
}

#[test]
fn missing_unused_oversized_and_broken_references_fail() {
    let repository = Repository::blessed();
    let references = repository.0.path().join("golden");
    let copy = |to: &str| {
        std::fs::copy(references.join("trees/a-0000.png"), references.join(to)).expect("writable");
    };
    copy("trees/a-0001.png");
    copy("old-0000.png");
    repository.put("golden/README.txt", "is nobody's reference");
    repository.put("golden/trees/a-0000.txt", &"x".repeat(40_000));
    let large = Picture::new(161, 1, [7, 7, 7, 255].repeat(161)).expect("filled");
    std::fs::write(
        references.join("trees/a-0000.png"),
        large.to_png().expect("a PNG"),
    )
    .expect("writable");
    repository.put("golden/trees/a-0002.png", "no picture");
    let (code, told) = repository.check();
    assert_eq!(code, 1);
    for part in [
        "frame 0: picture: 161 × 1 pixels in ",
        "; ledger: 40000 bytes, wanted at most 160 a side in 32768 bytes\n",
        "frame 2: picture: no PNG file\n",
        "golden/old-0000.png: unused: no scene keeps it\n",
        "golden/trees/a-0001.png: unused: no scene keeps it\n",
        "1 scene, 2 frames: 2 unused, 2 oversized, 1 unreadable, 0 scenes the same\n",
    ] {
        assert!(told.contains(part), "{part:?} is not in {told}");
    }
    let (code, told) = repository.told(&["golden", "bless"]);
    assert_eq!(code, 0, "{told}");
    assert!(
        told.contains("golden/old-0000.png: unused: no scene keeps it; kept\n"),
        "{told}"
    );
    assert!(told.ends_with("; 3 replaced, 2 unused kept\n"), "{told}");
    assert!(repository.has("golden/old-0000.png"));
    let (code, told) = repository.told(&["golden", "bless", "--remove-unused"]);
    assert_eq!(code, 0, "{told}");
    assert!(told.ends_with("; 2 removed\n"), "{told}");
    assert!(!repository.has("golden/old-0000.png") && repository.has("golden/README.txt"));
    assert_eq!(repository.check().0, 0);
}

#[test]
fn broken_scenes_are_findings_that_keep_nothing_else_from_being_compared() {
    let repository = Repository::blessed();
    repository.scene("trees/b", "frames = [0]");
    assert_eq!(repository.run(&["golden", "bless"]).status.code(), Some(0));
    repository.replace("scenes/trees/b.toml", "frames = [0]", "frames = [9]");
    repository.put(
        "scenes/notes.toml",
        "schema = \"somebody.else/1\"\nframes = [9]",
    );
    let (code, told) = repository.told(&["golden", "check", "--annotate", "github"]);
    assert_eq!(code, 1);
    let wrong = "scenes/trees/b.toml:19:10: `golden.frames`: found [9], wanted frames below 3, the \
                 scene's count";
    assert!(
        told.contains("::error file=scenes/trees/b.toml,line=19,title="),
        "{told}"
    );
    assert!(
        told.contains("\ntrees/b: 19:10: `golden.frames`: found [9]"),
        "{told}"
    );
    assert!(
        told.contains("\n2 scenes, 2 frames: 1 unreadable, 1 scene the same\n"),
        "{told}"
    );
    // Its references are neither unused nor replaced.
    let (code, told) = repository.told(&["golden", "bless", "--remove-unused"]);
    assert_eq!(code, 1);
    assert!(
        told.starts_with("scenes/trees/b.toml: not drawn: 19:10: "),
        "{told}"
    );
    assert!(repository.has("golden/trees/b-0000.png"));

    repository.replace("scenes/trees/a.toml", "../broom.toml", "../gone.toml");
    let output = repository.run(&["golden", "check"]);
    assert_eq!(output.status.code(), Some(2), "nothing could be compared");
    let told = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(
        told.contains("trees/a: scenes/trees/../gone.toml:1:1: cannot read"),
        "{told}"
    );
    let outcome = repository
        .goldens()
        .check(&Selection::ALL, &Silent)
        .expect("a folder");
    assert!(outcome.is_all_unreadable());
    let found: Vec<Case> = outcome
        .scenes
        .iter()
        .map(|scene| scene.cases[0].case)
        .collect();
    assert_eq!(found, [Case::Scene; 2]);
    let told: Vec<String> = outcome.findings().map(ToString::to_string).collect();
    assert!(
        told[1].ends_with(wrong.trim_start_matches("scenes/trees/")),
        "{told:?}"
    );
}

#[test]
fn digests_hold_scenes_without_pictures() {
    let repository = Repository::blessed();
    repository.put("scenes/trees/free.toml", SCENE);
    assert_eq!(repository.check().0, 0, "nothing of it is kept yet");
    let (_, lines) = repository.told(&["golden", "digests"]);
    assert_eq!(lines.lines().count(), 2);
    assert_eq!(
        lines,
        repository.told(&["golden", "digests", "--threads", "1"]).1
    );
    repository.put("golden/digests.txt", &lines);
    let same = "2 scenes, 2 frames: all the same\ntarget/golden/report.html\n";
    assert_eq!(repository.check(), (0, same.to_owned()));

    // The light changes the picture and nothing else.
    repository.replace(
        "scenes/trees/free.toml",
        "[model]",
        "[light]\nambient = [1, 0, 0]\n\n[model]",
    );
    repository.put(
        "golden/digests.txt",
        &format!("{lines}{}", lines.replace("trees/a", "gone")),
    );
    let (code, told) = repository.check();
    assert_eq!(code, 1);
    assert!(
        told.starts_with("trees/free: digests: images, ledgers differ\n"),
        "{told}"
    );
    assert!(
        told.contains("golden/digests.txt: line 3: unused: there is no scene \"gone\"\n"),
        "{told}"
    );
    let (code, told) = repository.told(&["golden", "bless"]);
    assert_eq!(code, 0);
    assert!(
        told.starts_with("golden/digests.txt: trees/free: replaced: images, ledgers differ\n"),
        "{told}"
    );
    assert_eq!(
        repository.told(&["golden", "bless", "--remove-unused"]).0,
        0
    );
    assert_eq!(repository.check(), (0, same.to_owned()));
    assert_eq!(
        repository.text("golden/digests.txt"),
        repository.told(&["golden", "digests"]).1
    );
}

#[test]
fn blessing_is_refused_in_ci() {
    let repository = Repository::new();
    let output = repository.run_in(&["golden", "bless"], "true");
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(told.contains("not blessed in CI"), "{told}");
    assert!(!repository.has("golden"));
}

#[test]
fn wrong_folders_and_outputs_are_refused() {
    let repository = Repository::blessed();
    for (arguments, code, part) in [
        (
            &["golden", "check", "nowhere"][..],
            2,
            "nowhere: cannot read",
        ),
        (
            &["golden", "digests", "golden"],
            2,
            "golden: no scene in this folder",
        ),
        (
            &["golden", "check", "--only", "oak"],
            2,
            "table and \"oak\" in its name",
        ),
        (
            &["golden", "check", "--json", "--annotate", "github"],
            2,
            "--json and --annotate",
        ),
        (
            &["golden", "check", "-o", "scenes/broom.toml/x"],
            4,
            "is a file, wanted a folder",
        ),
        (
            &["golden", "check", "-o", "scenes"],
            4,
            "which spinney did not write",
        ),
        (
            &["golden", "check", "--junit", "scenes"],
            4,
            "cannot write scenes",
        ),
        (
            &["golden", "bless", "--golden", "scenes/broom.toml"],
            2,
            "broom.toml: cannot read",
        ),
    ] {
        let output = repository.run(arguments);
        let told = String::from_utf8(output.stderr).expect("UTF-8");
        let root = repository.0.path().to_str().expect("a text");
        assert!(!told.contains(root), "{told}");
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {told}");
        assert!(
            told.contains(part),
            "{arguments:?}: {part:?} is not in {told:?}"
        );
    }
}

#[test]
fn programs_read_what_was_found_as_json() {
    let repository = Repository::blessed();
    repository.replace("golden/trees/a-0000.txt", "  52\n", "  62\n");
    let (code, told) = repository.told(&["golden", "check", "--json"]);
    assert_eq!(code, 1);
    let json: serde_json::Value = serde_json::from_str(&told).expect("JSON");
    assert_eq!(json["schema"], "spinney.golden/1");
    assert_eq!(
        (&json["same"], &json["counts"]["differ"]),
        (&false.into(), &1.into())
    );
    let scene = &json["scenes"][0];
    assert_eq!(
        (&scene["file"], &scene["line"]),
        (&"scenes/trees/a.toml".into(), &LINE.into())
    );
    let finding = &scene["cases"][0]["findings"][0];
    assert_eq!(
        (&finding["kind"], &finding["what"]),
        (&"differs".into(), &"ledger".into())
    );
    assert_eq!(finding["evidence"], "trees/a-0000.txt");
    let change = serde_json::json!({ "what": "leaves", "before": "62", "after": "52", "by": -10 });
    assert_eq!(finding["changes"], serde_json::Value::Array(vec![change]));
    assert_eq!(scene["cases"][1]["same"], true);
}

#[test]
fn libraries_find_and_bless_the_same() {
    let repository = Repository::new();
    let goldens = repository.goldens();
    let outcome = goldens.check(&Selection::ALL, &Silent).expect("scenes");
    assert_eq!(outcome.counts().missing, 4);
    assert!(
        outcome
            .findings()
            .all(|finding| finding.kind == FindingKind::Missing)
    );
    let blessing = goldens
        .bless(&Selection::ALL, Unused::Keep, &Silent)
        .expect("writable");
    assert_eq!((blessing.outcome, blessing.deeds.len()), (outcome, 4));
    goldens.assert_scene("trees/a");
    assert_eq!(goldens.names().expect("scenes"), ["trees/a"]);
    assert_eq!(goldens.unused().expect("references"), []);
    assert!(
        Path::new(&goldens.references)
            .join("trees/a-0002.txt")
            .exists()
    );
}

#[test]
#[should_panic(expected = "no [golden] table")]
fn assertions_want_something_to_compare() {
    let repository = Repository::new();
    repository.put("scenes/trees/free.toml", SCENE);
    repository.goldens().assert_scene("trees/free");
}
