//! Correlation of a field's noise: a factor `L` of its covariance `L L^T`.

use crate::error::Error;
use crate::noise::components::{
    Block, entries, for_components, multiply, multiply_diagonal, multiply_transposed,
};

/// A factor `L` of the covariance of a field's noise, with a row per unknown and a column per Brownian motion.
///
/// Implement it for further factors, such as one by Fourier transforms.
pub trait NoiseFactor: Sync {
    /// Number of rows.
    fn n_unknowns(&self) -> usize;

    /// Number of columns.
    fn n_motions(&self) -> usize;

    /// Writes `L z` into `result`: [`n_motions`](Self::n_motions) values to [`n_unknowns`](Self::n_unknowns).
    fn apply(&self, z: &[f64], result: &mut [f64]);

    /// Writes `L^T x` into `result`: [`n_unknowns`](Self::n_unknowns) values to [`n_motions`](Self::n_motions).
    ///
    /// It allows products with the covariance, `L (L^T x)`: a drift `L L^T f` and a noise `L z` then come from one
    /// factor.
    fn apply_transposed(&self, x: &[f64], result: &mut [f64]);
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
    if value == expected { Ok(()) } else { Err(Error::WrongLength { quantity, value, expected }) }
}

/// Independent motions for each unknown: `O(n)`.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagonalFactor {
    deviations: Vec<f64>,
}

impl DiagonalFactor {
    /// A factor from the standard deviations per square root of time.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn new(deviations: Vec<f64>) -> Result<Self, Error> {
        require_finite("deviation", &deviations)?;
        Ok(Self { deviations })
    }

    /// The standard deviations.
    #[must_use]
    pub fn deviations(&self) -> &[f64] {
        &self.deviations
    }

    for_components!();

    fn apply_block<const C: usize>(&self, of: Block, z: &[f64], result: &mut [f64]) -> usize {
        multiply_diagonal::<C>(&self.deviations, of, z, result)
    }

    fn apply_transposed_block<const C: usize>(
        &self,
        of: Block,
        x: &[f64],
        result: &mut [f64],
    ) -> usize {
        multiply_diagonal::<C>(&self.deviations, of, x, result)
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

    fn apply_transposed(&self, x: &[f64], result: &mut [f64]) {
        self.apply(x, result);
    }
}

/// A few motions for many unknowns, such as a truncated Karhunen-Loève expansion: `O(n k)`.
#[derive(Debug, Clone, PartialEq)]
pub struct LowRankFactor {
    n: usize,
    /// Column by column.
    columns: Vec<f64>,
}

impl LowRankFactor {
    /// A factor from its columns in sequence, with `n_unknowns` entries each.
    ///
    /// # Errors
    /// [`Error::TooFew`] for no unknowns, [`Error::WrongLength`] if the last column is incomplete, [`Error::NotFinite`].
    pub fn new(n_unknowns: usize, columns: Vec<f64>) -> Result<Self, Error> {
        if n_unknowns == 0 {
            return Err(Error::TooFew { quantity: "unknowns", value: 0, limit: 1 });
        }
        let whole = columns.len().next_multiple_of(n_unknowns);
        require_length("entries of the columns", columns.len(), whole)?;
        require_finite("entry of the columns", &columns)?;
        Ok(Self { n: n_unknowns, columns })
    }

    /// The columns, each with an entry per unknown.
    pub fn columns(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.columns.chunks_exact(self.n)
    }

    for_components!();

    fn apply_block<const C: usize>(&self, of: Block, z: &[f64], result: &mut [f64]) -> usize {
        multiply_transposed::<C>(self.n, self.columns().map(entries), of, z, result)
    }

    fn apply_transposed_block<const C: usize>(
        &self,
        of: Block,
        x: &[f64],
        result: &mut [f64],
    ) -> usize {
        multiply::<C>(self.columns().map(entries), of, x, result)
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

    fn apply_transposed(&self, x: &[f64], result: &mut [f64]) {
        for (result, column) in result.iter_mut().zip(self.columns()) {
            *result = column.iter().zip(x).map(|(l, x)| l * x).sum();
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
    /// Largest number of motions: a path draws a normal for each, used or not.
    pub const MAX_MOTIONS: usize = u32::MAX as usize;

    /// A factor from compressed rows.
    ///
    /// Row `i` has the entries `row_starts[i]..row_starts[i + 1]` of `columns` and `values`.
    ///
    /// # Errors
    /// [`Error::WrongLength`] (`values` against `columns`), [`Error::SparseRow`] if `row_starts` does not begin at 0,
    /// ascend and end at the number of entries, [`Error::SparseColumn`] for a nonexistent column,
    /// [`Error::NotFinite`], [`Error::TooMany`] for more than [`MAX_MOTIONS`](Self::MAX_MOTIONS).
    pub fn new(
        n_motions: usize,
        row_starts: Vec<usize>,
        columns: Vec<usize>,
        values: Vec<f64>,
    ) -> Result<Self, Error> {
        if n_motions > Self::MAX_MOTIONS {
            let (value, limit) = (n_motions as f64, Self::MAX_MOTIONS as f64);
            return Err(Error::TooMany { quantity: "motions", value, limit });
        }
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

    /// Row `i` as its columns and its values, in the given order.
    ///
    /// # Panics
    /// If there is no such row, as in slice indexing.
    #[must_use]
    pub fn row(&self, i: usize) -> (&[usize], &[f64]) {
        let row = self.row_starts[i]..self.row_starts[i + 1];
        (&self.columns[row.clone()], &self.values[row])
    }

    fn rows(&self) -> impl Iterator<Item = (&[usize], &[f64])> {
        (0..self.row_starts.len() - 1).map(|i| self.row(i))
    }

    fn entries(&self) -> impl Iterator<Item = impl Iterator<Item = (usize, f64)>> {
        self.rows().map(|(columns, values)| columns.iter().copied().zip(values.iter().copied()))
    }

    for_components!();

    fn apply_block<const C: usize>(&self, of: Block, z: &[f64], result: &mut [f64]) -> usize {
        multiply::<C>(self.entries(), of, z, result)
    }

    fn apply_transposed_block<const C: usize>(
        &self,
        of: Block,
        x: &[f64],
        result: &mut [f64],
    ) -> usize {
        multiply_transposed::<C>(self.n_motions, self.entries(), of, x, result)
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
        for (result, (columns, values)) in result.iter_mut().zip(self.rows()) {
            *result = columns.iter().zip(values).map(|(&column, l)| l * z[column]).sum();
        }
    }

    fn apply_transposed(&self, x: &[f64], result: &mut [f64]) {
        result.fill(0.0);
        for (x, (columns, values)) in x.iter().zip(self.rows()) {
            for (&column, l) in columns.iter().zip(values) {
                result[column] += l * x;
            }
        }
    }
}
