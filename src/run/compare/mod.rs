//! Every scheme of level of detail on one tree that walks away, each as coarse as nobody sees: what it
//! sends, holds and takes.
//!
//! ```text
//! distance 0, 1, …: the tree takes half as many pixels each time
//!   leaves or wood ─full detail─▶ pictures ─┬─▶ judged: the coarsest level within the tolerance
//!   scheme ─────────levels──────▶ pictures ─┘        │
//!                                                    └─▶ change sent, frames drawn: ledgers
//! ```
//!
//! So schemes are held against each other at the same visible error, which is the only fair way to ask
//! what one costs more than another. A scheme whose finest level is not within the tolerance shows that one.
//! Leaves and wood are looked at one without the other: a tree has a scheme for each.

mod part;
mod walk;

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use self::part::{Leaves, Part, Wood, leaf_model};
use self::walk::{Subject, Walk};
use super::RunError;
use super::options::SessionOptions;
use super::progress::Progress;
use super::stand_ins::sphere_of;
use super::sweep::Variant;
use super::views::Shot;
use super::world::World;
use crate::gpu::Ledger;
use crate::math::index_u32;
use crate::models::{Crown, State, TrunkKind};

/// What is compared, and how closely.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareOptions {
    /// The schemes of foliage.
    pub leaves: Vec<Variant>,
    /// The schemes of wood.
    pub wood: Vec<TrunkKind>,
    /// How they are looked at.
    pub looks: WalkAway,
}

/// How a tree that walks away is looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct WalkAway {
    /// The pictures' side at the first distance, in pixels, at least 8.
    pub side: u32,
    /// How many distances, each twice the one before: as long as pictures have 8 pixels a side.
    pub distances: u32,
    /// The greatest difference that goes unseen, in the judge's measure.
    pub tolerance: f64,
    /// Link, card and the makings of models.
    pub session: SessionOptions,
}

/// The pictures of a distance: from three sides, from slightly above.
pub const COMPARE_VIEWS: u32 = 3;

/// A scheme of one part of a tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scheme {
    /// Of its foliage.
    Leaves(Variant),
    /// Of its wood.
    Wood(TrunkKind),
}

impl Scheme {
    /// The label of the variant or kind.
    #[must_use]
    pub fn label(self) -> String {
        match self {
            Self::Leaves(variant) => variant.label(),
            Self::Wood(kind) => kind.label(),
        }
    }

    /// Whether it has anything but full detail.
    #[must_use]
    pub fn has_levels(self) -> bool {
        match self {
            Self::Leaves(variant) => variant.has_levels(),
            Self::Wood(kind) => kind.has_levels(),
        }
    }

    /// Whether it shows something else in place of leaves.
    #[must_use]
    pub fn stands_in(self) -> bool {
        matches!(self, Self::Leaves(variant) if !variant.kind.shows_leaves())
    }
}

/// What is found of a scheme.
#[derive(Debug, Clone, PartialEq)]
pub struct SchemeFound {
    /// The scheme.
    pub scheme: Scheme,
    /// The upload of the model and one instance.
    pub initial: Ledger,
    /// What they hold on the device, in bytes.
    pub resident_bytes: u64,
    /// Distance by distance, the nearest first.
    pub steps: Vec<SchemeStep>,
}

/// A scheme that cannot show the tree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// The scheme.
    pub scheme: Scheme,
    /// What the device has against it.
    pub reason: String,
}

/// A scheme at one distance.
#[derive(Debug, Clone, PartialEq)]
pub struct SchemeStep {
    /// The pictures' side in pixels, of which the sphere around the leaves, or around the wood, takes 90 %.
    pub side: u32,
    /// How far along its own levels it is: 0 the finest, 1 the coarsest.
    pub level: f64,
    /// Leaves that show, none where cards stand for them; of wood its triangles and lines.
    pub shown: u64,
    /// The judge's measure: the mean over the pictures.
    pub error: f64,
    /// What going over to it from the distance before sent.
    pub change: Ledger,
    /// What drawing its [`COMPARE_VIEWS`] frames took, all together.
    pub frames: Ledger,
    /// The first of its pictures.
    pub shot: Shot,
}

/// Is shown pictures at full detail, and answers what tells how far others are from them.
pub type Judge<'j, E> = dyn Fn(&[Shot]) -> Result<Box<Verdict<E>>, E> + Sync + 'j;

/// The difference of pictures from those at full detail, in the judge's measure.
pub type Verdict<E> = dyn Fn(&[Shot]) -> Result<f64, E> + Send + Sync;

/// What every scheme comes to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Compared {
    /// The schemes that show the tree: leaves before wood, in the order in which they were asked for.
    pub found: Vec<SchemeFound>,
    /// Those that cannot.
    pub left_out: Vec<LeftOut>,
}

/// What is found of a scheme, or why it cannot show the tree.
type Outcome<T> = Result<T, String>;

