//! Prints a line for everything that must be the same on every machine: every golden frame's picture
//! and ledger, plants, collapses, models, larger frames.
//!
//! ```text
//! cargo run --release --example digests -- --threads 7
//! ```
//!
//! The lines of two builds or machines are compared with `diff`; `.ci/digests` does so for debug and
//! release with 1, 2 and 7 threads. The lines after the golden frames are `golden/digests.txt`.

use std::io::{BufWriter, Write as _};

#[path = "../tests/golden/digests.rs"]
mod digests;
#[path = "../tests/golden/scenes.rs"]
mod scenes;
#[path = "../tests/golden/table.rs"]
mod table;

use scenes::GoldenScene;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let threads = threads(std::env::args().skip(1))?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let lines = pool.build()?.install(lines);
    let mut out = BufWriter::new(std::io::stdout().lock());
    for line in lines {
        writeln!(out, "{line}")?;
    }
    out.flush()?;
    Ok(())
}

/// The number after `--threads`; 0, as many as the machine has, where it is absent.
fn threads(mut arguments: impl Iterator<Item = String>) -> Result<usize, String> {
    match (arguments.next().as_deref(), arguments.next()) {
        (None, None) => Ok(0),
        (Some("--threads"), Some(count)) => {
            let wrong = |error| format!("--threads {count}: {error}");
            count.parse().map_err(wrong)
        }
        _ => Err("usage: digests [--threads N]".to_owned()),
    }
}

fn lines() -> Vec<String> {
    let mut lines = Vec::new();
    let mut tell = |name: &str, digests: &[spinney::math::Digest]| {
        let digests: Vec<String> = digests.iter().map(ToString::to_string).collect();
        lines.push(format!("{name} {}", digests.join(" ")));
    };
    for name in scenes::names() {
        let scene = GoldenScene::read(&name);
        if scene.golden().is_some() {
            digests::frames(&scene, &mut tell);
        }
    }
    digests::digests(&mut tell);
    lines
}
