//! How often nominal intervals of 95 % hold, for each estimator.

use std::f64::consts::PI;

use sde_integrators::{EulerMaruyama, Noise, Purpose, normal_probability, normal_quantile};
use uq_estimators::{
    Bias, ControlledSamples, Estimate, Failure, Multilevel, PathLadder, PolynomialControl,
    Sampling, Statistic, Surrogate, TailSampling, Target, Tolerance, UnitCube, quantile,
};
use vibrating_systems::GeometricBrownianMotion;

use crate::cases::estimators::multilevel::GROWTH;
use crate::cases::estimators::rare_events::{
    Model, exact_paraboloid, paraboloid, paraboloid_level,
};
use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "uq-estimators/coverage",
    title: "200 repetitions of each estimator: how often its interval of 95 % holds the true value",
    source: "closed forms: geometric Brownian motion, lognormal moments, Ishigami's function",
    cost: Profile::Default,
    run: Together(run),
};

const REPETITIONS: u64 = 200;

/// Half widths of intervals of 95 % in standard errors: normal, and Student's with 31 degrees of freedom.
const NORMAL: f64 = 1.96;
const STUDENT_31: f64 = 2.04;

/// Replicas of points of the unit cube, so that the second applies.
const REPLICAS: u64 = 32;
const FOLDS: usize = 32;

fn run(context: &Context<'_>) -> CaseResult {
    let mut claims = Vec::new();
    context.progress("multilevel");
    claims.extend(repeat(context, "multilevel", ["mean", "variance", "probability"], multilevel)?);
    context.progress("control variates");
    claims.extend(repeat(context, "control-variates", ["mean", "variance"], controlled)?);
    context.progress("polynomials");
    claims.extend(polynomials(context)?);
    context.progress("rare events");
    claims.extend(repeat(context, "line-sampling", ["paraboloid", "two-sided"], lines)?);
    context.progress("quantiles");
    claims.extend(repeat(context, "quantile", ["samples", "replicas"], quantiles)?);
    context.progress("points of the unit cube");
    for (name, sampling) in
        [("pseudo-random", Sampling::PseudoRandom), ("scrambled-sobol", Sampling::ScrambledSobol)]
    {
        let moments = |seed| cube(sampling, seed);
        claims.extend(repeat(context, name, ["mean", "variance"], moments)?);
        let indices = |seed| sensitivity(sampling, seed);
        let names = ["first-0", "first-1", "total-0", "total-2", "total-sum"];
        claims.extend(repeat(context, name, names, indices)?);
    }
    Ok(claims)
}

/// One interval of a repetition: the distance to the true value and the half width.
type Miss = (f64, f64);

fn miss(estimate: Estimate, exact: f64, quantile: f64) -> Miss {
    (estimate.value - exact, quantile * estimate.standard_error().unwrap_or(f64::NAN))
}

/// Parts of the intervals of 200 repetitions that hold the true value.
fn parts<const N: usize>(run: impl Fn(u64) -> CaseResult<[Miss; N]>) -> CaseResult<[f64; N]> {
    let mut hits = [0_u32; N];
    for repetition in 0..REPETITIONS {
        for (hits, (error, half_width)) in hits.iter_mut().zip(run(1000 + repetition)?) {
            *hits += u32::from(error.abs() <= half_width);
        }
    }
    Ok(hits.map(|hits| f64::from(hits) / REPETITIONS as f64))
}

fn subject(context: &Context<'_>, name: &str, quantity: &str) -> Subject {
    context.subject(
        format!("{name}/{quantity}"),
        "part of the intervals of 95 % that hold the true value",
        format!("{REPETITIONS} repetitions"),
    )
}

fn repeat<const N: usize>(
    context: &Context<'_>,
    name: &str,
    quantities: [&str; N],
    run: impl Fn(u64) -> CaseResult<[Miss; N]>,
) -> CaseResult {
    let claim = |(quantity, part): (&str, f64)| {
        let reason = "statistics: from 90 to 99 %; the deviation of 200 repetitions is 1.5 %";
        subject(context, name, quantity).absolute(part, 0.945).within(0.0451).because(reason)
    };
    Ok(quantities.into_iter().zip(parts(run)?).map(claim).collect())
}

