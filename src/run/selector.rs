//! From a scene's wishes to the state of each tree, frame after frame.
//!
//! ```text
//!  view ──wanted──▶ State ──settle──▶ State ──afforded──▶ State, and what was put off
//!                             ▲                   ▲
//!                             └── what stands ────┘
//! ```
//!
//! **Invariant.** What a choice remembers is what stands on the device, so a run that is continued
//! from its states chooses as one that was never stopped.

use super::world::{StandingTree, World};
use crate::math::whole_u32;
use crate::models::{
    Band, ByDistance, ByScreenError, BySilhouette, CardLevel, Criterion, Crown, Extent, Importance,
    Kind, Move, Painting, Resident, Sight, Spent, State, StrokeCut, gain, level, level_with,
    select, settle, spend, spread, within_pixels,
};
use crate::scene::{CriterionName, DetailKind, DetailRange, LeafAmount, ModelChoice, View};

/// Chooses the states of a scene's trees.
#[derive(Debug, Clone, Copy)]
pub(super) struct Selector {
    has_levels: bool,
    extent: Extent,
    model: ModelChoice,
}

/// How far from the first of two distances to the second the centre of a crown lies, in the world.
fn share_of(crown: &Crown, tree: &StandingTree, view: &View, range: DetailRange) -> f64 {
    let scale = tree.placement.scale;
    let [nearest, farthest] = [range.d_min() / scale, range.d_max() / scale].map(f64::from);
    let eye = tree.placement.to_plant(view.eye);
    let distance = f64::from(eye.distance(crown.center()));
    (distance - nearest) / (farthest - nearest)
}

/// States that changes of detail lead to within a budget of bytes.
#[derive(Debug)]
pub(super) struct Afforded {
    pub(super) states: Vec<State>,
    /// How many clusters, or trees that change as a whole, did not come as far as they should.
    pub(super) deferred: u64,
}

impl Selector {
    pub(super) fn new(kind: Kind, model: &ModelChoice) -> Self {
        Self {
            has_levels: kind.has_levels(),
            extent: match model.detail {
                DetailKind::Uniform => Extent::Uniform,
                DetailKind::Variable => Extent::Variable,
            },
            model: *model,
        }
    }

    /// What a view asks of a tree while `present` stands; `None` before anything does.
    pub(super) fn chosen(
        &self,
        crown: &Crown,
        tree: &StandingTree,
        view: &View,
        present: Option<&State>,
    ) -> State {
        let wanted = |demand| self.wanted(crown, tree, view, demand);
        let band = self.model.hysteresis;
        let present = match present {
            // A tree that comes near from afar shows what it should.
            Some(State::Cards(_)) | None => return wanted(0.0),
            Some(_) if band <= 0.0 => return wanted(0.0),
            Some(present) => present,
        };
        let band = match (self.model.amount, self.model.criterion, self.extent) {
            (Some(LeafAmount::PixelError(_)), _, _)
            | (None, CriterionName::Paper, _)
            | (None, _, Extent::Uniform) => Band::Between {
                finer: wanted(band),
                coarser: wanted(-band),
            },
            _ => Band::Share(band),
        };
        settle(crown, present, wanted(0.0), &band)
    }

    /// What a view asks of a tree, whatever stands.
    ///
    /// With another demand than 0 distances count as less by this share of the range in which detail
    /// falls, or errors as more by this share of themselves.
    fn wanted(&self, crown: &Crown, tree: &StandingTree, view: &View, demand: f32) -> State {
        let sequence = crown.sequence();
        match (self.has_levels, self.model.level, self.model.amount) {
            (false, _, _) => State::FINEST,
            (true, Some(fixed), _) => {
                let all = f64::from(sequence.collapse_count());
                State::Uniform {
                    collapses: whole_u32(f64::from(fixed) * all),
                }
            }
            (true, None, Some(LeafAmount::Budget(leaves))) => {
                self.budget(crown, leaves, tree, view)
            }
            (true, None, Some(LeafAmount::Share(share))) => {
                let leaves = f64::from(share) * f64::from(sequence.original_count());
                self.budget(crown, whole_u32(leaves), tree, view)
            }
            (true, None, Some(LeafAmount::PixelError(pixels))) => {
                let pixels = f64::from(pixels) / (1.0 + f64::from(demand));
                let sight = Sight::of(view, &tree.placement);
                within_pixels(crown, pixels, self.extent, &sight)
            }
            (true, None, None) => match (self.extent, self.model.criterion) {
                (Extent::Uniform, _) | (_, CriterionName::Paper) => {
                    self.by_distance(crown, tree, view, self.extent, demand)
                }
                // Distance says how many, the criterion where.
                (Extent::Variable, _) => {
                    let whole = self.by_distance(crown, tree, view, Extent::Uniform, demand);
                    let leaves = whole.leaf_count(crown.clusters());
                    self.budget(crown, leaves, tree, view)
                }
            },
        }
    }

