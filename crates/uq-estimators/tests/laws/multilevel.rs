//! Multilevel Monte Carlo on ladders with closed forms.

use sde_integrators::{EulerMaruyama, General, Noise, Purpose, Sde, Shark};
use uq_estimators::{
    Bias, Error, Failure, Ladder, Levels, Multilevel, MultilevelResult, Pair, PathLadder, Progress,
    Statistic, Target, Tolerance,
};

/// `dX = mu X dt + sigma X dW` from 1.
struct Growth {
    mu: f64,
    sigma: f64,
}

impl Sde<1, 1> for Growth {
    type Noise = General;
    fn drift(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
        [self.mu * x[0]]
    }
    fn noise(&self, _: f64, x: &[f64; 1]) -> [[f64; 1]; 1] {
        [[self.sigma * x[0]]]
    }
}

const GROWTH: Growth = Growth { mu: 0.05, sigma: 0.2 };

type Respond = fn(&[f64; 1], &mut [f64]);

fn state(x: &[f64; 1], y: &mut [f64]) {
    y[0] = x[0];
}

fn growth(seed: u64) -> PathLadder<'static, Growth, EulerMaruyama, [f64; 1], Respond, 1, 1> {
    PathLadder {
        system: &GROWTH,
        integrator: &EulerMaruyama,
        law: &[1.0],
        seed,
        end: 1.0,
        coarsest_steps: 1,
        n_levels: 10,
        n_responses: 1,
        responses: state,
    }
}

fn study(targets: &[Target]) -> Multilevel<'_> {
    let bias = Bias::Order(1.0);
    Multilevel { name: "growth", targets, bias, block_length: 64, pilot_blocks: 2, budget: 1e9 }
}

/// Mean, variance and probability of exceeding 1.2 of the exact solution.
fn targets(scale: f64) -> [Target; 3] {
    let statistics = [
        Statistic::Mean,
        Statistic::Variance,
        Statistic::SmoothedExceedance { threshold: 1.2, width: 0.1 },
    ];
    let tolerances = [4e-3, 3e-3, 1.2e-2];
    std::array::from_fn(|k| Target {
        response: 0,
        statistic: statistics[k],
        tolerance: Tolerance::Absolute(scale * tolerances[k]),
    })
}

/// The closed forms: mean `exp(mu)`, variance `exp(2 mu) (exp(sigma^2) - 1)`, and `Phi(-z)` with
/// `z = (ln 1.2 - mu + sigma^2/2) / sigma = 0.761608`, by a table of the normal distribution to seven digits.
fn exact() -> [f64; 3] {
    [0.05_f64.exp(), 0.1_f64.exp() * (0.04_f64.exp() - 1.0), 0.223147]
}

fn bits(result: &MultilevelResult) -> Vec<u64> {
    let numbers = result.targets.iter().flat_map(|target| {
        [target.estimate.value, target.estimate.standard_error().unwrap(), target.bias.value]
    });
    numbers.map(f64::to_bits).collect()
}

#[test]
fn moments_and_a_probability_are_within_their_tolerances() {
    let found = study(&targets(1.0)).run(&growth(3)).unwrap();
    for ((target, asked), exact) in found.targets.iter().zip(targets(1.0)).zip(exact()) {
        assert!(target.is_reached, "{found:?}");
        let error = target.estimate.value - exact;
        let Tolerance::Absolute(tolerance) = asked.tolerance else { panic!("{asked:?}") };
        assert!(error.abs() < 3.0 * tolerance + target.smoothing, "{error} {target:?}");
    }
    assert!(found.pays(), "{found:?}");
}

#[test]
fn standard_errors_are_the_scatter_of_repetitions() {
    let asked = targets(2.5);
    let n_runs = 60;
    let (mut squares, mut claimed) = ([0.0; 3], [0.0; 3]);
    for seed in 0..n_runs {
        let found = study(&asked).run(&growth(1000 + seed)).unwrap();
        for (k, target) in found.targets.iter().enumerate() {
            let standard_error = target.estimate.standard_error().unwrap();
            let bias = target.bias_bound + target.smoothing;
            let error = (target.estimate.value - exact()[k]).abs();
            squares[k] += (error - bias).max(0.0).powi(2);
            claimed[k] += standard_error.powi(2);
        }
    }
    for k in 0..3 {
        // Beyond the bias the mean square is at most the variance: its own error with 60 runs is 18 %, four of them.
        assert!(squares[k] < 1.75 * claimed[k], "{squares:?} {claimed:?}");
        assert!(squares[k] > 0.05 * claimed[k], "{squares:?} {claimed:?}");
    }
}

