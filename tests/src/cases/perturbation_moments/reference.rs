//! 51 cases against automatic differentiation, OpenTURNS and quadrature.

use result_figures::ErrorKind;

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::worst::Worst;
use crate::perturbation_moments::reference::{ReferenceCase, ReferenceTable};
use crate::perturbation_moments::responses::assess;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "perturbation-moments/reference",
    title: "Derivatives, moments and their distance to the true ones, 51 cases",
    source: "derivatives by JAX, moments by OpenTURNS 1.27 and by Gauss-Hermite quadrature",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// A family of cases by the beginning of their names, and what is claimed of its worst.
struct Family {
    name: &'static str,
    /// Whether OpenTURNS writes its derivatives in literals of six digits.
    has_literals: bool,
    /// How far Taylor variances of first and of fourth order may be from the true variance.
    truncation: [f64; 2],
}

/// Where the truncation vanishes, the variance of this crate has to be the true one.
const ROUNDOFF: f64 = 1e-13;

const FAMILIES: [Family; 8] = [
    Family { name: "linear3", has_literals: false, truncation: [ROUNDOFF, ROUNDOFF] },
    Family { name: "product2", has_literals: false, truncation: [0.07, ROUNDOFF] },
    Family { name: "exp2", has_literals: false, truncation: [0.25, 0.03] },
    Family { name: "cantilever", has_literals: true, truncation: [0.05, 2.5e-3] },
    Family { name: "ishigami", has_literals: false, truncation: [0.35, 0.09] },
    Family { name: "sdof", has_literals: false, truncation: [0.7, 1.6] },
    Family { name: "johnson_cook", has_literals: true, truncation: [0.06, 0.04] },
    Family { name: "mie_gruneisen", has_literals: true, truncation: [0.045, 1.7e-3] },
];

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    let table = ReferenceTable::read()?;
    let n_named = FAMILIES.iter().map(|family| of(&table, family).count()).sum::<usize>();
    if n_named != table.cases.len() {
        return Err("a case of the table belongs to no family, or to two".into());
    }
    for family in &FAMILIES {
        context.progress(family.name);
        claims.extend(errors(context, &table, family)?);
    }
    claims.extend(closed_means(context)?);
    Ok(claims)
}

fn of<'a>(
    table: &'a ReferenceTable,
    family: &'a Family,
) -> impl Iterator<Item = &'a ReferenceCase> {
    table.cases.iter().filter(|case| case.name.starts_with(family.name))
}

/// The worst errors of a family: of derivatives and moments against other programs, of Taylor variances against the true one.
fn errors(
    context: &Context<'_>,
    table: &ReferenceTable,
    family: &Family,
) -> Result<Vec<Claim>, CaseError> {
    let mut worst: [Worst; 5] = Default::default();
    for case in of(table, family) {
        let assessed = assess(case)?;
        worst[0].take(assessed.derivative_error, &case.name);
        worst[1].take(assessed.openturns_error, &case.name);
        worst[2].take(assessed.moment_error, &case.name);
        if case.has_a_variance() {
            let truth = case.quadrature.var;
            worst[3].take(assessed.variance_first_order / truth - 1.0, &case.name);
            worst[4].take(assessed.variance_fourth_order / truth - 1.0, &case.name);
        }
    }
    let rows = statements(family);
    Ok(rows
        .into_iter()
        .zip(worst)
        .map(|((name, quantity, method, tolerance, reason), worst)| {
            let id = format!("{}/{name}", family.name.replace('_', "-"));
            let (method, error) = (worst.method(method), worst.value());
            let subject = context.subject(&id, quantity, "", &method);
            Claim::within(subject, ErrorKind::Absolute, (error, 0.0), tolerance, reason)
        })
        .collect())
}

type Statement = (&'static str, &'static str, &'static str, f64, &'static str);

/// Name, quantity, method, tolerance and reason of the claims of a family.
fn statements(family: &Family) -> [Statement; 5] {
    const SAME: &str = "roundoff: some hundred operations in both programs";
    const SERIES: &str = "truncation of the Taylor series, no error of the code";
    let openturns = if family.has_literals {
        (1e-5, "OpenTURNS prints literals with six digits into its derivatives")
    } else {
        (ROUNDOFF, SAME)
    };
    let series = |tolerance: f64| if tolerance > ROUNDOFF { SERIES } else { SAME };
    let [first, fourth] = family.truncation;
    [
        (
            "derivatives",
            "worst error of value, gradient, Hessian, third derivatives",
            "dual numbers, jets (first and own second derivatives), and closed form where there is one",
            ROUNDOFF,
            SAME,
        ),
        (
            "openturns",
            "worst error of means, first-order variance, importance, gradient, Hessian",
            "moments from dual numbers",
            openturns.0,
            openturns.1,
        ),
        (
            "moments",
            "worst error of var2, fourth-order variance, third moment, fourth cumulant",
            "moments from dual numbers, over powers of the variance",
            ROUNDOFF,
            SAME,
        ),
        (
            "variance-first-order",
            "relative error of the first-order variance against the true one",
            "Taylor, against quadrature",
            first,
            series(first),
        ),
        (
            "variance-fourth-order",
            "relative error of the fourth-order variance against the true one",
            "Taylor, against quadrature",
            fourth,
            series(fourth),
        ),
    ]
}

/// The second-order mean where a closed form of the true mean exists: how far the series is from it.
fn closed_means(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut worst = 0.0_f64;
    let mut agreement = 0.0_f64;
    for case in &ReferenceTable::read()?.cases {
        let Some(exact) = case.exact else { continue };
        let assessed = assess(case)?;
        let in_deviations = (assessed.mean_second_order - exact.mean).abs() / exact.var.sqrt();
        worst = worst.max(in_deviations);
        agreement = agreement.max((case.quadrature.var / exact.var - 1.0).abs());
    }
    let subject = context.subject(
        "johnson-cook/mean-second-order/worst",
        "distance of the second-order mean to the closed form",
        "deviations",
        "Taylor, coefficients of variation 0.15 and 0.3, independent",
    );
    let reason =
        "truncation of the series: terms of fourth order in a coefficient of variation of 0.3";
    let mean = Claim::within(subject, ErrorKind::Absolute, (worst, 0.0), 2.5e-2, reason);
    let subject = context.subject(
        "johnson-cook/quadrature/worst",
        "distance of the quadrature to the closed form of the variance",
        "",
        "tensor Gauss-Hermite",
    );
    let reason =
        "two derivations of the reference: tensor Gauss-Hermite quadrature is converged to 1e-12";
    let quadrature = Claim::within(subject, ErrorKind::Absolute, (agreement, 0.0), 3e-12, reason);
    Ok(vec![mean, quadrature])
}
