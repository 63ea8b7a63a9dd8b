//! A picture or a page together with its data.

use serde::{Deserialize, Serialize};

use crate::cheapest::{Choice, choices, choices_table};
use crate::data::{Field, PathMap, Plane, TimeSeries, WorkPrecision};
use crate::error::ChartError;
use crate::field::field;
use crate::finite::{self, JsonError};
use crate::path_map::path_map;
use crate::plane::plane;
use crate::time_series::time_series;
use crate::work_precision::work_precision;

/// A picture or a page together with its data.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Drawing {
    /// Name of the files without their extensions.
    pub name: String,
    /// The picture or the page.
    pub face: Face,
    /// Its data as JSON.
    pub data: String,
    /// Table printed after the path of the file; may be empty.
    pub table: String,
}

/// The contents of a chart's JSON file.
#[derive(Serialize)]
struct Chosen<'a> {
    #[serde(flatten)]
    chart: &'a WorkPrecision,
    cheapest: Vec<Choice>,
}

/// A picture or a page.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Face {
    /// A picture, SVG.
    Picture(String),
    /// A page, Markdown.
    Page(String),
}

/// Error for a chart whose picture or data cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DrawingError {
    /// Error of the picture.
    #[error(transparent)]
    Chart(#[from] ChartError),
    /// Error of the data.
    #[error(transparent)]
    Json(#[from] JsonError),
}

impl Drawing {
    /// A chart of error against cost, with the cheapest method for a tolerance in its data and its table.
    ///
    /// # Errors
    /// [`DrawingError`] for numbers that cannot be drawn.
    pub fn work_precision(name: &str, data: &WorkPrecision) -> Result<Self, DrawingError> {
        let cheapest = choices(data);
        let table = choices_table(&cheapest, &data.reading).trim_end().to_owned();
        let picture = Face::Picture(work_precision(data)?);
        Ok(Self { table, ..Self::of(name, picture, &Chosen { chart: data, cheapest })? })
    }

    /// Prepends `rows` to the printed table.
    #[must_use]
    pub fn with_rows(self, rows: &str) -> Self {
        let table = [rows, &self.table].into_iter().filter(|part| !part.is_empty());
        Self { table: table.collect::<Vec<_>>().join("\n"), ..self }
    }

    /// A chart of values over time.
    ///
    /// # Errors
    /// [`DrawingError`] for numbers that cannot be drawn.
    pub fn time_series(name: &str, data: &TimeSeries) -> Result<Self, DrawingError> {
        Self::of(name, Face::Picture(time_series(data)?), data)
    }

    /// A picture of a density over a plane.
    ///
    /// # Errors
    /// [`DrawingError`] for numbers that cannot be drawn.
    pub fn plane(name: &str, data: &Plane) -> Result<Self, DrawingError> {
        Self::of(name, Face::Picture(plane(data)?), data)
    }

    /// A picture of a quantity over a plane.
    ///
    /// # Errors
    /// [`DrawingError`] for numbers that cannot be drawn.
    pub fn field(name: &str, data: &Field) -> Result<Self, DrawingError> {
        Self::of(name, Face::Picture(field(data)?), data)
    }

    /// A picture of a probability over a plane and a path on it.
    ///
    /// # Errors
    /// [`DrawingError`] for numbers that cannot be drawn.
    pub fn path_map(name: &str, data: &PathMap) -> Result<Self, DrawingError> {
        Self::of(name, Face::Picture(path_map(data)?), data)
    }

    /// A page of text.
    ///
    /// # Errors
    /// [`DrawingError`] for numbers that JSON cannot represent.
    pub fn page<T: Serialize>(name: &str, text: String, data: &T) -> Result<Self, DrawingError> {
        Self::of(name, Face::Page(text), data)
    }

    /// Without a table.
    fn of<T: Serialize>(name: &str, face: Face, data: &T) -> Result<Self, DrawingError> {
        Ok(Self { name: name.into(), face, data: finite::to_json(data)?, table: String::new() })
    }

    /// The SVG, if the drawing is a picture.
    #[must_use]
    pub fn into_svg(self) -> Option<String> {
        match self.face {
            Face::Picture(svg) => Some(svg),
            Face::Page(_) => None,
        }
    }
}
