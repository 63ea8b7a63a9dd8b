//! Charts of a run over time.

use result_figures::{Drawing, Line, Scale, TimeSeries, Words};
use scene_runs::kind::RunError;
use scene_runs::machine::Machine;

use super::observed::Observed;
use super::record::Series;

/// A chart of lines over time; the logarithmic ones are of probabilities.
pub(crate) fn over_time(
    name: &str,
    [title, subtitle, y_label]: [&str; 3],
    (scale, lines): (Scale, Vec<Line>),
) -> Result<Drawing, RunError> {
    let mut caption = vec![Machine::read().caption()];
    if scale == Scale::Log {
        caption.insert(0, "Values that are smaller than their error are left out.".to_owned());
    }
    let words = Words {
        title: title.to_owned(),
        subtitle: subtitle.to_owned(),
        x_label: "time t (s)".to_owned(),
        y_label: y_label.to_owned(),
        caption,
    };
    let chart = TimeSeries { words, scale, lines, bands: Vec::new(), references: Vec::new() };
    Drawing::time_series(name, &chart).map_err(RunError::solver)
}

/// Each series as a line; values rejected by `shown` are gaps.
pub(crate) fn lines<'a>(
    quantities: impl IntoIterator<Item = &'a Series>,
    shown: impl Fn(&Observed) -> Option<f64>,
) -> Vec<Line> {
    let line = |series: &Series| Line {
        name: series.quantity.clone(),
        points: series.values.iter().map(|observed| (observed.t, shown(observed))).collect(),
    };
    quantities.into_iter().map(line).collect()
}

/// Number of values of a line that are no gaps.
pub(crate) fn n_shown(line: &Line) -> usize {
    line.points.iter().filter(|(_, value)| value.is_some()).count()
}
