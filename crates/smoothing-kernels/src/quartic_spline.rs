//! The quartic B-spline.

use crate::geometry::{beta, integer_power, positive_part, unit_sphere_surface};
use crate::kernel::Kernel;

/// The quartic B-spline, Schoenberg's M5, with support `2.5 h`.
///
/// $$ w(q) = \tfrac{8}{115} \Bigl[ (\tfrac52 - q)_+^4 - 5 (\tfrac32 - q)_+^4 + 10 (\tfrac12 - q)_+^4 \Bigr], \qquad
///    \sigma_D = \frac{115\, D(D+1)(D+2)(D+3)(D+4)}{192\, S_D\, [(5/2)^{D+4} - 5 (3/2)^{D+4} + 10 (1/2)^{D+4}]} $$
///
/// in the print, whose bracket is not divided by its peak: `1/24, 96/(1199π), 1/(20π)` for D = 1, 2, 3.
/// Symbols: `q = r/h`; support `2.5 h`. Smoothness: continuous third derivative.
/// Particles pair at more neighbours than with the cubic spline; its Fourier transform has zeros too.
///
/// Source: Schoenberg 1946 for the splines `[@schoenberg1946]`; Dehnen & Aly 2012, table 1, for the constants
/// `[@dehnen2012]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct QuarticSpline;

/// One over the peak of the sum of truncated powers, at `q = 0`.
const SCALE: f64 = 1.0 / 14.375;

impl<const D: usize> Kernel<D> for QuarticSpline {
    #[inline]
    fn support(&self) -> f64 {
        2.5
    }

    #[inline]
    fn shape(&self, q: f64) -> f64 {
        let sum = integer_power(positive_part(2.5 - q), 4)
            - 5.0 * integer_power(positive_part(1.5 - q), 4);
        // The sum of all three truncated powers cancels here; the polynomial does not.
        let square = q * q;
        let inner = 1.0 - SCALE * (square * (15.0 - 6.0 * square));
        if q >= 0.5 { SCALE * sum } else { inner }
    }

    #[inline]
    fn shape_derivative(&self, q: f64) -> f64 {
        let sum = integer_power(positive_part(2.5 - q), 3)
            - 5.0 * integer_power(positive_part(1.5 - q), 3);
        let inner = q * inner_derivative_over_q(q);
        if q >= 0.5 { -4.0 * SCALE * sum } else { inner }
    }

    #[inline]
    fn shape_derivative_over_q(&self, q: f64) -> f64 {
        let outer = Kernel::<D>::shape_derivative(self, q) / q;
        let inner = inner_derivative_over_q(q);
        if q >= 0.5 { outer } else { inner }
    }

    #[inline]
    fn normalisation(&self) -> f64 {
        const {
            let sum = integer_power(2.5, D + 4) - 5.0 * integer_power(1.5, D + 4)
                + 10.0 * integer_power(0.5, D + 4);
            1.0 / (unit_sphere_surface::<D>() * SCALE * beta(D, 5) * sum)
        }
    }
}

/// `w'(q)/q` on the innermost piece, where the sum is `115/8 - 15 q^2 + 6 q^4`.
#[inline]
const fn inner_derivative_over_q(q: f64) -> f64 {
    -SCALE * (30.0 - 24.0 * (q * q))
}
