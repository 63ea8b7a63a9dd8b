//! Result file of an ensemble of cracks.

use peridyn_sde::CrackRun;
use peridyn_sde::statistics::{
    Band, Bootstrap, CrackEnsemble, CrackOutcome, CrackRecord, Distribution, Interval, QUANTILES,
};
use result_figures::number::tidy;
use scene_runs::answers::{ErrorOrigin, Number, Unknown};
use scene_runs::kind::RunError;
use scene_runs::scene::NamedFile;
use sde_integrators::{Accumulator, Estimate, student_quantile};
use serde::Serialize;

use crate::scene::CrackScene;
use crate::scene_problem::{CrackProblem, Resolved};

/// Default distance of path abscissae, in spacings.
const ABSCISSAE_EVERY: usize = 4;

/// Keys that this kind adds to every result: schema `crack-ensemble/1`.
#[derive(Debug, Serialize)]
pub(super) struct Content<'a> {
    /// Files that the scene names.
    pub(super) files: &'a [NamedFile],
    pub(super) resolved: &'a Resolved,
    pub(super) seed: u64,
    pub(super) work: WorkRecord,
    #[serde(flatten)]
    pub(super) record: &'a Record,
}

/// Work counters.
#[derive(Debug, Serialize)]
pub(super) struct WorkRecord {
    /// Steps of each realisation; none under a quasi-static load.
    steps: Option<u64>,
    /// Bonds times steps times realisations.
    bond_steps: Option<u64>,
    /// CPU time of the run on all threads.
    cpu_seconds: f64,
}

impl WorkRecord {
    pub(super) fn new(scene: &CrackScene, resolved: &Resolved, cpu_seconds: f64) -> Self {
        let steps = scene.time.as_ref().map(|time| time.steps);
        let bonds = resolved.bonds as u64 * scene.ensemble.realisations;
        let bond_steps = steps.map(|steps| bonds * steps);
        Self { steps, bond_steps, cpu_seconds }
    }
}

/// Distributions of the observed quantities.
#[derive(Debug, Serialize)]
pub(super) struct Record {
    /// Unknown errors, and why; nothing else is missing.
    pub(super) unknown: Vec<Unknown>,
    /// Realisations that ended in an error, with its text.
    pub(super) failures: Vec<Failure>,
    /// Probability of each outcome.
    pub(super) outcomes: Vec<Outcome>,
    /// Crack height at abscissae (m).
    pub(super) path: Vec<PathAt>,
    /// Height at which cracks leave the body (m).
    pub(super) exit: Option<Law>,
    /// Crack length, zero for no growth (m).
    pub(super) length: Option<Law>,
    /// The largest window-averaged load (N).
    pub(super) failure_load: Option<Law>,
    /// Number of broken bonds, without those of the notch.
    pub(super) broken_bonds: Option<Number>,
    /// One entry for each realisation, by number.
    pub(super) realisations: Vec<Realisation>,
    /// The mean load at the upper edge or the displaced region (N), window by window.
    pub(super) load: Vec<LoadAt>,
}

/// Result of one realisation.
#[derive(Debug, Serialize)]
pub(super) struct Realisation {
    pub(super) number: u64,
    pub(super) outcome: &'static str,
    /// Crack length (m).
    pub(super) length: f64,
    /// Exit height (m).
    pub(super) exit: Option<f64>,
    /// Failure load (N).
    pub(super) failure_load: Option<f64>,
    pub(super) broken_bonds: u64,
}

/// A failed realisation.
#[derive(Debug, Serialize)]
pub(super) struct Failure {
    realisation: u64,
    pub(super) reason: String,
}

/// Outcomes of realisations.
#[derive(Debug, Serialize)]
pub(super) struct Outcome {
    pub(super) outcome: &'static str,
    pub(super) probability: Number,
}

/// Distribution of a number.
#[derive(Debug, Serialize)]
pub(super) struct Law {
    /// Number of realisations with a value.
    pub(super) realisations: usize,
    /// Number of realisations without a value.
    pub(super) missing: usize,
    pub(super) mean: Number,
    /// Bootstrap confidence interval; none for fewer than 10 values.
    pub(super) standard_deviation: Option<Interval>,
    pub(super) quantiles: Vec<Quantile>,
}

