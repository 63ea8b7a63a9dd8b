//! Forces of a list of bonds of one realisation, a bond in every lane.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::ops::Range;

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
    xi: [[T; BATCH]; D],
    eta: [[T; BATCH]; D],
    force: [[T; BATCH]; D],
}

/// A part of the bonds of a node that fits in a batch.
#[derive(Debug, Clone, Copy)]
struct Part<'a> {
    node: usize,
    partners: &'a [u32],
    /// Where in the batch.
    at: usize,
}

impl<T: Real, const D: usize, const LINEAR: bool> WithSimd for InRows<'_, T, D, LINEAR> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let none = [[T::ZERO; BATCH]; D];
        let mut batch = Batch { xi: none, eta: none, force: none };
        self.forces.fill(T::ZERO);
        let (mut node, n_bonds) = (0, self.graph.1.len());
        for first in (0..n_bonds).step_by(BATCH) {
            let bonds = first..n_bonds.min(first + BATCH);
            for part in parts(self.graph.1, node, bonds.clone()) {
                self.gather(&mut batch, part);
            }
            self.compute_all(simd, &mut batch, bonds.clone());
            for part in parts(self.graph.1, node, bonds) {
                self.give_back(&batch, part);
                node = part.node;
            }
        }
    }
}

/// The parts of nodes from a node on that some bonds are.
#[inline(always)]
fn parts(bonds: &Bonds, from: usize, of: Range<usize>) -> impl Iterator<Item = Part<'_>> {
    (from..bonds.n_nodes()).map_while(move |node| {
        let row = bonds.row(node);
        let part = row.start.max(of.start)..row.end.min(of.end);
        let at = part.start.saturating_sub(of.start);
        (row.start < of.end).then(|| Part { node, partners: bonds.partners(part), at })
    })
}

impl<T: Real, const D: usize, const LINEAR: bool> InRows<'_, T, D, LINEAR> {
    #[inline(always)]
    fn gather(&self, batch: &mut Batch<T, D>, Part { node, partners, at }: Part<'_>) {
        let (x, u) = (self.graph.0.positions(), self.u.as_chunks::<D>().0);
        let (x_i, u_i) = (x[node], u[node]);
        let (xi, eta) = (&mut batch.xi, &mut batch.eta);
        for (at, &j) in (at..BATCH).zip(partners) {
            let (x_j, u_j) = (&x[j as usize], &u[j as usize]);
            for k in 0..D {
                xi[k][at] = T::of(x_j[k] - x_i[k]);
                eta[k][at] = u_j[k] - u_i[k];
            }
        }
    }

    #[inline(always)]
    fn give_back(&mut self, batch: &Batch<T, D>, Part { node, partners, at }: Part<'_>) {
        let forces = self.forces.as_chunks_mut::<D>().0;
        // The sum of a row is kept apart: adding each to memory would wait for the one before.
        let mut sum = [T::ZERO; D];
        for (at, &j) in (at..BATCH).zip(partners) {
            let force_j = &mut forces[j as usize];
            for k in 0..D {
                let force = batch.force[k][at];
                sum[k] += force;
                force_j[k] -= force;
            }
        }
        for k in 0..D {
            forces[node][k] += sum[k];
        }
    }

    #[inline(always)]
    fn compute_all<S: Simd>(&mut self, simd: S, batch: &mut Batch<T, D>, bonds: Range<usize>) {
        let lanes = T::lanes::<S>();
        let (first, count) = (bonds.start, bonds.len());
        let whole = count / lanes * lanes;
        for at in (0..whole).step_by(lanes) {
            self.compute(simd, batch, (first, at), lanes);
        }
        if whole < count {
            self.compute(simd, batch, (first, whole), count - whole);
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
