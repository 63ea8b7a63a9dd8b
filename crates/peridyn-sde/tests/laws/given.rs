//! Strength and stiffness that are given at the nodes.

use peridyn_sde::{
    BondConfig, BondOrder, BondValue, Bonds, CrackRun, CrackStudy, DisorderField, Error,
    FinalState, Loading, Nodes, Notch, PathConfig, Precision, Procedure, Program, Scheme,
    SimulationConfig, Stiffness, Strain, Strength, StudyLaw, VolumeCorrection,
};
use random_fields::{Correlation, CorrelationFunction, GaussianField, Marginal};
use sde_integrators::Noise;

use crate::fixtures::{PLATE, at, config, cube, in_time, overdamped};

const N: usize = 16;
pub(super) const N_NODES: usize = N * N;
/// Damage from which a node counts as damaged.
pub(super) const THRESHOLD: f64 = 0.3;
const SEED: u64 = 11;
pub(super) const STRETCH: f64 = 1e-3;
const REALISATION: u64 = 5;
const NOTCH: Notch = Notch { mouth: [0.0, 8.0], tip: [5.0, 8.0] };

/// Of the bonds of the plate.
pub(super) fn bond_config() -> BondConfig {
    BondConfig { volume_correction: VolumeCorrection::Ramp, ..config(2) }
}

/// A pull at the lowest and highest two rows of the plate, and the highest.
pub(super) fn tension(nodes: &Nodes<2>, program: Program) -> (Loading<2>, Vec<usize>) {
    let (edges, upper) = (at(nodes, |x| x[1] < 2.0 || x[1] > 14.0), at(nodes, |x| x[1] > 14.0));
    let gradient = [[0.0, 0.0], [0.0, 1.0]];
    let loading = Loading::new(nodes.positions().len());
    (loading.stretch(nodes, &edges, [true; 2], gradient, program).unwrap(), upper)
}

/// A plate of 16 by 16 nodes whose lowest and highest two rows are loaded in tension.
pub(super) struct Plate {
    nodes: Nodes<2>,
    bonds: Bonds,
    loading: Loading<2>,
    pub(super) simulation: SimulationConfig,
    upper: Vec<usize>,
    free: Vec<bool>,
}

impl Plate {
    fn new(nodes: Nodes<2>) -> Self {
        let bonds = Bonds::new(&nodes, &bond_config()).unwrap();
        let free: Vec<bool> = nodes.positions().iter().map(|x| x[1] > 2.0 && x[1] < 14.0).collect();
        // A body that is stretched evenly by 0.9 of the critical stretch, over 400 steps.
        let dt = 0.2;
        let program = Program::Linear { rate: 0.9 * STRETCH / (400.0 * dt) };
        let (loading, upper) = tension(&nodes, program);
        let dynamics = overdamped(&free, Scheme::EulerMaruyama, 1e-9);
        let simulation = in_time(dynamics, dt, SEED);
        Self { nodes, bonds, loading, simulation, upper, free }
    }

    pub(super) fn lattice() -> Self {
        Self::new(cube(N as f64, PLATE))
    }

    /// Whether each node is free.
    pub(super) fn free(&self) -> &[bool] {
        &self.free
    }

    pub(super) fn body(&self) -> (&Nodes<2>, &Bonds) {
        (&self.nodes, &self.bonds)
    }

    pub(super) fn study<'a>(
        &'a self,
        strength: Strength<'a>,
        stiffness: Stiffness<'a>,
    ) -> CrackStudy<'a> {
        CrackStudy {
            nodes: &self.nodes,
            bonds: &self.bonds,
            law: StudyLaw::BondBased,
            order: BondOrder::List,
            precision: Precision::Double,
            strain: Strain::Finite,
            strength,
            stiffness,
            no_fail: &[],
            notch: NOTCH,
            loading: &self.loading,
            procedure: Procedure::Dynamic { simulation: &self.simulation, n_steps: 400 },
            load: (&self.upper, 1),
            n_windows: 10,
            path: PathConfig::of_horizon(2.0),
            border: 14.0,
            damage_threshold: THRESHOLD,
        }
    }

    fn run(&self, strength: Strength<'_>, stiffness: Stiffness<'_>) -> Result<CrackRun, Error> {
        let study = self.study(strength, stiffness);
        study.run(REALISATION..REALISATION + 1, &[REALISATION])
    }

    pub(super) fn field(&self, mean: f64, number: u32) -> (DisorderField, Vec<f64>) {
        let correlation = Correlation { function: CorrelationFunction::Matern32, length: 4.0 };
        let gaussian =
            GaussianField::by_circulant_embedding(self.nodes.positions(), 1.0, correlation);
        let law = Marginal::Lognormal { mean, coefficient_of_variation: 0.3 };
        let field = DisorderField::new(gaussian.unwrap(), law, number).unwrap();
        let mut values = vec![0.0; self.nodes.positions().len()];
        field.sample(&Noise::new(SEED), REALISATION, &mut values).unwrap();
        (field, values)
    }
}

