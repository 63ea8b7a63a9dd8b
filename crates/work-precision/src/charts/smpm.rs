//! Error of the variance against CPU time: five methods on a plane shock and on an explosion.

use perturbation_moments::MonteCarlo;

use result_figures::{Drawing, Measure, Method, Run, RunOutcome, Words, WorkPrecision};
use scenes::clock::CpuClock;
use scenes::machine::Machine;
use scenes::smpm::experiment::SceneExperiment;
use scenes::smpm::reading::MOST_RANDOM;
use scenes::smpm::scene::SmpmScene;
use smpm::uncertainty::{FrozenForm, Series, Study};
use uq_estimators::{ControlledSamples, SampledMoments, Surrogate};

use super::cost::{LONG, cost_in_seconds, group_thousands, outcome, run, table, timed};
use crate::draw::ChartKind;
use crate::problems::shock;
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::quantile::quantile;
use reference_problems::smpm::problems::{Problem, experiment};

pub(crate) const CHART: ChartKind = ChartKind {
    name: "smpm",
    title: "five methods on a shock and on an explosion: error of the variance against CPU time",
    draw,
};

/// Sizes of the sampled ensembles.
const LADDER: [usize; 5] = [10, 30, 100, 300, 1000];
/// Parts of the samples that are timed separately.
const THIRDS: usize = 3;
/// Seed of the compared samples, and of the reference samples.
const SEEDS: [u64; 2] = [11, 2019];

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    // One thread, so CPU time is that of one core.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| {
        let mut drawings = vec![shock(context)?];
        let strengths: &[f64] = match context.profile {
            Profile::Quick => &[0.15],
            _ => &[0.05, 0.15],
        };
        for &strength in strengths {
            drawings.extend(explosion(context, strength)?);
        }
        Ok(drawings)
    })
}

