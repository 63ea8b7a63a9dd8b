//! Monte Carlo reference on the same system and initial distribution.

use scene_runs::clock::CpuClock;
use sde_integrators::{
    Ensemble, EnsembleConfig, Estimate, GaussianMixture, Observable, ShardRecord, merge,
};

use super::density::{Requested, monomial};
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

/// Samples paths of a system of a scene; [`Requested::cells`] is ignored.
///
/// # Errors
/// Errors of the ensemble: invalid numbers, or a path that is not finite.
pub fn run_on<S: Paths<D, M>, const D: usize, const M: usize>(
    system: &S,
    law: &GaussianMixture<D>,
    sampling: &Sampling,
    asked: &Requested<D>,
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
    asked: &Requested<D>,
) -> Result<SampledRun, PathsError> {
    let clock = CpuClock::start();
    let record = sampled_shard(shard, law, sampling, asked, (0, 1))?;
    SampledRun::of(asked, &merge(&[record])?.ensemble()?, clock.seconds())
}

/// Runs part `place.0` of `place.1` of an ensemble of paths.
///
/// All other code is compiled once for each number of states.
pub type Shard<'a, const D: usize> =
    &'a (dyn Fn(&PathEnsemble<'_, D>, (u64, u64)) -> Result<ShardRecord, PathsError> + Sync);

impl SampledRun {
    /// The results of an ensemble of paths.
    ///
    /// # Errors
    /// [`PathsError::OtherResults`] for an ensemble with other quantities.
    pub(crate) fn of<const D: usize>(
        asked: &Requested<D>,
        ensemble: &Ensemble,
        cpu_seconds: f64,
    ) -> Result<Self, PathsError> {
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
        Ok(Self {
            rows: ensemble.times.iter().zip(&ensemble.estimates).map(row).collect(),
            path_steps: ensemble.path_steps,
            cpu_seconds,
        })
    }
}

/// Samples shard `place.0` of `place.1` of an ensemble.
pub(crate) fn sampled_shard<const D: usize>(
    shard: Shard<'_, D>,
    law: &GaussianMixture<D>,
    sampling: &Sampling,
    asked: &Requested<D>,
    place: (u64, u64),
) -> Result<ShardRecord, PathsError> {
    let Requested { times, powers, demand, thresholds, .. } = asked;
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
    shard(&PathEnsemble { law, config: &config, observables: &observables }, place)
}
