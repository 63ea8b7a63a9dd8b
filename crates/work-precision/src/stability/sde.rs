//! Largest steps of the methods of `sde-integrators`: oscillator, cubic drift, multiplicative noise.

use result_figures::{Drawing, Scale};
use sde_integrators::{
    Baoab, EnsembleConfig, EulerMaruyama, Heun, Integrator, Observable, SemiImplicitEuler, Shark,
    StateSpace, StochasticTheta, StrangOscillator, simulate,
};

use super::axes::{linear, logarithmic, words};
use super::{Boundary, Panel, Work};
use crate::context::{CaseError, Context, Profile};
use crate::draw::ChartKind;
use crate::problems::sde::linear::probe;
use crate::problems::sde::oscillator_limits as limits;
use crate::problems::sde::oscillator_limits::Limited;
use crate::problems::sde::problems::{Cubic, Oscillator};
use crate::problems::sde::stability::{Formula, amplification_of, formula_boundary};

pub(crate) const MAP: ChartKind = ChartKind {
    name: "sde",
    title: "methods of sde-integrators: largest step on an oscillator, on -X^3, under multiplicative noise",
    draw,
};

/// Steps of a run, and its work limit.
const STEPS: u64 = 10_000;
/// Tolerance of every map.
///
/// It applies to the stationary variance, to the second moment of the cubic, and to the decay rate of the second
/// moment.
const TOLERANCE: f64 = 0.1;

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let n = if context.profile == Profile::Quick { 5 } else { 11 };
    let mut drawings = oscillators(n)?;
    drawings.push(cubic(n, 0.0)?);
    drawings.push(cubic(n, std::f64::consts::SQRT_2)?);
    for (id, name, formula) in [
        ("euler-maruyama", "Euler-Maruyama", Formula::Theta(0.0)),
        ("milstein", "Milstein", Formula::Milstein),
        ("heun", "Heun", Formula::Heun),
        ("theta-0.25", "theta = 0.25", Formula::Theta(0.25)),
        ("trapezoidal", "trapezoidal", Formula::Theta(0.5)),
        ("sk-rock-5", "SK-ROCK, 5 stages", Formula::SkRock(5)),
    ] {
        drawings.push(mean_square(n, id, name, formula)?);
    }
    Ok(drawings)
}

fn oscillators(n: u32) -> Result<Vec<Drawing>, CaseError> {
    let by = |limited: Limited| move |xi: f64| Some(limits::formula(limited, xi));
    Ok(vec![
        oscillator(n, "Euler-Maruyama", &EulerMaruyama, &by(Limited::EulerMaruyama))?,
        oscillator(n, "semi-implicit Euler", &SemiImplicitEuler, &by(Limited::SemiImplicitEuler))?,
        oscillator(n, "Heun", &Heun, &by(Limited::Heun))?,
        oscillator(n, "ShARK", &Shark, &by(Limited::Shark))?,
        oscillator(n, "BAOAB", &Baoab, &by(Limited::Baoab))?,
        oscillator(n, "Strang", &StrangOscillator, &|_| None)?,
        oscillator(n, "trapezoidal", &StochasticTheta::TRAPEZOIDAL, &|_| None)?,
        oscillator(n, "backward Euler", &StochasticTheta::BACKWARD_EULER, &|_| None)?,
    ])
}

