//! Dilatation of and forces on a band of rows of a lattice of a linear peridynamic solid, neighbouring nodes in the lanes.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::{Lanes, MOST_LANES, Registers, Work};

use crate::fast::LaneBits;
use crate::fast::bond_force::Separation;
use crate::fast::lattice_rows::{Band, Components};
use crate::fast::stencil::{GROUP, Sites, Stencil, Vector};
use crate::real::Real;

/// Rows that are computed together, with the sums of their dilatations.
#[derive(Debug, Clone)]
pub(in crate::fast) struct SolidBand<T, const D: usize> {
    pub(in crate::fast) band: Band<T, D>,
    /// `sum phi |xi|^2 s`, over the sites of its forces.
    pub(in crate::fast) sums: Components<T, 1>,
}

impl<T: Real, const D: usize> SolidBand<T, D> {
    pub(in crate::fast) fn new(band: Band<T, D>) -> Self {
        let sums = Components::new(band.forces.all()[0].len());
        Self { band, sums }
    }

    /// Adds what bonds of another band add to dilatations at sites of this one.
    pub(in crate::fast) fn add_sums(&mut self, before: &Self) {
        let at = self.band.first - before.band.first;
        let ([sums], [before]) = (self.sums.all_mut(), before.sums.all());
        for (sum, &other) in sums.iter_mut().zip(&before[at..]) {
            *sum += other;
        }
    }
}

/// What both passes read.
#[derive(Clone, Copy)]
pub(in crate::fast) struct Shared<'a, T, const D: usize> {
    pub(in crate::fast) sites: &'a Sites<D>,
    pub(in crate::fast) stencil: &'a Stencil<T, D>,
    /// `phi |xi|^2` of each vector.
    pub(in crate::fast) moments: &'a [T],
    pub(in crate::fast) padded: &'a Components<T, D>,
    /// `B/m - tau` and `tau` of each site.
    pub(in crate::fast) nodal: &'a Components<T, 2>,
}

/// The first pass: `sum phi |xi|^2 s` at both ends of bonds.
pub(in crate::fast) struct SumWork<'a, T, const D: usize, const LINEAR: bool> {
    pub(in crate::fast) shared: Shared<'a, T, D>,
    pub(in crate::fast) band: &'a mut SolidBand<T, D>,
    pub(in crate::fast) limit: T,
}

/// The second: forces at both ends, `phi ((sigma_i + sigma_j) p + tau_i + tau_j)` along `xi + eta`, with the pull
/// `p = 1 - 1/sqrt(1 + w)` and `sigma = B/m - tau`.
pub(in crate::fast) struct ForceWork<'a, T, const D: usize, const LINEAR: bool> {
    pub(in crate::fast) shared: Shared<'a, T, D>,
    pub(in crate::fast) band: &'a mut SolidBand<T, D>,
}

/// Calls a function with the registers that a group of sites needs as a known number, so that loops over them are unrolled.
macro_rules! in_groups {
    ($sites:expr, $band:expr, $n_vectors:expr, |$start:ident, $words:ident, $n:ident| $call:expr) => {
        let of_row = $sites.groups() * $n_vectors;
        let rows = $sites.rows()[$band.rows.clone()].iter();
        for (&first, intact) in rows.zip($band.intact.chunks_exact(of_row)) {
            // A row without nodes has no place.
            let words = intact.chunks_exact($n_vectors).filter(|_| first > 0);
            for (at, $words) in (0..$sites.width()).step_by(GROUP).zip(words) {
                let $start = first + at;
                let most = GROUP / R::N;
                match ($sites.width() - at).min(GROUP).div_ceil(R::N) {
                    2 if most >= 2 => {
                        const $n: usize = 2;
                        $call
                    }
                    3 if most >= 4 => {
                        const $n: usize = 3;
                        $call
                    }
                    4 if most >= 4 => {
                        const $n: usize = 4;
                        $call
                    }
                    5.. if most >= 8 => {
                        const $n: usize = 8;
                        $call
                    }
                    _ => {
                        const $n: usize = 1;
                        $call
                    }
                }
            }
        }
    };
}

