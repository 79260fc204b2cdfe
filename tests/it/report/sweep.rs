//! The folder of a walk, its table, and what storage a tree takes.

use serde_json::Value;
use spinney::gpu::{Card, Link};
use spinney::math::Digest;
use spinney::models::{Kind, TrunkKind};
use spinney::report::{
    Accounting, OutputFolder, PrintedSize, QualityMeter, QualitySummary, StorageReport,
    SweepHeader, SweepPictures, SweepQuality, SweepShare, ViewQuality, merge, quality_notes,
    storage_report, sweep_notes, sweep_table, sweep_text, write_sweep, write_sweep_shard,
};
use spinney::run::{
    Frame, Look, LookOptions, RunError, SessionOptions, Shard, Silent, Subject, Sweep,
    SweepOptions, Variant, looks, sweep, sweep_seen,
};

use spinney::scene::Scene;

use super::{assert_self_contained, files, keys_in_order, options, read, scene, words, world};
use crate::support::{OPTIONS, random_crown, random_trunk};

pub(super) fn sweep_header() -> SweepHeader {
    SweepHeader {
        scene: "tiny".to_owned(),
        link: Link::named("pcie1x16").expect("a known link"),
        card: Card::named("gtx770").expect("a known card"),
        resolved: "# resolved & <walked>\n".to_owned(),
    }
}

pub(super) fn tiny_sweep() -> Sweep {
    sweep_share(&Variant::ALL, Shard::WHOLE)
}

fn sweep_share(variants: &[Variant], shard: Shard) -> Sweep {
    let scene = scene("cluster", "uniform");
    let options = sweep_options(&scene, variants, shard);
    sweep(&scene, &world(), &options, &Silent).expect("memory suffices")
}

fn sweep_options(scene: &Scene, variants: &[Variant], shard: Shard) -> SweepOptions {
    SweepOptions {
        variants: variants.to_vec(),
        steps: 4,
        shard,
        session: SessionOptions {
            // Some variants compute.
            card: sweep_header().card,
            ..options(scene)
        },
    }
}

/// A walk with the pictures of its page.
pub(super) fn pictured_sweep(variants: &[Variant]) -> (Sweep, SweepPictures) {
    let scene = scene("cluster", "uniform");
    let options = sweep_options(&scene, variants, Shard::WHOLE);
    let mut pictures = SweepPictures::default();
    let see = |at, frame: &Frame| -> Result<(), RunError> {
        pictures.add(at, frame).expect("a picture");
        Ok(())
    };
    let sweep = sweep_seen(&scene, &world(), &options, &Silent, see).expect("memory suffices");
    (sweep, pictures)
}

const STEP: &str = "level leaves triangles collapses splits clusters_touched host_records upload \
    fetch command_bytes bus_ns gpu_ns frame_ns image_digest covered_pixels leaf_area folded_leaves";

#[test]
fn sweeps_have_the_keys_of_the_contract_and_all_files() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("sweep");
    let (sweep, pictures) = pictured_sweep(&Variant::ALL);
    let folder = OutputFolder::create(&target).unwrap();
    write_sweep(&folder, &sweep_header(), &sweep, None, &pictures).unwrap();
    folder.commit().unwrap();
    let names: Vec<String> = files(&target).into_keys().collect();
    let wanted = ".spinney plots/covered.svg plots/cumulated.svg plots/extraction.svg \
        plots/frame-time.svg plots/leaves.svg plots/pareto.svg plots/payload.svg report.html sweep.csv sweep.json table.md";
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
    let html = read(&target, "report.html");
    assert_self_contained(&html);
    // Five levels; what has none shows full detail at all of them.
    assert_eq!(html.matches("<img ").count(), 5);
    assert!(
        html.contains("data-shows=\"0,0,0,0,0;0,1,2,3,4;"),
        "models share pictures"
    );
    assert!(html.contains("<code># resolved &amp; &lt;walked&gt;</code>"));
    for text in [
        "Which models nothing beats",
        "lodf-host",
        "fetched, B",
        "draw-count",
    ] {
        assert!(html.contains(text), "{text}");
    }
    assert!(read(&target, "table.md").starts_with("| model | first upload, B | payload, B |"));
}

/// The tiny scene's levels 0 and 4, held against full detail; of the foliage two views only.
fn tiny_quality(variants: &[Variant]) -> SweepQuality {
    let scene = scene("cluster", "uniform");
    let options = LookOptions {
        variants: variants.to_vec(),
        steps: 4,
        looks: 1,
        shard: Shard::WHOLE,
        session: options(&scene),
    };
    let mut meter = QualityMeter::default();
    let take = |mut look: Look| -> Result<(), RunError> {
        let pictures = match look.subject {
            Subject::Scene => 1,
            Subject::Plant(_) => 26,
        };
        assert_eq!(look.shots.len(), pictures, "{:?}", look.subject);
        look.shots.truncate(2);
        meter.add(look).expect("pictures of one size");
        Ok(())
    };
    looks(&scene, &world(), &options, &Silent, take).expect("memory suffices");
    meter.finish()
}

