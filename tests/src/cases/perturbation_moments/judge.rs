//! The Monte Carlo judge: raw and controlled, against quadrature; the other ways to differentiate.

use figures::{ErrorKind, Measured, Reference};
use perturbation_moments::{
    CentralDifferences, Expansion, ForwardDifferentiation, HighestOrder, JetCurvature,
    JetDifferentiation, Judgement, Moments, MonteCarlo, RandomVector, Response,
};
use sde_integrators::Estimate;

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::{Criterion, STANDARD_ERRORS};
use crate::perturbation_moments::reference::{ReferenceCase, ReferenceTable};
use crate::perturbation_moments::responses::{Visitor, visit};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "perturbation-moments/judge",
    title: "Monte Carlo with a Taylor control variate; jets and differences against dual numbers",
    source: "mean and variance by Gauss-Hermite quadrature",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const JUDGE: MonteCarlo = MonteCarlo { seed: 51, n_samples: 200_000 };

/// Cases with the factors by which the standard errors of mean and variance must fall at least.
const CASES: [(&str, f64, f64); 5] = [
    ("exp2_s0.3", 5.0, 1.5),
    ("ishigami_gauss_s0.1", 10.0, 3.0),
    ("johnson_cook_ep0.1_rate1000_T0.2_cv0.15_rho0.0", 10.0, 5.0),
    ("johnson_cook_ep0.5_rate10000_T0.4_cv0.1_rho0.4", 10.0, 5.0),
    ("mie_gruneisen_mu0.2_e4e+09_cv0.05_rho0.0", 10.0, 3.0),
];

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let table = ReferenceTable::read()?;
    let mut claims = Vec::new();
    for (name, mean_factor, variance_factor) in CASES {
        context.progress(name);
        let case = table.cases.iter().find(|case| case.name == name).ok_or("no such case")?;
        let judged = visit(case, &mut Sample)?;
        claims.extend(against_quadrature(context, case, &judged));
        claims.extend(reductions(context, case, &judged, mean_factor, variance_factor));
        let (jets, differences) = visit(case, &mut OtherWays)?;
        claims.push(way(context, case, "jets", jets, 1e-12, "roundoff of the polarised Hessian"));
        let reason =
            "error estimates of the differences: 1e-7 of the deviation in third derivatives";
        claims.push(way(context, case, "central-differences", differences, 1e-6, reason));
    }
    claims.push(threads(context, &table)?);
    Ok(claims)
}

struct Sample;

impl Visitor for Sample {
    type Output = Judgement;

    fn visit<const N: usize>(
        &mut self,
        inputs: &RandomVector<N>,
        response: &(impl Response<N> + Sync),
        _closed: Option<Expansion<N>>,
    ) -> Result<Judgement, CaseError> {
        let way = ForwardDifferentiation { response, order: HighestOrder::Second };
        let moments = Moments::by(inputs, &way)?;
        Ok(JUDGE.judge(inputs, &moments, |x| response.value(x))?)
    }
}

/// Errors of the variance with curvature by jets, and of the fourth-order one by differences, relative to dual numbers.
struct OtherWays;

impl Visitor for OtherWays {
    type Output = (f64, f64);

    fn visit<const N: usize>(
        &mut self,
        inputs: &RandomVector<N>,
        response: &(impl Response<N> + Sync),
        _closed: Option<Expansion<N>>,
    ) -> Result<(f64, f64), CaseError> {
        let dual = ForwardDifferentiation { response, order: HighestOrder::Third };
        let jets = JetDifferentiation { response, curvature: JetCurvature::Full };
        let differences =
            CentralDifferences::new(|x: &[f64; N]| response.value(x), HighestOrder::Third);
        let expected = Moments::by(inputs, &dual)?;
        let jets = Moments::by(inputs, &jets)?.variance_with_curvature()?;
        let differences = Moments::by(inputs, &differences)?.variance_fourth_order()?;
        Ok((
            jets / expected.variance_with_curvature()? - 1.0,
            differences / expected.variance_fourth_order()? - 1.0,
        ))
    }
}

