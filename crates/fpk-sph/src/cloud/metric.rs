//! The metric of the cloud: in which coordinates distances between particles are measured.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use crate::error::Error;

/// In which coordinates smoothing lengths and distances are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Metric {
    /// The state's own coordinates, whatever their units (Canor & Denoël 2013).
    Isotropic,
    /// Coordinates in which the covariance of the cloud is the unit matrix, at every stage of a step:
    /// `y = L^-1 (x - mean)` with `L L^T = cov(x)`. Independent of units; a cloud that is a Gaussian stays round.
    Whitened,
}

/// Smallest pivot of the Cholesky factorisation over the variance of its axis: `1 - R^2` of that component on those
/// before it. Roundoff of a covariance summed in f64 is about 1e-15.
const SMALLEST_RELATIVE_PIVOT: f64 = 1e-12;

/// The affine map `x = mean + L y` with lower triangular `L`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Whitening<const D: usize> {
    mean: [f64; D],
    /// `L`, lower triangular.
    factor: [[f64; D]; D],
}

impl<const D: usize> Whitening<D> {
    /// The map that changes nothing.
    pub(crate) fn identity() -> Self {
        let mut factor = [[0.0; D]; D];
        for (k, row) in factor.iter_mut().enumerate() {
            row[k] = 1.0;
        }
        Self { mean: [0.0; D], factor }
    }

    /// The map of a metric for a cloud of particles of the given masses, at a step and time that errors name.
    pub(crate) fn of(
        metric: Metric,
        positions: &[[f64; D]],
        masses: &[f64],
        at: (u64, f64),
    ) -> Result<Self, Error> {
        if metric == Metric::Isotropic {
            return Ok(Self::identity());
        }
        let (mean, covariance) = mean_and_covariance(positions, masses);
        Self::of_covariance(mean, &covariance, at)
    }

    /// The map to `y = x - mean`.
    pub(crate) fn shifted(mean: [f64; D]) -> Self {
        Self { mean, ..Self::identity() }
    }

    /// The map that makes the given covariance the unit matrix.
    pub(crate) fn of_covariance(
        mean: [f64; D],
        covariance: &[[f64; D]; D],
        at: (u64, f64),
    ) -> Result<Self, Error> {
        let factor = cholesky(covariance).map_err(|(axis, pivot)| {
            let (step, time) = at;
            Error::SingularCovariance { step, time, axis, pivot, limit: SMALLEST_RELATIVE_PIVOT }
        })?;
        Ok(Self { mean, factor })
    }

    /// `y = L^-1 (x - mean)`.
    #[inline(always)]
    pub(crate) fn whiten(&self, x: &[f64; D]) -> [f64; D] {
        let mut offset = *x;
        for (value, mean) in offset.iter_mut().zip(&self.mean) {
            *value -= mean;
        }
        self.whiten_vector(&offset)
    }

    /// `L^-1 u`, for a velocity or a difference of positions.
    #[inline(always)]
    pub(crate) fn whiten_vector(&self, u: &[f64; D]) -> [f64; D] {
        let mut y = *u;
        for i in 0..D {
            for j in 0..i {
                y[i] -= self.factor[i][j] * y[j];
            }
            y[i] /= self.factor[i][i];
        }
        y
    }

    /// `x = mean + L y`.
    pub(crate) fn unwhiten(&self, y: &[f64; D]) -> [f64; D] {
        let mut x = self.mean;
        for (i, value) in x.iter_mut().enumerate() {
            for j in 0..=i {
                *value += self.factor[i][j] * y[j];
            }
        }
        x
    }

    /// `L^-T s`: a gradient with respect to `y` becomes one with respect to `x`.
    #[inline(always)]
    pub(crate) fn unwhiten_gradient(&self, s: &[f64; D]) -> [f64; D] {
        let mut gradient = *s;
        for i in (0..D).rev() {
            for j in i + 1..D {
                gradient[i] -= self.factor[j][i] * gradient[j];
            }
            gradient[i] /= self.factor[i][i];
        }
        gradient
    }

    /// `L^T s`: a gradient with respect to `x` becomes one with respect to `y`.
    pub(crate) fn whiten_gradient(&self, s: &[f64; D]) -> [f64; D] {
        std::array::from_fn(|i| (i..D).map(|j| self.factor[j][i] * s[j]).sum())
    }

    /// `det L`: a density in `y` is this times the density in `x`.
    pub(crate) fn determinant(&self) -> f64 {
        (0..D).map(|k| self.factor[k][k]).product()
    }

