//! Runs a density scene: two resolutions for the error, or Monte Carlo with its standard error.

use std::path::{Path, PathBuf};

use sde_integrators::{Estimate, Uncertainty};
use serde::Serialize;

use crate::case::Context;
use crate::chart::{Line, Scale, TimeSeries, Words};
use crate::charts::Drawing;
use crate::fpk::density::{self, Asked, DensityRun, Exceedances, Row};
use crate::fpk::monte_carlo::{self, Sampling};
use crate::fpk::scene::{FpkScene, MethodScene};
use crate::machine::{Machine, commit};
use crate::output::write_json;
use crate::scene::SceneFile;
use crate::scenes::{RunError, SceneKind};

pub(crate) const KIND: SceneKind = SceneKind { solver: "fpk-sph", run };

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
    /// A second run with the intervals per axis over the square root of two, and the fitted order 2.
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
    quantities: Vec<Series>,
    seed: Option<u64>,
}

/// The coarse run has this times the intervals per axis.
const COARSE: f64 = std::f64::consts::FRAC_1_SQRT_2;

fn run(file: &SceneFile, out: &Path, context: &Context<'_>) -> Result<Vec<PathBuf>, RunError> {
    let scene: FpkScene = file.parse()?;
    let Outcome { work, stopped, quantities, seed } =
        if let MethodScene::MonteCarlo { paths, step, integrator, seed } = scene.method {
            sampled(&scene, &Sampling { paths, step, integrator, seed }, context)?
        } else {
            solved(&scene, context)?
        };
    let drawings = drawings(&scene, &quantities)?;
    let result = RunResult {
        schema: "run-result/1",
        version: env!("CARGO_PKG_VERSION"),
        commit: commit(),
        machine: Machine::read(),
        scene: &scene,
        seed,
        work,
        stopped: stopped.as_ref().map(ToString::to_string),
        quantities,
    };
    let path = out.join("result.json");
    write_json(&path, &result)?;
    let mut written = vec![path];
    for drawing in drawings {
        written.push(drawing.write(out).map_err(RunError::solver)?);
    }
    // What was reached is written; that it was not all is the run's outcome.
    stopped.map_or(Ok(written), |error| Err(RunError::solver(error)))
}

fn asked(scene: &FpkScene, cells: bool) -> Asked {
    Asked {
        times: scene.times.list(),
        powers: scene.moments.clone(),
        thresholds: scene.thresholds.clone(),
        cells,
    }
}

/// The density solver at two resolutions.
fn solved(scene: &FpkScene, context: &Context<'_>) -> Result<Outcome, RunError> {
    let system = scene.system.build().map_err(RunError::solver)?;
    let law = scene.initial.build().map_err(RunError::solver)?;
    // The paper's clouds leave too few neighbours for local fits.
    let cells = matches!(scene.method, MethodScene::LogDensityFit { .. });
    let asked = asked(scene, cells);
    let at_scale = |scale: f64| -> Result<Option<DensityRun>, RunError> {
        let Some(config) = scene.density_config(system.period(), scale) else { return Ok(None) };
        density::run(&system, &law, &config, &asked).map(Some).map_err(RunError::solver)
    };
    context.progress("density");
    let Some(fine) = at_scale(1.0)? else { return Ok(Outcome::default()) };
    context.progress("density at the coarser resolution, for its error");
    // A coarse run that cannot be done leaves the error unknown; it says nothing against the fine one.
    let coarse = at_scale(COARSE).ok().flatten();
    let quantities = Pairs { fine: &fine, coarse: coarse.as_ref() }.series(scene);
    let work = WorkRecord {
        particles: Some(fine.n_particles),
        steps: Some(fine.work.steps),
        evaluations: Some(fine.work.evaluations),
        neighbour_visits: Some(fine.work.neighbour_visits),
        path_steps: None,
        cpu_seconds: fine.rows.last().map_or(0.0, |row| row.cpu_seconds),
    };
    Ok(Outcome { work, stopped: fine.stopped, quantities, seed: None })
}

/// An estimator of exceedance, as the end of an id and as a field.
type Estimator = (&'static str, fn(&Exceedances) -> Option<f64>);

const ESTIMATORS: [Estimator; 3] = [
    ("cell", |e| e.cell_integrated),
    ("log-interpolated", |e| Some(e.log_interpolated)),
    ("indicator", |e| Some(e.indicator)),
];

/// A fine run and a coarse one.
struct Pairs<'a> {
    fine: &'a DensityRun,
    coarse: Option<&'a DensityRun>,
}

