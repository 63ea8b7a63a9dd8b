//! Dilatation of and forces on a list of bonds of a linear peridynamic solid in one realisation: the bonds of a node are gathered into
//! registers, as those of a [`BondList`](crate::fast::lists::list::BondList) are.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::{MOST_LANES, Registers, Work};

use super::solid_lanes::SolidColumns;
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::BrokenBond;
use crate::fast::limit::Limit;
use crate::fast::lists::list_rows::{BATCH, Batch, Padded, RowColumns, in_batches};
use crate::real::Real;

/// What the first pass leaves to the second.
#[derive(Debug, Clone)]
pub(in crate::fast) struct OneRealisation<T> {
    padded: Padded<T>,
    /// Of each bond, `1 - 1/sqrt(1 + w)`, or `w/2` where strains are linear.
    pulls: Vec<T>,
}

impl<T: Real> OneRealisation<T> {
    pub(in crate::fast) fn new<const D: usize>(nodes: &Nodes<D>, bonds: &Bonds) -> Self {
        // Registers that begin at the last bonds end within the column.
        Self { padded: Padded::new(nodes), pulls: vec![T::ZERO; bonds.len() + MOST_LANES] }
    }
}

/// The first pass: `sum omega beta V_i V_j |xi|^2 s` of each node.
pub(in crate::fast) struct SumRows<'a, T, const D: usize, const LINEAR: bool> {
    pub(in crate::fast) bonds: &'a Bonds,
    pub(in crate::fast) columns: &'a SolidColumns<T>,
    pub(in crate::fast) one: &'a mut OneRealisation<T>,
    pub(in crate::fast) u: &'a [T],
    pub(in crate::fast) sums: &'a mut [T],
    pub(in crate::fast) limit: Limit,
    /// Bonds found at their limit, which are to be left out in another pass.
    pub(in crate::fast) reached: &'a mut Vec<BrokenBond>,
}

impl<T: Real, const D: usize, const LINEAR: bool> Work<T> for SumRows<'_, T, D, LINEAR> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<T>>(self, registers: R) {
        let Self { bonds, columns, one: OneRealisation { padded, pulls }, .. } = self;
        let SolidColumns { inverse_squares, moments, limits, .. } = columns;
        let columns = RowColumns { inverse_squares, factors: moments, limits };
        let mut batch = Batch::new();
        padded.begin::<D>(self.u);
        self.sums.fill(T::ZERO);
        for (i, some) in in_batches(bonds) {
            let partners = bonds.partners(some.clone());
            padded.gather::<LINEAR>(&mut batch, i, partners);
            let pulls = &mut pulls[some.start..];
            let part = |at, [w, pull, moment]: [R::Vector; 3]| {
                // Beyond the row they are those of bonds that come later.
                registers.store_at(pull, pulls, at);
                // sqrt(1 + w) - 1 = (1 + w) (1 - p) - 1.
                let stretch = if LINEAR { pull } else { w - (pull + w * pull) };
                moment * stretch
            };
            let some = (some, self.limit);
            batch.compute::<R, D, LINEAR>(registers, &columns, some, self.reached, part);
            let mut sum = T::ZERO;
            for (&part, &j) in batch.tensions.iter().zip(partners) {
                sum += part;
                self.sums[j as usize] += part;
            }
            self.sums[i] += sum;
        }
    }
}

/// The second: forces under the displacements of the first.
pub(in crate::fast) struct ForceRows<'a, T, const D: usize, const LINEAR: bool> {
    pub(in crate::fast) bonds: &'a Bonds,
    pub(in crate::fast) columns: &'a SolidColumns<T>,
    pub(in crate::fast) one: &'a mut OneRealisation<T>,
    pub(in crate::fast) u: &'a [T],
    /// `tau = D A theta/m` of each node.
    pub(in crate::fast) tau: &'a [T],
    pub(in crate::fast) forces: &'a mut [T],
}

impl<T: Real, const D: usize, const LINEAR: bool> Work<T> for ForceRows<'_, T, D, LINEAR> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<T>>(self, registers: R) {
        let Self { bonds, columns, one: OneRealisation { padded, pulls }, u, tau, forces } = self;
        let (mut batch, mut of_partners) = (Batch::new(), [T::ZERO; BATCH]);
        padded.begin::<D>(u);
        for (i, some) in in_batches(bonds) {
            let partners = bonds.partners(some.clone());
            padded.gather::<LINEAR>(&mut batch, i, partners);
            for (of, &j) in of_partners.iter_mut().zip(partners) {
                *of = tau[j as usize];
            }
            let tau_i = registers.splat(tau[i]);
            let filled = some.start..some.start + some.len().next_multiple_of(R::N);
            let [pulls, stiffness, weights] = [pulls, &columns.stiffness, &columns.weights]
                .map(|column| column[filled.clone()].chunks_exact(R::N));
            let tensions = batch.tensions.chunks_exact_mut(R::N);
            let blocks = tensions.zip(of_partners.chunks_exact(R::N)).zip(pulls);
            for (((tensions, tau_j), pulls), (stiffness, weights)) in
                blocks.zip(stiffness.zip(weights))
            {
                let load = |values: &[T]| registers.load_at(values, 0);
                let of_dilatation = load(weights) * (tau_i + load(tau_j));
                // With linear strains the tension of the dilatation acts along xi at rest.
                let own = if LINEAR { load(stiffness) } else { load(stiffness) - of_dilatation };
                registers.store_at(own * load(pulls) + of_dilatation, tensions, 0);
            }
            padded.scatter(&batch, i, partners);
        }
        padded.end::<D>(forces);
    }
}