/// A quantile.
#[derive(Debug, Serialize)]
pub(crate) struct Quantile {
    pub(crate) probability: f64,
    #[serde(flatten)]
    pub(crate) number: Number,
}

impl Quantile {
    /// Quantiles at some probabilities.
    pub(crate) fn all(probabilities: &[f64], values: &[Estimate]) -> Vec<Self> {
        let one =
            |(&probability, &value): (&f64, &Estimate)| Self { probability, number: number(value) };
        probabilities.iter().zip(values).map(one).collect()
    }
}

/// An estimate with its error, which is unknown where no realisation differs from another: they say nothing of it.
fn number(estimate: Estimate) -> Number {
    let number = Number::from(estimate);
    match number.error_kind {
        ErrorOrigin::StandardError if number.error == Some(0.0) => {
            Number::sampled(number.value, None)
        }
        _ => number,
    }
}

/// Fewest realisations whose scatter is an error. Of three, one ensemble in 500 would have the true mean beyond ten errors, of two one
/// in 100.
pub(super) const LEAST_REALISATIONS: usize = 4;

/// The error of a mean such that twice of it holds the true one in 95 % of ensembles although few realisations know their scatter
/// badly: the standard error times the quantile of Student's distribution over that of the normal one.
fn of_few(mean: Number, n: usize) -> Number {
    const NORMAL: f64 = 1.959_963_985;
    if n < LEAST_REALISATIONS {
        return Number::sampled(mean.value, None);
    }
    let by_normal = student_quantile((n - 1) as f64) / NORMAL;
    Number { error: mean.error.map(|error| error * by_normal), ..mean }
}

/// With the error of steps of a load that grows over the run: by the trapezoidal rule over `n` steps it is of the order of one in
/// `n^2`, and exceeds the scatter of the realisations where steps are few.
fn with_steps(mean: Number, n_steps: u64) -> Number {
    let of_steps = mean.value / (n_steps as f64).powi(2);
    Number { error: mean.error.map(|error| error.hypot(of_steps)), ..mean }
}

impl Law {
    /// Of one value, whose error is unknown; none of several.
    fn of_one(values: &[Option<f64>]) -> Option<Self> {
        let [value] = values.iter().flatten().collect::<Vec<_>>()[..] else { return None };
        let mean = Number::sampled(*value, None);
        let (realisations, missing) = (1, values.len() - 1);
        Some(Self { realisations, missing, mean, standard_deviation: None, quantiles: Vec::new() })
    }
}

impl From<&Distribution> for Law {
    fn from(law: &Distribution) -> Self {
        Self {
            realisations: law.n,
            missing: law.missing,
            mean: of_few(number(law.mean), law.n),
            standard_deviation: law.deviation.filter(|it| it.high > it.low),
            quantiles: Quantile::all(&QUANTILES, &law.quantiles),
        }
    }
}

/// Crack height at an abscissa.
#[derive(Debug, Serialize)]
pub(super) struct PathAt {
    pub(super) x: f64,
    /// Probability that a crack reaches it.
    pub(super) reach: Number,
    pub(super) height: Option<Law>,
}

impl From<&Band> for PathAt {
    fn from(band: &Band) -> Self {
        let height = band.heights.as_ref().map(Law::from);
        Self { x: band.x, reach: band.reach.into(), height }
    }
}

/// Load in a window.
#[derive(Debug, Serialize)]
pub(super) struct LoadAt {
    /// Centre of the window (s); none under a quasi-static load, which is observed at the end of each window.
    time: Option<f64>,
    /// Mean strain there; none where a region is displaced.
    pub(super) strain: Option<f64>,
    /// Displacement of the region there (m); none where a mean strain is prescribed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) displacement: Option<f64>,
    pub(super) load: Number,
    /// Standard deviation over realisations; unknown of one.
    pub(super) standard_deviation: Option<f64>,
}

