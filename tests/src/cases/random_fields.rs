//! What is claimed of `random-fields`.

pub(crate) mod conditioning;
pub(crate) mod covariance;
pub(crate) mod expansion;

use random_fields::{Correlation, CorrelationFunction, SpatialCorrelation};

/// The box of the cases (m): three by two lengths of the correlation along its edges.
const CORNERS: [[f64; 2]; 2] = [[0.0, 0.0], [3.0, 4.0]];

fn exponential(length: f64) -> Correlation {
    Correlation { function: CorrelationFunction::Exponential, length }
}

/// `exp(-|dx| - |dy|/2)`.
fn soil() -> SpatialCorrelation<2> {
    SpatialCorrelation::separable([exponential(1.0), exponential(2.0)])
}

/// Points of a lattice from a corner on.
fn lattice(corner: [f64; 2], counts: [usize; 2], spacings: [f64; 2]) -> Vec<[f64; 2]> {
    let place = |k: usize| {
        let at = [k % counts[0], k / counts[0]];
        [0, 1].map(|axis| corner[axis] + at[axis] as f64 * spacings[axis])
    };
    (0..counts[0] * counts[1]).map(place).collect()
}

/// The largest of some numbers; NaN if one is.
fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |most, x| if x.is_nan() || x > most { x } else { most })
}
