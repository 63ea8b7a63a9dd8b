//! Smoothing lengths within a step: their rate, and the order that it gives the method.

use fpk_sph::score::{Degree, LogDensityFit, SummationDensity, VolumeEstimate};
use fpk_sph::systems::{LinearOscillator, LinearOscillatorParameters, Window};
use fpk_sph::{
    Cloud, Combination, Config, DEFAULT_MOST_STEPS, Estimator, InitialLattice, Method,
    ScoreEstimator, Simulation, StepRule,
};
use neighbour_search::{BruteForce, NeighbourList, NeighbourSearch, Radii};
use sde_integrators::GaussianMixture;
use smoothing_kernels::{Kernel, Lucy};

/// A square of points, each moved a little by a wave.
fn points() -> Vec<[f64; 2]> {
    let place = |i: i32, j: i32| {
        let (a, b) = (f64::from(i), f64::from(j));
        [a + 0.2 * (1.3 * b).sin(), b + 0.2 * (0.7 * a + 0.4 * b).cos()]
    };
    (-4..=4).flat_map(|i| (-4..=4).map(move |j| place(i, j))).collect()
}

/// `sum_j W(r_ij, h_i)` of every point, itself included.
fn kernel_sums(points: &[[f64; 2]], h: &[f64]) -> Vec<f64> {
    let sum = |i: usize| {
        let to = |other: &[f64; 2]| {
            let r = (other[0] - points[i][0]).hypot(other[1] - points[i][1]);
            Kernel::<2>::value(&Lucy, r, h[i])
        };
        points.iter().map(to).sum()
    };
    (0..points.len()).map(sum).collect()
}

fn rates(
    estimator: &dyn ScoreEstimator<2>,
    points: &[[f64; 2]],
    h: &[f64],
    velocities: &[[f64; 2]],
) -> Vec<f64> {
    let radii: Vec<f64> = h.iter().map(|h| h * estimator.support()).collect();
    let mut neighbours = NeighbourList::new();
    let criterion = estimator.criterion().unwrap();
    let radii = Radii::PerPoint { radii: &radii, criterion };
    BruteForce::new().full_list(points, radii, &mut neighbours).unwrap();
    let cloud = Cloud {
        positions: points,
        masses: &vec![1.0; points.len()],
        smoothing_lengths: h,
        neighbours: &neighbours,
        lattice: &[],
        whitened: false,
        step: 0,
        time: 0.0,
    };
    let mut rates = vec![f64::NAN; 3];
    estimator.smoothing_rates(&cloud, velocities, &mut rates);
    rates
}

fn fit() -> LogDensityFit {
    LogDensityFit { volume: VolumeEstimate::KernelSum, ..LogDensityFit::default() }
}

#[test]
fn a_smoothing_length_changes_as_the_kernel_sum_that_it_keeps() {
    let (points, epsilon) = (points(), 1e-5);
    let velocities: Vec<[f64; 2]> =
        points.iter().map(|x| [0.4 * x[0] + (0.5 * x[1]).sin(), 0.1 * x[1] * x[0]]).collect();
    let h: Vec<f64> = points.iter().map(|x| 2.4 + 0.1 * (x[0] - x[1]).sin()).collect();
    let kept: Vec<f64> =
        kernel_sums(&points, &h).iter().zip(&h).map(|(sum, h)| h * sum.sqrt()).collect();
    // h with the same product at the points moved by +-epsilon: eq 20 iterated until it settles.
    let at = |epsilon: f64| {
        let moved: Vec<[f64; 2]> = points
            .iter()
            .zip(&velocities)
            .map(|(x, v)| [x[0] + epsilon * v[0], x[1] + epsilon * v[1]])
            .collect();
        let mut h = h.clone();
        for _ in 0..200 {
            let sums = kernel_sums(&moved, &h);
            for ((h, kept), sum) in h.iter_mut().zip(&kept).zip(sums) {
                *h = kept / sum.sqrt();
            }
        }
        h
    };
    let (after, before) = (at(epsilon), at(-epsilon));
    let found = rates(&fit(), &points, &h, &velocities);
    assert_eq!(found.len(), points.len());
    for ((rate, after), before) in found.iter().zip(after).zip(before) {
        let expected = (after / before).ln() / (2.0 * epsilon);
        // The square of epsilon, and roundoff over it.
        assert!((rate - expected).abs() < 1e-8 * (1.0 + expected.abs()), "{rate} {expected}");
    }
}

#[test]
fn an_even_expansion_is_followed_at_its_rate_and_a_lone_particle_keeps_its_length() {
    let points = points();
    let velocities: Vec<[f64; 2]> = points.iter().map(|x| x.map(|c| 0.3 * c)).collect();
    for rate in rates(&fit(), &points, &vec![2.5; points.len()], &velocities) {
        assert!((rate - 0.3).abs() < 1e-14, "{rate}");
    }
    let alone = rates(&fit(), &points[..1], &[2.5], &velocities[..1]);
    assert!(alone.len() == 1 && alone[0].abs() < f64::MIN_POSITIVE);
    // The paper's estimator has none: its smoothing lengths are frozen.
    let papers = SummationDensity::<Lucy>::default();
    assert!(rates(&papers, &points, &vec![2.5; points.len()], &velocities).is_empty());
}

/// `E[v^2]` of the linear oscillator by kernel-sum volumes, whose density depends on the smoothing lengths.
fn second_moment(steps_per_period: f64) -> f64 {
    let system = LinearOscillator::new(LinearOscillatorParameters {
        natural_frequency: std::f64::consts::PI,
        damping_ratio: 0.05,
        noise_intensity: 0.2,
        window: Window::Stationary,
    })
    .unwrap();
    let (volume, degree) = (VolumeEstimate::KernelSum, Degree::Quadratic);
    let method = Method::Custom(Combination {
        estimator: Estimator::LogDensityFit { volume, degree },
        step: StepRule::PeriodFraction { steps_per_period },
        ..Method::LogDensityFit.combination()
    });
    let law = GaussianMixture::independent([0.0; 2], [0.1, 0.4]).unwrap();
    let config = Config {
        method,
        lattice: InitialLattice::Ball { reach: 4.0, spacing: 0.5 },
        reference_period: system.period(),
        most_steps: DEFAULT_MOST_STEPS,
    };
    let mut simulation = Simulation::new(system, &law, &config).unwrap();
    simulation.advance_to(1.0).unwrap();
    simulation.raw_moment([0, 2])
}

#[test]
fn halving_the_step_leaves_a_quarter_of_its_error() {
    let [coarse, middle, fine] = [40.0, 80.0, 160.0].map(second_moment);
    let ratio = (coarse - middle) / (middle - fine);
    // Frozen lengths leave a half.
    assert!(ratio.abs() > 3.2, "{coarse} {middle} {fine}: {ratio}");
}
