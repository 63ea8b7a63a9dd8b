//! Numbers of a run beside their truths.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use scenes::answers::{Answers, Number};
use scenes::{Finished, Options, Progress, RunError, SceneFile, kind_of};
use serde_json::Value;

use crate::Truth;

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

/// Runs a scene as the command does, in a folder of its own, and finds the numbers whose truth is known.
///
/// # Errors
/// Those of the run, which writes all that it has found: a number that a file has no word for is one.
pub(crate) fn of_scene(
    scene: &Value,
    truths: &[Truth],
    longest: Duration,
) -> Result<Vec<Verdict>, RunError> {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    let file = SceneFile::from_text("scene.json", scene.to_string())?;
    let next = NEXT.fetch_add(1, Ordering::Relaxed);
    let name = format!("stated-errors-{}-{next}", std::process::id());
    let out = std::env::temp_dir().join(name);
    let options = Options { longest: Some(longest), ..Options::new(&out) };
    let finished = kind_of(scenes::ALL, &file)?.run_file(&file, &options, &Progress::silent());
    // A folder that stays is no fault of the scene.
    let _ = std::fs::remove_dir_all(&out);
    let Finished { found, unwritten, null, .. } = finished?;
    unwritten.map_or(Ok(()), Err)?;
    null.map_or(Ok(()), |text| Err(RunError::solver(std::io::Error::other(text))))?;
    Ok(compared(truths, &found.ok_or(RunError::NoShards)?.answers))
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
        // How an error is known is no warning.
        let how = value.number.error_kind.words();
        let is_warned = value.remark.as_deref().is_some_and(|remark| remark != how);
        Some(Verdict { truth: truth.clone(), number: value.number, is_warned })
    };
    truths.iter().filter_map(of).collect()
}
