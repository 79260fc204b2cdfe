//! Spinney's side of the race: draws what a peer draws, and tells how long its frames took.
//!
//! ```text
//! peer.py dump ─▶ folder ─Stage─▶ device ─ time(submit) ─▶ one line of JSON, a PNG at the end
//! ```
//!
//! `race.py` runs both sides in turn; `README.md` tells what is compared. Only the public API of
//! spinney is used.

mod clock;
mod dump;
mod growth;
mod hulls;
mod leaves;
mod light;
mod lines;
mod mesh;
mod stage;
mod texels;

use std::path::PathBuf;
use std::time::Instant;

use clock::{Schedule, time};
use growth::{GrowthOptions, growth};
use spinney::raster::Counters;
use stage::Stage;

/// Why something did not work; it is printed, and that is all.
pub(crate) type Fault = Box<dyn std::error::Error + Send + Sync>;

const USAGE: &str = "usage:
  spinney-peers draw DUMP [--threads N] [--frames N] [--warmup N] [--max-seconds S] [--label TEXT]
                [--out FILE.png] [--exact]
  spinney-peers growth SPECIES.toml OUT [--most TRIANGLES] [--frames N] [--max-seconds S]";

fn main() -> Result<(), Fault> {
    let mut arguments = std::env::args().skip(1);
    match arguments.next().as_deref() {
        Some("draw") => draw(&Options::read(arguments)?),
        Some("growth") => growth(&GrowthOptions::read(arguments)?),
        _ => Err(USAGE.into()),
    }
}

struct Options {
    folder: PathBuf,
    threads: usize,
    schedule: Schedule,
    label: String,
    out: Option<PathBuf>,
    counters: Counters,
}

impl Options {
    fn read(mut arguments: impl Iterator<Item = String>) -> Result<Self, Fault> {
        let mut options = Self {
            folder: PathBuf::from(arguments.next().ok_or(USAGE)?),
            threads: 2,
            schedule: Schedule {
                warmup: 2,
                frames: 15,
                most_seconds: 60.0,
            },
            label: String::new(),
            out: None,
            counters: Counters::Visible,
        };
        while let Some(name) = arguments.next() {
            let mut value = || arguments.next().ok_or(USAGE);
            match name.as_str() {
                "--threads" => options.threads = value()?.parse()?,
                "--frames" => options.schedule.frames = value()?.parse()?,
                "--warmup" => options.schedule.warmup = value()?.parse()?,
                "--max-seconds" => options.schedule.most_seconds = value()?.parse()?,
                "--label" => options.label = value()?,
                "--out" => options.out = Some(PathBuf::from(value()?)),
                "--exact" => options.counters = Counters::Exact,
                _ => return Err(USAGE.into()),
            }
        }
        Ok(options)
    }
}

/// Draws a dump, and prints what the peers' scripts print, by the same names.
fn draw(options: &Options) -> Result<(), Fault> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build()?;
    pool.install(|| {
        let begin = Instant::now();
        let mut stage = Stage::of(&options.folder, options.counters)?;
        let setup = begin.elapsed().as_secs_f64();
        let begin = Instant::now();
        stage.frame()?;
        let first = 1e3 * begin.elapsed().as_secs_f64();
        let ledger = stage.ledger();
        let between = |stage: &mut Stage| drop(stage.ledger());
        let frames = time(options.schedule, &mut stage, Stage::frame, between)?;
        let begin = Instant::now();
        let picture = stage.picture()?;
        let readback = 1e3 * begin.elapsed().as_secs_f64();
        if let Some(file) = &options.out {
            std::fs::write(file, picture.to_png()?)?;
        }
        let rounded = |value: f64| (1e3 * value).round() / 1e3;
        let [shortest, longest] = frames.ends();
        let what = if stage.draws_lines { "lines" } else { "triangles" };
        let mut report = serde_json::json!({
            "label": options.label, "frames": frames.sorted.len(), "threads": options.threads,
            "ms_median": rounded(frames.median()), "ms_min": rounded(shortest), "ms_max": rounded(longest),
            what: stage.primitives, "in_quads": stage.in_quads,
            "cpu_ms_per_frame": rounded(frames.own), "others_cpu": rounded(frames.others),
            "width": stage.size[0], "height": stage.size[1], "vertices": ledger.vertices,
            "draws": ledger.draws, "fragments_passed": ledger.visible_samples,
            "covered_px": stage.covered_pixels()?, "first_frame_ms": rounded(first),
            "setup_s": rounded(setup), "readback_ms": rounded(readback),
            "api": "spinney::gpu", "renderer": "spinney",
        });
        if let Some(work) = ledger.work {
            report["covered_samples"] = work.covered.into();
        }
        println!("{report}");
        Ok(())
    })
}
