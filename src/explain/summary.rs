//! Where two runs part, in one sentence: the first cause, the first transfer, the pixels.

use super::leaves::{LeafPlace, PlantDifference};
use super::trunks::TrunkDifference;
use super::{AskedDifference, RunsReport};

/// The sentence.
pub(super) fn of(report: &RunsReport) -> String {
    if report.same {
        return "the runs are the same".to_owned();
    }
    let mut parts = Vec::new();
    match (report.plants.first(), report.asked.first()) {
        (Some(plant), _) => parts.push(plant_cause(plant)),
        (None, Some(asked)) => parts.push(asked_cause(asked, report.asked_count)),
        (None, None) => {}
    }
    if report.plants.is_empty() && report.sequences.is_empty() {
        parts.push("all leaves and collapses are the same".to_owned());
    } else if let Some(sequence) = report.sequences.first() {
        parts.push(match sequence.first {
            Some(first) => format!("collapses differ from number {first} on"),
            None => "all collapses join the same leaves, at other costs".to_owned(),
        });
    }
    if let Some(trunk) = report.trunks.first() {
        parts.push(trunk_cause(trunk));
    }
    if let Some(levels) = &report.levels {
        let (frame, tree, [a, b]) = (levels.frame, levels.tree, levels.collapses);
        parts.push(format!(
            "frame {frame} shows the trunk of tree {tree} after {a} collapses in A, {b} in B"
        ));
    }
    match &report.operation {
        Some(operation) => {
            let side = operation.a.as_ref().or(operation.b.as_ref());
            let what = side.map_or_else(String::new, |side| {
                let owner = side.owner.as_ref().map(|owner| format!(" of {owner}"));
                let owner = owner.unwrap_or_default();
                format!(" at the {} of {:?}{owner}", side.stream, side.resource)
            });
            parts.push(match operation.frame {
                None => format!("the runs part before the first frame{what}"),
                Some(frame) => format!("frame {frame} parts{what}"),
            });
        }
        None if report.common_frames > 0 => {
            parts.push("all frames send the same bytes".to_owned());
        }
        None => parts.push("no frame is in both".to_owned()),
    }
    parts.push(pixels(report));
    let unsound = [("A", &report.a), ("B", &report.b)]
        .into_iter()
        .find_map(|(name, side)| {
            let wrong = side.replayed.iter().find(|frame| !frame.same)?;
            Some((name, wrong.frame))
        });
    if let Some((name, frame)) = unsound {
        parts.push(format!(
            "frame {frame} of {name}, played again, is not the ledger's"
        ));
    }
    parts.join("; ")
}

fn plant_cause(plant: &PlantDifference) -> String {
    let tree = plant.tree;
    let branch = |leaf: &LeafPlace| match leaf.branch {
        Some(branch) => format!(" (branch {branch})"),
        None => String::new(),
    };
    let alone = |leaf: &LeafPlace, side: &str| {
        let (number, branch) = (leaf.leaf, branch(leaf));
        format!("leaf {number} of tree {tree}{branch} stands in {side} alone")
    };
    let counts = [plant.only_a_count, plant.only_b_count, plant.moved_count];
    match (
        counts,
        plant.only_a.first(),
        plant.only_b.first(),
        plant.moved.first(),
    ) {
        ([1, 0, 0], Some(leaf), ..) => alone(leaf, "A"),
        ([0, 1, 0], _, Some(leaf), _) => alone(leaf, "B"),
        ([0, 0, 1], _, _, Some(moved)) => {
            let (leaf, branch) = (moved.a.leaf, branch(&moved.a));
            format!("leaf {leaf} of tree {tree}{branch} stands elsewhere in B")
        }
        ([0, 0, 0], ..) => {
            let parts = plant.parts.join(", ");
            format!("tree {tree} has the same leaves, but its {parts} differ")
        }
        ([only_a, only_b, moved], ..) => format!(
            "of the leaves of tree {tree}, {only_a} stand in A alone, {only_b} in B alone, and \
             {moved} moved"
        ),
    }
}

fn trunk_cause(trunk: &TrunkDifference) -> String {
    let tree = trunk.tree;
    match (trunk.first_triangle, &trunk.branch, trunk.first_collapse) {
        (Some(triangle), Some(branch), _) => {
            let branch = branch.branch;
            format!(
                "the trunk of tree {tree} differs from triangle {triangle} on (branch {branch})"
            )
        }
        (Some(triangle), None, _) => {
            format!("the trunk of tree {tree} differs from triangle {triangle} on")
        }
        (None, _, Some(first)) => {
            format!("collapses of the trunk of tree {tree} differ from number {first} on")
        }
        (None, _, None) => format!("the trunk of tree {tree} differs in its material"),
    }
}

fn asked_cause(asked: &AskedDifference, count: u64) -> String {
    let value = |value: &Option<String>| value.clone().unwrap_or_else(|| "nothing".to_owned());
    let more = match count {
        0 | 1 => String::new(),
        2 => " (another key differs)".to_owned(),
        more => format!(" ({} more keys differ)", more - 1),
    };
    let (a, b) = (value(&asked.a), value(&asked.b));
    format!("A asks for {} = {a}, B for {b}{more}", asked.key)
}

fn pixels(report: &RunsReport) -> String {
    let all = report.common_frames;
    match report.frames.as_slice() {
        [] => "all pictures are the same".to_owned(),
        [one] if one.pixels.is_some() => {
            let (frame, pixels) = (one.frame, one.pixels.unwrap_or(0));
            format!("{pixels} pixels of frame {frame} differ, of {all} frames")
        }
        frames => {
            let pixels: u64 = frames.iter().filter_map(|frame| frame.pixels).sum();
            let differing = frames.len();
            format!("{pixels} pixels differ in {differing} of {all} frames")
        }
    }
}
