//! What `fpk-sph` can bear on the damper of Canor & Denoël 2013, section 4.1: reach of the neighbourhood, step, reach and
//! count of the lattice, time, exponent of the damper.

use fpk_sph::systems::{ViscousDamper, ViscousDamperParameters};
use fpk_sph::{Combination, Config, InitialLattice, Method, Scheme, Simulation, StepRule};

use super::axes::{linear, logarithmic, words};
use super::{Panel, Work};
use crate::case::{CaseError, Context, Profile};
use crate::chart::Scale;
use crate::charts::{ChartKind, Drawing};
use crate::fpk::problem::Problem;
use crate::fpk::scene::System;

pub(crate) const MAP: ChartKind = ChartKind {
    name: "fpk",
    title: "methods of fpk-sph on the damper: reach, step, lattice, time, exponent",
    draw,
};

/// Most steps of a run: a hundred times what an accurate one takes.
const MOST_STEPS: u64 = 10_000;
/// Of E[q^2].
const TOLERANCE: f64 = 0.01;
/// The time of the sweeps that do not sweep it: noise at its plateau.
const TIME: f64 = 4.0;
/// `trace(D) / E[v^2]` at its largest, at t = 1 (reference): what the diffusion limit holds against the step.
const SPREAD: f64 = 0.05 / 0.02122;

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let n = if context.profile == Profile::Quick { 4 } else { 9 };
    let damper = Damper::new()?;
    let mut drawings = Vec::new();
    for (id, name, method) in METHODS {
        drawings.push(damper.reach_and_step(n, id, name, method)?);
        drawings.push(damper.lattice(n, id, name, method)?);
        drawings.push(damper.time(n, id, name, method)?);
    }
    drawings.push(damper.forward_euler(n)?);
    drawings.push(damper.exponent(n)?);
    Ok(drawings)
}

const METHODS: [(&str, &str, Method); 2] = [
    ("log-density-fit", "log-density fit", Method::LogDensityFit),
    ("flow-map-fit", "flow-map fit", Method::FlowMapFit),
];

fn drawn(panel: &Panel<'_>) -> Result<Drawing, CaseError> {
    Ok(panel.sweep()?)
}

/// An odd count of particles along an axis.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "tens of particles")]
fn odd(count: f64) -> usize {
    2 * (0.5 * count).round() as usize + 1
}

struct Damper {
    problem: Problem,
    system: ViscousDamper,
}

impl Damper {
    fn new() -> Result<Self, CaseError> {
        let problem = Problem::viscous_damper()?;
        let System::Damper(system) = &problem.system else {
            return Err("the scene of the damper is not one".into());
        };
        let system = system.clone();
        Ok(Self { problem, system })
    }

    /// `E[q^2]` at a time, by a run of its own.
    fn second_moment(
        &self,
        system: ViscousDamper,
        combination: Combination,
        lattice: InitialLattice<2>,
        time: f64,
        work: &mut Work,
    ) -> Result<f64, CaseError> {
        let config = Config {
            method: Method::Custom(combination),
            lattice,
            reference_period: system.period(),
            most_steps: MOST_STEPS,
        };
        let mut simulation = Simulation::new(system, &self.problem.law, &config)?;
        let outcome = simulation.advance_to(time);
        work.spend(simulation.work().steps)?;
        outcome?;
        Ok(simulation.raw_moment([2, 0]))
    }

    /// The relative error of `E[q^2]` against the reference.
    fn error(
        &self,
        combination: Combination,
        lattice: InitialLattice<2>,
        time: f64,
        work: &mut Work,
    ) -> Result<f64, CaseError> {
        let reference =
            self.problem.reference.moment([2, 0], time).ok_or("no reference at this time")?;
        let found = self.second_moment(self.system.clone(), combination, lattice, time, work)?;
        Ok((found / reference.value - 1.0).abs())
    }

    fn reach_and_step(
        &self,
        n: u32,
        id: &str,
        name: &str,
        method: Method,
    ) -> Result<Drawing, CaseError> {
        let run = |ratio: f64, dt: f64, work: &mut Work| {
            let combination = Combination {
                support_over_spacing: ratio,
                step: StepRule::Fixed { dt },
                ..method.combination()
            };
            self.error(combination, InitialLattice::box_of(41), TIME, work)
        };
        // 12 standard deviations over 40 spacings.
        let limit = |ratio: f64| {
            Some(Scheme::RungeKutta4.diffusion_limit() * (0.3 * ratio).powi(2) / SPREAD)
        };
        drawn(&Panel {
            name: format!("fpk-reach-step-{id}"),
            words: words(
                format!("{name}: reach of the neighbourhood and step"),
                "E[q²] of the damper at t = 4, 41 x 41 particles, Runge-Kutta 4 at a fixed step",
                ["reach / spacing", "step (s)"],
                "Boundary: the diffusion limit, 0.25 R² / D at its smallest. Too few neighbours end a run before it starts.",
            ),
            scale: Scale::Log,
            across: linear(n, 1.2, 3.6),
            upwards: logarithmic(n, 0.01, 0.3),
            boundary: Some(("diffusion limit", &limit)),
            tolerance: TOLERANCE,
            work_limit: MOST_STEPS,
            run: &run,
        })
    }

