//! Stability limits of `fpk-sph` on the damper of Canor & Denoël 2013, section 4.1.
//!
//! Swept are the support radius, the step, half-width and particle count of the lattice, the time, and the exponent of the
//! damper; for forward Euler time and step.
//!
//! The predicted step is the diffusion limit of Runge-Kutta 4,
//!
//! $$ \Delta t = \frac{0.25 \ell^2}{\max_{i,t} \operatorname{tr}(F_i^{-1} D F_i^{-T})}, $$
//!
//! with the deformed cells `F_i` in spacings and `l^2 = min(R^2, 10.4 / k^2)`, where `R` is the support radius in spacings
//! and `k` the steepest gradient that the fit gives to a wave of the lattice. `l(R)` comes from the estimator on an undeformed lattice, the trace from a run with
//! 81 x 81 particles and steps of at most 0.01. It is 4 times the trace of 41 x 41, since `F` is in spacings.

use fpk_sph::score::LatticePlaces;
use fpk_sph::{Combination, Config, InitialLattice, Method, Scheme, Simulation, StepRule};
use neighbour_search::{CellGrid, NeighbourList, NeighbourSearch, Radii};
use particle_store::Lattice;
use result_figures::Drawing;
use vibrating_systems::{ViscousDamper, ViscousDamperParameters};

use super::axes::{linear, logarithmic, words};
use super::{Limits, Panel, Work};
use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::fpk::oscillator::Oscillator;
use reference_problems::fpk::problem::Problem;

pub(crate) const MAP: ChartKind = ChartKind {
    name: "fpk",
    title: "the flow-map fit on the damper: reach, step, lattice, time, exponent; forward Euler",
    draw,
};

/// Tolerance of E[q^2], and a work limit in steps of a hundred times that of an accurate run.
const LIMITS: Limits = Limits { tolerance: 0.01, work: 10_000 };
/// Time of the other sweeps: noise at its plateau.
const TIME: f64 = 4.0;
/// Particles along an axis of the reference run, which also gives the diffusion limit.
const FINE: usize = 81;
/// Particles along an axis of the swept runs.
const COARSE: usize = 41;

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let n = if context.profile == Profile::Quick { 4 } else { 9 };
    let damper = Damper::new()?;
    Ok(vec![
        damper.reach_and_step(n)?,
        damper.lattice(n)?,
        damper.time(n)?,
        damper.forward_euler(n)?,
        damper.exponent(n)?,
    ])
}

/// Caption of the line in the map of support radius and step.
const REACH_AND_STEP: &str = "Boundary: the diffusion limit 0.25 l² / max tr(F⁻¹ D F⁻ᵀ), cells F in spacings; \
     the trace from a run with 81 x 81 particles; l² = min(R², 10.4 / k²) with the reach R and k the steepest gradient that \
     the fit gives to a wave. \
     No line where the reach holds too few neighbours: such a run does not start.";

/// Diffusion limit for [`COARSE`] particles per side from that for [`FINE`]: it scales with the squared spacing.
fn of_coarse(limit_of_fine: f64) -> f64 {
    limit_of_fine * ((FINE - 1) as f64 / (COARSE - 1) as f64).powi(2)
}

/// An odd number of particles along an axis.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "tens of particles")]
fn odd(count: f64) -> usize {
    2 * (0.5 * count).round() as usize + 1
}

/// Squared length, in spacings, in the diffusion limit on an undeformed lattice.
///
/// None if the support holds too few neighbours.
fn resolved(reach: f64) -> Result<Option<f64>, CaseError> {
    let mut estimator = combination().estimator.build::<2>();
    if estimator.check_resolution(reach).is_err() {
        return Ok(None);
    }
    let lattice = Lattice::<2>::ball_lattice(2.0 * reach, 1.0)?;
    let places: Vec<[f64; 2]> = lattice.indices.iter().map(|index| index.map(f64::from)).collect();
    let mut neighbours = NeighbourList::new();
    CellGrid::new().full_list(&places, Radii::Uniform(reach), &mut neighbours)?;
    neighbours.sort_rows();
    let at_rest = LatticePlaces { places: &places, neighbours: &neighbours, reach, spacing: 1.0 };
    estimator.start(&at_rest)?;
    let identity = [[1.0, 0.0], [0.0, 1.0]];
    Ok(Some(2.0 / estimator.spread(&identity, reach, &identity)))
}

/// The swept method, from which a sweep changes one or two entries.
fn combination() -> Combination {
    Method::FlowMapFit.combination()
}

