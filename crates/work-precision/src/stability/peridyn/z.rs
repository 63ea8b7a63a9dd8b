//! The step relative to the stiffest mode, by scheme.

use nalgebra::SymmetricEigen;
use peridyn_sde::{Dynamics, Mobility, Scheme};
use result_figures::{Drawing, Method, Reading, Run, RunOutcome, Words, WorkPrecision};
use scenes::causes::with_causes;

use crate::draw::ChartKind;
use crate::stability::axes::logarithmic;
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::peridyn::network::{Network, rate};
use reference_problems::peridyn::stationary::{
    TEMPERATURE, covariance_of_baoab, law_of, overdamped,
};

pub(crate) const MAP: ChartKind = ChartKind {
    name: "peridyn-z",
    title: "schemes of peridyn-sde over the step: variance of the stiffest mode",
    draw,
};

const SCHEMES: [Scheme; 5] = [
    Scheme::EulerMaruyama,
    Scheme::LeimkuhlerMatthews,
    Scheme::Heun,
    Scheme::Theta(0.5),
    Scheme::Theta(1.0),
];

/// Steps around the limit, and for implicit schemes far beyond.
fn steps(is_quick: bool, is_implicit: bool) -> Vec<f64> {
    let mut steps = logarithmic(if is_quick { 4 } else { 10 }, 0.1, 1.8);
    steps.extend([1.95, 1.998, 2.002, 2.2]);
    if is_implicit {
        steps.extend(logarithmic(if is_quick { 2 } else { 5 }, 3.0, 20.0));
    }
    steps
}

/// Variance of the stiffest mode of a chain over `kT/lambda`.
fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let is_quick = context.profile == Profile::Quick;
    let chain = Network::chain(10)?;
    let modes = SymmetricEigen::try_new(chain.stiffness(), f64::EPSILON, 10_000)
        .ok_or("the eigenvalues of a matrix were not found")?;
    let (at, lambda) = modes.eigenvalues.argmax();
    let mode = modes.eigenvectors.column(at);
    let mobility = Mobility::identity(&chain.free, 1.0)?;
    let (mut series, mut rows, mut worst) = (Vec::new(), Vec::new(), 0.0_f64);
    let mut add =
        |name: &str, found: Vec<(f64, Result<f64, CaseError>)>, of: &dyn Fn(f64) -> f64| {
            let known = found.iter().filter_map(|(z, y)| Some((*z, *y.as_ref().ok()?)));
            let largest = known.map(|(z, y)| (y / of(z) - 1.0).abs()).fold(0.0, f64::max);
            worst = worst.max(largest);
            let n_ended = found.iter().filter(|(_, y)| y.is_err()).count();
            rows.push(format!(
                "  {name:20} {} runs, {n_ended} ended; from the formula by up to {largest:.0e}",
                found.len(),
            ));
            let run = |(cost, found): (f64, Result<f64, CaseError>)| Run {
                cost,
                cost_error: None,
                outcome: match found {
                    Ok(value) => RunOutcome::Error { value, standard_error: None },
                    Err(error) => RunOutcome::Failed { reason: with_causes(error.as_ref()) },
                },
                label: None,
            };
            series.push(Method { name: name.into(), runs: found.into_iter().map(run).collect() });
        };
    for scheme in SCHEMES {
        // The code estimates its stiffest mode to one part in a thousand.
        let known = rate(&chain, &overdamped(&mobility, 0.0, scheme))?;
        let ratio = |z: f64| -> Result<f64, CaseError> {
            let covariance = law_of(&chain, &mobility, scheme, z * known / lambda)?.covariance;
            Ok((mode.transpose() * covariance * mode)[0] * lambda / TEMPERATURE)
        };
        let steps = steps(is_quick, matches!(scheme, Scheme::Theta(_)));
        let found = steps.into_iter().map(|z| (z, ratio(z))).collect();
        add(&scheme.name(), found, &|z| scheme.variance_factor(z));
    }
    let friction = 1.0;
    let known = rate(&chain, &Dynamics::Inertial { density: 1.0, friction, temperature: 0.0 })?;
    let ratio = |angle: f64| -> Result<f64, CaseError> {
        let covariance = covariance_of_baoab(&chain, friction, angle * known / lambda.sqrt())?;
        Ok((mode.transpose() * covariance * mode)[0] * lambda / TEMPERATURE)
    };
    let found = steps(is_quick, false).into_iter().map(|z| (z, ratio(z))).collect();
    add("BAOAB", found, &|_| 1.0);
    let words = Words {
        title: "Three schemes have the right variance up to z = 2, and theta = 1/2 beyond it".into(),
        subtitle: "chain of ten nodes; variance of the stiffest mode in the stationary law of the step, over that of the equation".into(),
        x_label: "z = h M λ of the stiffest mode; of BAOAB h ω".into(),
        y_label: "variance over kT/λ".into(),
        caption: vec![format!(
            "By the discrete Lyapunov equation of the map that a step of the code is; within {worst:.0e} of the formulas. Leimkuhler-Matthews, theta 0.5 and BAOAB lie on each other at 1. Crosses: the step is refused when the simulation is made."
        )],
    };
    let chart = WorkPrecision { words, reading: Reading::Parameter, series };
    Ok(vec![Drawing::work_precision("peridyn-z-variance", &chart)?.with_rows(&rows.join("\n"))])
}
