//! Mean, variance and third moment of a response from its derivatives.

use crate::along::{AlongDirections, Slopes};
use crate::error::Error;
use crate::expansion::Expansion;
use crate::random_vector::RandomVector;
use crate::trust::Trust;

/// Taylor moments of a response $y$, from its derivatives by the independent standard normals $t$ of its inputs.
///
/// With the covariance $\Sigma$ of normal inputs, gradient $g$, Hessian $H$ and third derivatives $T$ at the mean:
///
/// | moment | formula | exact for |
/// |---|---|---|
/// | [`mean_first_order`](Self::mean_first_order) | $y_0$ | linear |
/// | [`mean_second_order`](Self::mean_second_order) | $y_0 + \tfrac12 \operatorname{tr} H\Sigma$ | cubic |
/// | [`variance_first_order`](Self::variance_first_order) | $g^T \Sigma g$ | linear |
/// | [`variance_with_curvature`](Self::variance_with_curvature) | $g^T \Sigma g + \tfrac12 \operatorname{tr} H\Sigma H\Sigma$ | quadratic |
/// | [`variance_fourth_order`](Self::variance_fourth_order) | the same $+ \sum g_i T_{jkl} \Sigma_{ij} \Sigma_{kl}$ | quadratic; to $O(\sigma^4)$ for all |
/// | [`third_central_moment`](Self::third_central_moment) | $3 g^T \Sigma H \Sigma g + \operatorname{tr} (H\Sigma)^3$ | quadratic; to $O(\sigma^4)$ for all |
/// | [`fourth_cumulant`](Self::fourth_cumulant) | $12 g^T \Sigma H \Sigma H \Sigma g + 3 \operatorname{tr} (H\Sigma)^4$ | quadratic |
///
/// The variance with curvature alone is **not** of fourth order: it omits a term as large as the one it adds, and can
/// be worse than the first-order variance. See [`trust`](Self::trust). For lognormal inputs the same formulas hold in
/// normal coordinates; see [`RandomVector`].
///
/// Sources: Ang and Tang 2007 (first order); the cumulants of a quadratic form in Gaussian variables, Mathai and Provost
/// 1992, chapter 3; the third-derivative term by the same expansion carried to $O(\sigma^4)$.
///
/// ```
/// use perturbation_moments::{Expansion, Moments, RandomVector};
///
/// // y = x^2 at mean 3, deviation 0.5: E = 9.25, Var = 4 9 0.25 + 2 0.25^2 = 9.125.
/// let inputs = RandomVector::independent([3.0], [0.5])?;
/// let square = Expansion { value: 9.0, gradient: [6.0], hessian: Some([[2.0]]), third: None };
/// let moments = Moments::new(&inputs, &square)?;
/// assert_eq!(moments.mean_second_order()?, 9.25);
/// assert_eq!(moments.variance_with_curvature()?, 9.125);
/// # Ok::<(), perturbation_moments::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments<const N: usize> {
    value: f64,
    /// `a = L^T D g`.
    first: [f64; N],
    second: Second<N>,
    /// `sum_k d^3 y / dt_j dt_k dt_k`.
    third: Option<[f64; N]>,
    /// `g_i (Sigma g)_i`.
    shares: Option<[f64; N]>,
    /// Level below which the first-order variance is roundoff.
    roundoff: f64,
}

/// Known part of the Hessian with respect to `t`.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Second<const N: usize> {
    None,
    Full([[f64; N]; N]),
    Diagonal { entries: [f64; N], mixed_squares: Option<f64> },
}

