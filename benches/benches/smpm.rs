//! Steps of the material point method on one thread: throughput of each scheme, and cost of derivatives over `f64`.
//!
//! Particle updates per second are compared with the memory roof.
//!
//! The body is a square of 160 000 elastic particles, four per cell, plane strain, that stretches, shears and rotates:
//! every particle moves and some change cells in every step. The roof is a pass that reads and writes the
//! bytes of the particles that a step must read and write: the limit by memory bandwidth. Also with 16 particles per cell,
//! for a cube of 64 000 particles with eight per cell, and by wall time with two threads.
//!
//! The cost of derivatives is measured with Johnson-Cook steel, its five constants random, 40 000 particles, quadratic
//! B-splines; contenders alternate in one process.

#![expect(clippy::unwrap_used, reason = "a run that fails is a mistake of the benchmark")]

use std::hint::black_box;

use benches::ratios::{Ratios, Work};
use perturbation_moments::Jet;
use rayon::ThreadPoolBuilder;
use smpm::material::{
    JohnsonCook, LinearElasticParameters, LinearElasticSolid, MieGruneisen, Model, Solid, Units,
    library,
};
use smpm::{Body, BulkViscosity, Config, Fill, Number, Shape, Simulation, Transfer};

/// Particles along an edge: 160 000 in all.
const EDGE: u32 = 400;
/// Particles along an edge for jets, whose particles hold twenty times the bytes.
const EDGE_OF_JETS: u32 = 200;

/// Particles along an edge of the cube.
const EDGE_IN_SPACE: u32 = 40;
/// Works with threads, and particles along an edge.
const EDGES_OF_THREADS: [(&str, u32); 2] =
    [("wall time, 20 000 particles", 142), ("wall time, 160 000 particles", EDGE)];

/// Shape function and transfer.
const SCHEMES: [(&str, Shape, Transfer); 3] = [
    ("quadratic", Shape::QuadraticBSpline, Transfer::Flip),
    ("quadratic APIC", Shape::QuadraticBSpline, Transfer::Apic),
    ("cubic", Shape::CubicBSpline, Transfer::Flip),
];

fn square<S: Number>(
    (edge, per_axis): (u32, u32),
    material: impl Into<Model<S>>,
    speed: f64,
    (shape, transfer): (Shape, Transfer),
) -> Simulation<S, 2> {
    let spacing = 1.0 / f64::from(edge);
    let cell = f64::from(per_axis) * spacing;
    let fill = Fill::of([spacing; 2], ([0.0; 2], [1.0; 2]), |_| true).unwrap();
    let mut body = Body::new(material, &fill, [0.0; 2]).unwrap();
    body.set_velocities(|[x, y]| {
        let (x, y) = (3.0 * (x - 0.5), 3.0 * (y - 0.5));
        [speed * (1.0 + x.sin() - y), speed * (x - 0.5 * y.sin())]
    })
    .unwrap();
    let viscosity = BulkViscosity { quadratic: 1.5, linear: 0.06 };
    let config = Config { shape, transfer, viscosity, ..Config::with_cell(cell) };
    Simulation::new(config, vec![body]).unwrap()
}

/// Reads and writes `bytes`.
fn roof(bytes: usize) -> impl FnMut() {
    let mut column = vec![1.0_f64; bytes / size_of::<f64>()];
    move || {
        for value in &mut column {
            *value = *value * 0.999 + 0.001;
        }
        black_box(&column);
    }
}

fn elastic() -> LinearElasticSolid<f64> {
    let elastic =
        LinearElasticParameters { density: 1.0, young_modulus: 100.0, poisson_ratio: 0.3 };
    LinearElasticSolid::linear_elastic(elastic).unwrap()
}

/// A cube of elastic particles, eight per cell.
fn cube() -> Simulation<f64, 3> {
    let spacing = 1.0 / f64::from(EDGE_IN_SPACE);
    let fill = Fill::of([spacing; 3], ([0.0; 3], [1.0; 3]), |_| true).unwrap();
    let mut body = Body::new(elastic(), &fill, [0.0; 3]).unwrap();
    body.set_velocities(|[x, y, z]| {
        let (x, y) = (3.0 * (x - 0.5), 3.0 * (y - 0.5));
        [0.1 * (1.0 + x.sin() - y), 0.1 * (x - 0.5 * y.sin()), 0.05 * z]
    })
    .unwrap();
    Simulation::new(Config::with_cell(2.0 * spacing), vec![body]).unwrap()
}

