//! First passages of linear oscillators by guided paths, against the importance sampling of Au and Beck.

use random_vibration::{GuidedConfig, GuidedPaths, PairwiseRule, PassageQuestion};
use sde_integrators::{
    Accumulator, Between, DrivenLanes, Estimate, LaneSde, Noise, PairTerm, PairwiseSde, Purpose,
    Response, Side, normal_probability, normal_quantile,
};

/// `q'' + 2 xi w q' + w^2 q = W` with `w = 2 pi`, so that a period is 1; the stationary variance of `q` is 1.
#[derive(Debug, Clone, Copy)]
struct Linear {
    damping: f64,
}

const W: f64 = std::f64::consts::TAU;

impl LaneSde for Linear {
    fn n_states(&self) -> usize {
        2
    }

    fn drift<const L: usize>(&self, _: f64, x: &[[f64; L]], drift: &mut [[f64; L]]) {
        for lane in 0..L {
            drift[0][lane] = x[1][lane];
            drift[1][lane] = -2.0 * self.damping * W * x[1][lane] - W * W * x[0][lane];
        }
    }

    fn noise(&self, _: f64, g: &mut [f64]) {
        g.copy_from_slice(&[0.0, (4.0 * self.damping * W * W * W).sqrt()]);
    }
}

impl PairwiseSde for Linear {
    fn linear_part(&self) -> Vec<(usize, usize, f64)> {
        vec![(0, 1, 1.0), (1, 0, -W * W), (1, 1, -2.0 * self.damping * W)]
    }

    fn pair_terms(&self) -> Vec<PairTerm> {
        Vec::new()
    }

    fn pair_term(&self, _: usize, _: f64, _: f64) -> f64 {
        0.0
    }
}

/// `P(max |q_i| > T)` over the ends of steps from rest: `sum_i P(|q_i| > T) E[1/N]`, with the number `N` of steps beyond `T`, and
/// paths given `|q_i| > T` at a step drawn by its probability.
///
/// Source: Au and Beck 2001, First excursion probabilities for linear systems by very efficient importance sampling.
fn reference(system: Linear, (time, n): (f64, usize), threshold: f64) -> Estimate {
    let driven = DrivenLanes { system: &system, dt: time / n as f64 };
    let displacements = |normals: &[f64]| {
        let mut all = Vec::with_capacity(n);
        driven.run(&[0.0; 2], normals, |_, x| all.push(x[0][0])).unwrap();
        all
    };
    let mut normals = vec![0.0; n];
    normals[0] = 1.0;
    let impulse = displacements(&normals);
    let variances = impulse.iter().scan(0.0, |sum, h| {
        *sum += h * h;
        Some(*sum)
    });
    let deviations: Vec<f64> = variances.map(f64::sqrt).collect();
    let likely = |deviation: &f64| 2.0 * normal_probability(-threshold / deviation);
    let total: f64 = deviations.iter().map(likely).sum();
    let mut stream = Noise::new(77).stream(Purpose::MarkovChain, 1);
    let mut mean = Accumulator::default();
    for _ in 0..6_000 {
        stream.fill_normal(&mut normals);
        let mut place = stream.next_uniform() * total;
        let passed = |deviation: &f64| {
            place -= likely(deviation);
            place < 0.0
        };
        let end = deviations.iter().position(passed).unwrap_or(n - 1);
        let deviation = deviations[end];
        let rarer = stream.next_uniform() * normal_probability(-threshold / deviation);
        let beyond = -normal_quantile(rarer);
        let direction: Vec<f64> = impulse[..=end].iter().rev().map(|h| h / deviation).collect();
        let along: f64 = direction.iter().zip(&normals).map(|(d, z)| d * z).sum();
        for (z, d) in normals.iter_mut().zip(&direction) {
            *z += d * (beyond - along);
        }
        let count = displacements(&normals).iter().filter(|q| q.abs() > threshold).count();
        mean.push(total / count.max(1) as f64);
    }
    mean.estimate().unwrap()
}

/// Lightly damped passages fall between two guides most easily; a low threshold is passed by nearly all paths; 24 periods need many
/// guides; ten steps a period are further apart than the ends of guides to six deviations.
#[test]
fn first_passages_of_linear_oscillators_are_unbiased_with_the_stated_error_and_none_is_refused() {
    for (damping, span, thresholds, n_seeds) in [
        (0.012, (3.5, 175), &[1.8, 3.4][..], 12),
        (0.03, (2.0, 200), &[2.2], 8),
        (0.3, (5.0, 200), &[2.5, 4.5], 4),
        (0.07, (3.0, 90), &[0.4, 1.2], 8),
        (0.15, (24.0, 720), &[3.5], 2),
        (0.05, (5.0, 50), &[6.0], 8),
    ] {
        let system = Linear { damping };
        let rule = PairwiseRule { step: 0.02, hold: 2, unmodelled: 0.0 };
        let paths = GuidedPaths::from_rest(&system, span, &rule).unwrap();
        let (side, between) = (Side::Magnitude, Between::Endpoints);
        let (responses, n_steps) = (&[Response { component: 0, side, between }][..], &[span.1][..]);
        let question = PassageQuestion { responses, thresholds, n_steps };
        let exact: Vec<Estimate> =
            thresholds.iter().map(|threshold| reference(system, span, *threshold)).collect();
        let mut means = vec![Accumulator::default(); thresholds.len()];
        let mut squares = 0.0;
        for seed in 0..n_seeds {
            let config = GuidedConfig { n_paths: 2_000, n_pilots: 200, unguided: 0.05, seed };
            let found = paths.first_passages(&question, &config).unwrap().remove(0);
            for ((found, exact), mean) in found.into_iter().zip(&exact).zip(&mut means) {
                let found = found.unwrap();
                let error = found.estimate.standard_error().unwrap();
                assert!(found.largest_share < 0.03 && error < 0.05 * exact.value, "{found:?}");
                let of_reference = exact.standard_error().unwrap();
                let off = (found.estimate.value - exact.value) / error.hypot(of_reference);
                assert!(off.abs() < 4.5, "{damping} {seed}: {exact} {found:?}");
                squares += off * off;
                mean.push(found.estimate.value);
            }
        }
        for (mean, exact) in means.iter().zip(&exact) {
            let found = mean.estimate().unwrap();
            let error = found.standard_error().unwrap().hypot(exact.standard_error().unwrap());
            assert!((found.value - exact.value).abs() < 4.0 * error, "{damping}: {exact} {found}");
        }
        // The mean square of n normals is 1 within 4 sqrt(2/n).
        let n = n_seeds as f64 * thresholds.len() as f64;
        assert!(squares / n < 1.0 + 4.0 * (2.0 / n).sqrt(), "{damping}: {}", squares / n);
    }
}
