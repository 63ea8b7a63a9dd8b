//! Gradients by reverse mode are those of jets, for every scheme that has an adjoint, whatever states are kept.

use smpm::material::{
    ElasticBulk, ElasticBulkParameters, ElasticShear, ElasticShearParameters, JohnsonCook,
    LinearElasticSolid, MieGruneisen, MieGruneisenParameters, Solid, Units, VonMises, library,
};
use smpm::uncertainty::{FieldExperiment, FieldStudy, fewest_advances};
use smpm::{
    Body, Boundary, BoundaryKind, BulkViscosity, Config, Contact, Error, Fill, Gauge, Geometry,
    Number, Place, Plan, Quantity, Shape, Side, Simulation, Transfer, UpdateOrder, Window,
};

const UNITS: Units = Units::CM_G_US;
const ALL: usize = usize::MAX;

/// `sum_k xi_k cos(k (x + 2 y))/(k + 1)`.
fn field<S: Number, const D: usize>(coefficients: &[S], x: &[f64; D]) -> S {
    let place = x[0] + 2.0 * x.get(1).copied().unwrap_or(0.0);
    let term = |sum: S, (k, &xi): (usize, &S)| {
        let k = k as f64;
        sum + xi * ((k * place).cos() / (k + 1.0))
    };
    coefficients.iter().enumerate().fold(S::constant(0.0), term)
}

/// Compares the gradients of all responses by reverse mode with those by jets, relative to their lengths.
fn compare<const D: usize>(
    name: &str,
    study: &FieldStudy<'_, impl FieldExperiment<D>, D>,
    tolerance: f64,
) -> Result<(), String> {
    let jets = study.gradient().unwrap();
    let n = study.plan().n_responses();
    let responses: Vec<usize> = (0..n).rev().collect();
    let found = study.gradient_by_adjoint(&responses, ALL).unwrap();
    let cost = found.cost;
    assert_eq!((cost.n_steps, cost.n_advances), (study.schedule().n_steps(), cost.n_kept));
    let (mut largest, mut n_moving) = (0.0_f64, 0);
    for (position, &response) in responses.iter().enumerate() {
        let series = &jets.moments[response];
        let length = series.variance().sqrt();
        if length == 0.0 {
            assert!(found.gradients[position].iter().all(|&slope| slope == 0.0));
            continue;
        }
        n_moving += 1;
        for (by_jets, by_adjoint) in series.gradient.iter().zip(&found.gradients[position]) {
            let error = (by_jets - by_adjoint).abs() / length;
            assert!(error.is_finite(), "{name}");
            largest = largest.max(error);
        }
    }
    assert!(n_moving >= 2, "{name}");
    if largest <= tolerance { Ok(()) } else { Err(format!("{name}: {largest:e}")) }
}

/// Elastic bar whose moduli and density vary, between a wall and an absorbing plane, under gravity.
struct Bar {
    config: Config<1>,
}

fn bar(order: UpdateOrder, transfer: Transfer, shape: Shape, kind: BoundaryKind) -> Bar {
    let wall = Boundary { axis: 0, position: 0.0, side: Side::Above, kind };
    let kind = BoundaryKind::Absorbing { longitudinal: 0.6, shear: 0.3 };
    let open = Boundary { axis: 0, position: 2.0, side: Side::Below, kind };
    let config = Config {
        boundaries: vec![wall, open],
        update_order: order,
        transfer,
        shape,
        gravity: [-1e-4],
        ..Config::with_cell(0.1)
    };
    Bar { config }
}

impl FieldExperiment<1> for Bar {
    fn n_coefficients(&self) -> usize {
        10
    }

    fn simulation<S: Number>(&self, coefficients: &[S]) -> Result<Simulation<S, 1>, Error> {
        let material = |_: usize, x: &[f64; 1]| {
            let factor = (field(coefficients, x) * 0.1).exp();
            let density = field(&coefficients[5..], x) * 0.5 + 7.8;
            let (bulk_modulus, shear_modulus) = (factor * 1.2, factor * 0.8);
            Ok(LinearElasticSolid {
                equation: ElasticBulk::new(ElasticBulkParameters { density, bulk_modulus })?,
                strength: ElasticShear::new(ElasticShearParameters { shear_modulus })?,
            })
        };
        let fill = Fill::of([0.05], ([0.0], [2.0]), |_| true)?;
        Simulation::new(self.config.clone(), vec![Body::varying(material, &fill, [-0.003])?])
    }
}