#[test]
fn mean_loads_converge_with_the_square_of_the_step_and_noise_alone_has_loads_of_both_signs() {
    let mut plate = Plate::lattice();
    let mut loads = |(dt, n_steps): (f64, u64), temperature: f64, n_windows: u64| {
        let dynamics = overdamped(plate.free(), Scheme::Heun, temperature);
        plate.simulation = in_time(dynamics, dt, SEED);
        let simulation = &plate.simulation;
        let procedure = Procedure::Dynamic { simulation, n_steps };
        let study = plate.study(Strength::Uniform(1.0), Stiffness::Uniform);
        CrackStudy { procedure, n_windows, ..study }.run(0..1, &[]).unwrap().loads.swap_remove(0)
    };
    let [coarse, middle, fine] = [(0.2, 20), (0.1, 40), (0.05, 80)].map(|it| loads(it, 0.0, 1)[0]);
    let ratio = (coarse - middle) / (middle - fine);
    // Of first order it is 2, of second order 4; the load at ends of steps alone is off by one part in 40.
    assert!((3.0..5.0).contains(&ratio), "{ratio}");
    assert!((coarse / fine - 1.0).abs() < 2e-3, "{coarse} {fine}");
    // Its deviation is far above the pull of the ramp; a mean size would be positive in all windows.
    let noisy = loads((0.2, 40), 1e-3, 40);
    let n_positive = noisy.iter().filter(|&&load| load > 0.0).count();
    assert!((1..40).contains(&n_positive), "{noisy:?}");
}

#[test]
fn a_study_on_a_lattice_has_the_cracks_of_one_in_a_list() {
    let plate = Plate::lattice();
    let (strength, _) = plate.field(STRETCH, 0);
    let strength = Strength::Field { field: &strength, value: BondValue::Mean };
    let in_list = CrackStudy { no_fail: &[0, 1], ..plate.study(strength, Stiffness::Uniform) };
    let on_lattice = CrackStudy { order: BondOrder::Lattice, ..in_list };
    let list = in_list.run(0..3, &[1]).unwrap();
    let lattice = on_lattice.run(0..3, &[1]).unwrap();
    assert_eq!(lattice.broken, list.broken);
    assert!(list.broken.iter().all(|&broken| broken > 20), "{:?}", list.broken);
    // Bonds that break in one step come in the order in which they are visited.
    let sorted = |run: &CrackRun| {
        let mut history: Vec<_> = run.kept[0].history.iter().map(|at| (at.step, at.bond)).collect();
        history.sort_unstable();
        history
    };
    assert_eq!(sorted(&lattice), sorted(&list));
    for (a, b) in lattice.loads.iter().flatten().zip(list.loads.iter().flatten()) {
        // Roundoff of 400 steps.
        assert!((a - b).abs() < 1e-9 * b.abs(), "{a} {b}");
    }
    let (stiffness, _) = plate.field(1.0, 1);
    let stiffness = Stiffness::Field { field: &stiffness, value: BondValue::Mean };
    let refused = CrackStudy { stiffness, ..on_lattice }.run(0..1, &[]);
    assert_eq!(refused.unwrap_err(), Error::UniformStiffness { law: "a lattice" });
}

