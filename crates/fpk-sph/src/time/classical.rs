//! Explicit schemes that treat the velocity as a whole.

use super::begin::Begin;
use super::sums::combine;
use crate::error::Error;

/// Forward Euler: `x_1 = x_0 + dt k_1`.
pub(super) fn forward_euler<const D: usize>(
    x: &mut [[f64; D]],
    k: &[Vec<[f64; D]>; 4],
    begin: &Begin<'_, D>,
) {
    combine(x, begin.x, &[(begin.dt, &k[0])]);
}

/// The classical method of order 4.
pub(super) fn runge_kutta_4<const D: usize>(
    x: &mut [[f64; D]],
    [k_1, k_2, k_3, k_4]: &mut [Vec<[f64; D]>; 4],
    begin: &Begin<'_, D>,
    mut velocity: impl FnMut(f64, &[[f64; D]], &mut [[f64; D]]) -> Result<(), Error>,
) -> Result<(), Error> {
    let &Begin { t, x: x_0, dt, .. } = begin;
    combine(x, x_0, &[(dt / 2.0, k_1)]);
    velocity(t + dt / 2.0, x, k_2)?;
    combine(x, x_0, &[(dt / 2.0, k_2)]);
    velocity(t + dt / 2.0, x, k_3)?;
    combine(x, x_0, &[(dt, k_3)]);
    velocity(t + dt, x, k_4)?;
    let sixth = dt / 6.0;
    let third = dt / 3.0;
    combine(x, x_0, &[(sixth, k_1), (third, k_2), (third, k_3), (sixth, k_4)]);
    Ok(())
}
