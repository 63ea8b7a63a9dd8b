//! Random inputs: means, covariance, marginal distributions.

use crate::error::{Error, require_finite};
use crate::expansion::{Expansion, check_symmetric, set_symmetric};
use crate::symmetric::{eigenvalues, factor, roundoff};

/// Marginal distribution of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Marginal {
    /// Gaussian.
    #[default]
    Normal,
    /// The logarithm is Gaussian, for quantities that cannot be negative. The mean must be positive.
    Lognormal,
}

/// `N` random inputs: mean, standard deviations, correlation, marginals.
///
/// The joint distribution is defined through normal coordinates: with independent standard normals $t$ and
/// $C = L L^T$,
///
/// $$ u = L t, \qquad x_i = \mu_i + \sigma_i u_i \quad\text{or}\quad x_i = e^{m_i + s_i u_i}, \qquad
///    s_i^2 = \ln\left(1 + \sigma_i^2/\mu_i^2\right), \quad m_i = \ln \mu_i - s_i^2/2 . $$
///
/// `mean`, `deviations` and correlation are always those of the inputs $x$ themselves. The correlation $C$ of the normal
/// coordinates follows in closed form: equal between normals, and
/// $C_{ij} = \ln(1 + \rho_{ij} \delta_i \delta_j)/(s_i s_j)$ between lognormals,
/// $C_{ij} = \rho_{ij} \delta_i/s_i$ between lognormal $i$ and normal $j$, with $\delta = \sigma/\mu$.
///
/// A lognormal input enters the Taylor moments as the exponential of a Gaussian input: the chain rule transforms
/// derivatives with respect to $x$ to $u$. The alternative, third and fourth central moments of $x$ in the series,
/// would require joint moments of all inputs and formulas that depend on the marginals.
///
/// Derivatives are evaluated at [`centre`](Self::centre), where $u = 0$: the mean of a normal and the **median** of a
/// lognormal input. First order means first order about the median; the second-order mean contains the rest.
///
/// ```
/// use perturbation_moments::{Marginal, RandomVector};
///
/// let load = RandomVector::new([10.0, 4.0], [1.0, 0.4], [[1.0, 0.5], [0.5, 1.0]])?;
/// assert_eq!(load.covariance(), [[1.0, 0.2], [0.2, 0.16000000000000003]]);
///
/// let load = load.with_marginals([Marginal::Lognormal, Marginal::Normal])?;
/// assert!((load.centre()[0] - 10.0 / 1.01_f64.sqrt()).abs() < 1e-14); // the median
/// # Ok::<(), perturbation_moments::Error>(())
/// ```
///
/// Source of the closed correlations: Liu and Der Kiureghian 1986, Multivariate distribution models with prescribed
/// marginals and covariances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RandomVector<const N: usize> {
    mean: [f64; N],
    deviations: [f64; N],
    correlation: [[f64; N]; N],
    marginals: [Marginal; N],
    /// `sigma_i`, or `s_i` of the logarithm.
    scales: [f64; N],
    /// `L`, lower triangular.
    factor: [[f64; N]; N],
}

impl<const N: usize> RandomVector<N> {
    /// Normal inputs from means, standard deviations and the correlation matrix, each in the unit of its input.
    ///
    /// A deviation of zero makes an input certain.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::Negative`] (deviation), [`Error::NotSymmetric`], [`Error::Correlation`] (a
    /// diagonal entry not one, another above one), [`Error::NotPositiveSemidefinite`] with the invalid eigenvalue.
    pub fn new(
        mean: [f64; N],
        deviations: [f64; N],
        correlation: [[f64; N]; N],
    ) -> Result<Self, Error> {
        Self::checked(mean, deviations, correlation, [Marginal::Normal; N])
    }

