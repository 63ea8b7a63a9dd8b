//! The transfer of jets and gradients, against the same step over a number of which it knows nothing but the arithmetic.

#![allow(clippy::inline_always, reason = "part of formulas inside a dispatched closure")]

use std::ops::{Add, Div, Mul, Neg, Sub};

use perturbation_moments::{Gradient, Jet, LANES, Real, Scalar, one_value};
use smpm::material::{LinearElasticParameters, LinearElasticSolid};
use smpm::{Body, Config, Fill, Geometry, Number, Shape, Simulation, Transfer, UpdateOrder};

/// A jet that shows the step no derivative: every shape function is a jet, as for a number of a user.
#[derive(Debug, Clone, Copy)]
struct ByOperations(Jet);

impl Number for ByOperations {}

impl Real for ByOperations {
    one_value!(2);

    fn recip(self) -> Self {
        Self(self.0.recip())
    }
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    fn exp(self) -> Self {
        Self(self.0.exp())
    }
    fn ln(self) -> Self {
        Self(self.0.ln())
    }
    fn squared(self) -> Self {
        Self(self.0.squared())
    }
}

impl Scalar for ByOperations {
    fn constant(value: f64) -> Self {
        Self(Jet::constant(value))
    }
    fn value(self) -> f64 {
        self.0.value
    }
    fn sin(self) -> Self {
        Self(self.0.sin())
    }
    fn cos(self) -> Self {
        Self(self.0.cos())
    }
    fn powi(self, exponent: i32) -> Self {
        Self(self.0.powi(exponent))
    }
    fn powf(self, exponent: f64) -> Self {
        Self(self.0.powf(exponent))
    }
}

