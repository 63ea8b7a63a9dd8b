//! The columns of a file of points.

/// The columns that are read.
pub(super) const COLUMNS: [&str; 5] = ["x", "y", "volume", "strength_factor", "stiffness_factor"];

/// A body has no more points than this.
pub(super) const MOST_POINTS: usize = 10_000_000;

/// What was read of a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    /// The names of all its columns.
    pub(super) names: Vec<String>,
    /// Those of [`COLUMNS`] that it has.
    pub(super) columns: [Option<Vec<f64>>; COLUMNS.len()],
    /// The line of each row; none of a file without lines.
    pub(super) lines: Option<Vec<u64>>,
}

impl Table {
    /// Where a row stands, e.g. `points.csv line 7`.
    pub(super) fn place(&self, file: &str, row: usize) -> String {
        match self.lines.as_ref().and_then(|lines| lines.get(row)) {
            Some(line) => format!("{file} line {line}"),
            None => format!("{file} point {row}"),
        }
    }
}
