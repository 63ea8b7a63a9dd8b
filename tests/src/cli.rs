//! The command line of the proof.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use reference_problems::context::Extent;
use reference_problems::record::{Recording, default_folder, workspace};
use scenes::cli::exit_code;
use verification::{cases, verify};

#[derive(Debug, Parser)]
#[command(
    name = "verification",
    bin_name = "cargo xtask",
    version,
    about = "The proof of the workspace"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run the cases and print what each claims; fails if a claim does not hold
    Verify(Verify),
    /// Commands of scenes, for cases that start processes
    #[command(subcommand, hide = true)]
    Scenes(scenes::cli::Command),
}

#[derive(Debug, Args)]
#[expect(clippy::struct_excessive_bools, reason = "flags of a command line")]
struct Verify {
    /// Part of a case id, or the id of a claim; none runs all
    #[arg(value_name = "FILTER")]
    filters: Vec<String>,
    #[command(flatten)]
    extent: Extent,
    /// Print every claim instead of one line per case
    #[arg(long)]
    claims: bool,
    /// List the claims whose tolerance is over ten times the error without a reason for it
    #[arg(long)]
    loose: bool,
    /// List the cases instead of running them
    #[arg(long)]
    list: bool,
    /// Write docs/verification.md too; from a commit alone, and whole
    #[arg(long)]
    record: bool,
    /// Say whether docs/verification.md is older than cases, scenes and references, instead of running them
    #[arg(long, conflicts_with_all = ["list", "record"])]
    stale: bool,
    /// Write a second copy of the report here
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Where report.json and index.html go [default: target/verify]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Reads the command line, runs it, and returns the exit code.
pub(crate) fn main() -> ExitCode {
    exit_code(execute(Cli::parse().command, &mut io::stdout().lock()))
}

fn execute(command: Command, output: &mut dyn Write) -> miette::Result<ExitCode> {
    match command {
        Command::Verify(arguments) => execute_verify(arguments, output),
        Command::Scenes(command) => scenes::cli::execute(command, output),
    }
}

fn execute_verify(arguments: Verify, output: &mut dyn Write) -> miette::Result<ExitCode> {
    if arguments.list {
        verify::list(cases::ALL, &arguments.filters, output)?;
        return Ok(ExitCode::SUCCESS);
    }
    if arguments.stale {
        verify::stale(cases::ALL, &workspace(), output)?;
        return Ok(ExitCode::SUCCESS);
    }
    let profile = arguments.extent.profile();
    let options = verify::Options {
        recording: Recording::requested(arguments.record, profile)?,
        profile,
        filters: arguments.filters,
        out: arguments.out.unwrap_or_else(|| default_folder("verify")),
        json: arguments.json,
        rows: if arguments.claims { verify::Rows::Claims } else { verify::Rows::Cases },
        loose: if arguments.loose { verify::Loose::Listed } else { verify::Loose::Counted },
    };
    let report = verify::verify(cases::ALL, &options, output)?;
    Ok(if report.failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
