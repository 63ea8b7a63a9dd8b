//! Realisations of a scene, round by round.

use std::ops::Range;

use peridyn_sde::{CrackRun, GroupProgress, HaltedRun, RunOutcome};
use scene_runs::RunError;
use serde::{Deserialize, Serialize};

use super::scene::CrackScene;
use super::scene_problem::CrackProblem;

/// Realisations of a range so far.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CrackProgress {
    /// The realisations of the rounds that have ended.
    pub run: Option<CrackRun>,
    /// The round after them, if it was halted.
    pub halted: Option<HaltedRun>,
}

impl CrackProgress {
    /// Number of realisations of the rounds that have ended.
    #[must_use]
    pub fn n_ended(&self) -> u64 {
        self.run.as_ref().map_or(0, |run| run.records.len() as u64)
    }
}

impl CrackProblem {
    /// Runs all realisations of a range in one piece.
    ///
    /// # Errors
    /// [`RunError::Solver`] with those of [`peridyn_sde::CrackStudy::run`].
    pub fn run(&self, scene: &CrackScene, range: Range<u64>) -> Result<CrackRun, RunError> {
        self.run_while(scene, range, CrackProgress::default(), &|_| true, |_| Ok(()))
    }

    /// Runs the realisations of a range, or those after `past`.
    ///
    /// As many run at a time as threads run side by side; the results are bitwise independent of that number. All threads call
    /// `goes_on`, with the fraction of the range that is done where it is known; once it has returned false it must not return true
    /// again. `look` observes the realisations so far after each round, and when one was halted; then it must return an error.
    ///
    /// # Errors
    /// Those of [`peridyn_sde::CrackStudy::resume_while`] and of `look`.
    pub fn run_while(
        &self,
        scene: &CrackScene,
        range: Range<u64>,
        past: CrackProgress,
        goes_on: &(dyn Fn(Option<f64>) -> bool + Sync),
        mut look: impl FnMut(&CrackProgress) -> Result<(), RunError>,
    ) -> Result<CrackRun, RunError> {
        let (study, keep) = (self.study(scene), &scene.output.vtu);
        let n = (range.end - range.start) as f64;
        let each = self.n_side_by_side(scene) * rayon::current_num_threads() as u64;
        let mut so_far = past;
        if so_far.n_ended() > 0 {
            look(&so_far)?;
        }
        loop {
            let n_ended = so_far.n_ended();
            let first = range.start + n_ended;
            if let Some(run) = so_far.run.take_if(|_| first >= range.end) {
                return Ok(run);
            }
            // One that goes beyond the range is of a scene that asked for more.
            let known = so_far.halted.take().map(|halted| (halted.realisations(), halted));
            let known = known.filter(|(of, _)| of.start == first && of.end <= range.end);
            let round =
                known.as_ref().map_or(first..range.end.min(first + each), |it| it.0.clone());
            let in_round = (round.end - round.start) as f64;
            let part = |group: GroupProgress| {
                goes_on(group.done.map(|done| (n_ended as f64 + done * in_round) / n))
            };
            let ended = match known {
                None => study.run_while(round, keep, &part),
                Some((_, halted)) => study.resume_while(halted, keep, &part),
            };
            match ended.map_err(RunError::solver)? {
                RunOutcome::Halted(halted) => so_far.halted = Some(halted),
                RunOutcome::Finished(run) => match &mut so_far.run {
                    None => so_far.run = Some(run),
                    Some(all) => all.append(run).map_err(RunError::solver)?,
                },
            }
            look(&so_far)?;
        }
    }
}
