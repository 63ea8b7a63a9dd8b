//! Interrupted, shorter and divided runs give bitwise identical results.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use reference_problems::processes::{
    Scene, command_of_scenes, finish, outcome, piped, scenes, started,
};
use sde_integrators::{Noise, Purpose};

use crate::cases::prelude::*;

pub(super) const CASE: Case = Case {
    id: "run/resume",
    title: "Runs of scenes that are killed at random moments, made longer, or divided into shards",
    source: "a run of the same scene that nobody disturbs",
    cost: Profile::Default,
    run: Alone(run),
};

/// Kills of each scene.
const fn n_kills(profile: Profile) -> u32 {
    match profile {
        Profile::Quick | Profile::Default => 1,
        Profile::Full => 13,
    }
}

fn run(context: &Context<'_>) -> CaseResult {
    let folder = std::env::temp_dir().join(format!("resume-{}", std::process::id()));
    let claims = scenes()?
        .iter()
        .enumerate()
        .map(|(number, scene)| of_scene(context, scene, (number as u64, &folder)))
        .collect::<Result<Vec<_>, _>>();
    std::fs::remove_dir_all(&folder)?;
    Ok(claims?.concat())
}

/// A scene undisturbed, and what else comes to the same.
fn of_scene(context: &Context<'_>, scene: &Scene, (number, folder): (u64, &Path)) -> CaseResult {
    let file = scene.write(folder)?;
    let undisturbed = folder.join(format!("{}-undisturbed", scene.name));
    let start = Instant::now();
    finish(started(&file, &undisturbed, &[])?)?;
    let of = Undisturbed {
        context,
        scene,
        folder,
        file,
        duration: start.elapsed(),
        entries: outcome(&undisturbed)?,
    };
    let mut claims = of.killed(number)?;
    if let Some(shorter) = scene.write_shorter(folder)? {
        claims.push(of.longer(&shorter)?);
    }
    if scene.shards {
        claims.push(of.divided()?);
    }
    Ok(claims)
}

/// A run that nobody disturbed.
struct Undisturbed<'a> {
    context: &'a Context<'a>,
    scene: &'a Scene,
    folder: &'a Path,
    file: PathBuf,
    duration: Duration,
    entries: BTreeSet<String>,
}

impl Undisturbed<'_> {
    fn out(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{}-{name}", self.scene.name))
    }

    fn subject(&self, name: &str, quantity: &str, method: &str) -> Subject {
        self.context.subject(format!("{}/{name}", self.scene.name), quantity, method)
    }

    /// Entries that are not in both.
    fn n_different(&self, out: &Path) -> CaseResult<usize> {
        Ok(self.entries.symmetric_difference(&outcome(out)?).count())
    }

    fn same(&self, name: &str, method: &str, different: usize, runs: usize, reason: &str) -> Claim {
        self.subject(name, "entries of results and files of series that differ", method)
            .same_bits(different, runs * self.entries.len())
            .because(reason)
    }

    fn killed(&self, number: u64) -> CaseResult {
        let mut moments = Noise::new(2026).stream(Purpose::MarkovChain, number);
        let (mut different, mut n_refused, mut n_resumed) = (0, 0_u32, 0_u32);
        let n = n_kills(self.context.profile);
        for kill in 1..=n {
            self.context.progress(&format!("{}: kill {kill} of {n}", self.scene.name));
            let out = self.out("killed");
            kill_at_random(&self.file, &out, self.duration.mul_f64(0.8 * moments.next_uniform()))?;
            n_refused += u32::from(is_refused(&self.file, &out)?);
            let told = finish(started(&self.file, &out, &["--resume"])?)?;
            n_resumed += u32::from(told.contains("resumes from"));
            different += self.n_different(&out)?;
        }
        let (method, reason) =
            ("SIGKILL, --resume", "a checkpoint holds all that the numbers of a run depend on");
        let every = |name: &str, quantity: &str, method: &str, found: u32, reason: &'static str| {
            let subject = self.subject(name, quantity, method);
            subject.absolute(f64::from(found), f64::from(n)).within(0.0).because(reason)
        };
        let (resumed, refused) = ("runs that went on from a checkpoint", "runs that were refused");
        let hit = "a kill is repeated until it hits a run";
        let kept = "what a killed run has come to is not written over unasked";
        Ok(vec![
            self.same("killed", method, different, n as usize, reason),
            every("resumed", resumed, method, n_resumed, hit),
            every("not-overwritten", refused, "SIGKILL, run", n_refused, kept),
        ])
    }

    /// A shorter run, and the rest of it.
    fn longer(&self, shorter: &Path) -> CaseResult<Claim> {
        let out = self.out("longer");
        finish(started(shorter, &out, &[])?)?;
        finish(started(&self.file, &out, &["--resume"])?)?;
        let reason = "the end of a scene changes nothing before it";
        Ok(self.same("longer", "a shorter run, --resume", self.n_different(&out)?, 1, reason))
    }

    /// Two shards, joined in the wrong order.
    fn divided(&self) -> CaseResult<Claim> {
        let (shards, out) = (self.out("shards"), self.out("merged"));
        for shard in ["1/2", "2/2"] {
            finish(started(&self.file, &shards, &["--shard", shard])?)?;
        }
        let mut merge = command_of_scenes()?;
        merge.arg("merge").arg(&self.file).arg(shards.join("shard-2-of-2.bin"));
        merge.arg(shards.join("shard-1-of-2.bin")).arg("--out").arg(&out);
        finish(piped(merge)?)?;
        let reason = "realisations do not know of each other, and sums have one shape";
        Ok(self.same("merged", "two shards, merge", self.n_different(&out)?, 1, reason))
    }
}

/// Whether a run that would start anew over a checkpoint is not run, and says what to do.
fn is_refused(scene: &Path, out: &Path) -> CaseResult<bool> {
    let output = started(scene, out, &[])?.wait_with_output()?;
    let told = String::from_utf8_lossy(&output.stderr);
    Ok(!output.status.success() && told.contains("--overwrite"))
}

/// Tries of one kill: each is at half the time of the one before it.
const TRIES: u32 = 12;

/// Kills a run that has a checkpoint, so long after the first of them; sooner if it is at its end by then.
fn kill_at_random(scene: &Path, out: &Path, after: Duration) -> CaseResult<()> {
    for attempt in 0..TRIES {
        if out.exists() {
            std::fs::remove_dir_all(out)?;
        }
        let mut child = started(scene, out, &[])?;
        // Nobody reads its output, and a full pipe would hold it up.
        drop(child.stderr.take());
        let mut running = true;
        while running && !out.join("checkpoint-1.bin").exists() {
            running = child.try_wait()?.is_none();
            std::thread::sleep(Duration::from_millis(2));
        }
        std::thread::sleep(after / 2_u32.pow(attempt));
        running = running && child.try_wait()?.is_none();
        // An error says that it has ended by itself.
        let _ = child.kill();
        child.wait()?;
        if running && !out.join("result.json").exists() {
            return Ok(());
        }
    }
    Err(format!("a run ended {TRIES} times before it could be killed").into())
}
