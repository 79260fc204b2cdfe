//! The `spinney` program: arguments in, exit code out.

fn main() {}
