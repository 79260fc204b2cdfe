//! The `spinney` program: arguments in, exit code out.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(spinney::cli::main(std::env::args_os()))
}
