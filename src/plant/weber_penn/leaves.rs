//! Leaves on the stems of the last level: exactly as many as wanted, evenly over the whole crown.

use super::blade::{Bend, bent_prototype, bent_vertices};
use super::branching::{Bearer, Wood};
use super::formulas::{alternate, down_angle, lifted};
use super::frame::Frame;
use super::{GrowError, linear};
use crate::limits;
use crate::math::{Stream, Vec3, det, index_u32};
use crate::plant::{Blade, Foliage, FoliageKind, LeafGroup, Material, Prototype, Species};

/// Texels whose alpha is below this are not there, in all foliage that grows.
const ALPHA_CUTOFF: f32 = 0.5;

/// The least and greatest factor on the species' own leaf density that is tried.
const DENSITIES: (f64, f64) = (1e-6, 1e6);

/// All leaves, in one group a kind; groups without a leaf are left out.
///
/// # Errors
///
/// When the stems cannot bear as many leaves as wanted, or bear more than the limit, or a leaf that is
/// to be left out does not grow.
pub(super) fn foliage(species: &Species, wood: &Wood) -> Result<Foliage, GrowError> {
    let bearers = &wood.bearers;
    let (density, wanted) = density(species, bearers)?;
    let grown = total(bearers, density);
    if grown > limits::GROWN_LEAVES as u64 {
        return Err(GrowError::TooMany {
            what: "leaves",
            found: count(grown),
            limit: limits::GROWN_LEAVES,
        });
    }
    let mut groups: Vec<LeafGroup> = species.foliage.iter().map(empty_group).collect();
    let mut passed = 0_u64;
    for &bearer in bearers {
        let on_stem = leaves_on(bearer, density);
        for leaf in 0..on_stem {
            // Leaves come stem by stem, so each that is left out is as far from the next as can be.
            passed += 1;
            if passed * wanted / grown == (passed - 1) * wanted / grown {
                continue;
            }
            let stream = bearer.stream.child(leaf);
            let kind = kind_of(&species.foliage, stream);
            let (base, frame) = place(species, wood, bearer, stream, [leaf, on_stem]);
            let vertices = &mut groups[kind].positions;
            leaf_vertices(&species.foliage[kind], stream, base, frame, vertices);
            groups[kind].owners.push(bearer.branch);
        }
    }
    omit(&species.omitted_leaves, &mut groups)?;
    groups.retain(|group| !group.owners.is_empty());
    Ok(Foliage { groups })
}

/// Takes out the leaves with these numbers, which count through all groups.
fn omit(numbers: &[u32], groups: &mut [LeafGroup]) -> Result<(), GrowError> {
    let grown: usize = groups.iter().map(LeafGroup::leaf_count).sum();
    if let Some(&last) = numbers.last().filter(|last| **last as usize >= grown) {
        return Err(GrowError::Omitted {
            leaf: last,
            found: grown,
        });
    }
    let mut first = 0;
    let mut rest = numbers;
    for group in groups {
        let stride = group.prototype.vertices_per_leaf();
        let end = first + group.leaf_count();
        let here;
        (here, rest) = rest.split_at(rest.partition_point(|&number| (number as usize) < end));
        let stays = |leaf: usize| here.binary_search(&index_u32(first + leaf)).is_err();
        let mut kept = 0;
        for leaf in (0..group.leaf_count()).filter(|&leaf| stays(leaf)) {
            group.owners[kept] = group.owners[leaf];
            group
                .positions
                .copy_within(stride * leaf..stride * (leaf + 1), stride * kept);
            kept += 1;
        }
        group.owners.truncate(kept);
        group.positions.truncate(stride * kept);
        first = end;
    }
    Ok(())
}

/// The factor on the species' own leaf density, and how many leaves are kept.
fn density(species: &Species, bearers: &[Bearer]) -> Result<(f64, u64), GrowError> {
    match species.leaf_count {
        None => Ok((1.0, total(bearers, 1.0))),
        Some(count) => Ok((density_for(bearers, u64::from(count))?, u64::from(count))),
    }
}

fn empty_group(kind: &FoliageKind) -> LeafGroup {
    let (name, prototype, has_image) = match kind.blade {
        Blade::Flat => {
            let texture_corners = Prototype::WHOLE_IMAGE;
            let quad = Prototype::Quad { texture_corners };
            (kind.silhouette.name(), quad, true)
        }
        Blade::Bent { faces, .. } => (kind.silhouette.name(), bent_prototype(faces), true),
        Blade::Needle { diameter } => ("needles", Prototype::Needle { diameter }, false),
    };
    let material = if has_image {
        Material {
            name: name.to_owned(),
            base_color: [1.0; 4],
            texture: Some(kind.silhouette.draw(kind.color, kind.width)),
            alpha_cutoff: ALPHA_CUTOFF,
        }
    } else {
        Material::plain(name, linear(kind.color))
    };
    LeafGroup {
        name: name.to_owned(),
        prototype,
        material,
        positions: Vec::new(),
        owners: Vec::new(),
    }
}

/// How many leaves a stem bears when the species' own density is multiplied by `density`.
///
/// What is left of a leaf after rounding down grows as often as it is large: so the sum over many
/// stems is near the sum of what they should have, and rises in small steps.
fn leaves_on(bearer: Bearer, density: f64) -> u64 {
    let wanted = f64::from(bearer.leaves) * density + f64::from(bearer.stream.unit(0));
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the range of counts first"
    )]
    let whole = wanted.clamp(0.0, limits::GROWN_LEAVES as f64) as u64;
    whole
}

