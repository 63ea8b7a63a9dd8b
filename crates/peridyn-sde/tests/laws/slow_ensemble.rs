//! Ensembles under a load that grows slowly.

use peridyn_sde::law::Bilinear;
use peridyn_sde::{
    Body, BondList, BondValue, CrackRun, CrackStudy, EquilibriumConfig, Error, Loading,
    NextBreakage, Procedure, Program, QuasiStatic, SolidBonds, Stiffness, Strain, Strength,
    StudyLaw,
};
use sde_integrators::Noise;

use crate::given::{Plate, STRETCH, bond_config, tension};

const CONFIG: EquilibriumConfig = EquilibriumConfig::EVENT_BY_EVENT;
const N_WINDOWS: u64 = 10;

/// A load factor of one is a mean strain of 0.9 of the critical stretch.
pub(super) fn loading(plate: &Plate) -> (Loading<2>, Vec<usize>) {
    tension(plate.body().0, Program::Linear { rate: 0.9 * STRETCH })
}

pub(super) fn slow<'a>(
    plate: &'a Plate,
    loading: &'a Loading<2>,
    law: StudyLaw<'a>,
    (strength, stiffness): (Strength<'a>, Stiffness<'a>),
) -> CrackStudy<'a> {
    let procedure =
        Procedure::QuasiStatic { config: CONFIG, until: 1.0, n_steps: 200, noise: Noise::new(11) };
    CrackStudy { law, procedure, loading, n_windows: N_WINDOWS, ..plate.study(strength, stiffness) }
}

fn uniform<'a>(
    plate: &'a Plate,
    loading: &'a Loading<2>,
    law: StudyLaw<'a>,
) -> Result<CrackRun, Error> {
    let inputs = (Strength::Uniform(STRETCH), Stiffness::Uniform);
    slow(plate, loading, law, inputs).run(0..1, &[0])
}

#[test]
fn a_realisation_is_what_a_test_of_a_prescribed_displacement_sees_of_the_path() {
    let plate = Plate::lattice();
    let (loading, upper) = loading(&plate);
    let study = slow(
        &plate,
        &loading,
        StudyLaw::BondBased,
        (Strength::Uniform(STRETCH), Stiffness::Uniform),
    );
    let (nodes, bonds) = plate.body();
    let cut = bonds.across_segment(nodes, (study.notch.mouth, study.notch.tip)).unwrap();
    let strengths = vec![STRETCH; bonds.len()];
    let mut body =
        BondList::<f64, 2, 1>::new(nodes.clone(), bonds.clone(), Strain::Linear, &strengths)
            .unwrap();
    for &bond in &cut {
        body.set_intact(bond, 0);
    }
    let mut path = QuasiStatic::new(body, loading.clone(), CONFIG).unwrap();
    let (mut order, mut points, mut largest) = (Vec::new(), Vec::new(), 0.0_f64);
    let mut slope = path.pull_of_unit_load(&upper).unwrap()[1].abs();
    while let NextBreakage::At(event) = path.next_breakage().unwrap() {
        if event.factor > 1.0 {
            break;
        }
        if event.factor > largest {
            largest = event.factor;
            points.push((event.factor, slope));
        }
        order.extend(event.bonds);
        slope = path.pull_on(&upper)[1].abs() / event.factor;
    }
    let run = study.run(0..1, &[0]).unwrap();
    let broken: Vec<usize> =
        run.kept[0].history.iter().filter(|at| at.step > 0).map(|at| at.bond).collect();
    assert!(broken.len() > 30 && broken == order, "{} {}", broken.len(), order.len());
    let peak = points.iter().map(|(factor, slope)| factor * slope).fold(0.0, f64::max);
    let found = run.records[0].failure_load.unwrap();
    assert!((found / peak - 1.0).abs() < 1e-12, "{found} {peak}");
    assert_eq!(run.loads[0].len() as u64, N_WINDOWS);
    // Up to the first failure the load is proportional to the displacement.
    let (first, slope) = points[0];
    assert!(first * N_WINDOWS as f64 > 1.0, "{first}");
    for (window, load) in run.loads[0].iter().enumerate() {
        let factor = (window + 1) as f64 / N_WINDOWS as f64;
        if factor < first {
            assert!((load / (slope * factor) - 1.0).abs() < 1e-12, "{window}: {load}");
        }
    }
    assert!(run.loads[0].iter().all(|&load| load <= peak));
    let damage = run.kept[0].damage_at(bonds, 200).unwrap();
    assert_eq!(damage, run.kept[0].damage);
}

