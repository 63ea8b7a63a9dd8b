//! Replicas of points of the unit cube, at which responses are computed.

use crate::designs::points::Sampling;

/// Means and variances of responses of a point of the unit cube, by randomised quasi-Monte Carlo.
///
/// $$ \hat\mu = \frac1R \sum_r \hat\mu_r, \qquad \hat\mu_r = \frac1n \sum_{k < n} f(x_{rk}), \qquad
///    \text{s.e.}^2 = \frac{1}{R (R - 1)} \sum_r (\hat\mu_r - \hat\mu)^2 $$
///
/// The replicas are independent scrambles of the same points, each unbiased. The variance is the mean over the replicas of
/// $\hat\sigma_r^2 + R/(R-1)\, (\hat\mu_r - \hat\mu)^2$, with $\hat\sigma_r^2$ the mean square about $\hat\mu_r$: unbiased
/// too. A standard error from $R$ replicas has $R - 1$ degrees of freedom: for 8, 16, 32 replicas an interval of 95 % is
/// 2.36, 2.13, 2.04 standard errors to either side.
///
/// A random input with another distribution is the inverse of its distribution function of a coordinate; a probability is
/// the mean of an indicator.
///
/// Sources: L'Ecuyer and Lemieux 2002, Recent advances in randomized quasi-Monte Carlo methods; Owen 1997, Scrambled net
/// variance for integrals of smooth functions.
///
/// ```
/// use uq_estimators::{Sampling, UnitCube};
///
/// let cube = UnitCube {
///     dimension: 2, sampling: Sampling::ScrambledSobol, seed: 1, n_points: 1 << 10, n_replicas: 16,
/// };
/// let product = |x: &[f64], y: &mut [f64]| { y[0] = x[0] * x[1]; Ok(()) };
/// let mean = cube.moments(1, product)?[0].mean;
/// assert!((mean.value - 0.25).abs() < 1e-5 && mean.standard_error().unwrap() < 1e-5);
/// # Ok::<(), uq_estimators::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitCube {
    /// Number of coordinates; at most 64 of Sobol' points.
    pub dimension: usize,
    /// How the points are chosen.
    pub sampling: Sampling,
    /// Seed of the scrambles or points.
    pub seed: u64,
    /// Points of a replica; a power of two for Sobol' points.
    pub n_points: u64,
    /// Number of replicas, at least eight.
    pub n_replicas: u64,
}