/// Ranges that are no multiples of the lanes, run from the last to the first; a range that is there already is refused.
#[test]
fn ranges_that_run_apart_are_one_run() {
    let plate = Plate::lattice();
    let study = plate.study(Strength::Uniform(STRETCH), Stiffness::Uniform);
    let whole = study.run(0..11, &[0, 9]).unwrap();
    assert!(whole.broken.iter().all(|&broken| broken > 0), "{:?}", whole.broken);
    let [last, middle, first] = [8..11, 4..8, 0..4].map(|range| study.run(range, &[0, 9]).unwrap());
    let mut joined = first;
    joined.append(middle.clone()).unwrap();
    joined.append(last).unwrap();
    assert_eq!(joined, whole);
    assert_eq!(joined.append(middle), Err(Error::Doubled { realisation: 4 }));
    assert_eq!(joined, whole);
}

#[test]
fn given_values_break_the_bonds_that_a_field_of_the_same_values_breaks() {
    let plate = Plate::lattice();
    let (strength, strengths) = plate.field(STRETCH, 0);
    let (stiffness, factors) = plate.field(1.0, 1);
    for value in [BondValue::Mean, BondValue::Minimum] {
        let drawn = plate.run(
            Strength::Field { field: &strength, value },
            Stiffness::Field { field: &stiffness, value },
        );
        let given = plate.run(
            Strength::Given { values: &strengths, value },
            Stiffness::Given { values: &factors, value },
        );
        let drawn = drawn.unwrap();
        assert!(drawn.broken[0] > 10, "{:?}", drawn.broken);
        assert_eq!(drawn, given.unwrap());
        grows(&plate, &drawn.kept[0]);
        // Both count: without one of them the same plate breaks otherwise.
        let soft = plate.run(Strength::Given { values: &strengths, value }, Stiffness::Uniform);
        assert_ne!(soft.unwrap().damage, drawn.damage);
        let even = Stiffness::Given { values: &factors, value };
        assert_ne!(plate.run(Strength::Uniform(STRETCH), even).unwrap().damage, drawn.damage);
    }
}

/// From the notch alone to the damage of the end, and never back.
fn grows(plate: &Plate, state: &FinalState) {
    let at = |step: u64| state.damage_at(&plate.bonds, step).unwrap();
    let last = state.history.last().unwrap().step;
    assert!(last > 0 && at(last) == state.damage && at(u64::MAX) == state.damage);
    let notch: Vec<usize> =
        state.history.iter().filter(|it| it.step == 0).map(|it| it.bond).collect();
    assert!(!notch.is_empty() && at(0) != state.damage);
    for step in 1..=last {
        let pairs: Vec<_> = at(step - 1).into_iter().zip(at(step)).collect();
        assert!(pairs.iter().all(|(before, after)| before <= after), "{step}");
        let is_equal = pairs.iter().all(|(before, after)| before.to_bits() == after.to_bits());
        assert_eq!(is_equal, state.history.iter().all(|it| it.step != step), "{step}");
    }
}

#[test]
fn given_values_that_are_all_one_are_those_of_a_uniform_body() {
    let plate = Plate::lattice();
    let n = plate.nodes.positions().len();
    let (strengths, factors) = (vec![STRETCH; n], vec![1.0; n]);
    let value = BondValue::Mean;
    let given = plate.run(
        Strength::Given { values: &strengths, value },
        Stiffness::Given { values: &factors, value },
    );
    let given = given.unwrap();
    let uniform = plate.run(Strength::Uniform(STRETCH), Stiffness::Uniform).unwrap();
    assert_eq!((&given.records, &given.loads), (&uniform.records, &uniform.loads));
    assert_eq!((&given.damage, &given.broken), (&uniform.damage, &uniform.broken));
    assert_eq!(given.kept[0].strength, Some(strengths));
}

#[test]
fn given_values_of_another_body_or_without_sign_are_refused() {
    let plate = Plate::lattice();
    let value = BondValue::Mean;
    let run = |values: &[f64]| {
        let strength = plate.run(Strength::Given { values, value }, Stiffness::Uniform);
        let stiffness = Stiffness::Given { values, value };
        [strength, plate.run(Strength::Uniform(STRETCH), stiffness)].map(Result::unwrap_err)
    };
    for refused in run(&[STRETCH; N]) {
        assert!(matches!(refused, Error::Length { name: "the field", value: N, .. }), "{refused}");
    }
    let mut values = vec![STRETCH; N_NODES];
    values[7] = 0.0;
    for refused in run(&values) {
        assert!(matches!(refused, Error::Node { node: 7, .. }), "{refused}");
    }
}
