//! Regressions of a small system, by quadrature over all its states.

use sde_integrators::{Additive, GaussianMixture, Sde, SmallPivot, small_cholesky};

use crate::guides::regression::{Regression, Regressions, RunningLaw};
use crate::linearisation::{Closure, GaussianLaw, Linearisation, LinearisationError};

/// Nodes on either side of a kink: fewer than for moments, because a guide needs two digits alone.
const HALF_NODES: usize = 10;

/// Regressions up to a time.
///
/// Strength `kappa` takes the expectations under `kappa` times the deviations of the running distribution: paths that
/// reach a rare event are further out than most.
///
/// A step at which the covariance fails is halved, five times at most.
pub(crate) fn regressions<const D: usize, const M: usize>(
    rule: &Linearisation<D>,
    system: &dyn Sde<D, M, Noise = Additive>,
    start: &GaussianMixture<D>,
    time: f64,
    strengths: &[f64],
) -> Result<Regressions, LinearisationError> {
    let mut rule = *rule;
    for _ in 0..5 {
        match of_step(&rule, system, start, time, strengths) {
            Err(LinearisationError::NotACovariance { .. }) => rule.step *= 0.5,
            other => return other,
        }
    }
    of_step(&rule, system, start, time, strengths)
}

fn of_step<const D: usize, const M: usize>(
    rule: &Linearisation<D>,
    system: &dyn Sde<D, M, Noise = Additive>,
    start: &GaussianMixture<D>,
    time: f64,
    strengths: &[f64],
) -> Result<Regressions, LinearisationError> {
    let closure = rule.closure(system, HALF_NODES)?;
    let intervals = (time / rule.step).ceil().max(1.0);
    let spacing = time / intervals;
    let mut now = GaussianLaw { t: 0.0, mean: start.mean(), covariance: start.covariance() };
    let mut laws = Vec::new();
    let mut of_strength = vec![Vec::new(); strengths.len()];
    let mut done = 0.0;
    loop {
        now.t = done * spacing;
        let (mean, covariance) = (now.mean.to_vec(), now.covariance.as_flattened().to_vec());
        laws.push(RunningLaw { mean, covariance });
        for (strength, regressions) in strengths.iter().zip(&mut of_strength) {
            regressions.push(regression(&closure, &now, *strength)?);
        }
        if done >= intervals {
            let pattern = (0..D).flat_map(|i| (0..D).map(move |j| (i, j))).collect();
            return Ok(Regressions { pattern, spacing, laws, of_strength });
        }
        now = closure.stepped(&now, spacing)?;
        done += 1.0;
    }
}

fn regression<const D: usize, const M: usize>(
    closure: &Closure<'_, D, M>,
    law: &GaussianLaw<D>,
    strength: f64,
) -> Result<Regression, LinearisationError> {
    let square = strength * strength;
    let covariance = law.covariance.map(|row| row.map(|entry| square * entry));
    let wide = GaussianLaw { covariance, ..*law };
    let expectations = closure.expectations(&wide)?;
    let factor =
        small_cholesky(&covariance, 0.0).map_err(|SmallPivot { row, value, .. }| {
            LinearisationError::NotACovariance { time: law.t, state: row, value }
        })?;
    let slope = expectations.products.map(|row| solve(&factor, row));
    let constant = (0..D).map(|i| {
        let linear: f64 = slope[i].iter().zip(&law.mean).map(|(a, m)| a * m).sum();
        expectations.drift[i] - linear
    });
    Ok(Regression { constant: constant.collect(), slope: slope.as_flattened().to_vec() })
}

/// The `y` with `L L^T y = x`.
fn solve<const D: usize>(factor: &[[f64; D]; D], x: [f64; D]) -> [f64; D] {
    let mut y = x;
    for i in 0..D {
        let known: f64 = (0..i).map(|j| factor[i][j] * y[j]).sum();
        y[i] = (y[i] - known) / factor[i][i];
    }
    for i in (0..D).rev() {
        let known: f64 = (i + 1..D).map(|j| factor[j][i] * y[j]).sum();
        y[i] = (y[i] - known) / factor[i][i];
    }
    y
}
