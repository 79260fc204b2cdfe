//! The folder of a run.

use std::collections::BTreeMap;

use serde_json::Value;
use spinney::gpu::Ledger;
use spinney::models::{Kind, State};
use spinney::report::{
    LayerSamples, NO_NUMBER, OpsReader, RunFolder, RunHeader, RunLedger, frame_layers, run_notes,
};
use spinney::run::{Frame, PopMeter, Popping, Session};
use spinney::scene::Scene;

use super::{
    assert_self_contained, keys_in_order, options, read, run_header, run_into, scene, words, world,
};

const HEAD: &str = "schema version scene scene_digest link card size samples frames initial totals \
    path";
const SUMS: &str = "leaves triangles lines strokes draws vertices primitives visible_samples \
    resident_bytes peak_bytes upload fetch readback command_bytes collapses splits \
    clusters_touched by_cause by_buffer work gpu_ns";
const FRAME: &str = "frame image_digest leaves triangles lines strokes levels draws vertices \
    primitives visible_samples resident_bytes peak_bytes upload fetch readback command_bytes \
    collapses splits clusters_touched by_cause by_buffer work gpu_ns";
const TRAFFIC: &str = "transfers payload_bytes wire_bytes bus_ns";

#[test]
fn ledger_has_the_keys_of_the_contract_in_their_order() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("run");
    run_into(&target, &scene("slots", "uniform"));
    let text = read(&target, "ledger.json");
    assert_eq!(keys_in_order(&text), words(HEAD));
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(keys_in_order(lines[1]), words(FRAME));
    let sums = lines
        .iter()
        .filter(|line| line.starts_with("\"initial\"") || line.starts_with("\"totals\""));
    let sums: Vec<&str> = sums.map(|line| &line[line.find('{').unwrap()..]).collect();
    assert_eq!(sums.len(), 2);
    for sum in sums {
        assert_eq!(keys_in_order(sum), words(SUMS));
    }
    let upload = &lines[1][lines[1].find("\"upload\":").unwrap() + 9..];
    let upload = &upload[..=upload.find('}').unwrap()];
    assert_eq!(keys_in_order(upload), words(TRAFFIC));
    let value: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["schema"], "spinney.ledger/1");
    assert_eq!(
        (&value["lines"], &value["frames"][0]["lines"]),
        (&Value::Null, &0.into())
    );
    assert_eq!(value["size"], serde_json::json!([48, 32]));
    for key in ["covered", "alpha_killed", "hidden", "texels"] {
        assert!(value["frames"][0]["work"][key].is_u64(), "{key}");
    }
}

#[test]
fn totals_are_the_sums_of_the_frames() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("run");
    let frames = run_into(&target, &scene("cluster", "variable"));
    let ledger: RunLedger = serde_json::from_str(&read(&target, "ledger.json")).unwrap();
    assert_eq!(ledger.frames.len(), 5);
    let mut sum = spinney::report::LedgerEntry::default();
    ledger.frames.iter().for_each(|frame| sum.add(frame));
    assert_eq!(sum, ledger.totals);
    let leaves: u64 = frames.iter().map(|frame| frame.leaves).sum();
    let payload: u64 = frames
        .iter()
        .map(|frame| frame.ledger.upload.payload_bytes)
        .sum();
    assert_eq!((sum.leaves, sum.upload.payload_bytes), (leaves, payload));
    assert_eq!(
        ledger.frames[2].levels,
        Some(BTreeMap::from([("variable".to_owned(), 2)]))
    );
    assert!(sum.collapses > 0 && sum.gpu_ns.is_some() && sum.work.is_some());
    assert!(ledger.initial.upload.payload_bytes > 0);
}

