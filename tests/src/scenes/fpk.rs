//! Runs a density scene: two resolutions for the error, or Monte Carlo with its standard error.

mod pictures;
#[cfg(test)]
mod tests;
mod two_resolutions;

use std::path::{Path, PathBuf};

use sde_integrators::{Estimate, GaussianMixture, Uncertainty};
use serde::Serialize;

use crate::case::Context;
use crate::chart::{Line, Scale, TimeSeries, Words};
use crate::charts::Drawing;
use crate::fpk::density::{self, Asked, Erased, Exceedances, Row};
use crate::fpk::method_scene::MethodScene;
use crate::fpk::monte_carlo::{self, Sampling};
use crate::fpk::paths::Paths;
use crate::fpk::scene::FpkScene;
use crate::fpk::scene_system::{SceneSystem, Visitor};
use crate::machine::{Machine, commit};
use crate::output::write_json;
use crate::scene::SceneFile;
use crate::scenes::{RunError, SceneKind};
use pictures::Pictures;
use two_resolutions::{TwoResolutions, Unknown};

pub(crate) const KIND: SceneKind =
    SceneKind { solver: "fpk-sph", schema: || schemars::schema_for!(FpkScene), run };

/// Everything that came of a run: the schema `run-result/1`.
#[derive(Debug, Serialize)]
struct RunResult<'a> {
    schema: &'static str,
    version: &'static str,
    commit: Option<String>,
    machine: Machine,
    /// The scene as it was understood.
    scene: &'a FpkScene,
    seed: Option<u64>,
    work: WorkRecord,
    /// Why the run ended before its last time.
    stopped: Option<String>,
    /// What is not known, and why; nothing else is missing.
    unknown: Vec<Unknown>,
    quantities: Vec<Series>,
}

/// Work counted.
#[derive(Debug, Default, Serialize)]
struct WorkRecord {
    particles: Option<usize>,
    steps: Option<u64>,
    evaluations: Option<u64>,
    neighbour_visits: Option<u64>,
    path_steps: Option<u64>,
    cpu_seconds: f64,
}

/// A quantity over time.
#[derive(Debug, Serialize)]
struct Series {
    id: String,
    quantity: String,
    unit: &'static str,
    values: Vec<Observed>,
}

/// A quantity at a time, with its error.
#[derive(Debug, Serialize)]
struct Observed {
    t: f64,
    value: f64,
    error: Option<f64>,
    error_kind: ErrorOrigin,
    /// What the value rests on, where that is not firm.
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
}

impl Observed {
    /// The value, unless its error leaves nothing of it.
    fn known(&self) -> Option<f64> {
        self.error.is_none_or(|error| error < self.value.abs()).then_some(self.value)
    }
}

/// Where an error comes from.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "snake_case")]
enum ErrorOrigin {
    /// A second run with fewer intervals per axis, and the fitted order 2.
    TwoResolutions,
    StandardError,
    Bound,
    /// A count.
    Exact,
    Unknown,
}

/// What a method made of a scene.
#[derive(Debug, Default)]
struct Outcome {
    work: WorkRecord,
    stopped: Option<fpk_sph::Error>,
    unknown: Vec<Unknown>,
    quantities: Vec<Series>,
    seed: Option<u64>,
    /// Pictures of the density itself.
    drawings: Vec<Drawing>,
    /// Files already written.
    files: Vec<PathBuf>,
}

