//! Foliage keeps its mass: pixels and area at half, a quarter and a tenth of the leaves.

use std::path::Path;
use std::sync::Arc;

use spinney::models::State;
use spinney::plant::{Species, grow};
use spinney::run::{crown, mass};

fn assert_mass(species: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes/species")
        .join(species);
    let species = Species::read(&path).expect("a shipped species");
    let plant = grow(&species, 1).expect("a shipped species grows");
    let crown = Arc::new(crown(plant, species.stop_leaves));
    let leaves = crown.sequence().original_count();
    let states = [leaves, leaves / 2, leaves / 4, leaves / 10].map(|left| State::Uniform {
        collapses: leaves - left,
    });
    let masses = mass(&crown, &states).expect("memory without bounds");
    let share = masses[0].share_of_disc();
    assert!(
        (0.25..=0.75).contains(&share),
        "{share} of the disc at full detail"
    );
    for one in &masses[1..] {
        let (mean, _) = one.against(&masses[0]);
        let area = one.area / masses[0].area;
        assert!(
            (0.9..=1.1).contains(&mean),
            "{mean} of the pixels at {} leaves",
            one.leaves
        );
        assert!(
            (0.95..=1.05).contains(&area),
            "{area} of the area at {} leaves",
            one.leaves
        );
        assert_eq!(one.folded, 0, "folded at {} leaves", one.leaves);
    }
}

#[test]
fn a_yew_keeps_its_mass() {
    assert_mass("taxus_baccata.toml");
}

#[test]
fn a_birch_keeps_its_mass() {
    assert_mass("betula_lenta.toml");
}