    /// `L^-1 A L^-T` for a symmetric `A`: a diffusion matrix in this metric.
    pub(crate) fn whitened(&self, matrix: &[[f64; D]; D]) -> [[f64; D]; D] {
        // A is symmetric: its columns are its rows, and so are those of the result.
        let mut half = [[0.0; D]; D];
        for j in 0..D {
            let solved = self.whiten_vector(&matrix[j]);
            for i in 0..D {
                half[i][j] = solved[i];
            }
        }
        half.map(|row| self.whiten_vector(&row))
    }
}

/// `mean_k = sum mu x_k / sum mu` and the covariance likewise.
pub(crate) fn mean_and_covariance<const D: usize>(
    positions: &[[f64; D]],
    masses: &[f64],
) -> ([f64; D], [[f64; D]; D]) {
    let (mut total, mut mean) = (0.0, [0.0; D]);
    for (x, mu) in positions.iter().zip(masses) {
        total += mu;
        for k in 0..D {
            mean[k] += mu * x[k];
        }
    }
    for value in &mut mean {
        *value /= total;
    }
    let mut covariance = [[0.0; D]; D];
    for (x, mu) in positions.iter().zip(masses) {
        for k in 0..D {
            let weighted = mu * (x[k] - mean[k]);
            for l in 0..=k {
                covariance[k][l] += weighted * (x[l] - mean[l]);
            }
        }
    }
    for k in 0..D {
        for l in 0..=k {
            covariance[k][l] /= total;
            covariance[l][k] = covariance[k][l];
        }
    }
    (mean, covariance)
}

/// Lower triangular `L` with `L L^T = covariance`, or the failing axis with its relative pivot.
fn cholesky<const D: usize>(covariance: &[[f64; D]; D]) -> Result<[[f64; D]; D], (usize, f64)> {
    let mut factor = [[0.0; D]; D];
    for j in 0..D {
        for i in j..D {
            let mut entry = covariance[i][j];
            for k in 0..j {
                entry -= factor[i][k] * factor[j][k];
            }
            if i > j {
                factor[i][j] = entry / factor[j][j];
                continue;
            }
            let relative = entry / covariance[j][j];
            if relative.is_nan() || relative < SMALLEST_RELATIVE_PIVOT {
                return Err((j, relative));
            }
            factor[j][j] = entry.sqrt();
        }
    }
    Ok(factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four corners of a sheared square; by hand: mean (1, 2), covariance [[1, 1], [1, 2]].
    const CORNERS: [[f64; 2]; 4] = [[2.0, 4.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]];

    #[test]
    fn whitening_gives_the_unit_covariance_and_back() {
        let map = Whitening::of(Metric::Whitened, &CORNERS, &[0.25; 4], (0, 0.0)).unwrap();
        let whitened: Vec<_> = CORNERS.iter().map(|x| map.whiten(x)).collect();
        let (mean, covariance) = mean_and_covariance(&whitened, &[0.25; 4]);
        for i in 0..2 {
            assert!(mean[i].abs() < 1e-15);
            for j in 0..2 {
                assert!((covariance[i][j] - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
        // det L = sqrt(det cov) = 1.
        assert!((map.determinant() - 1.0).abs() < 1e-15);
        for (x, y) in CORNERS.iter().zip(&whitened) {
            assert!(map.unwhiten(y).iter().zip(x).all(|(a, b)| (a - b).abs() < 1e-15));
        }
    }

    #[test]
    fn a_gradient_transforms_so_that_its_product_with_a_difference_is_invariant() {
        let map = Whitening::of(Metric::Whitened, &CORNERS, &[0.25; 4], (0, 0.0)).unwrap();
        let (s, u) = ([0.3, -1.2], [0.7, 0.4]);
        let (gradient, y) = (map.unwhiten_gradient(&s), map.whiten_vector(&u));
        let (in_x, in_y) = (gradient[0] * u[0] + gradient[1] * u[1], s[0] * y[0] + s[1] * y[1]);
        assert!((in_x - in_y).abs() < 1e-15);
    }

    #[test]
    fn a_cloud_on_a_line_is_refused_with_its_pivot() {
        let line = [[0.0, 0.0], [1.0, 2.0], [2.0, 4.0], [3.0, 6.0]];
        let error = Whitening::of(Metric::Whitened, &line, &[0.25; 4], (7, 1.5)).unwrap_err();
        let Error::SingularCovariance { step: 7, axis: 1, pivot, limit, .. } = error else {
            unreachable!("{error}")
        };
        assert!(pivot < limit);
    }
}
