//! A run to a tolerance: the error that it states against the error that it makes.

use fpk_sph::{
    Config, DEFAULT_MOST_STEPS, InitialLattice, Method, Refinement, RefinementEnd, Simulation,
    refine,
};
use sde_integrators::{Additive, GaussianMixture, Sde};
use vibrating_systems::{
    Filter, Filtered, KanaiTajimiParameters, LinearOscillatorParameters, ViscousDamper,
    ViscousDamperParameters, Window,
};

#[test]
fn the_damper_to_a_tolerance_has_the_error_that_it_states() {
    let structure = LinearOscillatorParameters {
        natural_frequency: std::f64::consts::PI,
        damping_ratio: 0.01,
        noise_intensity: 0.2,
        window: Window::CANOR_DENOEL_2013,
    };
    let (damper_coefficient, damper_exponent) = (0.25, 0.35);
    let parameters = ViscousDamperParameters { structure, damper_coefficient, damper_exponent };
    let building = ViscousDamper::new(parameters).unwrap();
    let law = GaussianMixture::independent([0.0, 0.0], [0.15, 0.10]).unwrap();
    let refinement = Refinement { tolerance: 2e-3, order: 2.0, most_particles: 20_000 };
    let refined = refine(InitialLattice::box_of(15), &refinement, |lattice| {
        let config = Config {
            method: Method::FlowMapFit,
            lattice: *lattice,
            reference_period: building.period(),
            most_steps: DEFAULT_MOST_STEPS,
        };
        let mut simulation = Simulation::new(building.clone(), &law, &config)?;
        simulation.advance_to(3.0)?;
        let values = vec![simulation.raw_moment([2, 0]), simulation.raw_moment([0, 2])];
        Ok((simulation.n_particles(), values))
    })
    .unwrap();
    assert!(matches!(refined.end, RefinementEnd::Met), "{refined:?}");
    assert!(refined.runs.len() >= 3, "the first runs are not within the tolerance: {refined:?}");
    // The reference of the density grid, 1e-4 and 3e-4 relative (tests/reference of the project).
    for (found, exact) in refined.values.iter().zip([0.0296960, 0.237442]) {
        let (error, stated) = ((found.value / exact - 1.0).abs(), found.error / exact);
        assert!(
            error < 2e-3 && error < 2.0 * stated + 3e-4,
            "{error:e} where {stated:e} is stated"
        );
    }
}

/// A cubic spring and a quadratic damper: `q'' + 0.04 pi q' + 0.5 |q'| q' + pi^2 (q + 5 q^3) = a(t) u`.
#[derive(Debug, Clone)]
struct CubicSpring {
    window: Window,
}

impl Sde<2, 1> for CubicSpring {
    type Noise = Additive;

    fn drift(&self, _: f64, &[q, v]: &[f64; 2]) -> [f64; 2] {
        let damping = 0.04 * std::f64::consts::PI * v + 0.5 * v.abs() * v;
        [v, -damping - std::f64::consts::PI.powi(2) * (q + 5.0 * q.powi(3))]
    }

    fn noise(&self, t: f64, _: &[f64; 2]) -> [[f64; 1]; 2] {
        [[0.0], [self.window.amplitude(t) * 0.4_f64.sqrt()]]
    }
}

#[test]
fn slower_settling_shows_the_error_that_lattices_of_four_states_share() {
    let structure = CubicSpring { window: Window::CANOR_DENOEL_2013 };
    let soil = KanaiTajimiParameters { ground_frequency: 15.6, ground_damping: 0.6 };
    let filter = Filter::kanai_tajimi(soil).unwrap();
    let shaken = Filtered::new(structure, filter, Window::Stationary).unwrap();
    let law: GaussianMixture<4> = shaken.initial_distribution(&[0.0; 2], &[0.05, 0.15]).unwrap();
    let config = Config {
        method: Method::FlowMapFit,
        lattice: InitialLattice::Ball { reach: 5.0, spacing: std::f64::consts::SQRT_2 },
        reference_period: filter.period(),
        most_steps: DEFAULT_MOST_STEPS,
    };
    let moments = |config: &Config<4>| {
        let mut simulation = Simulation::new(shaken.clone(), &law, config).unwrap();
        [2.0, 3.0].map(|t| {
            simulation.advance_to(t).unwrap();
            simulation.raw_moment([2, 0, 0, 0])
        })
    };
    let (found, slower) = (moments(&config), moments(&config.with_slower_settling().unwrap()));
    // Paths, 0.1 % (tests/reference of the project). The lattice finer by the root of two has 0.012009 and 0.02215: it
    // agrees within 0.6 %, where both are 1.4 to 5.3 % off.
    for ((found, slower), exact) in found.into_iter().zip(slower).zip([0.0118246, 0.0210296]) {
        let (error, stated) = (found / exact - 1.0, 2.0 * (found - slower).abs() / exact);
        assert!((0.01..0.06).contains(&error), "{error}");
        // Seen: 2.3 and 1.8 times the error.
        assert!((1.0..3.0).contains(&(stated / error)), "{stated} where {error} is made");
    }
}
