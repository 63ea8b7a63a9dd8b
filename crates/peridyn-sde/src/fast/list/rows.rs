//! One pass over a list of bonds of one realisation: the components of a node in a register where bonds begin and end, bonds in
//! between.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::marker::PhantomData;
use std::ops::Range;

use simd_lanes::{Lanes, MOST_LANES, Registers, Work};

use super::columns::Columns;
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::{BrokenBond, Cause};
use crate::fast::bond_force::{Kind, Pass, SquaredElongation, component, solid_tension, stretch};
use crate::real::Real;

/// Components of a node, zero beyond its dimensions.
const WIDTH: usize = 4;

/// Bonds of a node that are gathered before any is computed: as many as let a processor finish writing before it reads them.
const BATCH: usize = 64;

/// The nodes as registers hold them.
#[derive(Debug, Clone)]
struct Padded<T>(Vec<Node<T>>);

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
    fn new<const D: usize>(nodes: &Nodes<D>) -> Self {
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
    /// What is computed of each bond: for the forces its tension over its length along the direction.
    tensions: [T; BATCH],
}

impl<T: Real> Batch<T> {
    fn new() -> Self {
        let none = [[T::ZERO; WIDTH]; BATCH];
        Self { directions: none, squares: none, tensions: [T::ZERO; BATCH] }
    }

