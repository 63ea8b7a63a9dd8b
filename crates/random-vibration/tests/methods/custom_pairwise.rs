//! Guided paths of systems whose number of states is known at run time.

use random_vibration::{
    FreePassages, GuidedConfig, GuidedEstimate, GuidedPaths, PairwiseRule, PassageQuestion,
    SubsetConfig, TailError, Tails, free_passages, subset_passage,
};
use sde_integrators::{
    Between, LaneSde, PairTerm, PairwiseSde, Response, Side, normal_probability,
};

use crate::systems::Oscillator;

/// `q'' + 2 xi w q' + w^2 ((1 - h) q + h z) = W` with `z' = q' (1 - 0.5 (sign(q' z) + 1) |z|/z_y)`; linear for `h = 0`.
#[derive(Debug, Clone, Copy)]
struct Hysteretic {
    share: f64,
    yield_drift: f64,
}

const LINEAR: Oscillator = Oscillator { frequency: 2.0, damping: 0.05, intensity: 0.1, cubic: 0.0 };

impl Hysteretic {
    fn rate(&self, v: f64, z: f64) -> f64 {
        v * (1.0 - 0.5 * (1f64.copysign(v * z) + 1.0) * z.abs() / self.yield_drift)
    }
}

impl LaneSde for Hysteretic {
    fn n_states(&self) -> usize {
        3
    }

    #[inline]
    fn drift<const L: usize>(&self, _: f64, x: &[[f64; L]], drift: &mut [[f64; L]]) {
        let Oscillator { frequency: w, damping: xi, .. } = LINEAR;
        for lane in 0..L {
            let [q, v, z] = std::array::from_fn(|i| x[i][lane]);
            let spring = (1.0 - self.share) * q + self.share * z;
            drift[0][lane] = v;
            drift[1][lane] = -2.0 * xi * w * v - w * w * spring;
            drift[2][lane] = self.rate(v, z);
        }
    }

    fn noise(&self, _: f64, g: &mut [f64]) {
        g.copy_from_slice(&[0.0, (2.0 * LINEAR.intensity).sqrt(), 0.0]);
    }
}

impl PairwiseSde for Hysteretic {
    fn linear_part(&self) -> Vec<(usize, usize, f64)> {
        let Oscillator { frequency: w, damping: xi, .. } = LINEAR;
        let (q, z) = (-w * w * (1.0 - self.share), -w * w * self.share);
        vec![(0, 1, 1.0), (1, 0, q), (1, 1, -2.0 * xi * w), (1, 2, z)]
    }

    fn pair_terms(&self) -> Vec<PairTerm> {
        vec![PairTerm { row: 2, states: [1, 2] }]
    }

    fn pair_term(&self, _: usize, v: f64, z: f64) -> f64 {
        self.rate(v, z)
    }
}

const RULE: PairwiseRule = PairwiseRule { step: 0.1, hold: 2, unmodelled: 0.0 };
const SPAN: (f64, usize) = (6.0, 150);
const CONFIG: GuidedConfig =
    GuidedConfig { n_paths: 4_000, n_pilots: 400, unguided: 0.05, seed: 5 };
const RESPONSE: Response<'_> = Response {
    component: 0,
    side: Side::Magnitude,
    between: Between::CubicHermite { velocity: 1 },
};

#[test]
fn a_linear_system_from_rest_is_found_at_any_probability() {
    let system = Hysteretic { share: 0.0, yield_drift: 1.0 };
    let paths = GuidedPaths::from_rest(&system, SPAN, &RULE).unwrap();
    let deviation = LINEAR.covariance([[0.0; 2]; 2], SPAN.0)[0][0].sqrt();
    for z in [3.3, 4.9, 6.1] {
        let expected = 2.0 * normal_probability(-z);
        let found = paths.exceedance(z * deviation, Tails::Both, &CONFIG).unwrap();
        let error = found.estimate.standard_error().unwrap();
        assert!(error < 0.03 * expected, "{z}: {expected:e} {found:?}");
        // 150 steps: the variance errs by (omega h)^2/12 = 5.3e-4, times z^2/2 in the tail.
        let off = (found.estimate.value - expected).abs();
        assert!(off < 4.0 * error + 3e-4 * z * z * expected, "{z}: {expected:e} {found:?}");
    }
}

