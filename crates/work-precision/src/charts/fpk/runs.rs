//! Runs of each method on the questions of a scene.

use std::time::Duration;

use fpk_sph::{
    Combination, Config, DEFAULT_MOST_STEPS, Estimator, InitialLattice, Method, Scheme, Settling,
    StepRule,
};
use random_vibration::{
    ExceedanceQuestion, GridConfig, GridDensity, GuidedConfig, GuidedPaths, Linearisation,
    TailPaths, Tails,
};
use result_figures::Reference;
use scenes::fpk::density::{self, Erased};
use scenes::fpk::monte_carlo::{self, Sampling};
use scenes::fpk::paths::Paths;
use sde_integrators::{Additive, Estimate, GaussianMixture, Integrator, Sde, SubsetConfig};

use super::question::{Quantity, Question};
use super::records::{Outcome, Record};
use crate::charts::cost::{group_thousands, timed};
use reference_problems::context::{CaseError, Context, Profile};

/// A scheme, its fewest steps per period, the part of the second moments whose cells its limit leaves out, and settling.
type Steps = (Scheme, f64, f64, Settling);

/// Methods of the density solver for every scene, with their steps if these are not those of the method: a new one is one line.
const METHODS: &[(&str, Method, Option<Steps>)] = &[
    ("particles, flow-map fit", Method::FlowMapFit, None),
    (
        "particles, flow-map fit, one evaluation",
        Method::FlowMapFit,
        Some((Scheme::LawsonAdamsBashforth2, 40.0, 0.0, Settling::UNIFORM)),
    ),
    (
        "particles, flow-map fit, one evaluation, 1 % negligible",
        Method::FlowMapFit,
        Some((Scheme::LawsonAdamsBashforth2, 40.0, 0.01, Settling::UNIFORM)),
    ),
    (
        "particles, flow-map fit, one evaluation, 1 % negligible, graded",
        Method::FlowMapFit,
        Some((Scheme::LawsonAdamsBashforth2, 40.0, 0.01, Settling::GRADED)),
    ),
];

/// A method with other steps, if they are given.
fn with_steps<const D: usize>(method: Method, steps: Option<Steps>) -> Method {
    steps.map_or(method, |(scheme, steps_per_period, negligible, graded)| {
        let step = StepRule::PeriodFraction { steps_per_period };
        let mut all = Combination { scheme, step, negligible, ..method.combination_in(D) };
        if let Estimator::FlowMapFit { settling, .. } = &mut all.estimator {
            *settling = graded;
        }
        Method::Custom(all)
    })
}

/// A method of the density solver on successively finer lattices.
pub(super) struct Ladder<const D: usize> {
    name: &'static str,
    method: Method,
    lattices: Vec<InitialLattice<D>>,
    /// Whether tails are integrated over cells, which needs a flow map.
    cells: bool,
}

/// All [`METHODS`] on the same lattices.
pub(super) fn usual<const D: usize>(lattices: &[InitialLattice<D>]) -> Vec<Ladder<D>> {
    let ladder = |&(name, method, steps)| {
        let method = with_steps::<D>(method, steps);
        Ladder { name, method, lattices: lattices.to_vec(), cells: true }
    };
    METHODS.iter().map(ladder).collect()
}

/// The method as printed, on the rectangle of the paper with other numbers of particles.
pub(super) fn papers_ladder() -> Ladder<2> {
    let rectangle = |count| InitialLattice::Rectangle { half_width: [0.6, 0.4], count };
    Ladder {
        name: "particles, Canor & Denoël 2013",
        method: Method::CanorDenoel2013,
        lattices: [[25, 17], [36, 24], [50, 33], [71, 47]].map(rectangle).to_vec(),
        cells: false,
    }
}

/// CPU time above which a run is not repeated.
const LONG: Duration = Duration::from_secs(1);

/// The answers of one run: moments, and probabilities per time and threshold.
struct Answers<T> {
    moments: Vec<T>,
    rows: Vec<Vec<T>>,
}

