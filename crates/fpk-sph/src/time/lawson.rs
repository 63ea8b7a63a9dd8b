//! Lawson's form: the linear part of the drift is solved exactly, the rest by an explicit scheme.
//!
//! With `v(t, x) = A x + r(t, x)` the variable `z = exp(-A t) x` obeys `dz/dt = exp(-A t) r(t, exp(A t) z)` (Lawson 1967). An
//! explicit scheme for `z`, written in `x`, takes each rate to the end of the step by the flow `exp(A s)` over the time `s` in
//! between. What oscillates or decays by `A` alone is exact, and limits no step.

use super::begin::Begin;
use super::sums::{subtract, transform};
use crate::error::Error;
use vibrating_systems::matrix::{exponential, identity, scaled};

/// A step may be so much longer than the one before it and still extrapolate from its rates.
///
/// The extrapolation amplifies differences between both rates by half the ratio.
const MOST_GROWTH: f64 = 2.0;

/// The method of Adams and Bashforth of order 2 in Lawson's form, with the ratio `w` of this step to the last one:
///
/// $$ x_1 = E \left(x_0 + \Delta t (1 + \tfrac w2) r_0\right) -
///    \Delta t \tfrac w2 \exp(A (\Delta t + \Delta t_{-1})) r_{-1} . $$
///
/// `k_1` holds `v(t, x_0)` before and `r_0` after it. Where there is no last step, or one much shorter, Heun's method in
/// Lawson's form takes its place.
pub(super) fn adams_bashforth_2<const D: usize>(
    x: &mut [[f64; D]],
    [r_0, r_1, ..]: &mut [Vec<[f64; D]>; 4],
    begin: &Begin<'_, D>,
    mut velocity: impl FnMut(f64, &[[f64; D]], &mut [[f64; D]]) -> Result<(), Error>,
) -> Result<(), Error> {
    let &Begin { t, x: x_0, dt, linear: a, .. } = begin;
    let whole = exponential(&a, dt);
    subtract(r_0, &a, x_0);
    let usable = begin.previous.filter(|previous| dt <= MOST_GROWTH * previous.dt);
    if let Some(previous) = usable {
        let half_ratio = 0.5 * dt / previous.dt;
        let over_both = exponential(&a, dt + previous.dt);
        let terms = [
            (whole, x_0),
            (scaled(&whole, dt * (1.0 + half_ratio)), r_0),
            (scaled(&over_both, -dt * half_ratio), &previous.values),
        ];
        transform(x, &terms);
        return Ok(());
    }
    transform(x, &[(whole, x_0), (scaled(&whole, dt), r_0)]);
    velocity(t + dt, x, r_1)?;
    subtract(r_1, &a, x);
    let half = 0.5 * dt;
    transform(x, &[(whole, x_0), (scaled(&whole, half), r_0), (scaled(&identity(), half), r_1)]);
    Ok(())
}
