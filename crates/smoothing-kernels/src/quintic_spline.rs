//! The quintic B-spline.

use crate::geometry::{beta, integer_power, positive_part, unit_sphere_surface};
use crate::kernel::Kernel;

/// The quintic B-spline, Schoenberg's M6, with support `3 h`.
///
/// $$ w(q) = \tfrac{1}{66} \Bigl[ (3 - q)_+^5 - 6 (2 - q)_+^5 + 15 (1 - q)_+^5 \Bigr], \qquad
///    \sigma_D = \frac{66\, D(D+1)(D+2)(D+3)(D+4)(D+5)}{120\, S_D\, [3^{D+5} - 6\cdot 2^{D+5} + 15]} $$
///
/// in the print, whose bracket is not divided by its peak: `1/120, 7/(478π), 1/(120π)` for D = 1, 2, 3.
/// Symbols: `q = r/h`; support `3 h`. Smoothness: continuous fourth derivative.
/// The closest of the splines to a Gaussian; particles still pair, because its Fourier transform has zeros.
///
/// Source: Schoenberg 1946 for the splines `[@schoenberg1946]`; Dehnen & Aly 2012, table 1, for the constants
/// `[@dehnen2012]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct QuinticSpline;

/// One over the peak of the sum of truncated powers, at `q = 0`.
const SCALE: f64 = 1.0 / 66.0;

impl<const D: usize> Kernel<D> for QuinticSpline {
    #[inline]
    fn support(&self) -> f64 {
        3.0
    }

    #[inline]
    fn shape(&self, q: f64) -> f64 {
        let sum = integer_power(positive_part(3.0 - q), 5)
            - 6.0 * integer_power(positive_part(2.0 - q), 5);
        // The sum of all three truncated powers cancels here; the polynomial does not.
        let square = q * q;
        let inner = 1.0 - SCALE * (square * (60.0 - square * (30.0 - 10.0 * q)));
        if q >= 1.0 { SCALE * sum } else { inner }
    }

    #[inline]
    fn shape_derivative(&self, q: f64) -> f64 {
        let sum = integer_power(positive_part(3.0 - q), 4)
            - 6.0 * integer_power(positive_part(2.0 - q), 4);
        let inner = q * inner_derivative_over_q(q);
        if q >= 1.0 { -5.0 * SCALE * sum } else { inner }
    }

    #[inline]
    fn shape_derivative_over_q(&self, q: f64) -> f64 {
        let outer = Kernel::<D>::shape_derivative(self, q) / q;
        let inner = inner_derivative_over_q(q);
        if q >= 1.0 { outer } else { inner }
    }

    #[inline]
    fn normalisation(&self) -> f64 {
        const {
            let sum = integer_power(3.0, D + 5) - 6.0 * integer_power(2.0, D + 5)
                + 15.0 * integer_power(1.0, D + 5);
            1.0 / (unit_sphere_surface::<D>() * SCALE * beta(D, 6) * sum)
        }
    }
}

/// `w'(q)/q` on the innermost piece, where the sum is `66 - 60 q^2 + 30 q^4 - 10 q^5`.
#[inline]
const fn inner_derivative_over_q(q: f64) -> f64 {
    -SCALE * (120.0 - 120.0 * (q * q) + 50.0 * (q * q * q))
}
