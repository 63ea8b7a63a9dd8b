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

    /// `L^T x` into `result`: [`n_unknowns`](Self::n_unknowns) values to [`n_motions`](Self::n_motions). With it the
    /// covariance itself can be applied, `L (L^T x)`: a drift `L L^T f` and a noise `L z` then come from one factor.
    fn apply_transposed(&self, x: &[f64], result: &mut [f64]);
}

/// What [`NoiseFactor`] does, for several fields at once whose values lie side by side: `[unknown][component]`, with
/// motions `[motion][component]`. Each field has the same factor and motions of its own. In blocks of components that fit
/// in registers, so that the factor is read once for eight.
macro_rules! for_components {
    () => {
        /// `L z` for several fields side by side: `z` is `[motion][component]`, `result` is `[unknown][component]`. What
        /// [`NoiseFactor::apply`] gives for each of them alone.
        pub fn apply_to_components(&self, components: usize, z: &[f64], result: &mut [f64]) {
            $crate::noise_factor::in_blocks!(self.apply_block(components, z, result));
        }

        /// `L^T x` for several fields side by side: `x` is `[unknown][component]`, `result` is `[motion][component]`. What
        /// [`NoiseFactor::apply_transposed`] gives for each of them alone.
        pub fn apply_transposed_to_components(
            &self,
            components: usize,
            x: &[f64],
            result: &mut [f64],
        ) {
            $crate::noise_factor::in_blocks!(self.apply_transposed_block(components, x, result));
        }
    };
}

macro_rules! in_blocks {
    ($self:ident.$block:ident($components:ident, $from:ident, $to:ident)) => {{
        let mut first = 0;
        while first < $components {
            first += match $components - first {
                8.. => $self.$block::<8>((first, $components), $from, $to),
                4.. => $self.$block::<4>((first, $components), $from, $to),
                3 => $self.$block::<3>((first, $components), $from, $to),
                2 => $self.$block::<2>((first, $components), $from, $to),
                _ => $self.$block::<1>((first, $components), $from, $to),
            };
        }
    }};
}

#[cfg(feature = "dense")]
pub(crate) use for_components;
pub(crate) use in_blocks;

/// `C` components of an unknown or a motion, from the `first` of `all` on.
#[inline]
pub(crate) fn load<const C: usize>(
    values: &[f64],
    index: usize,
    (first, all): (usize, usize),
) -> [f64; C] {
    let start = index * all + first;
    let mut block = [0.0; C];
    block.copy_from_slice(&values[start..start + C]);
    block
}

/// Where they go.
#[inline]
pub(crate) fn block_of<const C: usize>(
    values: &mut [f64],
    index: usize,
    (first, all): (usize, usize),
) -> &mut [f64] {
    let start = index * all + first;
    &mut values[start..start + C]
}

/// `values += l x`.
#[inline]
pub(crate) fn add_scaled<const C: usize>(values: &mut [f64], l: f64, x: &[f64; C]) {
    for (value, x) in values.iter_mut().zip(x) {
        *value += l * x;
    }
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

    /// The standard deviations.
    #[must_use]
    pub fn deviations(&self) -> &[f64] {
        &self.deviations
    }

    for_components!();

    fn apply_block<const C: usize>(
        &self,
        of: (usize, usize),
        z: &[f64],
        result: &mut [f64],
    ) -> usize {
        for (i, deviation) in self.deviations.iter().enumerate() {
            let z: [f64; C] = load(z, i, of);
            block_of::<C>(result, i, of).copy_from_slice(&z.map(|z| deviation * z));
        }
        C
    }

    fn apply_transposed_block<const C: usize>(
        &self,
        of: (usize, usize),
        x: &[f64],
        result: &mut [f64],
    ) -> usize {
        self.apply_block::<C>(of, x, result)
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

    /// The columns, each with an entry per unknown.
    pub fn columns(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.columns.chunks_exact(self.n)
    }

    for_components!();

    fn apply_block<const C: usize>(
        &self,
        of: (usize, usize),
        z: &[f64],
        result: &mut [f64],
    ) -> usize {
        for i in 0..self.n {
            block_of::<C>(result, i, of).fill(0.0);
        }
        for (j, column) in self.columns().enumerate() {
            let z: [f64; C] = load(z, j, of);
            for (i, &l) in column.iter().enumerate() {
                add_scaled(block_of::<C>(result, i, of), l, &z);
            }
        }
        C
    }

    fn apply_transposed_block<const C: usize>(
        &self,
        of: (usize, usize),
        x: &[f64],
        result: &mut [f64],
    ) -> usize {
        for (j, column) in self.columns().enumerate() {
            let mut sum = [0.0; C];
            for (i, &l) in column.iter().enumerate() {
                add_scaled(&mut sum, l, &load::<C>(x, i, of));
            }
            block_of::<C>(result, j, of).copy_from_slice(&sum);
        }
        C
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
    /// The largest number of motions: a path draws a normal for each, whether or not a row has it.
    pub const MAX_MOTIONS: usize = u32::MAX as usize;

    /// From compressed rows: row `i` has the entries `row_starts[i]..row_starts[i + 1]` of `columns` and `values`.
    ///
    /// # Errors
    /// [`Error::Length`] (`values` against `columns`), [`Error::SparseRow`] where `row_starts` does not begin at 0,
    /// ascend and end at the number of entries, [`Error::SparseColumn`] for a column that does not exist,
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

    /// Row `i` as its columns and its values, in the order they were given.
    ///
    /// # Panics
    /// If there is no such row, as a slice does.
    #[must_use]
    pub fn row(&self, i: usize) -> (&[usize], &[f64]) {
        let row = self.row_starts[i]..self.row_starts[i + 1];
        (&self.columns[row.clone()], &self.values[row])
    }

    fn rows(&self) -> impl Iterator<Item = (&[usize], &[f64])> {
        (0..self.row_starts.len() - 1).map(|i| self.row(i))
    }

    for_components!();

    fn apply_block<const C: usize>(
        &self,
        of: (usize, usize),
        z: &[f64],
        result: &mut [f64],
    ) -> usize {
        for (i, (columns, values)) in self.rows().enumerate() {
            let mut sum = [0.0; C];
            for (&column, &l) in columns.iter().zip(values) {
                add_scaled(&mut sum, l, &load::<C>(z, column, of));
            }
            block_of::<C>(result, i, of).copy_from_slice(&sum);
        }
        C
    }

    fn apply_transposed_block<const C: usize>(
        &self,
        of: (usize, usize),
        x: &[f64],
        result: &mut [f64],
    ) -> usize {
        for j in 0..self.n_motions {
            block_of::<C>(result, j, of).fill(0.0);
        }
        for (i, (columns, values)) in self.rows().enumerate() {
            let x: [f64; C] = load(x, i, of);
            for (&column, &l) in columns.iter().zip(values) {
                add_scaled(block_of::<C>(result, column, of), l, &x);
            }
        }
        C
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
