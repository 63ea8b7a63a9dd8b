//! A mobility that couples nodes: the cost of a smooth correlation without a nugget.

use nalgebra::DVector;
use peridyn_sde::{CorrelatedMobility, Error, Mobility, Scheme};
use random_fields::{Correlation, CorrelationFunction};
use result_figures::{Curve, CurvePoint, Curves, Drawing, Scale, Threshold, Words};
use scenes::causes::with_causes;
use sde_integrators::Noise;

use super::modes;
use crate::context::{CaseError, Context, Profile};
use crate::draw::ChartKind;
use crate::problems::peridyn::network::Network;
use crate::problems::peridyn::stationary::overdamped;
use crate::stability::axes::logarithmic;

pub(crate) const MAP: ChartKind = ChartKind {
    name: "peridyn-nugget",
    title: "steps that the slowest mode needs under a smooth mobility, over its nugget",
    draw,
};

/// Abscissa of points without a nugget.
const NONE: f64 = 1e-14;
/// Steps of a run that is compared with the eigenvalue.
const STEPS: i32 = 100;

/// The slowest eigenvalue of `M K` is roundoff.
///
/// The eigenvalues are squared singular values of a product of factors: below this fraction of the largest they are
/// roundoff.
#[derive(Debug, thiserror::Error)]
#[error("the slowest mode is {value:e} of the fastest, which is roundoff of {n} unknowns")]
struct Unresolved {
    value: f64,
    n: usize,
}

/// The slowest mode of `M K`.
struct Slowest {
    /// Steps from the eigenvalue, in units of the fastest mode.
    steps: f64,
    /// Steps from a run at `z = 1`: the same, up to errors of the code.
    in_run: f64,
}

fn slowest(network: &Network<2>, mobility: &Mobility) -> Result<Slowest, CaseError> {
    let l = network.factor(mobility)?;
    let m = &l * l.transpose();
    let root = network.stiffness().cholesky().ok_or("a singular network")?.l();
    let modes = modes(root.transpose() * &m * &root)?;
    let (Some((low, shape)), Some((high, _))) = (modes.first(), modes.last()) else {
        return Err("a network without a mode".into());
    };
    let (value, n) = (low / high, network.n_unknowns());
    // Also true for NaN.
    if !matches!(value.partial_cmp(&(n as f64 * f64::EPSILON)), Some(std::cmp::Ordering::Greater)) {
        return Err(Unresolved { value, n }.into());
    }
    let in_run = decay(network, mobility, &(m * root * shape), 1.0 / high)?;
    Ok(Slowest { steps: high / low, in_run })
}

/// Inverse of the decay rate of a mode shape in a step.
fn decay(
    network: &Network<2>,
    mobility: &Mobility,
    shape: &DVector<f64>,
    dt: f64,
) -> Result<f64, CaseError> {
    let scale = 1e-3 / shape.amax();
    let unknowns = network.unknowns();
    let mut u = vec![[0.0; 2]; network.free.len()];
    for (&(node, k), value) in unknowns.iter().zip(shape) {
        u[node][k] = scale * value;
    }
    let dynamics = overdamped(mobility, 0.0, Scheme::EulerMaruyama);
    let mut run = network.run(dynamics, dt, Noise::new(0))?;
    run.set_displacements(0, &u)?;
    for _ in 0..STEPS {
        let _ = run.step()?;
    }
    let after = run.displacements(0);
    // Component along the mode shape: modes excited by roundoff are orthogonal to it.
    let along: f64 =
        unknowns.iter().zip(shape).map(|(&(node, k), value)| after[node][k] * scale * value).sum();
    let part = along / (scale * scale * shape.norm_squared());
    Ok(1.0 / (1.0 - part.powf(1.0 / f64::from(STEPS))))
}

fn mobility(network: &Network<2>, length: f64, nugget: f64) -> Result<Mobility, Error> {
    let correlation = Correlation { function: CorrelationFunction::Gaussian, length };
    let config = CorrelatedMobility { mobility: 1.0, correlation, nugget };
    Mobility::dense(network.nodes.positions(), &network.free, &config)
}

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let is_quick = context.profile == Profile::Quick;
    let network = Network::square(if is_quick { 6 } else { 11 }, 2)?;
    let alone = slowest(&network, &Mobility::identity(&network.free, 1.0)?)?.steps;
    let mut nuggets = vec![0.0];
    nuggets.extend(logarithmic(if is_quick { 4 } else { 13 }, 1e-12, 1.0));
    let (mut series, mut rows) = (Vec::new(), Vec::new());
    let (mut worst, mut first) = (0.0_f64, None);
    for (look, length) in [0.7, 1.0, 1.5, 2.0, 3.0, 5.0].into_iter().enumerate() {
        context.progress(&format!("l = {length} dx"));
        let (mut points, mut row) = (Vec::new(), vec![format!("  l = {length} dx:")]);
        for &nugget in &nuggets {
            let x = if nugget > 0.0 { nugget } else { NONE };
            let found = mobility(&network, length, nugget)
                .map_err(CaseError::from)
                .and_then(|mobility| slowest(&network, &mobility));
            match found {
                Ok(Slowest { steps, in_run }) => {
                    if steps < 1e6 {
                        worst = worst.max((in_run / steps - 1.0).abs());
                    }
                    row.push(format!("{nugget:.0e}: {steps:.2e}"));
                    points.push(CurvePoint::at(x, steps));
                }
                Err(error) => {
                    let text = with_causes(error.as_ref());
                    row.push(format!("{nugget:.0e}: ended"));
                    points.push(CurvePoint::ended(x, text.clone()));
                    first.get_or_insert(text);
                }
            }
        }
        rows.push(row.join(" "));
        series.push(Curve::marked(format!("l = {length} dx"), look, points));
    }
    rows.push(format!(
        "  without correlation {alone:.0}; in runs of {STEPS} steps the same within {worst:.0e} where they are below 1e6"
    ));
    rows.extend(first.map(|text| format!("  first end: {text}")));
    let n = (network.free.len() as f64).sqrt().round();
    let drawing = Drawing::curves("peridyn-nugget", &picture(series, alone, n))?;
    Ok(vec![Drawing { table: rows.join("\n"), ..drawing }])
}

fn picture(series: Vec<Curve>, alone: f64, n: f64) -> Curves {
    Curves {
        words: Words {
            title: "A smooth mobility needs a nugget: without one its slowest mode hardly moves".into(),
            subtitle: format!("{n} x {n} nodes, two shells, held along one edge; Gaussian correlation of the integral scale l, factorised in full"),
            x_label: "nugget, over what nodes share; leftmost: none".into(),
            y_label: "steps of z = 1 for the slowest mode to fall by e".into(),
            caption: vec!["The largest eigenvalue of M K over its smallest. Crosses: the matrix is rejected as not positive definite, with the row of its pivot.".into()],
        },
        across: Scale::Log,
        upwards: Scale::Log,
        series,
        thresholds: vec![Threshold::upwards("every node for itself", alone)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For `M = 1` the modes are those of `K`.
    #[test]
    fn without_correlation_the_steps_are_the_condition_of_the_stiffness() {
        let network = Network::square(5, 2).unwrap();
        let mobility = Mobility::identity(&network.free, 1.0).unwrap();
        let found = slowest(&network, &mobility).unwrap();
        let stiffness = network.stiffness();
        let of = modes(stiffness).unwrap();
        let expected = of[of.len() - 1].0 / of[0].0;
        assert!((found.steps / expected - 1.0).abs() < 1e-9);
        assert!((found.in_run / expected - 1.0).abs() < 1e-9);
    }
}
