//! Prints how foliage keeps its mass while its leaves are collapsed: covered pixels from 26
//! directions, mean and worst, at a quarter and a twentieth of the leaves, once with the area kept
//! and once where it may rise to 108 %.
//!
//! ```text
//! cargo run --release --example mass -- scenes/species/taxus_baccata.toml …
//! ```

#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use spinney::models::{Crown, State};
use spinney::plant::{Species, grow};
use spinney::run::mass;
use spinney::simplify::{LeafCollapseOptions, collapse_leaves};

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "| tree | area aimed at | leaves | covered pixels | worst view | leaf area | folded |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for path in std::env::args().skip(1) {
        let species = Species::read(Path::new(&path))?;
        let plant = Arc::new(grow(&species, 1)?);
        let all = u32::try_from(plant.foliage().quad_count())?;
        let stop_leaves = species.stop_leaves.unwrap_or(all / 75).min(all / 20);
        for area_gain in [1.0, 1.08] {
            let options = LeafCollapseOptions {
                area_gain,
                ..LeafCollapseOptions::to(stop_leaves)
            };
            let sequence = collapse_leaves(plant.foliage(), &options);
            let most = sequence.collapse_count();
            let crown = Arc::new(Crown::new(Arc::clone(&plant), sequence));
            let states = [all, all / 4, all / 20].map(|left| State::Uniform {
                collapses: (all - left).min(most),
            });
            let masses = mass(&crown, &states)?;
            for one in &masses[1..] {
                let (mean, worst) = one.against(&masses[0]);
                println!(
                    "| {} | {:.0} % | {} | {mean:.3} | {worst:.3} | {:.3} | {} |",
                    species.latin,
                    100.0 * area_gain,
                    one.leaves,
                    one.area / masses[0].area,
                    one.folded,
                );
            }
        }
    }
    Ok(())
}
