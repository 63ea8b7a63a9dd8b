//! What every run must keep, whatever the material: mass, momentum, symmetry; and what is refused.

use perturbation_moments::Jet;
use smpm::material::{LinearElasticParameters, LinearElasticSolid};
use smpm::{
    Body, Boundary, BoundaryKind, Config, Error, Fill, Geometry, Number, ParameterError, Shape,
    Side, Simulation, Transfer,
};

use crate::fixtures::{NO_VISCOSITY, block, elastic, wall};

/// `E = 100, nu = 0, rho = 1`: waves at 10.
fn rod<S: Number>(scale: S) -> LinearElasticSolid<S> {
    let (density, poisson_ratio) = (S::constant(1.0), S::constant(0.0));
    let elastic = LinearElasticParameters { density, young_modulus: scale * 100.0, poisson_ratio };
    LinearElasticSolid::linear_elastic(elastic).unwrap()
}

fn clamped(axis: usize, position: f64, side: Side) -> Boundary {
    Boundary { axis, position, side, kind: BoundaryKind::Clamped }
}

/// A bar between clamped ends in its first mode, `v = v_0 sin(pi x / L)`, after half a period.
fn bar(shape: Shape, n_cells: u32) -> Simulation<f64, 1> {
    let cell = 1.0 / f64::from(n_cells);
    let fill = Fill::of([0.5 * cell], ([0.0], [1.0]), |_| true).unwrap();
    let mut body = Body::new(rod(1.0), &fill, [0.0]).unwrap();
    body.set_velocities(|x| [1e-4 * (std::f64::consts::PI * x[0]).sin()]).unwrap();
    let config = Config {
        shape,
        viscosity: NO_VISCOSITY,
        boundaries: vec![clamped(0, 0.0, Side::Above), clamped(0, 1.0, Side::Below)],
        ..Config::with_cell(cell)
    };
    let mut simulation = Simulation::new(config, vec![body]).unwrap();
    simulation.advance_to(0.1).unwrap();
    simulation
}

#[test]
fn a_clamped_bar_comes_back_with_the_opposite_velocity_at_second_order() {
    for shape in [Shape::QuadraticBSpline, Shape::CubicBSpline] {
        let error = |n_cells: u32| {
            let simulation = bar(shape, n_cells);
            let body = &simulation.bodies()[0];
            let worst = |(x, v): (&[f64; 1], &[f64; 1])| {
                (v[0] / 1e-4 + (std::f64::consts::PI * x[0]).sin()).abs()
            };
            body.positions().iter().zip(body.velocities()).map(worst).fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(20), error(40));
        assert!(fine < 0.02 && fine < 0.35 * coarse, "{shape:?}: {coarse} then {fine}");
    }
}

/// Two blocks that meet, in two dimensions.
fn blocks(change: impl FnOnce(&mut Config<2>)) -> Simulation<f64, 2> {
    let body = |low, high, velocity| Body::new(rod(1.0), &block(low, high), velocity).unwrap();
    let bodies = vec![
        body([0.0, -0.5], [1.0, 0.5], [0.2, 0.01]),
        body([1.0, -0.5], [1.5, 0.5], [-0.1, 0.0]),
    ];
    let mut config = Config { viscosity: NO_VISCOSITY, ..Config::with_cell(0.1) };
    change(&mut config);
    Simulation::new(config, bodies).unwrap()
}

#[test]
fn mass_and_momentum_are_conserved_by_every_shape_and_transfer() {
    for shape in [Shape::QuadraticBSpline, Shape::CubicBSpline] {
        for transfer in [Transfer::Flip, Transfer::Apic] {
            let mut simulation =
                blocks(|config| (config.shape, config.transfer) = (shape, transfer));
            let before = simulation.ledger();
            for _ in 0..30 {
                let _ = simulation.step().unwrap();
            }
            let after = simulation.ledger();
            let what = format!("{shape:?} {transfer:?}");
            assert!((after.mass - before.mass).abs() < 1e-14, "{what}");
            for k in 0..2 {
                // Roundoff of 600 particles and their nodes over 30 steps.
                let change = after.momentum[k] - before.momentum[k];
                assert!(change.abs() < 1e-12, "{what}: {change}");
            }
            let growth = (after.kinetic + after.internal) / before.kinetic;
            assert!(growth < 1.01, "{what}: {growth}");
        }
    }
}

