//! Realisations that run side by side.

use super::crack_run::BrokenInStep;
use super::ended::{AtEnd, failed};
use super::halted::{GroupState, LaneObservations, SavedGroup};
use super::study::{CrackStudy, Stiffness, StudyLaw};
use crate::bodies::body::Body;
use crate::breaking::broken_bond::Cause;
use crate::dynamics::config::SimulationConfig;
use crate::dynamics::simulation::Simulation;
use crate::dynamics::swing;
use crate::error::{Error, same_length};
use crate::fast::{BondList, LatticeBody};
use crate::material::strain::Strain;
use crate::real::Real;

/// Steps after which a group may halt for the first time.
const ASKED_AT: u64 = 4;
/// Steps from there to the next time. Between them lies the check for swings, whose memory is not saved.
const ASKED_EVERY: u64 = swing::EVERY;

/// A path that was lost, and why.
type Lost<const L: usize> = [Option<String>; L];

/// Makes the undamaged body of a group of realisations with these numbers and strengths.
pub(super) type MakeBody<'a, T, const L: usize> =
    dyn Fn([u64; L], &[Vec<f64>]) -> Result<Box<dyn Body<T, 2, L>>, Error> + Sync + 'a;

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
        make: &MakeBody<'_, T, L>,
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
            let mut body = make(ids, &strengths.of_bonds)?;
            leave_out(&mut *body, &lost);
            let mut simulation =
                Simulation::of_any(body, self.loading.clone(), config.clone(), ids)?;
            simulation.cut(cut)?;
            let mut seen = LaneObservations::new(L, cut);
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

    /// An undamaged body in a list, a realisation in each lane.
    pub(super) fn in_list<T: Real, const L: usize>(
        &self,
        ids: [u64; L],
        strengths: &[Vec<f64>],
        strain: Strain,
    ) -> Result<Box<dyn Body<T, 2, L>>, Error> {
        let (nodes, first) = (self.nodes.clone(), &strengths[0]);
        let mut body: BondList<T, 2, L> = match self.law {
            StudyLaw::Softening(_) => return Err(Error::SofteningInTime),
            StudyLaw::LinearSolid(solid) => {
                same_length("bonds of the solid", solid.bonds().len(), self.bonds.len())?;
                BondList::of_solid(nodes, solid.clone(), strain, first)?
            }
            StudyLaw::BondBased => BondList::new(nodes, self.bonds.clone(), strain, first)?,
        };
        if strengths.len() > 1 {
            body = body.with_strengths(strengths)?;
        }
        if let Some(factors) = self.stiffness_factors(ids)? {
            body = body.with_stiffness_factors(&factors)?;
        }
        Ok(Box::new(body))
    }

    /// An undamaged realisation on a lattice.
    pub(super) fn on_lattice<T: Real>(
        &self,
        strengths: &[Vec<f64>],
        strain: Strain,
    ) -> Result<Box<dyn Body<T, 2, 1>>, Error> {
        let (nodes, strengths) = (self.nodes.clone(), &strengths[0]);
        let Some(&first) = strengths.first() else {
            return Err(Error::TooFew { name: "bonds", value: 0, limit: 1 });
        };
        if !matches!(self.stiffness, Stiffness::Uniform) {
            return Err(Error::UniformStiffness { law: "a lattice" });
        }
        let mut body: LatticeBody<T, 2> = match self.law {
            StudyLaw::Softening(_) => return Err(Error::SofteningInTime),
            StudyLaw::LinearSolid(solid) => {
                same_length("bonds of the solid", solid.bonds().len(), self.bonds.len())?;
                LatticeBody::of_solid(nodes, solid.clone(), strain, first)?
            }
            StudyLaw::BondBased => LatticeBody::new(nodes, self.bonds.clone(), strain, first)?,
        };
        if strengths.iter().any(|&strength| (strength - first).abs() > 0.0) {
            body = body.with_strengths(strengths)?;
        }
        Ok(Box::new(body))
    }

    /// Steps to the end, while `goes_on` returns true.
    ///
    /// Mean loads of windows are by the trapezoidal rule over the ends of steps.
    fn follow<T: Real, const L: usize>(
        &self,
        simulation: &mut Simulation<T, 2, L>,
        n_steps: u64,
        seen: &mut LaneObservations,
        goes_on: &dyn Fn(u64) -> bool,
    ) -> Result<(), Error> {
        let (grip, component) = self.load;
        let window = n_steps / self.n_windows;
        let against = self.resists_along();
        let loads = |simulation: &Simulation<T, 2, L>| -> [f64; L] {
            std::array::from_fn(|lane| -against * simulation.pull_on(grip, lane)[component])
        };
        // Forces are those at the start of a step, in inertial dynamics those at its end.
        let lag = u64::from(!simulation.has_forces_of_end());
        if lag == 0 && simulation.steps() == 0 {
            seen.at_end_of(0, window, &loads(simulation));
        }
        for step in simulation.steps() + 1..=n_steps {
            let done = step - 1;
            if (done == 0 || done % ASKED_EVERY == ASKED_AT) && !goes_on(done) {
                return Ok(());
            }
            let report = simulation.step()?;
            for event in report.broken.iter().filter(|event| event.cause != Cause::Cut) {
                for lane in (0..L).filter(|lane| event.lanes & 1 << lane != 0) {
                    seen.histories[lane].push(BrokenInStep { step, bond: event.bond });
                }
            }
            seen.at_end_of(step - lag, window, &loads(simulation));
        }
        if lag > 0 {
            simulation.evaluate_intact()?;
            seen.at_end_of(n_steps, window, &loads(simulation));
        }
        Ok(())
    }

    /// The sign of the displacement prescribed where the load is measured: a body that resists has a positive load, and noise alone
    /// one of mean zero.
    fn resists_along(&self) -> f64 {
        let (grip, component) = self.load;
        let moved: f64 = grip.iter().map(|&node| self.loading.field(node, 1.0)[component]).sum();
        1.0_f64.copysign(moved)
    }
}

/// Breaks all bonds in the lanes that are left out.
fn leave_out<T: Real, const L: usize>(body: &mut dyn Body<T, 2, L>, lost: &Lost<L>) {
    let left_out = (0..L).filter(|&lane| lost[lane].is_some());
    let left_out = left_out.fold(0, |lanes: u16, lane| lanes | 1 << lane);
    for bond in 0..if left_out == 0 { 0 } else { body.bonds().len() } {
        let intact = body.intact(bond);
        body.set_intact(bond, intact & !left_out);
    }
}

/// The state between two steps, as far as there is one that can be saved.
fn halted<T: Real, const L: usize>(
    simulation: &Simulation<T, 2, L>,
    seen: LaneObservations,
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
