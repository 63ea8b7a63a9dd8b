//! What several laws start from.

use smpm::material::{LinearElasticParameters, LinearElasticSolid};
use smpm::{Boundary, BoundaryKind, BulkViscosity, Fill, Number, Side, Simulation};

pub(crate) const NO_VISCOSITY: BulkViscosity = BulkViscosity { quadratic: 0.0, linear: 0.0 };

pub(crate) fn elastic(
    density: f64,
    young_modulus: f64,
    poisson_ratio: f64,
) -> LinearElasticSolid<f64> {
    let parameters = LinearElasticParameters { density, young_modulus, poisson_ratio };
    LinearElasticSolid::linear_elastic(parameters).unwrap()
}

/// A block of particles 0.05 apart.
pub(crate) fn block(low: [f64; 2], high: [f64; 2]) -> Fill<2> {
    Fill::of([0.05; 2], (low, high), |_| true).unwrap()
}

/// The plane `x = 0`, with bodies above it.
pub(crate) fn wall(kind: BoundaryKind) -> Boundary {
    Boundary { axis: 0, position: 0.0, side: Side::Above, kind }
}

pub(crate) fn steps<S: Number>(simulation: &mut Simulation<S, 2>, n: usize) {
    for _ in 0..n {
        let _ = simulation.step().unwrap();
    }
}

/// All numbers of all particles, in bits.
pub(crate) fn bits<S: Number>(simulation: &Simulation<S, 2>) -> Vec<u64> {
    let mut bits = vec![simulation.time().to_bits(), simulation.longest_step().to_bits()];
    for body in simulation.bodies() {
        for p in 0..body.n_particles() {
            let observed = body.observe(p);
            let (x, v, stress) = (body.position(p), body.velocity(p), body.stress(p).0);
            let numbers = x.into_iter().chain(v).chain(stress).chain([
                body.volume_ratio(p),
                body.density(p),
                body.masses()[p],
                observed.energy,
                observed.plastic_strain,
                observed.temperature,
                observed.damage,
                observed.overshoot,
            ]);
            for number in numbers {
                bits.extend((0..S::PARTS).map(|part| number.part(part).to_bits()));
            }
        }
    }
    bits
}

/// A run of so many steps in one go, and one that stops after some of them and goes on elsewhere, on each number of threads.
pub(crate) fn goes_on_to_the_bit<S: Number>(
    new: impl Fn() -> Simulation<S, 2> + Sync,
    [some, all]: [usize; 2],
) {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (mut whole, mut other, mut snapshot) = (new(), new(), vec![]);
            steps(&mut whole, some);
            whole.snapshot(&mut snapshot).unwrap();
            steps(&mut whole, all - some);
            other.restore(snapshot.as_slice()).unwrap();
            assert_eq!(other.n_steps(), some as u64);
            steps(&mut other, all - some);
            assert!(bits(&whole) == bits(&other), "{threads} threads");
            bits(&whole)
        })
    };
    let one = run(1);
    assert!(run(2) == one && run(8) == one);
}
