//! The stiffest mode of a body.

use crate::bodies::body::Body;
use crate::dynamics::kicks::Kicks;
use crate::dynamics::resistance::Resistance;
use crate::error::Error;
use crate::real::Real;

/// Iterations of the power method, at most.
const MOST_ITERATIONS: usize = 200;

/// It ends when its value changes by less in ten iterations.
const SETTLED: f64 = 1e-4;

/// The largest eigenvalue of `L^T (K + epsilon) L`, that is of `M (K + epsilon)`, at rest (1/time, with masses 1/time squared),
/// from below, within about a part in a thousand.
pub(crate) fn stiffest<T: Real, const D: usize, const L: usize>(
    body: &mut dyn Body<T, D, L>,
    resistance: &Resistance<T>,
    kicks: &mut Kicks<L>,
    confinement: f64,
) -> Result<f64, Error> {
    let n = body.nodes().positions().len() * D * L;
    // Alternating from node to node and uneven: no symmetry of a body is orthogonal to it.
    let mut y: Vec<T> = Vec::new();
    y.extend((0..resistance.n_motions(D) * L).map(|at| {
        let motion = (at / L) as f64;
        T::of((2.4 * motion).sin() + 0.3 * (0.7 * motion * motion).cos())
    }));
    let (mut image, epsilon) = (vec![T::ZERO; n], T::of(confinement));
    let (mut value, mut settled) = (0.0, 0.0);
    for iteration in 0..MOST_ITERATIONS {
        let norm = norm(&y);
        if norm <= 0.0 {
            return Ok(0.0);
        }
        for y in &mut y {
            *y = T::of(y.to_f64() / norm);
        }
        kicks.forth(resistance, &mut y)?;
        body.linear_forces(&y, &mut image)?;
        for (image, &y) in image.iter_mut().zip(&y) {
            *image = epsilon * y - *image;
        }
        y.clone_from(&image);
        kicks.back(resistance, &mut y)?;
        value = self::norm(&y);
        if iteration % 10 == 9 {
            if value - settled < SETTLED * value {
                break;
            }
            settled = value;
        }
    }
    Ok(value)
}

fn norm<T: Real>(values: &[T]) -> f64 {
    values.iter().map(|v| v.to_f64() * v.to_f64()).sum::<f64>().sqrt()
}
