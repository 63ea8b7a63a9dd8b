//! A field given measured values at points.

use sde_integrators::{Cholesky, Noise};

use crate::correlations::correlation::distance;
use crate::error::{Error, finite, same_length};
use crate::random_field::RandomField;
use crate::symmetric_eigen::symmetric_eigen;

/// Smallest standard deviation of a measurement that has one.
const LEAST_DEVIATION: f64 = 1e-4;
/// Smallest part of its variance that a measurement must add to those before it.
const LEAST_PIVOT: f64 = 1e-8;
/// Noise over noise and signal below which a combination of measurements is exact. One with the least standard deviation has
/// more, with up to 1000 measurements.
const EXACT: f64 = 1e-11;

/// A measured value of a standard Gaussian field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurement<const D: usize> {
    /// Where (length).
    pub position: [f64; D],
    /// The value, in standard deviations from the mean; of a translation that of
    /// [`Marginal::normal_score`](crate::Marginal::normal_score).
    pub value: f64,
    /// Standard deviation of the measurement, in the same unit: zero for an exact one, otherwise at least 1e-4.
    pub standard_deviation: f64,
}

/// A Gaussian field given measured values: simple kriging, as a change of the coefficients.
///
/// With the modes $A$ at the measurements (a row each), their values `y` and the covariance $\Sigma$ of their errors the coefficients
/// $\xi$ are normal with
///
/// $$ E[\xi] = A^T K^{-1} y, \qquad C = I - A^T K^{-1} A, \qquad K = A A^T + \Sigma , $$
///
/// so that the field at `x` has the mean $k(x)^T K^{-1} y$ and the variance $k(x, x) - k(x)^T K^{-1} k(x)$ of kriging with the
/// covariance of the field's terms. A realisation is $E[\xi] + C^{1/2} \xi'$ with independent normals $\xi'$, as many as before. It
/// meets measurements without an error within roundoff. Far from all measurements it is the realisation of the field that
/// $\xi'$ gives.
///
/// What the truncation leaves out is no part of the field: its variance is to be compared with that of the measurements.
///
/// Source: Rasmussen and Williams 2006, eq 2.23 and 2.24.
///
/// ```
/// use random_fields::*;
///
/// let correlation = Correlation { function: CorrelationFunction::Exponential, length: 1.0 };
/// let field = RandomField::on_box([[0.0], [4.0]], correlation, Truncation::Terms(50))?;
/// let measured = Measurement { position: [1.0], value: 2.0, standard_deviation: 0.0 };
/// let given = ConditionedField::new(field, &[measured])?;
/// assert!(given.variance(&[1.0])?.abs() < 1e-12);
/// let mut mean = [0.0; 2];
/// given.mean(&[[1.0], [2.0]], &mut mean)?;
/// // One correlation length away: 2 exp(-1), but for the 3 % of the variance that 50 terms leave out.
/// assert!((mean[0] - 2.0).abs() < 1e-12 && (mean[1] - 2.0 * (-1.0_f64).exp()).abs() < 0.03);
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ConditionedField<const D: usize> {
    field: RandomField<D>,
    /// `E[xi]`.
    mean: Vec<f64>,
    /// Rows `w` with $C^{1/2} = I - \sum w w^T$.
    removed: Vec<f64>,
}

impl<const D: usize> ConditionedField<D> {
    /// A field given measurements.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a value, [`Error::OutOfRange`] for a standard deviation; [`Error::OutsideBox`] and
    /// [`Error::Point`] with the index of the measurement; [`Error::CoincidentMeasurements`] for two exact ones at one place,
    /// [`Error::DependentMeasurement`] for one that those before it determine, as more exact ones than terms do.
    pub fn new(field: RandomField<D>, measurements: &[Measurement<D>]) -> Result<Self, Error> {
        check(measurements)?;
        let (m, n_terms) = (measurements.len(), field.n_terms());
        let positions: Vec<[f64; D]> = measurements.iter().map(|one| one.position).collect();
        let mut rows = vec![0.0; m * n_terms];
        field.modes(&positions, &mut rows)?;
        let covariance = |i: usize, j: usize| {
            let noise = if i == j { measurements[i].standard_deviation.powi(2) } else { 0.0 };
            product(row(&rows, n_terms, i), row(&rows, n_terms, j)) + noise
        };
        let matrix = (0..m * m).map(|k| covariance(k / m, k % m)).collect();
        let factor = Cholesky::new(m, matrix, LEAST_PIVOT).map_err(|small| {
            let (measurement, value, limit) = (small.row, small.value, small.limit);
            Error::DependentMeasurement { measurement, value, limit, n_terms }
        })?;
        let mut values: Vec<f64> = measurements.iter().map(|one| one.value).collect();
        factor.solve_lower(&mut values, 1);
        factor.solve_lower(&mut rows, n_terms);
        let mut mean = vec![0.0; n_terms];
        for (i, value) in values.iter().enumerate() {
            add(&mut mean, *value, row(&rows, n_terms, i));
        }
        let removed = removed(m, n_terms, &rows)?;
        Ok(Self { field, mean, removed })
    }

