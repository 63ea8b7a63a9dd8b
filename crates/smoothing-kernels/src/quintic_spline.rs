//! The quintic B-spline.

use crate::geometry::{beta, integer_power, positive_part, unit_sphere_surface};
use crate::kernel::Kernel;

/// The quintic B-spline, Schoenberg's M6, on three smoothing lengths.
///
/// $$ w(q) = \tfrac{1}{66} \Bigl[ (3 - q)_+^5 - 6 (2 - q)_+^5 + 15 (1 - q)_+^5 \Bigr], \qquad
///    \sigma_D = \frac{66\, D(D+1)(D+2)(D+3)(D+4)(D+5)}{120\, S_D\, [3^{D+5} - 6\cdot 2^{D+5} + 15]} $$
///
/// in the print, whose bracket is not divided by its peak: `1/120, 7/(478π), 1/(120π)` for D = 1, 2, 3.
/// Symbols: `q = r/h`; support `3 h`. Smoothness: continuous fourth derivative.
/// The nearest of the splines to a Gaussian, and still one that pairs: its Fourier transform has zeros.
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

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;

    #[test]
    fn normalisation_is_the_published_one() {
        // Dehnen & Aly 2012, table 1: the factors of the sum of truncated powers, whose peak is 66.0.
        let ours = [
            Kernel::<1>::normalisation(&QuinticSpline),
            Kernel::<2>::normalisation(&QuinticSpline),
            Kernel::<3>::normalisation(&QuinticSpline),
        ];
        let published =
            [1.0 / 120.0, 7.0 / (478.0 * PI), 1.0 / (120.0 * PI)].map(|factor| 66.0 * factor);
        for (ours, published) in ours.into_iter().zip(published) {
            // The sum over the pieces cancels to about a tenth of its largest term.
            assert!((ours / published - 1.0).abs() < 1e-14, "{ours} {published}");
        }
    }

    #[test]
    fn values_at_the_knots_are_those_of_the_spline() {
        // (3-q)^5 - 6 (2-q)^5: 32 - 6 at q = 1, 1 at 2.
        for (q, expected) in [(1.0, 26.0), (2.0, 1.0), (3.0, 0.0)] {
            let shape = Kernel::<3>::shape(&QuinticSpline, q);
            assert!((shape - expected / 66.0).abs() < 1e-15, "{q}: {shape}");
        }
    }

    #[test]
    fn inner_piece_has_its_slope() {
        for q in [0.1, 0.3, 0.49] {
            let step = 1e-5;
            let shape = |q| Kernel::<2>::shape(&QuinticSpline, q);
            // Truncation below 2e-10, roundoff 1e-16 / 1e-5.
            let difference = (shape(q + step) - shape(q - step)) / (2.0 * step);
            assert!((q * inner_derivative_over_q(q) - difference).abs() < 1e-9);
        }
    }
}
