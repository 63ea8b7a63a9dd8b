//! A run reversed from its end to its start.

use std::any::Any;

use perturbation_moments::{Jet, LANES};

use super::adjoint::BodyAdjoint;
use super::local::quantity;
use super::revolve::{RevolveAction, fewest_advances, revolve};
use super::saved::{Layout, Saved, layouts};
use super::step::Scheme;
use crate::config::{Config, Contact, UpdateOrder};
use crate::error::Error;
use crate::observation::{Located, Plan, Window};
use crate::record::Schedule;
use crate::shape::Shape;
use crate::simulation::Simulation;

/// A run to be reversed.
#[derive(Debug)]
pub(crate) struct Task<'a, const D: usize> {
    /// At its start.
    pub(crate) run: Simulation<f64, D>,
    /// The same in jets, with derivatives by what the gradient is to be by: numbers without any are taken as certain.
    pub(crate) jets: Simulation<Jet, D>,
    pub(crate) plan: &'a Plan<D>,
    pub(crate) schedule: &'a Schedule,
    /// Numbers of the responses.
    pub(crate) responses: &'a [usize],
    /// Most bytes of kept states.
    pub(crate) memory: usize,
}

/// Derivatives of responses by all numbers of all particles at the start of a run.
#[derive(Debug)]
pub(crate) struct Sensitivities<const D: usize> {
    layouts: Vec<Layout>,
    groups: Vec<Vec<BodyAdjoint<D>>>,
    n_responses: usize,
    pub(crate) cost: SweepCost,
}

/// What a reversed run has cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SweepCost {
    /// Steps of the run, each reversed once.
    pub n_steps: usize,
    /// Steps forward.
    pub n_advances: usize,
    /// States that were kept at once.
    pub n_kept: usize,
    /// Bytes of them all.
    pub bytes: usize,
}

