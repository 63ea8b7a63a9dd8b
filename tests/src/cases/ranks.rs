//! What is claimed of mpi-ensembles: a scene on ranks comes to the bits of one process, and what is killed or damaged is named.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use mpi_ensembles::ThreadRank;
use reference_problems::processes::{AS_SCENES, Scene, finish, outcome, piped, scenes, started};
use scenes::ALL;
use scenes::kind::{Options, Progress, run_on_ranks};
use serde_json::Value;

use crate::cases::prelude::*;

pub(super) const CASE: Case = Case {
    id: "mpi-ensembles/same-bits",
    title: "Ensembles on ranks that are threads, and on those of mpirun: whole, restarted, killed",
    source: "a run of the same scene in one process",
    cost: Profile::Default,
    run: Alone(run),
};

/// Numbers of ranks: one that blocks are dealt to evenly, one that they are not.
const RANKS: [usize; 2] = [2, 3];
/// Those of the full profile besides.
const MORE_RANKS: [usize; 2] = [1, 4];

/// The program that starts ranks.
const MPIRUN: &str = "mpirun";

/// How a scene comes to be run on ranks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum How {
    /// Threads of this process.
    Threads,
    /// Processes.
    Mpirun,
}

fn run(context: &Context<'_>) -> CaseResult {
    let mpirun = match can_mpirun() {
        Ok(()) => true,
        Err(why) => {
            context.skip(&format!("ranks of mpirun: {why}"));
            false
        }
    };
    let folder = std::env::temp_dir().join(format!("ranks-{}", std::process::id()));
    let ensembles = scenes()?.into_iter().filter(|scene| scene.shards);
    let claims: CaseResult<Vec<_>> = ensembles
        .map(|scene| {
            let file = scene.write(&folder)?;
            let alone = folder.join(format!("{}-alone", scene.name));
            finish(started(&file, &alone, &[])?)?;
            let entries = outcome(&alone)?;
            let of = Ensemble { context, scene, folder: folder.clone(), file, entries };
            let mut claims = of.claims(How::Threads)?;
            if mpirun {
                claims.extend(of.claims(How::Mpirun)?);
                claims.extend(of.killed()?);
            }
            Ok(claims)
        })
        .collect();
    std::fs::remove_dir_all(&folder)?;
    Ok(claims?.concat())
}

