//! The mobility of a body: one factor for drift and noise.

mod build;

use sde_integrators::{DenseFactor, DiagonalFactor, LowRankFactor, NoiseFactor as _};

pub use self::build::CorrelatedMobility;
use crate::error::{Error, same_length};

/// The mobility `M = L L^T` of the nodes of a body: symmetric, positive definite on the nodes that are free, and zero on those
/// that are fixed. It does not depend on the displacement, so that `du = M f dt + sqrt(2 kT) L dB` needs no other drift.
///
/// Each component of the displacement has the same factor and noise of its own. Columns are node-major: forces and
/// displacements are `[node][component]`, motions `[motion][component]`. Realisations side by side are further components:
/// three dimensions in eight lanes are 24.
///
/// | made by | drift or noise of one component | when |
/// |---|---|---|
/// | [`identity`](Self::identity) | `O(n)` | uncorrelated |
/// | [`low_rank`](Self::low_rank) | `O(n k)`, `k` columns | many nodes, the more so the longer the correlation |
/// | [`dense`](Self::dense), [`from_matrix`](Self::from_matrix) | `O(n^2)`, once `O(n^3)` | up to a few thousand nodes |
///
/// The number of a motion does not depend on which nodes are fixed; motions of fixed nodes move nothing.
///
/// ```
/// use peridyn_sde::Mobility;
///
/// // Two nodes that move alike by half, and one that is held.
/// let matrix = [1.0, 0.5, 9.0, 0.5, 1.0, 9.0, 9.0, 9.0, 9.0];
/// let mobility = Mobility::from_matrix(&[true, true, false], &matrix)?;
/// let (mut motions, mut velocities) = ([0.0; 3], [0.0; 3]);
/// mobility.apply_factor_transposed(1, &[2.0, 0.0, 5.0], &mut motions)?;
/// mobility.apply_factor(1, &motions, &mut velocities)?;
/// assert!((velocities[0] - 2.0).abs() < 1e-15 && (velocities[1] - 1.0).abs() < 1e-15);
/// assert_eq!(velocities[2], 0.0);
/// # Ok::<(), peridyn_sde::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Mobility {
    factor: Factor,
    is_free: Vec<bool>,
}

#[derive(Debug, Clone, PartialEq)]
enum Factor {
    Diagonal(DiagonalFactor),
    /// Fixed nodes are as many independent ones in it; what they get is taken away.
    Dense(DenseFactor),
    LowRank {
        smooth: LowRankFactor,
        nugget: DiagonalFactor,
    },
}

impl Mobility {
    /// How many nodes it moves, the fixed ones included.
    #[must_use]
    pub fn n_nodes(&self) -> usize {
        self.is_free.len()
    }

    /// Which nodes are free.
    #[must_use]
    pub fn free(&self) -> &[bool] {
        &self.is_free
    }

    /// `M_ii`, zero on fixed nodes, if nodes are not coupled.
    #[must_use]
    pub fn diagonal(&self) -> Option<Vec<f64>> {
        match &self.factor {
            Factor::Diagonal(factor) => Some(factor.deviations().iter().map(|l| l * l).collect()),
            _ => None,
        }
    }

    /// How many Brownian motions drive one component of the displacement.
    #[must_use]
    pub fn n_motions(&self) -> usize {
        match &self.factor {
            Factor::Diagonal(factor) => factor.n_motions(),
            Factor::Dense(factor) => factor.n_motions(),
            Factor::LowRank { smooth, nugget } => smooth.n_motions() + nugget.n_motions(),
        }
    }

    /// `L z` into `out`: `z` is `[motion][component]`, `out` is `[node][component]`.
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn apply_factor(&self, components: usize, z: &[f64], out: &mut [f64]) -> Result<(), Error> {
        same_length("motions", z.len(), components * self.n_motions())?;
        same_length("displacements", out.len(), components * self.n_nodes())?;
        self.forth(components, z, out);
        Ok(())
    }

    /// `L^T f` into `y`: `f` is `[node][component]`, `y` is `[motion][component]`.
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn apply_factor_transposed(
        &self,
        components: usize,
        f: &[f64],
        y: &mut [f64],
    ) -> Result<(), Error> {
        same_length("forces", f.len(), components * self.n_nodes())?;
        same_length("motions", y.len(), components * self.n_motions())?;
        self.back(components, f, y);
        Ok(())
    }

