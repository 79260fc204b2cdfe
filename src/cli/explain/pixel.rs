//! A pixel's report as text.

use super::facts::Facts;
use crate::explain::{
    CollapseStory, FaceStory, Fate, LeafStory, MaterialStory, PixelPlace, PixelReport, Rival,
    SampleStory, TreeStory, TrunkStory, Verdict,
};

/// The most rivals of a sample that are listed.
const LISTED: usize = 20;

pub(super) fn text(report: &PixelReport, width: usize) -> String {
    let mut facts = Facts::new(width);
    let ([x, y], [columns, rows]) = (report.pixel, report.size);
    let (scene, model) = (&report.scene, &report.model);
    facts.add(
        "pixel",
        format!(
            "{x},{y} of {columns} × {rows}, frame {} of {scene} ({model})",
            report.frame.frame
        ),
    );
    let ([r, g, b, alpha], linear) = (report.colour.srgb, report.colour.linear);
    let alpha = match alpha {
        255 => String::new(),
        alpha => format!(", alpha {alpha}"),
    };
    facts.add(
        "colour",
        format!(
            "#{r:02x}{g:02x}{b:02x} ({r} {g} {b}{alpha}), linear {} {} {}",
            linear[0], linear[1], linear[2]
        ),
    );
    check(report, &mut facts);
    // Samples that show the same thing are told once.
    let mut told: Vec<u64> = Vec::new();
    for sample in &report.samples {
        let name = match report.samples.len() {
            1 => "shows".to_owned(),
            _ => format!("sample {}", sample.sample),
        };
        facts.add(&name, shown(report, sample));
        if let Some(shows) = sample.shows.filter(|shows| !told.contains(shows)) {
            told.push(shows);
        }
    }
    let mut told_trees = Vec::new();
    for place in told.iter().filter_map(|&number| fragment(report, number)) {
        facts.blank();
        let tree = report.trees.iter().find(|tree| tree.tree == place.tree);
        if let Some(tree) = tree.filter(|tree| !told_trees.contains(&tree.tree)) {
            told_trees.push(tree.tree);
            tell_tree(tree, &mut facts);
        }
        if let Some(leaf) = &place.leaf {
            tell_leaf(leaf, &mut facts);
        }
        if let Some(face) = &place.face {
            tell_face(face, &mut facts);
        }
        if let Some(trunk) = &place.trunk {
            tell_trunk(trunk, &mut facts);
        }
    }
    for sample in &report.samples {
        if sample.rivals.is_empty() {
            continue;
        }
        facts.blank();
        let of = match report.samples.len() {
            1 => String::new(),
            _ => format!(" sample {}", sample.sample),
        };
        facts.add("rivals", format!("what covers{of}, nearest first"));
        for rival in sample.rivals.iter().take(LISTED) {
            if let Some(place) = fragment(report, rival.fragment) {
                facts.row(&rival_row(rival, place));
            }
        }
        facts.more(sample.rival_count, sample.rivals.len().min(LISTED));
    }
    facts.text()
}

/// Whether what is told is what was drawn.
fn check(report: &PixelReport, facts: &mut Facts) {
    let frame = &report.frame;
    if frame.same {
        facts.add("replayed", "the frame is the ledger's, to the bit");
    } else {
        facts.add(
            "replayed",
            format!(
                "NOT the ledger's frame: its digest was {}…, played again by version {} it is {}…; \
                 what follows is of the latter",
                frame.ledger_digest.chars().take(16).collect::<String>(),
                env!("CARGO_PKG_VERSION"),
                frame.digest.chars().take(16).collect::<String>(),
            ),
        );
        facts.add("version", format!("of the run: {}", report.version));
    }
    if !report.agrees {
        facts.add(
            "beware",
            "what is told below does not give the pixel's colour, depth and key: a fault of spinney",
        );
    }
}

fn fragment(report: &PixelReport, number: u64) -> Option<&PixelPlace> {
    report.fragments.get(usize::try_from(number).ok()?)
}

