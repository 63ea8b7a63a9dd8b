//! Results of an ensemble of cracks.

use crate::error::Error;
use crate::statistics::{CrackRecord, DamageMap};

/// Results of some realisations.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CrackRun {
    /// One for each, by number.
    pub records: Vec<CrackRecord>,
    /// The mean load of each window, by realisation (force); empty for one that failed.
    pub loads: Vec<Vec<f64>>,
    /// Of all that did not fail.
    pub damage: DamageMap,
    /// Bonds that broke, by realisation; those of the notch not among them.
    pub broken: Vec<u64>,
    /// Of the realisations that were to be kept.
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
    /// The strength at each node (a stretch), if it is not the same everywhere.
    pub strength: Option<Vec<f64>>,
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
