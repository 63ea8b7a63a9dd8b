//! What forces act against: a mobility, or masses.

use crate::bodies::body::Body;
use crate::dynamics::loading::Loading;
use crate::dynamics::scheme::Dynamics;
use crate::error::{Error, same_length};
use crate::mobility::Mobility;
use crate::real::Real;

/// Mobility or inverse mass of each unknown, or a mobility that couples nodes.
#[derive(Debug, Clone)]
pub(crate) enum Resistance<T> {
    /// The mobility, or inverse mass, of each component of each node; zero where its displacement is prescribed.
    Diagonal {
        /// `M`.
        values: Vec<T>,
        /// `L = sqrt(M)`.
        factor: Vec<T>,
    },
    /// A mobility that couples whole nodes.
    Coupled {
        /// `M`.
        mobility: Mobility,
        /// Components of a displacement.
        dimension: usize,
    },
}

impl<T: Real> Resistance<T> {
    pub(crate) fn new<const D: usize, const L: usize>(
        body: &dyn Body<T, D, L>,
        loading: &Loading<D>,
        dynamics: &Dynamics,
    ) -> Result<Self, Error> {
        let prescribed = loading.prescribed();
        let of_nodes: Vec<f64> = match dynamics {
            Dynamics::Inertial { density, .. } => {
                body.nodes().volumes().iter().map(|volume| 1.0 / (density * volume)).collect()
            }
            Dynamics::Overdamped { mobility, .. } => {
                same_length("nodes of the mobility", mobility.n_nodes(), prescribed.len())?;
                let Some(diagonal) = mobility.diagonal() else {
                    return Self::coupled(mobility, prescribed);
                };
                diagonal
            }
        };
        let entries = || {
            of_nodes.iter().zip(prescribed).flat_map(|(&value, prescribed)| {
                prescribed.map(|prescribed| if prescribed { 0.0 } else { value })
            })
        };
        let values = entries().map(T::of).collect();
        Ok(Self::Diagonal { values, factor: entries().map(|m| T::of(m.sqrt())).collect() })
    }

    /// A mobility that couples nodes moves just the nodes without a prescribed component.
    fn coupled<const D: usize>(
        mobility: &Mobility,
        prescribed: &[[bool; D]],
    ) -> Result<Self, Error> {
        for (node, (prescribed, &free)) in prescribed.iter().zip(mobility.free()).enumerate() {
            if prescribed.contains(&free) {
                return Err(Error::MobilityOfPrescribed { node });
            }
        }
        Ok(Self::Coupled { mobility: mobility.clone(), dimension: D })
    }

    /// How many Brownian motions drive one realisation.
    pub(crate) fn n_motions(&self, dimension: usize) -> usize {
        match self {
            Self::Diagonal { values, .. } => values.len(),
            Self::Coupled { mobility, .. } => mobility.n_motions() * dimension,
        }
    }

    /// For each bond the rate at which noise spreads its stretch, `2 kT n^T (M_ii + M_jj - 2 M_ij) n / |xi|^2` (1/time).
    pub(crate) fn rates_of_bonds<const D: usize, const L: usize>(
        &self,
        body: &dyn Body<T, D, L>,
        dynamics: &Dynamics,
    ) -> Result<Vec<f64>, Error> {
        if !dynamics.has_path() {
            return Err(Error::NoPathBetween);
        }
        let (x, bonds) = (body.nodes().positions(), body.bonds());
        let rate = |((i, j), length): ((usize, usize), f64)| {
            let mut relative = 0.0;
            match self {
                Self::Diagonal { values, .. } => {
                    for k in 0..D {
                        let n = (x[j][k] - x[i][k]) / length;
                        let both = values[i * D + k].to_f64() + values[j * D + k].to_f64();
                        relative += n * n * both;
                    }
                }
                Self::Coupled { mobility, .. } => relative = mobility.relative(i, j),
            }
            2.0 * dynamics.temperature() * relative / (length * length)
        };
        Ok(bonds.pairs().zip(bonds.all()).map(|(pair, of)| rate((pair, of.length))).collect())
    }
}
