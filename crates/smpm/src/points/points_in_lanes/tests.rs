//! Materials in lanes against the same particles one by one, bit for bit, at every level.

use simd_lanes::SimdLevel;

use super::PointsInLanes;
use crate::config::BulkViscosity;
use crate::points::material_points::{MaterialPoints, Points, Strain};
use crate::transfer::velocity_gradients::VelocityGradients;
use constitutive_models::Fault;
use constitutive_models::{
    Detonation, Fluid, JohnsonCook, JohnsonCookDamage, Jwl, Material, MaterialFamily, MieGruneisen,
    NeoHookean, NeoHookeanParameters, Solid, TensionCutOff, Units, Varying, VonMises,
    VonMisesParameters, library,
};

const UNITS: Units = Units::CM_G_US;

/// One particle, three, numbers that fill no register, and several batches.
const SIZES: [usize; 6] = [1, 3, 8, 13, 32, 71];

const STEPS: usize = 60;

/// Particles that are compressed, torn, sheared and turned, each at a rate of its own: they yield, melt and fail at different steps.
fn gradient(particle: usize, step: usize, plane: bool) -> [[f64; 3]; 3] {
    let (p, wave) = (particle as f64, (0.05 * step as f64 + particle as f64).sin());
    let rate = 0.004 * (1.0 + 0.7 * (0.9 * p).cos()) * if particle % 3 == 2 { 1.5 } else { -1.0 };
    let mut l = [
        [rate * (1.0 + 0.2 * wave), 0.011 * wave, 0.002],
        [0.004 * wave, 0.3 * rate, 0.006],
        [-0.003, 0.001, 0.1 * rate],
    ];
    if particle % 5 == 4 {
        // At rest, and in the plane also where others leave it.
        l = [[0.0; 3]; 3];
    }
    if plane || particle % 4 == 1 {
        (l[0][2], l[1][2], l[2][0], l[2][1]) = (0.0, 0.0, 0.0, 0.0);
    }
    l
}

/// Everything that is kept of particles, and the faults of each step.
fn driven(
    points: &mut dyn MaterialPoints<f64>,
    n: usize,
    gradient: impl Fn(usize, usize) -> [[f64; 3]; 3],
) -> (Vec<u64>, Vec<(u32, Fault)>) {
    let viscosity = BulkViscosity { quadratic: 1.5, linear: 0.06 };
    // Numbers against the order of memory.
    let numbers: Vec<u32> = (0..u32::try_from(n).unwrap()).rev().collect();
    let mut faults = vec![];
    for step in 0..STEPS {
        let (dt, time) = (0.5, 0.5 * (step + 1) as f64);
        let strain = Strain { dt, time, cell: 0.2, viscosity };
        points.pass(&mut |points| {
            for begin in (0..n).step_by(32) {
                let batch = begin..n.min(begin + 32);
                let mut l = VelocityGradients::zero();
                for (i, p) in batch.clone().enumerate() {
                    l.set(i, &gradient(p, step));
                }
                faults.extend(points.update(batch.clone(), strain, &l, &numbers[batch]));
            }
        });
    }
    let mut bits = vec![];
    for place in 0..n {
        assert!(points.show_numbers(place, &mut |number| bits.push(number.to_bits())));
    }
    (bits, faults)
}

fn each_lane_has_the_bits_of_its_particle<M: MaterialFamily<f64> + 'static>(
    make: impl Fn() -> M,
    gradient: impl Fn(usize, usize, bool) -> [[f64; 3]; 3],
) -> Vec<Fault>
where
    <M as Material<f64>>::State: 'static,
{
    let mut seen = vec![];
    for n in SIZES {
        let places: Vec<_> = (0..n).map(|p| [0.1 * p as f64, 0.0, 0.0]).collect();
        for plane in [true, false] {
            let along = |particle: usize, step: usize| gradient(particle, step, plane);
            let mut alone = Points::at_start(make(), plane, &places);
            let expected = driven(&mut alone, n, along);
            for level in SimdLevel::available() {
                let mut points = PointsInLanes::at_start(make(), plane, &places);
                points.level = level;
                let found = driven(&mut points, n, along);
                assert_eq!(found, expected, "{n} particles, {level}, plane: {plane}");
            }
            seen.extend(expected.1.into_iter().map(|(_, fault)| fault));
        }
    }
    seen
}

fn steel() -> Solid<MieGruneisen<f64>, JohnsonCookDamage<f64>> {
    // So little heat capacity that some melt.
    let mut flow = library::steel_strength(UNITS);
    flow.specific_heat *= 0.002;
    Solid {
        equation: MieGruneisen::new(library::steel_equation(UNITS)).unwrap(),
        strength: JohnsonCookDamage::new(flow, library::steel_damage(UNITS)).unwrap(),
    }
}