#[test]
fn a_run_in_pieces_and_on_other_threads_has_the_same_bits() {
    let (asked, ladder) = (targets(2.0), growth(5));
    let study = study(&asked);
    let on = |n_threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| study.run(&ladder).unwrap())
    };
    let whole = on(1);
    assert_eq!(bits(&whole), bits(&on(2)));
    assert_eq!(bits(&whole), bits(&on(8)));

    // Blocks apart, in reverse, from a state that is copied each time.
    let mut progress: Progress = study.begin(&ladder).unwrap();
    while study.advance(&ladder, &mut progress).unwrap() {
        for id in progress.missing().into_iter().rev() {
            let block = study.block(&ladder, &progress.clone(), id).unwrap();
            assert!(study.advance(&ladder, &mut progress.clone()).is_err());
            progress.insert(block.clone()).unwrap();
            assert!(matches!(progress.insert(block), Err(Error::UnwantedBlock { .. })));
        }
    }
    let apart = study.finish(&ladder, &progress).unwrap();
    assert_eq!(bits(&whole), bits(&apart));
    assert_eq!(whole, apart);
}

/// The difference of a pair of paths, by a method that uses the integral: order 1.5 for additive noise.
#[test]
fn coarse_paths_follow_the_fine_ones() {
    /// `dX = -sin 3X dt + 0.8 dW`.
    struct Sine;
    impl Sde<1, 1> for Sine {
        type Noise = sde_integrators::Additive;
        fn drift(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
            [-(3.0 * x[0]).sin()]
        }
        fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
            [[0.8]]
        }
    }
    let ladder = PathLadder::<_, _, _, _, 1, 1> {
        system: &Sine,
        integrator: &Shark,
        law: &[0.3],
        seed: 9,
        end: 1.0,
        coarsest_steps: 8,
        n_levels: 6,
        n_responses: 1,
        responses: state,
    };
    let mean_square = |fine: usize, coarse: usize| {
        let (mut sum, n) = (0.0, 400);
        for realisation in 0..n {
            let (mut y, mut below) = ([0.0], [0.0]);
            let pair = Pair { fine, coarse: Some(coarse) };
            ladder.sample(pair, realisation, &mut y, &mut below).unwrap();
            sum += (y[0] - below[0]).powi(2);
        }
        sum / f64::from(u32::try_from(n).unwrap())
    };
    let squares: Vec<f64> = (1..6).map(|level| mean_square(level, level - 1)).collect();
    let rate = (squares[0] / squares[4]).log2() / 4.0;
    // Strong order 1.5, so the mean square decreases as 2^-3; 0.2 is four errors of a ratio of 400 samples.
    assert!((rate - 3.0).abs() < 0.2, "{squares:?}");
    // A level skipped: the rest of the difference to the level between.
    let skipped = mean_square(4, 2);
    assert!(skipped > squares[2] && skipped < 4.0 * squares[2], "{skipped} {squares:?}");
}

fn uniform(realisation: u64) -> f64 {
    Noise::new(17).stream(Purpose::Field, realisation).next_uniform()
}

#[test]
fn levels_that_do_not_pay_are_dropped() {
    // Level 0 has nothing to do with the others and costs nearly as much; then no level helps.
    let costs = [1.0, 1.2, 10.0];
    let unrelated = |level: usize, realisation: u64, y: &mut [f64]| -> Result<(), Failure> {
        let u = uniform(realisation);
        y[0] = if level == 0 { 3.0 * (50.0 * u).sin() } else { u + 0.01 * (level as f64) * u * u };
        Ok(())
    };
    let targets =
        [Target { response: 0, statistic: Statistic::Mean, tolerance: Tolerance::Absolute(4e-3) }];
    let study = Multilevel { bias: Bias::FinestIsExact, ..study(&targets) };
    let found = study.run(&Levels { costs: &costs, n_responses: 1, run: unrelated }).unwrap();
    assert_eq!((found.coarsest, found.pays()), (1, true), "{found:?}");
    let exact = 0.5 + 0.02 / 3.0;
    assert!((found.targets[0].estimate.value - exact).abs() < 4.0 * 4e-3, "{found:?}");

    let all_unrelated = |level: usize, realisation: u64, y: &mut [f64]| -> Result<(), Failure> {
        let u = uniform(realisation);
        y[0] = if level == 2 { u } else { ((level + 1) as f64 * 50.0 * u).sin() };
        Ok(())
    };
    let ladder = Levels { costs: &costs, n_responses: 1, run: all_unrelated };
    let found = study.run(&ladder).unwrap();
    assert_eq!((found.coarsest, found.pays()), (2, false), "{found:?}");
    assert!((found.targets[0].estimate.value - 0.5).abs() < 4.0 * 4e-3, "{found:?}");
    // What it costs beyond plain Monte Carlo is the pilot.
    assert!(found.cost < found.single_level_cost * 1.1 + 128.0 * (1.0 + 2.2 + 11.2), "{found:?}");
}

