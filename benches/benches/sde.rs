//! Normals, and path-steps of the linear oscillator and of the viscous damper.
//!
//! The damper is that of Canor & Denoël 2013, section 4.1.
//!
//! The rivals are what one writes without the crate: `ChaCha8` and `StandardNormal` (a ziggurat) in sequence, scalar
//! loops of Euler's and of Strang's method, powers from the platform's mathematics library, no addressing and no
//! checks. Strang's loop combines consecutive half flows of the damper. A path has 600 steps; 256 paths are one block
//! of an ensemble and run on the calling thread.

#![expect(clippy::unwrap_used, reason = "a rejected ensemble is an error of the benchmark")]

use std::f64::consts::PI;
use std::hint::black_box;

use benches::CpuTime;
use benches::ratios::{Ratios, Work};
use criterion::Criterion;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use sde_integrators::{
    EnsembleConfig, EulerMaruyama, GaussianMixture, Integrator, Noise, Observable, Purpose, Sde,
    SecondOrder, SemiImplicitEuler, SimdLevel, StrangOscillator, Study,
};
use vibrating_systems::{
    LinearOscillator, LinearOscillatorParameters, ViscousDamper, ViscousDamperParameters, Window,
};

const N_PATHS: u32 = 256;
const N_STEPS: u32 = 600;
const DT: f64 = 0.01;
const PATH_STEPS: usize = N_PATHS as usize * N_STEPS as usize;
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
fn ensemble<S, I>(system: &S, integrator: &I, level: SimdLevel) -> f64
where
    S: Sde<2, 1>,
    I: Integrator<S, 2, 1>,
{
    let law = GaussianMixture::independent([0.0; 2], DEVIATIONS).unwrap();
    let times = vec![f64::from(N_STEPS) * DT];
    let config = EnsembleConfig { seed: 1, n_paths: u64::from(N_PATHS), dt: DT, times };
    let observables = [Observable::Mean(&|_, x: &[f64; 2]| x[0] * x[0])];
    let study = Study {
        name: "bench",
        system,
        integrator,
        law: &law,
        config: &config,
        observables: &observables,
        level,
    };
    let ensemble = study.run::<1>().unwrap().ensemble().unwrap();
    assert_eq!(ensemble.path_steps, PATH_STEPS as u128);
    ensemble.estimates[0][0].value
}

/// Modulating function `a(t)`, as one writes it.
fn window(t: f64) -> f64 {
    if t < 2.0 {
        t / 2.0
    } else if t < 6.0 {
        1.0
    } else {
        (2.0 * (6.0 - t)).exp()
    }
}

/// `E[q^2]` at the end by the rival; `damper(v)` is the damper's acceleration.
fn scalar_euler(damper: impl Fn(f64) -> f64) -> f64 {
    let (omega, xi) = (black_box(PI), black_box(0.01));
    let intensity = (2.0 * black_box(0.2_f64)).sqrt() * DT.sqrt();
    let mut generator = ChaCha8Rng::seed_from_u64(1);
    let mut normal = || -> f64 { StandardNormal.sample(&mut generator) };
    let mut sum = 0.0;
    for _ in 0..N_PATHS {
        let (mut q, mut v) = (DEVIATIONS[0] * normal(), DEVIATIONS[1] * normal());
        for k in 0..N_STEPS {
            let t = f64::from(k) * DT;
            let acceleration = -2.0 * xi * omega * v - omega * omega * q - damper(v);
            q += DT * v;
            v += DT * acceleration + window(t) * intensity * normal();
        }
        sum += q * q;
    }
    sum / f64::from(N_PATHS)
}

/// `E[q^2]` at the end by Strang's splitting; `flow(v, dt)` is that of the damper. Each half kick takes one normal.
fn scalar_strang(flow: impl Fn(f64, f64) -> f64) -> f64 {
    let (omega, c) = (black_box(PI), 2.0 * black_box(0.01) * PI);
    let decay = (-0.5 * c * DT).exp();
    let kick = (2.0 * black_box(0.2_f64)).sqrt() * (-(-c * DT).exp_m1() / (2.0 * c)).sqrt();
    let (sin, cos) = (omega * DT).sin_cos();
    let mut generator = ChaCha8Rng::seed_from_u64(2);
    let mut normal = || -> f64 { StandardNormal.sample(&mut generator) };
    let mut sum = 0.0;
    for _ in 0..N_PATHS {
        let (mut q, mut v) = (DEVIATIONS[0] * normal(), DEVIATIONS[1] * normal());
        v = flow(v, 0.5 * DT);
        for k in 0..N_STEPS {
            let t = f64::from(k) * DT;
            v = decay * v + kick * window(t + 0.25 * DT) * normal();
            (q, v) = (cos * q + sin / omega * v, -omega * sin * q + cos * v);
            v = decay * v + kick * window(t + 0.75 * DT) * normal();
            v = flow(v, if k + 1 < N_STEPS { DT } else { 0.5 * DT });
        }
        sum += q * q;
    }
    sum / f64::from(N_PATHS)
}

/// Checks that the rival computes the same result.
///
/// Two estimates from 256 paths each differ by a standard error of `sqrt(2 * 2 / 256)` = 12.5 % of `E[q^2]` for normal
/// `q`; five standard errors are allowed.
fn check_rival(ours: f64, rival: f64) {
    assert!((rival / ours - 1.0).abs() < 5.0 * 0.125, "E[q^2] is {ours} and {rival}");
}