/// A number of each realisation and its distribution.
pub(super) struct Distributed<'a> {
    /// Its key in the result.
    pub(super) key: &'static str,
    pub(super) words: &'static str,
    pub(super) unit: &'static str,
    pub(super) law: &'a Law,
}

impl Record {
    /// Distributions that are known.
    pub(super) fn distributions(&self) -> impl Iterator<Item = Distributed<'_>> {
        [
            ("failure_load", "failure load", "N", &self.failure_load),
            ("exit", "height of exit", "m", &self.exit),
            ("length", "crack length", "m", &self.length),
        ]
        .into_iter()
        .filter_map(|(key, words, unit, law)| {
            Some(Distributed { key, words, unit, law: law.as_ref()? })
        })
    }

    pub(super) fn new(
        scene: &CrackScene,
        problem: &CrackProblem,
        run: &CrackRun,
        ensemble: &CrackEnsemble,
        bootstrap: &Bootstrap,
    ) -> Result<Self, RunError> {
        let mut unknown = Vec::new();
        let counted = || run.records.iter().filter(|record| record.outcome.counts());
        let mut law = |what: &str, law: Result<Distribution, peridyn_sde::Error>, of: Value| {
            let one = || Law::of_one(&counted().map(of).collect::<Vec<_>>());
            match law {
                Ok(law) => Some(Law::from(&law)),
                Err(error) => one().or_else(|| {
                    let (what, reason) = (what.to_owned(), error.to_string());
                    unknown.push(Unknown { what, reason });
                    None
                }),
            }
        };
        let exit = law("exit", ensemble.exit(bootstrap), |record| record.exit);
        let length = law("length", ensemble.length(bootstrap), |record| Some(record.length));
        let mut failure_load =
            law("failure_load", ensemble.failure_load(bootstrap), |record| record.failure_load);
        if let (Some(law), Some(time)) = (&mut failure_load, &scene.time) {
            law.mean = with_steps(law.mean, time.steps);
        }
        let path = match ensemble.bands(&abscissae(scene, problem), bootstrap) {
            Ok(bands) => bands.iter().map(PathAt::from).collect(),
            Err(error) => {
                unknown.push(Unknown { what: "path".into(), reason: error.to_string() });
                Vec::new()
            }
        };
        let ran = |id: usize| !matches!(run.records[id].outcome, CrackOutcome::Failed(_));
        let broken = (0..run.broken.len()).filter(|&id| ran(id)).map(|id| run.broken[id] as f64);
        let broken_bonds = mean(broken).map(|(mean, _)| mean);
        let load = loads(scene, problem, run);
        if broken_bonds.is_none() || load.is_empty() {
            let reason = "no realisation ran to its end".to_owned();
            unknown.push(Unknown { what: "broken_bonds, load".into(), reason });
        }
        unknown.push(of_lattice(scene, problem));
        let outcome = |&(outcome, probability): &(&'static str, Estimate)| Outcome {
            outcome,
            probability: probability.into(),
        };
        let outcomes = ensemble.outcomes().map_err(RunError::solver)?;
        Ok(Self {
            unknown,
            failures: failures(ensemble),
            outcomes: outcomes.iter().map(outcome).collect(),
            path,
            exit,
            length,
            failure_load,
            broken_bonds,
            realisations: run.records.iter().zip(&run.broken).map(realisation).collect(),
            load,
        })
    }
}

fn realisation((record, &broken_bonds): (&CrackRecord, &u64)) -> Realisation {
    Realisation {
        number: record.realisation,
        outcome: record.outcome.name(),
        length: record.length,
        exit: record.exit,
        failure_load: record.failure_load,
        broken_bonds,
    }
}

fn failures(ensemble: &CrackEnsemble) -> Vec<Failure> {
    let failure = |record: &CrackRecord| match &record.outcome {
        CrackOutcome::Failed(reason) => {
            Some(Failure { realisation: record.realisation, reason: reason.clone() })
        }
        _ => None,
    };
    ensemble.failures().filter_map(failure).collect()
}

