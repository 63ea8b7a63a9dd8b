//! What bonds near a surface lack.

use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;

/// What is done about the bonds that a node near a surface does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceCorrection {
    /// Nothing: a body is softer at its surface.
    None,
    /// Bonds are made stiffer, so that each node has the energy of the elastic body under a strain along each axis (Madenci &
    /// Oterkus 2014, section 4.2; Le & Bobaru 2018, "energy method").
    ///
    /// With the energy `W_ik` of node `i` by its own bonds under a small strain along axis `k`, the energy `W` of the elastic
    /// body under it, and the unit vector `n` along a bond,
    ///
    /// $$ S_{ik} = \frac{W}{W_{ik}}, \qquad g_{ij} = \left( \sum_k \frac{n_k^2}{\bar S_k^2} \right)^{-1/2}, \qquad \bar S_k = \frac{S_{ik} + S_{jk}}{2} , $$
    ///
    /// and the stiffness of the bond becomes `g` times what it was. The energy that nodes are held against is the continuum's,
    /// not that of a lattice without surfaces, so that points of any arrangement have it. In the interior of a square or cubic
    /// lattice `g` is therefore one number, which takes away the error of the lattice along its axes: 1/1.037 for 3 shells in
    /// plane stress without a volume correction.
    ///
    /// It overcorrects: a narrow plate becomes half as much too stiff as it was too soft. In a body some 20 nodes wide the errors
    /// of lattice and surface may cancel without it.
    Energy,
}

/// The factor `g` of each bond.
pub(crate) fn factors<const D: usize>(
    nodes: &Nodes<D>,
    bonds: &Bonds,
    young_modulus: f64,
) -> Vec<f64> {
    factors_of(nodes, bonds, &relative_energies(nodes, bonds, young_modulus))
}

/// The factor of each bond that makes numbers of nodes, one for each axis, equal to 1.
pub(crate) fn factors_of<const D: usize>(
    nodes: &Nodes<D>,
    bonds: &Bonds,
    relative: &[[f64; D]],
) -> Vec<f64> {
    let pairs = bonds.pairs().zip(bonds.all());
    let factor = |((i, j), bond): ((usize, usize), &crate::Bond)| {
        let n = direction(nodes, (i, j), bond.length);
        let mut square = 0.0;
        for k in 0..D {
            // 1/S of the mean of both S: no division by the energy of an axis along which a node has no bond.
            let (one, two) = (relative[i][k], relative[j][k]);
            let inverse = if one + two > 0.0 { 2.0 * one * two / (one + two) } else { 0.0 };
            square += (n[k] * inverse).powi(2);
        }
        1.0 / square.sqrt()
    };
    pairs.map(factor).collect()
}

/// `W_ik/W` of each node, for each axis.
fn relative_energies<const D: usize>(
    nodes: &Nodes<D>,
    bonds: &Bonds,
    young_modulus: f64,
) -> Vec<[f64; D]> {
    let elastic = nodes.condition().energy_of_uniaxial_strain() * young_modulus;
    let mut energies = vec![[0.0; D]; bonds.n_nodes()];
    for ((i, j), bond) in bonds.pairs().zip(bonds.all()) {
        let n = direction(nodes, (i, j), bond.length);
        for k in 0..D {
            // The stretch under a unit strain along k is n_k^2; half of the energy of the bond belongs to each end.
            let energy = 0.25 * bond.stiffness * bond.length * n[k].powi(4);
            energies[i][k] += energy;
            energies[j][k] += energy;
        }
    }
    for (energy, volume) in energies.iter_mut().zip(nodes.volumes()) {
        *energy = energy.map(|energy| energy / (elastic * volume));
    }
    energies
}

/// From the first node of a bond to the second, of length one.
pub(crate) fn direction<const D: usize>(
    nodes: &Nodes<D>,
    (i, j): (usize, usize),
    length: f64,
) -> [f64; D] {
    let x = nodes.positions();
    std::array::from_fn(|k| (x[j][k] - x[i][k]) / length)
}
