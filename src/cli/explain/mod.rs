//! `spinney explain`: what a pixel of a run shows, or where two runs part.

mod facts;
mod pixel;
mod runs;

use serde::Serialize;

use super::Verdict;
use super::arguments::{ExplainOptions, Shared};
use super::error::CliError;
use super::terminal::Terminal;
use crate::explain::{RecordedRun, explain_pixel, explain_runs};

pub(super) fn explain(
    options: &ExplainOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<Verdict, CliError> {
    let progress = terminal.progress();
    let (text, holds) = match (options.runs.as_slice(), options.pixel) {
        ([run], Some((x, y))) => {
            let run = RecordedRun::read(run)?;
            let report = explain_pixel(&run, options.frame, [x, y], &progress)?;
            let text = match shared.json {
                true => json(&report),
                false => pixel::text(&report, terminal.width()),
            };
            (text, report.frame.same && report.agrees)
        }
        ([a, b], None) if options.frame.is_none() => {
            let (a, b) = (RecordedRun::read(a)?, RecordedRun::read(b)?);
            let report = explain_runs(&a, &b, &progress)?;
            let text = match shared.json {
                true => json(&report),
                false => runs::text(&report, terminal.width()),
            };
            (text, report.same)
        }
        _ => {
            let wanted = "wanted one run with --pixel X,Y (and --frame N), or two runs without";
            return Err(CliError::Usage(wanted.to_owned()));
        }
    };
    drop(progress);
    terminal.print(&text)?;
    Ok(match holds {
        true => Verdict::Passed,
        false => Verdict::Failed,
    })
}

fn json(report: &impl Serialize) -> String {
    serde_json::to_string_pretty(report).expect("keys are texts, values numbers and texts")
}
