//! Guided paths: unbiased for any guide, those of an ensemble without one, bitwise identical for any number of threads.

use sde_integrators::{
    Accumulator, Between, EnsembleConfig, Error, GaussianMixture, Guide, GuidedEnsemble,
    GuidedPath, Observable, Passages, Response, Side, SmallPaths, StateSpace, StrangOscillator,
    maxima, simulate,
};

use crate::methods::{Linear, OSCILLATOR};

/// Of the stationary distribution: `0.81/0.6` of the velocity, over `2^2` of the displacement.
const DEVIATIONS: [f64; 2] = [0.580_947_501_931_1, 1.161_895_003_862_2];
const N_STEPS: usize = 10;
const DT: f64 = 0.2;

const RESPONSE: Response<'_> = Response {
    component: 0,
    side: Side::Magnitude,
    between: Between::CubicHermite { velocity: 1 },
};

/// A guide from no theory, so that nothing but its weights can make the result right.
fn guide(share: f64, sign: f64) -> Guide {
    let feedback = (0..N_STEPS - 2).flat_map(|k| [sign * 0.8, sign * 0.5, -1.0 - 0.1 * k as f64]);
    Guide {
        share,
        start: vec![sign * 0.7, -0.2],
        from: 0,
        hold: 1,
        level: 0,
        feedback: feedback.collect(),
        directions: [sign * 0.4, 0.1].repeat(N_STEPS - 2),
    }
}

/// The same with its feedback computed every third step.
fn held(share: f64, sign: f64) -> Guide {
    let guide = guide(share, sign);
    let feedback = guide.feedback.chunks(3).step_by(3).flatten().copied().collect();
    Guide { hold: 3, feedback, ..guide }
}

/// The same from the fifth step on.
fn late(share: f64, sign: f64) -> Guide {
    Guide { from: 4, ..guide(share, sign) }
}

/// Passages of one level.
fn through(level: &f64) -> Passages<'_> {
    const RESPONSES: &[Response<'_>] = &[RESPONSE];
    Passages { responses: RESPONSES, levels: std::slice::from_ref(level) }
}

type Paths = SmallPaths<'static, StateSpace<Linear>, StrangOscillator, 2>;

fn ensemble<'a>(
    guides: &'a [Guide],
    passages: Option<Passages<'a>>,
) -> GuidedEnsemble<'a, Paths, 1> {
    GuidedEnsemble {
        paths: &SmallPaths { system: &OSCILLATOR, integrator: &StrangOscillator },
        mean: &[0.0; 2],
        factor: &[DEVIATIONS[0], 0.0, 0.0, DEVIATIONS[1]],
        dt: DT,
        n_steps: N_STEPS,
        guides,
        passages,
        seed: 42,
    }
}

/// Ends, largest responses and weights.
fn paths(
    guides: &[Guide],
    passages: Option<Passages<'_>>,
    realisations: std::ops::Range<u64>,
) -> Result<Vec<[f64; 3]>, Error> {
    let join = |mut earlier: Vec<_>, later: Vec<_>| {
        earlier.extend(later);
        earlier
    };
    ensemble(guides, passages).run(realisations, Vec::new, push, join)
}

fn push(all: &mut Vec<[f64; 3]>, path: &GuidedPath<'_>) {
    all.push([path.end[0], path.largest, path.log_weight]);
}

#[test]
fn weights_undo_any_guide() {
    let n = 40_000;
    for guides in [
        vec![guide(0.8, 1.0)],
        vec![guide(0.4, 1.0), guide(0.6, -1.0)],
        vec![held(0.4, 1.0), held(0.6, -1.0)],
        vec![late(0.4, 1.0), guide(0.6, -1.0)],
    ] {
        let mut means = [Accumulator::default(); 3];
        for [q, _, log_weight] in paths(&guides, None, 0..n).unwrap() {
            let w = log_weight.exp();
            for (mean, value) in means.iter_mut().zip([w, w * q, w * q * q]) {
                mean.push(value);
            }
        }
        // Strang's splitting stays in the stationary distribution.
        let exact = [1.0, 0.0, DEVIATIONS[0] * DEVIATIONS[0]];
        for (mean, exact) in means.iter().zip(exact) {
            let estimate = mean.estimate().unwrap();
            let error = estimate.standard_error().unwrap();
            assert!(error < 0.02, "{estimate}");
            assert!((estimate.value - exact).abs() < 4.0 * error, "{estimate}, exact {exact}");
        }
    }
}

