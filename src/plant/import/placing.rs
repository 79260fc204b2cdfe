//! Leaves that a file counts, weighs or measures, placed where leaves could be.
//!
//! ```text
//!            blade        A leaf's petiole leaves the bark at the insertion angle; its blade goes on, bent
//!     petiole ╱▔▔▔▔       outwards and a little down, its upper face as far up as that allows.
//!           ╲╱
//!   ○────────┬──────○     Leaves of one internode stand at equal distances, each 137.5° around the axis
//!         internode       from the one before: the golden angle, which most plants keep.
//! ```
//!
//! **Invariant.** Where a leaf stands is a function of the seed, its branch and its number on it: other
//! branches do not matter.

use std::collections::BTreeMap;

use super::wood::{Place, place_of};
use super::{ImportError, ImportReport, ReportKind, Source};
use crate::limits::GROWN_LEAVES;
use crate::math::{Stream, Vec3, det, perpendicular, whole_u32};
use crate::plant::{Foliage, LeafGroup, Material, Node, Prototype, Silhouette, Skeleton};

/// How long a blade is of which the file says nothing, in metres: an apple's.
const BLADE_LENGTH: f32 = 0.08;

/// How wide a blade is, as a share of its length.
const BLADE_WIDTH: f32 = 0.6;

/// How long a petiole is, as a share of its blade's length.
const PETIOLE: f32 = 0.3;

/// The angle between an axis and a petiole, in degrees, where the file says nothing.
const INSERTION: f32 = 55.0;

/// From leaf to leaf around the axis, in degrees.
const GOLDEN_ANGLE: f32 = 137.507_76;

/// By how much a leaf's turn may differ from that, in degrees to either side.
const TURN_VARIATION: f32 = 12.0;

/// How far blades bend outwards, and down, as shares of their length.
const BEND: (f32, f32) = (0.4, 0.25);

/// The stream of random numbers, among those of an import.
const STREAM: u64 = 0x6c65_6166;

/// What leaves look like; the colour is sRGB.
const LOOK: (Silhouette, [u8; 3]) = (Silhouette::Elliptic, [0x4f, 0x7d, 0x32]);

/// Texels whose alpha is below this are not there.
const ALPHA_CUTOFF: f32 = 0.5;

/// Leaves of one internode, or a single one, as far as a file tells of them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Leaves {
    /// The internode along which they stand: from its first node to its last.
    pub(super) place: Place,
    /// How many there are.
    pub(super) count: Option<f64>,
    /// Their area together, in square metres.
    pub(super) area: Option<f64>,
    /// The length of each blade, in metres.
    pub(super) length: Option<f32>,
    /// The width of each blade, in metres.
    pub(super) width: Option<f32>,
    /// The angle between the axis and each leaf, in degrees.
    pub(super) insertion: Option<f32>,
    /// The turn around the axis, in degrees from the first leaf of the branch.
    pub(super) azimuth: Option<f32>,
    /// Where the tip of a single leaf is.
    pub(super) tip: Option<Vec3>,
    /// The line of the file that tells of them.
    pub(super) line: usize,
}

/// How large a blade is, in metres.
#[derive(Debug, Clone, Copy)]
struct Blade {
    length: f32,
    width: f32,
}

