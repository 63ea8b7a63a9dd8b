//! The `scenes` command: run, advise, merge, schema.

use std::process::ExitCode;

fn main() -> ExitCode {
    scenes::cli::main()
}
