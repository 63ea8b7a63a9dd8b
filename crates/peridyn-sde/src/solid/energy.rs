//! The energy of a linear peridynamic solid, one bond after the other.

use super::bonds::SolidBonds;
use crate::bodies::body::Body;
use crate::real::Real;

impl SolidBonds {
    /// The energy `V_i W_i` of each node of a body of these bonds in a lane (energy), over the intact bonds.
    ///
    /// Each end of a bond takes a share, inverse to its weighted volume, of the part that the bond has in the sum of all.
    ///
    /// # Panics
    /// For displacements `u` (length) or bonds of another body.
    #[must_use]
    pub fn energies<T: Real, const D: usize, const L: usize>(
        &self,
        body: &dyn Body<T, D, L>,
        u: &[T],
        lane: usize,
    ) -> Vec<f64> {
        let (bonds, weights, m) = (self.bonds(), self.weights(), self.weighted_volumes());
        let mut sums = vec![0.0; bonds.n_nodes()];
        let mut energies = sums.clone();
        for (bond, ((i, j), of)) in bonds.pairs().zip(bonds.all()).enumerate() {
            if body.intact(bond) & 1 << lane != 0 {
                let stretch = body.stretch(bond, (i, j), u, lane);
                let energy = 0.5 * of.stiffness * of.length * stretch * stretch;
                energies[i] += energy * m[j] / (m[i] + m[j]);
                energies[j] += energy * m[i] / (m[i] + m[j]);
                let part = weights[bond] * of.length * of.length * stretch;
                sums[i] += part;
                sums[j] += part;
            }
        }
        for ((energy, n), sum) in energies.iter_mut().zip(self.nodal()).zip(sums) {
            *energy += 0.5 * n * sum * sum;
        }
        energies
    }
}
