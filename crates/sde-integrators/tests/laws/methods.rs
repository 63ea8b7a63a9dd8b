//! Stationary laws and orders of the methods on linear systems, without sampling noise.

use sde_integrators::{
    EulerMaruyama, Increment, Integrator, LinearFlows, SecondOrder, SemiImplicitEuler, StateSpace,
    StochasticTheta, StrangOscillator,
};

use crate::moments::{Moments, after_steps, exact, order, probe, stationary, strong_difference};

/// `q'' + c q' + omega^2 q = f sin 3t - k q + s (1 + a sin 2t) W`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Linear {
    pub(crate) omega: f64,
    pub(crate) c: f64,
    pub(crate) s: f64,
    pub(crate) force: f64,
    pub(crate) stiffness: f64,
    pub(crate) modulation: f64,
}

impl Linear {
    pub(crate) const fn oscillator(omega: f64, c: f64, s: f64) -> Self {
        Self { omega, c, s, force: 0.0, stiffness: 0.0, modulation: 0.0 }
    }
}

/// Damped, under constant noise.
pub(crate) const OSCILLATOR: StateSpace<Linear> = StateSpace(Linear::oscillator(2.0, 0.3, 0.9));

impl SecondOrder<1, 1> for Linear {
    fn natural_frequency(&self) -> [f64; 1] {
        [self.omega]
    }

    fn linear_damping(&self) -> [f64; 1] {
        [self.c]
    }

    fn remaining_acceleration(&self, t: f64, q: &[f64; 1], _v: &[f64; 1]) -> [f64; 1] {
        [self.force * (3.0 * t).sin() - self.stiffness * q[0]]
    }

    fn remaining_flow(&self, t: f64, dt: f64, q: &[f64; 1], v: &mut [f64; 1]) {
        v[0] += dt * self.remaining_acceleration(t, q, v)[0];
    }

    fn noise_intensity(&self, t: f64) -> [[f64; 1]; 1] {
        [[self.s * (1.0 + self.modulation * (2.0 * t).sin())]]
    }
}

/// Three oscillators that share one Brownian motion.
#[derive(Clone, Copy)]
struct Three {
    omega: [f64; 3],
    c: [f64; 3],
    s: [f64; 3],
}

impl SecondOrder<3, 1> for Three {
    fn natural_frequency(&self) -> [f64; 3] {
        self.omega
    }

    fn linear_damping(&self) -> [f64; 3] {
        self.c
    }

    fn remaining_acceleration(&self, _t: f64, _q: &[f64; 3], _v: &[f64; 3]) -> [f64; 3] {
        [0.0; 3]
    }

    fn remaining_flow(&self, _t: f64, _dt: f64, _q: &[f64; 3], _v: &mut [f64; 3]) {}

    fn noise_intensity(&self, _t: f64) -> [[f64; 1]; 3] {
        self.s.map(|s| [s])
    }
}

/// Tolerance: roundoff of the doubling, about `eps` times the number of steps in a relaxation time (at most 1e3).
#[test]
fn strang_has_the_exact_stationary_law_of_a_linear_oscillator_at_any_step() {
    for omega in [0.5, 1.0, 3.0] {
        for xi in [0.01, 0.05, 0.2, 1.0, 5.0] {
            for angle in [0.05, 0.4, 1.3, 2.9, 7.0] {
                let (c, s, dt) = (2.0 * xi * omega, 0.7, angle / omega);
                let map =
                    probe::<_, _, 2>(&Linear::oscillator(omega, c, s), &StrangOscillator, 0.3, dt);
                let p = stationary(&map, dt);
                let v_squared = s * s / (2.0 * c);
                let q_squared = v_squared / (omega * omega);
                let cross = (q_squared * v_squared).sqrt();
                assert!(
                    (p[1][1] / v_squared - 1.0).abs() < 1e-12,
                    "E v^2, xi {xi}, h omega {angle}"
                );
                assert!(
                    (p[0][0] / q_squared - 1.0).abs() < 1e-12,
                    "E q^2, xi {xi}, h omega {angle}"
                );
                assert!((p[0][1] / cross).abs() < 1e-12, "E q v, xi {xi}, h omega {angle}");
            }
        }
    }
}

