//! The judge: whole runs at sampled parameters.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::ops::Range;

use estimators::{ControlledSamples, SampledMoments, Surrogate};
use perturbation_moments::{Estimate, Moments, MonteCarlo};

use super::experiment::Experiment;
use super::range::upper_tail;
use super::study::Study;
use crate::error::Error;
use crate::parallel::map_in_order;

/// Responses at sampled parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampled {
    pub(super) seed: u64,
    /// Those that could be run, in order.
    samples: Vec<Sample>,
    /// Samples that could not be run and why: parameters out of range, or a run that left its own. They are not in any
    /// moment.
    pub failures: Vec<(u64, Error)>,
}

/// A sample that could be run.
#[derive(Debug, Clone, PartialEq)]
struct Sample {
    realisation: u64,
    responses: Vec<f64>,
}

impl<X: Experiment<D, N>, const D: usize, const N: usize> Study<'_, X, D, N> {
    /// Runs the samples of a judge, on all threads; the same for any number of them.
    #[must_use]
    pub fn monte_carlo(&self, judge: MonteCarlo) -> Sampled {
        let (all, known) = (0..judge.n_samples, BTreeMap::new());
        let Ok(sampled) = self
            .monte_carlo_from(judge, all, &known, judge.n_samples, |_, _| Ok::<(), Infallible>(()));
        sampled
    }

    /// As [`monte_carlo`](Self::monte_carlo), for a range of the samples, `each` at a time, and without those whose responses are known
    /// from [`Sampled::responses`] of another run: bitwise identical. `seen` is shown what has come so far, with the number of samples
    /// that were tried, and may end the run.
    ///
    /// # Errors
    /// Those of `seen`.
    pub fn monte_carlo_from<E>(
        &self,
        judge: MonteCarlo,
        range: Range<u64>,
        known: &BTreeMap<u64, Vec<f64>>,
        each: u64,
        mut seen: impl FnMut(&Sampled, u64) -> Result<(), E>,
    ) -> Result<Sampled, E> {
        let run = |realisation| self.run(&judge.normals::<N>(realisation));
        Sampled::by(&run, judge.seed, (range, each), known, &mut seen)
    }
}

impl Sampled {
    /// Runs a range of samples, `each` at a time, but not those that are known.
    pub(super) fn by<E>(
        run: &(dyn Fn(u64) -> Result<Vec<f64>, Error> + Sync),
        seed: u64,
        (range, each): (Range<u64>, u64),
        known: &BTreeMap<u64, Vec<f64>>,
        seen: &mut dyn FnMut(&Self, u64) -> Result<(), E>,
    ) -> Result<Self, E> {
        let run = |&realisation: &u64| {
            let responses = match known.get(&realisation) {
                Some(responses) => Ok(responses.clone()),
                None => run(realisation),
            };
            responses.map(|responses| Sample { realisation, responses })
        };
        let mut sampled = Self { seed, samples: vec![], failures: vec![] };
        let mut from = range.start;
        while from < range.end {
            let end = range.end.min(from.saturating_add(each.max(1)));
            let realisations: Vec<u64> = (from..end).collect();
            for (&realisation, outcome) in
                realisations.iter().zip(map_in_order(&realisations, &run))
            {
                match outcome {
                    Ok(sample) => sampled.samples.push(sample),
                    Err(error) => sampled.failures.push((realisation, error)),
                }
            }
            from = end;
            seen(&sampled, end - range.start)?;
        }
        Ok(sampled)
    }

    /// How many samples could be run.
    #[must_use]
    pub fn n_samples(&self) -> usize {
        self.samples.len()
    }

    /// The responses of each sample that could be run, by its number.
    #[must_use]
    pub fn responses(&self) -> BTreeMap<u64, Vec<f64>> {
        let of = |sample: &Sample| (sample.realisation, sample.responses.clone());
        self.samples.iter().map(of).collect()
    }

    /// The first `n` of its samples.
    #[must_use]
    pub fn first(&self, n: usize) -> Self {
        Self {
            seed: self.seed,
            samples: self.samples.iter().take(n).cloned().collect(),
            failures: self.failures.clone(),
        }
    }

