//! Problems of structural reliability in few normals, by subset simulation.

use sde_integrators::{Error, Estimate, Noise, Sde, SubsetConfig, subset_simulation};
use serde::Deserialize;
use vibrating_systems::{BoucWen, BoucWenParameters, Window};

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/reliability-benchmarks",
    title: "Problems of structural reliability in few normals, by subset simulation",
    source: "Der Kiureghian & De Stefano 1991; Kurtz & Song 2013",
    cost: Profile::Default,
    run: Together(run),
};

/// `tests/reference/published/random-vibration/reliability.json`.
#[derive(Debug, Deserialize)]
struct Published {
    primary_secondary: PrimarySecondary,
    hysteretic_oscillator: HystereticOscillator,
}

/// A probability with its standard error.
#[derive(Debug, Deserialize)]
struct Probability {
    threshold: f64,
    value: f64,
    standard_error: f64,
}

/// A probability as printed.
#[derive(Debug, Deserialize)]
struct Printed {
    threshold: f64,
    value: f64,
}

/// Numbers of the primary and the secondary system.
#[derive(Debug, Deserialize)]
struct Parts {
    primary_mass: f64,
    secondary_mass: f64,
    primary_stiffness: f64,
    secondary_stiffness: f64,
    primary_damping: f64,
    secondary_damping: f64,
    intensity: f64,
}

#[derive(Debug, Deserialize)]
struct PrimarySecondary {
    means: Parts,
    coefficients_of_variation: Parts,
    capacity_coefficient_of_variation: f64,
    probabilities: Vec<Probability>,
    printed: Printed,
}

#[derive(Debug, Deserialize)]
struct HystereticOscillator {
    mass: f64,
    stiffness: f64,
    damping_ratio: f64,
    post_yield_ratio: f64,
    yield_displacement: f64,
    exponent: f64,
    intensity: f64,
    harmonics: u32,
    spacing: f64,
    time: f64,
    step: f64,
    probabilities: Vec<Probability>,
}

fn run(context: &Context<'_>) -> CaseResult {
    let text = include_str!("../../../reference/published/random-vibration/reliability.json");
    let Published { primary_secondary, hysteretic_oscillator } = serde_json::from_str(text)?;
    let mut claims = secondary_force(context, &primary_secondary)?;
    claims.extend(hysteresis(context, &hysteretic_oscillator)?);
    Ok(claims)
}

/// A response as a function of standard normals.
struct Problem<'a> {
    id: &'a str,
    response: &'a (dyn Fn(&[f64]) -> Result<f64, Error> + Sync),
    n_normals: usize,
    config: SubsetConfig,
    /// Bound of the bias of a run: its coefficient of variation squared.
    bias: f64,
}

impl Problem<'_> {
    /// `P(response > threshold)`, the mean of independent runs.
    fn solve(&self, threshold: f64) -> CaseResult<Estimate> {
        let Self { response, n_normals, ref config, .. } = *self;
        Ok(subset_simulation(response, n_normals, threshold, &Noise::new(6), config)?)
    }

    /// A claim for an estimate.
    fn claim(
        &self,
        context: &Context<'_>,
        id: &str,
        found: &Estimate,
        (reference, reason): (Reference, &str),
    ) -> CaseResult<Claim> {
        let SubsetConfig { n_samples, n_runs, .. } = self.config;
        let (id, method) =
            (format!("{}/{id}", self.id), format!("{n_runs} runs of {n_samples} samples a level"));
        let value = sampled(found)?;
        let subject = context.subject(&id, "probability of failure", &method);
        Ok(subject.relative(value, reference).monte_carlo(self.bias).because(reason))
    }
}

const REASON: &str = "a run has a bias of at most its coefficient of variation squared";
const PRINTED: &str = "the same, and three digits from a sample that is not stated";

/// A lognormal variable from a standard normal, by its mean and coefficient of variation.
fn lognormal(mean: f64, variation: f64, normal: f64) -> f64 {
    let variance = (variation * variation).ln_1p();
    mean * (variance.sqrt() * normal - 0.5 * variance).exp()
}

/// Three standard deviations of the force in the spring of a light secondary system on a primary one under white noise:
///
/// $$ F = 3 k_s \sqrt{\frac{\pi S_0}{4 \zeta_s \omega_s^3}
///    \frac{\zeta_a \zeta_s}{\zeta_p \zeta_s (4 \zeta_a^2 + \theta^2) + \gamma \zeta_a^2}
///    \frac{(\zeta_p \omega_p^3 + \zeta_s \omega_s^3) \omega_p}{4 \zeta_a \omega_a^4}} . $$
///
/// Letters: `a` = mean of both systems, `gamma` = ratio of the masses, `theta = (omega_p - omega_s)/omega_a`.
fn force(x: &Parts) -> f64 {
    let w_p = (x.primary_stiffness / x.primary_mass).sqrt();
    let w_s = (x.secondary_stiffness / x.secondary_mass).sqrt();
    let (z_p, z_s) = (x.primary_damping, x.secondary_damping);
    let (w_a, z_a) = (0.5 * (w_p + w_s), 0.5 * (z_p + z_s));
    let (gamma, theta) = (x.secondary_mass / x.primary_mass, (w_p - w_s) / w_a);
    let alone = std::f64::consts::PI * x.intensity / (4.0 * z_s * w_s.powi(3));
    let tuned = z_a * z_s / (z_p * z_s * (4.0 * z_a * z_a + theta * theta) + gamma * z_a * z_a);
    let shape = (z_p * w_p.powi(3) + z_s * w_s.powi(3)) * w_p / (4.0 * z_a * w_a.powi(4));
    3.0 * x.secondary_stiffness * (alone * tuned * shape).sqrt()
}

