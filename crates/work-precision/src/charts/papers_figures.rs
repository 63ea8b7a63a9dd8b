//! Figures of the source documents: the same quantities over the same axes, ours beside what is printed.

use fpk_sph::{Config, DEFAULT_MOST_STEPS, InitialLattice, Method};
use result_figures::{
    Band, Drawing, Line, Plane, ReferencePoint, ReferencePoints, Scale, TimeSeries, Words,
};
use scenes::fpk::density::{self, Demand, DensityRun, Requested};
use scenes::fpk::plane_density::{PlaneDensity, plane_density};
use scenes::machine::Machine;

use reference_problems::context::CaseError;
use reference_problems::fpk::methods::papers_config;
use reference_problems::fpk::problem::{Problem, bouc_wen};
use reference_problems::smpm::published::{Solved, TABLES, by_series, printed};

/// A figure of Chen et al. 2019, and the table and the gauge of its values.
#[derive(Clone, Copy)]
struct Figure {
    number: u32,
    table: usize,
    gauge: &'static str,
}

const OF_CHEN: [Figure; 4] = [
    Figure { number: 9, table: 0, gauge: "H" },
    Figure { number: 10, table: 0, gauge: "I" },
    Figure { number: 11, table: 1, gauge: "G" },
    Figure { number: 12, table: 2, gauge: "G" },
];

/// Moment, unit, factor from Mbar.
const MOMENTS: [(&str, &str, f64); 2] =
    [("mean", "1e-2 Mbar", 1e2), ("variance", "1e-6 Mbar^2", 1e6)];

/// Figures 9 to 12 of Chen et al. 2019: mean and variance at a gauge over time, at both coefficients of variation.
pub(super) fn of_chen(
    all: &[(f64, Solved)],
    times: &[f64],
    time: f64,
) -> Result<Vec<Drawing>, CaseError> {
    let mut drawings = Vec::new();
    for figure in OF_CHEN {
        for moment in 0..2 {
            drawings.push(figure_of_chen(all, times, time, figure, moment)?);
        }
    }
    Ok(drawings)
}

fn figure_of_chen(
    all: &[(f64, Solved)],
    times: &[f64],
    time: f64,
    figure: Figure,
    moment: usize,
) -> Result<Drawing, CaseError> {
    let Figure { number, table, gauge } = figure;
    let (word, unit, factor) = MOMENTS[moment];
    let (mut lines, mut references) = (Vec::new(), Vec::new());
    for (cv, solved) in all {
        let (mut run, mut frozen, mut samples) = (Vec::new(), Vec::new(), Vec::new());
        for &t in times {
            let response = solved.response(table, gauge, t)?;
            run.push((t, Some(factor * by_series(&solved.propagated[response])[moment].0)));
            frozen.push((t, Some(factor * by_series(&solved.frozen[response])[moment].0)));
            let (value, error) = solved.by_samples(response)?[moment];
            samples.push(ReferencePoint { x: t, y: factor * value, error: Some(factor * error) });
        }
        lines.push(Line { name: format!("derivatives of the run, {cv}"), points: run });
        lines.push(Line { name: format!("frozen form, {cv}"), points: frozen });
        references.push(ReferencePoints { name: format!("samples, {cv}"), points: samples });
    }
    let rows = printed()?.into_iter().filter(|row| row.table == table && row.gauge == gauge);
    let at_time = |y: f64| ReferencePoint { x: time, y: factor * y, error: None };
    references.push(ReferencePoints {
        name: "printed, method; no time given".into(),
        points: rows.map(|row| at_time(row.method[moment])).collect(),
    });
    let symbol = TABLES[table].1;
    let data = TimeSeries {
        words: Words {
            title: format!("Figure {number} of Chen et al. 2019: {word} of {symbol} at {gauge}"),
            subtitle: "contact explosion, strength as printed; A, B, n, C, m normal, coefficients of variation 0.1 and 0.15".into(),
            x_label: "time (us)".into(),
            y_label: format!("{word} of {symbol} ({unit})"),
            caption: vec![
                format!("Printed values of Tables 6 to 8 are drawn at {time} us, the one time at which ours are compared with all of them; curves of the print are not available."),
                Machine::read().caption(),
            ],
        },
        scale: Scale::Linear,
        lines,
        bands: Vec::<Band>::new(),
        references,
    };
    Ok(Drawing::time_series(&format!("papers-chen-figure-{number}-{word}"), &data)?)
}

