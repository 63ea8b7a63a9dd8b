//! The mobility of a body: one factor for drift and noise.

mod build;

use sde_integrators::{DenseFactor, DiagonalFactor, LowRankFactor, NoiseFactor};

pub use self::build::CorrelatedMobility;
use crate::error::Error;

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
/// mobility.drift(1, &[2.0, 0.0, 5.0], &mut motions, &mut velocities)?;
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
        expect("motions", z.len(), components * self.n_motions())?;
        expect("displacements", out.len(), components * self.n_nodes())?;
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
        expect("forces", f.len(), components * self.n_nodes())?;
        expect("motions", y.len(), components * self.n_motions())?;
        self.back(components, f, y);
        Ok(())
    }

    /// `M f = L (L^T f)` into `out`, by way of the motions: `f` and `out` are `[node][component]`.
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn drift(
        &self,
        components: usize,
        f: &[f64],
        motions: &mut [f64],
        out: &mut [f64],
    ) -> Result<(), Error> {
        self.apply_factor_transposed(components, f, motions)?;
        self.apply_factor(components, motions, out)
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

    /// `M_ij` (length / (force time)).
    ///
    /// # Errors
    /// [`Error::NoSuchNode`].
    pub fn pair(&self, i: usize, j: usize) -> Result<f64, Error> {
        let mut sum = 0.0;
        self.for_each_motion([i, j], |l_i, l_j| sum += l_i * l_j)?;
        Ok(sum)
    }

    /// `M_ii + M_jj - 2 M_ij`, without cancellation: the mobility of the one node as seen from the other. In time `t` noise
    /// gives the distance of the nodes a variance of `2 kT t` times it.
    ///
    /// # Errors
    /// [`Error::NoSuchNode`].
    pub fn relative(&self, i: usize, j: usize) -> Result<f64, Error> {
        let mut sum = 0.0;
        self.for_each_motion([i, j], |l_i, l_j| sum += (l_i - l_j) * (l_i - l_j))?;
        Ok(sum)
    }

    /// Entries of two rows of the factor, motion by motion, but for those where both are zero.
    fn for_each_motion(
        &self,
        [i, j]: [usize; 2],
        mut entries: impl FnMut(f64, f64),
    ) -> Result<(), Error> {
        let n_nodes = self.n_nodes();
        if let Some(&node) = [i, j].iter().find(|&&node| node >= n_nodes) {
            return Err(Error::NoSuchNode { node, n_nodes });
        }
        match &self.factor {
            Factor::Diagonal(factor) => own_entries(factor, [i, j], entries),
            Factor::Dense(factor) => {
                let row = |node| if self.is_free[node] { factor.row(node) } else { &[][..] };
                let (a, b) = (row(i), row(j));
                for k in 0..a.len().max(b.len()) {
                    entries(a.get(k).copied().unwrap_or(0.0), b.get(k).copied().unwrap_or(0.0));
                }
            }
            Factor::LowRank { smooth, nugget } => {
                smooth.columns().for_each(|column| entries(column[i], column[j]));
                own_entries(nugget, [i, j], entries);
            }
        }
        Ok(())
    }
}

/// A mobility as the noise factor of a field of displacements `[node][component]`.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplacementNoise {
    /// Its spatial factor.
    pub mobility: Mobility,
    /// Components of the displacement.
    pub components: usize,
}

impl NoiseFactor for DisplacementNoise {
    fn n_unknowns(&self) -> usize {
        self.components * self.mobility.n_nodes()
    }

    fn n_motions(&self) -> usize {
        self.components * self.mobility.n_motions()
    }

    fn apply(&self, z: &[f64], result: &mut [f64]) {
        self.mobility.forth(self.components, z, result);
    }

    fn apply_transposed(&self, x: &[f64], result: &mut [f64]) {
        self.mobility.back(self.components, x, result);
    }
}

/// Motions that each belong to one node.
fn own_entries(factor: &DiagonalFactor, [i, j]: [usize; 2], mut entries: impl FnMut(f64, f64)) {
    let deviations = factor.deviations();
    if i == j {
        entries(deviations[i], deviations[i]);
    } else {
        entries(deviations[i], 0.0);
        entries(0.0, deviations[j]);
    }
}

fn expect(name: &'static str, value: usize, expected: usize) -> Result<(), Error> {
    if value == expected { Ok(()) } else { Err(Error::Length { name, value, expected }) }
}