#[test]
fn steel_that_yields_melts_and_breaks() {
    assert_eq!(each_lane_has_the_bits_of_its_particle(steel, gradient), []);
    // All of it happened, and to some particles alone.
    let places: Vec<_> = (0..71).map(|_| [0.0; 3]).collect();
    let mut points = PointsInLanes::at_start(steel(), false, &places);
    let _ = driven(&mut points, 71, |particle, step| gradient(particle, step, false));
    let share = |holds: &dyn Fn(constitutive_models::Observed<f64>) -> bool| {
        (0..71).filter(|&place| holds(points.observe(place))).count()
    };
    let shares = [
        share(&|it| it.plastic_strain > 0.0),
        share(&|it| it.damage >= 1.0),
        share(&|it| it.temperature > 1498.0),
    ];
    assert!(shares.iter().all(|share| (3..68).contains(share)), "{shares:?}");
}

#[test]
fn steel_of_which_a_particle_fails() {
    let collapse = |particle: usize, step: usize, plane: bool| {
        let mut l = gradient(particle, step, plane);
        if (particle == 5 && step == 20) || (particle == 40 && step == 30) {
            l[0][0] = -4.0;
        }
        l
    };
    let faults = each_lane_has_the_bits_of_its_particle(steel, collapse);
    assert!(faults.iter().any(|fault| fault.quantity == "V/V_0"), "{faults:?}");
}

#[test]
fn a_liquid_that_cavitates_and_an_explosive_that_burns() {
    let water = || Solid {
        equation: TensionCutOff::new(MieGruneisen::new(library::water(UNITS)).unwrap(), 1e-6)
            .unwrap(),
        strength: Fluid,
    };
    assert_eq!(each_lane_has_the_bits_of_its_particle(water, gradient), []);
    let lit = Detonation { point: [0.0; 3], cells: 4.0 };
    let tnt = || Solid { equation: Jwl::new(library::tnt(UNITS), lit).unwrap(), strength: Fluid };
    assert_eq!(each_lane_has_the_bits_of_its_particle(tnt, gradient), []);
}

#[test]
fn a_plastic_metal_and_rubber() {
    let copper =
        VonMisesParameters { shear_modulus: 0.43, yield_stress: 2e-3, hardening_modulus: 3e-3 };
    let metal = || Solid {
        equation: MieGruneisen::new(library::copper_equation(UNITS)).unwrap(),
        strength: VonMises::new(copper).unwrap(),
    };
    assert_eq!(each_lane_has_the_bits_of_its_particle(metal, gradient), []);
    let rubber = NeoHookeanParameters { density: 1.1, shear_modulus: 2.0, bulk_modulus: 5.0 };
    assert_eq!(
        each_lane_has_the_bits_of_its_particle(|| NeoHookean::new(rubber).unwrap(), gradient),
        []
    );
}

/// Particles of one material, each with constants of its own.
fn varying_lanes_have_the_bits_of_their_particles<M: MaterialFamily<f64> + Copy + 'static>(
    make: impl Fn(f64) -> M,
) where
    <M as Material<f64>>::State: 'static,
{
    for n in SIZES {
        let places: Vec<_> = (0..n).map(|p| [0.1 * p as f64, 0.0, 0.0]).collect();
        let materials: Vec<M> = (0..n).map(|p| make(1.0 + 0.4 * (1.7 * p as f64).sin())).collect();
        let of_one = Varying::like(materials[0]);
        let along = |particle: usize, step: usize| gradient(particle, step, false);
        let states = Varying::starts::<f64>(&materials, &places);
        let mut alone = Points::of_states(of_one, false, &states);
        let expected = driven(&mut alone, n, along);
        for level in SimdLevel::available() {
            let mut points = PointsInLanes::of_states(of_one, false, &states);
            points.level = level;
            assert_eq!(driven(&mut points, n, along), expected, "{n} particles, {level}");
        }
        // Each is the plain material with its constants.
        for (p, material) in materials.iter().enumerate() {
            let mut plain = Points::at_start(*material, false, &places[..1]);
            let of_p = |_: usize, step: usize| gradient(p, step, false);
            let (bits, _) = driven(&mut plain, 1, of_p);
            let mut found = vec![];
            assert!(alone.show_numbers(p, &mut |number| found.push(number.to_bits())));
            // The constants are behind the numbers of the plain state.
            assert_eq!(found[..bits.len()], bits);
            assert!(found.len() > bits.len());
        }
    }
}

#[test]
fn constants_of_each_lane_are_those_of_its_particle() {
    varying_lanes_have_the_bits_of_their_particles(|factor| {
        let mut flow = library::steel_strength(UNITS);
        (flow.a, flow.n, flow.c) = (flow.a * factor, flow.n * factor, flow.c * factor);
        let mut equation = library::steel_equation(UNITS);
        equation.density *= factor;
        let equation = MieGruneisen::new(equation).unwrap();
        Solid { equation, strength: JohnsonCook::new(flow).unwrap() }
    });
    varying_lanes_have_the_bits_of_their_particles(|factor| {
        let mut hardening = library::copper_linear_hardening(UNITS);
        hardening.yield_stress *= factor;
        let equation = MieGruneisen::new(library::copper_equation(UNITS)).unwrap();
        Solid { equation, strength: VonMises::new(hardening).unwrap() }
    });
}
