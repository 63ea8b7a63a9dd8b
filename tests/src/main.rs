//! The `verification` command: verify, run, chart, stability.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
