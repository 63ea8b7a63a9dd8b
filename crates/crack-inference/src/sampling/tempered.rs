//! A cloud of points that goes from the prior to the posterior.

use rayon::prelude::*;
use sde_integrators::Purpose;
use simd_lanes::exp;

use crate::error::{Error, at_least, positive};
use crate::sampling::sampler_config::SamplerConfig;
use crate::sampling::target::{Proposal, Target, Walker};

/// Streams of [`Purpose::MarkovChain`]: chains have the first, particles of stage `t` those from `(t + 1) 2^32` on.
const STREAMS_OF_A_STAGE: u64 = 1 << 32;

/// Least number of points with a non-zero likelihood, from which the covariance is computed.
const LEAST_POSSIBLE: usize = 10;

/// Points of equal weight, distributed by the posterior but for few steps of their chains.
pub(crate) struct Cloud {
    pub(crate) walkers: Vec<Walker>,
    /// The powers of the likelihood, from above 0 to 1.
    pub(crate) temperatures: Vec<f64>,
}

/// Sequential Monte Carlo from prior to posterior: each power of the likelihood is such that weights are worth half of the points;
/// points are drawn again by their weights and moved by some steps of Metropolis's algorithm.
///
/// Source: Del Moral, Doucet and Jasra 2006, Sequential Monte Carlo samplers, section 3; the powers by Jasra, Stephens, Doucet and
/// Tsagaris 2011, Inference for Lévy-driven stochastic volatility models via adaptive sequential Monte Carlo.
pub(crate) fn tempered(target: &Target<'_>, config: &SamplerConfig) -> Result<Cloud, Error> {
    let draw = |particle: u64| {
        let mut stream = config.noise.stream(Purpose::InitialDistribution, particle);
        Walker::new(target, target.space.draw(|| stream.next_uniform()))
    };
    let mut walkers =
        (0..config.n_particles as u64).into_par_iter().map(draw).collect::<Result<Vec<_>, _>>()?;
    let mut temperatures = vec![];
    let (mut beta, mut stage) = (0.0, 0);
    while beta < 1.0 {
        let step = next_step(&walkers, 1.0 - beta)?;
        let next = if step < 1.0 - beta { beta + step } else { 1.0 };
        // The likelihood falls off so fast that its successive powers cannot be distinguished.
        positive("step of the power of the likelihood", next - beta)?;
        let weights = weights(&walkers, next - beta);
        let uniform = config.noise.stream(Purpose::Bootstrap, stage).next_uniform();
        walkers = drawn_again(&walkers, &weights, uniform);
        let dimension = target.space.parameters().len();
        let proposal = Proposal::new(dimension, &covariance(&walkers))?;
        let first = (stage + 1) * STREAMS_OF_A_STAGE;
        let moved = walkers.into_par_iter().enumerate().map(|(particle, mut walker)| {
            let mut stream = config.noise.stream(Purpose::MarkovChain, first + particle as u64);
            for _ in 0..config.n_moves {
                walker.step(target, next, &proposal, &mut stream)?;
            }
            Ok(walker)
        });
        walkers = moved.collect::<Result<Vec<_>, Error>>()?;
        (beta, stage) = (next, stage + 1);
        temperatures.push(beta);
    }
    Ok(Cloud { walkers, temperatures })
}

/// `L^step` over the largest, with nothing where the data cannot be.
fn weights(walkers: &[Walker], step: f64) -> Vec<f64> {
    let of = |walker: &Walker| walker.log_likelihood;
    let largest = walkers.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
    walkers.iter().map(|walker| exp(step * (of(walker) - largest))).collect()
}

/// How many points of equal weight the weights are worth (Kong, Liu and Wong 1994).
fn worth(weights: &[f64]) -> f64 {
    let (sum, squares) =
        weights.iter().fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
    sum * sum / squares
}

