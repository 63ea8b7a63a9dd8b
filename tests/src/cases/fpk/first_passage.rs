//! First passage: the absorbing boundary, the integral of the rate of crossing, and the bound that it gives.

use fpk_sph::observables::{CellIntegral, FirstPassage, OutcrossingBound, Probability};
use fpk_sph::{Config, Error, InitialLattice, Method, Simulation};
use reference_problems::fpk::linear_moments::linear_moments;
use reference_problems::fpk::oscillator::Oscillator;
use reference_problems::fpk::problem::{Problem, bouc_wen};
use reference_problems::fpk::reference::ReferenceTable;
use scenes::clock::CpuClock;
use sde_integrators::{
    Between, EnsembleConfig, GaussianMixture, Observable, Response, Sde, Side, StrangOscillator,
    maxima, simulate,
};
use vibrating_systems::{LinearOscillator, LinearOscillatorParameters, Window};

use super::{flow_map_fit, worst};
use crate::cases::prelude::*;

const SOURCE: &str =
    "Canor & Denoël 2013, sections 4.1 and 4.2; references by Monte Carlo with parabolic peaks";

pub(crate) const DAMPER: Case = Case {
    id: "fpk-sph/first-passage/viscous-damper",
    title: "First passage of a building with a viscous damper, from the run of its density",
    source: SOURCE,
    cost: Profile::Default,
    run: Together(damper),
};

pub(crate) const CROSSINGS: Case = Case {
    id: "fpk-sph/first-passage/crossings",
    title: "Expected number of crossings of a building with a viscous damper, against Monte Carlo",
    source: SOURCE,
    cost: Profile::Default,
    run: Together(crossings),
};

pub(crate) const BOUC_WEN: Case = Case {
    id: "fpk-sph/first-passage/bouc-wen",
    title: "First passage of a building that yields, from the run of its density",
    source: SOURCE,
    cost: Profile::Default,
    run: Together(hysteresis),
};

pub(crate) const FRAGILITY: Case = Case {
    id: "fpk-sph/first-passage/fragility",
    title: "Fragility over the intensity, and its sensitivity, from the same deterministic run",
    source: "paths of the same system by Strang's splitting",
    cost: Profile::Quick,
    run: Together(fragility),
};

/// When all that will pass has passed: the noise of both scenes is weak or none.
const END: f64 = 8.0;

/// What a run to the end gives, in the order of the thresholds.
struct Watched {
    absorbed: Vec<f64>,
    crossings: Vec<f64>,
    bound: Vec<f64>,
    supports: Vec<Option<Probability>>,
    words: String,
}

/// Runs to the end under watch of `|q|`; the rate of crossing is taken every `interval` where one is given.
fn watch<S: Sde<D, M>, const D: usize, const M: usize>(
    system: S,
    law: &GaussianMixture<D>,
    config: &Config<D>,
    thresholds: &[f64],
    interval: Option<f64>,
) -> CaseResult<Watched> {
    let demand = |x: &[f64; D]| x[0].abs();
    let start = CpuClock::start();
    let mut simulation = Simulation::new(system, law, config)?;
    let mut passage = FirstPassage::new(&simulation, demand, thresholds)?;
    let mut bounds: Vec<OutcrossingBound> = passage
        .probabilities()
        .iter()
        .map(|&initial| OutcrossingBound::new(initial))
        .collect::<Result<_, _>>()?;
    let add = |cells: &CellIntegral<D>, time: f64, bounds: &mut [OutcrossingBound]| {
        for (bound, &threshold) in bounds.iter_mut().zip(thresholds) {
            let rate = cells.crossing_rate(demand, |x| x[0].signum() * x[1], threshold)?;
            bound.record(time, rate)?;
        }
        Ok::<_, Error>(())
    };
    if let Some(interval) = interval {
        add(&simulation.cell_integral()?, 0.0, &mut bounds)?;
        let mut looks = 0.0;
        while simulation.time() < END {
            looks += 1.0;
            passage.advance_to(&mut simulation, (looks * interval).min(END))?;
            add(&simulation.cell_integral()?, simulation.time(), &mut bounds)?;
        }
    } else {
        passage.advance_to(&mut simulation, END)?;
    }
    Ok(Watched {
        absorbed: passage.probabilities().to_vec(),
        crossings: bounds.iter().map(OutcrossingBound::expected_crossings).collect(),
        bound: bounds.iter().map(OutcrossingBound::probability).collect(),
        supports: (0..thresholds.len()).map(|k| passage.probability(k)).collect(),
        words: format!(
            "{} particles, {} steps, {:.1} s CPU",
            simulation.n_particles(),
            simulation.work().steps,
            start.seconds()
        ),
    })
}

