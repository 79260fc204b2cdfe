//! Prints how foliage keeps its mass while its leaves are collapsed.
//!
//! ```text
//! cargo run --release --example mass -- scenes/species/taxus_baccata.toml …
//! ```

#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use spinney::models::State;
use spinney::plant::{Species, grow};
use spinney::run::{crown, mass};

fn main() -> Result<(), Box<dyn Error>> {
    println!("| tree | leaves | covered pixels | worst view | leaf area | folded | of the disc |");
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for path in std::env::args().skip(1) {
        let species = Species::read(Path::new(&path))?;
        let crown = Arc::new(crown(grow(&species, 1)?, species.stop_leaves));
        let all = crown.sequence().original_count();
        let collapses = [1, 2, 4, 10].map(|part| all - all / part);
        let most = crown.sequence().collapse_count();
        let states = collapses.map(|collapses| State::Uniform {
            collapses: collapses.min(most),
        });
        let masses = mass(&crown, &states)?;
        for one in &masses {
            let (mean, worst) = one.against(&masses[0]);
            println!(
                "| {} | {} | {:.3} | {:.3} | {:.3} | {} | {:.1} % |",
                species.latin,
                one.leaves,
                mean,
                worst,
                one.area / masses[0].area,
                one.folded,
                100.0 * one.share_of_disc()
            );
        }
    }
    Ok(())
}
