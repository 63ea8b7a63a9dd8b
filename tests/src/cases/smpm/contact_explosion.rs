//! The two examples of Chen et al. 2019: jets against whole runs, differenced and sampled, and the frozen formulas beside them.

use std::sync::Arc;

use perturbation_moments::MonteCarlo;
use reference_problems::quantile::quantile;
use reference_problems::smpm::problems::{Problem, experiment};
use scenes::smpm::experiment::SceneExperiment;
use smpm::uncertainty::{FrozenForm, Propagated, Sampled, Series, Study};
use smpm::{Plan, Quantity};

use crate::cases::prelude::*;

const SOURCE: &str =
    "own whole runs; Chen et al. 2019, section 5, with the geometry of docs/methods/smpm.md";

pub(crate) const DIFFERENCES: Case = Case {
    id: "smpm/contact-explosion/differences",
    title: "Derivatives carried through an explosion against central differences of whole runs",
    source: SOURCE,
    cost: Profile::Quick,
    run: Together(differences),
};

pub(crate) const SAMPLES: Case = Case {
    id: "smpm/contact-explosion/samples",
    title: "Mean and variance behind an explosion, from one run, against sampled runs",
    source: SOURCE,
    cost: Profile::Default,
    run: Together(samples),
};

/// Microseconds.
pub(super) const TIMES: [f64; 9] = [6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0];
/// Up to this time derivatives of whole runs settle.
const LAST_SMOOTH: f64 = 12.0;

/// A problem with its law, solved by jets, by the frozen formulas and by sampling.
pub(crate) struct Solved {
    pub(crate) plan: Plan<2>,
    pub(crate) propagated: Propagated,
    pub(crate) frozen: Vec<Option<Series>>,
    pub(crate) sampled: Sampled,
}

/// The study of a problem; with three parameters two more are certain.
fn study(
    experiment: &SceneExperiment<2>,
    problem: Problem,
    coefficient_of_variation: f64,
) -> CaseResult<Study<'_, SceneExperiment<2>, 2>> {
    let scene = problem.scene_with(coefficient_of_variation, &TIMES)?;
    let (inputs, plan) = (scene.inputs()?, scene.plan::<2>()?);
    Ok(Study::new(experiment, inputs, plan)?)
}

/// Solves once per run of the verification.
pub(crate) fn solved(
    context: &Context<'_>,
    problem: Problem,
    coefficient_of_variation: f64,
) -> CaseResult<Arc<Solved>> {
    let n_samples = if context.profile == Profile::Full { 1000 } else { 250 };
    let key = format!("smpm {problem:?} {coefficient_of_variation} {n_samples}");
    context.shared(&key, || {
        let scene = problem.scene_with(coefficient_of_variation, &TIMES)?;
        let experiment = experiment::<2>(&scene)?;
        let study = study(&experiment, problem, coefficient_of_variation)?;
        context.progress(&format!("{problem:?} at {coefficient_of_variation}: derivatives"));
        let propagated = study.propagated()?;
        let frozen = study.frozen(FrozenForm::Corrected)?;
        context.progress(&format!("{problem:?} at {coefficient_of_variation}: samples"));
        let sampled = study.monte_carlo(MonteCarlo { seed: 2019, n_samples })?;
        Ok(Solved { plan: study.plan().clone(), propagated, frozen, sampled })
    })
}

fn differences(context: &Context<'_>) -> CaseResult {
    let mut claims = Vec::new();
    for (problem, name, one_sided, tolerances) in [
        (Problem::ContactExplosion, "thin-plate", "thin-plate/one-sided", [2e-6, 2e-3]),
        (Problem::ThickPlate, "thick-plate", "thick-plate/one-sided", [4e-7, 2e-3]),
    ] {
        context.progress(name);
        let experiment = experiment::<2>(&problem.scene()?)?;
        let study = study(&experiment, problem, 0.05)?;
        let plan = study.plan();
        // 2 % of a deviation: 1e-3 of a parameter.
        let differenced = study.finite_difference(0.02)?;
        let jets = study.propagated()?.moments;
        let worst = farthest(plan, &jets, &differenced);
        let method = "jets against central differences, all quantities and gauges, t <= 12 us";
        let quantity = "largest distance of the two gradients, over the quantity's largest";
        let reason = "truncation of the differences, whose step is 1e-3 of a parameter, and switches within it";
        let subject = context.lines("", worst.method(method)).of(name, quantity);
        claims.push(subject.bounded(worst.value(), tolerances[0]).because(reason));
        let worst = farthest(plan, &study.forward_difference(0.02)?, &differenced);
        let method = "one-sided against central differences, the same";
        let lines = context.lines("", worst.method(method));
        let claim = lines.of(one_sided, quantity).bounded(worst.value(), tolerances[1]);
        claims.push(claim.because("half the step times the curvature"));
    }
    Ok(claims)
}

