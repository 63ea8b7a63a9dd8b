//! Sobol' indices of Ishigami's function, and of one of twenty inputs.

use std::f64::consts::PI;

use result_figures::ErrorKind;
use uq_estimators::{Estimate, Failure, Sampling, SobolIndices, UnitCube};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "uq-estimators/sobol-indices",
    title: "first-order and total Sobol' indices of Ishigami's function and of a product of twenty factors",
    source: "closed forms: Ishigami and Homma 1990; Sobol' 1993",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// Constants of Ishigami's function, and its mean.
pub(super) struct Ishigami {
    a: f64,
    b: f64,
    pub(super) mean: f64,
}

pub(super) const EXACT: Ishigami = Ishigami { a: 7.0, b: 0.1, mean: 3.5 };

/// `sin x_0 + a sin^2 x_1 + b x_2^4 sin x_0`, each uniform in `(-pi, pi)`.
#[allow(clippy::unnecessary_wraps, reason = "a response may fail")]
pub(super) fn ishigami(u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
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

    pub(super) fn variance(&self) -> f64 {
        self.parts().iter().sum()
    }

    pub(super) fn first(&self) -> [f64; 3] {
        let [alone, second, _] = self.parts();
        [alone, second, 0.0].map(|part| part / self.variance())
    }

    pub(super) fn total(&self) -> [f64; 3] {
        let [alone, second, both] = self.parts();
        [alone + both, second, both].map(|part| part / self.variance())
    }
}

/// Inputs of the product.
const FACTORS: usize = 20;

/// Slope of a factor: `f = prod (1 + (2 u_i - 1) / c_i)`, `c_i = 1 + i`.
fn weight(i: usize) -> f64 {
    1.0 / (1.0 + i as f64)
}

#[allow(clippy::unnecessary_wraps, reason = "a response may fail")]
fn product(u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
    y[0] = u.iter().enumerate().map(|(i, u)| 1.0 + weight(i) * (2.0 * u - 1.0)).product();
    Ok(())
}

/// Names of the quantities with their exact values, in the order of [`values`].
fn names(first: &[f64], total: &[f64]) -> Vec<(String, f64)> {
    let numbered = |name: &'static str, exact: &[f64]| {
        let each = exact.iter().enumerate().map(|(i, exact)| (format!("{name}-{i}"), *exact));
        each.collect::<Vec<_>>()
    };
    let mut all = numbered("first", first);
    all.extend(numbered("total", total));
    all.push(("first-sum".into(), first.iter().sum()));
    all.push(("total-sum".into(), total.iter().sum()));
    all
}

fn values(found: &SobolIndices) -> Vec<Estimate> {
    let mut all = found.first.clone();
    all.extend(&found.total);
    all.extend([found.first_sum, found.total_sum]);
    all
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let samplings =
        [("pseudo-random", Sampling::PseudoRandom), ("scrambled-sobol", Sampling::ScrambledSobol)];
    let mut claims = Vec::new();
    for (name, sampling) in samplings {
        context.progress(name);
        let cube = UnitCube { dimension: 3, sampling, seed: 71, n_points: 256, n_replicas: 32 };
        let found = &cube.sobol_indices(1, ishigami)?[0];
        let exact = names(&EXACT.first(), &EXACT.total());
        for ((quantity, exact), estimate) in exact.iter().zip(values(found)) {
            claims.push(index(context, &format!("ishigami/{name}/{quantity}"), estimate, *exact));
        }
        let t = |i: usize| weight(i).powi(2) / 3.0;
        let whole: f64 = (0..FACTORS).map(|i| 1.0 + t(i)).product();
        let first: Vec<f64> = (0..FACTORS).map(|i| t(i) / (whole - 1.0)).collect();
        let total: Vec<f64> =
            first.iter().enumerate().map(|(i, s)| s * whole / (1.0 + t(i))).collect();
        let cube = UnitCube { dimension: FACTORS, ..cube };
        let found = &cube.sobol_indices(1, product)?[0];
        let of_all = names(&first, &total);
        let worst = of_all.iter().zip(values(found)).map(|((_, exact), estimate)| {
            ((estimate.value - exact) / estimate.standard_error().unwrap_or(f64::NAN)).abs()
        });
        let worst =
            worst.fold(0.0, |worst: f64, z| if z.is_nan() || z > worst { z } else { worst });
        let subject = context.subject(
            &format!("twenty-inputs/{name}/worst"),
            "standard errors between an index and its exact value, the largest of 42",
            "s.e.",
            "256 points in each of 32 replicas",
        );
        let reason =
            "statistics: the largest of 42, by Student's distribution with 31 degrees of freedom";
        claims.push(Claim::within(subject, ErrorKind::Absolute, (worst, 0.0), 4.2, reason));
    }
    Ok(claims)
}

fn index(context: &Context<'_>, id: &str, estimate: Estimate, exact: f64) -> Claim {
    let standard_error = estimate.standard_error().unwrap_or(f64::NAN);
    let method = format!(
        "256 points in each of 32 replicas: {:.5} +- {standard_error:.1e}, exact {exact:.5}",
        estimate.value
    );
    let what = "standard errors between an index and its exact value";
    let subject = context.subject(id, what, "s.e.", &method);
    let reason = "statistics: three standard errors";
    let error = (estimate.value - exact) / standard_error;
    Claim::within(subject, ErrorKind::Absolute, (error, 0.0), 3.0, reason)
}
