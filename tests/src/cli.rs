//! The command line: words to options, errors to exit codes.

mod ranks;

use std::io::{self, Write};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Args, Parser, Subcommand};
use verification::case::Profile;
use verification::checkpoint::Start;
use verification::record::Recording;
use verification::scenes::Part;
use verification::{advise, cases, charts, output, scenes, schema, verify};

/// Exit code of a program whose reader went away.
const BROKEN_PIPE: u8 = 141;

#[derive(Debug, Parser)]
#[command(
    name = "verification",
    bin_name = "cargo xtask",
    version,
    about = "The proof of the workspace: cases, scenes, charts"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run the cases and print what each claims; fails if a claim does not hold
    Verify(Verify),
    /// Run a scene file
    Run(Run),
    /// Name the cheapest method and size for a tolerance on a scene, from short trial runs
    Advise(Advise),
    /// Join the shards of a scene to the result of one run
    Merge(Merge),
    /// Draw error against cost
    Chart(Chart),
    /// Sweep methods to where they fail
    Stability(Drawn),
    /// Write the schemas of scenes and the page of all their keys
    Schema(Schema),
}

#[derive(Debug, Args)]
struct Verify {
    /// Part of a case id, or the id of a claim; none runs all
    #[arg(value_name = "FILTER")]
    filters: Vec<String>,
    #[command(flatten)]
    extent: Extent,
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

#[derive(Debug, Args)]
struct Run {
    /// A scene, e.g. tests/scenes/fpk/viscous_damper.json
    #[arg(value_name = "SCENE.json")]
    scene: PathBuf,
    /// Where the results go
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Threads of parallel loops; the results are the same for any number [default: all processors, or 1 for each rank of mpirun]
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// A seed in place of that of the scene
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// Go on from the last checkpoint in DIR, to the same bits; its end may have been earlier
    #[arg(long)]
    resume: bool,
    /// Start from the beginning over the checkpoint in DIR of a run that has not come to its end, which is refused otherwise
    #[arg(long, conflicts_with = "resume")]
    overwrite: bool,
    /// The least time between two checkpoints
    #[arg(long, value_name = "SECONDS", default_value_t = scenes::Options::CHECKPOINT_EVERY.as_secs())]
    checkpoint_every: u64,
    /// Run shard K of N of an ensemble, which `merge` joins
    #[arg(long, value_name = "K/N", conflicts_with = "tolerance")]
    shard: Option<scenes::Place>,
    /// Run an ensemble block by block as ranks of mpirun do, in this process: each block is kept in a file, and job.json tells what
    /// it took
    #[arg(long, conflicts_with_all = ["shard", "tolerance"])]
    blocks: bool,
    /// The largest error over the value, e.g. 1e-2: the scene's own method, at the size that short trial runs say it needs
    #[arg(long, value_name = "T")]
    tolerance: Option<f64>,
    #[command(flatten)]
    wanted: Wanted,
}

#[derive(Debug, Args)]
struct Advise {
    /// A scene, e.g. tests/scenes/fpk/viscous_damper.json
    #[arg(value_name = "SCENE.json")]
    scene: PathBuf,
    #[command(flatten)]
    wanted: Wanted,
    /// The largest error over the value, e.g. 1e-2
    #[arg(long, value_name = "T")]
    tolerance: f64,
}

/// What is asked of trial runs.
#[derive(Debug, Args)]
struct Wanted {
    /// CPU seconds that no trial run may be expected to exceed; the first of each method is always made
    #[arg(long, value_name = "SECONDS", default_value_t = advise::Options::BUDGET)]
    budget: f64,
    /// The beginning of the id of a quantity, e.g. moment/ or exceedance/1; may be repeated; none asks for all
    #[arg(long = "quantity", value_name = "ID")]
    quantities: Vec<String>,
}

impl Wanted {
    fn within(self, tolerance: f64) -> advise::Options {
        let Self { budget, quantities } = self;
        advise::Options { tolerance, budget, quantities }
    }
}

#[derive(Debug, Args)]
struct Merge {
    /// The scene that the shards are of
    #[arg(value_name = "SCENE.json")]
    scene: PathBuf,
    /// Files that `run --shard` has left, all of them, in any order
    #[arg(value_name = "SHARD", required = true)]
    shards: Vec<PathBuf>,
    /// Where the results go
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// The seed that the shards were run with, where it is not that of the scene
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
}

#[derive(Debug, Args)]
struct Chart {
    /// Leave out one ingredient of each scene at a time instead, and tell which of them its answers need
    #[arg(long)]
    ladder: bool,
    #[command(flatten)]
    drawn: Drawn,
}

#[derive(Debug, Args)]
struct Drawn {
    /// Names, as --list shows them; none draws all
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    #[command(flatten)]
    extent: Extent,
    /// List the names instead of drawing
    #[arg(long)]
    list: bool,
    /// Write into docs/charts too, with a page of all pictures there; from a commit alone
    #[arg(long)]
    record: bool,
    /// Where the pictures go [default: target/chart, target/stability]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Debug, Args)]
struct Schema {
    /// Write into docs instead of target/schema
    #[arg(long)]
    record: bool,
}

#[derive(Debug, Clone, Copy, Args)]
#[group(multiple = false)]
struct Extent {
    /// The cheapest part, at most 3 minutes
    #[arg(long)]
    quick: bool,
    /// Everything, at most 90 minutes
    #[arg(long)]
    full: bool,
}

impl Extent {
    const fn profile(self) -> Profile {
        match (self.quick, self.full) {
            (true, _) => Profile::Quick,
            (_, true) => Profile::Full,
            _ => Profile::Default,
        }
    }
}

/// Reads the command line, runs it, and turns what comes of it into an exit code.
pub(crate) fn main() -> ExitCode {
    let cli = Cli::parse();
    match execute(cli.command, &mut io::stdout().lock()) {
        Ok(code) => code,
        Err(report) if is_broken_pipe(&report) => ExitCode::from(BROKEN_PIPE),
        Err(report) => {
            // With stderr gone there is nobody to tell; the exit code still says it.
            let _ = writeln!(io::stderr(), "{report:?}");
            ExitCode::FAILURE
        }
    }
}

fn execute(command: Command, output: &mut dyn Write) -> miette::Result<ExitCode> {
    match command {
        Command::Verify(arguments) => execute_verify(arguments, output),
        Command::Run(arguments) => execute_run(arguments, output),
        Command::Advise(Advise { scene, wanted, tolerance }) => {
            let (options, progress) = (wanted.within(tolerance), scenes::Progress::on_stderr());
            let advice = advise::advise(scenes::ALL, &scene, &options, &progress);
            progress.finish();
            advise::print(&advice?, output)?;
            Ok(ExitCode::SUCCESS)
        }
        Command::Merge(Merge { scene, shards, out, seed }) => {
            let part = Part::Merged(shards);
            run_scene(&scene, &scenes::Options { seed, part, ..scenes::Options::new(out) }, output)
        }
        Command::Chart(Chart { ladder: true, drawn }) => {
            execute_chart(charts::MODELS, "ladder of models", drawn, output)
        }
        Command::Chart(Chart { ladder: false, drawn }) => {
            execute_chart(charts::ALL, "chart", drawn, output)
        }
        Command::Stability(arguments) => {
            execute_chart(charts::STABILITY, "stability sweep", arguments, output)
        }
        Command::Schema(arguments) => execute_schema(&arguments, output),
    }
}

fn execute_verify(arguments: Verify, output: &mut dyn Write) -> miette::Result<ExitCode> {
    if arguments.list {
        verify::list(cases::ALL, &arguments.filters, output)?;
        return Ok(ExitCode::SUCCESS);
    }
    if arguments.stale {
        verify::stale(cases::ALL, &output::workspace(), output)?;
        return Ok(ExitCode::SUCCESS);
    }
    let profile = arguments.extent.profile();
    let options = verify::Options {
        recording: recording(arguments.record, profile)?,
        profile,
        filters: arguments.filters,
        out: arguments.out.unwrap_or_else(|| output::default_folder("verify")),
        json: arguments.json,
    };
    let report = verify::verify(cases::ALL, &options, output)?;
    Ok(if report.failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn execute_run(arguments: Run, output: &mut dyn Write) -> miette::Result<ExitCode> {
    let started = ranks::started();
    // Ranks are as many as there are cores.
    let threads = arguments.threads.or(started.is_some().then_some(NonZeroUsize::MIN));
    if let Some(threads) = threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get());
        pool.build_global().map_err(miette::Report::from_err)?;
    }
    let options = scenes::Options {
        out: arguments.out,
        seed: arguments.seed,
        start: match (arguments.resume, arguments.overwrite) {
            (true, _) => Start::GoOn,
            (_, true) => Start::Overwrite,
            _ => Start::Anew,
        },
        checkpoint_every: Duration::from_secs(arguments.checkpoint_every),
        part: arguments.shard.map_or(Part::Whole, Part::Shard),
    };
    if let Some(n_ranks) = started {
        if arguments.tolerance.is_some() {
            return Err(miette::miette!(
                "--tolerance tries sizes in one process: leave out mpirun"
            ));
        }
        return ranks::run_scene(n_ranks, &arguments.scene, &options, output);
    }
    if arguments.blocks {
        return ranks::run_alone(&arguments.scene, &options, output);
    }
    match arguments.tolerance {
        None => run_scene(&arguments.scene, &options, output),
        Some(tolerance) => {
            let wanted = arguments.wanted.within(tolerance);
            run_within(&arguments.scene, &options, &wanted, output)
        }
    }
}

/// Fails where the run itself tells a larger error than was asked for.
fn run_within(
    scene: &Path,
    options: &scenes::Options,
    wanted: &advise::Options,
    output: &mut dyn Write,
) -> miette::Result<ExitCode> {
    let progress = scenes::Progress::on_stderr();
    let ran = advise::run_within(scenes::ALL, scene, options, wanted, &progress);
    progress.finish();
    let within = ran?;
    advise::print_within(&within, wanted, output)?;
    Ok(if within.is_reached(wanted.tolerance) { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn run_scene(
    scene: &Path,
    options: &scenes::Options,
    output: &mut dyn Write,
) -> miette::Result<ExitCode> {
    let progress = scenes::Progress::on_stderr();
    let written = scenes::run(scenes::ALL, scene, options, &progress);
    progress.finish();
    print_paths(&written?, output)
}

fn print_paths(written: &[PathBuf], output: &mut dyn Write) -> miette::Result<ExitCode> {
    for path in written {
        writeln!(output, "{}", path.display()).map_err(miette::Report::from_err)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn execute_chart(
    table: &[charts::ChartKind],
    what: &'static str,
    arguments: Drawn,
    output: &mut dyn Write,
) -> miette::Result<ExitCode> {
    if arguments.list {
        charts::list(table, what, output)?;
        return Ok(ExitCode::SUCCESS);
    }
    let folder = if what == "stability sweep" { "stability" } else { "chart" };
    let profile = arguments.extent.profile();
    let options = charts::Options {
        what,
        names: arguments.names,
        recording: recording(arguments.record, profile)?,
        profile,
        out: arguments.out.unwrap_or_else(|| output::default_folder(folder)),
    };
    charts::draw(table, &options, output)?;
    Ok(ExitCode::SUCCESS)
}

fn execute_schema(arguments: &Schema, output: &mut dyn Write) -> miette::Result<ExitCode> {
    let workspace = output::workspace();
    let out =
        if arguments.record { workspace.join("docs") } else { output::default_folder("schema") };
    schema::write(scenes::ALL, &workspace.join("tests/scenes"), &out, output)?;
    Ok(ExitCode::SUCCESS)
}

/// What the flag asks for, if it may be.
fn recording(is_asked: bool, profile: Profile) -> miette::Result<Recording> {
    Ok(if is_asked { Recording::on(profile)? } else { Recording::Off })
}

fn is_broken_pipe(report: &miette::Report) -> bool {
    let broken = |error: &io::Error| error.kind() == io::ErrorKind::BrokenPipe;
    report.chain().any(|error| error.downcast_ref::<io::Error>().is_some_and(broken))
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn to_go_on_and_to_overwrite_exclude_each_other() {
        let run = |flags: &[&str]| {
            Cli::try_parse_from([&["x", "run", "scene.json", "--out", "out"], flags].concat())
        };
        assert!(run(&["--resume"]).is_ok() && run(&["--overwrite"]).is_ok());
        assert!(run(&["--resume", "--overwrite"]).is_err());
    }

    #[test]
    fn quick_and_full_exclude_each_other() {
        assert!(Cli::try_parse_from(["x", "verify", "--quick", "--full"]).is_err());
        let cli = Cli::try_parse_from(["x", "verify", "fpk-sph", "--quick"]).unwrap();
        let Command::Verify(arguments) = cli.command else { panic!("not verify") };
        assert_eq!((arguments.extent.profile(), arguments.filters.len()), (Profile::Quick, 1));
        assert!(recording(true, arguments.extent.profile()).is_err());
        assert_eq!(recording(false, Profile::Quick).unwrap(), Recording::Off);
    }
}
