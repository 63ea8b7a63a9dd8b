//! What a run of the schema `crack-inference/1` found: posteriors, their convergence, and whether the model fits.

use result_figures::number::{counted, percent, short};
use result_pages::{Answer, Cell, Chart, Note, Point, Series, Table};
use serde::Deserialize;
use serde_json::Value;

use crate::findings::sources::{OHAGAN_2006, PARKS_2008, VEHTARI_2021, WOOD_2010};
use crate::findings::{Findings, ReadNumber, ReadQuantile, cell, given_cell, how, short_cell};

#[derive(Debug, Deserialize)]
struct Read {
    scene: Value,
    seed: u64,
    work: Value,
    parameters: Vec<ReadParameter>,
    correlations: Vec<ReadCorrelation>,
    sampler: ReadSampler,
    emulator: ReadEmulator,
    measured: ReadMeasured,
    predictive: ReadPredictive,
}

#[derive(Debug, Deserialize)]
struct ReadParameter {
    key: String,
    mean: ReadNumber,
    standard_deviation: ReadNumber,
    quantiles: Vec<ReadQuantile>,
    contraction: ReadNumber,
    is_identified: bool,
    r_hat: f64,
    effective_sample_size: f64,
    error_of_ensembles: f64,
    marginal: Vec<ReadBin>,
}

#[derive(Debug, Deserialize)]
struct ReadBin {
    low: f64,
    high: f64,
    posterior: ReadNumber,
    prior: f64,
}

#[derive(Debug, Deserialize)]
struct ReadCorrelation {
    of: String,
    with: String,
    #[serde(flatten)]
    number: ReadNumber,
}

#[derive(Debug, Deserialize)]
struct ReadSampler {
    acceptance: f64,
}

#[derive(Debug, Deserialize)]
struct ReadEmulator {
    log_likelihood: ReadNumber,
    least_share: f64,
    fit: Vec<ReadFit>,
}

#[derive(Debug, Deserialize)]
struct ReadFit {
    component: String,
    chi_square: Option<f64>,
    degrees_of_freedom: f64,
    misfit: f64,
    over_error_of_plates: f64,
}

#[derive(Debug, Deserialize)]
struct ReadMeasured {
    plates: usize,
    without_summaries: usize,
}

#[derive(Debug, Deserialize)]
struct ReadPredictive {
    draws: Vec<Value>,
    share_inside: Option<ReadNumber>,
    summaries: Vec<ReadCompared>,
    path: Vec<ReadBand>,
}

#[derive(Debug, Deserialize)]
struct ReadCompared {
    summary: String,
    inside: ReadNumber,
    low: ReadNumber,
    median: ReadNumber,
    high: ReadNumber,
}

#[derive(Debug, Deserialize)]
struct ReadBand {
    x: f64,
    low: ReadNumber,
    median: ReadNumber,
    high: ReadNumber,
}

/// Limits of Vehtari et al. 2021, section 4.
const MOST_R_HAT: f64 = 1.01;
const LEAST_DRAWS: f64 = 400.0;
/// A misfit beyond half of what the plates themselves leave open moves a posterior visibly, if it is no accident: the sum of squares lies
/// beyond three of its standard deviations.
const MOST_MISFIT: f64 = 0.5;
const ACCIDENT: f64 = 3.0;
/// Below this share of complete cracks, the condition that the likelihood is of complete cracks counts.
const LEAST_SHARE: f64 = 0.5;

/// Reads the findings from a result.
pub(super) fn findings(result: &Value) -> Result<Findings, serde_json::Error> {
    let read = Read::deserialize(result)?;
    let mut findings = Findings::default();
    answers(&read, &mut findings);
    notes(&read, &mut findings);
    charts(&read, &mut findings);
    tables_of_posterior(&read, &mut findings);
    tables_of_model(&read, &mut findings);
    findings.fact("plate", read.scene["plate"].as_str().unwrap_or_default());
    findings.fact("measured plates", read.measured.plates.to_string());
    findings.fact("draws of the prediction", read.predictive.draws.len().to_string());
    findings.fact("accepted proposals", percent(read.sampler.acceptance));
    let error = read.emulator.log_likelihood.error;
    findings.fact("standard error of the log-likelihood", short(error));
    findings.fact("seed", read.seed.to_string());
    findings.counts(&read.work);
    findings.sources = vec![WOOD_2010, OHAGAN_2006, VEHTARI_2021, PARKS_2008];
    Ok(findings)
}

