//! Realisations that run side by side.

use super::crack_run::BrokenInStep;
use super::ended::{AtEnd, failed};
use super::halted::{GroupState, SavedGroup, Seen};
use super::study::{CrackStudy, StudyLaw};
use crate::body::Body;
use crate::broken_bond::Cause;
use crate::config::SimulationConfig;
use crate::error::{Error, same_length};
use crate::fast::{BondList, SolidList};
use crate::real::Real;
use crate::simulation::Simulation;
use crate::swing;

/// Steps after which a group may halt for the first time.
const ASKED_AT: u64 = 4;
/// Steps from there to the next time. Between them lies the check for swings, whose memory is not saved.
const ASKED_EVERY: u64 = swing::EVERY;

/// A path that was lost, and why.
type Lost<const L: usize> = [Option<String>; L];

type Motion<T, const L: usize> = Simulation<T, Box<dyn Body<T, 2, L>>, 2, L>;

/// Realisations of a group.
pub(super) struct Lanes<'a, const L: usize> {
    pub(super) ids: [u64; L],
    /// How it moves, and its steps.
    pub(super) motion: (&'a SimulationConfig, u64),
    /// Bonds of the notch.
    pub(super) cut: &'a [usize],
    /// Numbers of those whose final state is wanted.
    pub(super) keep: &'a [u64],
}

impl CrackStudy<'_> {
    /// Runs a group to its end, while `goes_on` returns true for the steps taken. A lane that is lost is left out, and the
    /// others run again without it: lanes are independent, so their results are bitwise identical.
    pub(super) fn group<T: Real, const L: usize>(
        &self,
        group: &Lanes<'_, L>,
        known: Option<GroupState>,
        (wanted, goes_on): (&dyn Fn(u64) -> bool, &dyn Fn(u64) -> bool),
    ) -> Result<GroupState, Error> {
        let Lanes { ids, motion: (config, n_steps), cut, keep } = *group;
        let strengths = self.strengths(ids)?;
        let (mut saved_group, mut lost) = (None, std::array::from_fn(|_| None));
        if let Some(GroupState::AtStep(known)) = known {
            known.check(L, self.bonds.len(), n_steps)?;
            let SavedGroup { saved, seen, lost: reasons } = *known;
            lost.iter_mut().zip(reasons).for_each(|(lost, reason)| *lost = reason);
            saved_group = Some((saved, seen));
        }
        let (simulation, seen) = loop {
            let body = self.body::<T, L>(ids, &strengths.of_bonds, &lost)?;
            let mut simulation = Simulation::new(body, self.loading.clone(), config.clone(), ids)?;
            simulation.cut(cut)?;
            let mut seen = Seen::new(L, cut);
            if let Some((saved, before)) = saved_group.take() {
                simulation.restore(&saved)?;
                seen = before;
            }
            match self.follow(&mut simulation, n_steps, &mut seen, goes_on) {
                Ok(()) if simulation.steps() < n_steps => {
                    return halted(&simulation, seen, &lost);
                }
                Ok(()) => break (simulation, seen),
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
        let ended = (0..L)
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
            .collect::<Result<_, _>>()?;
        Ok(GroupState::Finished(ended))
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

    /// Steps to the end, while `goes_on` returns true.
    fn follow<T: Real, const L: usize>(
        &self,
        simulation: &mut Motion<T, L>,
        n_steps: u64,
        seen: &mut Seen,
        goes_on: &dyn Fn(u64) -> bool,
    ) -> Result<(), Error> {
        let (grip, component) = self.load;
        let window = n_steps / self.n_windows;
        for step in simulation.steps() + 1..=n_steps {
            let done = step - 1;
            if (done == 0 || done % ASKED_EVERY == ASKED_AT) && !goes_on(done) {
                break;
            }
            let report = simulation.step()?;
            for event in report.broken.iter().filter(|event| event.cause != Cause::Cut) {
                for lane in (0..L).filter(|lane| event.lanes & 1 << lane != 0) {
                    seen.histories[lane].push(BrokenInStep { step, bond: event.bond });
                }
            }
            for lane in 0..L {
                seen.sums[lane] += simulation.pull_on(grip, lane)[component].abs();
                if step % window == 0 {
                    seen.loads[lane].push(seen.sums[lane] / window as f64);
                    seen.sums[lane] = 0.0;
                }
            }
        }
        Ok(())
    }
}

/// The state between two steps, as far as there is one that can be saved.
fn halted<T: Real, const L: usize>(
    simulation: &Motion<T, L>,
    seen: Seen,
    lost: &Lost<L>,
) -> Result<GroupState, Error> {
    if simulation.steps() == 0 {
        return Ok(GroupState::Unsaved);
    }
    match simulation.save() {
        Ok(saved) => {
            Ok(GroupState::AtStep(Box::new(SavedGroup { saved, seen, lost: lost.to_vec() })))
        }
        Err(Error::NotSaved) => Ok(GroupState::Unsaved),
        Err(error) => Err(error),
    }
}
