//! First-passage problems of the literature by guided paths.

use random_vibration::{GuidedConfig, GuidedPaths, PairwiseRule, PassageQuestion};
use sde_integrators::{Between, Estimate, Response, Side};
use serde::Deserialize;
use vibrating_systems::{
    CloughPenzienParameters, Ground, Hysteresis, KanaiTajimiParameters, ShearBuilding,
    ShearBuildingParameters, Storey, Window,
};

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/passage-benchmarks",
    title: "First-passage problems of the literature by guided paths",
    source: "Au & Beck 2001; after Schuëller & Pradlwarter 2007; Xian & Wang 2024",
    cost: Profile::Default,
    run: Together(run),
};

/// `tests/reference/published/random-vibration/first_passage.json`.
#[derive(Debug, Deserialize)]
struct Published {
    linear_oscillator: LinearOscillator,
    filtered_frame: FilteredFrame,
    hysteretic_frame: HystereticFrame,
}

/// A probability with its standard error.
#[derive(Debug, Deserialize)]
struct Probability {
    threshold: f64,
    value: f64,
    standard_error: f64,
}

#[derive(Debug, Deserialize)]
struct LinearOscillator {
    omega: f64,
    zeta: f64,
    intensity: f64,
    step: f64,
    duration: f64,
    probabilities: Vec<Probability>,
}

#[derive(Debug, Deserialize)]
struct FilteredFrame {
    mass: f64,
    stiffness: Vec<f64>,
    damping_ratio: f64,
    ground_frequency: f64,
    ground_damping: f64,
    low_cut_frequency: f64,
    low_cut_damping: f64,
    noise: f64,
    rise_end: f64,
    decay_start: f64,
    decay_rate: f64,
    step: f64,
    duration: f64,
    probabilities: Vec<Probability>,
}

#[derive(Debug, Deserialize)]
struct HystereticFrame {
    storeys: usize,
    mass: f64,
    stiffness: f64,
    damping_ratio: f64,
    post_yield_ratio: f64,
    yield_drift: f64,
    two_sided_intensity: f64,
    duration: f64,
    probabilities: Vec<Probability>,
    published: PublishedProbability,
}

/// A probability as printed.
#[derive(Debug, Deserialize)]
struct PublishedProbability {
    threshold: f64,
    value: f64,
}

fn run(context: &Context<'_>) -> CaseResult {
    let text = include_str!("../../../reference/published/random-vibration/first_passage.json");
    let Published { linear_oscillator, filtered_frame, hysteretic_frame } =
        serde_json::from_str(text)?;
    let mut claims = oscillator(context, &linear_oscillator)?;
    claims.extend(frame(context, &filtered_frame)?);
    claims.extend(yielding(context, &hysteretic_frame)?);
    Ok(claims)
}

/// A problem: a building, steps, the rule for its guides, and which drifts count at the ends of steps.
struct Problem<'a> {
    id: &'a str,
    building: ShearBuilding,
    span: (f64, usize),
    hold: usize,
    n_drifts: usize,
    config: GuidedConfig,
}

impl Problem<'_> {
    /// The probabilities of first passage of the thresholds, each from paths of its own: guides to others would cost as much again.
    fn solve(&self, context: &Context<'_>, of: &[Probability]) -> CaseResult<Vec<Estimate>> {
        let &Self { ref building, span, hold, n_drifts, config, .. } = self;
        let unmodelled = if building.is_hysteretic() { 0.2 } else { 0.0 };
        let rule = PairwiseRule { step: building.shortest_period() / 10.0, hold, unmodelled };
        let paths = GuidedPaths::from_rest(building, span, &rule)?;
        let (side, between) = (Side::Magnitude, Between::Endpoints);
        let responses: Vec<_> =
            (0..n_drifts).map(|component| Response { component, side, between }).collect();
        let solve = |of: &Probability| {
            context.progress(&format!("{} beyond {}", self.id, of.threshold));
            let (responses, thresholds) = (&responses[..], &[of.threshold][..]);
            let question = PassageQuestion { responses, thresholds, n_steps: &[span.1] };
            let found = paths.first_passages(&question, &config)?.into_iter().flatten().next();
            Ok(found.ok_or("no probability")??.estimate)
        };
        of.iter().map(solve).collect()
    }

    /// A probability against its reference.
    fn claim(
        &self,
        context: &Context<'_>,
        (name, found, expected): (&str, &Estimate, &Probability),
        (bias_bound, reason): (f64, &str),
    ) -> CaseResult<Claim> {
        let method = format!("{} guided paths, {} steps", self.config.n_paths, self.span.1);
        let id = format!("{}/{name}threshold-{}", self.id, expected.threshold);
        let quantity = format!("P(first passage of {})", expected.threshold);
        let reference = Reference { value: expected.value, error: Some(expected.standard_error) };
        let subject = context.subject(&id, quantity, &method);
        let compared = subject.relative(sampled(found)?, reference);
        Ok(compared.monte_carlo(bias_bound).because(reason))
    }

    /// A claim for each probability.
    fn claims(
        &self,
        context: &Context<'_>,
        probabilities: &[Probability],
        bias: (f64, &str),
    ) -> CaseResult {
        let found = self.solve(context, probabilities)?;
        let both = found.iter().zip(probabilities);
        both.map(|(found, expected)| self.claim(context, ("", found, expected), bias)).collect()
    }
}

