//! Explicit schemes for `dX/dt = v(t, X)`.

use crate::error::Error;
use crate::method::Scheme;
use crate::state::Previous;

/// The Runge-Kutta stages of a step.
#[derive(Debug)]
pub(crate) struct RungeKuttaStages<const D: usize> {
    /// Positions of a stage; after the last one those at the end of the step.
    pub(crate) x: Vec<[f64; D]>,
    /// Velocities `k_1` to `k_4`.
    pub(crate) k: [Vec<[f64; D]>; 4],
}

impl<const D: usize> RungeKuttaStages<D> {
    pub(crate) fn new(n: usize) -> Self {
        Self { x: vec![[0.0; D]; n], k: std::array::from_fn(|_| vec![[0.0; D]; n]) }
    }

    /// `x(t + dt)` from `x_0 = x(t)` and `k_1 = v(t, x_0)`, by the scheme.
    pub(crate) fn advance(
        &mut self,
        scheme: Scheme,
        (t, x_0, previous): (f64, &[[f64; D]], Option<&Previous<D>>),
        dt: f64,
        mut velocity: impl FnMut(f64, &[[f64; D]], &mut [[f64; D]]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let Self { x, k: [k_1, k_2, k_3, k_4] } = self;
        match (scheme, previous) {
            (Scheme::ForwardEuler, _) => combine(x, x_0, &[(dt, k_1)]),
            (Scheme::LeapFrog, Some(previous)) => {
                let ratio = dt / previous.dt;
                combine(x, x_0, &[((1.0 + ratio) * dt, k_1)]);
                for ((x, x_0), before) in x.iter_mut().zip(x_0).zip(&previous.positions) {
                    for k in 0..D {
                        x[k] += ratio * ratio * (before[k] - x_0[k]);
                    }
                }
            }
            (Scheme::Heun | Scheme::LeapFrog, _) => {
                combine(x, x_0, &[(dt, k_1)]);
                velocity(t + dt, x, k_2)?;
                combine(x, x_0, &[(dt / 2.0, k_1), (dt / 2.0, k_2)]);
            }
            (Scheme::RungeKutta4, _) => {
                combine(x, x_0, &[(dt / 2.0, k_1)]);
                velocity(t + dt / 2.0, x, k_2)?;
                combine(x, x_0, &[(dt / 2.0, k_2)]);
                velocity(t + dt / 2.0, x, k_3)?;
                combine(x, x_0, &[(dt, k_3)]);
                velocity(t + dt, x, k_4)?;
                let sixth = dt / 6.0;
                let third = dt / 3.0;
                combine(x, x_0, &[(sixth, k_1), (third, k_2), (third, k_3), (sixth, k_4)]);
            }
        }
        Ok(())
    }
}

/// `x = x_0 + sum_s c_s k_s`.
fn combine<const D: usize, const S: usize>(
    x: &mut [[f64; D]],
    x_0: &[[f64; D]],
    terms: &[(f64, &Vec<[f64; D]>); S],
) {
    let (x, x_0) = (x.as_flattened_mut(), x_0.as_flattened());
    let factors = terms.map(|(c, _)| c);
    let rates = terms.map(|(_, k)| &k.as_flattened()[..x_0.len()]);
    let x = &mut x[..x_0.len()];
    lanes::dispatch(
        #[inline(always)]
        || {
            for i in 0..x_0.len() {
                let mut value = x_0[i];
                for s in 0..S {
                    value += factors[s] * rates[s][i];
                }
                x[i] = value;
            }
        },
    );
}
