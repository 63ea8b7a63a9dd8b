//! How far out a lattice must go: the probability that a normal distribution has beyond it.

use crate::error::Error;

/// Part of the smallest probability asked for that a lattice may leave outside.
pub const MOST_OUTSIDE: f64 = 0.1;

/// Smallest probability that a reach can be asked for: what lies beyond 30 standard deviations.
const SMALLEST: f64 = 1e-190;

/// The radius, in standard deviations, of the smallest ball that leaves at most [`MOST_OUTSIDE`] of a probability outside,
/// for a normal distribution of `dimension` components: in three 4.9 for 1e-4, 6.0 for 1e-6, 7.1 for 1e-9.
///
/// # Errors
/// [`Error::OutOfRange`] for the probability.
pub fn ball_reach(dimension: usize, smallest_probability: f64) -> Result<f64, Error> {
    reach_for(smallest_probability, |r| outside_ball(dimension, r))
}

/// Half the edge of the smallest box, as [`ball_reach`].
///
/// # Errors
/// [`Error::OutOfRange`] for the probability.
pub fn box_reach(dimension: usize, smallest_probability: f64) -> Result<f64, Error> {
    reach_for(smallest_probability, |r| outside_box(dimension, r))
}

/// The smallest reach of which `outside` leaves little enough.
fn reach_for(probability: f64, outside: impl Fn(f64) -> f64) -> Result<f64, Error> {
    if !(SMALLEST..=1.0).contains(&probability) {
        let (name, value) = ("smallest probability", probability);
        return Err(Error::OutOfRange { name, value, from: SMALLEST, to: 1.0 });
    }
    let (mut inside, mut beyond) = (0.0, 40.0);
    // Sixty halvings of 40 reach the last bit of any reach.
    for _ in 0..60 {
        let middle = 0.5 * (inside + beyond);
        if outside(middle) > MOST_OUTSIDE * probability {
            inside = middle;
        } else {
            beyond = middle;
        }
    }
    Ok(beyond)
}

/// `P(|Z| > r)` of a standard normal vector in `dimension` components, the upper tail of the chi distribution:
///
/// $$ Q_1 = \mathrm{erfc}(r / \sqrt 2), \quad Q_2 = e^{-r^2/2}, \quad
///    Q_{n+2} = Q_n + \frac{(r^2/2)^{n/2}}{\Gamma(n/2 + 1)} e^{-r^2/2} . $$
pub(crate) fn outside_ball(dimension: usize, r: f64) -> f64 {
    let half_square = 0.5 * r * r;
    // The term that leads from n to n + 2 components, which becomes the next by a factor.
    let (mut n, mut tail, mut term) = if dimension.is_multiple_of(2) {
        (2, (-half_square).exp(), half_square * (-half_square).exp())
    } else {
        let gamma_of_three_halves = 0.5 * std::f64::consts::PI.sqrt();
        (1, outside_interval(r), half_square.sqrt() * (-half_square).exp() / gamma_of_three_halves)
    };
    while n < dimension {
        tail += term;
        n += 2;
        term *= half_square / (0.5 * n as f64);
    }
    tail
}

/// `P(max_k |Z_k| > r)` of a standard normal vector in `dimension` components.
fn outside_box(dimension: usize, r: f64) -> f64 {
    -(dimension as f64 * (-outside_interval(r)).ln_1p()).exp_m1()
}

/// `P(|Z| > r)` of a standard normal variable.
fn outside_interval(r: f64) -> f64 {
    libm::erfc(r * std::f64::consts::FRAC_1_SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `P(|Z| > r)` by the midpoint rule over the density of the radius.
    fn by_quadrature(dimension: usize, r: f64) -> f64 {
        let area = match dimension {
            1 => 2.0,
            2 => std::f64::consts::TAU,
            3 => 2.0 * std::f64::consts::TAU,
            4 => 2.0 * std::f64::consts::PI.powi(2),
            5 => 8.0 / 3.0 * std::f64::consts::PI.powi(2),
            _ => std::f64::consts::PI.powi(3),
        };
        let n = 20_000;
        let step = 10.0 / f64::from(n);
        let density = |s: f64| {
            let power = i32::try_from(dimension).unwrap();
            area * s.powi(power - 1) * (-0.5 * s * s).exp()
                / std::f64::consts::TAU.powf(0.5 * dimension as f64)
        };
        (0..n).map(|k| density(r + (f64::from(k) + 0.5) * step)).sum::<f64>() * step
    }

    #[test]
    fn what_lies_outside_a_ball_is_the_integral_over_the_radius() {
        for dimension in 1..=6 {
            for r in [0.5, 2.0, 5.0] {
                let (found, expected) = (outside_ball(dimension, r), by_quadrature(dimension, r));
                assert!((found / expected - 1.0).abs() < 1e-6, "{dimension}, {r}: {found:e}");
            }
        }
    }

    #[test]
    fn a_box_leaves_out_what_its_faces_cut_off() {
        let face = outside_ball(1, 2.0);
        let expected = 1.0 - (1.0 - face).powi(3);
        assert!((outside_box(3, 2.0) / expected - 1.0).abs() < 1e-14);
        // Where 1 - (1 - face)^2 is 0 in double precision.
        assert!((outside_box(2, 9.0) / (2.0 * outside_ball(1, 9.0)) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn the_reach_leaves_a_tenth_of_the_probability_outside() {
        for probability in [0.5, 1e-3, 1e-9, 1e-40, 1e-190] {
            let r = ball_reach(3, probability).unwrap();
            assert!(
                (outside_ball(3, r) / (0.1 * probability) - 1.0).abs() < 1e-10,
                "{probability:e}: {r}"
            );
        }
        for probability in [0.0, -1.0, 1.5, f64::NAN] {
            let error = box_reach(3, probability).unwrap_err();
            assert!(matches!(error, Error::OutOfRange { .. }), "{error}");
        }
    }
}
