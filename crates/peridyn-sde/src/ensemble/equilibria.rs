//! Realisations under a load that grows slowly.

use super::crack_run::BrokenInStep;
use super::ended::{AtEnd, Ended, failed};
use super::study::{BondOrder, CrackStudy, Stiffness, StudyLaw};
use crate::bodies::body::Body;
use crate::bodies::network::Network;
use crate::equilibrium::{EquilibriumConfig, NextBreakage, QuasiStatic};
use crate::error::Error;
use crate::material::strain::Strain;

/// The part of its stiffness that a bond has lost once it counts as broken. Of a bond that breaks at once it is all.
const BROKEN: f64 = 0.9;

/// A load that grows to a last factor.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlowLoad {
    pub(super) config: EquilibriumConfig,
    pub(super) until: f64,
    /// Equal parts of the last factor.
    pub(super) n_steps: u64,
}

/// Loads and failures under a prescribed displacement.
struct PathObservations {
    /// The load at the end of each window (force).
    loads: Vec<f64>,
    /// The largest load (force).
    largest_load: f64,
    history: Vec<BrokenInStep>,
}

impl CrackStudy<'_> {
    /// One realisation, to the last load factor or its separation; none if `goes_on` returned false.
    pub(super) fn equilibria(
        &self,
        load: SlowLoad,
        cut: &[usize],
        id: u64,
        (keep, goes_on): (&[u64], &dyn Fn() -> bool),
    ) -> Result<Option<Ended>, Error> {
        let mut strengths = self.strengths([id])?;
        let strengths_of_bonds = strengths.of_bonds.swap_remove(0);
        let mut body = self.slow_body(id, strengths_of_bonds)?;
        for &bond in cut {
            body.set_intact(bond, 0);
        }
        let mut run = QuasiStatic::of_any(body, self.loading.clone(), load.config)?;
        let seen = match self.follow_slowly(&mut run, load, (cut, goes_on)) {
            Ok(Some(seen)) => seen,
            Ok(None) => return Ok(None),
            Err(error @ Error::NotInEquilibrium { .. }) => {
                return Ok(Some(failed(id, &error.to_string())));
            }
            Err(error) => return Err(error),
        };
        let end = AtEnd {
            realisation: id,
            loads: &seen.loads,
            failure_load: Some(seen.largest_load),
            history: &seen.history,
            damage: run.damage(),
            displacements: keep.contains(&id).then(|| run.displacements()),
            strength: strengths.at_nodes.first(),
        };
        self.ended(end, cut).map(Some)
    }

    fn slow_body(&self, id: u64, strengths: Vec<f64>) -> Result<Box<dyn Body<f64, 2, 1>>, Error> {
        match (self.law, self.order) {
            (StudyLaw::Softening(_), _) if !matches!(self.stiffness, Stiffness::Uniform) => {
                Err(Error::UniformStiffness { law: "bonds that soften" })
            }
            (StudyLaw::Softening(law), _) => {
                let (nodes, bonds) = (self.nodes.clone(), self.bonds.clone());
                Ok(Box::new(Network::new(nodes, bonds, law, strengths)?))
            }
            (_, BondOrder::List) => self.in_list::<f64, 1>([id], &[strengths], Strain::Linear),
            (_, BondOrder::Lattice) => self.on_lattice::<f64>(&[strengths], Strain::Linear),
        }
    }

    /// From event to event. A prescribed displacement keeps the largest factor so far, while the path may fall behind it.
    fn follow_slowly(
        &self,
        run: &mut QuasiStatic<2>,
        load: SlowLoad,
        (cut, goes_on): (&[usize], &dyn Fn() -> bool),
    ) -> Result<Option<PathObservations>, Error> {
        let SlowLoad { until, n_steps, .. } = load;
        let (grip, component) = self.load;
        let mut seen = PathObservations {
            loads: Vec::new(),
            largest_load: 0.0,
            history: cut.iter().map(|&bond| BrokenInStep { step: 0, bond }).collect(),
        };
        let end = |window: u64| until * window as f64 / self.n_windows as f64;
        let mut largest = 0.0;
        // The load for each unit of the factor.
        let mut slope = run.pull_of_unit_load(grip)?[component].abs();
        while let Some(factor) = run.next_factor()?.filter(|&factor| factor <= until) {
            if !goes_on() {
                return Ok(None);
            }
            if factor > largest {
                largest = factor;
                seen.largest_load = seen.largest_load.max(slope * factor);
                seen.extend(slope, |window| window < self.n_windows && end(window) < factor, end);
            }
            let NextBreakage::At(event) = run.next_breakage()? else {
                slope = 0.0;
                break;
            };
            slope = run.pull_of_unit_load(grip)?[component].abs();
            let step = step_at(largest / until, n_steps);
            let broken = event.bonds.into_iter();
            let broken = broken.filter(|&bond| run.body().bond_damage(bond, 0) >= BROKEN);
            seen.history.extend(broken.map(|bond| BrokenInStep { step, bond }));
        }
        if slope > 0.0 {
            run.scale_to(until)?;
            seen.largest_load = seen.largest_load.max(slope * until);
        }
        seen.extend(slope, |window| window <= self.n_windows, end);
        Ok(Some(seen))
    }
}

impl PathObservations {
    /// The loads at the ends of the windows up to the last one that is to be seen.
    fn extend(&mut self, slope: f64, is_seen: impl Fn(u64) -> bool, end: impl Fn(u64) -> f64) {
        let mut window = self.loads.len() as u64 + 1;
        while is_seen(window) {
            self.loads.push(slope * end(window));
            window += 1;
        }
    }
}

/// The part of the last factor, from 1 on.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between 1 and the number of parts"
)]
fn step_at(part: f64, n_steps: u64) -> u64 {
    (part * n_steps as f64).ceil().clamp(1.0, n_steps as f64) as u64
}
