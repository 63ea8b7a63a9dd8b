//! A step allocates nothing after the first ones: its buffers are those of the simulation. One test alone in its program,
//! since the allocator counts for all threads.

#![expect(clippy::unwrap_used, reason = "a run that fails is a mistake of the test")]

use std::alloc::System;

use cap::Cap;
use fpk_sph::{
    Combination, Config, DEFAULT_MOST_STEPS, InitialLattice, Method, Scheme, Simulation,
};
use sde_integrators::{GaussianMixture, Sde};
use vibrating_systems::{
    BoucWen, BoucWenParameters, LinearOscillatorParameters, ViscousDamper, ViscousDamperParameters,
    Window,
};

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Steps that are counted.
const COUNTED_STEPS: usize = 10;

/// Bytes allocated in [`COUNTED_STEPS`] steps, after as many that are not counted.
fn allocated_by_steps<S: Sde<D, 1>, const D: usize>(simulation: &mut Simulation<S, D, 1>) -> usize {
    let mut steps = || {
        for _ in 0..COUNTED_STEPS {
            let report = simulation.step().unwrap();
            assert_eq!(report.unresolved.particles, 0);
        }
    };
    steps();
    let before = ALLOCATOR.total_allocated();
    steps();
    ALLOCATOR.total_allocated() - before
}

fn damper(method: Method) -> Simulation<ViscousDamper, 2, 1> {
    let structure = LinearOscillatorParameters {
        natural_frequency: std::f64::consts::PI,
        damping_ratio: 0.01,
        noise_intensity: 0.2,
        window: Window::CANOR_DENOEL_2013,
    };
    let (damper_coefficient, damper_exponent) = (0.25, 0.35);
    let parameters = ViscousDamperParameters { structure, damper_coefficient, damper_exponent };
    let system = ViscousDamper::new(parameters).unwrap();
    let law = GaussianMixture::independent([0.0, 0.0], [0.15, 0.10]).unwrap();
    let reference_period = system.period();
    let lattice = InitialLattice::box_of(31);
    let config = Config { method, lattice, reference_period, most_steps: DEFAULT_MOST_STEPS };
    Simulation::new(system, &law, &config).unwrap()
}

fn hysteresis(method: Method) -> Simulation<BoucWen, 3, 1> {
    let system = BoucWen::new(BoucWenParameters::CANOR_DENOEL_2013).unwrap();
    let law = GaussianMixture::independent([0.0; 3], [0.05; 3]).unwrap();
    let reference_period = system.period();
    let lattice = InitialLattice::Ball { reach: 4.0, spacing: 0.7 };
    let config = Config { method, lattice, reference_period, most_steps: DEFAULT_MOST_STEPS };
    Simulation::new(system, &law, &config).unwrap()
}

/// On one thread, since a pool may allocate whenever it likes. The paper's method is left out: its particles clump, and the
/// list of neighbours grows with that.
#[test]
fn a_step_allocates_nothing_after_the_first_ones() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let with =
            |scheme| Method::Custom(Combination { scheme, ..Method::FlowMapFit.combination() });
        for method in [Method::FlowMapFit, with(Scheme::LawsonAdamsBashforth2)] {
            assert_eq!(allocated_by_steps(&mut damper(method)), 0, "{method:?}");
        }
        let negligible = Method::Custom(Combination {
            scheme: Scheme::LawsonAdamsBashforth2,
            negligible: 1e-3,
            ..Method::FlowMapFit.combination()
        });
        for method in [Method::FlowMapFit, negligible] {
            assert_eq!(allocated_by_steps(&mut hysteresis(method)), 0, "{method:?}");
        }
    });
}
