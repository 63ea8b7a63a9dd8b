//! What is claimed of the ensembles of `sde-integrators`: bitwise identical however they are computed, and estimates that
//! agree with exact values.

pub(crate) mod first_passage;
pub(crate) mod rare_events;
pub(crate) mod reproducibility;

use result_figures::{ErrorKind, Measured, Reference};
use sde_integrators::{Estimate, SecondOrder};

use crate::case::{CaseError, Context};
use crate::claim::Criterion;
use crate::report::Claim;

/// `q'' + 2 xi omega q' + omega^2 q = s W`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Oscillator {
    pub(crate) omega: f64,
    pub(crate) xi: f64,
    pub(crate) intensity: f64,
}

impl Oscillator {
    /// `Var q(t)` from rest: Caughey and Stumpf 1961, Transient response of a dynamic system under random excitation.
    pub(crate) fn variance(&self, t: f64) -> f64 {
        let Self { omega, xi, .. } = *self;
        let damped = omega * (1.0 - xi * xi).sqrt();
        let (ratio, angle) = (xi * omega / damped, damped * t);
        let bracket = 1.0 + ratio * (2.0 * angle).sin() + 2.0 * (ratio * angle.sin()).powi(2);
        self.stationary_variance() * (1.0 - (-2.0 * xi * omega * t).exp() * bracket)
    }

    /// `Var q = s^2/(4 xi omega^3)`.
    pub(crate) fn stationary_variance(&self) -> f64 {
        self.intensity * self.intensity / (4.0 * self.xi * self.omega.powi(3))
    }
}

impl SecondOrder<1, 1> for Oscillator {
    fn natural_frequency(&self) -> [f64; 1] {
        [self.omega]
    }

    fn linear_damping(&self) -> [f64; 1] {
        [2.0 * self.xi * self.omega]
    }

    fn remaining_acceleration(&self, _: f64, _: &[f64; 1], _: &[f64; 1]) -> [f64; 1] {
        [0.0]
    }

    fn remaining_flow(&self, _: f64, _: f64, _: &[f64; 1], _: &mut [f64; 1]) {}

    fn noise_intensity(&self, _: f64) -> [[f64; 1]; 1] {
        [[self.intensity]]
    }
}

/// `P(Z > x)` for a standard normal, by the continued fraction of Laplace from `x = 2` on and Marsaglia's series below;
/// relative error below 1e-12.
pub(crate) fn upper_tail(x: f64) -> f64 {
    let density = (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    if x > 2.0 {
        let fraction = (1..=400).rev().fold(x, |below, k| x + f64::from(k) / below);
        return density / fraction;
    }
    let (mut term, mut sum) = (x, x);
    for k in 1..200 {
        term *= x * x / f64::from(2 * k + 1);
        sum += term;
    }
    0.5 - density * sum
}

/// The value of an estimate with its standard error.
pub(crate) fn sampled(estimate: &Estimate) -> Result<Measured, CaseError> {
    let standard_error = estimate.standard_error().ok_or("an estimate without standard error")?;
    Ok(Measured::sampled(estimate.value, standard_error))
}

/// A Monte Carlo claim against an exact value, relative.
pub(crate) fn against_exact(
    context: &Context<'_>,
    (name, quantity, method): (&str, &str, &str),
    estimate: &Estimate,
    exact: f64,
    (bias_bound, reason): (f64, &str),
) -> Result<Claim, CaseError> {
    Ok(Claim::judge(
        context.subject(name, quantity, "", method),
        ErrorKind::Relative,
        sampled(estimate)?,
        Reference::exact(exact),
        Criterion::MonteCarlo { bias_bound, reason },
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Abramowitz and Stegun, table 26.1 and 26.2.
    #[test]
    fn the_tail_of_the_normal_law_has_its_tabled_values() {
        for (x, expected) in [
            (0.0, 0.5),
            (1.0, 0.158655253931457),
            (2.0, 0.0227501319481792),
            (3.0, 0.00134989803163009),
            (5.0, 2.86651571879194e-7),
        ] {
            assert!((upper_tail(x) / expected - 1.0).abs() < 1e-11, "{x}: {}", upper_tail(x));
        }
    }

    #[test]
    fn the_transient_variance_ends_in_the_stationary_one() {
        let oscillator = Oscillator { omega: 2.0, xi: 0.05, intensity: 0.7 };
        let late = oscillator.variance(200.0) / oscillator.stationary_variance();
        assert!((late - 1.0).abs() < 1e-12);
        // From rest the variance begins as s^2 t^3/3.
        assert!((oscillator.variance(1e-2) / (0.49 * 1e-6 / 3.0) - 1.0).abs() < 1e-2);
    }
}
