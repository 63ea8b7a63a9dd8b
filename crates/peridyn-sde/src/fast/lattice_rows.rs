//! Forces on a band of rows of a lattice, neighbouring nodes in the lanes.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::pull::{Growth, Separation};
use super::stencil::{GROUP, Sites, Stencil, Vector};
use super::vectors::{MOST_LANES, Mask};
use crate::real::Real;

/// Rows that are computed together, each bond once: what their bonds pull with at both ends.
#[derive(Debug, Clone)]
pub(super) struct Band<T, const D: usize> {
    pub(super) rows: Range<usize>,
    /// The site that its forces begin at.
    pub(super) first: usize,
    /// Up to the last site that a bond of these rows reaches.
    pub(super) forces: Components<T, D>,
    /// Bits of whole bonds, by row, group of sites and vector.
    pub(super) whole: Vec<Mask>,
    /// Site and vector of bonds that broke.
    pub(super) broken: Vec<(usize, usize)>,
}

impl<T: Real, const D: usize> Band<T, D> {
    pub(super) fn new(rows: Range<usize>, sites: &Sites<D>, n_vectors: usize) -> Self {
        let whole = vec![0; rows.len() * sites.groups() * n_vectors];
        let of = sites.sites_of(&rows);
        let forces = Components::new(of.len());
        Self { rows, first: of.start, forces, whole, broken: Vec::new() }
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
    pub(super) limit: T,
}

impl<T: Real, const D: usize, const LINEAR: bool> WithSimd for BandWork<'_, T, D, LINEAR> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { band, sites, stencil, padded, limit } = self;
        let Band { rows, first, forces, whole, broken } = band;
        let n_vectors = stencil.len();
        let of_row = sites.groups() * n_vectors;
        let mut row = Row::<T, D> {
            vectors: &stencil.vectors,
            u: padded.all(),
            first: *first,
            forces: forces.all_mut(),
            broken,
            limit,
        };
        for forces in &mut row.forces {
            forces.fill(T::ZERO);
        }
        for (&start, whole) in sites.rows()[rows.clone()].iter().zip(whole.chunks_exact_mut(of_row))
        {
            // A row without nodes has no place.
            let words = whole.chunks_exact_mut(n_vectors).filter(|_| start > 0);
            for (at, words) in (0..sites.width()).step_by(GROUP).zip(words) {
                let group = (start + at, words);
                // As a number that is known, so that loops over registers are unrolled.
                match (sites.width() - at).min(GROUP).div_ceil(T::lanes::<S>()) {
                    0 | 1 => row.pull::<S, LINEAR, 1>(simd, group),
                    2 => row.pull::<S, LINEAR, 2>(simd, group),
                    3 => row.pull::<S, LINEAR, 3>(simd, group),
                    4 => row.pull::<S, LINEAR, 4>(simd, group),
                    _ => row.pull::<S, LINEAR, 8>(simd, group),
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
    broken: &'a mut Vec<(usize, usize)>,
    limit: T,
}

impl<T: Real, const D: usize> Row<'_, T, D> {
    /// The bonds from a group of sites on, with their words of bits, vector by vector, so that the order of sums does not depend on
    /// how long registers are; those at their limit break.
    #[inline(always)]
    fn pull<S: Simd, const LINEAR: bool, const N: usize>(
        &mut self,
        simd: S,
        (group, words): (usize, &mut [Mask]),
    ) {
        let lanes = T::lanes::<S>();
        let near = Growth::<T, S>::near::<LINEAR>(simd, T::splat(simd, self.limit));
        let mut sums = [[T::splat(simd, T::ZERO); D]; N];
        let here = self.u.map(|u| &u[group..group + N * lanes]);
        for (number, (vector, word)) in self.vectors.iter().zip(words).enumerate() {
            let xi = vector.xi.map(|xi| T::splat(simd, xi));
            let inverse_square = T::splat(simd, vector.inverse_square);
            let stiffness = T::splat(simd, vector.stiffness);
            let other = group + vector.offset;
            let there = self.u.map(|u| &u[other..other + N * lanes]);
            let other = other - self.first;
            let forces = self.forces.each_mut().map(|of| &mut of[other..other + N * lanes]);
            for register in 0..N {
                let at = register * lanes;
                // Where there is no bond, what is read instead does not count.
                let u = |of: &[&[T]; D], k: usize| T::load::<S>(of[k], at);
                let eta = std::array::from_fn(|k| T::minus(simd, u(&there, k), u(&here, k)));
                let shape = (&xi, inverse_square);
                let separation =
                    Separation::<T, S, D>::new::<LINEAR>(simd, shape, &eta, *word >> at);
                let mut pull = separation.growth.near_pull::<LINEAR>(simd);
                if T::any_beyond(simd, separation.growth.0, near) {
                    let mut values = [T::ZERO; MOST_LANES];
                    T::store::<S>(separation.growth.0, &mut values, 0);
                    let (word, broken) = (&mut *word, &mut *self.broken);
                    let (limit, of) = (self.limit, (group, at, number));
                    let values_of = &mut values;
                    simd.vectorize(Far::<T, LINEAR> { values: values_of, limit, word, broken, of });
                    pull = T::load::<S>(&values, 0);
                }
                let tension = T::times(simd, stiffness, pull);
                for k in 0..D {
                    let force = T::times(simd, tension, separation.direction[k]);
                    sums[register][k] = T::plus(simd, sums[register][k], force);
                    let other = T::load::<S>(forces[k], at);
                    T::store::<S>(T::minus(simd, other, force), forces[k], at);
                }
            }
        }
        for (register, sum) in sums.iter().enumerate() {
            let at = group + register * lanes - self.first;
            for k in 0..D {
                let here = T::load::<S>(self.forces[k], at);
                T::store::<S>(T::plus(simd, here, sum[k]), self.forces[k], at);
            }
        }
    }
}

/// A register whose bonds are not all near, as a function of its own: the rest does not share its registers with it.
struct Far<'a, T, const LINEAR: bool> {
    /// How far bonds have grown, then what they pull with.
    values: &'a mut [T; MOST_LANES],
    limit: T,
    word: &'a mut Mask,
    broken: &'a mut Vec<(usize, usize)>,
    /// Group, place in the group, and number of the vector.
    of: (usize, usize, usize),
}

impl<T: Real, const LINEAR: bool> WithSimd for Far<'_, T, LINEAR> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (group, at, number) = self.of;
        let mut growth = Growth::<T, S>(T::load::<S>(self.values, 0));
        let pull = growth.pull::<LINEAR>(simd, T::splat(simd, self.limit), |reached| {
            *self.word &= !(reached << at);
            for lane in (0..T::lanes::<S>()).filter(|lane| reached & 1 << lane != 0) {
                self.broken.push((group + at + lane, number));
            }
        });
        T::store::<S>(pull, self.values, 0);
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