/// Au and Beck's linear oscillator: the discrete white noise of the source, step by step.
fn oscillator(context: &Context<'_>, given: &LinearOscillator) -> CaseResult {
    let &LinearOscillator { omega, zeta, intensity, step, duration, ref probabilities } = given;
    let (stiffness, damping, hysteresis) = (omega * omega, 2.0 * zeta * omega, Hysteresis::None);
    let building = ShearBuilding::new(ShearBuildingParameters {
        storeys: vec![Storey { mass: 1.0, stiffness, damping, hysteresis }],
        mass_damping: 0.0,
        ground: Ground::WhiteNoise,
        // E[W(t) W(t + tau)] = 2 pi S delta(tau).
        noise_intensity: std::f64::consts::PI * intensity,
        window: Window::Stationary,
    })?;
    let config = GuidedConfig { n_paths: 3_000, n_pilots: 500, unguided: 0.05, seed: 3 };
    let (span, id) = (steps(duration, step), "linear-oscillator");
    let problem = Problem { id, building, span, hold: 1, n_drifts: 1, config };
    let bias = "none but that of Runge-Kutta 4 for the oscillation, (omega dt)^6/144 = 1e-7 a step";
    problem.claims(context, probabilities, (1e-3, bias))
}

/// The linear frame of ten storeys behind its filter.
fn frame(context: &Context<'_>, given: &FilteredFrame) -> CaseResult {
    let &FilteredFrame { mass, damping_ratio, ground_frequency, ground_damping, .. } = given;
    let &FilteredFrame { low_cut_frequency, low_cut_damping, .. } = given;
    let &FilteredFrame { rise_end, decay_start, decay_rate, .. } = given;
    let storey = |stiffness: &f64| Storey {
        mass,
        stiffness: *stiffness,
        damping: 2.0 * damping_ratio * (mass * stiffness).sqrt(),
        hysteresis: Hysteresis::None,
    };
    let soil = KanaiTajimiParameters { ground_frequency, ground_damping };
    let building = ShearBuilding::new(ShearBuildingParameters {
        storeys: given.stiffness.iter().map(storey).collect(),
        mass_damping: 0.0,
        ground: Ground::CloughPenzien(CloughPenzienParameters {
            soil,
            low_cut_frequency,
            low_cut_damping,
        }),
        noise_intensity: 0.5 * given.noise,
        window: Window::RisePlateauDecay { rise_exponent: 1.0, rise_end, decay_rate, decay_start },
    })?;
    let config = GuidedConfig { n_paths: 2_000, n_pilots: 500, unguided: 0.05, seed: 3 };
    let (span, id) = (steps(given.duration, given.step), "filtered-frame");
    let problem = Problem { id, building, span, hold: 4, n_drifts: 1, config };
    let bias = "none but that of Runge-Kutta 4 and of the window within a step of 0.005 s";
    problem.claims(context, &given.probabilities, (5e-3, bias))
}

/// The hysteretic frame of six storeys: white noise, where the source has a random series up to 25 pi rad/s.
fn yielding(context: &Context<'_>, given: &HystereticFrame) -> CaseResult {
    let &HystereticFrame { storeys, mass, stiffness, damping_ratio, .. } = given;
    let &HystereticFrame { post_yield_ratio, yield_drift, .. } = given;
    let (beta, exponent, damping) = (0.5, 1.0, 0.0);
    let hysteresis = Hysteresis::BoucWen { post_yield_ratio, yield_drift, beta, exponent };
    let parameters = ShearBuildingParameters {
        storeys: vec![Storey { mass, stiffness, damping, hysteresis }; storeys],
        mass_damping: 0.0,
        ground: Ground::WhiteNoise,
        noise_intensity: std::f64::consts::PI * given.two_sided_intensity,
        window: Window::Stationary,
    };
    let building =
        ShearBuilding::new(parameters.with_rayleigh_damping([1, storeys], [damping_ratio; 2])?)?;
    let config = GuidedConfig { n_paths: 3_000, n_pilots: 500, unguided: 0.05, seed: 3 };
    let (span, id) = (steps(given.duration, 0.01), "hysteretic-frame");
    // The last threshold is refused with 8,000 paths for all: their effective sample size there is 40, and 50 is the least.
    let (_, probabilities) = given.probabilities.split_last().ok_or("no probabilities")?;
    let problem = Problem { id, building, span, hold: 2, n_drifts: storeys, config };
    let bias = "the source cuts its series off at 25 pi rad/s, above all six modes; white noise has the rest too";
    let found = problem.solve(context, probabilities)?;
    let mut claims = Vec::new();
    for (found, expected) in found.iter().zip(probabilities) {
        claims.push(problem.claim(context, ("", found, expected), (0.05, bias))?);
        let PublishedProbability { threshold, value } = given.published;
        if threshold.to_bits() == expected.threshold.to_bits() {
            let printed = Probability { threshold, value, standard_error: 0.0 };
            let reason = "printed with two digits from a sample and a step that are not stated";
            claims.push(problem.claim(
                context,
                ("as-printed/", found, &printed),
                (0.12, reason),
            )?);
        }
    }
    Ok(claims)
}

/// Duration and number of steps.
fn steps(duration: f64, step: f64) -> (f64, usize) {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "some thousand steps"
    )]
    let n_steps = (duration / step).round() as usize;
    (duration, n_steps)
}
