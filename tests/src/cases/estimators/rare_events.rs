//! Rare events of many standard normals: closed forms in 2 to 500 dimensions, and what another sampling makes of them.

use result_figures::{ErrorKind, Measured, Reference};
use sde_integrators::{
    DesignPoint, Estimate, Noise, Purpose, importance_sampling, normal_probability,
};
use uq_estimators::{Error, Failure, NormalModel, SubsetConfig, TailSampling};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::sde_ensembles::{against_exact, sampled};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "uq-estimators/rare-events",
    title: "Line sampling and subset simulation of many standard normals: hyperplane, paraboloids, sphere, sum of lognormals",
    source: "closed forms: normal and chi-square distributions; plain samples",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// A closure of normals, without a gradient.
pub(super) struct Model<F>(pub(super) usize, pub(super) F);

impl<F: Fn(&[f64]) -> f64 + Sync> NormalModel for Model<F> {
    fn n_normals(&self) -> usize {
        self.0
    }

    fn value(&self, normals: &[f64]) -> Result<f64, Failure> {
        Ok((self.1)(normals))
    }
}

fn square(z: &[f64]) -> f64 {
    z.iter().map(|z| z * z).sum()
}

/// Half of the curvature of the paraboloids.
const HALF_CURVATURE: f64 = 0.01;

/// `z_1 + 0.01 (z_2^2 + ... + z_n^2)`.
pub(super) fn paraboloid(z: &[f64]) -> f64 {
    z[0] + HALF_CURVATURE * square(&z[1..])
}

/// Four deviations beyond the mean of a paraboloid.
pub(super) fn paraboloid_level(n: usize) -> f64 {
    4.0 + HALF_CURVATURE * (n - 1) as f64
}

/// `P(z_1 + 0.01 chi^2 > level)`: the trapezoidal rule over the root `y` of chi-square, whose density is `y^(n - 2) exp(-y^2/2)`
/// within a factor.
pub(super) fn exact_paraboloid(n: usize) -> f64 {
    let (mut sum, mut whole) = (0.0, 0.0);
    let largest = ((n - 1) as f64).sqrt();
    for k in 1..8000 {
        let y = f64::from(k) * (largest + 12.0) / 8000.0;
        let density =
            ((n - 2) as f64 * (y / largest).ln() - 0.5 * (y * y - largest * largest)).exp();
        whole += density;
        sum += density * normal_probability(HALF_CURVATURE * y * y - paraboloid_level(n));
    }
    sum / whole
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = vec![hyperplane(context)?];
    for n in [2, 20, 100, 500] {
        claims.push(of_paraboloid(context, n)?);
    }
    claims.push(shifted(context, 500)?);
    claims.extend(sphere(context)?);
    claims.push(lognormals(context)?);
    Ok(claims)
}

fn hyperplane(context: &Context<'_>) -> Result<Claim, CaseError> {
    let value = |z: &[f64]| z.iter().zip(1..).map(|(z, k)| z / f64::from(k)).sum();
    let deviation = (1..=300).map(|k| f64::from(k).powi(-2)).sum::<f64>().sqrt();
    let model = Model(300, value);
    let tail = TailSampling { model: &model, level: 5.0 * deviation, seed: 11 };
    let found = tail.line_sampling(&tail.design_point()?, 64)?;
    Ok(Claim::within(
        context.subject(
            "hyperplane",
            "P(sum of z_k / k > 5 deviations)",
            "",
            "64 lines, 300 normals",
        ),
        ErrorKind::Relative,
        (found.probability.value, normal_probability(-5.0)),
        1e-10,
        "roundoff: a gradient by differences has 1e-12 over its step of 1e-4, and its square is the error of the index",
    ))
}

fn of_paraboloid(context: &Context<'_>, n: usize) -> Result<Claim, CaseError> {
    let model = Model(n, paraboloid);
    let tail = TailSampling { model: &model, level: paraboloid_level(n), seed: 12 };
    let found = tail.line_sampling(&tail.design_point()?, 1_000)?;
    against_exact(
        context,
        (
            &format!("paraboloid/{n}"),
            "P(z_1 + 0.01 (z_2^2 + ... + z_n^2) > 4 + 0.01 (n - 1))",
            &format!("1,000 lines, {n} normals, {} runs", found.runs.values),
        ),
        &found.probability,
        exact_paraboloid(n),
        (1e-4, "the error of a root, 1e-4 of the probability on a line"),
    )
}