fn run(file: &SceneFile, out: &Path, context: &Context<'_>) -> Result<Vec<PathBuf>, RunError> {
    let scene: FpkScene = file.parse()?;
    let system = scene.system.build().map_err(RunError::solver)?;
    let Outcome { work, stopped, unknown, quantities, seed, drawings: planes, files } =
        if let MethodScene::MonteCarlo { paths, step, integrator, seed } = scene.method {
            context.progress("Monte Carlo");
            let sampling = Sampling { paths, step, integrator, seed };
            system.visit(Sampled { scene: &scene, system: &system, sampling })?
        } else {
            system.visit(Solved { scene: &scene, system: &system, out, context })?
        };
    for Unknown { what, reason } in &unknown {
        context.progress(&format!("unknown: {what}: {reason}"));
    }
    let drawings = drawings(&scene, &system, &quantities)?;
    let result = RunResult {
        schema: "run-result/1",
        version: env!("CARGO_PKG_VERSION"),
        commit: commit(),
        machine: Machine::read(),
        scene: &scene,
        seed,
        work,
        stopped: stopped.as_ref().map(ToString::to_string),
        unknown,
        quantities,
    };
    let path = out.join("result.json");
    write_json(&path, &result)?;
    let mut written = vec![path];
    written.extend(files);
    for drawing in drawings.into_iter().chain(planes) {
        written.push(drawing.write(out).map_err(RunError::solver)?);
    }
    // What was reached is written; that it was not all is the run's outcome.
    stopped.map_or(Ok(written), |error| Err(RunError::solver(error)))
}

/// What the scene asks, in the dimension of its system. The scene has been checked: its lists have as many entries as
/// the system has states.
fn asked<const D: usize>(
    scene: &FpkScene,
    system: &SceneSystem,
    cells: bool,
) -> Result<Asked<D>, RunError> {
    let powers = |powers: &Vec<u32>| {
        powers.as_slice().try_into().map_err(|_| RunError::solver(OtherDimension { states: D }))
    };
    Ok(Asked {
        times: scene.times.list(),
        powers: scene.moments.iter().map(powers).collect::<Result<_, _>>()?,
        demand: scene
            .demand(system.states())
            .map_err(|_| RunError::solver(OtherDimension { states: D }))?,
        thresholds: scene.thresholds.clone(),
        cells,
    })
}

/// A scene that was not checked.
#[derive(Debug, thiserror::Error)]
#[error("the scene is of another dimension than its system, which has {states} states")]
struct OtherDimension {
    states: usize,
}

/// The law of the scene in the dimension of its system.
fn law<const D: usize>(
    scene: &FpkScene,
    system: &SceneSystem,
) -> Result<GaussianMixture<D>, RunError> {
    scene.initial.build(system.filter_covariance().as_deref()).map_err(RunError::solver)
}

/// Most states for which exceedances are integrated over cells: beyond, each cell has thousands of parts.
const MOST_STATES_OF_CELLS: usize = 4;

/// Why nothing is integrated over cells, where that is so.
fn no_cells(method: &MethodScene, states: usize) -> Option<Unknown> {
    let reason = match method {
        MethodScene::LogDensityFit(_) | MethodScene::FlowMapFit(_) => {
            (states > MOST_STATES_OF_CELLS).then(|| {
                format!(
                    "cells are integrated in {MOST_STATES_OF_CELLS} dimensions at most, and there are {states} states: \
                     read exceedance-log-interpolated"
                )
            })
        }
        MethodScene::CanorDenoel2013 { .. } | MethodScene::MonteCarlo { .. } => Some(
            "the method has no local fits, which integrals over cells need: read exceedance-log-interpolated"
                .to_owned(),
        ),
    }?;
    Some(Unknown { what: "exceedance-cell, cell-mass and distrusted-cells".to_owned(), reason })
}

/// The density solver at two resolutions.
struct Solved<'a> {
    scene: &'a FpkScene,
    system: &'a SceneSystem,
    out: &'a Path,
    context: &'a Context<'a>,
}

impl Visitor for Solved<'_> {
    type Output = Result<Outcome, RunError>;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> Self::Output {
        let Self { scene, system: named, out, context } = self;
        let law = law::<D>(scene, named)?;
        let no_cells = no_cells(&scene.method, D);
        let asked = asked::<D>(scene, named, no_cells.is_none())?;
        let period = named.reference_period();
        let config = |part: f64| scene.method.density_config::<D>(period, part);
        let Some(whole) = config(1.0) else {
            return Err(RunError::solver(OtherDimension { states: D }));
        };
        context.progress("density");
        let mut pictures = Pictures::new(scene, named.states(), &whole, out);
        let fine = density::run_on(Erased(system), &law, &whole, &asked, |simulation, row| {
            pictures.look(simulation, row);
        })
        .map_err(RunError::solver)?;
        context.progress("density at the coarser resolution, for its error");
        let both = TwoResolutions::new(fine, config, |config| {
            density::run_on(Erased(system), &law, config, &asked, |_, _| ())
        });
        let quantities = series(&both, scene, named);
        let unknown = no_cells.into_iter().chain(both.unknown()).collect();
        let fine = both.fine;
        let (drawings, files) = pictures.finish()?;
        let work = WorkRecord {
            particles: Some(fine.n_particles),
            steps: Some(fine.work.steps),
            evaluations: Some(fine.work.evaluations),
            neighbour_visits: Some(fine.work.neighbour_visits),
            path_steps: None,
            cpu_seconds: fine.rows.last().map_or(0.0, |row| row.cpu_seconds),
        };
        let stopped = fine.stopped;
        Ok(Outcome { work, stopped, unknown, quantities, seed: None, drawings, files })
    }
}

