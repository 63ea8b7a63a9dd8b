//! The return to the yield surface of Johnson and Cook, as numbers.

use perturbation_moments::Real;
use simd_lanes::Mask;

use crate::error::Fault;

/// A plastic strain that is none: the curvature of its logarithm, `1/eps^2`, must be a number. Only exponents below 0.1 get
/// there, and the stress is the same within roundoff.
pub(super) const LEAST_STRAIN: f64 = 1e-100;

/// Iterations at most.
const MOST_ITERATIONS: usize = 200;

/// The return to the yield surface as numbers: `overshoot = 3 G x + h ((strain + x)^n - hardening)`.
pub(super) struct Return<P> {
    pub(super) overshoot: P,
    /// `3 G`.
    pub(super) shear: P,
    /// `B (1 + C ln rate) (1 - T^m)`.
    pub(super) factor: P,
    pub(super) exponent: P,
    pub(super) strain: P,
    /// `strain^n`.
    pub(super) hardening: P,
}

impl<P: Real<Primal = P>> Return<P> {
    /// The plastic strain of the step, to a relative `1e-12`, where the mask is true; the factor is above zero there. Most is
    /// needed of it at no plastic strain, where the slope is infinite; from below, Newton's method ascends to the root for `n <= 1`;
    /// for any `n` the bracket holds. Zero where it would be below [`LEAST_STRAIN`], and where the mask is false.
    #[inline(always)]
    pub(super) fn increment(&self, mask: P::Mask) -> Result<P, Fault> {
        let &Self { overshoot, shear, factor, exponent: n, strain, hardening } = self;
        let zero = overshoot.splat(0.0);
        let (mut low, mut high) = (zero, overshoot / shear);
        let (mut x, mut left) = self.begin(mask, high);
        for _ in 0..MOST_ITERATIONS {
            if !left.any() {
                return Ok(x);
            }
            let power = ((strain + x).ln() * n).exp();
            let residual = overshoot - shear * x - factor * (power - hardening);
            let is_below = zero.less(residual);
            low = P::select(is_below, x, low);
            high = P::select(is_below, high, x);
            let step = residual / (shear + factor * n * power / (strain + x));
            let (next, least) = (x + step, x * 1e-6);
            let is_found = least.at_least(step).and(least.at_least(-step));
            let is_inside = low.less(next).and(next.less(high));
            let bracketed = P::select(is_inside, next, (low + high) * 0.5);
            x = P::select(left, P::select(is_found, next, bracketed), x);
            left = left.and(is_found.not());
        }
        Fault::unless(
            left.not(),
            x,
            "the plastic strain of a step",
            "found within 200 iterations",
        )?;
        Ok(x)
    }

    /// The plastic strain from none at which hardening alone bears an overshoot.
    #[inline(always)]
    fn reach(&self, overshoot: P) -> P {
        ((overshoot / self.factor).ln() / self.exponent).exp()
    }

    /// Where the iteration begins, and in which lanes it is needed.
    #[inline(always)]
    fn begin(&self, mask: P::Mask, high: P) -> (P, P::Mask) {
        let &Self { overshoot, shear, factor, exponent: n, strain, hardening } = self;
        let zero = overshoot.splat(0.0);
        let is_strained = zero.less(strain);
        let tangent = overshoot / (shear + factor * n * hardening / strain);
        let x = P::select(is_strained, tangent, zero);
        let begins = mask.and(strain.less(high * 0.1));
        if !begins.any() {
            return (P::select(mask, x, zero), mask);
        }
        let is_none = self.reach(overshoot).less(overshoot.splat(LEAST_STRAIN));
        let is_none = begins.and(is_strained.not()).and(is_none);
        // Neither part takes more than half of the overshoot there.
        let (half, part) = (high * 0.5, self.reach(overshoot * 0.5));
        let least = P::select(half.less(part), half, part);
        let further = P::select(begins.and(x.less(least)), least, x);
        let left = mask.and(is_none.not());
        (P::select(left, further, zero), left)
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
                    let x = case.increment(true).unwrap();
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
