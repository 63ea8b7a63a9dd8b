//! Runs resumed from a snapshot, on any number of threads, and runs that repeat the steps of another.

use perturbation_moments::Jet;
use smpm::material::{
    Detonation, Fluid, JohnsonCook, JohnsonCookDamage, Jwl, Material, MieGruneisen, Model,
    NeoHookean, NeoHookeanParameters, Now, Observed, Solid, TensionCutOff, Units, VonMises,
    VonMisesParameters, library,
};
use smpm::tensor::Symmetric;
use smpm::{
    Body, BulkViscosity, Config, Contact, Error, Fault, Fill, Gauge, Number, Place, Plan, Quantity,
    Shape, Simulation, Transfer, Window,
};

use crate::fixtures::{bits, block, elastic, goes_on_to_the_bit, steps};

const UNITS: Units = Units::CM_G_US;

/// Explosive between steel and water; `scale` is that of the yield stress.
fn explosion<S: Number>(scale: S, change: impl FnOnce(&mut Config<2>)) -> Simulation<S, 2> {
    let of = |_: &'static str, value| S::constant(value);
    let burn = Detonation { point: [0.5, 0.5, 0.0], cells: 2.0 };
    let tnt =
        Solid { equation: Jwl::new(library::tnt(UNITS).map(of), burn).unwrap(), strength: Fluid };
    let strength = library::steel_strength(UNITS)
        .map(|name, value| if name == "a" { scale * value } else { S::constant(value) });
    let damage = library::steel_damage(UNITS).map(of);
    let steel = Solid {
        equation: MieGruneisen::new(library::steel_equation(UNITS).map(of)).unwrap(),
        strength: JohnsonCookDamage::new(strength, damage).unwrap(),
    };
    let water = MieGruneisen::new(library::water(UNITS).map(of)).unwrap();
    let water =
        Solid { equation: TensionCutOff::new(water, S::constant(0.0)).unwrap(), strength: Fluid };
    let still = [0.0; 2];
    let bodies = vec![
        Body::new(tnt, &block([0.0, 0.0], [1.0, 1.0]), still).unwrap(),
        Body::new(steel, &block([1.0, 0.0], [1.4, 1.0]), still).unwrap(),
        Body::new(water, &block([0.0, 1.0], [1.0, 1.5]), still).unwrap(),
    ];
    let viscosity = BulkViscosity { quadratic: 1.5, linear: 0.3 };
    let mut config = Config { viscosity, ..Config::with_cell(0.1) };
    change(&mut config);
    Simulation::new(config, bodies).unwrap()
}

#[test]
fn a_run_goes_on_from_a_snapshot_to_the_bit_on_any_number_of_threads() {
    let cubic = |config: &mut Config<2>| {
        config.shape = Shape::CubicBSpline;
        config.contact = Contact::Friction { coefficient: 0.2 };
    };
    goes_on_to_the_bit(|| explosion(1.0, |_| ()), [25, 40]);
    goes_on_to_the_bit(|| explosion(1.0, |config| config.transfer = Transfer::Apic), [25, 40]);
    goes_on_to_the_bit(|| explosion(1.0, cubic), [25, 40]);
}

#[test]
fn so_does_a_run_with_jets() {
    goes_on_to_the_bit(|| explosion(Jet::variable(1.0, 2), |_| ()), [25, 40]);
}

#[test]
fn particles_keep_their_numbers_when_they_change_places() {
    let mut simulation = explosion(1.0, |_| ());
    let start = simulation.bodies()[0].positions().to_vec();
    steps(&mut simulation, 40);
    let body = &simulation.bodies()[0];
    for (p, (x, from)) in body.positions().iter().zip(&start).enumerate() {
        assert_eq!(x.map(f64::to_bits), body.position(p).map(f64::to_bits));
        // Nobody has gone further than half the block.
        assert!((0..2).all(|k| (x[k] - from[k]).abs() < 0.5), "{p}: {from:?} {x:?}");
        let v = body.velocity(p).map(f64::to_bits);
        assert_eq!(body.velocities()[p].map(f64::to_bits), v);
    }
}

#[test]
fn a_snapshot_of_another_simulation_is_refused_and_changes_nothing() {
    let mut simulation = explosion(1.0, |_| ());
    steps(&mut simulation, 3);
    let before = bits(&simulation);
    let of_jets = {
        let mut bytes = vec![];
        explosion(Jet::variable(1.0, 0), |_| ()).snapshot(&mut bytes).unwrap();
        bytes
    };
    let error = simulation.restore(of_jets.as_slice()).unwrap_err();
    let expected = Error::ForeignSnapshot { quantity: "parts of a number", found: 17, expected: 1 };
    assert_eq!(error, expected);
    let mut bytes = vec![];
    simulation.snapshot(&mut bytes).unwrap();
    let half = &bytes[..bytes.len() / 2];
    assert!(matches!(simulation.restore(half), Err(Error::Snapshot { .. })));
    assert!(bits(&simulation) == before);
}