/// Polynomials on three responses: two exponentials, one of them steep, on the like of which their factors for heavy tails were
/// chosen, and sines.
fn polynomials(context: &Context<'_>) -> CaseResult {
    let of_exponential = ["mean", "variance", "total"];
    let mut claims = Vec::new();
    for (name, quantities, parts) in [
        ("polynomial", of_exponential, parts(|seed| exponential(seed, [0.1, 0.2, -0.1]))?),
        ("polynomial-of-sines", ["mean", "variance", "total-1"], parts(sines)?),
        (
            "polynomial-of-a-steep-exponential",
            of_exponential,
            parts(|seed| exponential(seed, [0.2, 0.3, 0.3]))?,
        ),
    ] {
        for (quantity, part) in quantities.iter().zip(parts) {
            let reason =
                "at least 90 %: the factors for heavy tails may be more than a response needs";
            let compared = subject(context, name, quantity).absolute(part, 0.95);
            claims.push(compared.within(0.0501).because(reason));
        }
    }
    Ok(claims)
}

/// Mean, variance and the probability of exceeding 3 of a geometric Brownian motion, by Euler-Maruyama.
fn multilevel(seed: u64) -> CaseResult<[Miss; 3]> {
    let system = GeometricBrownianMotion::new(GROWTH[0], GROWTH[1])?;
    let ladder = PathLadder::<_, _, _, _, 1, 1> {
        system: &system,
        integrator: &EulerMaruyama,
        law: &[1.0],
        seed,
        end: 1.0,
        coarsest_steps: 1,
        n_levels: 12,
        n_responses: 1,
        responses: |x: &[f64; 1], y: &mut [f64]| y[0] = x[0],
    };
    let square = (GROWTH[1] * GROWTH[1]).exp();
    // The last is the normal distribution function at -(ln 3 - 1 + 0.125) / 0.5.
    let exact = [GROWTH[0].exp(), (2.0 * GROWTH[0]).exp() * (square - 1.0), 0.327_356_458_8];
    let target = |statistic, tolerance| {
        let tolerance = Tolerance::Absolute(tolerance);
        Target { response: 0, statistic, tolerance }
    };
    let targets = [
        target(Statistic::Mean, 0.06),
        target(Statistic::Variance, 0.25),
        target(Statistic::SmoothedExceedance { threshold: 3.0, width: 0.5 }, 0.02),
    ];
    let study = Multilevel {
        name: "coverage",
        targets: &targets,
        bias: Bias::Order(1.0),
        block_length: 64,
        pilot_blocks: 4,
        budget: 1e9,
    };
    let found = study.run(&ladder)?.targets;
    Ok(std::array::from_fn(|k| {
        (found[k].estimate.value - exact[k], NORMAL * found[k].root_mean_square_error())
    }))
}

/// Mean and variance of `exp(x)`, `x ~ N(0, 0.3^2)`, with `x` and `x^2` as control variates.
fn controlled(seed: u64) -> CaseResult<[Miss; 2]> {
    let v = 0.09_f64;
    let mut normals = [0.0; 250];
    Noise::new(seed).stream(Purpose::Field, 0).fill_normal(&mut normals);
    let row = |t: &f64| [(0.3 * t).exp(), 0.3 * t, 0.09 * t * t];
    let samples: Vec<f64> = normals.iter().flat_map(row).collect();
    let surrogates = [
        Surrogate { mean: 0.0, variance: Some(v) },
        Surrogate { mean: v, variance: Some(2.0 * v * v) },
    ];
    let found =
        ControlledSamples { samples: &samples, surrogates: &surrogates, seed }.estimate()?;
    let exact = [(0.5 * v).exp(), v.exp() * (v.exp() - 1.0)];
    Ok([miss(found.mean, exact[0], NORMAL), miss(found.variance, exact[1], NORMAL)])
}

