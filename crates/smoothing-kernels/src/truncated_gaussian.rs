//! The truncated Gaussian.

use crate::exponential::exponential;
use crate::geometry::{capped, integer_power, unit_sphere_surface};
use crate::kernel::Kernel;

/// The Gaussian `exp(-q^2)`, truncated and normalised with the cut.
///
/// The cut is at [`TRUNCATION`](Self::TRUNCATION) smoothing lengths.
///
/// $$ w(q) = e^{-q^2}, \quad 0 \le q < a, \qquad
///    \sigma_D^{-1} = \tfrac12 S_D\, \gamma(D/2, a^2) = \pi^{D/2} P(D/2, a^2) $$
///
/// Symbols: `q = r/h`; `a` the truncation, in units of `h`; `gamma` the lower incomplete gamma function and `P` its
/// regularised form. Without the cut the standard deviation per axis would be `h/√2`.
///
/// The kernel jumps by `exp(-9)` = 1.2e-4 of its peak at `r = 3 h`; the jump does not contribute to its gradient.
/// Without the cut the normalisation would be `π^(-D/2)`; the mass beyond is 2.2e-5 for D = 1, 1.2e-4 for D = 2,
/// 4.4e-4 for D = 3 and 6.2e-3 for D = 6.
///
/// Source: Gingold & Monaghan 1977 for the Gaussian `[@gingold1977]`; NIST DLMF 8.2.1 and 8.7.1 for `gamma`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TruncatedGaussian;

impl TruncatedGaussian {
    /// Truncation in smoothing lengths.
    pub const TRUNCATION: f64 = 3.0;
}

/// `∫_0^a exp(-q^2) q^(D-1) dq = gamma(D/2, a^2) / 2` by DLMF 8.7.1,
///
/// $$ \gamma(s, x) = x^s e^{-x} \sum_k \frac{x^k}{s (s+1) \cdots (s+k)}, \qquad
///    e^{-x} = \Bigl(\sum_k \frac{x^k}{k!}\Bigr)^{-1}, $$
///
/// both sums of positive terms only, so nothing cancels; the constant is evaluated by the compiler.
const fn gaussian_moment<const D: usize>(a: f64) -> f64 {
    let x = a * a;
    let s = 0.5 * D as f64;
    let (mut term, mut exponential_term) = (1.0 / s, 1.0);
    let (mut sum, mut exponential) = (term, exponential_term);
    let mut k = 1;
    // At x = 9 the 80th term is below 1e-40 of the sum.
    while k < 80 {
        term *= x / (s + k as f64);
        exponential_term *= x / k as f64;
        sum += term;
        exponential += exponential_term;
        k += 1;
    }
    0.5 * integer_power(a, D) * sum / exponential
}

impl<const D: usize> Kernel<D> for TruncatedGaussian {
    #[inline]
    fn support(&self) -> f64 {
        Self::TRUNCATION
    }

    #[inline]
    fn shape(&self, q: f64) -> f64 {
        // Both sides of the cut are computed and one is selected, without a branch.
        let inside = capped(q, Self::TRUNCATION);
        let shape = exponential(-(inside * inside));
        if q >= Self::TRUNCATION { 0.0 } else { shape }
    }

    #[inline]
    fn shape_derivative(&self, q: f64) -> f64 {
        -2.0 * capped(q, Self::TRUNCATION) * Kernel::<D>::shape(self, q)
    }

    #[inline]
    fn shape_derivative_over_q(&self, q: f64) -> f64 {
        -2.0 * Kernel::<D>::shape(self, q)
    }

    #[inline]
    fn normalisation(&self) -> f64 {
        const { 1.0 / (unit_sphere_surface::<D>() * gaussian_moment::<D>(Self::TRUNCATION)) }
    }
}
