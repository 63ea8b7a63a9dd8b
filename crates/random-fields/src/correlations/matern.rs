//! Matérn's correlation for any smoothness.

use std::f64::consts::PI;

use simd_lanes::exp;

/// Step of the trapezoidal rule. Its error falls as $e^{-2 \pi d / s}$ with the half-width $d < \pi/2$ of the strip in which the
/// integrand is bounded: below 1e-25 times the growth of the integrand there.
const STEP: f64 = 1.0 / 8.0;
/// Integrands below $e^{-45}$ of the result are roundoff.
const NEGLIGIBLE: f64 = 45.0;

/// $2^{1-\nu} x^\nu K_\nu(x) / \Gamma(\nu)$ for $x \ge 0$, one at zero.
///
/// By the trapezoidal rule for $K_\nu(x) = \int_0^\infty e^{-x \cosh t} \cosh(\nu t) dt$, whose integrand falls doubly
/// exponentially, so the rule is exact within roundoff: about 1e-14 for $\nu \le 20$ (against the closed forms of half-integers).
///
/// Sources: DLMF 10.32.9; Trefethen and Weideman 2014, section 5 (the error of the rule).
pub(crate) fn matern(nu: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let prefactor = (1.0 - nu) * std::f64::consts::LN_2 - libm::lgamma(nu) + nu * libm::log(x);
    let term = |t: f64| {
        let exponent = prefactor - x * libm::cosh(t);
        0.5 * (exp(exponent + nu * t) + exp(exponent - nu * t))
    };
    // The exponents have their peak where sinh t = nu/x.
    let peak = libm::asinh(nu / x);
    let least = prefactor + nu * peak - x * libm::cosh(peak) - NEGLIGIBLE;
    let mut sum = 0.5 * term(0.0);
    for k in 1.. {
        let t = STEP * f64::from(k);
        sum += term(t);
        if t > peak && prefactor + nu * t - x * libm::cosh(t) < least {
            break;
        }
    }
    STEP * sum
}

/// $\int_0^\infty$ of [`matern`]: $\sqrt\pi \Gamma(\nu + 1/2)/\Gamma(\nu)$ (DLMF 10.43.19).
pub(crate) fn integral_scale(nu: f64) -> f64 {
    PI.sqrt() * libm::exp(libm::lgamma(nu + 0.5) - libm::lgamma(nu))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_integers_are_their_closed_forms() {
        // Polynomials in x that multiply exp(-x).
        let closed = [
            (0.5, [1.0, 0.0, 0.0, 0.0]),
            (1.5, [1.0, 1.0, 0.0, 0.0]),
            (2.5, [1.0, 1.0, 1.0 / 3.0, 0.0]),
            (3.5, [1.0, 1.0, 0.4, 1.0 / 15.0]),
        ];
        for (nu, polynomial) in closed {
            for x in [1e-6, 1e-3, 0.1, 0.7, 1.0, 3.0, 10.0, 40.0_f64] {
                let polynomial = polynomial.iter().rev().fold(0.0, |sum, c| sum * x + c);
                let expected = polynomial * (-x).exp();
                let error = (matern(nu, x) / expected - 1.0).abs();
                assert!(error < 3e-14, "nu {nu}, x {x}: {error:e}");
            }
        }
    }

    #[test]
    fn other_orders_are_those_of_tables() {
        // 30 digits of mpmath 1.3, besselk(nu, x).
        let tabulated = [
            (0.25, 1.0, 0.43073977444854854),
            (1.0, 2.0, 0.13986588181652243),
            (0.75, 0.01, 32.54345278535703),
        ];
        for (nu, x, expected) in tabulated {
            let factor = libm::tgamma(nu) * f64::exp2(nu - 1.0) / libm::pow(x, nu);
            let error = (matern(nu, x) * factor / expected - 1.0).abs();
            assert!(error < 1e-13, "nu {nu}, x {x}: {error:e}");
        }
    }
}
