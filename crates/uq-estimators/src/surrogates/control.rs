//! Control variates with fitted coefficients, from existing samples.

use std::cmp::Ordering;

use sde_integrators::{Accumulator, Estimate, Noise, Purpose, Stream, Uncertainty};

use crate::error::{Error, require_at_least, require_finite, require_finite_responses};
use crate::rates::{error_of_variance, with_error};

/// Exact moments of a surrogate: a cheap function of the same random input as the response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surrogate {
    /// Its mean.
    pub mean: f64,
    /// Its variance; none if it is unknown, and then the surrogate controls the mean alone.
    pub variance: Option<f64>,
}

/// Samples of a response together with those of surrogates of known mean.
///
/// With the regression coefficients $\beta$ of `y` on the surrogates $s_k$, and $\gamma$ of $(y - \bar y)^2$ on the
/// $(s_k - \bar s_k)^2$,
///
/// $$ \bar y_c = \bar y - \sum_k \beta_k (\bar s_k - \operatorname{E} s_k), \qquad
///    V_c = S_y^2 - \sum_k \gamma_k (S_k^2 - \operatorname{Var} s_k). $$
///
/// The samples are split into halves. Each half uses the coefficients of the other half, so a coefficient is
/// independent of the samples that it corrects, and the results are averaged. Without the split, a fitted coefficient
/// biases small samples and underestimates their errors. Standard errors come from a bootstrap within the halves,
/// including the coefficients. Of responses that are all equal they are unknown. What none of `n` samples has met, such as yielding, is
/// in no error: by the rule of three, with a response one deviation off its surrogate, $3/n$ of a deviation of the mean.
///
/// A roughly correct surrogate reduces the error, and a useless one hardly increases it. A surrogate that is constant, or
/// a linear combination of those before it within roundoff, takes the coefficient zero.
///
/// Sources: Glasserman 2003, Monte Carlo methods in financial engineering, section 4.1; Efron and Tibshirani 1993, An
/// introduction to the bootstrap.
///
/// ```
/// use uq_estimators::{ControlledSamples, Surrogate};
///
/// // y = 3 s + 1 of a surrogate with mean 0 and variance 1/3: exact, whatever was drawn.
/// let samples: Vec<f64> =
///     [0.1, -0.7, 0.4, 0.9, -0.2, -0.6, 0.3, 0.8].iter().flat_map(|s| [3.0 * s + 1.0, *s]).collect();
/// let surrogates = [Surrogate { mean: 0.0, variance: Some(1.0 / 3.0) }];
/// let found = ControlledSamples { samples: &samples, surrogates: &surrogates, seed: 1 };
/// let estimate = found.estimate()?;
/// assert!((estimate.mean.value - 1.0).abs() < 1e-14);
/// assert!((estimate.variance.value - 3.0).abs() < 1e-13);
/// # Ok::<(), uq_estimators::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlledSamples<'a> {
    /// The samples, row by row: the response, then the surrogates in order.
    pub samples: &'a [f64],
    /// The surrogates; any number of them.
    pub surrogates: &'a [Surrogate],
    /// Seed of the bootstrap.
    pub seed: u64,
}

/// Mean and variance from samples, each with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct SampledMoments {
    /// The mean.
    pub mean: Estimate,
    /// The variance.
    pub variance: Estimate,
}

impl SampledMoments {
    /// Those of values that are all equal, with unknown errors: samples of a rare event that none has met look the same.
    pub(crate) fn of_equal(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values = values.into_iter();
        let first = values.next()?;
        let unknown = |value| Estimate { value, uncertainty: Uncertainty::Unknown };
        let is_equal = values.all(|value| value.partial_cmp(&first).is_some_and(Ordering::is_eq));
        is_equal.then(|| Self { mean: unknown(first), variance: unknown(0.0) })
    }
}

/// Smallest number of samples, for each number of a row: two halves with coefficients.
const FEWEST_SAMPLES: usize = 4;

/// The relative error of the standard error itself is `1/sqrt(2 * 400)`, 4 %.
const N_REPLICATES: u64 = 400;

/// Part of a surrogate's variance that the surrogates before it leave, above which it is not their combination.
const ROUNDOFF: f64 = 1e-12;

