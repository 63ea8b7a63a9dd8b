//! Guides of paths: the feedback that shifts the normals of a step.

use crate::error::Error;

/// Largest shift of the normals of a step, in standard deviations.
///
/// Near the end of a guide a path that misses the event has no control left, and its shift would grow without bound.
pub(crate) const LARGEST_SHIFT: f64 = 4.0;

/// A guide of paths: one component of a [`GuidedEnsemble`](crate::GuidedEnsemble).
///
/// The normals of step `k` are shifted by `lambda(b) d_k` with `b = state . x + offset`:
///
/// $$ \lambda(b) = \varphi(b) / \Phi(b), \qquad |\lambda d_k| \le 4 . $$
///
/// Example: a linear response has the expected value `mu(x)` and the standard deviation `s`, given the state at the start
/// of the step. With `b = (mu(x) - T)/s` and the derivatives of the response by the normals over `s` as direction `d`, the
/// shift is the expectation of the normals given that the response exceeds `T`.
///
/// `lambda` is computed every `hold` steps and used until it is computed anew: a guide for many states costs as much as the
/// paths themselves, and its weights are exact for any `hold`.
#[derive(Debug, Clone, PartialEq)]
pub struct Guide {
    /// Probability that a path has this guide (no unit).
    pub share: f64,
    /// Shift of the normals of the start, one for each state (no unit).
    pub start: Vec<f64>,
    /// The step from which the guide acts: the path is free before.
    pub from: usize,
    /// Number of steps for which `lambda` is used, at least 1.
    pub hold: usize,
    /// Level after whose passage the guide ends, by its index; 0 where no level is given.
    pub level: usize,
    /// Coefficients of the states (1 per unit of each) and then the constant term of `b`, for each `hold` steps.
    pub feedback: Vec<f64>,
    /// `d` of each step that is guided: for the normals of the increments `w`, then for those of the areas `H`, which are ignored if the
    /// method does not use them. The path is free after the last one.
    pub directions: Vec<f64>,
}

impl Guide {
    /// Rejects lengths that do not match and numbers that are not finite; `index` is that of the guide.
    pub(crate) fn check(
        &self,
        index: usize,
        (n_states, n_motions, n_levels): (usize, usize, usize),
    ) -> Result<(), Error> {
        let n_steps = self.directions.len() / (2 * n_motions).max(1);
        let lengths = [
            ("shifts of the start in a guide", self.start.len(), n_states),
            ("directions of a guide", self.directions.len(), 2 * n_motions * n_steps),
            (
                "coefficients of the feedback of a guide",
                self.feedback.len(),
                (n_states + 1) * n_steps.div_ceil(self.hold.max(1)),
            ),
        ];
        for (quantity, value, expected) in lengths {
            if value != expected {
                return Err(Error::WrongLength { quantity, value, expected });
            }
        }
        if self.hold == 0 {
            let quantity = "steps for which a guide is held";
            return Err(Error::TooFew { quantity, value: 0, limit: 1 });
        }
        if self.level >= n_levels.max(1) {
            let (value, to) = (self.level as f64, n_levels.max(1) as f64 - 1.0);
            return Err(Error::OutOfRange { quantity: "level of a guide", value, from: 0.0, to });
        }
        let all = self.start.iter().chain(&self.feedback).chain(&self.directions);
        match all.copied().chain([self.share]).find(|value| !value.is_finite()) {
            Some(value) => Err(Error::NotFinite { quantity: "number of guide", index, value }),
            None => Ok(()),
        }
    }

    /// Coefficients of the states and the constant term of `b` at a step, if `lambda` is computed anew there.
    #[allow(clippy::inline_always, reason = "used in a dispatched function")]
    #[inline(always)]
    pub(crate) fn feedback_at(&self, k: usize, n_states: usize) -> Option<(&[f64], f64)> {
        let k = k.checked_sub(self.from)?;
        if !k.is_multiple_of(self.hold) {
            return None;
        }
        let first = k / self.hold * (n_states + 1);
        let (state, offset) = self.feedback[first..=first + n_states].split_at(n_states);
        Some((state, offset[0]))
    }

    /// `d` of a step, unless the guide does not yet act or has ended.
    #[allow(clippy::inline_always, reason = "used in a dispatched function")]
    #[inline(always)]
    pub(crate) fn direction<const M: usize>(&self, k: usize) -> Option<Direction<M>> {
        let k = k.checked_sub(self.from)?;
        let numbers = self.directions.get(2 * M * k..2 * M * (k + 1))?;
        let (brownian, area) = numbers.split_at(M);
        Some(Direction {
            brownian: std::array::from_fn(|m| brownian[m]),
            area: std::array::from_fn(|m| area[m]),
        })
    }
}

/// `d` of one step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Direction<const M: usize> {
    pub(crate) brownian: [f64; M],
    pub(crate) area: [f64; M],
}

impl<const M: usize> Direction<M> {
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
    let density = PEAK * simd_lanes::exp(-0.5 * a * a);
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