fn gauge<const D: usize>(name: &str, body: usize, place: [f64; D]) -> Gauge<D> {
    Gauge { name: name.to_owned(), body, place: Place::Nearest(place) }
}

fn bar_plan() -> Plan<1> {
    let region = Place::Region { from: [1.0], to: [1.4] };
    Plan {
        gauges: vec![
            gauge("foot", 0, [0.025]),
            Gauge { name: "middle".to_owned(), body: 0, place: region },
        ],
        quantities: vec![
            Quantity::Position(0),
            Quantity::Velocity(0),
            Quantity::Stress(0, 0),
            Quantity::Density,
            Quantity::Energy,
        ],
        windows: vec![Window::at(0.0), Window { from: 1.0, to: 3.0 }, Window::at(4.0)],
    }
}

const FLIP: Transfer = Transfer::Flip { damping_time: f64::INFINITY };
const DAMPED: Transfer = Transfer::Flip { damping_time: 1.0 };

#[test]
fn the_gradient_of_a_bar_by_reverse_mode_is_that_of_jets_for_every_scheme() {
    let kinds = [BoundaryKind::Symmetry, BoundaryKind::Clamped, BoundaryKind::Rigid];
    let mut n = 0;
    for order in [UpdateOrder::StressLast, UpdateOrder::ModifiedStressLast] {
        for transfer in [FLIP, DAMPED, Transfer::Apic] {
            for shape in [Shape::Linear, Shape::QuadraticBSpline, Shape::CubicBSpline] {
                let kind = kinds[(n % 4) % 3];
                n += 1;
                let bar = bar(order, transfer, shape, kind);
                let study = FieldStudy::new(&bar, bar_plan(), None).unwrap();
                let name = format!("{order:?} {transfer:?} {shape:?} {kind:?}");
                // Roundoff of sums in another order, through 59 steps; seen 2.5e-13.
                compare(&name, &study, 2.5e-12).unwrap();
            }
        }
    }
}

#[test]
fn the_gradient_by_reverse_mode_is_that_of_differences() {
    let mut bar = bar(
        UpdateOrder::ModifiedStressLast,
        Transfer::Apic,
        Shape::QuadraticBSpline,
        BoundaryKind::Clamped,
    );
    // The bulk viscosity acts in compression alone: a kink that derivatives do not see.
    bar.config.viscosity = BulkViscosity { quadratic: 0.0, linear: 0.0 };
    let study = FieldStudy::new(&bar, bar_plan(), None).unwrap();
    let responses = [2, 5, 8, 17, 20];
    let found = study.gradient_by_adjoint(&responses, ALL).unwrap();
    let differences = study.central_differences(1e-3, &study.units()).unwrap();
    for (gradient, &response) in found.gradients.iter().zip(&responses) {
        let length = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
        assert!(length > 0.0);
        for (slope, [difference, _]) in gradient.iter().zip(&differences[response]) {
            // Truncation: step^2 of the third derivative.
            let error = (slope - difference).abs() / length;
            assert!(error < 2e-6, "{response}: {error:e}");
        }
    }
}

#[test]
fn products_with_second_derivatives_are_those_along_directions_by_jets() {
    let mut bar = bar(UpdateOrder::StressLast, FLIP, Shape::CubicBSpline, BoundaryKind::Symmetry);
    bar.config.viscosity = BulkViscosity { quadratic: 0.0, linear: 0.0 };
    let study = FieldStudy::new(&bar, bar_plan(), None).unwrap();
    let responses = [2, 8, 20];
    let directions = &study.units()[..2];
    let both = [0, 1].into_iter().map(|k| directions[0][k] + directions[1][k]);
    let sum: Vec<f64> = both.chain(vec![0.0; 8]).collect();
    let products = study.hessian_products(&responses, directions, (1e-3, ALL)).unwrap();
    let along = [directions, &[sum]].concat();
    let along = study.along("two coefficients and their sum", &along).unwrap().derivatives;
    for (products, &response) in products.iter().zip(&responses) {
        let [[_, first], [_, second], [_, sum]] = along[response][..] else { panic!() };
        let scale = first.abs().max(second.abs());
        assert!(scale > 0.0);
        let mixed = 0.5 * (sum - first - second);
        let expected = [(0, 0, first), (1, 1, second), (0, 1, mixed), (1, 0, mixed)];
        for (of, by, expected) in expected {
            // Truncation: step^2 of the next derivatives.
            let error = (products[of][by] - expected).abs() / scale;
            assert!(error < 1e-5, "{response} {of} {by}: {error:e}");
        }
    }
}