#[test]
fn bonds_of_hardly_any_softening_break_as_those_that_break_at_once() {
    let plate = Plate::lattice();
    let (loading, _) = loading(&plate);
    let at_once = uniform(&plate, &loading, StudyLaw::BondBased).unwrap();
    // A tooth of 5 % leads past the end of the line.
    let brittle = StudyLaw::Softening(Bilinear::new(1.01).unwrap());
    let brittle = uniform(&plate, &loading, brittle).unwrap();
    assert_eq!(brittle.kept[0].history, at_once.kept[0].history);
    let [one, other] = [&brittle, &at_once].map(|run| run.records[0].failure_load.unwrap());
    assert!((one / other - 1.0).abs() < 1e-6, "{one} {other}");
    // Three times the energy: a higher load, and no bond is gone where the first one went.
    let tough = StudyLaw::Softening(Bilinear::new(3.0).unwrap());
    let tough = uniform(&plate, &loading, tough).unwrap();
    assert!(tough.records[0].failure_load.unwrap() > 1.1 * other);
}

#[test]
fn a_linear_solid_of_a_ratio_of_one_third_breaks_as_bonds_in_plane_stress() {
    let plate = Plate::lattice();
    let (loading, _) = loading(&plate);
    let (nodes, _) = plate.body();
    let solid = SolidBonds::new(nodes, &bond_config(), 1.0 / 3.0).unwrap();
    let inputs = (Strength::Uniform(STRETCH), Stiffness::Uniform);
    let study = slow(&plate, &loading, StudyLaw::LinearSolid(&solid), inputs);
    let study = CrackStudy { bonds: solid.bonds(), ..study };
    let solid = study.run(0..1, &[0]).unwrap();
    let bonds = uniform(&plate, &loading, StudyLaw::BondBased).unwrap();
    // In the interior the laws are one, times the weighted volume of the lattice over that of the continuum; at edges nodes of
    // the solid are stiffer.
    let [one, other] = [&solid, &bonds].map(|run| run.records[0].failure_load.unwrap());
    assert!((one / other - 1.0).abs() < 0.15, "{one} {other}");
    assert!(solid.records[0].length > 3.0 && bonds.records[0].length > 3.0);
}

#[test]
fn realisations_have_the_same_bits_alone_in_shards_and_all_together() {
    let plate = Plate::lattice();
    let (loading, _) = loading(&plate);
    let (strength, _) = plate.field(STRETCH, 0);
    let (stiffness, _) = plate.field(1.0, 1);
    let value = BondValue::Mean;
    let inputs = (
        Strength::Field { field: &strength, value },
        Stiffness::Field { field: &stiffness, value },
    );
    let study = slow(&plate, &loading, StudyLaw::BondBased, inputs);
    let whole = study.run(0..5, &[2]).unwrap();
    let [later, mut joined] = [3..5, 0..3].map(|range| study.run(range, &[2]).unwrap());
    joined.append(later).unwrap();
    assert_eq!(joined, whole);
    let alone = study.run(2..3, &[2]).unwrap();
    assert_eq!((&alone.records[0], &alone.loads[0]), (&whole.records[2], &whole.loads[2]));
    assert_eq!(alone.kept, whole.kept);
    let loads: Vec<_> = whole.records.iter().filter_map(|record| record.failure_load).collect();
    assert!(loads.windows(2).any(|pair| pair[0].to_bits() != pair[1].to_bits()), "{loads:?}");
}

#[test]
fn what_a_law_does_not_have_is_refused() {
    let plate = Plate::lattice();
    let (loading, _) = loading(&plate);
    let (field, _) = plate.field(1.0, 1);
    let softening = StudyLaw::Softening(Bilinear::new(5.0).unwrap());
    let factors = Stiffness::Field { field: &field, value: BondValue::Mean };
    let varying = slow(&plate, &loading, softening, (Strength::Uniform(STRETCH), factors));
    let refused = |study: CrackStudy<'_>| study.run(0..1, &[]).unwrap_err();
    assert_eq!(refused(varying), Error::UniformStiffness { law: "bonds that soften" });
    let in_time = plate.study(Strength::Uniform(STRETCH), Stiffness::Uniform);
    assert_eq!(refused(CrackStudy { law: softening, ..in_time }), Error::SofteningInTime);
    let backwards =
        Procedure::QuasiStatic { config: CONFIG, until: -1.0, n_steps: 200, noise: Noise::new(11) };
    let inputs = (Strength::Uniform(STRETCH), Stiffness::Uniform);
    let study = slow(&plate, &loading, StudyLaw::BondBased, inputs);
    let error = refused(CrackStudy { procedure: backwards, ..study });
    assert!(matches!(error, Error::Parameter { name: "last load factor", .. }), "{error}");
}