/// Rungs of the ladder to run.
fn ladder(context: &Context<'_>) -> &'static [usize] {
    if context.profile == Profile::Quick { &LADDER[..2] } else { &LADDER }
}

fn shock(context: &Context<'_>) -> Result<Drawing, CaseError> {
    // Scheme and cell are those of the scene.
    let usual = Problem::PlateImpact.scene()?;
    let mut scene = shock::scene(&usual.scheme, usual.grid.cell)?;
    let strength = scene.random[0].coefficient_of_variation;
    scene.times.truncate(1);
    context.progress("shock");
    let experiment = experiment::<1>(&scene)?;
    let solved = Solved::of(&experiment, &scene, ladder(context))?;
    let truth = vec![shock::variance(strength)];
    let question = Question { responses: vec![0], truth, truth_error: 0.0 };
    let words = Words {
        title: "Variance of the pressure behind a plane shock in steel, against cost".into(),
        subtitle: format!(
            "plate at 1 km/s on a rigid wall; S1, gamma0 and a normal, coefficient of variation {strength}; mean over a window"
        ),
        x_label: "CPU time on one thread (s)".into(),
        y_label: "relative error of Var p".into(),
        caption: vec![
            "Against the exact variance: p is linear in S1 and does not depend on gamma0 and a. The remainder at the right is the grid error, common to all methods but the frozen one.".into(),
        ],
    };
    solved.drawing("smpm-cost-shock-pressure", words, &question)
}

/// After first yield of all four gauges (us).
const TIMES: [f64; 4] = [9.0, 10.0, 11.0, 12.0];

fn explosion(context: &Context<'_>, strength: f64) -> Result<Vec<Drawing>, CaseError> {
    let quantities =
        [("flow_stress", "flow-stress", "sigma_y"), ("deviator_11", "deviator-11", "S11")];
    let mut scene = Problem::ContactExplosion.scene_with(strength, &TIMES)?;
    scene.quantities = quantities.iter().map(|(name, ..)| (*name).to_owned()).collect();
    context.progress(&format!("explosion, coefficient of variation {strength}"));
    let experiment = experiment::<2>(&scene)?;
    let solved = Solved::of(&experiment, &scene, ladder(context))?;
    let plan = scene.plan::<2>()?;
    let study = Study::new(&experiment, scene.inputs()?, plan)?;
    let n_samples = if context.profile == Profile::Quick { 60 } else { 1000 };
    context.progress("explosion: reference samples");
    let judge = study.monte_carlo(MonteCarlo { seed: SEEDS[1], n_samples })?;
    let mut drawings = Vec::new();
    for (q, (_, id, letter)) in quantities.into_iter().enumerate() {
        let plan = study.plan();
        let responses: Vec<usize> =
            (0..plan.n_responses()).filter(|&response| plan.parts(response).1 == q).collect();
        let (mut truth, mut errors) = (Vec::new(), Vec::new());
        for &response in &responses {
            let found = judge.controlled(response, &solved.surrogate[response])?.variance;
            truth.push(found.value);
            errors.push(found.standard_error().unwrap_or(f64::NAN) / found.value);
        }
        let truth_error = quantile(&errors, 0.5);
        let words = Words {
            title: format!("Variance of {letter} behind a contact explosion, against cost"),
            subtitle: format!(
                "4340 steel, A, B, n, C, m normal, coefficient of variation {strength}; median over gauges H, I, G, K at 9, 10, 11, 12 us"
            ),
            x_label: "CPU time on one thread (s)".into(),
            y_label: format!("relative error of Var {letter}"),
            caption: vec![format!(
                "Against {} other samples with control variate, whose own standard error is {truth_error:.1e} (median).",
                judge.n_samples(),
            )],
        };
        let question = Question { responses, truth, truth_error };
        let name = format!("smpm-cost-{id}-{}", format!("{strength:.2}").replace('.', ""));
        drawings.push(solved.drawing(&name, words, &question)?);
    }
    Ok(drawings)
}

/// Quantities compared between methods.
struct Question {
    responses: Vec<usize>,
    /// Reference variance of each.
    truth: Vec<f64>,
    /// Median relative error of the references.
    truth_error: f64,
}

impl Question {
    /// Median of the relative error over the responses.
    fn error(&self, variance: impl Fn(usize) -> f64) -> f64 {
        let off = |(&response, truth): (&usize, &f64)| (variance(response) / truth - 1.0).abs();
        let errors: Vec<f64> = self.responses.iter().zip(&self.truth).map(off).collect();
        quantile(&errors, 0.5)
    }
}

/// A method with a single result: its variance of every response.
struct Single {
    name: &'static str,
    cost: f64,
    spread: f64,
    variances: Vec<f64>,
}

/// A scene solved by all methods.
struct Solved {
    singles: Vec<Single>,
    /// Taylor moments from differences: the control variate.
    surrogate: Vec<Series>,
    /// Normals and responses of the successful samples.
    samples: Vec<([f64; MOST_RANDOM], Vec<f64>)>,
    n_failed: usize,
    ladder: Vec<usize>,
    /// CPU time of the reference run, the differences, and a sample (s).
    costs: [f64; 3],
    /// Half the range of the last time over thirds of the samples.
    sample_spread: f64,
}

impl Solved {
    fn of<const D: usize>(
        experiment: &SceneExperiment<D>,
        scene: &SmpmScene,
        ladder: &[usize],
    ) -> Result<Self, CaseError> {
        let (study, mean_run, _) = timed(LONG, || {
            let plan = scene.plan::<D>()?;
            Ok(Study::new(experiment, scene.inputs()?, plan)?)
        })?;
        let mut singles = Vec::new();
        let mut add = |name, (variances, cost, spread): (Vec<f64>, f64, f64)| {
            singles.push(Single { name, cost: mean_run + cost, spread, variances });
            cost
        };
        let of_frozen = |form| {
            let variance =
                |series: &Option<Series>| series.as_ref().map_or(f64::NAN, Series::variance);
            timed(LONG, || Ok(study.frozen(form)?.iter().map(variance).collect()))
        };
        add("frozen, as printed", of_frozen(FrozenForm::Printed)?);
        add("frozen, corrected", of_frozen(FrozenForm::Corrected)?);
        let (propagated, jets, spread) = timed(LONG, || Ok(study.propagated()?.moments))?;
        let first_order = |moments: &[Series]| moments.iter().map(Series::variance).collect();
        add("propagated, by jets", (first_order(&propagated), jets, spread));
        let (surrogate, differences, spread) =
            timed(LONG, || Ok(study.finite_difference(DIFFERENCE)?))?;
        let variances = first_order(&surrogate);
        add("finite differences, 2N + 1 runs", (variances, differences, spread));
        add(
            "sigma points, 2N + 1 runs",
            timed(LONG, || {
                Ok(study.sigma_points()?.iter().map(Series::surrogate_variance).collect())
            })?,
        );
        add(
            "one-sided differences, N + 1 runs",
            timed(LONG, || Ok(first_order(&study.forward_difference(ONE_SIDED)?)))?,
        );
        let n_samples = ladder.last().copied().unwrap_or(0);
        let judged = MonteCarlo { seed: SEEDS[0], n_samples: n_samples as u64 };
        let (mut samples, mut n_failed) = (Vec::new(), 0);
        let mut times = [0.0; THIRDS];
        for (third, time) in (0..).zip(&mut times) {
            let place = |third: u64| third * judged.n_samples / THIRDS as u64;
            let clock = CpuClock::start();
            for realisation in place(third)..place(third + 1) {
                let t = judged.normals(realisation);
                match study.run(&t) {
                    Ok(values) => samples.push((t, values)),
                    Err(_) => n_failed += 1,
                }
            }
            *time = clock.seconds() / (place(third + 1) - place(third)) as f64;
        }
        times.sort_by(f64::total_cmp);
        let [fastest, median, slowest] = times;
        Ok(Self {
            singles,
            surrogate,
            samples,
            n_failed,
            ladder: ladder.to_vec(),
            costs: [mean_run, differences, median],
            sample_spread: 0.5 * (slowest - fastest),
        })
    }

    /// Raw or controlled moments of a response from some of the samples.
    fn sampled(
        &self,
        response: usize,
        samples: &[([f64; MOST_RANDOM], Vec<f64>)],
        is_controlled: bool,
    ) -> Result<SampledMoments, CaseError> {
        let surrogate = &self.surrogate[response];
        let pairs: Vec<[f64; 2]> =
            samples.iter().map(|(t, values)| [values[response], surrogate.surrogate(t)]).collect();
        let controlled = ControlledSamples {
            samples: pairs.as_flattened(),
            surrogates: &[Surrogate {
                mean: surrogate.mean(),
                variance: Some(surrogate.surrogate_variance()),
            }],
            seed: SEEDS[0],
        };
        Ok(if is_controlled { controlled.estimate()? } else { controlled.raw()? })
    }

    /// Error of ensembles of `n` samples: the mean over all disjoint ensembles, with its standard error.
    ///
    /// For a single ensemble the standard error is that of its variance.
    fn ensemble(
        &self,
        question: &Question,
        n: usize,
        is_controlled: bool,
    ) -> Result<Run, CaseError> {
        let mut errors = Vec::new();
        let mut own = Vec::new();
        for batch in self.samples.chunks_exact(n.min(self.samples.len())) {
            let mut found = Vec::new();
            for &response in &question.responses {
                found.push(self.sampled(response, batch, is_controlled)?.variance);
            }
            let place = |response| question.responses.iter().position(|&r| r == response);
            errors.push(
                question.error(|response| place(response).map_or(f64::NAN, |k| found[k].value)),
            );
            let relative: Vec<f64> = found
                .iter()
                .zip(&question.truth)
                .map(|(found, truth)| found.standard_error().unwrap_or(f64::NAN) / truth)
                .collect();
            own.push(quantile(&relative, 0.5));
        }
        let count = errors.len() as f64;
        let value = errors.iter().sum::<f64>() / count;
        let square = errors.iter().map(|error| (error - value).powi(2)).sum::<f64>();
        let standard_error =
            if errors.len() > 1 { (square / (count - 1.0) / count).sqrt() } else { own[0] };
        let [mean_run, differences, sample] = self.costs;
        let control = if is_controlled { differences } else { 0.0 };
        let outcome = RunOutcome::Error { value, standard_error: Some(standard_error) };
        let cost = mean_run + control + sample * n as f64;
        let label = Some(group_thousands(n as u64));
        Ok(run((cost, self.sample_spread * n as f64), outcome, label))
    }

    fn drawing(
        &self,
        name: &str,
        mut words: Words,
        question: &Question,
    ) -> Result<Drawing, CaseError> {
        let single = |single: &Single| {
            let outcome = outcome(question.error(|response| single.variances[response]));
            let runs = vec![run((single.cost, single.spread), outcome, None)];
            Method { name: single.name.into(), runs }
        };
        let mut series: Vec<Method> = self.singles.iter().map(single).collect();
        for (name, is_controlled) in [
            ("Monte Carlo, raw (samples)", false),
            (
                "Monte Carlo with a Taylor series from differences as control variate (samples)",
                true,
            ),
        ] {
            let runs = self.ladder.iter().map(|&n| self.ensemble(question, n, is_controlled));
            series.push(Method { name: name.into(), runs: runs.collect::<Result<_, _>>()? });
        }
        words.caption.push(format!(
            "A Monte Carlo point is the mean error of as many ensembles as {} samples hold, the bar its standard error (of one ensemble: its own). {} samples failed. Across: median CPU time of three runs, the bar half their range; of a sample, of three thirds of all.",
            self.samples.len(), self.n_failed
        ));
        words.caption.push(Machine::read().caption());
        let table = table(&series);
        let reading = cost_in_seconds(Measure::Relative, question.truth_error);
        let chart = WorkPrecision { words, reading, series };
        Ok(Drawing::work_precision(name, &chart)?.with_rows(&table))
    }
}

/// Step of differences, in standard deviations.
const DIFFERENCE: f64 = 0.02;
/// The same for differences that are of first order in it.
const ONE_SIDED: f64 = 2e-3;
