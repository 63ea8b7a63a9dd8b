//! Draws scenes, runs them and compares their answers with the truth.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use scenes::answers::{Answers, Number};
use scenes::{Progress, RunError, SceneFile, causes, kind_of};
use serde_json::Value;

use crate::{ALL, Draw, Drawn, Family, Truth};

/// What to draw.
#[derive(Debug, Clone)]
pub struct Hunt {
    /// Number of scenes.
    pub runs: u64,
    /// Seed of all scenes.
    pub seed: u64,
    /// Number of the first scene.
    pub first: u64,
    /// Families to draw from; all where it is empty.
    pub families: Vec<String>,
    /// Methods to run; all where it is empty.
    pub methods: Vec<String>,
    /// Longest run.
    pub longest: Duration,
    /// Number of scenes that run at the same time, each on a thread.
    pub threads: usize,
}

/// A scene that was run.
#[derive(Debug)]
pub struct Outcome {
    /// Its number in the hunt.
    pub index: u64,
    /// The scene with its true answers.
    pub drawn: Drawn,
    /// Its numbers beside the truth, or why there are none.
    pub verdicts: Result<Vec<Verdict>, String>,
    /// Wall-clock time (s).
    pub seconds: f64,
}

/// A number beside its truth.
#[derive(Debug, Clone)]
pub struct Verdict {
    /// The truth.
    pub truth: Truth,
    /// The number.
    pub number: Number,
    /// Whether the number has a warning.
    pub is_warned: bool,
}

impl Verdict {
    /// Distance from the truth in stated errors, without the error of the truth; none where no error is stated.
    #[must_use]
    pub fn off(&self) -> Option<f64> {
        let away = self.away();
        self.number.error.map(|error| {
            if self.is_of_roundoff() { 0.0 } else { away / error.max(f64::MIN_POSITIVE) }
        })
    }

    /// Whether the number is off by roundoff alone, which is no one's error.
    #[must_use]
    pub fn is_of_roundoff(&self) -> bool {
        self.away() <= 1e-13 * self.number.value.abs()
    }

    /// Whether it is off by more than ten stated errors without a warning.
    #[must_use]
    pub fn is_silent(&self) -> bool {
        self.off().is_some_and(|off| off > 10.0) && !self.is_warned
    }

    /// Distance from the truth, without the error of the truth.
    #[must_use]
    pub fn away(&self) -> f64 {
        ((self.number.value - self.truth.value).abs() - self.truth.error).max(0.0)
    }
}

/// Runs scenes drawn from all families, and calls `look` after each; the outcomes in the order of their numbers.
pub fn hunt(hunt: &Hunt, look: &mut (dyn FnMut(&Outcome) + Send)) -> Vec<Outcome> {
    let next = AtomicU64::new(hunt.first);
    let done = Mutex::new((Vec::new(), look));
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= hunt.first + hunt.runs {
                break;
            }
            let Some(drawn) = hunt.drawn(index) else { continue };
            let started = Instant::now();
            let verdicts = judged(&drawn, hunt.longest);
            let verdicts = verdicts.map_err(|error| causes::with_causes(&error));
            let seconds = started.elapsed().as_secs_f64();
            let outcome = Outcome { index, drawn, verdicts, seconds };
            if let Ok(mut done) = done.lock() {
                (done.1)(&outcome);
                done.0.push(outcome);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..hunt.threads.max(1) {
            scope.spawn(work);
        }
    });
    let mut outcomes = done.into_inner().map_or_else(|poisoned| poisoned.into_inner().0, |it| it.0);
    outcomes.sort_by_key(|outcome| outcome.index);
    outcomes
}

impl Hunt {
    /// Scene of a number; none if its method is not asked for.
    fn drawn(&self, index: u64) -> Option<Drawn> {
        let is_asked = |family: &&Family| {
            self.families.is_empty() || self.families.iter().any(|name| name == family.name)
        };
        let families: Vec<&Family> = ALL.iter().filter(is_asked).collect();
        let whole: f64 = families.iter().map(|family| family.weight).sum();
        let mut draw = Draw::new(self.seed, index);
        let mut place = draw.between(0.0, whole);
        let chosen = families.iter().find(|family| {
            place -= family.weight;
            place <= 0.0
        });
        let family = *chosen.or(families.last())?;
        let is_hostile = draw.chance(0.35);
        let (scene, method) = (family.draw)(&mut draw, is_hostile);
        if !self.methods.is_empty() && self.methods.iter().all(|name| name != method) {
            return None;
        }
        let truths = (family.truths)(&scene).unwrap_or_default();
        Some(Drawn { family, scene, method, is_hostile, truths })
    }
}

/// A scene with what is known of it; none if no family knows any of its answers.
#[must_use]
pub fn known(scene: Value) -> Option<Drawn> {
    let (family, truths) =
        ALL.iter().find_map(|family| Some((family, (family.truths)(&scene)?)))?;
    Some(Drawn { family, scene, method: "", is_hostile: false, truths })
}

/// Runs a scene and compares its numbers with what is known.
///
/// # Errors
/// Those of the run.
pub fn judged(drawn: &Drawn, longest: Duration) -> Result<Vec<Verdict>, RunError> {
    // On one thread: most scenes are small, and threads that wait for each other cost more than they compute.
    let judge = || (drawn.family.judge)(&drawn.scene, &drawn.truths, longest);
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    alone.map_or_else(|_| judge(), |pool| pool.install(judge))
}

/// Runs a scene as the command does, and finds the numbers whose truth is known.
///
/// # Errors
/// Those of the run.
pub(crate) fn of_scene(
    scene: &Value,
    truths: &[Truth],
    longest: Duration,
) -> Result<Vec<Verdict>, RunError> {
    let file = SceneFile::from_text("scene.json", scene.to_string())?;
    let answers = kind_of(scenes::ALL, &file)?.solve(&file, Some(longest), &Progress::silent())?;
    Ok(compared(truths, &answers))
}

fn compared(truths: &[Truth], answers: &Answers) -> Vec<Verdict> {
    let of = |truth: &Truth| {
        let answer = answers.get(&truth.id)?;
        let values = answer.earlier.iter().chain([&answer.last]);
        let is_at = |window: Option<[f64; 2]>| match (window, truth.time) {
            (Some([_, end]), Some(t)) => (end - t).abs() <= 1e-9 * t.abs(),
            (window, time) => window.is_none() && time.is_none(),
        };
        let value = values.into_iter().find(|value| is_at(value.window))?;
        let is_warned = value.remark.is_some();
        Some(Verdict { truth: truth.clone(), number: value.number, is_warned })
    };
    truths.iter().filter_map(of).collect()
}
