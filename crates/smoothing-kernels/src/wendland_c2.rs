//! Wendland's C2 function.

use crate::geometry::{beta, capped, integer_power, power, unit_sphere_surface};
use crate::kernel::Kernel;

/// Wendland's C2 function of the given dimension, with support `2 h`.
///
/// $$ w(q) = (1 - x)^m (1 + m x), \quad x = q/2, \quad m = \lfloor D/2 \rfloor + 3, \qquad
///    \sigma_D = \frac{(D+m+1)!}{2^D S_D\, (D-1)!\, (m+1)!\,(D+1)} $$
///
/// which is 5/8, 7/(4π), 21/(16π) for D = 1, 2, 3.
/// Symbols: `q = r/h`; support `2 h`; `m` = 3 for D = 1, 4 for D = 2, 3, 5 for D = 4, 5, 6 for D = 6.
///
/// The exponent depends on the dimension because the function must be positive definite, that is, have a positive
/// Fourier transform. For that Wendland's `phi_{l,1}` requires `l = m - 1 >= floor(D/2) + 2`; the smallest is used.
/// This is why particles do not pair with this kernel (Dehnen & Aly 2012 `[@dehnen2012]`). Codes that use
/// `(1 - x)^4 (1 + 4x)` in one dimension too have a steeper kernel than this one.
/// Smoothness: continuous second derivative.
///
/// Source: Wendland 1995 `[@wendland1995]`; D = 1, 2, 3 as in Dehnen & Aly 2012, table 1 `[@dehnen2012]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WendlandC2;

/// `m = l + 1` in dimension `D`.
const fn exponent<const D: usize>() -> usize {
    D / 2 + 3
}

impl<const D: usize> Kernel<D> for WendlandC2 {
    #[inline]
    fn support(&self) -> f64 {
        2.0
    }

    #[inline]
    fn shape(&self, q: f64) -> f64 {
        let m = const { exponent::<D>() };
        let x = 0.5 * capped(q, 2.0);
        integer_power(1.0 - x, m) * (1.0 + m as f64 * x)
    }

    #[inline]
    fn shape_derivative(&self, q: f64) -> f64 {
        capped(q, 2.0) * Kernel::<D>::shape_derivative_over_q(self, q)
    }

    /// From `dw/dx = -m (m+1) x (1-x)^(m-1)`.
    #[inline]
    fn shape_derivative_over_q(&self, q: f64) -> f64 {
        let m = const { exponent::<D>() };
        -0.25 * (m * (m + 1)) as f64 * integer_power(1.0 - 0.5 * capped(q, 2.0), m - 1)
    }

    #[inline]
    fn normalisation(&self) -> f64 {
        const {
            let m = exponent::<D>();
            let integral = power::<D>(2.0) * (beta(D, m + 1) + m as f64 * beta(D + 1, m + 1));
            1.0 / (unit_sphere_surface::<D>() * integral)
        }
    }
}
