//! The warning against the truth: how often it is right.

use perturbation_moments::{Trust, Verdict};
use result_figures::ErrorKind;

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Subject;
use crate::perturbation_moments::reference::{ReferenceCase, ReferenceTable};
use crate::perturbation_moments::responses::{Assessed, assess};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "perturbation-moments/trust",
    title: "Warnings against the true error of the first-order variance, 49 cases and a pole",
    source: "variances by Gauss-Hermite quadrature; failures of the research note",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// A first-order variance that is further off is wrong.
const WRONG: f64 = 0.1;

/// One case with what is known of it.
struct Judged {
    case: ReferenceCase,
    assessed: Assessed,
    /// Of the first-order variance.
    error: f64,
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut judged = Vec::new();
    for case in ReferenceTable::read()?.cases {
        let assessed = assess(&case)?;
        let error = assessed.variance_first_order / case.quadrature.var - 1.0;
        judged.push(Judged { case, assessed, error });
    }
    let settled: Vec<&Judged> = judged.iter().filter(|j| j.case.has_a_variance()).collect();
    let kappa_alone =
        |a: &Assessed| a.trust.curvature_ratio.is_none_or(|ratio| ratio > Trust::LIMIT);
    let both = |a: &Assessed| a.trust.verdict() != Verdict::InPeace;
    let witnessed = |a: &Assessed| a.witnessed.verdict() != Verdict::InPeace;
    let mut claims = Vec::new();
    claims.extend(table(context, "both", &settled, both, [4, 1, 0, 44]));
    claims.extend(table(context, "kappa-alone", &settled, kappa_alone, [3, 1, 1, 44]));
    claims.extend(table(context, "with-sigma-points", &settled, witnessed, [4, 3, 0, 42]));
    claims.push(failures(context, &judged));
    claims.push(left_in_peace(context, &judged));
    claims.push(indicators(context, &judged));
    Ok(claims)
}

/// The indicators against the variances of another program: `kappa = var_2/var_1 - 1`, `tau = abs(var_4 - var_2)/var_1`.
fn indicators(context: &Context<'_>, judged: &[Judged]) -> Claim {
    let mut worst = 0.0_f64;
    for Judged { case, assessed, .. } in judged {
        let (first, by_formula) = (assessed.variance_first_order, &case.second_order);
        let Trust { curvature_ratio, third_ratio, .. } = assessed.trust;
        let curvature = by_formula.var2 / first - 1.0;
        let third = (by_formula.var_o4_with_third_derivs - by_formula.var2).abs() / first;
        for (found, expected) in [(curvature_ratio, curvature), (third_ratio, third)] {
            let error = (found.unwrap_or(f64::NAN) - expected).abs();
            worst = if error.is_nan() || worst.is_nan() { f64::NAN } else { worst.max(error) };
        }
    }
    let subject = context.subject(
        "indicators",
        "worst error of the two indicators",
        "",
        "51 cases, against variances by closed formulas on JAX derivatives",
    );
    let reason = "roundoff: differences of variances, eps times their ratio";
    Claim::within(subject, ErrorKind::Absolute, (worst, 0.0), 1e-13, reason)
}

/// The four counts of warned or not against wrong or not.
fn table(
    context: &Context<'_>,
    name: &str,
    judged: &[&Judged],
    warned: impl Fn(&Assessed) -> bool,
    expected: [usize; 4],
) -> Vec<Claim> {
    let cells = [
        ("warned-and-wrong", "warned, and off by more than 10 %", true, true),
        ("false-alarms", "warned, but within 10 %", true, false),
        ("misses", "left in peace, but off by more than 10 %", false, true),
        ("in-peace-and-right", "left in peace, and within 10 %", false, false),
    ];
    cells
        .into_iter()
        .zip(expected)
        .map(|((cell, quantity, alarm, wrong), expected)| {
            let found: Vec<&str> = judged
                .iter()
                .filter(|j| warned(&j.assessed) == alarm && (j.error.abs() > WRONG) == wrong)
                .map(|j| j.case.name.as_str())
                .collect();
            let method = if found.len() <= 6 { found.join(", ") } else { String::new() };
            let subject = context.subject(&format!("{name}/{cell}"), quantity, "cases", &method);
            let reason = "counted over the cases whose true variance is known; the limit 0.05 was chosen before";
            counted(subject, found.len(), expected, reason)
        })
        .collect()
}

/// A count that is known.
fn counted(subject: Subject, found: usize, expected: usize, reason: &str) -> Claim {
    let counts = (found as f64, expected as f64);
    Claim::within(subject, ErrorKind::Absolute, counts, 0.0, reason)
}

/// Those that must be warned of: how many are, by the larger of their indicators.
fn failures(context: &Context<'_>, judged: &[Judged]) -> Claim {
    let failures: Vec<&Judged> = judged
        .iter()
        .filter(|j| {
            let name = &j.case.name;
            name.starts_with("sdof")
                || name == "ishigami_gauss_s0.3"
                || name.starts_with("mie_gruneisen_mu0.5_e2e+10_cv0.15")
        })
        .collect();
    let indicator = |j: &Judged| {
        let Trust { curvature_ratio, third_ratio, .. } = j.assessed.trust;
        [curvature_ratio, third_ratio].into_iter().flatten().fold(0.0, f64::max)
    };
    let words = |j: &&Judged| {
        format!("{}: off by {:+.0} %, {:.2}", j.case.id(), 100.0 * j.error, indicator(j))
    };
    let method = failures.iter().map(words).collect::<Vec<_>>().join("; ");
    let subject = context.subject(
        "failures",
        "known failures with an indicator above 0.05",
        "cases",
        &method,
    );
    let warned = failures.iter().filter(|j| indicator(j) > Trust::LIMIT).count();
    counted(subject, warned, 5, "a known failure must be warned of")
}

/// Johnson-Cook, right within 6 % up to a coefficient of variation of 0.3, must not be warned of.
fn left_in_peace(context: &Context<'_>, judged: &[Judged]) -> Claim {
    let steel: Vec<&Judged> =
        judged.iter().filter(|j| j.case.name.starts_with("johnson_cook")).collect();
    let at_peace = steel.iter().filter(|j| j.assessed.trust.verdict() == Verdict::InPeace).count();
    let worst = steel.iter().fold(0.0_f64, |worst, j| worst.max(j.error.abs()));
    let method = format!("{} cases, worst error {:.1} %", steel.len(), 100.0 * worst);
    let subject = context.subject("johnson-cook/in-peace", "cases left in peace", "", &method);
    let reason = "its first-order variance is right within 6 % in all 20 cases";
    counted(subject, at_peace, 20, reason)
}
