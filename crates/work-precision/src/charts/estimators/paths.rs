//! Paths of stochastic differential equations: one level, several levels, and a better integrator.

use result_figures::{Drawing, Method, Words};
use sde_integrators::{
    EnsembleConfig, EulerMaruyama, Integrator, Observable, StateSpace, StrangOscillator, simulate,
};
use uq_estimators::{Bias, Multilevel, PathLadder, Statistic, Target, Tolerance};
use vibrating_systems::GeometricBrownianMotion;

use super::measured::{Size, drawing, method};
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::sde::damper::viscous_damper_at_rest;

/// Growth and volatility of the geometric Brownian motion, from 1 to time 1.
const GROWTH: [f64; 2] = [1.0, 0.5];
/// Final time of the damper (s).
const DAMPER_END: f64 = 2.0;

pub(super) fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    Ok(vec![growth(context)?, damper(context)?])
}

const fn n_seeds(context: &Context<'_>) -> u64 {
    if matches!(context.profile, Profile::Quick) { 4 } else { 8 }
}

/// Tolerances from 6 % on, halved.
fn tolerances(context: &Context<'_>) -> impl Iterator<Item = f64> {
    let n = if context.profile == Profile::Quick { 2 } else { 4 };
    (0..n).map(|k| 0.064 * 0.5_f64.powi(k))
}

/// A problem: a system, where its paths begin and end, the response, and its mean.
struct Problem<'a, S, const D: usize> {
    system: &'a S,
    start: [f64; D],
    end: f64,
    response: fn(&[f64; D]) -> f64,
    mean: f64,
}

impl<S: Sync, const D: usize> Problem<'_, S, D> {
    /// Paths of one number of steps; their number grows as its square, as errors of first order ask.
    fn one_level<'a, I: Integrator<S, D, 1> + Sync>(
        &'a self,
        integrator: &'a I,
        steps: u64,
        paths: u64,
    ) -> Size<'a> {
        let run = move |seed| {
            let dt = self.end / steps as f64;
            let config = EnsembleConfig { seed, n_paths: paths, dt, times: vec![self.end] };
            let mean = |_: f64, x: &[f64; D]| (self.response)(x);
            let observables = [Observable::Mean(&mean)];
            let found = simulate(self.system, integrator, &self.start, &config, &observables)?;
            Ok(vec![found.estimates[0][0].value / self.mean - 1.0])
        };
        Size { label: format!("{paths} x {steps} steps"), run: Box::new(run) }
    }

    /// Multilevel Monte Carlo to a tolerance.
    fn multilevel<'a, I: Integrator<S, D, 1> + Sync>(
        &'a self,
        integrator: &'a I,
        (coarsest_steps, order): (u64, f64),
        tolerance: f64,
    ) -> Size<'a> {
        let run = move |seed| {
            let ladder = PathLadder::<_, _, _, _, D, 1> {
                system: self.system,
                integrator,
                law: &self.start,
                seed,
                end: self.end,
                coarsest_steps,
                n_levels: 12,
                n_responses: 1,
                responses: |x: &[f64; D], y: &mut [f64]| y[0] = (self.response)(x),
            };
            let tolerance = Tolerance::Absolute(tolerance * self.mean);
            let target = Target { response: 0, statistic: Statistic::Mean, tolerance };
            let study = Multilevel {
                name: "chart",
                targets: &[target],
                bias: Bias::Order(order),
                block_length: 64,
                pilot_blocks: 4,
                budget: 1e10,
            };
            let found = study.run(&ladder)?.targets[0];
            Ok(vec![found.estimate.value / self.mean - 1.0])
        };
        Size { label: format!("to {:.1} %", 100.0 * tolerance), run: Box::new(run) }
    }
}

/// Numbers of paths and steps of an integrator of first order: the square of the error falls as both terms.
fn of_first_order(context: &Context<'_>, coarsest: u64) -> impl Iterator<Item = (u64, u64)> {
    let n = if context.profile == Profile::Quick { 2 } else { 4 };
    (0..n).map(move |k| (coarsest << k, 256 << (2 * k)))
}

