//! The source note to the letter.

use std::f64::consts::PI;

use peridyn_sde::{Condition, Dynamics, Error, Mobility, Nodes, NoteAsPrinted, Scheme};

const NOTE: NoteAsPrinted = NoteAsPrinted { bulk_modulus: 2.0, horizon: 3.0, eta: 0.5 };
const THICKNESS: f64 = 0.25;
const PLATE: Condition = Condition::PlaneStress { thickness: THICKNESS };

fn plate() -> Nodes<2> {
    Nodes::lattice(1.0, ([0.0; 2], [9.0; 2]), PLATE, |_| true).unwrap()
}

#[test]
fn bonds_of_the_note_have_one_constant_and_one_volume_and_end_before_the_horizon() {
    let nodes = plate();
    let bonds = NOTE.bonds(&nodes).unwrap();
    let stiffness = 18.0 * 2.0 / (PI * 81.0) * THICKNESS;
    assert!(bonds.all().iter().all(|bond| (bond.stiffness / stiffness - 1.0).abs() < 1e-14));
    // Places with 0 < x^2 + y^2 < 9 around the middle of 9 by 9: 4 at 1, 2, 4 and 8 each, 8 at 5.
    let n = bonds.pairs().filter(|&(i, j)| i == 40 || j == 40).count();
    assert_eq!(n, 24);
    // At a whole number of spacings, those on the circle itself are left out.
    assert!(bonds.all().iter().all(|bond| bond.length < 3.0));
}

#[test]
fn a_plate_of_the_note_is_as_much_too_stiff_as_is_said() {
    let volume = 0.7;
    let ratio = NOTE.stiffness_ratio(volume, PLATE).unwrap();
    assert!((ratio * volume / (2.0 * THICKNESS / 3.0) - 1.0).abs() < 1e-14, "{ratio}");
    // In three dimensions the constant is right, and only a volume is missing.
    let solid = NOTE.stiffness_ratio(volume, Condition::Solid).unwrap();
    assert!((solid * volume - 1.0).abs() < 1e-14, "{solid}");
}

#[test]
fn eta_of_the_note_is_its_temperature_and_numbers_without_sign_are_refused() {
    let mobility = Mobility::identity(&[true; 4], 2.0).unwrap();
    let dynamics = NOTE.dynamics(mobility.clone()).unwrap();
    let Dynamics::Overdamped { mobility: of, temperature, scheme } = dynamics else {
        panic!("{dynamics:?}")
    };
    assert!((temperature - 0.5).abs() < f64::EPSILON);
    assert_eq!((of, scheme), (mobility.clone(), Scheme::EulerMaruyama));
    let refused = NoteAsPrinted { eta: f64::NAN, ..NOTE }.dynamics(mobility).unwrap_err();
    assert!(matches!(refused, Error::NotPositive { name: "eta", .. }), "{refused}");
    let refused = NoteAsPrinted { bulk_modulus: -2.0, ..NOTE }.bonds(&plate()).unwrap_err();
    assert!(matches!(refused, Error::NotPositive { name: "bulk modulus", .. }), "{refused}");
    let refused = NoteAsPrinted { horizon: 0.0, ..NOTE }.bonds(&plate()).unwrap_err();
    assert!(matches!(refused, Error::NotPositive { name: "horizon", .. }), "{refused}");
    let refused = NoteAsPrinted { horizon: 0.9, ..NOTE }.bonds(&plate()).unwrap_err();
    assert!(matches!(refused, Error::LooseNode { .. }), "{refused}");
}
