//! A rigid body that moves the others.

use smpm::{
    Balance, Body, Boundary, BoundaryKind, Config, Contact, Error, Fill, Simulation, Transfer,
};

use crate::fixtures::{NO_VISCOSITY, block, elastic, goes_on_to_the_bit, wall};

/// A piston that moves at -0.1 along the first axis, beside a bar from 0 to 2 whose other end is clamped.
fn pushed(config: Config<2>, n_pistons: usize) -> Result<Simulation<f64, 2>, Error> {
    let body = |low, high, velocity| {
        Body::new(elastic(1.0, 100.0, 0.0), &block(low, high), velocity).unwrap()
    };
    let mut bodies = vec![body([0.0; 2], [2.0, 0.3], [0.0; 2])];
    for _ in 0..n_pistons {
        bodies.push(body([2.0, -0.2], [2.3, 0.5], [-0.1, 0.0]).rigid());
    }
    let boundaries = vec![wall(BoundaryKind::Clamped)];
    Simulation::new(Config { viscosity: NO_VISCOSITY, boundaries, ..config }, bodies)
}

fn with(transfer: Transfer) -> Config<2> {
    let contact = Contact::Friction { coefficient: 0.0 };
    Config { transfer, contact, ..Config::with_cell(0.1) }
}

#[test]
fn a_piston_drives_a_plane_wave() {
    // APIC loses energy, seen 5.1 %; FLIP gains 0.9 %.
    for (transfer, change) in [(Transfer::Flip, 0.03), (Transfer::Apic, 0.1)] {
        let mut simulation = pushed(with(transfer), 1).unwrap();
        let start = simulation.balance();
        // Contact takes two cells of the wave, at 10, to build up; it is at the clamped end at 0.2.
        let [early, end] = [0.08, 0.16].map(|time| {
            simulation.advance_to(time).unwrap();
            simulation.balance()
        });
        let piston = &simulation.bodies()[1];
        let off = |p: usize| (piston.velocity(p)[0] + 0.1).hypot(piston.velocity(p)[1]);
        // Roundoff of 20 steps.
        assert!((0..piston.n_particles()).all(|p| off(p) < 1e-15));
        let energy = |of: &Balance<2>| of.held.kinetic + of.held.internal;
        let gained = (energy(&end) - energy(&start)) / end.external.rigid_work;
        let given = end.external.rigid_impulse[0] - early.external.rigid_impulse[0];
        let bar = &simulation.bodies()[0];
        let behind: Vec<usize> =
            (0..bar.n_particles()).filter(|&p| (1.0..1.6).contains(&bar.position(p)[0])).collect();
        let stress = behind.iter().map(|&p| bar.stress(p).0[0]).sum::<f64>() / behind.len() as f64;
        // rho c V = 1, over the width. Seen 2.4 % more by FLIP, 1.0 % less by APIC.
        let force = given / (-0.3 * 0.08);
        assert!((force - 1.0).abs() < 0.05, "{transfer:?}: {force}");
        // Seen 6.0 and 1.3 % less, with a front of some cells in three across.
        assert!((stress + 1.0).abs() < 0.1, "{transfer:?}: {stress}");
        assert!((gained - 1.0).abs() < change, "{transfer:?}: {gained}");
    }
}

/// The change of the half width of the foot of a block that falls on a floor, and how far above the floor its lowest particles are.
fn fallen(on_a_body: bool, cell: f64) -> [f64; 2] {
    let spacing = [0.5 * cell; 2];
    let fill = |low, high| Fill::of(spacing, (low, high), |_| true).unwrap();
    let material = || elastic(1.0, 10.0, 0.3);
    let foot = fill([0.0; 2], [0.5, 1.0]);
    let mut bodies = vec![Body::new(material(), &foot, [0.0, -0.5]).unwrap()];
    let mut boundaries = vec![wall(BoundaryKind::Symmetry)];
    if on_a_body {
        let floor = fill([0.0, -0.5], [1.5, 0.0]);
        bodies.push(Body::new(material(), &floor, [0.0; 2]).unwrap().rigid());
    } else {
        let kind = BoundaryKind::Rigid { friction: 0.0 };
        boundaries.push(Boundary { axis: 1, ..wall(kind) });
    }
    let contact = Contact::Friction { coefficient: 0.0 };
    let config = Config { contact, boundaries, ..Config::with_cell(cell) };
    let mut simulation = Simulation::new(config, bodies).unwrap();
    simulation.advance_to(0.2).unwrap();
    let body = &simulation.bodies()[0];
    let lowest = |p: &usize| foot.positions[*p][1] < 0.5 * cell;
    let rim = (0..body.n_particles())
        .filter(lowest)
        .max_by(|&a, &b| foot.positions[a][0].total_cmp(&foot.positions[b][0]));
    let rim = rim.unwrap();
    let low = (0..body.n_particles()).map(|p| body.position(p)[1]).fold(1.0, f64::min);
    [body.position(rim)[0] - foot.positions[rim][0], low]
}

#[test]
fn the_foot_of_a_block_spreads_on_a_rigid_body_as_on_a_rigid_plane() {
    // Seen 5.1 and 1.9 % less, and as far above the floor within 0.5 and 1.9 %.
    for (cell, change) in [(0.1, 0.1), (0.05, 0.04)] {
        let [[plane, above_plane], [body, above_body]] = [false, true].map(|it| fallen(it, cell));
        assert!((body / plane - 1.0).abs() < change, "{cell}: {plane} {body}");
        assert!((above_body / above_plane - 1.0).abs() < 0.05, "{cell}: {above_body}");
    }
}

#[test]
fn a_pushed_bar_goes_on_to_the_bit() {
    goes_on_to_the_bit(|| pushed(with(Transfer::Flip), 1).unwrap(), [5, 12]);
}

#[test]
fn a_rigid_body_needs_contact_and_is_the_only_one() {
    let bonded = Config { contact: Contact::Bonded, ..with(Transfer::Flip) };
    assert_eq!(pushed(bonded, 1).unwrap_err(), Error::RigidAlone);
    assert_eq!(pushed(with(Transfer::Flip), 2).unwrap_err(), Error::RigidAlone);
}
