//! Studies, bridges, samples, rare events: what must hold of each.

use sde_integrators::{
    Between, DrivenPath, EnsembleConfig, Error, EulerMaruyama, Integrator, Joints, LANES,
    LaneIncrements, LinearFlows, Noise, Observable, Response, Samples, SemiImplicitEuler, Side,
    SimdLevel, StateSpace, StrangOscillator, Study, SubsetConfig, Uncertainty, maxima, merge,
    merge_so_far, subset_simulation,
};

use crate::ensemble::Cubic;
use crate::methods::{Linear, OSCILLATOR};

/// What lanes do is what single steps do, whatever the method and whatever the instructions.
#[test]
fn lanes_are_single_steps() {
    fn check<I: Integrator<StateSpace<Linear>, 2, 1>>(integrator: &I) {
        let noise = Noise::new(3);
        let mut paths: Vec<_> = (0..LANES as u64).map(|id| noise.path::<1>(id)).collect();
        let mut single = vec![[0.4, -0.2]; LANES];
        let mut lanes = [[0.4; LANES], [-0.2; LANES]];
        let mut memories = vec![I::Memory::default(); LANES];
        let mut lane_memories = std::array::from_fn(|_| I::Memory::default());
        for k in 0..20 {
            let (t, dt) = (0.1 * f64::from(k), 0.1);
            let mut dw = LaneIncrements::ZERO;
            for lane in 0..LANES {
                let increment = paths[lane].next_increment(dt);
                dw.brownian[0][lane] = increment.brownian[0];
                dw.space_time_area[0][lane] = increment.space_time_area[0];
                assert_eq!(dw.lane(lane), increment);
                integrator
                    .step(&OSCILLATOR, t, dt, &increment, &mut single[lane], &mut memories[lane])
                    .unwrap();
            }
            let mut failed = |_, _| ();
            integrator.step_lanes(
                &OSCILLATOR,
                t,
                dt,
                &dw,
                &mut lanes,
                &mut lane_memories,
                &mut failed,
            );
            for lane in 0..LANES {
                let bits = |x: [f64; 2]| x.map(f64::to_bits);
                assert_eq!(bits([lanes[0][lane], lanes[1][lane]]), bits(single[lane]));
            }
        }
    }
    check(&EulerMaruyama);
    check(&SemiImplicitEuler);
    check(&StrangOscillator);
}

/// What a step leaves to the next is done then: twenty steps of numbers of size one differ by their roundings. Between
/// joined steps the velocity lacks half a flow, so that the joints are seen to be there.
#[test]
fn joined_steps_are_single_steps_to_roundoff() {
    let system = StateSpace(Linear {
        force: 0.6,
        stiffness: 0.7,
        modulation: 0.3,
        ..Linear::oscillator(2.0, 0.3, 0.9)
    });
    let noise = Noise::new(4);
    let mut paths: Vec<_> = (0..LANES as u64).map(|id| noise.path::<1>(id)).collect();
    let start = [[0.4; LANES], [-0.2; LANES]];
    let (mut single, mut joined) = (start, start);
    let mut memories = [[LinearFlows::<1>::default(); LANES]; 2];
    let (n_steps, dt) = (20, 0.1);
    for k in 0..n_steps {
        let t = dt * f64::from(k);
        let mut dw = LaneIncrements::ZERO;
        for lane in 0..LANES {
            let increment = paths[lane].next_increment(dt);
            dw.brownian[0][lane] = increment.brownian[0];
            dw.space_time_area[0][lane] = increment.space_time_area[0];
        }
        let [first, second] = &mut memories;
        let method = StrangOscillator;
        method.step_lanes(&system, t, dt, &dw, &mut single, first, &mut |_, _| ());
        let joints = Joints { before: k > 0, after: k + 1 < n_steps };
        method.step_lanes_joined(joints, &system, t, dt, &dw, &mut joined, second, &mut |_, _| ());
        for lane in 0..LANES {
            let apart = [0, 1].map(|i| (single[i][lane] - joined[i][lane]).abs());
            assert!(apart[0] < 1e-14, "step {k}, lane {lane}: {apart:?}");
            assert!(joints.after || apart[1] < 1e-14, "lane {lane}: {apart:?}");
        }
        let largest = (0..LANES).map(|lane| (single[1][lane] - joined[1][lane]).abs());
        assert!(!joints.after || largest.fold(0.0, f64::max) > 1e-3, "no joint at step {k}");
    }
}

