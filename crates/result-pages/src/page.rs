//! Content of a page.

use crate::answer::{Answer, Note};
use crate::chart::Chart;
use crate::motion::Motion;
use crate::table::Table;

/// Everything that a page shows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Page {
    /// Its heading.
    pub title: String,
    /// Name of the solver.
    pub solver: String,
    /// Warnings and remarks, in any order; the page shows warnings first.
    pub notes: Vec<Note>,
    /// The answers that are shown first.
    pub answers: Vec<Answer>,
    /// Fields over time or over realisations.
    pub motions: Vec<Motion>,
    /// Why a field is not shown, and which key of the scene turns it on.
    pub absent: Vec<String>,
    /// Charts.
    pub charts: Vec<Chart>,
    /// Tables of all results.
    pub tables: Vec<Table>,
    /// Method, work and convergence.
    pub facts: Vec<Fact>,
    /// Every key of the scene, defaults included.
    pub scene: Vec<SceneKey>,
    /// What to cite.
    pub sources: Vec<Source>,
    /// Files of the run, relative to the page.
    pub files: Vec<String>,
    /// Version, commit and machine, in a line.
    pub origin: String,
}

/// A fact about the run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fact {
    /// Its name.
    pub name: String,
    /// Its value with its unit.
    pub text: String,
}

/// A key of the scene with its value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneKey {
    /// Path of the key, e.g. `method.flow_map_fit.spacing`.
    pub key: String,
    /// Its value as JSON.
    pub value: String,
    /// Unit; empty for a word or a dimensionless number.
    pub unit: String,
    /// Whether the scene leaves it out.
    pub is_default: bool,
    /// Its description.
    pub meaning: String,
}

/// A source to cite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source {
    /// Key in `docs/references.bib`.
    pub key: &'static str,
    /// Authors, year, title, place.
    pub text: &'static str,
    /// What of the run it describes.
    pub role: &'static str,
}
