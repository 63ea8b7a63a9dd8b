//! Who is bonded to whom, and how stiffly.

use neighbour_search::{CellGrid, NeighbourList, NeighbourSearch, Radii};

use crate::elasticity::{Influence, micromodulus};
use crate::error::Error;
use crate::horizon::Horizon;
use crate::nodes::Nodes;
use crate::surface::{SurfaceCorrection, factors};

/// How much of a node's volume counts where its box is cut by the horizon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VolumeCorrection {
    /// All of it, up to the horizon.
    None,
    /// `1/2 + (delta - r)/dx` for the bonds within half a spacing of the horizon, none beyond it (Parks et al. 2008, as in
    /// LAMMPS).
    Partial,
    /// The same for bonds up to half a spacing beyond the horizon too. Of the three the nearest to the elastic body.
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

    fn reach(self, horizon: Horizon) -> f64 {
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

/// What does not change of a bond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bond {
    /// Its length at rest (length).
    pub length: f64,
    /// Its tension over its stretch, `c omega beta V_i V_j` with the share `beta` of the volumes, times the
    /// factor of the surface correction (force).
    pub stiffness: f64,
}

/// The bonds of a body, each once: the rows of node `i` hold those to nodes `j > i`, by ascending `j`.
#[derive(Debug, Clone, PartialEq)]
pub struct Bonds {
    /// Where the bonds of each node begin; one more at the end.
    starts: Vec<usize>,
    partners: Vec<u32>,
    all: Vec<Bond>,
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
            for (bond, factor) in made.all.iter_mut().zip(factors) {
                bond.stiffness *= factor;
            }
        }
        Ok(made)
    }

    /// Bonds those nodes within `reach` of each other that `of` makes a bond for, given their numbers, the lower first, and their
    /// distance.
    pub(crate) fn within<const D: usize>(
        nodes: &Nodes<D>,
        reach: f64,
        horizon: f64,
        of: impl Fn((usize, usize), f64) -> Option<Bond>,
    ) -> Result<Self, Error> {
        let positions = nodes.positions();
        let mut list = NeighbourList::new();
        // Nodes are finite and fewer than an index holds, and the radius is that of a checked horizon.
        CellGrid::new()
            .full_list(positions, Radii::Uniform(reach), &mut list)
            .map_err(|_| Error::NotPositive { name: "horizon", value: horizon })?;
        list.sort_rows();
        let n = positions.len();
        let (mut starts, mut partners, mut all) = (Vec::with_capacity(n + 1), vec![], vec![]);
        let mut counts = vec![0_u32; n];
        starts.push(0);
        for (i, row) in list.rows().enumerate() {
            // A half list of the search has a pair under either of its ends; here it belongs to the lower one.
            for &partner in &row[row.partition_point(|&partner| (partner as usize) < i)..] {
                let j = partner as usize;
                let length = distance(&positions[i], &positions[j]);
                if length <= 0.0 {
                    return Err(Error::Coincident { first: i, second: j });
                }
                if let Some(bond) = of((i, j), length) {
                    partners.push(partner);
                    all.push(bond);
                    counts[i] += 1;
                    counts[j] += 1;
                }
            }
            starts.push(partners.len());
        }
        match counts.iter().position(|&count| count == 0) {
            Some(node) => Err(Error::LooseNode { node, horizon }),
            None => Ok(Self { starts, partners, all }),
        }
    }

    /// How many bonds there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// How many nodes they bond.
    #[must_use]
    pub fn n_nodes(&self) -> usize {
        self.starts.len() - 1
    }

    /// What does not change of each bond.
    #[must_use]
    pub fn all(&self) -> &[Bond] {
        &self.all
    }

    /// Both nodes of every bond, in the order of [`Bonds::all`].
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.n_nodes()).flat_map(move |i| self.row(i).map(move |bond| (i, self.partner(bond))))
    }

    /// The numbers of the bonds in the row of a node.
    pub(crate) fn row(&self, node: usize) -> std::ops::Range<usize> {
        self.starts[node]..self.starts[node + 1]
    }

    /// The nodes of a bond, the lower first.
    pub(crate) fn ends(&self, bond: usize) -> (usize, usize) {
        let node = self.starts.partition_point(|&start| start <= bond) - 1;
        (node, self.partner(bond))
    }

    /// The bond between two nodes, the lower first.
    pub(crate) fn number(&self, i: usize, j: usize) -> Option<usize> {
        let row = self.row(i);
        let partners = &self.partners[row.clone()];
        let at = partners.binary_search_by_key(&j, |&partner| partner as usize).ok()?;
        Some(row.start + at)
    }

    /// The other nodes of bonds.
    #[inline]
    pub(crate) fn partners(&self, bonds: std::ops::Range<usize>) -> &[u32] {
        self.partners.get(bonds).unwrap_or_default()
    }

    #[inline]
    pub(crate) fn partner(&self, bond: usize) -> usize {
        self.partners[bond] as usize
    }
}

/// Numbers of bonds that exist.
pub(crate) fn cut_numbers(bonds: &[usize], expected: usize) -> Result<(), Error> {
    match bonds.iter().find(|&&bond| bond >= expected) {
        Some(&value) => Err(Error::Length { name: "the number of a bond to cut", value, expected }),
        None => Ok(()),
    }
}

fn distance<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>().sqrt()
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
        let config = BondConfig {
            horizon: Horizon::of_shells(3, dx).unwrap(),
            young_modulus: 1.0,
            influence: Influence::Constant,
            volume_correction: VolumeCorrection::None,
            surface_correction: SurfaceCorrection::None,
        };
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
