//! Tables and figures of the source documents, beside ours.

use std::fmt::Write as _;

use result_figures::Drawing;
use serde::Serialize;

use super::papers_figures::{density_of_canor_denoel, moments_of_canor_denoel, of_chen};
use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::smpm::published::{
    MeanAndVariance, PrintedRow, Solved, TABLES, by_series, one_time, printed,
};

pub(crate) const CHART: ChartKind = ChartKind {
    name: "papers",
    title: "Tables 6 to 8 and figures 9 to 12 of Chen et al. 2019, figures 1b and 2a of Canor & Denoël 2013, beside ours",
    draw,
};

/// Candidates for the one time (us).
const TIMES: [f64; 7] = [8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0];
const COEFFICIENTS_OF_VARIATION: [f64; 2] = [0.1, 0.15];

/// A row of the page: (value, standard error), means in Mbar, variances in Mbar^2.
#[derive(Debug, Serialize)]
struct Row {
    quantity: &'static str,
    gauge: String,
    coefficient_of_variation: f64,
    printed_method: [f64; 2],
    printed_monte_carlo: [f64; 2],
    frozen: MeanAndVariance,
    propagated: MeanAndVariance,
    sampled: MeanAndVariance,
    /// Smallest and largest of the frozen form over all times.
    range: [[f64; 2]; 2],
}

#[derive(Debug, Serialize)]
struct Page {
    time: f64,
    n_samples: u64,
    rows: Vec<Row>,
}

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let n_samples = if context.profile == Profile::Quick { 20 } else { 200 };
    let mut all = Vec::new();
    for cv in COEFFICIENTS_OF_VARIATION {
        context.progress(&format!("coefficient of variation {cv}"));
        all.push((cv, Solved::new(cv, &TIMES, n_samples)?));
    }
    let time = one_time(&all[0].1, all[0].0, &TIMES)?;
    let mut rows = Vec::new();
    for printed in printed()? {
        let of = |(cv, _): &&(f64, Solved)| (cv - printed.coefficient_of_variation).abs() < 1e-9;
        let (_, solved) = all.iter().find(of).ok_or("a coefficient of variation not solved")?;
        rows.push(row(solved, printed, time)?);
    }
    let page = Page { time, n_samples, rows };
    let mut drawings = vec![Drawing::page("smpm-published-tables", text(&page)?, &page)?];
    context.progress("figures");
    drawings.extend(of_chen(&all, &TIMES, time)?);
    drawings.push(moments_of_canor_denoel()?);
    drawings.extend(density_of_canor_denoel()?);
    Ok(drawings)
}

fn row(solved: &Solved, printed: PrintedRow, time: f64) -> Result<Row, CaseError> {
    let response = solved.response(printed.table, &printed.gauge, time)?;
    let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for other in TIMES {
        let response = solved.response(printed.table, &printed.gauge, other)?;
        for (ends, (value, _)) in range.iter_mut().zip(by_series(&solved.frozen[response])) {
            *ends = [ends[0].min(value), ends[1].max(value)];
        }
    }
    Ok(Row {
        quantity: TABLES[printed.table].1,
        gauge: printed.gauge,
        coefficient_of_variation: printed.coefficient_of_variation,
        printed_method: printed.method,
        printed_monte_carlo: printed.monte_carlo,
        frozen: by_series(&solved.frozen[response]),
        propagated: by_series(&solved.propagated[response]),
        sampled: solved.by_samples(response)?,
        range,
    })
}

/// Both moments as tables, in the units of the print.
fn text(page: &Page) -> Result<String, std::fmt::Error> {
    let mut text = format!(
        "# Tables 6 to 8 of Chen et al. 2019 beside ours\n\n\
        Written by `cargo xtask chart papers --record`. Ours are of the built-in contact explosion with the strength that \
        reproduces Table 6, all at {} us.\nThe paper states no time: of the whole microseconds from 8 to 14 it is the one at \
        which the mean of σ_y is nearest to Table 6 at all four gauges together.\n\n\
        Frozen: formulas at the local state, corrected, with its range from 8 to 14 us. Run: derivatives of the whole run. \
        Samples: {} whole runs with control variate.\n",
        page.time, page.n_samples
    );
    for (k, (moment, unit, scale)) in
        [("Mean", "1e-2 Mbar", 1e2), ("Variance", "1e-6 Mbar^2", 1e6)].into_iter().enumerate()
    {
        write!(
            text,
            "\n## {moment} ({unit})\n\n| | gauge | coefficient of variation | print, method | frozen | 8 to 14 us | run | print, Monte Carlo | \
            samples |\n|---|---|---|---|---|---|---|---|---|\n"
        )?;
        for row in &page.rows {
            writeln!(
                text,
                "| {} | {} | {} | {:.4} | {:.4} | {:.3} to {:.3} | {:.4} | {:.4} | {:.4} ± {:.4} |",
                row.quantity,
                row.gauge,
                row.coefficient_of_variation,
                scale * row.printed_method[k],
                scale * row.frozen[k].0,
                scale * row.range[k][0],
                scale * row.range[k][1],
                scale * row.propagated[k].0,
                scale * row.printed_monte_carlo[k],
                scale * row.sampled[k].0,
                scale * row.sampled[k].1,
            )?;
        }
    }
    Ok(text)
}