/// The largest distance of two gradients of a response while it is smooth, over the largest of its quantity.
fn farthest(plan: &Plan<2>, a: &[Series], b: &[Series]) -> Worst {
    let mut worst = Worst::of_errors();
    for (q, quantity) in plan.quantities.iter().enumerate() {
        let scale = largest(plan, q, b);
        for (response, (a, b)) in a.iter().zip(b).enumerate() {
            let (_, of, window) = plan.parts(response);
            if of == q && plan.windows[window].to <= LAST_SMOOTH {
                let apart: f64 =
                    a.gradient.iter().zip(&b.gradient).map(|(a, b)| (a - b).powi(2)).sum();
                worst.take(apart.sqrt() / scale, &quantity.to_string());
            }
        }
    }
    worst
}

/// The largest gradient of a quantity at any gauge and time.
fn largest(plan: &Plan<2>, quantity: usize, moments: &[Series]) -> f64 {
    let of = moments.iter().enumerate().filter(|(i, _)| plan.parts(*i).1 == quantity);
    of.map(|(_, moments)| moments.variance().sqrt()).fold(0.0, f64::max)
}

/// Relative errors of mean and variance against the samples, of responses that are asked for.
struct Errors {
    mean: Vec<f64>,
    variance: Vec<f64>,
    frozen_variance: Vec<f64>,
    /// Of the sampled variance.
    standard_error: Vec<f64>,
}

/// From a microsecond after the first yield of its gauge: H yields at 6, G at 7, I and K between 7 and 8 us.
fn after_first_yield(gauge: &str, t: f64) -> bool {
    t >= if gauge == "I" || gauge == "K" { 9.0 } else { 8.0 }
}

fn errors(solved: &Solved, wanted: impl Fn(&str, Quantity, f64) -> bool) -> CaseResult<Errors> {
    let mut errors =
        Errors { mean: vec![], variance: vec![], frozen_variance: vec![], standard_error: vec![] };
    let Solved { plan, propagated, frozen, sampled } = solved;
    for (response, moments) in propagated.moments.iter().enumerate() {
        let (gauge, quantity, window) = plan.parts(response);
        let gauge = plan.gauges[gauge].name.as_str();
        if !wanted(gauge, plan.quantities[quantity], plan.windows[window].to) {
            continue;
        }
        let truth = sampled.controlled(response, moments)?;
        let (mean, variance) = (truth.mean.value, truth.variance.value);
        errors.mean.push((moments.mean() / mean - 1.0).abs());
        errors.variance.push((moments.variance() / variance - 1.0).abs());
        let error = truth.variance.standard_error().unwrap_or(f64::NAN);
        errors.standard_error.push(error / variance);
        if let Some(frozen) = &frozen[response] {
            errors.frozen_variance.push((frozen.variance() / variance - 1.0).abs());
        }
    }
    Ok(errors)
}

/// Claims of the jets, and of the frozen formulas, against samples.
struct Against<'a> {
    jets: Lines<'a>,
    frozen: Lines<'a>,
}

impl<'a> Against<'a> {
    fn new(context: &'a Context<'a>) -> Self {
        Self {
            jets: context.lines("", "jets, against sampled runs with control variate"),
            frozen: context.lines("", "formulas at the local state, corrected: a baseline"),
        }
    }

    /// The median error of the frozen variance, where it was seen.
    fn frozen(&self, id: &str, errors: &Errors, band: (f64, f64)) -> Claim {
        self.frozen
            .of(id, "median relative error of the frozen variance")
            .measured(quantile(&errors.frozen_variance, 0.5), band)
            .because("the state is taken for certain; seen with 250 samples as with 1000")
    }
}

fn samples(context: &Context<'_>) -> CaseResult {
    let against = Against::new(context);
    let mut claims = Vec::new();
    for (cv, of_mean, of_variance) in [(0.05, 1e-4, 3e-3), (0.15, 5e-4, 1e-2)] {
        let solved = solved(context, Problem::ContactExplosion, cv)?;
        claims.extend(flow_stress(&against, &solved, cv, of_mean, of_variance)?);
        claims.extend(deviator(&against, &solved, cv)?);
        claims.push(across(&against, &solved, cv)?);
    }
    for (cv, tolerances) in [(0.01, [5e-4, 6e-3]), (0.05, [2e-3, 0.015])] {
        let solved = solved(context, Problem::ThickPlate, cv)?;
        claims.extend(pressure(&against, &solved, cv, tolerances)?);
    }
    claims.extend(agreement(context)?);
    Ok(claims)
}

fn flow_stress(
    against: &Against<'_>,
    solved: &Solved,
    cv: f64,
    of_mean: f64,
    of_variance: f64,
) -> CaseResult<[Claim; 3]> {
    let flow = errors(solved, |gauge, quantity, t| {
        quantity == Quantity::FlowStress && after_first_yield(gauge, t)
    })?;
    let noise = quantile(&flow.standard_error, 0.5);
    let reason = format!("fourth order in cv; the samples' own error is {noise:.1e}");
    let worst = |name: &str, moment: &str, errors: &[f64], tolerance: f64| {
        let quantity =
            format!("largest relative error of {moment} sigma_y, 1 us after first yield and later");
        against
            .jets
            .of(format!("flow-stress/{name}/cv{cv}"), &quantity)
            .bounded(quantile(errors, 1.0), tolerance)
            .because(&reason)
    };
    let id = format!("flow-stress/frozen-variance/cv{cv}");
    Ok([
        worst("mean", "E", &flow.mean, of_mean),
        worst("variance", "Var", &flow.variance, of_variance),
        against.frozen(&id, &flow, (0.04, 0.065)),
    ])
}

