//! Observed order of convergence, with its error.

use result_figures::Measured;

/// Smallest number of levels for an order with a meaningful error.
pub const MIN_LEVELS: usize = 4;

/// Error of a fit of the order.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum OrderError {
    /// Too few levels.
    #[error("an order needs at least {MIN_LEVELS} levels, not {n_levels}")]
    TooFewLevels {
        /// Number of levels.
        n_levels: usize,
    },
    /// A step or an error is zero, negative or not finite.
    #[error("level {level}: step {step}, error {error}; both must be positive and finite")]
    NotPositive {
        /// Index of the level.
        level: usize,
        /// Its step.
        step: f64,
        /// Its error.
        error: f64,
    },
    /// All steps are equal.
    #[error("all levels have the step {step}")]
    SameSteps {
        /// The common step.
        step: f64,
    },
}

/// Slope of log error against log step by least squares, with its standard error from the residuals.
///
/// $$ p = \frac{\sum (x_i - \bar x)(y_i - \bar y)}{\sum (x_i - \bar x)^2}, \quad
///    s_p^2 = \frac{\sum (y_i - \bar y - p (x_i - \bar x))^2}{(n - 2) \sum (x_i - \bar x)^2} $$
///
/// Symbols: x = ln step, y = ln |error|; `levels` holds (step, error).
///
/// # Errors
/// [`OrderError`] for fewer than [`MIN_LEVELS`] levels, equal steps, or a level whose logarithm does not exist.
///
/// # Example
/// ```
/// let levels = [(0.4, 0.16), (0.2, 0.04), (0.1, 0.01), (0.05, 0.0025)];
/// let order = reference_problems::order::fit(&levels)?;
/// assert!((order.value - 2.0).abs() < 1e-12);
/// # Ok::<(), reference_problems::order::OrderError>(())
/// ```
pub fn fit(levels: &[(f64, f64)]) -> Result<Measured, OrderError> {
    let n_levels = levels.len();
    if n_levels < MIN_LEVELS {
        return Err(OrderError::TooFewLevels { n_levels });
    }
    let usable = |value: f64| value > 0.0 && value.is_finite();
    if let Some(level) =
        levels.iter().position(|&(step, error)| !usable(step) || !usable(error.abs()))
    {
        let (step, error) = levels[level];
        return Err(OrderError::NotPositive { level, step, error });
    }
    let n = n_levels as f64;
    let points: Vec<(f64, f64)> =
        levels.iter().map(|&(step, error)| (step.ln(), error.abs().ln())).collect();
    let mean_x = points.iter().map(|point| point.0).sum::<f64>() / n;
    let mean_y = points.iter().map(|point| point.1).sum::<f64>() / n;
    let s_xx: f64 = points.iter().map(|&(x, _)| (x - mean_x).powi(2)).sum();
    let s_xy: f64 = points.iter().map(|&(x, y)| (x - mean_x) * (y - mean_y)).sum();
    // Steps that agree within roundoff define no slope.
    if s_xx.sqrt() < 1e-9 {
        return Err(OrderError::SameSteps { step: levels[0].0 });
    }
    let slope = s_xy / s_xx;
    let residual: f64 =
        points.iter().map(|&(x, y)| (y - mean_y - slope * (x - mean_x)).powi(2)).sum();
    Ok(Measured::sampled(slope, (residual / (n - 2.0) / s_xx).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scatter_gives_the_slope_its_error() {
        // x = 0, 1, 2, 3 and y = 2 x + (1, -1, -1, 1) / 10: slope 2, residual 4 / 100, s_xx = 5.
        let levels: Vec<(f64, f64)> = [0.1, -0.1, -0.1, 0.1]
            .iter()
            .enumerate()
            .map(|(i, scatter)| ((i as f64).exp(), (2.0 * i as f64 + scatter).exp()))
            .collect();
        let order = fit(&levels).unwrap();
        assert!((order.value - 2.0).abs() < 1e-12);
        assert!((order.standard_error.unwrap() - (0.04_f64 / 2.0 / 5.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn levels_without_a_line_are_refused() {
        assert_eq!(fit(&[(1.0, 1.0); 3]), Err(OrderError::TooFewLevels { n_levels: 3 }));
        assert_eq!(fit(&[(1.0, 1.0); 4]), Err(OrderError::SameSteps { step: 1.0 }));
        let zero = [(1.0, 1.0), (0.5, 0.0), (0.2, 0.1), (0.1, 0.1)];
        assert_eq!(fit(&zero), Err(OrderError::NotPositive { level: 1, step: 0.5, error: 0.0 }));
        let nan = [(1.0, f64::NAN), (0.5, 0.0), (0.2, 0.1), (0.1, 0.1)];
        assert!(matches!(fit(&nan), Err(OrderError::NotPositive { level: 0, .. })));
    }
}
