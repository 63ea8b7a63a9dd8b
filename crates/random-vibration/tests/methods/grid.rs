//! The conservative grid.

use random_vibration::{GridConfig, GridDensity, GridError};
use sde_integrators::{Additive, GaussianMixture, Sde};

/// An undamped oscillator without noise, or with noise on the displacement.
#[derive(Debug)]
struct Turning {
    noise_on_q: f64,
    slip: f64,
}

const TURNING: Turning = Turning { noise_on_q: 0.0, slip: 0.0 };

impl Sde<2, 1> for Turning {
    type Noise = Additive;

    fn drift(&self, _: f64, &[q, v]: &[f64; 2]) -> [f64; 2] {
        [v + self.slip, -4.0 * q]
    }

    fn noise(&self, _: f64, _: &[f64; 2]) -> [[f64; 1]; 2] {
        [[self.noise_on_q], [0.0]]
    }
}

const PERIOD: f64 = std::f64::consts::PI;
const CONFIG: GridConfig =
    GridConfig { cells: 96, reach: 7.0, period: PERIOD, steps_per_period: 16.0 };

fn law() -> GaussianMixture<2> {
    GaussianMixture::independent([0.3, 0.0], [0.2, 0.6]).unwrap()
}

#[test]
fn an_undamped_oscillator_turns_as_a_whole() {
    let (system, law) = (TURNING, law());
    let mut density = GridDensity::new(&system, &law, CONFIG).unwrap();
    for (part, q, qq) in [(0.125, 0.3 * 0.5_f64.sqrt(), 0.065), (0.25, 0.0, 0.09), (1.0, 0.3, 0.04)]
    {
        density.advance_to(part * PERIOD).unwrap();
        let mean = density.raw_moment([1, 0]).unwrap();
        let second = density.raw_moment([2, 0]).unwrap();
        // The composition is exact and the remapping conserves the mean; the variance errs by that of a cell, h^2/12
        // with h = 14 x 0.3/96.
        assert!((mean - q).abs() < 1e-10, "{part}: {mean}");
        assert!((second - mean * mean - qq).abs() < 1.6e-4, "{part}: {second}");
        assert!((density.total_mass() - 1.0).abs() < 1e-13 && density.smallest_mass() >= 0.0);
    }
    assert_eq!(density.steps(), 16);
    // Two tails of the normal distribution with mean 0.3 and deviation 0.2 beyond 0.9: 3 and 6 deviations.
    let expected = 1.349898031630095e-3 + 9.865876450376946e-10;
    assert!((density.exceedance(0.9) / expected - 1.0).abs() < 2e-2, "{}", density.exceedance(0.9));
}

#[test]
fn a_grid_that_is_stopped_is_a_density_at_a_time_between() {
    let (system, law) = (TURNING, law());
    let mut density = GridDensity::new(&system, &law, CONFIG).unwrap();
    density.advance_while(PERIOD, &mut |t| t < 0.2 * PERIOD).unwrap();
    // The first even number of sixteenths beyond a fifth.
    assert!((density.time() / PERIOD - 0.25).abs() < 1e-12 && density.steps() == 4);
    let second = density.raw_moment([2, 0]).unwrap();
    assert!((second - 0.09).abs() < 1.6e-4, "{second}");
    density.advance_to(PERIOD).unwrap();
    assert!(density.steps() == 16 && (density.raw_moment([1, 0]).unwrap() - 0.3).abs() < 1e-10);
}

/// An undamped oscillator of frequency 2 under white noise of intensity 1.
#[derive(Debug)]
struct Shaken;

impl Sde<2, 1> for Shaken {
    type Noise = Additive;

    fn drift(&self, _: f64, &[q, v]: &[f64; 2]) -> [f64; 2] {
        [v, -4.0 * q]
    }

    fn noise(&self, _: f64, _: &[f64; 2]) -> [[f64; 1]; 2] {
        [[0.0], [1.0]]
    }
}

#[test]
fn a_start_far_narrower_than_the_noise_of_a_step_loses_none_of_it() {
    for deviation in [1e-3, 1e-6] {
        let law = GaussianMixture::independent([0.0, 0.0], [deviation; 2]).unwrap();
        let mut density = GridDensity::new(&Shaken, &law, CONFIG).unwrap();
        for turns in [1.0, 2.0] {
            density.advance_to(turns * PERIOD).unwrap();
            let second = density.raw_moment([2, 0]).unwrap();
            // The integral of sin^2(2 s)/4; 5e-4 off; a grid that does not hold the noise of its first steps is 39 % low.
            let expected = turns * PERIOD / 8.0;
            assert!((second / expected - 1.0).abs() < 5e-3, "{deviation} {turns}: {second}");
        }
    }
}

#[test]
fn what_the_scheme_does_not_know_is_refused() {
    let law = law();
    let refused =
        |config: GridConfig| GridDensity::new(&TURNING, &law, config).unwrap_err().to_string();
    assert_eq!(
        refused(GridConfig { cells: 8, ..CONFIG }),
        "cells is 8; it must be from 16 to 8192"
    );
    assert!(refused(GridConfig { reach: 0.0, ..CONFIG }).contains("greater than 0"));
    assert!(refused(GridConfig { steps_per_period: 2.0, ..CONFIG }).contains("at least 4"));
    let run = |system: Turning| {
        let mut density = GridDensity::new(&system, &law, CONFIG).unwrap();
        density.advance_to(1.0).unwrap_err()
    };
    let noisy = run(Turning { noise_on_q: 0.1, slip: 0.0 });
    assert!(matches!(noisy, GridError::NoiseOnDisplacement { .. }), "{noisy}");
    let slipping = run(Turning { noise_on_q: 0.0, slip: 0.1 });
    assert!(matches!(slipping, GridError::NoOscillator { .. }), "{slipping}");
    let mut density = GridDensity::new(&TURNING, &law, CONFIG).unwrap();
    assert!(matches!(density.advance_to(-1.0), Err(GridError::Time { .. })));
    assert!(matches!(density.raw_moment([5, 0]), Err(GridError::OutOfRange { .. })));
}