/// At most 4 million leaves on a million stems: far from overflow.
fn total(bearers: &[Bearer], density: f64) -> u64 {
    bearers
        .iter()
        .fold(0, |sum, &bearer| sum + leaves_on(bearer, density))
}

/// A count for an error message, on machines with small words too.
fn count(leaves: u64) -> usize {
    usize::try_from(leaves).unwrap_or(usize::MAX)
}

/// The least density that gives at least `wanted` leaves, found by halving: the count never falls
/// as the density rises.
fn density_for(bearers: &[Bearer], wanted: u64) -> Result<f64, GrowError> {
    let (mut low, mut high) = DENSITIES;
    let most = total(bearers, high);
    if most < wanted {
        return Err(GrowError::Leaves {
            wanted: count(wanted),
            found: count(most),
        });
    }
    // Sixty halvings of the exponent's range reach the precision of the factor itself.
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if total(bearers, middle) >= wanted {
            high = middle;
        } else {
            low = middle;
        }
    }
    let found = total(bearers, high);
    if found > wanted + wanted * 3 / 100 {
        return Err(GrowError::Leaves {
            wanted: count(wanted),
            found: count(found),
        });
    }
    Ok(high)
}

/// The kind that a leaf's draw falls on.
fn kind_of(kinds: &[FoliageKind], stream: Stream) -> usize {
    let all = kinds.iter().fold(0.0, |sum, kind| sum + kind.share);
    let mut left = all * stream.unit(0);
    for (place, kind) in kinds.iter().enumerate() {
        left -= kind.share;
        if left < 0.0 {
            return place;
        }
    }
    kinds.len() - 1
}

/// Where a leaf's base lies and how the leaf is turned; `leaf` of `count` on its stem.
fn place(
    species: &Species,
    wood: &Wood,
    bearer: Bearer,
    stream: Stream,
    [leaf, count]: [u64; 2],
) -> (Vec3, Frame) {
    let habit = &species.leaves;
    let angles = &species.stems[(species.crown.levels as usize).min(3)];
    let (leaf, count) = (leaf as f32, count as f32);
    let branch = &wood.skeleton.branches[bearer.branch as usize];
    let first = branch.first_node as usize;
    let last = first + branch.node_count as usize - 1;
    let (start, end) = (wood.along[first], wood.along[last]);
    let bare = start + habit.bare * (end - start);
    let (base, frame) = if habit.per_stem < 0.0 {
        // A fan: the leaves share the angle between them, around the stem's direction.
        let (_, tip, frame) = wood.place(bearer.branch, end);
        let turn =
            angles.rotate * ((leaf + 0.5) / count - 0.5) + stream.signed(2) * angles.rotate_v;
        let down = down_angle(angles, stream.signed(3), 1.0);
        (tip, frame.yaw(turn).pitch(down))
    } else {
        let jitter = 0.4 * stream.signed(4);
        let share = (leaf + 0.5 + jitter) / count;
        let (_, base, frame) = wood.place(bearer.branch, bare + share * (end - bare));
        let variation = stream.signed(2) * angles.rotate_v;
        let around = if angles.rotate >= 0.0 {
            360.0 * bearer.stream.unit(1) + leaf * angles.rotate + variation
        } else {
            alternate(leaf % 2.0 == 0.0, angles.rotate + variation)
        };
        let down = down_angle(angles, stream.signed(3), share);
        // The upper face is the one towards the stem's tip.
        (base, frame.roll(around).pitch(down).roll(180.0))
    };
    let frame = lifted(frame, habit.attraction_up);
    (base, to_light(base, frame, habit.bend))
}

/// Twists a leaf on its stalk, so that its upper face turns outwards and up, by a share of the way.
///
/// The paper turns the leaf's direction as well; here it stays, so that flat sprays remain flat.
fn to_light(base: Vec3, frame: Frame, share: f32) -> Frame {
    let outwards = Vec3::new(base.x, 0.0, base.z).normalize_or_zero();
    let light = outwards + 2.0 * Vec3::Y;
    let (beside, before) = (light.dot(frame.side), light.dot(frame.normal()));
    if share == 0.0 || (beside == 0.0 && before == 0.0) {
        return frame;
    }
    frame.roll(share * det::atan2(beside, before).to_degrees())
}

/// Adds the vertices of a leaf, as its prototype has them.
fn leaf_vertices(
    kind: &FoliageKind,
    stream: Stream,
    base: Vec3,
    frame: Frame,
    vertices: &mut Vec<Vec3>,
) {
    let length = kind.length * (1.0 + kind.length_v * stream.signed(1));
    let half = 0.5 * kind.width * length;
    match kind.blade {
        Blade::Flat => {
            let (half, tip) = (half * frame.side, base + length * frame.heading);
            vertices.extend([base - half, base + half, tip + half, tip - half]);
        }
        Blade::Bent { faces, droop, fold } => {
            let bend = Bend { droop, fold };
            bent_vertices(faces, bend, base, frame, [length, half], vertices);
        }
        Blade::Needle { .. } => vertices.extend([base, base + length * frame.heading]),
    }
}

/// How many leaves grow beyond those that are kept.
#[cfg(test)]
pub(super) fn surplus(species: &Species, wood: &Wood) -> Result<usize, GrowError> {
    let (density, wanted) = density(species, &wood.bearers)?;
    Ok(count(total(&wood.bearers, density) - wanted))
}
