//! Bonds of a list as registers read them: a realisation in every lane.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::Registers;

use super::LaneBits;
use super::bond_force::Separation;
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::real::Real;

/// Bonds that are the same in `L` realisations, but for the lanes in which they are broken.
#[derive(Clone, Copy)]
pub(super) struct Realisations<'a, T, const D: usize, const L: usize> {
    pub(super) nodes: &'a Nodes<D>,
    pub(super) bonds: &'a Bonds,
    pub(super) inverse_squares: &'a [T],
    pub(super) intact: &'a [LaneBits],
}

impl<T: Real, const D: usize, const L: usize> Realisations<'_, T, D, L> {
    /// Where a component of a node is, in the lanes from `first` on.
    #[inline(always)]
    pub(super) fn at(node: usize, k: usize, first: usize) -> usize {
        (node * D + k) * L + first
    }

    /// A column of nodes at one of them.
    #[inline(always)]
    pub(super) fn of_node<R: Registers<T>>(
        registers: R,
        column: &[T],
        node: usize,
        first: usize,
    ) -> [R::Vector; D] {
        let mut of_node = [registers.splat(T::ZERO); D];
        for (k, of_node) in of_node.iter_mut().enumerate() {
            *of_node = registers.load_at(column, Self::at(node, k, first));
        }
        of_node
    }

    /// A bond from a node with the displacement `u_i`.
    #[inline(always)]
    pub(super) fn separation<R: Registers<T>, const LINEAR: bool>(
        &self,
        registers: R,
        (bond, ends): (usize, [usize; 2]),
        (u, u_i): (&[T], &[R::Vector; D]),
        first: usize,
    ) -> Separation<R::Vector, D> {
        let [x_i, x_j] = ends.map(|end| &self.nodes.positions()[end]);
        let (mut xi, mut eta) = (*u_i, Self::of_node(registers, u, ends[1], first));
        for k in 0..D {
            xi[k] = registers.splat(T::of(x_j[k] - x_i[k]));
            eta[k] = eta[k] - u_i[k];
        }
        let shape = (&xi, registers.splat(self.inverse_squares[bond]));
        Separation::new::<R, LINEAR>(registers, shape, &eta, self.intact[bond] >> first)
    }
}
