//! Monte Carlo reference, raw and with the Taylor surrogate as control variate.

use sde_integrators::{Accumulator, Estimate, Noise, Purpose, Uncertainty, reduce_blocks};

use crate::error::Error;
use crate::moments::Moments;
use crate::random_vector::RandomVector;

/// Sampling of a response.
///
/// Sample `r` is realisation `r` of the noise of the seed, for the purpose [`Purpose::Field`]; it does not depend on
/// the number of threads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MonteCarlo {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of samples, at least two.
    pub n_samples: u64,
}

/// Mean and variance of a response by Monte Carlo, raw and controlled, each with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct Judgement {
    /// Mean of the samples.
    pub raw_mean: Estimate,
    /// Unbiased variance of the samples.
    pub raw_variance: Estimate,
    /// Mean with control variate.
    pub controlled_mean: Estimate,
    /// Variance with control variate.
    pub controlled_variance: Estimate,
    /// Deviation of the surrogate's sampled mean from its exact mean, in standard errors.
    ///
    /// Raw and controlled mean differ by that many standard errors.
    pub surrogate_mean_miss: f64,
    /// The same for the variance.
    pub surrogate_variance_miss: f64,
}

impl Judgement {
    /// Raw over controlled standard error of the mean: the square root of the factor by which samples are saved.
    ///
    /// It is infinite where the surrogate equals the response.
    #[must_use]
    pub fn mean_reduction(&self) -> f64 {
        ratio(&self.raw_mean, &self.controlled_mean)
    }

    /// Raw over controlled standard error of the variance.
    #[must_use]
    pub fn variance_reduction(&self) -> f64 {
        ratio(&self.raw_variance, &self.controlled_variance)
    }
}

impl MonteCarlo {
    /// Independent standard normals of a sample; its inputs are [`RandomVector::point`] of them.
    ///
    /// For responses that a closure cannot compute one by one, `ControlledSamples` of the crate estimators takes the
    /// collected values.
    #[must_use]
    pub fn normals<const N: usize>(&self, realisation: u64) -> [f64; N] {
        normals_of(Noise::new(self.seed), realisation)
    }

    /// Independent standard normals of a sample, as many as fit: the first of them are [`normals`](Self::normals).
    pub fn fill_normals(&self, realisation: u64, normals: &mut [f64]) {
        Noise::new(self.seed).stream(Purpose::Field, realisation).fill_normal(normals);
    }

    /// Samples the response and the quadratic surrogate $s$ of `moments` together.
    ///
    /// $$ \bar y_c = \bar y - \bar s + \operatorname{E} s, \qquad V_c = S_y^2 - S_s^2 + \operatorname{Var} s $$
    ///
    /// with sample means and unbiased sample variances $S^2$. Mean and variance of $s$ are known in closed form, so
    /// both estimates are unbiased for any surrogate. Their standard errors are those of the means of $y - s$ and of
    /// $(y - \bar y)^2 - (s - \bar s)^2$; for heavy tails, such as a pole near the inputs, they are as unreliable as
    /// those of any sample. What none of `n` samples has met is in no error: by the rule of three, with a response one deviation off its
    /// surrogate, $3/n$ of a deviation of the mean. The random numbers are those of `sde-integrators`; 16 bytes are stored per sample.
    ///
    /// Source: Glasserman 2003, Monte Carlo methods in financial engineering, section 4.1, with the coefficient one.
    ///
    /// ```
    /// use perturbation_moments::{Expansion, Moments, MonteCarlo, RandomVector};
    ///
    /// let inputs = RandomVector::independent([0.0], [0.1])?;
    /// let by_hand = Expansion { value: 1.0, gradient: [1.0], hessian: Some([[1.0]]), third: None };
    /// let moments = Moments::new(&inputs, &by_hand)?;
    /// let judge = MonteCarlo { seed: 1, n_samples: 10_000 };
    /// let found = judge.judge(&inputs, &moments, |&[x]| x.exp())?;
    /// let error = found.controlled_mean.value - 0.005_f64.exp();
    /// assert!(error.abs() < 4.0 * found.controlled_mean.standard_error().unwrap());
    /// assert!(found.mean_reduction() > 100.0);
    /// # Ok::<(), perturbation_moments::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::TooFew`] below two samples, [`Error::NonFiniteSample`] with the lowest sample that fails: none is ever
    /// dropped.
    pub fn judge<const N: usize>(
        &self,
        inputs: &RandomVector<N>,
        moments: &Moments<N>,
        response: impl Fn(&[f64; N]) -> f64 + Sync,
    ) -> Result<Judgement, Error> {
        if self.n_samples < 2 {
            return Err(Error::TooFew { quantity: "samples", value: self.n_samples, limit: 2 });
        }
        let noise = Noise::new(self.seed);
        let block = |ids: std::ops::Range<u64>| {
            ids.map(|realisation| {
                let t = normals_of(noise, realisation);
                let value = response(&inputs.point(&t));
                if value.is_finite() {
                    Ok([value, moments.surrogate(&t)])
                } else {
                    Err(Error::NonFiniteSample { realisation, value })
                }
            })
            .collect::<Result<Vec<_>, Error>>()
        };
        let join = |mut earlier: Vec<_>, later: Vec<_>| {
            earlier.extend(later);
            earlier
        };
        let samples = reduce_blocks(self.n_samples, block, join)?.unwrap_or_default();
        Ok(gather(&samples, moments.surrogate_mean(), moments.surrogate_variance()))
    }
}

