//! Complete runs at sampled parameters.

use std::collections::BTreeMap;
use std::ops::Range;

use perturbation_moments::{Estimate, MonteCarlo, Uncertainty};
use uq_estimators::{
    ControlledSamples, Error as SamplingError, PolynomialControl, SampledMoments, SobolIndices,
    Surrogate,
};

use super::design::Design;
use super::experiment::Experiment;
use super::range::upper_tail;
use super::series::Series;
use super::study::Study;
use crate::error::Error;
use crate::parallel::map_in_order;

/// Responses at sampled parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampled {
    pub(super) design: Design,
    /// Those that could be run, in order.
    samples: Vec<Sample>,
    /// Samples that could not be run and why: parameters out of range, or a run that left its own. They are not in any
    /// moment. What they would have answered is unknown: above [`MOST_FAILED`] of all samples so is the error of each moment.
    pub failures: Vec<(u64, Error)>,
}

/// Share of failed samples above which the error of a moment is unknown: they are not those of any inputs but of some range of them.
/// Up to it the error covers what they would have answered within three deviations of the mean of the others.
pub const MOST_FAILED: f64 = 0.02;

/// Distance within which a failed sample would have answered, in standard deviations of the others.
const FARTHEST: f64 = 3.0;

/// Fewest samples of a mean and a variance.
const FEWEST: usize = 8;

/// A sample that could be run.
#[derive(Debug, Clone, PartialEq)]
struct Sample {
    realisation: u64,
    responses: Vec<f64>,
}

impl<X: Experiment<D>, const D: usize> Study<'_, X, D> {
    /// Runs independent samples, on all threads; the same for any number of them.
    ///
    /// # Errors
    /// As [`sampled`](Self::sampled).
    pub fn monte_carlo(&self, judge: MonteCarlo) -> Result<Sampled, Error> {
        self.sampled(Design::Random(judge))
    }

    /// Runs the samples of a design, on all threads; the same for any number of them.
    ///
    /// # Errors
    /// [`Error::Sampling`] for the fields of a quasi-random design.
    pub fn sampled(&self, design: Design) -> Result<Sampled, Error> {
        let n = design.n_runs()?;
        self.sampled_from(design, 0..n, &BTreeMap::new(), n, |_, _| Ok(()))
    }

    /// As [`sampled`](Self::sampled), for a range of the samples, `each` at a time, and without those whose responses are known
    /// from [`Sampled::responses`] of another run: bitwise identical. `seen` is shown what has come so far, with the number of samples
    /// that were tried, and may end the run.
    ///
    /// # Errors
    /// As [`sampled`](Self::sampled), and those of `seen`.
    pub fn sampled_from<E: From<Error>>(
        &self,
        design: Design,
        range: Range<u64>,
        known: &BTreeMap<u64, Vec<f64>>,
        each: u64,
        mut seen: impl FnMut(&Sampled, u64) -> Result<(), E>,
    ) -> Result<Sampled, E> {
        let normals = design.normals()?;
        let run = |&realisation: &u64| {
            let responses = match known.get(&realisation) {
                Some(responses) => responses.clone(),
                None => self.run(&normals.of(realisation, self.n_normals()))?,
            };
            Ok(Sample { realisation, responses })
        };
        let mut sampled = Sampled { design, samples: vec![], failures: vec![] };
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
}

impl Sampled {
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

    /// The first `n` of its samples, and the failures before the next.
    #[must_use]
    pub fn first(&self, n: usize) -> Self {
        let samples: Vec<Sample> = self.samples.iter().take(n).cloned().collect();
        let mut failures = self.failures.clone();
        if let Some(next) = self.samples.get(n) {
            failures.retain(|(sample, _)| *sample < next.realisation);
        }
        Self { design: self.design, samples, failures }
    }

