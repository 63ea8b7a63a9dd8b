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
    /// Sampled as $E z - (E (y - c))^2$ with $z = (y - c)^2$ and a fixed $c$ near the mean; the standard error is that of
    /// the mean of the influence function $z - 2 d y$ with $d = E y - c$.
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

    /// Weights of the components in the influence function, for the estimated means of the components.
    pub(crate) fn influence(&self, means: [f64; COMPONENTS]) -> [f64; COMPONENTS] {
        match self.statistic {
            Statistic::Variance => [-2.0 * means[0], 1.0],
            Statistic::Mean
            | Statistic::Exceedance { .. }
            | Statistic::SmoothedExceedance { .. } => [1.0, 0.0],
        }
    }

    /// The statistic from the means of the components and the squared standard error of the first.
    pub(crate) fn value(&self, means: [f64; COMPONENTS], first_squared_error: f64) -> f64 {
        match self.statistic {
            // E mean^2 = (E mean)^2 + its variance.
            Statistic::Variance => means[1] - means[0] * means[0] + first_squared_error,
            Statistic::Mean
            | Statistic::Exceedance { .. }
            | Statistic::SmoothedExceedance { .. } => means[0],
        }
    }

    /// What a relative tolerance is a part of: from the means of the components of the finest level, and the variance of the
    /// first. None for a variance that comes out negative.
    pub(crate) fn magnitude(
        &self,
        means: [f64; COMPONENTS],
        first_variance: f64,
        n_samples: u64,
    ) -> Option<f64> {
        match self.statistic {
            Statistic::Mean => Some(means[0].abs().max(first_variance.sqrt())),
            Statistic::Variance => {
                Some(means[1] - means[0] * means[0]).filter(|variance| *variance >= 0.0)
            }
            Statistic::Exceedance { .. } | Statistic::SmoothedExceedance { .. } => {
                Some(means[0].max(1.0 / n_samples as f64))
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
#[derive(Debug, Clone, Copy)]
pub(crate) struct TargetSums<'a> {
    /// Components of the difference, then those of the finer level.
    pub(crate) sums: &'a Comoments,
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

    /// Variance of the first component of the difference.
    pub(crate) fn first_difference_variance(self) -> f64 {
        self.sums.variance(DIFFERENCE)
    }

    /// The same of the finer level.
    pub(crate) fn first_fine_variance(self) -> f64 {
        self.sums.variance(FINE)
    }

    /// Variance of a combination of the components, of the difference.
    pub(crate) fn difference_variance(self, weights: [f64; COMPONENTS]) -> f64 {
        self.variance(DIFFERENCE, DIFFERENCE, weights)
    }

    /// The same of the finer level.
    pub(crate) fn fine_variance(self, weights: [f64; COMPONENTS]) -> f64 {
        self.variance(FINE, FINE, weights)
    }

    /// The same of the coarser level, the finer one less the difference.
    pub(crate) fn coarse_variance(self, weights: [f64; COMPONENTS]) -> f64 {
        let cross = self.variance(FINE, DIFFERENCE, weights);
        (self.fine_variance(weights) - 2.0 * cross + self.difference_variance(weights)).max(0.0)
    }

    fn variance(self, a: usize, b: usize, w: [f64; COMPONENTS]) -> f64 {
        let mut sum = 0.0;
        for i in 0..COMPONENTS {
            for j in 0..COMPONENTS {
                sum += w[i] * w[j] * self.sums.covariance(a + i, b + j);
            }
        }
        if a == b && sum < 0.0 { 0.0 } else { sum }
    }
}
