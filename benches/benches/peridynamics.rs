//! Forces of breakable bonds by every fast path of peridyn-sde, at every register width, and complete Langevin steps.
//!
//! There are two bodies: a block of 31 nodes per side, that of `benches/rivals/lammps_peridynamics.py`, and a plate of
//! 100 x 100 nodes. The horizon is 3.015 spacings, strains are about 1e-4, no bond breaks. An element is a bond,
//! counted once, in one realisation, on one thread.
//!
//! Paths named `solid` are those of the linear peridynamic solid: dilatation of each node, then forces.
//!
//! A step is one of the Leimkuhler-Matthews method at z = 1 with unit mobility: forces, test of every bond, new
//! normals for every component of every node, update, test for non-finite numbers. The same step at `kT = 0` draws no
//! normals; the difference is the share of noise.
//!
//! `cargo bench -p benches --bench peridynamics -- rates` prints a line `<path>: <number> M bonds/s` for each path at
//! the widest registers, which the script of the rival reads, and a line with the share of noise for each step.

#![expect(clippy::unwrap_used, reason = "a run that fails is a mistake of the benchmark")]

use std::hint::black_box;
use std::io::Write;
use std::time::Duration;

use benches::CpuTime;
use cpu_time::ProcessTime;
use criterion::{Criterion, Throughput};
use peridyn_sde::{
    AtStrength, Body, BondConfig, BondList, Bonds, Breaking, Condition, Dynamics, Horizon,
    LatticeBody, Loading, Mobility, Nodes, Real, Scheme, Simulation, SimulationConfig, SolidBonds,
    Strain,
};
use rayon::ThreadPoolBuilder;
use sde_integrators::{Noise, Purpose, SimdLevel};

/// Nodes along an edge: of the rival's block, and of a plate.
const BLOCK: u32 = 31;
const PLATE: u32 = 100;
/// Nodes along an edge without measurement.
const SMALL: u32 = 8;

const STRENGTH: f64 = 0.01;
/// Of the linear peridynamic solid.
const POISSON_RATIO: f64 = 0.2;
/// Standard deviation of the bond stretch by noise, for equal bonds.
const NOISE: f64 = 1e-4;

/// Repetitions of a path, whose median is its rate, and the CPU time of each.
const ROUNDS: usize = 9;
const SAMPLE: Duration = Duration::from_millis(100);

/// A path to run, with its number of bonds.
struct Path {
    name: String,
    n_bonds: usize,
    run: Box<dyn FnMut()>,
}

struct Shape<const D: usize> {
    name: &'static str,
    nodes: Nodes<D>,
    bonds: Bonds,
    solid: SolidBonds,
}

impl<const D: usize> Shape<D> {
    fn new(name: &'static str, edge: u32, condition: Condition) -> Self {
        let nodes =
            Nodes::lattice(1.0, ([0.0; D], [f64::from(edge); D]), condition, |_| true).unwrap();
        let config = BondConfig::uncorrected(Horizon::of_shells(3, 1.0).unwrap(), 1.0);
        let bonds = Bonds::new(&nodes, &config).unwrap();
        let solid = SolidBonds::new(&nodes, &config, POISSON_RATIO).unwrap();
        Self { name, nodes, bonds, solid }
    }

    fn lattice<T: Real>(&self, level: SimdLevel) -> LatticeBody<T, D> {
        let (nodes, bonds) = (self.nodes.clone(), self.bonds.clone());
        LatticeBody::new(nodes, bonds, Strain::Finite, STRENGTH).unwrap().at_level(level)
    }

    fn solid_lattice<T: Real>(&self, level: SimdLevel) -> LatticeBody<T, D> {
        let (nodes, solid) = (self.nodes.clone(), self.solid.clone());
        LatticeBody::of_solid(nodes, solid, Strain::Finite, STRENGTH).unwrap().at_level(level)
    }

    fn solid_list<T: Real, const L: usize>(&self, level: SimdLevel) -> BondList<T, D, L> {
        let strengths = vec![STRENGTH; self.bonds.len()];
        let (nodes, solid) = (self.nodes.clone(), self.solid.clone());
        BondList::of_solid(nodes, solid, Strain::Finite, &strengths).unwrap().at_level(level)
    }

