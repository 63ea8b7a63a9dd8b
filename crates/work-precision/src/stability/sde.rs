//! Largest steps of Euler-Maruyama: a lightly damped oscillator, and a cubic drift.

use result_figures::{Drawing, Scale};
use sde_integrators::{EnsembleConfig, EulerMaruyama, Observable, StateSpace, simulate};

use super::axes::{linear, logarithmic, words};
use super::{Boundary, Panel, Work};
use crate::draw::ChartKind;
use crate::problems::oscillator_limits as limits;
use crate::problems::oscillator_limits::Limited;
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::sde::linear::probe;
use reference_problems::sde::problems::{Cubic, Oscillator};

pub(crate) const MAP: ChartKind = ChartKind {
    name: "sde",
    title: "Euler-Maruyama of sde-integrators: largest step on an oscillator and on -X^3",
    draw,
};

/// Steps of a run, and its work limit.
const STEPS: u64 = 10_000;
/// Tolerance of every map.
///
/// It applies to the stationary variance and to the second moment of the cubic.
const TOLERANCE: f64 = 0.1;

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let n = if context.profile == Profile::Quick { 5 } else { 11 };
    Ok(vec![oscillator(n, &|xi| Some(limits::formula(Limited::EulerMaruyama, xi)))?, cubic(n)?])
}

/// Euler-Maruyama on the linear oscillator.
fn oscillator(n: u32, boundary: &Boundary<'_>) -> Result<Drawing, CaseError> {
    let run = |xi: f64, angle: f64, work: &mut Work| -> Result<f64, CaseError> {
        let system = StateSpace(Oscillator { frequency: 1.0, damping_ratio: xi, intensity: 1.0 });
        work.spend(STEPS)?;
        let config =
            EnsembleConfig { seed: 81, n_paths: 32, dt: angle, times: vec![STEPS as f64 * angle] };
        let observables = [Observable::Probability(&|_, x: &[f64; 2]| x[0] > 0.0)];
        let _finite = simulate(&system, &EulerMaruyama, &[0.0; 2], &config, &observables)?;
        let (map, _) = probe(&system, &EulerMaruyama, angle, |_, ()| [0.0; 0])?;
        let exact = system.0.velocity_variance();
        Ok(map.stationary(angle).map_or(f64::INFINITY, |law| (law[0][0] / exact - 1.0).abs()))
    };
    let panel = Panel {
        name: "sde-oscillator-euler-maruyama".into(),
        words: words(
            "Euler-Maruyama on the oscillator q'' + 2 ξ ω q' + ω² q = W".into(),
            "error of the stationary E q², from the exact law of the step; and 32 paths of 10,000 steps",
            ["damping ratio ξ", "h ω"],
            "Boundary: spectral radius of a step. Just outside it a path of 10,000 steps grows and no error is reported.",
        ),
        scale: Scale::Log,
        across: linear(n, 0.01, 0.96),
        upwards: logarithmic(n + 3, 0.01, 6.0),
        boundary: Some(("predicted boundary", boundary)),
        tolerance: TOLERANCE,
        work_limit: STEPS,
        run: &run,
    };
    Ok(panel.sweep()?)
}

/// Euler-Maruyama on `dX = -X^3 dt + sqrt(2) dB` from `x_0`, to `T = 20`.
fn cubic(n: u32) -> Result<Drawing, CaseError> {
    const END: f64 = 20.0;
    let run = |start: f64, dt: f64, work: &mut Work| -> Result<f64, CaseError> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "10,000 at most"
        )]
        let n_steps = (END / dt).round().max(1.0) as u64;
        work.spend(n_steps)?;
        let end = n_steps as f64 * dt;
        let config = EnsembleConfig { seed: 82, n_paths: 4096, dt, times: vec![end] };
        let observables = [Observable::Mean(&|_, x: &[f64; 1]| x[0] * x[0])];
        let system = Cubic { intensity: std::f64::consts::SQRT_2 };
        let ensemble = simulate(&system, &EulerMaruyama, &[start], &config, &observables)?;
        Ok((ensemble.estimates[0][0].value / Cubic::STATIONARY_SECOND_MOMENT - 1.0).abs())
    };
    let panel = Panel {
        name: "sde-cubic-noise".into(),
        words: words(
            "Euler-Maruyama on dX = -X³ dt + √2 dB".into(),
            "error of E X² at t = 20 against the stationary law, 4,096 paths (standard error about 2 %)",
            ["start x₀", "step h"],
            "Boundary: |x₀| = √(2/h), beyond which the first step is too large to return. It does not include noise.",
        ),
        scale: Scale::Log,
        across: linear(n, 1.0, 12.0),
        upwards: logarithmic(n + 3, 0.005, 1.0),
        boundary: Some(("h = 2/x₀²", &|x: f64| Some(2.0 / (x * x)))),
        tolerance: TOLERANCE,
        work_limit: STEPS,
        run: &run,
    };
    Ok(panel.sweep()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The prediction is a theorem for the linear problem: every run must agree, and another boundary is contradicted.
    #[test]
    fn no_run_of_the_linear_map_contradicts_the_boundary() {
        let none = "0 against the prediction";
        let right = oscillator(3, &|xi| Some(2.0 * xi)).unwrap();
        assert!(right.table.contains(none), "{}", right.table);
        let wrong = oscillator(3, &|_| Some(2.0)).unwrap();
        assert!(!wrong.table.contains(none), "{}", wrong.table);
    }
}
