//! Forces of a list of bonds of one realisation: the components of a node in a register where bonds begin and end, bonds in
//! between.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::ops::Range;

use simd_lanes::{Lanes, MOST_LANES, Registers, Work};

use super::list_columns::Columns;
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::{BrokenBond, Cause};
use crate::fast::LaneBits;
use crate::fast::bond_force::{SquaredElongation, component};
use crate::fast::limit::Limit;
use crate::real::Real;

/// Components of a node, zero beyond its dimensions.
const WIDTH: usize = 4;

/// Bonds of a node that are gathered before any is computed: as many as let a processor finish writing before it reads them.
pub(in crate::fast) const BATCH: usize = 64;

/// The nodes as registers hold them.
#[derive(Debug, Clone)]
pub(in crate::fast) struct Padded<T>(Vec<Node<T>>);

/// All of a node in one place: apart from each other, forces and places get into each other's way in the cache.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
struct Node<T> {
    /// Where it is at rest.
    x: [f64; WIDTH],
    /// How far it has moved.
    u: [T; WIDTH],
    force: [T; WIDTH],
}

impl<T: Real> Padded<T> {
    pub(in crate::fast) fn new<const D: usize>(nodes: &Nodes<D>) -> Self {
        const { assert!(D <= WIDTH, "components of a node in one register") };
        let node = |of: &[f64; D]| {
            let (mut x, none) = ([0.0; WIDTH], [T::ZERO; WIDTH]);
            x[..D].copy_from_slice(of);
            Node { x, u: none, force: none }
        };
        Self(nodes.positions().iter().map(node).collect())
    }

    #[inline(always)]
    pub(in crate::fast) fn begin<const D: usize>(&mut self, u: &[T]) {
        for (node, u) in self.0.iter_mut().zip(u.as_chunks::<D>().0) {
            node.u[..D].copy_from_slice(u);
            node.force = [T::ZERO; WIDTH];
        }
    }

    #[inline(always)]
    pub(in crate::fast) fn end<const D: usize>(&self, forces: &mut [T]) {
        for (force, node) in forces.as_chunks_mut::<D>().0.iter_mut().zip(&self.0) {
            force.copy_from_slice(&node.force[..D]);
        }
    }

    #[inline(always)]
    pub(in crate::fast) fn gather<const LINEAR: bool>(
        &self,
        batch: &mut Batch<T>,
        i: usize,
        partners: &[u32],
    ) {
        let Node { x: x_i, u: u_i, .. } = self.0[i];
        let of_batch = batch.directions.iter_mut().zip(&mut batch.squares);
        for ((direction, square), &j) in of_batch.zip(partners) {
            let Node { x: x_j, u: u_j, .. } = &self.0[j as usize];
            for k in 0..WIDTH {
                let (xi, eta) = (T::of(x_j[k] - x_i[k]), u_j[k] - u_i[k]);
                (direction[k], square[k]) = component::<T, LINEAR>(xi, eta);
            }
        }
    }

    #[inline(always)]
    pub(in crate::fast) fn scatter(&mut self, batch: &Batch<T>, i: usize, partners: &[u32]) {
        // The sum of a row is kept apart: adding each to memory would wait for the one before.
        let (nodes, mut sum) = (&mut self.0[..], [T::ZERO; WIDTH]);
        let of_batch = batch.directions.iter().zip(&batch.tensions);
        for ((direction, &tension), &j) in of_batch.zip(partners) {
            let force_j = &mut nodes[j as usize].force;
            for k in 0..WIDTH {
                let force = tension * direction[k];
                sum[k] += force;
                force_j[k] -= force;
            }
        }
        for k in 0..WIDTH {
            nodes[i].force[k] += sum[k];
        }
    }
}

/// Bonds of a node.
pub(in crate::fast) struct Batch<T> {
    /// `xi + eta`, or `xi` where strains are linear.
    directions: [[T; WIDTH]; BATCH],
    /// By component, the growth of the squared length: `eta (2 xi + eta)`, or `2 eta xi`.
    squares: [[T; WIDTH]; BATCH],
    /// What is computed of each bond: for the forces its tension over its length along the direction.
    pub(in crate::fast) tensions: [T; BATCH],
}

impl<T: Real> Batch<T> {
    pub(in crate::fast) fn new() -> Self {
        let none = [[T::ZERO; WIDTH]; BATCH];
        Self { directions: none, squares: none, tensions: [T::ZERO; BATCH] }
    }