/// Moments of `exp(w z)`, and the total index of the second input.
fn exponential(seed: u64, weights: [f64; 3]) -> CaseResult<[Miss; 3]> {
    let response = |z: &[f64]| z.iter().zip(weights).map(|(z, w)| w * z).sum::<f64>().exp();
    let s: f64 = weights.iter().map(|w| w * w).sum();
    let variance = s.exp() * s.exp_m1();
    // One less what remains if the input is fixed.
    let total = 1.0 - s.exp() * (s - weights[1] * weights[1]).exp_m1() / variance;
    by_polynomials(seed, response, [(0.5 * s).exp(), variance, total], 1)
}

/// Moments of `sin 0.8 z_1 + 0.5 z_2 cos 0.6 z_3`, and the total index of `z_3`, which acts by the other input alone.
fn sines(seed: u64) -> CaseResult<[Miss; 3]> {
    let response = |z: &[f64]| (0.8 * z[0]).sin() + 0.5 * z[1] * (0.6 * z[2]).cos();
    let mean_square_sine = 0.5 * (1.0 - (-2.0 * 0.64_f64).exp());
    let mean_square_cosine = 0.5 * (1.0 + (-2.0 * 0.36_f64).exp());
    let variance = mean_square_sine + 0.25 * mean_square_cosine;
    let total = 0.25 * (mean_square_cosine - (-0.36_f64).exp()) / variance;
    by_polynomials(seed, response, [0.0, variance, total], 2)
}

/// Mean, variance and the total index of an input, by polynomials of eight points a fold.
fn by_polynomials(
    seed: u64,
    response: impl Fn(&[f64]) -> f64,
    [mean, variance, total]: [f64; 3],
    input: usize,
) -> CaseResult<[Miss; 3]> {
    let cube = UnitCube {
        dimension: 3,
        sampling: Sampling::ScrambledSobol,
        seed,
        n_points: 8,
        n_replicas: REPLICAS,
    };
    let runs = cube.runs()?;
    let mut inputs = vec![0.0; 3 * 8 * FOLDS];
    inputs.chunks_exact_mut(3).zip(0..).for_each(|(z, run)| runs.normals(run, z));
    let values: Vec<f64> = inputs.chunks_exact(3).map(response).collect();
    let found = PolynomialControl::new(&inputs, 3, FOLDS)?.moments(&values)?;
    let (error, half_width) = miss(found.total[input], total, STUDENT_31);
    Ok([
        miss(found.moments.mean, mean, STUDENT_31),
        miss(found.moments.variance, variance, STUDENT_31),
        (error, half_width + found.unexplained),
    ])
}

/// A paraboloid in 100 dimensions; `z_1^2 + 0.1 z_2^2 > 16`, on both sides, where all lines are searched for both crossings.
fn lines(seed: u64) -> CaseResult<[Miss; 2]> {
    let curved = Model(100, paraboloid);
    let tail = TailSampling { model: &curved, level: paraboloid_level(100), seed };
    let on_one = tail.line_sampling(&tail.design_point()?, 100)?.probability;
    let ellipse = Model(2, |z: &[f64]| z[0] * z[0] + 0.1 * z[1] * z[1]);
    let tail = TailSampling { model: &ellipse, level: 16.0, seed };
    let on_both = tail.line_sampling(&tail.design_point_from(&[1.0, 0.0])?, 200)?.probability;
    // The trapezoidal rule over z_2.
    let on_line = |y: f64| {
        let beyond = 2.0 * normal_probability(-(16.0 - 0.1 * y * y).max(0.0).sqrt());
        0.01 * beyond * (-0.5 * y * y).exp() / std::f64::consts::TAU.sqrt()
    };
    let both: f64 = (-1200..=1200).map(|k| on_line(0.01 * f64::from(k))).sum();
    Ok([miss(on_one, exact_paraboloid(100), NORMAL), miss(on_both, both, NORMAL)])
}