    fn forth(&self, components: usize, z: &[f64], out: &mut [f64]) {
        if components == 0 {
            return;
        }
        match &self.factor {
            Factor::Diagonal(factor) => factor.apply_to_components(components, z, out),
            Factor::Dense(factor) => {
                factor.apply_to_components(components, z, out);
                self.hold_fixed(components, out);
            }
            Factor::LowRank { smooth, nugget } => {
                let (shared, own) = z.split_at(components * smooth.n_motions());
                smooth.apply_to_components(components, shared, out);
                let rows = out.chunks_exact_mut(components).zip(own.chunks_exact(components));
                for ((out, z), deviation) in rows.zip(nugget.deviations()) {
                    for (out, z) in out.iter_mut().zip(z) {
                        *out += deviation * z;
                    }
                }
            }
        }
    }

    fn back(&self, components: usize, f: &[f64], y: &mut [f64]) {
        match &self.factor {
            Factor::Diagonal(factor) => factor.apply_transposed_to_components(components, f, y),
            Factor::Dense(factor) => {
                factor.apply_transposed_to_components(components, f, y);
                self.hold_fixed(components, y);
            }
            Factor::LowRank { smooth, nugget } => {
                let (shared, own) = y.split_at_mut(components * smooth.n_motions());
                smooth.apply_transposed_to_components(components, f, shared);
                nugget.apply_transposed_to_components(components, f, own);
            }
        }
    }

    /// A full factor has a row and a motion for each node, also for those that do not move.
    fn hold_fixed(&self, components: usize, values: &mut [f64]) {
        for (i, _) in self.is_free.iter().enumerate().filter(|&(_, is_free)| !is_free) {
            values[i * components..(i + 1) * components].fill(0.0);
        }
    }

    /// `M_ii + M_jj - 2 M_ij`, without cancellation: the mobility of the one node as seen from the other. In time `t` noise
    /// gives the distance of the nodes a variance of `2 kT t` times it.
    pub(crate) fn relative(&self, i: usize, j: usize) -> f64 {
        let square = |difference: f64| difference * difference;
        match &self.factor {
            Factor::Diagonal(factor) => own_relative(0.0, factor, [i, j]),
            Factor::Dense(factor) => {
                let row = |node| if self.is_free[node] { factor.row(node) } else { &[][..] };
                let (a, b) = (row(i), row(j));
                let entry = |row: &[f64], k: usize| row.get(k).copied().unwrap_or(0.0);
                (0..a.len().max(b.len())).map(|k| square(entry(a, k) - entry(b, k))).sum()
            }
            Factor::LowRank { smooth, nugget } => {
                let shared = smooth.columns().map(|of| square(of[i] - of[j])).sum();
                own_relative(shared, nugget, [i, j])
            }
        }
    }
}

/// Adds the relative mobility by motions that each belong to one node.
fn own_relative(shared: f64, factor: &DiagonalFactor, [i, j]: [usize; 2]) -> f64 {
    let deviations = factor.deviations();
    if i == j { shared } else { shared + deviations[i].powi(2) + deviations[j].powi(2) }
}

#[cfg(test)]
mod tests {
    use random_fields::{Correlation, CorrelationFunction};

    use super::*;

    /// By the columns of `M`, each the image of a unit force.
    #[test]
    fn relative_mobilities_are_those_of_the_matrix() {
        let places: Vec<[f64; 2]> = (0..64).map(|k| [f64::from(k % 8), f64::from(k / 8)]).collect();
        let free: Vec<bool> = (0..64).map(|node| node >= 8).collect();
        let correlation = Correlation { function: CorrelationFunction::Gaussian, length: 2.0 };
        let config = CorrelatedMobility { mobility: 0.7, correlation, nugget: 0.1 };
        for mobility in [
            Mobility::identity(&free, 0.7),
            Mobility::dense(&places, &free, &config),
            Mobility::low_rank(&places, &free, &config, 1e-3),
        ] {
            let mobility = mobility.unwrap();
            let column = |j: usize| {
                let (mut unit, mut image) = (vec![0.0; 64], vec![0.0; 64]);
                let mut motions = vec![0.0; mobility.n_motions()];
                unit[j] = 1.0;
                mobility.apply_factor_transposed(1, &unit, &mut motions).unwrap();
                mobility.apply_factor(1, &motions, &mut image).unwrap();
                image
            };
            for (i, j) in [(3, 8), (8, 9), (27, 27), (63, 20)] {
                let (of_i, of_j) = (column(i), column(j));
                let expected = of_i[i] + of_j[j] - 2.0 * of_j[i];
                assert!((mobility.relative(i, j) - expected).abs() < 1e-13, "{i} {j}");
            }
        }
    }
}