/// Figure 1b of Canor and Denoël 2013: second moments of the oscillator with a viscous damper over time.
pub(super) fn moments_of_canor_denoel() -> Result<Drawing, CaseError> {
    const TIMES: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let problem = Problem::viscous_damper()?;
    let powers = [[2, 0], [0, 2]];
    let asked = Requested {
        times: (1..=60).map(|tenth| f64::from(tenth) / 10.0).collect(),
        powers: powers.to_vec(),
        demand: Demand::displacement(),
        thresholds: vec![0.5],
        kinks: Vec::new(),
        cells: false,
    };
    let printed = problem.density(&papers_config(problem.system.period()), &asked)?;
    let better = problem.density(&problem.density_config(1.0)?, &asked)?;
    let line = |run: &DensityRun, of: &str, k: usize| Line {
        name: format!("{}, {of}", ["E[q^2]", "E[v^2]"][k]),
        points: run.rows.iter().map(|row| (row.t, Some(row.moments[k]))).collect(),
    };
    let mut lines = Vec::new();
    for k in 0..2 {
        lines.push(line(&printed, "method as printed", k));
        lines.push(line(&better, "log-density fit", k));
    }
    let references = powers.iter().enumerate().map(|(k, powers)| {
        let point = |&t: &f64| {
            let reference = problem.reference.moment(*powers, t)?;
            Some(ReferencePoint { x: t, y: reference.value, error: reference.error })
        };
        ReferencePoints {
            name: format!("{}, independent reference", ["E[q^2]", "E[v^2]"][k]),
            points: TIMES.iter().filter_map(point).collect(),
        }
    });
    let data = TimeSeries {
        words: Words {
            title: "Figure 1b of Canor and Denoël 2013: second moments of the damped building"
                .into(),
            subtitle:
                "viscous damper, 50 x 33 particles, Courant number 0.8, support of 2.5 spacings"
                    .into(),
            x_label: "time (s)".into(),
            y_label: "E[q^2] (m^2), E[v^2] (m^2/s^2)".into(),
            caption: vec![
                "Curves of the print are not available; its Monte Carlo has 100,000 samples."
                    .into(),
                Machine::read().caption(),
            ],
        },
        scale: Scale::Linear,
        lines,
        bands: Vec::new(),
        references: references.collect(),
    };
    Ok(Drawing::time_series("papers-canor-denoel-figure-1b", &data)?)
}

/// States of the oscillator with hysteresis, and the planes on which figure 2a projects its density.
const STATES: [&str; 3] = ["q", "v", "z"];
const PLANES: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];

/// Figure 2a of Canor and Denoël 2013: projections of the density of the oscillator with hysteresis at its largest
/// variance. The number of particles is the printed one; the method is ours, since the printed one ends at t = 2.38.
pub(super) fn density_of_canor_denoel() -> Result<Vec<Drawing>, CaseError> {
    const TIME: f64 = 3.6;
    const COUNT: usize = 21;
    /// Half the edge of the lattice in each state: four standard deviations.
    const HALF_WIDTH: f64 = 0.2;
    /// Of the kernel that smooths a picture, in standard deviations: 0.6 spacings of the lattice.
    const BANDWIDTH: f64 = 0.6 * 8.0 / (COUNT as f64 - 1.0);
    let (system, law, _) = bouc_wen()?;
    let config = Config {
        method: Method::FlowMapFit,
        lattice: InitialLattice::Rectangle { half_width: [HALF_WIDTH; 3], count: [COUNT; 3] },
        reference_period: system.period(),
        most_steps: DEFAULT_MOST_STEPS,
    };
    let asked = Requested {
        times: vec![TIME],
        powers: vec![[2, 0, 0]],
        demand: Demand::displacement(),
        thresholds: vec![0.5],
        kinks: Vec::new(),
        cells: false,
    };
    let mut planes: Vec<Option<PlaneDensity>> = Vec::new();
    let run = density::run_on(system, &law, &config, &asked, |at, _| {
        let (positions, masses) = (at.positions(), at.masses());
        planes = PLANES.map(|plane| plane_density(positions, masses, plane, BANDWIDTH)).into();
    })?;
    if let Some(error) = run.stopped {
        return Err(error.into());
    }
    let draw = |([across, up], density): ([usize; 2], Option<PlaneDensity>)| {
        let [across, up] = [STATES[across], STATES[up]];
        let density = density
            .ok_or_else(|| format!("the cloud does not span the plane of {across} and {up}"))?;
        let chart = Plane {
            words: Words {
                title: format!(
                    "Figure 2a of Canor and Denoël 2013: density of {across} and {up} at t = {TIME} s"
                ),
                subtitle: "hysteresis of Bouc and Wen, 9,261 particles as printed, flow-map fit"
                    .into(),
                x_label: across.to_owned(),
                y_label: up.to_owned(),
                caption: vec![
                    "The printed method ends at t = 2.38 s with these particles, so ours is drawn."
                        .into(),
                    format!(
                        "Masses of the particles, smoothed by a normal kernel of {BANDWIDTH:.2} standard deviations, which spreads z beyond its limits of -1 and 1."
                    ),
                    Machine::read().caption(),
                ],
            },
            x: density.x,
            y: density.y,
            values: density.values,
        };
        Ok(Drawing::plane(&format!("papers-canor-denoel-figure-2a-{across}-{up}"), &chart)?)
    };
    PLANES.into_iter().zip(planes).map(draw).collect()
}
