//! Rewriting: rules applied from the axiom on, depth first, while the turtle draws.

use super::turtle::{Turn, Turtle};
use super::{Command, Item, RlSystem, Rule};
use crate::document::DocumentError;
use crate::limits;
use crate::math::Stream;

/// A successor that is being gone through.
struct Frame<'a> {
    items: &'a [Item],
    next: usize,
    parameters: Vec<f32>,
    stream: Stream,
    /// How many rewritings led here.
    depth: u32,
}

/// Grows a system: no string is kept, only the successors that lead to the module that is rewritten, at
/// most one for each step.
///
/// Every module has a stream of random numbers of its own, a child of that of the module it comes from,
/// by its place in the successor: `2 i` gives the numbers in its parentheses, `2 i + 1` its own. So what
/// one module draws shifts no other's numbers.
pub(super) fn derive(system: &RlSystem, stream: Stream) -> Result<Turtle, DocumentError> {
    let mut turtle = Turtle::new();
    let mut work = 0_u64;
    let mut stack = Vec::new();
    let mut frames = vec![Frame {
        items: &system.axiom,
        next: 0,
        parameters: Vec::new(),
        stream,
        depth: 0,
    }];
    while let Some(frame) = frames.last_mut() {
        let Some(item) = frame.items.get(frame.next) else {
            frames.pop();
            continue;
        };
        let place = frame.next as u64;
        frame.next += 1;
        let mut draws = frame.stream.child(2 * place).draws();
        let arguments: Vec<f32> = item
            .arguments
            .iter()
            .map(|argument| argument.value(&frame.parameters, &mut draws, &mut stack))
            .collect();
        work += 1 + item.cost();
        let mut chosen = None;
        let stream = frame.stream.child(2 * place + 1);
        let depth = frame.depth;
        if let Some(module) = item.module
            && depth < system.steps
        {
            let rules = &system.rules[module as usize];
            work += rules.iter().map(Rule::cost).sum::<u64>();
            chosen = choose(rules, &arguments, stream, &mut stack);
        }
        if work > limits::RL_WORK {
            let limit = limits::RL_WORK;
            let message = format!(
                "growth takes more than {limit} steps of work; fewer steps, or a condition, end it"
            );
            return Err(system.document.error(item.offset, message));
        }
        match chosen {
            Some(rule) => frames.push(Frame {
                items: &rule.successor,
                next: 0,
                parameters: arguments,
                stream,
                depth: depth + 1,
            }),
            None => obey(&mut turtle, item.command, &arguments)
                .map_err(|message| system.document.error(item.offset, message))?,
        }
    }
    Ok(turtle)
}

/// The rule that rewrites a module: of those whose condition holds one by weight, if there is any.
fn choose<'a>(
    rules: &'a [Rule],
    arguments: &[f32],
    stream: Stream,
    stack: &mut Vec<f32>,
) -> Option<&'a Rule> {
    let mut holds = |(number, rule): (u64, &Rule)| match &rule.condition {
        None => true,
        Some(condition) => {
            // Numbers of successors count from 0 up, those of conditions from the end down.
            let mut draws = stream.child(u64::MAX - number).draws();
            let value = condition.value(arguments, &mut draws, stack);
            value != 0.0 && !value.is_nan()
        }
    };
    let applicable: Vec<&Rule> = (0_u64..)
        .zip(rules)
        .filter(|(number, rule)| holds((*number, rule)))
        .map(|(_, rule)| rule)
        .collect();
    let total = applicable.iter().fold(0.0, |sum, rule| sum + rule.weight);
    let mut drawn = total * stream.unit(0);
    for &rule in &applicable {
        if drawn < rule.weight {
            return Some(rule);
        }
        drawn -= rule.weight;
    }
    // Rounding may leave a last bit over.
    applicable
        .iter()
        .rev()
        .find(|rule| rule.weight > 0.0)
        .copied()
}

fn obey(turtle: &mut Turtle, command: Command, arguments: &[f32]) -> Result<(), String> {
    match (command, arguments) {
        (Command::Draw, [length]) => turtle.draw(*length, None),
        (Command::Draw, [length, radius]) => turtle.draw(*length, Some(*radius)),
        (Command::Walk, [length]) => turtle.walk(*length),
        (Command::Radius, [radius]) => turtle.set_radius(*radius),
        (Command::Place(object), [size]) => turtle.place(object, *size),
        (Command::Turn(turn), [degrees]) => {
            if !degrees.is_finite() || degrees.abs() > 1e6 {
                return Err(format!(
                    "a turn by {degrees} degrees, wanted a number up to a million"
                ));
            }
            turtle.turn(turn, *degrees);
            Ok(())
        }
        (Command::About, _) => {
            turtle.turn(Turn::Left, 180.0);
            Ok(())
        }
        (Command::Level, _) => {
            turtle.level();
            Ok(())
        }
        (Command::Push, _) => turtle.push(),
        (Command::Pop, _) => {
            turtle.pop();
            Ok(())
        }
        // A module that is not rewritten any more.
        _ => Ok(()),
    }
}