/// What a sample shows, and why that.
fn shown(report: &PixelReport, sample: &SampleStory) -> String {
    let Some(place) = sample.shows.and_then(|number| fragment(report, number)) else {
        return "background".to_owned();
    };
    let why = match sample.verdict {
        Verdict::Background => "",
        Verdict::Alone => "nothing else is there",
        Verdict::Depth => "it is nearest",
        Verdict::Key => "as near as the next, but its key is less",
        Verdict::Order => "as near as the next and of the same key, but submitted first",
    };
    format!("{} at depth {}: {why}", name(place), sample.depth)
}

/// A fragment in a few words.
fn name(place: &PixelPlace) -> String {
    let tree = place.tree;
    if let Some(face) = &place.face {
        return format!("leaf {} of tree {tree}", face.site);
    }
    match (&place.leaf, &place.trunk) {
        (Some(leaf), _) => format!("leaf {} of tree {tree}", leaf.leaf),
        (None, Some(trunk)) => format!("trunk triangle {} of tree {tree}", trunk.triangle),
        (None, None) => format!(
            "group {} of tree {tree}, vertex {}",
            place.key[0], place.key[2]
        ),
    }
}

fn tell_tree(tree: &TreeStory, facts: &mut Facts) {
    let [x, y, z] = tree.at;
    facts.add(
        &format!("tree {}", tree.tree),
        format!(
            "{:?} from {}, seed {}, at {x} {y} {z}, turned {}°, scale {}; {} detail, {} of {} \
             collapses done, {} leaves",
            tree.name,
            tree.source,
            tree.seed,
            tree.turn,
            tree.scale,
            tree.detail,
            tree.collapses,
            tree.all_collapses,
            tree.leaves
        ),
    );
}

fn tell_leaf(leaf: &LeafStory, facts: &mut Facts) {
    let branch = |branch: Option<u32>| branch.map_or("–".to_owned(), |branch| branch.to_string());
    let origin = match &leaf.made_by {
        None => match leaf.branch {
            Some(branch) => format!("an original, on branch {branch}"),
            None => "an original".to_owned(),
        },
        Some(made) => {
            let [first, second] = made.old;
            format!(
                "made by collapse {} (cost {}) of leaves {first} and {second}; stands for {} originals",
                made.collapse, made.cost, leaf.stands_for
            )
        }
    };
    facts.add(&format!("leaf {}", leaf.leaf), origin);
    facts.add("", fate(leaf.leaf, leaf.consumed_by.as_ref()));
    let cluster = &leaf.cluster;
    facts.add(
        &format!("cluster {}", cluster.cluster),
        format!(
            "of {} leaves; {} of {} collapses done, {} visible",
            cluster.originals,
            cluster.collapses,
            cluster.originals - 1,
            cluster.visible
        ),
    );
    tell_material(&leaf.material, facts);
    facts.add(
        "vertices",
        "corner (0 and 1 at the base), number, of leaf, on branch; in the plant | in the world, metres",
    );
    for vertex in &leaf.vertices {
        facts.wide_row(&format!(
            "{} {:>8} {:>7} {:>6}{} |{}",
            vertex.role,
            vertex.vertex,
            vertex.leaf,
            branch(vertex.branch),
            point(vertex.plant),
            point(vertex.world)
        ));
    }
}

fn tell_material(material: &MaterialStory, facts: &mut Facts) {
    let texture = material.texture.map_or(String::new(), |[width, height]| {
        format!(", texture {width} × {height}")
    });
    let [r, g, b, _] = material.base_color;
    facts.add(
        "material",
        format!(
            "{:?} (group {}), linear {r} {g} {b}{texture}, alpha below {} is cut",
            material.name, material.group, material.alpha_cutoff
        ),
    );
}

fn tell_face(face: &FaceStory, facts: &mut Facts) {
    let branch = face
        .branch
        .map_or(String::new(), |branch| format!(", on branch {branch}"));
    facts.add(
        &format!("leaf {}", face.site),
        format!(
            "face {} of {}{branch}; no collapse changes leaves of several faces",
            face.face, face.faces
        ),
    );
    tell_material(&face.material, facts);
    facts.add("vertices", "number; in the plant | in the world, metres");
    for corner in 0..3 {
        facts.wide_row(&format!(
            "{:>8}{} |{}",
            face.vertices[corner],
            point(face.plant[corner]),
            point(face.world[corner])
        ));
    }
}

