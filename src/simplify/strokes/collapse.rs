//! Several leaf strokes become one.

use super::leaf::LeafStroke;
use crate::math::{Vec3, det};
use crate::plant::Stroke;

/// Which strokes may become one: the criteria of LSA, distance and coplanarity
/// ([CQHCVL06](crate::references), section 4.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CollapseThresholds {
    /// How far their centres may be from the first's, in mean lengths of an original stroke.
    pub distance: f32,
    /// How far their planes may be turned against the first's, in degrees up to 90.
    pub angle: f32,
}

/// Joins strokes: each list names those that become one, by number, the first that which the others
/// were compared with; strokes that stay alone are lists of one.
///
/// Strokes are gone through from the least x on. Each that is not taken yet takes those of its group
/// within reach that cost least, at most `most` together with itself. The cost is the distance and the
/// sine squared between the planes, each as a share of what is allowed, together. A stroke without area
/// lies in no plane, and so in any.
pub(super) fn grouped(
    strokes: &[LeafStroke],
    distance: f32,
    angle: f32,
    most: usize,
) -> Vec<Vec<u32>> {
    let least_cosine = det::cos(angle.clamp(0.0, 90.0).to_radians());
    let allowed = (1.0 - least_cosine * least_cosine).max(1e-6);
    let normals: Vec<Vec3> = strokes.iter().map(|leaf| leaf.stroke.normal()).collect();
    let mut order: Vec<u32> = (0_u32..).take(strokes.len()).collect();
    let x = |stroke: u32| strokes[stroke as usize].stroke.center.x;
    order.sort_unstable_by(|a, b| x(*a).total_cmp(&x(*b)).then(a.cmp(b)));
    let mut is_taken = vec![false; strokes.len()];
    let mut groups = Vec::new();
    let mut near: Vec<(f32, u32)> = Vec::new();
    for (place, &first) in order.iter().enumerate() {
        if is_taken[first as usize] {
            continue;
        }
        near.clear();
        let seed = &strokes[first as usize];
        for &other in &order[place + 1..] {
            if x(other) - x(first) > distance {
                break;
            }
            let candidate = &strokes[other as usize];
            if is_taken[other as usize] || candidate.group != seed.group {
                continue;
            }
            let apart = candidate.stroke.center.distance(seed.stroke.center);
            let cosine = normals[first as usize].dot(normals[other as usize]).abs();
            let has_planes = [first, other].map(|leaf| normals[leaf as usize] != Vec3::ZERO);
            let sine = if has_planes == [true; 2] {
                1.0 - cosine * cosine
            } else {
                0.0
            };
            if apart <= distance && (sine <= 0.0 || cosine >= least_cosine) {
                let share = if distance > 0.0 {
                    apart / distance
                } else {
                    0.0
                };
                near.push((share + sine.max(0.0) / allowed, other));
            }
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut group = vec![first];
        group.extend(
            near.iter()
                .take(most.saturating_sub(1))
                .map(|(_, leaf)| *leaf),
        );
        for &leaf in &group {
            is_taken[leaf as usize] = true;
        }
        groups.push(group);
    }
    groups
}

/// The stroke of several: as large as they are together.
///
/// Its centre and directions are their means by area, planes and directions turned so that none cancels
/// the first's. Length and width are as they reach together, scaled to their areas' sum; where they hide
/// each other it reaches as far as they do and no further.
pub(super) fn joined(strokes: &[LeafStroke], group: &[u32]) -> LeafStroke {
    let members = || group.iter().map(|leaf| &strokes[*leaf as usize]);
    let first = &strokes[group[0] as usize];
    let facing = first.stroke.normal();
    let mut area = 0.0;
    let (mut center, mut normal, mut along) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
    // Strokes without any area count alike.
    let total: f32 = members().fold(0.0, |sum, leaf| sum + leaf.stroke.area());
    for leaf in members() {
        let own = leaf.stroke.area();
        let weight = if total > 0.0 {
            own / total
        } else {
            1.0 / group.len() as f32
        };
        area += own;
        center += weight * leaf.stroke.center;
        normal += weight * turned(leaf.stroke.normal(), facing);
        along += weight * turned(leaf.stroke.along, first.stroke.along);
    }
    let normal = normal.normalize_or(facing.try_normalize().unwrap_or(Vec3::Z));
    let along = along - along.dot(normal) * normal;
    let along = along.normalize_or(normal.any_orthonormal_vector());
    let across = along.cross(normal);
    let reach = |axis: Vec3| {
        members().fold(0.0_f32, |reach, leaf| {
            let Stroke {
                center: at,
                along,
                across,
            } = leaf.stroke;
            let half = along.dot(axis).abs() + across.dot(axis).abs();
            reach.max((at - center).dot(axis).abs() + half)
        })
    };
    let (length, width) = (reach(along), reach(across));
    let box_area = 4.0 * length * width;
    let scale = if box_area > area {
        (area / box_area).sqrt()
    } else {
        1.0
    };
    LeafStroke {
        stroke: Stroke {
            center,
            along: scale * length * along,
            across: scale * width * across,
        },
        group: first.group,
        leaves: members().fold(0, |sum: u32, leaf| sum.saturating_add(leaf.leaves)),
    }
}

/// A direction or its opposite, whichever points more with another.
fn turned(direction: Vec3, with: Vec3) -> Vec3 {
    if direction.dot(with) < 0.0 {
        -direction
    } else {
        direction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f32, turn: f32) -> LeafStroke {
        let (sine, cosine) = det::sin_cos(turn.to_radians());
        LeafStroke {
            stroke: Stroke {
                center: Vec3::new(x, 0.0, 0.0),
                along: Vec3::new(0.0, 0.5 * cosine, 0.5 * sine),
                across: Vec3::new(0.5, 0.0, 0.0),
            },
            group: 0,
            leaves: 1,
        }
    }

    #[test]
    fn the_near_and_coplanar_become_one_more_than_two_at_once() {
        //  0  1  2      3 is turned by 60°, 4 is far, 5 of another kind
        let mut strokes = [0.0, 1.0, 2.0, 2.1, 9.0, 0.5].map(|x| square(x, 0.0));
        strokes[3] = square(2.1, 60.0);
        strokes[5].group = 1;
        let parts = grouped(&strokes, 2.5, 30.0, 8);
        assert_eq!(parts, [vec![0, 1, 2], vec![5], vec![3], vec![4]]);
        assert_eq!(
            grouped(&strokes, 2.5, 30.0, 2)[0],
            [0, 1],
            "no more than wanted"
        );
        assert_eq!(grouped(&strokes, 2.5, 60.5, 8)[0], [0, 1, 2, 3]);
        let one = joined(&strokes, &[0, 1, 2]);
        assert_eq!((one.leaves, one.stroke.center), (3, Vec3::X));
        assert!(
            (one.stroke.area() - 3.0).abs() < 1e-5,
            "{}",
            one.stroke.area()
        );
        assert!((one.stroke.across.length() - 1.5).abs() < 1e-5);
        assert_eq!(one.stroke.normal(), Vec3::Z);
    }

    #[test]
    fn opposite_faces_do_not_cancel_and_copies_do_not_grow() {
        let strokes = [square(0.0, 0.0), square(0.0, 180.0)];
        let one = joined(&strokes, &[0, 1]).stroke;
        assert!((one.area() - 1.0).abs() < 1e-5, "{}", one.area());
        assert!(one.normal().z > 0.999, "{}", one.normal());
    }
}