impl ControlledSamples<'_> {
    /// Mean and unbiased variance of the response samples without the surrogates.
    ///
    /// The error of the variance is that of the mean of $(y - \bar y)^2$, and of fewer than 64 samples
    /// $\tfrac12 (e^{2 \rho} - 1)$ of the variance, with $\rho$ that error over it and at least $\sqrt{2/(n - 1)}$, as of normal samples:
    /// half the distance to the upper end of the interval of 95 % of its logarithm. Of eight samples it is at least 0.95 of it.
    ///
    /// # Errors
    /// Those of [`estimate`](Self::estimate).
    pub fn raw(&self) -> Result<SampledMoments, Error> {
        self.check()?;
        let values = || self.samples.iter().step_by(self.width());
        if let Some(equal) = SampledMoments::of_equal(values().copied()) {
            return Ok(equal);
        }
        let (mut plain, mut squares) = (Accumulator::default(), Accumulator::default());
        values().for_each(|y| plain.push(*y));
        values().for_each(|y| squares.push((y - plain.mean()).powi(2)));
        let error = |sum: &Accumulator| {
            (sum.variance().unwrap_or(f64::INFINITY) / sum.count() as f64).sqrt()
        };
        let variance = plain.variance().unwrap_or(f64::INFINITY);
        let error_of_squares = error_of_variance(variance, error(&squares), plain.count());
        Ok(SampledMoments {
            mean: with_error(plain.mean(), error(&plain)),
            variance: with_error(variance, error_of_squares),
        })
    }

    /// Mean and variance of the response with the control variates.
    ///
    /// # Errors
    /// [`Error::Length`] for an incomplete row; [`Error::TooFew`] below eight samples, or four for each number of a row;
    /// [`Error::NotFinite`] for a moment of a surrogate, [`Error::NonFiniteSample`] for the lowest sample with such a
    /// response (number 0) or surrogate (numbers from 1).
    pub fn estimate(&self) -> Result<SampledMoments, Error> {
        self.check()?;
        let width = self.width();
        if let Some(equal) = SampledMoments::of_equal(self.samples.iter().step_by(width).copied()) {
            return Ok(equal);
        }
        let half = self.samples.len() / width / 2 * width;
        let (first, second) = self.samples.split_at(half);
        let [mean, variance] = self.of_halves(first, second);
        let noise = Noise::new(self.seed);
        let (mut means, mut variances) = (Accumulator::default(), Accumulator::default());
        let (mut drawn, mut others) = (first.to_vec(), second.to_vec());
        for replicate in 0..N_REPLICATES {
            let mut stream = noise.stream(Purpose::Bootstrap, replicate);
            resample(first, width, &mut drawn, &mut stream);
            resample(second, width, &mut others, &mut stream);
            let [mean, variance] = self.of_halves(&drawn, &others);
            means.push(mean);
            variances.push(variance);
        }
        let scatter = |sum: &Accumulator| sum.variance().unwrap_or(f64::INFINITY).sqrt();
        Ok(SampledMoments {
            mean: with_error(mean, scatter(&means)),
            variance: with_error(variance, scatter(&variances)),
        })
    }

    /// Numbers of a sample.
    const fn width(&self) -> usize {
        1 + self.surrogates.len()
    }

    fn check(&self) -> Result<(), Error> {
        for (index, surrogate) in self.surrogates.iter().enumerate() {
            require_finite("mean of surrogate", index, surrogate.mean)?;
            require_finite("variance of surrogate", index, surrogate.variance.unwrap_or(0.0))?;
        }
        let (value, width) = (self.samples.len(), self.width());
        if !value.is_multiple_of(width) {
            let expected = value / width * width;
            return Err(Error::Length { quantity: "numbers in rows of samples", value, expected });
        }
        let limit = FEWEST_SAMPLES * width.max(2);
        require_at_least("samples", (value / width) as u64, limit as u64)?;
        for (realisation, row) in (0..).zip(self.samples.chunks_exact(width)) {
            require_finite_responses(&"response and surrogates", realisation, row)?;
        }
        Ok(())
    }

    /// Mean and variance, each half with the coefficients of the other.
    fn of_halves(&self, first: &[f64], second: &[f64]) -> [f64; 2] {
        let (a, b) = (self.half(first), self.half(second));
        let weights = [first.len() as f64, second.len() as f64];
        let each = |own: &Half, other: &Half| {
            let (mut mean, mut variance) = (own.mean[0], own.variance[0]);
            for (k, surrogate) in self.surrogates.iter().enumerate() {
                mean -= other.mean_coefficients[k] * (own.mean[1 + k] - surrogate.mean);
                if let Some(exact) = surrogate.variance {
                    variance -= other.variance_coefficients[k] * (own.variance[1 + k] - exact);
                }
            }
            [mean, variance]
        };
        let (a, b) = (each(&a, &b), each(&b, &a));
        std::array::from_fn(|k| (weights[0] * a[k] + weights[1] * b[k]) / (weights[0] + weights[1]))
    }

    fn half(&self, samples: &[f64]) -> Half {
        let width = self.width();
        let n = (samples.len() / width) as f64;
        let means_of = |rows: &[f64]| -> Vec<f64> {
            (0..width).map(|k| rows.iter().skip(k).step_by(width).sum::<f64>() / n).collect()
        };
        let mean = means_of(samples);
        let square = |(place, x): (usize, &f64)| (x - mean[place % width]).powi(2);
        let squares: Vec<f64> = samples.iter().enumerate().map(square).collect();
        let variance = (0..width)
            .map(|k| squares.iter().skip(k).step_by(width).sum::<f64>() / (n - 1.0))
            .collect();
        let is_known = |k: usize| self.surrogates[k].variance.is_some();
        let mean_coefficients = coefficients(samples, &mean, |_| true);
        let variance_coefficients = coefficients(&squares, &means_of(&squares), is_known);
        Half { mean, variance, mean_coefficients, variance_coefficients }
    }
}

