//! The columns of a file of points.

/// Columns that are read.
pub(super) const COLUMNS: [&str; 5] = ["x", "y", "volume", "strength_factor", "stiffness_factor"];

/// Largest number of points of a body.
pub(super) const MOST_POINTS: usize = 10_000_000;

/// Contents of a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    /// Names of all its columns.
    pub(super) names: Vec<String>,
    /// The columns among [`COLUMNS`] that it has.
    pub(super) columns: [Option<Vec<f64>>; COLUMNS.len()],
    /// Line of each row; none for a format without lines.
    pub(super) lines: Option<Vec<u64>>,
}

impl Table {
    /// Location of a row, e.g. `points.csv line 7`.
    pub(super) fn place(&self, file: &str, row: usize) -> String {
        match self.lines.as_ref().and_then(|lines| lines.get(row)) {
            Some(line) => format!("{file} line {line}"),
            None => format!("{file} point {row}"),
        }
    }
}
