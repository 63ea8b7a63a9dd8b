//! Bonds of a list that may have crossed their strength in a step, a realisation in every lane.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::{Lanes, Mask, Registers, Work};

use super::lanes::Realisations;
use crate::breaking::crossing::Crossing;
use crate::material::strain::Strain;
use crate::real::Real;

/// Limits that decide which bonds may have crossed their strength over a step, one for each bond and lane.
#[derive(Debug, Clone)]
pub(super) struct CrossingLimits<T> {
    /// `w_0`, the relative squared elongation at the strength.
    pub(super) strength: Vec<T>,
    /// Below it the product `(w_0 - w)(w_0 - w')` needs a test.
    pub(super) product: Vec<T>,
}

impl<T: Real> CrossingLimits<T> {
    /// Limits of so many bonds with these strengths, by bond and lane.
    pub(super) fn new<const L: usize>(
        strain: Strain,
        n_bonds: usize,
        crossing: &Crossing<L>,
        strength: impl Fn(usize, usize) -> f64,
    ) -> Self {
        let mut limits = Self { strength: Vec::new(), product: Vec::new() };
        for at in 0..n_bonds * L {
            let strength = strength(at / L, at % L);
            // A gap in stretch is at least that in elongation over the largest slope below the strength.
            let slope = strain.slope(strength);
            let product = slope * slope * crossing.least_product(at / L);
            limits.product.push(T::of(product));
            limits.strength.push(T::of(strain.squared_elongation(strength)));
        }
        limits
    }
}

/// Finds the bonds for which `(w_0 - w)(w_0 - w')`, with the relative squared elongations `w` before and `w'` after the step, is
/// below its limit in any lane.
pub(super) struct MayCross<'a, T, const D: usize, const L: usize, const LINEAR: bool> {
    pub(super) realisations: Realisations<'a, T, D, L>,
    pub(super) limits: &'a CrossingLimits<T>,
    pub(super) from: &'a [T],
    pub(super) to: &'a [T],
    /// Bonds with their ends.
    pub(super) found: &'a mut Vec<(usize, [usize; 2])>,
}

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool> Work<T>
    for MayCross<'_, T, D, L, LINEAR>
{
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<T>>(self, registers: R) {
        let bonds = self.realisations.bonds;
        for i in 0..bonds.n_nodes() {
            for bond in bonds.row(i) {
                let ends = [i, bonds.partner(bond)];
                let (mut first, mut near) = (0, false);
                while first < L {
                    near |= self.is_near(registers, (bond, ends), first);
                    first += R::N;
                }
                if near {
                    self.found.push((bond, ends));
                }
            }
        }
    }
}

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool> MayCross<'_, T, D, L, LINEAR> {
    #[inline(always)]
    fn is_near<R: Registers<T>>(
        &self,
        registers: R,
        (bond, ends): (usize, [usize; 2]),
        first: usize,
    ) -> bool {
        let of = |column: &[T]| registers.load_at(column, bond * L + first);
        let (limit, near) = (of(&self.limits.strength), of(&self.limits.product));
        let mut product = registers.splat(T::of(1.0));
        for u in [self.from, self.to] {
            let u_i = Realisations::<T, D, L>::of_node(registers, u, ends[0], first);
            let separation = self.realisations.separation::<R, LINEAR>(
                registers,
                (bond, ends),
                (u, &u_i),
                first,
            );
            product = product * (limit - separation.elongation.0);
        }
        // A difference that is subnormal counts for none.
        (near - product).at_least(near.splat(T::SMALLEST)).any()
    }
}