#[test]
fn rows_of_the_csv_add_up_to_the_ledger() {
    let root = tempfile::tempdir().unwrap();
    for (mode, detail) in [("slots", "variable"), ("host", "uniform")] {
        let target = root.path().join(mode);
        run_into(&target, &scene(mode, detail));
        let ledger: RunLedger = serde_json::from_str(&read(&target, "ledger.json")).unwrap();
        let csv = read(&target, "ledger.csv");
        let mut lines = csv.lines();
        assert_eq!(
            lines.next(),
            Some("frame,stream,resource,cause,id,ranges,payload,wire,ns")
        );
        let mut sums = BTreeMap::<(String, String), [u64; 4]>::new();
        for line in lines {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |index: usize| cells[index].parse::<u64>().unwrap();
            let sum = sums
                .entry((cells[0].to_owned(), cells[1].to_owned()))
                .or_default();
            for (sum, add) in sum.iter_mut().zip([1, number(6), number(7), number(8)]) {
                *sum += add;
            }
        }
        let initial = std::iter::once(("initial".to_owned(), &ledger.initial));
        let frames = ledger
            .frames
            .iter()
            .map(|f| (f.frame.unwrap().to_string(), f));
        for (name, entry) in initial.chain(frames) {
            for (stream, traffic) in [("upload", entry.upload), ("fetch", entry.fetch)] {
                let sum = sums
                    .remove(&(name.clone(), stream.to_owned()))
                    .unwrap_or_default();
                let wanted = [traffic.transfers, traffic.payload_bytes, traffic.wire_bytes];
                assert_eq!(sum[..3], wanted, "{name} {stream}");
                // Each row is rounded up for itself.
                assert!((traffic.bus_ns..=traffic.bus_ns + sum[0]).contains(&sum[3]));
            }
        }
        assert!(sums.is_empty(), "{sums:?}");
    }
}

#[test]
fn ops_give_the_states_back() {
    let root = tempfile::tempdir().unwrap();
    let world = world();
    for detail in ["uniform", "variable"] {
        let target = root.path().join(detail);
        let frames = run_into(&target, &scene("stamps", detail));
        let text = read(&target, "ops.jsonl");
        assert_eq!(text.lines().count(), frames.len());
        let mut reader = OpsReader::new(&world);
        for (line, frame) in text.lines().zip(&frames) {
            let (number, states) = reader.read(line).unwrap();
            assert_eq!((number, states), (frame.frame, &frame.states[..]));
        }
        assert!(frames[0].states != frames[4].states);
    }
    let first = read(&root.path().join("uniform"), "ops.jsonl");
    let wanted = "{\"frame\":0,\"trees\":[{\"tree\":0,\"uniform\":0},{\"tree\":1,\"uniform\":0}]}";
    assert_eq!(first.lines().next(), Some(wanted));
}

#[test]
fn ops_that_cannot_be_are_refused() {
    let world = world();
    for (line, wanted) in [
        (
            "{",
            "ops.jsonl:1: EOF while parsing an object at line 1 column 1",
        ),
        (
            r#"{"frame":0,"trees":[]}"#,
            "ops.jsonl:1: 0 trees, wanted all 2",
        ),
        (
            r#"{"frame":0,"trees":[{"tree":1,"uniform":0}]}"#,
            "ops.jsonl:1: tree 1 after 0 of 2",
        ),
        (
            r#"{"frame":0,"trees":[{"tree":0,"uniform":35}]}"#,
            "ops.jsonl:1: tree 0: 35 collapses, at most 34",
        ),
        (
            r#"{"frame":0,"trees":[{"tree":0,"variable":[[6,0]]}]}"#,
            "ops.jsonl:1: tree 0: cluster 6 of 6",
        ),
        (
            r#"{"frame":0,"trees":[{"tree":0}]}"#,
            "ops.jsonl:1: tree 0: wanted one of `uniform`, `variable`, `cards`, `strokes`",
        ),
    ] {
        let error = OpsReader::new(&world).read(line).unwrap_err().to_string();
        assert_eq!(error, wanted);
    }
}

/// Events of a trace by lane: name, begin and end in nanoseconds.
fn lanes(trace: &Value) -> BTreeMap<u64, Vec<(String, u64, u64)>> {
    let mut lanes = BTreeMap::<u64, Vec<_>>::new();
    let nanoseconds = |value: &Value| {
        // As the file has it: microseconds with up to three digits.
        let text = value.to_string();
        let (whole, part) = text.split_once('.').expect("a point");
        format!("{whole}{part:0<3}").parse::<u64>().expect("digits")
    };
    for event in trace["traceEvents"].as_array().expect("a list") {
        if event["ph"] == "X" {
            let (start, length) = (nanoseconds(&event["ts"]), nanoseconds(&event["dur"]));
            let name = event["name"].as_str().expect("a text").to_owned();
            let lane = lanes.entry(event["tid"].as_u64().expect("a number"));
            lane.or_default().push((name, start, start + length));
        }
    }
    lanes
}