    /// What a view asks of a tree that cards stand for while `present` stands: linear in the distance
    /// between the model's two, as detail of leaves is, or the fixed level.
    pub(super) fn cards(
        &self,
        crown: &Crown,
        tree: &StandingTree,
        view: &View,
        present: Option<&State>,
        levels: u32,
    ) -> CardLevel {
        if let Some(fixed) = self.model.level {
            return CardLevel::at_share(f64::from(fixed), levels);
        }
        self.card_level(
            share_of(crown, tree, view, self.model.range),
            present,
            levels,
        )
    }

    /// The same of a tree that cards stand for far away only; `None` where leaves show. Within the band of
    /// hysteresis beyond which they show, what stands stays.
    pub(super) fn far_cards(
        &self,
        crown: &Crown,
        tree: &StandingTree,
        view: &View,
        present: Option<&State>,
        (range, levels): (DetailRange, u32),
    ) -> Option<CardLevel> {
        let share = share_of(crown, tree, view, range);
        let stands = match present {
            Some(State::Cards(_)) => -f64::from(self.model.hysteresis),
            Some(_) => f64::from(self.model.hysteresis),
            None => 0.0,
        };
        (share > stands).then(|| self.card_level(share, present, levels))
    }

    fn card_level(&self, share: f64, present: Option<&State>, levels: u32) -> CardLevel {
        let band = f64::from(self.model.hysteresis);
        let [finer, wanted, coarser] =
            [-band, 0.0, band].map(|by| CardLevel::at_share(share + by, levels));
        match present {
            Some(State::Cards(level)) if (finer..=coarser).contains(level) => *level,
            _ => wanted,
        }
    }

    /// What a view asks of a tree that is painted while `present` stands: as many strokes as its distance
    /// wants, or the fixed level.
    pub(super) fn strokes(
        &self,
        painting: &Painting,
        tree: &StandingTree,
        view: &View,
        present: Option<&State>,
    ) -> StrokeCut {
        let sight = Sight::of(view, &tree.placement);
        let pixels = |distance: f32| sight.pixels_per_metre(distance);
        if let Some(fixed) = self.model.level {
            return painting.at_level(fixed, pixels);
        }
        // The wish is told in the world's metres, as the scene has them.
        let distance = sight.eye().distance(painting.center());
        let band = self.model.hysteresis;
        let [finer, wanted, coarser] =
            [1.0 - band, 1.0, 1.0 + band].map(|by| painting.at_distance(by * distance, pixels));
        let strokes = |cut: &StrokeCut| painting.counts(cut);
        match present {
            Some(State::Strokes(present)) if band > 0.0 => {
                let [most, found, least] = [&finer, present, &coarser].map(strokes);
                let is_between = (0..2).all(|of| least[of] <= found[of] && found[of] <= most[of]);
                if is_between { present.clone() } else { wanted }
            }
            _ => wanted,
        }
    }

    /// What a view asks of a tree at a step of the axis of detail.
    pub(super) fn at_step(
        &self,
        crown: &Crown,
        tree: &StandingTree,
        view: &View,
        [step, steps]: [u32; 2],
    ) -> State {
        match (self.has_levels, self.extent) {
            (false, _) => State::FINEST,
            (true, Extent::Uniform) => level(crown, step, steps),
            (true, Extent::Variable) => {
                let sight = Sight::of(view, &tree.placement);
                let importance = self.importance(crown, tree, &sight);
                level_with(crown, step, steps, &*importance, &sight)
            }
        }
    }

    /// The papers' law.
    fn by_distance(
        &self,
        crown: &Crown,
        tree: &StandingTree,
        view: &View,
        extent: Extent,
        demand: f32,
    ) -> State {
        let mut criterion = Criterion {
            extent,
            ..self.criterion(tree)
        };
        if demand != 0.0 {
            let nearer = demand * (criterion.farthest - criterion.nearest);
            criterion.nearest += nearer;
            criterion.farthest += nearer;
        }
        select(crown, criterion, tree.placement.to_plant(view.eye))
    }

    /// Distances are judged in the world: the plant's own space is scaled.
    fn criterion(&self, tree: &StandingTree) -> Criterion {
        Criterion {
            nearest: self.model.range.d_min() / tree.placement.scale,
            farthest: self.model.range.d_max() / tree.placement.scale,
            extent: self.extent,
        }
    }

    /// At least one leaf a cluster, at most all.
    fn budget(&self, crown: &Crown, leaves: u32, tree: &StandingTree, view: &View) -> State {
        match self.extent {
            Extent::Uniform => {
                let (most, least) = (
                    crown.sequence().original_count(),
                    crown.sequence().root_count(),
                );
                State::Uniform {
                    collapses: most - leaves.clamp(least, most),
                }
            }
            Extent::Variable => {
                let sight = Sight::of(view, &tree.placement);
                let importance = self.importance(crown, tree, &sight);
                spread(crown, leaves, &*importance, &sight)
            }
        }
    }