/// `P(max |q| > 1.5)` of guided paths, whose guides end at the passage, and of free ones.
#[test]
fn weights_that_stop_at_the_passage_are_unbiased() {
    let level = 1.5;
    let of = |guides: &[Guide], n| {
        let mut mean = Accumulator::default();
        for [_, largest, log_weight] in paths(guides, Some(through(&level)), 0..n).unwrap() {
            mean.push(if largest > level { log_weight.exp() } else { 0.0 });
        }
        let estimate = mean.estimate().unwrap();
        (estimate.value, estimate.standard_error().unwrap())
    };
    let (free, guided) = (of(&[], 100_000), of(&[guide(0.5, 1.0), guide(0.5, -1.0)], 20_000));
    assert!(free.1 < 0.02 * free.0 && guided.1 < 0.06 * guided.0, "{free:?} {guided:?}");
    assert!((free.0 - guided.0).abs() < 4.0 * free.1.hypot(guided.1), "{free:?} {guided:?}");
}

/// `P(first passage within some steps)` of three levels from one set of paths, guided to two of them, against free paths.
#[test]
fn one_set_of_paths_gives_the_passages_of_all_levels_and_times() {
    const LEVELS: [f64; 3] = [0.9, 1.3, 1.7];
    const STEPS: [u64; 2] = [4, N_STEPS as u64];
    let passages = Some(Passages { responses: &[RESPONSE], levels: &LEVELS });
    let of = |guides: &[Guide], n: u64| {
        let push = |sums: &mut Vec<Accumulator>, path: &GuidedPath<'_>| {
            let events = STEPS.iter().flat_map(|steps| (0..3).map(move |level| (level, *steps)));
            for (sum, (level, steps)) in sums.iter_mut().zip(events) {
                let passage = path.passages[level].filter(|passage| passage.steps <= steps);
                sum.push(passage.map_or(0.0, |passage| passage.log_weight.exp()));
            }
        };
        let join = |mut earlier: Vec<Accumulator>, later: Vec<Accumulator>| {
            for (sum, more) in earlier.iter_mut().zip(&later) {
                sum.merge(more);
            }
            earlier
        };
        let new = || vec![Accumulator::default(); 6];
        ensemble(guides, passages).run(0..n, new, push, join).unwrap()
    };
    let guides: Vec<Guide> = [(1.0, 0), (-1.0, 0), (1.0, 2), (-1.0, 2)]
        .into_iter()
        .map(|(sign, level)| Guide { level, ..guide(0.24, sign) })
        .collect();
    for (free, guided) in of(&[], 100_000).iter().zip(of(&guides, 40_000)) {
        let (free, guided) = (free.estimate().unwrap(), guided.estimate().unwrap());
        let error = free.standard_error().unwrap().hypot(guided.standard_error().unwrap());
        assert!(error < 0.1 * free.value, "{free} {guided}");
        assert!((free.value - guided.value).abs() < 4.0 * error, "{free} {guided}");
    }
}

#[test]
fn without_a_guide_the_paths_are_those_of_an_ensemble() {
    let law = GaussianMixture::independent([0.0; 2], DEVIATIONS).unwrap();
    let times = vec![DT * N_STEPS as f64];
    let config = EnsembleConfig { seed: 42, n_paths: 100, dt: DT, times };
    let observables = [Observable::Mean(&|_, x: &[f64; 2]| x[0])];
    let expected = simulate(&OSCILLATOR, &StrangOscillator, &law, &config, &observables).unwrap();
    let mut mean = Accumulator::default();
    for [q, _, log_weight] in paths(&[], None, 0..100).unwrap() {
        assert_eq!(log_weight.to_bits(), 0.0_f64.to_bits() | log_weight.to_bits() & 1 << 63);
        mean.push(q);
    }
    assert_eq!(mean.estimate().unwrap(), expected.estimates[0][0]);
    let expected = maxima(&OSCILLATOR, &StrangOscillator, &law, &config, &RESPONSE).unwrap();
    let watched = paths(&[], Some(through(&1.0)), 0..100).unwrap();
    for level in [0.5, 1.0] {
        let n_above = watched.iter().filter(|[_, largest, _]| *largest > level).count();
        let above = n_above as f64 / 100.0;
        assert!((above - expected[0].exceedance(level).unwrap().value).abs() < 1e-15);
    }
}

