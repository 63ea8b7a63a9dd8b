//! Rare events of many standard normals: closed forms in 2 to 500 dimensions, and plain samples.

use sde_integrators::{Estimate, Noise, Purpose, normal_probability};
use uq_estimators::{Failure, NormalModel, TailSampling};

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "uq-estimators/rare-events",
    title: "Line sampling of many standard normals: paraboloids, sum of lognormals",
    source: "quadrature over the normal and the chi-square distribution; plain samples",
    cost: Profile::Quick,
    run: Together(run),
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

fn run(context: &Context<'_>) -> CaseResult {
    let mut claims = Vec::new();
    for n in [2, 20, 100, 500] {
        claims.push(of_paraboloid(context, n)?);
    }
    claims.push(lognormals(context)?);
    Ok(claims)
}

fn of_paraboloid(context: &Context<'_>, n: usize) -> CaseResult<Claim> {
    let model = Model(n, paraboloid);
    let tail = TailSampling { model: &model, level: paraboloid_level(n), seed: 12 };
    let found = tail.line_sampling(&tail.design_point()?, 1_000)?;
    let quantity = "P(z_1 + 0.01 (z_2^2 + ... + z_n^2) > 4 + 0.01 (n - 1))";
    let method = format!("1,000 lines, {n} normals, {} runs", found.runs.values);
    let subject = context.subject(format!("paraboloid/{n}"), quantity, method);
    let compared = subject.relative(sampled(&found.probability)?, exact_paraboloid(n));
    Ok(compared.monte_carlo(1e-4).because("the error of a root, 1e-4 of the probability on a line"))
}

/// A sum of 50 lognormals with a common factor, against plain samples.
fn lognormals(context: &Context<'_>) -> CaseResult<Claim> {
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
    let method = format!("400 lines, {} runs, against 400,000 plain samples", found.runs.values);
    let reason = "the error of a root";
    let subject = context.subject("lognormal-sum", "P(sum of 50 lognormals > 100)", method);
    Ok(subject
        .relative(sampled(&found.probability)?, estimated(&plain))
        .monte_carlo(1e-4)
        .because(reason))
}