impl Neg for ByOperations {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

macro_rules! operators {
    ($($trait:ident $function:ident $operator:tt),+) => {
        $(
            impl $trait for ByOperations {
                type Output = Self;
                fn $function(self, other: Self) -> Self {
                    Self(self.0 $operator other.0)
                }
            }

            impl $trait<f64> for ByOperations {
                type Output = Self;
                fn $function(self, other: f64) -> Self {
                    Self(self.0 $operator other)
                }
            }
        )+
    };
}
operators!(Add add +, Sub sub -, Mul mul *, Div div /);

/// Largest distance of derivatives; the largest seen is 7e-13.
const LIMIT: f64 = 5e-12;

/// What is compared of a run: columns of numbers of a kind.
type Columns<S> = [Vec<S>; 4];

/// Places, velocities, stresses and masses of an elastic body that stretches, shears and rotates across cells.
fn run<S: Number, const D: usize>(
    config: &Config<D>,
    input: impl Fn(f64, usize) -> S,
) -> Columns<S> {
    let parameters = LinearElasticParameters {
        density: input(1.3, 0),
        young_modulus: input(40.0, 1),
        poisson_ratio: input(0.3, 2),
    };
    let solid = LinearElasticSolid::linear_elastic(parameters).unwrap();
    // Away from the nodes, so that particles leave their cells at different steps.
    let (low, edge) = (0.413, [2.0, 0.8, 0.4][D - 1]);
    let fill = Fill::of([0.05; D], ([low; D], [low + edge; D]), |_| true).unwrap();
    let mut body = Body::new(solid, &fill, [0.0; D]).unwrap();
    body.set_velocities(|place| {
        std::array::from_fn(|k| {
            let (along, across) = (place[k] - 0.6, place[(k + 1) % D] - 0.5);
            0.9 + 0.1 * (3.0 * along).sin() - 0.1 * across * across
        })
    })
    .unwrap();
    let mut simulation = Simulation::new(config.clone(), vec![body]).unwrap();
    for _ in 0..30 {
        let _ = simulation.step().unwrap();
    }
    let body = &simulation.bodies()[0];
    let stresses = (0..body.n_particles()).flat_map(|p| body.stress(p).0);
    [
        body.positions().as_flattened().to_vec(),
        body.velocities().as_flattened().to_vec(),
        stresses.collect(),
        body.masses().to_vec(),
    ]
}

/// Three inputs, and the line on which all of them change.
fn jet(value: f64, input: usize) -> Jet {
    let mut first = [0.0; LANES];
    (first[input], first[7]) = (1.0, [0.1, 3.0, 0.02][input]);
    Jet::new(value, first)
}

/// The largest difference of derivatives, over the largest derivative of a column and a direction.
fn distance(one: &[[f64; LANES]], two: &[[f64; LANES]]) -> f64 {
    let mut worst: f64 = 0.0;
    for lane in 0..LANES {
        let (mut largest, mut difference): (f64, f64) = (0.0, 0.0);
        for (one, two) in one.iter().zip(two) {
            assert!(one[lane].is_finite() && two[lane].is_finite());
            largest = largest.max(two[lane].abs());
            difference = difference.max((one[lane] - two[lane]).abs());
        }
        if difference > 0.0 {
            worst = worst.max(difference / largest);
        }
    }
    worst
}

/// Values and, for gradients, derivatives agree bit for bit; derivatives by operations, and values of `f64`, which is summed in
/// groups of particles, within roundoff.
fn compare<const D: usize>(config: &Config<D>) {
    let name = format!("{D}-D, {:?}, {:?}", config.shape, (config.update_order, config.transfer));
    let jets = run(config, jet);
    let by_operations = run(config, |value, input| ByOperations(jet(value, input)));
    let gradient = |value, input| Gradient { first: jet(value, input).first, value };
    let gradients = run(config, gradient);
    let plain = run(config, |value, _| value);
    for column in 0..jets.len() {
        let jets = &jets[column];
        let largest = jets.iter().fold(0.0_f64, |most, jet| most.max(jet.value.abs()));
        for (k, jet) in jets.iter().enumerate() {
            let (expected, gradient) = (by_operations[column][k].0, gradients[column][k]);
            assert_eq!((jet.value, k), (expected.value, k), "{name}: {k} of column {column}");
            // roundoff: of 30 steps, over the largest value; 1.1e-12 with hats, APIC and the stress last, which amplify it.
            let error = (jet.value - plain[column][k]).abs() / largest;
            assert!(error < LIMIT, "{name}: {k} of column {column}: {error:e}");
            assert_eq!((jet.value, jet.first), (gradient.value, gradient.first), "{name}");
        }
        // Masses are linear in the density.
        let is_curved = jets.iter().any(|jet| jet.second[7] != 0.0);
        assert_eq!(is_curved, column < 3, "{name}: column {column}");
        let first = |jet: &Jet| jet.first;
        let second = |jet: &Jet| jet.second;
        let expected: Vec<_> = by_operations[column].iter().map(|number| number.0).collect();
        for (order, of) in [first, second].into_iter().enumerate() {
            let all = |jets: &[Jet]| -> Vec<_> { jets.iter().map(of).collect() };
            let error = distance(&all(jets), &all(&expected));
            // roundoff: the sums are the same, their terms are rounded in another order.
            assert!(error < LIMIT, "{name}: order {}, column {column}: {error:e}", order + 1);
        }
    }
}

const FLIP: Transfer = Transfer::Flip { damping_time: f64::INFINITY };

fn compare_schemes<const D: usize>() {
    for shape in [Shape::Linear, Shape::QuadraticBSpline, Shape::CubicBSpline] {
        for update_order in [UpdateOrder::StressLast, UpdateOrder::ModifiedStressLast] {
            for transfer in [FLIP, Transfer::Apic] {
                compare(&Config::<D> {
                    shape,
                    update_order,
                    transfer,
                    courant_number: 0.2,
                    ..Config::with_cell(0.1)
                });
            }
        }
    }
}

#[test]
fn derivatives_by_plain_weights_are_those_of_jets_by_their_operations() {
    compare_schemes::<1>();
    compare_schemes::<2>();
    compare_schemes::<3>();
}

#[test]
fn the_hoop_and_gravity_have_their_derivatives() {
    for transfer in [FLIP, Transfer::Apic] {
        compare(&Config {
            shape: Shape::QuadraticBSpline,
            update_order: UpdateOrder::StressFirst,
            transfer,
            geometry: Geometry::Axisymmetric,
            gravity: [0.0, -0.7],
            ..Config::with_cell(0.1)
        });
    }
}
