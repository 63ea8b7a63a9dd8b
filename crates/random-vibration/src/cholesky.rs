//! Cholesky factor of a covariance.

/// The lower triangular `L` with `L L^T = C`, or the first pivot that is not positive, with its row.
pub(crate) fn cholesky<const D: usize>(
    covariance: &[[f64; D]; D],
) -> Result<[[f64; D]; D], (usize, f64)> {
    let mut factor = [[0.0; D]; D];
    for i in 0..D {
        for j in 0..=i {
            let rest: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            let value = covariance[i][j] - rest;
            if i != j {
                factor[i][j] = value / factor[j][j];
            } else if value > 0.0 && value.is_finite() {
                factor[i][i] = value.sqrt();
            } else {
                return Err((i, value));
            }
        }
    }
    Ok(factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_squared_is_the_covariance_and_what_is_none_is_refused() {
        let factor = cholesky(&[[4.0, 2.0], [2.0, 5.0]]).unwrap();
        assert_eq!(factor, [[2.0, 0.0], [1.0, 2.0]]);
        assert_eq!(cholesky(&[[1.0, 2.0], [2.0, 1.0]]), Err((1, -3.0)));
    }
}
