//! Balance of the reference run over time: its record, and the table, chart and file that show it.

use result_figures::number::exact;
use result_pages::{Chart, Series, Table};
use scene_runs::answers::Number;
use scene_runs::report::{cell, chart};
use serde::{Serialize, Serializer};
use smpm::Balance;

use crate::scene::{BoundaryKindScene, ContactScene, SmpmScene};

/// Names and values of the balance at a time, in units of the scene: what the bodies hold, and what gravity and each boundary have given
/// to them since the start. What is not known has no value, and is absent in the result.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BalanceRecord(Vec<(String, Option<f64>)>);

impl Serialize for BalanceRecord {
    fn serialize<R: Serializer>(&self, to: R) -> Result<R::Ok, R::Error> {
        to.collect_map(self.0.iter().filter_map(|(name, value)| Some((name, (*value)?))))
    }
}

/// Whether no work is done but that of gravity: by no absorbing boundary and no friction.
fn conserves_energy(scene: &SmpmScene) -> bool {
    let is_idle = |kind: BoundaryKindScene| match kind {
        BoundaryKindScene::Absorbing { .. } => false,
        BoundaryKindScene::Frictional { friction } => friction <= 0.0,
        _ => true,
    };
    let slides =
        matches!(scene.contact, ContactScene::Friction { coefficient } if coefficient > 0.0);
    !slides && scene.boundaries.iter().all(|boundary| is_idle(boundary.kind))
}

/// Records of a run in the order of time. Mean forces are since the time before.
pub(super) fn records<const D: usize>(scene: &SmpmScene, run: &[Balance<D>]) -> Vec<BalanceRecord> {
    let energy = |at: &Balance<D>| at.held.kinetic + at.held.internal;
    let record = |(i, at): (usize, &Balance<D>)| {
        let (held, external, mut all) = (&at.held, &at.external, Vec::new());
        let mut add = |name: String, value: Option<f64>| all.push((name, value));
        let error = energy(at) - energy(&run[0]) - external.gravity_work;
        for (name, value) in [
            ("time", Some(at.time)),
            ("mass", Some(held.mass)),
            ("failed_mass", Some(held.failed)),
            ("kinetic_energy", Some(held.kinetic)),
            ("internal_energy", Some(held.internal)),
            ("total_energy", Some(energy(at))),
            ("gravity_work", Some(external.gravity_work)),
            ("energy_error", conserves_energy(scene).then_some(error)),
        ] {
            add(name.to_owned(), value);
        }
        let before = i.checked_sub(1).map(|before| &run[before]);
        for k in 0..D {
            add(format!("momentum_{}", k + 1), Some(held.momentum[k]));
            add(format!("gravity_impulse_{}", k + 1), Some(external.gravity_impulse[k]));
            for (b, given) in external.reactions.iter().take(scene.boundaries.len()).enumerate() {
                let earlier = before.map(|it| (it.external.reactions[b][k], at.time - it.time));
                let force = earlier.map(|(earlier, span)| (given[k] - earlier) / span);
                add(format!("boundary_{b}_impulse_{}", k + 1), Some(given[k]));
                add(format!("boundary_{b}_mean_force_{}", k + 1), force);
            }
        }
        BalanceRecord(all)
    };
    run.iter().enumerate().map(record).collect()
}

/// A name in words with its unit: per radian, thickness or area where the scene has fewer than three dimensions.
fn head(scene: &SmpmScene, name: &str) -> String {
    let [length, time, _, density, velocity] = scene.units.names();
    let mass = density.split('/').next().unwrap_or_default();
    let unit = match name {
        "time" => return format!("time ({time})"),
        "mass" | "failed_mass" => mass.to_owned(),
        _ if name.contains("force") => format!("{mass} {length}/{time}^2"),
        _ if name.contains("impulse") || name.contains("momentum") => format!("{mass} {velocity}"),
        _ => format!("{mass} {length}^2/{time}^2"),
    };
    let per = match scene.dimension {
        1 => format!(" per {length}^2"),
        2 if scene.axisymmetric => " per radian".to_owned(),
        2 => format!(" per {length}"),
        _ => String::new(),
    };
    format!("{} ({unit}{per})", name.replace('_', " "))
}

/// Heads with units; none without a run that was shown.
fn heads(scene: &SmpmScene, records: &[BalanceRecord]) -> Option<Vec<String>> {
    Some(records.first()?.0.iter().map(|(name, _)| head(scene, name)).collect())
}

/// The table of the page, and the energies over time.
pub(super) fn shown(scene: &SmpmScene, records: &[BalanceRecord]) -> Option<(Table, Chart)> {
    let about = "Of the reference run. Impulses and work are since the start, mean forces since the time before. The energy error is the change of the total energy less the work of gravity.";
    let row = |at: &BalanceRecord| at.0.iter().map(|(_, value)| cell(*value)).collect();
    let (title, about) = ("Balance over time".to_owned(), about.to_owned());
    let rows = records.iter().map(row).collect();
    let table = Table { title, about, heads: heads(scene, records)?, rows };
    let line = |name: &str| {
        let get = |at: &BalanceRecord, name: &str| {
            at.0.iter().find(|(of, _)| of == name).and_then(|(_, value)| *value).unwrap_or_default()
        };
        let point = |at| Number::sampled(get(at, name), None).point(get(at, "time"));
        Series { name: name.replace('_', " "), points: records.iter().map(point).collect() }
    };
    let names = ["kinetic_energy", "internal_energy", "total_energy", "gravity_work"];
    let n_lines = if scene.gravity.is_empty() { 3 } else { 4 };
    let labels = ["time", "energy"].map(|name| head(scene, name));
    let lines = names.into_iter().take(n_lines).map(line).collect();
    Some((table, chart("Energies over time".to_owned(), labels, lines)))
}

/// The records as comma-separated values, all digits; an empty cell for what is not known.
pub(super) fn csv(scene: &SmpmScene, records: &[BalanceRecord]) -> Option<String> {
    let number = |value: Option<f64>| value.map_or_else(String::new, exact);
    let row = |at: &BalanceRecord| at.0.iter().map(|(_, value)| number(*value)).collect();
    let lines = std::iter::once(heads(scene, records)?).chain(records.iter().map(row));
    Some(lines.map(|cells: Vec<String>| cells.join(",") + "\n").collect())
}