/// Moments of a half, of response and surrogates, and its fitted coefficients.
struct Half {
    mean: Vec<f64>,
    variance: Vec<f64>,
    mean_coefficients: Vec<f64>,
    variance_coefficients: Vec<f64>,
}

/// Coefficients of the regression of the first column on the others, zero for those not `used`.
///
/// The equations of normal form by elimination in order, `A = L D L^T`; a pivot within roundoff takes the coefficient
/// zero.
pub(crate) fn coefficients(rows: &[f64], centre: &[f64], used: impl Fn(usize) -> bool) -> Vec<f64> {
    let width = centre.len();
    let n = width - 1;
    let (mut matrix, mut right) = (vec![0.0; n * n], vec![0.0; n]);
    for row in rows.chunks_exact(width) {
        for i in 0..n {
            let distance = row[1 + i] - centre[1 + i];
            right[i] += (row[0] - centre[0]) * distance;
            for j in 0..=i {
                matrix[i * n + j] += distance * (row[1 + j] - centre[1 + j]);
            }
        }
    }
    let diagonal: Vec<f64> = (0..n).map(|i| matrix[i * n + i]).collect();
    let is_in = |i: usize, pivot: f64| used(i) && pivot > ROUNDOFF * diagonal[i];
    for k in 0..n {
        let pivot = matrix[k * n + k];
        if !is_in(k, pivot) {
            continue;
        }
        for i in k + 1..n {
            let factor = matrix[i * n + k] / pivot;
            for j in k + 1..=i {
                matrix[i * n + j] -= factor * matrix[j * n + k];
            }
            right[i] -= factor * right[k];
        }
    }
    let mut solution = vec![0.0; n];
    for k in (0..n).rev() {
        let pivot = matrix[k * n + k];
        if is_in(k, pivot) {
            let rest: f64 = (k + 1..n).map(|i| matrix[i * n + k] * solution[i]).sum();
            solution[k] = (right[k] - rest) / pivot;
        }
    }
    solution
}

fn resample(from: &[f64], width: usize, into: &mut [f64], stream: &mut Stream) {
    let n_rows = from.len() / width;
    for row in into.chunks_exact_mut(width) {
        // The high word of the product is below the length, and uniform to 1e-16.
        let index = (u128::from(stream.next_u64()) * n_rows as u128) >> 64;
        let place = width * usize::try_from(index).unwrap_or(0);
        row.copy_from_slice(&from[place..place + width]);
    }
}