/// Millimetres are enough for people.
fn point(point: [f32; 3]) -> String {
    point.map(|value| format!("{value:8.3}")).concat()
}

fn fate(leaf: u32, consumed_by: Option<&CollapseStory>) -> String {
    match consumed_by {
        None => "no collapse consumes it: the last leaf of its cluster".to_owned(),
        Some(collapse) => {
            let partner = collapse.old.iter().find(|old| **old != leaf);
            let partner = partner.map_or(String::new(), |leaf| format!(" with leaf {leaf}"));
            format!(
                "collapse {} (cost {}) will join it{partner} into leaf {}",
                collapse.collapse, collapse.cost, collapse.new
            )
        }
    }
}

fn tell_trunk(trunk: &TrunkStory, facts: &mut Facts) {
    let place = match &trunk.branch {
        None => "of a trunk whose branches are not known".to_owned(),
        Some(branch) => {
            let bearer = branch.bearer.map_or(String::new(), |bearer| {
                format!(", borne by branch {bearer}")
            });
            format!(
                "on branch {} (level {}{bearer}), above node {} of 0..{}",
                branch.branch, branch.level, branch.node, branch.nodes
            )
        }
    };
    facts.add("trunk", format!("triangle {}, {place}", trunk.triangle));
    tell_level(trunk, facts);
    facts.add("material", format!("{:?}", trunk.material));
    facts.add("vertices", "number; in the plant | in the world, metres");
    for corner in 0..3 {
        facts.wide_row(&format!(
            "{:>8}{} |{}",
            trunk.vertices[corner],
            point(trunk.plant[corner]),
            point(trunk.world[corner])
        ));
    }
}

/// What the trunk's level made of a triangle, and what brought it.
fn tell_level(trunk: &TrunkStory, facts: &mut Facts) {
    if let Some(level) = &trunk.level {
        facts.add(
            "level",
            format!(
                "{} of {} collapses done, {} triangles",
                level.collapses, level.all_collapses, level.triangles
            ),
        );
        facts.add(
            "",
            match &trunk.made_by {
                None => "the triangle is as in the mesh".to_owned(),
                Some(made) => format!(
                    "made by collapse {} (cost {}, error {} m), which moved vertex {} to {}",
                    made.collapse, made.cost, made.error, made.vertex, made.target
                ),
            },
        );
        facts.add(
            "",
            match &trunk.changed_by {
                None => "no collapse changes it further".to_owned(),
                Some(next) => format!(
                    "collapse {} (cost {}) will {} vertex {} to {}",
                    next.collapse,
                    next.cost,
                    if next.removes {
                        "take it away, moving"
                    } else {
                        "move its"
                    },
                    next.vertex,
                    next.target
                ),
            },
        );
    }
    if let Some(upload) = &trunk.upload {
        let place = format!(
            "bytes {}..{} of {:?} of {}",
            upload.start, upload.end, upload.buffer, upload.owner
        );
        let when = upload.frame.map_or_else(
            || "before the first frame".to_owned(),
            |frame| format!("with frame {frame}"),
        );
        facts.add(
            "sent",
            match (&upload.cause, upload.payload_bytes) {
                (Some(cause), Some(bytes)) => {
                    let id = upload.id.map_or(String::new(), |id| format!(" {id}"));
                    format!("{place}, last {when}, cause {cause}{id}, {bytes} B")
                }
                _ => format!("{place}, in host memory: each draw pulls them"),
            },
        );
    }
}

fn rival_row(rival: &Rival, place: &PixelPlace) -> String {
    let what = match (&place.leaf, &place.trunk) {
        (Some(leaf), _) => format!(
            "leaf {}.{} cluster {} tree {}",
            leaf.leaf, place.key[3], leaf.cluster.cluster, place.tree
        ),
        _ => name(place),
    };
    let fate = match rival.fate {
        Fate::Shows => "shows",
        Fate::Behind => "behind",
        Fate::LostByKey => "as near, greater key",
        Fate::LostByOrder => "as near, submitted later",
        Fate::KilledByAlpha => "cut by alpha",
        Fate::BeyondClearDepth => "beyond the far plane",
        Fate::Blended => "blended over it",
    };
    format!("{:<11} {what:32} {fate}", rival.depth)
}
