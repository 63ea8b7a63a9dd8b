//! Stability limits of `peridyn-sde`.
//!
//! Swept are step, temperature, horizon and loading rate.

pub(crate) mod horizon;
pub(crate) mod load;
pub(crate) mod noise;
pub(crate) mod z;

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use result_figures::CurvePoint;
use scenes::causes::with_causes;

use reference_problems::context::CaseError;

/// A point of a curve, or the reason why it is missing.
fn point(x: f64, found: Result<f64, CaseError>) -> CurvePoint {
    match found {
        Ok(y) => CurvePoint::at(x, y),
        Err(error) => CurvePoint::ended(x, with_causes(error.as_ref())),
    }
}

/// Eigenvalues with normalised eigenvectors, the lowest first.
fn modes(matrix: DMatrix<f64>) -> Result<Vec<(f64, DVector<f64>)>, CaseError> {
    let of = SymmetricEigen::try_new(matrix, f64::EPSILON, 10_000)
        .ok_or("the eigenvalues of a matrix were not found")?;
    let vector = |at: usize| of.eigenvectors.column(at).into_owned();
    let values = of.eigenvalues.iter().enumerate();
    let mut modes: Vec<_> = values.map(|(at, &value)| (value, vector(at))).collect();
    modes.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(modes)
}