/// The velocity gained is the integral of the history, exact by the midpoint of each step where its points are ends of steps; the
/// place that a run resumes from does not matter.
#[test]
fn gravity_follows_its_history() {
    // A multiple that grows, stays, jumps and stays: 0.5, 0.5 and -0.25 in all.
    let history = vec![[0.1, 0.0], [1.1, 1.0], [1.6, 1.0], [1.6, -0.5], [2.1, -0.5], [2.1, 0.0]];
    let falling = || {
        let body = Body::new(elastic(1.0, 100.0, 0.3), &block([0.0; 2], [1.0, 0.5]), [0.0; 2]);
        let (gravity, gravity_history) = ([0.2, -0.4], history.clone());
        let config = Config { gravity, gravity_history, ..Config::with_cell(0.1) };
        Simulation::new(config, vec![body.unwrap()]).unwrap()
    };
    let before = falling().ledger();
    let mut run = falling();
    let mut kept = Vec::new();
    for step in 1..=460 {
        let _ = run.step_of(0.005).unwrap();
        if step == 100 {
            run.snapshot(&mut kept).unwrap();
        }
        let gained = match step {
            20 => 0.0,
            120 => 0.125,
            220 => 0.5,
            320 => 1.0,
            420 | 460 => 0.75,
            _ => continue,
        };
        for (k, along) in [0.2, -0.4].into_iter().enumerate() {
            let momentum = run.ledger().momentum[k] - before.momentum[k];
            // Roundoff of 200 particles over some hundred steps.
            assert!((momentum / before.mass - along * gained).abs() < 1e-12, "{step}: {momentum}");
        }
    }
    let mut resumed = falling();
    resumed.restore(&kept[..]).unwrap();
    for _ in 100..460 {
        let _ = resumed.step_of(0.005).unwrap();
    }
    assert_eq!(resumed.balance(), run.balance());
    let plain = blocks(|config| config.gravity = [0.2, -0.4]);
    let bits = |of: [f64; 2]| of.map(f64::to_bits);
    assert_eq!(bits(plain.config().gravity_at(3.0)), bits([0.2, -0.4]));
}

#[test]
fn half_a_body_at_a_plane_of_symmetry_moves_as_the_whole_does() {
    let part = |low: f64| {
        let fill = block([0.0, low], [1.0, 0.5]);
        let mut body = Body::new(rod(1.0), &fill, [0.0; 2]).unwrap();
        body.set_velocities(|x| [0.1 * x[1] * x[1], -0.3 * x[1]]).unwrap();
        body
    };
    for shape in [Shape::QuadraticBSpline, Shape::CubicBSpline] {
        let config = Config { shape, viscosity: NO_VISCOSITY, ..Config::with_cell(0.1) };
        let mut whole = Simulation::new(config.clone(), vec![part(-0.5)]).unwrap();
        let symmetry = Boundary { axis: 1, ..wall(BoundaryKind::Symmetry) };
        let config = Config { boundaries: vec![symmetry], ..config };
        let mut half = Simulation::new(config, vec![part(0.0)]).unwrap();
        for _ in 0..40 {
            let dt = whole.longest_step();
            let _ = whole.step_of(dt).unwrap();
            let _ = half.step_of(dt).unwrap();
        }
        let (whole, half) = (&whole.bodies()[0], &half.bodies()[0]);
        let upper = whole.positions().iter().zip(whole.velocities()).filter(|(x, _)| x[1] > 0.0);
        let mut compared = 0;
        for ((x, v), (y, w)) in upper.zip(half.positions().iter().zip(half.velocities())) {
            for k in 0..2 {
                assert!((x[k] - y[k]).abs() < 1e-11, "{shape:?}: {x:?} {y:?}");
                assert!((v[k] - w[k]).abs() < 1e-10, "{shape:?}: {v:?} {w:?}");
            }
            compared += 1;
        }
        assert_eq!(compared, 200);
    }
}

/// Bodies of few particles that turn and drift across cells: `f64` in lanes, jets one particle at a time.
#[test]
fn particles_in_lanes_move_as_they_do_one_by_one() {
    fn bodies<S: Number>(n: u32, config: &Config<2>) -> Simulation<S, 2> {
        let place = |i: u32| [0.5 * f64::from(i % 5) + 5.13, 0.5 * f64::from(i / 5) + 6.21];
        let fill = Fill { positions: (0..n).map(place).collect(), spacing: [0.5; 2] };
        let mut body = Body::new(rod(S::constant(1.0)), &fill, [0.0; 2]).unwrap();
        body.set_velocities(|[x, y]| [1.0 - 0.3 * (y - 7.0), 0.7 + 0.3 * (x - 6.0)]).unwrap();
        Simulation::new(config.clone(), vec![body]).unwrap()
    }
    for shape in [Shape::QuadraticBSpline, Shape::CubicBSpline] {
        for transfer in [Transfer::Flip, Transfer::Apic] {
            for n in [1, 3, 4, 37] {
                let most_energy_growth = 10.0;
                let config =
                    Config { shape, transfer, most_energy_growth, ..Config::with_cell(1.0) };
                let (mut lanes, mut alone) = (bodies::<f64>(n, &config), bodies::<Jet>(n, &config));
                for _ in 0..15 {
                    let dt = lanes.longest_step();
                    let _ = (lanes.step_of(dt).unwrap(), alone.step_of(dt).unwrap());
                }
                let (lanes, alone) = (&lanes.bodies()[0], &alone.bodies()[0]);
                let all = |body: &dyn Fn(usize, usize) -> [f64; 2]| -> Vec<f64> {
                    (0..n as usize).flat_map(|p| (0..2).flat_map(move |k| body(p, k))).collect()
                };
                let lanes = all(&|p, k| [lanes.position(p)[k], lanes.velocity(p)[k]]);
                let alone = all(&|p, k| [alone.position(p)[k].value, alone.velocity(p)[k].value]);
                for (a, b) in lanes.iter().zip(&alone) {
                    // Roundoff of 15 steps.
                    let error = (a - b).abs();
                    assert!(error < 1e-12, "{shape:?}, {transfer:?}, {n}: {error:e}");
                }
            }
        }
    }
}

