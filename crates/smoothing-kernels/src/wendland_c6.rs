//! Wendland's C6 function.

use crate::geometry::{beta, capped, integer_power, power, unit_sphere_surface};
use crate::kernel::Kernel;

/// Wendland's C6 function of the given dimension, with support `2 h`.
///
/// $$ w(q) = (1 - x)^p \Bigl(1 + p x + \tfrac15 (2 p^2 - 3)\, x^2 + \tfrac{1}{15} p (p^2 - 4)\, x^3\Bigr), \quad x = q/2, \quad p = \lfloor D/2 \rfloor + 7 $$
///
/// normalised by 55/64, 39/(14π), 1365/(512π) for D = 1, 2, 3.
/// Symbols: `q = r/h`; support `2 h`; `p` = 7 for D = 1, 8 for D = 2, 3, 9 for D = 4, 5, 10 for D = 6.
///
/// As in [`WendlandC2`](crate::WendlandC2) the exponent is the smallest for which the function is positive definite:
/// `phi_{l,3}` with `l = p - 3 = floor(D/2) + 4`.
/// Smoothness: continuous sixth derivative. It is narrower than the C4 function at the same support, so it requires
/// more neighbours, that is, a larger `h`.
///
/// Source: Wendland 1995 `[@wendland1995]`; D = 1, 2, 3 as in Dehnen & Aly 2012, table 1 `[@dehnen2012]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WendlandC6;

/// `p = l + 3` in dimension `D`.
const fn exponent<const D: usize>() -> usize {
    D / 2 + 7
}

impl<const D: usize> Kernel<D> for WendlandC6 {
    #[inline]
    fn support(&self) -> f64 {
        2.0
    }

    #[inline]
    fn shape(&self, q: f64) -> f64 {
        let exponent = const { exponent::<D>() };
        let p = exponent as f64;
        let x = 0.5 * capped(q, 2.0);
        let (square, cube) = ((2.0 * p * p - 3.0) / 5.0, p * (p * p - 4.0) / 15.0);
        integer_power(1.0 - x, exponent) * (1.0 + x * (p + x * (square + x * cube)))
    }

    #[inline]
    fn shape_derivative(&self, q: f64) -> f64 {
        capped(q, 2.0) * Kernel::<D>::shape_derivative_over_q(self, q)
    }

    /// From `dw/dx = -(p+2)(p+3)/5 x (1-x)^(p-1) (1 + (p-1) x + p (p-2)/3 x^2)`.
    #[inline]
    fn shape_derivative_over_q(&self, q: f64) -> f64 {
        let exponent = const { exponent::<D>() };
        let p = exponent as f64;
        let x = 0.5 * capped(q, 2.0);
        let slope = -0.25 * ((p + 2.0) * (p + 3.0) / 5.0);
        let square = p * (p - 2.0) / 3.0;
        slope * integer_power(1.0 - x, exponent - 1) * (1.0 + x * (p - 1.0 + x * square))
    }

    #[inline]
    fn normalisation(&self) -> f64 {
        const {
            let exponent = exponent::<D>();
            let p = exponent as f64;
            let integral = beta(D, exponent + 1)
                + p * beta(D + 1, exponent + 1)
                + (2.0 * p * p - 3.0) / 5.0 * beta(D + 2, exponent + 1)
                + p * (p * p - 4.0) / 15.0 * beta(D + 3, exponent + 1);
            1.0 / (unit_sphere_surface::<D>() * power::<D>(2.0) * integral)
        }
    }
}
