//! Telling leaves from wood.

use super::cards::{self, Pieces};
use super::foliage::Leaves;
use super::{Materials, Part, trunk};
use crate::plant::import::{ImportReport, ReportKind};
use crate::plant::{Foliage, Mesh};
use std::collections::BTreeMap;

/// By what leaves are told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::plant) enum Evidence {
    /// The names that the user gave.
    Named,
    /// What looks like it.
    Guess,
}

/// Leaves and wood.
///
/// A guess takes the first of these that finds any leaves, and reports it:
///
/// 1. materials with alpha most of whose triangles are cards or other small leaves;
/// 2. parts of which the material's name says that they are leaves, or else the names of groups, objects,
///    nodes and meshes, unless all say so;
/// 3. the pieces of the form of a leaf, wherever they are, if they are at least [`LEAST_LEAVES`].
///
/// # Errors
///
/// As [`Materials::read`].
pub(in crate::plant) fn sort<M: Materials>(
    parts: Vec<Part>,
    evidence: Evidence,
    materials: &mut M,
    report: &mut ImportReport,
) -> Result<(Option<Mesh>, Foliage), M::Fault> {
    let mut split: Vec<(Part, Option<Pieces>)> = parts
        .into_iter()
        .map(|part| {
            let may_be_foliage = match evidence {
                Evidence::Named => part.named,
                Evidence::Guess => part.has_alpha,
            };
            let pieces = may_be_foliage.then(|| pieces(&part));
            (part, pieces)
        })
        .collect();
    if evidence == Evidence::Guess {
        keep_mostly_leaves(&mut split, materials, report);
        if split.iter().all(|(_, pieces)| pieces.is_none()) {
            by_name(&mut split, report);
        }
    }
    let mut leaves = Leaves::default();
    let mut wood = Vec::new();
    let is_found = split.iter().any(|(_, pieces)| pieces.is_some());
    if evidence == Evidence::Guess && !is_found {
        let parts = split.into_iter().map(|(part, _)| part).collect();
        wood = by_form(parts, &mut leaves, report);
    } else {
        for (part, pieces) in split {
            match pieces {
                Some(mut pieces) => {
                    pieces.loosen(&part.positions, &part.coordinates);
                    leaves.add(&part, &pieces, report);
                }
                None => wood.push(part),
            }
        }
    }
    let trunk = trunk::join(wood, materials, report)?;
    let foliage = leaves.into_foliage(materials, report)?;
    Ok((trunk, foliage))
}

fn pieces(part: &Part) -> Pieces {
    cards::split(&part.positions, &part.coordinates, &part.triangles)
}

/// Takes the pieces away from materials that are not mostly leaves: those are wood.
fn keep_mostly_leaves<M: Materials>(
    parts: &mut [(Part, Option<Pieces>)],
    materials: &M,
    report: &mut ImportReport,
) {
    #[derive(Default)]
    struct Count {
        cards: u64,
        small: u64,
        all: u64,
    }
    let mut counts: BTreeMap<Option<usize>, Count> = BTreeMap::new();
    for (part, pieces) in parts.iter() {
        if let Some(pieces) = pieces {
            let others: usize = pieces.others.iter().map(Vec::len).sum();
            let small = leaves_of(part, pieces).map(|piece| piece.len() as u64);
            let count = counts.entry(part.material).or_default();
            count.cards += 2 * pieces.cards.len() as u64;
            count.small += small.sum::<u64>();
            count.all += 2 * pieces.cards.len() as u64 + others as u64;
        }
    }
    let mostly = |count: &Count| 2 * (count.cards + count.small) > count.all;
    for (&material, count) in &counts {
        let (name, place) = materials.name_and_place(material.unwrap_or_default());
        let taken = if mostly(count) { "foliage" } else { "wood" };
        let what = if count.small > 0 {
            "cards or other small leaves"
        } else {
            "cards"
        };
        let (leaves, all) = (count.cards + count.small, count.all);
        let message = format!(
            "material {name:?} has alpha and {leaves} of {all} triangles are {what}: taken as {taken}"
        );
        report.add(ReportKind::Guessed, 1, place, message);
    }
    for (part, pieces) in parts {
        if counts
            .get(&part.material)
            .is_some_and(|count| !mostly(count))
        {
            *pieces = None;
        }
    }
}

/// The pieces that are no cards but may be leaves.
fn leaves_of<'a>(part: &'a Part, pieces: &'a Pieces) -> impl Iterator<Item = &'a Vec<[u32; 3]>> {
    let places = &pieces.places;
    let others = pieces.others.iter();
    others.filter(|piece| cards::is_leaf(piece, &part.positions, places))
}

/// Takes parts apart whose names say that they are leaves.
fn by_name(parts: &mut [(Part, Option<Pieces>)], report: &mut ImportReport) {
    type Says = fn(&Part) -> bool;
    let ways: [(&str, Says); 2] = [
        ("material", |part| part.material_says),
        ("name", |part| part.name_says),
    ];
    for (what, says) in ways {
        let said = parts.iter().filter(|(part, _)| says(part)).count();
        if said == 0 || said == parts.len() {
            continue;
        }
        for (part, taken) in parts.iter_mut().filter(|(part, _)| says(part)) {
            let message = format!("parts whose {what} says that they are leaves: taken as foliage");
            report.add(ReportKind::Guessed, 1, &part.place, message);
            *taken = Some(pieces(part));
        }
        return;
    }
}

/// Takes out what has the form of leaves; returns the rest.
fn by_form(parts: Vec<Part>, leaves: &mut Leaves, report: &mut ImportReport) -> Vec<Part> {
    let found: Vec<Pieces> = parts.iter().map(pieces).collect();
    let mut count = 0;
    for (part, pieces) in parts.iter().zip(&found) {
        count += pieces.cards.len() + leaves_of(part, pieces).count();
    }
    if count < LEAST_LEAVES {
        return parts;
    }
    let mut wood = Vec::new();
    for (mut part, mut pieces) in parts.into_iter().zip(found) {
        let (small, rest): (Vec<_>, Vec<_>) = std::mem::take(&mut pieces.others)
            .into_iter()
            .partition(|piece| cards::is_leaf(piece, &part.positions, &pieces.places));
        pieces.others = small;
        let found = pieces.cards.len() + pieces.others.len();
        if found > 0 {
            let message = "pieces of 3 to 11 corners that are no tubes: taken as leaves";
            report.add(ReportKind::Guessed, found as u64, &part.place, message);
            leaves.add(&part, &pieces, report);
            part.keep(rest.concat());
        }
        if !part.triangles.is_empty() {
            wood.push(part);
        }
    }
    wood
}

/// Fewer pieces of the form of leaves are no crown.
const LEAST_LEAVES: usize = 4;
