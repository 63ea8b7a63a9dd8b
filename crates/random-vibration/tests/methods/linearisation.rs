//! Statistical linearisation.

use random_vibration::{Linearisation, LinearisationError, Quadrature};
use sde_integrators::{Additive, GaussianMixture, Sde, normal_probability};

use crate::systems::Oscillator;

const LINEAR: Oscillator = Oscillator { frequency: 1.0, damping: 0.05, intensity: 0.1, cubic: 0.0 };

fn start() -> GaussianMixture<2> {
    GaussianMixture::independent([0.0, 0.0], [0.7, 0.9]).unwrap()
}

fn plane(on_v: Quadrature) -> Linearisation<2> {
    Linearisation { order: [(1, on_v), (0, Quadrature::Hermite)], step: 0.02 }
}

#[test]
fn a_linear_system_keeps_its_exact_distribution_whatever_the_rule() {
    let exact = LINEAR.covariance(start().covariance(), 3.0);
    let split = [(0, Quadrature::Hermite), (1, Quadrature::SplitAt(0))];
    for (rule, limit) in [
        (plane(Quadrature::Hermite), 1.3e-7),
        (plane(Quadrature::SplitAtZero), 1.3e-7),
        // Split at 1.7 deviations, the rule itself errs by 8e-5 in a fourth moment.
        (Linearisation { order: split, step: 0.02 }, 8e-5),
    ] {
        let law = rule.laws(&LINEAR, &start(), &[3.0]).unwrap()[0];
        for i in 0..2 {
            for j in 0..2 {
                // Error of Runge-Kutta 4 for a covariance that rotates at 2 omega: 2 omega t (2 omega dt)^4/120.
                let error = (law.covariance[i][j] - exact[i][j]).abs();
                assert!(error < limit, "{rule:?}: {error:e}");
            }
        }
    }
}

#[test]
fn the_stationary_duffing_oscillator_has_the_closed_linearised_variance() {
    // w^2 (1 + 3 eps s) s = S_0/(2 xi w): with w = 1, eps = 0.5, s = (sqrt(1 + 6) - 1)/3.
    let system = Oscillator { cubic: 0.5, ..LINEAR };
    let law = plane(Quadrature::Hermite).laws(&system, &start(), &[150.0]).unwrap()[0];
    let expected = (7.0_f64.sqrt() - 1.0) / 3.0;
    // Remainder of the initial state: exp(-2 xi w t) = 3e-7.
    assert!((law.covariance[0][0] / expected - 1.0).abs() < 1e-5, "{}", law.covariance[0][0]);
    assert!((law.covariance[1][1] - 1.0).abs() < 1e-5);
}

/// A force with a root at `u = 0`, and one with a root at `u = v`.
struct Root;

impl Sde<2, 1> for Root {
    type Noise = Additive;

    fn drift(&self, _: f64, &[u, v]: &[f64; 2]) -> [f64; 2] {
        let force = |rate: f64| rate.abs().powf(0.35).copysign(rate);
        [-force(u), -force(v - u)]
    }

    fn noise(&self, _: f64, _: &[f64; 2]) -> [[f64; 1]; 2] {
        [[0.0]; 2]
    }
}

/// Four states with a root at zero.
struct FourRoots;

impl Sde<4, 1> for FourRoots {
    type Noise = Additive;

    fn drift(&self, _: f64, x: &[f64; 4]) -> [f64; 4] {
        x.map(|x| -x.abs().sqrt().copysign(x))
    }

    fn noise(&self, _: f64, _: &[f64; 4]) -> [[f64; 1]; 4] {
        [[0.0]; 4]
    }
}