/// The method, its parameter, and its CPU time with half the range over repeated runs.
struct Run<'a> {
    method: &'a str,
    label: String,
    cost: (f64, f64),
}

impl Run<'_> {
    fn record(&self, quantity: &Quantity, outcome: Outcome) -> Record {
        Record {
            quantity: quantity.name.into(),
            method: self.method.into(),
            label: self.label.clone(),
            cpu_seconds: self.cost.0,
            cpu_spread: self.cost.1,
            outcome,
        }
    }

    /// Records of a deterministic method, which answers all quantities at once.
    fn records<const D: usize>(
        &self,
        question: &Question<D>,
        found: &Result<Answers<f64>, String>,
    ) -> Vec<Record> {
        let outcome = |quantity: &Quantity| match found {
            Err(reason) => Outcome::Nothing { reason: reason.clone() },
            Ok(Answers { moments, .. }) if quantity.cells.is_empty() => {
                worst(question.moments.iter().map(|(_, r)| r).zip(moments.iter().copied()))
            }
            Ok(Answers { rows, .. }) => {
                let value = |((time, threshold), _): &((usize, usize), _)| rows[*time][*threshold];
                if quantity.cells.iter().any(|cell| value(cell) <= 0.0) {
                    let reason = "no mass beyond the threshold".into();
                    return Outcome::Nothing { reason };
                }
                worst(quantity.cells.iter().map(|cell| (&cell.1, value(cell))))
            }
        };
        let quantities = question.quantities.iter();
        quantities.map(|quantity| self.record(quantity, outcome(quantity))).collect()
    }
}

/// The largest relative error. A value that is no number is as wrong as can be.
fn largest<'r>(pairs: impl Iterator<Item = (&'r Reference, f64)>) -> f64 {
    let off = |(reference, value): (&Reference, f64)| (value / reference.value - 1.0).abs();
    pairs.map(off).fold(0.0, |a, b| if b.is_nan() { f64::INFINITY } else { a.max(b) })
}

fn worst<'r>(pairs: impl Iterator<Item = (&'r Reference, f64)>) -> Outcome {
    let error = largest(pairs);
    if error.is_finite() {
        Outcome::Off { error }
    } else {
        Outcome::Nothing { reason: format!("the error is {error}") }
    }
}

/// What all methods need of a scene.
pub(super) struct Setting<'a, S, I, const D: usize> {
    pub(super) context: &'a Context<'a>,
    pub(super) name: &'static str,
    pub(super) system: &'a S,
    pub(super) law: &'a GaussianMixture<D>,
    /// Period that determines the steps of the particles (s).
    pub(super) period: f64,
    /// Integrator of a path.
    pub(super) integrator: &'a I,
    pub(super) rule: &'a Linearisation<D>,
}

/// Independent runs of subset simulation; their scatter is the error.
const SUBSET_RUNS: u64 = 10;
/// Steps of the linearisation that guides paths, per period.
const STEPS_OF_GUIDE: f64 = 20.0;

