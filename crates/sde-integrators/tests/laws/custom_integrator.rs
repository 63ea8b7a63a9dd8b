//! A method as a user writes it: one that remembers the noise of the step before, for additive noise alone.

use sde_integrators::{
    Additive, EnsembleConfig, Error, EulerMaruyama, Increment, Integrator, Observable, Sde,
    StepError, simulate,
};

// docs: integrator
/// Leimkuhler and Matthews 2013, Rational construction of stochastic numerical methods for molecular sampling:
/// `x + h f + g (w_{n-1} + w_n)/2`. For additive noise that does not change in time.
struct LeimkuhlerMatthews;

impl<S, const D: usize, const M: usize> Integrator<S, D, M> for LeimkuhlerMatthews
where
    S: Sde<D, M, Noise = Additive>,
{
    type Memory = Option<[f64; D]>;

    fn step(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: &Increment<M>,
        x: &mut [f64; D],
        memory: &mut Self::Memory,
    ) -> Result<(), StepError> {
        if dt > 2.0 {
            return Err(StepError::StepTooLong { dt, limit: 2.0 });
        }
        let (f, g) = (system.drift(t, x), system.noise(t, x));
        let kick: [f64; D] =
            g.map(|row| row.iter().zip(&dw.brownian).map(|(g, w)| g * w).sum::<f64>());
        let before = memory.unwrap_or(kick);
        for i in 0..D {
            x[i] += dt * f[i] + 0.5 * (before[i] + kick[i]);
        }
        *memory = Some(kick);
        Ok(())
    }
}
// docs: end

/// `dX = -X dt + sqrt(2) dB`: `E X^2` tends to 1.
struct OrnsteinUhlenbeck;

impl Sde<1, 1> for OrnsteinUhlenbeck {
    type Noise = Additive;

    fn drift(&self, _t: f64, x: &[f64; 1]) -> [f64; 1] {
        [-x[0]]
    }

    fn noise(&self, _t: f64, _x: &[f64; 1]) -> [[f64; 1]; 1] {
        [[2.0_f64.sqrt()]]
    }
}

fn variance<I: Integrator<OrnsteinUhlenbeck, 1, 1>>(
    method: &I,
    dt: f64,
) -> Result<(f64, f64), Error> {
    let config = EnsembleConfig { seed: 3, n_paths: 100_000, dt, times: vec![20.0] };
    let observables = [Observable::Mean(&|_t, x: &[f64; 1]| x[0] * x[0])];
    let ensemble = simulate(&OrnsteinUhlenbeck, method, &[0.0], &config, &observables)?;
    let estimate = ensemble.estimates[0][0];
    Ok((estimate.value, estimate.standard_error().expect("a mean has a standard error")))
}

// docs: test
/// With the memory `E X^2` is 1 at any step; without, by Euler-Maruyama, `1/(1 - h/2) = 4/3` at `h = 1/2`. What is left
/// of the start after 20 units is below 1e-12. |z| < 4.
#[test]
fn a_method_with_memory_has_the_stationary_variance_it_was_made_for() {
    for (seen, expected) in
        [(variance(&LeimkuhlerMatthews, 0.5), 1.0), (variance(&EulerMaruyama, 0.5), 4.0 / 3.0)]
    {
        let (value, standard_error) = seen.unwrap();
        assert!((value - expected).abs() < 4.0 * standard_error, "{value} +- {standard_error}");
        assert!(standard_error < 0.01);
    }
}
// docs: end

#[test]
fn a_step_that_a_method_refuses_is_an_error_that_names_the_path() {
    let error = variance(&LeimkuhlerMatthews, 2.5).unwrap_err();
    assert_eq!(error.to_string(), "path 0, step 0, time 0: no step was possible");
    let source = std::error::Error::source(&error).unwrap().to_string();
    assert_eq!(source, "step length 2.5 exceeds its limit 2");
}
