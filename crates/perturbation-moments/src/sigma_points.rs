//! The 2N+1 sigma points: moments without derivatives.

use crate::along::AlongDirections;
use crate::error::Error;
use crate::moments::Moments;
use crate::random_vector::RandomVector;
use crate::trust::Trust;

/// Distance of the points from the centre, in deviations: matches the fourth moment of a normal distribution.
pub const SIGMA_POINT_DISTANCE: f64 = 1.732_050_807_568_877_2;

/// Moments from the response at the centre and at $\pm\sqrt3$ deviations along each direction `L e_k`.
///
/// $$ a_k = \frac{y_k^+ - y_k^-}{2\sqrt3}, \quad q_k = \frac{y_k^+ - 2 y_0 + y_k^-}{3}, \qquad
///    \operatorname{E} y \approx y_0 + \tfrac12 \sum q_k, \quad \operatorname{Var} y \approx \sum a_k^2 + \tfrac12 \sum q_k^2 $$
///
/// Use it where nothing can be differentiated: `2N + 1` values, without a smoothness assumption. It samples up to
/// three deviations and so **detects a kink** near the centre, which derivatives at the centre cannot:
/// [`judge`](Self::judge). The mean is that of the unscented transform with $\kappa = 3 - N$; the variance is a sum of
/// squares and, unlike that transform's, cannot become negative. Mixed terms are not included: `x1 x2` at zero mean
/// has zero variance here.
///
/// Sources: Julier and Uhlmann 2004, Unscented filtering and nonlinear estimation; Nørgaard, Poulsen and Ravn 2000, New
/// developments in state estimation for nonlinear systems, the variance.
///
/// ```
/// use perturbation_moments::{Expansion, Moments, RandomVector, SigmaPoints, Verdict};
///
/// // A kink 0.8 deviations from the mean: its derivatives there are those of a line, and wrong.
/// let gap = |&[x]: &[f64; 1]| (x - 0.8).max(0.0) + 0.1 * x;
/// let inputs = RandomVector::independent([0.0], [1.0])?;
/// let line = Expansion {
///     value: 0.0, gradient: [0.1], hessian: Some([[0.0]]), third: Some([[[0.0]]]),
/// };
/// let moments = Moments::new(&inputs, &line)?;
/// assert_eq!(moments.trust()?.verdict(), Verdict::InPeace);
///
/// let points = SigmaPoints::new(&inputs, gap)?;
/// assert_eq!(points.judge(&moments)?.verdict(), Verdict::Warned);
/// # Ok::<(), perturbation_moments::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SigmaPoints<const N: usize> {
    known: AlongDirections<N>,
}

impl<const N: usize> SigmaPoints<N> {
    /// Evaluates the response at the `2N + 1` points.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if the response is not finite; points are the centre, then `+` and `-` of each direction.
    pub fn new(
        inputs: &RandomVector<N>,
        response: impl Fn(&[f64; N]) -> f64,
    ) -> Result<Self, Error> {
        let at = |t: &[f64; N]| response(&inputs.point(t));
        let values: Vec<f64> = AlongDirections::star(SIGMA_POINT_DISTANCE).iter().map(at).collect();
        Self::from_values(&values)
    }

    /// Sigma points from the responses at the points of a star.
    ///
    /// The [star](AlongDirections::star) has the distance [`SIGMA_POINT_DISTANCE`].
    ///
    /// Use it for several responses of one run.
    ///
    /// # Errors
    /// Those of [`AlongDirections::from_star`].
    pub fn from_values(values: &[f64]) -> Result<Self, Error> {
        Ok(Self { known: AlongDirections::from_star(SIGMA_POINT_DISTANCE, values)? })
    }

    /// $y_0 + \tfrac12 \sum q_k$.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.known.value + 0.5 * self.known.second.iter().sum::<f64>()
    }

    /// $\sum a_k^2 + \tfrac12 \sum q_k^2$.
    #[must_use]
    pub fn variance(&self) -> f64 {
        let squares = |v: &[f64; N]| v.iter().map(|x| x * x).sum::<f64>();
        squares(&self.known.first) + 0.5 * squares(&self.known.second)
    }

    /// Slopes and curvatures over the distance of the points.
    #[must_use]
    pub const fn along(&self) -> &AlongDirections<N> {
        &self.known
    }

    /// Trust in Taylor moments, with the sigma points as a further indicator.
    ///
    /// # Errors
    /// [`Error::NoFirstOrderVariance`].
    pub fn judge(&self, moments: &Moments<N>) -> Result<Trust, Error> {
        let first_order = moments.first_order_variance()?;
        let ratio = (self.variance() / first_order - 1.0).abs();
        Ok(Trust { sigma_point_ratio: Some(ratio), ..moments.trust()? })
    }
}
