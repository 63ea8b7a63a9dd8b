//! A mixture of Gaussians in a linear system: a law that is not Gaussian and has a closed form at all times.

use sde_integrators::{GaussianComponent, GaussianMixture, Sde, normal_probability};

use super::linear_moments::{NormalLaw, linear_moments};
use crate::context::CaseError;

/// The law of a linear system of two states at a time, from a mixture of Gaussians: each component is carried by itself.
///
/// $$ \psi(t, x) = \sum_k w_k\, \mathcal N(x; m_k(t), P_k(t)) $$
///
/// with the mean and covariance of [`linear_moments`] for each component.
#[derive(Debug)]
pub struct MixtureLaw {
    /// The time.
    pub t: f64,
    /// The law.
    pub law: GaussianMixture<2>,
    /// The components with the error of their integration.
    components: Vec<(f64, NormalLaw<2>)>,
}

/// The law at the times, each component with steps of at most `step` ([`linear_moments`]).
pub fn mixture_laws<S: Sde<2, M>, const M: usize>(
    system: &S,
    start: &GaussianMixture<2>,
    times: &[f64],
    step: f64,
) -> Result<Vec<MixtureLaw>, CaseError> {
    let mut carried = Vec::new();
    for component in start.components() {
        let alone = GaussianMixture::gaussian(component.mean, component.covariance)?;
        carried.push((component.weight, linear_moments(system, &alone, times, step)?));
    }
    let at = |(k, &t): (usize, &f64)| {
        let components: Vec<_> = carried.iter().map(|(weight, laws)| (*weight, laws[k])).collect();
        let parts: Vec<_> = components
            .iter()
            .map(|&(weight, NormalLaw { mean, covariance, .. })| GaussianComponent {
                weight,
                mean,
                covariance,
            })
            .collect();
        Ok(MixtureLaw { t, law: GaussianMixture::mixture(&parts)?, components })
    };
    times.iter().enumerate().map(at).collect()
}

impl MixtureLaw {
    /// `E[X_i^n]` for `n` of 2 and 4:
    ///
    /// $$ E[X^2] = m^2 + P, \qquad E[X^4] = m^4 + 6 m^2 P + 3 P^2 . $$
    #[must_use]
    pub fn moment(&self, i: usize, n: u32) -> f64 {
        let of = |(weight, law): &(f64, NormalLaw<2>)| {
            let (square, variance) = (law.mean[i] * law.mean[i], law.covariance[i][i]);
            let moment = if n == 4 {
                square * square + 6.0 * square * variance + 3.0 * variance * variance
            } else {
                square + variance
            };
            weight * moment
        };
        self.components.iter().map(of).sum()
    }

    /// `P(|X_0| > T)`.
    #[must_use]
    pub fn exceedance(&self, threshold: f64) -> f64 {
        let of = |(weight, law): &(f64, NormalLaw<2>)| {
            let (mean, deviation) = (law.mean[0], law.covariance[0][0].sqrt());
            let tail = |distance: f64| normal_probability(-distance / deviation);
            weight * (tail(threshold - mean) + tail(threshold + mean))
        };
        self.components.iter().map(of).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fpk::oscillator::Oscillator;
    use crate::fpk::problem::Problem;

    #[test]
    fn moments_and_tails_are_those_of_its_density() {
        let problem = Problem::linear_oscillator().unwrap();
        let Oscillator::Linear(system) = &problem.system else { panic!("another system") };
        let component = |weight, mean| GaussianComponent {
            weight,
            mean,
            covariance: [[0.01, 0.0], [0.0, 0.04]],
        };
        let parts = [component(0.7, [0.3, 0.0]), component(0.3, [-0.2, 0.5])];
        let start = GaussianMixture::mixture(&parts).unwrap();
        let laws = mixture_laws(system, &start, &[0.75], 2e-3).unwrap();
        // The trapezoidal rule far beyond the tails is exact within roundoff for Gaussians.
        let (step, mut sums) = (0.02, [0.0; 3]);
        for a in -150..=150 {
            for b in -400..=400 {
                let x = [f64::from(a) * step, f64::from(b) * step];
                let part = laws[0].law.density(&x) * step * step;
                sums[0] += part * x[0] * x[0];
                sums[1] += part * x[0].powi(4);
                sums[2] += part * x[1] * x[1];
            }
        }
        let expected = [laws[0].moment(0, 2), laws[0].moment(0, 4), laws[0].moment(1, 2)];
        for (sum, expected) in sums.into_iter().zip(expected) {
            assert!((sum / expected - 1.0).abs() < 1e-9, "{sum} {expected}");
        }
        // Far below and far beyond the thresholds; the mean is that of the law.
        assert!((laws[0].exceedance(0.0) - 1.0).abs() < 1e-12 && laws[0].exceedance(5.0) < 1e-12);
        let covariance = laws[0].law.covariance()[0][0] + laws[0].law.mean()[0].powi(2);
        assert!((covariance / expected[0] - 1.0).abs() < 1e-12);
    }
}
