//! Morton order, in which neighbours in space are close in memory.

use crate::error::Error;

/// Order of points along the Morton curve (Z order): indices for [`permute`](crate::ParticleStore::permute).
///
/// The smallest cube that contains the points, with their lower corner, is halved along every axis. The parts follow
/// each other, first axis fastest, and each part is ordered in the same way. There are 32 halvings in one and two
/// dimensions, and `64 / D`, rounded down, in higher ones. Points in the same final cell keep their order. Axes share
/// one scale, because neighbours are defined by distance; if axes have different units, scale the points first.
///
/// O(n log n). Equal points give equal orders on every machine.
///
/// ```
/// use particle_store::{ParticleStore, morton_order};
///
/// let mut store = ParticleStore::<2>::new(4);
/// let position = store.add("position", vec![[1.0, 1.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0]])?;
/// let order = morton_order(store.get(position)?)?;
/// store.permute(&order)?;
/// assert_eq!(store.get(position)?, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]);
/// # Ok::<(), particle_store::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::NotFinite`] for a coordinate, [`Error::TooManyPoints`] for more points than a `u32` can index.
pub fn morton_order<const D: usize>(points: &[[f64; D]]) -> Result<Vec<u32>, Error> {
    const { assert!(D >= 1 && D <= 64, "a key has 64 bits, at least one for each axis") };
    let n = u32::try_from(points.len()).map_err(|_| Error::TooManyPoints)?;
    if let Some(wrong) = points.iter().position(|x| !x.iter().all(|value| value.is_finite())) {
        return Err(Error::NotFinite { what: format!("point {wrong}") });
    }
    let (mut lower, mut width) = ([f64::INFINITY; D], 0.0_f64);
    for x in points {
        for axis in 0..D {
            lower[axis] = lower[axis].min(x[axis]);
        }
    }
    // Halves, because the difference of two finite numbers may overflow.
    let above = |x: &[f64; D], axis: usize| 0.5 * x[axis] - 0.5 * lower[axis];
    for x in points {
        width = (0..D).map(|axis| above(x, axis)).fold(width, f64::max);
    }
    let n_bits = (64 / D).min(32);
    let n_cells = (1_u64 << n_bits) as f64;
    let key = |x: &[f64; D]| {
        let cell: [u64; D] = core::array::from_fn(|axis| {
            let share = if width > 0.0 { above(x, axis) / width } else { 0.0 };
            cell_of(share * n_cells, n_bits)
        });
        interleaved(&cell, n_bits)
    };
    let mut keyed: Vec<(u64, u32)> = points.iter().map(key).zip(0..n).collect();
    keyed.sort_unstable();
    Ok(keyed.into_iter().map(|(_, place)| place).collect())
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between 0 and 2^32; the fraction goes"
)]
fn cell_of(position: f64, n_bits: usize) -> u64 {
    (position as u64).min((1 << n_bits) - 1)
}

/// Bit `b` of axis `a` becomes bit `b D + a`.
fn interleaved<const D: usize>(cell: &[u64; D], n_bits: usize) -> u64 {
    let mut key = 0;
    for bit in (0..n_bits).rev() {
        for axis in (0..D).rev() {
            key = key << 1 | (cell[axis] >> bit & 1);
        }
    }
    key
}
