//! Choice of the default scheme: FLIP and APIC with every shape function.
//!
//! Measured on a plane shock and on the energy of an explosion, against CPU time.

use std::time::Duration;

use result_figures::{Drawing, Measure, Method, Run, RunOutcome, Words, WorkPrecision, markdown};
use scenes::causes::with_causes;
use scenes::machine::Machine;
use scenes::smpm::scene::{SchemeScene, ShapeScene, TransferScene};
use serde::Serialize;

use super::fpk::{cost_in_seconds, timed};
use super::smpm::{outcome, table};
use crate::draw::ChartKind;
use crate::problems::schemes::{Explosion, FLIP, SHAPES, Shock, scheme};
use crate::problems::work::Work;
use reference_problems::context::{CaseError, Context, Profile};

pub(crate) const CHART: ChartKind = ChartKind {
    name: "smpm-scheme",
    title: "FLIP and APIC; quadratic and cubic B-splines; on a shock and an explosion, against CPU time",
    draw,
};

/// Cells of the shock (cm); the middle one is in the table.
const SHOCK_CELLS: [f64; 4] = [0.2, 0.1, 0.05, 0.025];
/// Cells of the explosion (cm).
const EXPLOSION_CELLS: [f64; 3] = [1.0, 0.5, 0.25];
/// Cells in the table.
const TABLED: (f64, f64) = (0.05, 0.5);
/// Coefficients of the linear viscosity: the current one, and two larger ones.
const VISCOSITIES: [f64; 3] = [0.06, 0.3, 1.0];
/// Number of coefficients with charts; the table contains all.
const PICTURED: usize = 2;
/// End time of the energy (us).
const TIME: f64 = 40.0;
const MOST_STEPS: u64 = 100_000;
const LONG: Duration = Duration::from_secs(3);

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
        let mut drawings = Vec::new();
        for &linear in viscosities.iter().take(PICTURED) {
            drawings.extend(pictures(linear, &shocks, &explosions)?);
        }
        drawings.push(page(&shocks, &explosions)?);
        Ok(drawings)
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
    let scene = Shock::USUAL.scene(&candidate.scheme(linear), cell)?;
    let (mut row, behind) = measured((candidate, linear, cell), || {
        Shock::USUAL.behind(&scene, &mut Work::new(MOST_STEPS))
    })?;
    if let Some(behind) = behind {
        match Shock::USUAL.slopes(&scene) {
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
    let problem = Explosion::new(&candidate.scheme(linear), cell, 2)?;
    let (mut row, energy) = measured((candidate, linear, cell), || {
        problem.energy_change(TIME, &mut Work::new(MOST_STEPS))
    })?;
    row.energy = energy;
    Ok(row)
}

/// Rows on a chart.
struct Picture<'a> {
    id: &'a str,
    title: &'a str,
    y_label: &'a str,
    subtitle: &'a str,
    rows: &'a [Measured],
    reading: fn(&Measured) -> Option<f64>,
}

fn pictures(
    linear: f64,
    shocks: &[Measured],
    explosions: &[Measured],
) -> Result<Vec<Drawing>, CaseError> {
    let of_shock = format!(
        "plane shock of 0.47 Mbar in steel, MUSL, linear viscosity {linear}, 2 particles a cell"
    );
    let of_explosion = format!(
        "TNT in water on a steel plate, {TIME} us, MUSL, linear viscosity {linear}, 2 x 2 particles a cell"
    );
    let all = [
        Picture {
            id: "pressure",
            title: "Pressure behind a shock: which scheme",
            y_label: "relative error of the mean pressure",
            subtitle: &of_shock,
            rows: shocks,
            reading: |row| Some(row.shock?.pressure),
        },
        Picture {
            id: "ripple",
            title: "Post-shock oscillation: which scheme",
            y_label: "deviation of p over particles, over p",
            subtitle: &of_shock,
            rows: shocks,
            reading: |row| Some(row.shock?.ripple),
        },
        Picture {
            id: "slope",
            title: "Derivative of the pressure behind a shock: which scheme",
            y_label: "relative error of dp/dS1",
            subtitle: &of_shock,
            rows: shocks,
            reading: |row| Some(row.shock?.slope),
        },
        Picture {
            id: "energy",
            title: "Energy of an explosion: which scheme",
            y_label: "change of the energy, over that of the start",
            subtitle: &of_explosion,
            rows: explosions,
            reading: |row| row.energy,
        },
    ];
    all.iter().map(|picture| picture.draw(linear)).collect()
}

