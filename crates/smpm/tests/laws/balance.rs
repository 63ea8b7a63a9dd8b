//! Momentum and energy of all bodies change by what gravity and planes give to them.

use smpm::{Body, Boundary, BoundaryKind, Config, Contact, Ledger, Shape, Simulation, Transfer};

use crate::fixtures::{NO_VISCOSITY, block, elastic, steps, wall};

fn floor(kind: BoundaryKind) -> Boundary {
    Boundary { axis: 1, ..wall(kind) }
}

#[test]
fn momentum_changes_by_the_impulses_of_gravity_and_of_the_planes() {
    let kinds = [
        BoundaryKind::Symmetry,
        BoundaryKind::Clamped,
        BoundaryKind::Rigid { friction: 0.0 },
        BoundaryKind::Rigid { friction: 0.3 },
        BoundaryKind::Absorbing { longitudinal: 10.0, shear: 5.0 },
    ];
    let schemes = [Transfer::Flip, Transfer::Apic].map(|transfer| {
        [(transfer, Contact::Bonded), (transfer, Contact::Friction { coefficient: 0.2 })]
    });
    for (i, left) in kinds.into_iter().enumerate() {
        let below = kinds[(i + 1) % kinds.len()];
        for (transfer, contact) in schemes.into_iter().flatten() {
            // Two blocks in a corner of two planes.
            let body = |low, high, velocity| {
                Body::new(elastic(1.0, 100.0, 0.3), &block(low, high), velocity).unwrap()
            };
            let low = body([0.0, 0.0], [1.0, 0.5], [-0.3, -0.2]);
            let bodies = vec![low, body([0.0, 0.5], [0.5, 1.0], [0.1, -0.4])];
            let config = Config {
                shape: [Shape::QuadraticBSpline, Shape::CubicBSpline][i % 2],
                transfer,
                contact,
                gravity: [0.2, -0.5],
                gravity_history: vec![[0.0, 0.5], [0.2, 1.0]],
                boundaries: vec![wall(left), floor(below)],
                most_energy_growth: f64::MAX,
                ..Config::with_cell(0.1)
            };
            let mut simulation = Simulation::new(config, bodies).unwrap();
            let start = simulation.ledger();
            steps(&mut simulation, 60);
            let (end, external) = (simulation.ledger(), simulation.external());
            for k in 0..2 {
                let planes: f64 = external.reactions.iter().map(|reaction| reaction[k]).sum();
                let change = end.momentum[k] - start.momentum[k];
                let error = change - external.gravity_impulse[k] - planes;
                // Roundoff of 60 steps; seen 3.4e-15, where the planes give 0.05 to 0.4.
                assert!(
                    planes.abs() > 0.05 && error.abs() < 2e-14,
                    "{left:?} {below:?}: {error:e}"
                );
            }
        }
    }
}

fn energy(of: &Ledger<2>) -> f64 {
    of.kinetic + of.internal
}

#[test]
fn a_bar_that_leaves_a_rigid_wall_has_taken_its_momentum_twice() {
    let body = Body::new(elastic(1.0, 100.0, 0.0), &block([0.0; 2], [1.0, 0.2]), [-0.01, 0.0]);
    let boundaries = vec![wall(BoundaryKind::Rigid { friction: 0.0 })];
    let config = Config { boundaries, viscosity: NO_VISCOSITY, ..Config::with_cell(0.1) };
    let mut simulation = Simulation::new(config, vec![body.unwrap()]).unwrap();
    let start = simulation.balance();
    // The wave returns to the wall after 0.2.
    simulation.advance_to(0.3).unwrap();
    let end = simulation.balance();
    let [along, across] = end.external.reactions[0];
    assert!((along - end.held.momentum[0] + start.held.momentum[0]).abs() < 1e-15);
    // Seen 3.6 % less, which stays as vibration; none of the energy is lost but 2.7e-5.
    assert!((along / (2.0 * 0.01 * 0.2) - 1.0).abs() < 0.05 && across.abs() < 1e-15);
    let lost = 1.0 - energy(&end.held) / energy(&start.held);
    assert!(lost.abs() < 1e-4, "{lost:e}");
}

#[test]
fn a_clamped_plane_bears_the_weight_of_a_column() {
    let body = Body::new(elastic(1.0, 1e3, 0.0), &block([0.0; 2], [0.5, 1.0]), [0.0; 2]);
    let config = Config {
        gravity: [0.0, -1.0],
        gravity_history: vec![[0.0, 0.0], [1.0, 1.0]],
        boundaries: vec![floor(BoundaryKind::Clamped)],
        most_energy_growth: f64::MAX,
        ..Config::with_cell(0.1)
    };
    let mut simulation = Simulation::new(config, vec![body.unwrap()]).unwrap();
    let [loaded, end] = [1.0, 1.5].map(|time| {
        simulation.advance_to(time).unwrap();
        simulation.balance()
    });
    let (external, impulse) = (&end.external, end.external.reactions[0][1]);
    // From rest. Seen 2.8e-16.
    let error = end.held.momentum[1] - external.gravity_impulse[1] - impulse;
    assert!(error.abs() < 2e-15, "{error:e}");
    // The mean force over a time under the whole weight, 0.5. Seen 1.1e-4 of it less.
    let force = (impulse - loaded.external.reactions[0][1]) / 0.5;
    assert!((force / 0.5 - 1.0).abs() < 1e-3, "{force}");
    // Seen 0.7 % less than the work of gravity.
    let lost = 1.0 - energy(&end.held) / external.gravity_work;
    assert!(lost.abs() < 0.02, "{lost}");
}