/// Result of a run to a time.
struct Run {
    /// `E[q^2]` at the end.
    second_moment: f64,
    /// Smallest diffusion limit reported by its steps.
    least_limit: f64,
}

struct Damper {
    problem: Problem,
    system: ViscousDamper,
}

impl Damper {
    fn new() -> Result<Self, CaseError> {
        let problem = Problem::viscous_damper()?;
        let Oscillator::Damper(system) = &problem.system else {
            return Err("the scene of the damper is not one".into());
        };
        let system = system.clone();
        Ok(Self { problem, system })
    }

    fn run(
        &self,
        system: ViscousDamper,
        combination: Combination,
        lattice: InitialLattice<2>,
        time: f64,
        work: &mut Work,
    ) -> Result<Run, CaseError> {
        let config = Config {
            method: Method::Custom(combination),
            lattice,
            reference_period: system.period(),
            most_steps: LIMITS.work,
        };
        let mut simulation = Simulation::new(system, &self.problem.law, &config)?;
        let mut least_limit = f64::INFINITY;
        let mut to_the_end = || -> Result<(), fpk_sph::Error> {
            while simulation.time() < time {
                least_limit = least_limit.min(simulation.step_towards(time)?.diffusion_limit);
            }
            Ok(())
        };
        let outcome = to_the_end();
        work.spend(simulation.work().steps)?;
        outcome?;
        Ok(Run { second_moment: simulation.raw_moment([2, 0]), least_limit })
    }

    /// The run with [`FINE`] particles per side, in steps of at most 0.01.
    fn fine_run(&self, system: ViscousDamper) -> Result<Run, CaseError> {
        let step = StepRule::DiffusionLimited { longest: 0.01 };
        let combination = Combination { step, ..combination() };
        let lattice = InitialLattice::box_of(FINE);
        self.run(system, combination, lattice, TIME, &mut Work::new(LIMITS.work))
    }

    /// Relative error of `E[q^2]` against the reference.
    fn error(
        &self,
        combination: Combination,
        lattice: InitialLattice<2>,
        time: f64,
        work: &mut Work,
    ) -> Result<f64, CaseError> {
        let reference =
            self.problem.reference.moment([2, 0], time).ok_or("no reference at this time")?;
        let found = self.run(self.system.clone(), combination, lattice, time, work)?;
        Ok((found.second_moment / reference.value - 1.0).abs())
    }

    fn reach_and_step(&self, n: u32) -> Result<Drawing, CaseError> {
        let run = |ratio: f64, dt: f64, work: &mut Work| {
            let step = StepRule::Fixed { dt };
            let combination = Combination { support_over_spacing: ratio, step, ..combination() };
            self.error(combination, InitialLattice::box_of(COARSE), TIME, work)
        };
        let own = resolved(combination().support_over_spacing)?
            .ok_or("the default support radius of the method is rejected")?;
        let limit = of_coarse(self.fine_run(self.system.clone())?.least_limit);
        // If the support is rejected there is no stable step.
        let limit = |ratio: f64| match resolved(ratio) {
            Ok(length) => Some(length.map_or(0.0, |length| limit * length / own)),
            Err(_) => None,
        };
        Panel {
            name: "fpk-reach-step-flow-map-fit".into(),
            words: words(
                "flow-map fit: reach of the neighbourhood and step".into(),
                "E[q²] of the damper at t = 4, 41 x 41 particles, Runge-Kutta 4 at a fixed step",
                ["reach / spacing", "step (s)"],
                REACH_AND_STEP,
            ),
            across: linear(n, 1.2, 3.6),
            upwards: logarithmic(n, 0.01, 0.3),
            boundary: Some(("diffusion limit", &limit)),
            limits: LIMITS,
            run: &run,
        }
        .sweep()
    }

    fn lattice(&self, n: u32) -> Result<Drawing, CaseError> {
        let run = |reach: f64, count: f64, work: &mut Work| {
            let lattice = InitialLattice::Box { reach, count: [odd(count); 2] };
            self.error(combination(), lattice, TIME, work)
        };
        Panel {
            name: "fpk-lattice-flow-map-fit".into(),
            words: words(
                "flow-map fit: reach and count of the lattice".into(),
                "E[q²] of the damper at t = 4",
                ["reach of the lattice (standard deviations)", "particles along an axis"],
                "A lattice that ends at r standard deviations lacks the second moment beyond: 1 % at 3.4.",
            ),
            across: linear(n, 2.5, 8.5),
            upwards: logarithmic(n, 9.0, 81.0),
            boundary: None,
            limits: LIMITS,
            run: &run,
        }
        .sweep()
    }