    fn list<T: Real, const L: usize>(&self, level: SimdLevel) -> BondList<T, D, L> {
        let strengths = vec![STRENGTH; self.bonds.len()];
        let (nodes, bonds) = (self.nodes.clone(), self.bonds.clone());
        BondList::new(nodes, bonds, Strain::Finite, &strengths).unwrap().at_level(level)
    }

    /// Computes the forces of a body repeatedly from the same displacements.
    fn forces<T: Real, const L: usize>(
        &self,
        name: &str,
        level: SimdLevel,
        mut body: impl Body<T, D, L> + 'static,
    ) -> Path {
        let mut normals = vec![0.0; self.nodes.positions().len() * D * L];
        Noise::new(1).stream(Purpose::Field, 0).fill_normal(&mut normals);
        let u: Vec<T> = normals.iter().map(|z| T::of(3e-5 * z)).collect();
        let mut forces = vec![T::ZERO; u.len()];
        let name = format!("{} {name} {} {level}", self.name, T::NAME);
        let mut broken = Vec::new();
        let run = move || {
            let at = AtStrength::Break(&mut broken);
            body.forces(black_box(&u), &mut forces, at).unwrap();
            assert!(broken.is_empty());
        };
        Path { name, n_bonds: self.bonds.len() * L, run: Box::new(run) }
    }

    /// Each path at a level, created on demand.
    fn paths(&self, level: SimdLevel) -> impl Iterator<Item = Path> {
        (0..12).map(move |which| match which {
            0 => self.forces("lattice", level, self.lattice::<f64>(level)),
            1 => self.forces("lattice", level, self.lattice::<f32>(level)),
            2 => self.forces("list", level, self.list::<f64, 1>(level)),
            3 => self.forces("list", level, self.list::<f32, 1>(level)),
            4 => self.forces("ensemble of 8", level, self.list::<f64, 8>(level)),
            5 => self.forces("ensemble of 16", level, self.list::<f32, 16>(level)),
            6 => self.forces("solid lattice", level, self.solid_lattice::<f64>(level)),
            7 => self.forces("solid lattice", level, self.solid_lattice::<f32>(level)),
            8 => self.forces("solid ensemble of 8", level, self.solid_list::<f64, 8>(level)),
            9 => self.forces("solid ensemble of 16", level, self.solid_list::<f32, 16>(level)),
            10 => self.forces("solid list", level, self.solid_list::<f64, 1>(level)),
            _ => self.forces("solid list", level, self.solid_list::<f32, 1>(level)),
        })
    }
}

/// Whether a step has noise.
#[derive(Clone, Copy, PartialEq)]
enum Noisy {
    Yes,
    No,
}

impl<const D: usize> Shape<D> {
    /// A step of a body, which continues from the previous one.
    fn step<T: Real, B: Body<T, D, L> + 'static, const L: usize>(
        &self,
        name: &str,
        body: impl Fn() -> B,
        noisy: Noisy,
    ) -> Path {
        let n_nodes = self.nodes.positions().len();
        let share = self.bonds.len() as f64 / (n_nodes * D) as f64;
        let temperature = match noisy {
            Noisy::Yes => NOISE * NOISE * self.bonds.all()[0].stiffness * share,
            Noisy::No => 0.0,
        };
        let mobility = Mobility::identity(&vec![true; n_nodes], 1.0).unwrap();
        let scheme = Scheme::LeimkuhlerMatthews;
        let simulation = |dt: f64| {
            let config = SimulationConfig {
                dynamics: Dynamics::Overdamped { mobility: mobility.clone(), temperature, scheme },
                dt,
                breaking: Breaking::AtEnds,
                confinement: 0.0,
                noise: Noise::new(1),
            };
            let ids = std::array::from_fn(|lane| lane as u64);
            Simulation::new(body(), Loading::new(n_nodes), config, ids).unwrap()
        };
        let small = 1e-9;
        let mut run = simulation(small / simulation(small).relative_step());
        let what = if noisy == Noisy::Yes { "step" } else { "step without noise" };
        let name = format!("{} {what} {name} {} {}", self.name, T::NAME, SimdLevel::best());
        let step = move || assert!(run.step().unwrap().broken.is_empty());
        Path { name, n_bonds: self.bonds.len() * L, run: Box::new(step) }
    }

    /// Complete steps at the widest registers, created on demand.
    fn steps(&self, noisy: Noisy) -> impl Iterator<Item = Path> {
        let best = SimdLevel::best();
        (0..4).map(move |which| match which {
            0 => self.step("lattice", || self.lattice::<f64>(best), noisy),
            1 => self.step("list", || self.list::<f64, 1>(best), noisy),
            2 => self.step("ensemble of 8", || self.list::<f64, 8>(best), noisy),
            _ => self.step("ensemble of 16", || self.list::<f32, 16>(best), noisy),
        })
    }
}

