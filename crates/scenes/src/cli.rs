//! Command line of scenes: options and exit codes.

mod ranks;
mod summary;

use std::io::{self, Write};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Args, Parser, Subcommand};
use scene_runs::checkpoint::Start;
use scene_runs::kind::{self, EnsemblePart, Options, Place, Progress};
use scene_runs::{advise, interrupt, schema};

use self::summary::Ending;
use crate::built_in::ALL;

/// Exit code when the reader of the output has exited.
const BROKEN_PIPE: u8 = 141;
/// Exit code of a run that a signal ended, as of shells.
const INTERRUPTED: u8 = 130;

#[derive(Debug, Parser)]
#[command(
    name = "scenes",
    bin_name = "cargo xtask",
    version,
    about = "Runs scenes of stochastic mechanics"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// Commands on scenes.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a scene file
    Run(Run),
    /// Name the cheapest method and size for a tolerance on a scene, from short trial runs
    Advise(Advise),
    /// Join the shards of a scene to the result of one run
    Merge(Merge),
    /// Write the schemas of scenes and the page of all their keys
    Schema(Schema),
    /// List the materials that scenes of smpm may name, with their constants in SI and sources
    #[cfg(feature = "smpm")]
    Materials,
}

/// Options of `run`.
#[derive(Debug, Args)]
pub struct Run {
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
    /// Continue the interrupted run in DIR, bitwise identical; its end time may have been earlier
    #[arg(long)]
    resume: bool,
    /// Start from the beginning although DIR holds the checkpoint of an unfinished run, which is an error otherwise
    #[arg(long, conflicts_with = "resume")]
    overwrite: bool,
    /// Minimum interval between two checkpoints
    #[arg(long, value_name = "SECONDS", default_value_t = Options::CHECKPOINT_EVERY.as_secs())]
    checkpoint_every: u64,
    #[command(flatten)]
    allowed: Allowed,
    /// Run shard K of N of an ensemble, which `merge` joins
    #[arg(long, value_name = "K/N", conflicts_with = "tolerance")]
    shard: Option<Place>,
    /// Run an ensemble block by block in this process, with a file for each block; job.json holds the timings
    #[arg(long, conflicts_with_all = ["shard", "tolerance"])]
    blocks: bool,
    /// Run the scene's own method with this error relative to the value, e.g. 1e-2, from short trial runs
    #[arg(long, value_name = "T")]
    tolerance: Option<f64>,
    #[command(flatten)]
    end: End,
    #[command(flatten)]
    wanted: Wanted,
}

/// How long a run may take.
#[derive(Debug, Clone, Copy, Args)]
struct Allowed {
    /// Refuse a part of the run that would take longer than this, by what its first ten seconds have done
    #[arg(long, value_name = "HOURS", default_value_t = 24.0, value_parser = hours)]
    longest: f64,
    /// Run however long it takes
    #[arg(long, conflicts_with = "longest")]
    yes: bool,
}

impl Allowed {
    fn longest(self) -> Option<Duration> {
        (!self.yes).then(|| Duration::from_secs_f64(3600.0 * self.longest))
    }
}

/// What is printed at the end.
#[derive(Debug, Clone, Copy, Args)]
struct End {
    /// Print the paths of the files and nothing else at the end
    #[arg(long)]
    quiet: bool,
}

impl End {
    const fn ending(self) -> Ending {
        if self.quiet { Ending::Paths } else { Ending::Answers }
    }
}