impl<T: Real, const D: usize, const LINEAR: bool> Work<T> for SumWork<'_, T, D, LINEAR> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<T>>(self, registers: R) {
        let Self { shared, band: SolidBand { band, sums }, limit } = self;
        let ([sums], n_vectors, reached) =
            (sums.all_mut(), shared.stencil.len(), &mut band.reached);
        sums.fill(T::ZERO);
        let mut row = SumRow { shared, first: band.first, sums, reached, limit };
        in_groups!(shared.sites, band, n_vectors, |start, words, N| row
            .add::<R, LINEAR, N>(registers, (start, words)));
    }
}

/// Where a row of the first pass adds.
struct SumRow<'a, T, const D: usize> {
    shared: Shared<'a, T, D>,
    first: usize,
    sums: &'a mut [T],
    reached: &'a mut Vec<(usize, usize)>,
    limit: T,
}

impl<T: Real, const D: usize> SumRow<'_, T, D> {
    #[inline(always)]
    fn add<R: Registers<T>, const LINEAR: bool, const N: usize>(
        &mut self,
        registers: R,
        (group, words): (usize, &[LaneBits]),
    ) {
        let lanes = R::N;
        let limit = registers.splat(self.limit);
        let mut sums = [registers.splat(T::ZERO); N];
        let u = self.shared.padded.all();
        let here = u.map(|u| &u[group..group + N * lanes]);
        let vectors = self.shared.stencil.vectors.iter().zip(self.shared.moments).zip(words);
        for (number, ((vector, &moment), &word)) in vectors.enumerate() {
            let constants = Constants::<_, D>::new(registers, vector);
            let moment = registers.splat(moment);
            let other = group + vector.offset;
            let there = u.map(|u| &u[other..other + N * lanes]);
            let other = other - self.first;
            let of_other = &mut self.sums[other..other + N * lanes];
            for (register, sum) in sums.iter_mut().enumerate() {
                let at = register * lanes;
                let Separation { elongation, .. } =
                    constants.separation::<T, R, LINEAR>(registers, (&here, &there), at, word);
                let w = elongation.0;
                let pull = elongation.pull::<R, LINEAR>(
                    registers,
                    limit,
                    || limit,
                    |reached| {
                        let lanes = (0..lanes).filter(|lane| reached & 1 << lane != 0);
                        self.reached.extend(lanes.map(|lane| (group + at + lane, number)));
                    },
                );
                // sqrt(1 + w) - 1 = (1 + w) (1 - p) - 1.
                let stretch = if LINEAR { pull } else { w - (pull + w * pull) };
                let part = moment * stretch;
                *sum = *sum + part;
                let of = registers.load_at(of_other, at);
                registers.store_at(of + part, of_other, at);
            }
        }
        for (register, &sum) in sums.iter().enumerate() {
            let at = group + register * lanes - self.first;
            let here = registers.load_at(self.sums, at);
            registers.store_at(here + sum, self.sums, at);
        }
    }
}

impl<T: Real, const D: usize, const LINEAR: bool> Work<T> for ForceWork<'_, T, D, LINEAR> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<T>>(self, registers: R) {
        let Self { shared, band: SolidBand { band, .. } } = self;
        let (n_vectors, first) = (shared.stencil.len(), band.first);
        let mut forces = band.forces.all_mut();
        for forces in &mut forces {
            forces.fill(T::ZERO);
        }
        let mut row = ForceRow { shared, first, forces };
        in_groups!(shared.sites, band, n_vectors, |start, words, N| row
            .pull::<R, LINEAR, N>(registers, (start, words)));
    }
}

/// Where a row of the second pass adds.
struct ForceRow<'a, T, const D: usize> {
    shared: Shared<'a, T, D>,
    first: usize,
    forces: [&'a mut [T]; D],
}