/// The same with the finest level as the truth.
fn exact_study(targets: &[Target]) -> Multilevel<'_> {
    Multilevel { bias: Bias::FinestIsExact, ..study(targets) }
}

#[test]
fn relative_tolerances_are_met_by_the_standard_error_and_open_ones_ask_for_nothing() {
    // Levels of exp(2 u) by Taylor polynomials; the finest is of degree 8.
    let run = |level: usize, realisation: u64, y: &mut [f64]| -> Result<(), Failure> {
        let x = 2.0 * uniform(realisation);
        y[0] = (0..2_usize << level).rev().fold(1.0, |sum, k| 1.0 + x * sum / (k + 1) as f64);
        y[1] = 1e6 * y[0];
        y[2] = 3.0;
        Ok(())
    };
    let ladder = Levels { costs: &[1.0, 4.0, 16.0], n_responses: 3, run };
    let target = |response, statistic, tolerance| Target { response, statistic, tolerance };
    let asked = [
        target(0, Statistic::Mean, Tolerance::Relative(0.01)),
        target(0, Statistic::Variance, Tolerance::Relative(0.02)),
        // Neither of these adds a sample.
        target(1, Statistic::Variance, Tolerance::Open),
        target(2, Statistic::Mean, Tolerance::Relative(1e-9)),
        target(2, Statistic::Variance, Tolerance::Relative(1e-9)),
    ];
    let found = exact_study(&asked).run(&ladder).unwrap();
    let fewer = exact_study(&asked[..2]).run(&ladder).unwrap();
    assert_eq!(
        found.levels.iter().map(|level| level.n_samples).collect::<Vec<_>>(),
        fewer.levels.iter().map(|level| level.n_samples).collect::<Vec<_>>()
    );
    assert_eq!(found.targets[..2], fewer.targets[..]);
    // E e^(2u) = (e^2 - 1)/2, E e^(4u) = (e^4 - 1)/4.
    let mean = 0.5 * (2_f64.exp() - 1.0);
    let variance = 0.25 * (4_f64.exp() - 1.0) - mean * mean;
    for (found, exact) in found.targets.iter().zip([mean, variance]) {
        let error = (found.estimate.value - exact).abs();
        assert!(found.is_reached && error < 4.0 * found.estimate.standard_error().unwrap());
    }
    // The whole tolerance is for the standard error, and the variance decides.
    let [at_variance, scaled] = [1, 2].map(|k| {
        found.targets[k].estimate.standard_error().unwrap() / found.targets[k].estimate.value
    });
    assert!((0.017..=0.02).contains(&at_variance), "{at_variance}");
    assert!((scaled / at_variance - 1.0).abs() < 1e-9, "{scaled}");
    assert_eq!(found.targets[3].estimate.value, 3.0);
    assert_eq!(found.targets[4].estimate.value, 0.0);
    assert!(found.targets.iter().all(|target| target.is_reached));
}

/// Another mean as the coarser level than as the finer one.
struct Apart;
impl Ladder for Apart {
    fn n_levels(&self) -> usize {
        2
    }
    fn n_responses(&self) -> usize {
        1
    }
    fn cost(&self, level: usize) -> f64 {
        [1.0, 2.0][level]
    }
    fn sample(
        &self,
        pair: Pair,
        realisation: u64,
        fine: &mut [f64],
        coarse: &mut [f64],
    ) -> Result<(), Failure> {
        fine[0] = uniform(realisation);
        for y in coarse.iter_mut() {
            *y = uniform(realisation) + 0.5;
        }
        assert_eq!(coarse.len(), usize::from(pair.coarse.is_some()));
        Ok(())
    }
}

