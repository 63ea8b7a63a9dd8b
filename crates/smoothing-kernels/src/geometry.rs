//! Powers and the surface of the unit sphere, usable in constants.

use core::f64::consts::PI;

/// `h^D`, by multiplication from the left, so it is bitwise identical everywhere.
///
/// ```
/// assert_eq!(smoothing_kernels::power::<3>(0.5), 0.125);
/// ```
#[inline]
#[must_use]
pub const fn power<const D: usize>(h: f64) -> f64 {
    integer_power(h, D)
}

/// `base^exponent`; with a constant exponent the loop unrolls to that many multiplications.
#[inline]
pub(crate) const fn integer_power(base: f64, exponent: usize) -> f64 {
    let mut product = 1.0;
    let mut factor = 0;
    while factor < exponent {
        product *= base;
        factor += 1;
    }
    product
}

/// `max(a, 0)`, and NaN for NaN: one instruction, whereas `f64::max` would turn NaN into 0.
#[inline]
pub(crate) const fn positive_part(a: f64) -> f64 {
    if a < 0.0 { 0.0 } else { a }
}

/// `min(q, edge)`, and NaN for NaN.
///
/// A polynomial that is zero at its edge is zero beyond it if its argument is limited, without a branch; an infinite
/// argument never multiplies zero.
#[inline]
pub(crate) const fn capped(q: f64, edge: f64) -> f64 {
    if q > edge { edge } else { q }
}

/// Surface of the unit sphere in `D` dimensions,
///
/// $$ S_D = \frac{2 \pi^{D/2}}{\Gamma(D/2)}, \qquad S_1 = 2, \quad S_2 = 2\pi, \quad S_{D} = \frac{2\pi}{D-2} S_{D-2}, $$
///
/// The recurrence is `Γ(s + 1) = s Γ(s)` at half integers. A user-defined kernel needs it for its normalisation:
/// `sigma_D = 1 / (S_D ∫ shape(q) q^(D-1) dq)`. `D = 0` does not compile.
///
/// Source: NIST DLMF 5.19.4 for the sphere, 5.5.1 for the recurrence.
///
/// ```
/// let surface = smoothing_kernels::unit_sphere_surface::<3>();
/// assert!((surface - 4.0 * core::f64::consts::PI).abs() < 1e-15);
/// ```
#[inline]
#[must_use]
pub const fn unit_sphere_surface<const D: usize>() -> f64 {
    const { assert!(D >= 1, "a sphere needs at least one dimension") };
    let (mut dimension, mut surface) = if D % 2 == 1 { (1, 2.0) } else { (2, 2.0 * PI) };
    while dimension < D {
        surface *= 2.0 * PI / dimension as f64;
        dimension += 2;
    }
    surface
}

/// Beta function `B(a, b) = (a-1)! (b-1)! / (a+b-1)!` of positive integers.
///
/// It is the integral of `x^(a-1) (1-x)^(b-1)` over [0, 1], from which the normalisation of every polynomial kernel
/// follows.
pub(crate) const fn beta(a: usize, b: usize) -> f64 {
    let mut value = 1.0 / a as f64;
    let mut k = 1;
    while k < b {
        value *= k as f64 / (a + k) as f64;
        k += 1;
    }
    value
}