type Sweep<const D: usize> = fn(Task<'_, D>) -> Result<Sensitivities<D>, Error>;

static IN_ONE: Sweep<1> = sweep::<1>;
static IN_TWO: Sweep<2> = sweep::<2>;
static IN_THREE: Sweep<3> = sweep::<3>;

/// Reverses a run: compiled with this crate.
///
/// # Errors
/// [`Error::NotReversed`] for what has no adjoint, [`Error::AdjointMemory`], [`Error::NoSuchResponse`];
/// those of the run.
pub(crate) fn sensitivities<const D: usize>(task: Task<'_, D>) -> Result<Sensitivities<D>, Error> {
    let all: [&'static dyn Any; 3] = [&IN_ONE, &IN_TWO, &IN_THREE];
    match all.into_iter().find_map(<dyn Any>::downcast_ref::<Sweep<D>>) {
        Some(sweep) => sweep(task),
        None => Err(Error::NoSuchDimension { value: D }),
    }
}

/// Refuses configurations whose steps have no adjoint.
fn check<const D: usize>(config: &Config<D>, n_bodies: usize) -> Result<(), Error> {
    let refused = [
        (config.update_order == UpdateOrder::StressFirst, "update stress first"),
        (config.shape == Shape::Gimp, "shape functions of GIMP"),
        (n_bodies > 1 && config.contact != Contact::Bonded, "frictional contact"),
    ];
    match refused.into_iter().find(|(is, _)| *is) {
        Some((_, what)) => Err(Error::NotReversed { what }),
        None => Ok(()),
    }
}

/// Reversal under way.
struct Reversal<'a, const D: usize> {
    scheme: Scheme<D>,
    plan: &'a Plan<D>,
    responses: &'a [usize],
    located: Vec<Located>,
    steps: Vec<f64>,
    /// Weights of windows in the state at the begin of each step, and at the end of the last.
    weights: Vec<Vec<(usize, f64)>>,
    run: Simulation<f64, D>,
    jets: Simulation<Jet, D>,
    groups: Vec<Vec<BodyAdjoint<D>>>,
    slots: Vec<Option<Saved>>,
    /// The slot with the present state, if it is kept, and whether the run is there.
    present: (Option<usize>, bool),
}

fn sweep<const D: usize>(task: Task<'_, D>) -> Result<Sensitivities<D>, Error> {
    let Task { run, mut jets, plan, schedule, responses, memory } = task;
    check(run.config(), run.bodies().len())?;
    let limit = plan.n_responses();
    if let Some(&value) = responses.iter().find(|&&response| response >= limit) {
        return Err(Error::NoSuchResponse { value, limit });
    }
    let depends = |number: &Jet| number.first.iter().any(|&slope| slope != 0.0);
    super::certain::check(&mut jets)?;
    let layouts = layouts(&jets, depends)?;
    let start = Saved::of(&run, &layouts);
    let n_slots = memory / start.bytes();
    if n_slots == 0 {
        return Err(Error::AdjointMemory { value: memory, limit: start.bytes() });
    }
    let steps = schedule.steps().concat();
    let n_kept = n_slots.min(steps.len());
    let with_affine = run.config().transfer == crate::config::Transfer::Apic;
    let group = |_: &[usize]| {
        let bodies = run.bodies().iter().zip(&layouts);
        let zero = |(body, layout): (&crate::body::Body<f64, D>, &Layout)| {
            BodyAdjoint::zero(body.n_particles(), layout, with_affine)
        };
        bodies.map(zero).collect()
    };
    let groups = responses.chunks(LANES).map(group).collect();
    let planes = run.config().boundaries.iter();
    let planes = planes.map(|boundary| boundary.plane(D, &run.config().origin, run.config().cell));
    let scheme = Scheme {
        config: run.config().clone(),
        planes: planes.collect::<Result<_, _>>()?,
        smallest_mass: run.smallest_mass(),
        layouts,
    };
    let cost = SweepCost {
        n_steps: steps.len(),
        // One more to the end of the run.
        n_advances: fewest_advances(steps.len(), n_kept) + usize::from(!steps.is_empty()),
        n_kept,
        bytes: n_kept * start.bytes(),
    };
    let mut reversal = Reversal {
        located: plan.resolve(&run)?,
        weights: weights(plan, schedule),
        slots: vec![None; n_kept],
        present: (None, true),
        scheme,
        plan,
        responses,
        steps,
        run,
        jets,
        groups,
    };
    if reversal.steps.is_empty() {
        reversal.add_responses(0, &start);
    }
    revolve(reversal.steps.len(), n_kept, &mut |action| reversal.act(action))?;
    let Reversal { groups, scheme: Scheme { layouts, .. }, .. } = reversal;
    Ok(Sensitivities { layouts, groups, n_responses: responses.len(), cost })
}

/// Weights of windows in each state, as a run averages them: the trapezoidal rule.
fn weights<const D: usize>(plan: &Plan<D>, schedule: &Schedule) -> Vec<Vec<(usize, f64)>> {
    let (stops, steps) = (plan.stops(), schedule.steps());
    let mut weights = vec![vec![]; schedule.n_steps() + 1];
    for (w, window) in plan.windows.iter().enumerate() {
        if *window == Window::at(0.0) {
            weights[0].push((w, 1.0));
        }
        let (mut state, mut before) = (0, 0.0);
        for (&stop, steps) in stops.iter().zip(steps) {
            if window.from < window.to && window.from <= before && window.to >= stop {
                for (k, dt) in steps.iter().enumerate() {
                    let share = 0.5 * dt / (window.to - window.from);
                    weights[state + k].push((w, share));
                    weights[state + k + 1].push((w, share));
                }
            }
            state += steps.len();
            if *window == Window::at(stop) {
                weights[state].push((w, 1.0));
            }
            before = stop;
        }
    }
    weights
}

impl<const D: usize> Reversal<'_, D> {
    fn act(&mut self, action: RevolveAction) -> Result<(), Error> {
        match action {
            RevolveAction::Keep { slot } => {
                self.slots[slot] = Some(Saved::of(&self.run, &self.scheme.layouts));
                self.present = (Some(slot), true);
            }
            RevolveAction::Return { slot } => self.present = (Some(slot), false),
            RevolveAction::Advance { to } => {
                self.go_to_present();
                while self.n_steps_taken() < to {
                    let dt = self.steps[self.n_steps_taken()];
                    let _ = self.run.step_of(dt)?;
                }
                self.present = (None, true);
            }
            RevolveAction::Reverse { step } => self.reverse(step)?,
        }
        Ok(())
    }

    fn n_steps_taken(&self) -> usize {
        usize::try_from(self.run.n_steps()).unwrap_or(usize::MAX)
    }

    /// Brings the run to the present state.
    fn go_to_present(&mut self) {
        if let (Some(slot), false) = self.present
            && let Some(saved) = &self.slots[slot]
        {
            saved.put(&mut self.run, &self.scheme.layouts);
            self.present.1 = true;
        }
    }

    fn reverse(&mut self, step: usize) -> Result<(), Error> {
        let kept = self.present.0.and_then(|slot| self.slots[slot].take());
        let saved = kept.unwrap_or_else(|| Saved::of(&self.run, &self.scheme.layouts));
        let dt = self.steps[step];
        if step + 1 == self.steps.len() {
            if !self.present.1 {
                saved.put(&mut self.run, &self.scheme.layouts);
            }
            let _ = self.run.step_of(dt)?;
            self.present.1 = false;
            let end = Saved::of(&self.run, &self.scheme.layouts);
            self.add_responses(step + 1, &end);
        }
        let number = step as u64 + 1;
        self.scheme.reverse((&saved, dt, number), &mut self.jets, &mut self.groups)?;
        self.add_responses(step, &saved);
        if let (Some(slot), _) = self.present {
            self.slots[slot] = Some(saved);
        }
        Ok(())
    }

    /// Adds derivatives of the responses by the state in which they are read.
    fn add_responses(&mut self, state: usize, saved: &Saved) {
        for &(window, weight) in &self.weights[state] {
            for (position, &response) in self.responses.iter().enumerate() {
                let (gauge, of, at) = self.plan.parts(response);
                if at != window {
                    continue;
                }
                let (group, lane) = (position / LANES, position % LANES);
                let Located { body, particles } = &self.located[gauge];
                let (layout, saved) = (&self.scheme.layouts[*body], &saved.bodies[*body]);
                for &(particle, share) in particles {
                    let is_it = |&number: &u32| number as usize == particle;
                    let Some(place) = saved.number.iter().position(is_it) else { continue };
                    let row = &saved.rows[place * layout.len..(place + 1) * layout.len];
                    let adjoint = &mut self.groups[group][*body];
                    let jets = &mut self.jets.bodies_mut()[*body];
                    let of = self.plan.quantities[of];
                    quantity(jets, layout, row, of, |kind, derivative| {
                        if let Some(by) = adjoint.of_kind(layout, particle, kind) {
                            by.0[lane] += weight * share * derivative;
                        }
                    });
                }
            }
        }
    }
}

