//! Forces that are linear in the displacements, bond by bond.

use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::error::{Error, same_length};
use crate::real::Real;

/// Forces under small displacements `v` from rest; a bond has the stiffness of [`Bonds`] times the factor of its number and
/// lane.
pub(crate) fn linear_pull<T: Real, const D: usize, const L: usize>(
    nodes: &Nodes<D>,
    bonds: &Bonds,
    factor: impl Fn(usize, usize) -> f64,
    v: &[T],
    forces: &mut [T],
) -> Result<(), Error> {
    same_length("displacements", v.len(), bonds.n_nodes() * D * L)?;
    same_length("forces", forces.len(), v.len())?;
    forces.fill(T::ZERO);
    let x = nodes.positions();
    for (bond, ((i, j), of)) in bonds.pairs().zip(bonds.all()).enumerate() {
        let inverse = 1.0 / of.length;
        let e: [f64; D] = std::array::from_fn(|k| inverse * (x[j][k] - x[i][k]));
        for lane in 0..L {
            let at = |node: usize, k: usize| (node * D + k) * L + lane;
            let elongation: f64 = (0..D).map(|k| e[k] * (v[at(j, k)] - v[at(i, k)]).to_f64()).sum();
            let tension = of.stiffness * factor(bond, lane) * inverse * elongation;
            for k in 0..D {
                let force = T::of(tension * e[k]);
                forces[at(i, k)] += force;
                forces[at(j, k)] -= force;
            }
        }
    }
    Ok(())
}