/// Places all leaves of a plant; each place is one of the skeleton's.
///
/// # Errors
///
/// When there are more than [`GROWN_LEAVES`].
pub(super) fn place(
    skeleton: &Skeleton,
    all: &[Leaves],
    seed: u64,
    source: &Source<'_>,
    report: &mut ImportReport,
) -> Result<Foliage, ImportError> {
    if all.is_empty() {
        return Ok(Foliage::default());
    }
    let (silhouette, color) = LOOK;
    let texture = silhouette.draw(color, BLADE_WIDTH);
    let texels = texture.rgba().chunks_exact(4);
    let shown = texels.clone().filter(|texel| texel[3] >= 128).count();
    let coverage = shown as f32 / texels.len() as f32;
    let axes = Axes::of(skeleton);
    let mut sized = Vec::with_capacity(all.len());
    let mut total = 0_u64;
    for leaves in all {
        let (count, blade) = size(&axes, leaves, coverage);
        total += u64::from(count);
        sized.push((count, blade));
    }
    source.limit("leaves", total, GROWN_LEAVES as u64)?;
    for (leaves, (count, _)) in all.iter().zip(&sized) {
        note(leaves, *count, seed, report);
    }
    let mut group = LeafGroup {
        name: silhouette.name().to_owned(),
        prototype: Prototype::Quad {
            texture_corners: Prototype::WHOLE_IMAGE,
        },
        material: Material {
            name: silhouette.name().to_owned(),
            base_color: [1.0; 4],
            texture: Some(texture),
            alpha_cutoff: ALPHA_CUTOFF,
        },
        positions: Vec::new(),
        owners: Vec::new(),
    };
    // How many leaves each branch has so far.
    let mut before: BTreeMap<u32, u64> = BTreeMap::new();
    let stream = Stream::new(seed, STREAM);
    for (leaves, (count, blade)) in all.iter().zip(sized) {
        let branch = leaves.place.branch;
        let passed = before.entry(branch).or_default();
        let stream = stream.child(u64::from(branch));
        for leaf in 0..count {
            let share = (leaf as f32 + 0.5) / count as f32;
            let axis = axes.at(leaves.place, share);
            let turn = leaves.azimuth.unwrap_or_else(|| {
                golden_turn(*passed) + TURN_VARIATION * stream.signed(1 + *passed)
            });
            let first = 360.0 * stream.unit(0);
            group
                .positions
                .extend(axis.leaf(leaves, blade, first + turn));
            group.owners.push(branch);
            *passed += 1;
        }
    }
    report.quad_leaves += group.owners.len() as u64;
    let groups = if group.owners.is_empty() {
        Vec::new()
    } else {
        vec![group]
    };
    Ok(Foliage { groups })
}

/// The turn of a leaf that so many came before on its branch, in degrees below 360.
#[expect(
    clippy::cast_possible_truncation,
    reason = "whole turns are taken out first"
)]
fn golden_turn(before: u64) -> f32 {
    let turns = before as f64 * (f64::from(GOLDEN_ANGLE) / 360.0);
    (360.0 * (turns - turns.floor())) as f32
}

/// Says what of some leaves is not the file's.
fn note(leaves: &Leaves, count: u32, seed: u64, report: &mut ImportReport) {
    let is_single = leaves.count.is_none() && leaves.area.is_none();
    let is_sized = leaves.length.is_some() || leaves.width.is_some() || leaves.tip.is_some();
    let size = match (leaves.count, leaves.area) {
        (Some(_), Some(_)) => "of their share of the area".to_owned(),
        (None, Some(_)) => format!("as many of {BLADE_LENGTH} m as have about the area"),
        _ if is_sized => "as large as it says".to_owned(),
        _ => format!("{BLADE_LENGTH} m long"),
    };
    let message = if !is_single {
        format!(
            "leaves of which the file tells number or area: {size}, placed along their nodes by the golden \
             angle and the seed {seed}"
        )
    } else if leaves.tip.is_some() || (leaves.insertion.is_some() && leaves.azimuth.is_some()) {
        if is_sized {
            return;
        }
        format!("leaves of which the file tells where they point: {size}")
    } else {
        format!(
            "leaves of which the file does not tell where they point: {size}, turned by the golden angle \
             and the seed {seed}"
        )
    };
    report.add(
        ReportKind::Guessed,
        u64::from(count),
        place_of(leaves.line),
        message,
    );
}

