//! The seam: how derivatives of a response are had.

use crate::along::AlongDirections;
use crate::error::Error;
use crate::expansion::Expansion;
use crate::random_vector::RandomVector;

/// What is known of a response around the centre of its inputs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Known<const N: usize> {
    /// Derivatives by the inputs.
    ByInputs(Expansion<N>),
    /// Derivatives along the directions `L e_k`.
    AlongDirections(AlongDirections<N>),
}

/// A way to have the derivatives of a response. This is where users plug in; a function
/// `Fn(&[f64; N]) -> Expansion<N>` is one already: derivatives by hand, at the centre it is given.
///
/// ```
/// use perturbation_moments::{Expansion, Moments, RandomVector};
///
/// let inputs = RandomVector::independent([1.0], [0.1])?;
/// let by_hand = |&[x]: &[f64; 1]| Expansion {
///     value: x.exp(),
///     gradient: [x.exp()],
///     hessian: Some([[x.exp()]]),
///     third: Some([[[x.exp()]]]),
/// };
/// let moments = Moments::by(&inputs, &by_hand)?;
/// assert!((moments.trust()?.curvature_ratio.unwrap() - 0.005).abs() < 1e-15);
/// # Ok::<(), perturbation_moments::Error>(())
/// ```
pub trait Derivatives<const N: usize> {
    /// Derivatives at [`RandomVector::centre`], or along its directions.
    ///
    /// # Errors
    /// Whatever keeps the derivatives from being had. What is not finite may be returned: the moments refuse it by name.
    fn know(&self, inputs: &RandomVector<N>) -> Result<Known<N>, Error>;
}

impl<const N: usize, F: Fn(&[f64; N]) -> Expansion<N>> Derivatives<N> for F {
    fn know(&self, inputs: &RandomVector<N>) -> Result<Known<N>, Error> {
        Ok(Known::ByInputs(self(&inputs.centre())))
    }
}
