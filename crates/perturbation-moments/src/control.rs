//! Control variates with fitted coefficients, from existing samples.

use sde_integrators::{Accumulator, Estimate, Noise, Purpose, Stream, Uncertainty};

use crate::error::{Error, require_finite};

/// Samples of a response together with those of a surrogate of known mean and variance.
///
/// With the regression coefficients $\beta, \gamma$ of `y` on `s` and of $(y - \bar y)^2$ on $(s - \bar s)^2$,
///
/// $$ \bar y_c = \bar y - \beta (\bar s - \operatorname{E} s), \qquad
///    V_c = S_y^2 - \gamma (S_s^2 - \operatorname{Var} s). $$
///
/// The samples are split into halves. Each half uses the coefficients of the other half, so a coefficient is
/// independent of the samples that it corrects, and the results are averaged. Without the split, a fitted coefficient
/// biases small samples and underestimates their errors. Standard errors come from a bootstrap within the halves,
/// including the coefficients.
///
/// In [`MonteCarlo::judge`](crate::MonteCarlo::judge) the coefficient is one. Here a roughly correct surrogate reduces
/// the error too, and a useless one does not increase it.
///
/// Sources: Glasserman 2003, Monte Carlo methods in financial engineering, section 4.1; Efron and Tibshirani 1993, An
/// introduction to the bootstrap.
///
/// ```
/// use perturbation_moments::ControlledSamples;
///
/// // y = 3 s + 1 of a surrogate with mean 0 and variance 1/3: exact, whatever was drawn.
/// let samples: Vec<[f64; 2]> =
///     [0.1, -0.7, 0.4, 0.9, -0.2, -0.6, 0.3, 0.8].iter().map(|s| [3.0 * s + 1.0, *s]).collect();
/// let found = ControlledSamples { samples: &samples, surrogate_mean: 0.0, surrogate_variance: 1.0 / 3.0, seed: 1 };
/// let estimate = found.estimate()?;
/// assert!((estimate.mean.value - 1.0).abs() < 1e-14);
/// assert!((estimate.variance.value - 3.0).abs() < 1e-13);
/// # Ok::<(), perturbation_moments::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlledSamples<'a> {
    /// Response and surrogate of each sample.
    pub samples: &'a [[f64; 2]],
    /// The exact mean of the surrogate.
    pub surrogate_mean: f64,
    /// The exact variance of the surrogate.
    pub surrogate_variance: f64,
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

/// Smallest number of samples for two halves with coefficients.
const FEWEST_SAMPLES: usize = 8;

/// The relative error of the standard error itself is `1/sqrt(2 * 400)`, 4 %.
const N_REPLICATES: u64 = 400;

