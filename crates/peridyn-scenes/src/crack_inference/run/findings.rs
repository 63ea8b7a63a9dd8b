//! What the page shows of a result of the schema `crack-inference/1`: posteriors, their convergence, and whether the model fits.

use result_figures::number::{counted, percent, short};
use result_pages::{Cell, Chart, Note, Point, Series};
use scene_runs::answers::Number;
use scene_runs::report::{Report, cell, chart, given_cell, number_cells, short_cell, table};

use super::posterior_record::{AT_BOUND, Bin, Correlation, NOT_IDENTIFIED, ParameterRecord};
use super::predictive::{Band, Compared};
use super::record::{Content, Fit};
use crate::crack_inference::scene::{InferenceScene, ScaleScene};
use crate::sources::{OHAGAN_2006, PARKS_2008, VEHTARI_2021, WOOD_2010};

/// Limits of Vehtari et al. 2021, section 4.
const MOST_R_HAT: f64 = 1.01;
const LEAST_DRAWS: f64 = 400.0;
/// A misfit beyond half of what the plates themselves leave open moves a posterior visibly, if it is no accident: the sum of squares lies
/// beyond three of its standard deviations.
const MOST_MISFIT: f64 = 0.5;
const ACCIDENT: f64 = 3.0;
/// Below this share of complete cracks, the condition that the likelihood is of complete cracks counts.
const LEAST_SHARE: f64 = 0.5;

/// What the page shows beside the answers.
pub(super) fn report(scene: &InferenceScene, content: &Content) -> Report {
    let sources = vec![WOOD_2010, OHAGAN_2006, VEHTARI_2021, PARKS_2008];
    let mut report = Report { notes: notes(content), sources, ..Report::default() };
    charts(scene, content, &mut report);
    tables_of_posterior(content, &mut report);
    tables_of_model(content, &mut report);
    report.fact("plate", scene.plate.clone());
    report.fact("measured plates", content.measured.plates.to_string());
    report.fact("draws of the prediction", content.predictive.draws.len().to_string());
    report.fact("accepted proposals", percent(content.sampler.acceptance));
    let error = content.emulator.log_likelihood.error;
    report.fact("standard error of the log-likelihood", short(error));
    report.fact("seed", content.seed.to_string());
    report.counts(&content.work);
    report
}

/// What makes a posterior untrustworthy.
fn notes(content: &Content) -> Vec<Note> {
    let mut notes = Vec::new();
    let mut warn = |text: String| notes.push(Note::Warning(text));
    for ParameterRecord { key, r_hat, effective_sample_size, .. } in &content.parameters {
        if *r_hat > MOST_R_HAT {
            warn(format!("{key}: R-hat is {r_hat:.3}, above {MOST_R_HAT}: raise `sampler.draws`"));
        }
        if *effective_sample_size < LEAST_DRAWS {
            warn(format!(
                "{key}: the effective sample size is {effective_sample_size:.0}, below {LEAST_DRAWS}: raise `sampler.draws`"
            ));
        }
    }
    for fit in &content.emulator.fit {
        let freedom = fit.degrees_of_freedom as f64;
        let limit = freedom + ACCIDENT * (2.0 * freedom).sqrt();
        let is_accident = fit.chi_square.is_some_and(|chi_square| chi_square <= limit);
        if fit.over_error_of_plates > MOST_MISFIT && !is_accident {
            warn(format!(
                "no quadratic follows the {}: what it leaves is {:.1} standard errors of the plates; narrow the bounds of `parameters`",
                fit.component, fit.over_error_of_plates
            ));
        }
    }
    if let Some(share) = &content.predictive.share_inside
        && share.value + 3.0 * share.error.unwrap_or(0.0) < 0.9
    {
        warn(format!(
            "the model does not fit: {} of the measured values lie inside the predicted 90 %",
            percent(share.value)
        ));
    }
    for of in content.predictive.summaries.iter().filter(|it| it.is_outside) {
        warn(format!(
            "{}: {} of the measured values lie inside what the posterior predicts, {} to {}: check their unit, or the model is another",
            of.summary,
            percent(of.inside.value),
            short(Some(of.band.low.value)),
            short(Some(of.band.high.value))
        ));
    }
    for of in content.parameters.iter().filter(|of| of.verdict == AT_BOUND) {
        warn(format!(
            "{}: the posterior lies at a bound of its prior, which decides on its mean and width: widen the bounds in `parameters`, or the data are not of this model",
            of.key
        ));
    }
    if content.emulator.least_share < LEAST_SHARE {
        warn(format!(
            "at one point of the design only {} of the cracks come to all abscissae; the likelihood is that of these",
            percent(content.emulator.least_share)
        ));
    }
    let (absent, plates) = (content.measured.without_summaries, content.measured.plates);
    if absent > 0 {
        warn(format!(
            "{absent} of {} have no crack at all abscissae and do not count",
            counted(plates, "measured plate")
        ));
    }
    for of in content.parameters.iter().filter(|of| of.verdict == NOT_IDENTIFIED) {
        notes.push(Note::Remark(format!(
            "{}: the data say less of it than the prior; its posterior is more the prior than the data",
            of.key
        )));
    }
    notes
}

