//! Constants of the linear peridynamic solid, bond by bond and node by node.

use crate::bodies::bond_config::BondConfig;
use crate::bodies::bonds::{Bond, Bonds};
use crate::bodies::nodes::Nodes;
use crate::bodies::surface::SurfaceCorrection;
use crate::error::Error;

use super::moduli::Moduli;
use super::surface::{check, factors};

/// Bonds of a linear peridynamic solid (ordinary state-based; Silling et al. 2007, section 15), in one to three dimensions.
///
/// With the elongation `e = |xi + eta| - |xi|` of a bond, the influence `omega`, the share `beta` of a volume at the horizon, and
/// the weighted volume `m` and the dilatation `theta` of a node,
///
/// $$ m_i = \sum_j \omega \beta |\xi|^2 V_j, \qquad \theta_i = \frac{D}{m_i} \sum_j \omega \beta |\xi| e V_j, $$
///
/// the energy density of a node is
///
/// $$ W_i = \frac{A}{2} \theta_i^2 + \frac{B}{2 m_i} \sum_j \omega \beta e^2 V_j, \qquad B = D (D + 2) G, \quad A = \Lambda - G $$
///
/// and the tension of a bond minus the derivative of `sum_i V_i W_i` with respect to `e`:
///
/// $$ t_{ij} = \omega \beta V_i V_j \left( D A |\xi| \left( \frac{\theta_i}{m_i} + \frac{\theta_j}{m_j} \right) + B e \left( \frac{1}{m_i} + \frac{1}{m_j} \right) \right) . $$
///
/// `G` is the shear modulus, and `Lambda` the Lamé constant of the [`Condition`](crate::Condition) after strains across are eliminated: `2 G nu/(1 - 2 nu)`
/// in three dimensions and plane strain, `2 G nu/(1 - nu)` in plane stress, `2 G nu` for a bar. `theta` is the trace of the strain
/// in the `D` dimensions of the body. In three dimensions `D A = 3 K - 5 G` and `B = 15 G`, as in Silling et al.; in two they are
/// those of Le, Chan & Schwartz 2014. A homogeneous deformation of the interior has the energy of the elastic body (of a lattice:
/// for each mean extension exactly, for shear within its anisotropy). In a bar that energy depends on `E` alone.
///
/// `omega = (delta/|xi|) omega(|xi|/delta)` with the [`Influence`](crate::Influence) of the configuration: where `Lambda = G`, that is
/// `nu = 1/4`, in plane stress `1/3`, the law is that of bonds with the same influence, times the ratio of the continuum's
/// weighted volume to the node's. [`Influence::Constant`](crate::Influence::Constant) with
/// [`VolumeCorrection::Partial`](crate::VolumeCorrection::Partial) is `peri/lps` of LAMMPS.
///
/// **When bonds break**, they leave the dilatation and both sums over bonds. The weighted volume keeps its value at rest, as in
/// LAMMPS: a node that has lost bonds is softer, its energy only falls, and forces remain minus the gradient of the energy. With a
/// weighted volume of the remaining bonds, the few bonds left would take over the stiffness of those lost: a node with a single
/// bond would be as stiff as one inside the body, and the force would not vanish with the last bond.
///
/// **Near a surface**, `m` is that of the node's own bonds, which are therefore stiffer: in itself a surface correction by volume
/// (Le & Bobaru 2018). [`SurfaceCorrection::Energy`] multiplies `omega beta`, but in `m`, by a factor of each bond. Each node then
/// has the dilatation 1 under a unit strain along each axis (Madenci & Oterkus 2014, section 4.2), and the energy of the elastic
/// body under a mean extension. In the interior of a square or cubic lattice the factor is 1.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidBonds {
    /// With the tension over the stretch at a fixed dilatation as stiffness.
    bonds: Bonds,
    /// For each bond `omega beta V_i V_j`, times the factor of the surface correction.
    weights: Vec<f64>,
    /// For each node `D^2 A/(m^2 V)`.
    nodal: Vec<f64>,
    weighted_volumes: Vec<f64>,
    /// `B` (stress).
    b: f64,
}

