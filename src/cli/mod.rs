//! The command line: parse, call, print; the only place that prints or reads the environment.
//!
//! | exit code | meaning |
//! |---|---|
//! | 0 | done, or the same |
//! | 1 | differs, or a check failed |
//! | 2 | bad usage or input |
//! | 3 | out of a stated budget |
//! | 4 | cannot write |

mod arguments;
mod branches;
mod build;
mod bytes;
mod cache;
mod check_trace;
mod compare;
mod diff;
mod error;
mod explain;
mod frame_folder;
mod golden;
mod grow;
mod inspect;
mod merge;
mod own_tree;
mod paint;
mod parallax;
mod prepare;
// WebAssembly has no terminal to draw a bar on.
#[cfg_attr(target_family = "wasm", path = "progress_none.rs")]
mod progress;
mod run;
mod selftest;
mod stand_ins;
mod step;
mod storage;
mod sweep;
mod terminal;
mod tree_arguments;

use std::ffi::OsString;

use clap::Parser as _;

use arguments::{Arguments, Command, Topic};
use error::CliError;
use terminal::Terminal;

/// Runs the program with these arguments, the first being its own name, and returns its exit code.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => return terminal::usage(&error),
    };
    let terminal = Terminal::new(&arguments.shared);
    match terminal.within_threads(arguments.shared.threads, || dispatch(&arguments, &terminal)) {
        Ok(Verdict::Passed) => 0,
        Ok(Verdict::Failed) => 1,
        Err(error) => {
            terminal.error(&error);
            error.code()
        }
    }
}

/// How a command ended that did what it was asked to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    /// Done, or the same.
    Passed,
    /// Differs, or a check failed; the command has said so.
    Failed,
}

fn dispatch(arguments: &Arguments, terminal: &Terminal) -> Result<Verdict, CliError> {
    let shared = &arguments.shared;
    let done = match &arguments.command {
        Command::CheckTrace(options) => return check_trace::check_trace(options, shared, terminal),
        Command::Paint(options) => return paint::paint(options, shared, terminal),
        Command::StandIns(options) => return stand_ins::stand_ins(options, shared, terminal),
        Command::Branches(options) => return branches::branches(options, shared, terminal),
        Command::Selftest => return selftest::selftest(shared, terminal),
        Command::Diff(options) => return diff::diff(options, shared, terminal),
        Command::Golden(options) => return golden::golden(options, shared, terminal),
        Command::Explain(options) => return explain::explain(options, shared, terminal),
        Command::Run(options) => run::run(options, shared, terminal),
        Command::Sweep(options) => sweep::sweep(options, shared, terminal),
        Command::Step(options) => step::step(options, shared, terminal),
        Command::Parallax(options) => parallax::parallax(options, shared, terminal),
        Command::Merge(options) => merge::merge(options, shared, terminal),
        Command::Storage(options) => storage::storage(options, shared, terminal),
        Command::Build(options) => build::build(options, shared, terminal),
        Command::Compare(options) => compare::compare(options, shared, terminal),
        Command::Inspect(options) => inspect::inspect(options, shared, terminal),
        Command::Grow(options) => grow::grow(options, shared, terminal),
        Command::Help(options) => match options.topic {
            Some(Topic::Scene) => terminal.print(&crate::scene::key_help()),
            Some(Topic::Limits) => terminal.print(&crate::limits::limit_help()),
            Some(Topic::Species) => terminal.print(crate::plant::Species::HELP),
            None => terminal.print(&arguments::long_help()),
        },
    };
    done.map(|()| Verdict::Passed)
}