#[test]
fn a_root_of_the_drift_is_integrated_as_in_closed_form_at_zero_and_between_two_states() {
    // E[x f(x)] = s^1.35 2^0.675 Gamma(1.175)/sqrt(pi), twice of which the variance loses.
    let gamma = 0.9251974225134013;
    let moment = |s: f64| s.powf(1.35) * 2.0_f64.powf(0.675) * gamma / std::f64::consts::PI.sqrt();
    let (s_u, s_v, t) = (0.4_f64, 0.9_f64, 1e-6);
    let law = GaussianMixture::independent([0.0; 2], [s_u, s_v]).unwrap();
    let order = [(0, Quadrature::SplitAtZero), (1, Quadrature::SplitAt(0))];
    let law = Linearisation { order, step: t }.laws(&Root, &law, &[t]).unwrap()[0];
    let lost = |k: usize, s: f64| (s * s - law.covariance[k][k]) / t;
    // The rule integrates the root to 1e-5; the difference over t has 1e-6 of curvature and 1e-10 of roundoff.
    assert!((lost(0, s_u) / (2.0 * moment(s_u)) - 1.0).abs() < 1e-5, "{}", lost(0, s_u));
    // E[v f(v - u)] is the share s_v^2/s^2 of E[(v - u) f(v - u)], with s^2 = s_u^2 + s_v^2.
    let square = s_u * s_u + s_v * s_v;
    let expected = 2.0 * moment(square.sqrt()) * s_v * s_v / square;
    assert!((lost(1, s_v) / expected - 1.0).abs() < 1e-5, "{} {expected}", lost(1, s_v));
}

#[test]
fn moments_and_tails_are_those_of_the_normal_distribution() {
    let law = GaussianMixture::gaussian([0.3, -0.2], [[1.0, 0.6], [0.6, 2.0]]).unwrap();
    let rule = Linearisation { step: 1e-9, ..plane(Quadrature::Hermite) };
    let law = rule.laws(&LINEAR, &law, &[1e-9]).unwrap()[0];
    // E[q^3] = m^3 + 3 m P; E[q^2 v^2] and E[q v^3] by Isserlis.
    let (m, n, p, c, r) = (0.3_f64, -0.2_f64, 1.0, 0.6, 2.0);
    let mixed = m * m * n * n + m * m * r + n * n * p + 4.0 * m * n * c + p * r + 2.0 * c * c;
    let cubic = m * n.powi(3) + 3.0 * m * n * r + 3.0 * n * n * c + 3.0 * r * c;
    for (powers, expected) in [
        ([0, 0], 1.0),
        ([1, 0], m),
        ([3, 0], m.powi(3) + 3.0 * m * p),
        ([2, 2], mixed),
        ([1, 3], cubic),
    ] {
        // The step changes them by a relative 1e-9.
        assert!((law.raw_moment(powers) - expected).abs() < 1e-7, "{powers:?}");
    }
    // q - v has the mean 0.5 and the variance 1 - 1.2 + 2.
    let deviation = 1.8_f64.sqrt();
    let expected = normal_probability(-1.5 / deviation) + normal_probability(-2.5 / deviation);
    assert!((law.exceedance(&[1.0, -1.0], 2.0) / expected - 1.0).abs() < 1e-7);
}

#[test]
fn bad_input_is_refused() {
    let with = |linearisation: Linearisation<2>, times: &[f64]| {
        linearisation.laws(&LINEAR, &start(), times).unwrap_err()
    };
    let good = plane(Quadrature::Hermite);
    assert!(matches!(
        with(Linearisation { step: 0.0, ..good }, &[1.0]),
        LinearisationError::Step { .. }
    ));
    assert!(matches!(with(good, &[1.0, 1.0]), LinearisationError::Times { .. }));
    let twice = Linearisation { order: [good.order[0]; 2], ..good };
    assert_eq!(with(twice, &[1.0]), LinearisationError::Order { value: 1, limit: 2 });
    let order = [0, 1, 2, 3].map(|k| (k, Quadrature::SplitAtZero));
    let law = GaussianMixture::independent([0.0; 4], [1.0; 4]).unwrap();
    let four_kinks = Linearisation { order, step: 0.1 };
    let error = four_kinks.laws(&FourRoots, &law, &[1.0]).unwrap_err();
    assert_eq!(error, LinearisationError::TooManyNodes { value: 1_048_576.0, limit: 3e5 });
    let early = plane(Quadrature::SplitAt(0));
    assert_eq!(with(early, &[1.0]), LinearisationError::Split { state: 1, at: 0 });
}