fn answer(quantity: String, number: &ReadNumber, how: String) -> Answer {
    Answer {
        quantity,
        at: String::new(),
        value: number.value,
        error: number.error,
        bound: None,
        unit: String::new(),
        how,
    }
}

fn answers(read: &Read, findings: &mut Findings) {
    for of in &read.parameters {
        let verdict = if of.is_identified { "identified" } else { "not identified" };
        let spread = answer(String::new(), &of.standard_deviation, String::new());
        let how = format!("{verdict}; standard deviation {}", spread.value_and_error());
        findings.answers.push(answer(format!("{}, mean", of.key), &of.mean, how));
    }
    if let Some(share) = &read.predictive.share_inside {
        let quantity = "measured values inside the predicted 90 %".to_owned();
        findings.answers.push(answer(quantity, share, how(&share.error_kind)));
    }
    let of_parameters: usize = read.parameters.iter().map(|it| 6 + it.quantiles.len()).sum();
    findings.n_more = of_parameters + read.correlations.len() + 3 * read.predictive.path.len();
}

fn notes(read: &Read, findings: &mut Findings) {
    let mut warn = |text: String| findings.notes.push(Note::Warning(text));
    for ReadParameter { key, r_hat, effective_sample_size, .. } in &read.parameters {
        if *r_hat > MOST_R_HAT {
            warn(format!("{key}: R-hat is {r_hat:.3}, above {MOST_R_HAT}: raise `sampler.draws`"));
        }
        if *effective_sample_size < LEAST_DRAWS {
            warn(format!(
                "{key}: the effective sample size is {effective_sample_size:.0}, below {LEAST_DRAWS}: raise `sampler.draws`"
            ));
        }
    }
    for fit in &read.emulator.fit {
        let freedom = fit.degrees_of_freedom;
        let limit = freedom + ACCIDENT * (2.0 * freedom).sqrt();
        let is_accident = fit.chi_square.is_some_and(|chi_square| chi_square <= limit);
        if fit.over_error_of_plates > MOST_MISFIT && !is_accident {
            warn(format!(
                "no quadratic follows the {}: what it leaves is {:.1} standard errors of the plates; narrow the bounds of `parameters`",
                fit.component, fit.over_error_of_plates
            ));
        }
    }
    if let Some(share) = &read.predictive.share_inside
        && share.value + 3.0 * share.error.unwrap_or(0.0) < 0.9
    {
        warn(format!(
            "the model does not fit: {} of the measured values lie inside the predicted 90 %",
            percent(share.value)
        ));
    }
    if read.emulator.least_share < LEAST_SHARE {
        warn(format!(
            "at one point of the design only {} of the cracks come to all abscissae; the likelihood is that of these",
            percent(read.emulator.least_share)
        ));
    }
    let (absent, plates) = (read.measured.without_summaries, read.measured.plates);
    if absent > 0 {
        warn(format!(
            "{absent} of {} have no crack at all abscissae and do not count",
            counted(plates, "measured plate")
        ));
    }
    for of in read.parameters.iter().filter(|of| !of.is_identified) {
        findings.notes.push(Note::Remark(format!(
            "{}: the data say less of it than the prior; its posterior is more the prior than the data",
            of.key
        )));
    }
}

fn charts(read: &Read, findings: &mut Findings) {
    let point = |x: f64, y: f64, error: Option<f64>, kind: &str| Point {
        x,
        y,
        error,
        bound: None,
        how: if kind.is_empty() { String::new() } else { how(kind) },
        spread: None,
    };
    let of_number =
        |x: f64, number: &ReadNumber| point(x, number.value, number.error, &number.error_kind);
    if read.predictive.path.len() > 1 {
        let series = |name: &str, of: fn(&ReadBand) -> &ReadNumber| Series {
            name: name.to_owned(),
            points: read.predictive.path.iter().map(|at| of_number(at.x, of(at))).collect(),
        };
        let mut series = vec![
            series("5 %", |at| &at.low),
            series("median", |at| &at.median),
            series("95 %", |at| &at.high),
        ];
        for series in &mut series {
            series.points.sort_by(|a, b| a.x.total_cmp(&b.x));
        }
        findings.charts.push(Chart {
            title: "Predicted path of the crack".to_owned(),
            x_label: "x (m)".to_owned(),
            y_label: "height y (m)".to_owned(),
            is_logarithmic: false,
            x_is_logarithmic: false,
            spread: String::new(),
            series,
        });
    }
    for (i, of) in read.parameters.iter().enumerate() {
        let middle = |bin: &ReadBin| f64::midpoint(bin.low, bin.high);
        let posterior = of.marginal.iter().map(|bin| of_number(middle(bin), &bin.posterior));
        let prior = of.marginal.iter().map(|bin| point(middle(bin), bin.prior, None, ""));
        let series = |name: &str, points: Vec<Point>| Series { name: name.to_owned(), points };
        findings.charts.push(Chart {
            title: format!("Posterior of {}", of.key),
            x_label: of.key.clone(),
            y_label: "density (1/unit of the key)".to_owned(),
            is_logarithmic: false,
            x_is_logarithmic: read.scene["parameters"][i]["scale"] == "logarithmic",
            spread: String::new(),
            series: vec![
                series("posterior", posterior.collect()),
                series("prior", prior.collect()),
            ],
        });
    }
}

