//! Ensembles at points of the parameters, kept in the checkpoint of the run.

use std::ops::Range;

use peridyn_sde::CrackRun;
use peridyn_sde::statistics::CrackRecord;
use serde::{Deserialize, Serialize};

use crate::checkpoint::Checkpoint;
use crate::clock::CpuClock;
use crate::crack_inference::plate::{PlateAt, PlateModel};
use crate::kind::{Progress, RunError};
use crate::scene::{Objection, SceneError, SceneFile};

/// Name of the unfinished ensemble in a checkpoint.
const UNDER_WAY: &str = "under way";

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

/// Runs ensembles of a plate.
pub(super) struct Ensembles<'a> {
    pub(super) file: &'a SceneFile,
    pub(super) plate: &'a PlateModel,
    /// None for a run on ranks, which stores blocks.
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
}

impl Ensembles<'_> {
    /// Ensembles at points, those of a checkpoint among them.
    pub(super) fn run(
        &self,
        series: &Series<'_>,
        points: &[Vec<f64>],
    ) -> Result<Vec<Ended>, RunError> {
        let n = points.len() as u64;
        let mut all = Vec::with_capacity(points.len());
        for (number, point) in (0..).zip(points) {
            all.push(self.one(series, (number, point))?);
            self.progress.at((number + 1, n), || self.plate.words(point));
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
            return self.compute(series.seed, (point, range), (None, 0.0), &|_, _| Ok(()));
        };
        let name = format!("{} {number}", series.name);
        // A draw of the posterior depends on keys that do not identify the checkpoint.
        let is_this = |ended: &Ended| ended.point == point && holds(&ended.records, &range);
        if let Some(ended) = checkpoint.part::<Ended>(&name)?.filter(is_this) {
            return Ok(ended);
        }
        let past = checkpoint.part::<UnderWay>(UNDER_WAY)?;
        let past = past
            .filter(|(of, at, run, _)| *of == name && at == point && starts(&run.records, &range));
        let past = past.map_or((None, 0.0), |(_, _, run, seconds)| (Some(run), seconds));
        let keep = |so_far: &CrackRun, seconds: f64| {
            if checkpoint.is_due() {
                checkpoint.keep(UNDER_WAY, &(&name, point, so_far, seconds))?;
            }
            Ok(())
        };
        let ended = self.compute(series.seed, (point, range), past, &keep)?;
        checkpoint.keep_if_due(&name, &ended)?;
        Ok(ended)
    }

    /// Runs realisations at a point after those of an earlier run, which took `before` seconds; `keep` observes those so far.
    fn compute(
        &self,
        seed: u64,
        (point, range): (&[f64], Range<u64>),
        (past, before): (Option<CrackRun>, f64),
        keep: &dyn Fn(&CrackRun, f64) -> Result<(), RunError>,
    ) -> Result<Ended, RunError> {
        let plate = self.plate.at(point, seed);
        let PlateAt { scene, problem } =
            plate.map_err(|objection| RunError::from(self.refused(point, &objection)))?;
        let clock = CpuClock::start();
        let all = range.end - range.start;
        let run = problem.run(&scene, range, past, |so_far| {
            if so_far.records.len() as u64 == all {
                return Ok(());
            }
            keep(so_far, before + clock.seconds())
        })?;
        let seconds = before + clock.seconds();
        Ok(Ended { point: point.to_vec(), records: run.records, seconds })
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
