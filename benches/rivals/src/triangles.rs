//! Leaves as triangles over their own vertices, and back.

use spinney::plant::{Foliage, LeafGroup, NO_BRANCH, Prototype};

/// The triangles of a group's leaves, 0-1-2 and 0-2-3 of each: three vertex indices a triangle.
pub fn triangles(group: &LeafGroup) -> Vec<u32> {
    let leaves = 0..u32::try_from(group.leaf_count()).expect("leaves are fewer by limit");
    let corners = leaves.flat_map(|leaf| [0, 1, 2, 0, 2, 3].map(|role| 4 * leaf + role));
    corners.collect()
}

/// Foliage of triangles over the vertices of a group: each becomes a leaf whose fourth corner is its
/// third, so that its normal, the cross product of the diagonals, is the triangle's.
///
/// Texture coordinates of a leaf go with its group, so triangles that take other corners of the image
/// come in other groups: at most 4³.
///
/// # Panics
///
/// When the group's leaves are no quads.
pub fn leaves(group: &LeafGroup, indices: &[u32]) -> Vec<LeafGroup> {
    let Prototype::Quad { texture_corners } = &group.prototype else {
        panic!("only quads are simplified");
    };
    let roles = (0..64).map(|code| [code / 16, code / 4 % 4, code % 4]);
    let of_roles = |roles: [u32; 3]| {
        let triangles = indices.as_chunks::<3>().0.iter();
        let fitting = triangles.filter(|triangle| triangle.map(|vertex| vertex % 4) == roles);
        let positions = fitting
            .flat_map(|&[a, b, c]| [a, b, c, c].map(|vertex| group.positions[vertex as usize]));
        let positions: Vec<_> = positions.collect();
        let [a, b, c] = roles.map(|role| texture_corners[role as usize]);
        LeafGroup {
            name: group.name.clone(),
            prototype: Prototype::Quad {
                texture_corners: [a, b, c, c],
            },
            material: group.material.clone(),
            owners: vec![NO_BRANCH; positions.len() / 4],
            positions,
        }
    };
    roles
        .map(of_roles)
        .filter(|group| group.leaf_count() > 0)
        .collect()
}

/// Foliage in which `change` has made other groups of each group of quads; it is told how many of
/// `leaves` leaves are the group's, in proportion.
pub fn by_group(
    foliage: &Foliage,
    leaves: u32,
    mut change: impl FnMut(&LeafGroup, u32) -> Vec<LeafGroup>,
) -> Foliage {
    let all = foliage.quad_count() as u64;
    // What is left of earlier groups goes to the next, so that the sum is exact.
    let (mut before, mut given) = (0, 0);
    let groups = foliage.quad_groups().flat_map(|(group, _)| {
        before += group.leaf_count() as u64;
        let until = before * u64::from(leaves) / all;
        let share = u32::try_from(until - given).expect("a part of a u32");
        given = until;
        change(group, share)
    });
    Foliage {
        groups: groups.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use spinney::math::{Vec2, Vec3};

    fn two_leaves() -> LeafGroup {
        let corner = |index: u8| Vec3::new(f32::from(index % 4), f32::from(index), 0.0);
        LeafGroup {
            name: "leaves".to_owned(),
            prototype: Prototype::Quad {
                texture_corners: Prototype::WHOLE_IMAGE,
            },
            material: spinney::plant::Material::plain("leaf", [1.0; 3]),
            positions: (0..8).map(corner).collect(),
            owners: vec![NO_BRANCH; 2],
        }
    }

    #[test]
    fn triangles_keep_their_places_and_texture_corners() {
        let group = two_leaves();
        let indices = triangles(&group);
        assert_eq!(indices, [0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7]);
        let groups = leaves(&group, &indices);
        assert_eq!(groups.len(), 2, "0-1-2 and 0-2-3");
        let back: Vec<usize> = groups.iter().map(LeafGroup::leaf_count).collect();
        assert_eq!(back, [2, 2]);
        let [first, third, fourth] = [0, 2, 3].map(|role| Prototype::WHOLE_IMAGE[role]);
        assert_eq!(
            groups[1].prototype,
            Prototype::Quad {
                texture_corners: [first, third, fourth, fourth] as [Vec2; 4]
            }
        );
        let wanted = [0, 2, 3, 3, 4, 6, 7, 7].map(|vertex: usize| group.positions[vertex]);
        assert_eq!(groups[1].positions, wanted);
    }

    #[test]
    fn shares_of_groups_sum_to_all() {
        let foliage = Foliage {
            groups: vec![two_leaves(), two_leaves(), two_leaves()],
        };
        let mut shares = Vec::new();
        by_group(&foliage, 4, |_, share| {
            shares.push(share);
            Vec::new()
        });
        assert_eq!(shares, [1, 1, 2]);
    }
}
