//! Materials whose constants differ from particle to particle: against the same material everywhere, against two bodies, and from a
//! snapshot.

use smpm::material::{
    Detonation, Fluid, JohnsonCook, Jwl, Material, MieGruneisen, Model, Solid, Units, Varying,
    VonMises, library,
};
use smpm::{Body, BoundaryKind, Config, Error, ParameterError, Simulation};

use crate::fixtures::{bits, block, elastic, goes_on_to_the_bit, steps, wall};

const UNITS: Units = Units::CM_G_US;

type Metal = Solid<MieGruneisen<f64>, JohnsonCook<f64>>;

fn metal(yield_stress: f64) -> Result<Metal, Error> {
    let mut flow = library::steel_strength(UNITS);
    flow.a = yield_stress;
    Ok(Solid {
        equation: MieGruneisen::new(library::steel_equation(UNITS))?,
        strength: JohnsonCook::new(flow)?,
    })
}

fn copper() -> Solid<MieGruneisen<f64>, VonMises<f64>> {
    Solid {
        equation: MieGruneisen::new(library::copper_equation(UNITS)).unwrap(),
        strength: VonMises::new(library::copper_linear_hardening(UNITS)).unwrap(),
    }
}

/// Bodies that run into a wall.
fn impact(bodies: Vec<Body<f64, 2>>) -> Simulation<f64, 2> {
    let boundaries = vec![wall(BoundaryKind::Symmetry)];
    let config = Config { boundaries, ..Config::with_cell(0.1) };
    Simulation::new(config, bodies).unwrap()
}

fn same_everywhere(material: impl Into<Model<f64>>, speed: f64) {
    let material = material.into();
    let box_of = block([0.0, 0.0], [1.0, 0.65]);
    let velocity = [-speed, 0.1 * speed];
    let run = |body| {
        let mut simulation = impact(vec![body]);
        steps(&mut simulation, 60);
        bits(&simulation)
    };
    let plain = run(Body::new(material, &box_of, velocity).unwrap());
    let varying = run(Body::varying(|_, _| Ok(material), &box_of, velocity).unwrap());
    assert!(plain == varying);
}

#[test]
fn equal_constants_everywhere_are_bitwise_the_plain_material() {
    same_everywhere(metal(0.00792).unwrap(), 0.03);
    same_everywhere(elastic(7.8, 2.0, 0.3), 0.001);
    same_everywhere(copper(), 0.03);
}

#[test]
fn two_layers_in_one_body_are_two_bonded_bodies() {
    let (soft, stiff) = (elastic(4.0, 1.0, 0.3), elastic(8.0, 2.0, 0.3));
    let velocity = [-0.002, 0.0];
    let in_one = |_: usize, x: &[f64; 2]| Ok(if x[0] < 0.5 { soft } else { stiff });
    let one = Body::varying(in_one, &block([0.0, 0.0], [1.0, 0.4]), velocity).unwrap();
    // Particles by their places: the lattice of the whole goes row by row.
    let order = |n: usize| (0..n).flat_map(move |row| (0..10).map(move |k| (row, k)));
    let two = vec![
        Body::new(soft, &block([0.0, 0.0], [0.5, 0.4]), velocity).unwrap(),
        Body::new(stiff, &block([0.5, 0.0], [1.0, 0.4]), velocity).unwrap(),
    ];
    let (mut one, mut two) = (impact(vec![one]), impact(two));
    steps(&mut one, 80);
    steps(&mut two, 80);
    assert!((one.time() / two.time() - 1.0).abs() < 1e-13);
    let whole = &one.bodies()[0];
    let mut largest = 0.0_f64;
    for (half, body) in two.bodies().iter().enumerate() {
        for (row, k) in order(8) {
            let (p, q) = (row * 20 + 10 * half + k, row * 10 + k);
            for i in 0..2 {
                assert!((whole.position(p)[i] - body.position(q)[i]).abs() < 1e-14);
                assert!((whole.velocity(p)[i] - body.velocity(q)[i]).abs() < 1e-15);
            }
            largest = largest.max(whole.stress(p).0[0].abs());
            let difference = whole.stress(p).0[0] - body.stress(q).0[0];
            // Sums over the nodes in another order: roundoff of the stress, in 80 steps.
            assert!(difference.abs() < 1e-13, "{difference:e}");
            assert!((whole.masses()[p] / body.masses()[q] - 1.0).abs() < 1e-15);
        }
    }
    // The stress of the impact is there: rho c v of the softer half.
    assert!(largest > 0.002, "{largest}");
}

/// Steel whose yield stress grows along the plate.
fn graded() -> Simulation<f64, 2> {
    let graded = |_: usize, x: &[f64; 2]| metal(0.008 * (0.5 + x[0]));
    impact(vec![Body::varying(graded, &block([0.0, 0.0], [1.0, 0.65]), [-0.03, 0.003]).unwrap()])
}

#[test]
fn a_varying_body_resumes_from_a_snapshot_to_the_bit_on_any_number_of_threads() {
    goes_on_to_the_bit(graded, [40, 60]);
    // It yields more where it is weaker.
    let mut simulation = graded();
    steps(&mut simulation, 60);
    let body = &simulation.bodies()[0];
    let flow = |p: usize| body.observe(p).flow_stress;
    assert!(flow(19) > 1.5 * flow(0), "{} {}", flow(19), flow(0));
}

#[test]
fn constants_that_cannot_be_are_refused_with_particle_place_and_limit() {
    let box_of = block([0.0, 0.0], [1.0, 0.1]);
    let weak = |particle: usize, _: &[f64; 2]| metal(if particle == 21 { -0.001 } else { 0.008 });
    let error = Body::<f64, 2>::varying(weak, &box_of, [0.0; 2]).unwrap_err();
    let Error::AtParticle { particle: 21, place, reason } = &error else { panic!("{error}") };
    let expected = ParameterError::NotPositive { name: "a of Johnson-Cook", value: -0.001 };
    assert_eq!(**reason, Error::Parameter(expected));
    assert!((place[0] - 0.075).abs() < 1e-15 && (place[1] - 0.075).abs() < 1e-15);
    let words = "particle 21 at [0.07500000000000001, 0.07500000000000001]: a of Johnson-Cook is -0.001; it must be greater than 0";
    assert_eq!(error.to_string(), words);
    // Its detonation point is not a number that particles may have of their own.
    let tnt = |_: usize, _: &[f64; 2]| {
        let burn = Detonation { point: [0.0; 3], cells: 2.0 };
        let equation = Jwl::new(library::tnt(UNITS), burn)?;
        Ok(Solid { equation, strength: Fluid })
    };
    let error = Body::<f64, 2>::varying(tnt, &box_of, [0.0; 2]).unwrap_err();
    assert!(matches!(error, Error::ConstantsCannotVary), "{error}");
}

#[test]
fn the_numbers_of_a_varying_material_are_those_of_its_state_and_its_own() {
    let plain = metal(0.008).unwrap();
    let mut state = Material::<f64>::start(&Varying::like(plain), [0.0; 3]);
    let mut n = [0; 2];
    assert!(plain.visit_numbers(&mut state.history.clone(), |_: &mut f64| n[0] += 1));
    assert!(Varying::like(plain).visit_numbers(&mut state, |_: &mut f64| n[1] += 1));
    // Mie-Grueneisen: 8 parameters at most and a modulus; Johnson-Cook: 13 parameters and two numbers that follow.
    let mut own = 0;
    assert!({ plain }.visit_constants(|_: &mut f64| own += 1));
    assert_eq!(n[1], n[0] + own);
    assert!(own >= 15 + 5, "{own}");
}
