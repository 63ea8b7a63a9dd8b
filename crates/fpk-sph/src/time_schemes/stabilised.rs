//! The stabilised Runge-Kutta-Chebyshev method, in Lawson's form where the drift has a linear part.

use super::begin::Begin;
use super::sums::{subtract, transform};
use crate::chebyshev::{Chebyshev, StageFactors};
use crate::error::Error;
use crate::matrix::{exponential, identity, scaled};

/// As many stages as the step needs for its diffusion (Sommeijer, Shampine & Verwer 1998, eq 2.2), for `z = exp(-A t) x`:
///
/// $$ Y_j = (1 - \mu_j - \nu_j) x_0 + \mu_j Y_{j-1} + \nu_j Y_{j-2} +
///    \tilde\mu_j \Delta t\, \rho_{j-1} + \tilde\gamma_j \Delta t\, \rho_0, \qquad
///    \rho_j = e^{-A c_j \Delta t}\, r(t + c_j \Delta t, e^{A c_j \Delta t} Y_j) . $$
///
/// `k_1` holds `v(t, x_0)`.
pub(super) fn runge_kutta_chebyshev<const D: usize>(
    x: &mut Vec<[f64; D]>,
    [first, rate, now, before]: &mut [Vec<[f64; D]>; 4],
    begin: &Begin<'_, D>,
    mut velocity: impl FnMut(f64, &[[f64; D]], &mut [[f64; D]]) -> Result<(), Error>,
) -> Result<(), Error> {
    let &Begin { t, x: x_0, dt, linear: a, share_of_limit, .. } = begin;
    let (method, one) = (Chebyshev::covering(share_of_limit), identity());
    let times = |c: f64| scaled(&one, c);
    subtract(first, &a, x_0);
    transform(now, &[(one, x_0), (times(method.first() * dt), first)]);
    before.copy_from_slice(x_0);
    for j in 2..=method.stages {
        let StageFactors { mu, nu, rate: factor, first_rate, before: c } = method.stage(j);
        let (there, back) = (exponential(&a, c * dt), exponential(&a, -c * dt));
        transform(x, &[(there, now)]);
        velocity(t + c * dt, x, rate)?;
        subtract(rate, &a, x);
        transform(
            x,
            &[
                (times(1.0 - mu - nu), x_0),
                (times(mu), now),
                (times(nu), before),
                (scaled(&back, factor * dt), rate),
                (times(first_rate * dt), first),
            ],
        );
        std::mem::swap(now, before);
        std::mem::swap(now, x);
    }
    transform(x, &[(exponential(&a, dt), now)]);
    Ok(())
}
