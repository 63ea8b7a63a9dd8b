//! The tail of the standard normal distribution.

/// `P(Z > z)` of a standard normal variable, to full relative precision.
///
/// It is `e^(-z^2/2)/sqrt(2 pi)` times the integral of `e^(-z t - t^2/2)` over `t > 0`, by the trapezoidal rule in `u`
/// with `t = exp(pi/2 sinh u)`.
#[must_use]
pub fn upper_tail(z: f64) -> f64 {
    use std::f64::consts::{FRAC_PI_2, TAU};
    if z < 0.0 {
        return 1.0 - upper_tail(-z);
    }
    let step = 1.0 / 64.0;
    let term = |k: i32| {
        let u = f64::from(k) * step;
        let t = (FRAC_PI_2 * u.sinh()).exp();
        FRAC_PI_2 * u.cosh() * t * (-t * (z + 0.5 * t)).exp()
    };
    let integral: f64 = (-256..=160).map(term).sum::<f64>() * step;
    (-0.5 * z * z).exp() / TAU.sqrt() * integral
}