/// Why ranks of MPI cannot be started.
fn can_mpirun() -> Result<(), String> {
    if !cfg!(feature = "mpi") {
        return Err("built without the feature `mpi` (docs/scaling.md says how)".to_owned());
    }
    let mut version = Command::new(MPIRUN);
    version.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
    match version.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{MPIRUN} --version` ended with {status}")),
        Err(error) => Err(format!("`{MPIRUN}` cannot be started: {error}")),
    }
}

/// A scene, and what one process came to.
struct Ensemble<'a> {
    context: &'a Context<'a>,
    scene: Scene,
    folder: PathBuf,
    file: PathBuf,
    entries: BTreeSet<String>,
}

impl Ensemble<'_> {
    fn subject(&self, name: &str, quantity: &str, method: &str) -> Subject {
        self.context.subject(format!("{}/{name}", self.scene.name), quantity, method)
    }

    /// Entries of the results in a folder that are not those of one process.
    fn same(&self, out: &Path, name: &str, method: &str, reason: &str) -> CaseResult<Claim> {
        let different = self.entries.symmetric_difference(&outcome(out)?).count();
        Ok(self
            .subject(name, "entries of results and files of series that differ", method)
            .same_bits(different, self.entries.len())
            .because(reason))
    }

    fn count(
        &self,
        name: &str,
        quantity: &str,
        method: &str,
        found: usize,
        expected: usize,
        reason: &'static str,
    ) -> Claim {
        let compared = self.subject(name, quantity, method).absolute(found as f64, expected as f64);
        compared.within(0.0).because(reason)
    }

    fn claims(&self, how: How) -> CaseResult {
        let (stem, ranks) = match how {
            How::Threads => ("threads", "ranks that are threads"),
            How::Mpirun => ("mpirun", "ranks of mpirun"),
        };
        let mut claims = Vec::new();
        let blocks_alone =
            "blocks are those of the ensemble, whoever computes them, and sums have one shape";
        let more = MORE_RANKS.iter().filter(|_| self.context.profile == Profile::Full);
        for &n in RANKS.iter().chain(more) {
            self.context.progress(&format!("{}: {n} {ranks}", self.scene.name));
            let out = self.out(&format!("{stem}-{n}"));
            self.run_on(how, n, &out, &[])?;
            let (name, method) = (format!("{stem}-{n}"), format!("{n} {ranks}"));
            claims.push(self.same(&out, &name, &method, blocks_alone)?);
        }
        let out = self.out(&format!("{stem}-2"));
        claims.extend(self.restarted(how, &out, (stem, ranks))?);
        Ok(claims)
    }

    fn out(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{}-{name}", self.scene.name))
    }

    /// Blocks that are gone are computed, and no others; one that is damaged, or of another seed, is refused by name.
    fn restarted(&self, how: How, out: &Path, (stem, ranks): (&str, &str)) -> CaseResult {
        let method = format!("--resume, {ranks}");
        let (blocks, first) = blocks(out)?;
        std::fs::remove_file(&first)?;
        self.run_on(how, 2, out, &["--resume"])?;
        let job: Value = serde_json::from_str(&std::fs::read_to_string(out.join("job.json"))?)?;
        let n_computed = job["blocks"].as_array().map_or(0, Vec::len);
        let mut claims = vec![
            self.count(
                &format!("{stem}-restart/computed"),
                "blocks computed after one of them was removed",
                &method,
                n_computed,
                1,
                "a block that is kept is not computed again",
            ),
            self.same(
                out,
                &format!("{stem}-restart/bits"),
                &method,
                "a block is bitwise identical whenever it is computed",
            )?,
        ];
        let mut refusals = vec![("", "--overwrite", self.refusal(how, out, &[])?)];
        refusals.push(("seed", "seed", self.refusal(how, out, &["--resume", "--seed", "99"])?));
        let bytes = std::fs::read(&first)?;
        std::fs::write(&first, &bytes[..bytes.len() - 1])?;
        refusals.push(("cut off", "block-", self.refusal(how, out, &["--resume"])?));
        let n_named = refusals
            .iter()
            .filter(|(what, sign, told)| told.contains(what) && told.contains(sign))
            .count();
        claims.push(self.count(
            &format!("{stem}-restart/refused"),
            "runs over blocks, with blocks of another seed, with one cut off: refused by name",
            &method,
            n_named,
            refusals.len(),
            "nothing is computed over what somebody kept, nor from what is not this ensemble",
        ));
        if blocks < 2 {
            return Err(format!("{} has {blocks} blocks: too few to share", self.scene.name).into());
        }
        Ok(claims)
    }

    /// What a run says that must be refused.
    fn refusal(&self, how: How, out: &Path, more: &[&str]) -> CaseResult<String> {
        match self.run_on(how, 2, out, more) {
            Ok(()) => {
                Err(format!("{}: a run with {more:?} was not refused", self.scene.name).into())
            }
            Err(told) => Ok(told.to_string()),
        }
    }

    fn run_on(&self, how: How, n_ranks: usize, out: &Path, more: &[&str]) -> CaseResult<()> {
        match how {
            How::Threads => self.on_threads(n_ranks, out, more),
            How::Mpirun => finish(piped(self.mpirun(n_ranks, out, more)?)?).map(drop),
        }
    }

    fn on_threads(&self, n_ranks: usize, out: &Path, more: &[&str]) -> CaseResult<()> {
        let mut options = Options::new(out);
        options.seed = more.contains(&"--seed").then_some(99);
        if more.contains(&"--resume") {
            options.start = scenes::checkpoint::Start::GoOn;
        }
        let (options, file) = (&options, &self.file);
        let ended: Vec<Result<(), String>> = thread::scope(|scope| {
            let start = |rank: ThreadRank| {
                scope.spawn(move || {
                    let ran = run_on_ranks(ALL, file, options, &Progress::silent(), &rank);
                    ran.map(drop).map_err(|error| format!("{:?}", miette::Report::new(error)))
                })
            };
            let threads: Vec<_> = ThreadRank::all(n_ranks).into_iter().map(start).collect();
            let panicked = |_| Err("a rank panicked".to_owned());
            threads.into_iter().map(|thread| thread.join().unwrap_or_else(panicked)).collect()
        });
        Ok(ended.into_iter().collect::<Result<(), String>>()?)
    }

    fn mpirun(&self, n_ranks: usize, out: &Path, more: &[&str]) -> CaseResult<Command> {
        let mut command = Command::new(MPIRUN);
        // A case runs where it runs: as root in a container, and with more ranks than cores.
        command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
        command.args(["--oversubscribe", "-n", &n_ranks.to_string()]).arg(std::env::current_exe()?);
        command.args([AS_SCENES, "run"]).arg(&self.file).arg("--out").arg(out).args(more);
        Ok(command)
    }

    /// One of two ranks is killed when a block is done; nothing is claimed where the job ended before.
    fn killed(&self) -> CaseResult<Option<Claim>> {
        self.context.progress(&format!("{}: a rank is killed", self.scene.name));
        let out = self.out("killed-rank");
        let mut command = self.mpirun(2, &out, &[])?;
        let mut child =
            command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()?;
        let has_blocks = || blocks(&out).is_ok_and(|(n, _)| n >= 1);
        while child.try_wait()?.is_none() && !has_blocks() {
            thread::sleep(Duration::from_millis(2));
        }
        if let Some(rank) = children_of(child.id()).last() {
            Command::new("sh").args(["-c", &format!("kill -9 {rank}")]).status()?;
        }
        let ended = child.wait()?;
        if ended.success() {
            self.context
                .skip(&format!("{}: the job ended before a rank could be killed", self.scene.name));
            return Ok(None);
        }
        self.run_on(How::Mpirun, 2, &out, &["--resume"])?;
        let method = "SIGKILL of one of two ranks of mpirun, --resume";
        self.same(&out, "mpirun-killed", method, "what was done is on the disk").map(Some)
    }
}

/// How many blocks are kept, and the first.
fn blocks(out: &Path) -> CaseResult<(usize, PathBuf)> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(out.join("blocks"))?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    files.sort();
    let first = files.first().cloned().ok_or("no blocks")?;
    Ok((files.len(), first))
}

/// The processes that a process has started, in rising order; none where `/proc` does not list them.
fn children_of(parent: u32) -> Vec<u32> {
    let processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let mut children: Vec<u32> = processes
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
        .filter(|pid| {
            // `pid (name) state parent ...`: a name may hold blanks.
            let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
            let behind = stat.rsplit_once(") ").map(|(_, behind)| behind).unwrap_or_default();
            behind.split(' ').nth(1) == Some(parent.to_string().as_str())
        })
        .collect();
    children.sort_unstable();
    children
}
