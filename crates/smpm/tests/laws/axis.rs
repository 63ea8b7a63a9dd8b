//! The axis of an axisymmetric run: a plane of symmetry by itself, and no force where there is none.

use smpm::material::{
    Fluid, LinearElasticSolid, Model, Solid, StiffenedGas, StiffenedGasParameters,
};
use smpm::{
    Body, Boundary, BoundaryKind, BulkViscosity, Config, Error, Fill, Geometry, Quantity, Shape,
    Side, Simulation, Transfer,
};

use crate::fixtures::elastic;

const GAMMA: f64 = 1.4;

fn gas(density: f64, pressure: f64) -> Model<f64> {
    let parameters = StiffenedGasParameters { density, exponent: GAMMA, stiffness: 0.0, pressure };
    Solid { equation: StiffenedGas::new(parameters).unwrap(), strength: Fluid }.into()
}

fn plane(axis: usize, position: f64, side: Side) -> Boundary {
    Boundary { axis, position, side, kind: BoundaryKind::Symmetry }
}

fn axisymmetric(cell: f64) -> Config<2> {
    Config { geometry: Geometry::Axisymmetric, ..Config::with_cell(cell) }
}

/// Gas at rest in a closed cylinder of radius and height 0.8, in units of its sound speed.
fn vessel(shape: Shape, transfer: Transfer, along: u32) -> Simulation<f64, 2> {
    let cell = 0.1;
    let spacing = [cell / f64::from(along); 2];
    let fill = Fill::of(spacing, ([0.0; 2], [0.8; 2]), |_| true).unwrap();
    let body = Body::new(gas(1.0, 1.0 / GAMMA), &fill, [0.0; 2]).unwrap();
    let boundaries =
        vec![plane(1, 0.0, Side::Above), plane(1, 0.8, Side::Below), plane(0, 0.8, Side::Below)];
    let config = Config { shape, transfer, boundaries, ..axisymmetric(cell) };
    Simulation::new(config, vec![body]).unwrap()
}

#[test]
fn gas_at_rest_in_a_vessel_stays_at_rest_with_any_number_of_particles_a_cell() {
    for shape in [Shape::QuadraticBSpline, Shape::CubicBSpline] {
        for transfer in [Transfer::Flip, Transfer::Apic] {
            for along in 1..=4 {
                let mut run = vessel(shape, transfer, along);
                run.advance_to(2.0).unwrap();
                let body = &run.bodies()[0];
                let what = format!("{shape:?}, {transfer:?}, {along} along a cell");
                for p in 0..body.n_particles() {
                    let (pressure, velocity) = (body.pressure(p), body.velocity(p));
                    let error = (pressure * GAMMA - 1.0).abs();
                    let speed = velocity[0].hypot(velocity[1]);
                    // Roundoff of the steps; seen: 3.5e-14 and 1.3e-14.
                    assert!(error < 3e-13 && speed < 1e-13, "{what}: {error:e}, {speed:e}");
                }
            }
        }
    }
}

#[test]
fn a_plane_wave_is_on_the_axis_what_it_is_off_it() {
    // Two disks of radius 4 meet; until rarefactions come from the rim, 1.5 away, the middle is a plane wave.
    let disk = |low: f64, high: f64, velocity: f64| {
        let fill = Fill::of([0.05; 2], ([0.0, low], [4.0, high]), |_| true).unwrap();
        Body::new(elastic(1.0, 1.0, 0.3), &fill, [0.0, velocity]).unwrap()
    };
    for shape in [Shape::QuadraticBSpline, Shape::CubicBSpline] {
        let bodies = vec![disk(-1.5, 0.0, 0.02), disk(0.0, 1.5, 0.0)];
        let mut run = Simulation::new(Config { shape, ..axisymmetric(0.1) }, bodies).unwrap();
        run.advance_to(0.9).unwrap();
        let target = &run.bodies()[1];
        let row = |radius: f64| {
            let near = |p: &usize| {
                let [r, z] = target.positions()[*p];
                (r - radius).abs() < 0.03 && (z - 0.35).abs() < 0.03
            };
            let particle = (0..target.n_particles()).find(near).unwrap();
            Quantity::Stress(1, 1).of(target, particle).unwrap()
        };
        let off = row(1.525);
        assert!(off < -0.005, "{off}");
        for radius in [0.025, 0.075, 0.125, 0.225, 0.525] {
            let error = (row(radius) / off - 1.0).abs();
            // Seen: 1.3e-8 (quadratic), 8.4e-8 (cubic).
            assert!(error < 5e-7, "{shape:?} at {radius}: {error}");
        }
    }
}

