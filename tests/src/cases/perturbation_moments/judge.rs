//! The Monte Carlo judge: raw and controlled, against quadrature; the other ways to differentiate.

use perturbation_moments::{
    CentralDifferences, Expansion, ForwardDifferentiation, HighestOrder, Judgement, Moments,
    MonteCarlo, RandomVector, Response,
};
use result_figures::{ErrorKind, Measured, Reference};
use sde_integrators::Estimate;

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::{Criterion, STANDARD_ERRORS};
use crate::perturbation_moments::reference::{ReferenceCase, ReferenceTable};
use crate::perturbation_moments::responses::{Visitor, visit};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "perturbation-moments/judge",
    title: "Monte Carlo with a Taylor control variate; differences against dual numbers",
    source: "mean and variance by Gauss-Hermite quadrature",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const JUDGE: MonteCarlo = MonteCarlo { seed: 51, n_samples: 200_000 };

/// Cases with the factors by which the standard errors of mean and variance fell.
const CASES: [(&str, [f64; 2]); 5] = [
    ("exp2_s0.3", [10.15, 3.22]),
    ("ishigami_gauss_s0.1", [42.7, 11.8]),
    ("johnson_cook_ep0.1_rate1000_T0.2_cv0.15_rho0.0", [45.4, 27.6]),
    ("johnson_cook_ep0.5_rate10000_T0.4_cv0.1_rho0.4", [345.0, 111.5]),
    ("mie_gruneisen_mu0.2_e4e+09_cv0.05_rho0.0", [461.0, 130.6]),
];

/// A factor moves by so much with another seed: heavy tails of what the surrogate leaves.
const FACTOR_SPREAD: f64 = 1.25;

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let table = ReferenceTable::read()?;
    let mut claims = Vec::new();
    let mut differences = 0.0_f64;
    for (name, factors) in CASES {
        context.progress(name);
        let case = table.cases.iter().find(|case| case.name == name).ok_or("no such case")?;
        let judged = visit(case, &mut Sample)?;
        claims.extend(against_quadrature(context, case, &judged));
        claims.push(surrogate(context, case, &judged));
        claims.extend(reductions(context, case, &judged, factors));
        differences = largest(differences, visit(case, &mut ByDifferences)?);
    }
    let reason = "differences extrapolated to a few 1e-13 of a deviation in third derivatives";
    claims.push(way(context, "central-differences", differences, 5e-12, reason));
    claims.push(threads(context, &table)?);
    Ok(claims)
}

/// The larger size; NaN stays.
fn largest(worst: f64, error: f64) -> f64 {
    if worst.is_nan() || error.is_nan() { f64::NAN } else { worst.max(error.abs()) }
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

/// Error of the fourth-order variance by differences, relative to dual numbers.
struct ByDifferences;

impl Visitor for ByDifferences {
    type Output = f64;

    fn visit<const N: usize>(
        &mut self,
        inputs: &RandomVector<N>,
        response: &(impl Response<N> + Sync),
        _closed: Option<Expansion<N>>,
    ) -> Result<f64, CaseError> {
        let dual = ForwardDifferentiation { response, order: HighestOrder::Third };
        let differences =
            CentralDifferences::new(|x: &[f64; N]| response.value(x), HighestOrder::Third);
        let expected = Moments::by(inputs, &dual)?;
        let differences = Moments::by(inputs, &differences)?.variance_fourth_order()?;
        Ok(differences / expected.variance_fourth_order()? - 1.0)
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

/// The sample means of the surrogate and of its square against the values that are known exactly.
fn surrogate(context: &Context<'_>, case: &ReferenceCase, judged: &Judgement) -> Claim {
    let miss = judged.surrogate_mean_miss.max(judged.surrogate_variance_miss);
    let subject = context.subject(
        &format!("{}/surrogate", case.id()),
        "standard errors between sample and exact moments of the surrogate, the larger of two",
        "s.e.",
        "control variate by the quadratic surrogate",
    );
    let reason = "statistics: four standard errors";
    Claim::within(subject, ErrorKind::Absolute, (miss, 0.0), STANDARD_ERRORS, reason)
}

/// How much sharper the controlled estimates are: the square of the factor is saved in samples.
fn reductions(
    context: &Context<'_>,
    case: &ReferenceCase,
    judged: &Judgement,
    [mean_factor, variance_factor]: [f64; 2],
) -> [Claim; 2] {
    [
        ("mean/reduction", judged.mean_reduction(), mean_factor),
        ("variance/reduction", judged.variance_reduction(), variance_factor),
    ]
    .map(|(name, value, seen)| {
        let subject = context.subject(
            &format!("{}/{name}", case.id()),
            "raw over controlled s.e.",
            "",
            "control variate by the quadratic surrogate",
        );
        let (from, to) = (seen / FACTOR_SPREAD, seen * FACTOR_SPREAD);
        let reason = "what the surrogate leaves of the deviation, by this sample";
        Claim::as_measured(subject, Measured::exact(value), from, to, reason)
    })
}

fn way(context: &Context<'_>, name: &str, error: f64, tolerance: f64, reason: &str) -> Claim {
    let subject = context.subject(
        name,
        "relative error of the second-order or fourth-order variance",
        "",
        "against dual numbers, worst of five cases",
    );
    Claim::within(subject, ErrorKind::Absolute, (error, 0.0), tolerance, reason)
}

/// Bitwise identical on 1, 2 and 8 threads.
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
