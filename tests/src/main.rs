//! The `verification` command: verify.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
