//! Runs of each method on one scene.

use std::time::Duration;

use fpk_sph::{
    Combination, Config, DEFAULT_MOST_STEPS, Estimator, InitialLattice, Method, Scheme, Settling,
    StepRule,
};
use random_vibration::{
    GridConfig, GridDensity, GuidedConfig, GuidedPaths, Linearisation, TailPaths, Tails,
};
use result_figures::Reference;
use scenes::fpk::density::{self, Demand, DensityRun, Erased, Requested};
use scenes::fpk::monte_carlo::{self, Sampling};
use scenes::fpk::paths::Paths;
use sde_integrators::{Additive, Estimate, GaussianMixture, Integrator, Sde, SubsetConfig};

use super::records::{Outcome, Quantity, Record, Scene};
use crate::charts::fpk::{group_thousands_u64, timed};
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
    pub(super) name: &'static str,
    pub(super) method: Method,
    pub(super) lattices: Vec<InitialLattice<D>>,
}

/// All [`METHODS`] on the same lattices.
pub(super) fn usual<const D: usize>(lattices: &[InitialLattice<D>]) -> Vec<Ladder<D>> {
    let ladder = |&(name, method, steps)| {
        let method = with_steps::<D>(method, steps);
        Ladder { name, method, lattices: lattices.to_vec() }
    };
    METHODS.iter().map(ladder).collect()
}

/// CPU time above which a run is not repeated.
pub(super) const LONG: Duration = Duration::from_secs(1);

/// Rungs of a ladder to run: the first two in a quick run.
pub(super) fn rungs<T: Clone>(context: &Context<'_>, all: &[T]) -> Vec<T> {
    let n = if context.profile == Profile::Quick { all.len().min(2) } else { all.len() };
    all[..n].to_vec()
}

/// One probability `P(|q| > T)`.
pub(super) struct Target {
    pub(super) name: &'static str,
    pub(super) threshold: f64,
    pub(super) reference: Reference,
}

/// Quantities and inputs common to all methods.
pub(super) struct Setting<'a, S, I, const D: usize> {
    pub(super) name: &'static str,
    pub(super) title: String,
    pub(super) system: &'a S,
    pub(super) law: &'a GaussianMixture<D>,
    /// Period that determines the steps of the particles (s).
    pub(super) period: f64,
    pub(super) time: f64,
    /// `E[q^2]` and `E[q'^2]`.
    pub(super) moments: [([u32; D], Reference); 2],
    pub(super) targets: Vec<Target>,
    /// Integrator of a path.
    pub(super) integrator: &'a I,
    pub(super) n_steps: u32,
}

/// Name of the quantity with both second moments.
const MOMENTS: &str = "moments";

impl<S, I, const D: usize> Setting<'_, S, I, D> {
    /// The scene, without records.
    pub(super) fn scene(&self) -> Scene {
        let mut quantities = vec![Quantity {
            name: MOMENTS,
            title: "Second moments: the worse of E[q^2] and E[q'^2]".into(),
            reference_error: self.moments.iter().map(|(_, r)| relative(r)).fold(0.0, f64::max),
        }];
        quantities.extend(self.targets.iter().map(|target| Quantity {
            name: target.name,
            title: format!(
                "Probability P(|q| > {:.3}) = {:.1e}",
                target.threshold, target.reference.value
            ),
            reference_error: relative(&target.reference),
        }));
        Scene { name: self.name, title: self.title.clone(), quantities, records: Vec::new() }
    }

    fn asked(&self, cells: bool) -> Requested<D> {
        Requested {
            times: vec![self.time],
            powers: self.moments.iter().map(|(powers, _)| *powers).collect(),
            demand: Demand::of_state(0, "q", D),
            thresholds: self.targets.iter().map(|target| target.threshold).collect(),
            cells,
        }
    }

    /// The larger error of both moments.
    fn moment_error(&self, values: &[f64]) -> Outcome {
        let off = |((_, reference), value): (&(_, Reference), &f64)| {
            (value / reference.value - 1.0).abs()
        };
        deterministic(self.moments.iter().zip(values).map(off).fold(0.0, f64::max))
    }

    /// Records of a deterministic method that computes all quantities at once.
    fn deterministic(
        &self,
        (method, label): (&str, &str),
        (moment_cost, tail_cost): ((f64, f64), (f64, f64)),
        moments: &[f64],
        tails: &[f64],
    ) -> Vec<Record> {
        let record = |quantity: &str, (cpu_seconds, cpu_spread), outcome| Record {
            quantity: quantity.into(),
            method: method.into(),
            label: label.into(),
            cpu_seconds,
            cpu_spread,
            outcome,
        };
        let mut records = vec![record(MOMENTS, moment_cost, self.moment_error(moments))];
        for (target, value) in self.targets.iter().zip(tails) {
            let outcome = if *value > 0.0 {
                deterministic((value / target.reference.value - 1.0).abs())
            } else {
                Outcome::Nothing { reason: "no mass beyond the threshold".into() }
            };
            records.push(record(target.name, tail_cost, outcome));
        }
        records
    }
}

