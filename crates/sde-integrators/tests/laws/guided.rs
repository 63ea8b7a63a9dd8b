//! Guided paths: unbiased for any guide, those of an ensemble without one, bitwise identical for any number of threads.

use sde_integrators::{
    Accumulator, Between, EnsembleConfig, Error, GaussianMixture, Guidance, Guide, GuidedEnsemble,
    GuidedPath, Observable, Response, Side, StateSpace, StrangOscillator, maxima, simulate,
};

use crate::methods::Linear;

const OSCILLATOR: StateSpace<Linear> = StateSpace(Linear::oscillator(2.0, 0.3, 0.9));
/// Of the stationary distribution: `0.81/0.6` of the velocity, over `2^2` of the displacement.
const DEVIATIONS: [f64; 2] = [0.580_947_501_931_1, 1.161_895_003_862_2];
const N_STEPS: usize = 10;
const DT: f64 = 0.2;

const RESPONSE: Response<'_, 2> = Response {
    component: 0,
    side: Side::Magnitude,
    between: Between::CubicHermite { velocity: 1 },
};

/// A guide from no theory, so that nothing but its weights can make the result right.
fn guide(share: f64, sign: f64) -> Guide<2, 1> {
    let step = |k: usize| Guidance {
        state: [sign * 0.8, sign * 0.5],
        offset: -1.0 - 0.1 * k as f64,
        brownian: [sign * 0.4],
        area: [0.1],
    };
    Guide { share, start: [sign * 0.7, -0.2], steps: (0..N_STEPS - 2).map(step).collect() }
}

fn ensemble<'a>(
    guides: &'a [Guide<2, 1>],
    passage: Option<(&'a Response<'a, 2>, f64)>,
) -> GuidedEnsemble<'a, StateSpace<Linear>, StrangOscillator, 2, 1> {
    let [of_q, of_v] = DEVIATIONS;
    GuidedEnsemble {
        system: &OSCILLATOR,
        integrator: &StrangOscillator,
        mean: [0.0; 2],
        factor: [[of_q, 0.0], [0.0, of_v]],
        dt: DT,
        n_steps: N_STEPS,
        guides,
        passage,
        seed: 42,
    }
}

/// Ends, largest responses and weights.
fn paths(
    guides: &[Guide<2, 1>],
    passage: Option<(&Response<'_, 2>, f64)>,
    realisations: std::ops::Range<u64>,
) -> Result<Vec<[f64; 3]>, Error> {
    let push = |all: &mut Vec<[f64; 3]>, path: &GuidedPath<'_, 2>| {
        all.push([path.end[0], path.largest, path.log_weight]);
    };
    let join = |mut earlier: Vec<_>, later: Vec<_>| {
        earlier.extend(later);
        earlier
    };
    ensemble(guides, passage).run(realisations, Vec::new, push, join)
}

#[test]
fn weights_undo_any_guide() {
    let n = 40_000;
    for guides in [vec![guide(0.8, 1.0)], vec![guide(0.4, 1.0), guide(0.6, -1.0)]] {
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
    let passage = Some((&RESPONSE, level));
    let of = |guides: &[Guide<2, 1>], n| {
        let mut mean = Accumulator::default();
        for [_, largest, log_weight] in paths(guides, passage, 0..n).unwrap() {
            mean.push(if largest > level { log_weight.exp() } else { 0.0 });
        }
        let estimate = mean.estimate().unwrap();
        (estimate.value, estimate.standard_error().unwrap())
    };
    let (free, guided) = (of(&[], 100_000), of(&[guide(0.5, 1.0), guide(0.5, -1.0)], 20_000));
    assert!(free.1 < 0.02 * free.0 && guided.1 < 0.06 * guided.0, "{free:?} {guided:?}");
    assert!((free.0 - guided.0).abs() < 4.0 * free.1.hypot(guided.1), "{free:?} {guided:?}");
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
    let watched = paths(&[], Some((&RESPONSE, 1.0)), 0..100).unwrap();
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
        pool.install(|| paths(&guides, Some((&RESPONSE, 1.0)), 0..n).unwrap())
    };
    let alone = on(1);
    assert_eq!(alone.len() as u64, n);
    assert_eq!(alone, on(2));
    assert_eq!(alone, on(8));
    assert_eq!(alone[4000..4100], paths(&guides, Some((&RESPONSE, 1.0)), 4000..4100).unwrap());
}

#[test]
fn invalid_shares_guides_and_ranges_are_refused() {
    let refused = |guides: &[Guide<2, 1>]| paths(guides, None, 0..10).unwrap_err();
    for share in [0.0, -0.1, 1.1] {
        let error = refused(&[guide(share, 1.0)]);
        assert!(
            matches!(error, Error::OutOfRange { value, .. } if value.to_bits() == share.to_bits())
        );
    }
    let error = refused(&[guide(0.6, 1.0), guide(0.6, 1.0)]);
    assert!(matches!(error, Error::OutOfRange { to, .. } if (to - 0.4).abs() < 1e-15), "{error}");
    let mut broken = guide(0.5, 1.0);
    broken.steps[3].offset = f64::NAN;
    assert!(matches!(refused(&[guide(0.1, 1.0), broken]), Error::NotFinite { index: 1, .. }));
    let none = paths(&[], None, 5..5).unwrap_err();
    assert!(matches!(none, Error::TooFew { quantity: "paths", .. }), "{none}");
}
