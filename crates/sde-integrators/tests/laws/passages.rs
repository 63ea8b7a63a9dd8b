//! First passage: what happens between the steps, by the right rule and by wrong ones; rare events by subset simulation.

#![allow(clippy::unwrap_used, reason = "a test ends by it")]

use sde_integrators::{
    Additive, Between, DrivenPath, EnsembleConfig, Error, Estimate, EulerMaruyama, GaussianMixture,
    Noise, Response, Sde, Side, StateSpace, StrangOscillator, SubsetConfig, maxima,
    subset_simulation,
};

use crate::methods::Linear;

/// `dX = s dB`.
struct BrownianMotion(f64);

impl Sde<1, 1> for BrownianMotion {
    type Noise = Additive;

    fn drift(&self, _: f64, _: &[f64; 1]) -> [f64; 1] {
        [0.0]
    }

    fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[self.0]]
    }
}

const INTENSITY: f64 = 0.7;

/// Within four standard errors and a bias, relative.
fn is(name: &str, found: &Estimate, exact: f64, bias: f64) {
    let error = found.standard_error().unwrap();
    let off = (found.value - exact).abs();
    assert!(off <= bias * exact + 4.0 * error, "{name}: {found} for {exact}");
}

/// Standard errors between two estimates.
fn apart(a: &Estimate, b: &Estimate) -> f64 {
    (a.value - b.value).abs() / a.standard_error().unwrap().hypot(b.standard_error().unwrap())
}

/// `P(max X > b) = 2 P(X(T) > b)` and the median of the maximum, with eight steps only. Watched at the ends of steps the barrier is as
/// if `0.5826 s sqrt(h)` higher (Broadie, Glasserman and Kou 1997); what that leaves falls as h.
#[test]
fn a_bridge_has_the_passages_of_brownian_motion_and_the_ends_of_steps_shift_the_barrier() {
    let run = |seed, n_paths, n_steps: f64, between| {
        let config = EnsembleConfig { seed, n_paths, dt: n_steps.recip(), times: vec![1.0] };
        let response = Response { component: 0, side: Side::Above, between };
        let system = BrownianMotion(INTENSITY);
        maxima(&system, &EulerMaruyama, &[0.0], &config, &response).unwrap().remove(0)
    };
    let level = 1.2 * INTENSITY;
    let bridge = run(17, 100_000, 8.0, Between::BrownianBridge { intensity: &|_, _| INTENSITY });
    let passage = bridge.exceedance(level).unwrap();
    // 2 P(Z > 1.2), and P(|Z| > x) = 1/2.
    is("bridge", &passage, 2.0 * 0.115_069_670_221_708_3, 0.0);
    is("median", &bridge.quantile(0.5).unwrap(), INTENSITY * 0.674_489_750_196_082, 0.0);
    let ends = run(17, 100_000, 8.0, Between::Endpoints).exceedance(level).unwrap();
    assert!(apart(&ends, &passage) > 10.0, "{ends} {passage}");
    // 2 P(Z > 1.2 + 0.5826/sqrt(128)).
    let ends = run(18, 50_000, 128.0, Between::Endpoints).exceedance(level).unwrap();
    is("ends of 128 steps", &ends, 2.0 * 0.105_376_959_008_040_5, 0.005);
}

