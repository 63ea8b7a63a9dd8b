//! What realisations come to.

use super::crack_run::{BrokenInStep, FinalState};
use super::study::CrackStudy;
use crate::error::Error;
use crate::path::{Fractured, crack_path};
use crate::statistics::{CrackOutcome, CrackRecord};

/// A realisation that has ended.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Ended {
    pub(super) record: CrackRecord,
    pub(super) loads: Vec<f64>,
    /// `None` for one that failed.
    pub(super) damage: Option<Vec<f64>>,
    pub(super) broken: u64,
    pub(super) kept: Option<FinalState>,
}

/// A realisation at the end of its run.
pub(super) struct AtEnd<'a> {
    pub(super) realisation: u64,
    pub(super) loads: &'a [f64],
    /// The largest load.
    pub(super) failure_load: Option<f64>,
    pub(super) history: &'a [BrokenInStep],
    pub(super) damage: Vec<f64>,
    /// If its final state is kept.
    pub(super) displacements: Option<Vec<[f64; 2]>>,
    pub(super) strength: Option<&'a Vec<f64>>,
}

impl CrackStudy<'_> {
    /// Follows the crack and judges the body.
    pub(super) fn ended(&self, end: AtEnd<'_>, cut: &[usize]) -> Result<Ended, Error> {
        let AtEnd { realisation, loads, failure_load, history, damage, displacements, strength } =
            end;
        let mut broken = vec![false; self.bonds.len()];
        for at in history {
            broken[at.bond] = true;
        }
        let body = Fractured { nodes: self.nodes, bonds: self.bonds, broken: &broken, cut };
        let record = if let Some(outcome) = self.broke_elsewhere(&broken, &damage) {
            CrackRecord::without_crack(realisation, outcome)
        } else {
            let path = crack_path(&body, &self.notch, &self.path)?;
            CrackRecord::of_path(realisation, path.as_ref(), Some(self.border), failure_load)
        };
        let kept = displacements.map(|displacements| FinalState {
            realisation,
            displacements,
            damage: damage.clone(),
            history: history.to_vec(),
            strength: strength.cloned(),
        });
        let n_broken = broken.iter().filter(|&&broken| broken).count() - cut.len();
        let (loads, damage) = (loads.to_vec(), Some(damage));
        Ok(Ended { record, loads, damage, broken: n_broken as u64, kept })
    }
}

/// The record of a run that ended with an error.
pub(super) fn failed(realisation: u64, message: &str) -> Ended {
    let outcome = CrackOutcome::Failed(message.to_owned());
    let record = CrackRecord::without_crack(realisation, outcome);
    Ended { record, loads: Vec::new(), damage: None, broken: 0, kept: None }
}
