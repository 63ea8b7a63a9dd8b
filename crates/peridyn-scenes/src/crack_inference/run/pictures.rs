//! Pictures of an inference: measured paths over their prediction, and marginal posteriors over their priors.

use result_figures::{Band, Drawing, Line, Scale, TimeSeries, Words};
use scene_runs::kind::RunError;
use scene_runs::machine::Machine;

use super::posterior_record::{Bin, ParameterRecord};
use super::predictive::PathBand;
use crate::crack_inference::measured::MeasuredPlate;

/// Millimetres per metre.
const MM: f64 = 1e3;

/// `predictive.svg`: the measured paths over the band of predicted ones; none without paths.
pub(super) fn predictive(
    title: &str,
    plates: &[MeasuredPlate],
    path: &[PathBand],
    (draws, realisations): (usize, u64),
) -> Result<Option<Drawing>, RunError> {
    if path.is_empty() {
        return Ok(None);
    }
    let gap = |plate: &MeasuredPlate| plate.path.last().map(|end| (MM * end[0], None));
    let points = |plate: &MeasuredPlate| -> Vec<(f64, Option<f64>)> {
        let points = plate.path.iter().map(|&[x, y]| (MM * x, Some(MM * y)));
        points.chain(gap(plate)).collect()
    };
    let measured: Vec<_> = plates.iter().flat_map(points).collect();
    let median = path.iter().map(|at| (MM * at.x, Some(MM * at.band.median.value))).collect();
    let ends = |at: &PathBand| (MM * at.x, MM * at.band.low.value, MM * at.band.high.value);
    let mut lines = vec![Line { name: "median of predicted paths".into(), points: median }];
    if !measured.is_empty() {
        lines.push(Line { name: format!("{} measured paths", plates.len()), points: measured });
    }
    let chart = TimeSeries {
        words: Words {
            title: title.to_owned(),
            subtitle: "Measured crack paths over the posterior prediction; shaded: from 5 % to 95 % of predicted paths".into(),
            x_label: "x (mm)".into(),
            y_label: "height y (mm)".into(),
            caption: vec![
                format!("{draws} draws of the posterior with {realisations} realisations each, measured with the errors of the plates."),
                "Heights where cracks first pass an abscissa, as far as half of them come.".into(),
                Machine::read().caption(),
            ],
        },
        scale: Scale::Linear,
        lines,
        bands: vec![Band { points: path.iter().map(ends).collect() }],
        references: Vec::new(),
    };
    Drawing::time_series("predictive", &chart).map(Some).map_err(RunError::solver)
}

/// `posterior-1.svg`: the marginal posterior of a parameter over its prior.
pub(super) fn marginal(
    title: &str,
    (number, parameter): (usize, &ParameterRecord),
) -> Result<Drawing, RunError> {
    let middle = |bin: &Bin| f64::midpoint(bin.low, bin.high);
    let bins = || parameter.marginal.iter();
    let posterior = bins().map(|bin| (middle(bin), Some(bin.posterior.value))).collect();
    let prior = bins().map(|bin| (middle(bin), Some(bin.prior))).collect();
    let error = |bin: &Bin| {
        let error = bin.posterior.error.unwrap_or(0.0);
        (middle(bin), (bin.posterior.value - error).max(0.0), bin.posterior.value + error)
    };
    let chart = TimeSeries {
        words: Words {
            title: title.to_owned(),
            subtitle: format!(
                "Marginal posterior of {}; shaded: one standard error",
                parameter.key
            ),
            x_label: parameter.key.clone(),
            y_label: "density (1/unit of the key)".into(),
            caption: vec![
                format!(
                    "Shares of the draws in {} intervals of equal width on the scale of the parameter.",
                    parameter.marginal.len()
                ),
                Machine::read().caption(),
            ],
        },
        scale: Scale::Linear,
        lines: vec![
            Line { name: "posterior".into(), points: posterior },
            Line { name: "prior".into(), points: prior },
        ],
        bands: vec![Band { points: bins().map(error).collect() }],
        references: Vec::new(),
    };
    let name = format!("posterior-{number}");
    Drawing::time_series(&name, &chart).map_err(RunError::solver)
}