#[cfg(feature = "rayon")]
#[test]
fn guided_paths_have_the_same_bits_for_any_number_of_threads_and_in_any_part() {
    let guides = [guide(0.5, 1.0), guide(0.3, -1.0)];
    let n = 2 * 4096 + 37;
    let on = |n_threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| paths(&guides, Some(through(&1.0)), 0..n).unwrap())
    };
    let alone = on(1);
    assert_eq!(alone.len() as u64, n);
    assert_eq!(alone, on(2));
    assert_eq!(alone, on(8));
    // The blocks of a part are those of the whole.
    let of = |blocks| {
        let ensemble = ensemble(&guides, Some(through(&1.0)));
        ensemble.blocks((0..n, 4096), blocks, Vec::new, push).unwrap().concat()
    };
    assert_eq!(alone[4096..], of(1..3));
    assert_eq!(alone, [of(0..1), of(1..2), of(2..3)].concat());
    assert!(of(3..4).is_empty());
}

/// Of 1000 paths in blocks of 100, each guide has its share in each block within one path at either end of its stratum.
#[test]
fn each_block_has_the_shares_of_the_guides() {
    // Starts far apart, by which the guide of a path is known.
    let far = |share: f64, sign: f64| Guide { start: vec![40.0 * sign, 0.0], ..guide(share, 1.0) };
    let guides = [far(0.5, 1.0), far(0.3, -1.0)];
    let push = |counts: &mut [u32; 3], path: &GuidedPath<'_>| {
        let [up, down] = [0, 1].map(|k| path.log_ratios[k] > 0.0);
        counts[usize::from(!up) + usize::from(!up && !down)] += 1;
    };
    let ensemble = ensemble(&guides, None);
    let blocks = ensemble.blocks((0..1000, 100), 0..10, || [0; 3], push).unwrap();
    assert_eq!(blocks.len(), 10);
    for counts in blocks {
        for (count, expected) in counts.into_iter().zip([50_u32, 30, 20]) {
            assert!(expected.abs_diff(count) <= 1, "{counts:?}");
        }
    }
}

#[test]
fn invalid_shares_guides_and_ranges_are_refused() {
    let refused = |guides: &[Guide]| paths(guides, None, 0..10).unwrap_err();
    for share in [0.0, -0.1, 1.1] {
        let error = refused(&[guide(share, 1.0)]);
        assert!(
            matches!(error, Error::OutOfRange { value, .. } if value.to_bits() == share.to_bits())
        );
    }
    let error = refused(&[guide(0.6, 1.0), guide(0.6, 1.0)]);
    assert!(matches!(error, Error::OutOfRange { to, .. } if (to - 0.4).abs() < 1e-15), "{error}");
    let mut broken = guide(0.5, 1.0);
    broken.feedback[11] = f64::NAN;
    assert!(matches!(refused(&[guide(0.1, 1.0), broken]), Error::NotFinite { index: 1, .. }));
    let short = Guide { start: vec![0.1], ..guide(0.5, 1.0) };
    assert!(matches!(refused(&[short]), Error::WrongLength { value: 1, expected: 2, .. }));
    let short = Guide { hold: 2, ..guide(0.5, 1.0) };
    assert!(matches!(refused(&[short]), Error::WrongLength { value: 24, expected: 12, .. }));
    let endless = Guide { level: 1, ..guide(0.5, 1.0) };
    assert!(matches!(refused(&[endless]), Error::OutOfRange { quantity: "level of a guide", .. }));
    let responses = &[RESPONSE];
    let none = Passages { responses: &[], levels: &[1.0] };
    let (falling, empty) = ([1.0, 0.5], []);
    for passages in [none, Passages { responses, levels: &empty }] {
        let refused = paths(&[], Some(passages), 0..10).unwrap_err();
        assert!(matches!(refused, Error::TooFew { value: 0, limit: 1, .. }), "{refused}");
    }
    let refused = paths(&[], Some(Passages { responses, levels: &falling }), 0..10).unwrap_err();
    assert!(matches!(refused, Error::OutOfRange { value: 0.5, from: 1.0, .. }), "{refused}");
    let none = paths(&[], None, 5..5).unwrap_err();
    assert!(matches!(none, Error::TooFew { quantity: "paths", .. }), "{none}");
}
