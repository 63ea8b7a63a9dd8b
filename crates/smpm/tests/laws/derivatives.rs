//! The derivatives that jets and gradients carry through a step, against differences of whole runs with `f64`.

use perturbation_moments::{Jet, LANES};
use smpm::material::{LinearElasticParameters, LinearElasticSolid};
use smpm::{Body, Config, Fill, Geometry, Number, Shape, Simulation, SurfaceLoad, Transfer};

/// Step of the differences, along the line on which all inputs change.
const STEP: f64 = 2e-5;
/// The direction of a jet along that line.
const LINE: usize = 7;
/// The line, by input.
const SLOPES: [f64; 3] = [0.1, 3.0, 0.02];

/// What is compared of a run: columns of numbers of a kind.
type Columns<S> = [Vec<S>; 4];

/// Places, velocities, stresses and masses of an elastic body that stretches, shears and rotates across cells, with loads on its
/// surface where there is gravity, after steps of these lengths, or thirty of those that it allows.
fn run<S: Number, const D: usize>(
    config: &Config<D>,
    steps: &mut Vec<f64>,
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
    if config.gravity.iter().any(|&along| along != 0.0) {
        let (within, traction) = ([[0.0; D], [2.0; D]], [0.2; D]);
        let load = SurfaceLoad { within, pressure: 0.5, traction, history: vec![] };
        body = body.loaded(&[load]).unwrap();
    }
    let mut simulation = Simulation::new(config.clone(), vec![body]).unwrap();
    if steps.is_empty() {
        steps.extend((0..30).map(|_| simulation.step().unwrap().dt));
    } else {
        for &dt in &*steps {
            let _ = simulation.step_of(dt).unwrap();
        }
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
    (first[input], first[LINE]) = (1.0, SLOPES[input]);
    Jet::new(value, first)
}

/// The largest difference of two columns, over the largest number of the second.
fn distance(one: &[f64], two: &[f64]) -> f64 {
    let largest = two.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let apart = one.iter().zip(two).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    if apart > 0.0 { apart / largest } else { 0.0 }
}

/// Values of jets are those of `f64`, which is summed in groups of particles, within roundoff; derivatives are the slopes of runs at
/// other values.
fn compare<const D: usize>(config: &Config<D>) {
    let (name, mut steps) = (format!("{D}-D, {:?}, {:?}", config.shape, config.transfer), vec![]);
    let plain = run(config, &mut steps, |value, _| value);
    let jets = run(config, &mut steps, jet);
    let ends = [STEP, -STEP].map(|step| {
        run(config, &mut steps, |value, input| jet(value + step * SLOPES[input], input))
    });
    // Where a particle changes cells within a step of the differences, the second derivative of a run with quadratic functions
    // jumps, the third with cubic ones: an error of the order of the step.
    let (limit, limit_of_second) = match config.shape {
        Shape::QuadraticBSpline => (1e-5, None),
        Shape::CubicBSpline => (1e-6, Some(2e-3)),
    };
    for column in 0..jets.len() {
        let name = format!("{name}: column {column}");
        let of = |read: fn(&Jet) -> f64| -> Vec<f64> { jets[column].iter().map(read).collect() };
        // roundoff: of 30 steps.
        assert!(distance(&of(|jet| jet.value), &plain[column]) < 1e-12, "{name}");
        let difference = |read: fn(&Jet) -> f64| -> Vec<f64> {
            let both = ends[0][column].iter().zip(&ends[1][column]);
            both.map(|(a, b)| (read(a) - read(b)) / (2.0 * STEP)).collect()
        };
        let error = distance(&of(|jet| jet.first[LINE]), &difference(|end| end.value));
        assert!(error < limit, "{name}: first derivatives: {error:e}");
        // Masses are linear in the density.
        let curved = of(|jet| jet.second[LINE]);
        assert_eq!(curved.iter().any(|&second| second != 0.0), column < 3, "{name}");
        if let Some(limit) = limit_of_second.filter(|_| column < 3) {
            let error = distance(&curved, &difference(|end| end.first[LINE]));
            assert!(error < limit, "{name}: second derivatives: {error:e}");
        }
    }
}

fn compare_schemes<const D: usize>() {
    for shape in [Shape::QuadraticBSpline, Shape::CubicBSpline] {
        for transfer in [Transfer::Flip, Transfer::Apic] {
            let usual = Config::with_cell(0.1);
            compare(&Config::<D> { shape, transfer, courant_number: 0.2, ..usual });
        }
    }
}

#[test]
fn derivatives_are_those_of_differences_of_runs() {
    compare_schemes::<1>();
    compare_schemes::<2>();
    compare_schemes::<3>();
}

#[test]
fn the_hoop_gravity_and_loads_have_their_derivatives() {
    for transfer in [Transfer::Flip, Transfer::Apic] {
        compare(&Config {
            shape: Shape::CubicBSpline,
            transfer,
            geometry: Geometry::Axisymmetric,
            gravity: [0.0, -0.7],
            ..Config::with_cell(0.1)
        });
    }
}
