//! Runs of an ensemble of cracks.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::crack_run::CrackRun;
use super::ended::Ended;
use super::equilibria::SlowLoad;
use super::group::{Lanes, MakeBody};
use super::halted::{GroupProgress, GroupState, HaltedGroup, HaltedRun};
use super::study::{BondOrder, CrackStudy, Precision, Procedure};
use crate::dynamics::config::SimulationConfig;
use crate::error::{Error, at_least, positive};
use crate::real::Real;
use crate::statistics::DamageMap;

impl CrackStudy<'_> {
    /// Runs the realisations of a range, in groups side by side and groups in parallel; on a [lattice](BondOrder::Lattice) and under
    /// a quasi-static load one by one. `keep` are the numbers of those whose final state is wanted.
    /// [`run_while`](Self::run_while) can be halted.
    ///
    /// Ranges may run apart, in any order and on any machine: [`CrackRun::append`] joins their results, bitwise identical to one run.
    ///
    /// A realisation whose path is lost, or that comes to no equilibrium, is counted as failed, with its reason.
    ///
    /// # Errors
    /// [`Error::TooFew`] for no realisation, no window or fewer steps than windows; [`Error::SofteningInTime`],
    /// [`Error::UniformStiffness`]; those of [`Simulation::new`](crate::Simulation::new), of
    /// [`QuasiStatic::next_breakage`](crate::QuasiStatic::next_breakage), of the notch and of the fields; of values that are given,
    /// those of [`between_nodes`](crate::between_nodes). [`Error::Parameter`] for the last load factor.
    pub fn run(&self, realisations: Range<u64>, keep: &[u64]) -> Result<CrackRun, Error> {
        let groups = self.groups(HaltedRun::at_start(realisations), keep, &|_| true)?;
        self.joined(groups.into_iter().flat_map(HaltedGroup::ended))
    }

    /// Runs all groups of a range that have not ended, in parallel.
    pub(super) fn groups(
        &self,
        halted: HaltedRun,
        keep: &[u64],
        goes_on: &(dyn Fn(GroupProgress) -> bool + Sync),
    ) -> Result<Vec<HaltedGroup>, Error> {
        let HaltedRun { realisations, groups: known } = halted;
        let least = |name, value: u64, limit: u64| {
            let [value, limit] = [value, limit].map(|n| usize::try_from(n).unwrap_or(usize::MAX));
            at_least(name, value, limit)
        };
        let count = realisations.end.saturating_sub(realisations.start);
        least("realisations", count, 1)?;
        least("windows of the load", self.n_windows, 1)?;
        least("steps", self.n_steps(), self.n_windows)?;
        let cut = self.bonds.across_segment(self.nodes, (self.notch.mouth, self.notch.tip))?;
        let (simulation, n_steps) = match self.procedure {
            Procedure::Dynamic { simulation, n_steps } => (simulation, n_steps),
            Procedure::QuasiStatic { config, until, n_steps, .. } => {
                positive("last load factor", until)?;
                let load = SlowLoad { config, until, n_steps };
                return run_groups(realisations, known, &|id, _| {
                    let goes_on = || goes_on(GroupProgress { realisation: id, done: None });
                    let ended = self.equilibria(load, &cut, id, (keep, &goes_on))?;
                    Ok(ended.map_or(GroupState::Unsaved, |ended| GroupState::Finished(vec![ended])))
                });
            }
        };
        let motion = (simulation, n_steps);
        let run = InTime { realisations: &realisations, motion, cut: &cut, keep, goes_on };
        let strain = self.strain;
        match (self.order, self.precision) {
            (BondOrder::List, Precision::Double) => {
                self.in_time::<f64, 8>(&run, known, &|ids, of| self.in_list(ids, of, strain))
            }
            (BondOrder::List, Precision::Single) => {
                self.in_time::<f32, 16>(&run, known, &|ids, of| self.in_list(ids, of, strain))
            }
            (BondOrder::Lattice, Precision::Double) => {
                self.in_time::<f64, 1>(&run, known, &|_, of| self.on_lattice(of, strain))
            }
            (BondOrder::Lattice, Precision::Single) => {
                self.in_time::<f32, 1>(&run, known, &|_, of| self.on_lattice(of, strain))
            }
        }
    }

    /// Runs groups of `L` realisations in time.
    fn in_time<T: Real, const L: usize>(
        &self,
        run: &InTime<'_>,
        known: Vec<HaltedGroup>,
        make: &MakeBody<'_, T, L>,
    ) -> Result<Vec<HaltedGroup>, Error> {
        let InTime { realisations, motion, cut, keep, goes_on } = *run;
        let lanes = L as u64;
        let groups = realisations.start / lanes..realisations.end.div_ceil(lanes);
        let wanted = |id: u64| realisations.contains(&id);
        run_groups(groups, known, &|group, known| {
            let ids: [u64; L] = std::array::from_fn(|lane| group * lanes + lane as u64);
            let realisation = ids[0].max(realisations.start);
            let goes_on = |step: u64| {
                let done = Some(step as f64 / motion.1 as f64);
                goes_on(GroupProgress { realisation, done })
            };
            let group = Lanes { ids, motion, cut, keep };
            self.group::<T, L>(&group, make, known, (&wanted, &goes_on))
        })
    }

    /// Joins realisations in order.
    pub(super) fn joined(&self, all: impl IntoIterator<Item = Ended>) -> Result<CrackRun, Error> {
        let mut run = CrackRun {
            records: Vec::new(),
            loads: Vec::new(),
            damage: DamageMap::new(self.nodes.positions().len(), self.damage_threshold)?,
            broken: Vec::new(),
            kept: Vec::new(),
        };
        for ended in all {
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

/// A run in time.
struct InTime<'a> {
    realisations: &'a Range<u64>,
    /// How bodies move, and their steps.
    motion: (&'a SimulationConfig, u64),
    /// Bonds of the notch.
    cut: &'a [usize],
    /// Numbers of those whose final state is wanted.
    keep: &'a [u64],
    goes_on: &'a (dyn Fn(GroupProgress) -> bool + Sync),
}

type RunGroup<'a> = dyn Fn(u64, Option<GroupState>) -> Result<GroupState, Error> + Sync + 'a;

/// Runs groups in parallel, each from where it is known to be. A virtual call runs a group, so that what is around it is compiled
/// once.
fn run_groups(
    groups: Range<u64>,
    known: Vec<HaltedGroup>,
    run_group: &RunGroup<'_>,
) -> Result<Vec<HaltedGroup>, Error> {
    let mut known: BTreeMap<u64, GroupState> =
        known.into_iter().map(|HaltedGroup { group, at }| (group, at)).collect();
    let all: Vec<_> = groups.map(|group| (group, known.remove(&group))).collect();
    let run = |(group, known)| {
        let at = match known {
            Some(ended @ GroupState::Finished(_)) => ended,
            known => run_group(group, known)?,
        };
        Ok(HaltedGroup { group, at })
    };
    all.into_par_iter().map(run).collect()
}
