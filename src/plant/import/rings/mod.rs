//! The skeleton of wood that is made of rings.
//!
//! ```text
//!   places in the file's order      rings of e       nodes
//!   0 1 2 3 4 5 6 7 8 9 10 11 12    ─▶  0…3, 4…7, 8…11, tip 12  ─▶  ○──○──○──○
//! ```
//!
//! Programs write tubes ring by ring. Where all wood is such tubes, each ring's centre is a node and its
//! mean distance from there the radius; a tube is borne by the thicker one that it begins in.

mod nearest;
#[cfg(test)]
mod tests;

use super::frame::Frame;
use super::mesh::{components, place_classes};
use super::wood::{Segment, Wood};
use super::{ImportReport, Reading, ReportKind, Source, Unit, UpAxis};
use crate::limits::WOOD_SEGMENTS;
use crate::math::{DVec3, index_u32};
use crate::plant::{Mesh, Skeleton};
use nearest::{Axes, Axis};

/// A ring: where its centre is, and how far its corners are from there.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ring {
    center: DVec3,
    radius: f64,
}

/// The skeleton of wood; `None` unless all of it is tubes of rings, each of as many corners as the tube's
/// others, in order.
pub(in crate::plant) fn skeleton(
    trunk: &Mesh,
    source: &Source<'_>,
    place: &str,
    report: &mut ImportReport,
) -> Option<Skeleton> {
    let mut tubes = tubes(trunk)?;
    let segments: usize = tubes.iter().map(|tube| tube.len() - 1).sum();
    if segments > WOOD_SEGMENTS {
        let message = format!(
            "the skeleton of tubes of {segments} segments: more than the limit of {WOOD_SEGMENTS}"
        );
        report.add(ReportKind::Dropped, 1, place, message);
        return None;
    }
    let count = tubes.len() as u64;
    let message = "tubes of rings without a skeleton: the rings' centres are its nodes";
    report.add(ReportKind::Repaired, count, place, message);
    // Bearers first: they are thicker where they begin.
    tubes.sort_by(|a, b| b[0].radius.total_cmp(&a[0].radius));
    let wood = join(&tubes, source)?;
    let frame = Frame::new(Reading::default(), UpAxis::Y, Unit::M);
    Some(wood.grow(&frame, report).skeleton)
}

/// The tubes of a mesh, the thick end first; `None` if anything is no tube.
fn tubes(trunk: &Mesh) -> Option<Vec<Vec<Ring>>> {
    let classes = place_classes(&trunk.positions);
    let triangles: Vec<[u32; 3]> = trunk
        .indices
        .chunks_exact(3)
        .map(|corners| [corners[0], corners[1], corners[2]])
        .collect();
    // Each place by its first vertex: the order of the file.
    let mut first = vec![u32::MAX; trunk.positions.len()];
    for (&class, vertex) in classes.iter().zip(0_u32..) {
        let first = &mut first[class as usize];
        *first = vertex.min(*first);
    }
    let place = |vertex: u32| first[classes[vertex as usize] as usize];
    let pieces = components(&classes, &triangles);
    let tubes = pieces.into_iter().map(|piece| {
        let piece = piece.into_iter().map(|corners| corners.map(place));
        let (places, piece) = super::mesh::compact(piece.collect());
        let points: Vec<DVec3> = places
            .iter()
            .map(|&vertex| trunk.positions[vertex as usize].as_dvec3())
            .collect();
        tube(&points, &piece)
    });
    let tubes: Option<Vec<Vec<Ring>>> = tubes.collect();
    tubes.filter(|tubes| !tubes.is_empty())
}

/// The rings of a tube, the thick end first.
fn tube(points: &[DVec3], triangles: &[[u32; 3]]) -> Option<Vec<Ring>> {
    let mut around: Vec<u32> = triangles
        .iter()
        .filter(|corners| corners.contains(&0))
        .flatten()
        .copied()
        .filter(|&corner| corner != 0)
        .collect();
    around.sort_unstable();
    around.dedup();
    // The first corner's neighbours are the next of its ring, the ring's last, and some of the next ring.
    let open = around.get(1).map(|&last| Layout {
        lead: 0,
        edges: last as usize + 1,
    });
    // A cap's neighbours are the whole first ring.
    let is_cap = around
        .iter()
        .zip(1..)
        .all(|(&corner, wanted)| corner == wanted);
    let capped = is_cap.then_some(Layout {
        lead: 1,
        edges: around.len(),
    });
    let mut rings = [open, capped]
        .into_iter()
        .flatten()
        .find_map(|layout| layout.rings(points, triangles))?;
    let [first, .., last] = rings.as_slice() else {
        return None;
    };
    if last.radius > first.radius {
        rings.reverse();
    }
    Some(rings)
}

/// How a tube's corners are numbered: perhaps a cap's middle, rings, perhaps tips or middles of caps.
#[derive(Debug, Clone, Copy)]
struct Layout {
    lead: usize,
    edges: usize,
}

