//! Command line of charts and stability maps.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use scenes::cli::exit_code;

use crate::{charts, draw};
use reference_problems::context::Extent;
use reference_problems::record::{self, Recording};

#[derive(Debug, Parser)]
#[command(
    name = "work-precision",
    bin_name = "cargo xtask",
    version,
    about = "Charts of error against cost, and stability maps"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Draw error against cost
    Chart(Chart),
    /// Sweep methods over two parameters to where they fail
    Stability(Drawn),
    /// Commands of scenes, for charts that start processes
    #[command(subcommand, hide = true)]
    Scenes(scenes::cli::Command),
}

#[derive(Debug, Args)]
struct Chart {
    /// Run each scene without one of its ingredients at a time, and report which of them its results need
    #[arg(long)]
    ladder: bool,
    #[command(flatten)]
    drawn: Drawn,
}

#[derive(Debug, Args)]
struct Drawn {
    /// Names, as --list prints them; none draws all
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    #[command(flatten)]
    extent: Extent,
    /// List the names instead of drawing
    #[arg(long)]
    list: bool,
    /// Also write into docs/charts, with a page of all pictures there; requires a clean commit
    #[arg(long)]
    record: bool,
    /// Where the pictures go [default: target/chart, target/stability]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Parses the command line, runs the command, and returns the exit code.
pub fn main() -> ExitCode {
    exit_code(execute(Cli::parse().command, &mut io::stdout().lock()))
}

fn execute(command: Command, output: &mut dyn Write) -> miette::Result<ExitCode> {
    match command {
        Command::Chart(Chart { ladder: true, drawn }) => {
            execute_chart(charts::MODELS, "model ladder", drawn, output)
        }
        Command::Chart(Chart { ladder: false, drawn }) => {
            execute_chart(charts::ALL, "chart", drawn, output)
        }
        Command::Stability(arguments) => {
            execute_chart(charts::STABILITY, "stability sweep", arguments, output)
        }
        Command::Scenes(command) => scenes::cli::execute(command, output),
    }
}

fn execute_chart(
    table: &[draw::ChartKind],
    what: &'static str,
    arguments: Drawn,
    output: &mut dyn Write,
) -> miette::Result<ExitCode> {
    if arguments.list {
        draw::list(table, what, output)?;
        return Ok(ExitCode::SUCCESS);
    }
    let folder = if what == "stability sweep" { "stability" } else { "chart" };
    let profile = arguments.extent.profile();
    let options = draw::Options {
        what,
        names: arguments.names,
        recording: Recording::requested(arguments.record, profile)?,
        profile,
        out: arguments.out.unwrap_or_else(|| record::default_folder(folder)),
    };
    draw::draw(table, &options, output)?;
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;
    use reference_problems::context::Profile;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn quick_and_full_exclude_each_other() {
        assert!(Cli::try_parse_from(["x", "chart", "--quick", "--full"]).is_err());
        let cli = Cli::try_parse_from(["x", "chart", "fpk", "--quick"]).unwrap();
        let Command::Chart(arguments) = cli.command else { panic!("not chart") };
        assert_eq!(arguments.drawn.extent.profile(), Profile::Quick);
        assert!(Recording::requested(true, Profile::Quick).is_err());
        assert_eq!(Recording::requested(false, Profile::Quick).unwrap(), Recording::Off);
    }
}