/// The absorbing estimate against the reference, threshold by threshold.
fn absorbed<'c>(
    lines: &Lines<'_>,
    (watched, thresholds): (&Watched, &[f64]),
    reference: &ReferenceTable,
    criterion: impl Fn(f64) -> Criterion<'c>,
) -> CaseResult {
    let mut claims = Vec::new();
    for (&threshold, &value) in thresholds.iter().zip(&watched.absorbed) {
        let (name, quantity) = passage_words("absorbing", threshold);
        let reference = reference.first_passage(threshold, END).ok_or("no reference")?;
        let compared = lines.of(name, quantity).relative(value, reference);
        claims.push(compared.judged(criterion(threshold)));
    }
    Ok(claims)
}

fn passage_words(estimator: &str, threshold: f64) -> (String, String) {
    (format!("{estimator}/threshold-{threshold}"), format!("P(max |q| > {threshold})"))
}

/// The bound lies above the reference, and no further than seen.
fn bounded(
    lines: &Lines<'_>,
    (watched, thresholds): (&Watched, &[f64]),
    reference: &ReferenceTable,
    most: &[f64],
) -> CaseResult {
    let reason = "an upper bound, at least the reference less two standard errors; it is high by the mean number of \
                  crossings in a clump, and was seen a tenth below the upper end";
    let mut claims = Vec::new();
    for ((&threshold, &value), &to) in thresholds.iter().zip(&watched.bound).zip(most) {
        let reference = reference.first_passage(threshold, END).ok_or("no reference")?;
        let from = -2.0 * reference.error.unwrap_or(0.0) / reference.value;
        let (name, quantity) = passage_words("bound", threshold);
        let compared = lines.of(name, quantity).relative(value, reference);
        claims.push(compared.as_measured(from, to).because(reason));
    }
    Ok(claims)
}

const DAMPER_THRESHOLDS: [f64; 3] = [0.5, 0.75, 1.0];
/// The rate of crossing swings with the period of 2 s, twice in each: ten times in a swing.
const INTERVAL: f64 = 0.1;

fn flow_map(problem: &Problem, refinement: f64) -> CaseResult<Config<2>> {
    let config = problem.density_config(refinement)?;
    Ok(Config { method: Method::FlowMapFit, ..config })
}

fn damper_system(problem: &Problem) -> CaseResult<vibrating_systems::ViscousDamper> {
    match &problem.system {
        Oscillator::Damper(system) => Ok(system.clone()),
        Oscillator::Linear(_) => Err("the scene holds another system".into()),
    }
}

fn damper(context: &Context<'_>) -> CaseResult {
    let problem = Problem::viscous_damper()?;
    let system = damper_system(&problem)?;
    let mut claims = Vec::new();
    let reason = "a threshold between layers of particles, and numerical diffusion of the survival across the noise";
    for (id, refinement, tolerance, interval) in
        [("flow-map-fit", 1.0, 0.08, Some(INTERVAL)), ("flow-map-fit-refined", 2.0, 0.03, None)]
    {
        let config = flow_map(&problem, refinement)?;
        let thresholds = &DAMPER_THRESHOLDS;
        let watched = watch(system.clone(), &problem.law, &config, thresholds, interval)?;
        let lines = context.lines(id, format!("flow-map fit, {}", watched.words));
        let criterion = |_| Criterion::Within { tolerance, reason };
        let both = (&watched, thresholds.as_slice());
        let family = absorbed(&lines, both, &problem.reference, criterion)?;
        let name = format!("{id}/absorbing/worst");
        claims.push(worst(context, (&name, &format!("T = {thresholds:?}")), family)?);
        if interval.is_some() {
            claims.extend(bounded(&lines, both, &problem.reference, &[1.1, 0.67, 0.41])?);
        }
    }
    Ok(claims)
}

/// Half the width over which paths count as being at the threshold. The rate is even about it to second order.
const HALF_WIDTH: f64 = 0.02;
const BATCHES: u64 = 16;
const PATHS_PER_BATCH: u64 = 25_000;

