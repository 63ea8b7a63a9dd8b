//! How many paths of Euler-Maruyama leave the numbers.

use rayon::prelude::*;
use sde_integrators::{EulerMaruyama, Integrator, Noise, StepError};
use work_precision::problems::sde::problems::Cubic;

/// Where and when a path left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Departure {
    /// The path.
    pub realisation: u64,
    /// Steps taken when the state was beyond the limit.
    pub steps: u64,
}

/// The paths from 0, of the realisations from 0 on, that are beyond `limit` or not a number within `n_steps` steps.
///
/// # Errors
/// Never: the method is explicit.
pub fn departures(
    system: Cubic,
    (seed, n_paths): (u64, u64),
    (dt, n_steps): (f64, u64),
    limit: f64,
) -> Result<Vec<Departure>, StepError> {
    let noise = Noise::new(seed);
    let path = |realisation: u64| -> Result<Option<Departure>, StepError> {
        let (mut x, mut path) = ([0.0], noise.path::<1>(realisation));
        for n in 0..n_steps {
            let dw = path.next_increment(dt);
            EulerMaruyama.step(&system, n as f64 * dt, dt, &dw, &mut x, &mut ())?;
            if x[0].is_nan() || x[0].abs() > limit {
                return Ok(Some(Departure { realisation, steps: n + 1 }));
            }
        }
        Ok(None)
    };
    let all: Vec<_> = (0..n_paths).into_par_iter().map(path).collect::<Result<_, _>>()?;
    Ok(all.into_iter().flatten().collect())
}
