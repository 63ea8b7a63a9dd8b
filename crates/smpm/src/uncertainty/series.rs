//! A response as a Taylor series in independent standard normals: mean, variance, and how far to trust them.

use crate::error::Error;

/// A response as a Taylor series in independent standard normals, without mixed second derivatives.
///
/// $$ y(t) \approx y_0 + \sum_k g_k t_k + \tfrac12 \sum_k h_k t_k^2, \qquad
///    g_k = \frac{\partial y}{\partial t_k}, \quad h_k = \frac{\partial^2 y}{\partial t_k^2} $$
///
/// Mean to second order: $y_0 + \tfrac12 \sum_k h_k$, complete, since mixed terms have no mean. Variance to first order:
/// $\sum_k g_k^2$; what it leaves out is $\tfrac12 \lVert H \rVert_F^2$ and higher terms.
///
/// Source: Ghanem and Spanos 1991 (coefficients of a Karhunen-Loève expansion), chapter 2; the moments are those of any Taylor series
/// in normals.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// `y_0`, with all normals zero.
    pub value: f64,
    /// `g`, by normal.
    pub gradient: Vec<f64>,
    /// `h`, by normal; empty where it is unknown.
    pub curvature: Vec<f64>,
    /// $\sum_{j \ne k} H_{jk}^2$, estimated by probes; `None` without any.
    pub mixed_squares: Option<f64>,
}

/// Below this multiple of the slopes a standard deviation is roundoff.
const ROUNDOFF: f64 = 16.0 * f64::EPSILON;

impl Series {
    /// Refuses derivatives that have overflowed.
    pub(super) fn checked(self) -> Result<Self, Error> {
        let finite = |quantity: &'static str, numbers: &[f64]| match numbers
            .iter()
            .position(|number| !number.is_finite())
        {
            None => Ok(()),
            Some(index) => {
                let value = numbers[index];
                Err(perturbation_moments::Error::NotFinite { quantity, index, value })
            }
        };
        finite("value of the response", &[self.value])?;
        finite("first derivative along direction", &self.gradient)?;
        finite("second derivative along direction", &self.curvature)?;
        let squares = self.mixed_squares.unwrap_or(0.0);
        finite("variance of the series", &[self.surrogate_variance() + squares])?;
        Ok(self)
    }

    /// The mean: to second order, or to first order where the curvature is unknown.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.value + 0.5 * self.curvature.iter().sum::<f64>()
    }

    /// The variance to first order.
    #[must_use]
    pub fn variance(&self) -> f64 {
        square(&self.gradient)
    }

    /// The series at a point.
    #[must_use]
    pub fn surrogate(&self, normals: &[f64]) -> f64 {
        let curvature = self.curvature.iter().chain(std::iter::repeat(&0.0));
        let terms = normals.iter().zip(self.gradient.iter().zip(curvature));
        self.value + terms.map(|(t, (g, h))| (g + 0.5 * h * t) * t).sum::<f64>()
    }

    /// The variance of the series: $\sum_k (g_k^2 + \tfrac12 h_k^2)$.
    #[must_use]
    pub fn surrogate_variance(&self) -> f64 {
        self.variance() + 0.5 * square(&self.curvature)
    }

    /// The variance by curvature over that by slope: $\tfrac12 \lVert H \rVert_F^2 / \sum_k g_k^2$, of own curvatures alone where
    /// there were no probes. `None` where no curvature is known, or where the slopes are roundoff.
    #[must_use]
    pub fn curvature_ratio(&self) -> Option<f64> {
        let variance = self.variance();
        let slopes: f64 = self.gradient.iter().map(|slope| slope.abs()).sum();
        if variance <= (ROUNDOFF * slopes).powi(2) {
            return None;
        }
        match self.mixed_squares {
            Some(mixed) => Some(0.5 * (square(&self.curvature) + mixed) / variance),
            None if self.curvature.iter().all(|&curvature| curvature == 0.0) => None,
            None => Some((self.surrogate_variance() - variance) / variance),
        }
    }
}

fn square(numbers: &[f64]) -> f64 {
    numbers.iter().map(|number| number * number).sum()
}
