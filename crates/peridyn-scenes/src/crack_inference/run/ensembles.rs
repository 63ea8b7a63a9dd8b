//! Ensembles at points of the parameters, kept in the checkpoint of the run.

use std::ops::Range;

use peridyn_sde::statistics::CrackRecord;
use peridyn_sde::{CrackRun, HaltedRun};
use scene_runs::checkpoint::Checkpoint;
use scene_runs::clock::CpuClock;
use scene_runs::interrupt;
use scene_runs::kind::{Pace, Progress, RunError, TooLong};
use scene_runs::scene::{Objection, SceneError, SceneFile};
use serde::{Deserialize, Serialize};

use crate::crack_inference::plate::{PlateAt, PlateModel};
use crate::progress::CrackProgress;

/// Name of the unfinished ensemble in a checkpoint.
const UNDER_WAY: &str = "under way";
/// Name of its realisations that were halted before their end.
const HALTED: &str = "halted realisations";

/// A finished ensemble.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Ended {
    /// Where it is.
    pub(super) point: Vec<f64>,
    /// Its realisations.
    pub(super) records: Vec<CrackRecord>,
    /// CPU time on all threads (s).
    pub(super) seconds: f64,
}

/// An ensemble that is not finished: its name and point, its realisations so far, and their CPU time (s).
type UnderWay = (String, Vec<f64>, CrackRun, f64);
/// The same of realisations that were halted before their end.
type Halted = (String, Vec<f64>, HaltedRun, f64);

/// Runs ensembles of a plate.
pub(super) struct Ensembles<'a> {
    pub(super) file: &'a SceneFile,
    pub(super) plate: &'a PlateModel,
    /// The checkpoint; none for a run on ranks, which stores blocks.
    pub(super) checkpoint: Option<&'a Checkpoint>,
    pub(super) progress: &'a Progress,
}

/// Ensembles of one kind.
pub(super) struct Series<'a> {
    /// Name of one of them, in the checkpoint and in messages.
    pub(super) name: &'a str,
    /// Their seed; realisations are numbered through.
    pub(super) seed: u64,
    /// Realisations of each.
    pub(super) realisations: u64,
    /// Number of ensembles.
    pub(super) n: u64,
    pub(super) pace: Pace<'a>,
}

impl Series<'_> {
    /// Takes note of the part of an ensemble that is done.
    fn at(&self, number: u64, part: f64) -> Result<(), TooLong> {
        self.pace.at((number as f64 + part) / self.n as f64)
    }
}

impl Ensembles<'_> {
    /// Ensembles at points, those of a checkpoint among them.
    pub(super) fn run(
        &self,
        series: &Series<'_>,
        points: &[Vec<f64>],
    ) -> Result<Vec<Ended>, RunError> {
        let mut all = Vec::with_capacity(points.len());
        for (number, point) in (0..).zip(points) {
            all.push(self.one(series, (number, point))?);
            self.progress.at((number + 1, series.n), || self.plate.words(point));
        }
        Ok(all)
    }

    /// The ensemble at a point with its number: that of the checkpoint if it is there.
    pub(super) fn one(
        &self,
        series: &Series<'_>,
        (number, point): (u64, &[f64]),
    ) -> Result<Ended, RunError> {
        let range = series.realisations * number..series.realisations * (number + 1);
        let Some(checkpoint) = self.checkpoint else {
            let PlateAt { scene, problem } = self.plate_at(series, point)?;
            let clock = CpuClock::start();
            let CrackRun { records, .. } = problem.run(&scene, range)?;
            return Ok(Ended { point: point.to_vec(), records, seconds: clock.seconds() });
        };
        let name = format!("{} {number}", series.name);
        // A draw of the posterior depends on keys that do not identify the checkpoint.
        let is_this = |ended: &Ended| ended.point == point && holds(&ended.records, &range);
        if let Some(ended) = checkpoint.part::<Ended>(&name)?.filter(is_this) {
            return Ok(ended);
        }
        let ended = self.compute(series, (number, point), (checkpoint, &name, range))?;
        checkpoint.keep_if_due(&name, &ended)?;
        Ok(ended)
    }

    /// Runs the realisations at a point, after those of the checkpoint.
    fn compute(
        &self,
        series: &Series<'_>,
        (number, point): (u64, &[f64]),
        (checkpoint, name, range): (&Checkpoint, &str, Range<u64>),
    ) -> Result<Ended, RunError> {
        let is_this = |of: &str, at: &[f64]| of == name && at == point;
        let past = checkpoint.part::<UnderWay>(UNDER_WAY)?;
        let past = past.filter(|(of, at, run, _)| is_this(of, at) && starts(&run.records, &range));
        let (run, before) = past.map(|(_, _, run, seconds)| (run, seconds)).unzip();
        let halted = checkpoint.part::<Option<Halted>>(HALTED)?.flatten();
        let halted = halted.filter(|(of, at, ..)| is_this(of, at));
        let (halted, halted_before) = halted.map(|(_, _, run, seconds)| (run, seconds)).unzip();
        let before = halted_before.or(before).unwrap_or(0.0);

        let PlateAt { scene, problem } = self.plate_at(series, point)?;
        let clock = CpuClock::start();
        let seconds = || before + clock.seconds();
        let (past, n) = (CrackProgress { run, halted }, range.end - range.start);
        series.at(number, past.n_ended() as f64 / n as f64)?;
        let goes_on = |part: Option<f64>| {
            !interrupt::is_requested() && part.is_none_or(|part| series.at(number, part).is_ok())
        };
        let run = problem.run_while(&scene, range, past, &goes_on, |so_far| {
            let allowed = series.at(number, so_far.n_ended() as f64 / n as f64);
            let is_halted = so_far.halted.is_some() || allowed.is_err();
            if so_far.n_ended() < n && (is_halted || checkpoint.is_due()) {
                let halted = so_far.halted.as_ref();
                let halted = halted.map(|halted| (name, point, halted, seconds()));
                checkpoint.put(HALTED, &halted)?;
                match &so_far.run {
                    Some(run) => checkpoint.keep(UNDER_WAY, &(name, point, run, seconds()))?,
                    None => checkpoint.keep(HALTED, &halted)?,
                }
            }
            allowed.map_err(RunError::from)
        })?;
        Ok(Ended { point: point.to_vec(), records: run.records, seconds: seconds() })
    }

    fn plate_at(&self, series: &Series<'_>, point: &[f64]) -> Result<PlateAt, RunError> {
        let plate = self.plate.at(point, series.seed);
        plate.map_err(|objection| self.refused(point, &objection).into())
    }

    fn refused(&self, point: &[f64], objection: &Objection) -> SceneError {
        self.file.object_to(&self.plate.objection("parameters", point, objection))
    }
}

/// Whether these are all realisations of a range.
fn holds(records: &[CrackRecord], range: &Range<u64>) -> bool {
    starts(records, range) && records.len() as u64 == range.end - range.start
}

/// Whether these are the first realisations of a range.
fn starts(records: &[CrackRecord], range: &Range<u64>) -> bool {
    records.len() as u64 <= range.end - range.start
        && range.clone().zip(records).all(|(number, record)| record.realisation == number)
}
