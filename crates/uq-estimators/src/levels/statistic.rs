//! What is estimated of a response.

use crate::comoments::Comoments;
use crate::error::{Error, require_finite, require_positive};

/// A statistic of one response.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Statistic {
    /// Its mean.
    Mean,
    /// Its variance.
    ///
    /// Sampled as the variance on the coarsest level and the differences of the variances of neighbouring levels. Each is about
    /// the mean of its level in the same samples, so that a shift of the response from level to level costs nothing. The
    /// standard error is that of the means of $(y_l - E y_l)^2 - (y_{l-1} - E y_{l-1})^2$.
    ///
    /// Source: Krumscheid, Nobile and Pisaroni 2020, Quantifying uncertain system outputs via the multilevel Monte Carlo method,
    /// part I, section 2.
    Variance,
    /// The probability that it exceeds a threshold, $E\, 1_{y > T}$.
    ///
    /// The indicator differs by one between two levels on either side of the threshold, so its differences have a large
    /// variance: [`SmoothedExceedance`](Self::SmoothedExceedance) is cheaper wherever the response has a density.
    Exceedance {
        /// The threshold `T`, in the unit of the response.
        threshold: f64,
    },
    /// The same with a smoothed indicator,
    ///
    /// $$ P(y > T) \approx E\, g((y - T) / \delta), \qquad
    ///    g(s) = \tfrac12 + \tfrac18 (9 s - 5 s^3) \text{ for } \lvert s \rvert < 1 , $$
    ///
    /// 0 below and 1 above. Its first three moments are those of the step, so the error is $O(\delta^4)$ for a density
    /// with three derivatives. A third of the difference to $2 \delta$ is reported as the error of smoothing, which
    /// holds if it decreases as $\delta^2$ or faster, as for every density with a bounded derivative.
    ///
    /// Source: Giles, Nagapetyan and Ritter 2015, Multilevel Monte Carlo approximation of distribution functions and
    /// densities, section 2 (their $g$ for $r = 3$, mirrored).
    SmoothedExceedance {
        /// The threshold `T`, in the unit of the response.
        threshold: f64,
        /// The width `delta`, in the unit of the response.
        width: f64,
    },
}

/// Root mean square error asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Tolerance {
    /// In the unit of the statistic.
    Absolute(f64),
    /// A part of the statistic, as it is estimated from the samples so far; of a mean, of the larger of its magnitude and the
    /// standard deviation of the response. What does not vary asks for no sample.
    Relative(f64),
    /// None: the statistic is estimated from the samples that others need.
    Open,
}

impl Tolerance {
    /// In the unit of a statistic of this magnitude; infinite where nothing is asked.
    pub(crate) const fn of(self, magnitude: f64) -> f64 {
        match self {
            Self::Absolute(tolerance) => tolerance,
            Self::Relative(part) => part * magnitude,
            Self::Open => f64::INFINITY,
        }
    }

    fn check(self, index: usize) -> Result<(), Error> {
        match self {
            Self::Absolute(value) | Self::Relative(value) => {
                require_positive("tolerance", index, value)
            }
            Self::Open => Ok(()),
        }
    }
}

/// A statistic of a response, with its tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Target {
    /// Index of the response.
    pub response: usize,
    /// The statistic.
    pub statistic: Statistic,
    /// Root mean square error asked for.
    pub tolerance: Tolerance,
}

/// Numbers of a sample that a target needs.
pub(crate) const COMPONENTS: usize = 2;

impl Target {
    pub(crate) fn check(&self, index: usize, n_responses: usize) -> Result<(), Error> {
        self.tolerance.check(index)?;
        if self.response >= n_responses {
            let (response, limit) = (self.response, n_responses);
            return Err(Error::NoSuchResponse { target: index, response, limit });
        }
        match self.statistic {
            Statistic::Mean | Statistic::Variance => Ok(()),
            Statistic::Exceedance { threshold } => require_finite("threshold", index, threshold),
            Statistic::SmoothedExceedance { threshold, width } => {
                require_finite("threshold", index, threshold)?;
                require_positive("smoothing width", index, width)
            }
        }
    }

    /// The components of a response `y`, with `c` near its mean; the second is zero where there is none.
    pub(crate) fn components(&self, y: f64, c: f64) -> [f64; COMPONENTS] {
        match self.statistic {
            Statistic::Mean => [y, 0.0],
            Statistic::Variance => [y - c, (y - c) * (y - c)],
            Statistic::Exceedance { threshold } => [f64::from(u8::from(y > threshold)), 0.0],
            Statistic::SmoothedExceedance { threshold, width } => {
                [step((y - threshold) / width), step((y - threshold) / (2.0 * width))]
            }
        }
    }

