//! The folder of a walk, its table, and what storage a tree takes.

use serde_json::Value;
use spinney::gpu::{Card, Link};
use spinney::models::Kind;
use spinney::report::{
    Accounting, OutputFolder, PrintedSize, StorageReport, SweepHeader, storage_report, sweep_notes,
    sweep_table, sweep_text, write_sweep,
};
use spinney::run::{SessionOptions, Shard, Silent, Sweep, SweepOptions, Variant, sweep};

use super::{assert_self_contained, files, keys_in_order, options, read, scene, words, world};
use crate::support::{OPTIONS, random_crown};

pub(super) fn sweep_header() -> SweepHeader {
    SweepHeader {
        scene: "tiny".to_owned(),
        link: Link::named("pcie1x16").expect("a known link"),
        card: Card::named("gtx770").expect("a known card"),
    }
}

pub(super) fn tiny_sweep() -> Sweep {
    let scene = scene("cluster", "uniform");
    let options = SweepOptions {
        variants: Variant::ALL.to_vec(),
        steps: 4,
        shard: Shard::WHOLE,
        session: SessionOptions {
            // Some variants compute.
            card: sweep_header().card,
            ..options(&scene)
        },
    };
    sweep(&scene, &world(), &options, &Silent).expect("memory suffices")
}

const STEP: &str = "level leaves triangles collapses splits clusters_touched host_records upload \
    fetch command_bytes bus_ns gpu_ns frame_ns image_digest covered_pixels leaf_area folded_leaves";

#[test]
fn sweeps_have_the_keys_of_the_contract_and_all_files() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("sweep");
    let sweep = tiny_sweep();
    let folder = OutputFolder::create(&target).unwrap();
    write_sweep(&folder, &sweep_header(), &sweep).unwrap();
    folder.commit().unwrap();
    let names: Vec<String> = files(&target).into_keys().collect();
    let wanted = ".spinney plots/covered.svg plots/cumulated.svg plots/frame-time.svg \
        plots/leaves.svg plots/payload.svg report.html sweep.csv sweep.json table.md";
    assert_eq!(names, words(wanted));

    let text = read(&target, "sweep.json");
    assert_eq!(keys_in_order(&text), words("schema scene link card models"));
    let lines: Vec<&str> = text.lines().collect();
    let step = lines
        .iter()
        .find(|line| line.starts_with("{\"level\""))
        .unwrap();
    assert_eq!(keys_in_order(step), words(STEP));
    let value: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["schema"], "spinney.sweep/1");
    let models = value["models"].as_array().unwrap();
    assert_eq!(models.len(), Variant::ALL.len());
    for model in models {
        let steps = model["steps"].as_array().unwrap();
        assert_eq!(steps.len(), 5);
        assert_eq!(
            (&steps[0]["level"], &steps[4]["level"]),
            (&0.0.into(), &1.0.into())
        );
        for key in [
            "leaves",
            "collapses",
            "command_bytes",
            "bus_ns",
            "gpu_ns",
            "frame_ns",
        ] {
            let sum: u64 = steps.iter().map(|step| step[key].as_u64().unwrap()).sum();
            assert_eq!(model["totals"][key].as_u64(), Some(sum), "{key}");
        }
        assert!(
            model["initial"]["upload"]["payload_bytes"]
                .as_u64()
                .is_some()
        );
    }
    let csv = read(&target, "sweep.csv");
    assert_eq!(csv.lines().count(), 1 + 5 * Variant::ALL.len());
    let columns = csv.lines().map(|line| line.split(',').count());
    assert!(columns.into_iter().all(|count| count == 26), "{csv}");
    assert_self_contained(&read(&target, "report.html"));
    assert!(read(&target, "table.md").starts_with("| model | first upload, B | payload, B |"));
}

#[test]
fn sweep_table_counts_changes_without_the_view() {
    let sweep = tiny_sweep();
    let table = sweep_table(&sweep);
    let find = |label: &str| {
        let place = sweep
            .models
            .iter()
            .position(|model| model.variant.label() == label);
        place.expect("all models were walked")
    };
    let count = |label: &str, column: usize| match table.rows[find(label)][column] {
        spinney::report::Cell::Count(count) => count,
        _ => panic!("a count"),
    };
    // Stamps send one word a step and tree that changes: 4 steps, 2 trees.
    assert_eq!(
        (count("lodf-stamps", 2), count("lodf-stamps", 3)),
        (4 * 4 * 2, 8)
    );
    // Host modes send nothing, and fetch 64 bytes a leaf at least once a step.
    assert_eq!(count("lodf-host", 2), 0);
    let leaves: u64 = sweep.models[find("lodf-host")]
        .steps
        .iter()
        .map(|step| step.leaves)
        .sum();
    assert_eq!(count("lodf-host", 6), 64 * leaves);
    assert!(count("lodf-cluster", 2) > count("lodf-slots", 2));

    let notes = sweep_notes(&sweep);
    assert_eq!(notes.len(), 6, "{notes:#?}");
    assert!(
        notes[3].starts_with("Changes, lodf-stamps: 32 B in 8 transfers, 224 B on the wire"),
        "{notes:#?}"
    );
    let wanted = "First upload: lodf-stamps sends 360 B more than lodf-cluster; with its changes it \
        has paid off at step 1 of 4.";
    assert_eq!(notes[5], wanted);
    let text = sweep_text(&sweep, 80);
    assert!(
        text.lines()
            .take_while(|line| !line.starts_with("Changes"))
            .all(|line| line.chars().count() <= 80)
    );
    assert_eq!(text.matches("lodf-slots-gathered  ").count(), 3, "{text}");
}

#[test]
fn storage_stands_beside_the_papers_figures() {
    let crown = random_crown(3, 30, 4);
    let accounting = Accounting {
        name: "original".to_owned(),
        bytes: 64 * 30,
        printed: vec![PrintedSize {
            table: "I".to_owned(),
            mebibyte_hundredths: 294,
            leaves: 48_160,
            erratum: None,
        }],
    };
    let report = storage_report("little yew", &crown, OPTIONS, vec![accounting]);
    let StorageReport { counts, models, .. } = &report;
    assert_eq!(
        (counts.vertices, counts.records, counts.groups),
        (120, 56, 4)
    );
    assert_eq!(models.len(), Kind::ALL.len());
    for model in models {
        let kind = Kind::labelled(&model.model).unwrap();
        let host = kind.model(&crown, OPTIONS).host_bytes();
        assert_eq!(model.host_bytes, host.len() as u64, "{}", model.model);
    }
    let json: Value = serde_json::from_str(&report.to_json()).unwrap();
    assert_eq!(
        (&json["leaves"], &json["schema"]),
        (&30.into(), &"spinney.storage/1".into())
    );
    let wanted = "\
little yew: 30 leaves, 120 vertices, 26 collapses,
56 leaves old and new, 4 clusters

By the papers' accounting
accounting  bytes  B/leaf    MiB  printed, MiB
──────────  ─────  ──────  ─────  ────────────
original    1,920   64.00  0.002      2.94 (I)

As built: host and shared once a species, instance and its part on the host once a tree
";
    let text = report.to_text(80);
    assert!(text.starts_with(wanted), "{text}");
}
