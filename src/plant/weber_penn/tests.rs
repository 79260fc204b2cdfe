//! The shipped species, and what growing promises of any.

use std::path::Path;

use super::*;

/// The eleven trees of the papers' Table I and how many leaves they have.
const TABLE_1: [(&str, u32); 2] = [("betula_lenta", 20376), ("taxus_baccata", 48160)];

fn species(name: &str) -> Species {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/species");
    Species::read(&folder.join(format!("{name}.toml"))).expect("shipped species are sound")
}

#[test]
fn table_1_is_met_to_the_leaf_with_at_most_3_percent_thinned() {
    for (name, leaves) in TABLE_1 {
        let species = species(name);
        assert_eq!(species.leaf_count, Some(leaves), "{name}");
        let leaves = leaves as usize;
        let wood = branching::grow_wood(&species, Stream::new(1, 0)).unwrap();
        let surplus = leaves::surplus(&species, &wood).unwrap();
        assert!(surplus <= leaves * 3 / 100, "{name} thins out {surplus}");
        let plant = grow(&species, 1).unwrap();
        assert_eq!(plant.foliage().leaf_count(), leaves, "{name}");
        assert_eq!(plant.foliage().quad_count(), leaves, "{name}");
        assert_eq!(
            plant.digest(),
            grow(&species, 1).unwrap().digest(),
            "{name}"
        );
        assert_ne!(
            plant.digest(),
            grow(&species, 2).unwrap().digest(),
            "{name}"
        );
    }
}
