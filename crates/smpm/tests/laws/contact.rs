//! Bodies that meet with velocities of their own: they part, slide and stick.

use smpm::material::{LinearElasticParameters, LinearElasticSolid};
use smpm::{
    Body, Boundary, BoundaryKind, BulkViscosity, Config, Contact, Error, Fill, Side, Simulation,
    Transfer,
};

const NO_VISCOSITY: BulkViscosity = BulkViscosity { quadratic: 0.0, linear: 0.0 };

fn elastic(density: f64, young_modulus: f64, poisson_ratio: f64) -> LinearElasticSolid<f64> {
    LinearElasticSolid::linear_elastic(LinearElasticParameters {
        density,
        young_modulus,
        poisson_ratio,
    })
    .unwrap()
}

/// Two disks of Sulsky, Chen and Schreyer 1994: radius 0.2, centres (0.2, 0.2) and (0.8, 0.8), velocities 0.1 and -0.1 along
/// both axes, E = 1000, nu = 0.3, rho = 1000; they touch at 1.58579.
fn disks() -> Simulation<f64, 2> {
    let contact = Contact::Friction { coefficient: 0.0 };
    let disk = |centre: f64, speed: f64| {
        let within = |x: &[f64; 2]| (x[0] - centre).hypot(x[1] - centre) < 0.2;
        let corner = |reach: f64| [centre + reach; 2];
        let fill = Fill::of([0.0125; 2], (corner(-0.2), corner(0.2)), within).unwrap();
        Body::new(elastic(1000.0, 1000.0, 0.3), &fill, [speed; 2]).unwrap()
    };
    let config = Config { contact, viscosity: NO_VISCOSITY, ..Config::with_cell(0.025) };
    Simulation::new(config, vec![disk(0.2, 0.1), disk(0.8, -0.1)]).unwrap()
}

#[test]
fn colliding_disks_part_with_their_energy() {
    let mut simulation = disks();
    let start = simulation.ledger();
    // The lattice covers the disks to 1 %.
    assert!((start.kinetic / 2.5132741228718345 - 1.0).abs() < 0.01, "{}", start.kinetic);
    // Free flight until they touch, at 1.58579.
    simulation.advance_to(1.58).unwrap();
    assert!((simulation.ledger().kinetic / start.kinetic - 1.0).abs() < 1e-12);
    simulation.advance_to(1.9).unwrap();
    let squeezed = simulation.ledger();
    assert!(squeezed.kinetic < 0.6 * start.kinetic, "{}", squeezed.kinetic);
    simulation.advance_to(3.5).unwrap();
    let (end, ledgers) = (simulation.ledger(), simulation.ledgers());
    for k in 0..2 {
        // Roundoff of some thousand steps, relative to the momentum 12.5 of a disk.
        assert!(end.momentum[k].abs() < 1e-11 * 12.5, "{}", end.momentum[k]);
    }
    let mass = ledgers[0].mass;
    let velocity = ledgers[0].momentum.map(|p| p / mass);
    // Some of the energy stays as vibration.
    assert!(velocity.iter().all(|&v| v < -0.08 && v > -0.1), "{velocity:?}");
    let total = (end.kinetic + end.internal) / start.kinetic;
    assert!((total - 1.0).abs() < 0.01, "{total}");
}

const GRAVITY: f64 = 10.0;
/// When the block has settled, and how long it is watched from then on.
const SETTLED: f64 = 0.2;
const DURATION: f64 = 0.2;

/// A block on a slab, both inclined by `angle`: what its mean velocity along the slab grows by, and its place less what the
/// velocity at the beginning accounts for.
///
/// Weight that acts at once sets block and slab swinging, with a normal force between none and twice the weight. Below 0.68 of
/// it a block that should stick slips, so only with the swing damped can sticking be seen.
fn slide(angle: f64, coefficient: f64) -> (f64, f64) {
    let fill = |low: [f64; 2], high: [f64; 2]| Fill::of([0.05; 2], (low, high), |_| true).unwrap();
    let slab = Body::new(elastic(1.0, 1e4, 0.0), &fill([0.0, 0.0], [4.0, 0.5]), [0.0; 2]).unwrap();
    let block = Body::new(elastic(1.0, 1e4, 0.0), &fill([1.0, 0.5], [2.0, 1.0]), [0.0; 2]).unwrap();
    let ground =
        Boundary { axis: 1, position: 0.0, side: Side::Above, kind: BoundaryKind::Clamped };
    let config = Config {
        contact: Contact::Friction { coefficient },
        gravity: [GRAVITY * angle.sin(), -GRAVITY * angle.cos()],
        boundaries: vec![ground],
        // PIC damps what is uneven over a cell and leaves the slide of a body alone.
        transfer: Transfer::Flip { damping_time: 1e-3 },
        viscosity: NO_VISCOSITY,
        ..Config::with_cell(0.1)
    };
    // The fall of the slab under its own weight is energy that no state holds at the start.
    let config = Config { most_energy_growth: f64::MAX, ..config };
    let mut simulation = Simulation::new(config, vec![slab, block]).unwrap();
    let mut watched = |until: f64| {
        simulation.advance_to(until).unwrap();
        let positions = simulation.bodies()[1].positions();
        let place = positions.iter().map(|x| x[0]).sum::<f64>() / positions.len() as f64;
        let ledger = simulation.ledgers()[1];
        (ledger.momentum[0] / ledger.mass, place)
    };
    let (velocity, place) = watched(SETTLED);
    let (later, there) = watched(SETTLED + DURATION);
    (later - velocity, there - place - velocity * DURATION)
}

#[test]
fn a_block_slides_down_an_incline_as_coulomb_says() {
    let angle = 0.5_f64;
    for coefficient in [0.0, 0.2, 0.4] {
        let (velocity, displacement) = slide(angle, coefficient);
        let acceleration = GRAVITY * (angle.sin() - coefficient * angle.cos());
        let exact = acceleration * DURATION;
        // The block settles and swings: friction follows its normal momentum, which is not quite that of its weight.
        let tolerance = 0.02 * GRAVITY * DURATION * angle.sin();
        assert!((velocity - exact).abs() < tolerance, "{coefficient}: {velocity} {exact}");
        let exact = 0.5 * acceleration * DURATION * DURATION;
        let tolerance = 0.02 * 0.5 * GRAVITY * DURATION * DURATION * angle.sin();
        assert!((displacement - exact).abs() < tolerance, "{coefficient}: {displacement} {exact}");
    }
}

#[test]
fn a_block_stays_below_the_angle_of_friction() {
    // tan 0.5 = 0.546.
    let (velocity, displacement) = slide(0.5, 0.8);
    let free = 0.5 * GRAVITY * DURATION * DURATION * 0.5_f64.sin();
    // Seen 0.1 % of the way and 0.04 % of the speed of free fall.
    assert!(displacement.abs() < 0.005 * free, "{displacement} of {free}");
    let free = GRAVITY * DURATION * 0.5_f64.sin();
    assert!(velocity.abs() < 0.005 * free, "{velocity} of {free}");
}

#[test]
fn a_coefficient_below_zero_is_refused() {
    let refused =
        Config::<2> { contact: Contact::Friction { coefficient: -0.1 }, ..Config::with_cell(0.1) };
    let body = Body::new(
        elastic(1.0, 1.0, 0.0),
        &Fill::of([0.1; 2], ([0.0; 2], [1.0; 2]), |_| true).unwrap(),
        [0.0; 2],
    );
    let error = Simulation::new(refused, vec![body.unwrap()]).unwrap_err();
    assert!(matches!(error, Error::Negative { name: "friction coefficient", .. }), "{error}");
}
