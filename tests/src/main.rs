//! The `verification` command: verify, run, chart.

fn main() {}
