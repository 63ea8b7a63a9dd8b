//! Runs of an ensemble of cracks.

use rayon::prelude::*;

use super::crack_run::CrackRun;
use super::ended::Ended;
use super::equilibria::SlowLoad;
use super::study::{CrackStudy, Procedure};
use crate::error::{Error, positive};
use crate::real::Real;
use crate::statistics::DamageMap;

impl CrackStudy<'_> {
    /// Runs the realisations of a range, `L` side by side (8 or 16) and groups of them in parallel; under a quasi-static load one by
    /// one in `f64`, whatever `T` and `L`. `keep` are the numbers of those whose final state is wanted; `finished` gets the number
    /// of realisations that ended since.
    ///
    /// A realisation whose path is lost, or that comes to no equilibrium, is counted as failed, with its reason.
    ///
    /// # Errors
    /// [`Error::TooFew`] for no realisation, no window or fewer steps than windows; [`Error::SofteningInTime`],
    /// [`Error::UniformStiffness`]; those of [`Simulation::new`](crate::Simulation::new), of
    /// [`QuasiStatic::next_breakage`](crate::QuasiStatic::next_breakage), of the notch and of the fields; of values that are given,
    /// those of [`between_nodes`](crate::between_nodes). [`Error::NotPositive`] for the last load factor.
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
        least("steps", self.n_steps(), self.n_windows)?;
        let cut = self.bonds.across_segment(self.nodes, (self.notch.mouth, self.notch.tip))?;
        let (simulation, n_steps) = match self.procedure {
            Procedure::Dynamic { simulation, n_steps } => (simulation, n_steps),
            Procedure::QuasiStatic { config, until, n_steps, .. } => {
                positive("last load factor", until)?;
                let load = SlowLoad { config, until, n_steps };
                return self.run_groups(realisations, &|id| {
                    let ended = self.equilibria(load, &cut, id, keep)?;
                    finished(1);
                    Ok(vec![ended])
                });
            }
        };
        let lanes = L as u64;
        let groups = realisations.start / lanes..realisations.end.div_ceil(lanes);
        self.run_groups(groups, &|group| {
            let ids = std::array::from_fn(|lane| group * lanes + lane as u64);
            let wanted = |id: u64| realisations.contains(&id);
            let motion = (simulation, n_steps);
            let ended = self.group::<T, L>(motion, &cut, ids, (keep, &wanted))?;
            finished(ended.len() as u64);
            Ok(ended)
        })
    }

    /// Runs groups in parallel and joins their realisations. A virtual call runs a group, so that what is around it is compiled
    /// once.
    fn run_groups(
        &self,
        groups: std::ops::Range<u64>,
        run_group: &(dyn Fn(u64) -> Result<Vec<Ended>, Error> + Sync),
    ) -> Result<CrackRun, Error> {
        let runs: Result<Vec<_>, Error> = groups.into_par_iter().map(run_group).collect();
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
