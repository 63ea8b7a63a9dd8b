//! Corrections that make a sum over neighbours exact for constants and linear functions.

use crate::error::Error;

/// Smallest sum of volumes times kernel values for a division: a full neighbourhood has about one.
pub const SMALLEST_SHEPARD_SUM: f64 = 1e-10;

/// Smallest reciprocal condition of the renormalisation matrix: below it, roundoff exceeds about 1e-8 of a gradient.
pub const SMALLEST_RECIPROCAL_CONDITION: f64 = 1e-8;

/// Shepard's factor `1 / S_i`: with it a sum over neighbours is exact for constants.
///
/// $$ S_i = \sum_j V_j W_{ij}, \qquad f(x_i) \approx \frac{1}{S_i} \sum_j V_j f_j W_{ij} $$
///
/// Symbols: `sum` = `S_i`, including the particle itself; `V_j` a volume, `W_ij` a kernel value per volume. `S_i` is
/// dimensionless, near one inside a body and near one half at a plane surface.
///
/// Source: Shepard 1968, eq 2 with weights of any kind `[@shepard1968]`.
///
/// # Errors
/// [`Error::ShepardSum`] if the sum is not finite, or below [`SMALLEST_SHEPARD_SUM`]: a point without neighbours.
///
/// ```
/// use smoothing_kernels::shepard_factor;
///
/// // At a plane surface the sum of a constant 3 is half of it.
/// let (sum, sum_of_three) = (0.5, 1.5);
/// assert_eq!(shepard_factor(sum)? * sum_of_three, 3.0);
/// # Ok::<(), smoothing_kernels::Error>(())
/// ```
pub fn shepard_factor(sum: f64) -> Result<f64, Error> {
    if sum >= SMALLEST_SHEPARD_SUM && sum.is_finite() {
        Ok(1.0 / sum)
    } else {
        Err(Error::ShepardSum { value: sum, limit: SMALLEST_SHEPARD_SUM })
    }
}

/// Renormalisation matrix `B_i`: with it the gradient of a linear function is exact for any neighbours.
///
/// $$ B_i = \Bigl[ \sum_j V_j\, (x_j - x_i) \otimes \nabla_i W_{ij} \Bigr]^{-T}, \qquad
///    \nabla f(x_i) \approx \sum_j V_j\, (f_j - f_i)\, B_i \nabla_i W_{ij} $$
///
/// Symbols: `moment[a][b]` = `Σ_j V_j (x_j - x_i)_a (∇_i W_ij)_b`, dimensionless, near the identity inside a body;
/// `∇_i W_ij` is [`Kernel::gradient`](crate::Kernel::gradient) with `x_ij = x_i - x_j`. For a radial kernel the moment
/// is symmetric, and the transposition matters only for gradients that are already mixed.
///
/// The corrected pair gradients are not antisymmetric: they are consistent, but a momentum sum is not conserved.
///
/// The inverse is computed by Gauss-Jordan elimination with the largest pivot. The reciprocal condition is
/// `1 / (|M| |M^-1|)` in the maximum row-sum norm: 1 for the identity, 0 for a singular matrix.
///
/// Source: Randles & Libersky 1996 `[@randles1996]`; Bonet & Lok 1999 `[@bonet1999]`.
///
/// # Errors
/// [`Error::SingularMoment`] if the reciprocal condition is below [`SMALLEST_RECIPROCAL_CONDITION`] or NaN: fewer than
/// `D` neighbours in independent directions.
///
/// ```
/// use smoothing_kernels::{corrected_gradient, renormalisation_matrix};
///
/// // Half of the neighbours are missing along x: the sum sees half of a slope there.
/// let matrix = renormalisation_matrix(&[[0.5, 0.0], [0.0, 1.0]])?;
/// assert_eq!(corrected_gradient(&matrix, &[1.5, -1.0]), [3.0, -1.0]);
/// # Ok::<(), smoothing_kernels::Error>(())
/// ```
pub fn renormalisation_matrix<const D: usize>(
    moment: &[[f64; D]; D],
) -> Result<[[f64; D]; D], Error> {
    let limit = SMALLEST_RECIPROCAL_CONDITION;
    let inverse = inverse(moment).ok_or(Error::SingularMoment { value: 0.0, limit })?;
    let value = 1.0 / (norm(moment) * norm(&inverse));
    if value >= limit {
        Ok(transposed(&inverse))
    } else {
        Err(Error::SingularMoment { value, limit })
    }
}

/// `B ∇W`: a kernel gradient, or a sum of them, corrected by [`renormalisation_matrix`].
#[inline]
#[must_use]
pub fn corrected_gradient<const D: usize>(matrix: &[[f64; D]; D], gradient: &[f64; D]) -> [f64; D] {
    matrix.map(|row| row.iter().zip(gradient).map(|(b, g)| b * g).sum())
}

/// Maximum row-sum norm; NaN if an entry is NaN.
fn norm<const D: usize>(matrix: &[[f64; D]; D]) -> f64 {
    let sums = matrix.map(|row| row.iter().map(|entry| entry.abs()).sum::<f64>());
    sums.into_iter().fold(0.0, |largest, sum| if sum <= largest { largest } else { sum })
}

fn transposed<const D: usize>(matrix: &[[f64; D]; D]) -> [[f64; D]; D] {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[column][row]))
}

/// The inverse; none for a zero pivot.
fn inverse<const D: usize>(matrix: &[[f64; D]; D]) -> Option<[[f64; D]; D]> {
    let mut left = *matrix;
    let mut right: [[f64; D]; D] =
        std::array::from_fn(|row| std::array::from_fn(|column| f64::from(u8::from(row == column))));
    for column in 0..D {
        let largest = |a: usize, b: usize| {
            if left[b][column].abs() > left[a][column].abs() { b } else { a }
        };
        let pivot = (column..D).fold(column, largest);
        left.swap(column, pivot);
        right.swap(column, pivot);
        if left[column][column].abs() <= 0.0 {
            return None;
        }
        let scale = 1.0 / left[column][column];
        left[column] = left[column].map(|entry| entry * scale);
        right[column] = right[column].map(|entry| entry * scale);
        for row in 0..D {
            if row != column {
                let factor = left[row][column];
                for k in 0..D {
                    left[row][k] -= factor * left[column][k];
                    right[row][k] -= factor * right[column][k];
                }
            }
        }
    }
    Some(right)
}
