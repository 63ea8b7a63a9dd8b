//! Eigenvalues, truncation, and one function on every mesh.

use nalgebra::DMatrix;
use random_fields::{ConditionedField, Measurement, RandomField, Truncation};
use result_figures::ErrorKind;
use sde_integrators::Noise;

use super::{CORNERS, exponential, largest, lattice, soil};
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "random-fields/expansion",
    title: "Karhunen-Loève terms of a box and of points: eigenvalues, truncation, one function on every mesh",
    source: "Ghanem and Spanos 1991, section 2.3.3; eigenvalues of the dense matrix",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = vec![printed_equations(context)?, trace(context)?];
    claims.extend(dense(context)?);
    claims.extend(truncation(context)?);
    claims.push(meshes(context)?);
    Ok(claims)
}

/// The root between two values of opposite sign, by bisection.
fn bisection(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let is_positive = f(low) > 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if (f(middle) > 0.0) == is_positive { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// `b - w tan w = 0` and `w + b tan w = 0`, multiplied by the cosine, solved one by one.
fn printed_equations(context: &Context<'_>) -> Result<Claim, CaseError> {
    use std::f64::consts::FRAC_PI_2;
    let mut errors = Vec::new();
    for b in [0.02_f64, 0.5, 3.0, 40.0] {
        let field =
            RandomField::on_box([[0.0], [2.0 * b]], exponential(1.0), Truncation::Terms(100))?;
        for (m, share) in field.shares().iter().enumerate() {
            let (low, high) = (m as f64 * FRAC_PI_2, (m + 1) as f64 * FRAC_PI_2);
            let root = if m % 2 == 0 {
                bisection(low, high, |w| b * w.cos() - w * w.sin())
            } else {
                bisection(low, high, |w| w * w.cos() + b * w.sin())
            };
            // lambda/(2 a) with a = b l.
            errors.push((share * b * (1.0 + (root / b).powi(2)) - 1.0).abs());
        }
    }
    let subject = context.subject(
        "eigenvalues/printed-equations",
        "eigenvalue of the exponential correlation on an interval, worst relative error",
        "",
        "100 terms each on intervals of 0.04, 1, 6 and 80 lengths; the equations as printed by bisection",
    );
    let reason = "roundoff: of a root beside a multiple of pi/2, squared";
    Ok(Claim::within(subject, ErrorKind::Absolute, (largest(errors), 0.0), 2e-13, reason))
}

/// Shares fall as `4 b/(pi m)^2` and sum up to one.
fn trace(context: &Context<'_>) -> Result<Claim, CaseError> {
    let (b, n) = (1.5, 2000);
    let field = RandomField::on_box([[0.0], [2.0 * b]], exponential(1.0), Truncation::Terms(n))?;
    // The roots are m pi/2 + 2 b/(m pi): to first order 1/theta^2 sums up as 1/(m pi/2)^2.
    let tail = 4.0 * b / (std::f64::consts::PI.powi(2) * (n as f64 - 0.5));
    let subject = context.subject(
        "eigenvalues/trace",
        "variance left out by 2,000 terms on an interval of 3 lengths",
        "",
        "one less the sum of all shares, against the asymptotic sum of the others",
    );
    let reason = "the next term of the asymptotic sum, of order 1/n^2";
    let values = (field.mean_left_out_variance(), tail);
    Ok(Claim::within(subject, ErrorKind::Relative, values, 1e-6, reason))
}

/// Terms by points against all eigenvalues of the covariance of these points.
fn dense(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let points = lattice(CORNERS[0], [16, 21], [0.2, 0.2]);
    let n = points.len();
    let matrix = DMatrix::from_fn(n, n, |i, j| soil().between(&points[i], &points[j]) / n as f64);
    let mut exact: Vec<f64> = matrix.symmetric_eigenvalues().iter().copied().collect();
    exact.sort_by(|a, b| b.total_cmp(a));
    let whole = RandomField::on_points(&points, soil(), Truncation::Terms(n.div_ceil(4)))?;
    let errors =
        whole.shares().iter().zip(&exact).map(|(found, exact)| (found / exact - 1.0).abs());
    let subject = context.subject(
        "points/all-pivots",
        "eigenvalue of the covariance of 336 points, worst relative error of 84",
        "",
        "pivoted Cholesky with all points as pivots; nalgebra",
    );
    let reason = "roundoff: of an eigenvalue a thousandth of the largest";
    let mut claims =
        vec![Claim::within(subject, ErrorKind::Absolute, (largest(errors), 0.0), 2e-13, reason)];
    let few = RandomField::on_points(&points, soil(), Truncation::Terms(20))?;
    let least = 1.0 - exact[..20].iter().sum::<f64>();
    let subject = context.subject(
        "points/four-pivots-a-term",
        "variance left out by 20 terms over the least that 20 terms leave",
        "",
        "80 pivots of 336 points; all eigenvalues by nalgebra",
    );
    let reason = "what 80 pivots leave of the first 20 modes";
    let values = (few.mean_left_out_variance(), least);
    claims.push(Claim::within(subject, ErrorKind::Relative, values, 0.06, reason));
    Ok(claims)
}

/// The covariance of the terms differs from the correlation as stated: no more, and not much less.
fn truncation(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let inner = lattice([0.05, 0.05], [30, 40], [0.1, 0.1]);
    let cover = lattice(CORNERS[0], [31, 41], [0.1, 0.1]);
    let fields = [
        ("box", RandomField::on_box(CORNERS, soil(), Truncation::Share(0.9))?),
        ("points", RandomField::on_points(&cover, soil(), Truncation::Share(0.9))?),
    ];
    let mut claims = Vec::new();
    for (name, field) in &fields {
        let pairs = lattice([0.05, 0.05], [8, 10], [0.4, 0.4]);
        let mut over = Vec::new();
        let left: Vec<f64> =
            pairs.iter().map(|x| field.left_out_variance(x)).collect::<Result<_, _>>()?;
        for (i, a) in pairs.iter().enumerate() {
            for (j, b) in pairs.iter().enumerate().filter(|&(j, _)| j != i) {
                let error = (soil().between(a, b) - field.covariance(a, b)?).abs();
                over.push(error / (left[i] * left[j]).sqrt());
            }
        }
        let method = format!("{} terms, 90 % of the variance, 80 points", field.n_terms());
        let subject = context.subject(
            &format!("truncation/{name}/bound"),
            "error of a covariance over its stated bound, worst of all pairs of different points",
            "",
            &method,
        );
        let reason = "a bound that is reached in order of size: above 1 it would be wrong";
        let worst = largest(over);
        claims.push(Claim::within(subject, ErrorKind::Absolute, (worst, 0.5), 0.5, reason));
        let mean = inner.iter().map(|x| field.left_out_variance(x)).sum::<Result<f64, _>>()?
            / inner.len() as f64;
        let subject = context.subject(
            &format!("truncation/{name}/mean"),
            "mean variance left out, sampled over the body against the stated mean",
            "",
            &method,
        );
        // The stated mean is that over the box, or over the points that made the field.
        let (tolerance, reason) = match *name {
            "box" => (0.02, "a mean over 1,200 points for one over the box"),
            _ => (
                0.35,
                "a rough field has more left out between the points that made it, a tenth of a length apart",
            ),
        };
        let values = (mean, field.mean_left_out_variance());
        claims.push(Claim::within(subject, ErrorKind::Relative, values, tolerance, reason));
    }
    Ok(claims)
}

/// Values at the points that a coarse and a fine mesh share.
fn meshes(context: &Context<'_>) -> Result<Claim, CaseError> {
    let (coarse, fine) = (
        lattice([0.0, 0.0], [13, 17], [0.25, 0.25]),
        lattice([0.0, 0.0], [25, 33], [0.125, 0.125]),
    );
    let on_box = RandomField::on_box(CORNERS, soil(), Truncation::Terms(100))?;
    let on_points = RandomField::on_points(&coarse, soil(), Truncation::Terms(50))?;
    let scaled = on_points.clone().with_unit_variance();
    let at = |x: f64, y: f64, value: f64| Measurement {
        position: [x, y],
        value,
        standard_deviation: 0.0,
    };
    let measured = [at(0.3, 0.4, 1.0), at(2.0, 3.0, -2.0)];
    let (mut different, mut compared) = (0, 0);
    for field in [on_box, on_points, scaled] {
        let given = ConditionedField::new(field.clone(), &measured)?;
        let mut coefficients = vec![0.0; field.n_terms()];
        given.coefficients(&Noise::new(5), 3, 0, &mut coefficients)?;
        let values = |points: &[[f64; 2]]| -> Result<Vec<f64>, CaseError> {
            let mut out = vec![0.0; points.len()];
            field.values(&coefficients, points, &mut out)?;
            Ok(out)
        };
        let (on_coarse, on_fine) = (values(&coarse)?, values(&fine)?);
        for (k, value) in on_coarse.iter().enumerate() {
            let same = 2 * (k % 13) + 25 * 2 * (k / 13);
            different += usize::from(value.to_bits() != on_fine[same].to_bits());
            compared += 1;
        }
    }
    let subject = context.subject(
        "meshes/same-bits",
        "values of a realisation that differ between a coarse and a fine mesh",
        "",
        "box, points, points scaled to unit variance; given two measurements; 221 shared points",
    );
    Ok(Claim::same_bits(subject, different, compared, "a value depends on its point alone"))
}
