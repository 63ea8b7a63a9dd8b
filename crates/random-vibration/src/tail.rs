//! Exceedance probabilities at one time by subset simulation of paths.

use std::sync::atomic::{AtomicU64, Ordering};

use sde_integrators::{
    DrivenPath, Error, Estimate, GaussianMixture, Integrator, Noise, SmallPivot, SubsetConfig,
    small_cholesky, subset_simulation,
};

use crate::linearisation::LinearisationError;

impl TailError {
    pub(crate) fn of_pivot(SmallPivot { row, value, .. }: SmallPivot) -> Self {
        Self::NotACovariance { state: row, value }
    }
}

/// The state at the end of a path, as a function of its start and of the driving normals.
type PathEnd<'a, const D: usize> = dyn Fn([f64; D], &[f64]) -> Result<[f64; D], Error> + Sync + 'a;

/// `P(|y| > T)` of a demand `y = w . X(t)` at one time.
///
/// Paths are functions of independent standard normals: first those of the initial distribution, then those of the
/// steps.
///
/// Source: Au and Beck 2001, Estimation of small failure probabilities in high dimensions by subset simulation.
pub struct TailPaths<'a, const D: usize> {
    path: Box<PathEnd<'a, D>>,
    n_normals: usize,
    mean: [f64; D],
    factor: [[f64; D]; D],
    weights: [f64; D],
    followed: AtomicU64,
}

/// The tails that guided paths cover.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tails {
    /// The upper tail, doubled: for distributions symmetric about zero.
    Doubled,
    /// Both tails.
    Both,
    /// The upper tail alone, `P(y > T)`.
    Upper,
}

/// Error of a tail probability.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TailError {
    /// The initial distribution is a mixture, which is no function of one normal for each state.
    #[error("the initial distribution has {value} components; it must be one normal distribution")]
    Mixture {
        /// Number of components.
        value: usize,
    },
    /// The initial covariance is not positive definite.
    #[error("the pivot of the initial covariance at state {state} is {value}; it must be positive")]
    NotACovariance {
        /// Index of the state.
        state: usize,
        /// The pivot.
        value: f64,
    },
    /// The linearisation that guides the paths failed.
    #[error(transparent)]
    Linearisation(#[from] LinearisationError),
    /// The weights of guided paths are too uneven for a standard error.
    #[error(
        "{hits} of {n_paths} guided paths reached {threshold}, with an effective sample size of {effective:.3} \
         (at least {fewest}) and a largest weight of {share:.3} of the sum (at most {most}): take more paths, \
         or subset simulation"
    )]
    Untrusted {
        /// The threshold.
        threshold: f64,
        /// Number of paths.
        n_paths: u64,
        /// Number of paths that reached the event.
        hits: u64,
        /// Effective sample size, zero without a weight.
        effective: f64,
        /// Its minimum.
        fewest: f64,
        /// Share of the largest weight in the sum, zero without a weight.
        share: f64,
        /// Its maximum.
        most: f64,
    },
    /// A path or a sampling method failed.
    #[error(transparent)]
    Sampling(#[from] Error),
}

impl<'a, const D: usize> TailPaths<'a, D> {
    /// Paths from a normal distribution to a time; the demand is the first state.
    ///
    /// # Errors
    /// [`TailError::Mixture`], [`TailError::NotACovariance`].
    pub fn new<S: Sync + ?Sized, I: Integrator<S, D, M>, const M: usize>(
        system: &'a S,
        integrator: &'a I,
        law: &GaussianMixture<D>,
        (time, n_steps): (f64, usize),
    ) -> Result<Self, TailError> {
        let value = law.components().len();
        if value != 1 {
            return Err(TailError::Mixture { value });
        }
        let mean = law.mean();
        let factor = small_cholesky(&law.covariance(), 0.0).map_err(TailError::of_pivot)?;
        let dt = time / n_steps as f64;
        let path = move |start| DrivenPath { system, integrator, start, dt, n_steps };
        let n_normals = D + path(mean).n_normals::<M>();
        let path =
            Box::new(move |start, normals: &[f64]| path(start).run::<M>(normals, |_, _, _| ()));
        let weights = std::array::from_fn(|i| if i == 0 { 1.0 } else { 0.0 });
        Ok(Self { path, n_normals, mean, factor, weights, followed: AtomicU64::new(0) })
    }

    /// The same paths with another demand.
    #[must_use]
    pub fn with_demand(self, weights: [f64; D]) -> Self {
        Self { weights, ..self }
    }

    /// Number of paths evaluated so far.
    #[must_use]
    pub fn n_followed(&self) -> u64 {
        self.followed.load(Ordering::Relaxed)
    }

    /// The demand at the end of the path that the normals define.
    fn demand(&self, normals: &[f64]) -> Result<f64, Error> {
        self.followed.fetch_add(1, Ordering::Relaxed);
        let (first, rest) = normals.split_at(D);
        let start = std::array::from_fn(|i| {
            self.mean[i] + (0..=i).map(|k| self.factor[i][k] * first[k]).sum::<f64>()
        });
        let end = (self.path)(start, rest)?;
        Ok(self.weights.iter().zip(end).map(|(weight, x)| weight * x).sum())
    }

    /// Subset simulation of `|y| > T`, with the error of [`subset_simulation`].
    ///
    /// # Errors
    /// [`TailError::Sampling`].
    pub fn subset(
        &self,
        threshold: f64,
        config: &SubsetConfig,
        seed: u64,
    ) -> Result<Estimate, TailError> {
        let response = |normals: &[f64]| Ok(self.demand(normals)?.abs());
        let noise = Noise::new(seed);
        Ok(subset_simulation(&response, self.n_normals, threshold, &noise, config)?)
    }
}

impl<const D: usize> std::fmt::Debug for TailPaths<'_, D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { n_normals, weights, .. } = self;
        f.debug_struct("TailPaths")
            .field("n_normals", n_normals)
            .field("weights", weights)
            .finish_non_exhaustive()
    }
}