fn against_quadrature(
    context: &Context<'_>,
    case: &ReferenceCase,
    judged: &Judgement,
) -> Vec<Claim> {
    let truth = &case.quadrature;
    let rows: [(&str, &str, &Estimate, f64); 4] = [
        ("mean/raw", "mean", &judged.raw_mean, truth.mean),
        ("mean/controlled", "mean", &judged.controlled_mean, truth.mean),
        ("variance/raw", "variance", &judged.raw_variance, truth.var),
        ("variance/controlled", "variance", &judged.controlled_variance, truth.var),
    ];
    rows.into_iter()
        .map(|(name, quantity, estimate, truth)| {
            let method = format!("Monte Carlo, {} samples", JUDGE.n_samples);
            let subject = context.subject(&format!("{}/{name}", case.id()), quantity, "", &method);
            let standard_error = estimate.standard_error().unwrap_or(f64::NAN);
            Claim::judge(
                subject,
                ErrorKind::Relative,
                Measured::sampled(estimate.value, standard_error),
                Reference::exact(truth),
                Criterion::MonteCarlo {
                    bias_bound: 0.0,
                    reason: "both estimates are unbiased, whatever the surrogate is worth",
                },
            )
        })
        .collect()
}

fn reductions(
    context: &Context<'_>,
    case: &ReferenceCase,
    judged: &Judgement,
    mean_factor: f64,
    variance_factor: f64,
) -> Vec<Claim> {
    let miss = judged.surrogate_mean_miss.max(judged.surrogate_variance_miss);
    let rows = [
        ("raw-against-controlled", "standard errors apart", miss, 0.0, STANDARD_ERRORS),
        ("mean/reduction", "raw over controlled s.e.", judged.mean_reduction(), mean_factor, 1e3),
        (
            "variance/reduction",
            "raw over controlled s.e.",
            judged.variance_reduction(),
            variance_factor,
            1e3,
        ),
    ];
    rows.into_iter()
        .map(|(name, quantity, value, from, to)| {
            let subject = context.subject(
                &format!("{}/{name}", case.id()),
                quantity,
                "",
                "control variate by the quadratic surrogate",
            );
            let reason = "raw and controlled may differ by 4 s.e.; a surrogate that is worth its name saves \
                          the square of the factor in samples";
            Claim::as_measured(subject, Measured::exact(value), from, to, reason)
        })
        .collect()
}

fn way(
    context: &Context<'_>,
    case: &ReferenceCase,
    name: &str,
    error: f64,
    tolerance: f64,
    reason: &str,
) -> Claim {
    let subject = context.subject(
        &format!("{}/{name}", case.id()),
        "relative error of the second-order or fourth-order variance",
        "",
        "against dual numbers",
    );
    Claim::within(subject, ErrorKind::Absolute, (error, 0.0), tolerance, reason)
}

/// The same bits on 1, 2 and 8 threads.
fn threads(context: &Context<'_>, table: &ReferenceTable) -> Result<Claim, CaseError> {
    let case = table.cases.iter().find(|case| case.name == "exp2_s0.3").ok_or("no such case")?;
    let on = |n_threads: usize| -> Result<Judgement, CaseError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build()?;
        pool.install(|| visit(case, &mut Sample))
    };
    let one = on(1)?;
    let bits = |judged: &Judgement| {
        [judged.raw_mean, judged.raw_variance, judged.controlled_mean, judged.controlled_variance]
            .map(|estimate| estimate.value.to_bits())
    };
    let mut different = 0;
    for n_threads in [2, 8] {
        let other = on(n_threads)?;
        different += bits(&one).iter().zip(bits(&other)).filter(|(a, b)| **a != *b).count();
    }
    let subject =
        context.subject("threads/same-bits", "values that differ", "", "1, 2 and 8 threads");
    Ok(Claim::same_bits(subject, different, 8, "samples are addressed and gathered by number"))
}