#[test]
fn one_set_of_guided_paths_gives_the_passages_of_free_paths_at_all_thresholds_and_times() {
    let system = Hysteretic { share: 0.5, yield_drift: 0.3 };
    let paths =
        GuidedPaths::from_rest(&system, SPAN, &PairwiseRule { unmodelled: 0.25, ..RULE }).unwrap();
    let (responses, n_steps) = (&[RESPONSE][..], &[75, 150][..]);
    let question = PassageQuestion { responses, thresholds: &[0.8, 1.0], n_steps };
    let free = free_passages(&system, SPAN, &question, (200_000, 8)).unwrap();
    let found = paths.first_passages(&question, &CONFIG).unwrap();
    assert_eq!((found.len(), found[0].len()), (2, 2));
    for (found, free) in found.iter().flatten().zip(free.iter().flatten()) {
        let found = found.as_ref().unwrap();
        let error = found.estimate.standard_error().unwrap();
        assert!(free.value > 2e-4 && free.value < 0.2, "{free}");
        assert!(error < 0.1 * found.estimate.value, "{free} {found:?}");
        let off = (found.estimate.value - free.value).abs();
        assert!(off < 4.0 * error.hypot(free.standard_error().unwrap()), "{free} {found:?}");
    }
    let rare = paths.first_passage(&RESPONSE, 1.8, &CONFIG).unwrap();
    assert!(rare.estimate.value < 1e-5, "{rare:?}");
    assert!(rare.estimate.standard_error().unwrap() < 0.15 * rare.estimate.value, "{rare:?}");
}

/// Bits of all values and errors.
fn bits(all: &[Vec<Result<GuidedEstimate, TailError>>]) -> Vec<[u64; 3]> {
    let of = |found: &Result<GuidedEstimate, TailError>| match found {
        Ok(GuidedEstimate { estimate, largest_share, .. }) => {
            let error = estimate.standard_error().unwrap_or(f64::NAN);
            [estimate.value, error, *largest_share].map(f64::to_bits)
        }
        Err(_) => [0; 3],
    };
    all.iter().flatten().map(of).collect()
}

#[test]
fn blocks_that_run_apart_give_the_bits_of_one_run_and_other_blocks_are_refused() {
    let system = Hysteretic { share: 0.5, yield_drift: 0.3 };
    let paths = GuidedPaths::from_rest(&system, SPAN, &RULE).unwrap();
    let (responses, n_steps) = (&[RESPONSE][..], &[75, 150][..]);
    let question = PassageQuestion { responses, thresholds: &[0.8, 1.0], n_steps };
    let config = GuidedConfig { n_paths: 2_100, ..CONFIG };
    let whole = paths.first_passages(&question, &config).unwrap();
    // As two processes make it.
    let [study, other] = [0, 1].map(|_| paths.passage_study(&question, &config).unwrap());
    let n = study.n_blocks();
    assert!(n == 5 && study.path_steps() == 150 * (2_100 + 400), "{n}");
    let parts = [(&study, 0..2), (&other, 2..3), (&study, 3..n)];
    let apart = parts.map(|(study, part)| study.blocks(part).unwrap()).concat();
    assert_eq!(bits(&other.estimates(&apart).unwrap()), bits(&whole));
    for wrong in [&apart[1..], &[&apart[..4], &apart[..1]].concat()] {
        let refused = study.estimates(wrong).unwrap_err().to_string();
        assert!(refused.contains("block"), "{refused}");
    }
    let refused = study.blocks(4..6).unwrap_err().to_string();
    assert!(refused.contains("block of guided paths"), "{refused}");
    let one = PassageQuestion { thresholds: &[0.8], ..question };
    let other = paths.passage_study(&one, &config).unwrap().blocks(0..n).unwrap();
    let refused = study.estimates(&other).unwrap_err().to_string();
    assert!(refused.contains("sums of a block"), "{refused}");

    let free = || FreePassages::new(&system, SPAN, &question, (2_100, 8)).unwrap();
    let apart = [0..1, 1..n].map(|part| free().blocks(part).unwrap()).concat();
    let whole = free_passages(&system, SPAN, &question, (2_100, 8)).unwrap();
    assert_eq!(free().estimates(&apart).unwrap(), whole);
}

