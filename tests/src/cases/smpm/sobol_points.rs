//! Explosion with random steel at Sobol' points: variance by few runs, and which constant causes it.

use reference_problems::smpm::problems::{Problem, experiment};
use scenes::smpm::experiment::SceneExperiment;
use smpm::Plan;
use smpm::uncertainty::{Design, Study};
use uq_estimators::{Estimate, PolynomialMoments, Sampling, SobolIndices, UnitCube};

use crate::cases::prelude::*;
use crate::cases::smpm::contact_explosion;

pub(crate) const CASE: Case = Case {
    id: "smpm/contact-explosion/sobol-points",
    title: "Variance and Sobol' indices behind an explosion by 128 runs at Sobol' points, four designs",
    source: "own runs: 1,024 at other points, 250 independent ones, 896 of the design of Saltelli et al. 2010",
    cost: Profile::Default,
    run: Together(run),
};

const STRENGTH: f64 = 0.15;
/// Microseconds; after first yield of all gauges.
const TIMES: [f64; 4] = [9.0, 10.0, 11.0, 12.0];
const REPLICAS: u64 = 8;
/// Of the designs of 128 runs, whose worst counts; none of them was looked at when the estimator was made.
const SEEDS: [u64; 4] = [11, 12, 13, 14];

fn cube(n_points: u64, seed: u64) -> UnitCube {
    let sampling = Sampling::ScrambledSobol;
    UnitCube { dimension: 5, sampling, seed, n_points, n_replicas: REPLICAS }
}

/// Polynomials of each response at Sobol' points.
fn fitted(
    study: &Study<'_, SceneExperiment<2>, 2>,
    cube: UnitCube,
) -> CaseResult<Vec<PolynomialMoments>> {
    let sampled = study.sampled(Design::QuasiRandom(cube))?;
    let polynomial = sampled.polynomial_control()?;
    let of = |response| Ok(polynomial.moments(&sampled.values(response)?)?);
    (0..study.plan().n_responses()).map(of).collect()
}

fn error(estimate: &Estimate) -> f64 {
    estimate.standard_error().unwrap_or(f64::NAN)
}

fn run(context: &Context<'_>) -> CaseResult {
    let mut scene = Problem::ContactExplosion.scene_with(STRENGTH, &TIMES)?;
    scene.quantities = vec!["flow_stress".to_owned(), "deviator_11".to_owned()];
    let experiment = experiment::<2>(&scene)?;
    let study = Study::new(&experiment, scene.inputs()?, scene.plan::<2>()?)?;
    context.progress("four times 128 runs");
    let few = SEEDS.map(|seed| fitted(&study, cube(16, seed)));
    let few = few.into_iter().collect::<Result<Vec<_>, _>>()?;
    context.progress("1,024 runs");
    let many = fitted(&study, cube(128, 77))?;
    let plan = study.plan();
    let mut claims = variances(context, plan, &few, &many);
    claims.push(against_samples(context, plan, &many)?);
    if context.profile < Profile::Full {
        context.skip("Sobol' indices by the design of Saltelli, 896 runs: with --full");
        return Ok(claims);
    }
    context.progress("896 runs for Sobol' indices");
    let design = study.sampled(Design::SobolIndices(cube(16, 3)))?;
    let of_flow = |response: &usize| plan.parts(*response).1 == 0;
    let flow: Vec<usize> = (0..plan.n_responses()).filter(of_flow).collect();
    let indices: Vec<SobolIndices> =
        flow.iter().map(|&i| design.sobol_indices(i)).collect::<Result<_, _>>()?;
    let polynomials: Vec<&PolynomialMoments> = flow.iter().map(|&i| &many[i]).collect();
    claims.extend(of_indices(context, &polynomials, &indices));
    Ok(claims)
}

fn place(plan: &Plan<2>, response: usize) -> String {
    let (gauge, _, window) = plan.parts(response);
    format!("{} t{}", plan.gauges[gauge].name, plan.windows[window].to)
}

