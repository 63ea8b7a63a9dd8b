//! Whether chains have mixed, and how many independent draws they are worth.
//!
//! Vehtari, Gelman, Simpson, Carpenter and Bürkner 2021, Rank-normalization, folding, and localization: an improved R-hat for
//! assessing convergence of MCMC, Bayesian Analysis 16. Equations are those of the paper.

use sde_integrators::normal_quantile;

use crate::error::{Error, at_least, finite, positive, same_count};

/// The fewest draws of a chain.
const LEAST_DRAWS: usize = 100;
/// The fewest chains.
const LEAST_CHAINS: usize = 2;

/// The larger of the split `R`-hat of ranks and that of ranks of distances to the median (section 4.1).
///
/// $$ \hat R = \sqrt{\frac{(N-1) W/N + B/N}{W}} $$
///
/// with `B/N` the variance of the means of the halves of chains and `W` the mean of their variances (eq 1 to 4), of
/// `z = Phi^{-1}((r - 3/8)/(S + 1/4))` in place of the draws, with their ranks `r` among all `S` (eq 14). Chains that have mixed have
/// less than 1.01.
///
/// # Errors
/// [`Error::TooFew`] for fewer than 2 chains or 100 draws, [`Error::Count`] for chains of different lengths,
/// [`Error::NotFinite`], [`Error::NotPositive`] for draws that are all equal.
pub fn r_hat(chains: &[Vec<f64>]) -> Result<f64, Error> {
    check(chains)?;
    let median = median(chains);
    let folded: Vec<Vec<f64>> =
        chains.iter().map(|chain| chain.iter().map(|x| (x - median).abs()).collect()).collect();
    let of_ranks = Halves::new(&ranked(chains)).r_hat()?;
    // Draws of two values, the median between them, have one distance to it: their ranks say all.
    let of_distances = Halves::new(&ranked(&folded)).r_hat().unwrap_or(of_ranks);
    Ok(of_ranks.max(of_distances))
}

/// Bulk effective sample size: [`effective_sample_size`] of ranks as in [`r_hat`] (section 4.3).
/// Four chains need at least 400.
///
/// # Errors
/// As [`r_hat`].
pub fn bulk_effective_sample_size(chains: &[Vec<f64>]) -> Result<f64, Error> {
    check(chains)?;
    Halves::new(&ranked(chains)).effective_sample_size()
}

/// How many independent draws have a mean with the same error:
///
/// $$ S_{eff} = \frac{S}{\tau}, \qquad \tau = 1 + 2 \sum_t \hat\rho_t $$
///
/// with the autocorrelations of the halves of all chains together (eq 10 to 13), summed in pairs as long as these are positive and
/// made to decrease (Geyer 1992, Practical Markov chain Monte Carlo). At most `S log10 S` for chains that swing.
///
/// # Errors
/// As [`r_hat`].
pub fn effective_sample_size(chains: &[Vec<f64>]) -> Result<f64, Error> {
    check(chains)?;
    Halves::new(chains).effective_sample_size()
}

fn check(chains: &[Vec<f64>]) -> Result<(), Error> {
    at_least("chains", chains.len(), LEAST_CHAINS)?;
    for chain in chains {
        at_least("draws of a chain", chain.len(), LEAST_DRAWS)?;
        same_count("draws of a chain", chain.len(), chains[0].len())?;
        chain.iter().try_for_each(|&draw| finite("a draw", draw))?;
    }
    Ok(())
}

fn median(chains: &[Vec<f64>]) -> f64 {
    let mut all = chains.concat();
    all.sort_unstable_by(f64::total_cmp);
    let n = all.len();
    0.5 * (all[(n - 1) / 2] + all[n / 2])
}

/// Normal scores of the ranks among all draws; equal draws have the mean of their ranks (eq 14).
fn ranked(chains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let all = chains.concat();
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|&a, &b| all[a].total_cmp(&all[b]));
    let mut scores = vec![0.0; all.len()];
    let mut first = 0;
    for group in order.chunk_by(|&a, &b| all[a].total_cmp(&all[b]).is_eq()) {
        let rank = first as f64 + 0.5 * (group.len() + 1) as f64;
        let score = normal_quantile((rank - 0.375) / (all.len() as f64 + 0.25));
        for &draw in group {
            scores[draw] = score;
        }
        first += group.len();
    }
    scores.chunks_exact(chains[0].len()).map(<[f64]>::to_vec).collect()
}

/// Halves of chains, less their means.
struct Halves {
    away: Vec<Vec<f64>>,
    n: usize,
    /// The mean of their variances, `W`.
    within: f64,
    /// The variance of the means, `B/N`.
    between: f64,
}

impl Halves {
    fn new(chains: &[Vec<f64>]) -> Self {
        let n = chains[0].len() / 2;
        // Of an odd number of draws the one in the middle is left out.
        let halves = chains.iter().flat_map(|chain| [&chain[..n], &chain[chain.len() - n..]]);
        let (mut away, mut means) = (vec![], vec![]);
        for half in halves {
            let mean = half.iter().sum::<f64>() / n as f64;
            means.push(mean);
            away.push(half.iter().map(|x| x - mean).collect::<Vec<f64>>());
        }
        let m = means.len() as f64;
        let middle = means.iter().sum::<f64>() / m;
        let between = means.iter().map(|x| (x - middle) * (x - middle)).sum::<f64>() / (m - 1.0);
        let squares: f64 = away.iter().flatten().map(|x| x * x).sum();
        let within = squares / (m * (n - 1) as f64);
        Self { away, n, within, between }
    }