fn growth(context: &Context<'_>) -> Result<Drawing, CaseError> {
    context.progress("growth");
    let system = GeometricBrownianMotion::new(GROWTH[0], GROWTH[1])?;
    let problem = Problem {
        system: &system,
        start: [1.0],
        end: 1.0,
        response: |x: &[f64; 1]| x[0],
        mean: GROWTH[0].exp(),
    };
    let seeds = n_seeds(context);
    let plain: Vec<Size<'_>> = of_first_order(context, 8)
        .map(|(steps, paths)| problem.one_level(&EulerMaruyama, steps, paths))
        .collect();
    let levels: Vec<Size<'_>> = tolerances(context)
        .map(|tolerance| problem.multilevel(&EulerMaruyama, (1, 1.0), tolerance))
        .collect();
    let series = vec![
        method("Monte Carlo, Euler-Maruyama", &plain, seeds),
        method("multilevel, Euler-Maruyama", &levels, seeds),
    ];
    let words = Words {
        title: "Mean of a geometric Brownian motion, against cost".into(),
        subtitle: format!("dX = {} X dt + {} X dW from 1, t = 1; exact: e", GROWTH[0], GROWTH[1]),
        x_label: String::new(),
        y_label: "relative error of E X".into(),
        caption: vec![],
    };
    drawing("estimators-growth", words, series, (0.0, seeds))
}

fn damper(context: &Context<'_>) -> Result<Drawing, CaseError> {
    context.progress("damper: reference");
    let oscillator = viscous_damper_at_rest()?;
    let system = StateSpace(oscillator);
    let n_paths = if context.profile == Profile::Quick { 1 << 14 } else { 1 << 20 };
    let config = EnsembleConfig { seed: 63, n_paths, dt: 0.01, times: vec![DAMPER_END] };
    let square = [Observable::Mean(&|_, x: &[f64; 2]| x[0] * x[0])];
    let reference = simulate(&system, &StrangOscillator, &[0.0; 2], &config, &square)?;
    let reference = reference.estimates[0][0];
    let truth_error = reference.standard_error().unwrap_or(f64::NAN) / reference.value;
    let problem = Problem {
        system: &system,
        start: [0.0; 2],
        end: DAMPER_END,
        response: |x: &[f64; 2]| x[0] * x[0],
        mean: reference.value,
    };
    let seeds = n_seeds(context);
    let euler: Vec<Size<'_>> = of_first_order(context, 32)
        .map(|(steps, paths)| problem.one_level(&EulerMaruyama, steps, paths))
        .collect();
    // 32 steps a period: their bias is far below all errors here.
    let strang: Vec<Size<'_>> = of_first_order(context, 32)
        .map(|(_, paths)| problem.one_level(&StrangOscillator, 32, paths))
        .collect();
    let levels = |coarsest| -> Vec<Size<'_>> {
        let of = |tolerance| problem.multilevel(&EulerMaruyama, (coarsest, 1.0), tolerance);
        tolerances(context).map(of).collect()
    };
    let of_strang: Vec<Size<'_>> = tolerances(context)
        .map(|tolerance| problem.multilevel(&StrangOscillator, (4, 2.0), tolerance))
        .collect();
    let series: Vec<Method> = vec![
        method("Monte Carlo, Euler-Maruyama", &euler, seeds),
        method("multilevel, Euler-Maruyama", &levels(16), seeds),
        method("Monte Carlo, Strang, 32 steps a period", &strang, seeds),
        method("multilevel, Strang", &of_strang, seeds),
    ];
    let words = Words {
        title: "Mean square of an oscillator with viscous damper, against cost".into(),
        subtitle: format!("Canor & Denoël 2013, eq 26, a = 1, from rest, t = {DAMPER_END} s"),
        x_label: String::new(),
        y_label: "relative error of E q^2".into(),
        caption: vec![format!(
            "Against {n_paths} other paths by Strang's splitting, whose own standard error is {truth_error:.1e}."
        )],
    };
    drawing("estimators-damper", words, series, (truth_error, seeds))
}
