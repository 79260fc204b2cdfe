//! From a frame's number to the detail of every tree: what is wanted, what is afforded, what is sent.

use super::Session;
use crate::math::{index_u32, whole_u32};
use crate::models::{
    Camera, CardLevel, Criterion, Crown, Extent, Kind, Sight, State, TreeChange, TreeState, Trunk,
    TrunkLevel,
};
use crate::run::RunError;
use crate::run::selector::Selector;
use crate::run::world::StandingTree;
use crate::scene::{self, ModelChoice};

impl Session<'_> {
    /// The state of every tree at a frame, from what stands: the first is chosen freely, and what a
    /// scene's band of hysteresis holds back stays. A budget of bytes is not looked at.
    #[must_use]
    pub fn select(&self, frame: u32) -> Vec<TreeState> {
        self.selected(frame, &self.selector, &self.scene.model)
    }

    /// The state of every tree at a level from 0, full detail, to 1, the coarsest: as at a frame of a scene
    /// that fixes `model.level` and `model.trunk_level` there. What stands changes nothing.
    #[must_use]
    pub fn at_level(&self, frame: u32, level: f32) -> Vec<TreeState> {
        let model = ModelChoice {
            level: Some(level),
            trunk_level: Some(level),
            ..self.scene.model
        };
        self.selected(frame, &Selector::new(Kind::LodfHost, &model), &model)
    }

    fn selected(&self, frame: u32, selector: &Selector, model: &ModelChoice) -> Vec<TreeState> {
        let view = self.scene.camera.at(frame, self.size);
        let state = |(number, tree): (usize, &StandingTree)| {
            let crown = &self.world.crowns[tree.crown];
            let all = crown.sequence().collapse_count();
            let present = self.residents.get(number).map(|resident| resident.state());
            // What foliage with levels shows, and how far the trunk goes with it.
            let axis = selector.chosen(crown, tree, &view, present);
            let far = self.far_cards(selector, crown, tree, &view, present);
            let trunk = self.world.trunks[tree.crown].as_ref();
            let trunk = trunk.filter(|_| self.trunk.has_levels() && !self.paints_trunk(tree.crown));
            TreeState {
                trunk: trunk.map_or(TrunkLevel::FINEST, |trunk| match model.trunk_level {
                    Some(level) if self.trunk.has_errors() => {
                        const PARTS: u32 = 1 << 16;
                        self.trunk.level(trunk, share_of(level, PARTS), PARTS)
                    }
                    Some(level) => {
                        let all = trunk.collapses().collapse_count();
                        TrunkLevel::Collapses(share_of(level, all))
                    }
                    None if self.trunk.has_errors() => {
                        branch_level(&self.scene.branches, trunk, tree, &view)
                    }
                    None if far.is_some() => trunk.level(all, all),
                    None => trunk.level(axis.collapse_count(), all),
                }),
                foliage: match (self.kind.shows_leaves(), self.kind.has_levels()) {
                    (true, _) if far.is_some() => far.map_or(State::FINEST, State::Cards),
                    (true, true) => axis,
                    (true, false) => State::FINEST,
                    (false, _) => match &self.paintings[tree.crown] {
                        Some(painting) => {
                            let cut = selector.strokes(painting, tree, &view, present);
                            State::Strokes(cut)
                        }
                        None => {
                            let levels = self.card_levels;
                            let level = selector.cards(crown, tree, &view, present, levels);
                            State::Cards(level)
                        }
                    },
                },
            }
        };
        self.world.trees.iter().enumerate().map(state).collect()
    }

    /// The level of the cards that stand for a tree's leaves far away; `None` where leaves show.
    fn far_cards(
        &self,
        selector: &Selector,
        crown: &Crown,
        tree: &StandingTree,
        view: &scene::View,
        present: Option<&State>,
    ) -> Option<CardLevel> {
        let far = self.scene.cards.far.filter(|_| self.kind.shows_leaves())?;
        let levels = index_u32(self.scene.cards.levels.as_slice().len());
        selector.far_cards(crown, tree, view, present, (far.range, levels))
    }

    /// Goes over to the detail of a frame, as far as the scene's budget of bytes allows; what it
    /// costs is counted with the next frame drawn, or dropped by [`skip`](Self::skip).
    ///
    /// # Errors
    ///
    /// None on this session's own device.
    pub fn commit(&mut self, frame: u32) -> Result<TreeChange, RunError> {
        let mut states = self.select(frame);
        if let Some(camera) = self.selecting_camera(frame) {
            return self.follow(camera, &states);
        }
        if let Some(budget) = self.scene.model.budget_bytes {
            let view = self.scene.camera.at(frame, self.size);
            self.deferred = Some(self.afford(&mut states, budget, &view));
        }
        self.commit_states(&states)
    }

    /// Sends the camera, by which the device goes over to these states of foliage itself; trunks are
    /// sent theirs.
    fn follow(&mut self, camera: Camera, states: &[TreeState]) -> Result<TreeChange, RunError> {
        let mut queue = self.device.queue();
        if self.camera != Some(camera) {
            self.environment.set_camera(&mut queue, &camera)?;
            self.camera = Some(camera);
        }
        let mut change = TreeChange::default();
        let residents = self.trunks.iter_mut().zip(&mut self.residents);
        for ((trunk, resident), state) in residents.zip(states) {
            if let Some(trunk) = trunk {
                change.trunk.add(&trunk.commit(&mut queue, &state.trunk)?);
            }
            change
                .foliage
                .add(&resident.follow(&mut queue, &state.foliage)?);
        }
        Ok(change)
    }

    /// The camera of a frame, where the device selects by it: by the papers' criterion, which
    /// [`select`](Self::select) follows too. What a scene dictates, spreads, holds back or bounds
    /// otherwise is chosen on the host.
    pub(super) fn selecting_camera(&self, frame: u32) -> Option<Camera> {
        let model = &self.scene.model;
        let by_distance = model.level.is_none() && model.amount.is_none();
        let at_once = model.hysteresis == 0.0 && model.budget_bytes.is_none();
        let follows = self.environment.has_camera()
            && model.criterion == scene::CriterionName::Paper
            && by_distance
            && at_once;
        follows.then(|| Camera {
            eye: self.scene.camera.at(frame, self.size).eye,
            criterion: Criterion {
                nearest: model.range.d_min(),
                farthest: model.range.d_max(),
                extent: match model.detail {
                    scene::DetailKind::Uniform => Extent::Uniform,
                    scene::DetailKind::Variable => Extent::Variable,
                },
            },
        })
    }

    /// Takes back what a budget of bytes does not allow; returns how many clusters, trunks, or trees
    /// that change as a whole, are held back. Trunks go first, tree by tree, since they cost little;
    /// what they leave is spent where the picture gains most.
    fn afford(&self, states: &mut [TreeState], budget: u64, view: &scene::View) -> u64 {
        let (mut left, mut deferred) = (budget, 0);
        for (trunk, state) in self.trunks.iter().zip(&mut *states) {
            let Some(trunk) = trunk else {
                continue;
            };
            match left.checked_sub(trunk.price(&state.trunk)) {
                Some(rest) => left = rest,
                None => {
                    state.trunk = *trunk.state();
                    deferred += 1;
                }
            }
        }
        let wanted: Vec<State> = states.iter().map(|state| state.foliage.clone()).collect();
        let afforded = Selector::afforded(self.world, &self.residents, &wanted, view, left);
        for (state, foliage) in states.iter_mut().zip(afforded.states) {
            state.foliage = foliage;
        }
        deferred + afforded.deferred
    }

    /// Goes over to given states, one a tree.
    ///
    /// # Errors
    ///
    /// None on this session's own device.
    pub fn commit_states(&mut self, states: &[TreeState]) -> Result<TreeChange, RunError> {
        let mut change = TreeChange::default();
        let residents = self.trunks.iter_mut().zip(&mut self.residents);
        for ((trunk, resident), state) in residents.zip(states) {
            if let Some(trunk) = trunk {
                let of_trunk = trunk.commit(&mut self.device.queue(), &state.trunk)?;
                change.trunk.add(&of_trunk);
            }
            let of_foliage = resident.commit(&mut self.device.queue(), &state.foliage)?;
            change.foliage.add(&of_foliage);
        }
        Ok(change)
    }
}

/// The level whose error a scene fixes, or that looks so large at the nearest point of a tree.
fn branch_level(
    choice: &scene::BranchChoice,
    trunk: &Trunk,
    tree: &StandingTree,
    view: &scene::View,
) -> TrunkLevel {
    let error = choice.error.unwrap_or_else(|| {
        let sight = Sight::of(view, &tree.placement);
        let pixels = sight.pixels_per_metre_at(&trunk.branches().bounds());
        error_of(f64::from(choice.pixel_error) / pixels)
    });
    TrunkLevel::Error(trunk.branch_choice().step(error))
}

/// Rounded once; whatever is no error is none.
#[expect(clippy::cast_possible_truncation, reason = "an error, rounded once")]
fn error_of(metres: f64) -> f32 {
    if metres.is_finite() {
        metres as f32
    } else {
        0.0
    }
}

/// How many collapses stand at a level from 0 to 1.
fn share_of(level: f32, all: u32) -> u32 {
    whole_u32(f64::from(level) * f64::from(all))
}
