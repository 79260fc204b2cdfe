//! Trunks at a level explain themselves: which collapse made a triangle, what brought it to the device,
//! and what of a trunk two runs do not share.

use spinney::explain::{PixelReport, RecordedRun, Replay, TrunkStory, explain_pixel};
use spinney::models::{Trunk, TrunkLevel};
use spinney::run::Silent;

use crate::explain::{SCENE, folder, printed, shrub, told, write};

/// The scene with a trunk that has levels, and `more` keys of the model.
fn scene(trunk: &str, mode: &str, more: &str) -> String {
    let keys = format!("[model]\ntrunk = {trunk:?}\ntrunk_mode = {mode:?}\n{more}");
    SCENE.replace("[model]", &keys)
}

/// The stories of some pixels of frame 2 that show wood, and the run's trunk.
fn stories(run: &RecordedRun, some: usize) -> Vec<PixelReport> {
    let world = run.world(&Silent).expect("its own copies");
    let mut replay = Replay::new(run, &world).expect("it fits");
    while replay.draw_next().expect("its own states").is_some() {}
    let session = replay.session();
    let target = session.device().inspect_target(session.target());
    let target = target.expect("a session keeps its target");
    let pixels = (0..48).flat_map(|y| (0..64).map(move |x| [x, y]));
    let wood: Vec<[u32; 2]> = pixels
        .filter(|&[x, y]| target.key(x, y).is_some_and(|key| key.group == 0))
        .collect();
    assert!(wood.len() > some, "{wood:?}");
    let every = wood.into_iter().step_by(2).take(some);
    let told = every.map(|pixel| explain_pixel(run, Some(2), pixel, &Silent));
    told.map(|report| report.expect("a pixel of it")).collect()
}

/// Whether a collapse of the story is where the sequence has it: the triangle has its corners from just
/// after the collapse that made it until the next that is told.
fn check_changes(trunk: &Trunk, story: &TrunkStory) {
    let collapses = trunk.collapses();
    let level = story.level.as_ref().expect("it has levels");
    let after = |count: u32| {
        let there = collapses.shows(story.triangle, count);
        there.then(|| collapses.corners(story.triangle, count))
    };
    let number = |vertex: u32| collapses.order()[vertex as usize];
    let shown = after(level.collapses).expect("it shows");
    let named = shown.map(number);
    let turned = [0, 1, 2].map(|turn| [0, 1, 2].map(|corner| named[(corner + turn) % 3]));
    assert!(turned.contains(&story.vertices), "{story:?}");
    let count = trunk.triangle_count(TrunkLevel::Collapses(level.collapses));
    assert_eq!(level.triangles, count, "of the level");
    match &story.made_by {
        None => assert_eq!(after(0), Some(shown), "as in the mesh"),
        Some(made) => {
            let done = made.done && made.collapse < level.collapses && !made.removes;
            assert!(done, "{made:?}");
            assert_eq!(after(made.collapse + 1), Some(shown), "from then on");
            assert_ne!(after(made.collapse), Some(shown), "but not before");
            assert!(story.vertices.contains(&made.target), "{story:?}");
        }
    }
    match &story.changed_by {
        None => assert_eq!(after(collapses.collapse_count()), Some(shown), "to the end"),
        Some(next) => {
            let done = next.done || next.collapse < level.collapses;
            assert!(!done, "{next:?}");
            assert_eq!(after(next.collapse), Some(shown), "until then");
            assert_ne!(after(next.collapse + 1), Some(shown), "but no longer");
            let goes = after(next.collapse + 1).is_none();
            assert_eq!(goes, next.removes, "{next:?}");
            assert!(story.vertices.contains(&next.vertex), "{story:?}");
        }
    }
}

