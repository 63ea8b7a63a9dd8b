//! How the noise of a field is correlated: a factor `L` of its covariance `L L^T`.

use crate::error::Error;

/// A factor `L` of the covariance of a field's noise, with a row per unknown and a column per Brownian motion.
///
/// Implement it for a factor that is not here, such as one by Fourier transforms.
pub trait NoiseFactor: Sync {
    /// How many rows it has.
    fn n_unknowns(&self) -> usize;

    /// How many columns it has.
    fn n_motions(&self) -> usize;

    /// `L z` into `result`: [`n_motions`](Self::n_motions) values to [`n_unknowns`](Self::n_unknowns).
    fn apply(&self, z: &[f64], result: &mut [f64]);
}

pub(crate) fn require_finite(quantity: &'static str, values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(Error::NotFinite { quantity, index, value: values[index] }),
        None => Ok(()),
    }
}

pub(crate) fn require_length(
    quantity: &'static str,
    value: usize,
    expected: usize,
) -> Result<(), Error> {
    if value == expected { Ok(()) } else { Err(Error::Length { quantity, value, expected }) }
}

/// Each unknown has a motion of its own: `O(n)`.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagonalFactor {
    deviations: Vec<f64>,
}

impl DiagonalFactor {
    /// From the standard deviations per square root of time.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn new(deviations: Vec<f64>) -> Result<Self, Error> {
        require_finite("deviation", &deviations)?;
        Ok(Self { deviations })
    }
}

impl NoiseFactor for DiagonalFactor {
    fn n_unknowns(&self) -> usize {
        self.deviations.len()
    }

    fn n_motions(&self) -> usize {
        self.deviations.len()
    }

    fn apply(&self, z: &[f64], result: &mut [f64]) {
        for ((result, z), deviation) in result.iter_mut().zip(z).zip(&self.deviations) {
            *result = deviation * z;
        }
    }
}

/// A few motions for many unknowns, as of a truncated Karhunen-Loève expansion: `O(n k)`.
#[derive(Debug, Clone, PartialEq)]
pub struct LowRankFactor {
    n: usize,
    /// Column after column.
    columns: Vec<f64>,
}

impl LowRankFactor {
    /// From the columns, one after the other, of `n_unknowns` entries each.
    ///
    /// # Errors
    /// [`Error::TooFew`] without an unknown, [`Error::Length`] where the last column is not whole,
    /// [`Error::NotFinite`].
    pub fn new(n_unknowns: usize, columns: Vec<f64>) -> Result<Self, Error> {
        if n_unknowns == 0 {
            return Err(Error::TooFew { quantity: "unknowns", value: 0, limit: 1 });
        }
        let whole = columns.len().next_multiple_of(n_unknowns);
        require_length("entries of the columns", columns.len(), whole)?;
        require_finite("entry of the columns", &columns)?;
        Ok(Self { n: n_unknowns, columns })
    }
}

impl NoiseFactor for LowRankFactor {
    fn n_unknowns(&self) -> usize {
        self.n
    }

    fn n_motions(&self) -> usize {
        self.columns.len() / self.n
    }

    fn apply(&self, z: &[f64], result: &mut [f64]) {
        result.fill(0.0);
        for (column, z) in self.columns.chunks_exact(self.n).zip(z) {
            for (result, l) in result.iter_mut().zip(column) {
                *result += l * z;
            }
        }
    }
}

/// A sparse factor in compressed rows: `O(n + entries)`.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseFactor {
    n_motions: usize,
    row_starts: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
}

impl SparseFactor {
    /// From compressed rows: row `i` has the entries `row_starts[i]..row_starts[i + 1]` of `columns` and `values`.
    ///
    /// # Errors
    /// [`Error::Length`] (`values` against `columns`), [`Error::SparseRow`] where `row_starts` does not begin at 0,
    /// ascend and end at the number of entries, [`Error::SparseColumn`] for a column that does not exist,
    /// [`Error::NotFinite`].
    pub fn new(
        n_motions: usize,
        row_starts: Vec<usize>,
        columns: Vec<usize>,
        values: Vec<f64>,
    ) -> Result<Self, Error> {
        require_length("values", values.len(), columns.len())?;
        let n_entries = columns.len();
        let mut least = 0;
        for (row, &start) in row_starts.iter().enumerate() {
            let last = row + 1 == row_starts.len();
            let limit = if row == 0 { 0 } else { n_entries };
            if start < least || start > limit || (last && start != n_entries) {
                return Err(Error::SparseRow { row, start, from: least, to: limit });
            }
            least = start;
        }
        if row_starts.is_empty() {
            return Err(Error::TooFew { quantity: "row starts", value: 0, limit: 1 });
        }
        if let Some(entry) = columns.iter().position(|&column| column >= n_motions) {
            return Err(Error::SparseColumn { entry, column: columns[entry], n_motions });
        }
        require_finite("value", &values)?;
        Ok(Self { n_motions, row_starts, columns, values })
    }
}

impl NoiseFactor for SparseFactor {
    fn n_unknowns(&self) -> usize {
        self.row_starts.len() - 1
    }

    fn n_motions(&self) -> usize {
        self.n_motions
    }

    fn apply(&self, z: &[f64], result: &mut [f64]) {
        for (result, ends) in result.iter_mut().zip(self.row_starts.windows(2)) {
            let row = ends[0]..ends[1];
            *result = self.columns[row.clone()]
                .iter()
                .zip(&self.values[row])
                .map(|(&column, l)| l * z[column])
                .sum();
        }
    }
}