/// Each of several degrees of freedom has the law it has alone, so that states and velocities are not mixed up.
#[test]
fn degrees_of_freedom_keep_their_own_stationary_laws() {
    let three = Three { omega: [0.5, 2.0, 3.0], c: [0.3, 0.2, 1.0], s: [1.0, 0.4, 2.0] };
    let dt = 0.4;
    let strang = stationary(&probe::<_, _, 6>(&three, &StrangOscillator, 0.0, dt), dt);
    let semi = stationary(&probe::<_, _, 6>(&three, &SemiImplicitEuler, 0.0, dt), dt);
    let euler = probe::<_, _, 6>(&StateSpace(three), &EulerMaruyama, 0.0, dt);
    for k in 0..3 {
        let alone = Linear::oscillator(three.omega[k], three.c[k], three.s[k]);
        let v_squared = three.s[k] * three.s[k] / (2.0 * three.c[k]);
        assert!((strang[3 + k][3 + k] / v_squared - 1.0).abs() < 1e-12);
        let expected = stationary(&probe::<_, _, 2>(&alone, &SemiImplicitEuler, 0.0, dt), dt);
        assert!((semi[k][k] / expected[0][0] - 1.0).abs() < 1e-12);
        let expected = probe::<_, _, 2>(&StateSpace(alone), &EulerMaruyama, 0.0, dt);
        assert!((euler.a[3 + k][k] - expected.a[1][0]).abs() < 1e-14);
        assert!((euler.by_w[3 + k] - expected.by_w[1]).abs() < 1e-14);
    }
}

/// The values of a survey by the discrete Lyapunov equation; tolerance: half a unit of their last digit.
#[test]
fn semi_implicit_euler_has_its_known_stationary_errors() {
    let (omega, xi, s) = (2.0, 0.05, 1.0);
    let c = 2.0 * xi * omega;
    let q_squared = s * s / (2.0 * c) / (omega * omega);
    let published = [
        (0.8, 0.20, 0.005),
        (0.4, 0.043, 0.0005),
        (0.2, 0.010, 0.0005),
        (0.1, 2.5e-3, 0.05e-3),
        (0.05, 6.3e-4, 0.05e-4),
    ];
    for (angle, error, half_digit) in published {
        let dt = angle / omega;
        let p = stationary(
            &probe::<_, _, 2>(&Linear::oscillator(omega, c, s), &SemiImplicitEuler, 0.0, dt),
            dt,
        );
        let measured = p[0][0] / q_squared - 1.0;
        assert!((measured - error).abs() <= half_digit, "h omega {angle}: {measured}");
    }
}

/// `q` under a linear method is a second-order autoregression, whose variance is known. With `a = h omega` and
/// `d = c h = 2 xi a`, relative to the exact `E[q^2]`; tolerance: roundoff, `eps` times the steps of a relaxation time.
#[test]
fn linear_methods_have_the_stationary_variance_of_their_autoregression() {
    let semi_implicit = |xi: f64, a: f64| 1.0 / (1.0 - a * a / (4.0 - 4.0 * xi * a));
    let backward = |xi: f64, a: f64| {
        let d = 2.0 * xi * a;
        2.0 * d * (2.0 + d + a * a) / ((d + a * a) * (4.0 + 2.0 * d + a * a))
    };
    let euler = |xi: f64, a: f64| {
        let d = 2.0 * xi * a;
        (4.0 - 2.0 * d + 2.0 * a * a) / (4.0 - 2.0 * d + a * a) * d / (d - a * a)
    };
    for xi in [0.02, 0.05, 0.5] {
        // At half the damping the limit of the semi-implicit method is 2 (sqrt(1.25) - 0.5) = 1.236.
        for a in [0.05, 0.4, 1.2] {
            is_as_stated(&SemiImplicitEuler, xi, a, semi_implicit(xi, a));
        }
        for a in [0.05, 0.4, 1.3, 1.9] {
            is_as_stated(&StochasticTheta::BACKWARD_EULER, xi, a, backward(xi, a));
            let p = is_as_stated(&StochasticTheta::TRAPEZOIDAL, xi, a, 1.0);
            assert!(p[0][1].abs() < 1e-12 * (p[0][0] * p[1][1]).sqrt(), "xi {xi}, h omega {a}");
            assert!((p[1][1] / (4.0 * p[0][0]) - 1.0).abs() < 1e-12, "xi {xi}, h omega {a}");
        }
        // Euler-Maruyama is stable for h omega < 2 xi alone.
        for share in [0.1, 0.5, 0.9] {
            let a = share * 2.0 * xi;
            is_as_stated(&EulerMaruyama, xi, a, euler(xi, a));
        }
    }
}

/// Checks `E[q^2]` at `omega = 2` and returns the stationary covariance.
fn is_as_stated<I>(method: &I, xi: f64, angle: f64, expected: f64) -> crate::moments::Matrix
where
    I: Integrator<StateSpace<Linear>, 2, 1>,
{
    let (omega, s) = (2.0, 0.7);
    let (c, dt) = (2.0 * xi * omega, angle / omega);
    let p = stationary(&probe(&StateSpace(Linear::oscillator(omega, c, s)), method, 0.0, dt), dt);
    let ratio = p[0][0] / (s * s / (2.0 * c) / (omega * omega));
    assert!((ratio / expected - 1.0).abs() < 1e-12, "xi {xi}, h omega {angle}: {ratio} {expected}");
    p
}

const START: [f64; 2] = [0.4, -0.7];

