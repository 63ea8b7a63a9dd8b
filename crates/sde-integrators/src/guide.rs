//! Guides of paths: the feedback that shifts the normals of a step.

/// Largest shift of the normals of a step, in standard deviations.
///
/// Near the end of a guide a path that misses the event has no control left, and its shift would grow without bound.
pub(crate) const LARGEST_SHIFT: f64 = 4.0;

/// The guide of one step: its normals are shifted by `lambda(b) d` with `b = state . x + offset`.
///
/// $$ \lambda(b) = \varphi(b) / \Phi(b), \qquad |\lambda d| \le 4 . $$
///
/// Example: a linear response has the expected value `mu(x)` and the standard deviation `s`, given the state at the start
/// of the step. With `b = (mu(x) - T)/s` and the derivatives of the response by the normals over `s` as direction `d`, the
/// shift is the expectation of the normals given that the response exceeds `T`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guidance<const D: usize, const M: usize> {
    /// Coefficients of the state (1 per unit of each state).
    pub state: [f64; D],
    /// Constant term of `b` (no unit).
    pub offset: f64,
    /// `d`, for the normals of the increments `w` (no unit).
    pub brownian: [f64; M],
    /// `d`, for the normals of the areas `H` (no unit); ignored if the method does not use them.
    pub area: [f64; M],
}

/// A guide of paths: one component of a [`GuidedEnsemble`](crate::GuidedEnsemble).
#[derive(Debug, Clone, PartialEq)]
pub struct Guide<const D: usize, const M: usize> {
    /// Probability that a path has this guide (no unit).
    pub share: f64,
    /// Shift of the normals of the start (no unit).
    pub start: [f64; D],
    /// Guides of the first steps; the path is free afterwards.
    pub steps: Vec<Guidance<D, M>>,
}

impl<const D: usize, const M: usize> Guide<D, M> {
    /// A number that is not finite, if there is one.
    pub(crate) fn not_finite(&self) -> Option<f64> {
        let of_step = |step: &Guidance<D, M>| {
            let all = step.state.iter().chain(&step.brownian).chain(&step.area);
            all.copied().chain([step.offset]).find(|value| !value.is_finite())
        };
        let mut first = [self.share].into_iter().chain(self.start);
        first.find(|value| !value.is_finite()).or_else(|| self.steps.iter().find_map(of_step))
    }
}

impl<const D: usize, const M: usize> Guidance<D, M> {
    /// `|d|^2`.
    #[allow(clippy::inline_always, reason = "used in a dispatched function")]
    #[inline(always)]
    pub(crate) fn square<const USES_AREA: bool>(&self) -> f64 {
        let mut square = 0.0;
        for m in 0..M {
            square += self.brownian[m] * self.brownian[m];
            if USES_AREA {
                square += self.area[m] * self.area[m];
            }
        }
        square
    }
}

/// `phi(b)/Phi(b)` within a relative 1 %.
///
/// A guide needs no more: the weights use the same number. For `a = |b|` the ratio of Mills is
/// `R(a) = pi/(2 a + sqrt((pi - 2)^2 a^2 + 2 pi))` (Boyd 1959, Inequalities for Mills' ratio), which is exact at zero and for large `a`.
#[allow(clippy::inline_always, reason = "used in a dispatched function")]
#[inline(always)]
pub(crate) fn hazard(b: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    const STEEPNESS: f64 = (PI - 2.0) * (PI - 2.0);
    const PEAK: f64 = 0.398_942_280_401_432_7;
    let a = b.abs();
    let over_mills = (2.0 * a + (STEEPNESS * a * a + TAU).sqrt()) / PI;
    let density = PEAK * lanes::exp(-0.5 * a * a);
    let likely = density / (1.0 - density / over_mills);
    if b > 0.0 { likely } else { over_mills }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `1/R(-b)` with the ratio of Mills `R(x)`, the integral of `exp(-x t - t^2/2)` over `t > 0`, by the midpoint rule.
    #[test]
    fn the_hazard_is_that_of_the_normal_distribution_within_one_per_cent() {
        let step = 1e-3;
        for k in -60..=60 {
            let b = 0.1 * f64::from(k);
            let term = |i: i32| {
                let t = (f64::from(i) + 0.5) * step;
                (b * t - 0.5 * t * t).exp()
            };
            let exact = 1.0 / ((0..20_000).map(term).sum::<f64>() * step);
            let off = hazard(b) / exact - 1.0;
            assert!(off.abs() < 0.01, "{b}: {} {exact}", hazard(b));
        }
        assert!((hazard(-1e3) / 1e3 - 1.0).abs() < 1e-5 && hazard(1e3).abs() < f64::MIN_POSITIVE);
    }
}