    /// Mean and variance of a response without a control variate.
    ///
    /// # Errors
    /// [`Error::NoSuchResponse`]; [`Error::SamplesFailed`]; too few samples or one that is not finite, as
    /// [`ControlledSamples::raw`];
    /// [`Error::SampleOfDesign`], [`Error::SamplesMissing`] for a quasi-random design that is not whole. A response that does not vary
    /// is none: its errors are unknown.
    pub fn raw(&self, response: usize) -> Result<SampledMoments, Error> {
        let values = self.values(response)?;
        match self.design {
            Design::Random(judge) => {
                let (samples, surrogates, seed) = (&values, &[], judge.seed);
                Ok(self.of_the_rest(ControlledSamples { samples, surrogates, seed }.raw()?))
            }
            Design::QuasiRandom(cube) => {
                self.require_whole()?;
                Ok(cube.moments_of_runs(&values, &[])?)
            }
            Design::SobolIndices(_) => {
                match self.sobol_indices(response) {
                    Ok(indices) => {
                        Ok(SampledMoments { mean: indices.mean, variance: indices.variance })
                    }
                    // It has no indices, but others may.
                    Err(Error::Sampling(SamplingError::NoVariance { .. })) => {
                        let unknown = |value| Estimate { value, uncertainty: Uncertainty::Unknown };
                        let first = values.first().copied().unwrap_or(0.0);
                        Ok(SampledMoments { mean: unknown(first), variance: unknown(0.0) })
                    }
                    Err(error) => Err(error),
                }
            }
        }
    }

    /// Mean and variance of a response with its Taylor surrogate, under the same distribution, as control variate. Independent
    /// samples: each half takes the coefficient of the other, errors are by bootstrap. Replicas: each takes that of the others.
    /// The runs for Sobol' indices serve without it.
    ///
    /// # Errors
    /// As [`raw`](Self::raw).
    pub fn controlled(&self, response: usize, series: &Series) -> Result<SampledMoments, Error> {
        let normals = self.design.normals()?;
        let values = self.values(response)?;
        let n = series.gradient.len();
        let pair = |(y, sample): (&f64, &Sample)| {
            [*y, series.surrogate(&normals.of(sample.realisation, n))]
        };
        let pairs: Vec<[f64; 2]> = values.iter().zip(&self.samples).map(pair).collect();
        let (mean, variance) = (series.mean(), Some(series.surrogate_variance()));
        let surrogates = &[Surrogate { mean, variance }];
        let samples = pairs.as_flattened();
        match self.design {
            Design::Random(judge) => {
                let samples = ControlledSamples { samples, surrogates, seed: judge.seed };
                Ok(self.of_the_rest(samples.estimate()?))
            }
            Design::QuasiRandom(cube) => {
                self.require_whole()?;
                Ok(cube.moments_of_runs(samples, surrogates)?)
            }
            Design::SobolIndices(_) => self.raw(response),
        }
    }

    /// Polynomials of the parameters of a quasi-random design, to be fitted to its responses: [`PolynomialControl::moments`] of
    /// [`values`](Self::values) gives mean, variance and Sobol' indices without further runs.
    ///
    /// # Errors
    /// As [`raw`](Self::raw); [`Error::SamplesMissing`] for another design.
    pub fn polynomial_control(&self) -> Result<PolynomialControl, Error> {
        let Design::QuasiRandom(cube) = self.design else {
            return Err(Error::SamplesMissing { value: self.samples.len(), expected: 0 });
        };
        self.require_whole()?;
        let (runs, n) = (cube.runs()?, cube.dimension);
        let mut inputs = vec![0.0; self.samples.len() * n];
        for (sample, input) in self.samples.iter().zip(inputs.chunks_exact_mut(n)) {
            runs.normals(sample.realisation, input);
        }
        let n_folds = usize::try_from(cube.n_replicas).unwrap_or(usize::MAX);
        Ok(PolynomialControl::new(&inputs, cube.dimension, n_folds)?)
    }

    /// Sobol' indices of a response, of the parameters that vary.
    ///
    /// # Errors
    /// [`Error::NoSuchResponse`]; [`Error::SampleOfDesign`], [`Error::SamplesMissing`]; [`Error::Sampling`] for a response that does
    /// not vary, and where the design is another one.
    pub fn sobol_indices(&self, response: usize) -> Result<SobolIndices, Error> {
        let values = self.values(response)?;
        let Design::SobolIndices(cube) = self.design else {
            let (value, expected) = (values.len(), 0);
            return Err(Error::SamplesMissing { value, expected });
        };
        self.require_whole()?;
        Ok(cube.sobol_indices_of_runs(&values)?)
    }

    /// Share of the samples that failed.
    #[must_use]
    pub fn failed_share(&self) -> f64 {
        let n = self.samples.len() + self.failures.len();
        self.failures.len() as f64 / n.max(1) as f64
    }