/// How many leaves there are, and how large each is. An area is that of the blades, not of their quads, of
/// which images cover a share.
fn size(axes: &Axes<'_>, leaves: &Leaves, coverage: f32) -> (u32, Blade) {
    let usual = f64::from(BLADE_LENGTH * BLADE_LENGTH * BLADE_WIDTH * coverage);
    let count = match (leaves.count, leaves.area) {
        (Some(count), _) => whole_u32(count.round()),
        (None, Some(area)) if area > 0.0 => whole_u32((area / usual).round()).max(1),
        (None, Some(_)) => 0,
        (None, None) => 1,
    };
    #[expect(clippy::cast_possible_truncation, reason = "rounded once, at the end")]
    let share = |area: f64| (area / f64::from(count.max(1))) as f32 / coverage;
    let area = leaves.area.map(share);
    let blade = match (leaves.length, leaves.width, area) {
        (Some(length), Some(width), _) => Blade { length, width },
        (Some(length), None, Some(area)) if length > 0.0 => Blade {
            length,
            width: area / length,
        },
        (Some(length), None, _) => Blade::of_length(length),
        (None, Some(width), _) => Blade {
            length: width / BLADE_WIDTH,
            width,
        },
        (None, None, Some(area)) => Blade::of_length((area / BLADE_WIDTH).sqrt()),
        (None, None, None) => {
            let base = axes.at(leaves.place, 1.0).position;
            let distance = leaves.tip.map(|tip| tip.distance(base));
            Blade::of_length(distance.unwrap_or(BLADE_LENGTH))
        }
    };
    (count, blade)
}

impl Blade {
    /// A blade of usual form.
    fn of_length(length: f32) -> Self {
        Self {
            length,
            width: BLADE_WIDTH * length,
        }
    }
}

/// All branches of a skeleton, measured.
#[derive(Debug)]
struct Axes<'a> {
    nodes: &'a [Node],
    /// How far each node is from its branch's base, along the branch.
    along: Vec<f64>,
    /// Where the axis goes that arrives at each node, of unit length.
    directions: Vec<Vec3>,
}

/// A point of an axis.
#[derive(Debug, Clone, Copy)]
struct Axis {
    position: Vec3,
    /// Where the axis goes, of unit length.
    direction: Vec3,
    radius: f32,
}

impl<'a> Axes<'a> {
    fn of(skeleton: &'a Skeleton) -> Self {
        let nodes = &skeleton.nodes[..];
        let mut along = vec![0.0; nodes.len()];
        let mut directions = vec![Vec3::Y; nodes.len()];
        for branch in &skeleton.branches {
            let first = branch.first_node as usize;
            let own = first..first + branch.node_count as usize;
            // Where an internode has no length, the axis goes on as it came.
            let mut way = own
                .clone()
                .skip(1)
                .map(|node| (node, nodes[node].position - nodes[node - 1].position));
            let begun = way.clone().find_map(|(_, way)| way.try_normalize());
            directions[first] = begun.unwrap_or(Vec3::Y);
            way.by_ref().for_each(|(node, way)| {
                along[node] = along[node - 1] + f64::from(way.length());
                directions[node] = way.normalize_or(directions[node - 1]);
            });
        }
        Self {
            nodes,
            along,
            directions,
        }
    }

    /// The point at a share of the way along an internode.
    fn at(&self, place: Place, share: f32) -> Axis {
        let [first, last] = [place.first, place.last].map(|node| node as usize);
        let [start, end] = [self.along[first], self.along[last]];
        let target = start + f64::from(share) * (end - start);
        let passed = self.along[first..=last].partition_point(|along| *along <= target);
        let after = (first + passed).min(last);
        let before = after.saturating_sub(1).max(first);
        let whole = self.along[after] - self.along[before];
        #[expect(clippy::cast_possible_truncation, reason = "a share, rounded once")]
        let share = if whole > 0.0 {
            ((target - self.along[before]) / whole) as f32
        } else {
            1.0
        };
        let [from, to] = [before, after].map(|node| self.nodes[node]);
        Axis {
            position: from.position.lerp(to.position, share),
            direction: self.directions[after],
            radius: from.radius + share * (to.radius - from.radius),
        }
    }
}