impl Picture<'_> {
    fn draw(&self, linear: f64) -> Result<Drawing, CaseError> {
        let run = |row: &Measured| Run {
            cost: row.cpu_seconds,
            cost_error: (row.cpu_scatter > 0.0).then_some(row.cpu_scatter),
            outcome: match ((self.reading)(row), &row.failure) {
                (Some(value), _) => outcome(value.abs()),
                (None, failure) => RunOutcome::Failed {
                    reason: failure.clone().unwrap_or_else(|| "no value".into()),
                },
            },
            label: Some(format!("{}", 10.0 * row.cell)),
        };
        let of = |candidate: Candidate| {
            let is_of = |row: &&Measured| {
                row.scheme == candidate.name() && row.linear_viscosity.total_cmp(&linear).is_eq()
            };
            let runs = self.rows.iter().filter(is_of).map(run).collect();
            Method { name: candidate.name(), runs }
        };
        let series: Vec<Method> = Candidate::all().into_iter().map(of).collect();
        let words = Words {
            title: self.title.into(),
            subtitle: self.subtitle.into(),
            x_label: "CPU time of one run on one thread (s)".into(),
            y_label: self.y_label.into(),
            caption: vec![
                format!(
                    "Labels: cell (mm). Behind the shock: means over 2.5 cm of material and the time in which the front runs 1 cm."
                ),
                Machine::read().caption(),
            ],
        };
        let name = format!("smpm-scheme-{}-{}", self.id, format!("{linear:.2}").replace('.', ""));
        let rows = table(&series);
        let reading = cost_in_seconds(Measure::Relative, 0.0);
        let chart = WorkPrecision { words, reading, series };
        Ok(Drawing::work_precision(&name, &chart)?.with_rows(&rows))
    }
}

/// Column heads of the page.
const HEADS: [&str; 9] = [
    "scheme",
    "linear viscosity",
    "pressure",
    "ripple",
    "dp/dS1, mean over a window",
    "dp/dS1 at an instant",
    "CPU, shock (s)",
    "energy of the explosion",
    "CPU, explosion (s)",
];

/// All results at one cell of each problem.
fn page(shocks: &[Measured], explosions: &[Measured]) -> Result<Drawing, CaseError> {
    let mut text = format!(
        "# Which scheme\n\nA plane shock of 0.47 Mbar in steel, cells of {} mm; the energy of an explosion over {TIME} us, cells of {} mm. MUSL, quadratic viscosity 1.5, 2 particles a cell along each axis. {}\n\n",
        10.0 * TABLED.0,
        10.0 * TABLED.1,
        Machine::read().caption()
    );
    let at = |rows: &'_ [Measured], cell: f64| -> Vec<Measured> {
        rows.iter().filter(|row| row.cell.total_cmp(&cell).is_eq()).cloned().collect()
    };
    let (shocks_at, explosions_at) = (at(shocks, TABLED.0), at(explosions, TABLED.1));
    let percent = |value: Option<f64>| {
        value.map_or_else(|| "ended".to_owned(), |value| format!("{:+.2} %", 100.0 * value))
    };
    let row = |(shock, explosion): (&Measured, &Measured)| {
        let of = |reading: fn(ShockErrors) -> f64| percent(shock.shock.map(reading));
        vec![
            shock.scheme.clone(),
            shock.linear_viscosity.to_string(),
            of(|errors| errors.pressure),
            of(|errors| errors.ripple).trim_start_matches('+').to_owned(),
            of(|errors| errors.slope),
            of(|errors| errors.slope_at_an_instant),
            format!("{:.3}", shock.cpu_seconds),
            percent(explosion.energy),
            format!("{:.2}", explosion.cpu_seconds),
        ]
    };
    let rows: Vec<Vec<String>> = shocks_at.iter().zip(&explosions_at).map(row).collect();
    text.push_str(&markdown::table(&HEADS.map(str::to_owned), &rows));
    let all: Vec<Measured> = shocks.iter().chain(explosions).cloned().collect();
    Ok(Drawing::page("smpm-scheme", text, &all)?)
}