fn charts(scene: &InferenceScene, content: &Content, report: &mut Report) {
    if content.predictive.path.len() > 1 {
        let series = |name: &str, of: fn(&Band) -> &Number| Series {
            name: name.to_owned(),
            points: content.predictive.path.iter().map(|at| of(&at.band).point(at.x)).collect(),
        };
        let mut series = vec![
            series("5 %", |at| &at.low),
            series("median", |at| &at.median),
            series("95 %", |at| &at.high),
        ];
        for series in &mut series {
            series.points.sort_by(|a, b| a.x.total_cmp(&b.x));
        }
        let labels = ["x (m)".to_owned(), "height y (m)".to_owned()];
        report.charts.push(chart("Predicted path of the crack".to_owned(), labels, series));
    }
    for (i, of) in content.parameters.iter().enumerate() {
        let middle = |bin: &Bin| f64::midpoint(bin.low, bin.high);
        let posterior = of.marginal.iter().map(|bin| bin.posterior.point(middle(bin)));
        let prior = of.marginal.iter().map(|bin| {
            let point = Number::sampled(bin.prior, None).point(middle(bin));
            Point { how: String::new(), ..point }
        });
        let series = |name: &str, points: Vec<Point>| Series { name: name.to_owned(), points };
        let labels = [of.key.clone(), "density (1/unit of the key)".to_owned()];
        let series =
            vec![series("posterior", posterior.collect()), series("prior", prior.collect())];
        let chart = chart(format!("Posterior of {}", of.key), labels, series);
        let x_is_logarithmic = scene.parameters[i].scale == ScaleScene::Logarithmic;
        report.charts.push(Chart { x_is_logarithmic, ..chart });
    }
}