#[test]
fn quality_is_the_same_for_all_models_and_told_in_every_form() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("sweep");
    let (sweep, quality) = (tiny_sweep(), tiny_quality(&Variant::ALL));
    let [full, coarse] = &quality.steps[..] else {
        panic!("two levels, not {}", quality.steps.len());
    };
    assert_eq!((full.step, coarse.step, quality.plants), (0, 4, 1));
    let perfect = ViewQuality {
        covered: 1.0,
        silhouette: 0.0,
        flip: 0.0,
        ssim: Some(1.0),
    };
    assert_eq!(full.frame, perfect);
    assert_eq!(full.foliage, QualitySummary::of(&[perfect]));
    assert!(coarse.frame.flip > 0.0 && coarse.foliage.silhouette.mean > 0.0);
    let notes = quality_notes(&sweep, &quality);
    let agreement = "At all 2 levels that were looked at, all 13 models show the same picture of the \
        scene, bit for bit.";
    assert_eq!(notes[1], agreement);

    let folder = OutputFolder::create(&target).unwrap();
    write_sweep(
        &folder,
        &sweep_header(),
        &sweep,
        Some(&quality),
        &SweepPictures::default(),
    )
    .unwrap();
    folder.commit().unwrap();
    let value: Value = serde_json::from_str(&read(&target, "sweep.json")).unwrap();
    for model in value["models"].as_array().unwrap() {
        let steps = model["steps"].as_array().unwrap();
        let has = steps.iter().map(|step| step.get("quality").is_some());
        assert_eq!(has.collect::<Vec<_>>(), [true, false, false, false, true]);
        let looked_at = match model["model"] == "full" {
            true => full,
            false => coarse,
        };
        let last = &steps[4]["quality"];
        assert_eq!(last["flip"]["mean"], looked_at.foliage.flip.mean);
        assert_eq!(last["frame"]["flip"], looked_at.frame.flip);
    }
    let csv = read(&target, "sweep.csv");
    let columns = csv.lines().map(|line| line.split(',').count());
    assert!(columns.into_iter().all(|count| count == 26 + 13), "{csv}");
    for name in ["area", "covered", "silhouette", "flip", "ssim"] {
        let plot = read(&target, &format!("plots/quality-{name}.svg"));
        assert!(!plot.contains("nothing to show"), "{name}");
    }
    assert_self_contained(&read(&target, "report.html"));
    assert!(read(&target, "table.md").contains("| detail | area | covered |"));
    let text = sweep_text(&sweep, Some(&quality), 80);
    assert!(text.contains("1 (1)"), "{text}");
}

/// What has no levels, leaf collapses, and pruned leaves in two modes.
const BOTH_FOLIAGES: [Variant; 4] = [
    Variant::usual(Kind::Full),
    Variant::usual(Kind::LodfCluster),
    Variant::usual(Kind::LodfCluster).pruned(),
    Variant::usual(Kind::LodfStamps).pruned().compact(),
];

#[test]
fn pruned_foliage_is_looked_at_beside_the_scenes() {
    let (sweep, quality) = (
        sweep_share(&BOTH_FOLIAGES, Shard::WHOLE),
        tiny_quality(&BOTH_FOLIAGES),
    );
    let labels = sweep.models.iter().map(|model| model.variant.label());
    let wanted = [
        "full",
        "lodf-cluster",
        "lodf-cluster-pruned",
        "lodf-stamps-pruned-u16",
    ];
    assert_eq!(labels.collect::<Vec<_>>(), wanted);
    let steps = quality
        .steps
        .iter()
        .map(|step| (step.appearance.pruned, step.step));
    let wanted = [(false, 0), (false, 4), (true, 0), (true, 4)];
    assert_eq!(steps.collect::<Vec<_>>(), wanted);
    assert_eq!(quality.plants, 1);
    let of = |model: usize, step: usize| {
        let model = &sweep.models[model];
        quality
            .of(model, &model.steps[step])
            .expect("all show the same")
    };
    assert_eq!(of(1, 0).foliage, of(2, 0).foliage);
    assert_eq!(of(0, 4), of(1, 0));
    assert_eq!(of(2, 4), of(3, 4));
    assert_ne!(of(1, 4).image_digest, of(2, 4).image_digest);
    // Pruned leaves keep their area, and as many are left.
    assert!((of(2, 4).leaf_area - 1.0).abs() < 1e-6);
    let last = sweep.models.iter().map(|model| model.steps[4].leaves);
    let [full, collapsed, pruned, compact] = last.collect::<Vec<_>>()[..] else {
        panic!("four models");
    };
    assert!(full > collapsed && collapsed == pruned && pruned == compact);
    let text = sweep_text(&sweep, Some(&quality), 120);
    assert!(
        text.contains("as the scene says") && text.contains("pruned "),
        "{text}"
    );
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("sweep");
    let folder = OutputFolder::create(&target).unwrap();
    write_sweep(
        &folder,
        &sweep_header(),
        &sweep,
        Some(&quality),
        &SweepPictures::default(),
    )
    .unwrap();
    folder.commit().unwrap();
    let plot = read(&target, "plots/quality-area.svg");
    assert!(plot.contains("leaves, pruned"), "{plot}");
}