/// Some paths are lost.
fn cubic<T>(
    n_paths: u64,
    look: impl FnOnce(&Study<'_, Cubic, EulerMaruyama, [f64; 1], 1>) -> T,
) -> T {
    let config = EnsembleConfig { seed: 3, n_paths, dt: 0.1, times: vec![20.0] };
    look(&Study {
        name: "cubic",
        system: &Cubic { intensity: 4.0 },
        integrator: &EulerMaruyama,
        law: &[0.0],
        config: &config,
        observables: &[Observable::Mean(&|_, x| x[0])],
        level: SimdLevel::best(),
    })
}

#[test]
fn failed_paths_are_counted_and_no_estimate_is_made_of_the_rest() {
    cubic(5_000, |study| {
        let outcome = study.run::<1>().unwrap();
        let mut n_failed = 0;
        let mut first = None;
        for realisation in 0..5_000 {
            let (mut x, mut path) = (0.0_f64, Noise::new(3).path::<1>(realisation));
            for _ in 0..200 {
                x += -x * x * x * 0.1 + 4.0 * path.next_increment(0.1).brownian[0];
            }
            if !x.is_finite() {
                n_failed += 1;
                first = first.or(Some(realisation));
            }
        }
        assert!(n_failed > 1_000, "{n_failed}");
        assert_eq!((outcome.n_failed, outcome.n_paths), (n_failed, 5_000));
        let failure = outcome.first_failure.clone().unwrap();
        assert_eq!(Some(failure.realisation), first);
        let error = outcome.ensemble().unwrap_err();
        assert!(matches!(error, Error::PathsFailed { n_failed: k, .. } if k == n_failed));
        assert!(error.to_string().contains(&failure.message));
    });
}

#[test]
fn wrong_sets_of_shards_are_refused_by_name() {
    cubic(9_000, |study| {
        let all: Vec<_> = (0..2).map(|k| study.shard::<1>(k, 2).unwrap()).collect();
        let [first, second] = all.as_slice() else { unreachable!("two shards") };
        assert_eq!(merge(&[second.clone(), first.clone()]), study.run::<1>());
        assert_eq!(
            merge(std::slice::from_ref(second)).unwrap_err(),
            Error::MissingShard { shard: 0, n_shards: 2 }
        );
        let doubled = merge(&[first.clone(), second.clone(), first.clone()]);
        assert_eq!(doubled.unwrap_err(), Error::DoubledShard { shard: 0 });
        let foreign = study.shard::<1>(1, 3).unwrap();
        let message = merge(&[first.clone(), foreign]).unwrap_err().to_string();
        assert_eq!(
            message,
            "shard 1 is of another study: its n_shards is 3, that of the first is 2"
        );
        assert_eq!(
            study.shard::<1>(2, 2).unwrap_err(),
            Error::NoSuchShard { shard: 2, n_shards: 2 }
        );
        assert!(matches!(merge(&[]), Err(Error::TooFew { .. })));
    });
}

/// Shards of paths 0 to 4095 and from 8192 on: what the first alone comes to is the ensemble of its paths, and all are what [`merge`] gives.
#[test]
fn shards_that_are_there_say_what_is_known_so_far() {
    let config = EnsembleConfig { seed: 3, n_paths: 9_000, dt: 0.1, times: vec![0.5, 2.0] };
    let shortened = EnsembleConfig { n_paths: 4_096, ..config.clone() };
    let exceeds = |_: f64, x: &[f64; 2]| x[0] > 0.3;
    let observables =
        [Observable::Mean(&|_, x: &[f64; 2]| x[0] * x[0]), Observable::Probability(&exceeds)];
    let study = Study {
        name: "",
        system: &OSCILLATOR,
        integrator: &SemiImplicitEuler,
        law: &[0.0; 2],
        config: &config,
        observables: &observables,
        level: SimdLevel::best(),
    };
    let shards: Vec<_> = (0..3).map(|k| study.shard::<1>(k, 3).unwrap()).collect();
    let first = merge_so_far(&shards[..1]).unwrap();
    let short = Study { config: &shortened, ..study }.run::<1>().unwrap();
    assert_eq!(first.ensemble().unwrap(), short.ensemble().unwrap());
    let ends = [shards[2].clone(), shards[0].clone()];
    assert_eq!(merge_so_far(&ends).unwrap().n_paths, 4_096 + 808);
    assert_eq!(merge_so_far(&shards), merge(&shards));
    let twice = [shards[0].clone(), shards[0].clone()];
    assert_eq!(merge_so_far(&twice).unwrap_err(), Error::DoubledShard { shard: 0 });
    assert!(matches!(merge_so_far(&[]), Err(Error::TooFew { .. })));
}

/// Uniform ranks: the quantiles of 1, 2, .., 1000 and their binomial spread.
#[test]
fn a_quantile_is_a_rank_and_its_error_a_spread_of_ranks() {
    let samples = Samples::new((1..=1_000).rev().map(f64::from).collect()).unwrap();
    let median = samples.quantile(0.5).unwrap();
    assert!((median.value - 500.0).abs() < 1e-12);
    // sqrt(1000/4) = 15.8 ranks, to the next whole one.
    assert!((median.standard_error().unwrap() - 15.8).abs() < 1.0, "{median}");
    let above = samples.exceedance(900.0).unwrap();
    assert!((above.value - 0.1).abs() < 1e-15);
    assert!(matches!(samples.quantile(0.005), Err(Error::TooFew { value: 5, limit: 10, .. })));
    assert!(samples.quantile(f64::NAN).is_err() && samples.quantile(1.0).is_err());
    assert!(matches!(Samples::new(vec![1.0, f64::NAN]), Err(Error::NotFinite { index: 1, .. })));
}

#[test]
fn a_response_that_cannot_be_is_refused() {
    let config = EnsembleConfig { seed: 3, n_paths: 10, dt: 1.6, times: vec![3.2] };
    let run = |component, between| {
        let response = Response { component, side: Side::Above, between };
        maxima(&OSCILLATOR, &StrangOscillator, &[0.0; 2], &config, &response).unwrap_err()
    };
    assert_eq!(run(2, Between::Endpoints), Error::NoSuchComponent { component: 2, limit: 2 });
    let hermite = Between::CubicHermite { velocity: 5 };
    assert_eq!(run(0, hermite), Error::NoSuchComponent { component: 5, limit: 2 });
    let arc = run(0, Between::RotationArc { natural_frequency: 2.0 });
    assert!(matches!(arc, Error::ArcTooLong { angle, .. } if (angle - 3.2).abs() < 1e-15));
    let arc = run(0, Between::RotationArc { natural_frequency: -1.0 });
    assert!(matches!(arc, Error::NotPositive { .. }));
    let bridge =
        run(0, Between::BrownianBridge { intensity: &|t, _| if t > 1.0 { f64::NAN } else { 1.0 } });
    assert!(matches!(bridge, Error::NotFinite { .. }));
}

#[test]
fn subset_simulation_refuses_what_cannot_be() {
    let path = DrivenPath {
        system: &OSCILLATOR,
        integrator: &StrangOscillator,
        start: [0.0; 2],
        dt: 0.1,
        n_steps: 10,
    };
    assert_eq!(path.n_normals::<1>(), 20);
    let short = path.run::<1>(&[0.0; 19], |_, _, _| ()).unwrap_err();
    assert!(matches!(short, Error::WrongLength { value: 19, expected: 20, .. }));
    let config = SubsetConfig { n_samples: 100, correlation: 0.8, n_runs: 4 };
    let subset = |config| subset_simulation(&|u| Ok(u[0]), 2, 3.0, &Noise::new(1), &config);
    assert!(subset(config).is_ok());
    assert!(matches!(subset(SubsetConfig { n_samples: 99, ..config }), Err(Error::TooFew { .. })));
    assert!(matches!(subset(SubsetConfig { n_runs: 3, ..config }), Err(Error::TooFew { .. })));
    let wrong = SubsetConfig { correlation: 1.0, ..config };
    assert!(matches!(subset(wrong), Err(Error::NotPositive { .. })));
    let large = SubsetConfig { n_samples: usize::MAX, ..config };
    assert!(matches!(subset(large), Err(Error::TooMany { .. })));
    let many = SubsetConfig { n_runs: u64::MAX, ..config };
    assert!(matches!(subset(many), Err(Error::TooMany { .. })));
    let backwards = DrivenPath { dt: -0.1, ..path }.run::<1>(&[0.0; 20], |_, _, _| ());
    assert!(matches!(backwards, Err(Error::NotPositive { value: -0.1, .. })));
}

/// Compared with a threshold, NaN is as if it had not exceeded.
#[test]
fn subset_simulation_refuses_what_is_not_a_number() {
    let sometimes = |u: &[f64]| Ok(u[0].sqrt());
    let always = |u: &[f64]| Ok(u[0]);
    let of_response = Err(Error::NotANumber { quantity: "response" });
    let of_threshold = Err(Error::NotANumber { quantity: "threshold" });
    let noise = Noise::new(1);
    let config = SubsetConfig { n_samples: 100, correlation: 0.8, n_runs: 4 };
    let subset = |response, threshold| {
        subset_simulation(response, 1, threshold, &noise, &config).map(|_| ())
    };
    assert_eq!(subset(&sometimes, 3.0), of_response);
    assert_eq!(subset(&always, f64::NAN), of_threshold);
}

/// Zeros have no spread, and ones have none.
#[test]
fn what_was_never_seen_has_no_error() {
    let response = |u: &[f64]| Ok(u[0].min(1.0));
    let noise = Noise::new(1);
    let config = SubsetConfig { n_samples: 100, correlation: 0.8, n_runs: 4 };
    let subset = |threshold| subset_simulation(&response, 1, threshold, &noise, &config).unwrap();
    let never = subset(2.0);
    assert_eq!((never.value, never.uncertainty), (0.0, Uncertainty::Unknown));
    let always = subset(-20.0);
    assert_eq!((always.value, always.uncertainty), (1.0, Uncertainty::Bound(3.0 / 400.0)));
}

/// `P(u > 3) = 1.3499e-3` (Abramowitz and Stegun, table 26.1) from a single normal.
#[test]
fn subset_simulation_finds_the_tail_of_the_normal_law() {
    let response = |u: &[f64]| Ok(u[0]);
    let config = SubsetConfig { n_samples: 1_000, correlation: 0.8, n_runs: 40 };
    let subset = subset_simulation(&response, 2, 3.0, &Noise::new(6), &config).unwrap();
    let exact = 0.00134989803;
    let error = (subset.value - exact).abs();
    assert!(error <= 0.05 * exact + 4.0 * subset.standard_error().unwrap(), "{subset}");
}
