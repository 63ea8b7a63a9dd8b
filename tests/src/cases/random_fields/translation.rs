//! Marginals by translation, and the correlation that they keep.

use random_fields::Marginal;
use result_figures::{ErrorKind, Measured, Reference};
use sde_integrators::{Noise, Purpose};

use super::largest;
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "random-fields/translation",
    title: "moments and correlations of lognormal, Weibull and uniform values of a Gaussian field",
    source: "Grigoriu 1995, section 3.1; Liu and Der Kiureghian 1986",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const MARGINALS: [(&str, Marginal); 5] = [
    ("lognormal-0.3", Marginal::Lognormal { mean: 23.0, coefficient_of_variation: 0.3 }),
    ("lognormal-1", Marginal::Lognormal { mean: 23.0, coefficient_of_variation: 1.0 }),
    ("weibull-1", Marginal::Weibull { mean: 2.0, shape: 1.0 }),
    ("weibull-5", Marginal::Weibull { mean: 2.0, shape: 5.0 }),
    ("uniform", Marginal::Uniform { low: -1.0, high: 3.0 }),
];

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    for (name, marginal) in &MARGINALS {
        context.progress(name);
        claims.push(quadrature(context, name, marginal)?);
        claims.push(inverse(context, name, marginal)?);
        for (sign, rho) in [("negative", -0.7), ("positive", 0.5)] {
            claims.push(sampled(context, &format!("{name}/sampled/{sign}"), marginal, rho)?);
        }
    }
    claims.push(opposed_exponentials(context)?);
    Ok(claims)
}

/// `E[x(z_1) x(z_2)]` by the trapezoidal rule in both normals.
fn quadrature(context: &Context<'_>, name: &str, marginal: &Marginal) -> Result<Claim, CaseError> {
    let step = 1.0 / 32.0;
    let density = |z: f64| step * (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let nodes: Vec<f64> = (-320..=320).map(|k| step * f64::from(k)).collect();
    let mut errors = Vec::new();
    for rho in [-0.95_f64, -0.5, 0.1, 0.5, 0.9] {
        let across = (1.0 - rho * rho).sqrt();
        let mut product = 0.0;
        for a in &nodes {
            let inner: f64 =
                nodes.iter().map(|b| density(*b) * marginal.at(rho * a + across * b)).sum();
            product += density(*a) * marginal.at(*a) * inner;
        }
        let exact = (product - marginal.mean().powi(2)) / marginal.standard_deviation().powi(2);
        errors.push((marginal.translated_correlation(rho)? - exact).abs());
    }
    let subject = context.subject(
        &format!("{name}/quadrature"),
        "correlation of two values, worst error of five correlations of their normals",
        "",
        "closed form or Mehler's series of 40 terms; trapezoidal rule in both normals",
    );
    let (tolerance, reason) = (2e-13, "roundoff: of a sum of 400,000 products");
    Ok(Claim::within(subject, ErrorKind::Absolute, (largest(errors), 0.0), tolerance, reason))
}

fn inverse(context: &Context<'_>, name: &str, marginal: &Marginal) -> Result<Claim, CaseError> {
    let mut errors = Vec::new();
    for k in -20..=20 {
        let rho = 0.05 * f64::from(k);
        let back = marginal.normal_correlation(marginal.translated_correlation(rho)?)?;
        errors.push((back - rho).abs());
    }
    let subject = context.subject(
        &format!("{name}/inverse"),
        "correlation of normals from that of values, worst error of 41",
        "",
        "there and back",
    );
    let reason = "roundoff: over the slope of the correlation, at least 0.3";
    Ok(Claim::within(subject, ErrorKind::Absolute, (largest(errors), 0.0), 1e-14, reason))
}

fn sampled(
    context: &Context<'_>,
    id: &str,
    marginal: &Marginal,
    rho: f64,
) -> Result<Claim, CaseError> {
    let mut stream = Noise::new(71).stream(Purpose::Field, 0);
    let across = (1.0 - rho * rho).sqrt();
    let draws = 200_000;
    let mut sums = [0.0; 2];
    let (mean, variance) = (marginal.mean(), marginal.standard_deviation().powi(2));
    for _ in 0..draws {
        let [a, b] = stream.next_normal_pair();
        let product =
            (marginal.at(a) - mean) * (marginal.at(rho * a + across * b) - mean) / variance;
        sums[0] += product;
        sums[1] += product * product;
    }
    let n = f64::from(draws);
    let value = sums[0] / n;
    let error = ((sums[1] / n - value * value) / n).sqrt();
    let subject = context.subject(
        id,
        "correlation of two values",
        "",
        &format!("200,000 pairs of values, whose normals have {rho}"),
    );
    let measured = Measured { value, standard_error: Some(error) };
    let reference = Reference::exact(marginal.translated_correlation(rho)?);
    let criterion = Criterion::MonteCarlo { bias_bound: 0.0, reason: "none" };
    Ok(Claim::judge(subject, ErrorKind::Absolute, measured, reference, criterion))
}

/// Two exponential variables of opposed quantiles: `1 - pi^2/6`.
fn opposed_exponentials(context: &Context<'_>) -> Result<Claim, CaseError> {
    let marginal = Marginal::Weibull { mean: 1.0, shape: 1.0 };
    let subject = context.subject(
        "weibull-1/least",
        "least correlation of two exponential values",
        "",
        "Mehler's series at -1; 1 - pi^2/6",
    );
    let exact = 1.0 - std::f64::consts::PI.powi(2) / 6.0;
    let values = (marginal.translated_correlation(-1.0)?, exact);
    Ok(Claim::within(
        subject,
        ErrorKind::Absolute,
        values,
        1e-13,
        "roundoff: of 40 terms of the series",
    ))
}