fn table(title: &str, heads: &[&str], rows: Vec<Vec<Cell>>) -> Table {
    Table {
        title: title.to_owned(),
        about: String::new(),
        heads: heads.iter().map(|&head| head.to_owned()).collect(),
        rows,
    }
}

fn number(it: &ReadNumber) -> [Cell; 2] {
    [cell(Some(it.value)), short_cell(it.error)]
}

fn tables_of_posterior(read: &Read, findings: &mut Findings) {
    let row = |of: &ReadParameter| {
        let verdict = if of.is_identified { "identified" } else { "not identified" };
        let start = [Cell::text(of.key.clone()), Cell::text(verdict)];
        let end = [
            cell(Some(of.r_hat)),
            short_cell(Some(of.effective_sample_size)),
            short_cell(Some(of.error_of_ensembles)),
        ];
        start
            .into_iter()
            .chain([&of.mean, &of.standard_deviation, &of.contraction].into_iter().flat_map(number))
            .chain(end)
            .collect()
    };
    let heads = [
        "parameter",
        "verdict",
        "mean",
        "error",
        "standard deviation",
        "error",
        "contraction",
        "error",
        "R-hat",
        "effective sample size",
        "error by finite ensembles, on the scale",
    ];
    let rows = read.parameters.iter().map(row).collect();
    findings.tables.push(table("Posterior", &heads, rows));
    let rows = read.parameters.iter().flat_map(|of| {
        of.quantiles.iter().map(|quantile| {
            let start = [Cell::text(of.key.clone()), given_cell(quantile.probability)];
            start.into_iter().chain(number(&quantile.number)).collect()
        })
    });
    let heads = ["parameter", "probability", "quantile", "error"];
    findings.tables.push(table("Quantiles of the posterior", &heads, rows.collect()));
    if !read.correlations.is_empty() {
        let row = |it: &ReadCorrelation| {
            let start = [Cell::text(it.of.clone()), Cell::text(it.with.clone())];
            start.into_iter().chain(number(&it.number)).collect()
        };
        let rows = read.correlations.iter().map(row).collect();
        let heads = ["parameter", "with", "correlation", "error"];
        findings.tables.push(table("Correlations under the posterior", &heads, rows));
    }
}

/// The prediction beside the plates, and the fit of the likelihood.
fn tables_of_model(read: &Read, findings: &mut Findings) {
    let row = |it: &ReadCompared| {
        let numbers = [&it.low, &it.median, &it.high, &it.inside].into_iter().flat_map(number);
        [Cell::text(it.summary.clone())].into_iter().chain(numbers).collect()
    };
    let rows = read.predictive.summaries.iter().map(row).collect();
    let heads =
        ["summary", "5 %", "error", "median", "error", "95 %", "error", "plates inside", "error"];
    findings.tables.push(table("Prediction and measured plates", &heads, rows));
    let row = |it: &ReadFit| {
        vec![
            Cell::text(it.component.clone()),
            short_cell(it.chi_square),
            short_cell(Some(it.degrees_of_freedom)),
            short_cell(Some(it.misfit)),
            short_cell(Some(it.over_error_of_plates)),
        ]
    };
    let rows = read.emulator.fit.iter().map(row).collect();
    let heads = [
        "fitted by a quadratic",
        "chi-square",
        "degrees of freedom",
        "misfit",
        "misfit over the error of the plates",
    ];
    findings.tables.push(table("Lack of fit of the likelihood", &heads, rows));
}