/// Options of `advise`.
#[derive(Debug, Args)]
pub struct Advise {
    /// A scene, e.g. tests/scenes/fpk/viscous_damper.json
    #[arg(value_name = "SCENE.json")]
    scene: PathBuf,
    #[command(flatten)]
    wanted: Wanted,
    /// Largest error relative to the value, e.g. 1e-2
    #[arg(long, value_name = "T")]
    tolerance: f64,
    /// Also write the advice as a page, DIR/index.html
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Options of trial runs.
#[derive(Debug, Args)]
struct Wanted {
    /// Largest expected cost of a trial run in CPU seconds; the first trial of each method may take ten times as long
    #[arg(long, value_name = "SECONDS", default_value_t = advise::Options::BUDGET)]
    budget: f64,
    /// Prefix of the id of a quantity, e.g. moment/ or exceedance/1; may be repeated; all if not given
    #[arg(long = "quantity", value_name = "ID")]
    quantities: Vec<String>,
}

impl Wanted {
    fn within(self, tolerance: f64) -> advise::Options {
        let Self { budget, quantities } = self;
        advise::Options { tolerance, budget, quantities }
    }
}

/// Options of `merge`.
#[derive(Debug, Args)]
pub struct Merge {
    /// The scene that the shards are of
    #[arg(value_name = "SCENE.json")]
    scene: PathBuf,
    /// Files written by `run --shard`, all of them, in any order
    #[arg(value_name = "SHARD", required = true)]
    shards: Vec<PathBuf>,
    /// Where the results go
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// The seed of the shards, if it is not that of the scene
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    #[command(flatten)]
    end: End,
}

/// Options of `schema`.
#[derive(Debug, Args)]
pub struct Schema {
    /// The folder of the built-in scenes, the source of the examples
    #[arg(long, value_name = "DIR", default_value = "tests/scenes")]
    scenes: PathBuf,
    /// Where the schemas and the page go
    #[arg(long, value_name = "DIR", default_value = "target/schema")]
    out: PathBuf,
}

/// Parses the command line, runs the command, and returns the exit code.
pub fn main() -> ExitCode {
    exit_code(execute(Cli::parse().command, &mut io::stdout().lock()))
}

/// The exit code of a command; an error is printed on standard error.
pub fn exit_code(result: miette::Result<ExitCode>) -> ExitCode {
    match result {
        Ok(code) => code,
        Err(report) if is_broken_pipe(&report) => ExitCode::from(BROKEN_PIPE),
        Err(report) => {
            // Without standard error the exit code still reports it.
            let _ = writeln!(io::stderr(), "{report:?}");
            if interrupt::is_requested() { ExitCode::from(INTERRUPTED) } else { ExitCode::FAILURE }
        }
    }
}

/// Runs a command.
///
/// # Errors
/// Any error of the scene, the solver or the files, as a report.
pub fn execute(command: Command, output: &mut dyn Write) -> miette::Result<ExitCode> {
    match command {
        Command::Run(arguments) => execute_run(arguments, output),
        Command::Advise(Advise { scene, wanted, tolerance, out }) => {
            let (options, progress) = (wanted.within(tolerance), Progress::on_stderr());
            let advice = advise::advise(ALL, &scene, &options, &progress);
            progress.finish();
            let advice = advice?;
            advise::print(&advice, output)?;
            if let Some(out) = out {
                let page = advise::write_page(ALL, &scene, &advice, &out)?;
                writeln!(output, "written: {}", page.display())
                    .map_err(advise::AdviseError::Write)?;
            }
            Ok(ExitCode::SUCCESS)
        }
        Command::Merge(Merge { scene, shards, out, seed, end }) => {
            let part = EnsemblePart::Merged(shards);
            let options = Options { seed, part, ..Options::new(out) };
            run_scene(&scene, &options, end.ending(), output)
        }
        Command::Schema(arguments) => execute_schema(&arguments, output),
        #[cfg(feature = "smpm")]
        Command::Materials => {
            let list = smpm_scenes::materials::text();
            output.write_all(list.as_bytes()).map_err(miette::Report::from_err)?;
            Ok(ExitCode::SUCCESS)
        }
    }
}

/// A number of hours, of which a limit can be made.
fn hours(text: &str) -> Result<f64, String> {
    const MOST: f64 = 1e6;
    let hours: f64 = text.parse().map_err(|_| format!("`{text}` is no number of hours"))?;
    if hours > 0.0 && hours <= MOST {
        return Ok(hours);
    }
    Err(format!("it must be above 0 and at most {MOST}; without a limit: --yes"))
}

/// Rejects threads that only wait for each other: most likely a typing error.
fn at_most_threads(threads: usize) -> miette::Result<()> {
    const FOR_EACH_PROCESSOR: usize = 4;
    let processors = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let limit = FOR_EACH_PROCESSOR * processors;
    if threads <= limit {
        return Ok(());
    }
    Err(miette::miette!(
        help = "leave out --threads for one on each processor",
        "--threads {threads}: this machine has {processors} processors; at most {limit} threads are allowed"
    ))
}

/// At the first signal to end (Ctrl-C, SIGTERM, SIGHUP) the run ends at its next checkpoint; at the second, at once.
fn end_at_signals() -> miette::Result<()> {
    let handler = || {
        if interrupt::request() {
            std::process::exit(INTERRUPTED.into());
        }
        let _ = writeln!(
            io::stderr(),
            "\ninterrupted: the run ends at its next checkpoint; another signal ends it at once"
        );
    };
    ctrlc::set_handler(handler).map_err(miette::Report::from_err)
}

fn execute_run(arguments: Run, output: &mut dyn Write) -> miette::Result<ExitCode> {
    end_at_signals()?;
    let (started, ending) = (ranks::started(), arguments.end.ending());
    // There are as many ranks as cores.
    let threads = arguments.threads.or(started.is_some().then_some(NonZeroUsize::MIN));
    if let Some(threads) = threads {
        at_most_threads(threads.get())?;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get());
        pool.build_global().map_err(miette::Report::from_err)?;
    }
    let options = Options {
        out: arguments.out,
        seed: arguments.seed,
        start: match (arguments.resume, arguments.overwrite) {
            (true, _) => Start::GoOn,
            (_, true) => Start::Overwrite,
            _ => Start::Anew,
        },
        checkpoint_every: Duration::from_secs(arguments.checkpoint_every),
        part: arguments.shard.map_or(EnsemblePart::Whole, EnsemblePart::Shard),
        longest: arguments.allowed.longest(),
    };
    if let Some(n_ranks) = started {
        if arguments.tolerance.is_some() {
            return Err(miette::miette!(
                "--tolerance tries sizes in one process: run it without mpirun"
            ));
        }
        return ranks::run_scene(n_ranks, &arguments.scene, &options, ending, output);
    }
    if arguments.blocks {
        return ranks::run_alone(&arguments.scene, &options, ending, output);
    }
    match arguments.tolerance {
        None => run_scene(&arguments.scene, &options, ending, output),
        Some(tolerance) => {
            let wanted = arguments.wanted.within(tolerance);
            run_within(&arguments.scene, &options, &wanted, ending, output)
        }
    }
}

