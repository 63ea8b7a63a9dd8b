//! Many cracks of one body: realisations side by side, in shards.

mod fate;
mod group;
mod shard;

use rayon::prelude::*;

pub use shard::{CrackShard, merge_shards};

use crate::bonds::Bonds;
use crate::disorder::{BondValue, DisorderField};
use crate::error::Error;
use crate::fast::Strain;
use crate::loading::Loading;
use crate::nodes::Nodes;
use crate::path::{Notch, PathConfig};
use crate::real::Real;
use crate::simulation::SimulationConfig;
use crate::statistics::{CrackRecord, DamageMap};

/// The stretches at which bonds break.
#[derive(Debug, Clone, Copy)]
pub enum Strength<'a> {
    /// One for all.
    Uniform(f64),
    /// From a field of its own in each realisation.
    Field {
        /// The critical stretch at the nodes.
        field: &'a DisorderField,
        /// Between them.
        value: BondValue,
    },
    /// From values at the nodes that are given, the same in each realisation.
    Given {
        /// The critical stretch at the nodes.
        values: &'a [f64],
        /// Between them.
        value: BondValue,
    },
}

/// Factors on the stiffness of bonds.
#[derive(Debug, Clone, Copy)]
pub enum Stiffness<'a> {
    /// One.
    Uniform,
    /// From a field of its own in each realisation.
    Field {
        /// The factor at the nodes, of mean one.
        field: &'a DisorderField,
        /// Between them.
        value: BondValue,
    },
    /// From factors at the nodes that are given, the same in each realisation.
    Given {
        /// The factor at the nodes.
        values: &'a [f64],
        /// Between them.
        value: BondValue,
    },
}

/// A notched body that is pulled apart, again and again: with other noise, or another field of strength, each time.
///
/// The numbers of a realisation follow from the seed and its own number alone: not from how many there are, which run side by
/// side, or how many threads run them.
#[derive(Debug, Clone, Copy)]
pub struct CrackStudy<'a> {
    /// The nodes.
    pub nodes: &'a Nodes<2>,
    /// The bonds.
    pub bonds: &'a Bonds,
    /// How strains are measured.
    pub strain: Strain,
    /// When bonds break.
    pub strength: Strength<'a>,
    /// How stiff they are, over their mean. A field of stiffness bends the stresses on the length of its correlation; a smooth
    /// field of strength turns a crack only by what one horizon sees of it.
    pub stiffness: Stiffness<'a>,
    /// Nodes none of whose bonds breaks, such as those around grips.
    pub no_fail: &'a [usize],
    /// The notch that cracks are followed from; it is cut in.
    pub notch: Notch,
    /// What is done to the body.
    pub loading: &'a Loading<2>,
    /// How it moves.
    pub simulation: &'a SimulationConfig,
    /// Steps of each realisation.
    pub n_steps: u64,
    /// Where the load is measured: nodes of a grip, and the component of the force.
    pub load: (&'a [usize], usize),
    /// Load is averaged over so many windows of equal length, without the remainder of the steps; the largest mean is the failure
    /// load.
    pub n_windows: u64,
    /// What counts as a crack.
    pub path: PathConfig,
    /// The abscissa at which a crack leaves the body (length).
    pub border: f64,
    /// Damage from which a node counts as damaged in the map.
    pub damage_threshold: f64,
}

/// What became of some realisations.
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
    /// Takes in realisations that come after all that are in.
    ///
    /// # Errors
    /// Those of [`DamageMap::merge`]; nothing is taken in then.
    pub fn append(&mut self, later: Self) -> Result<(), Error> {
        self.damage.merge(&later.damage)?;
        self.records.extend(later.records);
        self.loads.extend(later.loads);
        self.broken.extend(later.broken);
        self.kept.extend(later.kept);
        Ok(())
    }
}

impl CrackStudy<'_> {
    /// Runs the realisations of a range, `L` side by side and groups of them in parallel. `keep` are the numbers of those whose
    /// final state is wanted; `finished` is told how many more have ended.
    ///
    /// A realisation whose path is lost is counted as failed, with its reason.
    ///
    /// # Errors
    /// [`Error::TooFew`] for no realisation, no window or fewer steps than windows; those of
    /// [`Simulation::new`](crate::Simulation::new), of the notch and of the fields; of values that are given, those of
    /// [`between_nodes`](crate::between_nodes).
    pub fn run<T: Real, const L: usize>(
        &self,
        realisations: std::ops::Range<u64>,
        keep: &[u64],
        finished: &(dyn Fn(u64) + Sync),
    ) -> Result<CrackRun, Error> {
        let least = |name, value: u64, limit: u64| {
            let [value, limit] = [value, limit].map(|n| usize::try_from(n).unwrap_or(usize::MAX));
            if value < limit { Err(Error::TooFew { name, value, limit }) } else { Ok(()) }
        };
        let count = realisations.end.saturating_sub(realisations.start);
        least("realisations", count, 1)?;
        least("windows of the load", self.n_windows, 1)?;
        least("steps", self.n_steps, self.n_windows)?;
        let cut = self.bonds.across_segment(self.nodes, (self.notch.mouth, self.notch.tip))?;
        let lanes = L as u64;
        let groups = realisations.start / lanes..realisations.end.div_ceil(lanes);
        let runs: Result<Vec<_>, Error> = groups
            .into_par_iter()
            .map(|group| {
                let ids = std::array::from_fn(|lane| group * lanes + lane as u64);
                let wanted = |id: u64| realisations.contains(&id);
                let ended = self.group::<T, L>(&cut, ids, keep, &wanted)?;
                finished(ended.len() as u64);
                Ok(ended)
            })
            .collect();
        let mut run = CrackRun {
            records: Vec::new(),
            loads: Vec::new(),
            damage: DamageMap::new(self.nodes.positions().len(), self.damage_threshold)?,
            broken: Vec::new(),
            kept: Vec::new(),
        };
        for ended in runs?.into_iter().flatten() {
            if let Some(damage) = &ended.damage {
                run.damage.push(ended.record.realisation, damage)?;
            }
            run.records.push(ended.record);
            run.loads.push(ended.loads);
            run.broken.push(ended.broken);
            run.kept.extend(ended.kept);
        }
        Ok(run)
    }
}
