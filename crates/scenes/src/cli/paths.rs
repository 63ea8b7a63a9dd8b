//! Prints the paths of written files.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Prints the paths, one a line.
pub(super) fn print_paths(written: &[PathBuf], output: &mut dyn Write) -> miette::Result<ExitCode> {
    for path in written {
        writeln!(output, "{}", path.display()).map_err(miette::Report::from_err)?;
    }
    Ok(ExitCode::SUCCESS)
}