fn tables_of_posterior(content: &Content, report: &mut Report) {
    let row = |of: &ParameterRecord| {
        let start = [Cell::text(of.key.clone()), Cell::text(of.verdict)];
        let end = [
            cell(Some(of.r_hat)),
            short_cell(Some(of.effective_sample_size)),
            short_cell(Some(of.error_of_ensembles)),
        ];
        start
            .into_iter()
            .chain(
                [&of.mean, &of.standard_deviation, &of.contraction]
                    .into_iter()
                    .flat_map(number_cells),
            )
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
    let rows = content.parameters.iter().map(row).collect();
    report.tables.push(table("Posterior", &heads, rows));
    let rows = content.parameters.iter().flat_map(|of| {
        of.quantiles.iter().map(|quantile| {
            let start = [Cell::text(of.key.clone()), given_cell(quantile.probability)];
            start.into_iter().chain(number_cells(&quantile.number)).collect()
        })
    });
    let heads = ["parameter", "probability", "quantile", "error"];
    report.tables.push(table("Quantiles of the posterior", &heads, rows.collect()));
    if !content.correlations.is_empty() {
        let row = |it: &Correlation| {
            let start = [Cell::text(it.of.clone()), Cell::text(it.with.clone())];
            start.into_iter().chain(number_cells(&it.number)).collect()
        };
        let rows = content.correlations.iter().map(row).collect();
        let heads = ["parameter", "with", "correlation", "error"];
        report.tables.push(table("Correlations under the posterior", &heads, rows));
    }
}

/// The prediction beside the plates, and the fit of the likelihood.
fn tables_of_model(content: &Content, report: &mut Report) {
    let row = |it: &Compared| {
        let numbers = [&it.band.low, &it.band.median, &it.band.high, &it.inside]
            .into_iter()
            .flat_map(number_cells);
        [Cell::text(it.summary.clone())].into_iter().chain(numbers).collect()
    };
    let rows = content.predictive.summaries.iter().map(row).collect();
    let heads =
        ["summary", "5 %", "error", "median", "error", "95 %", "error", "plates inside", "error"];
    report.tables.push(table("Prediction and measured plates", &heads, rows));
    let row = |it: &Fit| {
        vec![
            Cell::text(it.component.clone()),
            short_cell(it.chi_square),
            short_cell(Some(it.degrees_of_freedom as f64)),
            short_cell(Some(it.misfit)),
            short_cell(Some(it.over_error_of_plates)),
        ]
    };
    let rows = content.emulator.fit.iter().map(row).collect();
    let heads = [
        "fitted by a quadratic",
        "chi-square",
        "degrees of freedom",
        "misfit",
        "misfit over the error of the plates",
    ];
    report.tables.push(table("Lack of fit of the likelihood", &heads, rows));
}

#[cfg(test)]
mod tests {
    use super::super::record::{
        EmulatorRecord, MeasuredRecord, PredictiveRecord, SamplerRecord, WorkRecord,
    };
    use super::*;

    /// A result that can be trusted.
    fn content() -> Content {
        let number = |value| Number::sampled(value, Some(0.01));
        let parameter = ParameterRecord {
            key: "a".to_owned(),
            mean: number(1.0),
            standard_deviation: number(0.1),
            quantiles: Vec::new(),
            contraction: number(0.9),
            is_identified: true,
            verdict: "identified",
            r_hat: 1.001,
            effective_sample_size: 900.0,
            error_of_ensembles: 0.01,
            marginal: Vec::new(),
        };
        let fit = Fit {
            component: "mean of the height".to_owned(),
            chi_square: Some(100.0),
            degrees_of_freedom: 4,
            misfit: 0.1,
            over_error_of_plates: 0.4,
        };
        let (points, paths, draws) = (Vec::new(), Vec::new(), Vec::new());
        let (summaries, path) = (Vec::new(), Vec::new());
        Content {
            files: Vec::new(),
            seed: 1,
            work: WorkRecord::default(),
            parameters: vec![parameter],
            correlations: Vec::new(),
            sampler: SamplerRecord {
                acceptance: 0.3,
                temperatures: vec![1.0],
                has_converged: true,
            },
            emulator: EmulatorRecord {
                log_likelihood: number(-3.0),
                least_share: 0.9,
                fit: vec![fit],
                points,
            },
            measured: MeasuredRecord { plates: 20, without_summaries: 0, paths },
            predictive: PredictiveRecord {
                draws,
                share_inside: Some(number(0.9)),
                summaries,
                path,
            },
        }
    }

    fn warnings(change: impl FnOnce(&mut Content)) -> Vec<String> {
        let mut content = content();
        change(&mut content);
        notes(&content).iter().filter(|it| it.is_warning()).map(|it| it.text().to_owned()).collect()
    }

    #[test]
    fn warnings_name_what_makes_a_posterior_untrustworthy() {
        assert_eq!(warnings(|_| ()), [""; 0]);
        let one = |words: &str, change: fn(&mut Content)| {
            let found = warnings(change);
            assert!(found.len() == 1 && found[0].contains(words), "{words}: {found:?}");
        };
        one("R-hat is 1.020, above 1.01", |it| it.parameters[0].r_hat = 1.02);
        one("the effective sample size is 399", |it| {
            it.parameters[0].effective_sample_size = 399.0;
        });
        one("the model does not fit: 10 %", |it| {
            it.predictive.share_inside = Some(Number::sampled(0.1, Some(0.01)));
        });
        one("only 40 % of the cracks come to all abscissae", |it| it.emulator.least_share = 0.4);
        one("2 of 20 measured plates have no crack at all abscissae", |it| {
            it.measured.without_summaries = 2;
        });
    }

    #[test]
    fn a_lack_of_fit_is_one_where_it_is_larger_than_the_error_of_the_plates_and_no_accident() {
        let lack = |over: f64, chi_square: f64| {
            let found = warnings(|it| {
                it.emulator.fit[0].over_error_of_plates = over;
                it.emulator.fit[0].chi_square = Some(chi_square);
            });
            found.iter().any(|text| text.contains("no quadratic follows"))
        };
        assert!(lack(0.6, 100.0) && !lack(0.4, 100.0) && !lack(0.6, 5.0));
    }
}
