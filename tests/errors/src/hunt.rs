//! Draws scenes, runs them and compares their answers with the truth.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use scenes::{RunError, causes};
use serde_json::Value;

use crate::{ALL, Draw, Drawn, Family, Verdict};

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
