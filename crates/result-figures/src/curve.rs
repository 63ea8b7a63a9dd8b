//! The data of curves over a parameter.

use serde::{Deserialize, Serialize};

use crate::data::{Scale, Words};

/// Curves over a parameter, with thresholds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Curves {
    /// Title, labels and caption.
    pub words: Words,
    /// Scale of the horizontal axis.
    pub across: Scale,
    /// Scale of the vertical axis.
    pub upwards: Scale,
    /// The curves.
    pub series: Vec<Curve>,
    /// Values marked by lines across the picture.
    pub thresholds: Vec<Threshold>,
}

/// One curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Curve {
    /// Its name in the legend; empty for none, where another curve of the same look has one.
    pub name: String,
    /// Index of its colour, marker and dashes: prediction and measurement may share one.
    pub look: usize,
    /// How it is drawn.
    pub style: Style,
    /// Its points, in the order in which they are joined.
    pub points: Vec<CurvePoint>,
}

impl Curve {
    /// Values joined by a line.
    pub fn line(
        name: impl Into<String>,
        look: usize,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let points = points.into_iter().map(|(x, y)| CurvePoint::at(x, y)).collect();
        Self { name: name.into(), look, style: Style::Line, points }
    }

    /// Open markers.
    pub fn points(name: impl Into<String>, look: usize, points: Vec<CurvePoint>) -> Self {
        Self { name: name.into(), look, style: Style::Points, points }
    }

    /// Joined markers.
    pub fn marked(name: impl Into<String>, look: usize, points: Vec<CurvePoint>) -> Self {
        Self { name: name.into(), look, style: Style::LineAndPoints, points }
    }
}

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Style {
    /// Joined, without markers.
    Line,
    /// Open markers.
    Points,
    /// Joined markers.
    LineAndPoints,
}

/// A point of a curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurvePoint {
    /// The parameter.
    pub x: f64,
    /// The result there.
    pub height: Height,
}

impl CurvePoint {
    /// A value without error.
    #[must_use]
    pub const fn at(x: f64, y: f64) -> Self {
        Self { x, height: Height::Value { y, bar: None } }
    }

    /// A value with its standard error.
    #[must_use]
    pub const fn sampled(x: f64, y: f64, standard_error: f64) -> Self {
        Self { x, height: Height::Value { y, bar: Some(standard_error) } }
    }

    /// Its value, if it has one.
    #[must_use]
    pub const fn value(&self) -> Option<f64> {
        match self.height {
            Height::Value { y, .. } => Some(y),
            Height::Ended { .. } => None,
        }
    }

    /// A point whose run ended in an error.
    #[must_use]
    pub const fn ended(x: f64, error: String) -> Self {
        Self { x, height: Height::Ended { error } }
    }
}

impl Threshold {
    /// A threshold of the parameter.
    pub fn across(name: impl Into<String>, at: f64) -> Self {
        Self { name: name.into(), direction: Direction::Across, at }
    }

    /// A threshold of the quantity on the vertical axis.
    pub fn upwards(name: impl Into<String>, at: f64) -> Self {
        Self { name: name.into(), direction: Direction::Upwards, at }
    }
}

/// Result at a point of a curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Height {
    /// A value.
    Value {
        /// It.
        y: f64,
        /// Its standard error.
        bar: Option<f64>,
    },
    /// A typed error: a cross in a strip above the scale.
    Ended {
        /// Its text.
        error: String,
    },
}

/// A value that divides a picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Threshold {
    /// Its name in the legend.
    pub name: String,
    /// Along which axis it is a value.
    pub direction: Direction,
    /// The value.
    pub at: f64,
}

/// One of the two axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// The horizontal one.
    Across,
    /// The vertical one.
    Upwards,
}
