//! Small matrices and their exponential.

/// A small square matrix, row by row.
pub type Matrix<const D: usize> = [[f64; D]; D];

/// Terms of the series of an exponential whose exponent does not exceed one half: the last is below 1e-16 of the first.
const TERMS: u32 = 14;

/// The unit matrix.
#[must_use]
pub fn identity<const D: usize>() -> Matrix<D> {
    std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))))
}

/// `exp(A t)`: the Taylor series over a part of the time, squared until it is whole (Moler & Van Loan 2003, method 3).
///
/// The relative error is that of roundoff, about `|A t|` times 1e-16.
#[must_use]
pub fn exponential<const D: usize>(a: &Matrix<D>, t: f64) -> Matrix<D> {
    let (mut part, mut squarings) = (t, 0);
    while norm(a) * part.abs() > 0.5 {
        part *= 0.5;
        squarings += 1;
    }
    let (mut sum, mut term) = (identity(), identity());
    for k in 1..=TERMS {
        term = scaled(&product(a, &term), part / f64::from(k));
        sum = add(&sum, &term);
    }
    for _ in 0..squarings {
        sum = product(&sum, &sum);
    }
    sum
}

/// The largest sum over a row of absolute values.
#[must_use]
pub fn norm<const D: usize>(a: &Matrix<D>) -> f64 {
    a.iter().map(|row| row.iter().map(|value| value.abs()).sum()).fold(0.0, f64::max)
}

/// `A B`.
#[must_use]
pub fn product<const D: usize>(a: &Matrix<D>, b: &Matrix<D>) -> Matrix<D> {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..D).map(|k| a[i][k] * b[k][j]).sum()))
}

/// `A^T`.
#[must_use]
pub fn transposed<const D: usize>(a: &Matrix<D>) -> Matrix<D> {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

/// `A + B`.
#[must_use]
pub fn add<const D: usize>(a: &Matrix<D>, b: &Matrix<D>) -> Matrix<D> {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + b[i][j]))
}

/// `c A`.
#[must_use]
pub fn scaled<const D: usize>(a: &Matrix<D>, by: f64) -> Matrix<D> {
    a.map(|row| row.map(|value| by * value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_oscillator_turns_and_decays() {
        // x'' + 2 c x' + w^2 x = 0, closed form with the damped frequency.
        let (w, c) = (3.0_f64, 0.4_f64);
        let a = [[0.0, 1.0], [-w * w, -2.0 * c]];
        let damped = (w * w - c * c).sqrt();
        for t in [0.0, 0.01, 0.7, 9.0, -0.7] {
            let (sin, cos) = (damped * t).sin_cos();
            let decay = (-c * t).exp();
            let exact = [
                [decay * (cos + c / damped * sin), decay * sin / damped],
                [-decay * w * w / damped * sin, decay * (cos - c / damped * sin)],
            ];
            let found = exponential(&a, t);
            for (found, exact) in found.as_flattened().iter().zip(exact.as_flattened()) {
                // Roundoff, 2e-16 times |A t| up to 100.
                assert!((found - exact).abs() < 1e-13, "{found} {exact} at {t}");
            }
        }
    }

    #[test]
    fn a_nilpotent_matrix_has_a_polynomial() {
        let a = [[0.0, 2.0, 0.0], [0.0, 0.0, 3.0], [0.0; 3]];
        let exact = [[1.0, 8.0, 48.0], [0.0, 1.0, 12.0], [0.0, 0.0, 1.0]];
        let found = exponential(&a, 4.0);
        for (found, exact) in found.as_flattened().iter().zip(exact.as_flattened()) {
            assert!((found - exact).abs() < 1e-13, "{found} {exact}");
        }
    }
}
