//! A step after the first allocates nothing.

#![allow(clippy::unwrap_used, reason = "what is given lies within its range")]

use std::alloc::System;

use cap::Cap;
use perturbation_moments::Jet;
use smpm::material::{JohnsonCook, MieGruneisen, Solid, Units, library};
use smpm::{Body, Config, Contact, Fill, Number, Shape, Simulation, Transfer};

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Two blocks of steel that meet.
fn blocks<S: Number>(change: impl FnOnce(&mut Config<2>)) -> Simulation<S, 2> {
    let block = |low: [f64; 2], high: [f64; 2], speed: f64| {
        let strength = library::steel_strength(Units::CM_G_US).map(|_, value| S::constant(value));
        let equation = library::steel_equation(Units::CM_G_US).map(|_, value| S::constant(value));
        let steel = Solid {
            equation: MieGruneisen::new(equation).unwrap(),
            strength: JohnsonCook::new(strength).unwrap(),
        };
        let fill = Fill::of([0.05, 0.05], (low, high), |_| true).unwrap();
        Body::new(steel, &fill, [speed, 0.0]).unwrap()
    };
    let bodies =
        vec![block([0.23, 0.23], [1.23, 1.23], 0.02), block([1.23, 0.23], [2.23, 1.23], -0.02)];
    let mut config = Config::with_cell(0.1);
    change(&mut config);
    Simulation::new(config, bodies).unwrap()
}

/// Bytes that ten steps allocate after a first one, freed again or not. The blocks stay within their tiles.
fn of_ten_steps<S: Number>(change: impl FnOnce(&mut Config<2>)) -> usize {
    let mut simulation = blocks::<S>(change);
    let _ = simulation.step().unwrap();
    let before = ALLOCATOR.total_allocated();
    for _ in 0..10 {
        let _ = simulation.step().unwrap();
    }
    ALLOCATOR.total_allocated() - before
}

/// One thread: a pool may allocate whenever it likes.
fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        assert_eq!(of_ten_steps::<f64>(|_| ()), 0);
        assert_eq!(of_ten_steps::<f64>(|config| config.shape = Shape::CubicBSpline), 0);
        assert_eq!(of_ten_steps::<f64>(|config| config.transfer = Transfer::Apic), 0);
        let contact = Contact::Friction { coefficient: 0.3 };
        assert_eq!(of_ten_steps::<f64>(|config| config.contact = contact), 0);
        assert_eq!(of_ten_steps::<Jet>(|_| ()), 0);
        // The count is no constant.
        let before = ALLOCATOR.total_allocated();
        let simulation = blocks::<f64>(|_| ());
        assert!(ALLOCATOR.total_allocated() > before + 800 * simulation.bodies().len());
    });
}
