//! 51 cases against automatic differentiation, OpenTURNS and quadrature.

use figures::{ErrorKind, Measured, Reference};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::perturbation_moments::reference::{ReferenceCase, ReferenceTable};
use crate::perturbation_moments::responses::{Assessed, assess};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "perturbation-moments/reference",
    title: "Derivatives, moments and their distance to the true ones, 51 cases",
    source: "derivatives by JAX, moments by OpenTURNS 1.27 and by Gauss-Hermite quadrature",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    for case in &ReferenceTable::read()?.cases {
        context.progress(&case.name);
        let assessed = assess(case)?;
        claims.extend(errors(context, case, &assessed));
        claims.extend(distances(context, case, &assessed));
    }
    claims.extend(closed_means(context)?);
    Ok(claims)
}

/// Against numbers that must agree.
fn errors(context: &Context<'_>, case: &ReferenceCase, assessed: &Assessed) -> Vec<Claim> {
    let rows = [
        (
            "derivatives",
            "worst error of value, gradient, Hessian, third derivatives",
            "dual numbers, and closed form where there is one",
            assessed.derivative_error,
            1e-12,
            "two automatic differentiations in double precision, over the largest of the same order in deviations",
        ),
        (
            "openturns",
            "worst error of means, first-order variance, importance, gradient, Hessian",
            "moments from dual numbers",
            assessed.openturns_error,
            1e-5,
            "OpenTURNS prints literals with six digits into its derivatives",
        ),
        (
            "moments",
            "worst error of var2, fourth-order variance, third moment, fourth cumulant",
            "moments from dual numbers",
            assessed.moment_error,
            1e-12,
            "the same closed formulas by another program: roundoff, over powers of the variance",
        ),
    ];
    rows.into_iter()
        .map(|(name, quantity, method, error, tolerance, reason)| {
            let subject = context.subject(&format!("{}/{name}", case.id()), quantity, "", method);
            Claim::within(subject, ErrorKind::Absolute, (error, 0.0), tolerance, reason)
        })
        .collect()
}

/// Against the true variance: how far a Taylor variance is off, which is no error of the code.
fn distances(context: &Context<'_>, case: &ReferenceCase, assessed: &Assessed) -> Vec<Claim> {
    let truth = case.quadrature.var;
    let reference = Reference::uncertain(truth, truth * case.quadrature.rel_change[1]);
    let rows = [
        (
            "variance-first-order",
            assessed.variance_first_order,
            case.openturns.var1,
            1e-5,
            "the distance of OpenTURNS' first-order variance to the same quadrature, to its six digits",
        ),
        (
            "variance-fourth-order",
            assessed.variance_fourth_order,
            case.second_order.var_o4_with_third_derivs,
            1e-9,
            "the distance of the fourth-order formula on JAX derivatives to the same quadrature",
        ),
    ];
    rows.into_iter()
        .map(|(name, ours, theirs, width, reason)| {
            let expected = theirs / truth - 1.0;
            let subject = context.subject(
                &format!("{}/{name}", case.id()),
                "variance",
                "",
                "Taylor, against the true variance by quadrature",
            );
            let (from, to) = (expected - width, expected + width);
            Claim::judge(
                subject,
                ErrorKind::Relative,
                Measured::exact(ours),
                reference,
                Criterion::AsMeasured { from, to, reason },
            )
        })
        .collect()
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
        "Taylor, C.V. 0.15 and 0.3, independent",
    );
    let reason = "1e-5 to 2e-2 deviations were seen by another program";
    let mean = Claim::as_measured(subject, Measured::exact(worst), 1e-5, 2.5e-2, reason);
    let subject = context.subject(
        "johnson-cook/quadrature/worst",
        "distance of the quadrature to the closed form of the variance",
        "",
        "tensor Gauss-Hermite",
    );
    let reason = "two derivations of the reference agree to what is claimed of it";
    let quadrature = Claim::within(subject, ErrorKind::Absolute, (agreement, 0.0), 1e-11, reason);
    Ok(vec![mean, quadrature])
}
