//! Forces on a band of rows of a lattice, neighbouring nodes in the lanes.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::ops::Range;

use simd_lanes::{Registers, Work};

use super::LaneBits;
use super::bond_force::Separation;
use super::stencil::{GROUP, Sites, Stencil, Vector};
use crate::real::Real;

/// Rows that are computed together, each bond once: what their bonds pull with at both ends.
#[derive(Debug, Clone)]
pub(super) struct Band<T, const D: usize> {
    pub(super) rows: Range<usize>,
    /// The site that its forces begin at.
    pub(super) first: usize,
    /// Up to the last site that a bond of these rows reaches.
    pub(super) forces: Components<T, D>,
    /// Bits of intact bonds, by row, group of sites and vector.
    pub(super) intact: Vec<LaneBits>,
    /// The limit of each of these bits; empty where all bonds have one.
    pub(super) limits: Vec<T>,
    /// Site and vector of bonds found at their limit.
    pub(super) reached: Vec<(usize, usize)>,
}

impl<T: Real, const D: usize> Band<T, D> {
    pub(super) fn new(rows: Range<usize>, sites: &Sites<D>, n_vectors: usize) -> Self {
        let intact = vec![0; rows.len() * sites.groups() * n_vectors];
        let of = sites.sites_of(&rows);
        let forces = Components::new(of.len());
        Self { rows, first: of.start, forces, intact, limits: Vec::new(), reached: Vec::new() }
    }

    /// Adds what another band pulls with at sites of this one.
    pub(super) fn add(&mut self, before: &Self) {
        let at = self.first - before.first;
        for (forces, before) in self.forces.all_mut().into_iter().zip(before.forces.all()) {
            for (force, &other) in forces.iter_mut().zip(&before[at..]) {
                *force += other;
            }
        }
    }
}

/// The forces of a band.
pub(super) struct BandWork<'a, T, const D: usize, const LINEAR: bool> {
    pub(super) band: &'a mut Band<T, D>,
    pub(super) sites: &'a Sites<D>,
    pub(super) stencil: &'a Stencil<T, D>,
    pub(super) padded: &'a Components<T, D>,
    /// Below that of every bond.
    pub(super) limit: T,
    /// Whether bonds break at limits of their own, where the band has them.
    pub(super) own: bool,
}

impl<T: Real, const D: usize, const LINEAR: bool> Work<T> for BandWork<'_, T, D, LINEAR> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<T>>(self, registers: R) {
        let Self { band, sites, stencil, padded, limit, own } = self;
        let Band { rows, first, forces, intact, limits, reached } = band;
        let n_vectors = stencil.len();
        let of_row = sites.groups() * n_vectors;
        let limits = if own { &limits[..] } else { &[] };
        let mut row = Row::<T, D> {
            vectors: &stencil.vectors,
            u: padded.all(),
            first: *first,
            forces: forces.all_mut(),
            reached,
            limit,
        };
        for forces in &mut row.forces {
            forces.fill(T::ZERO);
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
                    2 if most >= 2 => row.pull::<R, LINEAR, 2>(registers, group),
                    3 if most >= 4 => row.pull::<R, LINEAR, 3>(registers, group),
                    4 if most >= 4 => row.pull::<R, LINEAR, 4>(registers, group),
                    5.. if most >= 8 => row.pull::<R, LINEAR, 8>(registers, group),
                    _ => row.pull::<R, LINEAR, 1>(registers, group),
                }
            }
        }
    }
}

/// What bonds of a row read and write.
struct Row<'a, T, const D: usize> {
    vectors: &'a [Vector<T, D>],
    u: [&'a [T]; D],
    first: usize,
    forces: [&'a mut [T]; D],
    reached: &'a mut Vec<(usize, usize)>,
    limit: T,
}

impl<T: Real, const D: usize> Row<'_, T, D> {
    /// The bonds from a group of sites on, with their words of bits, vector by vector, so that the order of sums does not depend on
    /// how long registers are; those at their limit carry no force.
    #[inline(always)]
    fn pull<R: Registers<T>, const LINEAR: bool, const N: usize>(
        &mut self,
        registers: R,
        (group, words, limits): (usize, &[LaneBits], &[T]),
    ) {
        let lanes = R::N;
        let limit = registers.splat(self.limit);
        let mut sums = [[registers.splat(T::ZERO); D]; N];
        let here = self.u.map(|u| &u[group..group + N * lanes]);
        for (number, (vector, &word)) in self.vectors.iter().zip(words).enumerate() {
            let xi = vector.xi.map(|xi| registers.splat(xi));
            let inverse_square = registers.splat(vector.inverse_square);
            let stiffness = registers.splat(vector.stiffness);
            let other = group + vector.offset;
            let there = self.u.map(|u| &u[other..other + N * lanes]);
            let other = other - self.first;
            let forces = self.forces.each_mut().map(|of| &mut of[other..other + N * lanes]);
            for register in 0..N {
                let at = register * lanes;
                // Where there is no bond, what is read instead does not count.
                let u = |of: &[&[T]; D], k: usize| registers.load_at(of[k], at);
                let eta = std::array::from_fn(|k| u(&there, k) - u(&here, k));
                let shape = (&xi, inverse_square);
                let separation = Separation::<R::Vector, D>::new::<R, LINEAR>(
                    registers,
                    shape,
                    &eta,
                    word >> at,
                );
                let own = || {
                    let at = number * GROUP + at;
                    if limits.is_empty() { limit } else { registers.load_at(limits, at) }
                };
                let pull =
                    separation.elongation.pull::<R, LINEAR>(registers, limit, own, |reached| {
                        let lanes = (0..lanes).filter(|lane| reached & 1 << lane != 0);
                        self.reached.extend(lanes.map(|lane| (group + at + lane, number)));
                    });
                let tension = stiffness * pull;
                for k in 0..D {
                    let force = tension * separation.direction[k];
                    sums[register][k] = sums[register][k] + force;
                    let other = registers.load_at(forces[k], at);
                    registers.store_at(other - force, forces[k], at);
                }
            }
        }
        for (register, sum) in sums.iter().enumerate() {
            let at = group + register * lanes - self.first;
            for k in 0..D {
                let here = registers.load_at(self.forces[k], at);
                registers.store_at(here + sum[k], self.forces[k], at);
            }
        }
    }
}

/// Numbers of sites by component, all of one length.
#[derive(Debug, Clone)]
pub(super) struct Components<T, const D: usize>(Vec<T>);

impl<T: Real, const D: usize> Components<T, D> {
    pub(super) fn new(n_sites: usize) -> Self {
        Self(vec![T::ZERO; n_sites * D])
    }

    #[inline(always)]
    pub(super) fn all(&self) -> [&[T]; D] {
        let n = self.0.len() / D;
        std::array::from_fn(|k| &self.0[k * n..(k + 1) * n])
    }

    #[inline(always)]
    pub(super) fn all_mut(&mut self) -> [&mut [T]; D] {
        let n = self.0.len() / D;
        let mut rest = &mut self.0[..];
        std::array::from_fn(|_| rest.split_off_mut(..n).unwrap_or_default())
    }
}
