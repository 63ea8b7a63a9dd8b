//! Mean and variance of a response from its derivatives by the coefficients of random fields.

use perturbation_moments::MonteCarlo;
use uq_estimators::SampledMoments;

use super::sampled::Sampled;
use crate::error::Error;

/// A response as a Taylor series in independent standard normals, without mixed second derivatives.
///
/// $$ y(\xi) \approx y_0 + \sum_k g_k \xi_k + \tfrac12 \sum_k h_k \xi_k^2, \qquad
///    g_k = \frac{\partial y}{\partial \xi_k}, \quad h_k = \frac{\partial^2 y}{\partial \xi_k^2} $$
///
/// Mean to second order: $y_0 + \tfrac12 \sum_k h_k$, complete, since mixed terms have no mean. Variance to first order:
/// $\sum_k g_k^2$; what it leaves out is $\tfrac12 \lVert H \rVert_F^2$ and higher terms.
///
/// Source: Ghanem and Spanos 1991 (coefficients of a Karhunen-Loève expansion), chapter 2; the moments are those of any Taylor series
/// in normals.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldMoments {
    /// `y_0`, with all coefficients zero.
    pub value: f64,
    /// `g`, by coefficient.
    pub gradient: Vec<f64>,
    /// `h`, by coefficient.
    pub curvature: Vec<f64>,
}

impl FieldMoments {
    /// From first and second derivatives by each coefficient.
    pub(super) fn of(value: f64, along: &[[f64; 2]]) -> Self {
        let (gradient, curvature) = along.iter().map(|[g, h]| (*g, *h)).unzip();
        Self { value, gradient, curvature }
    }

    /// The mean to second order.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.value + 0.5 * self.curvature.iter().sum::<f64>()
    }

    /// The variance to first order.
    #[must_use]
    pub fn variance(&self) -> f64 {
        self.gradient.iter().map(|g| g * g).sum()
    }

    /// The direction of the gradient, of length one; `None` where it is zero.
    #[must_use]
    pub fn direction(&self) -> Option<Vec<f64>> {
        let length = self.variance().sqrt();
        (length > 0.0).then(|| self.gradient.iter().map(|g| g / length).collect())
    }

    /// The series at a point.
    #[must_use]
    pub fn surrogate(&self, coefficients: &[f64]) -> f64 {
        let terms = coefficients.iter().zip(self.gradient.iter().zip(&self.curvature));
        self.value + terms.map(|(xi, (g, h))| (g + 0.5 * h * xi) * xi).sum::<f64>()
    }

    /// The variance of the series: $\sum_k (g_k^2 + \tfrac12 h_k^2)$.
    #[must_use]
    pub fn surrogate_variance(&self) -> f64 {
        self.variance() + 0.5 * self.curvature.iter().map(|h| h * h).sum::<f64>()
    }
}

impl Sampled {
    /// As [`controlled`](Self::controlled), with the Taylor series in the coefficients of fields as control variate.
    ///
    /// # Errors
    /// As [`raw`](Self::raw).
    pub fn controlled_by_fields(
        &self,
        response: usize,
        series: &FieldMoments,
    ) -> Result<SampledMoments, Error> {
        let judge = MonteCarlo { seed: self.design.seed(), n_samples: 0 };
        let of = |realisation| {
            let mut normals = vec![0.0; series.gradient.len()];
            judge.fill_normals(realisation, &mut normals);
            series.surrogate(&normals)
        };
        self.controlled_by(response, (series.mean(), series.surrogate_variance()), &of)
    }
}
