//! Steps and runs of fpk-sph on the viscous damper and the hysteretic building.
//!
//! Measured on the damper of Canor & Denoël 2013, section 4.1: a complete run, a step of each method, the density
//! integrated over the cells. On their hysteretic building, section 4.2, with three states: a step.
//!
//! Runs use one thread; a step is also measured with two. Times are CPU time of all threads, so the excess over one
//! thread is the cost of threading. Work counters do not depend on the machine and are printed once. The throughput is
//! in neighbour visits.

#![expect(clippy::unwrap_used, reason = "a run that fails is a mistake of the benchmark")]
#![expect(clippy::print_stdout, reason = "the work counted belongs beside the times")]

use std::f64::consts::PI;
use std::hint::black_box;
use std::time::Duration;

use benches::CpuTime;
use criterion::{BatchSize, Criterion, SamplingMode, Throughput};
use fpk_sph::{Config, DEFAULT_MOST_STEPS, InitialLattice, Method, Simulation, Work};
use rayon::ThreadPool;
use sde_integrators::{GaussianMixture, Sde};
use vibrating_systems::{
    BoucWen, BoucWenParameters, LinearOscillatorParameters, ViscousDamper, ViscousDamperParameters,
    Window,
};

/// Time at which the earthquake begins to decay.
const END: f64 = 6.0;

type Damper = Simulation<ViscousDamper, 2, 1>;

/// A method by name, with its initialisation.
type Start<S, const D: usize> = (&'static str, fn() -> Simulation<S, D, 1>);
type Named = Start<ViscousDamper, 2>;

fn simulation(method: Method, lattice: InitialLattice<2>) -> Damper {
    let structure = LinearOscillatorParameters {
        natural_frequency: PI,
        damping_ratio: 0.01,
        noise_intensity: 0.2,
        window: Window::CANOR_DENOEL_2013,
    };
    let parameters =
        ViscousDamperParameters { structure, damper_coefficient: 0.25, damper_exponent: 0.35 };
    let system = ViscousDamper::new(parameters).unwrap();
    let at_rest = GaussianMixture::independent([0.0, 0.0], [0.15, 0.10]).unwrap();
    let reference_period = system.period();
    let config = Config { method, lattice, reference_period, most_steps: DEFAULT_MOST_STEPS };
    Simulation::new(system, &at_rest, &config).unwrap()
}

fn flow_map() -> Damper {
    simulation(Method::FlowMapFit, InitialLattice::box_of(41))
}

fn at_the_end(start: fn() -> Damper) -> Damper {
    let mut simulation = start();
    simulation.advance_to(END).unwrap();
    simulation
}

/// The method of this project, with its initialisation.
const OURS: Named = ("FlowMapFit 41 x 41", flow_map);

fn paper() -> Damper {
    let lattice = InitialLattice::Rectangle { half_width: [0.6, 0.4], count: [50, 33] };
    simulation(Method::CanorDenoel2013, lattice)
}

type Building = Simulation<BoucWen, 3, 1>;

fn building(method: Method) -> Building {
    let system = BoucWen::new(BoucWenParameters::CANOR_DENOEL_2013).unwrap();
    let at_rest = GaussianMixture::independent([0.0; 3], [0.05; 3]).unwrap();
    let lattice = InitialLattice::Ball { reach: 5.0, spacing: 0.5 };
    let reference_period = system.period();
    let config = Config { method, lattice, reference_period, most_steps: DEFAULT_MOST_STEPS };
    Simulation::new(system, &at_rest, &config).unwrap()
}

fn building_flow_map() -> Building {
    building(Method::FlowMapFit)
}

fn print_work<S: Sde<D, 1>, const D: usize>(
    name: &str,
    simulation: &Simulation<S, D, 1>,
    work: Work,
) {
    let n = simulation.n_particles();
    let Work { steps, evaluations, neighbour_visits } = work;
    println!(
        "{name}: {n} particles, {steps} steps, {evaluations} evaluations, {neighbour_visits} neighbour visits"
    );
}

/// Initialisation and steps to `t = 6`.
fn run(criterion: &mut Criterion<CpuTime>, pool: &ThreadPool) {
    let mut group = criterion.benchmark_group("fpk/viscous damper, run to 6 s");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.warm_up_time(Duration::from_secs(2)).measurement_time(Duration::from_secs(10));
    let (name, start) = OURS;
    let simulation = pool.install(|| at_the_end(start));
    print_work(&format!("{name}, start and run to t = 6"), &simulation, simulation.work());
    group.throughput(Throughput::Elements(simulation.work().neighbour_visits));
    group.bench_function(name, |b| b.iter(|| pool.install(|| at_the_end(start))));
    group.finish();
}

/// One step from `t = 1`, where the noise has begun and the lattice has rotated.
fn step<S: Sde<D, 1> + Send, const D: usize>(
    criterion: &mut Criterion<CpuTime>,
    scene: &str,
    methods: &[Start<S, D>],
) {
    let mut group = criterion.benchmark_group(format!("fpk/{scene}, step from 1 s"));
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for (method, start) in methods {
            let name = format!("{method}, threads: {threads}");
            let mut snapshot = Vec::new();
            let mut simulation = pool.install(start);
            pool.install(|| simulation.advance_to(1.0)).unwrap();
            simulation.snapshot(&mut snapshot).unwrap();
            let before = simulation.work();
            let _report = pool.install(|| simulation.step()).unwrap();
            let after = simulation.work();
            let work = Work {
                steps: after.steps - before.steps,
                evaluations: after.evaluations - before.evaluations,
                neighbour_visits: after.neighbour_visits - before.neighbour_visits,
            };
            print_work(&format!("{name}, step {} from t = 1", after.steps), &simulation, work);

            group.throughput(Throughput::Elements(work.neighbour_visits));
            let restored = || {
                let mut simulation = pool.install(start);
                simulation.restore(&snapshot[..]).unwrap();
                simulation
            };
            group.bench_function(name, |b| {
                b.iter_batched(
                    restored,
                    |mut simulation| {
                        let _report = pool.install(|| simulation.step()).unwrap();
                        simulation
                    },
                    BatchSize::SmallInput,
                );
            });
        }
    }
    group.finish();
}

/// The density as a function, and a probability from it.
fn observables(criterion: &mut Criterion<CpuTime>, pool: &ThreadPool) {
    let simulation = pool.install(|| at_the_end(flow_map));
    let integral = simulation.cell_integral().unwrap();
    let mut group = criterion.benchmark_group("fpk/viscous damper, observables at 6 s");
    group.bench_function("cell_integral", |b| {
        b.iter(|| pool.install(|| black_box(&simulation).cell_integral()).unwrap());
    });
    group.bench_function("exceedance", |b| {
        b.iter(|| black_box(&integral).exceedance(|x| x[0].abs(), 1.0).unwrap());
    });
    group.finish();
}

fn main() {
    let mut criterion = benches::criterion();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    run(&mut criterion, &pool);
    let paper: Named = ("CanorDenoel2013 50 x 33", paper);
    step(&mut criterion, "viscous damper", &[paper, OURS]);
    step::<BoucWen, 3>(
        &mut criterion,
        "Bouc-Wen",
        &[("FlowMapFit, spacing 0.5", building_flow_map)],
    );
    observables(&mut criterion, &pool);
    criterion.final_summary();
}