/// The abscissae of the scene, or every fourth spacing from the tip to the exit.
fn abscissae(scene: &CrackScene, problem: &CrackProblem) -> Vec<f64> {
    if !scene.output.abscissae.is_empty() {
        return scene.output.abscissae.clone();
    }
    from_tip_to_exit(scene, problem).into_iter().step_by(ABSCISSAE_EVERY).collect()
}

/// Every spacing from the tip to the exit, and the exit.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "less than the columns")]
pub(super) fn from_tip_to_exit(scene: &CrackScene, problem: &CrackProblem) -> Vec<f64> {
    let (tip, exit) = (scene.notch.tip[0], problem.resolved.exit);
    let spacing = scene.body.spacing;
    let between = ((exit - tip).abs() / spacing - 1e-9).max(0.0) as u32;
    let forward = (exit - tip).signum() * spacing;
    (1..=between).map(|k| tip + forward * f64::from(k)).chain([exit]).collect()
}

/// Mean with standard error, and standard deviation, both unknown of one value; none without values.
fn mean(values: impl Iterator<Item = f64>) -> Option<(Number, Option<f64>)> {
    let mut sample = Accumulator::default();
    values.for_each(|value| sample.push(value));
    let of_one = (sample.count() > 0).then(|| Number::sampled(sample.mean(), None));
    let mean = sample.estimate().ok().map(number).or(of_one)?;
    Some((mean, sample.variance().ok().map(f64::sqrt)))
}

/// A value that a realisation may have.
type Value = fn(&CrackRecord) -> Option<f64>;

/// What no realisation shows, since all share the lattice.
fn of_lattice(scene: &CrackScene, problem: &CrackProblem) -> Unknown {
    let (spacing, horizon) = (scene.body.spacing, problem.resolved.horizon);
    let reason = format!(
        "errors are those of the realisations, which share a spacing of {} m and a horizon of {} m: run with half of both and compare",
        tidy(spacing),
        tidy(horizon)
    );
    Unknown { what: "error of the lattice".to_owned(), reason }
}

fn loads(scene: &CrackScene, problem: &CrackProblem, run: &CrackRun) -> Vec<LoadAt> {
    let (steps, windows) = (scene.n_steps(), scene.output.windows);
    // Windows are without the remainder of the steps.
    let length = (steps / windows) as f64 / steps as f64;
    let (length, place) = match problem.resolved.duration {
        Some(_) => (length, 0.5),
        None => (1.0 / windows as f64, 1.0),
    };
    let at = |window: usize| {
        let of_window = run.loads.iter().filter_map(|loads| loads.get(window).copied());
        let (load, standard_deviation) = mean(of_window)?;
        let part = (window as f64 + place) * length;
        Some(LoadAt {
            time: problem.resolved.duration.map(|duration| part * duration),
            strain: problem.load_end.strain().map(|strain| part * strain),
            displacement: problem.load_end.displacement().map(|u| part * u),
            load,
            standard_deviation,
        })
    };
    let longest = run.loads.iter().map(Vec::len).max().unwrap_or(0);
    (0..longest).filter_map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_few_realisations_are_by_student_and_those_of_few_steps_count() {
        let error = |n| of_few(Number::sampled(5.0, Some(1.0)), n).error.unwrap_or(f64::NAN);
        // Quantiles of 97.5 % from tables, over that of the normal distribution.
        for (n, student) in [(4, 3.182), (6, 2.571), (11, 2.228), (61, 2.000)] {
            assert!((error(n) * 1.959_964 / student - 1.0).abs() < 0.01, "{n}: {}", error(n));
        }
        assert_eq!(of_few(Number::sampled(5.0, None), 4).error, None);
        assert_eq!(of_few(Number::sampled(5.0, Some(1.0)), 3).error, None);
        let of = |n| with_steps(Number::sampled(8.0, Some(0.03)), n).error.unwrap_or(f64::NAN);
        // 8/20^2 = 0.02.
        assert!((of(20) - 0.03_f64.hypot(0.02)).abs() < 1e-15 && of(2000) < 0.030_001);
    }
}
