//! Fields: the noisy heat equation on a rod, short and long.

use rayon::prelude::*;
use result_figures::{ErrorKind, Measured, Reference};
use sde_integrators::{
    DenseFactor, DiagonalFactor, Error, FieldIntegrator, FieldPath, LinearTheta, Noise,
    NoiseFactor, Shark, SkRock, SparseFactor,
};
use work_precision::problems::sde::problems::Rod;
use work_precision::problems::sde::stability::sk_rock_factors;

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/fields",
    title: "the noisy heat equation on a rod: stationary variance, a correlated factor, a million unknowns",
    source: "eigenvalues of the second difference; a step of each method on one eigenvalue",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// Conductivity: the largest eigenvalue is below `4 k = 40`.
const CONDUCTIVITY: f64 = 10.0;
const UNKNOWNS: usize = 8;
const PATHS: u64 = 4000;
const LARGE: usize = 1_000_000;
const STAGES: u64 = 5;

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let shark = |p: f64| {
        // ShARK without noise is 1 + p + p^2/2, and of the noise it takes w (1 + p/2) + H (p + p^2/2).
        let variance = (1.0 + 0.5 * p).powi(2) + (p + 0.5 * p * p).powi(2) / 12.0;
        (1.0 + p + 0.5 * p * p, variance.sqrt())
    };
    let diagonal = DiagonalFactor::new(vec![1.0; UNKNOWNS])?;
    let sk_rock = SkRock::new(STAGES)?;
    let mut claims = vec![
        stationary_claim(context, "shark", &Shark, (&diagonal, 0.02), &shark)?,
        // h l = 4: twice the limit of Euler-Maruyama.
        stationary_claim(context, "sk-rock", &sk_rock, (&diagonal, 0.1), &|p| {
            sk_rock_factors(STAGES, p)
        })?,
    ];
    // The same covariance through a Cholesky factor of the unit matrix.
    let unit: Vec<f64> =
        (0..UNKNOWNS * UNKNOWNS).map(|k| f64::from(u8::from(k % (UNKNOWNS + 1) == 0))).collect();
    let dense = DenseFactor::new(UNKNOWNS, &unit)?;
    claims.push(stationary_claim(context, "shark-dense", &Shark, (&dense, 0.02), &shark)?);
    claims.extend(implicit_claims(context, &diagonal)?);
    claims.push(large_claim(context)?);
    Ok(claims)
}

/// The linearly implicit theta method: on the eigenvalue `-l` a step is `A = (1 - (1 - theta) h l)/(1 + theta h l)` and
/// `B = 1/(1 + theta h l)`. With the trapezoidal rule the sum over modes is that of the equation itself, `1/(2 l)`, at a
/// step of which no explicit method takes the twentieth part.
fn implicit_claims(
    context: &Context<'_>,
    factor: &DiagonalFactor,
) -> Result<Vec<Claim>, CaseError> {
    let dt = 1.0;
    let factors = |theta: f64| {
        move |p: f64| ((1.0 + (1.0 - theta) * p) / (1.0 - theta * p), 1.0 / (1.0 - theta * p))
    };
    let method = |theta: f64| -> Result<LinearTheta<SparseFactor>, CaseError> {
        Ok(LinearTheta::new(theta, second_difference(UNKNOWNS)?)?)
    };
    let (trapezoidal, backward) = (method(0.5)?, method(1.0)?);
    let exact: f64 = eigenvalues(UNKNOWNS).map(|l| 0.5 / l).sum();
    let by_step: f64 =
        eigenvalues(UNKNOWNS).map(|l| stationary_variance(factors(0.5)(-l * dt), dt)).sum();
    let same_law = Claim::within(
        context.subject(
            "rod/linear-theta-law",
            "E sum x_i^2 of the method over that of the equation",
            "",
            "theta = 1/2, h = 1, formula of a step",
        ),
        ErrorKind::Relative,
        (by_step, exact),
        1e-13,
        "roundoff: eight terms of ten operations",
    );
    Ok(vec![
        same_law,
        stationary_claim(context, "linear-theta", &trapezoidal, (factor, dt), &factors(0.5))?,
        stationary_claim(context, "linear-theta-backward", &backward, (factor, dt), &factors(1.0))?,
    ])
}