#[test]
fn a_ball_of_gas_expands_as_a_ball() {
    // Ten times the pressure inside a radius of 0.5, by which its front moves on.
    let cell = 0.05;
    let fill = |inside: bool| {
        Fill::of([0.5 * cell; 2], ([0.0; 2], [1.5; 2]), |[r, z]| (r.hypot(*z) < 0.5) == inside)
            .unwrap()
    };
    let bodies = vec![
        Body::new(gas(1.0, 10.0), &fill(true), [0.0; 2]).unwrap(),
        Body::new(gas(1.0, 1.0), &fill(false), [0.0; 2]).unwrap(),
    ];
    let boundaries =
        vec![plane(1, 0.0, Side::Above), plane(1, 1.5, Side::Below), plane(0, 1.5, Side::Below)];
    let viscosity = BulkViscosity { quadratic: 1.5, linear: 0.3 };
    let shape = Shape::CubicBSpline;
    let config = Config { shape, viscosity, boundaries, ..axisymmetric(cell) };
    let mut run = Simulation::new(config, bodies).unwrap();
    run.advance_to(0.15).unwrap();
    let body = &run.bodies()[0];
    // The outermost particle of the ball within 10 degrees of each direction.
    let extent = |direction: f64| {
        let along = |p: usize| {
            let [r, z] = body.positions()[p];
            ((z.atan2(r) - direction).abs() < 0.17).then(|| r.hypot(z))
        };
        (0..body.n_particles()).filter_map(along).fold(0.0, f64::max)
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    let (equator, middle, pole) = (extent(0.05), extent(0.5 * quarter), extent(quarter - 0.05));
    assert!(middle > 0.55, "{middle}");
    for other in [equator, pole] {
        let error = (other / middle - 1.0).abs();
        // Seen: 0.004.
        assert!(error < 0.02, "{equator} {middle} {pole}");
    }
}

#[test]
fn the_axis_is_implied_and_can_be_nothing_else() {
    let body = || {
        let fill = Fill::of([0.05; 2], ([0.0; 2], [0.5; 2]), |_| true).unwrap();
        let rod: LinearElasticSolid<f64> = elastic(1.0, 100.0, 0.0);
        Body::new(rod, &fill, [0.0; 2]).unwrap()
    };
    let with = |boundaries| {
        let config = Config { boundaries, ..axisymmetric(0.1) };
        Simulation::new(config, vec![body()])
    };
    let axis = plane(0, 0.0, Side::Above);
    let (implied, given) = (with(vec![]).unwrap(), with(vec![axis]).unwrap());
    assert_eq!(implied.config().boundaries, vec![axis]);
    assert_eq!(given.config(), implied.config());
    let clamped = Boundary { kind: BoundaryKind::Clamped, ..axis };
    assert_eq!(with(vec![clamped]).unwrap_err(), Error::AxisIsNoBoundary);
    let wall = plane(1, 0.0, Side::Above);
    let contradicted =
        with(vec![wall, Boundary { kind: BoundaryKind::Rigid { friction: 0.0 }, ..wall }]);
    let expected = Error::BoundariesContradict { axis: 1, value: 0.0 };
    assert_eq!(contradicted.unwrap_err(), expected);
    let off = Config { origin: [0.03, 0.0], ..axisymmetric(0.1) };
    assert!(matches!(Simulation::new(off, vec![body()]), Err(Error::NotOnGrid { axis: 0, .. })));
}
