//! The second example of Chen et al. 2019 with as many particles as there, beside its tables.

use std::collections::BTreeMap;

use figures::{ErrorKind, Reference};
use scenes::clock::CpuClock;
use scenes::smpm::experiment::SceneExperiment;
use scenes::smpm::scene::{SmpmScene, SolidScene};
use serde::Deserialize;
use smpm::Quantity;
use smpm::uncertainty::{Propagated, Study};
use work_precision::problems::smpm::problems::{Problem, experiment};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "smpm/paper-size",
    title: "Contact explosion with 160,000 particles beside Tables 6 to 8 of the paper, and its cost",
    source: "Chen et al. 2019, Tables 6-9, as printed; what its code must have done: docs/errata.md",
    cost: Profile::Full,
    schedule: Schedule::Alone,
    run,
};

/// Two metres of water, cells of 5 mm, four particles a cell: 160,000 of them in the half above the plane of symmetry, which is
/// half a metre high. The paper's half metre beyond holds nothing that moves in the time.
const HALF_LENGTH: f64 = 100.0;
const HEIGHT: f64 = 50.0;
const COEFFICIENT_OF_VARIATION: f64 = 0.1;
const N_SAMPLES: f64 = 1e4;

#[derive(Debug, Deserialize)]
struct Published {
    tables: BTreeMap<String, Vec<PublishedRow>>,
}

/// Mean in 1e-2 Mbar, variance in 1e-6 Mbar^2.
#[derive(Debug, Deserialize)]
struct PublishedRow {
    gauge: String,
    coefficient_of_variation: f64,
    mean: f64,
    variance: f64,
}

impl Published {
    /// Mean (Mbar) and variance (Mbar^2).
    fn moments(&self, quantity: Quantity, gauge: &str) -> Result<[f64; 2], CaseError> {
        let rows = self.tables.get(&quantity.to_string()).ok_or("no such table")?;
        let wanted = |row: &&PublishedRow| {
            row.gauge == gauge
                && (row.coefficient_of_variation - COEFFICIENT_OF_VARIATION).abs() < 1e-9
        };
        let row = rows.iter().find(wanted).ok_or("no such row")?;
        Ok([1e-2 * row.mean, 1e-6 * row.variance])
    }
}

/// The scene over two metres, with the strength that reproduces Table 6, looked at four times a microsecond.
fn scene() -> Result<SmpmScene, CaseError> {
    let times: Vec<f64> = (0..=16).map(|k| 7.0 + 0.25 * f64::from(k)).collect();
    let mut scene = Problem::ContactExplosion.scene_with(COEFFICIENT_OF_VARIATION, &times)?;
    scene.quantities = ["flow_stress", "deviator_11", "deviator_22"].map(str::to_owned).to_vec();
    for body in &mut scene.bodies {
        if let SolidScene::Box { from, to } = &mut body.shape {
            match body.name.as_str() {
                "water" => (*from, *to) = (vec![-HALF_LENGTH, 0.0], vec![HALF_LENGTH, HEIGHT]),
                "plate" => to[1] = HEIGHT,
                _ => {}
            }
        }
        for except in &mut body.except {
            if let SolidScene::Box { from, to } = except
                && from[0] > 0.0
            {
                to[1] = HEIGHT;
            }
        }
    }
    let steel = scene.materials.get_mut("steel").and_then(|steel| steel.strength.as_mut());
    steel.ok_or("the plate has no strength")?.take_from("steel_as_published");
    Ok(scene)
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let text = include_str!("../../../reference/published/smpm/chen_2019_tables.json");
    let published: Published = serde_json::from_str(text)?;
    let scene = scene()?;
    let experiment = experiment::<2>(&scene)?;
    let n_particles = experiment.n_particles();
    context.progress("reference run");
    let study = Study::<_, 2, 5>::new(&experiment, scene.inputs()?, scene.plan()?)?;
    let start = CpuClock::start();
    let _ = study.run(&[0.0; 5])?;
    let of_one = start.seconds();
    context.progress("run with derivatives");
    let start = CpuClock::start();
    let propagated = study.propagated()?;
    let of_jets = start.seconds();

    let method = format!(
        "jets, {n_particles} particles, cells of 5 mm, {} steps, Johnson-Cook as published",
        study.schedule().n_steps()
    );
    let mut claims = Vec::new();
    for gauge in 0..study.plan().gauges.len() {
        claims.extend(beside_tables(context, &method, &study, &propagated, &published, gauge)?);
    }
    let lines = Lines { context, id: "", method };
    claims.push(lines.measured(
        ("particles", "particles", ""),
        n_particles as f64,
        (160_000.0, 160_000.0),
        "as many as in the paper",
    ));
    claims.push(lines.measured(
        ("within-yield", "largest abs(S_11) over sigma_y", ""),
        largest_deviator(&study, &propagated),
        (0.6, 2.0 / 3.0 + 1e-6),
        "in plane strain von Mises allows 2/3 and no more; the paper prints up to 0.705",
    ));
    claims.push(lines.measured(
        ("cost/jets", "processor time of the run with derivatives over that of one run", ""),
        of_jets / of_one,
        (5.0, 40.0),
        "17 numbers for one, of the same run; the paper's 1.06 is what derivatives at a frozen state cost",
    ));
    claims.push(lines.measured(
        (
            "cost/samples",
            "processor time of 10,000 runs over that of the reference run and the jets",
            "",
        ),
        N_SAMPLES * of_one / (of_one + of_jets),
        (200.0, 2000.0),
        "by the time of one run, of the same case; the paper's ratio is 9,404",
    ));
    Ok(claims)
}