/// A strip that stretches and shears, of any material.
fn strip(material: impl Into<Model<f64>>) -> Simulation<f64, 2> {
    let mut body = Body::new(material, &block([0.0; 2], [1.0, 0.3]), [0.0; 2]).unwrap();
    body.set_velocities(|x| [0.02 * x[0], 0.01 * x[0] * x[0]]).unwrap();
    Simulation::new(Config::with_cell(0.1), vec![body]).unwrap()
}

#[test]
fn the_other_materials_have_snapshots_too() {
    let equation = || MieGruneisen::new(library::steel_equation(UNITS)).unwrap();
    let rubber = NeoHookeanParameters { density: 1.0, bulk_modulus: 0.02, shear_modulus: 0.01 };
    let metal =
        VonMisesParameters { shear_modulus: 0.8, yield_stress: 0.005, hardening_modulus: 0.01 };
    let johnson_cook = || JohnsonCook::new(library::steel_strength(UNITS)).unwrap();
    let makes: [&(dyn Fn() -> Simulation<f64, 2> + Sync); 4] = [
        &|| strip(NeoHookean::new(rubber).unwrap()),
        &|| strip(Solid { equation: equation(), strength: VonMises::new(metal).unwrap() }),
        &|| strip(elastic(8.0, 2.0, 0.3)),
        &|| strip(Solid { equation: equation(), strength: johnson_cook() }),
    ];
    for make in makes {
        goes_on_to_the_bit(make, [20, 30]);
    }
}

/// A material that remembers, and does not say what.
#[derive(Debug)]
struct Silent;

impl Material<f64> for Silent {
    type State = f64;

    fn density(&self) -> f64 {
        1.0
    }

    fn start(&self, _position: [f64; 3]) -> f64 {
        0.0
    }

    fn update(&self, _now: &Now<f64>, _state: &mut f64) -> Result<Symmetric<f64>, Fault> {
        Ok(Symmetric::zero())
    }

    fn wave_speed(&self, _volume: f64, _state: &f64) -> f64 {
        1.0
    }

    fn observe(&self, _state: &f64) -> Observed<f64> {
        Observed::of_energy(0.0)
    }
}

#[test]
fn a_material_that_does_not_say_what_it_remembers_has_no_snapshot() {
    let fill = Fill::of([0.1], ([0.0], [1.0]), |_| true).unwrap();
    let body = Body::one_by_one(Silent, &fill, [0.0]).unwrap();
    let simulation = Simulation::new(Config::with_cell(0.2), vec![body]).unwrap();
    assert_eq!(simulation.snapshot(vec![]).unwrap_err(), Error::MaterialNotStored { body: 0 });
}

#[test]
fn a_run_takes_the_steps_of_another() {
    let plan = Plan {
        gauges: vec![Gauge { name: "steel".into(), body: 1, place: Place::Nearest([1.2, 0.5]) }],
        quantities: vec![Quantity::FlowStress],
        windows: vec![Window::at(0.25), Window { from: 0.25, to: 0.5 }],
    };
    let mut mean = explosion(1.0, |_| ());
    let record = mean.record(&plan).unwrap();
    assert_eq!(record.schedule.n_steps() as u64, mean.n_steps());
    let mut same = explosion(1.0, |_| ());
    assert_eq!(same.replay(&plan, &record.schedule).unwrap(), record.values);
    assert!(bits(&same) == bits(&mean));
    let mut sample = explosion(0.7, |_| ());
    assert!(sample.replay(&plan, &record.schedule).unwrap() != record.values);
    assert_eq!(sample.n_steps(), mean.n_steps());
}

#[test]
fn a_step_beyond_the_courant_number_one_is_refused_and_the_run_stays_ended() {
    let mut simulation = explosion(1.0, |_| ());
    let most = simulation.longest_step() / 0.4;
    let _ = simulation.step_of(0.99 * most).unwrap();
    let most = simulation.longest_step() / 0.4;
    let error = simulation.step_of(1.01 * most).unwrap_err();
    let Error::Courant { step: 2, dt, limit, .. } = error else {
        unreachable!("{error}");
    };
    assert_eq!((dt, limit), (1.01 * most, most));
    assert_eq!(simulation.step().unwrap_err(), error);
}