#[test]
fn traces_are_well_nested() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("run");
    let frames = run_into(&target, &scene("cluster", "variable"));
    let trace: Value = serde_json::from_str(&read(&target, "trace.json")).unwrap();
    let lanes = lanes(&trace);
    for (lane, events) in &lanes {
        let mut open: Vec<u64> = Vec::new();
        let mut last = 0;
        for (name, start, end) in events {
            assert!(*start >= last, "lane {lane}: {name} goes back");
            last = *start;
            while open.last().is_some_and(|open| open <= start) {
                open.pop();
            }
            assert!(
                open.iter().all(|open| end <= open),
                "lane {lane}: {name} sticks out"
            );
            open.push(*end);
        }
    }
    // Lane 1 are the frames; what happens in one lies within it.
    let spans = &lanes[&1];
    assert_eq!(spans.len(), 1 + frames.len());
    for (_, start, end) in lanes.values().flatten() {
        assert!(spans.iter().any(|span| span.1 <= *start && *end <= span.2));
    }
    let events = trace["traceEvents"].as_array().unwrap();
    let counted = |name: &str| events.iter().filter(|event| event["name"] == name).count();
    assert_eq!((counted("leaves"), counted("bytes")), (5, 5));
    assert!(
        lanes.contains_key(&5),
        "counters are exact, so there is a card's lane"
    );
}

#[test]
fn pages_of_runs_are_self_contained() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("run");
    run_into(&target, &scene("cluster", "uniform"));
    let html = read(&target, "report.html");
    assert_self_contained(&html);
    assert_eq!(html.matches("<img ").count(), 5);
    assert_eq!(html.matches("<svg ").count(), 4);
    for text in [
        "data-shows=\"0,1,2,3,4\"",
        "Uploads of each frame by cause",
        "<code># resolved</code>",
        "tiny, lodf-cluster",
        "64 B a leaf",
        "pcie5x16",
        "leaf vertices",
    ] {
        assert!(html.contains(text), "{text}");
    }
    assert_eq!(read(&target, "scene.resolved.toml"), "# resolved\n");
}

#[test]
fn shards_say_of_their_frames_what_all_say() {
    let root = tempfile::tempdir().unwrap();
    let scene = scene("slots", "uniform");
    let whole = root.path().join("whole");
    run_into(&whole, &scene);
    let world = world();
    let options = options(&scene);
    let mut session = Session::new(&scene, &world, &options).unwrap();
    let header = RunHeader {
        scene: scene.name.clone(),
        scene_digest: scene.digest(),
        model: options.kind.label(),
        link: options.link,
        card: options.card,
        size: [48, 32],
        samples: 1,
        resolved: String::new(),
        resident: Vec::new(),
    };
    let shard = root.path().join("shard");
    let mut folder = RunFolder::create(&shard, header, session.initial()).unwrap();
    for number in 0..scene.frames {
        if number % 2 == 1 {
            folder.add(&session.frame(number).unwrap()).unwrap();
        } else {
            session.skip(number).unwrap();
        }
    }
    folder.finish().unwrap();
    let [whole, shard] = [whole, shard].map(|folder| {
        let ledger: RunLedger = serde_json::from_str(&read(&folder, "ledger.json")).unwrap();
        ledger
    });
    assert_eq!(
        shard.frames,
        [whole.frames[1].clone(), whole.frames[3].clone()]
    );
    assert_eq!((shard.head, shard.initial), (whole.head, whole.initial));
}

#[test]
fn layers_name_the_leaves_that_show() {
    let world = world();
    let crown = &world.crowns[0];
    let mut found: Vec<Vec<u32>> = Vec::new();
    for (mode, kind) in [("slots", Kind::LodfSlots), ("stamps", Kind::LodfStamps)] {
        let scene = scene(mode, "variable");
        let options = options(&scene);
        assert_eq!(options.kind, kind);
        let mut session = Session::new(&scene, &world, &options).unwrap();
        let frame = session.frame(3).unwrap();
        let layers = frame_layers(&session, &world, kind, options.model, &frame);
        let names: Vec<&str> = layers.iter().map(|layer| layer.name.as_str()).collect();
        let wanted = [
            "R", "G", "B", "depth", "instance", "leaf", "normal.X", "normal.Y", "normal.Z",
        ];
        assert_eq!(names, wanted);
        let numbers = |index: usize| match &layers[index].samples {
            LayerSamples::U32(samples) => samples.clone(),
            LayerSamples::F32(_) => panic!("numbers are numbers"),
        };
        let floats = |index: usize| match &layers[index].samples {
            LayerSamples::F32(samples) => samples.clone(),
            LayerSamples::U32(_) => panic!("measures are measures"),
        };
        let (trees, leaves, depth) = (numbers(4), numbers(5), floats(3));
        let visible: Vec<Vec<u32>> = frame
            .states
            .iter()
            .map(|state| state.foliage.visible(crown.clusters()))
            .collect();
        let mut shown = 0;
        for pixel in 0..leaves.len() {
            let normal = [6, 7, 8].map(|index| floats(index)[pixel]);
            let length: f32 = normal.iter().map(|part| part * part).sum();
            if leaves[pixel] == NO_NUMBER {
                assert_eq!((trees[pixel], depth[pixel], length), (NO_NUMBER, 1.0, 0.0));
            } else {
                assert!(visible[trees[pixel] as usize].contains(&leaves[pixel]));
                assert!(depth[pixel] < 1.0 && (length - 1.0).abs() < 1e-5);
                shown += 1;
            }
        }
        assert_eq!(shown, session.covered_pixels());
        assert!(shown > 20 && leaves.iter().any(|&leaf| leaf != NO_NUMBER && leaf >= 40));
        found.push(leaves);
    }
    assert_eq!(found[0], found[1], "canonical: the same in all modes");
}

