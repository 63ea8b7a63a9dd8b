//! Wendland's C4 function.

use crate::geometry::{beta, capped, integer_power, power, unit_sphere_surface};
use crate::kernel::Kernel;

/// Wendland's C4 function of the given dimension, with support `2 h`.
///
/// $$ w(q) = (1 - x)^p \Bigl(1 + p x + \tfrac13 (p^2 - 1)\, x^2\Bigr), \quad x = q/2, \quad p = \lfloor D/2 \rfloor + 5 $$
///
/// normalised by 3/4, 9/(4π), 495/(256π) for D = 1, 2, 3.
/// Symbols: `q = r/h`; support `2 h`; `p` = 5 for D = 1, 6 for D = 2, 3, 7 for D = 4, 5, 8 for D = 6.
///
/// As in [`WendlandC2`](crate::WendlandC2) the exponent is the smallest for which the function is positive definite:
/// `phi_{l,2}` with `l = p - 2 = floor(D/2) + 3`.
/// Smoothness: continuous fourth derivative. It is narrower than the C2 function at the same support, so it requires
/// more neighbours, that is, a larger `h`.
///
/// Source: Wendland 1995 `[@wendland1995]`; D = 1, 2, 3 as in Dehnen & Aly 2012, table 1 `[@dehnen2012]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WendlandC4;

/// `p = l + 2` in dimension `D`.
const fn exponent<const D: usize>() -> usize {
    D / 2 + 5
}

impl<const D: usize> Kernel<D> for WendlandC4 {
    #[inline]
    fn support(&self) -> f64 {
        2.0
    }

    #[inline]
    fn shape(&self, q: f64) -> f64 {
        let exponent = const { exponent::<D>() };
        let p = exponent as f64;
        let x = 0.5 * capped(q, 2.0);
        integer_power(1.0 - x, exponent) * (1.0 + x * (p + x * ((p * p - 1.0) / 3.0)))
    }

    #[inline]
    fn shape_derivative(&self, q: f64) -> f64 {
        capped(q, 2.0) * Kernel::<D>::shape_derivative_over_q(self, q)
    }

    /// From `dw/dx = -(p+1)(p+2)/3 x (1-x)^(p-1) (1 + (p-1) x)`.
    #[inline]
    fn shape_derivative_over_q(&self, q: f64) -> f64 {
        let exponent = const { exponent::<D>() };
        let p = exponent as f64;
        let x = 0.5 * capped(q, 2.0);
        let slope = -0.25 * ((p + 1.0) * (p + 2.0) / 3.0);
        slope * integer_power(1.0 - x, exponent - 1) * (1.0 + x * (p - 1.0))
    }

    #[inline]
    fn normalisation(&self) -> f64 {
        const {
            let exponent = exponent::<D>();
            let p = exponent as f64;
            let integral = beta(D, exponent + 1)
                + p * beta(D + 1, exponent + 1)
                + (p * p - 1.0) / 3.0 * beta(D + 2, exponent + 1);
            1.0 / (unit_sphere_surface::<D>() * power::<D>(2.0) * integral)
        }
    }
}