#[test]
fn bad_input_is_refused_with_its_value() {
    let good =
        [Target { response: 0, statistic: Statistic::Mean, tolerance: Tolerance::Absolute(0.01) }];
    let run = |_: usize, realisation: u64, y: &mut [f64]| -> Result<(), Failure> {
        y[0] = uniform(realisation);
        Ok(())
    };
    let two = Levels { costs: &[1.0, 2.0], n_responses: 1, run };
    for tolerance in [0.0, -1.0, f64::NAN] {
        for tolerance in [Tolerance::Absolute(tolerance), Tolerance::Relative(tolerance)] {
            let found = exact_study(&[Target { tolerance, ..good[0] }]).run(&two);
            assert!(matches!(found, Err(Error::NotPositive { quantity: "tolerance", .. })));
        }
    }
    let found = exact_study(&[Target { tolerance: Tolerance::Open, ..good[0] }]).run(&two);
    assert!(matches!(found, Err(Error::TooFew { quantity: "targets with a tolerance", .. })));
    let found = exact_study(&[Target { response: 1, ..good[0] }]).run(&two);
    assert!(matches!(found, Err(Error::NoSuchResponse { response: 1, limit: 1, .. })));
    let falling = Levels { costs: &[2.0, 2.0], ..two };
    let found = exact_study(&good).run(&falling);
    assert!(matches!(found, Err(Error::CostNotIncreasing { level: 1, .. })));
    let found = Multilevel { block_length: 3, pilot_blocks: 2, ..exact_study(&good) }.run(&two);
    assert!(matches!(found, Err(Error::TooFew { value: 6, limit: 8, .. })));
    let found = study(&good).run(&Levels { costs: &[1.0], n_responses: 1, run });
    assert!(matches!(found, Err(Error::TooFew { quantity: "levels", .. })));
    let found = Multilevel { budget: 1e3, ..exact_study(&good) }.run(&two);
    assert!(matches!(found, Err(Error::OverBudget { limit: 1e3, .. })), "{found:?}");
    let found = Multilevel { budget: f64::NAN, ..exact_study(&good) }.run(&two);
    assert!(matches!(found, Err(Error::NotPositive { quantity: "budget", .. })));
}

#[test]
fn bad_samples_ladders_and_blocks_are_refused() {
    let good =
        [Target { response: 0, statistic: Statistic::Mean, tolerance: Tolerance::Absolute(0.01) }];
    let run = |_: usize, realisation: u64, y: &mut [f64]| -> Result<(), Failure> {
        y[0] = uniform(realisation);
        Ok(())
    };
    let two = Levels { costs: &[1.0, 2.0], n_responses: 1, run };
    let nan = Levels {
        costs: &[1.0, 2.0],
        n_responses: 1,
        run: |level: usize, _: u64, y: &mut [f64]| -> Result<(), Failure> {
            y[0] = if level == 1 { f64::NAN } else { 0.0 };
            Ok(())
        },
    };
    assert!(matches!(
        exact_study(&good).run(&nan),
        Err(Error::NonFiniteSample { response: 0, .. })
    ));
    let failing = Levels {
        costs: &[1.0, 2.0],
        n_responses: 1,
        run: |_: usize, _: u64, _: &mut [f64]| -> Result<(), Failure> { Err("no mesh".into()) },
    };
    let message = exact_study(&good).run(&failing).unwrap_err().to_string();
    assert!(message.contains("no mesh"), "{message}");

    let found = exact_study(&good).run(&Apart);
    assert!(matches!(found, Err(Error::NotNested { level: 0, .. })), "{found:?}");

    let foreign = Multilevel { name: "other", ..exact_study(&good) };
    let mut progress = exact_study(&good).begin(&two).unwrap();
    assert!(matches!(foreign.advance(&two, &mut progress), Err(Error::ForeignBlock { .. })));
    assert!(exact_study(&good).advance(&two, &mut progress).unwrap());
    let id = progress.missing()[0];
    let block = foreign.block(&two, &progress, id).unwrap();
    assert!(matches!(progress.insert(block), Err(Error::ForeignBlock { field: "name", .. })));
    let early = exact_study(&good).finish(&two, &progress);
    assert!(matches!(early, Err(Error::MissingBlocks { missing: 4, .. })), "{early:?}");
}

#[test]
fn a_fitted_order_is_that_of_the_method() {
    let targets = [Target {
        response: 0,
        statistic: Statistic::Variance,
        tolerance: Tolerance::Absolute(1e-3),
    }];
    let study = Multilevel { bias: Bias::FittedOrder, ..study(&targets) };
    let found = study.run(&growth(2)).unwrap();
    let order = found.targets[0].order.unwrap();
    let error = order.standard_error().unwrap();
    assert!((order.value - 1.0).abs() < 4.0 * error + 0.1 && error < 0.3, "{order:?}");
    let error = found.targets[0].estimate.value - exact()[1];
    assert!(error.abs() < 3e-3, "{found:?}");
}
