//! The fields of the standard deviation over a plate, at ten of its particles, against sampled runs.

use figures::{ErrorKind, Measured, Reference};
use perturbation_moments::MonteCarlo;
use scenes::smpm::scene::GaugeScene;
use smpm::uncertainty::Study;
use work_precision::problems::smpm::problems::{Problem, experiment};
use work_precision::quantile::quantile;

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::cases::worst::Worst;
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "smpm/variance-fields",
    title: "Standard deviations at ten particles of a plate beside an explosion, from one run, against sampled runs",
    source: "own whole runs; Chen et al. 2019, section 5.2, whose figures are means",
    cost: Profile::Default,
    schedule: Schedule::Together,
    run,
};

/// When the pictures of docs/methods/smpm.md are taken (us).
const TIME: f64 = 10.0;
const COEFFICIENT_OF_VARIATION: f64 = 0.05;

/// Where ten particles start, by four depths and eight heights (cm): what a field shows is one particle's.
const POINTS: [[f64; 2]; 10] = [
    [4.125, 0.125],
    [4.875, 0.125],
    [5.875, 0.625],
    [4.125, 1.125],
    [5.125, 2.125],
    [5.875, 2.625],
    [4.375, 3.125],
    [5.125, 3.625],
    [5.625, 4.125],
    [4.875, 5.125],
];

/// Quantity of a scene, its name in ids, its symbol, and how far median and worst may be off.
const QUANTITIES: [(&str, &str, &str, [f64; 2]); 3] = [
    ("flow_stress", "flow-stress", "sigma_y", [3e-3, 0.02]),
    ("deviator_11", "deviator-11", "S_11", [4e-3, 0.1]),
    ("deviator_22", "deviator-22", "S_22", [5e-3, 0.15]),
];

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut scene = Problem::ContactExplosion.scene_with(COEFFICIENT_OF_VARIATION, &[TIME])?;
    let gauge = |at: &[f64; 2]| GaugeScene {
        name: format!("{} {} cm", at[0], at[1]),
        body: "plate".to_owned(),
        at: Some(at.to_vec()),
        within: None,
    };
    scene.gauges = POINTS.iter().map(gauge).collect();
    scene.quantities = QUANTITIES.map(|(quantity, ..)| quantity.to_owned()).to_vec();
    let experiment = experiment::<2>(&scene)?;
    let study = Study::<_, 2, 5>::new(&experiment, scene.inputs()?, scene.plan()?)?;
    context.progress("derivatives");
    let propagated = study.propagated()?;
    let n_samples = if context.profile == Profile::Full { 1000 } else { 250 };
    context.progress("samples");
    let sampled = study.monte_carlo(MonteCarlo { seed: 2019, n_samples });
    let mut claims = Vec::new();
    for (q, (_, id, symbol, [of_median, of_worst])) in QUANTITIES.into_iter().enumerate() {
        let (mut worst, mut errors, mut noise) = (Worst::of_errors(), Vec::new(), f64::NAN);
        for gauge in 0..POINTS.len() {
            let response = study.plan().index(gauge, q, 0);
            let moments = &propagated.moments[response];
            let truth = sampled.controlled(response, moments)?.variance;
            let error = (moments.variance_first_order() / truth.value).sqrt() - 1.0;
            worst.take(error, &study.plan().gauges[gauge].name);
            if worst.value().to_bits() == error.to_bits() {
                noise = 0.5 * truth.standard_error().unwrap_or(f64::NAN) / truth.value;
            }
            let trust = moments.trust();
            eprintln!(
                "DBG {id} {} {error:.4} {:?} {:?}",
                study.plan().gauges[gauge].name,
                trust,
                propagated.switches[response]
            );
            errors.push(error.abs());
        }
        let method = format!("jets, against {n_samples} sampled runs with control variate");
        let lines = |method: String| Lines { context, id, method };
        claims.push(lines(format!("{method}: ten particles")).bounded(
            ("median", &format!("median relative error of the deviation of {symbol}"), ""),
            quantile(&errors, 0.5),
            of_median,
            "third derivatives, of the order of cv^2, and the samples' own error, a part in a thousand",
        ));
        let subject = context.subject(
            &format!("{id}/worst"),
            &format!("largest relative error of the deviation of {symbol}"),
            "",
            &worst.method(&method),
        );
        claims.push(Claim::judge(
            subject,
            ErrorKind::Absolute,
            Measured { value: worst.value(), standard_error: Some(noise) },
            Reference::exact(0.0),
            Criterion::MonteCarlo {
                bias_bound: of_worst,
                reason: "one particle at one instant, where some samples yield or unload and others do not yet: the series does not see the switch",
            },
        ));
    }
    Ok(claims)
}