impl<S, I, const D: usize> Setting<'_, S, I, D> {
    /// Rungs of a ladder to run: the first two in a quick run.
    fn rungs<T: Clone>(&self, all: &[T]) -> Vec<T> {
        let n = if self.context.profile == Profile::Quick { all.len().min(2) } else { all.len() };
        all[..n].to_vec()
    }

    fn tell(&self, run: &Run<'_>) {
        let Run { method, label, cost: (seconds, _) } = run;
        self.context.progress(&format!("{}: {method}, {label}, {seconds:.2} s", self.name));
    }

    /// The density solver on successively finer lattices, and statistical linearisation.
    pub(super) fn by_density(
        &self,
        question: &Question<D>,
        ladders: &[Ladder<D>],
    ) -> Result<Vec<Record>, CaseError>
    where
        S: Sde<D, 1, Noise = Additive>,
    {
        let mut records = Vec::new();
        for &Ladder { name, method, ref lattices, cells } in ladders {
            let asked = question.asked(cells);
            for lattice in self.rungs(lattices) {
                let (reference_period, most_steps) = (self.period, DEFAULT_MOST_STEPS);
                let config = Config { method, lattice, reference_period, most_steps };
                let (run, seconds, spread) = timed(LONG, || {
                    let system: Erased<'_, Additive, D, 1> = Erased(self.system);
                    Ok(density::run_on(system, self.law, &config, &asked, |_, _| ())?)
                })?;
                let label = group_thousands(run.n_particles as u64);
                let timed = Run { method: name, label, cost: (seconds, spread) };
                self.tell(&timed);
                let last = run.rows.last();
                let found = match &run.stopped {
                    _ if run.rows.len() == question.times.len() => {
                        let probability = |p: &density::Exceedances| {
                            p.cell_integrated.unwrap_or(p.log_interpolated)
                        };
                        let row =
                            |row: &density::Row| row.exceedances.iter().map(probability).collect();
                        Ok(Answers {
                            moments: last.map_or_else(Vec::new, |row| row.moments.clone()),
                            rows: run.rows.iter().map(row).collect(),
                        })
                    }
                    Some(stopped) => Err(stopped.to_string()),
                    None => Err("no row".to_owned()),
                };
                let mut found = timed.records(question, &found);
                // A moment requires no integral over cells.
                if let (false, Some(row)) = (question.moments.is_empty(), last) {
                    found[0].cpu_seconds = row.cpu_seconds;
                }
                records.extend(found);
            }
        }
        records.extend(self.linearised(question)?);
        Ok(records)
    }

    /// One linearisation, with the tails of its normal distributions.
    fn linearised(&self, question: &Question<D>) -> Result<Vec<Record>, CaseError>
    where
        S: Sde<D, 1, Noise = Additive>,
    {
        let (laws, seconds, spread) =
            timed(LONG, || Ok(self.rule.laws(self.system, self.law, &question.times)?))?;
        let last = laws.last().ok_or("no law")?;
        let displacement = std::array::from_fn(|i| f64::from(u8::from(i == 0)));
        let row = |law: &random_vibration::GaussianLaw<D>| {
            question.thresholds.iter().map(|t| law.exceedance(&displacement, *t)).collect()
        };
        let found = Answers {
            moments: question.moments.iter().map(|(powers, _)| last.raw_moment(*powers)).collect(),
            rows: laws.iter().map(row).collect(),
        };
        let (method, label) = ("statistical linearisation", String::new());
        Ok(Run { method, label, cost: (seconds, spread) }.records(question, &Ok(found)))
    }

    /// Samples by Monte Carlo, guided paths and subset simulation.
    pub(super) fn sampled(&self, question: &Question<D>) -> Result<Vec<Record>, CaseError>
    where
        S: Paths<D, 1> + Sde<D, 1, Noise = Additive>,
        I: Integrator<S, D, 1>,
    {
        let mut records = Vec::new();
        for paths in self.rungs(&[1_000_u64, 10_000, 100_000, 1_000_000]) {
            records.extend(self.plain(question, paths)?);
        }
        for quantity in question.quantities.iter().filter(|quantity| !quantity.cells.is_empty()) {
            for samples in self.rungs(&[500_u64, 2_000, 20_000, 100_000]) {
                let words = ("guided paths", group_thousands(samples));
                let run = || self.guided(question, quantity, samples);
                records.push(self.estimated(quantity, words, None, run)?);
            }
            // One probability at a time, so a surface takes the smallest runs alone.
            let sizes = if quantity.cells.len() == 1 { &[200, 500, 1_500][..] } else { &[200] };
            for n_samples in self.rungs(sizes) {
                let config = SubsetConfig { n_samples, correlation: 0.8, n_runs: SUBSET_RUNS };
                let label = format!("{SUBSET_RUNS} x {}", group_thousands(n_samples as u64));
                // A standard deviation from n values has the relative error 1/sqrt(2 (n - 1)).
                let known_to = (2.0 * (SUBSET_RUNS as f64 - 1.0)).sqrt().recip();
                let run = || self.subset(question, quantity, &config);
                let words = ("subset simulation", label);
                records.push(self.estimated(quantity, words, Some(known_to), run)?);
            }
        }
        Ok(records)
    }

    /// One run of free paths, observed at all times. The standard error of a probability is that of the binomial
    /// distribution at the smallest reference, so that a sample without hits has an error too.
    fn plain(&self, question: &Question<D>, paths: u64) -> Result<Vec<Record>, CaseError>
    where
        S: Paths<D, 1>,
    {
        let (until, n_steps) = question.span();
        let sampling = Sampling { paths, step: until / n_steps as f64, seed: paths };
        let asked = question.asked(false);
        let (run, seconds, spread) =
            timed(LONG, || Ok(monte_carlo::run_on(self.system, self.law, &sampling, &asked)?))?;
        let method = format!("Monte Carlo, {}", S::INTEGRATOR.name());
        let timed = Run { method: &method, label: group_thousands(paths), cost: (seconds, spread) };
        self.tell(&timed);
        let estimates = Answers {
            moments: run.rows.last().ok_or("no row")?.moments.clone(),
            rows: run.rows.iter().map(|row| row.exceedances.clone()).collect(),
        };
        let mut records = Vec::new();
        for quantity in &question.quantities {
            let outcome = if quantity.cells.is_empty() {
                let (mut predicted, mut seen) = (0.0_f64, 0.0_f64);
                for ((_, reference), estimate) in question.moments.iter().zip(&estimates.moments) {
                    let error = estimate.standard_error().ok_or("no standard error")?;
                    let error = error / reference.value;
                    if error > predicted {
                        (predicted, seen) = (error, (estimate.value / reference.value - 1.0).abs());
                    }
                }
                Outcome::Sampled { predicted, uncertainty: None, seen: Some(seen) }
            } else {
                let smallest = quantity.cells.iter().map(|(_, p)| p.value).fold(1.0, f64::min);
                let expected = smallest * paths as f64;
                let cells = quantity.cells.iter();
                let pairs = cells.map(|((time, k), p)| (p, estimates.rows[*time][*k].value));
                if expected >= 1.0 {
                    Outcome::Sampled {
                        predicted: ((1.0 - smallest) / expected).sqrt(),
                        uncertainty: None,
                        seen: Some(largest(pairs)),
                    }
                } else {
                    let reason = format!("{expected:.0e} paths expected beyond it");
                    Outcome::Nothing { reason }
                }
            };
            records.push(timed.record(quantity, outcome));
        }
        Ok(records)
    }

    /// Runs a method that estimates the cells of one quantity; that there is no estimate is a result too.
    fn estimated(
        &self,
        quantity: &Quantity,
        (method, label): (&str, String),
        known_to: Option<f64>,
        mut run: impl FnMut() -> Result<Vec<Estimate>, CaseError>,
    ) -> Result<Record, CaseError> {
        let (found, seconds, spread) = timed(LONG, || Ok(run()))?;
        let timed = Run { method, label, cost: (seconds, spread) };
        self.tell(&timed);
        let outcome = match found {
            Err(error) => Outcome::Nothing { reason: error.to_string() },
            Ok(estimates) if estimates.iter().any(|estimate| estimate.value <= 0.0) => {
                Outcome::Nothing { reason: "no sample beyond it".into() }
            }
            Ok(estimates) => {
                let relative = |((_, p), estimate): (&(_, Reference), &Estimate)| {
                    estimate.standard_error().unwrap_or(f64::INFINITY) / p.value
                };
                let cells = quantity.cells.iter().zip(&estimates);
                let predicted = cells.map(relative).fold(0.0, f64::max);
                let references = quantity.cells.iter().map(|(_, reference)| reference);
                let seen = largest(references.zip(estimates.iter().map(|found| found.value)));
                if predicted.is_finite() {
                    let uncertainty = known_to.map(|part| part * predicted);
                    Outcome::Sampled { predicted, uncertainty, seen: Some(seen) }
                } else {
                    Outcome::Nothing { reason: "an estimate without an error".into() }
                }
            }
        };
        Ok(timed.record(quantity, outcome))
    }

    /// Guided paths with all that they need, linearisation and pilot paths: a set for each time, which serves all thresholds.
    fn guided(
        &self,
        question: &Question<D>,
        quantity: &Quantity,
        samples: u64,
    ) -> Result<Vec<Estimate>, CaseError>
    where
        S: Sde<D, 1, Noise = Additive>,
        I: Integrator<S, D, 1>,
    {
        let rule = Linearisation { step: self.period / STEPS_OF_GUIDE, ..*self.rule };
        let paths =
            GuidedPaths::new(self.system, self.integrator, self.law, question.span(), &rule)?;
        let n_pilots = (samples / 4).clamp(200, 1_000);
        let config = GuidedConfig { n_paths: samples, n_pilots, unguided: 0.05, seed: samples };
        let distinct = |of: fn(&(usize, usize)) -> usize| {
            let all: std::collections::BTreeSet<usize> =
                quantity.cells.iter().map(|(cell, _)| of(cell)).collect();
            all.into_iter().collect::<Vec<_>>()
        };
        let (times, thresholds) = (distinct(|cell| cell.0), distinct(|cell| cell.1));
        let n_steps: Vec<usize> =
            times.iter().map(|time| (time + 1) * question.steps_each).collect();
        let levels: Vec<f64> = thresholds.iter().map(|&k| question.thresholds[k]).collect();
        let asked = ExceedanceQuestion {
            thresholds: &levels,
            n_steps: &n_steps,
            tails: Tails::Doubled,
            smallest: quantity.smallest,
        };
        let found = paths.exceedances(&asked, &config)?;
        let estimate = |((time, k), _): &((usize, usize), Reference)| {
            let place = |all: &[usize], one: usize| all.partition_point(|&other| other < one);
            match &found[place(&times, *time)][place(&thresholds, *k)] {
                Ok(found) => Ok(found.estimate),
                Err(error) => Err(error.to_string().into()),
            }
        };
        quantity.cells.iter().map(estimate).collect()
    }

    fn subset(
        &self,
        question: &Question<D>,
        quantity: &Quantity,
        config: &SubsetConfig,
    ) -> Result<Vec<Estimate>, CaseError>
    where
        S: Sde<D, 1, Noise = Additive>,
        I: Integrator<S, D, 1>,
    {
        let estimate = |((time, k), _): &((usize, usize), Reference)| {
            let span = (question.times[*time], (time + 1) * question.steps_each);
            let paths = TailPaths::new::<_, _, 1>(self.system, self.integrator, self.law, span)?;
            Ok(paths.subset(question.thresholds[*k], config, config.n_samples as u64)?)
        };
        quantity.cells.iter().map(estimate).collect()
    }
}