fn is_given(option: &str) -> bool {
    std::env::args().any(|argument| argument == option)
}

fn shapes() -> (Shape<3>, Shape<2>) {
    let is_measured = is_given("--bench") && !is_given("--test") && !is_given("--list");
    let edge = |edge: u32| if is_measured { edge } else { SMALL };
    let plane = Condition::PlaneStress { thickness: 1.0 };
    (Shape::new("block", edge(BLOCK), Condition::Solid), Shape::new("plate", edge(PLATE), plane))
}

fn forces(criterion: &mut Criterion<CpuTime>) {
    let (block, plate) = shapes();
    let mut group = criterion.benchmark_group("forces");
    for level in SimdLevel::available() {
        for mut path in block.paths(level).chain(plate.paths(level)) {
            group.throughput(Throughput::Elements(path.n_bonds as u64));
            group.bench_function(&path.name, |b| b.iter(&mut path.run));
        }
    }
    group.finish();
}

fn steps(criterion: &mut Criterion<CpuTime>) {
    let (block, plate) = shapes();
    let mut group = criterion.benchmark_group("steps");
    for noisy in [Noisy::Yes, Noisy::No] {
        for mut path in block.steps(noisy).chain(plate.steps(noisy)) {
            group.throughput(Throughput::Elements(path.n_bonds as u64));
            group.bench_function(&path.name, |b| b.iter(&mut path.run));
        }
    }
    group.finish();
}

/// Bonds per CPU second, the median of the rounds.
fn rate(path: &mut Path) -> f64 {
    let mut repetitions = 1_u32;
    let mut seconds = |repetitions: u32| {
        let start = ProcessTime::now();
        for _ in 0..repetitions {
            (path.run)();
        }
        start.elapsed().as_secs_f64()
    };
    while seconds(repetitions) < SAMPLE.as_secs_f64() {
        repetitions *= 2;
    }
    let mut rounds: Vec<f64> =
        (0..ROUNDS).map(|_| seconds(repetitions) / f64::from(repetitions)).collect();
    rounds.sort_unstable_by(f64::total_cmp);
    path.n_bonds as f64 / rounds[ROUNDS / 2]
}

fn say(line: &str) {
    // A closed output needs no rates.
    let _ = std::io::stdout().write_all(line.as_bytes());
}

fn rates() {
    let (block, plate) = shapes();
    let best = SimdLevel::best();
    let told = |path: &mut Path| {
        let rate = rate(path);
        say(&format!("{}: {:.1} M bonds/s\n", path.name, 1e-6 * rate));
        rate
    };
    for mut path in block.paths(best).chain(plate.paths(best)) {
        told(&mut path);
    }
    let noisy = block.steps(Noisy::Yes).chain(plate.steps(Noisy::Yes));
    let still = block.steps(Noisy::No).chain(plate.steps(Noisy::No));
    for (mut noisy, mut still) in noisy.zip(still) {
        let share = 1.0 - told(&mut noisy) / told(&mut still);
        say(&format!("{}: {:.1} % of it is noise\n", noisy.name, 100.0 * share));
    }
}

fn main() {
    let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        if is_given("rates") {
            rates();
            return;
        }
        let mut criterion = benches::criterion();
        forces(&mut criterion);
        steps(&mut criterion);
        criterion.final_summary();
    });
}
