//! Random parametric L-systems ([CQHCVL06](crate::references), sections 2 and 3): plants from rules.
//!
//! ```text
//!               tokens, programs            depth first              instantiation
//! species.rls ──────────────────▶ RlSystem ─────────────▶ turtle ──────────────────▶ Growth
//!                                   seed       branches, organs     Plant: skeleton, trunk, foliage
//!                                                                   placed organs: geometry, strokes
//! ```
//!
//! Rewriting is not done on a string: a module is rewritten when the turtle comes to it, so memory is
//! bounded by the number of steps, and what grows by [`limits`](crate::limits).
//!
#![doc = include_str!("grammar.md")]

mod derive;
mod expression;
mod lexer;
mod object;
mod read;
#[cfg(test)]
mod tests;
mod turtle;
mod words;

use expression::Expression;
pub use object::{Object, ObjectForm, PlacedObject};
use turtle::Turn;

use super::texture::linear_of_srgb;
use super::tube::{Tubes, trunk_mesh};
use super::{Foliage, GrowError, Material, Plant, Stroke};
use crate::document::{Document, DocumentError};
use crate::math::Stream;

/// The schema that a grammar names.
pub const RLS_SCHEMA: &str = "spinney.rls/1";

/// The stream of random numbers of L-systems; that of other species is 0.
const STREAM: u64 = 0x524c_5359;

/// A random parametric L-system, read and checked.
#[derive(Debug, Clone)]
pub struct RlSystem {
    document: Document,
    name: String,
    latin: String,
    stop_leaves: Option<u32>,
    steps: u32,
    bark: [u8; 3],
    edges: [u32; 4],
    objects: Vec<Object>,
    axiom: Vec<Item>,
    /// By module.
    rules: Vec<Vec<Rule>>,
}

/// What an L-system has grown into.
#[derive(Debug, Clone, PartialEq)]
pub struct Growth {
    /// Skeleton, trunk mesh and foliage; what bears fruit or flowers has them among its foliage.
    pub plant: Plant,
    /// Every organ, in the order in which the turtle came to them.
    pub placed: Vec<PlacedObject>,
}

/// One way to rewrite a module.
#[derive(Debug, Clone)]
struct Rule {
    condition: Option<Expression>,
    weight: f32,
    successor: Vec<Item>,
}

/// A module or command of a successor.
#[derive(Debug, Clone)]
struct Item {
    /// The rules that may rewrite it.
    module: Option<u32>,
    /// What the turtle does when none does.
    command: Command,
    arguments: Vec<Expression>,
    offset: usize,
}

/// What the turtle does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Command {
    Nothing,
    Draw,
    Walk,
    Radius,
    Turn(Turn),
    About,
    Level,
    Push,
    Pop,
    Place(u32),
}

impl RlSystem {
    /// What a grammar may say, in Markdown.
    pub const HELP: &'static str = include_str!("grammar.md");

    /// The system that a document describes.
    ///
    /// # Errors
    ///
    /// What is wrong at which line and column, and what would be right.
    pub fn parse(document: &Document) -> Result<Self, DocumentError> {
        read::parse(document)
    }

    /// What people call the plant.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The botanical name; may be empty.
    #[must_use]
    pub fn latin(&self) -> &str {
        &self.latin
    }

    /// How many leaves remain after all collapses, where the file says so.
    #[must_use]
    pub fn stop_leaves(&self) -> Option<u32> {
        self.stop_leaves
    }

    /// The kinds of organs that rules instantiate.
    #[must_use]
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Grows the plant that a seed names; the same on every machine.
    ///
    /// # Errors
    ///
    /// When it would grow too large, or a rule asks for a length, radius or size that is none, with the
    /// place in the grammar.
    pub fn grow(&self, seed: u64) -> Result<Growth, GrowError> {
        let turtle = derive::derive(self, Stream::new(seed, STREAM)).map_err(GrowError::Rule)?;
        let (skeleton, placed) = turtle.skeleton();
        let objects = self.objects.iter().enumerate();
        let groups = objects
            .map(|(number, object)| object.group(number, &placed))
            .filter(|group| group.leaf_count() > 0)
            .collect();
        let tubes = Tubes {
            edges: self.edges,
            polygons: None,
            lobes: 0,
            lobe_depth: 0.0,
        };
        let bark = Material::plain("bark", self.bark.map(linear_of_srgb));
        let trunk = trunk_mesh(&skeleton, &tubes, bark)?;
        let trunk = (!trunk.indices.is_empty()).then_some(trunk);
        let skeleton = (!skeleton.branches.is_empty()).then_some(skeleton);
        let plant = Plant::new(self.name.clone(), skeleton, trunk, Foliage { groups })?;
        Ok(Growth { plant, placed })
    }

    /// The strokes of all organs of a growth of this system, organ by organ.
    pub fn strokes<'a>(&'a self, growth: &'a Growth) -> impl Iterator<Item = Stroke> + 'a {
        let clouds: Vec<Vec<Stroke>> = self.objects.iter().map(Object::strokes).collect();
        growth.placed.iter().flat_map(move |placed| {
            let cloud = clouds.get(placed.object as usize).into_iter().flatten();
            cloud
                .map(|stroke| placed.stroke(*stroke))
                .collect::<Vec<_>>()
        })
    }
}

impl Item {
    /// How much work its arguments are.
    fn cost(&self) -> u64 {
        self.arguments
            .iter()
            .map(|argument| argument.steps.len() as u64)
            .sum()
    }
}

impl Rule {
    /// How much work its condition is.
    fn cost(&self) -> u64 {
        1 + self
            .condition
            .as_ref()
            .map_or(0, |condition| condition.steps.len() as u64)
    }
}