    fn importance(&self, crown: &Crown, tree: &StandingTree, sight: &Sight) -> Box<dyn Importance> {
        match self.model.criterion {
            CriterionName::Paper => {
                let criterion = self.criterion(tree);
                Box::new(ByDistance {
                    nearest: criterion.nearest,
                    farthest: criterion.farthest,
                })
            }
            CriterionName::Distance => Box::new(ByDistance::across(crown, sight.eye())),
            CriterionName::ScreenError => Box::new(ByScreenError),
            CriterionName::Silhouette => Box::new(BySilhouette),
        }
    }

    /// Which of the changes from what stands to `wanted` a frame can pay for; `None` where the scene
    /// has no budget of bytes.
    ///
    /// While changes are put off, a budget of leaves is not kept exactly: leaves mostly come before
    /// others go.
    pub(super) fn afforded(
        world: &World,
        residents: &[Box<dyn Resident>],
        wanted: &[State],
        view: &View,
        budget: u64,
    ) -> Afforded {
        let mut moves = Vec::new();
        for (number, (tree, resident)) in (0..).zip(world.trees.iter().zip(residents)) {
            let (crown, sight) = (&world.crowns[tree.crown], Sight::of(view, &tree.placement));
            moves_of(
                number,
                crown,
                &**resident,
                &wanted[number as usize],
                &sight,
                &mut moves,
            );
        }
        let spent = spend(budget, moves, |one, collapses| {
            let (tree, resident) = (one.tree as usize, &residents[one.tree as usize]);
            match (one.cluster, &wanted[tree]) {
                (Some(cluster), _) => resident
                    .cluster_price(cluster, collapses)
                    .expect("a cluster moves by itself only where its price stands for itself"),
                (None, State::Uniform { .. }) if is_uniform(resident.state()) => {
                    resident.price(&State::Uniform { collapses })
                }
                (None, _) => resident.price(&wanted[tree]),
            }
        });
        reached(residents, wanted, &spent)
    }
}

fn is_uniform(state: &State) -> bool {
    matches!(state, State::Uniform { .. })
}

fn is_whole(state: &State) -> bool {
    matches!(state, State::Cards(_) | State::Strokes(_))
}

/// The moves that lead a tree to what is wanted: of its clusters, where each has a price of its own;
/// along the sequence; else all or nothing, as from 0 to 1.
fn moves_of(
    tree: u32,
    crown: &Crown,
    resident: &dyn Resident,
    wanted: &State,
    sight: &Sight,
    moves: &mut Vec<Move>,
) {
    let whole = |from: u32, to: u32, gain: f64| Move {
        tree,
        cluster: None,
        from,
        to,
        gain,
    };
    let present = resident.state();
    if present == wanted {
        return;
    }
    if let (State::Uniform { collapses: from }, State::Uniform { collapses: to }) =
        (present, wanted)
    {
        let gain = gain(crown, &crown.bounds(), *from, *to, sight);
        moves.push(whole(*from, *to, gain));
        return;
    }
    // What shows as a whole changes as a whole.
    if is_whole(present) || is_whole(wanted) {
        moves.push(whole(0, 1, 1.0));
        return;
    }
    let clusters = crown.clusters();
    let counts = present
        .counts(clusters)
        .into_iter()
        .zip(wanted.counts(clusters));
    let changed = (0..).zip(counts).filter(|(_, (from, to))| from != to);
    let changed: Vec<Move> = changed
        .map(|(cluster, (from, to))| {
            let bounds = &crown.cluster_bounds()[cluster as usize];
            Move {
                cluster: Some(cluster),
                ..whole(from, to, gain(crown, bounds, from, to, sight))
            }
        })
        .collect();
    let separable = !is_uniform(present) && !is_uniform(wanted) && {
        let price = |one: &Move| one.cluster.and_then(|c| resident.cluster_price(c, one.to));
        changed.iter().all(|one| price(one).is_some())
    };
    if separable {
        moves.extend(changed);
    } else {
        moves.push(whole(0, 1, changed.iter().map(|one| one.gain).sum()));
    }
}

/// The states that moves came to.
fn reached(residents: &[Box<dyn Resident>], wanted: &[State], spent: &[Spent]) -> Afforded {
    let mut states: Vec<State> = residents.iter().map(|one| one.state().clone()).collect();
    let mut deferred = 0;
    for Spent { made, reached } in spent {
        deferred += u64::from(*reached != made.to);
        let (state, wanted) = (&mut states[made.tree as usize], &wanted[made.tree as usize]);
        match (made.cluster, &mut *state, wanted) {
            (Some(cluster), State::Variable { counts }, _) => counts[cluster as usize] = *reached,
            (None, State::Uniform { collapses }, State::Uniform { .. }) => *collapses = *reached,
            _ if *reached == made.to => *state = wanted.clone(),
            _ => {}
        }
    }
    Afforded { states, deferred }
}