impl Axis {
    /// The corners of a leaf that stands here, turned by degrees around the axis.
    fn leaf(&self, leaves: &Leaves, blade: Blade, turn: f32) -> [Vec3; 4] {
        let Blade { length, width } = blade;
        let side = perpendicular(self.direction);
        let (sine, cosine) = det::sin_cos(turn.to_radians());
        let outwards = cosine * side + sine * self.direction.cross(side);
        let insertion = leaves.insertion.unwrap_or(INSERTION);
        let (sine, cosine) = det::sin_cos(insertion.to_radians());
        let petiole = cosine * self.direction + sine * outwards;
        let bent = petiole + BEND.0 * outwards - BEND.1 * Vec3::Y;
        let (base, heading) = match leaves.tip {
            Some(tip) => {
                let heading = (tip - self.position).normalize_or(petiole);
                (tip - length * heading, heading)
            }
            None => {
                let base = self.position + self.radius * outwards + PETIOLE * length * petiole;
                let is_told = leaves.insertion.is_some();
                let heading = if is_told {
                    petiole
                } else {
                    bent.normalize_or(petiole)
                };
                (base, heading)
            }
        };
        let up = (Vec3::Y - heading.y * heading).normalize_or(perpendicular(heading));
        let half = 0.5 * width * heading.cross(up);
        let tip = base + length * heading;
        [base - half, base + half, tip + half, tip - half]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::Branch;

    /// A rod of radius 0.1 from the origin up to (0, 2, 0).
    fn rod() -> Skeleton {
        let node = |height: f32| Node {
            position: Vec3::new(0.0, height, 0.0),
            radius: 0.1,
        };
        Skeleton {
            nodes: vec![node(0.0), node(1.0), node(2.0)],
            branches: vec![Branch {
                bearer: None,
                level: 0,
                first_node: 0,
                node_count: 3,
            }],
        }
    }

    const WHOLE: Place = Place {
        branch: 0,
        first: 0,
        last: 2,
    };

    fn placed(all: &[Leaves], seed: u64) -> Result<(Foliage, Vec<String>), String> {
        let source = Source::new("a.mtg", b"", None).expect("no bytes");
        let mut report = ImportReport::default();
        let foliage = place(&rod(), all, seed, &source, &mut report).map_err(|e| e.to_string())?;
        assert_eq!(report.quad_leaves, foliage.leaf_count() as u64);
        let said = report.entries.iter().map(ToString::to_string).collect();
        Ok((foliage, said))
    }

    #[test]
    fn counted_leaves_climb_by_the_golden_angle_outside_of_the_bark() {
        let ten = Leaves {
            place: WHOLE,
            count: Some(10.0),
            line: 4,
            ..Leaves::default()
        };
        let (foliage, said) = placed(&[ten], 7).unwrap();
        let group = &foliage.groups[0];
        assert_eq!(group.leaf_count(), 10);
        assert_eq!(group.owners, [0; 10]);
        let mut turns = Vec::new();
        for leaf in 0..10 {
            let corners = group.leaf(leaf);
            let base = 0.5 * (corners[0] + corners[1]);
            let away = Vec3::new(base.x, 0.0, base.z);
            // The petiole: 0.3 · 0.08 m long, at 55° from the axis.
            assert!(
                (away.length() - 0.1 - 0.024 * 0.81915).abs() < 1e-5,
                "{away}"
            );
            let foot = 0.1 + 0.2 * leaf as f32;
            assert!((base.y - foot - 0.024 * 0.57358).abs() < 1e-5, "{base}");
            assert!((corners[0].distance(corners[3]) - 0.08).abs() < 1e-6);
            assert!((corners[0].distance(corners[1]) - 0.048).abs() < 1e-6);
            let normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
            assert!(normal.y > 0.0, "leaf {leaf} lies on its back");
            turns.push(det::atan2(away.z, away.x).to_degrees());
        }
        for pair in turns.windows(2) {
            let step = (pair[0] - pair[1]).rem_euclid(360.0);
            let off = (step - GOLDEN_ANGLE)
                .abs()
                .min((step - 360.0 + GOLDEN_ANGLE).abs());
            assert!(off <= 2.0 * TURN_VARIATION, "a step of {step}");
        }
        assert_eq!(
            said,
            [
                "guessed: leaves of which the file tells number or area: 0.08 m long, placed along their nodes by \
              the golden angle and the seed 7 (10, first at line 4)"
            ]
        );
        assert_eq!(placed(&[ten], 7).unwrap().0, foliage);
        assert_ne!(placed(&[ten], 8).unwrap().0, foliage);
    }

    #[test]
    fn areas_are_met_by_what_the_images_show() {
        let leaves = |count, area| Leaves {
            place: WHOLE,
            count,
            area: Some(area),
            line: 1,
            ..Leaves::default()
        };
        let (foliage, _) = placed(&[leaves(Some(5.0), 0.02)], 1).unwrap();
        let group = &foliage.groups[0];
        let texture = group.material.texture.as_ref().unwrap();
        let texels = texture.rgba().chunks_exact(4);
        let shown = texels.clone().filter(|texel| texel[3] >= 128).count() as f64;
        let area = group.area() * shown / texels.len() as f64;
        assert!((area - 0.02).abs() < 1e-6, "{area}");
        // Without a number, as many as leaves are usually large: 0.08 · 0.048 m² · coverage.
        let usual = 0.00384 * shown / texels.len() as f64;
        let (foliage, said) = placed(&[leaves(None, 7.3 * usual)], 1).unwrap();
        assert_eq!(foliage.leaf_count(), 7);
        assert!(
            said[0].contains("as many of 0.08 m as have about the area"),
            "{}",
            said[0]
        );
        assert_eq!(
            placed(&[leaves(None, 0.0)], 1).unwrap().0,
            Foliage::default()
        );
    }

    #[test]
    fn single_leaves_keep_what_the_file_says() {
        let leaf = Leaves {
            place: Place { first: 2, ..WHOLE },
            length: Some(0.5),
            width: Some(0.25),
            line: 1,
            ..Leaves::default()
        };
        let pointing = Leaves {
            tip: Some(Vec3::new(2.0, 2.0, 0.0)),
            ..leaf
        };
        let (foliage, said) = placed(&[pointing], 1).unwrap();
        let wanted = [
            Vec3::new(1.5, 2.0, -0.125),
            Vec3::new(1.5, 2.0, 0.125),
            Vec3::new(2.0, 2.0, 0.125),
            Vec3::new(2.0, 2.0, -0.125),
        ];
        for (found, wanted) in foliage.groups[0].leaf(0).iter().zip(wanted) {
            assert!(found.distance(wanted) < 1e-6, "{found} instead of {wanted}");
        }
        assert_eq!(said, [""; 0]);
        // At a right angle to a rod that stands upright, a leaf is level; half a turn further it points back.
        let turned = |azimuth| Leaves {
            insertion: Some(90.0),
            azimuth: Some(azimuth),
            ..leaf
        };
        let (foliage, _) = placed(&[turned(0.0), turned(180.0)], 1).unwrap();
        let [there, back] = [0, 1].map(|leaf| {
            let corners = foliage.groups[0].leaf(leaf);
            corners[3] - corners[0]
        });
        assert!(
            there.y.abs() < 1e-6 && (there + back).length() < 1e-5,
            "{there} {back}"
        );
    }

    #[test]
    fn too_many_leaves_are_refused() {
        let many = Leaves {
            place: WHOLE,
            count: Some(1e300),
            ..Leaves::default()
        };
        assert_eq!(
            placed(&[many], 1).unwrap_err(),
            "a.mtg: 4294967295 leaves exceed the limit of 4000000; split or thin the tree"
        );
    }
}