fn weak_errors<I>(system: &StateSpace<Linear>, method: &I) -> Vec<f64>
where
    I: Integrator<StateSpace<Linear>, 2, 1>,
{
    let start = Moments { mean: START.to_vec(), covariance: vec![vec![0.3, 0.1], vec![0.1, 0.2]] };
    // The error of Runge-Kutta at this step is below 1e-12, far below every error of the methods.
    let truth = exact(system, &start, 2.0, 4_000);
    [64, 128, 256, 512, 1024]
        .map(|n| after_steps(system, method, &start, 2.0, n).largest_difference(&truth))
        .to_vec()
}

fn strong_errors<I>(system: &StateSpace<Linear>, method: &I) -> Vec<f64>
where
    I: Integrator<StateSpace<Linear>, 2, 1>,
{
    [64, 128, 256, 512, 1024].map(|n| strong_difference(system, method, START, 2.0, n)).to_vec()
}

/// Linear systems: autonomous; with a stiffness in the remaining force; with force and intensity that change in time;
/// without a linear part at all.
fn systems() -> [StateSpace<Linear>; 4] {
    let damped = Linear::oscillator(1.7, 0.5, 0.8);
    [
        damped,
        Linear { stiffness: 2.0, ..damped },
        Linear { force: 1.5, stiffness: 0.5, modulation: 0.6, ..damped },
        Linear { force: 1.5, stiffness: 3.0, modulation: 0.6, ..Linear::oscillator(0.0, 0.0, 0.8) },
    ]
    .map(StateSpace)
}

/// Slopes over five levels; tolerance 0.15 for the next term of the error at the coarse end. No sampling noise.
fn has_its_orders<I: Integrator<StateSpace<Linear>, 2, 1>>(
    name: &str,
    method: &I,
    weak_order: f64,
) {
    for system in &systems() {
        let (weak, strong) = (weak_errors(system, method), strong_errors(system, method));
        for (kind, errors, expected) in [("weak", weak, weak_order), ("strong", strong, 1.0)] {
            let measured = order(&errors);
            assert!(
                (measured - expected).abs() < 0.15,
                "{name}: {kind} {measured}, {errors:?}, {system:?}"
            );
        }
    }
}

#[test]
fn every_method_has_its_weak_and_strong_order_in_the_transient() {
    has_its_orders("Euler-Maruyama", &EulerMaruyama, 1.0);
    has_its_orders("semi-implicit Euler", &SemiImplicitEuler, 1.0);
    has_its_orders("Strang", &StrangOscillator, 2.0);
}

/// `omega = 0`, `c = 0`: the rotation is a drift and the kicks are whole, continuously in both limits.
#[test]
fn strang_goes_over_into_free_motion() {
    let (dt, s) = (0.3, 0.8);
    let free = probe::<_, _, 2>(&Linear::oscillator(0.0, 0.0, s), &StrangOscillator, 0.0, dt);
    // w/2 + sqrt(3) H drifts for h, w/2 - sqrt(3) H not at all.
    let by_h = dt * s * 3.0_f64.sqrt();
    assert!((free.a[0][1] - dt).abs() < 1e-16 && free.a[1][0].abs() < 1e-16);
    assert!((free.by_w[0] - 0.5 * dt * s).abs() < 1e-16 && (free.by_w[1] - s).abs() < 1e-16);
    assert!((free.by_h[0] - by_h).abs() < 1e-16 && free.by_h[1].abs() < 1e-16);
    let nearly = probe::<_, _, 2>(&Linear::oscillator(1e-9, 1e-9, s), &StrangOscillator, 0.0, dt);
    let entries = |map: &crate::moments::StepMap| {
        [map.a.concat(), map.by_w.clone(), map.by_h.clone()].concat()
    };
    for (a, b) in entries(&free).iter().zip(entries(&nearly)) {
        assert!((a - b).abs() < 1e-9);
    }
}

/// The kept coefficients follow step length and system: a used memory gives the bits of a fresh one.
#[test]
fn the_memory_of_strang_is_no_more_than_a_memory() {
    let dw = Increment { brownian: [0.3], space_time_area: [-0.1] };
    let mut memory = LinearFlows::default();
    for (omega, c, dt) in
        [(1.0, 0.2, 0.1), (1.0, 0.2, 0.2), (1.5, 0.2, 0.2), (1.5, 0.0, 0.2), (0.0, 0.0, 0.2)]
    {
        let system = Linear::oscillator(omega, c, 1.0);
        let (mut used, mut fresh) = (START, START);
        StrangOscillator.step(&system, 0.0, dt, &dw, &mut used, &mut memory).unwrap();
        StrangOscillator
            .step(&system, 0.0, dt, &dw, &mut fresh, &mut LinearFlows::default())
            .unwrap();
        assert_eq!(used.map(f64::to_bits), fresh.map(f64::to_bits));
    }
}