fn relative(reference: &Reference) -> f64 {
    reference.error.unwrap_or(0.0) / reference.value
}

fn deterministic(error: f64) -> Outcome {
    if error.is_finite() {
        Outcome::Off { error }
    } else {
        Outcome::Nothing { reason: format!("the error is {error}") }
    }
}

/// Solves with the density solver; tails are integrated over cells.
pub(super) fn solve_with_particles<S, I, const D: usize>(
    context: &Context<'_>,
    setting: &Setting<'_, S, I, D>,
    ladders: &[Ladder<D>],
) -> Result<Vec<Record>, CaseError>
where
    S: Sde<D, 1, Noise = Additive>,
{
    let asked = setting.asked(true);
    let mut records = Vec::new();
    for &Ladder { name, method, ref lattices } in ladders {
        for lattice in rungs(context, lattices) {
            let config = Config {
                method,
                lattice,
                reference_period: setting.period,
                most_steps: DEFAULT_MOST_STEPS,
            };
            let (run, cost, spread) = timed(LONG, || {
                let system: Erased<'_, Additive, D, 1> = Erased(setting.system);
                Ok(density::run_on(system, setting.law, &config, &asked, |_, _| ())?)
            })?;
            let label = group_thousands_u64(run.n_particles as u64);
            context.progress(&format!("{}: {name}, {label}, {cost:.1} s", setting.name));
            records.extend(particles(setting, (name, &label), &run, (cost, spread)));
        }
    }
    Ok(records)
}

fn particles<S, I, const D: usize>(
    setting: &Setting<'_, S, I, D>,
    words: (&str, &str),
    run: &DensityRun,
    tail_cost: (f64, f64),
) -> Vec<Record> {
    let Some(row) = run.rows.first() else {
        let stopped = run.stopped.as_ref();
        let reason = stopped.map_or_else(|| "no row".to_owned(), ToString::to_string);
        return setting
            .scene()
            .quantities
            .iter()
            .map(|quantity| Record {
                quantity: quantity.name.into(),
                method: words.0.into(),
                label: words.1.into(),
                cpu_seconds: tail_cost.0,
                cpu_spread: tail_cost.1,
                outcome: Outcome::Nothing { reason: reason.clone() },
            })
            .collect();
    };
    let tails: Vec<f64> =
        row.exceedances.iter().map(|p| p.cell_integrated.unwrap_or(p.log_interpolated)).collect();
    // A moment requires no integral over cells.
    let moment_cost = (row.cpu_seconds, tail_cost.1);
    setting.deterministic(words, (moment_cost, tail_cost), &row.moments, &tails)
}

/// Cells along each axis of the grids, with their steps per period.
pub(super) const GRIDS: [(usize, f64); 5] =
    [(40, 16.0), (56, 24.0), (80, 40.0), (112, 60.0), (160, 100.0)];

