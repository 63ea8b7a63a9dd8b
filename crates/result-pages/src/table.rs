//! A table whose columns sort.

/// A table.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Its heading.
    pub title: String,
    /// What it shows, in a sentence; may be empty.
    pub about: String,
    /// Names of its columns.
    pub heads: Vec<String>,
    /// Its rows; each has a cell for each head.
    pub rows: Vec<Vec<Cell>>,
}

/// A cell of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Its text.
    pub text: String,
    /// Number by which its column sorts; none for a text.
    pub number: Option<f64>,
}

impl Cell {
    /// A cell that sorts as text.
    pub fn text(text: impl Into<String>) -> Self {
        Self { text: text.into(), number: None }
    }

    /// A cell that sorts as a number.
    pub fn number(text: impl Into<String>, number: f64) -> Self {
        Self { text: text.into(), number: Some(number) }
    }
}
