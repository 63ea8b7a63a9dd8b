//! One pass over the bonds of a band of rows of a lattice, neighbouring nodes in the lanes.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::marker::PhantomData;

use simd_lanes::{Registers, Work};

use super::band::{Band, Components};
use super::grid::Grid;
use super::stencil::GROUP;
use crate::fast::LaneBits;
use crate::fast::bond_force::{Kind, Pass, Separation, intact, solid_tension_over_weight, stretch};
use crate::real::Real;

/// Constants and nodal numbers of the sites of a linear peridynamic solid, empty for other bodies.
#[derive(Debug, Clone)]
pub(super) struct SolidSites<T> {
    /// `phi |xi|^2` of each vector, in the unit of [`SolidBonds::moment_unit`](crate::SolidBonds).
    pub(super) moments: Vec<T>,
    /// `B/m` of each site, and `tau` over the sum of its bonds; zero without a node.
    pub(super) constants: Components<T>,
    /// `B/m - tau` and `tau` of each site in the last evaluation.
    pub(super) nodal: Components<T>,
}

/// A pass over the bonds of a band that adds `M` numbers at both ends of each.
pub(super) struct BandWork<'a, T, P, const D: usize, const M: usize, const LINEAR: bool> {
    pub(super) grid: &'a Grid<T, D>,
    pub(super) solid: &'a SolidSites<T>,
    pub(super) band: &'a mut Band<T>,
    /// No bond has a limit below this one.
    pub(super) limit: T,
    /// Whether bonds break at limits of their own, where the band has them.
    pub(super) own: bool,
    pub(super) pass: PhantomData<P>,
}

impl<T: Real, P: Pass, const D: usize, const M: usize, const LINEAR: bool> Work<T>
    for BandWork<'_, T, P, D, M, LINEAR>
{
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<T>>(self, registers: R) {
        let Self { grid, solid, band, limit, own, .. } = self;
        let Band { rows, first, forces, dilatations, intact, limits, reached } = band;
        let sums = if P::IS_DILATATION { dilatations } else { forces };
        let (sites, n_vectors) = (&grid.sites, grid.stencil.len());
        let of_row = sites.groups() * n_vectors;
        let limits = if own { &limits[..] } else { &[] };
        let (u, sums) = (grid.padded.all(), sums.all_mut());
        let mut row = Row::<T, D, M> { grid, solid, u, first: *first, sums, reached, limit };
        for sums in &mut row.sums {
            sums.fill(T::ZERO);
        }
        let each = sites.rows()[rows.clone()].iter().zip(intact.chunks_exact(of_row)).enumerate();
        for (number, (&start, intact)) in each {
            // A row without nodes has no place.
            let words = intact.chunks_exact(n_vectors).filter(|_| start > 0);
            for (at, words) in (0..sites.width()).step_by(GROUP).zip(words) {
                let first = (number * of_row + at / GROUP * n_vectors) * GROUP;
                let group = (start + at, words, limits.get(first..).unwrap_or(&[]));
                // As a number that is known, so that loops over registers are unrolled; guards leave out what no group needs.
                let most = GROUP / R::N;
                match (sites.width() - at).min(GROUP).div_ceil(R::N) {
                    2 if most >= 2 => row.visit::<R, P, LINEAR, 2>(registers, group),
                    3 if most >= 4 => row.visit::<R, P, LINEAR, 3>(registers, group),
                    4 if most >= 4 => row.visit::<R, P, LINEAR, 4>(registers, group),
                    5.. if most >= 8 => row.visit::<R, P, LINEAR, 8>(registers, group),
                    _ => row.visit::<R, P, LINEAR, 1>(registers, group),
                }
            }
        }
    }
}