    /// The field without measurements.
    #[must_use]
    pub fn field(&self) -> &RandomField<D> {
        &self.field
    }

    /// Number of terms: that of the field.
    #[must_use]
    pub fn n_terms(&self) -> usize {
        self.field.n_terms()
    }

    /// Replaces independent standard normals by coefficients of the field given the measurements, for
    /// [`RandomField::values`].
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn condition(&self, coefficients: &mut [f64]) -> Result<(), Error> {
        same_length("the coefficients", coefficients.len(), self.n_terms())?;
        self.project(coefficients);
        for (xi, mean) in coefficients.iter_mut().zip(&self.mean) {
            *xi += mean;
        }
        Ok(())
    }

    /// The coefficients of field `number` of a realisation, given the measurements: those of [`RandomField::coefficients`],
    /// conditioned.
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn coefficients(
        &self,
        noise: &Noise,
        realisation: u64,
        number: u32,
        out: &mut [f64],
    ) -> Result<(), Error> {
        self.field.coefficients(noise, realisation, number, out)?;
        self.condition(out)
    }

    /// The derivatives of the values at points with respect to the independent normals, `out[i * n_terms + j]`: the modes of the
    /// conditioned field, whose squares sum up to its variance.
    ///
    /// # Errors
    /// Those of [`RandomField::modes`].
    pub fn modes(&self, points: &[[f64; D]], out: &mut [f64]) -> Result<(), Error> {
        self.field.modes(points, out)?;
        for modes in out.chunks_exact_mut(self.n_terms()) {
            self.project(modes);
        }
        Ok(())
    }

    /// The mean of the field given the measurements at points: their kriging estimate.
    ///
    /// # Errors
    /// Those of [`RandomField::values`].
    pub fn mean(&self, points: &[[f64; D]], out: &mut [f64]) -> Result<(), Error> {
        self.field.values(&self.mean, points, out)
    }

    /// The variance of the field given the measurements at a point, within roundoff.
    ///
    /// # Errors
    /// [`Error::OutsideBox`], [`Error::Point`].
    pub fn variance(&self, x: &[f64; D]) -> Result<f64, Error> {
        let mut modes = vec![0.0; self.n_terms()];
        self.modes(&[*x], &mut modes)?;
        Ok(product(&modes, &modes))
    }

    /// Applies $C^{1/2}$, which is symmetric.
    fn project(&self, vector: &mut [f64]) {
        let n_terms = self.n_terms();
        let rows = self.removed.chunks_exact(n_terms);
        let parts: Vec<f64> = rows.clone().map(|w| product(w, vector)).collect();
        for (part, w) in parts.iter().zip(rows) {
            add(vector, -part, w);
        }
    }
}

/// Rows `w` of the root of `I - V V^T`, from those of `V^T`. With `V^T V = R S R^T` the root is
///
/// ```text
/// I - V R (1 + sqrt(1 - S))^-1 R^T V^T
/// ```
fn removed(m: usize, n_terms: usize, rows: &[f64]) -> Result<Vec<f64>, Error> {
    let gram = |k: usize| product(row(rows, n_terms, k / m), row(rows, n_terms, k % m));
    let eigen = symmetric_eigen(m, (0..m * m).map(gram).collect())?;
    let mut removed = vec![0.0; m * n_terms];
    for (i, w) in removed.chunks_exact_mut(n_terms).enumerate() {
        let noise = 1.0 - eigen.values[i];
        let root = if noise < EXACT { 0.0 } else { noise.sqrt() };
        let scale = (1.0 / (1.0 + root)).sqrt();
        for j in 0..m {
            add(w, scale * eigen.vectors[i * m + j], row(rows, n_terms, j));
        }
    }
    Ok(removed)
}

fn check<const D: usize>(measurements: &[Measurement<D>]) -> Result<(), Error> {
    for (first, one) in measurements.iter().enumerate() {
        finite("the value of a measurement", one.value)?;
        let value = one.standard_deviation;
        if value != 0.0 && !(value >= LEAST_DEVIATION && value.is_finite()) {
            let name = "the standard deviation of a measurement, where it is not 0,";
            return Err(Error::OutOfRange {
                name,
                value,
                from: LEAST_DEVIATION,
                to: f64::INFINITY,
            });
        }
        let both = |other: &Measurement<D>| value == 0.0 && other.standard_deviation == 0.0;
        let same =
            |other: &Measurement<D>| both(other) && distance(&other.position, &one.position) == 0.0;
        if let Some(second) = measurements[..first].iter().position(same) {
            return Err(Error::CoincidentMeasurements {
                first: second,
                second: first,
                first_value: measurements[second].value,
                second_value: one.value,
            });
        }
    }
    Ok(())
}

fn row(rows: &[f64], width: usize, i: usize) -> &[f64] {
    &rows[i * width..(i + 1) * width]
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn add(sum: &mut [f64], factor: f64, row: &[f64]) {
    for (sum, x) in sum.iter_mut().zip(row) {
        *sum += factor * x;
    }
}