/// An estimator of exceedance, as the end of an id and as a field.
type Estimator = (&'static str, fn(&Exceedances) -> Option<f64>);

const CELL: &str = "cell";
const ESTIMATORS: [Estimator; 3] = [
    (CELL, |e| e.cell_integrated),
    ("log-interpolated", |e| Some(e.log_interpolated)),
    ("indicator", |e| Some(e.indicator)),
];

/// All quantities of the scene; those that the method does not give are left out.
fn series(both: &TwoResolutions, scene: &FpkScene, system: &SceneSystem) -> Vec<Series> {
    let series = |id: String, quantity: String, values| Series { id, quantity, unit: "", values };
    let mut all = Vec::new();
    for (k, powers) in scene.moments.iter().enumerate() {
        let values = both.values(|row| Some(row.moments[k]));
        let quantity = moment_words(powers, system.states());
        all.push(series(moment_id(powers), quantity, values));
    }
    let demand = demand_name(scene, system);
    for (name, pick) in ESTIMATORS {
        for (k, threshold) in scene.thresholds.iter().enumerate() {
            let mut values = both.values(|row| pick(&row.exceedances[k]));
            if name == CELL {
                for observed in &mut values {
                    let row = both.fine.at(observed.t);
                    observed.note = row.and_then(|row| row.exceedances[k].note());
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
    let counted = |row: &Row| {
        let value = row.distrusted_cells? as f64;
        let error_kind = ErrorOrigin::Exact;
        Some(Observed { t: row.t, value, error: None, error_kind, note: None })
    };
    all.push(series(
        "distrusted-cells".into(),
        "cells in which the fit was not trusted".into(),
        both.fine.rows.iter().filter_map(counted).collect(),
    ));
    all.retain(|series| !series.values.is_empty());
    all
}

/// Sampled paths.
struct Sampled<'a> {
    scene: &'a FpkScene,
    system: &'a SceneSystem,
    sampling: Sampling,
}

impl Visitor for Sampled<'_> {
    type Output = Result<Outcome, RunError>;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> Self::Output {
        let Self { scene, system: named, sampling } = self;
        let (law, asked) = (law::<D>(scene, named)?, asked::<D>(scene, named, false)?);
        let run = monte_carlo::run_on(system, &law, &sampling, &asked).map_err(RunError::solver)?;
        let values = |pick: &dyn Fn(&monte_carlo::SampledRow) -> Estimate| -> Vec<Observed> {
            run.rows.iter().map(|row| sampled_value(row.t, pick(row))).collect()
        };
        let series = |id, quantity, values| Series { id, quantity, unit: "", values };
        let mut quantities = Vec::new();
        for (k, powers) in scene.moments.iter().enumerate() {
            let (id, quantity) = (moment_id(powers), moment_words(powers, named.states()));
            quantities.push(series(id, quantity, values(&|row| row.moments[k])));
        }
        for (k, threshold) in scene.thresholds.iter().enumerate() {
            let quantity = format!("P(|{}| > {threshold})", asked.demand.name);
            let id = format!("exceedance/{threshold}");
            quantities.push(series(id, quantity, values(&|row| row.exceedances[k])));
        }
        let work = WorkRecord {
            path_steps: u64::try_from(run.path_steps).ok(),
            cpu_seconds: run.cpu_seconds,
            ..WorkRecord::default()
        };
        Ok(Outcome { work, quantities, seed: Some(sampling.seed), ..Outcome::default() })
    }
}

/// `moment/2-0`.
fn moment_id(powers: &[u32]) -> String {
    let powers: Vec<String> = powers.iter().map(ToString::to_string).collect();
    format!("moment/{}", powers.join("-"))
}

/// `E[q^2 v]`, without what is to the power of zero.
fn moment_words(powers: &[u32], states: &[&str]) -> String {
    let factor = |(name, &power): (&&str, &u32)| match power {
        0 => None,
        1 => Some((*name).to_owned()),
        _ => Some(format!("{name}^{power}")),
    };
    let factors: Vec<String> = states.iter().zip(powers).filter_map(factor).collect();
    format!("E[{}]", factors.join(" "))
}

fn sampled_value(t: f64, estimate: Estimate) -> Observed {
    let (error, error_kind) = match estimate.uncertainty {
        Uncertainty::StandardError(error) => (Some(error), ErrorOrigin::StandardError),
        Uncertainty::Bound(error) => (Some(error), ErrorOrigin::Bound),
        Uncertainty::Unknown => (None, ErrorOrigin::Unknown),
    };
    Observed { t, value: estimate.value, error, error_kind, note: None }
}

/// The name of what exceeds the thresholds.
fn demand_name(scene: &FpkScene, system: &SceneSystem) -> String {
    scene.demand(system.states()).map(|demand| demand.name).unwrap_or_default()
}

/// The second moments, and the probabilities, over time.
fn drawings(
    scene: &FpkScene,
    system: &SceneSystem,
    quantities: &[Series],
) -> Result<Vec<Drawing>, RunError> {
    let second = |powers: &&Vec<u32>| powers.iter().sum::<u32>() == 2;
    let second: Vec<String> =
        scene.moments.iter().filter(second).map(|powers| moment_id(powers)).collect();
    let exceeds = format!("P(|{}| > T)", demand_name(scene, system));
    // One estimator on the picture: the best that the method offers. All are in the result.
    let best = ["exceedance-cell/", "exceedance-log-interpolated/", "exceedance/"];
    let prefix = best
        .into_iter()
        .find(|prefix| quantities.iter().any(|series| series.id.starts_with(prefix)))
        .unwrap_or(best[0]);
    let moments = lines(
        quantities,
        |id| second.iter().any(|wanted| wanted == id),
        |observed| Some(observed.value),
    );
    let tails = lines(quantities, |id| id.starts_with(prefix), Observed::known);
    let smaller = "Values that are smaller than their error are left out.";
    let mut drawings = Vec::new();
    for (name, lines, scale, title, y_label, note) in [
        ("moments", moments, Scale::Linear, "Second moments over time", "second moment", None),
        (
            "exceedance",
            tails,
            Scale::Log,
            "Probability of exceedance over time",
            exceeds.as_str(),
            Some(smaller),
        ),
    ] {
        if lines.is_empty() {
            continue;
        }
        let words = Words {
            title: title.into(),
            subtitle: scene.title.clone(),
            x_label: "time t (s)".into(),
            y_label: y_label.into(),
            caption: note
                .map(str::to_owned)
                .into_iter()
                .chain([Machine::read().caption()])
                .collect(),
        };
        let chart = TimeSeries { words, scale, lines, bands: Vec::new(), references: Vec::new() };
        drawings.push(Drawing::time_series(name, &chart).map_err(RunError::solver)?);
    }
    Ok(drawings)
}

/// The wanted series as lines; what `shown` leaves out is a gap.
fn lines(
    quantities: &[Series],
    wanted: impl Fn(&str) -> bool,
    shown: impl Fn(&Observed) -> Option<f64>,
) -> Vec<Line> {
    let line = |series: &Series| Line {
        name: series.quantity.clone(),
        points: series.values.iter().map(|observed| (observed.t, shown(observed))).collect(),
    };
    quantities
        .iter()
        .filter(|series| wanted(&series.id))
        .map(line)
        .filter(|line| line.points.iter().any(|(_, value)| value.is_some()))
        .collect()
}
