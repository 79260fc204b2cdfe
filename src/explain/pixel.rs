//! What a pixel of a run shows, and why.

use std::sync::Arc;

use serde::Serialize;

use super::face::{FaceStory, face_story};
use super::leaf::{LeafBook, LeafStory};
use super::operations::operations;
use super::replay::{RecordedRun, Replay, ReplayedFrame};
use super::rivals::{SampleStory, decide};
use super::trunk::{TrunkStory, trunk_story};
use super::uploads::Uploads;
use super::{EXPLAIN_SCHEMA, ExplainError, bounded};
use crate::gpu::{Key, ProbedFragment};
use crate::math::Vec4;
use crate::models::{CARD_GROUP, LEAF_GROUP, State, TERRAIN_GROUP, TRUNK_GROUP, Trunk};
use crate::run::{Frame, Owner, Progress, Session, World};
use crate::scene::{PlantSource, Tree};

/// All there is to tell of a pixel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PixelReport {
    /// [`EXPLAIN_SCHEMA`].
    pub schema: &'static str,
    /// `pixel`.
    pub kind: &'static str,
    /// The scene's name.
    pub scene: String,
    /// The version of spinney that made the run.
    pub version: String,
    /// Model and mode in one word.
    pub model: String,
    /// The frame, drawn again.
    pub frame: ReplayedFrame,
    /// The pixel: column, row.
    pub pixel: [u32; 2],
    /// Columns and rows of the picture.
    pub size: [u32; 2],
    /// Its colour.
    pub colour: ColourStory,
    /// Whether what is told of the samples gives the picture's colour, depth and key, to the bit. It
    /// is found by another way than the picture is.
    pub agrees: bool,
    /// Its samples.
    pub samples: Vec<SampleStory>,
    /// How many fragments cover one of its samples.
    pub fragment_count: u64,
    /// What covers a sample, in the order of submission.
    pub fragments: Vec<PixelPlace>,
    /// The trees that these fragments are of.
    pub trees: Vec<TreeStory>,
}

/// A colour.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColourStory {
    /// As in the picture: sRGB with alpha, 8 bits a channel.
    pub srgb: [u8; 4],
    /// Before it was made sRGB: the mean of the samples.
    pub linear: [f32; 4],
}

/// A fragment: a triangle at the pixel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PixelPlace {
    /// `leaf`, `trunk`, `card` for what stands for leaves, or `unknown` for what neither a leaf's nor a trunk's corners fit.
    pub what: &'static str,
    /// The key by which ties of depth are broken: group, instance, first vertex, triangle.
    pub key: [u32; 4],
    /// The tree.
    pub tree: u32,
    /// Its corners' numbers in the vertex buffer.
    pub vertices: Vec<u32>,
    /// Whether the alpha test keeps it.
    pub kept: bool,
    /// Whether its front is seen.
    pub front: bool,
    /// Its linear colour, also where it does not show.
    pub colour: [f32; 4],
    /// The leaf that it is part of.
    pub leaf: Option<LeafStory>,
    /// The face that it is, of a leaf that has several.
    pub face: Option<FaceStory>,
    /// The triangle of the trunk that it is.
    pub trunk: Option<TrunkStory>,
}

/// A tree of the scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TreeStory {
    /// Its number in the scene.
    pub tree: u32,
    /// Its plant, by its number among all plants of the scene.
    pub plant: u32,
    /// What the plant is called.
    pub name: String,
    /// The file that it comes from, in the run's folder.
    pub source: String,
    /// The seed that it grew from; of no meaning where it is imported.
    pub seed: u64,
    /// Where it stands, in metres.
    pub at: [f32; 3],
    /// Its turn about +Y, in degrees.
    pub turn: f32,
    /// The factor on its size.
    pub scale: f32,
    /// `uniform`, `variable` or `cards`.
    pub detail: &'static str,
    /// Collapses done, over all clusters.
    pub collapses: u32,
    /// Collapses that there are.
    pub all_collapses: u32,
    /// Leaves that are visible.
    pub leaves: u64,
}

