//! The cubic B-spline.

use crate::geometry::{beta, capped, positive_part, power, unit_sphere_surface};
use crate::kernel::Kernel;

/// The cubic B-spline with support `2 h`: the usual kernel of smoothed particle hydrodynamics.
///
/// $$ w(q) = \tfrac14 (2 - q)_+^3 - (1 - q)_+^3, \qquad
///    \sigma_D = \frac{D(D+1)(D+2)(D+3)}{6\,(2^{D+1} - 1)\, S_D} $$
///
/// which is 2/3, 10/(7π), 1/π for D = 1, 2, 3.
/// Symbols: `q = r/h`; support `2 h`. Smoothness: continuous second derivative.
/// Its Fourier transform changes sign, so particles pair at many neighbours (Dehnen & Aly 2012 `[@dehnen2012]`).
///
/// Source: Monaghan & Lattanzio 1985 `[@monaghan1985]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CubicSpline;

impl<const D: usize> Kernel<D> for CubicSpline {
    #[inline]
    fn support(&self) -> f64 {
        2.0
    }

    #[inline]
    fn shape(&self, q: f64) -> f64 {
        let q = capped(q, 2.0);
        let to_edge = 2.0 - q;
        let outer = 0.25 * (to_edge * to_edge * to_edge);
        let inner = 1.0 - 0.75 * (q * q) * to_edge;
        if q >= 1.0 { outer } else { inner }
    }

    #[inline]
    fn shape_derivative(&self, q: f64) -> f64 {
        let to_edge = positive_part(2.0 - q);
        let outer = -0.75 * (to_edge * to_edge);
        let inner = q * (2.25 * q - 3.0);
        if q >= 1.0 { outer } else { inner }
    }

    #[inline]
    fn shape_derivative_over_q(&self, q: f64) -> f64 {
        let outer = Kernel::<D>::shape_derivative(self, q) / q;
        let inner = 2.25 * q - 3.0;
        if q >= 1.0 { outer } else { inner }
    }

    #[inline]
    fn normalisation(&self) -> f64 {
        const {
            let integral = beta(D, 4) * (2.0 * power::<D>(2.0) - 1.0);
            1.0 / (unit_sphere_surface::<D>() * integral)
        }
    }
}
