//! Result file of a run: quantities over time, each value with its error.

use serde::Serialize;

use super::observed::Observed;
use super::resolutions::Resolutions;
use crate::fpk::density::Exceedances;
use crate::fpk::scene::FpkScene;
use crate::fpk::system::System;
use crate::run_result::Unknown;

/// Keys that this kind adds to the schema `run-result/1`.
#[derive(Debug, Serialize)]
pub(crate) struct Content {
    pub(crate) seed: Option<u64>,
    pub(crate) work: WorkRecord,
    /// Why the run ended before its last time.
    pub(crate) stopped: Option<String>,
    /// Unknown errors, and why; nothing else is missing.
    pub(crate) unknown: Vec<Unknown>,
    pub(crate) quantities: Vec<Series>,
}

/// Work counters.
#[derive(Debug, Default, Serialize)]
pub(crate) struct WorkRecord {
    pub(crate) particles: Option<usize>,
    pub(crate) steps: Option<u64>,
    pub(crate) evaluations: Option<u64>,
    pub(crate) neighbour_visits: Option<u64>,
    pub(crate) path_steps: Option<u64>,
    pub(crate) cpu_seconds: f64,
}

/// A quantity over time.
#[derive(Debug, Serialize)]
pub(crate) struct Series {
    pub(crate) id: String,
    pub(crate) quantity: String,
    pub(crate) unit: String,
    pub(crate) values: Vec<Observed>,
}

/// An exceedance estimator: suffix of its id, and its field.
type Estimator = (&'static str, fn(&Exceedances) -> Option<f64>);

const CELL: &str = "cell";
const ESTIMATORS: [Estimator; 3] = [
    (CELL, |e| e.cell_integrated),
    ("log-interpolated", |e| Some(e.log_interpolated)),
    ("indicator", |e| Some(e.indicator)),
];

/// All quantities of the scene, without those that the method does not compute.
pub(super) fn series(both: &Resolutions, scene: &FpkScene, system: &System) -> Vec<Series> {
    let series =
        |id: String, quantity: String, values| Series { id, quantity, unit: String::new(), values };
    let mut all = Vec::new();
    for (k, powers) in scene.moments.iter().enumerate() {
        let values = both.values(|row| Some(row.moments[k]));
        all.push(moment_series(powers, system, values));
    }
    let demand = demand_name(scene, system);
    for (name, pick) in ESTIMATORS {
        for (k, threshold) in scene.thresholds.iter().enumerate() {
            let mut values = both.values(|row| pick(&row.exceedances[k]));
            for observed in &mut values {
                let Some(row) = both.fine.at(observed.t) else { continue };
                if name == CELL {
                    observed.note.clone_from(&row.exceedances[k].note);
                    // `Probability::Below`: a difference of runs says nothing of what no particle carries.
                    if observed.value <= row.mass_outside {
                        observed.bounded_by(row.mass_outside);
                    }
                } else {
                    // Counts of masses end with the cloud; the fits of the cells go on beyond it.
                    observed.may_lack(row.mass_outside);
                }
            }
            let quantity = format!("P(|{demand}| > {threshold})");
            all.push(series(format!("exceedance-{name}/{threshold}"), quantity, values));
        }
    }
    all.push(series(
        "total-mass".into(),
        "sum of the masses".into(),
        both.values(|row| Some(row.total_mass)),
    ));
    all.push(series(
        "cell-mass".into(),
        "mass over the cells".into(),
        both.values(|row| row.cell_mass),
    ));
    all.push(series(
        "entropy".into(),
        "entropy (nats)".into(),
        both.values(|row| Some(row.entropy)),
    ));
    all.retain(|series| !series.values.is_empty());
    all
}

/// Moments and exceedances of a scene by a method with one estimator.
///
/// `moment` and `exceedance` take indices in the lists of the scene. Quantities without a value are omitted.
pub(super) fn asked_series(
    scene: &FpkScene,
    system: &System,
    moment: &dyn Fn(usize) -> Vec<Observed>,
    exceedance: &dyn Fn(usize) -> Vec<Observed>,
) -> Vec<Series> {
    let moments = scene.moments.iter().enumerate();
    let moments = moments.map(|(k, powers)| moment_series(powers, system, moment(k)));
    let demand = demand_name(scene, system);
    let exceedances = scene.thresholds.iter().enumerate().map(|(k, threshold)| {
        let quantity = format!("P(|{demand}| > {threshold})");
        let id = format!("exceedance/{threshold}");
        Series { id, quantity, unit: String::new(), values: exceedance(k) }
    });
    moments.chain(exceedances).filter(|series| !series.values.is_empty()).collect()
}

fn moment_series(powers: &[u32], system: &System, values: Vec<Observed>) -> Series {
    let (id, quantity) = (moment_id(powers), moment_words(powers, system.states()));
    Series { id, quantity, unit: moment_unit(powers, system.states()), values }
}

/// Unit of a moment, e.g. `m^2/s` of `E[q v]`; none of a process whose states have the unit of the user.
pub(super) fn moment_unit(powers: &[u32], states: &[&str]) -> String {
    let (mut length, mut time) = (0, 0);
    for (&power, state) in powers.iter().zip(states) {
        match *state {
            "xg" | "xf" => length += power,
            state if state.starts_with(['q', 'z']) => length += power,
            state if state.starts_with('v') => (length, time) = (length + power, time + power),
            _ => return String::new(),
        }
    }
    let power_of = |unit: &str, power: u32| match power {
        1 => unit.to_owned(),
        power => format!("{unit}^{power}"),
    };
    match (length, time) {
        (0, _) => String::new(),
        (length, 0) => power_of("m", length),
        (length, time) => format!("{}/{}", power_of("m", length), power_of("s", time)),
    }
}

/// Id of a moment, e.g. `moment/2-0`.
pub(super) fn moment_id(powers: &[u32]) -> String {
    let powers: Vec<String> = powers.iter().map(ToString::to_string).collect();
    format!("moment/{}", powers.join("-"))
}

/// Symbol of a moment, e.g. `E[q^2 v]`, without states to the power of zero.
pub(super) fn moment_words(powers: &[u32], states: &[&str]) -> String {
    let factor = |(name, &power): (&&str, &u32)| match power {
        0 => None,
        1 => Some((*name).to_owned()),
        _ => Some(format!("{name}^{power}")),
    };
    let factors: Vec<String> = states.iter().zip(powers).filter_map(factor).collect();
    format!("E[{}]", factors.join(" "))
}

/// Name of the demand.
pub(super) fn demand_name(scene: &FpkScene, system: &System) -> String {
    scene.demand(system.states()).map(|demand| demand.name).unwrap_or_default()
}
