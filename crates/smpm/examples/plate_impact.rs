//! The scene of the tutorial (`docs/tutorials/smpm.md`) without its file: a plate of steel with three random parameters runs into
//! a rigid wall at 1.5 km/s.
//!
//! ```text
//! cargo run --release -p smpm --example plate_impact
//! ```

use perturbation_moments::RandomVector;
use smpm::material::{Fluid, MieGruneisen, MieGruneisenParameters, Solid, Units, library};
use smpm::uncertainty::{Experiment, Study, exactly};
use smpm::{
    Body, Boundary, BoundaryKind, BulkViscosity, Config, Error, Fill, Gauge, Number, Place, Plan,
    Quantity, Shape, Side, Simulation, Transfer, Window,
};

/// Speed of the plate (cm/us).
const SPEED: f64 = 0.15;

// docs: experiment
/// The plate, over the slope of its Hugoniot and its two Grüneisen parameters.
struct PlateImpact;

impl Experiment<1> for PlateImpact {
    fn simulation<S: Number>(&self, x: &[S]) -> Result<Simulation<S, 1>, Error> {
        let [s1, gruneisen, gruneisen_slope] = exactly(x)?;
        let certain = library::steel_equation(Units::CM_G_US).map(|_, value| S::constant(value));
        let parameters = MieGruneisenParameters { s1, gruneisen, gruneisen_slope, ..certain };
        let steel = Solid { equation: MieGruneisen::new(parameters)?, strength: Fluid };
        let fill = Fill::of([0.025], ([0.0], [8.0]), |_| true)?;
        let wall = BoundaryKind::Symmetry;
        let config = Config {
            shape: Shape::CubicBSpline,
            transfer: Transfer::Apic,
            viscosity: BulkViscosity { quadratic: 1.5, linear: 1.0 },
            boundaries: vec![Boundary { axis: 0, position: 0.0, side: Side::Above, kind: wall }],
            ..Config::with_cell(0.05)
        };
        Simulation::new(config, vec![Body::new(steel, &fill, [-SPEED])?])
    }
}
// docs: end

#[allow(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), Error> {
    // docs: study
    let steel = library::steel_equation(Units::CM_G_US);
    let means = [steel.s1, steel.gruneisen, steel.gruneisen_slope];
    let inputs = RandomVector::independent(means, means.map(|mean| 0.05 * mean))?;
    let place = Place::Region { from: [0.5], to: [3.0] };
    let plan = Plan {
        gauges: vec![Gauge { name: "wake".to_owned(), body: 0, place }],
        quantities: vec![Quantity::Pressure],
        windows: vec![Window { from: 7.0, to: 8.0 }],
    };
    let study = Study::new(&PlateImpact, inputs, plan)?;
    let pressure = &study.propagated()?.moments[0];
    let deviation = pressure.variance().sqrt();
    println!("pressure: {:.4} +- {deviation:.4} Mbar", pressure.mean());
    // docs: end

    // Behind a plane shock p = rho_0 (C + S_1 u) u, and dp/dS_1 = rho_0 u^2; the Grüneisen parameters do not enter.
    let (density, sound) = (steel.density, steel.sound_speed);
    let exact = density * (sound + steel.s1 * SPEED) * SPEED;
    let exact_deviation = density * SPEED * SPEED * 0.05 * steel.s1;
    println!("exact:    {exact:.4} +- {exact_deviation:.4} Mbar");
    let centre = pressure.value;
    assert!((centre / exact - 1.0).abs() < 2e-3, "{centre}");
    assert!((deviation / exact_deviation - 1.0).abs() < 2e-2, "{deviation}");
    Ok(())
}

#[test]
fn the_example_runs() {
    main().unwrap();
}
