//! The turtle: where rules draw, and the branches it has drawn.

use super::object::PlacedObject;
use crate::limits;
use crate::math::Vec3;
use crate::plant::weber_penn::frame::Frame;
use crate::plant::{Branch, NO_BRANCH, Node, Skeleton};

/// Coordinates beyond this, in metres, are refused: an `f32` there is no finer than a decimetre.
const FURTHEST: f32 = 1e6;

/// A turtle that walks, and remembers where it was.
#[derive(Debug)]
pub(super) struct Turtle {
    here: State,
    before: Vec<State>,
    branches: Vec<Drawn>,
    nodes: usize,
    pub(super) placed: Vec<PlacedObject>,
}

/// Where the turtle is.
#[derive(Debug, Clone, Copy)]
struct State {
    position: Vec3,
    frame: Frame,
    radius: f32,
    /// The branch drawn last from here back, and which of its nodes.
    at: Option<(u32, u32)>,
    /// Whether the next piece goes on with that branch.
    goes_on: bool,
}

/// A branch as it is drawn.
#[derive(Debug)]
struct Drawn {
    bearer: Option<(u32, u32)>,
    level: u32,
    nodes: Vec<Node>,
}

/// How the turtle turns; angles in degrees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Turn {
    Left,
    Right,
    Down,
    Up,
    RollLeft,
    RollRight,
    Lift,
}

impl Turtle {
    pub(super) fn new() -> Self {
        Self {
            here: State {
                position: Vec3::ZERO,
                frame: Frame::UPRIGHT,
                radius: 0.05,
                at: None,
                goes_on: false,
            },
            before: Vec::new(),
            branches: Vec::new(),
            nodes: 0,
            placed: Vec::new(),
        }
    }

    pub(super) fn turn(&mut self, turn: Turn, degrees: f32) {
        let frame = self.here.frame;
        self.here.frame = match turn {
            Turn::Left => frame.yaw(-degrees),
            Turn::Right => frame.yaw(degrees),
            Turn::Down => frame.pitch(-degrees),
            Turn::Up => frame.pitch(degrees),
            Turn::RollLeft => frame.roll(-degrees),
            Turn::RollRight => frame.roll(degrees),
            Turn::Lift => frame.lift(degrees),
        };
    }

    /// Rolls until its side is level; a vertical turtle stays.
    pub(super) fn level(&mut self) {
        let heading = self.here.frame.heading;
        let side = heading.cross(Vec3::Y);
        if side.length() > 1e-4 {
            self.here.frame = Frame {
                side: side.normalize_or(Vec3::X),
                heading,
            };
        }
    }

    /// The radius of the wood from here on, at least 0.
    pub(super) fn set_radius(&mut self, radius: f32) -> Result<(), String> {
        if !(0.0..=FURTHEST).contains(&radius) {
            return Err(format!("a radius of {radius}, wanted 0 to {FURTHEST}"));
        }
        self.here.radius = radius;
        Ok(())
    }

    /// Begins a branch: what is drawn until [`Self::pop`] is one level higher.
    pub(super) fn push(&mut self) -> Result<(), String> {
        let (found, limit) = (self.before.len() + 1, limits::RL_DEPTH);
        if found > limit {
            return Err(format!("{found} open brackets exceed the limit of {limit}"));
        }
        self.before.push(self.here);
        self.here.goes_on = false;
        Ok(())
    }

    /// Returns to where the branch began.
    pub(super) fn pop(&mut self) {
        self.here = self.before.pop().expect("the parser pairs brackets");
    }

    /// Walks without drawing: what is drawn next is another branch.
    pub(super) fn walk(&mut self, length: f32) -> Result<(), String> {
        let to = self.here.position + length * self.here.frame.heading;
        let is_near = to.is_finite() && to.abs().max_element() <= FURTHEST;
        if !is_near || !length.is_finite() {
            return Err(format!(
                "a step of {length} to {to}, wanted within {FURTHEST} m"
            ));
        }
        self.here.position = to;
        self.here.goes_on = false;
        Ok(())
    }

    /// Draws wood: a node at its end, and where a branch begins, one here.
    pub(super) fn draw(&mut self, length: f32, radius: Option<f32>) -> Result<(), String> {
        let from = self.node();
        let goes_on = self.here.goes_on;
        self.walk(length)?;
        if let Some(radius) = radius {
            self.set_radius(radius)?;
        }
        let to = self.node();
        match self.here.at {
            Some((branch, _)) if goes_on => {
                self.count_nodes(1)?;
                let nodes = &mut self.branches[branch as usize].nodes;
                self.here.at = Some((branch, counted(nodes.len())?));
                nodes.push(to);
            }
            bearer => {
                self.count_nodes(2)?;
                let branch = counted(self.branches.len())?;
                if self.branches.len() >= limits::GROWN_BRANCHES {
                    return Err(format!(
                        "more than {} branches; fewer steps, or a condition, end growth",
                        limits::GROWN_BRANCHES
                    ));
                }
                let level = match bearer {
                    None => 0,
                    Some((bearer, _)) => self.branches[bearer as usize].level + 1,
                };
                self.branches.push(Drawn {
                    bearer,
                    level,
                    nodes: vec![from, to],
                });
                self.here.at = Some((branch, 1));
            }
        }
        self.here.goes_on = true;
        Ok(())
    }

    /// Puts an organ here.
    pub(super) fn place(&mut self, object: u32, size: f32) -> Result<(), String> {
        if !(size > 0.0 && size <= FURTHEST) {
            return Err(format!(
                "a size of {size}, wanted above 0, at most {FURTHEST} m"
            ));
        }
        if self.placed.len() >= limits::GROWN_LEAVES {
            return Err(format!(
                "more than {} leaves, flowers and fruit; fewer steps, or a condition, end growth",
                limits::GROWN_LEAVES
            ));
        }
        self.placed.push(PlacedObject {
            object,
            branch: self.here.at.map_or(NO_BRANCH, |(branch, _)| branch),
            base: self.here.position,
            side: self.here.frame.side,
            heading: self.here.frame.heading,
            size,
        });
        Ok(())
    }

    /// All branches, bearers first: in the order in which they were begun.
    pub(super) fn skeleton(self) -> (Skeleton, Vec<PlacedObject>) {
        let mut skeleton = Skeleton::default();
        for drawn in self.branches {
            let bearer = drawn.bearer.map(|(branch, node)| {
                let bearer: &Branch = &skeleton.branches[branch as usize];
                bearer.first_node + node
            });
            skeleton.branches.push(Branch {
                bearer,
                level: drawn.level,
                first_node: crate::math::index_u32(skeleton.nodes.len()),
                node_count: crate::math::index_u32(drawn.nodes.len()),
            });
            skeleton.nodes.extend(drawn.nodes);
        }
        (skeleton, self.placed)
    }

    fn node(&self) -> Node {
        Node {
            position: self.here.position,
            radius: self.here.radius,
        }
    }

    fn count_nodes(&mut self, more: usize) -> Result<(), String> {
        self.nodes += more;
        if self.nodes > limits::GROWN_NODES {
            return Err(format!(
                "more than {} nodes; fewer steps, or a condition, end growth",
                limits::GROWN_NODES
            ));
        }
        Ok(())
    }
}

fn counted(length: usize) -> Result<u32, String> {
    u32::try_from(length).map_err(|error| format!("{length} are too many: {error}"))
}