/// The force in the secondary spring exceeds its capacity.
fn secondary_force(context: &Context<'_>, given: &PrimarySecondary) -> CaseResult {
    let (means, variations) = (&given.means, &given.coefficients_of_variation);
    let mut claims = Vec::new();
    for expected in &given.probabilities {
        let threshold = expected.threshold;
        let response = |u: &[f64]| {
            let of =
                |k: usize, part: fn(&Parts) -> f64| lognormal(part(means), part(variations), u[k]);
            let parts = Parts {
                primary_mass: of(0, |x| x.primary_mass),
                secondary_mass: of(1, |x| x.secondary_mass),
                primary_stiffness: of(2, |x| x.primary_stiffness),
                secondary_stiffness: of(3, |x| x.secondary_stiffness),
                primary_damping: of(4, |x| x.primary_damping),
                secondary_damping: of(5, |x| x.secondary_damping),
                intensity: of(6, |x| x.intensity),
            };
            let capacity = lognormal(threshold, given.capacity_coefficient_of_variation, u[7]);
            // The same event as a force above the capacity, and nearly linear in the normals.
            Ok((force(&parts) / capacity).ln())
        };
        let config = SubsetConfig { n_samples: 10_000, correlation: 0.8, n_runs: 16 };
        let problem = Problem {
            id: "primary-secondary",
            response: &response,
            n_normals: 8,
            config,
            bias: 0.015,
        };
        let found = problem.solve(0.0)?;
        let (value, error) = (expected.value, Some(expected.standard_error));
        let id = format!("capacity-{threshold}");
        claims.push(problem.claim(context, &id, &found, (Reference { value, error }, REASON))?);
        if given.printed.threshold.to_bits() == threshold.to_bits() {
            let printed = Reference { value: given.printed.value, error: None };
            let id = format!("as-printed/capacity-{threshold}");
            claims.push(problem.claim(context, &id, &found, (printed, PRINTED))?);
        }
    }
    Ok(claims)
}

/// The displacement of an oscillator with hysteresis exceeds a threshold at a time, under a series of five harmonics.
fn hysteresis(context: &Context<'_>, given: &HystereticOscillator) -> CaseResult {
    let HystereticOscillator { exponent, yield_displacement, intensity, spacing, .. } = *given;
    // z' = v - (sign(v z) + 1)/2 v |z / z_y|^n, z_y being the displacement at yielding.
    let half = 0.5 * yield_displacement.powf(-exponent);
    let system = BoucWen::new(BoucWenParameters {
        natural_frequency: (given.stiffness / given.mass).sqrt(),
        damping_ratio: given.damping_ratio,
        hardening: given.post_yield_ratio,
        initial_slope: 1.0,
        beta: half,
        gamma: half,
        exponent,
        noise_intensity: 0.0,
        window: Window::Stationary,
    })?;
    let amplitude = (2.0 * intensity * spacing).sqrt();
    let n_steps = steps(given.time, given.step);
    // Cosine and sine of each harmonic at the ends and the middle of each step.
    let places = 0..=2 * n_steps;
    let table: Vec<Vec<f64>> = places
        .map(|k| {
            let t = 0.5 * given.step * k as f64;
            let of = |i: u32| <[f64; 2]>::from((f64::from(i) * spacing * t).sin_cos());
            (1..=given.harmonics).flat_map(of).map(|wave| amplitude * wave).collect()
        })
        .collect();
    let response = |u: &[f64]| {
        let ground = |k: usize| u.iter().zip(&table[k]).map(|(u, wave)| u * wave).sum::<f64>();
        let mut x = [0.0; 3];
        for step in 0..n_steps {
            let loads = [0, 1, 2].map(|k| ground(2 * step + k));
            x = stepped(&system, &x, given.step, loads);
        }
        Ok(x[0])
    };
    let config = SubsetConfig { n_samples: 2_000, correlation: 0.8, n_runs: 8 };
    let n_normals = 2 * given.harmonics as usize;
    let id = "hysteretic-oscillator";
    let problem = Problem { id, response: &response, n_normals, config, bias: 0.05 };
    let mut claims = Vec::new();
    for expected in &given.probabilities {
        context.progress(&format!("hysteretic oscillator, {}", expected.threshold));
        let found = problem.solve(expected.threshold)?;
        let (value, error) = (expected.value, Some(expected.standard_error));
        let id = format!("threshold-{}", expected.threshold);
        claims.push(problem.claim(context, &id, &found, (Reference { value, error }, REASON))?);
    }
    Ok(claims)
}

/// A step of Runge-Kutta 4 with the ground accelerations at its start, middle and end.
fn stepped(system: &BoucWen, x: &[f64; 3], h: f64, [first, middle, last]: [f64; 3]) -> [f64; 3] {
    let rate = |x: &[f64; 3], ground: f64| {
        let mut rate = system.drift(0.0, x);
        rate[1] -= ground;
        rate
    };
    let moved = |h: f64, k: &[f64; 3]| std::array::from_fn(|i| x[i] + h * k[i]);
    let k_1 = rate(x, first);
    let k_2 = rate(&moved(0.5 * h, &k_1), middle);
    let k_3 = rate(&moved(0.5 * h, &k_2), middle);
    let k_4 = rate(&moved(h, &k_3), last);
    std::array::from_fn(|i| x[i] + h / 6.0 * (k_1[i] + 2.0 * (k_2[i] + k_3[i]) + k_4[i]))
}

fn steps(duration: f64, step: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "some hundred steps"
    )]
    let n_steps = (duration / step).round() as usize;
    n_steps
}
