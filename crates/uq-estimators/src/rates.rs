//! Rates over the levels: of variances, and of means for the bias.

use sde_integrators::{Accumulator, Estimate, Uncertainty};

/// What is known of the bias of the finest level.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Bias {
    /// The finest level of the ladder is the truth; all levels are used.
    FinestIsExact,
    /// The bias of level `l` decreases as `2^(-order l)`.
    Order(f64),
    /// The same, with the order fitted to the means of the differences; at least 0.5 is taken, as by Giles 2015.
    FittedOrder,
}

impl Bias {
    /// Part of the squared tolerance that is for the variance of the estimate.
    pub(crate) const fn share_of_variance(self) -> f64 {
        match self {
            Self::FinestIsExact => 1.0,
            Self::Order(_) | Self::FittedOrder => 0.5,
        }
    }
}

pub(crate) const fn with_error(value: f64, standard_error: f64) -> Estimate {
    Estimate { value, uncertainty: Uncertainty::StandardError(standard_error) }
}

/// Mean square about the mean.
pub(crate) fn mean_square(sum: &Accumulator) -> f64 {
    let n = sum.count() as f64;
    sum.variance().unwrap_or(f64::INFINITY) * ((n - 1.0) / n)
}

/// Mean over independent replicas, with the standard error from their scatter.
pub(crate) fn of_replicas(sum: &Accumulator) -> Estimate {
    let variance = sum.variance().unwrap_or(f64::INFINITY);
    with_error(sum.mean(), (variance / sum.count() as f64).sqrt())
}

/// Error of a variance, or of another mean of squares, of `n` samples with this standard error: of few half the distance to the upper
/// end of the interval of 95 % of its logarithm, with the relative error $\rho$ at least $\sqrt{2/(n - 1)}$, as of a normal response,
///
/// $$ \tfrac12 (e^{2 \rho} - 1) . $$
///
/// Few samples that lie close together have a small variance and a small scatter of its terms. The scatter of [`MANY`] is their own.
pub(crate) fn error_of_variance(variance: f64, standard_error: f64, n: u64) -> f64 {
    if n >= MANY || variance.is_nan() || variance <= 0.0 {
        return standard_error;
    }
    let relative = (standard_error / variance).max((2.0 / (n as f64 - 1.0)).sqrt());
    0.5 * variance * (2.0 * relative).exp_m1()
}

/// Samples from which the scatter of their squares is known to a quarter where they are normal.
const MANY: u64 = 64;

/// An estimate from all of the data and without each part of it: the delete-one jackknife, which removes the bias of first order.
pub(crate) fn jackknife(whole: f64, left_out: &[f64]) -> Estimate {
    let n = left_out.len() as f64;
    let mean = left_out.iter().sum::<f64>() / n;
    let squares: f64 = left_out.iter().map(|value| (value - mean).powi(2)).sum();
    with_error(n * whole - (n - 1.0) * mean, (squares * (n - 1.0) / n).sqrt())
}

/// Smallest rate that is taken from a fit, per level and in powers of two: Giles 2015, section 3.
const LEAST_RATE: f64 = 0.5;

/// Variances of the differences, each at least half of what the fitted rate predicts from the level below.
///
/// $$ V_l \ge \tfrac12 2^{-\beta} V_{l-1}, \qquad l \ge 2 . $$
pub(crate) fn floored(mut variances: Vec<f64>) -> Vec<f64> {
    let points: Vec<[f64; 3]> = (0..)
        .zip(&variances)
        .skip(1)
        .filter(|(_, variance)| **variance > 0.0)
        .map(|(level, variance)| [f64::from(level), variance.log2(), 1.0])
        .collect();
    if let Some((slope, _)) = line(&points) {
        let rate = (-slope).max(LEAST_RATE);
        for level in 2..variances.len() {
            let floor = 0.5 * variances[level - 1] * (-rate).exp2();
            if variances[level] < floor {
                variances[level] = floor;
            }
        }
    }
    variances
}

/// Slope of a weighted line through points `(x, y, weight)`, with its standard error for weights that are inverse
/// squared errors; none for fewer than two places.
fn line(points: &[[f64; 3]]) -> Option<(f64, f64)> {
    let sum = |f: &dyn Fn(&[f64; 3]) -> f64| points.iter().map(f).sum::<f64>();
    let weight = sum(&|p| p[2]);
    let (x, y) = (sum(&|p| p[2] * p[0]) / weight, sum(&|p| p[2] * p[1]) / weight);
    let squares = sum(&|p| p[2] * (p[0] - x) * (p[0] - x));
    let products = sum(&|p| p[2] * (p[0] - x) * (p[1] - y));
    (points.len() > 1 && squares > 0.0).then(|| (products / squares, squares.recip().sqrt()))
}

/// Bias of the finest level.
pub(crate) struct Extrapolated {
    /// The true value less that of the finest level.
    pub(crate) estimate: Estimate,
    /// Largest magnitude that the three finest differences predict.
    pub(crate) bound: f64,
    /// The weak order.
    pub(crate) order: Option<Estimate>,
}

/// Extrapolates means of differences with their errors, from level 1 on.
///
/// With the rate $\alpha$ the sum of all further differences is $m_L / (2^\alpha - 1)$.
pub(crate) fn extrapolated(bias: Bias, differences: &[[f64; 2]]) -> Extrapolated {
    let order = match bias {
        Bias::FinestIsExact => {
            return Extrapolated { estimate: with_error(0.0, 0.0), bound: 0.0, order: None };
        }
        Bias::Order(order) => with_error(order, 0.0),
        Bias::FittedOrder => fitted_order(differences),
    };
    let rest = |mean: f64, levels_below: usize| {
        mean * (-order.value * levels_below as f64).exp2() / (order.value.exp2() - 1.0)
    };
    let finest = differences.last().copied().unwrap_or([f64::NAN; 2]);
    let bound = differences
        .iter()
        .rev()
        .take(3)
        .enumerate()
        .map(|(below, difference)| rest(difference[0], below).abs())
        .fold(
            0.0,
            |largest: f64, value| {
                if value.is_nan() || value > largest { value } else { largest }
            },
        );
    let estimate = with_error(rest(finest[0], 0), rest(finest[1], 0));
    Extrapolated { estimate, bound, order: Some(order) }
}

/// Rate at which the means decrease, weighted by their relative errors; at least [`LEAST_RATE`].
fn fitted_order(differences: &[[f64; 2]]) -> Estimate {
    let points: Vec<[f64; 3]> = (1..)
        .zip(differences)
        .filter(|(_, [mean, _])| *mean != 0.0)
        .map(|(level, [mean, error])| {
            // The error of log2 m; roundoff is the least that a mean has.
            let relative = (error / mean).abs().max(f64::EPSILON) / std::f64::consts::LN_2;
            [f64::from(level), mean.abs().log2(), relative.powi(-2)]
        })
        .collect();
    match line(&points) {
        Some((slope, error)) => with_error((-slope).max(LEAST_RATE), error),
        None => Estimate { value: LEAST_RATE, uncertainty: Uncertainty::Unknown },
    }
}
