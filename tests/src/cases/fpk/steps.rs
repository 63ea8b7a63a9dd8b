//! The error of the step where the density depends on smoothing lengths: its order, and its size for Bouc-Wen.

use fpk_sph::score::{Degree, VolumeEstimate};
use fpk_sph::{
    Combination, Config, DEFAULT_MOST_STEPS, Estimator, InitialLattice, Method, Simulation,
    StepRule,
};
use result_figures::{ErrorKind, Reference};
use scenes::fpk::density::estimate;
use sde_integrators::{GaussianMixture, Sde};
use work_precision::order;
use work_precision::problems::fpk::oscillator::Oscillator;
use work_precision::problems::fpk::problem::{Problem, bouc_wen};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/steps",
    title: "Order and size of the step's error, log-density fit with kernel-sum volumes",
    source: "runs with shorter steps; Canor & Denoël 2013, sections 4.1 and 4.2",
    cost: Profile::Default,
    schedule: Schedule::Together,
    run,
};

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = vec![linear(context)?];
    claims.extend(hysteresis(context)?);
    Ok(claims)
}

/// The fit whose densities depend on smoothing lengths most: kernel-sum volumes.
fn kernel_sums(steps_per_period: f64) -> Method {
    let (volume, degree) = (VolumeEstimate::KernelSum, Degree::Quadratic);
    Method::Custom(Combination {
        estimator: Estimator::LogDensityFit { volume, degree },
        step: StepRule::PeriodFraction { steps_per_period },
        ..Method::LogDensityFit.combination()
    })
}

/// `E[v^2]` and `P(|q| > T)` by cells at a time, with so many steps a period of 2.
fn observed<S: Sde<D, M> + Clone, const D: usize, const M: usize>(
    (system, law): (&S, &GaussianMixture<D>),
    lattice: InitialLattice<D>,
    (t, threshold): (f64, f64),
    steps_per_period: f64,
) -> Result<[f64; 2], CaseError> {
    let config = Config {
        method: kernel_sums(steps_per_period),
        lattice,
        reference_period: 2.0,
        most_steps: DEFAULT_MOST_STEPS,
    };
    let mut simulation = Simulation::new(system.clone(), law, &config)?;
    simulation.advance_to(t)?;
    let powers = std::array::from_fn(|k| if k == 1 { 2 } else { 0 });
    let tail = simulation.cell_integral()?.exceedance(|x| x[0].abs(), threshold)?;
    Ok([simulation.raw_moment(powers), estimate(tail.probability())])
}

/// The order of a tail probability of the linear oscillator, whose drift has no kink, at t = 1.5.
fn linear(context: &Context<'_>) -> Result<Claim, CaseError> {
    let problem = Problem::linear_oscillator()?;
    let Oscillator::Linear(system) = &problem.system else {
        return Err("the scene holds another system".into());
    };
    let lattice = InitialLattice::Ball { reach: 5.0, spacing: 0.4 };
    let tail = |steps| {
        let [_, tail] = observed((system, &problem.law), lattice, (1.5, 0.5), steps)?;
        Ok::<_, CaseError>(tail)
    };
    let fine = tail(640.0)?;
    let mut levels = Vec::new();
    for steps in STEPS {
        levels.push((2.0 / steps, (tail(steps)? / fine - 1.0).abs()));
    }
    let errors: Vec<String> = levels.iter().map(|level| format!("{:.1e}", level.1)).collect();
    let method = format!("{STEPS:?} steps a period against 640: {}", errors.join(", "));
    let (name, quantity) =
        ("linear-oscillator/exceedance-cell/order", "order in the step of |error| of P(|q| > 0.5)");
    let subject = context.subject(name, quantity, "", &method);
    let reason = "smoothing lengths follow the rate of the kernel sum, with an error of the second order in the step; frozen over \
                  a step they leave the first";
    let criterion = Criterion::Within { tolerance: 0.3, reason };
    let (order, expected) = (order::fit(&levels)?, Reference::exact(2.0));
    Ok(Claim::judge(subject, ErrorKind::Order, order, expected, criterion))
}

const STEPS: [f64; 4] = [40.0, 57.0, 80.0, 113.0];

/// What a fortieth of the period leaves for Bouc-Wen.
fn hysteresis(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let (system, law, _) = bouc_wen()?;
    let lattice = InitialLattice::Ball { reach: 6.0, spacing: 0.6 };
    let at = |steps| observed((&system, &law), lattice, (2.0, 0.5), steps);
    let (coarse, fine) = (at(40.0)?, at(160.0)?);
    let method = "ball of 6 sigma, spacing 0.6, 40 steps a period against 160".to_owned();
    let lines = Lines { context, id: "bouc-wen", method };
    let reason = "second order in the step, and kinks of the drift, which a Runge-Kutta step crosses; frozen smoothing lengths \
                  leave 1.4e-3 of E[v^2]";
    let judge = |(name, quantity), kind, k: usize, tolerance| {
        let (what, exact) = ((name, quantity, ""), Reference::exact(fine[k]));
        lines.judge(what, kind, coarse[k], exact, Criterion::Within { tolerance, reason })
    };
    Ok(vec![
        judge(("second-moment-v", "E[v^2], t = 2"), ErrorKind::Relative, 0, 1e-4),
        judge(("exceedance-cell", "P(|q| > 0.5), t = 2"), ErrorKind::Log10, 1, 1e-3),
    ])
}