    fn lattice(&self, n: u32, id: &str, name: &str, method: Method) -> Result<Drawing, CaseError> {
        let run = |reach: f64, count: f64, work: &mut Work| {
            let lattice = InitialLattice::Box { reach, count: [odd(count); 2] };
            self.error(method.combination(), lattice, TIME, work)
        };
        drawn(&Panel {
            name: format!("fpk-lattice-{id}"),
            words: words(
                format!("{name}: reach and count of the lattice"),
                "E[q²] of the damper at t = 4",
                ["reach of the lattice (standard deviations)", "particles along an axis"],
                "A lattice that ends at r standard deviations lacks the second moment beyond: 1 % at 3.4.",
            ),
            scale: Scale::Log,
            across: linear(n, 2.5, 8.5),
            upwards: logarithmic(n, 9.0, 81.0),
            boundary: None,
            tolerance: TOLERANCE,
            work_limit: MOST_STEPS,
            run: &run,
        })
    }

    /// The noise dies from t = 6 on and the cloud falls onto a slow manifold.
    fn time(&self, n: u32, id: &str, name: &str, method: Method) -> Result<Drawing, CaseError> {
        let run = |time: f64, count: f64, work: &mut Work| {
            self.error(method.combination(), InitialLattice::box_of(odd(count)), time.round(), work)
        };
        drawn(&Panel {
            name: format!("fpk-time-{id}"),
            words: words(
                format!("{name}: time and particles"),
                "E[q²] of the damper; the noise decays from t = 6 on, to 3e-4 at t = 10",
                ["time (s)", "particles along an axis"],
                "Reach of the lattice: 6 standard deviations.",
            ),
            scale: Scale::Log,
            across: vec![1.0, 2.0, 4.0, 6.0, 7.0, 8.0, 10.0],
            upwards: logarithmic(n, 15.0, 81.0),
            boundary: None,
            tolerance: TOLERANCE,
            work_limit: MOST_STEPS,
            run: &run,
        })
    }

    fn forward_euler(&self, n: u32) -> Result<Drawing, CaseError> {
        let run = |time: f64, dt: f64, work: &mut Work| {
            let combination = Combination {
                scheme: Scheme::ForwardEuler,
                step: StepRule::Fixed { dt },
                ..Method::FlowMapFit.combination()
            };
            self.error(combination, InitialLattice::box_of(31), time.round(), work)
        };
        let omega_squared = std::f64::consts::PI.powi(2);
        let growth = |time: f64| Some(TOLERANCE.ln_1p() / (omega_squared * time));
        drawn(&Panel {
            name: "fpk-forward-euler".into(),
            words: words(
                "forward Euler: time and step".into(),
                "E[q²] of the damper, flow-map fit, 31 x 31 particles",
                ["time (s)", "step (s)"],
                "Boundary: an undamped oscillator grows by exp(ω² dt t) in energy; the damper takes part of it out.",
            ),
            scale: Scale::Log,
            across: vec![1.0, 2.0, 4.0, 6.0],
            upwards: logarithmic(n, 5e-4, 0.1),
            boundary: Some(("growth of 1 % in energy", &growth)),
            tolerance: TOLERANCE,
            work_limit: MOST_STEPS,
            run: &run,
        })
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
        let mut finest = Vec::new();
        for &exponent in &across {
            let combination = Combination {
                step: StepRule::DiffusionLimited { longest: 0.01 },
                ..Method::FlowMapFit.combination()
            };
            let lattice = InitialLattice::box_of(81);
            let mut work = Work::new(MOST_STEPS);
            finest.push(self.second_moment(
                system(exponent)?,
                combination,
                lattice,
                TIME,
                &mut work,
            ));
        }
        let run = |exponent: f64, dt: f64, work: &mut Work| {
            let k = across.iter().position(|e| (e - exponent).abs() < 1e-12);
            let Some(Ok(finest)) = k.and_then(|k| finest.get(k)) else {
                return Err("the run to compare with has failed".into());
            };
            let combination =
                Combination { step: StepRule::Fixed { dt }, ..Method::FlowMapFit.combination() };
            let lattice = InitialLattice::box_of(41);
            let found = self.second_moment(system(exponent)?, combination, lattice, TIME, work)?;
            Ok((found / finest - 1.0).abs())
        };
        let limit =
            |_: f64| Some(Scheme::RungeKutta4.diffusion_limit() * (0.3_f64 * 2.8).powi(2) / SPREAD);
        drawn(&Panel {
            name: "fpk-exponent".into(),
            words: words(
                "flow-map fit: exponent of the damper and step".into(),
                "E[q²] at t = 4, 41 x 41 particles, against 81 x 81 with steps of at most 0.01",
                ["exponent of the damper", "step (s)"],
                "Boundary: the diffusion limit of the exponent 0.35, not swept.",
            ),
            scale: Scale::Log,
            across: across.clone(),
            upwards: logarithmic(n, 0.01, 0.3),
            boundary: Some(("diffusion limit", &limit)),
            tolerance: TOLERANCE,
            work_limit: MOST_STEPS,
            run: &run,
        })
    }
}
