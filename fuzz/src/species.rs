//! Species files: what is read grows, on a scale that takes milliseconds.

use spinney::plant::{Species, grow};

/// A species of 60 leaves.
pub(crate) const BUSH: &str = "schema = \"spinney.species/1\"
name = \"bush\"
leaf_count = 60
stop_leaves = 5
[crown]
levels = 2
scale = 2.0
[stems]
branches = [1.0, 9.0, 3.0, 3.0]
curve_res = [3, 2, 2, 1]
[wood]
tube_edges = [4, 3, 0, 0]
[[foliage]]
silhouette = \"round\"
length = 0.2
[[foliage]]
silhouette = \"rush\"
share = 0.5
color = \"#204020\"
";

/// Species files: parsed as they are, grown as a [`bonsai`].
pub fn species(bytes: &[u8]) {
    let Some(document) = crate::document("fuzz.toml", bytes) else {
        return;
    };
    let species = match Species::parse(&document) {
        Ok(species) => bonsai(species),
        Err(error) => {
            _ = error.to_string();
            return;
        }
    };
    for seed in [0, u64::MAX] {
        match grow(&species, seed) {
            Ok(plant) => {
                if let Some(leaves) = species.leaf_count {
                    assert_eq!(plant.foliage().leaf_count(), leaves as usize);
                }
                let bounds = plant.bounds();
                assert!(bounds.is_empty() || bounds.center().is_finite());
            }
            Err(error) => _ = error.to_string(),
        }
    }
}

/// The species with few stems and leaves: counts are lowered to what grows within milliseconds, and
/// everything that shapes, turns and sizes stays as it is.
fn bonsai(mut species: Species) -> Species {
    let few = |count: &mut u32, most| *count = (*count).min(most);
    few(&mut species.clump.count, 2);
    few(&mut species.wood.base_splits, 2);
    for edges in &mut species.wood.tube_edges {
        few(edges, 5);
    }
    for stem in &mut species.stems {
        few(&mut stem.curve_res, 5);
        stem.branches = stem.branches.min(3.0);
        stem.segment_splits = stem.segment_splits.min(0.4);
    }
    species.leaves.per_stem = species.leaves.per_stem.clamp(-6.0, 6.0);
    for count in [
        &mut species.leaf_count,
        &mut species.stop_leaves,
        &mut species.trunk_polygons,
    ] {
        *count = count.map(|count| count.min(300));
    }
    species
}
