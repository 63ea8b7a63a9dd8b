//! Choice of the default scheme: FLIP and APIC with every shape function.
//!
//! Measured on a plane shock and on the energy of an explosion: a page with all cells, and two charts against CPU time.

use result_figures::{Drawing, Measure, Method, RunOutcome, Words, WorkPrecision, markdown};
use scenes::causes::with_causes;
use scenes::machine::Machine;
use scenes::smpm::scene::{SchemeScene, ShapeScene, TransferScene};
use serde::Serialize;
use smpm::Simulation;

use super::cost::{LONG, cost_in_seconds, outcome, run, table, timed};
use crate::draw::ChartKind;
use crate::problems::shock::{self, FLIP, SHAPES, at_centre, scheme};
use crate::problems::work::Work;
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::smpm::problems::{Problem, experiment};

pub(crate) const CHART: ChartKind = ChartKind {
    name: "smpm-scheme",
    title: "FLIP and APIC; quadratic and cubic B-splines; on a shock and an explosion, against CPU time",
    draw,
};

/// Cells of the shock (cm).
const SHOCK_CELLS: [f64; 4] = [0.2, 0.1, 0.05, 0.025];
/// Cells of the explosion (cm).
const EXPLOSION_CELLS: [f64; 3] = [1.0, 0.5, 0.25];
/// Coefficients of the linear viscosity: the current one, and two larger ones.
const VISCOSITIES: [f64; 3] = [0.06, 0.3, 1.0];
/// The coefficient of the charts; the page has all.
const PICTURED: f64 = 0.3;
/// End time of the energy (us).
const TIME: f64 = 40.0;
const MOST_STEPS: u64 = 100_000;

/// A shape function with a transfer.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    shape: ShapeScene,
    shape_name: &'static str,
    transfer: TransferScene,
}

impl Candidate {
    /// Every shape function with every transfer.
    fn all() -> Vec<Self> {
        let with = |(shape, shape_name)| {
            [FLIP, TransferScene::Apic].map(|transfer| Self { shape, shape_name, transfer })
        };
        SHAPES.into_iter().flat_map(with).collect()
    }

    fn name(self) -> String {
        let transfer = if self.transfer == FLIP { "FLIP" } else { "APIC" };
        format!("{}, {transfer}", self.shape_name)
    }

    fn scheme(self, linear: f64) -> SchemeScene {
        scheme(self.shape, self.transfer, linear)
    }
}

/// Results of a candidate at a cell; signed errors, or why they are missing.
#[derive(Debug, Clone, Serialize)]
struct Measured {
    scheme: String,
    linear_viscosity: f64,
    cell: f64,
    cpu_seconds: f64,
    cpu_scatter: f64,
    shock: Option<ShockErrors>,
    energy: Option<f64>,
    failure: Option<String>,
}

#[derive(Debug, Clone, Copy, Serialize)]
struct ShockErrors {
    pressure: f64,
    ripple: f64,
    slope: f64,
    slope_at_an_instant: f64,
}

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let is_quick = context.profile == Profile::Quick;
    let (shock_cells, explosion_cells, viscosities): (&[f64], &[f64], &[f64]) = if is_quick {
        (&SHOCK_CELLS[1..3], &EXPLOSION_CELLS[..2], &VISCOSITIES[..2])
    } else {
        (&SHOCK_CELLS, &EXPLOSION_CELLS, &VISCOSITIES)
    };
    // One thread, so CPU time is that of one core.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| {
        let (mut shocks, mut explosions) = (Vec::new(), Vec::new());
        for &linear in viscosities {
            for candidate in Candidate::all() {
                context.progress(&format!("{}, linear viscosity {linear}", candidate.name()));
                for &cell in shock_cells {
                    shocks.push(shock(candidate, linear, cell)?);
                }
                for &cell in explosion_cells {
                    explosions.push(explosion(candidate, linear, cell)?);
                }
            }
        }
        let ripple = Picture {
            name: "smpm-scheme-ripple-030",
            title: "Post-shock oscillation: which scheme",
            subtitle: "plane shock of 0.47 Mbar in steel, linear viscosity 0.3, 2 particles a cell",
            y_label: "deviation of p over particles, over p",
            reading: |row| Some(row.shock?.ripple),
        };
        let energy = Picture {
            name: "smpm-scheme-energy-030",
            title: "Energy of an explosion: which scheme",
            subtitle: "TNT in water on a steel plate, 40 us, linear viscosity 0.3, 2 x 2 particles a cell",
            y_label: "change of the energy, over that of the start",
            reading: |row| row.energy,
        };
        Ok(vec![ripple.draw(&shocks)?, energy.draw(&explosions)?, page(&shocks, &explosions)?])
    })
}

/// A timed run with any outcome.
fn measured<T>(
    (candidate, linear, cell): (Candidate, f64, f64),
    mut run: impl FnMut() -> Result<T, CaseError>,
) -> Result<(Measured, Option<T>), CaseError> {
    let (found, cpu_seconds, cpu_scatter) = timed(LONG, || Ok(run()))?;
    let failure = found.as_ref().err().map(|error| with_causes(error.as_ref()));
    let scheme = candidate.name();
    let row = Measured {
        scheme,
        linear_viscosity: linear,
        cell,
        cpu_seconds,
        cpu_scatter,
        shock: None,
        energy: None,
        failure,
    };
    Ok((row, found.ok()))
}

