//! The energy of a linear peridynamic solid in a lane, one bond after the other.

use super::bonds::SolidBonds;
use crate::body::Body;
use crate::real::Real;

/// `sum V_i W_i` over the intact bonds (energy).
pub(crate) fn energy<T: Real, const D: usize, const L: usize>(
    body: &dyn Body<T, D, L>,
    solid: &SolidBonds,
    u: &[T],
    lane: usize,
) -> f64 {
    let (bonds, weights) = (solid.bonds(), solid.weights());
    let (mut sums, mut energy) = (vec![0.0; bonds.n_nodes()], 0.0);
    for (bond, ((i, j), of)) in bonds.pairs().zip(bonds.all()).enumerate() {
        if body.intact(bond) & 1 << lane != 0 {
            let stretch = body.stretch(bond, (i, j), u, lane);
            energy += 0.5 * of.stiffness * of.length * stretch * stretch;
            let part = weights[bond] * of.length * of.length * stretch;
            sums[i] += part;
            sums[j] += part;
        }
    }
    let of_nodes = solid.nodal().iter().zip(&sums).map(|(n, sum)| 0.5 * n * sum * sum);
    energy + of_nodes.sum::<f64>()
}