    /// `var^+` of eq 3.
    fn variance(&self) -> Result<f64, Error> {
        positive("the variance of the draws of a chain", self.within)?;
        let n = self.n as f64;
        Ok((n - 1.0) / n * self.within + self.between)
    }

    fn r_hat(&self) -> Result<f64, Error> {
        Ok((self.variance()? / self.within).sqrt())
    }

    /// `rho_t` of eq 10.
    fn autocorrelation(&self, lag: usize, variance: f64) -> f64 {
        let products = |half: &Vec<f64>| -> f64 {
            half[lag..].iter().zip(half).map(|(later, x)| later * x).sum()
        };
        let sum: f64 = self.away.iter().map(products).sum();
        let covariance = sum / (self.n * self.away.len()) as f64;
        1.0 - (self.within - covariance) / variance
    }

    fn effective_sample_size(&self) -> Result<f64, Error> {
        let variance = self.variance()?;
        let total = (self.n * self.away.len()) as f64;
        let (mut sum, mut last, mut lag) = (0.0, f64::INFINITY, 0);
        while lag + 1 < self.n {
            // rho_0 is one, whatever the divisor of the covariance.
            let even = if lag == 0 { 1.0 } else { self.autocorrelation(lag, variance) };
            let pair = (even + self.autocorrelation(lag + 1, variance)).min(last);
            if pair <= 0.0 {
                break;
            }
            sum += pair;
            last = pair;
            lag += 2;
        }
        let tau = (2.0 * sum - 1.0).max(1.0 / total.log10());
        Ok(total / tau)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use sde_integrators::{Accumulator, Noise, Purpose};

    use super::*;

    /// Chains `x_t = rho x_(t-1) + sqrt(1 - rho^2) e_t` of variance one.
    fn autoregressive(rho: f64, seed: u64, n_draws: usize) -> Vec<Vec<f64>> {
        let chain = |id| {
            let mut stream = Noise::new(seed).stream(Purpose::MarkovChain, id);
            let mut normals = vec![0.0; n_draws + 1];
            stream.fill_normal(&mut normals);
            let mut x = normals[n_draws];
            let mut draw = |e: &f64| {
                x = rho * x + (1.0 - rho * rho).sqrt() * e;
                x
            };
            normals[..n_draws].iter().map(&mut draw).collect()
        };
        (0..4).map(chain).collect()
    }

    #[test]
    fn size_of_an_autoregressive_chain_is_the_closed_form() {
        for rho in [0.0, 0.6, 0.9, -0.5] {
            // Geyer's sum has a deviation of its own, which repetitions measure.
            let (mut raw, mut bulk) = (Accumulator::default(), Accumulator::default());
            for seed in 0..20 {
                let chains = autoregressive(rho, seed, 2000);
                raw.push(effective_sample_size(&chains).unwrap());
                bulk.push(bulk_effective_sample_size(&chains).unwrap());
            }
            let expected = 8000.0 * (1.0 - rho) / (1.0 + rho);
            for found in [raw.estimate().unwrap(), bulk.estimate().unwrap()] {
                let error = (found.value - expected).abs();
                // Where the sum ends costs about a part in thirty: it is the first pair below its own noise.
                let limit = 4.0 * found.standard_error().unwrap() + 0.04 * expected;
                assert!(error < limit, "{rho}: {found} {expected}");
            }
        }
    }

    #[test]
    fn chains_that_have_mixed_have_an_r_hat_of_one_and_others_have_not() {
        let mixed = autoregressive(0.3, 1, 2000);
        assert!(r_hat(&mixed).unwrap() < 1.01);
        let mut apart = mixed.clone();
        // Means of halves of 0 and, two of eight, 2: sqrt(1 + 0.86) of draws, less of ranks.
        apart[2].iter_mut().for_each(|x| *x += 2.0);
        assert!(r_hat(&apart).unwrap() > 1.1);
        // One mean, another spread: only distances to the median detect it.
        let mut wide = mixed.clone();
        wide[1].iter_mut().for_each(|x| *x *= 3.0);
        assert!(r_hat(&wide).unwrap() > 1.1);
        // Each chain drifts: only split chains detect it.
        let mut drift = mixed;
        for chain in &mut drift {
            for (t, x) in chain.iter_mut().enumerate() {
                *x += t as f64 / 500.0;
            }
        }
        assert!(r_hat(&drift).unwrap() > 1.1);
    }

    #[test]
    fn scores_of_equal_draws_are_equal() {
        let chains = [vec![1.0, 1.0, 2.0], vec![0.0, 1.0, 3.0]];
        let scores = ranked(&chains);
        // Ranks 3, 3, 5; 1, 3, 6 of six.
        let expected = [[3.0, 3.0, 5.0], [1.0, 3.0, 6.0]];
        for (scores, ranks) in scores.iter().zip(expected) {
            for (score, rank) in scores.iter().zip(ranks) {
                let z = normal_quantile((rank - 0.375) / 6.25);
                assert!((score - z).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn few_constant_or_broken_draws_are_refused() {
        let chains = autoregressive(0.0, 0, 100);
        assert!(r_hat(&chains).is_ok());
        assert!(matches!(r_hat(&chains[..1]), Err(Error::TooFew { .. })));
        let few = r_hat(&autoregressive(0.0, 0, 99)).unwrap_err();
        assert_eq!(few.to_string(), "99 draws of a chain; at least 100 are needed");
        let constant = effective_sample_size(&[vec![1.0; 100], vec![1.0; 100]]);
        assert!(matches!(constant, Err(Error::NotPositive { .. })));
        let mut nan = chains;
        nan[0][3] = f64::NAN;
        assert!(matches!(r_hat(&nan), Err(Error::NotFinite { .. })));
    }
}
