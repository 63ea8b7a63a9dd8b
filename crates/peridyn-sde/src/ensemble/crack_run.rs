//! Results of an ensemble of cracks.

use crate::bodies::bonds::Bonds;
use crate::error::{Error, exists};
use crate::statistics::{CrackRecord, DamageMap};

/// Results of some realisations.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CrackRun {
    /// One for each, by number.
    pub records: Vec<CrackRecord>,
    /// The mean load of each window, by realisation (force); empty for one that failed.
    pub loads: Vec<Vec<f64>>,
    /// Damage over all realisations that did not fail.
    pub damage: DamageMap,
    /// Bonds that broke, by realisation; those of the notch not among them.
    pub broken: Vec<u64>,
    /// Final states of the realisations that were to be kept.
    pub kept: Vec<FinalState>,
}

/// A realisation at its end.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FinalState {
    /// Its number.
    pub realisation: u64,
    /// Displacements (length).
    pub displacements: Vec<[f64; 2]>,
    /// Damage of each node.
    pub damage: Vec<f64>,
    /// Bonds in the order in which they broke; those of the notch come first.
    pub history: Vec<BrokenInStep>,
    /// The strength at each node (a stretch), if it is not the same everywhere.
    pub strength: Option<Vec<f64>>,
}

/// A bond that broke, and when.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BrokenInStep {
    /// The step, from 1 on; 0 for a bond that the notch cuts.
    pub step: u64,
    /// Its number in [`Bonds::all`].
    pub bond: usize,
}

impl FinalState {
    /// Damage of each node after a step: the part of the stiffness of its bonds that is lost by then. After the last step it is
    /// bitwise [`damage`](Self::damage).
    ///
    /// `bonds` are those of the study.
    ///
    /// # Errors
    /// [`Error::Length`] for bonds of another body.
    pub fn damage_at(&self, bonds: &Bonds, step: u64) -> Result<Vec<f64>, Error> {
        let mut broken = vec![0.0; bonds.len()];
        for at in self.history.iter().take_while(|at| at.step <= step) {
            exists("the number of a broken bond", at.bond, bonds.len())?;
            broken[at.bond] = 1.0;
        }
        Ok(bonds.damage_of_nodes(|bond| broken[bond]))
    }
}

impl CrackRun {
    /// Adds realisations that come after all that are here.
    ///
    /// # Errors
    /// Those of [`DamageMap::merge`]; nothing is added then.
    pub fn append(&mut self, later: Self) -> Result<(), Error> {
        self.damage.merge(&later.damage)?;
        self.records.extend(later.records);
        self.loads.extend(later.loads);
        self.broken.extend(later.broken);
        self.kept.extend(later.kept);
        Ok(())
    }
}
