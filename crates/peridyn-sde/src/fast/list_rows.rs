//! Forces of a list of bonds of one realisation: the components of a node in a register where bonds begin and end, bonds in
//! between.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::ops::Range;

use lanes::{Lanes, MOST_LANES, Registers, Work};

use super::LaneBits;
use super::bond_force::{SquaredElongation, component};
use super::limit::Limit;
use super::list_columns::Columns;
use crate::bonds::Bonds;
use crate::broken_bond::{BrokenBond, Cause};
use crate::nodes::Nodes;
use crate::real::Real;

/// Components of a node, zero beyond its dimensions.
const WIDTH: usize = 4;

/// Bonds of a node that are gathered before any is computed: as many as let a processor finish writing before it reads them.
const BATCH: usize = 64;

/// The nodes as registers hold them.
#[derive(Debug, Clone)]
pub(super) struct Padded<T>(Vec<Node<T>>);

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
    pub(super) fn new<const D: usize>(nodes: &Nodes<D>) -> Self {
        const { assert!(D <= WIDTH, "components of a node in one register") };
        let node = |of: &[f64; D]| {
            let (mut x, none) = ([0.0; WIDTH], [T::ZERO; WIDTH]);
            x[..D].copy_from_slice(of);
            Node { x, u: none, force: none }
        };
        Self(nodes.positions().iter().map(node).collect())
    }

    #[inline(always)]
    fn begin<const D: usize>(&mut self, u: &[T]) {
        for (node, u) in self.0.iter_mut().zip(u.as_chunks::<D>().0) {
            node.u[..D].copy_from_slice(u);
            node.force = [T::ZERO; WIDTH];
        }
    }

    #[inline(always)]
    fn end<const D: usize>(&self, forces: &mut [T]) {
        for (force, node) in forces.as_chunks_mut::<D>().0.iter_mut().zip(&self.0) {
            force.copy_from_slice(&node.force[..D]);
        }
    }

    #[inline(always)]
    fn gather<const LINEAR: bool>(&self, batch: &mut Batch<T>, i: usize, partners: &[u32]) {
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
    fn scatter(&mut self, batch: &Batch<T>, i: usize, partners: &[u32]) {
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
struct Batch<T> {
    /// `xi + eta`, or `xi` where strains are linear.
    directions: [[T; WIDTH]; BATCH],
    /// By component, the growth of the squared length: `eta (2 xi + eta)`, or `2 eta xi`.
    squares: [[T; WIDTH]; BATCH],
    tensions: [T; BATCH],
}

/// Forces under `u`, node by node: its bonds are gathered, computed in registers, and their forces added one by one.
pub(super) struct InRows<'a, T, const D: usize, const LINEAR: bool> {
    pub(super) bonds: &'a Bonds,
    pub(super) columns: &'a Columns<T>,
    pub(super) padded: &'a mut Padded<T>,
    pub(super) u: &'a [T],
    pub(super) forces: &'a mut [T],
    pub(super) limit: Limit,
    /// Bonds found at their limit.
    pub(super) reached: &'a mut Vec<BrokenBond>,
}

impl<T: Real, const D: usize, const LINEAR: bool> Work<T> for InRows<'_, T, D, LINEAR> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<T>>(mut self, registers: R) {
        let none = [[T::ZERO; WIDTH]; BATCH];
        let mut batch = Batch { directions: none, squares: none, tensions: [T::ZERO; BATCH] };
        self.padded.begin::<D>(self.u);
        for i in 0..self.bonds.n_nodes() {
            let row = self.bonds.row(i);
            for first in row.clone().step_by(BATCH) {
                let bonds = first..row.end.min(first + BATCH);
                let partners = self.bonds.partners(bonds.clone());
                self.padded.gather::<LINEAR>(&mut batch, i, partners);
                self.pull(registers, &mut batch, bonds);
                self.padded.scatter(&batch, i, partners);
            }
        }
        self.padded.end::<D>(self.forces);
    }
}

impl<T: Real, const D: usize, const LINEAR: bool> InRows<'_, T, D, LINEAR> {
    /// Tensions of gathered bonds; those at their limit carry none.
    #[inline(always)]
    fn pull<R: Registers<T>>(&mut self, registers: R, batch: &mut Batch<T>, bonds: Range<usize>) {
        let lanes = R::N;
        let least = match self.limit {
            Limit::Strength => T::ZERO,
            Limit::Unreached => T::LARGEST,
        };
        // The last register holds zeros beside these bonds.
        let n = bonds.len().next_multiple_of(lanes);
        batch.squares[bonds.len()..n].fill([T::ZERO; WIDTH]);
        let filled = bonds.start..bonds.start + n;
        let Columns { inverse_squares, stiffness, limits, .. } = self.columns;
        let inverse_squares = inverse_squares[filled.clone()].chunks_exact(lanes);
        let stiffness = stiffness[filled.clone()].chunks_exact(lanes);
        let limits = limits[filled].chunks_exact(lanes);
        let columns = inverse_squares.zip(stiffness.zip(limits));
        let squares = batch.squares[..n].chunks_exact(lanes);
        let blocks = squares.zip(batch.tensions[..n].chunks_exact_mut(lanes)).zip(columns);
        let mut first = bonds.start;
        for block in blocks {
            let ((squares, tensions), (inverse_squares, (stiffness, limits))) = block;
            let load = |values: &[T]| registers.load_at(values, 0);
            let elongation = sums::<T, R, D>(registers, squares) * load(inverse_squares);
            let elongation = SquaredElongation::new(registers, elongation, LaneBits::MAX);
            let limit = registers.splat(least).max(load(limits));
            let pull = elongation.pull::<R, LINEAR>(registers, limit, |reached| {
                for lane in (0..lanes).filter(|lane| reached & 1 << lane != 0) {
                    let bond = first + lane;
                    self.reached.push(BrokenBond { bond, lanes: 1, cause: Cause::Stretch });
                }
            });
            registers.store_at(load(stiffness) * pull, tensions, 0);
            first += lanes;
        }
    }
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
