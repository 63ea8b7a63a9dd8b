//! The step relative to the stiffest mode, by scheme.

use peridyn_sde::{Mobility, Scheme};
use result_figures::{Curve, CurvePoint, Curves, Drawing, Scale, Threshold, Words};

use super::{modes, point};
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

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let is_quick = context.profile == Profile::Quick;
    Ok(vec![variance(is_quick)?])
}

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
fn variance(is_quick: bool) -> Result<Drawing, CaseError> {
    let chain = Network::chain(10)?;
    let (lambda, mode) = modes(chain.stiffness())?.pop().ok_or("a chain without a mode")?;
    let mobility = Mobility::identity(&chain.free, 1.0)?;
    let (mut series, mut rows, mut worst) = (Vec::new(), Vec::new(), 0.0_f64);
    let mut add = |look: usize, name: &str, points: Vec<CurvePoint>, line: &dyn Fn(f64) -> f64| {
        let of = |point: &CurvePoint| point.value().map(|y| (point.x, y));
        let known: Vec<(f64, f64)> = points.iter().filter_map(of).collect();
        let error = |&(z, y): &(f64, f64)| (y / line(z) - 1.0).abs();
        let largest = known.iter().map(error).fold(0.0, f64::max);
        worst = worst.max(largest);
        rows.push(format!(
            "  {name:20} {} runs, {} ended; from the formula by up to {largest:.0e}",
            points.len(),
            points.len() - known.len()
        ));
        let last = known.iter().map(|&(z, _)| z).fold(0.1, f64::max);
        let drawn = logarithmic(200, 0.1, last).into_iter().map(|z| (z, line(z)));
        series.push(Curve::line(name, look, drawn));
        series.push(Curve::points("", look, points));
    };
    for (look, scheme) in SCHEMES.into_iter().enumerate() {
        // The code estimates its stiffest mode to one part in a thousand.
        let known = rate(&chain, &overdamped(&mobility, 0.0, scheme))?;
        let ratio = |z: f64| -> Result<f64, CaseError> {
            let covariance = law_of(&chain, &mobility, scheme, z * known / lambda)?.covariance;
            Ok((mode.transpose() * covariance * &mode)[0] * lambda / TEMPERATURE)
        };
        let is_implicit = matches!(scheme, Scheme::Theta(_));
        let points = steps(is_quick, is_implicit).into_iter().map(|z| point(z, ratio(z))).collect();
        add(look, &scheme.name(), points, &|z| scheme.variance_factor(z));
    }
    let friction = 1.0;
    let cold = peridyn_sde::Dynamics::Inertial { density: 1.0, friction, temperature: 0.0 };
    let known = rate(&chain, &cold)?;
    let ratio = |angle: f64| -> Result<f64, CaseError> {
        let covariance = covariance_of_baoab(&chain, friction, angle * known / lambda.sqrt())?;
        Ok((mode.transpose() * covariance * &mode)[0] * lambda / TEMPERATURE)
    };
    let points = steps(is_quick, false).into_iter().map(|z| point(z, ratio(z))).collect();
    add(SCHEMES.len(), "BAOAB", points, &|_| 1.0);
    let drawing = Drawing::curves("peridyn-z-variance", &picture(series, worst))?;
    Ok(Drawing { table: rows.join("\n"), ..drawing })
}

fn picture(series: Vec<Curve>, worst: f64) -> Curves {
    Curves {
        words: Words {
            title: "Three schemes have the right variance up to z = 2, and theta = 1/2 beyond it".into(),
            subtitle: "chain of ten nodes; variance of the stiffest mode in the stationary law of the step, over that of the equation".into(),
            x_label: "z = h M λ of the stiffest mode; of BAOAB h ω".into(),
            y_label: "variance over kT/λ".into(),
            caption: vec![format!(
                "Lines: formulas. Points: discrete Lyapunov equation of the map that a step of the code is; within {worst:.0e} of the lines. Leimkuhler-Matthews, theta 0.5 and BAOAB lie on each other at 1. Crosses: the step is refused when the simulation is made."
            )],
        },
        across: Scale::Log,
        upwards: Scale::Log,
        series,
        thresholds: vec![Threshold::across("z = 2", 2.0)],
    }
}