#[test]
fn literal_states_are_those_that_were_asked_for() {
    // The papers' list shows other leaves; what is written down is the state all the same.
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("run");
    let frames = run_into(&target, &scene("literal", "uniform"));
    assert!(matches!(frames[4].states[0].foliage, State::Uniform { collapses } if collapses > 0));
}

/// The frames of the tiny scene with their popping; only those of which `drawn` says so are drawn.
fn popping(scene: &Scene, drawn: impl Fn(u32) -> bool) -> Vec<Frame> {
    let world = world();
    let options = options(scene);
    let mut session = Session::new(scene, &world, &options).expect("memory suffices");
    let mut meter = PopMeter::new(scene, &world, &options).expect("memory suffices");
    let mut frames = Vec::new();
    for number in 0..scene.frames {
        if drawn(number) {
            let mut frame = session.frame(number).expect("a sound frame");
            let shown = session.drawn().expect("it was drawn");
            let found = meter.frame(number, &frame.states, &shown);
            frame.popping = found.expect("a sound frame");
            frames.push(frame);
        } else {
            session.skip(number).expect("a sound frame");
            meter.skip(number, &session.states());
        }
    }
    frames
}

#[test]
fn frames_pop_where_their_states_switch() {
    let scene = scene("slots", "uniform");
    let frames = popping(&scene, |_| true);
    assert_eq!(frames[0].popping, None);
    let mut pops = 0;
    for pair in frames.windows(2) {
        let found = pair[1].popping.expect("a frame came before");
        let switches = pair[0].states != pair[1].states;
        assert!(switches || found.popped == 0, "{found:?}");
        assert!(found.toggled_beyond <= found.toggled, "{found:?}");
        assert!(found.popped <= 48 * 32, "{found:?}");
        pops += u64::from(found.popped > 0);
    }
    assert!(pops > 0, "detail falls along the path");
    // What is told of a frame does not depend on which others are drawn.
    for frame in popping(&scene, |number| number % 2 == 1) {
        let whole = &frames[frame.frame as usize];
        assert_eq!(frame.popping, whole.popping, "frame {}", frame.frame);
    }
    // Full detail toggles as full detail does, and never pops.
    let mut full = scene;
    full.model.level = Some(0.0);
    for frame in popping(&full, |number| number > 0) {
        let found = frame.popping.expect("a frame came before");
        let wanted = Popping {
            popped: 0,
            toggled: found.toggled_at_full_detail,
            toggled_at_full_detail: found.toggled,
            toggled_beyond: 0,
        };
        assert_eq!(found, wanted);
    }
}

#[test]
fn popping_is_told_in_the_ledger_and_on_the_page() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("run");
    let scene = scene("slots", "uniform");
    let frames = popping(&scene, |_| true);
    let header = run_header(&scene);
    let mut folder = RunFolder::create(&target, header, &Ledger::default()).unwrap();
    for frame in &frames {
        folder.add(frame).unwrap();
    }
    let rows = folder.finish().unwrap();
    let ledger: RunLedger = serde_json::from_str(&read(&target, "ledger.json")).unwrap();
    let mut sum = Popping::default();
    for (entry, frame) in ledger.frames.iter().zip(&frames) {
        assert_eq!(entry.popping, frame.popping);
        sum.add(&frame.popping.unwrap_or_default());
    }
    assert_eq!(ledger.totals.popping, Some(sum));
    assert!(read(&target, "report.html").contains("Popping: pixels that a switch"));
    let notes = run_notes(&rows, options(&scene).link);
    let last = notes.last().unwrap();
    let wanted = format!("switches of detail alone change {} pixels", sum.popped);
    assert!(last.contains(&wanted), "{last}");
}
