//! Wall clock by stage.

fn main() {}