impl<const D: usize> Sensitivities<D> {
    /// The chain rule onto eight coefficients: by response, derivatives by those of a run in jets at its start.
    ///
    /// # Errors
    /// [`Error::NotReversed`] for a number that had no derivatives in the run that was reversed.
    pub(crate) fn by(&mut self, start: &Simulation<Jet, D>) -> Result<Vec<[f64; LANES]>, Error> {
        let mut gradient = vec![[0.0; LANES]; self.n_responses];
        for (b, (body, layout)) in start.bodies().iter().zip(&self.layouts).enumerate() {
            let kinds: Vec<_> = (0..layout.len).map(|number| layout.kind(number)).collect();
            let mut is_known = true;
            for particle in 0..body.n_particles() {
                let mut kinds = kinds.iter();
                let _ = body.show_numbers(particle, &mut |number: &mut Jet| {
                    let kind = kinds.next();
                    if number.first.iter().all(|&slope| slope == 0.0) {
                        return;
                    }
                    for (g, group) in self.groups.iter_mut().enumerate() {
                        let by = kind.and_then(|kind| group[b].of_kind(layout, particle, *kind));
                        let Some(by) = by else {
                            is_known = false;
                            return;
                        };
                        for (sum, of_response) in gradient[g * LANES..].iter_mut().zip(&by.0) {
                            for (sum, slope) in sum.iter_mut().zip(&number.first) {
                                *sum += of_response * slope;
                            }
                        }
                    }
                });
            }
            if !is_known {
                return Err(Error::NotReversed { what: "a number that no step changes" });
            }
        }
        Ok(gradient)
    }
}
