//! Runs a scene on the ranks that mpirun has started.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use mpi_ensembles::Alone;
use scene_runs::kind::{self, Options, Progress};

use super::summary::{self, Ending};
use crate::built_in::ALL;

/// Variables that MPI launchers set in their processes: OpenMPI, Hydra (MPICH, Intel MPI), PMIx alone (srun).
const OF_LAUNCHERS: [&str; 4] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMI_RANK", "PMIX_RANK"];

/// The variable of an MPI launcher, if one has started this process.
pub(super) fn started() -> Option<Launched> {
    let value = |name: &'static str| Some(Launched { name, value: std::env::var(name).ok()? });
    OF_LAUNCHERS.into_iter().find_map(value)
}

/// A variable of a launcher and its value.
#[derive(Debug, Clone)]
pub(super) struct Launched {
    name: &'static str,
    value: String,
}

/// Runs a scene block by block on one rank, which is this process.
pub(super) fn run_alone(
    scene: &Path,
    options: &Options,
    ending: Ending,
    output: &mut dyn Write,
) -> miette::Result<ExitCode> {
    let progress = Progress::on_stderr();
    let finished = kind::run_on_ranks(ALL, scene, options, &progress, &Alone);
    progress.finish();
    summary::print_finished(finished?, ending, output)
}

/// Runs a scene together with the other ranks. An error on one rank aborts all of them; the function does not return.
#[cfg(feature = "mpi")]
pub(super) fn run_scene(
    launched: Launched,
    scene: &Path,
    options: &Options,
    ending: Ending,
    output: &mut dyn Write,
) -> miette::Result<ExitCode> {
    use mpi_ensembles::{Ranks, World};

    let Launched { name, value } = launched;
    let started = format!("started by a launcher of MPI ({name} is {value})");
    let world =
        World::start().map_err(|error| miette::Report::from_err(error).wrap_err(started))?;
    let is_first = world.rank() == 0;
    let progress = if is_first { Progress::on_stderr() } else { Progress::silent() };
    let finished = kind::run_on_ranks(ALL, scene, options, &progress, &world);
    progress.finish();
    match finished {
        Ok(finished) => summary::print_finished(finished, ending, output),
        Err(error) => {
            // The other ranks reject what rank 0 rejects, or receive no message.
            if is_first {
                let report = miette::Report::new(error);
                let _ = writeln!(std::io::stderr(), "{report:?}");
                world.abort(1)
            }
            hold(&world, error)
        }
    }
}

/// Reports the failed run of a rank other than 0.
///
/// Rank 0 reports the error if it has received it; otherwise this rank does so after a delay.
#[cfg(feature = "mpi")]
fn hold(world: &mpi_ensembles::World, error: kind::RunError) -> ! {
    use mpi_ensembles::Ranks;

    std::thread::sleep(std::time::Duration::from_secs(2));
    let rank = world.rank();
    let report = miette::Report::new(error).wrap_err(format!("rank {rank}"));
    let _ = writeln!(std::io::stderr(), "{report:?}");
    world.abort(1)
}

/// Rejects the run: each process would write the same files.
#[cfg(not(feature = "mpi"))]
pub(super) fn run_scene(
    launched: Launched,
    _: &Path,
    _: &Options,
    _: Ending,
    _: &mut dyn Write,
) -> miette::Result<ExitCode> {
    let Launched { name, value } = launched;
    Err(miette::miette!(
        help = "cargo build --release --package scenes --features mpi",
        "started by a launcher of MPI ({name} is {value}), and built without MPI"
    ))
}