fn shock(candidate: Candidate, linear: f64, cell: f64) -> Result<Measured, CaseError> {
    let scene = shock::scene(&candidate.scheme(linear), cell)?;
    let (mut row, behind) =
        measured((candidate, linear, cell), || shock::behind(&scene, &mut Work::new(MOST_STEPS)))?;
    if let Some(behind) = behind {
        match shock::slopes(&scene) {
            Ok([slope, at_instant]) => {
                row.shock = Some(ShockErrors {
                    pressure: behind.pressure,
                    ripple: behind.ripple,
                    slope: slope - 1.0,
                    slope_at_an_instant: at_instant - 1.0,
                });
            }
            Err(error) => row.failure = Some(with_causes(error.as_ref())),
        }
    }
    Ok(row)
}

fn explosion(candidate: Candidate, linear: f64, cell: f64) -> Result<Measured, CaseError> {
    let mut scene = Problem::ContactExplosion.scene()?;
    scene.scheme = candidate.scheme(linear);
    (scene.grid.cell, scene.grid.particles_per_cell) = (cell, 2);
    let experiment = experiment::<2>(&scene)?;
    let energy = |run: &Simulation<f64, 2>| run.ledger().kinetic + run.ledger().internal;
    let (mut row, change) = measured((candidate, linear, cell), || {
        let mut run = at_centre(&experiment, &scene)?;
        let before = energy(&run);
        let outcome = run.advance_to(TIME);
        Work::new(MOST_STEPS).spend(run.n_steps())?;
        outcome?;
        Ok(energy(&run) / before - 1.0)
    })?;
    row.energy = change;
    Ok(row)
}

/// A chart of one error of all candidates over CPU time.
struct Picture {
    name: &'static str,
    title: &'static str,
    subtitle: &'static str,
    y_label: &'static str,
    reading: fn(&Measured) -> Option<f64>,
}

impl Picture {
    /// From the rows at the pictured viscosity.
    fn draw(&self, rows: &[Measured]) -> Result<Drawing, CaseError> {
        let run = |row: &Measured| {
            let outcome = (self.reading)(row).map_or_else(
                || RunOutcome::Failed { reason: row.failure.clone().unwrap_or_default() },
                |value| outcome(value.abs()),
            );
            let label = Some(format!("{}", 10.0 * row.cell));
            run((row.cpu_seconds, row.cpu_scatter), outcome, label)
        };
        let of = |candidate: Candidate| {
            let name = candidate.name();
            let is_of = |row: &&Measured| {
                row.scheme == name && row.linear_viscosity.total_cmp(&PICTURED).is_eq()
            };
            let runs = rows.iter().filter(is_of).map(run).collect();
            Method { name, runs }
        };
        let series: Vec<Method> = Candidate::all().into_iter().map(of).collect();
        let words = Words {
            title: self.title.into(),
            subtitle: self.subtitle.into(),
            x_label: "CPU time of one run on one thread (s)".into(),
            y_label: self.y_label.into(),
            caption: vec!["Labels: cell (mm).".into(), Machine::read().caption()],
        };
        let rows = table(&series);
        let reading = cost_in_seconds(Measure::Relative, 0.0);
        let chart = WorkPrecision { words, reading, series };
        Ok(Drawing::work_precision(self.name, &chart)?.with_rows(&rows))
    }
}

/// All results, a table for each problem.
fn page(shocks: &[Measured], explosions: &[Measured]) -> Result<Drawing, CaseError> {
    let percent = |value: Option<f64>| {
        value.map_or_else(|| "ended".to_owned(), |value| format!("{:+.2} %", 100.0 * value))
    };
    let heads = |of: &[&str]| -> Vec<String> {
        let first = ["scheme", "linear viscosity", "cell (mm)"];
        first.iter().chain(of).chain(&["CPU (s)"]).map(|&head| head.to_owned()).collect()
    };
    let row = |run: &Measured, of: Vec<String>| -> Vec<String> {
        let first =
            [run.scheme.clone(), run.linear_viscosity.to_string(), (10.0 * run.cell).to_string()];
        let seconds = format!("{:.3} ± {:.3}", run.cpu_seconds, run.cpu_scatter);
        first.into_iter().chain(of).chain([seconds]).collect()
    };
    let of_shock = |run: &Measured| {
        let of = |reading: fn(ShockErrors) -> f64| percent(run.shock.map(reading));
        let ripple = of(|errors| errors.ripple).trim_start_matches('+').to_owned();
        let slopes = [of(|errors| errors.slope), of(|errors| errors.slope_at_an_instant)];
        let [over_window, at_instant] = slopes;
        row(run, vec![of(|errors| errors.pressure), ripple, over_window, at_instant])
    };
    let shock_heads =
        heads(&["pressure", "ripple", "dp/dS1, mean over a window", "dp/dS1 at an instant"]);
    let shock_rows: Vec<Vec<String>> = shocks.iter().map(of_shock).collect();
    let explosion_rows: Vec<Vec<String>> =
        explosions.iter().map(|run| row(run, vec![percent(run.energy)])).collect();
    let text = format!(
        "# Which scheme\n\nMUSL, quadratic viscosity 1.5, 2 particles a cell along each axis, one thread. {}\n\n## A plane shock of 0.47 Mbar in steel\n\n\
         Means over 2.5 cm of material behind the front and the time in which it runs 1 cm.\n\n{}\n## The energy of an explosion over {TIME} us\n\n\
         Change of the energy, over that of the start.\n\n{}",
        Machine::read().caption(),
        markdown::table(&shock_heads, &shock_rows),
        markdown::table(&heads(&["energy"]), &explosion_rows)
    );
    let all: Vec<Measured> = shocks.iter().chain(explosions).cloned().collect();
    Ok(Drawing::page("smpm-scheme", text, &all)?)
}
