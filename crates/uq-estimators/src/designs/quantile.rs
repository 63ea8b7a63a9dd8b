//! Quantiles of samples and of replicas of a design.

use sde_integrators::{Accumulator, Estimate};

use crate::designs::cube::UnitCube;
use crate::designs::points::check_points;
use crate::error::{Error, require_at_least, require_finite};
use crate::rates::of_replicas;

/// A quantile of independent samples, with an interval that holds for any continuous distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct QuantileInterval {
    /// The sample with the number `n p`, rounded up, in increasing order.
    pub value: f64,
    /// The interval between two samples.
    pub interval: [f64; 2],
    /// Probability that the interval holds the quantile, at least what was asked for; exact for a continuous distribution.
    pub confidence: f64,
}

/// The quantile of the probability `p` of independent samples, in any order.
///
/// With the samples in increasing order, $y_{(r)} \le y_{(s)}$ hold the quantile between them with the probability
///
/// $$ P(r \le K < s) = \sum_{k=r}^{s-1} \binom nk p^k (1-p)^{n-k} , $$
///
/// for any continuous distribution, and at least that for others. Of each side at most half of the error is given: $r$ is the
/// largest and $s$ the smallest with $P(K < r), P(K \ge s) \le (1 - c)/2$ for the confidence `c`.
///
/// Source: David and Nagaraja 2003, Order Statistics, section 7.1.
///
/// ```
/// let samples: Vec<f64> = (1..=100).map(f64::from).collect();
/// let median = uq_estimators::quantile(&samples, 0.5, 0.95)?;
/// assert_eq!((median.value, median.interval), (50.0, [40.0, 61.0]));
/// # Ok::<(), uq_estimators::Error>(())
/// ```
///
/// # Errors
/// [`Error::OutsideOpenInterval`] for a probability or confidence not between zero and one; [`Error::NotFinite`] for a sample;
/// [`Error::TooFew`] where no two samples hold the quantile with this confidence, with how many do.
pub fn quantile(samples: &[f64], p: f64, confidence: f64) -> Result<QuantileInterval, Error> {
    require_inside("probability of the quantile", p)?;
    require_inside("confidence", confidence)?;
    for (index, &value) in samples.iter().enumerate() {
        require_finite("sample", index, value)?;
    }
    let n = samples.len();
    let side = 0.5 * (1.0 - confidence);
    // The extremes miss the quantile with probabilities (1 - p)^n and p^n.
    let limit = (side.ln() / p.max(1.0 - p).ln()).ceil();
    let value = n as u64;
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive; a larger number saturates"
    )]
    require_at_least("samples for this confidence", value, limit.max(1.0) as u64)?;
    let masses = binomial(n, p);
    let mut below = 0.0;
    let mut lower = 0;
    while below + masses[lower] <= side {
        below += masses[lower];
        lower += 1;
    }
    let mut above = 0.0;
    let mut upper = n;
    while above + masses[upper] <= side {
        above += masses[upper];
        upper -= 1;
    }
    // Samples count from one: `r` is the number of masses below, `s` one more than the largest count that is held.
    let missing =
        Error::TooFew { quantity: "samples for this confidence", value, limit: value + 1 };
    if lower == 0 || upper == n {
        return Err(missing);
    }
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    Ok(QuantileInterval {
        value: sorted[place(n, p)],
        interval: [sorted[lower - 1], sorted[upper]],
        confidence: 1.0 - below - above,
    })
}

/// Index of the sample with the number `n p`, rounded up.
fn place(n: usize, p: f64) -> usize {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and n, which is a length"
    )]
    let number = (n as f64 * p).ceil() as usize;
    number.clamp(1, n) - 1
}

/// Probabilities of the binomial distribution, from its mode by ratios of neighbours; those below roundoff may be zero.
fn binomial(n: usize, p: f64) -> Vec<f64> {
    let mode = place(n + 1, p).min(n);
    let mut masses = vec![0.0; n + 1];
    masses[mode] = 1.0;
    let odds = p / (1.0 - p);
    for k in mode..n {
        masses[k + 1] = masses[k] * odds * (n - k) as f64 / (k + 1) as f64;
    }
    for k in (0..mode).rev() {
        masses[k] = masses[k + 1] / odds * (k + 1) as f64 / (n - k) as f64;
    }
    let sum: f64 = masses.iter().sum();
    for mass in &mut masses {
        *mass /= sum;
    }
    masses
}

impl UnitCube {
    /// The quantile of the probability `p` of a response, from its values in all [`runs`](Self::runs).
    ///
    /// The value is the quantile of all points together, the standard error the scatter of the quantiles of the replicas over the
    /// root of their number. A quantile of `m` points has a bias of the order of `1/m`, which the scatter does not show; for
    /// all points together it is smaller by the number of replicas.
    ///
    /// # Errors
    /// [`Error::OutsideOpenInterval`] for the probability; [`Error::TooFew`] where a replica has fewer than ten points on either
    /// side of the quantile; [`Error::Length`], [`Error::NotFinite`] for the values; those of [`runs`](Self::runs).
    pub fn quantile_of_runs(&self, values: &[f64], p: f64) -> Result<Estimate, Error> {
        check_points(self.sampling, self.n_points, self.n_replicas)?;
        require_inside("probability of the quantile", p)?;
        let limit = FEWEST_BESIDE / p.min(1.0 - p);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive; a larger number saturates"
        )]
        require_at_least("points of a replica", self.n_points, limit.ceil() as u64)?;
        let expected = usize::try_from(self.n_points.saturating_mul(self.n_replicas));
        let (value, expected) = (values.len(), expected.unwrap_or(usize::MAX));
        if value != expected {
            return Err(Error::Length { quantity: "values of all runs", value, expected });
        }
        for (index, &value) in values.iter().enumerate() {
            require_finite("value of run", index, value)?;
        }
        let of = |mut values: Vec<f64>| {
            let place = place(values.len(), p);
            *values.select_nth_unstable_by(place, f64::total_cmp).1
        };
        let n_replicas = usize::try_from(self.n_replicas).unwrap_or(usize::MAX);
        let mut replicas = Accumulator::default();
        for replica in 0..n_replicas {
            replicas.push(of(values.iter().skip(replica).step_by(n_replicas).copied().collect()));
        }
        Ok(Estimate { value: of(values.to_vec()), ..of_replicas(&replicas) })
    }
}

/// Fewest points of a replica below and above a quantile.
const FEWEST_BESIDE: f64 = 10.0;

fn require_inside(quantity: &'static str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value < 1.0 {
        Ok(())
    } else {
        Err(Error::OutsideOpenInterval { quantity, value })
    }
}