fn normals_of<const N: usize>(noise: Noise, realisation: u64) -> [f64; N] {
    let mut t = [0.0; N];
    noise.stream(Purpose::Field, realisation).fill_normal(&mut t);
    t
}

fn gather(samples: &[[f64; 2]], mean: f64, variance: f64) -> Judgement {
    let ys = summed(samples.iter().map(|[y, _]| *y));
    let ss = summed(samples.iter().map(|[_, s]| *s));
    let difference = summed(samples.iter().map(|[y, s]| y - s));
    let square = |x: f64, centre: f64| (x - centre) * (x - centre);
    let (y_squares, s_squares, squares_difference) = (
        summed(samples.iter().map(|[y, _]| square(*y, ys.mean))),
        summed(samples.iter().map(|[_, s]| square(*s, ss.mean))),
        summed(samples.iter().map(|[y, s]| square(*y, ys.mean) - square(*s, ss.mean))),
    );
    Judgement {
        raw_mean: with_error(ys.mean, ys.standard_error),
        raw_variance: with_error(ys.variance, y_squares.standard_error),
        controlled_mean: with_error(mean + difference.mean, difference.standard_error),
        controlled_variance: with_error(
            ys.variance - ss.variance + variance,
            squares_difference.standard_error,
        ),
        surrogate_mean_miss: over(ss.mean - mean, ss.standard_error),
        surrogate_variance_miss: over(ss.variance - variance, s_squares.standard_error),
    }
}

/// Mean, unbiased variance and standard error of the mean.
struct Summed {
    mean: f64,
    variance: f64,
    standard_error: f64,
}

fn summed(values: impl Iterator<Item = f64>) -> Summed {
    let mut sum = Accumulator::default();
    values.for_each(|value| sum.push(value));
    let variance = sum.variance().unwrap_or(f64::INFINITY);
    let standard_error = (variance / sum.count() as f64).sqrt();
    Summed { mean: sum.mean(), variance, standard_error }
}

fn with_error(value: f64, standard_error: f64) -> Estimate {
    Estimate { value, uncertainty: Uncertainty::StandardError(standard_error) }
}

fn ratio(raw: &Estimate, controlled: &Estimate) -> f64 {
    match (raw.standard_error(), controlled.standard_error()) {
        (Some(raw), Some(controlled)) if raw > 0.0 => raw / controlled,
        _ => 1.0,
    }
}

/// A deviation in standard errors; zero where both are zero.
fn over(miss: f64, standard_error: f64) -> f64 {
    if miss == 0.0 { 0.0 } else { miss.abs() / standard_error }
}