/// The methods on one system at every SIMD level, with their targets relative to the scalar loops.
struct Oscillator<'a, S> {
    name: &'static str,
    system: &'a S,
    euler: &'a dyn Fn() -> f64,
    strang: &'a dyn Fn() -> f64,
}

impl<S: Sde<2, 1> + SecondOrder<1, 1>> Oscillator<'_, S> {
    fn measure(&self, ratios: &mut Ratios, criterion: &mut Criterion<CpuTime>) {
        check_rival(ensemble(self.system, &EulerMaruyama, SimdLevel::best()), (self.euler)());
        check_rival(ensemble(self.system, &StrangOscillator, SimdLevel::best()), (self.strang)());
        self.method(ratios, criterion, "EulerMaruyama", &EulerMaruyama, 4.0);
        self.method(ratios, criterion, "SemiImplicitEuler", &SemiImplicitEuler, 4.0);
        self.method(ratios, criterion, "StrangOscillator", &StrangOscillator, 2.0);
    }

    fn method<I: Integrator<S, 2, 1>>(
        &self,
        ratios: &mut Ratios,
        criterion: &mut Criterion<CpuTime>,
        method: &'static str,
        integrator: &I,
        target: f64,
    ) {
        let (rival, name) = if method == "StrangOscillator" {
            (self.strang, "scalar Strang loop, libm")
        } else {
            (self.euler, "scalar Euler loop, libm")
        };
        for level in SimdLevel::available() {
            let work = format!("sde/{}, {method}, {level}", self.name);
            let ours = || {
                black_box(ensemble(black_box(self.system), integrator, level));
            };
            let theirs = || {
                black_box(rival());
            };
            let work = Work::new(work, PATH_STEPS, "sde-integrators", ours)
                .rival_to_beat(name, target, theirs);
            let is_best = level == SimdLevel::best();
            ratios.measure(if is_best { work.in_criterion(criterion) } else { work });
        }
    }
}

fn linear_oscillator(ratios: &mut Ratios, criterion: &mut Criterion<CpuTime>) {
    let system = LinearOscillator::new(STRUCTURE).unwrap();
    let (euler, strang) = (|| scalar_euler(|_| 0.0), || scalar_strang(|v, _| v));
    Oscillator { name: "linear oscillator", system: &system, euler: &euler, strang: &strang }
        .measure(ratios, criterion);
}

fn viscous_damper(ratios: &mut Ratios, criterion: &mut Criterion<CpuTime>) {
    let parameters = ViscousDamperParameters {
        structure: STRUCTURE,
        damper_coefficient: DAMPER_COEFFICIENT,
        damper_exponent: DAMPER_EXPONENT,
    };
    let system = ViscousDamper::new(parameters).unwrap();
    let (eta, alpha) = (black_box(DAMPER_COEFFICIENT), black_box(DAMPER_EXPONENT));
    let euler = || scalar_euler(|v| eta * v.signum() * v.abs().powf(alpha));
    let beta = 1.0 - alpha;
    let strang = || {
        scalar_strang(|v, dt| {
            let left = v.abs().powf(beta) - eta * beta * dt;
            if left <= 0.0 { 0.0 } else { v.signum() * left.powf(1.0 / beta) }
        })
    };
    Oscillator { name: "viscous damper", system: &system, euler: &euler, strang: &strang }
        .measure(ratios, criterion);
}

/// Normals of one stream into a slice, as a field with that many unknowns draws them in each step.
fn normals(ratios: &mut Ratios, criterion: &mut Criterion<CpuTime>) {
    for n in [1_000, 65_536] {
        let (mut ours, mut theirs) = (vec![0.0; n], vec![0.0; n]);
        for level in SimdLevel::available() {
            let mut stream = Noise::new(1).stream(Purpose::Field, 0).at_level(level);
            let mut generator = ChaCha8Rng::seed_from_u64(1);
            let work = Work::new(format!("sde/{n} normals, {level}"), n, "fill_normal", || {
                stream.fill_normal(black_box(&mut ours));
            })
            .rival_to_beat("ChaCha8 + StandardNormal", 1.2, || {
                for normal in black_box(&mut theirs) {
                    *normal = StandardNormal.sample(&mut generator);
                }
            });
            let is_best = level == SimdLevel::best();
            ratios.measure(if is_best { work.in_criterion(criterion) } else { work });
        }
    }
    let mut path = Noise::new(1).path::<1>(0);
    let mut generator = ChaCha8Rng::seed_from_u64(1);
    let (mut step, mut its_step) = (0_u64, 0_u64);
    ratios.measure(
        Work::new("sde/increment at a random step", 1_000, "increment_at", || {
            for _ in 0..1_000 {
                step = step.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
                black_box(path.increment_at(step >> 40, 0.01));
            }
        })
        .rival("ChaCha8, set_word_pos + StandardNormal", || {
            for _ in 0..1_000 {
                its_step = its_step.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
                generator.set_word_pos(u128::from(its_step >> 40) * 16);
                let normal: f64 = StandardNormal.sample(&mut generator);
                black_box(normal);
            }
        }),
    );
}

fn main() {
    let mut criterion = benches::criterion();
    let mut ratios = Ratios::from_args("sde");
    normals(&mut ratios, &mut criterion);
    linear_oscillator(&mut ratios, &mut criterion);
    viscous_damper(&mut ratios, &mut criterion);
    ratios.note(
        "M/s: normals, or path-steps. A level is the widest vector instructions that were allowed.",
    );
    criterion.final_summary();
    ratios.print();
}