#[test]
fn a_triangle_knows_the_collapse_that_made_it_and_what_brought_it() {
    let here = folder();
    let here = here.path();
    let (mut made, mut sent_with_frames) = (0, 0);
    for (name, mode) in [
        ("lodstrips", "device"),
        ("lodstrips-cut", "device"),
        ("mom", "device"),
        ("lodstrips", "host"),
        ("full", "device"),
    ] {
        write(
            here,
            "scene.toml",
            scene(name, mode, "trunk_triangles = 0\n"),
        );
        printed(here, &["run", "scene.toml", "-o", "a"], 0);
        let run = RecordedRun::read(&here.join("a")).expect("a run");
        let world = run.world(&Silent).expect("its own copies");
        let trunk = world.trunks[0].as_ref().expect("it has one");
        let mut replay = Replay::new(&run, &world).expect("it fits");
        while replay.draw_next().expect("its own states").is_some() {}
        let device = replay.session().device();
        let reports = stories(&run, 3);
        for report in &reports {
            assert!(report.agrees && report.frame.same, "{name}-{mode}");
            let shown = report.samples[0].shows.expect("the trunk");
            let place = &report.fragments[usize::try_from(shown).expect("small")];
            let story = place.trunk.as_ref().expect("a triangle of it");
            let upload = story.upload.as_ref().expect("it lies somewhere");
            // There lie the corners, by the numbers that the buffer has.
            let owned = |label: &str| {
                let tree = format!("tree {}", place.tree);
                let of_tree = upload.owner == tree || upload.owner == "plant 0";
                of_tree && label == upload.buffer
            };
            let ends = [upload.start, upload.end].map(|at| usize::try_from(at).expect("small"));
            let held = device.buffers().filter(|(_, label)| owned(label));
            let mut held = held.map(|(buffer, _)| {
                let bytes = device.inspect_buffer(buffer).expect("it lives");
                let words = bytes[ends[0]..ends[1]].as_chunks::<4>().0.iter();
                let mut words: Vec<u32> = words.map(|word| u32::from_le_bytes(*word)).collect();
                words.sort_unstable();
                words
            });
            let mut corners = place.vertices.clone();
            corners.sort_unstable();
            assert!(held.any(|words| words == corners), "{upload:?}");
            match (name, mode) {
                ("full", _) => {
                    assert_eq!((&story.level, &story.made_by), (&None, &None), "no levels");
                    assert_eq!(upload.cause.as_deref(), Some("trunk"), "once, at first");
                }
                (_, "host") => assert_eq!(upload.cause, None, "pulled by draws"),
                _ => {
                    let cause = upload.cause.as_deref().expect("it was sent");
                    let known = match upload.frame {
                        None => "trunk",
                        Some(_) if name == "mom" => "triangle",
                        Some(_) => "strip",
                    };
                    assert_eq!(cause, known, "{upload:?}");
                    sent_with_frames += u32::from(upload.frame.is_some());
                }
            }
            if name != "full" {
                check_changes(trunk, story);
                made += u32::from(story.made_by.is_some());
            }
        }
        let [x, y] = reports[0].pixel;
        let pixel = format!("{x},{y}");
        let text = printed(
            here,
            &["explain", "a", "--pixel", &pixel, "--frame", "2"],
            0,
        );
        for word in ["level ", "sent "] {
            let says = text.lines().any(|line| line.starts_with(word));
            assert_eq!(says, word == "sent " || name != "full", "{text}");
        }
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
    }
    assert!(
        made >= 3 && sent_with_frames >= 3,
        "{made}, {sent_with_frames}"
    );
}

#[test]
fn what_two_trunks_do_not_share_is_named() {
    let here = folder();
    let here = here.path();
    let run = |name: &str, more: &str| {
        write(here, "scene.toml", scene("lodstrips", "device", more));
        printed(here, &["run", "scene.toml", "-o", name], 0);
    };
    run("a", "");
    // Another level.
    run("b", "trunk_level = 0.25\n");
    let report = told(here, &["a", "b"], 1);
    assert_eq!(
        report["trunks"],
        serde_json::json!([]),
        "one mesh, one sequence"
    );
    let levels = &report["levels"];
    let frame = &levels["frame"];
    assert_eq!([frame, &levels["tree"], &levels["trees"]], [0, 0, 2]);
    assert!(
        levels["triangles"][0].as_u64() > levels["triangles"][1].as_u64(),
        "{levels}"
    );
    let [ours, theirs] = [0, 1].map(|side| levels["collapses"][side].as_u64().expect("a count"));
    let said =
        format!("frame 0 shows the trunk of tree 0 after {ours} collapses in A, {theirs} in B");
    let summary = report["summary"].as_str().expect("a sentence");
    assert!(summary.contains(&said), "{summary}");
    // A sequence that goes on.
    run("c", "trunk_triangles = 40\n");
    let report = told(here, &["a", "c"], 1);
    let trunk = &report["trunks"][0];
    assert_eq!(trunk["first_triangle"], serde_json::Value::Null, "one mesh");
    assert_eq!(
        trunk["first_collapse"], trunk["collapses"][0],
        "all of A's are B's"
    );
    assert_eq!(trunk["a"], serde_json::Value::Null, "A has no more");
    assert!(trunk["b"]["vertex"].is_u64(), "{trunk}");
    // Another mesh.
    let thicker = shrub("").replace("ratio = 0.012", "ratio = 0.013");
    write(here, "kinds/shrub.toml", thicker);
    run("d", "");
    let report = told(here, &["a", "d"], 1);
    let trunk = &report["trunks"][0];
    assert_eq!(trunk["first_triangle"], 0, "{trunk}");
    assert_eq!(trunk["branch"]["branch"], 0, "{trunk}");
    let summary = report["summary"].as_str().expect("a sentence");
    let said = "the trunk of tree 0 differs from triangle 0 on (branch 0)";
    assert!(summary.contains(said), "{summary}");
    for other in ["b", "c", "d"] {
        let text = printed(here, &["explain", "a", other], 1);
        let names = |word: &str| text.lines().any(|line| line.starts_with(word));
        assert!(names("levels") || names("trunk"), "{text}");
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
    }
}