    /// Uncorrelated normal inputs.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn independent(mean: [f64; N], deviations: [f64; N]) -> Result<Self, Error> {
        Self::new(mean, deviations, identity())
    }

    /// The same means, deviations and correlation with other marginal distributions.
    ///
    /// # Errors
    /// [`Error::LognormalMean`] for a mean that is not positive; [`Error::Correlation`] and
    /// [`Error::NotPositiveSemidefinite`] for a correlation that is impossible for these marginals.
    pub fn with_marginals(self, marginals: [Marginal; N]) -> Result<Self, Error> {
        Self::checked(self.mean, self.deviations, self.correlation, marginals)
    }

    fn checked(
        mean: [f64; N],
        deviations: [f64; N],
        correlation: [[f64; N]; N],
        marginals: [Marginal; N],
    ) -> Result<Self, Error> {
        check_inputs(&mean, &deviations, &correlation)?;
        let mut scales = deviations;
        for i in (0..N).filter(|&i| marginals[i] == Marginal::Lognormal) {
            if mean[i] <= 0.0 {
                return Err(Error::LognormalMean { index: i, value: mean[i] });
            }
            scales[i] = (deviations[i] / mean[i]).powi(2).ln_1p().sqrt();
        }
        let mut normal = identity();
        for i in 0..N {
            for j in 0..i {
                let value = normal_correlation(i, j, &mean, &deviations, &correlation, &marginals);
                if value.is_nan() || value.abs() > 1.0 + roundoff(N) {
                    let requirement = "in normal coordinates, must lie in [-1, 1]";
                    return Err(Error::Correlation { row: i, column: j, value, requirement });
                }
                (normal[i][j], normal[j][i]) = (value, value);
            }
        }
        let limit = -roundoff(N);
        for (index, eigenvalue) in eigenvalues(&normal).into_iter().enumerate() {
            if eigenvalue < limit {
                return Err(Error::NotPositiveSemidefinite { index, eigenvalue, limit });
            }
        }
        Ok(Self { mean, deviations, correlation, marginals, scales, factor: factor(&normal) })
    }

    /// The means of the inputs.
    #[must_use]
    pub const fn mean(&self) -> &[f64; N] {
        &self.mean
    }

    /// The standard deviations of the inputs.
    #[must_use]
    pub const fn deviations(&self) -> &[f64; N] {
        &self.deviations
    }

    /// The covariance matrix of the inputs.
    #[must_use]
    pub fn covariance(&self) -> [[f64; N]; N] {
        let s = &self.deviations;
        std::array::from_fn(|i| std::array::from_fn(|j| self.correlation[i][j] * s[i] * s[j]))
    }

    /// Expansion point: the mean of normal, the median of lognormal inputs.
    #[must_use]
    pub fn centre(&self) -> [f64; N] {
        self.point(&[0.0; N])
    }

    /// The inputs for independent standard normals `t`.
    #[must_use]
    pub fn point(&self, t: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|i| {
            self.marginal_point(i, (0..=i).map(|k| self.factor[i][k] * t[k]).sum())
        })
    }

    /// The quantile at $\Phi(u)$ of every input separately.
    #[must_use]
    pub fn quantiles(&self, u: f64) -> [f64; N] {
        std::array::from_fn(|i| self.marginal_point(i, u))
    }

    /// Input `i` at the normal coordinate `u`.
    fn marginal_point(&self, i: usize, u: f64) -> f64 {
        let (mean, s) = (self.mean[i], self.scales[i]);
        match self.marginals[i] {
            Marginal::Normal => mean + s * u,
            Marginal::Lognormal => (mean.ln() - 0.5 * s * s + s * u).exp(),
        }
    }

    /// Transforms an expansion from the inputs to the independent standard normals `t`.
    ///
    /// $$ \frac{\partial y}{\partial t} = L^T D g, \qquad \frac{\partial^2 y}{\partial t^2} = L^T (D H D + \ldots) L $$
    pub(crate) fn standardise(&self, given: &Expansion<N>) -> Expansion<N> {
        let (d, c, b) = self.marginal_derivatives();
        let gradient: [f64; N] = std::array::from_fn(|i| given.gradient[i] * d[i]);
        let hessian = given.hessian.map(|h| {
            let mut out = [[0.0; N]; N];
            for i in 0..N {
                for j in 0..N {
                    out[i][j] = h[i][j] * d[i] * d[j];
                }
                out[i][i] += given.gradient[i] * c[i];
            }
            out
        });
        let third = given.third.zip(given.hessian).map(|(t, h)| {
            let mut out = [[[0.0; N]; N]; N];
            for i in 0..N {
                for j in i..N {
                    for k in j..N {
                        let mut value = t[i][j][k] * d[i] * d[j] * d[k];
                        // Two of three indices equal: the curvature of that marginal.
                        for (a, b, other) in [(i, j, k), (i, k, j), (j, k, i)] {
                            if a == b {
                                value += h[a][other] * c[a] * d[other];
                            }
                        }
                        if i == j && j == k {
                            value += given.gradient[i] * b[i];
                        }
                        set_symmetric(&mut out, [i, j, k], value);
                    }
                }
            }
            out
        });
        self.rotate(&Expansion { value: given.value, gradient, hessian, third })
    }

    /// Transforms from the correlated normal coordinates `u` to the independent `t`.
    fn rotate(&self, given: &Expansion<N>) -> Expansion<N> {
        let l = &self.factor;
        let along = |v: &[f64; N]| -> [f64; N] {
            std::array::from_fn(|k| (k..N).map(|i| v[i] * l[i][k]).sum())
        };
        let both = |h: &[[f64; N]; N]| -> [[f64; N]; N] {
            let half: [[f64; N]; N] = std::array::from_fn(|i| along(&h[i]));
            std::array::from_fn(|k| {
                std::array::from_fn(|m| (k..N).map(|i| half[i][m] * l[i][k]).sum())
            })
        };
        let third = given.third.map(|t| {
            let half: [[[f64; N]; N]; N] = std::array::from_fn(|i| both(&t[i]));
            let mut out = [[[0.0; N]; N]; N];
            for (k, slice) in out.iter_mut().enumerate() {
                for (m, row) in slice.iter_mut().enumerate() {
                    for (n, entry) in row.iter_mut().enumerate() {
                        *entry = (k..N).map(|i| half[i][m][n] * l[i][k]).sum();
                    }
                }
            }
            out
        });
        Expansion {
            value: given.value,
            gradient: along(&given.gradient),
            hessian: given.hessian.as_ref().map(both),
            third,
        }
    }

    /// First, second and third derivative of each input with respect to its normal coordinate at the centre.
    pub(crate) fn marginal_derivatives(&self) -> ([f64; N], [f64; N], [f64; N]) {
        let (mut d, mut c, mut b) = (self.scales, [0.0; N], [0.0; N]);
        let centre = self.centre();
        for i in (0..N).filter(|&i| self.marginals[i] == Marginal::Lognormal) {
            let s = self.scales[i];
            (d[i], c[i], b[i]) = (s * centre[i], s * s * centre[i], s * s * s * centre[i]);
        }
        (d, c, b)
    }

    pub(crate) fn lower_factor(&self) -> &[[f64; N]; N] {
        &self.factor
    }
}

