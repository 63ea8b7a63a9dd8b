//! Chart contents as plain data.

use serde::{Deserialize, Serialize};

/// Title, labels and caption of a chart.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Words {
    /// Title of the chart.
    pub title: String,
    /// Problem, quantity and time.
    pub subtitle: String,
    /// Quantity (unit) of the horizontal axis.
    pub x_label: String,
    /// Quantity (unit) of the vertical axis.
    pub y_label: String,
    /// Caption: how it was measured, the machine, its load and the commit. Each entry is a line.
    pub caption: Vec<String>,
}

/// Error against cost on logarithmic axes, one series per method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkPrecision {
    /// Title, labels and caption.
    pub words: Words,
    /// Meaning of the axes.
    pub reading: Reading,
    /// The methods.
    pub series: Vec<Method>,
}

/// Meaning of two logarithmic axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Reading {
    /// The horizontal axis is a cost and the vertical one an error: the chart has a cheapest method for a tolerance.
    Cost {
        /// Unit of the cost, e.g. `s`.
        unit: String,
        /// Definition of the errors.
        errors: Measure,
        /// Error of the reference in the same measure; 0 for a closed form. No choice is made below it.
        reference_error: f64,
    },
    /// The horizontal axis is a parameter, so no run is cheaper than another.
    Parameter,
}

/// Definition of the errors of a chart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Relative to the exact value: 0.1 is 10 %.
    Relative,
    /// Decimal logarithm of measured over exact value: 0.041 is 10 %.
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
    /// Its cost, e.g. CPU seconds.
    pub cost: f64,
    /// The scatter of that cost over repeated runs.
    pub cost_error: Option<f64>,
    /// Its result or failure.
    pub outcome: RunOutcome,
    /// Its parameter, e.g. `1,700`, written beside the point.
    pub label: Option<String>,
}

/// Result or failure of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RunOutcome {
    /// A result.
    Error {
        /// Absolute value of its error, positive.
        value: f64,
        /// Standard error of that error.
        standard_error: Option<f64>,
    },
    /// A typed error instead of a result: drawn as a cross at the upper edge.
    Failed {
        /// Text of the error.
        reason: String,
    },
}

/// Values over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeSeries {
    /// Title, labels and caption.
    pub words: Words,
    /// Scale of the vertical axis.
    pub scale: Scale,
    /// Computed values, joined by lines.
    pub lines: Vec<Line>,
    /// Ranges around the lines, shaded in their colours: band `i` belongs to line `i`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bands: Vec<Band>,
    /// Reference values, drawn as points.
    pub references: Vec<ReferencePoints>,
}

/// A range around a line, such as one standard deviation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Band {
    /// (time, lower end, upper end), in order of time.
    pub points: Vec<(f64, f64, f64)>,
}

/// A density over a plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// Title, labels and caption.
    pub words: Words,
    /// Edges of the cells along the horizontal axis.
    pub x: Vec<f64>,
    /// Edges of the cells along the vertical axis.
    pub y: Vec<f64>,
    /// The density in each cell, row by row from the bottom.
    pub values: Vec<Vec<f64>>,
}

/// A quantity over a plane on a linear scale.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Field {
    /// Title, labels and caption.
    pub words: Words,
    /// Quantity (unit), above the colour key.
    pub unit: String,
    /// Edges of the cells along the horizontal axis.
    pub x: Vec<f64>,
    /// Edges of the cells along the vertical axis.
    pub y: Vec<f64>,
    /// The value in each cell, row by row from the bottom; none where the quantity is not defined.
    pub values: Vec<Vec<Option<f64>>>,
    /// Named regions without values.
    pub regions: Vec<Region>,
}

/// Cells of a field that carry a name instead of a value.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Its name in the colour key.
    pub name: String,
    /// Whether each cell belongs to the region.
    pub cells: Vec<Vec<bool>>,
}

/// A probability over a plane and the quantiles of a path on it, both axes to the same scale.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathMap {
    /// Title, labels and caption.
    pub words: Words,
    /// Name of the probability above the colour key; one entry for each line.
    pub probability: Vec<String>,
    /// Edges of the cells along the horizontal axis.
    pub x: Vec<f64>,
    /// Edges of the cells along the vertical axis.
    pub y: Vec<f64>,
    /// The probability in each cell, row by row from the bottom; none outside the body.
    pub values: Vec<Vec<Option<f64>>>,
    /// Initial geometry such as a notch: a name and points joined by a thick line.
    pub given: (String, Vec<[f64; 2]>),
    /// Quantiles of the path, from the lowest probability to the highest, with their names.
    ///
    /// The middle one is drawn boldly and the range of the others shaded.
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
    /// Linear scale.
    Linear,
    /// Logarithmic scale. Values of zero or below leave a gap, and the chart counts them in its caption.
    Log,
}

/// Computed values over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Line {
    /// Its name in the legend.
    pub name: String,
    /// (time, value); a missing value leaves a gap.
    pub points: Vec<(f64, Option<f64>)>,
}

/// Reference values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferencePoints {
    /// Their name in the legend.
    pub name: String,
    /// The values.
    pub points: Vec<ReferencePoint>,
}

/// One reference value.
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
