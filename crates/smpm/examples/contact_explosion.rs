//! A charge of TNT in water, in contact with a plate of steel whose Johnson-Cook constants are random: the second example of
//! Chen et al. (2019), with the mean and the deviation of the flow stress from one run.
//!
//! ```text
//! cargo run --release -p smpm --example contact_explosion
//! ```

#![allow(clippy::print_stdout, reason = "an example that prints")]

use perturbation_moments::RandomVector;
use smpm::material::{
    Detonation, Fluid, JohnsonCook, JohnsonCookParameters, Jwl, MieGruneisen, Solid, TensionCutOff,
    Units, library,
};
use smpm::uncertainty::{Experiment, FrozenForm, Series, Study, exactly};
use smpm::{
    Body, Boundary, BoundaryKind, Config, Error, Fill, Gauge, Number, Place, Plan, Quantity, Side,
    Simulation, Window,
};

/// Centimetres, grams, microseconds; stresses in megabar.
const UNITS: Units = Units::CM_G_US;

/// The upper half of a plane: charge around the origin, plate from 4 to 6 cm, water else.
#[derive(Debug)]
struct ContactExplosion {
    cell: f64,
}

impl Experiment<2> for ContactExplosion {
    fn simulation<S: Number>(&self, x: &[S]) -> Result<Simulation<S, 2>, Error> {
        let [a, b, n, c, m] = exactly(x)?;
        let half = 0.5 * self.cell;
        let charge = |x: &[f64; 2]| x[0].abs() < 4.0 && x[1] < 4.0;
        let plate = |x: &[f64; 2]| (4.0..6.0).contains(&x[0]);
        let fill = |inside: &dyn Fn(&[f64; 2]) -> bool| {
            Fill::of([half; 2], ([-14.0, 0.0], [14.0, 12.0]), inside)
        };

        let detonation = Detonation { point: [0.0; 3], cells: 2.0 };
        let tnt = Jwl::new(library::tnt(UNITS).map(|_, value| S::constant(value)), detonation)?;
        let tnt = Solid { equation: tnt, strength: Fluid };
        let water = MieGruneisen::new(library::water(UNITS).map(|_, value| S::constant(value)))?;
        let water =
            Solid { equation: TensionCutOff::new(water, S::constant(0.0))?, strength: Fluid };
        let equation = library::steel_equation(UNITS).map(|_, value| S::constant(value));
        let certain = library::steel_strength(UNITS).map(|_, value| S::constant(value));
        let strength = JohnsonCook::new(JohnsonCookParameters { a, b, n, c, m, ..certain })?;
        let steel = Solid { equation: MieGruneisen::new(equation)?, strength };

        let symmetry =
            Boundary { axis: 1, position: 0.0, side: Side::Above, kind: BoundaryKind::Symmetry };
        let config = Config { boundaries: vec![symmetry], ..Config::with_cell(self.cell) };
        let bodies = vec![
            Body::new(tnt, &fill(&charge)?, [0.0; 2])?,
            Body::new(steel, &fill(&plate)?, [0.0; 2])?,
            Body::new(water, &fill(&|x| !charge(x) && !plate(x))?, [0.0; 2])?,
        ];
        Simulation::new(config, bodies)
    }
}

fn main() -> Result<(), Error> {
    let steel = library::steel_strength(UNITS);
    let mean = [steel.a, steel.b, steel.n, steel.c, steel.m];
    let inputs = RandomVector::independent(mean, mean.map(|value| 0.05 * value))?;
    let gauge =
        |name: &str, point| Gauge { name: name.to_owned(), body: 1, place: Place::Nearest(point) };
    let plan = Plan {
        gauges: vec![gauge("H", [4.5, 0.0]), gauge("G", [5.0, 0.0])],
        quantities: vec![Quantity::FlowStress, Quantity::Deviator(0, 0), Quantity::Pressure],
        windows: (6..=14).map(|t| Window::at(f64::from(t))).collect(),
    };
    let study = Study::new(&ContactExplosion { cell: 0.5 }, inputs, plan)?;
    let propagated = study.propagated()?;
    let frozen = study.frozen(FrozenForm::Corrected)?;
    println!("{} steps; MPa", study.schedule().n_steps());
    println!("gauge, quantity, time: mean +- deviation (deviation by frozen formulas)");
    let plan = study.plan();
    for (response, moments) in propagated.moments.iter().enumerate() {
        let (gauge, quantity, window) = plan.parts(response);
        let deviation = |variance: f64| 1e5 * variance.sqrt();
        let frozen = frozen[response].as_ref().map_or(0.0, Series::variance);
        println!(
            "{} {:12} {:4} us: {:8.1} +- {:5.1} ({:.1})",
            plan.gauges[gauge].name,
            plan.quantities[quantity].to_string(),
            plan.windows[window].to,
            1e5 * moments.mean(),
            deviation(moments.variance()),
            deviation(frozen),
        );
    }
    Ok(())
}
