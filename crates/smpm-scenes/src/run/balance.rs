//! Balance of the reference run over time: its record, and the table, chart and file that show it.

use result_figures::number::{exact, percent, short};
use result_pages::{Chart, Note, Series, Table};
use scene_runs::answers::Number;
use scene_runs::report::{cell, chart};
use serde::{Serialize, Serializer};
use smpm::Balance;

use crate::scene::{BoundaryKindScene, ContactScene, SmpmScene};

/// Names and values of the balance at a time, in units of the scene: what the bodies hold, and what gravity, loads and each boundary have given
/// to them since the start. What is not known has no value, and is absent in the result.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BalanceRecord(Vec<(String, Option<f64>)>);

impl Serialize for BalanceRecord {
    fn serialize<R: Serializer>(&self, to: R) -> Result<R::Ok, R::Error> {
        to.collect_map(self.0.iter().filter_map(|(name, value)| Some((name, (*value)?))))
    }
}

/// Whether no work is done but that of gravity, loads and a rigid body: by no absorbing boundary, no friction and no damping.
fn conserves_energy(scene: &SmpmScene) -> bool {
    let is_idle = |kind: BoundaryKindScene| match kind {
        BoundaryKindScene::Absorbing { .. } => false,
        BoundaryKindScene::Frictional { friction } => friction <= 0.0,
        _ => true,
    };
    let slides =
        matches!(scene.contact, ContactScene::Friction { coefficient } if coefficient > 0.0);
    !is_damped(scene) && !slides && scene.boundaries.iter().all(|boundary| is_idle(boundary.kind))
}

/// Whether damping takes momentum and energy that no record has.
fn is_damped(scene: &SmpmScene) -> bool {
    scene.scheme.damping.is_some_and(|damping| damping > 0.0)
}

/// Records of a run in the order of time. Mean forces are since the time before.
pub(super) fn records<const D: usize>(scene: &SmpmScene, run: &[Balance<D>]) -> Vec<BalanceRecord> {
    let energy = |at: &Balance<D>| at.held.kinetic + at.held.internal;
    let is_rigid = scene.bodies.iter().any(|body| body.rigid);
    let is_loaded = scene.bodies.iter().any(|body| !body.loads.is_empty());
    // What it gives is what the others lack, which damping takes too, and along the radius hoop stress.
    let is_known = |k: usize| !is_damped(scene) && (k > 0 || !scene.axisymmetric);
    let record = |(i, at): (usize, &Balance<D>)| {
        let (held, external) = (&at.held, &at.external);
        let work = external.gravity_work + external.load_work + external.rigid_work;
        let error = energy(at) - energy(&run[0]) - work;
        let mut all: Vec<(String, Option<f64>)> = [
            ("time", Some(at.time)),
            ("mass", Some(held.mass)),
            ("failed_mass", Some(held.failed)),
            ("kinetic_energy", Some(held.kinetic)),
            ("internal_energy", Some(held.internal)),
            ("total_energy", Some(energy(at))),
            ("gravity_work", Some(external.gravity_work)),
            ("energy_error", conserves_energy(scene).then_some(error)),
        ]
        .map(|(name, value)| (name.to_owned(), value))
        .into();
        if is_loaded {
            all.push(("load_work".to_owned(), Some(external.load_work)));
        }
        if is_rigid {
            let work = (!is_damped(scene)).then_some(external.rigid_work);
            all.push(("rigid_body_work".to_owned(), work));
        }
        let before = i.checked_sub(1).map(|before| &run[before]);
        let given = |name: &str, k: usize, by: &dyn Fn(&Balance<D>) -> Option<f64>| {
            let force = before.and_then(|it| Some((by(at)? - by(it)?) / (at.time - it.time)));
            [("impulse", by(at)), ("mean_force", force)]
                .map(|(what, value)| (format!("{name}_{what}_{}", k + 1), value))
        };
        for k in 0..D {
            all.push((format!("momentum_{}", k + 1), Some(held.momentum[k])));
            let by_gravity = external.gravity_impulse[k];
            all.push((format!("gravity_impulse_{}", k + 1), Some(by_gravity)));
            if is_loaded {
                all.push((format!("load_impulse_{}", k + 1), Some(external.load_impulse[k])));
            }
            for b in 0..scene.boundaries.len() {
                all.extend(given(&format!("boundary_{b}"), k, &|it| {
                    it.external.reactions.get(b).map(|by| by[k])
                }));
            }
            if is_rigid {
                all.extend(given("rigid_body", k, &|it| {
                    is_known(k).then_some(it.external.rigid_impulse[k])
                }));
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
    let about = "Of the reference run. Impulses and work are since the start, mean forces since the time before. The energy error is the change of the total energy less the work of gravity, loads and a rigid body.";
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

/// Whether a damped run is at rest at its last time, by the part `K / W` of kinetic energy in the work of gravity and loads or else the
/// change of internal energy: what oscillates about `u` by `a` has `K / W` up to `(a / u)^2 / 2`.
pub(super) fn rest(scene: &SmpmScene, records: &[BalanceRecord]) -> Option<Note> {
    let (first, last) = (records.first()?, records.last().filter(|_| is_damped(scene))?);
    let get = |at: &BalanceRecord, name: &str| at.0.iter().find(|(of, _)| of == name)?.1;
    let change = get(last, "internal_energy")? - get(first, "internal_energy")?;
    let given = get(last, "gravity_work")? + get(last, "load_work").unwrap_or_default();
    let work = if given == 0.0 { change } else { given }.abs();
    let share = get(last, "kinetic_energy")? / work;
    let swing = (2.0 * share).sqrt();
    let text = format!(
        "damped: at the last time the kinetic energy is {} of the work done, so that displacements are within about {} of those at rest",
        short(Some(share)),
        percent(swing)
    );
    Some(if swing < AT_REST {
        Note::Remark(text)
    } else {
        Note::Warning(format!("{text}; take a later last time, or more `damping`"))
    })
}

/// Part of a displacement by which a damped body may still oscillate at rest (no unit).
const AT_REST: f64 = 0.01;

/// The records as comma-separated values, all digits; an empty cell for what is not known.
pub(super) fn csv(scene: &SmpmScene, records: &[BalanceRecord]) -> Option<String> {
    let number = |value: Option<f64>| value.map_or_else(String::new, exact);
    let row = |at: &BalanceRecord| at.0.iter().map(|(_, value)| number(*value)).collect();
    let lines = std::iter::once(heads(scene, records)?).chain(records.iter().map(row));
    Some(lines.map(|cells: Vec<String>| cells.join(",") + "\n").collect())
}