/// The numbers that the bonds of a row read and write.
struct Row<'a, T, const D: usize, const M: usize> {
    grid: &'a Grid<T, D>,
    solid: &'a SolidSites<T>,
    u: [&'a [T]; D],
    first: usize,
    sums: [&'a mut [T]; M],
    reached: &'a mut Vec<(usize, usize)>,
    limit: T,
}

impl<T: Real, const D: usize, const M: usize> Row<'_, T, D, M> {
    /// The bonds from a group of sites on, with their words of bits, vector by vector, so that the order of sums does not depend on
    /// how long registers are; those at their limit carry no force.
    #[inline(always)]
    fn visit<R: Registers<T>, P: Pass, const LINEAR: bool, const N: usize>(
        &mut self,
        registers: R,
        (group, words, limits): (usize, &[LaneBits], &[T]),
    ) {
        let lanes = R::N;
        let limit = registers.splat(self.limit);
        let mut sums = [[registers.splat(T::ZERO); M]; N];
        let here = self.u.map(|u| &u[group..group + N * lanes]);
        let nodal = self.solid.nodal.all::<2>();
        let nodal_at = |site: usize| match P::KIND {
            Kind::SolidForce => nodal.map(|of| &of[site..site + N * lanes]),
            _ => [&[][..]; 2],
        };
        let nodal_here = nodal_at(group);
        for (number, (vector, &word)) in self.grid.stencil.vectors.iter().zip(words).enumerate() {
            let mut xi = [limit; D];
            for k in 0..D {
                xi[k] = registers.splat(vector.xi[k]);
            }
            let inverse_square = registers.splat(vector.inverse_square);
            let factor = registers.splat(match P::KIND {
                Kind::Dilatation => self.solid.moments[number],
                Kind::PairForce | Kind::SolidForce => vector.stiffness,
            });
            let other = group + vector.offset;
            let there = self.u.map(|u| &u[other..other + N * lanes]);
            let nodal_there = nodal_at(other);
            let other = other - self.first;
            let at_other = self.sums.each_mut().map(|of| &mut of[other..other + N * lanes]);
            for register in 0..N {
                let at = register * lanes;
                // Where there is no bond, what is read instead does not count.
                // Without closures over registers: one that is not inlined is compiled without their instructions.
                let mut eta = xi;
                for k in 0..D {
                    eta[k] = registers.load_at(there[k], at) - registers.load_at(here[k], at);
                }
                let shape = (&xi, inverse_square);
                let Separation { direction, elongation } = Separation::<R::Vector, D>::new::<
                    R,
                    LINEAR,
                >(
                    registers, shape, &eta, word >> at
                );
                let own = || {
                    let at = number * GROUP + at;
                    if limits.is_empty() { limit } else { registers.load_at(limits, at) }
                };
                let w = elongation.0;
                let pull = elongation.pull::<R, LINEAR>(registers, limit, own, |reached| {
                    let lanes = (0..lanes).filter(|lane| reached & 1 << lane != 0);
                    self.reached.extend(lanes.map(|lane| (group + at + lane, number)));
                });
                let value = match P::KIND {
                    Kind::PairForce => factor * pull,
                    Kind::Dilatation => factor * stretch::<_, LINEAR>(w, pull),
                    Kind::SolidForce => {
                        let sigma = registers.load_at(nodal_here[0], at)
                            + registers.load_at(nodal_there[0], at);
                        let tau = registers.load_at(nodal_here[1], at)
                            + registers.load_at(nodal_there[1], at);
                        let tension = solid_tension_over_weight::<_, LINEAR>(sigma, tau, pull);
                        intact(registers, factor * tension, word >> at)
                    }
                };
                for k in 0..M {
                    let part = if P::IS_DILATATION { value } else { value * direction[k] };
                    sums[register][k] = sums[register][k] + part;
                    let other = registers.load_at(at_other[k], at);
                    let other = if P::IS_DILATATION { other + part } else { other - part };
                    registers.store_at(other, at_other[k], at);
                }
            }
        }
        for (register, sum) in sums.iter().enumerate() {
            let at = group + register * lanes - self.first;
            for k in 0..M {
                let here = registers.load_at(self.sums[k], at);
                registers.store_at(here + sum[k], self.sums[k], at);
            }
        }
    }
}