/// Walks every scheme away, as many at a time as there are threads. Everything is of the world's first plant; of
/// a part that it does not have nothing is found.
///
/// # Errors
///
/// What the device refuses, unless it is that it cannot do what a scheme wants, and what `judge` answers.
pub fn compare<E: From<RunError> + Send>(
    world: &World,
    options: &CompareOptions,
    progress: &dyn Progress,
    judge: &Judge<'_, E>,
) -> Result<Compared, E> {
    let session = &options.looks.session;
    let leaves = Leaves::of(world, &options.leaves, session);
    let wood = Wood::of(world, &options.wood, session);
    let kinds = |part: Option<usize>| part.unwrap_or(0) as u64;
    let schemes = kinds(leaves.as_ref().map(|leaves| leaves.kinds().len()))
        + kinds(wood.as_ref().map(|wood| wood.kinds().len()));
    progress.begin("schemes", schemes);
    let (leaves, wood) = rayon::join(
        || part_outcomes(leaves.as_ref(), &options.looks, progress, judge),
        || part_outcomes(wood.as_ref(), &options.looks, progress, judge),
    );
    let mut compared = Compared::default();
    for (scheme, outcome) in leaves?.into_iter().chain(wood?) {
        match outcome {
            Ok(found) => compared.found.push(found),
            Err(reason) => compared.left_out.push(LeftOut { scheme, reason }),
        }
    }
    Ok(compared)
}

/// Walks the schemes of a part away, in their order.
fn part_outcomes<P: Part, E: From<RunError> + Send>(
    part: Option<&P>,
    options: &WalkAway,
    progress: &dyn Progress,
    judge: &Judge<'_, E>,
) -> Result<Vec<(Scheme, Outcome<SchemeFound>)>, E> {
    let Some(part) = part else {
        return Ok(Vec::new());
    };
    let walk = Walk::new(&part.full(), part.sphere(), options, judge)?;
    let mut alike: BTreeMap<P::Kind, Vec<P::Kind>> = BTreeMap::new();
    for &kind in part.kinds() {
        alike.entry(part.alike(kind)).or_default().push(kind);
    }
    let found = alike.par_iter().map(|(&alike, kinds)| {
        let outcomes = alike_outcomes(part, &walk, (alike, kinds), progress)?;
        Ok(kinds.iter().copied().zip(outcomes))
    });
    let found: Vec<_> = found.collect::<Result<_, E>>()?;
    let mut found: BTreeMap<P::Kind, _> = found.into_iter().flatten().collect();
    let kinds = part.kinds().iter();
    let taken = kinds.filter_map(|kind| Some((P::scheme(*kind), found.remove(kind)?)));
    Ok(taken.collect())
}

/// Looks for the levels of schemes that look alike by one of them, and measures each.
fn alike_outcomes<P: Part, E: From<RunError> + Send>(
    part: &P,
    walk: &Walk<'_, E>,
    (alike, kinds): (P::Kind, &[P::Kind]),
    progress: &dyn Progress,
) -> Result<Vec<Outcome<SchemeFound>>, E> {
    let subject = part.subject(alike);
    let levels = match part.last_step(alike) {
        None => Ok(walk.full_detail(&subject.finest)),
        Some(last) => match walk.studio_if_able(&subject)? {
            Ok(studio) => Ok(walk.choose(studio, last, &|step| part.state(alike, step))?),
            Err(reason) => Err(reason),
        },
    };
    let found = kinds.par_iter().map(|&kind| {
        let outcome = match levels.clone() {
            Ok(levels) => {
                let shown = |state: &P::State| part.shown(kind, state);
                let own = (kind != alike).then(|| part.subject(kind));
                let subject = own.as_ref().unwrap_or(&subject);
                walk.measure(P::scheme(kind), subject, levels, &shown)?
            }
            Err(reason) => Err(reason),
        };
        progress.step();
        Ok(outcome)
    });
    found.collect()
}

/// The coarsest of some uniform levels of a crown that is within the tolerance, picture side by picture side,
/// the largest first: the side, and which of them. `collapses` ascends from 0.
///
/// # Errors
///
/// What the device refuses, and what `judge` answers.
pub(super) fn coarsest_unseen<E: From<RunError>>(
    crown: &Arc<Crown>,
    collapses: &[u32],
    options: &WalkAway,
    judge: &Judge<'_, E>,
) -> Result<Vec<(u32, u32)>, E> {
    let subject = Subject::leaves(leaf_model(crown, &options.session));
    let walk = Walk::new(&subject, sphere_of(crown), options, judge)?;
    let last = index_u32(collapses.len().saturating_sub(1));
    let state = |step: u32| State::Uniform {
        collapses: collapses.get(step as usize).copied().unwrap_or(0),
    };
    let chosen = walk.choose(walk.studio(&subject)?, last, &state)?;
    let steps = chosen.iter().map(|chosen| chosen.step);
    Ok(walk.sides().zip(steps).collect())
}
