//! Monte Carlo reference on the same system and initial distribution.

use std::ops::Range;

use scene_runs::clock::CpuClock;
use sde_integrators::{
    Ensemble, EnsembleConfig, Estimate, GaussianMixture, Observable, ShardRecord, merge,
    merge_so_far,
};
use serde::{Deserialize, Serialize};

use super::density::Asked;
use super::paths::{PathEnsemble, Paths, PathsError};

/// Ensemble size and step.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampling {
    /// Number of paths.
    pub paths: u64,
    /// Longest step.
    pub step: f64,
    /// Seed.
    pub seed: u64,
}

/// Results at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledRow {
    /// The time.
    pub t: f64,
    /// Raw moments, in the requested order.
    pub moments: Vec<Estimate>,
    /// `P(|q| > T)`, in the order of the thresholds.
    pub exceedances: Vec<Estimate>,
}

/// Results of an ensemble.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledRun {
    /// One row for each time.
    pub rows: Vec<SampledRow>,
    /// Steps of all paths.
    pub path_steps: u128,
    /// CPU time (s).
    pub cpu_seconds: f64,
}

impl SampledRun {
    /// The row of a requested time.
    #[must_use]
    pub fn at(&self, t: f64) -> Option<&SampledRow> {
        self.rows.iter().find(|row| (row.t - t).abs() < 1e-9)
    }
}

/// Samples paths of a system of a scene; [`Asked::cells`] is ignored.
///
/// # Errors
/// Errors of the ensemble: invalid numbers, or a path that is not finite.
pub fn run_on<S: Paths<D, M>, const D: usize, const M: usize>(
    system: &S,
    law: &GaussianMixture<D>,
    sampling: &Sampling,
    asked: &Asked<D>,
) -> Result<SampledRun, PathsError> {
    run_by(&|paths, place| system.shard(paths, place), law, sampling, asked)
}

/// As [`run_on`] for paths that `shard` samples.
///
/// # Errors
/// As [`run_on`].
pub fn run_by<const D: usize>(
    shard: Shard<'_, D>,
    law: &GaussianMixture<D>,
    sampling: &Sampling,
    asked: &Asked<D>,
) -> Result<SampledRun, PathsError> {
    let so_far = SampledSoFar::default();
    sample(shard, law, sampling, asked, (0..1, 1), so_far, &mut |_| Ok::<(), PathsError>(()))?
        .run(asked)
}

/// Runs part `place.0` of `place.1` of an ensemble of paths.
///
/// All other code is compiled once for each number of states.
pub type Shard<'a, const D: usize> =
    &'a (dyn Fn(&PathEnsemble<'_, D>, (u64, u64)) -> Result<ShardRecord, PathsError> + Sync);

/// Finished shards of an ensemble.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SampledSoFar {
    shards: Vec<ShardRecord>,
    cpu_seconds: f64,
}

impl SampledSoFar {
    /// Number of shards.
    #[must_use]
    pub fn n_shards(&self) -> u64 {
        self.shards.len() as u64
    }

    /// All shards of some parts.
    pub fn of(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Self::default();
        for part in parts {
            all.shards.extend(part.shards);
            all.cpu_seconds += part.cpu_seconds;
        }
        all
    }

    /// Combined results of all shards.
    ///
    /// # Errors
    /// [`PathsError::Ensemble`] for a missing shard and for failed paths; [`PathsError::OtherResults`] for shards with
    /// other quantities.
    pub fn run<const D: usize>(&self, asked: &Asked<D>) -> Result<SampledRun, PathsError> {
        self.of_ensemble(asked, &merge(&self.shards)?.ensemble()?)
    }

    /// Combined results of the available shards.
    ///
    /// # Errors
    /// Those of [`SampledSoFar::run`], except for missing shards.
    pub fn present<const D: usize>(&self, asked: &Asked<D>) -> Result<SampledRun, PathsError> {
        self.of_ensemble(asked, &merge_so_far(&self.shards)?.ensemble()?)
    }

    fn of_ensemble<const D: usize>(
        &self,
        asked: &Asked<D>,
        ensemble: &Ensemble,
    ) -> Result<SampledRun, PathsError> {
        let (n_moments, n_thresholds) = (asked.powers.len(), asked.thresholds.len());
        let expected = n_moments + n_thresholds;
        let other = ensemble.estimates.iter().map(Vec::len).find(|&found| found != expected);
        if let Some(found) = other {
            return Err(PathsError::OtherResults { found, expected });
        }
        let row = |(&t, estimates): (&f64, &Vec<Estimate>)| SampledRow {
            t,
            moments: estimates[..n_moments].to_vec(),
            exceedances: estimates[n_moments..].to_vec(),
        };
        Ok(SampledRun {
            rows: ensemble.times.iter().zip(&ensemble.estimates).map(row).collect(),
            path_steps: ensemble.path_steps,
            cpu_seconds: self.cpu_seconds,
        })
    }
}

/// Samples a range of shards of an ensemble in sequence; the first shards may be finished already.
///
/// `look` is called after each shard and may stop the run.
///
/// # Errors
/// Those of [`run_on`] and of `look`.
pub fn sample<E: From<PathsError>, const D: usize>(
    shard_of: Shard<'_, D>,
    law: &GaussianMixture<D>,
    sampling: &Sampling,
    asked: &Asked<D>,
    (range, n_shards): (Range<u64>, u64),
    mut so_far: SampledSoFar,
    look: &mut dyn FnMut(&SampledSoFar) -> Result<(), E>,
) -> Result<SampledSoFar, E> {
    let Asked { times, powers, demand, thresholds, .. } = asked;
    let monomials: Vec<_> =
        powers.iter().map(|&powers| move |_: f64, x: &[f64; D]| monomial(powers, x)).collect();
    let events: Vec<_> = thresholds
        .iter()
        .map(|&threshold| move |_: f64, x: &[f64; D]| demand.magnitude(x) > threshold)
        .collect();
    let mut observables: Vec<Observable<'_, D>> = Vec::new();
    observables.extend(monomials.iter().map(|f| Observable::Mean(f)));
    observables.extend(events.iter().map(|event| Observable::Probability(event)));
    let config = EnsembleConfig {
        seed: sampling.seed,
        n_paths: sampling.paths,
        dt: sampling.step,
        times: times.clone(),
    };
    let paths = PathEnsemble { law, config: &config, observables: &observables };
    for shard in range.start + so_far.n_shards()..range.end {
        let start = CpuClock::start();
        so_far.shards.push(shard_of(&paths, (shard, n_shards))?);
        so_far.cpu_seconds += start.seconds();
        look(&so_far)?;
    }
    Ok(so_far)
}

fn monomial<const D: usize>(powers: [u32; D], x: &[f64; D]) -> f64 {
    let power = |base: f64, exponent: u32| (0..exponent).fold(1.0, |product, _| product * base);
    x.iter().zip(powers).map(|(&x, a)| power(x, a)).product()
}