/// Three periods of a stationary oscillator, eight steps to a period against 128: the kicks within a step are not in the curve, an
/// error of second order.
#[test]
fn cubics_and_arcs_have_the_passages_of_an_oscillator_and_ends_and_bridges_do_not() {
    const COARSE: f64 = 0.4;
    const OMEGA: f64 = 2.0;
    let oscillator = StateSpace(Linear::oscillator(OMEGA, 0.2, 1.0));
    let deviation = 0.625_f64.sqrt();
    let passage = |between, dt, seed, n_paths| {
        let law = GaussianMixture::independent([0.0; 2], [deviation, deviation * OMEGA]).unwrap();
        let config = EnsembleConfig { seed, n_paths, dt, times: vec![9.6] };
        let response = Response { component: 0, side: Side::Magnitude, between };
        let found = maxima(&oscillator, &StrangOscillator, &law, &config, &response).unwrap();
        found[0].exceedance(2.2 * deviation).unwrap()
    };
    let hermite = Between::CubicHermite { velocity: 1 };
    let fine = passage(hermite, COARSE / 16.0, 5, 60_000);
    for (between, dt, bias) in [
        (hermite, COARSE, 0.01),
        (hermite, 0.5 * COARSE, 0.0025),
        (Between::RotationArc { natural_frequency: OMEGA }, COARSE, 0.01),
    ] {
        let found = passage(between, dt, 6, 100_000);
        let error = found.standard_error().unwrap().hypot(fine.standard_error().unwrap());
        let off = (found.value - fine.value).abs();
        assert!(off <= bias * fine.value + 4.0 * error, "{dt}: {found} for {fine}");
    }
    let ends = passage(Between::Endpoints, COARSE, 6, 100_000);
    let intensity = |_: f64, _: &[f64]| 1.0;
    let bridge = passage(Between::BrownianBridge { intensity: &intensity }, COARSE, 6, 100_000);
    assert!(apart(&ends, &fine) > 10.0 && apart(&bridge, &fine) > 10.0, "{ends} {bridge} {fine}");
}

const SUBSET: SubsetConfig = SubsetConfig { n_samples: 1_000, correlation: 0.8, n_runs: 24 };

/// `P(q(6) > b)` from rest at 4.5 deviations, with `Var q(6)` by Caughey and Stumpf 1961. The bias is `b^2` times the error of the
/// deviation, below 1e-3 each way, and that of a run.
#[test]
fn subset_simulation_finds_a_rare_displacement() {
    let system = StateSpace(Linear::oscillator(2.0, 0.2, 1.0));
    let (integrator, n_steps) = (&StrangOscillator, 120);
    let dt = 6.0 / n_steps as f64;
    let path = DrivenPath { system: &system, integrator, start: [0.0; 2], dt, n_steps };
    let response =
        |normals: &[f64]| -> Result<f64, Error> { Ok(path.run::<1>(normals, |_, _, _| ())?[0]) };
    let threshold = 4.5 * 0.445_119_438_518_517_1_f64.sqrt();
    let n_normals = path.n_normals::<1>();
    let found = subset_simulation(&response, n_normals, threshold, &Noise::new(4), &SUBSET);
    is("P(Z > 4.5)", &found.unwrap(), 3.397_673_124_730_061_5e-6, 0.06);
}

/// `P(max W > 4)` over the unit of time, `2 Phi(-4)`. The maximum between steps is a function of two more normals per step,
/// `-ln U = (z_1^2 + z_2^2)/2`, so that the answer is exact with 16 steps, but for the bias of a run: the square of its coefficient of
/// variation, 0.3.
#[test]
fn subset_simulation_finds_a_rare_passage() {
    let n_steps = 16;
    let dt = 1.0 / n_steps as f64;
    let (system, integrator) = (&BrownianMotion(1.0), &EulerMaruyama);
    let path = DrivenPath { system, integrator, start: [0.0], dt, n_steps };
    let n_driving = path.n_normals::<1>();
    let response = |normals: &[f64]| -> Result<f64, Error> {
        let (driving, between) = normals.split_at(n_driving);
        let (mut largest, mut pairs) = (0.0_f64, between.chunks_exact(2));
        path.run::<1>(driving, |_, &[x_0], &[x_1]| {
            let square: f64 = pairs.next().into_iter().flatten().map(|z| z * z).sum();
            let spread = ((x_1 - x_0).powi(2) + dt * square).sqrt();
            largest = largest.max(0.5 * (x_0 + x_1 + spread));
        })?;
        Ok(largest)
    };
    let found = subset_simulation(&response, 3 * n_steps, 4.0, &Noise::new(5), &SUBSET).unwrap();
    is("P(max W > 4)", &found, 2.0 * 3.167_124_183_311_996_5e-5, 0.1);
}