impl Pairs<'_> {
    /// All quantities of the scene; those that the method does not give are left out.
    fn series(&self, scene: &FpkScene) -> Vec<Series> {
        let series =
            |id: String, quantity: String, values| Series { id, quantity, unit: "", values };
        let mut all = Vec::new();
        for (k, [a, b]) in scene.moments.iter().enumerate() {
            let values = self.values(|row| Some(row.moments[k]));
            all.push(series(format!("moment/{a}-{b}"), moment_words(*a, *b), values));
        }
        for (name, pick) in ESTIMATORS {
            for (k, threshold) in scene.thresholds.iter().enumerate() {
                let values = self.values(|row| pick(&row.exceedances[k]));
                let quantity = format!("P(|q| > {threshold})");
                all.push(series(format!("exceedance-{name}/{threshold}"), quantity, values));
            }
        }
        all.push(series(
            "total-mass".into(),
            "sum of the masses".into(),
            self.values(|row| Some(row.total_mass)),
        ));
        all.push(series(
            "cell-mass".into(),
            "mass over the cells".into(),
            self.values(|row| row.cell_mass),
        ));
        all.push(series(
            "entropy".into(),
            "entropy (nats)".into(),
            self.values(|row| Some(row.entropy)),
        ));
        let counted = |row: &Row| {
            let value = row.distrusted_cells? as f64;
            Some(Observed { t: row.t, value, error: None, error_kind: ErrorOrigin::Exact })
        };
        all.push(series(
            "distrusted-cells".into(),
            "cells in which the fit was not trusted".into(),
            self.fine.rows.iter().filter_map(counted).collect(),
        ));
        all.retain(|series| !series.values.is_empty());
        all
    }

    /// The fine value with `|fine - coarse| / (r^2 - 1)`, `r` the ratio of the spacings: Richardson's estimate at the
    /// order 2 that the verification measures.
    fn values(&self, pick: impl Fn(&Row) -> Option<f64>) -> Vec<Observed> {
        let ratio = self.coarse.map_or(f64::NAN, |coarse| {
            let per_axis = |run: &DensityRun| (run.n_particles as f64).sqrt() - 1.0;
            per_axis(self.fine) / per_axis(coarse)
        });
        let mut values = Vec::new();
        for row in &self.fine.rows {
            let Some(value) = pick(row) else { continue };
            let coarse = self.coarse.and_then(|run| run.at(row.t)).and_then(&pick);
            let error = coarse
                .map(|coarse| (value - coarse).abs() / (ratio * ratio - 1.0))
                .filter(|e| e.is_finite());
            let error_kind =
                if error.is_some() { ErrorOrigin::TwoResolutions } else { ErrorOrigin::Unknown };
            values.push(Observed { t: row.t, value, error, error_kind });
        }
        values
    }
}

fn sampled(
    scene: &FpkScene,
    sampling: &Sampling,
    context: &Context<'_>,
) -> Result<Outcome, RunError> {
    let system = scene.system.build().map_err(RunError::solver)?;
    let law = scene.initial.build().map_err(RunError::solver)?;
    context.progress("Monte Carlo");
    let run = monte_carlo::run(&system, &law, sampling, &asked(scene, false))
        .map_err(RunError::solver)?;
    let values = |pick: &dyn Fn(&monte_carlo::SampledRow) -> Estimate| -> Vec<Observed> {
        run.rows.iter().map(|row| sampled_value(row.t, pick(row))).collect()
    };
    let mut quantities = Vec::new();
    for (k, [a, b]) in scene.moments.iter().enumerate() {
        let (id, quantity) = (format!("moment/{a}-{b}"), moment_words(*a, *b));
        quantities.push(Series { id, quantity, unit: "", values: values(&|row| row.moments[k]) });
    }
    for (k, threshold) in scene.thresholds.iter().enumerate() {
        let (id, quantity) = (format!("exceedance/{threshold}"), format!("P(|q| > {threshold})"));
        quantities.push(Series {
            id,
            quantity,
            unit: "",
            values: values(&|row| row.exceedances[k]),
        });
    }
    let work = WorkRecord {
        path_steps: u64::try_from(run.path_steps).ok(),
        cpu_seconds: run.cpu_seconds,
        ..WorkRecord::default()
    };
    Ok(Outcome { work, stopped: None, quantities, seed: Some(sampling.seed) })
}