#[test]
fn the_passage_of_any_of_several_responses_is_at_least_that_of_each() {
    let system = Hysteretic { share: 0.5, yield_drift: 0.3 };
    let paths = GuidedPaths::from_rest(&system, SPAN, &RULE).unwrap();
    let velocity = Response { component: 1, between: Between::Endpoints, ..RESPONSE };
    let both = [RESPONSE, velocity];
    let of = |responses: &[Response<'_>]| {
        let question = PassageQuestion { responses, thresholds: &[1.0], n_steps: &[150] };
        let free = free_passages(&system, SPAN, &question, (100_000, 8)).unwrap()[0][0];
        let found = paths.first_passages(&question, &CONFIG).unwrap().remove(0).remove(0).unwrap();
        let error = found.estimate.standard_error().unwrap().hypot(free.standard_error().unwrap());
        let off = (found.estimate.value - free.value).abs();
        assert!(off < 4.0 * error && error < 0.3 * free.value, "{free} {found:?}");
        free.value
    };
    let (any, each) = (of(&both), [of(&both[..1]), of(&both[1..])]);
    assert!(any > each[0] && any >= each[1] && any <= each[0] + each[1], "{any} {each:?}");
}

#[test]
fn subset_simulation_finds_the_passages_of_free_paths_and_refuses_a_bridge() {
    let system = Hysteretic { share: 0.5, yield_drift: 0.3 };
    let responses = &[RESPONSE][..];
    let question = PassageQuestion { responses, thresholds: &[0.8], n_steps: &[150] };
    let free = free_passages(&system, SPAN, &question, (50_000, 8)).unwrap()[0][0];
    let config = SubsetConfig { n_samples: 400, correlation: 0.8, n_runs: 16 };
    let found = subset_passage(&system, responses, 0.8, SPAN, (&config, 4)).unwrap();
    let error = found.standard_error().unwrap();
    assert!(error < 0.2 * found.value, "{found}");
    let off = (found.value - free.value).abs();
    assert!(off < 4.0 * error.hypot(free.standard_error().unwrap()), "{free} {found}");
    let between = Between::BrownianBridge { intensity: &|_, _| 1.0 };
    let bridged = [Response { between, ..RESPONSE }];
    let refused = subset_passage(&system, &bridged, 0.8, SPAN, (&config, 4)).unwrap_err();
    assert!(matches!(refused, TailError::Sampling(_)), "{refused}");
    let refused = subset_passage(&system, &[], 0.8, SPAN, (&config, 4)).unwrap_err();
    assert!(refused.to_string().contains("responses"), "{refused}");
}

#[test]
fn invalid_questions_are_refused() {
    let system = Hysteretic { share: 0.5, yield_drift: 0.3 };
    let paths = GuidedPaths::from_rest(&system, SPAN, &RULE).unwrap();
    let refused = |thresholds: &[f64], n_steps: &[usize]| {
        let question = PassageQuestion { responses: &[RESPONSE], thresholds, n_steps };
        let refused = paths.first_passages(&question, &CONFIG).unwrap_err();
        assert!(matches!(refused, TailError::Sampling(_)));
        refused.to_string()
    };
    assert!(refused(&[], &[150]).contains("thresholds"));
    assert!(refused(&[1.0], &[]).contains("times"));
    assert!(refused(&[1.0], &[151]).contains("number of steps to a time"));
    assert!(refused(&[1.0], &[80, 80]).contains("number of steps to a time"));
    assert!(refused(&[1.0, 0.5], &[150]).contains("level"));
    assert!(refused(&[f64::NAN], &[150]).contains("threshold"));
    for (span, rule) in [
        ((0.0, 10), RULE),
        ((1.0, 0), RULE),
        (SPAN, PairwiseRule { hold: 0, ..RULE }),
        (SPAN, PairwiseRule { unmodelled: -0.1, ..RULE }),
    ] {
        let refused = GuidedPaths::from_rest(&system, span, &rule).map(drop).unwrap_err();
        assert!(matches!(refused, TailError::Sampling(_)), "{refused}");
    }
    let rule = PairwiseRule { step: f64::NAN, ..RULE };
    let refused = GuidedPaths::from_rest(&system, SPAN, &rule).map(drop).unwrap_err();
    assert!(matches!(refused, TailError::Linearisation(_)), "{refused}");
    let refused = paths.with_demand(&[1.0]).map(drop).unwrap_err().to_string();
    assert_eq!(refused, "1 weights, must be 3");
}
