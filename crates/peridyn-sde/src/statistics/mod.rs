//! Statistics of cracks over an ensemble.
//!
//! What a realisation comes to is a [`CrackRecord`]; records of any shards make a [`CrackEnsemble`], in order of realisations, so
//! that every statistic is bitwise identical for any division of the work. Damage of nodes goes into a [`DamageMap`].

mod bootstrap;
mod damage_map;
mod ensemble;
mod record;
mod summaries;

pub use bootstrap::{Bootstrap, Interval};
pub use damage_map::DamageMap;
pub use ensemble::{Band, CrackEnsemble, Distribution};
pub use record::{CrackOutcome, CrackRecord};
pub use summaries::{CrackSummaries, LoadSummary, SummaryConfig};

/// Probabilities of the reported quantiles.
pub const QUANTILES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];