/// Normals about the same design point, as many as lines take runs: none of them are where the probability is.
fn shifted(context: &Context<'_>, n: usize) -> Result<Claim, CaseError> {
    let model = Model(n, paraboloid);
    let level = paraboloid_level(n);
    let point = TailSampling { model: &model, level, seed: 12 }.design_point()?;
    let (normals, reliability_index) = (point.normals, point.reliability_index);
    let point = DesignPoint { normals, reliability_index, iterations: point.steps };
    let found = importance_sampling(&|z| Ok(paraboloid(z)), level, &point, &Noise::new(13), 2_000)?;
    Ok(Claim::as_measured(
        context.subject(
            &format!("shifted-normal/{n}"),
            "probability by normals about the design point, over the exact one",
            "",
            "2,000 samples of sde-integrators, 500 normals",
        ),
        Measured::exact(found.value / exact_paraboloid(n)),
        0.0,
        0.01,
        "the design point is nine deviations away, most of the event five beside it: why lines are sampled",
    ))
}

/// `P(|z|^2 > 640)` in 500 dimensions: no direction is important.
fn sphere(context: &Context<'_>) -> Result<[Claim; 2], CaseError> {
    let (n, level) = (500, 640.0);
    let model = Model(n, square);
    let tail = TailSampling { model: &model, level, seed: 14 };
    // Chi-square with an even number of degrees of freedom is a sum of Poisson's terms.
    let (mut term, mut sum) = (1.0, 1.0);
    for j in 1..n / 2 {
        term *= 0.5 * level / j as f64;
        sum += term;
    }
    let exact = (-0.5 * level).exp() * sum;
    let config = SubsetConfig { n_samples: 1_000, correlation: 0.8, n_runs: 24 };
    let found = tail.subset(&config)?;
    let point = tail.design_point_from(&[0.1; 500])?;
    let is_refused = matches!(tail.line_sampling(&point, 400), Err(Error::UnevenWeights { .. }));
    Ok([
        against_exact(
            context,
            ("sphere/subset", "P(chi-square of 500 > 640)", "24 runs of 1,000 a level"),
            &found.probability,
            exact,
            (0.1, "the bias of a run: the square of its coefficient of variation, 0.3"),
        )?,
        Claim::within(
            context.subject("sphere/refused", "lines refused for uneven weights", "", "400 lines"),
            ErrorKind::Absolute,
            (f64::from(u8::from(is_refused)), 1.0),
            0.0,
            "no direction is important",
        ),
    ])
}

/// A sum of 50 lognormals with a common factor, against plain samples.
fn lognormals(context: &Context<'_>) -> Result<Claim, CaseError> {
    const N: usize = 51;
    let value = |z: &[f64]| z[1..].iter().map(|own| (0.2 * z[0] + 0.3 * own).exp()).sum::<f64>();
    let (level, n_samples) = (100.0, 400_000);
    let (mut z, mut hits) = ([0.0; N], 0);
    for sample in 0..n_samples {
        Noise::new(15).stream(Purpose::Field, sample).fill_normal(&mut z);
        hits += u64::from(value(&z) > level);
    }
    let plain = Estimate::probability(hits, n_samples)?;
    let model = Model(N, value);
    let tail = TailSampling { model: &model, level, seed: 16 };
    let found = tail.line_sampling(&tail.design_point()?, 400)?;
    let plain = sampled(&plain)?;
    let error = plain.standard_error.ok_or("no sample above the level")?;
    Ok(Claim::judge(
        context.subject(
            "lognormal-sum",
            "P(sum of 50 lognormals > 100)",
            "",
            &format!("400 lines, {} runs, against 400,000 plain samples", found.runs.values),
        ),
        ErrorKind::Relative,
        sampled(&found.probability)?,
        Reference::uncertain(plain.value, error),
        Criterion::MonteCarlo { bias_bound: 1e-4, reason: "the error of a root" },
    ))
}