    /// Mean and variance of a response without a control variate.
    ///
    /// # Errors
    /// [`Error::NoSuchResponse`]; too few samples or one that is not finite, as [`ControlledSamples::raw`].
    pub fn raw(&self, response: usize) -> Result<SampledMoments, Error> {
        let (samples, surrogates, seed) = (&self.values(response)?, &[], self.seed);
        Ok(ControlledSamples { samples, surrogates, seed }.raw()?)
    }

    /// Mean and variance of a response with its Taylor surrogate, under the same law, as control variate; each half of the
    /// samples takes the coefficient of the other, errors are by bootstrap.
    ///
    /// # Errors
    /// As [`raw`](Self::raw).
    pub fn controlled<const N: usize>(
        &self,
        response: usize,
        surrogate: &Moments<N>,
    ) -> Result<SampledMoments, Error> {
        let (mean, variance) = (surrogate.surrogate_mean(), surrogate.surrogate_variance());
        let judge = MonteCarlo { seed: self.seed, n_samples: 0 };
        let of = |realisation| surrogate.surrogate(&judge.normals(realisation));
        self.controlled_by(response, (mean, variance), &of)
    }

    /// The same by a surrogate of known mean and variance, as a function of the number of a sample.
    pub(super) fn controlled_by(
        &self,
        response: usize,
        (mean, variance): (f64, f64),
        surrogate: &dyn Fn(u64) -> f64,
    ) -> Result<SampledMoments, Error> {
        let values = self.values(response)?;
        let pair = |(y, sample): (&f64, &Sample)| [*y, surrogate(sample.realisation)];
        let pairs: Vec<[f64; 2]> = values.iter().zip(&self.samples).map(pair).collect();
        let surrogates = &[Surrogate { mean, variance: Some(variance) }];
        let (samples, seed) = (pairs.as_flattened(), self.seed);
        Ok(ControlledSamples { samples, surrogates, seed }.estimate()?)
    }

    /// A response of every sample.
    ///
    /// # Errors
    /// [`Error::NoSuchResponse`].
    pub fn values(&self, response: usize) -> Result<Vec<f64>, Error> {
        let limit = self.samples.first().map_or(0, |sample| sample.responses.len());
        if response >= limit {
            return Err(Error::NoSuchResponse { value: response, limit });
        }
        Ok(self.samples.iter().map(|sample| sample.responses[response]).collect())
    }

    /// The share of samples in which a response exceeds a level; see [`Estimate::probability`] for its error.
    ///
    /// # Errors
    /// [`Error::NoSuchResponse`], also where no sample could be run.
    pub fn exceedance(&self, response: usize, level: f64) -> Result<Estimate, Error> {
        let values = self.values(response)?;
        let hits = values.iter().filter(|&&y| y > level).count() as u64;
        let (value, limit) = (response, 0);
        Estimate::probability(hits, values.len() as u64)
            .map_err(|_| Error::NoSuchResponse { value, limit })
    }
}

/// The chance that a response exceeds a level, by moments and a normal law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exceedance {
    /// The level (unit of the response).
    pub level: f64,
    /// `1 - Phi((level - mean)/sd)`; a step where the variance is zero.
    pub probability: f64,
}

impl Exceedance {
    /// By the second-order mean, the first-order one where curvature is unknown, and the first-order variance. How far the
    /// response is from normal it does not know: see [`Moments::trust`].
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the level.
    pub fn by_normal_law<const N: usize>(moments: &Moments<N>, level: f64) -> Result<Self, Error> {
        let mean = moments.mean_second_order().unwrap_or_else(|_| moments.mean_first_order());
        Self::of_normal((mean, moments.variance_first_order()), level)
    }

    /// Of a normal response with this mean and variance.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the level.
    pub fn of_normal((mean, variance): (f64, f64), level: f64) -> Result<Self, Error> {
        crate::error::finite("level", level)?;
        let probability = if variance > 0.0 {
            upper_tail((level - mean) / variance.sqrt())
        } else {
            f64::from(u8::from(mean > level))
        };
        Ok(Self { level, probability })
    }
}