/// `int nu dt` by paths: `E[max(d|q|/dt, 0)]` where `|q|` is near the threshold, over the width, at the same times; its
/// standard error from batches, since one path counts at many times.
fn crossings(context: &Context<'_>) -> CaseResult {
    let problem = Problem::viscous_damper()?;
    let system = damper_system(&problem)?;
    let thresholds = [0.5, 0.75];
    let config = flow_map(&problem, 1.0)?;
    let watched = watch(system.clone(), &problem.law, &config, &thresholds, Some(INTERVAL))?;
    context.progress("paths");
    let times: Vec<f64> = (1..=80).map(|k| INTERVAL * f64::from(k)).collect();
    let rates = thresholds.map(|threshold| {
        move |_: f64, [q, v]: &[f64; 2]| {
            let near = (q.abs() - threshold).abs() < HALF_WIDTH;
            if near { (q.signum() * v).max(0.0) / (2.0 * HALF_WIDTH) } else { 0.0 }
        }
    });
    let observables = rates.each_ref().map(|rate| Observable::Mean(rate));
    let mut totals = Vec::new();
    for seed in 0..BATCHES {
        let config =
            EnsembleConfig { seed, n_paths: PATHS_PER_BATCH, dt: 0.02, times: times.clone() };
        let ensemble = simulate(&system, &StrangOscillator, &problem.law, &config, &observables)?;
        let mut total = [0.0; 2];
        for (n, estimates) in ensemble.estimates.iter().enumerate() {
            // The trapezoidal rule; nothing crosses at t = 0, 3 and 5 deviations away with no noise yet.
            let weight = if n + 1 == times.len() { 0.5 } else { 1.0 };
            for (total, estimate) in total.iter_mut().zip(estimates) {
                *total += weight * INTERVAL * estimate.value;
            }
        }
        totals.push(total);
    }
    let method =
        format!("flow-map fit, {}, against {} paths", watched.words, BATCHES * PATHS_PER_BATCH);
    let lines = context.lines("flow-map-fit", method);
    let mut claims = Vec::new();
    for (k, threshold) in thresholds.into_iter().enumerate() {
        let n = totals.len() as f64;
        let mean = totals.iter().map(|total| total[k]).sum::<f64>() / n;
        let variance =
            totals.iter().map(|total| (total[k] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let reason = "0.6 % of the variance in the tail, a threshold between layers of particles, and two standard errors of the \
                      paths";
        let (name, _) = passage_words("crossings", threshold);
        let value = watched.crossings[k];
        let reference = Reference::uncertain(mean, (variance / n).sqrt());
        let subject = lines.of(name, format!("E[crossings of |q| = {threshold}]"));
        claims.push(subject.relative(value, reference).within(0.05).because(reason));
    }
    Ok(claims)
}

fn hysteresis(context: &Context<'_>) -> CaseResult {
    let (system, law, reference) = bouc_wen()?;
    let period = system.period();
    let near = flow_map_fit(InitialLattice::Ball { reach: 5.0, spacing: 0.6 }, period);
    context.progress("flow-map fit");
    let watched = watch(system.clone(), &law, &near, &[1.0], Some(0.2))?;
    let method = format!("flow-map fit, ball of 5 sigma, spacing 0.6, {}", watched.words);
    let lines = context.lines("flow-map-fit", method);
    let reason =
        "truncation of the cubic fit at the fold; it changes sign: 0.4 % low at spacing 0.4";
    let within = |_| Criterion::Within { tolerance: 0.005, reason };
    let mut claims = absorbed(&lines, (&watched, &[1.0]), &reference, within)?;
    // At T = 1.5 neither density has a bound worth a claim: too little tail here, and fits across the sheet that the limit
    // of z makes of the cloud give the other rates of crossing hundreds of times too high.
    claims.extend(bounded(&lines, (&watched, &[1.0]), &reference, &[0.26])?);

    if context.profile < Profile::Full {
        context.skip(
            "a reach for probabilities of 1e-6, where none is said to be resolved: with --full",
        );
        return Ok(claims);
    }
    context.progress("flow-map fit, reach for 1e-6");
    let far = flow_map_fit(InitialLattice::ball_down_to(1e-6, 0.5)?, period);
    let watched = watch(system, &law, &far, &[1.5, 2.0], None)?;
    let method = format!("flow-map fit, ball for P down to 1e-6, spacing 0.5, {}", watched.words);
    let lines = context.lines("flow-map-fit-1e-6", method);
    // No claim on the probabilities: particles at the rim go astray, and the last bit decides which pass; at T = 1.5 runs
    // with reaches of 5.97 and 6 are 3.4 and 1.1 times the reference.
    let astray =
        watched.supports.iter().filter(|of| matches!(of, Some(Probability::Resolved(_)))).count();
    let quantity = "P(max |q| > 1.5) and P(max |q| > 2) said to be resolved";
    let claim = lines.of("absorbing/said-to-be-resolved", quantity).bounded(astray as f64, 0.0);
    claims.push(claim.because("counted: much comes from particles whose cells are turned over"));
    Ok(claims)
}

/// The linear oscillator of section 4.1, its noise by a factor.
fn shaken(intensity: f64) -> Result<LinearOscillator, vibrating_systems::Error> {
    LinearOscillator::new(LinearOscillatorParameters {
        natural_frequency: std::f64::consts::PI,
        damping_ratio: 0.05,
        noise_intensity: intensity,
        window: Window::CANOR_DENOEL_2013,
    })
}

const AT_REST: [f64; 2] = [0.05, 0.05];
/// Passed by about a tenth and a hundredth of the paths.
const FRAGILITY_THRESHOLDS: [f64; 2] = [0.4, 0.55];

fn shaken_run(intensity: f64, count: usize) -> CaseResult<(Vec<f64>, f64)> {
    let law = GaussianMixture::independent([0.0; 2], AT_REST)?;
    let system = shaken(intensity)?;
    let config = flow_map_fit(InitialLattice::box_of(count), system.period());
    let mut simulation = Simulation::new(system, &law, &config)?;
    let mut passage = FirstPassage::new(&simulation, |x| x[0].abs(), &FRAGILITY_THRESHOLDS)?;
    passage.advance_to(&mut simulation, 6.0)?;
    Ok((passage.probabilities().to_vec(), simulation.raw_moment([2, 0])))
}

/// Fragility at one intensity against paths, and the derivative of `E[q^2]` by the intensity, which is exact:
/// the part of the variance that the noise brings is proportional to it.
fn fragility(context: &Context<'_>) -> CaseResult {
    let (intensity, step) = (0.15, 0.0075);
    let law = GaussianMixture::independent([0.0; 2], AT_REST)?;
    let (found, _) = shaken_run(intensity, 41)?;
    let config = EnsembleConfig { seed: 21, n_paths: 100_000, dt: 0.02, times: vec![6.0] };
    let between = Between::CubicHermite { velocity: 1 };
    let response = Response { component: 0, side: Side::Magnitude, between };
    let maxima = maxima(&shaken(intensity)?, &StrangOscillator, &law, &config, &response)?;
    let method = "flow-map fit, 1,681 particles, S_0 = 0.15; against 100,000 paths".to_owned();
    let lines = context.lines("linear-oscillator", method);
    let mut claims = Vec::new();
    for (threshold, value) in FRAGILITY_THRESHOLDS.into_iter().zip(found) {
        let paths = maxima[0].exceedance(threshold)?;
        let reason =
            "spacing of 0.3 deviations, 5 % on the damper, and two standard errors of the paths";
        let (name, quantity) = passage_words("fragility", threshold);
        let reference = estimated(&paths);
        let compared = lines.of(name, quantity).relative(value, reference);
        claims.push(compared.within(0.08).because(reason));
    }
    let second_moment = |intensity: f64| Ok::<_, CaseError>(shaken_run(intensity, 31)?.1);
    let derivative =
        (second_moment(intensity + step)? - second_moment(intensity - step)?) / (2.0 * step);
    // E[q^2](S_0) is linear in S_0: two other intensities give its slope without error of the difference.
    let exact = |intensity: f64| -> CaseResult<f64> {
        let laws = linear_moments(&shaken(intensity)?, &law, &[6.0], 1e-3)?;
        Ok(laws[0].covariance[0][0])
    };
    let slope = (exact(0.3)? - exact(0.1)?) / 0.2;
    let reason = "what a step of a fortieth of the period leaves, 1e-5 of E[q^2], over a difference of a tenth of it";
    let subject = lines.of("sensitivity/second-moment-q", "d E[q^2] / d S_0").unit("s^3");
    claims.push(subject.relative(derivative, slope).within(1e-4).because(reason));
    Ok(claims)
}