/// Solves on the grid, in two dimensions.
pub(super) fn solve_on_grid<S, I>(
    context: &Context<'_>,
    setting: &Setting<'_, S, I, 2>,
) -> Result<Vec<Record>, CaseError>
where
    S: Sde<2, 1, Noise = Additive>,
{
    let mut records = Vec::new();
    for (cells, steps_per_period) in rungs(context, &GRIDS) {
        let config = GridConfig { cells, reach: 8.0, period: setting.period, steps_per_period };
        let (density, cost, spread) = timed(LONG, || {
            let mut density = GridDensity::new(setting.system, setting.law, config)?;
            density.advance_to(setting.time)?;
            Ok(density)
        })?;
        let moments = setting
            .moments
            .iter()
            .map(|(powers, _)| density.raw_moment(*powers))
            .collect::<Result<Vec<_>, _>>()?;
        let tails: Vec<f64> =
            setting.targets.iter().map(|t| density.exceedance(t.threshold)).collect();
        let label = format!("{cells}²");
        let cost = (cost, spread);
        records.extend(setting.deterministic(("grid", &label), (cost, cost), &moments, &tails));
    }
    Ok(records)
}

/// Solves by statistical linearisation, with the tail of its normal distribution.
pub(super) fn solve_linearised<S, I, const D: usize>(
    setting: &Setting<'_, S, I, D>,
    rule: &Linearisation<D>,
) -> Result<Vec<Record>, CaseError>
where
    S: Sde<D, 1, Noise = Additive>,
{
    let (laws, cost, spread) =
        timed(LONG, || Ok(rule.laws(setting.system, setting.law, &[setting.time])?))?;
    let law = laws.first().ok_or("no law")?;
    let moments: Vec<f64> =
        setting.moments.iter().map(|(powers, _)| law.raw_moment(*powers)).collect();
    let displacement = std::array::from_fn(|i| f64::from(u8::from(i == 0)));
    let exceedance = |target: &Target| law.exceedance(&displacement, target.threshold);
    let tails: Vec<f64> = setting.targets.iter().map(exceedance).collect();
    let words = ("statistical linearisation", "");
    Ok(setting.deterministic(words, ((cost, spread), (cost, spread)), &moments, &tails))
}

/// Samples by Monte Carlo, guided paths and subset simulation.
pub(super) fn sample<S, I, const D: usize>(
    context: &Context<'_>,
    setting: &Setting<'_, S, I, D>,
    rule: &Linearisation<D>,
) -> Result<Vec<Record>, CaseError>
where
    S: Paths<D, 1> + Sde<D, 1, Noise = Additive>,
    I: Integrator<S, D, 1>,
{
    let mut records = Vec::new();
    for paths in rungs(context, &[1_000_u64, 10_000, 100_000, 1_000_000]) {
        context.progress(&format!("{}: Monte Carlo, {paths} paths", setting.name));
        records.extend(plain(setting, paths)?);
    }
    let path = (setting.time, setting.n_steps as usize);
    let tail = TailPaths::new::<_, _, 1>(setting.system, setting.integrator, setting.law, path)?;
    for target in &setting.targets {
        context.progress(&format!("{}: {}, one at a time", setting.name, target.name));
        for samples in rungs(context, &[500_u64, 2_000, 20_000, 100_000]) {
            let label = group_thousands_u64(samples);
            let run = || guided(setting, rule, target.threshold, samples);
            records.push(one(target, ("guided paths", &label), None, run)?);
        }
        for n_samples in rungs(context, &[200_usize, 500, 1_500]) {
            let config = SubsetConfig { n_samples, correlation: 0.8, n_runs: SUBSET_RUNS };
            let label = format!("{SUBSET_RUNS} x {}", group_thousands_u64(n_samples as u64));
            let run = || Ok(tail.subset(target.threshold, &config, n_samples as u64)?);
            // A standard deviation from n values has the relative error 1/sqrt(2 (n - 1)).
            let known_to = (2.0 * (SUBSET_RUNS as f64 - 1.0)).sqrt().recip();
            records.push(one(target, ("subset simulation", &label), Some(known_to), run)?);
        }
    }
    Ok(records)
}

/// Steps of the linearisation that guides paths, per period.
const STEPS_OF_GUIDE: f64 = 20.0;

/// The linearisation of a guide.
pub(super) fn guide_rule<const D: usize>(rule: &Linearisation<D>, period: f64) -> Linearisation<D> {
    Linearisation { step: period / STEPS_OF_GUIDE, ..*rule }
}

