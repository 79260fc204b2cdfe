//! Cases in the order of their size: the first that fails is a smallest one.

use std::sync::Arc;

use super::super::{History, Operation, Walk};
use crate::math::{Stream, Vec3, index_u32, index_usize};
use crate::models::{Crown, State};
use crate::plant::{Foliage, LeafGroup, Material, NO_BRANCH, Plant, Prototype, Texture};

/// How far all cases are tried; beyond, some by seed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    /// Steps of the longest walk, by the number of leaves from 2 on.
    pub(super) steps: &'static [usize],
    /// Whether single collapses and splits are steps of their own.
    pub(super) single_steps: SingleSteps,
    /// Seeded walks through larger histories.
    pub(super) seeded: u64,
}

/// Whether steps are also given as collapse and split.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SingleSteps {
    /// States, collapses and splits.
    Too,
    /// States only: a device model knows no others.
    No,
}

/// Calls `visit` with every case, by leaves, collapses, and steps, until it returns a value.
pub(super) fn first<T>(extent: Extent, mut visit: impl FnMut(&Walk) -> Option<T>) -> Option<T> {
    for (leaves, &steps) in (2..).zip(extent.steps) {
        for collapses in 0..leaves {
            for steps in 0..=steps {
                let mut ops = Vec::new();
                let mut found = None;
                histories(leaves, collapses, &mut ops, &mut |history| {
                    let mut walk = Walk {
                        history: history.clone(),
                        operations: Vec::new(),
                    };
                    let alphabet = alphabet(history, extent.single_steps);
                    found = walks(&mut walk, &State::FINEST, steps, &alphabet, &mut visit);
                    found.is_some()
                });
                if found.is_some() {
                    return found;
                }
            }
        }
    }
    (0..extent.seeded).find_map(|seed| visit(&seeded(seed, extent.single_steps)))
}

/// Every history of so many collapses, each pair both ways round; until `visit` returns `true`.
fn histories(
    leaves: u32,
    collapses: u32,
    ops: &mut Vec<[u32; 2]>,
    visit: &mut impl FnMut(&History) -> bool,
) -> bool {
    if ops.len() == collapses as usize {
        let history = History::new(leaves, ops).expect("only visible leaves are paired");
        return visit(&history);
    }
    let born = leaves + index_u32(ops.len());
    let gone: Vec<u32> = ops.iter().flatten().copied().collect();
    let left: Vec<u32> = (0..born).filter(|leaf| !gone.contains(leaf)).collect();
    for &first in &left {
        for &second in left.iter().filter(|&&leaf| leaf != first) {
            ops.push([first, second]);
            let stop = histories(leaves, collapses, ops, visit);
            ops.pop();
            if stop {
                return true;
            }
        }
    }
    false
}

/// Every step that there is.
fn alphabet(history: &History, single: SingleSteps) -> Vec<Operation> {
    let mut alphabet = Operation::every(history);
    if single == SingleSteps::No {
        alphabet.retain(|step| matches!(step, Operation::To(_)));
    }
    alphabet
}

/// Every walk of so many further steps, each of which can be taken and leads elsewhere.
fn walks<T>(
    walk: &mut Walk,
    state: &State,
    steps: usize,
    alphabet: &[Operation],
    visit: &mut impl FnMut(&Walk) -> Option<T>,
) -> Option<T> {
    if steps == 0 {
        return visit(walk);
    }
    for operation in alphabet {
        let target = operation.target(&walk.history, state);
        let Some(target) = target.filter(|target| target != state) else {
            continue;
        };
        walk.operations.push(operation.clone());
        let found = walks(walk, &target, steps - 1, alphabet, visit);
        walk.operations.pop();
        if found.is_some() {
            return found;
        }
    }
    None
}

/// A walk of eight steps through a history of five to twelve leaves.
fn seeded(seed: u64, single: SingleSteps) -> Walk {
    let mut draws = Stream::new(seed, 0).draws();
    let mut below = |bound: usize| index_usize(draws.below(bound as u64));
    let leaves = index_u32(5 + below(8));
    let mut left: Vec<u32> = (0..leaves).collect();
    let mut ops = Vec::new();
    for op in 0..below(leaves as usize) {
        let first = left.swap_remove(below(left.len()));
        let second = left.swap_remove(below(left.len()));
        ops.push([first, second]);
        left.push(leaves + index_u32(op));
    }
    let history = History::new(leaves, &ops).expect("only visible leaves are paired");
    let steps = alphabet(&history, single);
    let operations = (0..8).map(|_| steps[below(steps.len())].clone());
    Walk {
        operations: operations.collect(),
        history,
    }
}

/// Leaves in one plane, each a step beside the last, so that they overlap at equal depth; the image
/// on them has another colour in each corner.
pub(super) fn flat_crown(history: &History) -> Arc<Crown> {
    let mut positions = Vec::new();
    for leaf in 0..history.leaf_count() {
        let step = f32::from(u16::try_from(leaf).unwrap_or(u16::MAX));
        let center = Vec3::new(0.21 * step - 0.5, 0.13 * step - 0.3, 0.0);
        let (side, up) = (Vec3::new(0.5, 0.0, 0.0), Vec3::new(0.0, 0.5, 0.0));
        positions.extend([
            center - side - up,
            center + side - up,
            center + side + up,
            center - side + up,
        ]);
    }
    let corner = |index: u8| {
        let (x, y) = (index % 2, index / 2);
        [60 + 180 * x, 60 + 180 * y, 250 - 100 * x, 255]
    };
    let texture = Texture::new(2, 2, (0..4).flat_map(corner).collect());
    let group = LeafGroup {
        name: "leaves".to_owned(),
        prototype: Prototype::Quad {
            texture_corners: Prototype::WHOLE_IMAGE,
        },
        material: Material {
            texture,
            ..Material::plain("leaf", [1.0, 1.0, 1.0])
        },
        owners: vec![NO_BRANCH; positions.len() / 4],
        positions,
    };
    let foliage = Foliage {
        groups: vec![group],
    };
    let plant = Plant::new("flat", None, None, foliage).expect("finite, few, and without owners");
    Arc::new(Crown::new(Arc::new(plant), history.sequence().clone()))
}
