//! The number type of a run.

use perturbation_moments::Scalar;

/// A number that particles and nodes carry: `f64`, or a [`Jet`](perturbation_moments::Jet), which carries the derivatives of
/// its history. Implemented for every [`Scalar`] that threads may share.
pub trait Number: Scalar + std::fmt::Debug + Send + Sync + 'static {}

impl<S: Scalar + std::fmt::Debug + Send + Sync + 'static> Number for S {}
