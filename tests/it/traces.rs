//! Recorded traces: those of our models keep every law, what is broken is found at its line, and
//! what is no trace is refused there.

use std::io::Write as _;
use std::process::{Command, Stdio};

use spinney::models::{Kind, State};
use spinney::testkit::trace::{TraceReport, check_trace, record_model, record_structure};
use spinney::testkit::{History, Law, ModelStructure, Operation, Walk};

use crate::support::{OPTIONS, Stage, StageExt as _, random_crown, random_state};

const EXAMPLE: &str = include_str!("../../src/testkit/trace/example.jsonl");

fn check(text: &str) -> Result<TraceReport, String> {
    check_trace("t.jsonl", text.as_bytes()).map_err(|error| error.to_string())
}

/// The broken laws with the lines where they break first.
fn broken(report: &TraceReport) -> Vec<(Law, usize)> {
    let laws = report.laws.iter();
    laws.filter_map(|law| law.first.as_ref().map(|(line, _)| (law.law, *line)))
        .collect()
}

#[test]
fn the_documented_example_breaks_where_it_says() {
    let report = check(EXAMPLE).expect("a trace");
    assert_eq!((report.leaves, report.collapses, report.steps), (3, 1, 3));
    let wanted = [
        Law::Partition,
        Law::SplitUndoesCollapse,
        Law::HistoryIndependence,
        Law::MonotoneDetail,
        Law::Residency,
    ];
    assert_eq!(broken(&report), wanted.map(|law| (law, 4)));
    let unrecorded = report.laws.iter().find(|law| law.checked == 0);
    assert_eq!(unrecorded.map(|law| law.law), Some(Law::ImageEquality));
    // Sound, if the split wrote both slots back and told what shows.
    let mended = EXAMPLE
        .replace("[0,2,2]", "[0,1,2]")
        .replace("000002000200", "000001000200")
        .replace(
            r#"[[{"to":0,"at":0,"hex":"0000"}]],"counted":{"transfers":1,"bytes":2}"#,
            r#"[[{"to":0,"at":0,"hex":"00000100"}]],"counted":{"transfers":1,"bytes":4}"#,
        );
    assert!(check(&mended).expect("a trace").is_kept());
    let uncounted = mended.replace(r#"{"transfers":1,"bytes":4}}"#, "");
    let uncounted = uncounted.replacen(
        r#""transfers":1,"bytes":4"#,
        r#""transfers":1,"bytes":2"#,
        1,
    );
    let report = check(&uncounted).expect("a trace");
    assert_eq!(broken(&report), [(Law::Conservation, 3)]);
}

#[test]
fn our_models_record_traces_that_keep_every_law() {
    for seed in 0..6 {
        let crown = random_crown(seed, 9, 3);
        let history = History::of(crown.sequence());
        let mut states: Vec<State> = (0..12).map(|choice| random_state(&crown, choice)).collect();
        states.extend([states[3].clone(), State::FINEST]);
        for kind in Kind::SOUND.into_iter().filter(|kind| kind.has_levels()) {
            let model = kind.model(&crown, OPTIONS);
            let build = |state: &State| Stage::at(kind, OPTIONS, &crown, state, 24);
            let mut trace = Vec::new();
            let visible = |state: &State| model.drawn(state);
            record_model(&mut trace, &history, &states, build, visible).expect("into memory");
            let report = check_trace("t", trace.as_slice()).expect("a trace");
            assert_eq!(broken(&report), [], "{kind:?} {seed}");
            for law in report.laws {
                let apart = [Law::SplitUndoesCollapse, Law::ErrorNeverRises];
                let wanted = !apart.contains(&law.law);
                assert_eq!(law.checked > 0, wanted, "{kind:?}: {:?}", law.law);
            }
        }
    }
}

#[test]
fn the_papers_list_is_found_in_its_trace() {
    let history = History::new(4, &[[0, 1], [2, 4], [5, 3]]).expect("a sound history");
    let crown = random_crown(1, 4, 1);
    let plant = crown.plant().clone();
    let crown = spinney::models::Crown::new(plant, history.sequence().clone()).into();
    let operations = [const { Operation::Collapse }; 3]
        .into_iter()
        .chain([const { Operation::Split }; 3]);
    let walk = Walk {
        history,
        operations: operations.collect(),
    };
    let found = |kind: Kind| {
        let mut trace = Vec::new();
        let build = |_: &History| ModelStructure::new(kind.model(&crown, OPTIONS));
        record_structure(&mut trace, &walk, build).expect("into memory");
        check_trace("t", trace.as_slice()).expect("a trace")
    };
    assert!(found(Kind::LodfSlots).is_kept());
    let literal = found(Kind::LodfLiteral);
    assert!(
        broken(&literal).contains(&(Law::Partition, 4)),
        "{literal:?}"
    );
    let split = literal
        .laws
        .iter()
        .find(|law| law.law == Law::SplitUndoesCollapse);
    assert_eq!(split.map(|law| law.checked), Some(1));
}

#[test]
fn what_is_no_trace_is_refused_at_its_line() {
    let header = EXAMPLE.lines().next().expect("a header");
    let visible =
        r#"{"schema":"spinney.trace/1","leaves":3,"collapses":[[0,1]],"parts":["visible"]}"#;
    let with = |step: &str| format!("{visible}\n{{\"level\":0,\"visible\":[0]}}\n{step}");
    let second = |step: &str| format!("{header}\n{step}");
    let cases = [
        (String::new(), "t.jsonl:1:1: no header"),
        ("{}".to_owned(), "t.jsonl:1:2: missing field `schema`"),
        (
            visible.replace("/1", "/9"),
            "t.jsonl:1:1: schema \"spinney.trace/9\", wanted",
        ),
        (
            visible.replace("[0,1]", "[0,3]"),
            "t.jsonl:1:1: collapses: collapse 0 consumes leaf 3",
        ),
        (
            visible.replace(":3,", ":4294967295,"),
            "t.jsonl:1:1: 4294967295 leaves, at most",
        ),
        (
            visible.replace("[\"visible\"]", "[]"),
            "t.jsonl:1:1: no parts",
        ),
        (
            visible.replace("visible", "fresh"),
            "t.jsonl:1:1: part \"fresh\" needs \"resident\"",
        ),
        (
            visible.replace("visible", "writes"),
            "t.jsonl:1:1: part \"writes\" needs \"resources\"",
        ),
        (
            visible.replace("visible", "colour"),
            "t.jsonl:1:73: unknown variant `colour`",
        ),
        (visible.to_owned(), "t.jsonl:2:1: no step follows"),
        (
            with("{\"level\":2,\"visible\":[]}"),
            "t.jsonl:3:1: level 2, but there are 1 collapses",
        ),
        (
            with("{\"level\":1}"),
            "t.jsonl:3:1: the header says that steps do tell \"visible\"",
        ),
        (
            with("{\"visible\":[]}"),
            "t.jsonl:3:1: wanted exactly one of",
        ),
        (
            with("{\"split\":1,\"visible\":[]}"),
            "t.jsonl:3:1: 1 splits, but only 0",
        ),
        (
            with("{\"clusters\":[0],\"visible\":[]}"),
            "t.jsonl:3:1: 1 numbers for 2 clusters",
        ),
        (
            with("{\"clusters\":[2,0],\"visible\":[]}"),
            "t.jsonl:3:1: 2 collapses in cluster 0",
        ),
        (
            with("{\"level\":0,\"visible\":[-1]}"),
            "t.jsonl:3:25: invalid value",
        ),
        (
            with("{\"level\":0,\"visible\":[],\"image\":\"\"}"),
            "t.jsonl:3:1: the header says that steps do not tell",
        ),
        (
            with("\n\n{\"level\":0,\"visible\":7}"),
            "t.jsonl:5:23: invalid type",
        ),
        (with("{\"level\":0,"), "t.jsonl:3:11: EOF"),
        (
            second("{\"collapse\":1}"),
            "t.jsonl:2:1: the header says that",
        ),
        (
            EXAMPLE.replace("\"at\":2", "\"at\":5"),
            "t.jsonl:3:1: bytes 5..7 of resource 0, which has 6",
        ),
        (
            EXAMPLE.replace("\"to\":0,\"at\":2", "\"to\":1,\"at\":2"),
            "t.jsonl:3:1: resource 1, but there are 1",
        ),
        (
            EXAMPLE.replace("\"hex\":\"0300\"", "\"hex\":\"030\""),
            "t.jsonl:3:69: wanted bytes as pairs",
        ),
        (
            EXAMPLE.replace("[0,0,4]", "[0,4,3]"),
            "t.jsonl:3:1: bytes 4..3 of resource 0",
        ),
        (
            EXAMPLE.replace("\"resident\":[\"03", "\"resident\":[\"0303"),
            "t.jsonl:3:1: \"resident\" tells 7 bytes",
        ),
        (
            EXAMPLE.replace("\"bytes\":6}]", "\"bytes\":18446744073709551615}]"),
            "t.jsonl:1:1: resources of more than",
        ),
    ];
    for (text, wanted) in cases {
        let found = check(&text).expect_err("no trace");
        // Where in a line a value is wrong is the JSON reader's affair.
        let (place, message) = wanted.split_once(": ").expect("a place and a message");
        let line = place.rsplit_once(':').expect("a line and a column").0;
        let fits = found.starts_with(&format!("{line}:")) && found.contains(message);
        assert!(fits, "{found}\nwanted {wanted}\nin {text}");
    }
    let endless = format!(
        "{visible}\n{{\"level\":0,\"visible\":[{}",
        "0,".repeat(17 << 20)
    );
    let found = check(&endless).expect_err("too long");
    assert!(
        found.starts_with("t.jsonl:2:1: a line of more than"),
        "{found}"
    );
}

/// The program on a trace at standard input: exit code, standard output, standard error.
fn spinney(arguments: &[&str], input: &str) -> (Option<i32>, String, String) {
    let program = Command::new(env!("CARGO_BIN_EXE_spinney"))
        // What is built must not come from another build.
        .env_remove("XDG_CACHE_HOME")
        .env_remove("HOME")
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut program = program.expect("the program starts");
    let mut stdin = program.stdin.take().expect("it is piped");
    // A program that refuses its first line may be gone before it is told all.
    _ = stdin.write_all(input.as_bytes());
    drop(stdin);
    let output = program.wait_with_output().expect("it ends");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (
        output.status.code(),
        text(output.stdout),
        text(output.stderr),
    )
}

#[test]
fn the_program_tells_kept_from_broken_from_not_recorded() {
    let (code, text, _) = spinney(&["check-trace", "-"], EXAMPLE);
    assert_eq!(code, Some(1), "{text}");
    let row = |law: &str| {
        let found = text.lines().find(|line| line.starts_with(law));
        let row: Vec<&str> = found.expect("a row a law").split_whitespace().collect();
        row.join(" ")
    };
    assert_eq!(row("image equality"), "image equality 0 not recorded");
    assert_eq!(row("conservation"), "conservation 3 kept");
    assert_eq!(row("residency"), "residency 3 broken: 1");
    let found = "standard input:4: split undoes collapse is broken in level 0";
    assert!(text.contains(found), "{text}");
    // Two steps that are sound.
    let sound: Vec<&str> = EXAMPLE.lines().take(3).collect();
    let (code, text, _) = spinney(&["check-trace", "-", "--json"], &sound.join("\n"));
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!((code, &json["kept"]), (Some(0), &true.into()), "{text}");
    assert_eq!(json["laws"][2]["result"], "not recorded", "no split was");
    let (code, _, errors) = spinney(&["check-trace", "-"], "{}");
    assert_eq!(code, Some(2), "{errors}");
    assert!(
        errors.contains("standard input:1:2: missing field"),
        "{errors}"
    );
    let (code, _, errors) = spinney(&["check-trace", "no/such/file"], "");
    assert_eq!(code, Some(2), "{errors}");
}
