//! The fields of the standard deviation over a plate, at ten of its particles, against sampled runs.

use perturbation_moments::MonteCarlo;
use reference_problems::quantile::quantile;
use reference_problems::smpm::problems::{Problem, experiment};
use scenes::smpm::scene::GaugeScene;
use smpm::uncertainty::{Study, Switch};

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "smpm/variance-fields",
    title: "Standard deviations at ten particles of a plate beside an explosion, from one run, against sampled runs",
    source: "own whole runs; Chen et al. 2019, section 5.2, whose figures are means",
    cost: Profile::Default,
    run: Together(run),
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

/// Quantity of a scene, its name in ids, its symbol, and how far the median, and the worst without a warning, may be off.
const QUANTITIES: [(&str, &str, &str, [f64; 2]); 3] = [
    ("flow_stress", "flow-stress", "sigma_y", [3e-3, 5e-3]),
    ("deviator_11", "deviator-11", "S_11", [4e-3, 0.05]),
    ("deviator_22", "deviator-22", "S_22", [5e-3, 0.02]),
];

/// The quantity and the particle at which the error is known to be large: near a switch, of which `Switch` warns.
const KNOWN: (&str, usize) = ("deviator-22", 0);

fn run(context: &Context<'_>) -> CaseResult {
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
    let study = Study::new(&experiment, scene.inputs()?, scene.plan()?)?;
    context.progress("derivatives");
    let propagated = study.propagated()?;
    let n_samples = if context.profile == Profile::Full { 1000 } else { 250 };
    context.progress("samples");
    let sampled = study.monte_carlo(MonteCarlo { seed: 2019, n_samples })?;
    let mut claims = Vec::new();
    for (q, (_, id, symbol, [of_median, of_worst])) in QUANTITIES.into_iter().enumerate() {
        let (mut worst, mut errors, mut n_warned) = (Worst::of_errors(), Vec::new(), 0);
        let method = format!("jets, against {n_samples} sampled runs with control variate");
        let lines = |method: String| context.lines(id, method);
        for gauge in 0..POINTS.len() {
            let response = study.plan().index(gauge, q, 0);
            let moments = &propagated.moments[response];
            let truth = sampled.controlled(response, moments)?.variance;
            let error = (moments.variance() / truth.value).sqrt() - 1.0;
            errors.push(error.abs());
            if propagated.switches[response].at_end > Switch::LIMIT {
                worst.take(error, &study.plan().gauges[gauge].name);
            } else {
                n_warned += 1;
            }
            if (id, gauge) == KNOWN {
                let quantity = format!("relative error of the deviation of {symbol} near a switch");
                let reason = "some samples yield or unload and others do not yet, which the series does not see; four standard errors of 250 samples about what 1,000 give";
                let subject = lines(method.clone()).of("near-a-switch", &quantity);
                claims.push(subject.measured(error, (-0.32, -0.12)).because(reason));
            }
        }
        let quantity = format!("median relative error of the deviation of {symbol}");
        let reason = "third derivatives, of the order of cv^2, and the samples' own error, a part in a thousand";
        let subject = lines(format!("{method}: ten particles")).of("median", quantity);
        claims.push(subject.bounded(quantile(&errors, 0.5), of_median).because(reason));
        let quantity =
            format!("largest relative error of the deviation of {symbol} without a warning");
        let method = format!("{}, {n_warned} of 10 warned of a switch", worst.method(&method));
        let reason =
            "as the median, and the samples' own error where rare samples come near a switch";
        let subject = lines(method).of("worst-without-warning", &quantity);
        claims.push(subject.bounded(worst.value(), of_worst).because(reason));
    }
    Ok(claims)
}
