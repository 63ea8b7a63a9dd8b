//! The `work-precision` command: chart, stability.

use std::process::ExitCode;

fn main() -> ExitCode {
    work_precision::cli::main()
}
