//! Where two runs part, as text.

use super::facts::{Facts, counted};
use crate::explain::{
    AskedDifference, BufferDifference, ClusterPlace, CollapsePlace, LeafPlace, OperationDifference,
    OperationSide, PlantDifference, RunsReport, SequenceDifference, SideReport, TrunkDifference,
};
use crate::report::grouped;

/// The most entries of a list.
const LISTED: usize = 20;

pub(super) fn text(report: &RunsReport, width: usize) -> String {
    let mut facts = Facts::new(width);
    for (name, side) in [("A", &report.a), ("B", &report.b)] {
        facts.add(name, side_words(side));
    }
    if report.same {
        facts.add("same", "asked, plants, states, transfers and pictures");
        return facts.text();
    }
    asked(report, &mut facts);
    for plant in &report.plants {
        facts.blank();
        tell_plant(plant, &mut facts);
    }
    for sequence in &report.sequences {
        facts.blank();
        tell_sequence(sequence, &mut facts);
    }
    for trunk in &report.trunks {
        facts.blank();
        tell_trunk(trunk, &mut facts);
    }
    if let Some(levels) = &report.levels {
        let ([a, b], [ours, theirs]) = (levels.collapses, levels.triangles);
        facts.add(
            "levels",
            format!(
                "frame {} shows the trunk of tree {} after {a} collapses in A ({ours} triangles), {b} in \
                 B ({theirs}); so do {} of its trees",
                levels.frame, levels.tree, levels.trees
            ),
        );
    }
    facts.blank();
    match &report.operation {
        None => facts.add("transfers", "all the same, where frames are in both"),
        Some(operation) => tell_operation(operation, &mut facts),
    }
    for record in &report.records {
        facts.add(
            record.file,
            format!("the runs' own files part at line {}", record.line),
        );
        for (side, line) in [("A", &record.a), ("B", &record.b)] {
            let line = line.as_deref().unwrap_or("ends before");
            facts.row(&format!("{side}: {line}"));
        }
    }
    if !report.buffers.is_empty() {
        facts.blank();
        for buffer in report.buffers.iter().take(LISTED) {
            tell_buffer(buffer, &mut facts);
        }
        facts.more(report.buffer_count, report.buffers.len().min(LISTED));
    }
    facts.blank();
    pixels(report, &mut facts);
    for (name, side) in [("A", &report.a), ("B", &report.b)] {
        if let Some(frame) = side.replayed.iter().find(|frame| !frame.same) {
            facts.add(
                "beware",
                format!(
                    "frame {} of {name}, played again, is not the ledger's: the run was made by \
                     another spinney (it says version {}, this is {})",
                    frame.frame,
                    side.version,
                    env!("CARGO_PKG_VERSION")
                ),
            );
        }
    }
    facts.blank();
    facts.add("in short", &report.summary);
    facts.text()
}

fn side_words(side: &SideReport) -> String {
    format!(
        "{} ({}), {}, {} B uploaded, {} B fetched",
        side.scene,
        side.model,
        counted(side.frames, "frame"),
        grouped(side.upload_bytes, ","),
        grouped(side.fetch_bytes, ",")
    )
}

fn asked(report: &RunsReport, facts: &mut Facts) {
    if report.asked.is_empty() && report.plant_files.is_empty() {
        facts.add("asked", "the same of both");
        return;
    }
    if !report.asked.is_empty() {
        facts.add("asked", "not the same of both (A | B)");
    }
    list_keys(&report.asked, report.asked_count, facts);
    for file in report.plant_files.iter().take(LISTED) {
        let names = match file.a == file.b {
            true => file.a.clone(),
            false => format!("{} | {}", file.a, file.b),
        };
        let what = match file.keys.len() {
            0 => " differs in comments or layout alone",
            _ => " differs (A | B)",
        };
        facts.add("plant file", names + what);
        list_keys(&file.keys, file.keys.len() as u64, facts);
    }
    facts.more(
        report.plant_files.len() as u64,
        report.plant_files.len().min(LISTED),
    );
}

fn list_keys(keys: &[AskedDifference], all: u64, facts: &mut Facts) {
    for key in keys.iter().take(LISTED) {
        let value = |value: &Option<String>| value.clone().unwrap_or_else(|| "–".to_owned());
        facts.row(&format!(
            "{}: {} | {}",
            key.key,
            value(&key.a),
            value(&key.b)
        ));
    }
    facts.more(all, keys.len().min(LISTED));
}

