//! A chart whose values and errors are shown under the pointer.

use serde::Serialize;

/// Values over an abscissa, drawn by uPlot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chart {
    /// Its heading.
    pub title: String,
    /// Abscissa with its unit, e.g. `time (s)`.
    pub x_label: String,
    /// Ordinate with its unit.
    pub y_label: String,
    /// Whether the ordinate is logarithmic; values of zero or below are then gaps.
    pub is_logarithmic: bool,
    /// Whether the abscissa is logarithmic; all abscissae are then positive.
    pub x_is_logarithmic: bool,
    /// Meaning of `Point::spread`; empty if no point has one.
    pub spread: String,
    /// The lines.
    pub series: Vec<Series>,
}

/// A line of a chart.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Its points, in order of the abscissa.
    pub points: Vec<Point>,
}

/// A point of a line.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// Abscissa.
    pub x: f64,
    /// Value.
    pub y: f64,
    /// Its error; none if it is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// The upper bound, where no more is known: shown under the pointer in place of value and error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<f64>,
    /// How the error is known, in words.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub how: String,
    /// Half the width of a shaded range around it, such as one standard deviation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spread: Option<f64>,
}
