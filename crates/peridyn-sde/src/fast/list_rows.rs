//! Forces of a list of bonds of one realisation, a bond in every lane.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use pulp::{Simd, WithSimd};

use super::list::Columns;
use super::pull::Separation;
use super::vectors::{MOST_LANES, Mask};
use crate::body::{AtStrength, BrokenBond, Cause};
use crate::bonds::Bonds;
use crate::nodes::Nodes;
use crate::real::Real;

/// Bonds that are gathered before any is computed: as many as let a processor finish writing before it reads them in registers.
const BATCH: usize = 64;

/// Forces under `u`: bonds are gathered, computed in registers, and their forces given back one by one.
pub(super) struct InRows<'a, T, const D: usize, const LINEAR: bool> {
    pub(super) graph: (&'a Nodes<D>, &'a Bonds),
    pub(super) columns: &'a Columns<T>,
    pub(super) whole: &'a mut [Mask],
    pub(super) broken: &'a mut Vec<BrokenBond>,
    pub(super) u: &'a [T],
    pub(super) forces: &'a mut [T],
    pub(super) at: AtStrength,
}

/// Bonds side by side, component by component.
struct Batch<T, const D: usize> {
    ends: [[usize; 2]; BATCH],
    xi: [[T; BATCH]; D],
    eta: [[T; BATCH]; D],
    force: [[T; BATCH]; D],
}

impl<T: Real, const D: usize, const LINEAR: bool> WithSimd for InRows<'_, T, D, LINEAR> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let (nodes, bonds) = self.graph;
        let none = [[T::ZERO; BATCH]; D];
        let mut batch = Batch { ends: [[0; 2]; BATCH], xi: none, eta: none, force: none };
        let (x, u) = (nodes.positions(), self.u.as_chunks::<D>().0);
        self.forces.fill(T::ZERO);
        let (mut first, mut filled) = (0, 0);
        for i in 0..bonds.n_nodes() {
            for bond in bonds.row(i) {
                let j = bonds.partner(bond);
                batch.ends[filled] = [i, j];
                for k in 0..D {
                    batch.xi[k][filled] = T::of(x[j][k] - x[i][k]);
                    batch.eta[k][filled] = u[j][k] - u[i][k];
                }
                filled += 1;
                if filled == BATCH {
                    self.give(simd, &mut batch, first, filled);
                    first += filled;
                    filled = 0;
                }
            }
        }
        self.give(simd, &mut batch, first, filled);
    }
}

impl<T: Real, const D: usize, const LINEAR: bool> InRows<'_, T, D, LINEAR> {
    /// Computes and gives back the bonds from `first` on.
    #[inline(always)]
    fn give<S: Simd>(&mut self, simd: S, batch: &mut Batch<T, D>, first: usize, count: usize) {
        let lanes = T::lanes::<S>();
        let mut at = 0;
        while at + lanes <= count {
            self.compute(simd, batch, (first, at), lanes);
            at += lanes;
        }
        if at < count {
            self.compute(simd, batch, (first, at), count - at);
        }
        let (forces, _) = self.forces.as_chunks_mut::<D>();
        // The sum of a row is kept apart: adding each to memory would wait for the one before.
        let (mut row, mut sum) = (batch.ends[0][0], [T::ZERO; D]);
        for (at, &[i, j]) in batch.ends[..count].iter().enumerate() {
            if i != row {
                for k in 0..D {
                    forces[row][k] += sum[k];
                }
                (row, sum) = (i, [T::ZERO; D]);
            }
            for k in 0..D {
                sum[k] += batch.force[k][at];
                forces[j][k] -= batch.force[k][at];
            }
        }
        for k in 0..D {
            forces[row][k] += sum[k];
        }
    }

    /// A register of bonds, of which `count` exist; the others are as broken.
    #[inline(always)]
    fn compute<S: Simd>(
        &mut self,
        simd: S,
        batch: &mut Batch<T, D>,
        (first, at): (usize, usize),
        count: usize,
    ) {
        let zero = T::splat(simd, T::ZERO);
        let (mut xi, mut eta) = ([zero; D], [zero; D]);
        for k in 0..D {
            xi[k] = T::load::<S>(&batch.xi[k], at);
            eta[k] = T::load::<S>(&batch.eta[k], at);
        }
        let bonds = first + at..first + at + count;
        let whole = gather_bits(&self.whole[bonds.clone()]);
        let columns = self.columns;
        let inverse_square = load_some::<T, S>(&columns.inverse_squares[bonds.clone()], T::ZERO);
        let mut separation =
            Separation::<T, S, D>::new::<LINEAR>(simd, (&xi, inverse_square), &eta, whole);
        let limit = match self.at {
            AtStrength::Break => load_some::<T, S>(&columns.limits[bonds.clone()], T::LARGEST),
            AtStrength::Hold => T::splat(simd, T::LARGEST),
        };
        let pull = separation.pull::<LINEAR>(simd, limit, |reached| {
            for bond in bonds.clone().filter(|bond| reached & 1 << (bond - bonds.start) != 0) {
                self.whole[bond] = 0;
                self.broken.push(BrokenBond { bond, lanes: 1, cause: Cause::Stretch });
            }
        });
        let tension =
            T::times(simd, load_some::<T, S>(&columns.stiffness[bonds.clone()], T::ZERO), pull);
        for k in 0..D {
            let force = T::times(simd, tension, separation.direction[k]);
            T::store::<S>(force, &mut batch.force[k], at);
        }
    }
}

/// A bit for each of at most sixteen bonds.
#[inline(always)]
fn gather_bits(whole: &[Mask]) -> Mask {
    if whole.iter().fold(1, |all, one| all & one) == 1 {
        return Mask::MAX >> (MOST_LANES - whole.len());
    }
    whole.iter().enumerate().fold(0, |bits, (lane, &one)| bits | (one & 1) << lane)
}

/// A register of as many numbers as there are, and what else stands for none.
#[inline(always)]
fn load_some<T: Real, S: Simd>(values: &[T], none: T) -> T::V<S> {
    if values.len() == T::lanes::<S>() {
        return T::load::<S>(values, 0);
    }
    let mut some = [none; MOST_LANES];
    some[..values.len()].copy_from_slice(values);
    T::load::<S>(&some, 0)
}
