//! Ensembles that are halted before their end, and resumed.

use std::ops::Range;

use super::crack_run::{BrokenInStep, CrackRun};
use super::ended::Ended;
use super::study::CrackStudy;
use crate::dynamics::saved::SavedState;
use crate::error::{Error, exists, same_length};

/// How far a group of realisations that run side by side has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupProgress {
    /// The first of them.
    pub realisation: u64,
    /// The part of their steps that is done; none under a quasi-static load, where the next bonds to break may be the last.
    pub done: Option<f64>,
}

/// What [`CrackStudy::run_while`] came to.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub enum RunOutcome {
    /// All realisations ended.
    Finished(CrackRun),
    /// The caller ended it before.
    Halted(HaltedRun),
}

/// Realisations of which some are not at their end. [`CrackStudy::resume_while`] continues them, bitwise identical to one run.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HaltedRun {
    pub(super) realisations: Range<u64>,
    pub(super) groups: Vec<HaltedGroup>,
}

/// A group of realisations, by its number.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct HaltedGroup {
    pub(super) group: u64,
    pub(super) at: GroupState,
}

/// State of a group of realisations.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum GroupState {
    /// At its end.
    Finished(Vec<Ended>),
    /// After a step, from which it goes on.
    AtStep(Box<SavedGroup>),
    /// At a state that cannot be saved: it starts again.
    Unsaved,
}

/// A group between two steps.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct SavedGroup {
    pub(super) saved: SavedState,
    pub(super) seen: LaneObservations,
    /// Why a lane is left out.
    pub(super) lost: Vec<Option<String>>,
}

/// What was observed of each lane.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct LaneObservations {
    /// Mean load of each window that has ended (force).
    pub(super) loads: Vec<Vec<f64>>,
    /// Sum of the loads of the window that has not (force).
    pub(super) sums: Vec<f64>,
    pub(super) histories: Vec<Vec<BrokenInStep>>,
}

impl LaneObservations {
    /// Observations of lanes of which nothing but the cut bonds is broken.
    pub(super) fn new(lanes: usize, cut: &[usize]) -> Self {
        let history: Vec<_> = cut.iter().map(|&bond| BrokenInStep { step: 0, bond }).collect();
        Self {
            loads: vec![Vec::new(); lanes],
            sums: vec![0.0; lanes],
            histories: vec![history; lanes],
        }
    }

    /// Takes in the loads of all lanes at the end of a step, of which a window has so many; half of one counts at its ends.
    pub(super) fn at_end_of(&mut self, step: u64, window: u64, loads: &[f64]) {
        for (lane, &load) in loads.iter().enumerate() {
            if !step.is_multiple_of(window) {
                self.sums[lane] += load;
                continue;
            }
            if step > 0 {
                self.loads[lane].push((self.sums[lane] + 0.5 * load) / window as f64);
            }
            self.sums[lane] = 0.5 * load;
        }
    }
}

impl SavedGroup {
    /// Refuses the state of another study, as far as the state of the simulation itself does not.
    pub(super) fn check(&self, lanes: usize, n_bonds: usize, n_steps: u64) -> Result<(), Error> {
        let Self { saved, seen, lost } = self;
        if saved.step > n_steps {
            return Err(Error::SavedStep { value: saved.step, limit: n_steps });
        }
        for of_lanes in [seen.loads.len(), seen.sums.len(), seen.histories.len(), lost.len()] {
            same_length("lanes of a halted run", of_lanes, lanes)?;
        }
        let mut broken = seen.histories.iter().flatten();
        broken.try_for_each(|at| exists("the number of a broken bond", at.bond, n_bonds))
    }
}

impl HaltedGroup {
    /// Its realisations that have ended.
    pub(super) fn ended(self) -> Vec<Ended> {
        match self.at {
            GroupState::Finished(ended) => ended,
            GroupState::AtStep(_) | GroupState::Unsaved => Vec::new(),
        }
    }
}

impl HaltedRun {
    /// A run of realisations that have not begun.
    pub(super) const fn at_start(realisations: Range<u64>) -> Self {
        Self { realisations, groups: Vec::new() }
    }

    /// Its realisations.
    #[must_use]
    pub fn realisations(&self) -> Range<u64> {
        self.realisations.clone()
    }
}

impl CrackStudy<'_> {
    /// As [`run`](Self::run), while `goes_on` returns true. All threads call it, after every eighth step or, under a quasi-static
    /// load, before bonds break. Once it has returned false it must not return true again: each group halts at its own next call.
    ///
    /// The outcome holds realisations that have ended, and the state of those between two steps. Realisations under a quasi-static
    /// load have no such state: they start again.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_while(
        &self,
        realisations: Range<u64>,
        keep: &[u64],
        goes_on: &(dyn Fn(GroupProgress) -> bool + Sync),
    ) -> Result<RunOutcome, Error> {
        self.resume_while(HaltedRun::at_start(realisations), keep, goes_on)
    }

    /// Continues realisations that were halted; results are bitwise identical to those of a run in one piece.
    ///
    /// # Errors
    /// As [`run`](Self::run); [`Error::Length`], [`Error::SavedStep`], [`Error::SavedBond`] and [`Error::Node`] for realisations
    /// of another study, as far as it can be seen.
    pub fn resume_while(
        &self,
        halted: HaltedRun,
        keep: &[u64],
        goes_on: &(dyn Fn(GroupProgress) -> bool + Sync),
    ) -> Result<RunOutcome, Error> {
        let realisations = halted.realisations.clone();
        let groups = self.groups(halted, keep, goes_on)?;
        if groups.iter().all(|group| matches!(group.at, GroupState::Finished(_))) {
            return self
                .joined(groups.into_iter().flat_map(HaltedGroup::ended))
                .map(RunOutcome::Finished);
        }
        Ok(RunOutcome::Halted(HaltedRun { realisations, groups }))
    }
}