#[test]
fn an_axisymmetric_ring_that_expands_has_its_hoop_strain() {
    // A thin disk, clamped along its axis, every radius growing at the same rate: J = (1 + rate t)^2 for a while.
    let fill = block([1.0, 0.0], [1.5, 0.5]);
    let mut body = Body::new(rod(1.0), &fill, [0.0; 2]).unwrap();
    body.set_velocities(|x| [0.1 * x[0], 0.0]).unwrap();
    let config = Config {
        geometry: Geometry::Axisymmetric,
        viscosity: NO_VISCOSITY,
        ..Config::with_cell(0.1)
    };
    let mut simulation = Simulation::new(config, vec![body]).unwrap();
    let mass = simulation.ledger().mass;
    // Per radian: the area times the mean radius.
    assert!((mass - 0.25 * 1.25).abs() < 1e-12, "{mass}");
    let t = 1e-3;
    simulation.advance_to(t).unwrap();
    let centre = 10 * 5 + 5;
    let ratio = simulation.bodies()[0].volume_ratio(centre);
    // Its stress has changed the rate by less than 1 % in this time.
    assert!((ratio - (1.0 + 0.1 * t).powi(2)).abs() < 0.01 * 0.2 * t, "{ratio}");
}

#[test]
fn what_cannot_be_is_refused_with_its_value() {
    let fill = Fill::of([0.05], ([0.0], [1.0]), |_| true).unwrap();
    let body = || Body::new(rod(1.0), &fill, [0.0]).unwrap();
    let refused = |change: fn(&mut Config<1>)| {
        let mut config = Config::with_cell(0.1);
        change(&mut config);
        Simulation::new(config, vec![body()]).unwrap_err().to_string()
    };
    assert_eq!(refused(|c| c.cell = -0.1), "cell is -0.1; it must be greater than 0");
    assert_eq!(refused(|c| c.courant_number = 2.0), "courant_number is 2; it must be from 0 to 1");
    assert_eq!(
        refused(|c| c.courant_number = 0.0),
        "courant_number is 0; it must be greater than 0"
    );
    let refused_history = refused(|c| c.gravity_history = vec![[1.0, 0.0], [0.5, 1.0]]);
    assert!(refused_history.starts_with("time in gravity_history is 0.5; it must be from 1"));
    assert_eq!(
        refused(|c| c.gravity_history = vec![[0.0, f64::NAN]]),
        "multiple in gravity_history is NaN; it must be finite"
    );
    assert_eq!(
        refused(|c| c.boundaries = vec![clamped(0, 0.05, Side::Below)]),
        "a boundary normal to the first axis is at 0.05; it must be a whole number of cells of 0.1 from the origin"
    );
    assert_eq!(
        refused(|c| c.boundaries = vec![clamped(0, 0.5, Side::Above)]),
        "first body, particle 0: the first component of its position is 0.025; it must be on the bodies' side of 0.5"
    );
    assert_eq!(
        refused(|c| c.boundaries = vec![clamped(0, 0.0, Side::Above), clamped(0, 0.2, Side::Below)]),
        "boundaries normal to the first axis are 2 cells apart; they must be at least 4"
    );
    assert!(matches!(
        Simulation::<f64, 1>::new(Config::with_cell(0.1), vec![]),
        Err(Error::NoBody)
    ));
    let empty = Fill { positions: vec![], spacing: [0.1] };
    assert!(matches!(Body::new(rod(1.0), &empty, [0.0]), Err(Error::EmptyBody { .. })));
    let nan = Fill { positions: vec![[f64::NAN]], spacing: [0.1] };
    assert!(matches!(
        Body::new(rod(1.0), &nan, [0.0]),
        Err(Error::Parameter(ParameterError::NotFinite { .. }))
    ));
}
