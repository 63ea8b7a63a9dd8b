//! How a mobility is made.

use random_fields::{Correlation, Enough, pivoted_cholesky};
use sde_integrators::{DenseFactor, DiagonalFactor, LowRankFactor};

use super::{Factor, Mobility};
use crate::error::{Error, at_most, between, not_negative, positive, same_length};

/// Most nodes of a full matrix: 2 GB of it.
const MOST_DENSE: usize = 16_384;

/// A mobility whose correlation between nodes is given, `M_ij = m (rho(r_ij) + nugget delta_ij)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CorrelatedMobility {
    /// `m` (length / (force time)).
    pub mobility: f64,
    /// `rho`.
    pub correlation: Correlation,
    /// What each node has of its own, as a part of what it shares. A smooth correlation without it has modes that hardly
    /// move: the slowest of a Gaussian of a few spacings may need 1e12 steps, with a nugget of 0.1 some hundred.
    pub nugget: f64,
}

impl Mobility {
    /// Every free node for itself: `M = m 1`.
    ///
    /// # Errors
    /// [`Error::NoFreeNode`], [`Error::Parameter`] for the mobility (length / (force time)).
    pub fn identity(free: &[bool], mobility: f64) -> Result<Self, Error> {
        positive("mobility", mobility)?;
        any_free(free)?;
        Ok(Self { factor: Factor::Diagonal(own(free, mobility)?), is_free: free.to_vec() })
    }

    /// From the matrix itself, row after row (length / (force time)). Rows and columns of fixed nodes are not looked at.
    ///
    /// # Errors
    /// [`Error::NoFreeNode`], [`Error::TooMany`], [`Error::Length`]; [`Error::Factor`] for an entry that is not finite or
    /// not that on the other side of the diagonal to 1e-12; [`Error::NotPositiveDefinite`] with its first row.
    pub fn from_matrix(free: &[bool], matrix: &[f64]) -> Result<Self, Error> {
        let n = free.len();
        same_length("the matrix of the mobility", matrix.len(), n * n)?;
        Self::of_entries(free, |i, j| matrix[i * n + j])
    }

    /// With a correlation between all nodes (lengths), by a Cholesky factor.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the mobility or a negative nugget, [`Error::Length`], [`Error::Node`], [`Error::NoFreeNode`],
    /// [`Error::TooMany`]; [`Error::Field`] for the correlation; [`Error::NotPositiveDefinite`] for a smooth correlation without a
    /// nugget.
    pub fn dense<const D: usize>(
        positions: &[[f64; D]],
        free: &[bool],
        config: &CorrelatedMobility,
    ) -> Result<Self, Error> {
        config.check(positions, free)?;
        let CorrelatedMobility { mobility, correlation, nugget } = *config;
        Self::of_entries(free, |i, j| {
            let own = if i == j { nugget } else { 0.0 };
            mobility * (correlation.between(&positions[i], &positions[j]) + own)
        })
    }

    /// With a correlation between all nodes (lengths), by as many columns of a pivoted Cholesky factor as leave less than a
    /// part `tolerance` of the trace, and the nugget: `L = [U, sqrt(m nugget) 1]`. What is left, is left out: `M_ii` is less
    /// than `m (1 + nugget)` by it.
    ///
    /// # Errors
    /// As [`Mobility::dense`]; [`Error::Parameter`] for a nugget of zero, without which most of the motion would be frozen, or for a
    /// tolerance not between 0 and 1.
    pub fn low_rank<const D: usize>(
        positions: &[[f64; D]],
        free: &[bool],
        config: &CorrelatedMobility,
        tolerance: f64,
    ) -> Result<Self, Error> {
        config.check(positions, free)?;
        let CorrelatedMobility { mobility, correlation, nugget } = *config;
        positive("nugget", nugget)?;
        between("tolerance of the factor", tolerance, 0.0, 1.0)?;
        let is_shared = |i: usize, j: usize| free[i] && free[j];
        let entry = |i: usize, j: usize| {
            if !is_shared(i, j) {
                return 0.0;
            }
            mobility * correlation.between(&positions[i], &positions[j])
        };
        let found = pivoted_cholesky(free.len(), entry, Enough::Trace(tolerance))?;
        let smooth = LowRankFactor::new(free.len(), found.columns)?;
        let nugget = own(free, mobility * nugget)?;
        Ok(Self { factor: Factor::LowRank { smooth, nugget }, is_free: free.to_vec() })
    }

    /// A full factor of the rows and columns of free nodes.
    fn of_entries(free: &[bool], entry: impl Fn(usize, usize) -> f64) -> Result<Self, Error> {
        let n = free.len();
        any_free(free)?;
        at_most("nodes of a full matrix", n, MOST_DENSE)?;
        let mut matrix = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                let is_both = free[i] && free[j];
                matrix[i * n + j] = if is_both { entry(i, j) } else { f64::from(i == j) };
            }
        }
        let limit = |row: usize| n as f64 * f64::EPSILON * matrix[row * n + row].abs();
        let not_definite = |row| Error::NotPositiveDefinite { row, limit: limit(row) };
        let factor = DenseFactor::new(n, &matrix).map_err(|error| match error {
            sde_integrators::Error::CovarianceNotPositiveDefinite { row } => not_definite(row),
            other => Error::Factor(other),
        })?;
        // Higham 2002, algorithm 10.2: a pivot below this is roundoff of the diagonal.
        match (0..n).find(|&row| factor.row(row)[row].powi(2) <= limit(row)) {
            Some(row) => Err(not_definite(row)),
            None => Ok(Self { factor: Factor::Dense(factor), is_free: free.to_vec() }),
        }
    }
}

impl CorrelatedMobility {
    fn check<const D: usize>(&self, positions: &[[f64; D]], free: &[bool]) -> Result<(), Error> {
        positive("mobility", self.mobility)?;
        self.correlation.check()?;
        not_negative("nugget", self.nugget)?;
        same_length("the free nodes", free.len(), positions.len())?;
        for (node, place) in positions.iter().enumerate() {
            if let Some(&value) = place.iter().find(|x| !x.is_finite()) {
                return Err(Error::Node { name: "a coordinate", node, value, must: "finite" });
            }
        }
        any_free(free)
    }
}

/// A motion for each node, which moves it where it is free.
fn own(free: &[bool], variance: f64) -> Result<DiagonalFactor, Error> {
    let deviation = |&is_free: &bool| if is_free { variance.sqrt() } else { 0.0 };
    Ok(DiagonalFactor::new(free.iter().map(deviation).collect())?)
}

fn any_free(free: &[bool]) -> Result<(), Error> {
    if free.contains(&true) { Ok(()) } else { Err(Error::NoFreeNode { n_nodes: free.len() }) }
}