#[test]
fn joined_shards_tell_of_the_levels_what_all_tell() {
    let root = tempfile::tempdir().unwrap();
    let quality = tiny_quality(&BOTH_FOLIAGES);
    let write = |name: &str, sweep: &Sweep, quality: &SweepQuality, shard: Option<Shard>| {
        let target = root.path().join(name);
        let (folder, none) = (
            OutputFolder::create(&target).unwrap(),
            SweepPictures::default(),
        );
        write_sweep(&folder, &sweep_header(), sweep, Some(quality), &none).unwrap();
        if let Some(shard) = shard {
            let share = SweepShare {
                shard,
                scene_digest: Digest([7; 32]),
                exact: true,
                steps: 4,
                looks: Some(1),
            };
            write_sweep_shard(&folder, &sweep_header(), share, sweep, Some(quality), &none)
                .unwrap();
        }
        folder.commit().unwrap();
        target
    };
    let whole = write(
        "whole",
        &sweep_share(&BOTH_FOLIAGES, Shard::WHOLE),
        &quality,
        None,
    );
    let shards = [0, 1, 2].map(|index| {
        let shard = Shard { index, count: 3 };
        let mut own = quality.clone();
        own.steps
            .retain(|step| step.step == 0 || shard.draws(step.step));
        let sweep = sweep_share(&BOTH_FOLIAGES, shard);
        write(&index.to_string(), &sweep, &own, Some(shard))
    });
    let target = root.path().join("merged");
    merge(&shards, |_, _| target.clone(), &Silent).unwrap();
    assert!(
        files(&whole) == files(&target),
        "the same files with the same bytes"
    );
}

#[test]
fn a_model_that_shows_something_else_is_named_and_not_judged() {
    let (mut sweep, quality) = (tiny_sweep(), tiny_quality(&Variant::ALL));
    sweep.models[3].steps[4].image_digest = sweep.models[3].steps[0].image_digest;
    let model = &sweep.models[3];
    assert_eq!(quality.of(model, &model.steps[4]), None);
    let label = model.variant.label();
    let notes = quality_notes(&sweep, &quality);
    assert!(
        notes[1].ends_with(&format!("{label} from step 4 on.")),
        "{notes:#?}"
    );
}