/// Explains a pixel of a frame, or of the run's first: column and row from the top left.
///
/// The run is played again up to the frame. Then every fragment of the frame's pass at the pixel is
/// found by a pass of its own over that one pixel, also what is hidden or killed.
///
/// # Errors
///
/// When the run does not have the frame or the pixel, or cannot be played again.
pub fn explain_pixel(
    run: &RecordedRun,
    frame: Option<u32>,
    pixel: [u32; 2],
    progress: &dyn Progress,
) -> Result<PixelReport, ExplainError> {
    let frames = run.frames();
    let wanted = frame.or(frames.first().copied()).unwrap_or(0);
    let unknown = || ExplainError::Frame {
        frame: wanted,
        known: in_words(&frames),
    };
    let place = frames.iter().position(|&frame| frame == wanted);
    let place = place.ok_or_else(unknown)?;
    let size = [run.scene().size.width(), run.scene().size.height()];
    if pixel[0] >= size[0] || pixel[1] >= size[1] {
        return Err(ExplainError::Pixel { pixel, size });
    }
    let world = run.world(progress)?;
    let mut replay = Replay::new(run, &world)?;
    progress.begin("frames", place as u64 + 1);
    let mut drawn = None;
    let mut uploads = Uploads::default();
    let session = replay.session();
    uploads.add(None, &operations(session.initial(), session), session);
    for _ in 0..=place {
        drawn = replay.draw_next()?;
        if let Some((frame, _)) = &drawn {
            let session = replay.session();
            let sent = operations(&frame.ledger, session);
            uploads.add(Some(frame.frame), &sent, session);
        }
        progress.step();
    }
    let Some((frame, replayed)) = drawn else {
        return Err(unknown());
    };
    let scene = Played {
        run,
        world: &world,
        session: replay.session(),
        uploads,
    };
    report(&scene, &frame, replayed, pixel)
}

/// A run as it was played again up to a frame.
struct Played<'p> {
    run: &'p RecordedRun,
    world: &'p World,
    session: &'p Session<'p>,
    uploads: Uploads,
}

fn report(
    played: &Played<'_>,
    frame: &Frame,
    replayed: ReplayedFrame,
    pixel: [u32; 2],
) -> Result<PixelReport, ExplainError> {
    let Played {
        run,
        world,
        session,
        ..
    } = played;
    let fragments = session.probe(pixel)?;
    let target = session.device().inspect_target(session.target());
    let target = target.expect("a session keeps its target");
    let clear = Clear {
        depth: 1.0,
        colour: session.background(),
    };
    let decided: Vec<(SampleStory, Option<usize>)> = (0..)
        .zip(target.samples().offsets())
        .map(|(sample, _)| decide(sample, &fragments, clear.depth))
        .collect();
    let [x, y] = pixel;
    let colours = decided
        .iter()
        .map(|(_, winner)| winner.map_or(clear.colour, |winner| fragments[winner].colour));
    let first = decided.first();
    let agrees = mean(&colours.collect::<Vec<_>>()) == target.colour(x, y)
        && first.is_some_and(|(story, winner)| {
            story.depth.to_bits() == target.depth(x, y).to_bits()
                && winner.map(|winner| fragments[winner].key) == target.key(x, y)
        });
    let at = 4 * (y as usize * frame.image.width as usize + x as usize);
    let srgb = frame.image.rgba.get(at..at + 4);
    let numbers: Vec<u32> = {
        let mut numbers: Vec<u32> = fragments.iter().map(|one| one.key.instance).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    };
    let mut places: Vec<Option<PixelPlace>> = vec![None; fragments.len()];
    let mut trees = Vec::new();
    for number in numbers {
        let tree = tree_story(run, world, frame, number);
        for (place, fragment) in places.iter_mut().zip(&fragments) {
            if fragment.key.instance == number {
                *place = Some(plain_place(fragment));
            }
        }
        if let Some(tree) = tree {
            tell(played, frame, number, &mut places);
            trees.push(tree);
        }
    }
    let (fragment_count, fragments) = bounded(places.into_iter().flatten().collect());
    Ok(PixelReport {
        schema: EXPLAIN_SCHEMA,
        kind: "pixel",
        scene: run.scene().name.clone(),
        version: run.ledger().head.version.clone(),
        model: run.kind().label(),
        frame: replayed,
        pixel,
        size: [target.width(), target.height()],
        colour: ColourStory {
            srgb: srgb
                .and_then(|four| four.try_into().ok())
                .unwrap_or_default(),
            linear: target.colour(x, y).to_array(),
        },
        agrees,
        samples: decided.into_iter().map(|(story, _)| story).collect(),
        fragment_count,
        fragments,
        trees,
    })
}

/// What a picture was cleared to.
struct Clear {
    depth: f32,
    colour: Vec4,
}