type PaperStudy<'a> = Study<'a, SceneExperiment<2>, 2, 5>;

/// The quantities of the plan, by their place in it.
const QUANTITIES: [(&str, &str, Quantity); 3] = [
    ("flow-stress", "sigma_y", Quantity::FlowStress),
    ("deviator-11", "S_11", Quantity::Deviator(0, 0)),
    ("deviator-22", "S_22", Quantity::Deviator(1, 1)),
];

/// Mean and variance at a gauge when the mean of its flow stress comes nearest to that of Table 6.
fn beside_tables(
    context: &Context<'_>,
    method: &str,
    study: &PaperStudy<'_>,
    propagated: &Propagated<5>,
    published: &Published,
    gauge: usize,
) -> Result<Vec<Claim>, CaseError> {
    let plan = study.plan();
    let name = plan.gauges[gauge].name.as_str();
    let moments = |quantity: usize, window: usize| -> Result<[f64; 2], CaseError> {
        let moments = &propagated.moments[plan.index(gauge, quantity, window)];
        Ok([moments.mean_second_order()?, moments.variance_first_order()])
    };
    let table_6 = published.moments(Quantity::FlowStress, name)?[0];
    let mut nearest = (f64::INFINITY, 0);
    for window in 0..plan.windows.len() {
        let apart = (moments(0, window)?[0] - table_6).abs();
        if apart < nearest.0 {
            nearest = (apart, window);
        }
    }
    let window = nearest.1;
    let method = format!("{method}, at {} us", plan.windows[window].to);
    let id = name.to_lowercase();
    let lines = Lines { context, id: &id, method };
    let mut claims = vec![lines.measured(
        ("time", "when the mean of sigma_y is nearest to that of Table 6", "us"),
        plan.windows[window].to,
        nearest_time(name),
        "the paper does not say when; no single time fits all four points",
    )];
    for (k, (id, symbol, quantity)) in QUANTITIES.into_iter().enumerate() {
        let (ours, theirs) = (moments(k, window)?, published.moments(quantity, name)?);
        for (m, moment) in ["mean", "variance"].into_iter().enumerate() {
            let ((from, to), reason) = seen(quantity, m, name);
            claims.push(lines.judge(
                (&format!("{id}/{moment}"), &format!("{moment} of {symbol}"), "Mbar or its square"),
                ErrorKind::Relative,
                ours[m],
                Reference::exact(theirs[m]),
                Criterion::AsMeasured { from, to, reason },
            ));
        }
    }
    Ok(claims)
}

/// When the flow stress of a point was seen to come nearest to Table 6, give or take a step of the plan (us).
fn nearest_time(gauge: &str) -> (f64, f64) {
    match gauge {
        "H" => (7.5, 8.0),
        "I" => (9.25, 9.75),
        "G" => (10.0, 10.5),
        _ => (10.5, 11.0),
    }
}

/// Where errors against the tables were seen, and why.
fn seen(quantity: Quantity, moment: usize, gauge: &str) -> ((f64, f64), &'static str) {
    let off_axis = gauge == "I";
    match (quantity, moment) {
        (Quantity::FlowStress, 0) => (
            (-0.04, 0.02),
            "cell and steps of the paper, if they are not these, are not given; at K it never comes nearer",
        ),
        (Quantity::FlowStress, _) => {
            ((-0.1, 0.0), "the paper's is that at a frozen state, within its own noise of 1.4 %")
        }
        (Quantity::Deviator(0, 0), 0) => {
            (if off_axis { (-0.35, -0.15) } else { (0.0, 0.12) }, NORM)
        }
        (_, 0) => (if off_axis { (0.4, 0.9) } else { (-0.1, 0.07) }, NORM),
        (Quantity::Deviator(0, 0), _) => {
            (if off_axis { (0.4, 0.8) } else { (-0.25, -0.05) }, FROZEN)
        }
        _ => (if off_axis { (1.1, 2.0) } else { (-0.25, 0.1) }, FROZEN),
    }
}

const NORM: &str = "the printed norm of the deviator drops S_33, so that its stresses lie outside the yield surface; I, off the axis, is seen at another state than in the paper";
const FROZEN: &str =
    "the paper's is (S/sigma_y)^2 of that of sigma_y, a frozen state outside the yield surface";

/// Over all gauges and times.
fn largest_deviator(study: &PaperStudy<'_>, propagated: &Propagated<5>) -> f64 {
    let plan = study.plan();
    let mut largest = 0.0_f64;
    for gauge in 0..plan.gauges.len() {
        for window in 0..plan.windows.len() {
            let centre = |quantity| {
                propagated.moments[plan.index(gauge, quantity, window)].mean_first_order()
            };
            largest = largest.max(centre(1).abs() / centre(0));
        }
    }
    largest
}