impl<const N: usize> Moments<N> {
    /// Moments from derivatives with respect to the inputs at the centre of `inputs`.
    ///
    /// # Errors
    /// [`Error::NotFinite`] and [`Error::NotSymmetric`] for invalid derivatives.
    pub fn new(inputs: &RandomVector<N>, expansion: &Expansion<N>) -> Result<Self, Error> {
        expansion.check()?;
        let by_t = inputs.standardise(expansion);
        let (slopes, _, _) = inputs.marginal_derivatives();
        let terms = std::array::from_fn(|i| expansion.gradient[i] * slopes[i]);
        let second = by_t.hessian.map_or(Second::None, Second::Full);
        let third =
            by_t.third.map(|t| std::array::from_fn(|j| (0..N).map(|k| t[j][k][k]).sum::<f64>()));
        let moments = Self {
            value: by_t.value,
            first: by_t.gradient,
            second,
            third,
            shares: Some(shares(inputs, &terms, &by_t.gradient)),
            roundoff: roundoff(&terms),
        };
        moments.check()
    }

    /// Moments from derivatives along the directions `L e_k`.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn along(inputs: &RandomVector<N>, known: &AlongDirections<N>) -> Result<Self, Error> {
        known.check()?;
        let AlongDirections { value, first, second, mixed_squares } = *known;
        let second = Second::Diagonal { entries: second, mixed_squares };
        Self::by_directions(inputs, &Slopes { value, first }, second)
    }

    /// Moments from first derivatives along the directions `L e_k`: those of second order are
    /// [`Error::CurvatureIncomplete`].
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn from_slopes(inputs: &RandomVector<N>, slopes: &Slopes<N>) -> Result<Self, Error> {
        crate::error::require_finite("value of the response", 0, slopes.value)?;
        for (k, &slope) in slopes.first.iter().enumerate() {
            crate::error::require_finite("first derivative along direction", k, slope)?;
        }
        Self::by_directions(inputs, slopes, Second::None)
    }

    fn by_directions(
        inputs: &RandomVector<N>,
        &Slopes { value, first }: &Slopes<N>,
        second: Second<N>,
    ) -> Result<Self, Error> {
        let terms = solve_transposed(inputs.lower_factor(), &first);
        let moments = Self {
            value,
            first,
            second,
            third: None,
            shares: terms.map(|terms| shares(inputs, &terms, &first)),
            roundoff: roundoff(&terms.unwrap_or(first)),
        };
        moments.check()
    }

    /// Squares of finite derivatives may overflow.
    fn check(self) -> Result<Self, Error> {
        let squares = self.second_squares("curvature", "").unwrap_or(0.0);
        crate::error::require_finite("first-order variance", 0, self.variance_first_order())?;
        crate::error::require_finite("square of the Hessian", 0, squares)?;
        Ok(self)
    }

    /// $y_0$: the response at the centre.
    #[must_use]
    pub const fn mean_first_order(&self) -> f64 {
        self.value
    }

    /// $y_0 + \tfrac12 \operatorname{tr} H\Sigma$.
    ///
    /// # Errors
    /// [`Error::CurvatureIncomplete`] without second derivatives.
    pub fn mean_second_order(&self) -> Result<f64, Error> {
        let diagonal: [f64; N] = match self.second {
            Second::Full(a) => std::array::from_fn(|k| a[k][k]),
            Second::Diagonal { entries, .. } => entries,
            Second::None => {
                return Err(incomplete(
                    "the second-order mean",
                    "second derivatives, all or along the directions L e_k",
                    "none are",
                ));
            }
        };
        Ok(self.value + 0.5 * diagonal.iter().sum::<f64>())
    }

    /// Derivatives with respect to the independent standard normals of the inputs, $L^T D g$.
    #[must_use]
    pub const fn slopes(&self) -> &[f64; N] {
        &self.first
    }

    /// $g^T \Sigma g$.
    #[must_use]
    pub fn variance_first_order(&self) -> f64 {
        dot(&self.first, &self.first)
    }

    /// $g^T \Sigma g + \tfrac12 \operatorname{tr} H\Sigma H\Sigma$; an estimate of it from a diagonal with a probe.
    ///
    /// # Errors
    /// [`Error::CurvatureIncomplete`] for a diagonal without a probe, or without second derivatives.
    pub fn variance_with_curvature(&self) -> Result<f64, Error> {
        let squares =
            self.second_squares("the variance with curvature", "the full Hessian or a probe")?;
        Ok(self.variance_first_order() + 0.5 * squares)
    }

    /// Variance with all terms to $O(\sigma^4)$:
    ///
    /// $g^T \Sigma g + \tfrac12 \operatorname{tr} H\Sigma H\Sigma + \sum g_i T_{jkl} \Sigma_{ij} \Sigma_{kl}$. It may
    /// be negative where the series fails; [`trust`](Self::trust) warns long before.
    ///
    /// # Errors
    /// [`Error::ThirdDerivativesMissing`]; [`Error::CurvatureIncomplete`] as for the variance with curvature.
    pub fn variance_fourth_order(&self) -> Result<f64, Error> {
        let moment = "the variance of fourth order";
        let third = self.third.ok_or(Error::ThirdDerivativesMissing { moment })?;
        Ok(self.variance_with_curvature()? + dot(&self.first, &third))
    }

    /// $3 g^T \Sigma H \Sigma g + \operatorname{tr} (H\Sigma)^3$.
    ///
    /// # Errors
    /// [`Error::CurvatureIncomplete`] without the full Hessian.
    pub fn third_central_moment(&self) -> Result<f64, Error> {
        let a = self.full("the third central moment")?;
        let once = times(a, &self.first);
        let mut cube = 0.0;
        for row in a {
            cube += dot(row, &times(a, row));
        }
        Ok(3.0 * dot(&self.first, &once) + cube)
    }

    /// $12 g^T \Sigma H \Sigma H \Sigma g + 3 \operatorname{tr} (H\Sigma)^4$, the fourth cumulant.
    ///
    /// It equals the fourth central moment minus three times the square of the variance.
    ///
    /// # Errors
    /// [`Error::CurvatureIncomplete`] without the full Hessian.
    pub fn fourth_cumulant(&self) -> Result<f64, Error> {
        let a = self.full("the fourth cumulant")?;
        let once = times(a, &self.first);
        let mut fourth = 0.0;
        for row in a {
            let square = times(a, row);
            fourth += dot(&square, &square);
        }
        Ok(12.0 * dot(&once, &once) + 3.0 * fourth)
    }

    /// Share of each input in the first-order variance, $g_i (\Sigma g)_i / g^T \Sigma g$.
    ///
    /// The shares sum to one. For correlated inputs **a share may be negative** or above one: an input with opposite
    /// effect cancels part of another's contribution. A share is then no fraction of a whole. For lognormal inputs $g$
    /// and $\Sigma$ are those of the normal coordinates.
    ///
    /// # Errors
    /// [`Error::NoFirstOrderVariance`]; [`Error::CurvatureIncomplete`] for derivatives along the directions of a
    /// singular correlation, which do not determine the gradient with respect to the inputs.
    pub fn importance_factors(&self) -> Result<[f64; N], Error> {
        let variance = self.first_order_variance()?;
        let shares = self.shares.ok_or(incomplete(
            "importance factors",
            "the gradient by the inputs",
            "derivatives along the directions of a singular correlation are",
        ))?;
        Ok(shares.map(|share| share / variance))
    }

    /// Trust indicators of the Taylor series.
    ///
    /// # Errors
    /// [`Error::NoFirstOrderVariance`] if the first-order variance is zero.
    pub fn trust(&self) -> Result<Trust, Error> {
        let variance = self.first_order_variance()?;
        let squares = self.second_squares("", "").ok();
        Ok(Trust {
            curvature_ratio: squares.map(|squares| 0.5 * squares / variance),
            third_ratio: self.third.map(|third| dot(&self.first, &third).abs() / variance),
            sigma_point_ratio: None,
        })
    }

    /// The quadratic surrogate at independent standard normals `t`; linear without second derivatives.
    ///
    /// Its exact moments are [`surrogate_mean`](Self::surrogate_mean) and
    /// [`surrogate_variance`](Self::surrogate_variance).
    #[must_use]
    pub fn surrogate(&self, t: &[f64; N]) -> f64 {
        let quadratic = match &self.second {
            Second::None => 0.0,
            Second::Full(a) => dot(t, &times(a, t)),
            Second::Diagonal { entries, .. } => (0..N).map(|k| entries[k] * t[k] * t[k]).sum(),
        };
        self.value + dot(&self.first, t) + 0.5 * quadratic
    }

    /// Exact mean of the surrogate.
    #[must_use]
    pub fn surrogate_mean(&self) -> f64 {
        self.mean_second_order().unwrap_or(self.value)
    }

    /// Exact variance of the surrogate; without mixed derivatives, of a surrogate that has none.
    #[must_use]
    pub fn surrogate_variance(&self) -> f64 {
        let squares = match &self.second {
            Second::None => 0.0,
            Second::Full(a) => squares(a),
            Second::Diagonal { entries, .. } => dot(entries, entries),
        };
        self.variance_first_order() + 0.5 * squares
    }

    pub(crate) fn first_order_variance(&self) -> Result<f64, Error> {
        let (value, limit) = (self.variance_first_order(), self.roundoff);
        if value > limit { Ok(value) } else { Err(Error::NoFirstOrderVariance { value, limit }) }
    }

    /// `tr(AA)`.
    fn second_squares(&self, moment: &'static str, needed: &'static str) -> Result<f64, Error> {
        match &self.second {
            Second::Full(a) => Ok(squares(a)),
            Second::Diagonal { entries, mixed_squares: Some(mixed) } => {
                Ok(dot(entries, entries) + mixed)
            }
            Second::Diagonal { .. } => Err(incomplete(moment, needed, "only their diagonal is")),
            Second::None => Err(incomplete(moment, needed, "no second derivatives are")),
        }
    }

    fn full(&self, moment: &'static str) -> Result<&[[f64; N]; N], Error> {
        match &self.second {
            Second::Full(a) => Ok(a),
            Second::Diagonal { .. } => {
                Err(incomplete(moment, "the full Hessian", "only its diagonal is"))
            }
            Second::None => {
                Err(incomplete(moment, "the full Hessian", "no second derivatives are"))
            }
        }
    }
}