/// The step of the power at which weights are worth half of the points that are possible, by bisection; at most `most`.
fn next_step(walkers: &[Walker], most: f64) -> Result<f64, Error> {
    let n_possible =
        walkers.iter().filter(|walker| walker.log_likelihood > f64::NEG_INFINITY).count();
    at_least("points of the prior at which the data are possible", n_possible, LEAST_POSSIBLE)?;
    let half = 0.5 * n_possible as f64;
    if worth(&weights(walkers, most)) >= half {
        return Ok(most);
    }
    let (mut low, mut high) = (0.0, most);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if worth(&weights(walkers, middle)) >= half {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(0.5 * (low + high))
}

/// Systematic resampling by one uniform number (Kitagawa 1996).
fn drawn_again(walkers: &[Walker], weights: &[f64], uniform: f64) -> Vec<Walker> {
    let n = walkers.len();
    let spacing = weights.iter().sum::<f64>() / n as f64;
    let (mut chosen, mut sum) = (0, weights[0]);
    let pick = |k: usize| {
        let place = spacing * (k as f64 + uniform);
        while sum <= place && chosen + 1 < n {
            chosen += 1;
            sum += weights[chosen];
        }
        walkers[chosen].clone()
    };
    (0..n).map(pick).collect()
}

/// The covariance of points in units.
pub(crate) fn covariance(walkers: &[Walker]) -> Vec<f64> {
    let (n, d) = (walkers.len() as f64, walkers[0].units.len());
    let mean = |i: usize| walkers.iter().map(|walker| walker.units[i]).sum::<f64>() / n;
    let mean: Vec<f64> = (0..d).map(mean).collect();
    let mut covariance = vec![0.0; d * d];
    for walker in walkers {
        for i in 0..d {
            for j in 0..d {
                let (a, b) = (walker.units[i] - mean[i], walker.units[j] - mean[j]);
                covariance[i * d + j] += a * b / (n - 1.0);
            }
        }
    }
    covariance
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::*;

    fn walkers(log_likelihoods: &[f64]) -> Vec<Walker> {
        let walker = |(k, &log_likelihood): (usize, &f64)| Walker {
            units: vec![k as f64],
            log_prior: 0.0,
            log_likelihood,
        };
        log_likelihoods.iter().enumerate().map(walker).collect()
    }

    #[test]
    fn weights_after_a_step_are_worth_half_of_the_points() {
        let steep: Vec<f64> = (0..100).map(|k| -1e4 * f64::from(k)).collect();
        let step = next_step(&walkers(&steep), 1.0).unwrap();
        assert!((worth(&weights(&walkers(&steep), step)) - 50.0).abs() < 1e-6);
        let flat = vec![-3.0; 20];
        assert!((next_step(&walkers(&flat), 0.7).unwrap() - 0.7).abs() < 1e-15);
    }

    #[test]
    fn points_at_which_data_cannot_be_have_no_weight_and_too_few_others_are_refused() {
        let mut some = vec![f64::NEG_INFINITY; 100];
        some[40..60].fill(-5.0);
        let half = walkers(&some);
        assert!((next_step(&half, 1.0).unwrap() - 1.0).abs() < 1e-15);
        let again = drawn_again(&half, &weights(&half, 1.0), 0.5);
        assert!(again.iter().all(|walker| walker.log_likelihood > -6.0));
        some[9..91].fill(f64::NEG_INFINITY);
        let none = next_step(&walkers(&some), 1.0);
        assert!(matches!(none, Err(Error::TooFew { value: 0, limit: 10, .. })));
    }

    #[test]
    fn points_are_drawn_again_as_often_as_their_weights_say() {
        let again = drawn_again(&walkers(&[0.0; 4]), &[1.0, 0.0, 2.0, 1.0], 0.3);
        let chosen: Vec<f64> = again.iter().map(|walker| walker.units[0]).collect();
        assert_eq!(chosen, [0.0, 2.0, 2.0, 3.0]);
    }
}
