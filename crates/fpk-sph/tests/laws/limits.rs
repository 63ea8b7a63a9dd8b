//! Limits in one, two and three dimensions: systems whose moments are known in closed form.

use fpk_sph::{Error, InitialLattice, Simulation};
use sde_integrators::{Additive, GaussianComponent, GaussianMixture, General, Sde};

use crate::fixtures::{config, exact_moments, oscillator};

/// `dX_k = -r_k X_k dt + s dB_k`.
#[derive(Debug, Clone, Copy)]
struct OrnsteinUhlenbeck<const D: usize> {
    rates: [f64; D],
    noise: f64,
}

impl<const D: usize> Sde<D, D> for OrnsteinUhlenbeck<D> {
    type Noise = Additive;

    fn drift(&self, _: f64, x: &[f64; D]) -> [f64; D] {
        std::array::from_fn(|k| -self.rates[k] * x[k])
    }

    fn noise(&self, _: f64, _: &[f64; D]) -> [[f64; D]; D] {
        std::array::from_fn(|k| std::array::from_fn(|l| if k == l { self.noise } else { 0.0 }))
    }
}

/// The largest relative error of a variance after the time 0.5, the law divided by the mass on the lattice.
fn ornstein_uhlenbeck_error<const D: usize>(lattice: InitialLattice<D>) -> f64 {
    let system = OrnsteinUhlenbeck { rates: std::array::from_fn(|k| 1.0 + k as f64), noise: 0.8 };
    let law = GaussianMixture::independent([0.0; D], [0.5; D]).unwrap();
    let mut simulation = Simulation::new(system, &law, &config(lattice, 1.0)).unwrap();
    let start: f64 = simulation.expectation(|x| x[0] * x[0]) / simulation.total_mass();
    simulation.advance_to(0.5).unwrap();
    (0..D)
        .map(|k| {
            // `Var(t) = Var(0) e^(-2 r t) + s^2 / (2 r) (1 - e^(-2 r t))` with Var(0) = 0.25. The score is that of the whole
            // Gaussian, so that the part which the lattice holds grows in the same ratio.
            let r = system.rates[k];
            let decay = (-2.0 * r * 0.5_f64).exp();
            let exact = start / 0.25 * (0.25 * decay + 0.64 / (2.0 * r) * (1.0 - decay));
            let found = simulation.expectation(|x| x[k] * x[k]) / simulation.total_mass();
            (found / exact - 1.0).abs()
        })
        .fold(0.0, f64::max)
}

#[test]
fn an_ornstein_uhlenbeck_process_keeps_its_variances_in_one_two_and_three_dimensions() {
    // A Gaussian is fitted exactly; its steps err by (r dt)^5 / 120, 2e-8 each at r = 3 and forty steps to the unit of
    // time.
    assert!(ornstein_uhlenbeck_error::<1>(InitialLattice::Box { reach: 6.0, count: [41] }) < 1e-6);
    assert!(
        ornstein_uhlenbeck_error::<2>(InitialLattice::Ball { reach: 6.0, spacing: 0.4 }) < 1e-6
    );
    assert!(
        ornstein_uhlenbeck_error::<3>(InitialLattice::Ball { reach: 6.0, spacing: 0.8 }) < 1e-6
    );
}

#[test]
fn a_mixture_of_two_gaussians_moves_its_covariance_by_the_lyapunov_equation() {
    let component = |mean: f64| GaussianComponent {
        weight: 0.5,
        mean: [mean, 0.0],
        covariance: [[0.04, 0.0], [0.0, 0.09]],
    };
    let law = GaussianMixture::mixture(&[component(-0.3), component(0.3)]).unwrap();
    let system = oscillator(2.0, 0.1, 0.1);
    let exact = exact_moments(&system, &law, 1.0);
    let mut simulation =
        Simulation::new(system, &law, &config(InitialLattice::box_of(61), 1.0)).unwrap();
    simulation.advance_to(1.0).unwrap();
    // log of a mixture is no quadratic: truncation h^2 of the fit at a spacing of 0.2 standard deviations.
    for (powers, exact) in [([2, 0], exact[0][0]), ([0, 2], exact[1][1])] {
        let error = (simulation.raw_moment(powers) / exact - 1.0).abs();
        assert!(error < 5e-3, "{powers:?}: {error:e}");
    }
}

/// Geometric Brownian motion in the logarithm's neighbourhood: `dX = s X dB` on a law far from zero.
#[derive(Debug, Clone, Copy)]
struct Multiplicative {
    noise: f64,
}

impl Sde<1, 1> for Multiplicative {
    type Noise = General;

    fn drift(&self, _: f64, _: &[f64; 1]) -> [f64; 1] {
        [0.0]
    }

    fn noise(&self, _: f64, x: &[f64; 1]) -> [[f64; 1]; 1] {
        [[self.noise * x[0]]]
    }
}

#[test]
fn the_divergence_of_a_state_dependent_diffusion_is_not_dropped() {
    let law = GaussianMixture::independent([1.0], [0.05]).unwrap();
    let system = Multiplicative { noise: 0.1 };
    let lattice = InitialLattice::Box { reach: 6.0, count: [61] };
    let mut simulation = Simulation::new(system, &law, &config(lattice, 1.0)).unwrap();
    simulation.advance_to(1.0).unwrap();
    // A martingale: E[X] = 1, where dropping div D (eq 17) would give exp(s^2 t) = 1.01; E[X^2] = 1.0025 exp(0.01).
    let mean = simulation.raw_moment([1]);
    let square = simulation.raw_moment([2]);
    // The fit's truncation on the skew law, 1.2e-4 of the mean, is a hundredth of what dropping would do.
    assert!((mean - 1.0).abs() < 3e-4, "{mean}");
    assert!((square / (1.0025 * 0.01_f64.exp()) - 1.0).abs() < 6e-4, "{square}");
}

/// A drift that stops being a number.
#[derive(Debug, Clone, Copy)]
struct Broken;

impl Sde<2, 1> for Broken {
    type Noise = Additive;

    fn drift(&self, t: f64, x: &[f64; 2]) -> [f64; 2] {
        if t > 0.1 { [f64::NAN, 0.0] } else { [x[1], -x[0]] }
    }

    fn noise(&self, _: f64, _: &[f64; 2]) -> [[f64; 1]; 2] {
        [[0.0], [0.1]]
    }
}

#[test]
fn a_drift_that_is_not_a_number_ends_the_run_with_step_time_and_particle() {
    let law = GaussianMixture::independent([0.0, 0.0], [1.0, 1.0]).unwrap();
    let mut simulation =
        Simulation::new(Broken, &law, &config(InitialLattice::box_of(11), 1.0)).unwrap();
    let error = simulation.advance_to(1.0).unwrap_err();
    assert!(
        matches!(error, Error::SingularCovariance { .. } | Error::LeftStableRange { .. }),
        "{error}"
    );
    assert!(
        simulation.positions().iter().flatten().all(|x| x.is_finite()),
        "the state before the step is kept"
    );
}