    /// Computes a number of each gathered bond, registers of bonds one after the other: `of` gets the place of the first in the
    /// batch, the relative squared elongations, the pulls (none where a bond is at its limit), and their `factors`.
    #[inline(always)]
    fn compute<R: Registers<T>, const D: usize, const LINEAR: bool>(
        &mut self,
        registers: R,
        (columns, factors): (&Columns<T>, &[T]),
        (bonds, breaks): (Range<usize>, bool),
        reached: &mut Vec<BrokenBond>,
        mut of: impl FnMut(usize, [R::Vector; 3]) -> R::Vector,
    ) {
        let lanes = R::N;
        let least = if breaks { T::ZERO } else { T::LARGEST };
        // The last register holds zeros beside these bonds.
        let n = bonds.len().next_multiple_of(lanes);
        self.squares[bonds.len()..n].fill([T::ZERO; WIDTH]);
        let filled = bonds.start..bonds.start + n;
        let inverse_squares = columns.inverse_squares[filled.clone()].chunks_exact(lanes);
        let factors = factors[filled.clone()].chunks_exact(lanes);
        let limits = columns.limits[filled].chunks_exact(lanes);
        let columns = inverse_squares.zip(factors.zip(limits));
        let squares = self.squares[..n].chunks_exact(lanes);
        let blocks = squares.zip(self.tensions[..n].chunks_exact_mut(lanes)).zip(columns);
        let mut at = 0;
        for block in blocks {
            let ((squares, tensions), (inverse_squares, (factors, limits))) = block;
            let load = |values: &[T]| registers.load_at(values, 0);
            let w = sums::<T, R, D>(registers, squares) * load(inverse_squares);
            let limit = registers.splat(least).max(load(limits));
            let pull = SquaredElongation(w).pull::<R, LINEAR>(
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

/// Buffers of one realisation.
#[derive(Debug, Clone)]
pub(super) struct OneRealisation<T> {
    padded: Padded<T>,
    /// The pull of each bond of a linear peridynamic solid, which the dilatations leave to the forces.
    pulls: Vec<T>,
}

impl<T: Real> OneRealisation<T> {
    /// With room for the pulls of so many bonds.
    pub(super) fn new<const D: usize>(nodes: &Nodes<D>, n_bonds: usize) -> Self {
        // Registers that begin at the last bonds end within the column.
        Self { padded: Padded::new(nodes), pulls: vec![T::ZERO; n_bonds + MOST_LANES] }
    }
}

/// A pass under `u`, node by node: its bonds are gathered, computed in registers, and their numbers added one by one.
pub(super) struct RowWork<'a, T, P, const D: usize, const LINEAR: bool> {
    pub(super) bonds: &'a Bonds,
    pub(super) columns: &'a Columns<T>,
    pub(super) one: &'a mut OneRealisation<T>,
    pub(super) u: &'a [T],
    /// `tau = D A theta/m` of each node of a linear peridynamic solid, for the forces.
    pub(super) tau: &'a [T],
    pub(super) sums: &'a mut [T],
    /// Whether it looks for bonds at their limit.
    pub(super) breaks: bool,
    /// Bonds found at their limit.
    pub(super) reached: &'a mut Vec<BrokenBond>,
    pub(super) pass: PhantomData<P>,
}

impl<T: Real, P: Pass, const D: usize, const LINEAR: bool> Work<T>
    for RowWork<'_, T, P, D, LINEAR>
{
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<T>>(self, registers: R) {
        let Self { bonds, columns, one, u, tau, sums, breaks, reached, .. } = self;
        let OneRealisation { padded, pulls } = one;
        let (mut batch, mut tau_of_partners) = (Batch::new(), [T::ZERO; BATCH]);
        padded.begin::<D>(u);
        if P::IS_DILATATION {
            sums.fill(T::ZERO);
        }
        for (i, some) in in_batches(bonds) {
            let partners = bonds.partners(some.clone());
            padded.gather::<LINEAR>(&mut batch, i, partners);
            match P::KIND {
                Kind::PairForce => {
                    let tension = |_, [_, pull, stiffness]: [R::Vector; 3]| stiffness * pull;
                    let factors = (columns, &columns.stiffness[..]);
                    let some = (some, breaks);
                    batch.compute::<R, D, LINEAR>(registers, factors, some, reached, tension);
                    padded.scatter(&batch, i, partners);
                }
                Kind::Dilatation => {
                    let pulls = &mut pulls[some.start..];
                    let part = |at, [w, pull, moment]: [R::Vector; 3]| {
                        // Beyond the row they are those of bonds that come later.
                        registers.store_at(pull, pulls, at);
                        moment * stretch::<_, LINEAR>(w, pull)
                    };
                    let factors = (columns, &columns.moments[..]);
                    let some = (some, breaks);
                    batch.compute::<R, D, LINEAR>(registers, factors, some, reached, part);
                    let mut sum = T::ZERO;
                    for (&part, &j) in batch.tensions.iter().zip(partners) {
                        sum += part;
                        sums[j as usize] += part;
                    }
                    sums[i] += sum;
                }
                Kind::SolidForce => {
                    for (of, &j) in tau_of_partners.iter_mut().zip(partners) {
                        *of = tau[j as usize];
                    }
                    let tau = (registers.splat(tau[i]), &tau_of_partners);
                    let columns = (columns, &pulls[..]);
                    batch.solid_tensions::<R, LINEAR>(registers, columns, &some, tau);
                    padded.scatter(&batch, i, partners);
                }
            }
        }
        if !P::IS_DILATATION {
            padded.end::<D>(sums);
        }
    }
}

impl<T: Real> Batch<T> {
    /// The tensions of gathered bonds of a linear peridynamic solid, from their pulls and `tau` at both ends.
    #[inline(always)]
    fn solid_tensions<R: Registers<T>, const LINEAR: bool>(
        &mut self,
        registers: R,
        (columns, pulls): (&Columns<T>, &[T]),
        bonds: &Range<usize>,
        (tau_i, tau): (R::Vector, &[T; BATCH]),
    ) {
        let filled = bonds.start..bonds.start + bonds.len().next_multiple_of(R::N);
        let [pulls, stiffness, weights] = [pulls, &columns.stiffness, &columns.weights]
            .map(|column| column[filled.clone()].chunks_exact(R::N));
        let tensions = self.tensions.chunks_exact_mut(R::N);
        let blocks = tensions.zip(tau.chunks_exact(R::N)).zip(pulls);
        for (((tensions, tau_j), pulls), (stiffness, weights)) in blocks.zip(stiffness.zip(weights))
        {
            let load = |values: &[T]| registers.load_at(values, 0);
            let phi_tau = load(weights) * (tau_i + load(tau_j));
            let tension = solid_tension::<_, LINEAR>(load(stiffness), phi_tau, load(pulls));
            registers.store_at(tension, tensions, 0);
        }
    }
}

/// The bonds of each node, at most [`BATCH`] at a time.
#[inline(always)]
fn in_batches(bonds: &Bonds) -> impl Iterator<Item = (usize, Range<usize>)> {
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