impl Layout {
    /// The rings, if every triangle is where this layout has it, and none is missing.
    fn rings(self, points: &[DVec3], triangles: &[[u32; 3]]) -> Option<Vec<Ring>> {
        let edges = self.edges;
        if edges < 3 || points.len() < self.lead + edges {
            return None;
        }
        let (count, tail) = (
            (points.len() - self.lead) / edges,
            (points.len() - self.lead) % edges,
        );
        if tail > 2 {
            return None;
        }
        let rings_end = self.lead + count * edges;
        let ring = |corner: u32| {
            let corner = corner as usize;
            let is_ring = (self.lead..rings_end).contains(&corner);
            is_ring.then(|| (corner - self.lead) / edges)
        };
        let are_next = |a: u32, b: u32| {
            let step = (a as usize).abs_diff(b as usize);
            step == 1 || step == edges - 1
        };
        let mut bands = vec![0_usize; count - 1];
        let mut caps = [(0_usize, 0_usize); 3];
        for &[a, b, c] in triangles {
            // Turned so that the first corner is the one apart.
            let [ra, rb, rc] = [a, b, c].map(ring);
            let ([apart, p, q], r) = if rb == rc {
                ([a, b, c], rb?)
            } else if ra == rc {
                ([b, c, a], rc?)
            } else if ra == rb {
                ([c, a, b], ra?)
            } else {
                return None;
            };
            match ring(apart) {
                Some(same) if same == r => {
                    // A polygon that closes an end.
                    if r != 0 && r + 1 != count {
                        return None;
                    }
                    continue;
                }
                _ if !are_next(p, q) => return None,
                Some(other) if other.abs_diff(r) == 1 => bands[other.min(r)] += 1,
                Some(_) => return None,
                None => {
                    let cap = &mut caps[(apart as usize).saturating_sub(rings_end - 1)];
                    if (r != 0 && r + 1 != count) || (cap.1 > 0 && cap.0 != r) {
                        return None;
                    }
                    *cap = (r, cap.1 + 1);
                }
            }
        }
        let cap_count = self.lead + tail;
        let used = caps.iter().filter(|cap| cap.1 == edges).count();
        if bands.iter().any(|&band| band != 2 * edges) || used != cap_count {
            return None;
        }
        let corners = &points[self.lead..rings_end];
        let mut rings: Vec<Ring> = corners.chunks_exact(edges).map(Ring::of).collect();
        let ends = [rings[0], rings[count - 1]];
        let lead = (self.lead == 1).then_some((0, caps[0]));
        let tails = (0..tail).map(|place| (rings_end + place, caps[1 + place]));
        for (corner, (at, _)) in lead.into_iter().chain(tails) {
            // The only ring has its tip after it.
            let is_start = at == 0 && count > 1;
            let end = ends[usize::from(!is_start)];
            let tip = points[corner];
            if tip.distance(end.center) <= FLAT_CAP * end.radius {
                continue;
            }
            let tip = Ring {
                center: tip,
                radius: 0.0,
            };
            if is_start {
                rings.insert(0, tip);
            } else {
                rings.push(tip);
            }
        }
        Some(rings)
    }
}

/// A cap's middle that is nearer to its ring's centre, in radii, is no tip.
const FLAT_CAP: f64 = 0.05;

impl Ring {
    fn of(corners: &[DVec3]) -> Self {
        let count = corners.len() as f64;
        let center = corners
            .iter()
            .fold(DVec3::ZERO, |sum, &corner| sum + corner)
            / count;
        let sum = corners
            .iter()
            .fold(0.0, |sum, corner| sum + corner.distance(center));
        Self {
            center,
            radius: sum / count,
        }
    }
}

/// Tubes as segments of wood, each borne by the tube that it begins in: of those before it the one whose
/// wood it is deepest in, or nearest to.
fn join(tubes: &[Vec<Ring>], source: &Source<'_>) -> Option<Wood> {
    let mut axes = Vec::new();
    for (tube, rings) in tubes.iter().enumerate() {
        axes.extend(rings.windows(2).map(|ends| Axis {
            tube: index_u32(tube),
            ends: [ends[0].center, ends[1].center],
            radii: [ends[0].radius, ends[1].radius],
        }));
    }
    let nearest = Axes::new(&axes);
    let mut wood = Wood::new("segments of tubes");
    let mut number = 0;
    for (tube, rings) in tubes.iter().enumerate() {
        let base = rings[0];
        let bearer = nearest.nearest(base.center, index_u32(tube));
        let bearer = bearer.filter(|(axis, gap)| {
            let radii = axes[*axis as usize].radii;
            *gap <= base.radius.max(radii[0].max(radii[1]))
        });
        for (place, ends) in rings.windows(2).enumerate() {
            let (parent, follows) = match (place, bearer) {
                (0, None) => (None, None),
                (0, Some((axis, _))) => {
                    let end = axes[axis as usize].ends[1];
                    let is_end = end.distance(base.center) <= base.radius;
                    // Whether an end goes on, and in what, is for the wood to say.
                    (Some(axis), if is_end { None } else { Some(false) })
                }
                _ => (Some(number - 1), Some(true)),
            };
            let segment = Segment {
                parent,
                follows,
                start: Some(ends[0].center),
                end: ends[1].center,
                start_radius: Some(ends[0].radius),
                end_radius: Some(ends[1].radius),
                line: 1,
            };
            number = wood.push(segment, source).ok()? + 1;
        }
    }
    Some(wood)
}
