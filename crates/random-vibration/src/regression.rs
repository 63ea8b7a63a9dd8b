//! Linear regressions of the drift along the running normal distribution, under several strengths.

use sde_integrators::{Additive, GaussianMixture, Sde};

use crate::cholesky::cholesky;
use crate::linearisation::{Closure, GaussianLaw, Linearisation, LinearisationError};

/// Nodes on either side of a kink: fewer than for moments, because a guide needs two digits alone.
const HALF_NODES: usize = 10;

/// `f(x) ~ slope x + constant` at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Regression<const D: usize> {
    pub(crate) slope: [[f64; D]; D],
    pub(crate) constant: [f64; D],
}

/// Regressions at equally spaced times from 0 on.
#[derive(Debug, Clone)]
pub(crate) struct Regressions<const D: usize> {
    /// Distance of the times.
    spacing: f64,
    /// The running normal distribution of the linearisation at each time.
    pub(crate) laws: Vec<GaussianLaw<D>>,
    /// Per strength, per time.
    of_strength: Vec<Vec<Regression<D>>>,
}

impl<const D: usize> Regressions<D> {
    /// Regressions up to a time.
    ///
    /// Strength `kappa` takes the expectations under `kappa` times the deviations of the running distribution: paths that
    /// reach a rare event are further out than most.
    ///
    /// A step at which the covariance fails is halved, five times at most.
    pub(crate) fn new<const M: usize>(
        rule: &Linearisation<D>,
        system: &dyn Sde<D, M, Noise = Additive>,
        start: &GaussianMixture<D>,
        time: f64,
        strengths: &[f64],
    ) -> Result<Self, LinearisationError> {
        let mut rule = *rule;
        for _ in 0..5 {
            match Self::of_step(&rule, system, start, time, strengths) {
                Err(LinearisationError::NotACovariance { .. }) => rule.step *= 0.5,
                other => return other,
            }
        }
        Self::of_step(&rule, system, start, time, strengths)
    }

    fn of_step<const M: usize>(
        rule: &Linearisation<D>,
        system: &dyn Sde<D, M, Noise = Additive>,
        start: &GaussianMixture<D>,
        time: f64,
        strengths: &[f64],
    ) -> Result<Self, LinearisationError> {
        let closure = rule.closure(system, HALF_NODES)?;
        let intervals = (time / rule.step).ceil().max(1.0);
        let spacing = time / intervals;
        let mut now = GaussianLaw { t: 0.0, mean: start.mean(), covariance: start.covariance() };
        let mut laws = Vec::new();
        let mut of_strength = vec![Vec::new(); strengths.len()];
        let mut done = 0.0;
        loop {
            now.t = done * spacing;
            laws.push(now);
            for (strength, regressions) in strengths.iter().zip(&mut of_strength) {
                regressions.push(regression(&closure, &now, *strength)?);
            }
            if done >= intervals {
                return Ok(Self { spacing, laws, of_strength });
            }
            now = closure.stepped(&now, spacing)?;
            done += 1.0;
        }
    }

    /// The regression of a strength at a time, linearly interpolated.
    pub(crate) fn at(&self, strength: usize, t: f64) -> Regression<D> {
        let regressions = &self.of_strength[strength];
        let (before, part) = self.place(t);
        let (a, b) = (&regressions[before], &regressions[before + 1]);
        let between = |a: f64, b: f64| a + part * (b - a);
        Regression {
            slope: std::array::from_fn(|i| {
                std::array::from_fn(|j| between(a.slope[i][j], b.slope[i][j]))
            }),
            constant: std::array::from_fn(|i| between(a.constant[i], b.constant[i])),
        }
    }

    /// The running normal distribution at the start of the interval that contains a time.
    pub(crate) fn law_at(&self, t: f64) -> &GaussianLaw<D> {
        &self.laws[self.place(t).0]
    }

    /// The interval that contains a time, and the part of it before the time.
    fn place(&self, t: f64) -> (usize, f64) {
        let place = t / self.spacing;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a number of intervals, and a cast saturates"
        )]
        let before = (place as usize).min(self.laws.len() - 2);
        (before, place - before as f64)
    }
}

fn regression<const D: usize, const M: usize>(
    closure: &Closure<'_, D, M>,
    law: &GaussianLaw<D>,
    strength: f64,
) -> Result<Regression<D>, LinearisationError> {
    let square = strength * strength;
    let covariance = law.covariance.map(|row| row.map(|entry| square * entry));
    let wide = GaussianLaw { covariance, ..*law };
    let expectations = closure.expectations(&wide)?;
    let factor = cholesky(&covariance).map_err(|(state, value)| {
        LinearisationError::NotACovariance { time: law.t, state, value }
    })?;
    let slope = expectations.products.map(|row| solve(&factor, row));
    let constant = std::array::from_fn(|i| {
        let linear: f64 = slope[i].iter().zip(&law.mean).map(|(a, m)| a * m).sum();
        expectations.drift[i] - linear
    });
    Ok(Regression { slope, constant })
}

/// The `y` with `L L^T y = x`.
fn solve<const D: usize>(factor: &[[f64; D]; D], x: [f64; D]) -> [f64; D] {
    let mut y = x;
    for i in 0..D {
        let known: f64 = (0..i).map(|j| factor[i][j] * y[j]).sum();
        y[i] = (y[i] - known) / factor[i][i];
    }
    for i in (0..D).rev() {
        let known: f64 = (i + 1..D).map(|j| factor[j][i] * y[j]).sum();
        y[i] = (y[i] - known) / factor[i][i];
    }
    y
}
