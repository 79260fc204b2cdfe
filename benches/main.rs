//! Wall clock by stage, for our own code: `cargo bench --bench stages -- raster`.
//!
//! Names are `stage/case/size`. What a scheme costs is counted elsewhere; these numbers are asserted
//! and reported nowhere.

mod models;
mod plant;
mod raster;
mod simplify;
mod strokes;
mod yew;

use std::time::Duration;

use criterion::Criterion;

fn main() {
    // Few and short: the cases take from microseconds to a second.
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2))
        .configure_from_args();
    plant::bench(&mut criterion);
    simplify::bench(&mut criterion);
    raster::bench(&mut criterion);
    models::bench(&mut criterion);
    strokes::bench(&mut criterion);
    criterion.final_summary();
}
