//! What a chart shows, as plain data.

use serde::{Deserialize, Serialize};

/// Words around a chart.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Words {
    /// What is shown, in a few words.
    pub title: String,
    /// The problem, the quantity, the time.
    pub subtitle: String,
    /// Quantity (unit) of the horizontal axis.
    pub x_label: String,
    /// Quantity (unit) of the vertical axis.
    pub y_label: String,
    /// The foot: how it was measured; the machine, its load and the commit. One line each.
    pub caption: Vec<String>,
}

/// Error against cost on logarithmic axes, one series per method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkPrecision {
    /// Words around it.
    pub words: Words,
    /// What its axes mean.
    pub reading: Reading,
    /// The methods.
    pub series: Vec<Method>,
}

/// What may be read from two logarithmic axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Reading {
    /// Across is a cost and upwards an error: the chart has a cheapest method for a tolerance.
    Cost {
        /// Unit of the cost, e.g. `s`.
        unit: String,
        /// How the errors were formed.
        errors: Measure,
        /// The error of the reference, formed so too; 0 for a closed form. Below it nothing is told.
        reference_error: f64,
    },
    /// Across is a parameter, of which none is cheaper than another.
    Parameter,
}

/// How the errors of a chart were formed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Over the size of what is sought: 0.1 is 10 %.
    Relative,
    /// The decimal logarithm of measured over sought: 0.041 is 10 %.
    Log10,
    /// In the unit of the vertical axis.
    Absolute,
}

/// A method and its runs, in the order in which they are joined.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Method {
    /// Its name in the legend.
    pub name: String,
    /// Its runs.
    pub runs: Vec<Run>,
}

/// One run of a method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// What it cost, e.g. CPU seconds.
    pub cost: f64,
    /// The scatter of that cost over repeated runs.
    pub cost_error: Option<f64>,
    /// What came of it.
    pub outcome: RunOutcome,
    /// Its parameter, e.g. `1,700`, written beside the point.
    pub label: Option<String>,
}

/// What came of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RunOutcome {
    /// A result.
    Error {
        /// Size of its error, positive.
        value: f64,
        /// Standard error of that error.
        standard_error: Option<f64>,
    },
    /// A typed error instead of a result: a cross at the upper edge.
    Failed {
        /// Why.
        reason: String,
    },
}

/// Values over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeSeries {
    /// Words around it.
    pub words: Words,
    /// Scale of the vertical axis.
    pub scale: Scale,
    /// Computed values, joined by lines.
    pub lines: Vec<Line>,
    /// Ranges around the lines, shaded in their colours: band `i` belongs to line `i`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bands: Vec<Band>,
    /// Values to compare with, as points.
    pub references: Vec<ReferencePoints>,
}

/// A range around a line, such as one standard deviation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Band {
    /// (time, lower end, upper end), by time.
    pub points: Vec<(f64, f64, f64)>,
}

/// A density over a plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// Words around it.
    pub words: Words,
    /// Edges of the cells along the horizontal axis.
    pub x: Vec<f64>,
    /// Edges of the cells along the vertical axis.
    pub y: Vec<f64>,
    /// The density in each cell, row by row from below.
    pub values: Vec<Vec<f64>>,
}

/// A quantity over a plane on a linear scale.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Field {
    /// Words around it.
    pub words: Words,
    /// Quantity (unit), above the key.
    pub unit: String,
    /// Edges of the cells along the horizontal axis.
    pub x: Vec<f64>,
    /// Edges of the cells along the vertical axis.
    pub y: Vec<f64>,
    /// The value in each cell, row by row from below; none where the quantity is not.
    pub values: Vec<Vec<Option<f64>>>,
    /// What stands in other cells.
    pub regions: Vec<Region>,
}

/// Cells of a field that are named instead of valued.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Its name in the key.
    pub name: String,
    /// Whether each cell belongs to it.
    pub cells: Vec<Vec<bool>>,
}

/// A probability over a plane and the law of a path on it, both axes to one scale.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathMap {
    /// Words around it.
    pub words: Words,
    /// What the probability is of, above the key; one entry for each line.
    pub probability: Vec<String>,
    /// Edges of the cells along the horizontal axis.
    pub x: Vec<f64>,
    /// Edges of the cells along the vertical axis.
    pub y: Vec<f64>,
    /// The probability in each cell, row by row from below; none where there is nothing.
    pub values: Vec<Vec<Option<f64>>>,
    /// What is there at the start, such as a notch: a name and points joined by a thick line.
    pub given: (String, Vec<[f64; 2]>),
    /// The path by its quantiles, from the lowest probability to the highest, with their names; the middle one is drawn boldly, the
    /// range of the others shaded.
    pub quantiles: Vec<PathQuantile>,
}

/// A quantile of a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathQuantile {
    /// Its name in the legend.
    pub name: String,
    /// Its height at each abscissa.
    pub points: Vec<[f64; 2]>,
}

/// Scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// Equal steps.
    Linear,
    /// Equal factors. Values of zero or below leave a gap, and the chart counts them in its foot.
    Log,
}

/// Computed values over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Line {
    /// Its name in the legend.
    pub name: String,
    /// (time, value); no value leaves a gap.
    pub points: Vec<(f64, Option<f64>)>,
}

/// Values to compare with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferencePoints {
    /// Their name in the legend.
    pub name: String,
    /// The values.
    pub points: Vec<ReferencePoint>,
}

/// One value to compare with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferencePoint {
    /// Time.
    pub x: f64,
    /// Value.
    pub y: f64,
    /// Its error, one sigma.
    pub error: Option<f64>,
}
