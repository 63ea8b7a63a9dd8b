//! Bonds of an elastic body: stiffness from Young's modulus, corrected at the horizon and at surfaces.

use crate::bodies::bonds::{Bond, Bonds};
use crate::bodies::nodes::Nodes;
use crate::bodies::surface::{SurfaceCorrection, factors};
use crate::error::Error;
use crate::material::elasticity::{Influence, micromodulus};
use crate::material::horizon::Horizon;

/// How much of a node's volume counts where its box is cut by the horizon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VolumeCorrection {
    /// All of it, up to the horizon.
    None,
    /// `1/2 + (delta - r)/dx` for the bonds within half a spacing of the horizon, none beyond it (Parks et al. 2008, as in
    /// LAMMPS).
    Partial,
    /// The same for bonds up to half a spacing beyond the horizon too. Of the three it is the nearest to the elastic body.
    Ramp,
}

impl VolumeCorrection {
    /// Every one, for tests and tables.
    pub const ALL: [Self; 3] = [Self::None, Self::Partial, Self::Ramp];

    /// The share of a volume at a distance.
    #[must_use]
    pub fn share(self, distance: f64, horizon: Horizon) -> f64 {
        let ramp = 0.5 + (horizon.radius() - distance) / horizon.spacing();
        match self {
            Self::None => f64::from(distance <= horizon.radius()),
            Self::Partial if distance > horizon.radius() => 0.0,
            Self::Partial | Self::Ramp => ramp.clamp(0.0, 1.0),
        }
    }

    /// How far nodes are bonded.
    pub(crate) fn reach(self, horizon: Horizon) -> f64 {
        match self {
            Self::None | Self::Partial => horizon.radius(),
            Self::Ramp => horizon.radius() + 0.5 * horizon.spacing(),
        }
    }
}

/// What is needed to bond nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BondConfig {
    /// How far a node sees.
    pub horizon: Horizon,
    /// Young's modulus (stress).
    pub young_modulus: f64,
    /// The weight of a bond by its length.
    pub influence: Influence,
    /// What becomes of volumes at the horizon.
    pub volume_correction: VolumeCorrection,
    /// What becomes of bonds near a surface.
    pub surface_correction: SurfaceCorrection,
}

impl BondConfig {
    /// Bonds of a constant influence, without corrections.
    #[must_use]
    pub const fn uncorrected(horizon: Horizon, young_modulus: f64) -> Self {
        Self {
            horizon,
            young_modulus,
            influence: Influence::Constant,
            volume_correction: VolumeCorrection::None,
            surface_correction: SurfaceCorrection::None,
        }
    }
}

impl Bonds {
    /// Bonds all nodes within the horizon of each other.
    ///
    /// # Errors
    /// Those of [`micromodulus`]; [`Error::Coincident`] for two nodes at one place, [`Error::LooseNode`] for a node without a
    /// bond.
    pub fn new<const D: usize>(nodes: &Nodes<D>, config: &BondConfig) -> Result<Self, Error> {
        let BondConfig { horizon, young_modulus, influence, volume_correction, surface_correction } =
            *config;
        let c = micromodulus(young_modulus, horizon.radius(), influence, nodes.condition())?;
        let volumes = nodes.volumes();
        let reach = volume_correction.reach(horizon);
        let mut made = Self::within(nodes, reach, horizon.radius(), |(i, j), length| {
            let share = volume_correction.share(length, horizon);
            // Beyond the horizon a ramp still counts a part of the box, with the weight at the horizon.
            let weight = influence.weight((length / horizon.radius()).min(1.0));
            let stiffness = c * weight * share * volumes[i] * volumes[j];
            (share * weight > 0.0).then_some(Bond { length, stiffness })
        })?;
        if surface_correction == SurfaceCorrection::Energy {
            let factors = factors(nodes, &made, young_modulus);
            made.stiffen(factors);
        }
        Ok(made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Condition;

    /// The search sorts nodes into cells, whose order is not that of the nodes.
    #[test]
    fn every_bond_belongs_to_the_lower_of_its_nodes_in_ascending_order() {
        let (dx, plate) = (1e-3, Condition::PlaneStress { thickness: 1.0 });
        let nodes = Nodes::lattice(dx, ([0.0, -0.1], [0.1, 0.1]), plate, |_| true).unwrap();
        let config = BondConfig::uncorrected(Horizon::of_shells(3, dx).unwrap(), 1.0);
        let bonds = Bonds::new(&nodes, &config).unwrap();
        let pairs: Vec<_> = bonds.pairs().collect();
        assert!(pairs.iter().all(|(i, j)| i < j) && pairs.is_sorted());
        // Vectors (a, b) shorter than the horizon, one of each and its opposite: each fits (100 - a) (200 - |b|) times.
        let vectors = (0..=3_i64).flat_map(|a| (-3..=3_i64).map(move |b| (a, b)));
        let half = vectors.filter(|&(a, b)| (a > 0 || b > 0) && a * a + b * b < 10);
        let expected: i64 = half.map(|(a, b)| (100 - a) * (200 - b.abs())).sum();
        assert_eq!(i64::try_from(pairs.len()), Ok(expected));
        for (bond, &(i, j)) in pairs.iter().enumerate() {
            assert_eq!((bonds.number(i, j), bonds.ends(bond)), (Some(bond), (i, j)));
        }
    }
}
