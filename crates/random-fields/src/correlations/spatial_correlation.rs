//! Correlation of two points: isotropic, with a length for each axis, or a product over axes.

use crate::correlations::correlation::{Correlation, CorrelationFunction, distance};
use crate::error::{Error, positive};

/// Largest deviation of the inner products of axes.
const ORTHONORMAL: f64 = 1e-9;
/// Largest correlation length, in sizes of the body.
const MOST_SIZES: f64 = 1e3;

/// Unit vectors at right angles, one in each row: the axes of an anisotropic correlation.
pub type Axes<const D: usize> = [[f64; D]; D];

/// The correlation of two points in `D` dimensions, of the difference `d` of their positions.
///
/// | form | correlation | use |
/// |---|---|---|
/// | isotropic | $\rho(\lvert d \rvert)$ | no direction is special |
/// | elliptic | $\rho\big(\sqrt{\sum_k (e_k \cdot d/l_k)^2}\big)$ | layers, fibres: iso-lines are ellipses |
/// | separable | $\prod_k \rho_k(\lvert e_k \cdot d \rvert)$ | soils, as $e^{-\lvert d_x \rvert/L_x - \lvert d_y \rvert/L_y}$; eigenfunctions of boxes are products |
///
/// Any of the functions of [`CorrelationFunction`] may be used in each form. Axes are unit vectors at right angles.
///
/// Source: Vanmarcke 1983, Random fields (ellipsoidal and separable correlation).
///
/// ```
/// use random_fields::{Correlation, CorrelationFunction, SpatialCorrelation};
///
/// let along = |length| Correlation { function: CorrelationFunction::Exponential, length };
/// let soil = SpatialCorrelation::separable([along(20.0), along(2.0)]);
/// // 10 m apart and 1 m below: exp(-1/2 - 1/2).
/// assert!((soil.between(&[0.0, 0.0], &[10.0, -1.0]) - (-1.0_f64).exp()).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum SpatialCorrelation<const D: usize> {
    /// Of the distance alone.
    Isotropic(Correlation),
    /// Of a distance in units of a length for each axis.
    Elliptic {
        /// Its shape.
        function: CorrelationFunction,
        /// The integral scale along each axis (length).
        lengths: [f64; D],
        /// The axes.
        axes: Axes<D>,
    },
    /// A product over axes.
    Separable {
        /// The correlation along each axis.
        factors: [Correlation; D],
        /// The axes.
        axes: Axes<D>,
    },
}

impl<const D: usize> From<Correlation> for SpatialCorrelation<D> {
    fn from(correlation: Correlation) -> Self {
        Self::Isotropic(correlation)
    }
}

impl<const D: usize> SpatialCorrelation<D> {
    /// The axes of the coordinates.
    pub const COORDINATES: Axes<D> = {
        let mut axes = [[0.0; D]; D];
        let mut k = 0;
        while k < D {
            axes[k][k] = 1.0;
            k += 1;
        }
        axes
    };

    /// Of a distance in units of a length for each coordinate.
    #[must_use]
    pub fn elliptic(function: CorrelationFunction, lengths: [f64; D]) -> Self {
        Self::Elliptic { function, lengths, axes: Self::COORDINATES }
    }

    /// A product over the coordinates.
    #[must_use]
    pub fn separable(factors: [Correlation; D]) -> Self {
        Self::Separable { factors, axes: Self::COORDINATES }
    }

    /// The same correlation about other axes; an isotropic one is left as it is.
    #[must_use]
    pub fn with_axes(self, axes: Axes<D>) -> Self {
        match self {
            Self::Isotropic(_) => self,
            Self::Elliptic { function, lengths, .. } => Self::Elliptic { function, lengths, axes },
            Self::Separable { factors, .. } => Self::Separable { factors, axes },
        }
    }

    /// The correlation of two points (lengths).
    #[must_use]
    pub fn between(&self, a: &[f64; D], b: &[f64; D]) -> f64 {
        const { assert!(D >= 1 && D <= 3, "not all of the functions are positive definite beyond") };
        match self {
            Self::Isotropic(correlation) => correlation.at(distance(a, b)),
            Self::Elliptic { function, lengths, axes } => {
                let along = |k: usize| component(&axes[k], a, b) / lengths[k];
                function.at((0..D).map(|k| along(k) * along(k)).sum::<f64>().sqrt())
            }
            Self::Separable { factors, axes } => {
                (0..D).map(|k| factors[k].at(component(&axes[k], a, b).abs())).product()
            }
        }
    }

    /// Checks lengths and axes.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for a length, [`Error::OutOfRange`] for a smoothness, [`Error::NotOrthonormal`].
    pub fn check(&self) -> Result<(), Error> {
        match self {
            Self::Isotropic(correlation) => correlation.check(),
            Self::Elliptic { function, lengths, axes } => {
                function.check()?;
                lengths.iter().try_for_each(|&length| positive("correlation length", length))?;
                check_axes(axes)
            }
            Self::Separable { factors, axes } => {
                factors.iter().try_for_each(Correlation::check)?;
                check_axes(axes)
            }
        }
    }

    /// Checks it for a body between two corners: no length may exceed 1000 sizes of the body.
    pub(crate) fn check_within(&self, low: &[f64; D], high: &[f64; D]) -> Result<(), Error> {
        self.check()?;
        let size = (0..D).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        let limit = MOST_SIZES * size;
        match self.lengths().into_iter().find(|&length| size > 0.0 && length > limit) {
            Some(length) => Err(Error::LengthBeyondBody { length, limit }),
            None => Ok(()),
        }
    }

    /// The axes; those of the coordinates where it is isotropic.
    pub(crate) fn axes(&self) -> Axes<D> {
        match self {
            Self::Isotropic(_) => Self::COORDINATES,
            Self::Elliptic { axes, .. } | Self::Separable { axes, .. } => *axes,
        }
    }

    /// The correlation length along each axis.
    pub(crate) fn lengths(&self) -> [f64; D] {
        match self {
            Self::Isotropic(correlation) => [correlation.length; D],
            Self::Elliptic { lengths, .. } => *lengths,
            Self::Separable { factors, .. } => factors.map(|factor| factor.length),
        }
    }
}

/// `e . (a - b)`.
fn component<const D: usize>(axis: &[f64; D], a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|k| axis[k] * (a[k] - b[k])).sum()
}

fn check_axes<const D: usize>(axes: &Axes<D>) -> Result<(), Error> {
    for first in 0..D {
        for second in 0..=first {
            let value: f64 = (0..D).map(|k| axes[first][k] * axes[second][k]).sum();
            let (expected, limit) = (f64::from(first == second), ORTHONORMAL);
            let difference = (value - expected).abs();
            if difference.is_nan() || difference > limit {
                return Err(Error::NotOrthonormal { first, second, value, expected, limit });
            }
        }
    }
    Ok(())
}

/// Lowest and highest coordinates of a set of points, checked to be there and finite.
pub(crate) fn bounds<const D: usize>(points: &[[f64; D]]) -> Result<[[f64; D]; 2], Error> {
    let Some(&first) = points.first() else { return Err(Error::NoPoints) };
    let (mut low, mut high) = (first, first);
    for (point, x) in points.iter().enumerate() {
        if let Some(&value) = x.iter().find(|x| !x.is_finite()) {
            return Err(Error::Point { name: "a coordinate", point, value, must: "finite" });
        }
        for k in 0..D {
            low[k] = low[k].min(x[k]);
            high[k] = high[k].max(x[k]);
        }
    }
    Ok([low, high])
}
