//! Ensembles that are halted and resumed, bitwise identical to one run.

use std::sync::atomic::{AtomicU64, Ordering};

use peridyn_sde::{
    BondValue, CrackRun, CrackStudy, Error, GroupProgress, HaltedRun, Precision, Procedure,
    RunOutcome, Scheme, Stiffness, Strength, StudyLaw,
};

use crate::fixtures::overdamped;
use crate::given::{Plate, STRETCH};
use crate::slow_ensemble::{loading, slow};

/// Not a multiple of the lanes.
const N: u64 = 11;
const KEEP: [u64; 2] = [0, 9];

/// Runs a study that is halted whenever it has been asked so many times; returns the run and how often it was halted.
fn in_pieces(study: &CrackStudy<'_>, asked: u64) -> (CrackRun, u64) {
    let next = |halted: Option<HaltedRun>| {
        let count = AtomicU64::new(0);
        let goes_on = |_| count.fetch_add(1, Ordering::Relaxed) < asked;
        match halted {
            None => study.run_while(0..N, &KEEP, &goes_on),
            Some(halted) => study.resume_while(halted, &KEEP, &goes_on),
        }
    };
    let mut ran = next(None).unwrap();
    for n_halts in 0.. {
        match ran {
            RunOutcome::Finished(run) => return (run, n_halts),
            RunOutcome::Halted(halted) => {
                assert_eq!(halted.realisations(), 0..N);
                ran = next(Some(halted)).unwrap();
            }
        }
    }
    unreachable!("an ensemble of 400 steps ends")
}

#[test]
fn pieces_of_a_run_in_time_are_one_run() {
    let mut plate = Plate::lattice();
    let free = plate.free().to_vec();
    for scheme in [Scheme::EulerMaruyama, Scheme::LeimkuhlerMatthews] {
        plate.simulation.dynamics = overdamped(&free, scheme, 1e-9);
        let (strength, _) = plate.field(STRETCH, 0);
        let strength = Strength::Field { field: &strength, value: BondValue::Minimum };
        let study = plate.study(strength, Stiffness::Uniform);
        let whole = study.run(0..N, &KEEP).unwrap();
        assert!(whole.broken.iter().any(|&broken| broken > 0), "{:?}", whole.broken);
        for asked in [7, 40] {
            let (run, n_halts) = in_pieces(&study, asked);
            assert!(n_halts >= 1, "{asked}");
            assert_eq!(run, whole, "{scheme:?}, halted after {asked} questions {n_halts} times");
        }
    }
}

#[test]
fn realisations_under_a_slow_load_start_again_but_those_that_ended_do_not() {
    let plate = Plate::lattice();
    let (loading, _) = loading(&plate);
    let inputs = (Strength::Uniform(STRETCH), Stiffness::Uniform);
    let study = slow(&plate, &loading, StudyLaw::BondBased, inputs);
    let RunOutcome::Finished(whole) = study.run_while(0..3, &KEEP, &|_| true).unwrap() else {
        panic!("a run that nobody halts ends")
    };
    let RunOutcome::Halted(halted) =
        study.run_while(0..3, &KEEP, &|it| it.realisation < 1).unwrap()
    else {
        panic!("a run that is halted ended")
    };
    // The first realisation has ended and is not asked again.
    let asked = |it: GroupProgress| {
        assert!(it.realisation >= 1 && it.done.is_none());
        true
    };
    let RunOutcome::Finished(run) = study.resume_while(halted, &KEEP, &asked).unwrap() else {
        panic!("a run that nobody halts ends")
    };
    assert_eq!(run, whole);
}

#[test]
fn the_state_of_another_study_is_refused() {
    let plate = Plate::lattice();
    let study = plate.study(Strength::Uniform(STRETCH), Stiffness::Uniform);
    let count = AtomicU64::new(0);
    let goes_on = |_| count.fetch_add(1, Ordering::Relaxed) < 5;
    let RunOutcome::Halted(halted) = study.run_while(0..8, &[], &goes_on).unwrap() else {
        panic!("a run that is halted ended")
    };
    let single = CrackStudy { precision: Precision::Single, ..study };
    let error = single.resume_while(halted.clone(), &[], &|_| true).unwrap_err();
    let lanes = Error::Length { name: "lanes of a halted run", value: 8, expected: 16 };
    assert_eq!(error, lanes);
    let Procedure::Dynamic { simulation, .. } = study.procedure else { panic!("a run in time") };
    let shorter = Procedure::Dynamic { simulation, n_steps: 10 };
    let shorter = CrackStudy { procedure: shorter, ..study };
    let error = shorter.resume_while(halted, &[], &|_| true).unwrap_err();
    assert!(matches!(error, Error::SavedStep { limit: 10, .. }), "{error}");
}