/// Fails if the run's own error estimate exceeds the tolerance.
fn run_within(
    scene: &Path,
    options: &Options,
    wanted: &advise::Options,
    ending: Ending,
    output: &mut dyn Write,
) -> miette::Result<ExitCode> {
    let progress = Progress::on_stderr();
    let ran = advise::run_within(ALL, scene, options, wanted, &progress);
    progress.finish();
    let mut within = ran?;
    summary::print(&within.files, Some(&within.found), ending, output)?;
    advise::print_within(&within, wanted, output)?;
    within.unwritten.take().map_or(Ok(()), Err)?;
    Ok(if within.is_reached(wanted.tolerance) { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn run_scene(
    scene: &Path,
    options: &Options,
    ending: Ending,
    output: &mut dyn Write,
) -> miette::Result<ExitCode> {
    let progress = Progress::on_stderr();
    let finished = kind::run(ALL, scene, options, &progress);
    progress.finish();
    summary::print_finished(finished?, ending, output)
}

fn execute_schema(arguments: &Schema, output: &mut dyn Write) -> miette::Result<ExitCode> {
    schema::write(ALL, &arguments.scenes, &arguments.out, output)?;
    Ok(ExitCode::SUCCESS)
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
    fn a_limit_is_a_number_of_hours() {
        for refused in ["0", "-1", "NaN", "inf", "1e7", "day"] {
            assert!(hours(refused).is_err(), "{refused}");
        }
        assert_eq!(hours("0.5"), Ok(0.5));
    }
}
