//! Realisations that run side by side.

use super::crack_run::BrokenInStep;
use super::ended::{AtEnd, Ended, failed};
use super::study::{CrackStudy, StudyLaw};
use crate::body::Body;
use crate::broken_bond::Cause;
use crate::config::SimulationConfig;
use crate::error::{Error, same_length};
use crate::fast::{BondList, SolidList};
use crate::real::Real;
use crate::simulation::Simulation;

/// A path that was lost, and why.
type Lost<const L: usize> = [Option<String>; L];

type Lanes<T, const L: usize> = Simulation<T, Box<dyn Body<T, 2, L>>, 2, L>;

/// Loads and broken bonds of each lane, observed at every step.
struct Seen<const L: usize> {
    loads: [Vec<f64>; L],
    histories: [Vec<BrokenInStep>; L],
}

impl CrackStudy<'_> {
    /// Runs a group to its end. A lane that is lost is left out, and the others run again without it: lanes are independent, so
    /// their results are bitwise identical.
    pub(super) fn group<T: Real, const L: usize>(
        &self,
        (simulation, n_steps): (&SimulationConfig, u64),
        cut: &[usize],
        ids: [u64; L],
        (keep, wanted): (&[u64], &dyn Fn(u64) -> bool),
    ) -> Result<Vec<Ended>, Error> {
        let config = simulation;
        let strengths = self.strengths(ids)?;
        let mut lost: Lost<L> = std::array::from_fn(|_| None);
        let (simulation, seen) = loop {
            let body = self.body::<T, L>(ids, &strengths.of_bonds, &lost)?;
            let mut simulation = Simulation::new(body, self.loading.clone(), config.clone(), ids)?;
            simulation.cut(cut)?;
            match self.follow(&mut simulation, n_steps, cut) {
                Ok(seen) => break (simulation, seen),
                Err(error) => {
                    let (Error::Lost { realisation, .. } | Error::Swings { realisation, .. }) =
                        error
                    else {
                        return Err(error);
                    };
                    let lane = ids.iter().position(|&id| id == realisation);
                    match lane.filter(|&lane| lost[lane].is_none()) {
                        Some(lane) => lost[lane] = Some(error.to_string()),
                        None => return Err(error),
                    }
                }
            }
        };
        (0..L)
            .filter(|&lane| wanted(ids[lane]))
            .map(|lane| {
                if let Some(message) = &lost[lane] {
                    return Ok(failed(ids[lane], message));
                }
                let keep = keep.contains(&ids[lane]);
                self.ended(
                    AtEnd {
                        realisation: ids[lane],
                        loads: &seen.loads[lane],
                        failure_load: seen.loads[lane].iter().copied().reduce(f64::max),
                        history: &seen.histories[lane],
                        damage: simulation.damage(lane),
                        displacements: keep.then(|| simulation.displacements(lane)),
                        strength: strengths.at_nodes.get(lane),
                    },
                    cut,
                )
            })
            .collect()
    }

    /// Undamaged, but for lanes that are left out.
    fn body<T: Real, const L: usize>(
        &self,
        ids: [u64; L],
        strengths: &[Vec<f64>],
        lost: &Lost<L>,
    ) -> Result<Box<dyn Body<T, 2, L>>, Error> {
        let (nodes, factors) = (self.nodes.clone(), self.stiffness_factors(ids)?);
        let mut body: Box<dyn Body<T, 2, L>> = match self.law {
            StudyLaw::Softening(_) => return Err(Error::SofteningInTime),
            StudyLaw::LinearSolid(_) if factors.is_some() => {
                return Err(Error::UniformStiffness { law: "a linear peridynamic solid" });
            }
            StudyLaw::LinearSolid(solid) => {
                same_length("bonds of the solid", solid.bonds().len(), self.bonds.len())?;
                let each = (0..L).map(|lane| strengths[lane % strengths.len()].clone());
                let each: Vec<_> = each.collect();
                Box::new(SolidList::new(nodes, solid.clone(), self.strain, &each)?)
            }
            StudyLaw::BondBased => {
                let mut body =
                    BondList::new(nodes, self.bonds.clone(), self.strain, &strengths[0])?;
                if strengths.len() > 1 {
                    body = body.with_strengths(strengths)?;
                }
                if let Some(factors) = factors {
                    body = body.with_stiffness_factors(&factors)?;
                }
                Box::new(body)
            }
        };
        let left_out = (0..L).filter(|&lane| lost[lane].is_some());
        let left_out = left_out.fold(0, |lanes: u16, lane| lanes | 1 << lane);
        for bond in 0..if left_out == 0 { 0 } else { self.bonds.len() } {
            let intact = body.intact(bond);
            body.set_intact(bond, intact & !left_out);
        }
        Ok(body)
    }

    fn follow<T: Real, const L: usize>(
        &self,
        simulation: &mut Lanes<T, L>,
        n_steps: u64,
        cut: &[usize],
    ) -> Result<Seen<L>, Error> {
        let (grip, component) = self.load;
        let mut seen = Seen {
            loads: std::array::from_fn(|_| Vec::new()),
            histories: std::array::from_fn(|_| {
                cut.iter().map(|&bond| BrokenInStep { step: 0, bond }).collect()
            }),
        };
        let window = n_steps / self.n_windows;
        let mut sums = [0.0; L];
        for step in 1..=n_steps {
            let report = simulation.step()?;
            for event in report.broken.iter().filter(|event| event.cause != Cause::Cut) {
                for lane in (0..L).filter(|lane| event.lanes & 1 << lane != 0) {
                    seen.histories[lane].push(BrokenInStep { step, bond: event.bond });
                }
            }
            for lane in 0..L {
                sums[lane] += simulation.pull_on(grip, lane)[component].abs();
                if step % window == 0 {
                    seen.loads[lane].push(sums[lane] / window as f64);
                    sums[lane] = 0.0;
                }
            }
        }
        Ok(seen)
    }
}
