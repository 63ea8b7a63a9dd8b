//! Realisations that run side by side.

use super::crack_run::{BrokenInStep, FinalState};
use super::study::{CrackStudy, Stiffness, Strength};
use crate::broken_bond::Cause;
use crate::disorder::{DisorderField, between_nodes};
use crate::error::Error;
use crate::fast::BondList;
use crate::path::{Fractured, crack_path};
use crate::real::Real;
use crate::simulation::Simulation;
use crate::statistics::{CrackOutcome, CrackRecord};

/// A stretch that no bond comes to.
const NEVER: f64 = 1e6;

/// A realisation that has ended.
pub(super) struct Ended {
    pub(super) record: CrackRecord,
    pub(super) loads: Vec<f64>,
    /// `None` for one that failed.
    pub(super) damage: Option<Vec<f64>>,
    pub(super) broken: u64,
    pub(super) kept: Option<FinalState>,
}

/// Strengths of the realisations of a group.
struct Strengths {
    /// Of the bonds, lane by lane, or one for all.
    of_bonds: Vec<Vec<f64>>,
    /// At the nodes, lane by lane; none where they are one.
    at_nodes: Vec<Vec<f64>>,
}

/// A path that was lost, and why.
type Lost<const L: usize> = [Option<String>; L];

type Lanes<T, const L: usize> = Simulation<T, BondList<T, 2, L>, 2, L>;

/// Loads and broken bonds of each lane, observed at every step.
struct Seen<const L: usize> {
    loads: [Vec<f64>; L],
    histories: [Vec<BrokenInStep>; L],
}

/// A lane at the end of its run.
struct LaneEnd<'a> {
    realisation: u64,
    loads: &'a [f64],
    history: &'a [BrokenInStep],
    damage: Vec<f64>,
    /// If its final state is kept.
    displacements: Option<Vec<[f64; 2]>>,
    strength: Option<&'a Vec<f64>>,
}