fn variances(
    context: &Context<'_>,
    plan: &Plan<2>,
    few: &[Vec<PolynomialMoments>],
    many: &[PolynomialMoments],
) -> Vec<Claim> {
    let (mut off, mut stated) = (Worst::of_errors(), Worst::of_errors());
    let (mut left, mut left_at_h) = (Worst::of_errors(), Worst::of_errors());
    for (response, many) in many.iter().enumerate() {
        let (gauge, quantity, _) = plan.parts(response);
        let place = place(plan, response);
        if quantity == 0 {
            let truth = many.moments.variance.value;
            for few in few.iter().map(|few| &few[response]) {
                off.take(few.moments.variance.value / truth - 1.0, &place);
                stated.take(error(&few.moments.variance) / truth, &place);
                left.take(few.unexplained, &place);
            }
        } else if plan.gauges[gauge].name == "H" {
            left_at_h.take(many.unexplained, &place);
        }
    }
    let line = |worst: &Worst, method: &str| context.lines("", worst.method(method));
    let polynomial = "8 replicas of 16 Sobol' points with a polynomial, worst of four designs";
    vec![
        line(&off, polynomial)
            .of("flow-stress/variance", "relative error of Var sigma_y")
            .bounded(off.value(), 5e-3)
            .because("0.5 % is asked; statistics of 128 runs"),
        line(&stated, polynomial)
            .of("flow-stress/stated-error", "standard error over Var sigma_y")
            .measured(stated.value(), (2e-3, 8e-3))
            .because("0.5 % is asked: the deviation is, the error stated of one design is more"),
        line(&left, polynomial)
            .of("flow-stress/unexplained", "part of the variance that the polynomial leaves")
            .bounded(left.value(), 4e-4)
            .because("a smooth response at 15 %: what degree four and higher have of it, of the worst design"),
        line(&left_at_h, "8 replicas of 128 points")
            .of("deviator-11/unexplained", "part of Var S11 at H that the polynomial leaves")
            .measured(left_at_h.value(), (0.02, 0.3))
            .because("reverse yield begins within the scatter: a kink, which no polynomial follows"),
    ]
}

/// Independent samples with a Taylor series as control variate.
fn against_samples(
    context: &Context<'_>,
    plan: &Plan<2>,
    many: &[PolynomialMoments],
) -> CaseResult<Claim> {
    let solved = contact_explosion::solved(context, Problem::ContactExplosion, STRENGTH)?;
    let mut worst = Worst::of_errors();
    for (response, found) in many.iter().enumerate() {
        let (gauge, quantity, window) = plan.parts(response);
        let is_same = |&other: &usize| {
            let (g, q, w) = solved.plan.parts(other);
            g == gauge
                && solved.plan.quantities[q] == plan.quantities[quantity]
                && solved.plan.windows[w] == plan.windows[window]
        };
        let other = (0..solved.plan.n_responses()).find(is_same);
        let Some(other) = other.filter(|_| quantity == 0) else { continue };
        let sampled = solved.sampled.controlled(other, &solved.propagated.moments[other])?;
        let scale = error(&found.moments.variance).hypot(error(&sampled.variance));
        let distance = found.moments.variance.value - sampled.variance.value;
        worst.take(distance / scale, &place(plan, response));
    }
    let method = worst.method("1,024 runs at Sobol' points against independent samples");
    Ok(context
        .lines("", method)
        .of("flow-stress/independent-samples", "distance of Var sigma_y in standard errors")
        .bounded(worst.value(), 4.0)
        .because("statistics: four standard errors; the responses are close to one random number"))
}

fn of_indices(
    context: &Context<'_>,
    polynomials: &[&PolynomialMoments],
    indices: &[SobolIndices],
) -> Vec<Claim> {
    let (mut apart, mut sums) = (Worst::of_errors(), Worst::of_errors());
    for (polynomial, design) in polynomials.iter().zip(indices) {
        let pairs = [(&polynomial.first, &design.first), (&polynomial.total, &design.total)];
        for (of_fit, of_design) in pairs {
            for (k, (a, b)) in of_fit.iter().zip(of_design).enumerate() {
                apart.take((a.value - b.value) / error(a).hypot(error(b)), &format!("input {k}"));
            }
        }
        // The first must be at most one, the second at least one.
        for (sum, side) in [(&design.first_sum, 1.0), (&design.total_sum, -1.0)] {
            sums.take((side * (sum.value - 1.0) / error(sum)).max(0.0), "a sum");
        }
    }
    let line = |worst: &Worst, method: &str| context.lines("", worst.method(method));
    vec![
        line(&apart, "polynomial against the design of Saltelli")
            .of("flow-stress/indices", "distance of Sobol' indices in standard errors")
            .bounded(apart.value(), 4.0)
            .because("statistics: four standard errors, of ten indices of one random number"),
        line(&sums, "design of Saltelli")
            .of(
                "flow-stress/index-sums",
                "excess of the sums over what they may be, in standard errors",
            )
            .bounded(sums.value(), 3.0)
            .because(
                "statistics: first-order indices sum to at most one, total ones to at least one",
            ),
    ]
}
