//! A plate that runs into a rigid wall, in uniaxial strain: the shock states of the material's Hugoniot, and their derivative.

use perturbation_moments::Jet;
use smpm::material::library::steel_equation;
use smpm::material::{Fluid, MieGruneisen, Solid, Units};
use smpm::{
    Body, Boundary, BoundaryKind, BulkViscosity, Config, Fill, Number, Side, Simulation, Transfer,
};

use crate::fixtures::wall;

/// Mean and standard deviation of the pressure, over its exact value, between the wall and the front.
struct Plateau<S> {
    pressure: S,
    ripple: f64,
}

/// Centimetres, grams, microseconds. The plate stops at the wall: the particle velocity of the shock is its speed.
fn plateau<S: Number>(
    speed: f64,
    slope: S,
    wall: Boundary,
    change: impl FnOnce(&mut Config<1>),
) -> Plateau<S> {
    let parameters = steel_equation(Units::CM_G_US)
        .map(|name, value| if name == "s1" { slope } else { S::constant(value) });
    let steel = Solid { equation: MieGruneisen::new(parameters).unwrap(), strength: Fluid };
    let (inward, ends) = match wall.side {
        Side::Above => (1.0, ([0.0], [8.0])),
        Side::Below => (-1.0, ([-8.0], [0.0])),
    };
    let mut config = Config { boundaries: vec![wall], ..Config::with_cell(0.1) };
    change(&mut config);
    let fill = Fill::of([0.5 * config.cell], ends, |_| true).unwrap();
    let body = Body::new(steel, &fill, [-inward * speed]).unwrap();
    let mut simulation = Simulation::new(config, vec![body]).unwrap();
    simulation.advance_to(8.0).unwrap();
    let body = &simulation.bodies()[0];
    let window: Vec<S> = (0..body.n_particles())
        .filter(|&p| (0.5..2.5).contains(&(inward * body.positions()[p][0].value())))
        .map(|p| body.pressure(p))
        .collect();
    let n = window.len() as f64;
    let mean = window.iter().fold(S::constant(0.0), |sum, &p| sum + p) * (1.0 / n);
    let spread = window.iter().map(|p| (p.value() - mean.value()).powi(2)).sum::<f64>() / n;
    Plateau { pressure: mean, ripple: spread.sqrt() / mean.value() }
}

/// `p = rho_0 (C + S_1 u) u`.
fn hugoniot(speed: f64) -> f64 {
    let steel = steel_equation(Units::CM_G_US);
    steel.density * (steel.sound_speed + steel.s1 * speed) * speed
}

const SPEEDS: [f64; 3] = [0.01, 0.1, 0.2];

fn viscosity(linear: f64) -> BulkViscosity {
    BulkViscosity { quadratic: 1.5, linear }
}

#[test]
fn the_shock_state_is_that_of_the_hugoniot() {
    let below = |wall: Boundary| Boundary { side: Side::Below, ..wall };
    let (symmetry, rigid) =
        (wall(BoundaryKind::Symmetry), wall(BoundaryKind::Rigid { friction: 0.0 }));
    // Behind a rigid wall the oscillation was measured at 4.2 %.
    for (wall, transfer, most) in [
        (symmetry, Transfer::Flip, 0.04),
        (symmetry, Transfer::Apic, 0.04),
        (rigid, Transfer::Flip, 0.05),
        (below(rigid), Transfer::Flip, 0.05),
    ] {
        for speed in SPEEDS {
            let seen = plateau(speed, steel_equation(Units::CM_G_US).s1, wall, |config| {
                (config.transfer, config.viscosity) = (transfer, viscosity(0.3));
            });
            let what = format!("{wall:?}, {transfer:?} at {speed}");
            let error = seen.pressure / hugoniot(speed) - 1.0;
            // The mean over two centimetres of an oscillation of 3 %; seen within 0.42 %.
            assert!(error.abs() < 5e-3, "{what}: {error}");
            assert!(seen.ripple < most, "{what}: post-shock oscillation {}", seen.ripple);
        }
    }
}

/// Linear in `S_1`: `dp/dS_1 = rho_0 u^2`. Derivatives at the frozen state give 2.0 to 2.3 times that.
#[test]
fn the_carried_derivative_is_that_of_the_hugoniot() {
    let steel = steel_equation(Units::CM_G_US);
    for speed in SPEEDS {
        let wall = wall(BoundaryKind::Symmetry);
        let seen = plateau(speed, Jet::variable(steel.s1, 0), wall, |config| {
            (config.transfer, config.viscosity) = (Transfer::Apic, viscosity(1.0));
        });
        let error = seen.pressure.first[0] / (steel.density * speed * speed) - 1.0;
        // The phase of the oscillation moves with the parameter: what is left of it in the mean over two centimetres at one time.
        // It was measured within 4.6 %.
        assert!(error.abs() < 0.06, "at {speed}: {error}");
        assert!((seen.pressure.value / hugoniot(speed) - 1.0).abs() < 5e-3, "at {speed}");
    }
}