/// Steps of a simulation against reading and writing so many numbers of each particle.
fn against_roof<const D: usize>(
    ratios: &mut Ratios,
    name: &str,
    numbers: usize,
    start: impl FnOnce() -> Simulation<f64, D>,
) {
    if !ratios.wants(name) {
        return;
    }
    let mut simulation = start();
    let n = simulation.bodies()[0].n_particles();
    let _ = simulation.step().unwrap();
    let step = || {
        let _ = black_box(simulation.step().unwrap());
    };
    let roof = roof(n * numbers * size_of::<f64>());
    ratios.measure(Work::new(name, n, "ours", step).rival("memory roof", roof));
}

/// Each scheme; the quadratic one also with more particles per cell, and in space.
fn schemes(ratios: &mut Ratios) {
    // Position, velocity, volume, stress in the plane and its normal, pressure, energy: 2 + 2 + 1 + 4 + 2 numbers.
    for (name, shape, transfer) in SCHEMES {
        let start = || square((EDGE, 2), elastic(), 0.1, (shape, transfer));
        against_roof(ratios, name, 11, start);
    }
    let (_, shape, transfer) = SCHEMES[0];
    let many = || square((EDGE, 4), elastic(), 0.1, (shape, transfer));
    against_roof(ratios, "quadratic, 16 per cell", 11, many);
    // The same in space: 3 + 3 + 1 + 6 + 2 numbers.
    against_roof(ratios, "quadratic in space, 8 per cell", 15, cube);
}

/// Ten steps with one and two threads, from the smallest body for which two are asked to gain on.
fn threads(ratios: &mut Ratios) {
    let by = |n_threads: usize, edge: u32| {
        let pool = ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        let (_, shape, transfer) = SCHEMES[0];
        let mut simulation = square((edge, 2), elastic(), 0.01, (shape, transfer));
        move || {
            pool.install(|| {
                for _ in 0..10 {
                    let _ = black_box(simulation.step().unwrap());
                }
            });
        }
    };
    for (name, edge) in EDGES_OF_THREADS {
        if ratios.wants(name) {
            ratios.wall(name, ["two threads", "one"], 1.7, by(2, edge), by(1, edge));
        }
    }
}

/// Johnson-Cook steel, with `of` applied to its five constants and their numbers.
fn steel<S: Number>(of: impl Fn(f64, usize) -> S) -> Simulation<S, 2> {
    let strength = library::steel_strength(Units::CM_G_US).map(|name, value| {
        match ["a", "b", "n", "c", "m"].iter().position(|&random| random == name) {
            Some(lane) => of(value, lane),
            None => S::constant(value),
        }
    });
    let equation = library::steel_equation(Units::CM_G_US).map(|_, value| S::constant(value));
    let steel = Solid {
        equation: MieGruneisen::new(equation).unwrap(),
        strength: JohnsonCook::new(strength).unwrap(),
    };
    square((EDGE_OF_JETS, 2), steel, 0.01, (Shape::QuadraticBSpline, Transfer::Flip))
}

fn overheads(ratios: &mut Ratios) {
    const DERIVATIVES: &str = "5 derivatives";
    if ratios.wants(DERIVATIVES) {
        let mut plain = steel(|value, _| value);
        let mut jets = steel(Jet::variable);
        let n = plain.bodies()[0].n_particles();
        ratios.measure(
            Work::new(DERIVATIVES, n, "f64", || {
                let _ = black_box(plain.step().unwrap());
            })
            .rival("Jet, first and second", || {
                let _ = black_box(jets.step().unwrap());
            }),
        );
    }
}

fn main() {
    let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let mut ratios = Ratios::from_args("smpm");
        schemes(&mut ratios);
        overheads(&mut ratios);
        threads(&mut ratios);
        ratios.note("for the memory roof the ratio is the part of it that is reached");
        ratios.note("for derivatives the ratio is their overhead over the same run with f64");
        ratios.print();
    });
}
