//! Path-steps of the linear oscillator and of the oscillator with a viscous damper (Canor & Denoël 2013, section 4.1).
//!
//! The rival is what one writes without the crate: a scalar loop of Euler's method, `ChaCha8` and `StandardNormal` in
//! the order they come, the powers from the platform's mathematics library, nothing addressed and nothing checked.
//! A path has 600 steps. 256 paths are one block of an ensemble and run on the calling thread.

#![expect(
    clippy::unwrap_used,
    reason = "an ensemble that is refused is a mistake of the benchmark"
)]

use std::f64::consts::PI;
use std::hint::black_box;

use benches::CpuTime;
use criterion::measurement::Measurement;
use criterion::{BenchmarkGroup, Criterion, Throughput};
use fpk_sph::systems::{
    LinearOscillator, LinearOscillatorParameters, ViscousDamper, ViscousDamperParameters, Window,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use sde_integrators::{
    EnsembleConfig, EulerMaruyama, GaussianMixture, Integrator, Observable, Sde, SecondOrder,
    SemiImplicitEuler, StrangOscillator, simulate,
};

const N_PATHS: u32 = 256;
const N_STEPS: u32 = 600;
const DT: f64 = 0.01;
const PATH_STEPS: u64 = N_PATHS as u64 * N_STEPS as u64;
const DEVIATIONS: [f64; 2] = [0.15, 0.10];

const STRUCTURE: LinearOscillatorParameters = LinearOscillatorParameters {
    natural_frequency: PI,
    damping_ratio: 0.01,
    noise_intensity: 0.2,
    window: Window::CANOR_DENOEL_2013,
};
const DAMPER_COEFFICIENT: f64 = 0.25;
const DAMPER_EXPONENT: f64 = 0.35;

/// `E[q^2]` at the end.
fn ensemble<S, I>(system: &S, integrator: &I) -> f64
where
    S: Sde<2, 1>,
    I: Integrator<S, 2, 1>,
{
    let law = GaussianMixture::independent([0.0; 2], DEVIATIONS).unwrap();
    let times = vec![f64::from(N_STEPS) * DT];
    let config = EnsembleConfig { seed: 1, n_paths: u64::from(N_PATHS), dt: DT, times };
    let observables = [Observable::Mean(&|_, x: &[f64; 2]| x[0] * x[0])];
    let ensemble = simulate(system, integrator, &law, &config, &observables).unwrap();
    assert_eq!(ensemble.path_steps, u128::from(PATH_STEPS));
    ensemble.estimates[0][0].value
}

/// `E[q^2]` at the end by the rival; `damper(v)` is the damper's acceleration.
fn scalar_loop(damper: impl Fn(f64) -> f64) -> f64 {
    let (omega, xi) = (black_box(PI), black_box(0.01));
    let intensity = (2.0 * black_box(0.2_f64)).sqrt() * DT.sqrt();
    let mut generator = ChaCha8Rng::seed_from_u64(1);
    let mut normal = || -> f64 { StandardNormal.sample(&mut generator) };
    let mut sum = 0.0;
    for _ in 0..N_PATHS {
        let (mut q, mut v) = (DEVIATIONS[0] * normal(), DEVIATIONS[1] * normal());
        for k in 0..N_STEPS {
            let t = f64::from(k) * DT;
            let window = if t < 2.0 {
                t / 2.0
            } else if t < 6.0 {
                1.0
            } else {
                (2.0 * (6.0 - t)).exp()
            };
            let acceleration = -2.0 * xi * omega * v - omega * omega * q - damper(v);
            q += DT * v;
            v += DT * acceleration + window * intensity * normal();
        }
        sum += q * q;
    }
    sum / f64::from(N_PATHS)
}

fn methods<S>(group: &mut BenchmarkGroup<'_, impl Measurement>, system: &S)
where
    S: Sde<2, 1> + SecondOrder<1, 1>,
{
    group.throughput(Throughput::Elements(PATH_STEPS));
    group.bench_function("EulerMaruyama", |b| {
        b.iter(|| ensemble(black_box(system), &EulerMaruyama));
    });
    group.bench_function("SemiImplicitEuler", |b| {
        b.iter(|| ensemble(black_box(system), &SemiImplicitEuler));
    });
    group.bench_function("StrangOscillator", |b| {
        b.iter(|| ensemble(black_box(system), &StrangOscillator));
    });
}

/// A rival that computes something else is none. Two estimates from 256 paths each differ by a standard error of
/// `sqrt(2 * 2 / 256)` = 12.5 % of `E[q^2]` where `q` is normal; five of them are allowed.
fn check_rival(ours: f64, rival: f64) {
    assert!((rival / ours - 1.0).abs() < 5.0 * 0.125, "E[q^2] is {ours} and {rival}");
}

fn linear_oscillator(criterion: &mut Criterion<CpuTime>) {
    let system = LinearOscillator::new(STRUCTURE).unwrap();
    let rival = || scalar_loop(|_| 0.0);
    check_rival(ensemble(&system, &EulerMaruyama), rival());
    let mut group = criterion.benchmark_group("sde/linear oscillator");
    methods(&mut group, &system);
    group.bench_function("Euler, scalar loop (rival)", |b| b.iter(rival));
    group.finish();
}

fn viscous_damper(criterion: &mut Criterion<CpuTime>) {
    let parameters = ViscousDamperParameters {
        structure: STRUCTURE,
        damper_coefficient: DAMPER_COEFFICIENT,
        damper_exponent: DAMPER_EXPONENT,
    };
    let system = ViscousDamper::new(parameters).unwrap();
    let (eta, alpha) = (black_box(DAMPER_COEFFICIENT), black_box(DAMPER_EXPONENT));
    let rival = || scalar_loop(|v| eta * v.signum() * v.abs().powf(alpha));
    check_rival(ensemble(&system, &EulerMaruyama), rival());
    let mut group = criterion.benchmark_group("sde/viscous damper");
    methods(&mut group, &system);
    group.bench_function("Euler, scalar loop (rival)", |b| b.iter(rival));
    group.finish();
}

fn main() {
    let mut criterion = benches::criterion();
    linear_oscillator(&mut criterion);
    viscous_damper(&mut criterion);
    criterion.final_summary();
}