impl SolidBonds {
    /// Bonds all nodes within the horizon of each other.
    ///
    /// # Errors
    /// [`Error::Parameter`] for Young's modulus, and for a Poisson's ratio outside of -1 to 0.5;
    /// [`Error::Coincident`] for two nodes at one place, [`Error::LooseNode`] for a node without a bond; [`Error::Node`] for one whose
    /// energy the surface correction makes negative.
    pub fn new<const D: usize>(
        nodes: &Nodes<D>,
        config: &BondConfig,
        poisson_ratio: f64,
    ) -> Result<Self, Error> {
        let BondConfig { horizon, influence, volume_correction, .. } = *config;
        let moduli = Moduli::new(config.young_modulus, poisson_ratio, nodes.condition())?;
        let v = nodes.volumes();
        // In place of the stiffness, at first: beta V_i V_j.
        let mut bonds = Bonds::within(
            nodes,
            volume_correction.reach(horizon),
            horizon.radius(),
            |(i, j), length| {
                let share = volume_correction.share(length, horizon);
                let is_bonded =
                    share * influence.weight((length / horizon.radius()).min(1.0)) > 0.0;
                is_bonded.then_some(Bond { length, stiffness: share * v[i] * v[j] })
            },
        )?;
        let weight = |length: f64| {
            let q = length / horizon.radius();
            influence.weight(q.min(1.0)) / q
        };
        let mut weights: Vec<f64> =
            bonds.all().iter().map(|bond| weight(bond.length) * bond.stiffness).collect();
        let mut m = vec![0.0; bonds.n_nodes()];
        for ((i, j), (bond, weight)) in bonds.pairs().zip(bonds.all().iter().zip(&weights)) {
            m[i] += weight * bond.length * bond.length / v[i];
            m[j] += weight * bond.length * bond.length / v[j];
        }
        if config.surface_correction == SurfaceCorrection::Energy {
            let factors = factors(nodes, &bonds, (&weights, &m));
            for (weight, factor) in weights.iter_mut().zip(factors) {
                *weight *= factor;
            }
        }
        check(nodes, &bonds, (&weights, &m), moduli)?;
        let stiffness =
            bonds.pairs().zip(bonds.all()).zip(&weights).map(|(((i, j), bond), weight)| {
                moduli.b * weight * (1.0 / m[i] + 1.0 / m[j]) * bond.length
            });
        let stiffness: Vec<f64> = stiffness.collect();
        bonds.set_stiffness(stiffness);
        let dimension = D as f64;
        let of_node = |(m, v): (&f64, &f64)| dimension * dimension * moduli.a / (m * m * v);
        Ok(Self {
            weights,
            nodal: m.iter().zip(v).map(of_node).collect(),
            bonds,
            weighted_volumes: m,
            b: moduli.b,
        })
    }

    /// The bonds, with their tension over their stretch at a fixed dilatation as stiffness.
    #[must_use]
    pub fn bonds(&self) -> &Bonds {
        &self.bonds
    }

    /// The weighted volume `m` of each node at rest (length to the fifth).
    #[must_use]
    pub fn weighted_volumes(&self) -> &[f64] {
        &self.weighted_volumes
    }

    /// `omega beta V_i V_j` of each bond, times the factor of the surface correction.
    pub(crate) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// A power of two next to the largest `omega beta V_i V_j |xi|^2`: sums over bonds in this unit, and `D^2 A/(m^2 V)` in the
    /// inverse one, stay within single precision whatever the unit of length.
    pub(crate) fn moment_unit(&self) -> f64 {
        let moments = self.bonds.all().iter().zip(&self.weights);
        let largest = moments.map(|(of, w)| w * of.length * of.length).fold(0.0, f64::max);
        if largest > 0.0 { largest.log2().round().exp2() } else { 1.0 }
    }

    /// `D^2 A/(m^2 V)` of each node.
    pub(crate) fn nodal(&self) -> &[f64] {
        &self.nodal
    }

    /// `B/m` of a node.
    pub(crate) fn distortion(&self, node: usize) -> f64 {
        self.b / self.weighted_volumes[node]
    }
}
