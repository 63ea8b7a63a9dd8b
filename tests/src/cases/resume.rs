//! What is claimed of runs that were killed: that they go on to the same bits.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use sde_integrators::{Noise, Purpose};
use serde_json::{Value, json};

use crate::case::{Case, CaseError, Context, Profile};
use crate::checkpoint::Start;
use crate::claim::{Criterion, Measured, Reference};
use crate::report::{Claim, ErrorKind};

pub(super) const CASE: Case = Case {
    id: "run/resume",
    title: "Runs of scenes that are killed at random moments and go on from their checkpoint",
    source: "a run of the same scene that nobody disturbs",
    cost: Profile::Default,
    run,
};

/// Kills of each scene.
const fn n_kills(profile: Profile) -> u32 {
    match profile {
        Profile::Quick | Profile::Default => 1,
        Profile::Full => 13,
    }
}

/// A built-in scene, made smaller.
struct Scene {
    name: &'static str,
    text: &'static str,
    /// JSON pointers and what stands there instead.
    changes: Vec<(&'static str, Value)>,
}

fn scenes() -> Vec<Scene> {
    let damper = include_str!("../../scenes/fpk/viscous_damper.json");
    let sampled =
        json!({ "paths": 300_000, "step": 0.02, "integrator": "strang_oscillator", "seed": 7 });
    let judge = json!({ "samples": 400, "seed": 7, "control": false });
    vec![
        Scene {
            name: "density",
            text: damper,
            changes: vec![
                ("/times", json!({ "until": 5, "every": 0.1 })),
                ("/planes", json!({ "states": [["q", "v"]], "times": [1, 2] })),
                ("/cloud", json!({ "every_observations": 10 })),
            ],
        },
        Scene {
            name: "paths",
            text: damper,
            changes: vec![("/method", json!({ "monte_carlo": sampled }))],
        },
        Scene {
            name: "samples-of-a-plate",
            text: include_str!("../../scenes/smpm/plate_impact.json"),
            changes: vec![("/method", json!({ "monte_carlo": judge }))],
        },
        Scene {
            name: "cracks",
            text: include_str!("../../scenes/peridyn/notched_plate_ensemble.json"),
            changes: vec![
                ("/ensemble/realisations", json!(32)),
                ("/time/steps", json!(600)),
                ("/output/vtu", json!([0, 20])),
            ],
        },
    ]
}

impl Scene {
    /// The scene as a file in a folder.
    fn write(&self, folder: &Path) -> Result<PathBuf, CaseError> {
        let mut scene: Value = serde_json::from_str(self.text)?;
        for (pointer, value) in &self.changes {
            let (parent, key) = pointer.rsplit_once('/').ok_or("a pointer without a key")?;
            let object = scene.pointer_mut(parent).and_then(Value::as_object_mut);
            object
                .ok_or_else(|| format!("no object at {parent}"))?
                .insert(key.into(), value.clone());
        }
        let path = folder.join(format!("{}.json", self.name));
        crate::output::write_json(&path, &scene)?;
        Ok(path)
    }
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let folder = std::env::temp_dir().join(format!("resume-{}", std::process::id()));
    let claims = scenes()
        .iter()
        .enumerate()
        .map(|(number, scene)| killed(context, scene, (number as u64, &folder)))
        .collect::<Result<Vec<_>, _>>();
    std::fs::remove_dir_all(&folder)?;
    Ok(claims?.concat())
}

/// A scene undisturbed, and killed.
fn killed(
    context: &Context<'_>,
    scene: &Scene,
    (number, folder): (u64, &Path),
) -> Result<Vec<Claim>, CaseError> {
    let file = scene.write(folder)?;
    let undisturbed = folder.join(format!("{}-undisturbed", scene.name));
    let start = Instant::now();
    finish(started(&file, &undisturbed, Start::Anew)?)?;
    let duration = start.elapsed();
    let expected = outcome(&undisturbed)?;
    let mut moments = Noise::new(2026).stream(Purpose::MarkovChain, number);
    let (mut different, mut compared, mut n_resumed) = (0, 0, 0_u32);
    let n = n_kills(context.profile);
    for kill in 0..n {
        context.progress(&format!("{}: kill {} of {n}", scene.name, kill + 1));
        let out = folder.join(format!("{}-{kill}", scene.name));
        kill_at_random(&file, &out, duration.mul_f64(0.8 * moments.next_uniform()))?;
        let told = finish(started(&file, &out, Start::GoOn)?)?;
        n_resumed += u32::from(told.contains("goes on from"));
        let found = outcome(&out)?;
        different += expected.symmetric_difference(&found).count();
        compared += expected.len();
        std::fs::remove_dir_all(&out)?;
    }
    let subject = |name: &str, quantity: &str| {
        context.subject(&format!("{}/{name}", scene.name), quantity, "", "SIGKILL, then --resume")
    };
    Ok(vec![
        Claim::same_bits(
            subject("bits", "entries of results and files of series that differ"),
            different,
            compared,
            "a checkpoint holds all that the numbers of a run depend on",
        ),
        Claim::judge(
            subject("resumed", "runs that were killed and went on from a checkpoint"),
            ErrorKind::Absolute,
            Measured::exact(f64::from(n_resumed)),
            Reference::exact(f64::from(n)),
            Criterion::Within { tolerance: 0.0, reason: "a kill is repeated until it hits a run" },
        ),
    ])
}

/// This program, at a scene.
fn started(scene: &Path, out: &Path, start: Start) -> Result<Child, CaseError> {
    let mut command = Command::new(std::env::current_exe()?);
    command.arg("run").arg(scene).arg("--out").arg(out).args(["--checkpoint-every", "0"]);
    if start == Start::GoOn {
        command.arg("--resume");
    }
    Ok(command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?)
}

/// Waits for the end of a run and gives what it has told.
fn finish(child: Child) -> Result<String, CaseError> {
    let output = child.wait_with_output()?;
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() { Ok(told) } else { Err(told.into()) }
}

/// Tries of one kill: each is at half the time of the one before it.
const TRIES: u32 = 12;

/// Kills a run that has a checkpoint, so long after the first of them; sooner if it is at its end by then.
fn kill_at_random(scene: &Path, out: &Path, after: Duration) -> Result<(), CaseError> {
    for attempt in 0..TRIES {
        if out.exists() {
            std::fs::remove_dir_all(out)?;
        }
        let mut child = started(scene, out, Start::Anew)?;
        // Nobody reads what it tells, and a full pipe would hold it up.
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
        if running {
            return Ok(());
        }
    }
    Err(format!("a run ended {TRIES} times before it could be killed").into())
}

/// All numbers and words of a result, without those of the machine and the clock, and its files of series by their bytes.
fn outcome(folder: &Path) -> Result<BTreeSet<String>, CaseError> {
    let text = std::fs::read_to_string(folder.join("result.json"))?;
    let mut result: Value = serde_json::from_str(&text)?;
    for (parent, key) in [("", "machine"), ("", "commit"), ("/work", "cpu_seconds")] {
        if let Some(object) = result.pointer_mut(parent).and_then(Value::as_object_mut) {
            object.remove(key);
        }
    }
    let mut entries = BTreeSet::new();
    flatten(&result, &mut String::new(), &mut entries);
    for series in ["cloud", "fields"].map(|name| folder.join(name)) {
        if !series.exists() {
            continue;
        }
        for file in std::fs::read_dir(series)? {
            let path = file?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            entries.insert(format!("{name} {:?}", std::fs::read(&path)?));
        }
    }
    Ok(entries)
}

/// `path value` for every leaf.
fn flatten(value: &Value, path: &mut String, entries: &mut BTreeSet<String>) {
    let length = path.len();
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                // A string takes what is written to it.
                let _ = write!(path, ".{key}");
                flatten(value, path, entries);
                path.truncate(length);
            }
        }
        Value::Array(array) => {
            for (i, value) in array.iter().enumerate() {
                let _ = write!(path, "[{i}]");
                flatten(value, path, entries);
                path.truncate(length);
            }
        }
        leaf => {
            entries.insert(format!("{path} {leaf}"));
        }
    }
}
