//! Draws scenes, runs them and compares their answers with the truth.

use std::time::{Duration, Instant};

use fpk_scenes::scene::FpkScene;
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
}

/// A scene that was run.
#[derive(Debug)]
pub struct Outcome {
    /// Name of its family.
    pub family: &'static str,
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
        let Number { value, error, .. } = self.number;
        let away = self.away();
        error.map(|error| {
            // Roundoff of a value is nobody's error.
            if away <= 1e-13 * value.abs() { 0.0 } else { away / error.max(f64::MIN_POSITIVE) }
        })
    }

    /// Distance from the truth, without the error of the truth.
    #[must_use]
    pub fn away(&self) -> f64 {
        ((self.number.value - self.truth.value).abs() - self.truth.error).max(0.0)
    }
}

/// Runs scenes drawn from families, and calls `look` after each.
pub fn hunt(families: &[Family], hunt: &Hunt, look: &mut dyn FnMut(&Outcome)) -> Vec<Outcome> {
    let is_asked = |family: &&Family| {
        hunt.families.is_empty() || hunt.families.iter().any(|name| name == family.name)
    };
    let families: Vec<&Family> = families.iter().filter(is_asked).collect();
    let whole: f64 = families.iter().map(|family| family.weight).sum();
    let mut outcomes = Vec::new();
    for index in hunt.first..hunt.first + hunt.runs {
        let mut draw = Draw::new(hunt.seed, index);
        let mut place = draw.between(0.0, whole);
        let chosen = families.iter().find(|family| {
            place -= family.weight;
            place <= 0.0
        });
        let Some(family) = chosen.or(families.last()) else { break };
        let hostile = draw.chance(0.35);
        let (scene, method) = (family.draw)(&mut draw, hostile);
        let truths = known(&scene).unwrap_or_default();
        let drawn = Drawn { scene, method, is_hostile: hostile, truths };
        if !hunt.methods.is_empty() && hunt.methods.iter().all(|name| name != drawn.method) {
            continue;
        }
        let started = Instant::now();
        let verdicts = judged(&drawn, hunt.longest);
        let verdicts = verdicts.map_err(|error| causes::with_causes(&error));
        let seconds = started.elapsed().as_secs_f64();
        let outcome = Outcome { family: family.name, index, drawn, verdicts, seconds };
        look(&outcome);
        outcomes.push(outcome);
    }
    outcomes
}

/// What is known of the answers of a scene.
///
/// # Errors
/// Those of the scene.
pub fn known(scene: &Value) -> Result<Vec<Truth>, RunError> {
    let (scene, system) = FpkScene::read("scene.json", &scene.to_string())?;
    Ok(ALL.iter().find_map(|family| (family.truths)(&scene, &system)).unwrap_or_default())
}

/// Runs a scene and compares its numbers with what is known.
///
/// # Errors
/// Those of the run.
pub fn judged(drawn: &Drawn, longest: Duration) -> Result<Vec<Verdict>, RunError> {
    // On one thread: most scenes are small, and threads that wait for each other cost more than they compute.
    let solved = || solved(drawn, longest);
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let answers = alone.map_or_else(|_| solved(), |pool| pool.install(solved))?;
    Ok(compared(drawn, &answers))
}

fn solved(drawn: &Drawn, longest: Duration) -> Result<Answers, RunError> {
    let file = SceneFile::from_text("scene.json", drawn.scene.to_string())?;
    kind_of(scenes::ALL, &file)?.solve(&file, Some(longest), &Progress::silent())
}

/// The numbers whose truth is known.
fn compared(drawn: &Drawn, answers: &Answers) -> Vec<Verdict> {
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
    drawn.truths.iter().filter_map(of).collect()
}