impl CrackStudy<'_> {
    /// Runs a group to its end. A lane that is lost is left out, and the others run again without it: lanes are independent, so
    /// their results are bitwise identical.
    pub(super) fn group<T: Real, const L: usize>(
        &self,
        cut: &[usize],
        ids: [u64; L],
        keep: &[u64],
        wanted: &dyn Fn(u64) -> bool,
    ) -> Result<Vec<Ended>, Error> {
        let strengths = self.strengths(ids)?;
        let mut lost: Lost<L> = std::array::from_fn(|_| None);
        let (simulation, seen) = loop {
            let mut simulation = self.start::<T, L>(cut, ids, &strengths.of_bonds, &lost)?;
            match self.follow(&mut simulation, cut) {
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
                    LaneEnd {
                        realisation: ids[lane],
                        loads: &seen.loads[lane],
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

    /// A field at the nodes, lane by lane.
    fn sample<const L: usize>(
        &self,
        field: &DisorderField,
        ids: [u64; L],
    ) -> Result<Vec<Vec<f64>>, Error> {
        ids.iter()
            .map(|&id| {
                let mut values = vec![0.0; self.nodes.positions().len()];
                field.sample(&self.simulation.noise, id, &mut values)?;
                Ok(values)
            })
            .collect()
    }

    /// The strengths of a group.
    fn strengths<const L: usize>(&self, ids: [u64; L]) -> Result<Strengths, Error> {
        let (of_bonds, at_nodes) = match self.strength {
            Strength::Uniform(strength) => (vec![vec![strength; self.bonds.len()]], Vec::new()),
            Strength::Given { values, value } => {
                (vec![between_nodes(self.bonds, values, value)?], vec![values.to_vec(); L])
            }
            Strength::Field { field, value } => {
                let fields = self.sample(field, ids)?;
                let of = |field: &Vec<f64>| between_nodes(self.bonds, field, value);
                (fields.iter().map(of).collect::<Result<_, _>>()?, fields)
            }
            Strength::Weibull(weibull) => {
                let mut drawn = vec![vec![0.0; self.bonds.len()]; L];
                for (strengths, &id) in drawn.iter_mut().zip(&ids) {
                    weibull.sample(&self.simulation.noise, id, strengths)?;
                }
                let at_nodes =
                    drawn.iter().map(|of| weibull.weakest_at_nodes(self.bonds, of)).collect();
                (drawn, at_nodes)
            }
        };
        let of_bonds =
            of_bonds.into_iter().map(|of| self.protected(of)).collect::<Result<_, _>>()?;
        Ok(Strengths { of_bonds, at_nodes })
    }

    fn start<T: Real, const L: usize>(
        &self,
        cut: &[usize],
        ids: [u64; L],
        strengths: &[Vec<f64>],
        lost: &Lost<L>,
    ) -> Result<Lanes<T, L>, Error> {
        let (nodes, bonds) = (self.nodes.clone(), self.bonds.clone());
        let mut body = BondList::new(nodes, bonds, self.strain, &strengths[0])?;
        if let Strength::Field { .. } | Strength::Weibull(_) = self.strength {
            body = body.with_strengths(strengths)?;
        }
        if let Some(factors) = self.stiffness_factors(ids)? {
            body = body.with_stiffness_factors(&factors)?;
        }
        for lane in (0..L).filter(|&lane| lost[lane].is_some()) {
            body.leave_out(lane);
        }
        let mut simulation =
            Simulation::new(body, self.loading.clone(), self.simulation.clone(), ids)?;
        simulation.cut(cut)?;
        Ok(simulation)
    }

    /// Of the bonds, lane by lane; none where they are all one.
    fn stiffness_factors<const L: usize>(
        &self,
        ids: [u64; L],
    ) -> Result<Option<Vec<Vec<f64>>>, Error> {
        match self.stiffness {
            Stiffness::Uniform => Ok(None),
            Stiffness::Given { values, value } => {
                Ok(Some(vec![between_nodes(self.bonds, values, value)?; L]))
            }
            Stiffness::Field { field, value } => {
                let fields = self.sample(field, ids)?;
                let of = |field: &Vec<f64>| between_nodes(self.bonds, field, value);
                fields.iter().map(of).collect::<Result<_, _>>().map(Some)
            }
        }
    }

    /// Strengths with those of bonds that must not break out of reach.
    fn protected(&self, mut strengths: Vec<f64>) -> Result<Vec<f64>, Error> {
        let n = self.nodes.positions().len();
        let mut is_protected = vec![false; n];
        for &node in self.no_fail {
            match is_protected.get_mut(node) {
                Some(flag) => *flag = true,
                None => {
                    return Err(Error::Length {
                        name: "the number of a node",
                        value: node,
                        expected: n,
                    });
                }
            }
        }
        for (strength, (i, j)) in strengths.iter_mut().zip(self.bonds.pairs()) {
            if is_protected[i] || is_protected[j] {
                *strength = NEVER;
            }
        }
        Ok(strengths)
    }

    fn follow<T: Real, const L: usize>(
        &self,
        simulation: &mut Lanes<T, L>,
        cut: &[usize],
    ) -> Result<Seen<L>, Error> {
        let (grip, component) = self.load;
        let mut seen = Seen {
            loads: std::array::from_fn(|_| Vec::new()),
            histories: std::array::from_fn(|_| {
                cut.iter().map(|&bond| BrokenInStep { step: 0, bond }).collect()
            }),
        };
        let window = self.n_steps / self.n_windows;
        let mut sums = [0.0; L];
        for step in 1..=self.n_steps {
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

    fn ended(&self, lane: LaneEnd<'_>, cut: &[usize]) -> Result<Ended, Error> {
        let LaneEnd { realisation, loads, history, damage, displacements, strength } = lane;
        let mut broken = vec![false; self.bonds.len()];
        for at in history {
            broken[at.bond] = true;
        }
        let body = Fractured { nodes: self.nodes, bonds: self.bonds, broken: &broken, cut };
        let failure_load = loads
            .iter()
            .copied()
            .fold(None, |most: Option<f64>, load| Some(most.map_or(load, |most| most.max(load))));
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

fn failed(realisation: u64, message: &str) -> Ended {
    let outcome = CrackOutcome::Failed(message.to_owned());
    let record = CrackRecord::without_crack(realisation, outcome);
    Ended { record, loads: Vec::new(), damage: None, broken: 0, kept: None }
}