/// `k (x_{i-1} - 2 x_i + x_{i+1})` in compressed rows.
fn second_difference(n: usize) -> Result<SparseFactor, Error> {
    let (mut row_starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for i in 0..n {
        for j in i.saturating_sub(1)..(i + 2).min(n) {
            columns.push(j);
            values.push(if i == j { -2.0 * CONDUCTIVITY } else { CONDUCTIVITY });
        }
        row_starts.push(columns.len());
    }
    SparseFactor::new(n, row_starts, columns, values)
}

/// `h B^2/(1 - A^2)`.
fn stationary_variance((a, b): (f64, f64), dt: f64) -> f64 {
    dt * b * b / (1.0 - a * a)
}

/// `E sum x_i^2` in the stationary state: on the eigenvalue `-l` a step is `A x + B w`, so that the variance is
/// `h B^2/(1 - A^2)`.
fn stationary_claim<I: FieldIntegrator, F: NoiseFactor + Clone>(
    context: &Context<'_>,
    id: &str,
    method: &I,
    (factor, dt): (&F, f64),
    factors: &dyn Fn(f64) -> (f64, f64),
) -> Result<Claim, CaseError> {
    let system = Rod { conductivity: CONDUCTIVITY, factor: factor.clone() };
    let expected: f64 =
        eigenvalues(UNKNOWNS).map(|l| stationary_variance(factors(-l * dt), dt)).sum();
    // The slowest mode has l = 1.2: after 5 units exp(-2 l t) is 6e-6. Where a method damps less than the equation, as
    // many steps as leave 1e-5 of every mode's start.
    let slowest = eigenvalues(UNKNOWNS).map(|l| factors(-l * dt).0.abs()).fold(0.0, f64::max);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "250 at most")]
    let n_steps = (5.0 / dt).max(-5.8 / slowest.ln()).ceil() as u32;
    let energy = |realisation: u64| -> Result<f64, Error> {
        let start = vec![0.0; UNKNOWNS];
        let mut path = FieldPath::new(&system, method, &Noise::new(71), realisation, start)?;
        for _ in 0..n_steps {
            path.step(dt)?;
        }
        Ok(path.state().iter().map(|x| x * x).sum())
    };
    let energies: Vec<f64> = (0..PATHS).into_par_iter().map(energy).collect::<Result<_, _>>()?;
    let subject = context.subject(
        &format!("rod/{id}"),
        "E sum x_i^2, stationary",
        "",
        &format!("{id}, h = {dt}, {UNKNOWNS} unknowns, {PATHS} paths"),
    );
    let reason = "what is left of the start: 6e-6 of the value; the law of the method is exact";
    let criterion = Criterion::MonteCarlo { bias_bound: 1e-5, reason };
    let expected = Reference::exact(expected);
    Ok(Claim::judge(subject, ErrorKind::Relative, mean(&energies), expected, criterion))
}

/// `-l` are the eigenvalues of the second difference with cold ends.
fn eigenvalues(n: usize) -> impl Iterator<Item = f64> {
    let angle = 0.5 * std::f64::consts::PI / (n + 1) as f64;
    (1..=n).map(move |j| 4.0 * CONDUCTIVITY * (angle * j as f64).sin().powi(2))
}

/// Mean and standard error of independent values.
fn mean(values: &[f64]) -> Measured {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
    Measured::sampled(mean, (squares / (n - 1.0) / n).sqrt())
}

/// One path of a million unknowns, ten stiff steps: the mean of `x_i^2` over the rod against the mean over its
/// eigenvalues; its error from 1000 stretches of 1000 unknowns, which hardly know of each other.
fn large_claim(context: &Context<'_>) -> Result<Claim, CaseError> {
    context.progress("a million unknowns");
    let (dt, n_steps) = (1.0, 10_i32);
    let factor = DiagonalFactor::new(vec![1.0; LARGE])?;
    let system = Rod { conductivity: CONDUCTIVITY, factor };
    let method = SkRock::new(STAGES)?;
    let mut path = FieldPath::new(&system, &method, &Noise::new(72), 0, vec![0.0; LARGE])?;
    for _ in 0..n_steps {
        path.step(dt)?;
    }
    let variance = |l: f64| {
        let (a, b) = sk_rock_factors(STAGES, -l * dt);
        let a_squared = a * a;
        dt * b * b * (0..n_steps).map(|k| a_squared.powi(k)).sum::<f64>()
    };
    let expected = eigenvalues(LARGE).map(variance).sum::<f64>() / LARGE as f64;
    let stretches: Vec<f64> = path
        .state()
        .chunks(1000)
        .map(|stretch| stretch.iter().map(|x| x * x).sum::<f64>() / 1000.0)
        .collect();
    let subject = context.subject(
        "million/sk-rock",
        "mean of x_i^2",
        "",
        "SK-ROCK, 5 stages, l h up to 40, 1,000,000 unknowns, 10 steps",
    );
    let reason = "the law of the method is exact";
    let criterion = Criterion::MonteCarlo { bias_bound: 0.0, reason };
    let expected = Reference::exact(expected);
    Ok(Claim::judge(subject, ErrorKind::Relative, mean(&stretches), expected, criterion))
}
