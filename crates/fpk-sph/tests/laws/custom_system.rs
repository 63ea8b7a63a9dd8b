//! A system as a user would write it: a pendulum with friction in wind, in ten lines.

use fpk_sph::{Config, DEFAULT_MOST_STEPS, InitialLattice, Method, Simulation};
use sde_integrators::{
    Additive, EnsembleConfig, EulerMaruyama, GaussianMixture, Observable, Sde, simulate,
};

// docs: system
#[derive(Debug, Clone, Copy)]
struct Pendulum {
    friction: f64,
    wind: f64,
}

impl Sde<2, 1> for Pendulum {
    type Noise = Additive;

    fn drift(&self, _: f64, &[angle, rate]: &[f64; 2]) -> [f64; 2] {
        [rate, -angle.sin() - self.friction * rate]
    }

    fn noise(&self, _: f64, _: &[f64; 2]) -> [[f64; 1]; 2] {
        [[0.0], [self.wind]]
    }
}
// docs: end

// docs: test
#[test]
fn a_users_system_runs_in_the_density_solver_and_in_monte_carlo_alike() {
    let pendulum = Pendulum { friction: 0.5, wind: 0.3 };
    let law = GaussianMixture::independent([0.3, 0.0], [0.1, 0.1]).unwrap();
    let config = Config {
        method: Method::FlowMapFit,
        lattice: InitialLattice::box_of(31),
        reference_period: std::f64::consts::TAU,
        most_steps: DEFAULT_MOST_STEPS,
    };
    let mut simulation = Simulation::new(pendulum, &law, &config).unwrap();
    simulation.advance_to(2.0).unwrap();

    let ensemble = EnsembleConfig { seed: 1, n_paths: 40_000, dt: 0.002, times: vec![2.0] };
    let observables = [
        Observable::Mean(&|_, x: &[f64; 2]| x[0] * x[0]),
        Observable::Mean(&|_, x: &[f64; 2]| x[1] * x[1]),
    ];
    let paths = simulate(&pendulum, &EulerMaruyama, &law, &ensemble, &observables).unwrap();

    for (k, powers) in [[2, 0], [0, 2]].into_iter().enumerate() {
        let estimate = paths.estimates[0][k];
        let error = (simulation.raw_moment(powers) - estimate.value).abs();
        // Four standard errors, and 0.5 %: forward Euler at this step adds up to w^2 dt t = 0.4 % of energy.
        let tolerance = 4.0 * estimate.standard_error().unwrap() + 0.005 * estimate.value;
        assert!(error < tolerance, "moment {powers:?}: {error:e} above {tolerance:e}");
    }
}
// docs: end