impl<T: Real, const D: usize> ForceRow<'_, T, D> {
    #[inline(always)]
    fn pull<R: Registers<T>, const LINEAR: bool, const N: usize>(
        &mut self,
        registers: R,
        (group, words): (usize, &[LaneBits]),
    ) {
        let lanes = R::N;
        // Bonds at their strength were found in the first pass, and are broken in this one.
        let limit = registers.splat(T::LARGEST);
        let mut sums = [[registers.splat(T::ZERO); D]; N];
        let (u, nodal) = (self.shared.padded.all(), self.shared.nodal.all());
        let here = u.map(|u| &u[group..group + N * lanes]);
        let nodal_here = nodal.map(|of| &of[group..group + N * lanes]);
        for (vector, &word) in self.shared.stencil.vectors.iter().zip(words) {
            let constants = Constants::<_, D>::new(registers, vector);
            let stiffness = registers.splat(vector.stiffness);
            let other = group + vector.offset;
            let there = u.map(|u| &u[other..other + N * lanes]);
            let nodal_there = nodal.map(|of| &of[other..other + N * lanes]);
            let other = other - self.first;
            let forces = self.forces.each_mut().map(|of| &mut of[other..other + N * lanes]);
            for (register, sums) in sums.iter_mut().enumerate() {
                let at = register * lanes;
                let Separation { direction, elongation } =
                    constants.separation::<T, R, LINEAR>(registers, (&here, &there), at, word);
                let pull = elongation.pull::<R, LINEAR>(registers, limit, || limit, |_| ());
                let both = |k: usize| {
                    registers.load_at(nodal_here[k], at) + registers.load_at(nodal_there[k], at)
                };
                // With linear strains the tension of the dilatation acts along xi at rest.
                let own = if LINEAR { (both(0) + both(1)) * pull } else { both(0) * pull };
                let tension = intact(registers, stiffness * (own + both(1)), word >> at);
                for k in 0..D {
                    let force = tension * direction[k];
                    sums[k] = sums[k] + force;
                    let of = registers.load_at(forces[k], at);
                    registers.store_at(of - force, forces[k], at);
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

/// A number of bonds, zero where they are broken.
#[inline(always)]
pub(in crate::fast) fn intact<T: Real, R: Registers<T>>(
    registers: R,
    of: R::Vector,
    word: LaneBits,
) -> R::Vector {
    let all = LaneBits::MAX >> (MOST_LANES - R::N);
    if R::MASKS_ARE_BITS || word & all != all {
        return R::Vector::select(registers.mask(word.into()), of, registers.splat(T::ZERO));
    }
    of
}

/// The vector of bonds in registers.
struct Constants<V, const D: usize> {
    xi: [V; D],
    inverse_square: V,
}

impl<V: Lanes<Number: Real>, const D: usize> Constants<V, D> {
    #[inline(always)]
    fn new<T: Real, R: Registers<T, Vector = V>>(registers: R, vector: &Vector<T, D>) -> Self
    where
        V: Lanes<Number = T>,
    {
        let inverse_square = registers.splat(vector.inverse_square);
        Self { xi: vector.xi.map(|xi| registers.splat(xi)), inverse_square }
    }

    /// Of bonds from a place in some sites to the same place in others.
    #[inline(always)]
    fn separation<T: Real, R: Registers<T, Vector = V>, const LINEAR: bool>(
        &self,
        registers: R,
        (here, there): (&[&[T]; D], &[&[T]; D]),
        at: usize,
        word: LaneBits,
    ) -> Separation<V, D>
    where
        V: Lanes<Number = T>,
    {
        let load = |of: &[&[T]; D], k: usize| registers.load_at(of[k], at);
        // Where there is no bond, what is read instead does not count.
        let eta = std::array::from_fn(|k| load(there, k) - load(here, k));
        let shape = (&self.xi, self.inverse_square);
        Separation::new::<R, LINEAR>(registers, shape, &eta, word >> at)
    }
}
