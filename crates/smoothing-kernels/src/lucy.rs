//! Lucy's kernel.

use crate::geometry::{beta, capped, unit_sphere_surface};
use crate::kernel::Kernel;

/// Lucy's kernel: quartic, bell-shaped, with support `h`.
///
/// $$ w(q) = (1 + 3q)(1 - q)^3, \quad 0 \le q \le 1, \qquad \sigma_D = \frac{D (D+2)(D+3)(D+4)}{24\, S_D} $$
///
/// which is 5/4, 5/π, 105/(16π), 28/π² for D = 1, 2, 3, 4.
/// Symbols: `q = r/h`; support `h`, not `2 h`: for the same width its smoothing length is about twice that of the
/// cubic spline.
/// Smoothness: continuous second derivative inside, `w' ~ (1-q)^2` at the edge.
/// Second moment in units of h: `<x^2>/h^2` = 0.0893 for D = 2 and 0.0833 for D = 3.
///
/// In one dimension this is Wendland's C2 function; in higher dimensions it is not positive definite.
///
/// Source: Lucy 1977 `[@lucy1977]`; the constants for D = 2, 3, 4 as in Canor & Denoël 2013, eq 9 `[@canor2013]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Lucy;

impl<const D: usize> Kernel<D> for Lucy {
    #[inline]
    fn support(&self) -> f64 {
        1.0
    }

    #[inline]
    fn shape(&self, q: f64) -> f64 {
        let q = capped(q, 1.0);
        let to_edge = 1.0 - q;
        (1.0 + 3.0 * q) * (to_edge * to_edge * to_edge)
    }

    #[inline]
    fn shape_derivative(&self, q: f64) -> f64 {
        capped(q, 1.0) * Kernel::<D>::shape_derivative_over_q(self, q)
    }

    #[inline]
    fn shape_derivative_over_q(&self, q: f64) -> f64 {
        let to_edge = 1.0 - capped(q, 1.0);
        -12.0 * (to_edge * to_edge)
    }

    #[inline]
    fn normalisation(&self) -> f64 {
        const { 1.0 / (unit_sphere_surface::<D>() * (beta(D, 4) + 3.0 * beta(D + 1, 4))) }
    }
}
