//! Standard output and standard error.

use std::io::{ErrorKind, IsTerminal as _, Write as _};

use super::arguments::{Color, Shared};
use super::error::CliError;
use super::progress::Bar;

/// Where results, remarks and progress go.
#[derive(Debug)]
pub(super) struct Terminal {
    quiet: bool,
    color: bool,
    width: usize,
}

/// Columns where nobody says how many there are.
const USUAL_WIDTH: usize = 80;

impl Terminal {
    pub(super) fn new(shared: &Shared) -> Self {
        let color = match shared.color {
            Color::Always => true,
            Color::Never => false,
            Color::Auto => {
                std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none()
            }
        };
        let columns = std::env::var("COLUMNS")
            .ok()
            .and_then(|columns| columns.parse().ok());
        let width = columns.unwrap_or(USUAL_WIDTH).clamp(40, 400);
        Self {
            quiet: shared.quiet,
            color,
            width,
        }
    }

    /// Columns of the terminal.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// A sentence as lines of the terminal's width, words whole.
    pub(super) fn wrapped(&self, text: &str) -> String {
        let mut lines = String::new();
        let mut column = 0;
        for word in text.split_whitespace() {
            let length = word.chars().count();
            if column > 0 && column + 1 + length > self.width {
                lines.push('\n');
                column = 0;
            }
            if column > 0 {
                lines.push(' ');
                column += 1;
            }
            lines.push_str(word);
            column += length;
        }
        lines.push('\n');
        lines
    }

    /// Prints a result to standard output. A reader that went away is no error.
    pub(super) fn print(&self, text: &str) -> Result<(), CliError> {
        let mut out = std::io::stdout().lock();
        let newline = if text.ends_with('\n') { "" } else { "\n" };
        match write!(out, "{text}{newline}").and_then(|()| out.flush()) {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Write {
                place: "standard output".to_owned(),
                problem: error.to_string(),
            }),
            _ => Ok(()),
        }
    }

    /// Says something by the way, on standard error.
    pub(super) fn remark(&self, text: &str) {
        if !self.quiet {
            // Nobody is left to be told if this fails.
            _ = writeln!(std::io::stderr(), "{text}");
        }
    }

    /// Says what went wrong.
    pub(super) fn error(&self, error: &CliError) {
        let (red, plain) = if self.color {
            ("\x1b[1;31m", "\x1b[0m")
        } else {
            ("", "")
        };
        _ = writeln!(std::io::stderr(), "{red}error:{plain} {error}");
    }

    /// A progress bar on a terminal, nothing elsewhere.
    pub(super) fn progress(&self) -> Bar {
        Bar::new(!self.quiet && std::io::stderr().is_terminal())
    }

    /// Runs something with so many threads, all there are without a number.
    pub(super) fn within_threads<T: Send>(
        &self,
        threads: Option<u16>,
        work: impl FnOnce() -> T + Send,
    ) -> T {
        let pool = threads.and_then(|threads| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(usize::from(threads))
                .build()
                .ok()
        });
        match pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }
}

/// Prints what `clap` has to say: help and version are results, the rest is bad usage.
pub(super) fn usage(error: &clap::Error) -> u8 {
    // Nobody is left to be told if this fails.
    _ = error.print();
    if error.use_stderr() { 2 } else { 0 }
}
