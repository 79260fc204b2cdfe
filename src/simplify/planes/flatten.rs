//! Leaves moved into their planes.

use super::hierarchy::PlaneLevel;
use super::plane::Plane;
use crate::plant::{Foliage, LeafGroup};

/// The foliage with every leaf moved into the plane of its cluster: what impostors are "equivalent to"
/// ([GSS05](crate::references), § 4), drawn as leaves.
///
/// Every vertex goes to the nearest point of the plane, which is where an impostor shows it that was
/// seen along the plane's normal: leaves that cross their plane at an angle get shorter. The paper's
/// "moving and rotating" would keep their lengths, but its impostors do not. Needles stay, as do
/// leaves beyond those that the level knows.
#[must_use]
pub fn flattened(foliage: &Foliage, level: &PlaneLevel) -> Foliage {
    let mut planes = level
        .cluster_of_site
        .iter()
        .map(|&cluster| level.planes.get(cluster as usize));
    let groups = foliage.groups.iter().map(|group| {
        let is_sited = group.prototype.triangles_per_leaf() > 0;
        let count = if is_sited { group.leaf_count() } else { 0 };
        in_planes(group, planes.by_ref().take(count).flatten())
    });
    Foliage {
        groups: groups.collect(),
    }
}

/// The leaves of one cluster of a level alone, in the groups that they are of; no needles.
#[must_use]
pub fn leaves_of_cluster(foliage: &Foliage, level: &PlaneLevel, cluster: u32) -> Foliage {
    let mut clusters = level.cluster_of_site.iter();
    let groups = foliage.groups.iter().map(|group| {
        let is_sited = group.prototype.triangles_per_leaf() > 0;
        let count = if is_sited { group.leaf_count() } else { 0 };
        let kept = clusters.by_ref().take(count).enumerate();
        let kept: Vec<usize> = kept
            .filter(|(_, of)| **of == cluster)
            .map(|(leaf, _)| leaf)
            .collect();
        LeafGroup {
            positions: kept
                .iter()
                .flat_map(|&leaf| group.leaf(leaf).iter().copied())
                .collect(),
            owners: kept.iter().map(|&leaf| group.owners[leaf]).collect(),
            ..group.clone()
        }
    });
    Foliage {
        groups: groups.collect(),
    }
}

/// The group with its first leaves in these planes, one a leaf.
fn in_planes<'a>(group: &LeafGroup, planes: impl Iterator<Item = &'a Plane>) -> LeafGroup {
    let mut moved = group.clone();
    let stride = group.prototype.vertices_per_leaf().max(1);
    for (leaf, plane) in moved.positions.chunks_mut(stride).zip(planes) {
        for vertex in leaf {
            *vertex = plane.project(*vertex);
        }
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::super::{PlaneOptions, cluster_planes, leaf_sites};
    use super::*;
    use crate::math::{Draws, Stream, Vec3};
    use crate::plant::{Material, NO_BRANCH, Prototype};

    fn group(prototype: Prototype, positions: Vec<Vec3>) -> LeafGroup {
        LeafGroup {
            name: "leaves".to_owned(),
            owners: vec![NO_BRANCH; positions.len() / prototype.vertices_per_leaf()],
            prototype,
            material: Material::plain("leaf", [0.1, 0.4, 0.1]),
            positions,
        }
    }

    fn quads(positions: Vec<Vec3>) -> LeafGroup {
        let texture_corners = Prototype::WHOLE_IMAGE;
        group(Prototype::Quad { texture_corners }, positions)
    }

    fn vector(draws: &mut Draws) -> Vec3 {
        Vec3::new(draws.signed(), draws.signed(), draws.signed())
    }

    fn level(foliage: &Foliage, count: u32) -> PlaneLevel {
        cluster_planes(&leaf_sites(foliage), &PlaneOptions::to(count)).into()
    }

    fn random() -> Foliage {
        let mut draws = Stream::new(20, 0).draws();
        let mut points = |count: usize, scale: f32| -> Vec<Vec3> {
            (0..count).map(|_| scale * vector(&mut draws)).collect()
        };
        Foliage {
            groups: vec![
                quads(points(4 * 30, 3.0)),
                group(Prototype::Needle { diameter: 0.01 }, points(2 * 5, 3.0)),
                quads(points(4 * 10, 2.0)),
            ],
        }
    }

    #[test]
    fn leaves_lie_in_the_planes_of_their_clusters() {
        let foliage = random();
        let level = level(&foliage, 6);
        let flat = flattened(&foliage, &level);
        assert_eq!(flat.groups[1], foliage.groups[1]);
        let leaves = [0, 2].into_iter().flat_map(|group| {
            let group: &LeafGroup = &flat.groups[group];
            group.positions.as_chunks::<4>().0
        });
        let mut count = 0;
        for (leaf, cluster) in leaves.zip(&level.cluster_of_site) {
            let plane = level.planes[*cluster as usize];
            assert!(
                leaf.iter()
                    .all(|&vertex| plane.signed_distance(vertex).abs() < 1e-6)
            );
            count += 1;
        }
        assert_eq!(count, 40);
    }

    #[test]
    fn clusters_share_the_leaves_out() {
        let foliage = random();
        let level = level(&foliage, 6);
        let parts: Vec<Foliage> = (0..6)
            .map(|cluster| leaves_of_cluster(&foliage, &level, cluster))
            .collect();
        let count: usize = parts.iter().map(Foliage::leaf_count).sum();
        // All but the needles.
        assert_eq!(count, 40);
        let first = level.cluster_of_site[0] as usize;
        assert_eq!(parts[first].groups[0].leaf(0), foliage.groups[0].leaf(0));
        let last = level.cluster_of_site[39] as usize;
        let leaves = parts[last].groups[2].leaf_count();
        assert_eq!(
            parts[last].groups[2].leaf(leaves - 1),
            foliage.groups[2].leaf(9)
        );
        assert!(parts.iter().all(|part| part.groups[1].leaf_count() == 0));
    }

    #[test]
    fn flattening_twice_is_flattening_once() {
        let foliage = random();
        let level = level(&foliage, 6);
        let once = flattened(&foliage, &level);
        let twice = flattened(&once, &level);
        let pairs = once.groups.iter().zip(&twice.groups);
        for (one, other) in
            pairs.flat_map(|(one, other)| one.positions.iter().zip(&other.positions))
        {
            // A point on a plane is off it by rounding.
            assert!(one.distance(*other) < 1e-6, "{one} {other}");
        }
    }

    #[test]
    fn coplanar_leaves_stay() {
        let mut draws = Stream::new(21, 0).draws();
        // Leaves in y = 2 and, further away, in x = 6: their planes are found, and are exact.
        let mut positions: Vec<Vec3> = Vec::new();
        for _ in 0..40 {
            let mut flat = || [draws.signed(), draws.signed()];
            positions.extend([0; 4].map(|_| flat()).map(|[x, z]| Vec3::new(x, 2.0, z)));
            positions.extend([0; 4].map(|_| flat()).map(|[y, z]| Vec3::new(6.0, y, z)));
        }
        let foliage = Foliage {
            groups: vec![quads(positions)],
        };
        let flat = flattened(&foliage, &level(&foliage, 2));
        let pairs = foliage.groups[0]
            .positions
            .iter()
            .zip(&flat.groups[0].positions);
        for (before, after) in pairs {
            assert!(before.distance(*after) < 1e-6, "{before} {after}");
        }
    }
}
