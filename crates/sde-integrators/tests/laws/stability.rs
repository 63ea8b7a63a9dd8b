//! Where the methods stop being stable: the spectral radius of one step just inside and just outside the limit.

use sde_integrators::{
    EulerMaruyama, Heun, Integrator, SemiImplicitEuler, Shark, StateSpace, StrangOscillator,
};

use crate::methods::Linear;
use crate::moments::{StepMap, probe};

/// The largest modulus of the eigenvalues of a 2 x 2 matrix.
fn spectral_radius(map: &StepMap) -> f64 {
    let a = &map.a;
    let (half_trace, determinant) =
        (0.5 * (a[0][0] + a[1][1]), a[0][0] * a[1][1] - a[0][1] * a[1][0]);
    let discriminant = half_trace * half_trace - determinant;
    if discriminant < 0.0 { determinant.sqrt() } else { half_trace.abs() + discriminant.sqrt() }
}

const OMEGA: f64 = 3.0;

fn oscillator(xi: f64) -> StateSpace<Linear> {
    StateSpace(Linear::oscillator(OMEGA, 2.0 * xi * OMEGA, 1.0))
}

#[test]
fn euler_maruyama_grows_beyond_twice_the_damping_ratio() {
    for xi in [0.01, 0.05, 0.2, 0.9] {
        let radius = |angle: f64| {
            spectral_radius(&probe::<_, _, 2>(&oscillator(xi), &EulerMaruyama, 0.0, angle / OMEGA))
        };
        assert!(radius(0.999 * 2.0 * xi) < 1.0 && radius(1.001 * 2.0 * xi) > 1.0, "xi {xi}");
    }
}

#[test]
fn semi_implicit_euler_grows_beyond_its_limit() {
    // The survey's values for xi = 0.01, 0.05, 0.2, 1, 5, measured to about 0.5 %.
    let measured = [(0.01, 1.99), (0.05, 1.90), (0.2, 1.64), (1.0, 0.83), (5.0, 0.20)];
    for (xi, published) in measured {
        let limit = 2.0 * (f64::hypot(1.0, xi) - xi);
        assert!((limit - published).abs() <= 0.01, "xi {xi}: {limit}");
        let radius = |angle: f64| {
            spectral_radius(&probe::<_, _, 2>(
                &oscillator(xi),
                &SemiImplicitEuler,
                0.0,
                angle / OMEGA,
            ))
        };
        assert!(radius(0.999 * limit) < 1.0 && radius(1.001 * limit) > 1.0, "xi {xi}");
    }
}

/// `|1 + z + z^2/2| = 1` at the eigenvalue `z = h omega (-xi + i sqrt(1 - xi^2))`; a survey found 0.445, 0.80 and 1.40 to its
/// last digit.
#[test]
fn heun_and_shark_grow_beyond_the_limit_of_an_explicit_method_of_order_two() {
    for (xi, published) in [(0.01, 0.445), (0.05, 0.80), (0.2, 1.40)] {
        let amplification = |angle: f64| {
            let (x, y) = (-xi * angle, f64::sqrt(1.0 - xi * xi) * angle);
            f64::hypot(1.0 + x + 0.5 * (x * x - y * y), y + x * y)
        };
        let (mut below, mut above) = (0.1, 2.0);
        for _ in 0..60 {
            let middle = 0.5 * (below + above);
            if amplification(middle) <= 1.0 { below = middle } else { above = middle }
        }
        assert!((below / published - 1.0).abs() < 0.01, "xi {xi}: {below}");
        is_stable_up_to(&Heun, xi, below);
        is_stable_up_to(&Shark, xi, below);
    }
}

fn is_stable_up_to<I>(method: &I, xi: f64, limit: f64)
where
    I: Integrator<StateSpace<Linear>, 2, 1>,
{
    let radius = |angle: f64| {
        spectral_radius(&probe::<_, _, 2>(&oscillator(xi), method, 0.0, angle / OMEGA))
    };
    assert!(radius((1.0 - 1e-6) * limit) < 1.0 && radius((1.0 + 1e-6) * limit) > 1.0, "xi {xi}");
}

/// The radius is that of the damping alone, `exp(-c h/2)`, while the discriminant is negative; it never reaches 1.
#[test]
fn strang_is_stable_at_every_step() {
    for xi in [0.01, 0.2, 1.0, 5.0] {
        for angle in [0.01, 0.5, 2.0, 3.1, 10.0, 100.0] {
            let map = probe::<_, _, 2>(&oscillator(xi), &StrangOscillator, 0.0, angle / OMEGA);
            assert!(spectral_radius(&map) < 1.0, "xi {xi}, h omega {angle}");
        }
    }
}
