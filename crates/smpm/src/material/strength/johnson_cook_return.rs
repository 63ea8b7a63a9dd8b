//! The return to the yield surface of Johnson and Cook, as numbers.

use crate::error::Fault;

/// A plastic strain that is none: the curvature of its logarithm, `1/eps^2`, must be a number. Only exponents below 0.1 get
/// there, and the stress is the same within roundoff.
pub(super) const LEAST_STRAIN: f64 = 1e-100;

/// The return to the yield surface as numbers: `overshoot = 3 G x + h ((strain + x)^n - hardening)`.
pub(super) struct Return {
    pub(super) overshoot: f64,
    /// `3 G`.
    pub(super) shear: f64,
    /// `B (1 + C ln rate) (1 - T^m)`.
    pub(super) factor: f64,
    pub(super) exponent: f64,
    pub(super) strain: f64,
    /// `strain^n`.
    pub(super) hardening: f64,
}

impl Return {
    /// The plastic strain of the step, to a relative `1e-12`. Most is needed of it at no plastic strain, where the slope is
    /// infinite; from below, Newton's method ascends to the root for `n <= 1`; for any `n` the bracket holds. Zero where it would
    /// be below [`LEAST_STRAIN`].
    pub(super) fn increment(&self) -> Result<f64, Fault> {
        let &Self { overshoot, shear, factor, exponent: n, strain, hardening } = self;
        let (mut low, mut high) = (0.0, overshoot / shear);
        if factor <= 0.0 {
            return Ok(high);
        }
        let mut x =
            if strain > 0.0 { overshoot / (shear + factor * n * hardening / strain) } else { 0.0 };
        if strain < 0.1 * high {
            let reach = |overshoot: f64| (overshoot / factor).powf(1.0 / n);
            if strain <= 0.0 && reach(overshoot) < LEAST_STRAIN {
                return Ok(0.0);
            }
            // Neither part takes more than half of the overshoot there.
            x = x.max((0.5 * high).min(reach(0.5 * overshoot)));
        }
        for _ in 0..200 {
            let power = (n * (strain + x).ln()).exp();
            let residual = overshoot - shear * x - factor * (power - hardening);
            if residual > 0.0 {
                low = x;
            } else {
                high = x;
            }
            let step = residual / (shear + factor * n * power / (strain + x));
            if step.abs() <= 1e-6 * x {
                return Ok(x + step);
            }
            x = if low < x + step && x + step < high { x + step } else { 0.5 * (low + high) };
        }
        Err(Fault {
            quantity: "the plastic strain of a step",
            value: x,
            must: "found within 200 iterations",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_return_satisfies_its_equation_at_every_strain() {
        let factor = 510.0 * 1.1;
        for strain in [0.0, 1e-30, 1e-12, 1e-6, 1e-3, 0.1, 2.0] {
            for overshoot in [1e-7, 1e-3, 1.0, 100.0, 1e5] {
                for exponent in [0.05, 0.26, 1.0, 2.5] {
                    let hardening = if strain > 0.0 { f64::powf(strain, exponent) } else { 0.0 };
                    let shear = 3.0 * 77500.0;
                    let case = Return { overshoot, shear, factor, exponent, strain, hardening };
                    let x = case.increment().unwrap();
                    if strain <= 0.0 && (overshoot / factor).powf(1.0 / exponent) < LEAST_STRAIN {
                        assert_eq!(x.to_bits(), 0);
                        continue;
                    }
                    assert!(x > 0.0 && x <= overshoot / shear);
                    let power = (strain + x).powf(exponent);
                    let residual = overshoot - shear * x - factor * (power - hardening);
                    // Roundoff of the power, and 1e-12 of the overshoot.
                    let bound = 1e-11 * overshoot + 1e-14 * factor * power;
                    assert!(residual.abs() < bound, "{strain} {overshoot} {exponent}: {residual}");
                }
            }
        }
    }
}
