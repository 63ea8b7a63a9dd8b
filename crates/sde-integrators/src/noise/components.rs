//! Noise factors applied to several fields in interleaved storage.
//!
//! Fields are stored as `[unknown][component]`, motions as `[motion][component]`.
//!
//! The fields share a factor and have independent motions.

/// Applies a [`NoiseFactor`](crate::NoiseFactor) to several fields at once.
///
/// It works in blocks of components that fit in registers, so that the factor is read once for eight.
macro_rules! for_components {
    () => {
        /// `L z` for several interleaved fields: `z` is `[motion][component]`, `result` is `[unknown][component]`.
        ///
        /// The result is that of [`NoiseFactor::apply`] for each field alone.
        pub fn apply_to_components(&self, components: usize, z: &[f64], result: &mut [f64]) {
            $crate::noise::components::in_blocks!(self.apply_block(components, z, result));
        }

        /// `L^T x` for several interleaved fields: `x` is `[unknown][component]`, `result` is `[motion][component]`.
        ///
        /// The result is that of [`NoiseFactor::apply_transposed`] for each field alone.
        pub fn apply_transposed_to_components(
            &self,
            components: usize,
            x: &[f64],
            result: &mut [f64],
        ) {
            $crate::noise::components::in_blocks!(
                self.apply_transposed_block(components, x, result)
            );
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

pub(crate) use for_components;
pub(crate) use in_blocks;

/// A block: its first component, and the total number.
pub(crate) type Block = (usize, usize);

/// `A x` for `C` components, with the rows of `A` given as columns and values.
pub(crate) fn multiply<const C: usize>(
    rows: impl Iterator<Item = impl Iterator<Item = (usize, f64)>>,
    block: Block,
    x: &[f64],
    result: &mut [f64],
) -> usize {
    for (i, row) in rows.enumerate() {
        let mut sum = [0.0; C];
        for (j, value) in row {
            add_scaled(&mut sum, value, &load::<C>(x, j, block));
        }
        block_of::<C>(result, i, block).copy_from_slice(&sum);
    }
    C
}

/// `A^T x`, computed from the columns of `A^T`, of `n` entries.
pub(crate) fn multiply_transposed<const C: usize>(
    n: usize,
    rows: impl Iterator<Item = impl Iterator<Item = (usize, f64)>>,
    block: Block,
    x: &[f64],
    result: &mut [f64],
) -> usize {
    for j in 0..n {
        block_of::<C>(result, j, block).fill(0.0);
    }
    for (i, row) in rows.enumerate() {
        let x: [f64; C] = load(x, i, block);
        for (j, value) in row {
            add_scaled(block_of::<C>(result, j, block), value, &x);
        }
    }
    C
}

/// Multiplies each entry of `x` by that of the diagonal.
pub(crate) fn multiply_diagonal<const C: usize>(
    diagonal: &[f64],
    block: Block,
    x: &[f64],
    result: &mut [f64],
) -> usize {
    for (i, value) in diagonal.iter().enumerate() {
        let x: [f64; C] = load(x, i, block);
        block_of::<C>(result, i, block).copy_from_slice(&x.map(|x| value * x));
    }
    C
}

/// Entries of a dense row.
pub(crate) fn entries(row: &[f64]) -> impl Iterator<Item = (usize, f64)> {
    row.iter().copied().enumerate()
}

/// `C` components of an unknown or a motion, starting at `first` of `all`.
#[inline]
fn load<const C: usize>(values: &[f64], index: usize, (first, all): Block) -> [f64; C] {
    let start = index * all + first;
    let mut block = [0.0; C];
    block.copy_from_slice(&values[start..start + C]);
    block
}

/// The same, mutable.
#[inline]
fn block_of<const C: usize>(values: &mut [f64], index: usize, (first, all): Block) -> &mut [f64] {
    let start = index * all + first;
    &mut values[start..start + C]
}

/// `values += l x`.
#[inline]
fn add_scaled<const C: usize>(values: &mut [f64], l: f64, x: &[f64; C]) {
    for (value, x) in values.iter_mut().zip(x) {
        *value += l * x;
    }
}