/// As samples resolve.
fn mean(colours: &[Vec4]) -> Vec4 {
    match *colours {
        [a, b, c, d] => ((a + b) + (c + d)) * 0.25,
        [one, ..] => one,
        [] => Vec4::ZERO,
    }
}

/// What a fragment says of itself.
fn plain_place(fragment: &ProbedFragment) -> PixelPlace {
    let Key {
        group,
        instance,
        vertex,
        triangle,
    } = fragment.key;
    PixelPlace {
        what: match group {
            TERRAIN_GROUP => "ground",
            _ => "unknown",
        },
        key: [group, instance, vertex, triangle],
        tree: instance,
        vertices: fragment.corners.clone(),
        kept: fragment.kept,
        front: fragment.front,
        colour: fragment.colour.to_array(),
        leaf: None,
        face: None,
        trunk: None,
    }
}

/// Tells the leaves and triangles of one tree's fragments.
fn tell(played: &Played<'_>, frame: &Frame, number: u32, places: &mut [Option<PixelPlace>]) {
    let Played {
        run,
        world,
        session,
        uploads,
    } = played;
    let standing = world.trees.get(number as usize);
    let Some((tree, state)) = standing.zip(frame.states.get(number as usize)) else {
        return;
    };
    let crown = &world.crowns[tree.crown];
    let book = LeafBook::new(crown, &state.foliage, run.kind(), run.options().model);
    let trunk = world.trunks[tree.crown].as_ref();
    let level = Some(state.trunk).filter(|_| run.options().trunk.has_levels());
    let ours = places.iter_mut().flatten();
    for place in ours.filter(|place| place.tree == number) {
        match (place.key[0], place.vertices.as_slice()) {
            (LEAF_GROUP, &[a, b, c, d]) => {
                let leaf = book.leaf_with([a, b, c, d]);
                place.leaf = leaf.map(|leaf| book.story(leaf, &tree.placement));
            }
            (LEAF_GROUP, &[a, b, c]) => {
                place.face = face_story(crown, [a, b, c], &tree.placement);
            }
            (TRUNK_GROUP, &[a, b, c]) => {
                let story = |trunk: &Arc<Trunk>| {
                    trunk_story(crown, trunk, level, [a, b, c], &tree.placement)
                };
                place.trunk = trunk.and_then(story);
                if let Some(trunk) = &mut place.trunk {
                    let owners = [Owner::Tree(number), Owner::Plant(tree.crown)];
                    trunk.upload = uploads.of_triangle(session, owners, [a, b, c]);
                }
            }
            _ => {}
        }
        if place.key[0] == CARD_GROUP {
            place.what = "card";
        } else if place.leaf.is_some() || place.face.is_some() {
            place.what = "leaf";
        } else if place.trunk.is_some() {
            place.what = "trunk";
        }
    }
}

fn tree_story(run: &RecordedRun, world: &World, frame: &Frame, number: u32) -> Option<TreeStory> {
    let asked: Tree = run
        .scene()
        .standing_trees()
        .into_iter()
        .nth(number as usize)?;
    let standing = world.trees.get(number as usize)?;
    let state = &frame.states.get(number as usize)?.foliage;
    let crown = &world.crowns[standing.crown];
    let (PlantSource::Species(source) | PlantSource::File { path: source, .. }) = &asked.source;
    Some(TreeStory {
        tree: number,
        plant: crate::math::index_u32(standing.crown),
        name: crown.plant().name().to_owned(),
        source: source.clone(),
        seed: asked.seed,
        at: asked.at.to_array(),
        turn: asked.turn,
        scale: asked.scale,
        detail: match state {
            State::Uniform { .. } => "uniform",
            State::Variable { .. } => "variable",
            State::Cards(_) => "cards",
            State::Strokes(_) => "strokes",
        },
        collapses: state.collapse_count(),
        all_collapses: crown.sequence().collapse_count(),
        leaves: crown.shown_leaves(state),
    })
}

/// Ascending numbers in words, runs joined: `0..=3, 8`.
fn in_words(numbers: &[u32]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    let words = runs.map(|run| match run {
        [one] => one.to_string(),
        [first, .., last] => format!("{first}..={last}"),
        [] => String::new(),
    });
    let words: Vec<String> = words.take(12).collect();
    if words.is_empty() {
        "none".to_owned()
    } else {
        words.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_frames_are_joined() {
        assert_eq!(in_words(&[0, 1, 2, 3, 8, 10, 11]), "0..=3, 8, 10..=11");
        assert_eq!(in_words(&[]), "none");
    }
}