fn identity<const N: usize>() -> [[f64; N]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
}

fn check_inputs<const N: usize>(
    mean: &[f64; N],
    deviations: &[f64; N],
    correlation: &[[f64; N]; N],
) -> Result<(), Error> {
    for index in 0..N {
        require_finite("mean", index, mean[index])?;
        require_finite("standard deviation", index, deviations[index])?;
        if deviations[index] < 0.0 {
            let value = deviations[index];
            return Err(Error::Negative { quantity: "standard deviation", index, value });
        }
    }
    for row in 0..N {
        for column in 0..N {
            let value = correlation[row][column];
            require_finite("correlation entry", N * row + column, value)?;
            let requirement = if row == column && (value - 1.0).abs() > roundoff(N) {
                "must be 1"
            } else if value.abs() > 1.0 + roundoff(N) {
                "must lie in [-1, 1]"
            } else {
                continue;
            };
            return Err(Error::Correlation { row, column, value, requirement });
        }
    }
    check_symmetric("correlation", correlation)
}

/// Correlation of the normal coordinates for a correlation of two inputs.
fn normal_correlation<const N: usize>(
    i: usize,
    j: usize,
    mean: &[f64; N],
    deviations: &[f64; N],
    correlation: &[[f64; N]; N],
    marginals: &[Marginal; N],
) -> f64 {
    let rho = correlation[i][j];
    let coefficient = |k: usize| match marginals[k] {
        Marginal::Lognormal if deviations[k] > 0.0 => Some(deviations[k] / mean[k]),
        _ => None,
    };
    let scale = |delta: f64| (delta * delta).ln_1p().sqrt();
    match (coefficient(i), coefficient(j)) {
        (Some(a), Some(b)) => (rho * a * b).ln_1p() / (scale(a) * scale(b)),
        (Some(delta), None) | (None, Some(delta)) => rho * delta / scale(delta),
        (None, None) => rho,
    }
}