    /// Computes a number of each gathered bond, registers of bonds one after the other: `of` gets the place of the first in the
    /// batch, the relative squared elongations, the pulls (none where a bond is at its limit), and what `columns` hold of them.
    #[inline(always)]
    pub(in crate::fast) fn compute<R: Registers<T>, const D: usize, const LINEAR: bool>(
        &mut self,
        registers: R,
        columns: &RowColumns<'_, T>,
        (bonds, limit): (Range<usize>, Limit),
        reached: &mut Vec<BrokenBond>,
        mut of: impl FnMut(usize, [R::Vector; 3]) -> R::Vector,
    ) {
        let lanes = R::N;
        let least = match limit {
            Limit::Strength => T::ZERO,
            Limit::Unreached => T::LARGEST,
        };
        // The last register holds zeros beside these bonds.
        let n = bonds.len().next_multiple_of(lanes);
        self.squares[bonds.len()..n].fill([T::ZERO; WIDTH]);
        let filled = bonds.start..bonds.start + n;
        let inverse_squares = columns.inverse_squares[filled.clone()].chunks_exact(lanes);
        let factors = columns.factors[filled.clone()].chunks_exact(lanes);
        let limits = columns.limits[filled].chunks_exact(lanes);
        let columns = inverse_squares.zip(factors.zip(limits));
        let squares = self.squares[..n].chunks_exact(lanes);
        let blocks = squares.zip(self.tensions[..n].chunks_exact_mut(lanes)).zip(columns);
        let mut at = 0;
        for block in blocks {
            let ((squares, tensions), (inverse_squares, (factors, limits))) = block;
            let load = |values: &[T]| registers.load_at(values, 0);
            let elongation = sums::<T, R, D>(registers, squares) * load(inverse_squares);
            let elongation = SquaredElongation::new(registers, elongation, LaneBits::MAX);
            let w = elongation.0;
            let limit = registers.splat(least).max(load(limits));
            let pull = elongation.pull::<R, LINEAR>(
                registers,
                limit,
                || limit,
                |of_lanes| {
                    for lane in (0..lanes).filter(|lane| of_lanes & 1 << lane != 0) {
                        let bond = bonds.start + at + lane;
                        reached.push(BrokenBond { bond, lanes: 1, cause: Cause::Stretch });
                    }
                },
            );
            registers.store_at(of(at, [w, pull, load(factors)]), tensions, 0);
            at += lanes;
        }
    }
}

/// What is read of bonds in a row; each with numbers beyond the last bond that fill a register.
#[derive(Clone, Copy)]
pub(in crate::fast) struct RowColumns<'a, T> {
    /// `1/|xi|^2`, zero where a bond is broken.
    pub(in crate::fast) inverse_squares: &'a [T],
    /// What the pull or the stretch is multiplied by.
    pub(in crate::fast) factors: &'a [T],
    /// The relative squared elongation at which a bond breaks.
    pub(in crate::fast) limits: &'a [T],
}

/// Forces under `u`, node by node: its bonds are gathered, computed in registers, and their forces added one by one.
pub(in crate::fast) struct InRows<'a, T, const D: usize, const LINEAR: bool> {
    pub(in crate::fast) bonds: &'a Bonds,
    pub(in crate::fast) columns: &'a Columns<T>,
    pub(in crate::fast) padded: &'a mut Padded<T>,
    pub(in crate::fast) u: &'a [T],
    pub(in crate::fast) forces: &'a mut [T],
    pub(in crate::fast) limit: Limit,
    /// Bonds found at their limit.
    pub(in crate::fast) reached: &'a mut Vec<BrokenBond>,
}

impl<T: Real, const D: usize, const LINEAR: bool> Work<T> for InRows<'_, T, D, LINEAR> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<T>>(self, registers: R) {
        let Self { bonds, columns, padded, u, forces, limit, reached } = self;
        let Columns { inverse_squares, stiffness, limits, .. } = columns;
        let columns = RowColumns { inverse_squares, factors: stiffness, limits };
        let mut batch = Batch::new();
        padded.begin::<D>(u);
        for (i, some) in in_batches(bonds) {
            let partners = bonds.partners(some.clone());
            padded.gather::<LINEAR>(&mut batch, i, partners);
            let tension = |_, [_, pull, stiffness]: [R::Vector; 3]| stiffness * pull;
            let some = (some, limit);
            batch.compute::<R, D, LINEAR>(registers, &columns, some, reached, tension);
            padded.scatter(&batch, i, partners);
        }
        padded.end::<D>(forces);
    }
}

/// The bonds of each node, at most [`BATCH`] at a time.
#[inline(always)]
pub(in crate::fast) fn in_batches(bonds: &Bonds) -> impl Iterator<Item = (usize, Range<usize>)> {
    (0..bonds.n_nodes()).flat_map(|i| {
        let row = bonds.row(i);
        let starts = row.clone().step_by(BATCH);
        starts.map(move |first| (i, first..row.end.min(first + BATCH)))
    })
}

/// Sums over the components of as many bonds as a register has lanes.
#[inline(always)]
fn sums<T: Real, R: Registers<T>, const D: usize>(
    registers: R,
    squares: &[[T; WIDTH]],
) -> R::Vector {
    if let (true, [a, b, c, d]) = (R::N == WIDTH, squares) {
        // The sum in the same order: what is added beyond the dimensions is zero.
        return registers.sum_fours([a, b, c, d].map(|four| registers.load_fours(&[four])));
    }
    let mut square = [T::ZERO; MOST_LANES];
    for lane in 0..R::N {
        let parts = &squares[lane];
        square[lane] = parts[1..D].iter().fold(parts[0], |sum, &part| sum + part);
    }
    registers.load_at(&square, 0)
}