/// One probability by guided paths, with all that it needs: linearisation and pilot paths.
fn guided<S, I, const D: usize>(
    setting: &Setting<'_, S, I, D>,
    rule: &Linearisation<D>,
    threshold: f64,
    samples: u64,
) -> Result<Estimate, CaseError>
where
    S: Sde<D, 1, Noise = Additive>,
    I: Integrator<S, D, 1>,
{
    let (system, span) = (setting.system, (setting.time, setting.n_steps as usize));
    let rule = guide_rule(rule, setting.period);
    let paths = GuidedPaths::new(system, setting.integrator, setting.law, span, &rule)?;
    let n_pilots = (samples / 4).clamp(200, 1_000);
    let config = GuidedConfig { n_paths: samples, n_pilots, unguided: 0.05, seed: samples };
    Ok(paths.exceedance(threshold, Tails::Doubled, &config)?.estimate)
}

/// Independent runs of subset simulation; their scatter is the error.
pub(super) const SUBSET_RUNS: u64 = 10;

fn plain<S, I, const D: usize>(
    setting: &Setting<'_, S, I, D>,
    paths: u64,
) -> Result<Vec<Record>, CaseError>
where
    S: Paths<D, 1>,
{
    let step = setting.time / f64::from(setting.n_steps);
    let sampling = Sampling { paths, step, seed: paths };
    let asked = setting.asked(false);
    let (run, cpu_seconds, cpu_spread) =
        timed(LONG, || Ok(monte_carlo::run_on(setting.system, setting.law, &sampling, &asked)?))?;
    let row = run.at(setting.time).ok_or("no row")?;
    let record = |quantity: &str, outcome| Record {
        quantity: quantity.into(),
        method: format!("Monte Carlo, {}", S::INTEGRATOR.name()),
        label: group_thousands_u64(paths),
        cpu_seconds,
        cpu_spread,
        outcome,
    };
    let (mut predicted, mut seen) = (0.0_f64, 0.0_f64);
    for ((_, reference), estimate) in setting.moments.iter().zip(&row.moments) {
        let error = estimate.standard_error().ok_or("no standard error")? / reference.value;
        if error > predicted {
            (predicted, seen) = (error, (estimate.value / reference.value - 1.0).abs());
        }
    }
    let moments = Outcome::Sampled { predicted, uncertainty: None, seen: Some(seen) };
    let mut records = vec![record(MOMENTS, moments)];
    for (target, estimate) in setting.targets.iter().zip(&row.exceedances) {
        let p = target.reference.value;
        let expected = p * paths as f64;
        let outcome = if expected >= 1.0 {
            // From the binomial distribution, so that a sample without hits has an error too.
            let predicted = ((1.0 - p) / expected).sqrt();
            let seen = Some((estimate.value / p - 1.0).abs());
            Outcome::Sampled { predicted, uncertainty: None, seen }
        } else {
            Outcome::Nothing { reason: format!("{expected:.0e} paths expected beyond it") }
        };
        records.push(record(target.name, outcome));
    }
    Ok(records)
}

/// Runs a method that estimates one probability at a time.
fn one(
    target: &Target,
    (method, label): (&str, &str),
    known_to: Option<f64>,
    mut run: impl FnMut() -> Result<Estimate, CaseError>,
) -> Result<Record, CaseError> {
    let mut reason = None;
    let (estimate, cpu_seconds, cpu_spread) = timed(LONG, || match run() {
        Ok(estimate) => Ok(Some(estimate)),
        // That there is no estimate is a result too.
        Err(error) => {
            reason = Some(error.to_string());
            Ok(None)
        }
    })?;
    let p = target.reference.value;
    let outcome = match estimate.as_ref().map(|e| (e.value, e.standard_error())) {
        Some((value, Some(error))) if value > 0.0 => Outcome::Sampled {
            predicted: error / p,
            uncertainty: known_to.map(|part| part * error / p),
            seen: Some((value / p - 1.0).abs()),
        },
        _ => Outcome::Nothing { reason: reason.unwrap_or_else(|| "no sample beyond it".into()) },
    };
    Ok(Record {
        quantity: target.name.into(),
        method: method.into(),
        label: label.into(),
        cpu_seconds,
        cpu_spread,
        outcome,
    })
}