    /// The noise decays from t = 6 on and the cloud collapses onto a slow manifold.
    fn time(&self, n: u32) -> Result<Drawing, CaseError> {
        let run = |time: f64, count: f64, work: &mut Work| {
            self.error(combination(), InitialLattice::box_of(odd(count)), time.round(), work)
        };
        Panel {
            name: "fpk-time-flow-map-fit".into(),
            words: words(
                "flow-map fit: time and particles".into(),
                "E[q²] of the damper; the noise decays from t = 6 on, to 3e-4 at t = 10",
                ["time (s)", "particles along an axis"],
                "Reach of the lattice: 6 standard deviations.",
            ),
            across: vec![1.0, 2.0, 4.0, 6.0, 7.0, 8.0, 10.0],
            upwards: logarithmic(n, 15.0, 81.0),
            boundary: None,
            limits: LIMITS,
            run: &run,
        }
        .sweep()
    }

    fn forward_euler(&self, n: u32) -> Result<Drawing, CaseError> {
        let run = |time: f64, dt: f64, work: &mut Work| {
            let (scheme, step) = (Scheme::ForwardEuler, StepRule::Fixed { dt });
            let combination = Combination { scheme, step, ..combination() };
            self.error(combination, InitialLattice::box_of(31), time.round(), work)
        };
        let omega_squared = std::f64::consts::PI.powi(2);
        let growth = |time: f64| Some(LIMITS.tolerance.ln_1p() / (omega_squared * time));
        Panel {
            name: "fpk-forward-euler".into(),
            words: words(
                "forward Euler: time and step".into(),
                "E[q²] of the damper, flow-map fit, 31 x 31 particles",
                ["time (s)", "step (s)"],
                "Boundary: an undamped oscillator grows by exp(ω² dt t) in energy; the damper takes part of it out.",
            ),
            across: vec![1.0, 2.0, 4.0, 6.0],
            upwards: logarithmic(n, 5e-4, 0.1),
            boundary: Some(("growth of 1 % in energy", &growth)),
            limits: LIMITS,
            run: &run,
        }
        .sweep()
    }

    /// Below 1 the drift has no Lipschitz constant at rest.
    fn exponent(&self, n: u32) -> Result<Drawing, CaseError> {
        let structure = self.system.structure().parameters().clone();
        let system = |damper_exponent: f64| {
            ViscousDamper::new(ViscousDamperParameters {
                structure: structure.clone(),
                damper_coefficient: 0.25,
                damper_exponent,
            })
        };
        let across = linear(n, 0.1, 1.0);
        let mut fine_runs = Vec::new();
        for &exponent in &across {
            fine_runs.push(self.fine_run(system(exponent)?));
        }
        let fine_at = |exponent: f64| {
            let k = across.iter().position(|e| (e - exponent).abs() < 1e-12);
            k.and_then(|k| fine_runs.get(k)?.as_ref().ok())
        };
        let run = |exponent: f64, dt: f64, work: &mut Work| {
            let fine = fine_at(exponent).ok_or("the run to compare with has failed")?;
            let combination = Combination { step: StepRule::Fixed { dt }, ..combination() };
            let lattice = InitialLattice::box_of(COARSE);
            let found = self.run(system(exponent)?, combination, lattice, TIME, work)?;
            Ok((found.second_moment / fine.second_moment - 1.0).abs())
        };
        // The limit is interpolated linearly between the exponents that were run.
        let limit = |exponent: f64| {
            let after = across.partition_point(|&e| e < exponent - 1e-12);
            let limit_at = |k: usize| Some(of_coarse(fine_runs.get(k)?.as_ref().ok()?.least_limit));
            let to = across.get(after)?;
            if after == 0 || (to - exponent).abs() < 1e-12 {
                return limit_at(after);
            }
            let from = across[after - 1];
            let part = (exponent - from) / (to - from);
            Some((1.0 - part) * limit_at(after - 1)? + part * limit_at(after)?)
        };
        Panel {
            name: "fpk-exponent".into(),
            words: words(
                "flow-map fit: exponent of the damper and step".into(),
                "E[q²] at t = 4, 41 x 41 particles, against 81 x 81 with steps of at most 0.01",
                ["exponent of the damper", "step (s)"],
                "Boundary: the diffusion limit of the run with 81 x 81 particles, four times it for spacings twice as wide.",
            ),
            across: across.clone(),
            upwards: logarithmic(n, 0.01, 0.3),
            boundary: Some(("diffusion limit", &limit)),
            limits: LIMITS,
            run: &run,
        }
        .sweep()
    }
}