impl<S, I> Setting<'_, S, I, 2>
where
    S: Sde<2, 1, Noise = Additive>,
{
    /// The grid: one run observed at all times.
    pub(super) fn on_grid(&self, question: &Question<2>) -> Result<Vec<Record>, CaseError> {
        /// Cells along each axis, with the steps per period.
        const GRIDS: [(usize, f64); 5] =
            [(40, 16.0), (56, 24.0), (80, 40.0), (112, 60.0), (160, 100.0)];
        let mut records = Vec::new();
        for (cells, steps_per_period) in self.rungs(&GRIDS) {
            let config = GridConfig { cells, reach: 8.0, period: self.period, steps_per_period };
            let (found, seconds, spread) = timed(LONG, || {
                let mut density = GridDensity::new(self.system, self.law, config)?;
                let mut rows = Vec::new();
                for &t in &question.times {
                    density.advance_to(t)?;
                    let thresholds = question.thresholds.iter();
                    rows.push(thresholds.map(|t| density.exceedance(*t)).collect());
                }
                let moments = question.moments.iter();
                let moments = moments.map(|(powers, _)| density.raw_moment(*powers));
                Ok(Answers { moments: moments.collect::<Result<_, _>>()?, rows })
            })?;
            let run = Run { method: "grid", label: format!("{cells}²"), cost: (seconds, spread) };
            self.tell(&run);
            records.extend(run.records(question, &Ok(found)));
        }
        Ok(records)
    }
}