#[test]
fn with_few_states_kept_the_gradient_has_the_same_bits_by_more_steps() {
    let bar =
        bar(UpdateOrder::ModifiedStressLast, FLIP, Shape::QuadraticBSpline, BoundaryKind::Symmetry);
    let study = FieldStudy::new(&bar, bar_plan(), None).unwrap();
    let whole = study.gradient_by_adjoint(&[2, 5], ALL).unwrap();
    let of_one = whole.cost.bytes / whole.cost.n_kept;
    for slots in [1, 2, 3, 10] {
        let found = study.gradient_by_adjoint(&[2, 5], slots * of_one + 5).unwrap();
        assert!(found.gradients == whole.gradients, "{slots}");
        let n = study.schedule().n_steps();
        assert_eq!(found.cost.n_kept, slots);
        assert_eq!(found.cost.n_advances, fewest_advances(n, slots) + 1);
        assert_eq!(found.cost.bytes, slots * of_one);
    }
    assert_eq!(
        study.gradient_by_adjoint(&[2], of_one - 1),
        Err(Error::AdjointMemory { value: of_one - 1, limit: of_one })
    );
}

/// A plate of steel in water or a bar of copper, both with a yield stress that varies, in two dimensions.
struct Impact {
    config: Config<2>,
    /// Beside water, its constants certain.
    in_water: bool,
}

impl FieldExperiment<2> for Impact {
    fn n_coefficients(&self) -> usize {
        10
    }

    fn simulation<S: Number>(&self, coefficients: &[S]) -> Result<Simulation<S, 2>, Error> {
        let c = S::constant;
        let fluid = |parameters: MieGruneisenParameters<f64>| {
            MieGruneisen::new(parameters.map(|_, number| c(number)))
        };
        let steel = |_: usize, x: &[f64; 2]| {
            let mut flow = library::steel_strength(UNITS).map(|_, number| c(number));
            flow.a = flow.a * (field(coefficients, x) * 0.1 + 1.0);
            let equation = fluid(library::steel_equation(UNITS))?;
            Ok(Solid { equation, strength: JohnsonCook::new(flow)? })
        };
        let copper = |_: usize, x: &[f64; 2]| {
            let mut flow = library::copper_linear_hardening(UNITS).map(|_, number| c(number));
            flow.yield_stress = flow.yield_stress * (field(coefficients, x) * 0.1).exp();
            let equation = fluid(library::copper_equation(UNITS))?;
            Ok(Solid { equation, strength: VonMises::new(flow)? })
        };
        let fill = Fill::of([0.05; 2], ([0.0, 0.0], [0.5, 0.8]), |_| true)?;
        let velocity = [-0.01, -0.03];
        let mut bodies = if self.in_water {
            vec![Body::varying(steel, &fill, velocity)?]
        } else {
            vec![Body::varying(copper, &fill, [0.0, -0.03])?]
        };
        if self.in_water {
            let water = fluid(library::water(UNITS))?;
            let beside = Fill::of([0.05; 2], ([0.5, 0.0], [0.9, 0.8]), |_| true)?;
            let water = Solid { equation: water, strength: smpm::material::Fluid };
            bodies.push(Body::new(water, &beside, velocity)?);
        }
        Simulation::new(self.config.clone(), bodies)
    }
}

fn impact(order: UpdateOrder, transfer: Transfer, shape: Shape, in_water: bool) -> Impact {
    let wall =
        |axis| Boundary { axis, position: 0.0, side: Side::Above, kind: BoundaryKind::Symmetry };
    let geometry = if in_water { Geometry::Cartesian } else { Geometry::Axisymmetric };
    let config = Config {
        boundaries: vec![wall(0), wall(1)],
        update_order: order,
        transfer,
        shape,
        geometry,
        ..Config::with_cell(0.1)
    };
    Impact { config, in_water }
}