    /// Moments without the samples that failed, with what these may change.
    fn of_the_rest(&self, moments: SampledMoments) -> SampledMoments {
        if self.failures.is_empty() {
            return moments;
        }
        let (share, variance) = (self.failed_share(), moments.variance.value.max(0.0));
        let with = |estimate: Estimate, change: f64| Estimate {
            uncertainty: match estimate.uncertainty {
                Uncertainty::StandardError(error) if share <= MOST_FAILED => {
                    Uncertainty::StandardError(error + share * change)
                }
                _ => Uncertainty::Unknown,
            },
            ..estimate
        };
        SampledMoments {
            mean: with(moments.mean, FARTHEST * variance.sqrt()),
            variance: with(moments.variance, FARTHEST * FARTHEST * variance),
        }
    }

    /// Refuses fewer than eight samples that are left, with the reason of the first that failed.
    fn require_enough(&self) -> Result<(), Error> {
        let failed = self.failures.len();
        match self.failures.first() {
            Some((sample, reason)) if self.samples.len() < FEWEST => {
                if !matches!(self.design, Design::Random(_)) {
                    return self.require_whole();
                }
                let (sample, reason, n) =
                    (*sample, reason.to_string(), self.samples.len() + failed);
                Err(Error::SamplesFailed { failed, n, sample, reason })
            }
            _ => Ok(()),
        }
    }

    /// Whether all runs of a quasi-random design are there.
    fn require_whole(&self) -> Result<(), Error> {
        if let Some((sample, reason)) = self.failures.first() {
            return Err(Error::SampleOfDesign { sample: *sample, reason: reason.to_string() });
        }
        let (value, expected) = (self.samples.len(), self.design.n_runs()?);
        if value as u64 == expected {
            return Ok(());
        }
        Err(Error::SamplesMissing { value, expected })
    }

    /// A response of every sample.
    ///
    /// # Errors
    /// [`Error::NoSuchResponse`]; [`Error::SamplesFailed`] where failures leave fewer than eight.
    pub fn values(&self, response: usize) -> Result<Vec<f64>, Error> {
        self.require_enough()?;
        let limit = self.samples.first().map_or(0, |sample| sample.responses.len());
        if response >= limit {
            return Err(Error::NoSuchResponse { value: response, limit });
        }
        Ok(self.samples.iter().map(|sample| sample.responses[response]).collect())
    }

    /// The share of samples in which a response exceeds a level; of the runs for Sobol' indices, of those at independent
    /// points. Its error follows from the replicas; that of independent samples, and of no or only hits, is that of
    /// [`Estimate::probability`], and the share of samples that failed, which may all exceed it or none.
    ///
    /// # Errors
    /// As [`raw`](Self::raw), also where no sample could be run.
    pub fn exceedance(&self, response: usize, level: f64) -> Result<Estimate, Error> {
        let mut values = self.values(response)?;
        let cube = match self.design {
            Design::Random(_) => None,
            Design::QuasiRandom(cube) => Some(cube),
            Design::SobolIndices(cube) => {
                values = values.into_iter().step_by(cube.dimension + 2).collect();
                Some(cube)
            }
        };
        let hits: Vec<f64> = values.iter().map(|&y| f64::from(u8::from(y > level))).collect();
        let n_hits = values.iter().filter(|&&y| y > level).count();
        match cube {
            Some(cube) if n_hits > 0 && n_hits < hits.len() => {
                self.require_whole()?;
                Ok(cube.mean_of_runs(&hits)?)
            }
            _ => {
                let (value, limit) = (response, 0);
                let mut share = Estimate::probability(n_hits as u64, hits.len() as u64)
                    .map_err(|_| Error::NoSuchResponse { value, limit })?;
                if let Uncertainty::StandardError(error) | Uncertainty::Bound(error) =
                    share.uncertainty
                    && !self.failures.is_empty()
                {
                    share.uncertainty = Uncertainty::Bound((error + self.failed_share()).min(1.0));
                }
                Ok(share)
            }
        }
    }
}

/// The chance that a normal response with this mean and variance exceeds a level, `1 - Phi((level - mean)/sd)`; a step where the
/// variance is zero. How far the response is from normal it does not know: see [`Series::curvature_ratio`].
///
/// # Errors
/// [`Error::Parameter`] for the level.
pub fn exceedance_of_normal(mean: f64, variance: f64, level: f64) -> Result<f64, Error> {
    constitutive_models::finite("level", level)?;
    Ok(if variance > 0.0 {
        upper_tail((level - mean) / variance.sqrt())
    } else {
        f64::from(u8::from(mean > level))
    })
}
