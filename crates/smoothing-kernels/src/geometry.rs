//! Powers and the surface of the unit sphere, usable in constants.

use core::f64::consts::PI;

/// `h^D`, by multiplication from the left: the same bits wherever it is used.
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

/// `max(a, 0)`, and NaN for NaN: one instruction, where `f64::max` would turn NaN into 0.
#[inline]
pub(crate) const fn positive_part(a: f64) -> f64 {
    if a < 0.0 { 0.0 } else { a }
}

/// `min(q, edge)`, and NaN for NaN. A polynomial that vanishes at its edge vanishes beyond it when its argument is
/// capped there, without a branch, and an infinite argument meets no zero.
#[inline]
pub(crate) const fn capped(q: f64, edge: f64) -> f64 {
    if q > edge { edge } else { q }
}

/// Surface of the unit sphere in `D` dimensions,
///
/// $$ S_D = \frac{2 \pi^{D/2}}{\Gamma(D/2)}, \qquad S_1 = 2, \quad S_2 = 2\pi, \quad S_{D} = \frac{2\pi}{D-2} S_{D-2}, $$
///
/// the recurrence being `Γ(s + 1) = s Γ(s)` at the half integers. What a user's kernel needs for its normalisation:
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

/// Beta function `B(a, b) = (a-1)! (b-1)! / (a+b-1)!` of positive integers: the integral of `x^(a-1) (1-x)^(b-1)` over
/// [0, 1], of which every polynomial kernel's normalisation is made.
pub(crate) const fn beta(a: usize, b: usize) -> f64 {
    let mut value = 1.0 / a as f64;
    let mut k = 1;
    while k < b {
        value *= k as f64 / (a + k) as f64;
        k += 1;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surface_of_the_unit_sphere_is_the_textbook_value() {
        // 2 pi^(D/2) / Gamma(D/2), Gamma(1/2) = sqrt(pi), Gamma(3/2) = sqrt(pi)/2, Gamma(5/2) = 3 sqrt(pi)/4.
        let surfaces = [
            unit_sphere_surface::<1>(),
            unit_sphere_surface::<2>(),
            unit_sphere_surface::<3>(),
            unit_sphere_surface::<4>(),
            unit_sphere_surface::<5>(),
            unit_sphere_surface::<6>(),
        ];
        let textbook = [2.0, 2.0 * PI, 4.0 * PI, 2.0 * PI * PI, 8.0 * PI * PI / 3.0, PI * PI * PI];
        for (surface, expected) in surfaces.into_iter().zip(textbook) {
            // At most six roundings.
            assert!((surface / expected - 1.0).abs() < 6.0 * f64::EPSILON, "{surface} {expected}");
        }
    }

    #[test]
    fn beta_of_integers_is_a_ratio_of_factorials() {
        assert!((beta(1, 1) - 1.0).abs() < f64::EPSILON);
        assert!((beta(3, 4) - 2.0 * 6.0 / 720.0).abs() < f64::EPSILON);
        assert!((beta(4, 3) - beta(3, 4)).abs() < f64::EPSILON);
    }

    #[test]
    fn power_is_repeated_multiplication() {
        assert_eq!(power::<1>(3.0).to_bits(), 3.0_f64.to_bits());
        assert_eq!(power::<6>(2.0).to_bits(), 64.0_f64.to_bits());
    }
}