fn tell_plant(plant: &PlantDifference, facts: &mut Facts) {
    let [ours, theirs] = plant.leaves;
    facts.add(
        &format!("tree {}", plant.tree),
        format!(
            "{} leaves in A, {} in B: {} in A alone, {} in B alone, {} moved; {} of the others have \
             another number",
            ours, theirs, plant.only_a_count, plant.only_b_count, plant.moved_count, plant.renumbered
        ),
    );
    if !plant.parts.is_empty() {
        facts.add("", format!("also differing: {}", plant.parts.join(", ")));
    }
    for (name, list, all) in [
        ("in A alone", &plant.only_a, plant.only_a_count),
        ("in B alone", &plant.only_b, plant.only_b_count),
    ] {
        if all > 0 {
            facts.add(name, "leaf, branch, group, centre in metres");
        }
        for leaf in list.iter().take(LISTED) {
            facts.row(&leaf_words(leaf));
        }
        facts.more(all, list.len().min(LISTED));
    }
    if plant.moved_count > 0 {
        facts.add("moved", "leaf in A, in B; branch; how far in metres");
    }
    for moved in plant.moved.iter().take(LISTED) {
        let branch = moved
            .a
            .branch
            .map_or("–".to_owned(), |branch| branch.to_string());
        facts.row(&format!(
            "{:>7} {:>7} {branch:>6} {}",
            moved.a.leaf, moved.b.leaf, moved.distance
        ));
    }
    facts.more(plant.moved_count, plant.moved.len().min(LISTED));
}

fn leaf_words(leaf: &LeafPlace) -> String {
    let branch = leaf
        .branch
        .map_or("–".to_owned(), |branch| branch.to_string());
    let [x, y, z] = leaf.centre;
    format!(
        "{:>7} {branch:>6} {:12} {x:7.3} {y:7.3} {z:7.3}",
        leaf.leaf, leaf.group
    )
}

fn tell_sequence(sequence: &SequenceDifference, facts: &mut Facts) {
    let [ours, theirs] = sequence.collapses;
    let [only_a, only_b] = sequence.only;
    let first = match (sequence.first, sequence.first_cost) {
        (Some(first), Some(cost)) if cost < first => {
            format!("the first that joins others is {first} (costs differ from {cost} on)")
        }
        (Some(first), _) => format!("the first that joins others is {first}"),
        (None, cost) => {
            let cost = cost.unwrap_or(0);
            format!("all join the same leaves, but costs differ from {cost} on")
        }
    };
    facts.add(
        "collapses",
        format!(
            "{ours} in A, {theirs} in B, of tree {}; {only_a} of A make leaves that B never has, \
             {only_b} of B leaves that A never has; {first}",
            sequence.tree
        ),
    );
    let words = |collapse: &Option<CollapsePlace>| match collapse {
        None => "ends before".to_owned(),
        Some(collapse) => format!(
            "leaves {} and {} become {} at cost {}, cluster {}",
            collapse.old[0], collapse.old[1], collapse.new, collapse.cost, collapse.cluster
        ),
    };
    facts.side("A", words(&sequence.a));
    facts.side("B", words(&sequence.b));
    let [ours, theirs] = sequence.clusters;
    let list = |clusters: &[ClusterPlace], all: u64| {
        let words = clusters
            .iter()
            .take(LISTED / 2)
            .map(|cluster| format!("{} ({} leaves)", cluster.cluster, cluster.originals));
        let mut words = words.collect::<Vec<_>>().join(", ");
        let more = all - all.min(LISTED as u64 / 2);
        if more > 0 {
            words += &format!(" and {more} more");
        }
        words
    };
    facts.add(
        "clusters",
        format!(
            "{ours} in A, {theirs} in B; in A alone {}, in B alone {}",
            sequence.clusters_only_a_count, sequence.clusters_only_b_count
        ),
    );
    if sequence.clusters_only_a_count > 0 {
        let words = list(&sequence.clusters_only_a, sequence.clusters_only_a_count);
        facts.side("A", words);
    }
    if sequence.clusters_only_b_count > 0 {
        let words = list(&sequence.clusters_only_b, sequence.clusters_only_b_count);
        facts.side("B", words);
    }
}

fn tell_trunk(trunk: &TrunkDifference, facts: &mut Facts) {
    let ([a, b], [c, d]) = (trunk.vertices, trunk.triangles);
    let first = match (trunk.first_triangle, &trunk.branch) {
        (None, _) => "the triangles are the same".to_owned(),
        (Some(first), None) => format!("the first triangle that differs is {first}"),
        (Some(first), Some(branch)) => format!(
            "the first triangle that differs is {first}, on branch {} above node {}",
            branch.branch, branch.node
        ),
    };
    facts.add(
        "trunk",
        format!(
            "of tree {}: {a} vertices and {c} triangles in A, {b} and {d} in B; {first}",
            trunk.tree
        ),
    );
    let (Some([ours, theirs]), Some(first)) = (trunk.collapses, trunk.first_collapse) else {
        return;
    };
    facts.add(
        "",
        format!("{ours} collapses in A, {theirs} in B, the first that differs is {first}"),
    );
    for (side, place) in [("A", &trunk.a), ("B", &trunk.b)] {
        let words = place.as_ref().map_or("ends before".to_owned(), |place| {
            format!(
                "vertex {} goes to {} at cost {}, error {} m",
                place.vertex, place.target, place.cost, place.error
            )
        });
        facts.side(side, words);
    }
}