impl ControlledSamples<'_> {
    /// Mean and unbiased variance of the response samples without the surrogate.
    ///
    /// The error of the variance is that of the mean of $(y - \bar y)^2$.
    ///
    /// # Errors
    /// Those of [`estimate`](Self::estimate).
    pub fn raw(&self) -> Result<SampledMoments, Error> {
        self.check()?;
        let values = || self.samples.iter().map(|[y, _]| *y);
        let (mut plain, mut squares) = (Accumulator::default(), Accumulator::default());
        values().for_each(|y| plain.push(y));
        values().for_each(|y| squares.push((y - plain.mean()).powi(2)));
        let error = |sum: &Accumulator| {
            (sum.variance().unwrap_or(f64::INFINITY) / sum.count() as f64).sqrt()
        };
        Ok(SampledMoments {
            mean: with_error(plain.mean(), error(&plain)),
            variance: with_error(plain.variance().unwrap_or(f64::INFINITY), error(&squares)),
        })
    }

    /// Mean and variance of the response with the control variate.
    ///
    /// # Errors
    /// [`Error::TooFew`] below eight samples; [`Error::NotFinite`] for a moment of the surrogate,
    /// [`Error::NonFiniteSample`] for the lowest such sample of the response or the surrogate.
    pub fn estimate(&self) -> Result<SampledMoments, Error> {
        self.check()?;
        let n = self.samples.len();
        let (first, second) = self.samples.split_at(n / 2);
        let [mean, variance] = self.of_halves(first, second);
        let noise = Noise::new(self.seed);
        let (mut means, mut variances) = (Accumulator::default(), Accumulator::default());
        let (mut drawn, mut others) = (first.to_vec(), second.to_vec());
        for replicate in 0..N_REPLICATES {
            let mut stream = noise.stream(Purpose::Bootstrap, replicate);
            resample(first, &mut drawn, &mut stream);
            resample(second, &mut others, &mut stream);
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

    fn check(&self) -> Result<(), Error> {
        require_finite("mean of the surrogate", 0, self.surrogate_mean)?;
        require_finite("variance of the surrogate", 0, self.surrogate_variance)?;
        let n = self.samples.len();
        if n < FEWEST_SAMPLES {
            let limit = FEWEST_SAMPLES as u64;
            return Err(Error::TooFew { quantity: "samples", value: n as u64, limit });
        }
        for (realisation, sample) in (0..).zip(self.samples) {
            if let Some(&value) = sample.iter().find(|value| !value.is_finite()) {
                return Err(Error::NonFiniteSample { realisation, value });
            }
        }
        Ok(())
    }

    /// Mean and variance, each half with the coefficients of the other.
    fn of_halves(&self, first: &[[f64; 2]], second: &[[f64; 2]]) -> [f64; 2] {
        let (a, b) = (Half::of(first), Half::of(second));
        let weights = [first.len() as f64, second.len() as f64];
        let each = |own: &Half, other: &Half| {
            [
                own.mean[0] - other.mean_coefficient * (own.mean[1] - self.surrogate_mean),
                own.variance[0]
                    - other.variance_coefficient * (own.variance[1] - self.surrogate_variance),
            ]
        };
        let (a, b) = (each(&a, &b), each(&b, &a));
        std::array::from_fn(|k| (weights[0] * a[k] + weights[1] * b[k]) / (weights[0] + weights[1]))
    }
}

/// Moments of a half, of response and surrogate, and its fitted coefficients.
struct Half {
    mean: [f64; 2],
    variance: [f64; 2],
    mean_coefficient: f64,
    variance_coefficient: f64,
}

impl Half {
    fn of(samples: &[[f64; 2]]) -> Self {
        let n = samples.len() as f64;
        let mean: [f64; 2] =
            std::array::from_fn(|k| samples.iter().map(|sample| sample[k]).sum::<f64>() / n);
        let squares: Vec<[f64; 2]> = samples
            .iter()
            .map(|sample| std::array::from_fn(|k| (sample[k] - mean[k]).powi(2)))
            .collect();
        let variance = std::array::from_fn(|k| {
            squares.iter().map(|square| square[k]).sum::<f64>() / (n - 1.0)
        });
        Self {
            mean,
            variance,
            mean_coefficient: slope(samples),
            variance_coefficient: slope(&squares),
        }
    }
}

/// Slope of the regression of the first on the second; zero for a constant second.
fn slope(pairs: &[[f64; 2]]) -> f64 {
    let n = pairs.len() as f64;
    let centre: [f64; 2] =
        std::array::from_fn(|k| pairs.iter().map(|pair| pair[k]).sum::<f64>() / n);
    let (mut covariance, mut variance) = (0.0, 0.0);
    for pair in pairs {
        covariance += (pair[0] - centre[0]) * (pair[1] - centre[1]);
        variance += (pair[1] - centre[1]).powi(2);
    }
    if variance > 0.0 { covariance / variance } else { 0.0 }
}

fn resample(from: &[[f64; 2]], into: &mut [[f64; 2]], stream: &mut Stream) {
    for entry in into {
        // The high word of the product is below the length, and uniform to 1e-16.
        let index = (u128::from(stream.next_u64()) * from.len() as u128) >> 64;
        *entry = from[usize::try_from(index).unwrap_or(0)];
    }
}

pub(crate) fn with_error(value: f64, standard_error: f64) -> Estimate {
    Estimate { value, uncertainty: Uncertainty::StandardError(standard_error) }
}
