//! One pass over a list of bonds, a realisation in every lane.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::marker::PhantomData;

use simd_lanes::{Registers, Work};

use super::columns::Columns;
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::{BrokenBond, Cause};
use crate::fast::LaneBits;
use crate::fast::bond_force::{Kind, Pass, Separation, intact, solid_tension, stretch};
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
    /// The displacement of a node.
    #[inline(always)]
    pub(super) fn of_node<R: Registers<T>>(
        registers: R,
        u: &[T],
        node: usize,
        first: usize,
    ) -> [R::Vector; D] {
        load::<T, R, D, L>(registers, u, node, first)
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

/// Where a component of a node is, of `M` components, in the lanes from `first` on.
#[inline(always)]
fn place<const M: usize, const L: usize>(node: usize, k: usize, first: usize) -> usize {
    (node * M + k) * L + first
}

/// The components of a column at a node.
#[inline(always)]
fn load<T: Real, R: Registers<T>, const M: usize, const L: usize>(
    registers: R,
    column: &[T],
    node: usize,
    first: usize,
) -> [R::Vector; M] {
    let mut of_node = [registers.splat(T::ZERO); M];
    for (k, of_node) in of_node.iter_mut().enumerate() {
        *of_node = registers.load_at(column, place::<M, L>(node, k, first));
    }
    of_node
}

/// A pass under `u` that adds `M` numbers at both ends of each bond, as many realisations at a time as a register holds.
pub(super) struct LaneWork<
    'a,
    T,
    P,
    const D: usize,
    const M: usize,
    const L: usize,
    const LINEAR: bool,
    const OWN: bool,
> {
    pub(super) realisations: Realisations<'a, T, D, L>,
    pub(super) columns: &'a Columns<T>,
    pub(super) u: &'a [T],
    /// `tau = D A theta/m` of each node and lane of a linear peridynamic solid, for the forces.
    pub(super) tau: &'a [T],
    pub(super) sums: &'a mut [T],
    /// Whether it looks for bonds at their limit.
    pub(super) breaks: bool,
    /// Bonds found at their limit.
    pub(super) reached: &'a mut Vec<BrokenBond>,
    pub(super) pass: PhantomData<P>,
}

impl<T, P, const D: usize, const M: usize, const L: usize, const LINEAR: bool, const OWN: bool>
    Work<T> for LaneWork<'_, T, P, D, M, L, LINEAR, OWN>
where
    T: Real,
    P: Pass,
{
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<T>>(mut self, registers: R) {
        self.sums.fill(T::ZERO);
        for first in (0..L).step_by(R::N) {
            for node in 0..self.realisations.bonds.n_nodes() {
                self.row(registers, node, first);
            }
        }
    }
}

impl<T, P, const D: usize, const M: usize, const L: usize, const LINEAR: bool, const OWN: bool>
    LaneWork<'_, T, P, D, M, L, LINEAR, OWN>
where
    T: Real,
    P: Pass,
{
    /// Bonds in the row of a node, in the lanes from `first` on.
    #[inline(always)]
    fn row<R: Registers<T>>(&mut self, registers: R, i: usize, first: usize) {
        let (all, columns) = (self.realisations, self.columns);
        let of_node = |column: &[T], node: usize| registers.load_at(column, node * L + first);
        let u_i = Realisations::<T, D, L>::of_node(registers, self.u, i, first);
        let mut total = load::<T, R, M, L>(registers, self.sums, i, first);
        for bond in all.bonds.row(i) {
            let j = all.bonds.partner(bond);
            let moved = (self.u, &u_i);
            let Separation { direction, elongation } =
                all.separation::<R, LINEAR>(registers, (bond, [i, j]), moved, first);
            let limit = if self.breaks {
                Self::of(registers, &columns.limits, bond, first)
            } else {
                registers.splat(T::LARGEST)
            };
            let w = elongation.0;
            let pull = elongation.pull::<R, LINEAR>(
                registers,
                limit,
                || limit,
                |reached| {
                    let lanes = reached << first;
                    self.reached.push(BrokenBond { bond, lanes, cause: Cause::Stretch });
                },
            );
            let value = match P::KIND {
                Kind::PairForce => Self::of(registers, &columns.stiffness, bond, first) * pull,
                Kind::Dilatation => {
                    registers.splat(columns.moments[bond]) * stretch::<_, LINEAR>(w, pull)
                }
                Kind::SolidForce => {
                    let tau = of_node(self.tau, i) + of_node(self.tau, j);
                    let phi_tau = registers.splat(columns.weights[bond]) * tau;
                    let stiffness = registers.splat(columns.stiffness[bond]);
                    let tension = solid_tension::<_, LINEAR>(stiffness, phi_tau, pull);
                    intact(registers, tension, all.intact[bond] >> first)
                }
            };
            for k in 0..M {
                let part = if P::IS_DILATATION { value } else { value * direction[k] };
                total[k] = total[k] + part;
                let at = place::<M, L>(j, k, first);
                let other = registers.load_at(self.sums, at);
                let other = if P::IS_DILATATION { other + part } else { other - part };
                registers.store_at(other, self.sums, at);
            }
        }
        for k in 0..M {
            registers.store_at(total[k], self.sums, place::<M, L>(i, k, first));
        }
    }

    /// A constant of a bond.
    #[inline(always)]
    fn of<R: Registers<T>>(registers: R, column: &[T], bond: usize, first: usize) -> R::Vector {
        if OWN {
            registers.load_at(column, bond * L + first)
        } else {
            registers.splat(column[bond])
        }
    }
}