fn tell_operation(operation: &OperationDifference, facts: &mut Facts) {
    let when = match operation.frame {
        None => "before the first frame".to_owned(),
        Some(frame) => format!("at frame {frame}"),
    };
    let [ours, theirs] = operation.transfers;
    facts.add(
        "transfers",
        format!(
            "part {when}, at transfer {} (of {ours} in A, {theirs} in B; {} differ)",
            operation.place, operation.differing
        ),
    );
    for (name, side) in [("A", &operation.a), ("B", &operation.b)] {
        let Some(side) = side else {
            facts.side(name, "does no more");
            continue;
        };
        facts.side(name, operation_words(side));
        if let (Some(at), Some(sent)) = (side.differs_at, &side.sent) {
            const DIGITS: usize = 32;
            let digits: String = sent.chars().take(DIGITS).collect();
            let more = if digits.len() < sent.len() { "…" } else { "" };
            facts.row(&format!("   from byte {at} on: {digits}{more}"));
        }
        if let Some(record) = &side.record {
            facts.row(&format!("   {record}"));
        }
    }
}

fn operation_words(side: &OperationSide) -> String {
    let owner = side
        .owner
        .as_ref()
        .map_or(String::new(), |owner| format!(" of {owner}"));
    let id = side.id.map_or(String::new(), |id| format!(" {id}"));
    let range = match (side.offset, side.length) {
        (Some(offset), Some(length)) => format!(", bytes {offset}..{}", offset + length),
        _ => String::new(),
    };
    let ranges = match side.ranges {
        0 | 1 => String::new(),
        ranges => format!(" in {ranges} ranges"),
    };
    format!(
        "{} {:?}{owner}, {} B{ranges}, cause {}{id}{range}",
        side.stream,
        side.resource,
        grouped(side.payload_bytes, ","),
        side.cause
    )
}

fn tell_buffer(buffer: &BufferDifference, facts: &mut Facts) {
    let name = format!("{:?} of {}", buffer.label, buffer.owner);
    let [Some(ours), Some(theirs)] = buffer.bytes else {
        let (side, bytes) = match buffer.bytes {
            [Some(bytes), _] => ("A", bytes),
            [_, bytes] => ("B", bytes.unwrap_or(0)),
        };
        let bytes = grouped(bytes, ",");
        facts.add("buffer", format!("{name}: {bytes} B, in {side} alone"));
        return;
    };
    let sizes = match ours == theirs {
        true => format!("{} B", grouped(ours, ",")),
        false => format!(
            "{} B in A, {} B in B",
            grouped(ours, ","),
            grouped(theirs, ",")
        ),
    };
    if let Some(inserted) = &buffer.inserted {
        let (side, start, end) = (&inserted.side, inserted.start, inserted.end);
        let side = side.to_uppercase();
        facts.add(
            "buffer",
            format!(
                "{name}: {sizes}; bytes {start}..{end} stand in {side} alone, the rest is equal"
            ),
        );
        facts.row(&format!("{side}: {}", inserted.record));
        return;
    }
    facts.add(
        "buffer",
        format!(
            "{name}: {sizes}; of records of {} B, {} differ, in {}",
            buffer.stride,
            grouped(buffer.differing_records, ","),
            counted(buffer.range_count, "range")
        ),
    );
    const RANGES: usize = 3;
    for range in buffer.ranges.iter().take(RANGES) {
        facts.row(&format!("bytes {}..{}", range.start, range.end));
        facts.row(&format!("  A: {}", range.a));
        facts.row(&format!("  B: {}", range.b));
    }
    facts.more(buffer.range_count, buffer.ranges.len().min(RANGES));
}

fn pixels(report: &RunsReport, facts: &mut Facts) {
    if report.frames.is_empty() {
        let frames = report.common_frames;
        facts.add(
            "pixels",
            format!("the same in all {frames} frames that are in both"),
        );
        return;
    }
    let (some, all) = (report.frames.len(), report.common_frames);
    facts.add("pixels", format!("differ in {some} of {all} frames"));
    for frame in report.frames.iter().take(LISTED) {
        let number = frame.frame;
        let row = match (frame.pixels, frame.bounds, frame.largest) {
            (Some(pixels), Some([left, top, right, bottom]), Some(largest)) => format!(
                "frame {number}: {} by up to {largest}, x {left}..={right}, y {top}..={bottom}",
                counted(pixels, "pixel")
            ),
            _ => {
                let [[a, b], [c, d]] = frame.sizes;
                format!("frame {number}: {a} × {b} pixels in A, {c} × {d} in B")
            }
        };
        facts.row(&row);
    }
    facts.more(report.frames.len() as u64, some.min(LISTED));
}
