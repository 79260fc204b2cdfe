//! The commands of a frame.
//!
//! ```text
//! ground, trunks, leaves ─▶ [lines of forests, into targets of their own] ─▶ what is blended, from far to near
//! ```

use super::Session;
use crate::gpu::{Command, Load, RenderPass, Step};
use crate::models::frame_commands;

impl Session<'_> {
    /// The commands that draw all trees as they are committed.
    pub(in crate::run) fn commands(&self) -> Vec<Command> {
        self.assembled(self.pass(), self.blended())
    }

    /// What is opaque, then what is blended, behind passes of its own where it has some.
    pub(super) fn assembled(&self, pass: RenderPass, mut blended: Vec<Step>) -> Vec<Command> {
        let residents = self.residents.iter().map(|resident| &**resident);
        let passes = self
            .groves
            .iter()
            .flat_map(|grove| grove.line_passes(self.target));
        let passes: Vec<Command> = passes.collect();
        let later = match passes.is_empty() {
            true => Vec::new(),
            false => std::mem::take(&mut blended),
        };
        let mut commands = frame_commands(&self.environment, pass, blended, residents);
        if !later.is_empty() {
            commands.extend(passes);
            commands.push(Command::Render(RenderPass {
                label: "blended".to_owned(),
                target: self.target,
                load: Load::Keep,
                steps: later,
            }));
        }
        commands
    }

    /// The pass that draws all trees as they are committed, or as many as are drawn first.
    pub(super) fn pass(&self) -> RenderPass {
        let mut steps = Vec::new();
        if let Some(first) = self.residents.first() {
            first.draw_behind(&mut steps);
        }
        if let Some(ground) = &self.ground {
            ground.draw(&mut steps);
        }
        for (trunk, resident) in self.trunks.iter().zip(&self.residents) {
            if let Some(trunk) = trunk {
                trunk.draw(&mut steps);
            }
            // What is painted is blended.
            if !self.kind.paints() {
                resident.draw(&mut steps);
            }
        }
        for grove in &self.groves {
            grove.draw(&mut steps);
        }
        RenderPass {
            label: "frame".to_owned(),
            target: self.target,
            load: Load::Clear {
                color: self.background(),
                depth: 1.0,
            },
            steps,
        }
    }

    /// What is blended, the farthest tree first, of equals the first.
    pub(super) fn blended(&self) -> Vec<Step> {
        let mut steps = Vec::new();
        if !self.trunk.has_errors() && !self.kind.paints() {
            return steps;
        }
        for grove in &self.groves {
            grove.draw_lines(&mut steps);
        }
        let trees = self.world.trees.iter().enumerate();
        let mut far: Vec<(f32, usize)> = trees
            .map(|(number, tree)| {
                let center = self.world.crowns[tree.crown].plant().bounds().center();
                let center = tree.placement.to_world(center);
                (center.distance_squared(self.eye), number)
            })
            .collect();
        far.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, number) in far {
            if let Some(trunk) = &self.trunks[number] {
                trunk.draw_lines(&mut steps);
            }
            if self.kind.paints() {
                self.residents[number].draw(&mut steps);
            }
        }
        steps
    }
}
