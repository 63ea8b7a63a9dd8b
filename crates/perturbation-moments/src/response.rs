//! The trait of a differentiable response.

use crate::numbers::scalar::Scalar;

/// A response $y(x_1, .., x_N)$ written once for every number type.
///
/// Rust has no generic closures, so this is a trait with one method. It serves all ways of differentiation: dual
/// numbers, jets, differences, sigma points, Monte Carlo.
///
/// ```
/// use perturbation_moments::{Response, Scalar};
///
/// struct Cantilever;
///
/// impl Response<4> for Cantilever {
///     /// Tip deflection `F L^3 / (3 E J)`.
///     fn value<S: Scalar>(&self, x: &[S; 4]) -> S {
///         let [force, modulus, length, inertia] = *x;
///         force * length.powi(3) / (modulus * inertia * 3.0)
///     }
/// }
/// ```
pub trait Response<const N: usize> {
    /// The response at `x`. Outside its domain: NaN or infinite, never a panic.
    fn value<S: Scalar>(&self, x: &[S; N]) -> S;
}

impl<const N: usize, R: Response<N> + ?Sized> Response<N> for &R {
    #[inline]
    fn value<S: Scalar>(&self, x: &[S; N]) -> S {
        (**self).value(x)
    }
}