fn impact_plan() -> Plan<2> {
    Plan {
        gauges: vec![gauge("corner", 0, [0.025, 0.025]), gauge("top", 0, [0.475, 0.775])],
        quantities: vec![
            Quantity::VonMises,
            Quantity::PlasticStrain,
            Quantity::FlowStress,
            Quantity::Pressure,
            Quantity::Position(1),
        ],
        windows: vec![Window::at(0.5), Window::at(1.5)],
    }
}

#[test]
fn the_gradient_of_an_impact_by_reverse_mode_is_that_of_jets() {
    let mut failed = vec![];
    for (order, transfer, shape, in_water) in [
        (UpdateOrder::ModifiedStressLast, FLIP, Shape::QuadraticBSpline, true),
        (UpdateOrder::StressLast, Transfer::Apic, Shape::CubicBSpline, true),
        (UpdateOrder::ModifiedStressLast, Transfer::Apic, Shape::QuadraticBSpline, false),
        (UpdateOrder::ModifiedStressLast, FLIP, Shape::Linear, false),
        (UpdateOrder::StressLast, FLIP, Shape::CubicBSpline, false),
        (UpdateOrder::ModifiedStressLast, DAMPED, Shape::QuadraticBSpline, false),
    ] {
        let impact = impact(order, transfer, shape, in_water);
        let study = FieldStudy::new(&impact, impact_plan(), None).unwrap();
        let name = format!("{order:?} {transfer:?} {shape:?} {in_water}");
        // Roundoff in up to 30 steps; seen 1.5e-12, with APIC around the axis, else below 2e-13. Hats with APIC are not here: at
        // light nodes their runs are so sensitive that jets, reverse mode and differences differ by 1e-7 to 1e-4.
        failed.extend(compare(&name, &study, 1.5e-11).err());
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// The impact with a modulus of the water that depends on the coefficients without varying.
struct Uniform(Impact);

impl FieldExperiment<2> for Uniform {
    fn n_coefficients(&self) -> usize {
        10
    }

    fn simulation<S: Number>(&self, coefficients: &[S]) -> Result<Simulation<S, 2>, Error> {
        let mut parameters = library::water(UNITS).map(|_, number| S::constant(number));
        parameters.sound_speed = parameters.sound_speed * (coefficients[0] * 0.1 + 1.0);
        let water =
            Solid { equation: MieGruneisen::new(parameters)?, strength: smpm::material::Fluid };
        let fill = Fill::of([0.05; 2], ([0.0, 0.0], [0.5, 0.8]), |_| true)?;
        Simulation::new(self.0.config.clone(), vec![Body::new(water, &fill, [0.0, -0.01])?])
    }
}

#[test]
fn what_has_no_adjoint_is_refused_by_name() {
    let refused = |config: Config<2>, what: &str| {
        let impact = Impact { config, in_water: true };
        let study = FieldStudy::new(&impact, impact_plan(), None).unwrap();
        let error = study.gradient_by_adjoint(&[0], ALL).unwrap_err();
        assert!(matches!(error, Error::NotReversed { .. }), "{error}");
        assert!(error.to_string().contains(what), "{error}");
    };
    let usual = impact(UpdateOrder::StressLast, FLIP, Shape::QuadraticBSpline, true).config;
    refused(Config { update_order: UpdateOrder::StressFirst, ..usual.clone() }, "stress first");
    refused(Config { shape: Shape::Gimp, ..usual.clone() }, "GIMP");
    let contact = Contact::Friction { coefficient: 0.1 };
    refused(Config { contact, ..usual.clone() }, "frictional contact");
    let uniform = Uniform(Impact { config: usual, in_water: true });
    let study = FieldStudy::new(&uniform, impact_plan(), None).unwrap();
    let error = study.gradient_by_adjoint(&[0], ALL).unwrap_err();
    assert!(error.to_string().contains("without varying in space"), "{error}");
    assert_eq!(
        study.gradient_by_adjoint(&[20], ALL),
        Err(Error::NoSuchResponse { value: 20, limit: 20 })
    );
}