/// `E[q^a v^b]`, without what is to the power of zero.
fn moment_words(a: u32, b: u32) -> String {
    let factor = |name: &str, power: u32| match power {
        0 => None,
        1 => Some(name.to_owned()),
        _ => Some(format!("{name}^{power}")),
    };
    let factors: Vec<String> = [factor("q", a), factor("v", b)].into_iter().flatten().collect();
    format!("E[{}]", factors.join(" "))
}

fn sampled_value(t: f64, estimate: Estimate) -> Observed {
    let (error, error_kind) = match estimate.uncertainty {
        Uncertainty::StandardError(error) => (Some(error), ErrorOrigin::StandardError),
        Uncertainty::Bound(error) => (Some(error), ErrorOrigin::Bound),
        Uncertainty::Unknown => (None, ErrorOrigin::Unknown),
    };
    Observed { t, value: estimate.value, error, error_kind }
}

/// The second moments, and the probabilities, over time.
fn drawings(scene: &FpkScene, quantities: &[Series]) -> Result<Vec<Drawing>, RunError> {
    let second = ["moment/2-0", "moment/1-1", "moment/0-2"];
    // One estimator on the picture: the best that the method offers. All are in the result.
    let best = ["exceedance-cell/", "exceedance-log-interpolated/", "exceedance/"];
    let prefix = best
        .into_iter()
        .find(|prefix| quantities.iter().any(|series| series.id.starts_with(prefix)))
        .unwrap_or(best[0]);
    let moments = lines(quantities, |id| second.contains(&id), |observed| Some(observed.value));
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
            "P(|q| > T)",
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
        let chart = TimeSeries { words, scale, lines, references: Vec::new() };
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

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = include_str!("../../scenes/fpk/viscous_damper.json");

    /// The scene with one text in place of another, and what reading it says: message, line, column, help.
    fn mistake(from: &str, to: &str) -> (String, usize, usize, Option<String>) {
        assert!(SCENE.contains(from), "{from}");
        let file = SceneFile::from_text("scene.json", SCENE.replacen(from, to, 1));
        let error = file.and_then(|file| file.parse::<FpkScene>()).unwrap_err();
        let mistake = error.mistake().unwrap();
        (mistake.message.clone(), mistake.line, mistake.column, mistake.help.clone())
    }

    #[test]
    fn a_negative_diffusion_is_refused_where_it_stands() {
        let (message, line, column, _) =
            mistake("\"noise_intensity\": 0.2", "\"noise_intensity\": -0.2");
        assert_eq!(message, "-0.2 was given; it must be 0 or greater: it is a diffusion");
        assert_eq!((line, column), (9, 28));
    }

    #[test]
    fn a_mean_beyond_the_range_a_null_and_an_unknown_key_are_refused_where_they_stand() {
        let (message, line, ..) = mistake("\"mean\": [0, 0]", "\"mean\": [1e999, 0]");
        assert!(message.contains("1e999") && line == 18, "{message} {line}");
        let (message, line, ..) =
            mistake("\"damper_coefficient\": 0.25", "\"damper_coefficient\": null");
        assert!(message.contains("null") && line == 14, "{message} {line}");
        let (message, line, _, help) = mistake("\"damper_exponent\"", "\"damper_exponant\"");
        assert!(message.contains("damper_exponant") && line == 15, "{message} {line}");
        assert_eq!(help.as_deref(), Some("did you mean `damper_exponent`?"));
    }

    #[test]
    fn zero_particles_and_thresholds_out_of_order_are_refused_where_they_stand() {
        let (message, line, ..) = mistake("\"count\": [41, 41]", "\"count\": [0, 41]");
        assert_eq!(
            (message.as_str(), line),
            ("0 was given; it must be from 3 to 2000 particles", 19)
        );
        let (message, line, ..) = mistake("[0.1, 0.25,", "[0.3, 0.25,");
        assert_eq!(
            (message.as_str(), line),
            ("0.25 was given; it must be greater than the one before it", 22)
        );
    }
}
