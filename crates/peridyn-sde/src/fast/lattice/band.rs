//! Rows of a lattice that are computed together, with the sums over their bonds.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::ops::Range;

use super::stencil::Sites;
use crate::fast::LaneBits;
use crate::fast::bond_force::Pass;
use crate::real::Real;

/// Rows that are computed together, each bond once: the sums over their bonds at both ends.
#[derive(Debug, Clone)]
pub(super) struct Band<T> {
    pub(super) rows: Range<usize>,
    /// The first site of its sums. They reach up to the last site of a bond of these rows.
    pub(super) first: usize,
    pub(super) forces: Components<T>,
    /// `sum phi |xi|^2 s` of a linear peridynamic solid, empty for others.
    pub(super) dilatations: Components<T>,
    /// Bits of intact bonds, by row, group of sites and vector.
    pub(super) intact: Vec<LaneBits>,
    /// The limit of each of these bits; empty where all bonds have one.
    pub(super) limits: Vec<T>,
    /// Site and vector of bonds found at their limit.
    pub(super) reached: Vec<(usize, usize)>,
}

impl<T: Real> Band<T> {
    pub(super) fn new<const D: usize>(
        rows: Range<usize>,
        all: &Sites<D>,
        n_vectors: usize,
        is_solid: bool,
    ) -> Self {
        let sites = all.sites_of(&rows);
        Self {
            intact: vec![0; rows.len() * all.groups() * n_vectors],
            rows,
            first: sites.start,
            forces: Components::new(sites.len(), D),
            dilatations: Components::new(if is_solid { sites.len() } else { 0 }, 1),
            limits: Vec::new(),
            reached: Vec::new(),
        }
    }

    /// The sums of a pass.
    fn sums<P: Pass>(&mut self) -> &mut Components<T> {
        if P::IS_DILATATION { &mut self.dilatations } else { &mut self.forces }
    }

    /// Adds the sums of another band at sites of this one, with `M` numbers to a site.
    pub(super) fn add<P: Pass, const M: usize>(&mut self, before: &mut Self) {
        let at = self.first - before.first;
        let before = before.sums::<P>().all::<M>();
        for (sums, before) in self.sums::<P>().all_mut::<M>().into_iter().zip(before) {
            for (sum, &other) in sums.iter_mut().zip(&before[at..]) {
                *sum += other;
            }
        }
    }
}

/// Numbers of sites by component, all of one length.
#[derive(Debug, Clone)]
pub(super) struct Components<T>(Vec<T>);

impl<T: Real> Components<T> {
    pub(super) fn new(n_sites: usize, n_components: usize) -> Self {
        Self(vec![T::ZERO; n_sites * n_components])
    }

    #[inline(always)]
    pub(super) fn all<const M: usize>(&self) -> [&[T]; M] {
        let n = self.0.len() / M;
        std::array::from_fn(|k| &self.0[k * n..(k + 1) * n])
    }

    #[inline(always)]
    pub(super) fn all_mut<const M: usize>(&mut self) -> [&mut [T]; M] {
        let n = self.0.len() / M;
        let mut rest = &mut self.0[..];
        std::array::from_fn(|_| rest.split_off_mut(..n).unwrap_or_default())
    }
}
