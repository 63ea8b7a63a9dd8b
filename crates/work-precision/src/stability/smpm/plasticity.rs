//! Plastic strain caused by cell-crossing noise, at gauge H of an explosion.

use rayon::prelude::*;
use result_figures::{Drawing, Line, Scale, TimeSeries, Words};
use scenes::smpm::scene::TransferScene;

use crate::context::CaseError;
use crate::problems::smpm::schemes::{Explosion, FLIP, SHAPES, scheme};

/// Edges of cells (cm).
const CELLS: [f64; 2] = [0.5, 0.25];

/// Runs to `end` (us) and draws the chart.
pub(super) fn chart(end: f64) -> Result<Drawing, CaseError> {
    let times: Vec<f64> = (1..=60).map(|k| end * f64::from(k) / 60.0).collect();
    let [_, _, quadratic, cubic] = SHAPES;
    let mut runs: Vec<(String, _, f64)> = SHAPES
        .iter()
        .map(|&(shape, name)| (format!("{name}, FLIP"), scheme(shape, FLIP, 0.06), CELLS[0]))
        .collect();
    for (shape, name) in [quadratic, cubic] {
        runs.push((format!("{name}, APIC"), scheme(shape, TransferScene::Apic, 0.06), CELLS[0]));
    }
    for (shape, name) in [SHAPES[0], quadratic, cubic] {
        let name = format!("{name}, FLIP, cells of 2.5 mm");
        runs.push((name, scheme(shape, FLIP, 0.06), CELLS[1]));
    }
    let follow = |(name, scheme, cell): &(String, _, f64)| {
        let (strains, failure) = Explosion::new(scheme, *cell, 2)?.plastic_strain(&times)?;
        let points = times.iter().enumerate().map(|(k, &t)| (t, strains.get(k).copied()));
        let last = strains.last().copied().unwrap_or(0.0);
        let until = times.get(strains.len().wrapping_sub(1)).copied().unwrap_or(0.0);
        let end = failure.map_or_else(String::new, |error| format!("; {error}"));
        let row = format!("  {name:36} {last:.3} at {until:.1} us{end}");
        Ok((Line { name: name.clone(), points: points.collect() }, row))
    };
    let followed: Result<Vec<(Line, String)>, String> = runs
        .par_iter()
        .map(|run| follow(run).map_err(|error: CaseError| error.to_string()))
        .collect();
    let (lines, rows): (Vec<Line>, Vec<String>) = followed?.into_iter().unzip();
    let chart = TimeSeries {
        words: Words {
            title: "Noise of crossed cells feeds plasticity".into(),
            subtitle: "plastic strain at gauge H of a steel plate under an explosion; MUSL, linear viscosity 0.06".into(),
            x_label: "time (us)".into(),
            y_label: "equivalent plastic strain".into(),
            caption: vec![
                "Cells of 5 mm and 2 x 2 particles but where it says otherwise. What hats have above splines on the same grid is noise: a force that jumps where a particle crosses a cell makes steel yield. Between grids the strain has not converged.".into(),
            ],
        },
        scale: Scale::Linear,
        lines,
        bands: Vec::new(),
        references: Vec::new(),
    };
    Ok(Drawing { table: rows.join("\n"), ..Drawing::time_series("smpm-plastic-noise", &chart)? })
}