/// The quantile of 0.9 of `exp(z)` by 300 samples, and of `z_1 + z_2` by replicas.
fn quantiles(seed: u64) -> CaseResult<[Miss; 2]> {
    let exact = normal_quantile(0.9);
    let mut samples = [0.0; 300];
    Noise::new(seed).stream(Purpose::Field, 0).fill_normal(&mut samples);
    let [low, high] = quantile(&samples.map(f64::exp), 0.9, 0.95)?.interval;
    let of_samples = (0.5 * (low + high) - exact.exp(), 0.5 * (high - low));
    let sampling = Sampling::ScrambledSobol;
    let cube = UnitCube { dimension: 2, sampling, seed, n_points: 128, n_replicas: REPLICAS };
    let runs = cube.runs()?;
    let mut z = [0.0; 2];
    let values: Vec<f64> = (0..runs.n_runs())
        .map(|run| {
            runs.normals(run, &mut z);
            z[0] + z[1]
        })
        .collect();
    let of_replicas = cube.quantile_of_runs(&values, 0.9)?;
    Ok([of_samples, miss(of_replicas, exact * 2.0_f64.sqrt(), STUDENT_31)])
}

fn of_ishigami(sampling: Sampling, seed: u64, n_points: u64) -> UnitCube {
    UnitCube { dimension: 3, sampling, seed, n_points, n_replicas: REPLICAS }
}

fn cube(sampling: Sampling, seed: u64) -> CaseResult<[Miss; 2]> {
    let found = of_ishigami(sampling, seed, 256).moments(1, ishigami)?[0];
    Ok([
        miss(found.mean, EXACT.mean, STUDENT_31),
        miss(found.variance, EXACT.variance(), STUDENT_31),
    ])
}

fn sensitivity(sampling: Sampling, seed: u64) -> CaseResult<[Miss; 5]> {
    let found = &of_ishigami(sampling, seed, 256).sobol_indices(1, ishigami)?[0];
    let (first, total) = (EXACT.first(), EXACT.total());
    Ok([
        miss(found.first[0], first[0], STUDENT_31),
        miss(found.first[1], first[1], STUDENT_31),
        miss(found.total[0], total[0], STUDENT_31),
        miss(found.total[2], total[2], STUDENT_31),
        miss(found.total_sum, total.iter().sum(), STUDENT_31),
    ])
}

/// Constants of Ishigami's function, and its mean.
struct Ishigami {
    a: f64,
    b: f64,
    mean: f64,
}

const EXACT: Ishigami = Ishigami { a: 7.0, b: 0.1, mean: 3.5 };

/// `sin x_0 + a sin^2 x_1 + b x_2^4 sin x_0`, each uniform in `(-pi, pi)`.
#[allow(clippy::unnecessary_wraps, reason = "a response may fail")]
fn ishigami(u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
    let x = [0, 1, 2].map(|i| PI * (2.0 * u[i] - 1.0));
    let sine = x[0].sin();
    y[0] = sine + EXACT.a * x[1].sin().powi(2) + EXACT.b * x[2].powi(4) * sine;
    Ok(())
}

impl Ishigami {
    /// Parts of the variance by the first input alone, the second alone, and the first with the third.
    fn parts(&self) -> [f64; 3] {
        let (a, b) = (self.a, self.b);
        [0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2), a * a / 8.0, 8.0 * b * b * PI.powi(8) / 225.0]
    }

    fn variance(&self) -> f64 {
        self.parts().iter().sum()
    }

    fn first(&self) -> [f64; 3] {
        let [alone, second, _] = self.parts();
        [alone, second, 0.0].map(|part| part / self.variance())
    }

    fn total(&self) -> [f64; 3] {
        let [alone, second, both] = self.parts();
        [alone + both, second, both].map(|part| part / self.variance())
    }
}