fn oscillator<I>(
    n: u32,
    name: &str,
    method: &I,
    boundary: &Boundary<'_>,
) -> Result<Drawing, CaseError>
where
    I: Integrator<StateSpace<Oscillator>, 2, 1>,
{
    let run = |xi: f64, angle: f64, work: &mut Work| -> Result<f64, CaseError> {
        let system = StateSpace(Oscillator { frequency: 1.0, damping_ratio: xi, intensity: 1.0 });
        work.spend(STEPS)?;
        let config =
            EnsembleConfig { seed: 81, n_paths: 32, dt: angle, times: vec![STEPS as f64 * angle] };
        let observables = [Observable::Probability(&|_, x: &[f64; 2]| x[0] > 0.0)];
        let _finite = simulate(&system, method, &[0.0; 2], &config, &observables)?;
        let (map, _) = probe(&system, method, angle, |_, _| [0.0; 0])?;
        let exact = system.0.velocity_variance();
        Ok(map.stationary(angle).map_or(f64::INFINITY, |law| (law[0][0] / exact - 1.0).abs()))
    };
    let panel = Panel {
        name: format!("sde-oscillator-{}", name.to_lowercase().replace(' ', "-")),
        words: words(
            format!("{name} on the oscillator q'' + 2 ξ ω q' + ω² q = W"),
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

/// Euler-Maruyama on `dX = -X^3 dt + sigma dB` from `x_0`, to `T = 20`.
fn cubic(n: u32, sigma: f64) -> Result<Drawing, CaseError> {
    const END: f64 = 20.0;
    let has_noise = sigma > 0.0;
    let run = |start: f64, dt: f64, work: &mut Work| -> Result<f64, CaseError> {
        let n_paths = if has_noise { 4096 } else { 2 };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "10,000 at most"
        )]
        let n_steps = (END / dt).round().max(1.0) as u64;
        work.spend(n_steps)?;
        let end = n_steps as f64 * dt;
        let config = EnsembleConfig { seed: 82, n_paths, dt, times: vec![end] };
        let observables = [Observable::Mean(&|_, x: &[f64; 1]| x[0] * x[0])];
        let ensemble =
            simulate(&Cubic { intensity: sigma }, &EulerMaruyama, &[start], &config, &observables)?;
        let exact = if has_noise {
            Cubic::STATIONARY_SECOND_MOMENT
        } else {
            start * start / (1.0 + 2.0 * start * start * end)
        };
        Ok((ensemble.estimates[0][0].value / exact - 1.0).abs())
    };
    let subtitle = if has_noise {
        "error of E X² at t = 20 against the stationary law, 4,096 paths (standard error about 2 %)"
    } else {
        "without noise; error of X² at t = 20"
    };
    let panel = Panel {
        name: if has_noise { "sde-cubic-noise".into() } else { "sde-cubic".into() },
        words: words(
            if has_noise {
                "Euler-Maruyama on dX = -X³ dt + √2 dB".into()
            } else {
                "Euler's method on dX = -X³ dt".into()
            },
            subtitle,
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

/// The second moment overflows.
#[derive(Debug, thiserror::Error)]
#[error("the second moment overflows after {steps:.0} steps: it grows by {amplification} a step")]
struct SecondMomentOverflow {
    amplification: f64,
    steps: f64,
}

/// Decay rate of `E X^2` on `dX = -X dt + sqrt(2 r) X dB`, by quadrature over a step of the code.
fn mean_square(n: u32, id: &str, name: &str, formula: Formula) -> Result<Drawing, CaseError> {
    let run = |ray: f64, size: f64, work: &mut Work| -> Result<f64, CaseError> {
        work.spend(STEPS)?;
        let amplification = amplification_of(formula, -1.0, (2.0 * ray).sqrt(), size)?;
        let steps = f64::MAX.ln() / amplification.ln();
        if steps > 0.0 && steps < STEPS as f64 {
            return Err(SecondMomentOverflow { amplification, steps }.into());
        }
        Ok((amplification.ln() / (2.0 * (ray - 1.0) * size) - 1.0).abs())
    };
    let boundary = |ray: f64| formula_boundary(ray, formula);
    let panel = Panel {
        name: format!("sde-mean-square-{id}"),
        words: words(
            format!("{name} in the mean square, dX = l X dt + m X dB"),
            "error of the decay rate of E X², which is followed by quadrature over a step, never by sampling",
            ["m² / (2 |l|), noise against damping", "|l| h"],
            "Boundary: E|R|² = 1 by formula. A path itself may stay finite outside it: its second moment does not.",
        ),
        scale: Scale::Log,
        across: linear(n, 0.0, 0.95),
        upwards: logarithmic(n + 3, 0.01, 100.0),
        boundary: Some(("predicted boundary", &boundary)),
        tolerance: TOLERANCE,
        work_limit: STEPS,
        run: &run,
    };
    Ok(panel.sweep()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The prediction is a theorem for the linear problems and for the cubic without noise: every run must agree.
    #[test]
    fn no_run_of_the_linear_maps_contradicts_the_boundary() {
        let none = "0 against the prediction";
        for drawing in oscillators(3).unwrap() {
            assert!(drawing.table.contains(none), "{}: {}", drawing.name, drawing.table);
        }
        for drawing in [
            cubic(3, 0.0).unwrap(),
            mean_square(3, "milstein", "Milstein", Formula::Milstein).unwrap(),
        ] {
            assert!(drawing.table.contains(none), "{}: {}", drawing.name, drawing.table);
        }
        // The boundary of another method is contradicted.
        let wrong = oscillator(3, "BAOAB", &Baoab, &|xi| Some(2.0 * xi)).unwrap();
        assert!(!wrong.table.contains(none), "{}", wrong.table);
    }
}