fn deviator(against: &Against<'_>, solved: &Solved, cv: f64) -> CaseResult<[Claim; 3]> {
    let deviator = errors(solved, |gauge, quantity, t| {
        quantity == Quantity::Deviator(0, 0) && after_first_yield(gauge, t)
    })?;
    let id = format!("deviator-11/variance-median/cv{cv}");
    let median = against
        .jets
        .of(&id, "median relative error of Var S_11, 1 us after first yield and later")
        .bounded(quantile(&deviator.variance, 0.5), 0.01)
        .because("unloading and reverse yield are smooth in the parameters but where they begin");
    let id = format!("deviator-11/frozen-variance/cv{cv}");
    Ok([
        median,
        unloading(against, cv, quantile(&deviator.variance, 0.9)),
        against.frozen(&id, &deviator, (0.08, 0.12)),
    ])
}

/// `S_22` at the gauges; at its ninth decile are gauges that unload, as for `S_11`.
fn across(against: &Against<'_>, solved: &Solved, cv: f64) -> CaseResult<Claim> {
    let deviator = errors(solved, |gauge, quantity, t| {
        quantity == Quantity::Deviator(1, 1) && after_first_yield(gauge, t)
    })?;
    let id = format!("deviator-22/variance-median/cv{cv}");
    Ok(against
        .jets
        .of(&id, "median relative error of Var S_22, 1 us after first yield and later")
        .bounded(quantile(&deviator.variance, 0.5), 0.01)
        .because("unloading and reverse yield are smooth in the parameters but where they begin"))
}

/// The ninth decile is made of gauges that unload: their trial stress is within two deviations of yield, as
/// [`Switch`](smpm::uncertainty::Switch) says, or their gradient passes through zero.
fn unloading(against: &Against<'_>, cv: f64, measured: f64) -> Claim {
    let id = format!("deviator-11/variance-p90/cv{cv}");
    let quantity =
        "ninth decile of the relative error of Var S_11, 1 us after first yield and later";
    let of = against.jets.of(&id, quantity);
    if cv < 0.1 {
        let reason = "where unloading begins, samples differ in whether they yield";
        return of.bounded(measured, 0.05).because(reason);
    }
    of.measured(measured, (0.0, 0.12))
        .because("5 % is not reached: at H and K unloading is within two deviations of yield, which is flagged, and at I the gradient passes through zero")
}

fn pressure(
    against: &Against<'_>,
    solved: &Solved,
    cv: f64,
    [of_median, of_decile]: [f64; 2],
) -> CaseResult<[Claim; 3]> {
    let pressure = errors(solved, |_, quantity, _| quantity == Quantity::Pressure)?;
    let at = |name: &str, quantity: &str, share: f64, tolerance: f64| {
        let id = format!("pressure/{name}/cv{cv}");
        let reason = "third derivatives; largest where the gradient passes through zero";
        let measured = quantile(&pressure.variance, share);
        against.jets.of(&id, quantity).bounded(measured, tolerance).because(reason)
    };
    let id = format!("pressure/frozen-variance/cv{cv}");
    Ok([
        at("variance-median", "median relative error of Var p", 0.5, of_median),
        at("variance-p90", "ninth decile of the relative error of Var p", 0.9, of_decile),
        against.frozen(&id, &pressure, (0.8, 0.95)),
    ])
}

/// Raw and controlled samples see the same.
fn agreement(context: &Context<'_>) -> CaseResult {
    let solved = solved(context, Problem::ContactExplosion, 0.15)?;
    let (mut worst, mut gains) = (0.0_f64, Vec::new());
    for (response, moments) in solved.propagated.moments.iter().enumerate() {
        let raw = solved.sampled.raw(response)?;
        let controlled = solved.sampled.controlled(response, moments)?;
        for (a, b) in [(raw.mean, controlled.mean), (raw.variance, controlled.variance)] {
            let error = a.standard_error().unwrap_or(f64::NAN);
            worst = worst.max((a.value - b.value).abs() / error);
        }
        let errors =
            [raw.variance, controlled.variance].map(|e| e.standard_error().unwrap_or(f64::NAN));
        gains.push(errors[0] / errors[1]);
    }
    let lines = |method: &str| context.lines("", method);
    Ok(vec![
        lines("one set of samples")
            .of("raw-against-controlled", "largest distance, in standard errors of the raw one")
            .bounded(worst, 4.0)
            .because("both are without bias, and one is much the surer"),
        lines("the surrogate of one run with jets")
            .of("gain-of-control", "raw over controlled standard error of the variance, median")
            .measured(quantile(&gains, 0.5), (8.0, 13.0))
            .because("the square of it is the number of samples saved: a hundred for one"),
    ])
}