    /// What a relative tolerance is a part of: from the statistic as estimated, and the standard deviation of the response on the
    /// finest level. None for a variance that comes out negative.
    pub(crate) fn magnitude(&self, value: f64, deviation: f64, n_samples: u64) -> Option<f64> {
        match self.statistic {
            Statistic::Mean => Some(value.abs().max(deviation)),
            Statistic::Variance => Some(value).filter(|variance| *variance >= 0.0),
            Statistic::Exceedance { .. } | Statistic::SmoothedExceedance { .. } => {
                Some(value.max(1.0 / n_samples as f64))
            }
        }
    }

    /// Error of smoothing, from the means of the components.
    pub(crate) fn smoothing(&self, means: [f64; COMPONENTS]) -> f64 {
        match self.statistic {
            Statistic::SmoothedExceedance { .. } => (means[1] - means[0]).abs() / 3.0,
            Statistic::Mean | Statistic::Variance | Statistic::Exceedance { .. } => 0.0,
        }
    }
}

/// The smoothed step of Giles, Nagapetyan and Ritter.
fn step(s: f64) -> f64 {
    if s <= -1.0 {
        0.0
    } else if s >= 1.0 {
        1.0
    } else {
        0.5 + 0.125 * s * (9.0 - 5.0 * s * s)
    }
}

/// Means and variances of a target over the samples of one pair.
///
/// A variance is the difference of those of both levels, each about its own mean: a shift of the response from level to level
/// does not scatter it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TargetSums<'a> {
    /// Components of the difference, then those of the finer level.
    pub(crate) sums: &'a Comoments,
    /// Whether the statistic is a variance.
    pub(crate) is_variance: bool,
}

/// Places of the components in the sums of a target.
const DIFFERENCE: usize = 0;
const FINE: usize = COMPONENTS;

impl TargetSums<'_> {
    /// Means of the components of the difference.
    pub(crate) fn difference_means(self) -> [f64; COMPONENTS] {
        [self.sums.mean(DIFFERENCE), self.sums.mean(DIFFERENCE + 1)]
    }

    /// Means of the components of the finer level.
    pub(crate) fn fine_means(self) -> [f64; COMPONENTS] {
        [self.sums.mean(FINE), self.sums.mean(FINE + 1)]
    }

    /// The statistic on the finer level.
    pub(crate) fn fine_value(self) -> f64 {
        if self.is_variance { self.sums.variance(FINE) } else { self.sums.mean(FINE) }
    }

    /// Its difference to that on the coarser level, which is zero where there is none.
    pub(crate) fn difference_value(self) -> f64 {
        if self.is_variance {
            // Var F - Var (F - D)
            2.0 * self.sums.covariance(FINE, DIFFERENCE) - self.sums.variance(DIFFERENCE)
        } else {
            self.sums.mean(DIFFERENCE)
        }
    }

    /// Standard deviation of the first component of the finer level.
    pub(crate) fn fine_deviation(self) -> f64 {
        self.sums.variance(FINE).sqrt()
    }

    /// Variance of a sample of the statistic's difference: `n` times the squared standard error of their mean.
    pub(crate) fn difference_variance(self) -> f64 {
        let [fine, difference] = [self.fine_means(), self.difference_means()];
        let of_fine = self.influence(fine[0]);
        let of_coarse = self.influence(fine[0] - difference[0]);
        // w_f F - w_c C with C = F - D.
        let more: [f64; COMPONENTS] = std::array::from_fn(|c| of_fine[c] - of_coarse[c]);
        self.variance([of_coarse, more])
    }

    /// The same of the finer level alone.
    pub(crate) fn fine_variance(self) -> f64 {
        self.variance([[0.0; COMPONENTS], self.influence(self.fine_means()[0])])
    }

    /// Variances of a component of both levels: of the finer, of the coarser.
    pub(crate) fn component_variances(self, component: usize) -> [f64; 2] {
        let mut unit = [0.0; COMPONENTS];
        unit[component] = 1.0;
        let minus = unit.map(|weight: f64| -weight);
        [self.variance([[0.0; COMPONENTS], unit]), self.variance([minus, unit])]
    }

    /// Weights of the components of a level in the influence function, by the mean of the first.
    fn influence(self, mean: f64) -> [f64; COMPONENTS] {
        if self.is_variance { [-2.0 * mean, 1.0] } else { [1.0, 0.0] }
    }

    /// Variance of a combination of the components of the difference and of the finer level.
    fn variance(self, weights: [[f64; COMPONENTS]; 2]) -> f64 {
        let w = weights.as_flattened();
        let mut sum = 0.0;
        for (i, a) in w.iter().enumerate() {
            for (j, b) in w.iter().enumerate() {
                sum += a * b * self.sums.covariance(i, j);
            }
        }
        sum.max(0.0)
    }
}