fn incomplete(moment: &'static str, needed: &'static str, given: &'static str) -> Error {
    Error::CurvatureIncomplete { moment, needed, given }
}

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    (0..N).map(|k| a[k] * b[k]).sum()
}

fn times<const N: usize>(a: &[[f64; N]; N], v: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|k| dot(&a[k], v))
}

fn squares<const N: usize>(a: &[[f64; N]; N]) -> f64 {
    a.iter().map(|row| dot(row, row)).sum()
}

/// `h_i (C h)_i` with `h = D g`, and `C h = L a`.
fn shares<const N: usize>(
    inputs: &RandomVector<N>,
    terms: &[f64; N],
    first: &[f64; N],
) -> [f64; N] {
    std::array::from_fn(|i| terms[i] * dot(&inputs.lower_factor()[i], first))
}

/// Square of the possible roundoff of a sum that should be zero, from terms that cancel or from rounded derivatives.
fn roundoff<const N: usize>(terms: &[f64; N]) -> f64 {
    let sum: f64 = terms.iter().map(|term| term.abs()).sum();
    (16.0 * f64::EPSILON * sum).powi(2)
}

/// Solves `L^T h = a`; none for a singular `L`.
fn solve_transposed<const N: usize>(l: &[[f64; N]; N], a: &[f64; N]) -> Option<[f64; N]> {
    let mut h = [0.0; N];
    for k in (0..N).rev() {
        if l[k][k] <= 0.0 {
            return None;
        }
        h[k] = (a[k] - (k + 1..N).map(|i| l[i][k] * h[i]).sum::<f64>()) / l[k][k];
    }
    Some(h)
}
