//! The commands of a frame: what residents prepare, the pass that draws them, and what that reveals.

use super::{Environment, Resident};
use crate::gpu::{Command, Load, RenderPass, Step};

/// The commands of a frame: those before `pass`, the light's pass where there are
/// [shadows](Environment::cast_shadows), the pass itself, which draws all `residents` and
/// whatever else there is, and those after it, for residents that draw first what was seen last. What
/// is blended comes after all of them, in the order of `blended`, and not into the light's pass.
pub fn frame_commands<'r, S: 'r>(
    environment: &Environment,
    mut pass: RenderPass,
    blended: Vec<Step>,
    residents: impl Iterator<Item = &'r dyn Resident<S>> + Clone,
) -> Vec<Command> {
    let mut commands = Vec::new();
    for resident in residents.clone() {
        resident.prepare(&mut commands);
    }
    let target = pass.target;
    commands.extend(environment.shadow_pass(&pass).map(Command::Render));
    let (mut reveal, mut steps) = (Vec::new(), Vec::new());
    for resident in residents {
        resident.reveal(&mut reveal);
        resident.draw_revealed(&mut steps);
    }
    if reveal.is_empty() {
        pass.steps.extend(blended);
        commands.push(Command::Render(pass));
        return commands;
    }
    commands.push(Command::Render(pass));
    steps.extend(blended);
    commands.extend(environment.pyramid_pass().map(Command::Compute));
    commands.append(&mut reveal);
    commands.push(Command::Render(RenderPass {
        label: "revealed".to_owned(),
        target,
        load: Load::Keep,
        steps,
    }));
    commands
}
