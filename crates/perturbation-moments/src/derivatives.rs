//! The trait for derivatives of a response.

use crate::along::AlongDirections;
use crate::error::Error;
use crate::expansion::Expansion;
use crate::random_vector::RandomVector;

/// Derivatives of a response at the centre of its inputs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Known<const N: usize> {
    /// Derivatives with respect to the inputs.
    ByInputs(Expansion<N>),
    /// Derivatives along the directions `L e_k`.
    AlongDirections(AlongDirections<N>),
}

/// A method to compute the derivatives of a response.
///
/// Users implement it for their own methods. A function `Fn(&[f64; N]) -> Expansion<N>` implements it: derivatives by
/// hand at the given centre.
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
    /// Any error that prevents the derivatives. Results may be non-finite: the moments reject them by name.
    fn know(&self, inputs: &RandomVector<N>) -> Result<Known<N>, Error>;
}

impl<const N: usize, F: Fn(&[f64; N]) -> Expansion<N>> Derivatives<N> for F {
    fn know(&self, inputs: &RandomVector<N>) -> Result<Known<N>, Error> {
        Ok(Known::ByInputs(self(&inputs.centre())))
    }
}