#[test]
fn own_trunks_and_quantised_vertices_are_judged_by_pictures_of_their_own() {
    let scene = scene("cluster", "uniform");
    let mut world = world();
    world.trunks = vec![Some(random_trunk(5))];
    let labels = [
        "lodf-stamps",
        "full",
        "lodf-cluster-u16-quantised",
        "vdf-host+mom-host",
        "full+lodstrips-cut-device",
    ];
    let variants = labels.map(|label| Variant::labelled(label).expect("a label"));
    let walk = |shard| {
        let options = SweepOptions {
            variants: variants.to_vec(),
            steps: 2,
            shard,
            session: options(&scene),
        };
        sweep(&scene, &world, &options, &Silent).expect("memory suffices")
    };
    let look = |shard| {
        let options = LookOptions {
            variants: variants.to_vec(),
            steps: 2,
            looks: 2,
            shard,
            session: options(&scene),
        };
        let mut meter = QualityMeter::default();
        let take = |mut look: Look| -> Result<(), RunError> {
            look.shots.truncate(1);
            meter.add(look).expect("pictures of one size");
            Ok(())
        };
        looks(&scene, &world, &options, &Silent, take).expect("memory suffices");
        meter.finish()
    };
    let (whole, quality) = (walk(Shard::WHOLE), look(Shard::WHOLE));
    assert_eq!(quality.looks().len(), 4);
    assert_eq!((quality.plants, quality.steps.len()), (1, 4 * 3));
    for model in &whole.models {
        for step in &model.steps {
            let label = model.variant.label();
            assert_eq!(
                quality.agrees(model, step),
                Some(true),
                "{label} {}",
                step.step
            );
        }
    }
    let last = |place: usize| {
        let model = &whole.models[place];
        quality
            .of(model, &model.steps[2])
            .expect("it was looked at")
    };
    // Without levels nothing changes; with those of the trunk alone, only the scene does.
    assert_eq!((last(1).frame.flip, last(1).foliage.flip.mean), (0.0, 0.0));
    assert!(last(4).frame.flip > 0.0 && last(4).foliage.flip.mean == 0.0);
    assert!(last(0).foliage == last(3).foliage && last(0).frame != last(3).frame);
    let notes = quality_notes(&whole, &quality);
    assert!(
        notes[1].contains("all 5 models show the picture"),
        "{notes:#?}"
    );
    let text = sweep_text(&whole, Some(&quality), 80);
    assert!(
        text.contains("\nWith quantised vertices, against full detail"),
        "{text}"
    );

    let root = tempfile::tempdir().unwrap();
    let write = |name: &str, shard: Shard| {
        let target = root.path().join(name);
        let folder = OutputFolder::create(&target).unwrap();
        let (sweep, quality) = (walk(shard), look(shard));
        write_sweep(
            &folder,
            &sweep_header(),
            &sweep,
            Some(&quality),
            &SweepPictures::default(),
        )
        .unwrap();
        if shard != Shard::WHOLE {
            let share = SweepShare {
                shard,
                scene_digest: Digest([7; 32]),
                exact: true,
                steps: 2,
                looks: Some(2),
            };
            write_sweep_shard(
                &folder,
                &sweep_header(),
                share,
                &sweep,
                Some(&quality),
                &SweepPictures::default(),
            )
            .unwrap();
        }
        folder.commit().unwrap();
        target
    };
    let all = write("whole", Shard::WHOLE);
    let shards = [0, 1].map(|index| write(&index.to_string(), Shard { index, count: 2 }));
    let target = root.path().join("merged");
    merge(&shards, |_, _| target.clone(), &Silent).unwrap();
    assert!(
        files(&all) == files(&target),
        "the same files with the same bytes"
    );
    assert!(files(&all).contains_key("plots/quality-flip-full-foliage-trunks.svg"));
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
    assert_eq!(notes.len(), 11, "{notes:#?}");
    assert!(
        notes[3].starts_with("Changes, lodf-stamps: 32 B in 8 transfers, 224 B on the wire"),
        "{notes:#?}"
    );
    let wanted = "First upload: lodf-stamps sends 360 B more than lodf-cluster; with its changes it \
        has paid off at step 1 of 4.";
    assert_eq!(notes[5], wanted);
    let records = |label: &str| -> u64 {
        let steps = sweep.models[find(label)].steps.iter();
        steps.map(|step| step.change.host_records).sum()
    };
    let [own, rival] = [records("lodf-host"), records("vdf-host")];
    let wanted = format!("Extraction, lodf-host against vdf-host: {own} records against {rival}, ");
    assert!(notes[6].starts_with(&wanted), "{notes:#?}");
    let text = sweep_text(&sweep, None, 80);
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
    let trunk = random_trunk(5);
    let subject = (&crown, Some(&trunk));
    let report = storage_report("little yew", subject, OPTIONS, vec![accounting]);
    let StorageReport { counts, models, .. } = &report;
    assert_eq!(
        (counts.vertices, counts.records, counts.groups),
        (120, 56, 4)
    );
    assert_eq!(models.len(), Kind::LEAVES.len());
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

As built: once a species, then once a tree, on the device and on the host
";
    let text = report.to_text(80);
    assert!(text.starts_with(wanted), "{text}");
    let built = report.trunk.as_ref().expect("it has one");
    assert_eq!(built.models.len(), TrunkKind::all().count());
    for model in &built.models {
        let kind = TrunkKind::labelled(&model.model).unwrap();
        let host = kind.model(&trunk, OPTIONS).host_bytes();
        assert_eq!(model.host_bytes, host.len() as u64, "{}", model.model);
    }
    let triangles = trunk.mesh().triangle_count();
    assert_eq!(json["trunk"]["triangles"], triangles);
    assert!(
        text.contains(&format!("\nTrunk: {triangles} triangles, ")),
        "{text}"
    );
    let without = storage_report("bush", (&crown, None), OPTIONS, Vec::new());
    assert!(without.trunk.is_none() && !without.to_text(80).contains("Trunk"));
}
