//! Arithmetic of rules: parameters, conditions and random numbers.

use crate::math::{Draws, det};

/// An expression, as a program of a stack machine: operands before what is done with them.
#[derive(Debug, Clone)]
pub(super) struct Expression {
    pub(super) steps: Vec<Step>,
}

/// A step of a program.
#[derive(Debug, Clone, Copy)]
pub(super) enum Step {
    /// Puts a number on the stack.
    Number(f32),
    /// Puts a parameter of the rule on the stack.
    Parameter(usize),
    /// Changes the number on top.
    One(fn(f32) -> f32),
    /// Puts one number in place of two.
    Two(fn(f32, f32) -> f32),
    /// Puts a random number in place of two: uniform between them.
    Uniform,
    /// Puts a random number in place of two: normal, with mean and deviation.
    Normal,
}

/// Functions by name; angles are in degrees.
pub(super) fn function(name: &str) -> Option<(usize, Step)> {
    Some(match name {
        "rnd" => (2, Step::Uniform),
        "nrm" => (2, Step::Normal),
        "min" => (2, Step::Two(f32::min)),
        "max" => (2, Step::Two(f32::max)),
        "pow" => (2, Step::Two(det::pow)),
        "abs" => (1, Step::One(f32::abs)),
        "sqrt" => (1, Step::One(f32::sqrt)),
        "floor" => (1, Step::One(f32::floor)),
        "sin" => (1, Step::One(|angle| det::sin(angle.to_radians()))),
        "cos" => (1, Step::One(|angle| det::cos(angle.to_radians()))),
        _ => return None,
    })
}

/// Signs between two operands, by how strongly they bind; comparisons are 1 where they hold, else 0.
pub(super) fn operator(sign: &str) -> Option<(u8, Step)> {
    let truth = |strength, holds| Some((strength, Step::Two(holds)));
    match sign {
        "or" => truth(1, |a, b| number(a != 0.0 || b != 0.0)),
        "and" => truth(2, |a, b| number(a != 0.0 && b != 0.0)),
        "<" => truth(3, |a, b| number(a < b)),
        "<=" => truth(3, |a, b| number(a <= b)),
        ">" => truth(3, |a, b| number(a > b)),
        ">=" => truth(3, |a, b| number(a >= b)),
        "==" => truth(3, |a, b| number(a == b)),
        "!=" => truth(3, |a, b| number(a != b)),
        "+" => truth(4, |a, b| a + b),
        "-" => truth(4, |a, b| a - b),
        "*" => truth(5, |a, b| a * b),
        "/" => truth(5, |a, b| a / b),
        _ => None,
    }
}

pub(super) fn number(holds: bool) -> f32 {
    if holds { 1.0 } else { 0.0 }
}

impl Expression {
    /// The value, which may be no number; `draws` gives random numbers in the order in which they stand
    /// in the text.
    pub(super) fn value(&self, parameters: &[f32], draws: &mut Draws, stack: &mut Vec<f32>) -> f32 {
        stack.clear();
        for step in &self.steps {
            let value = match *step {
                Step::Number(number) => number,
                Step::Parameter(place) => parameters[place],
                Step::One(change) => change(top(stack)),
                Step::Two(join) => {
                    let second = top(stack);
                    join(top(stack), second)
                }
                Step::Uniform => {
                    let high = top(stack);
                    let low = top(stack);
                    low + (high - low) * draws.unit()
                }
                Step::Normal => {
                    let deviation = top(stack);
                    top(stack) + deviation * draws.normal()
                }
            };
            stack.push(value);
        }
        top(stack)
    }
}

fn top(stack: &mut Vec<f32>) -> f32 {
    stack
        .pop()
        .expect("the parser puts operands before what uses them")
}
