//! Multifidelity Monte Carlo.

use sde_integrators::{Noise, Purpose};
use uq_estimators::{Error, Failure, Multifidelity, MultifidelityResult};

/// `exp(0.5 u)` and surrogates: a cubic and a linear polynomial, a function without relation, a constant.
fn model(seed: u64, model: usize, sample: u64) -> f64 {
    let u = Noise::new(seed).stream(Purpose::Field, sample).next_uniform();
    let v = 0.5 * u;
    match model {
        0 => v.exp(),
        1 => 1.0 + v + 0.5 * v * v,
        2 => 5.0 - 3.0 * u,
        3 => (700.0 * u).sin(),
        _ => 2.0,
    }
}

const COSTS: [f64; 5] = [1.0, 0.05, 1e-4, 0.01, 1e-4];

fn study(tolerance: f64) -> Multifidelity<'static> {
    Multifidelity {
        name: "laws",
        costs: &COSTS,
        tolerance,
        pilot: 60,
        block_length: 32,
        budget: 1e6,
    }
}

fn run(seed: u64, tolerance: f64) -> MultifidelityResult {
    study(tolerance).run(|m, sample| Ok(model(seed, m, sample))).unwrap()
}

#[test]
fn useful_surrogates_are_chosen_and_the_mean_is_unbiased() {
    let exact = 2.0 * (0.5_f64.exp() - 1.0);
    let (n_runs, tolerance) = (100, 2e-3);
    let (mut sum, mut squares, mut claimed) = (0.0, 0.0, 0.0);
    for seed in 0..n_runs {
        let found = run(seed, tolerance);
        let used: Vec<usize> = found.models.iter().map(|model| model.model).collect();
        assert_eq!(used[0], 0);
        assert!(used.contains(&2) && !used.contains(&3) && !used.contains(&4), "{found:?}");
        assert!(found.cost < 0.2 * found.single_model_cost, "{found:?}");
        let standard_error = found.mean.standard_error().unwrap();
        assert!(standard_error <= tolerance);
        let error = found.mean.value - exact;
        sum += error;
        squares += error * error;
        claimed += standard_error * standard_error;
    }
    let n = n_runs as f64;
    // Four standard errors; the variance of 100 runs is known to 14 %.
    assert!((sum / n).abs() < 4.0 * squares.sqrt() / n, "{sum} {squares}");
    assert!((squares / claimed - 1.0).abs() < 0.56, "{squares} {claimed}");
}

#[test]
fn without_a_useful_surrogate_it_is_plain_monte_carlo() {
    let study = Multifidelity { costs: &[1.0, 0.5], budget: 1e5, ..study(5e-3) };
    let found = study.run(|m, sample| Ok(model(1, 3 * m, sample))).unwrap();
    assert_eq!(found.models.len(), 1, "{found:?}");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let again = pool.install(|| study.run(|m, sample| Ok(model(1, 3 * m, sample))).unwrap());
    assert_eq!(found, again);
}

#[test]
fn blocks_apart_in_any_order_change_no_bit() {
    let study = study(2e-3);
    let whole = run(9, 2e-3);
    let one = |m, sample| Ok(model(9, m, sample));
    let mut progress = study.begin().unwrap();
    let mut rounds = 0;
    while study.advance(&mut progress).unwrap() {
        rounds += 1;
        let early = study.finish(&progress);
        assert!(matches!(early, Err(Error::MissingBlocks { .. })), "{early:?}");
        let mut blocks: Vec<_> =
            progress.missing().into_iter().map(|range| study.block(one, range).unwrap()).collect();
        blocks.reverse();
        let first = blocks[0].clone();
        for block in blocks {
            // As if the state had been written and read between.
            progress = progress.clone();
            progress.insert(block).unwrap();
        }
        let twice = progress.insert(first);
        assert!(matches!(twice, Err(Error::UnwantedBlock { .. })), "{twice:?}");
    }
    assert!(rounds >= 2);
    assert_eq!(study.finish(&progress).unwrap(), whole);
    let longer = Multifidelity { block_length: 500, ..study };
    assert_eq!(longer.run(one).unwrap(), whole);
    assert!(matches!(longer.finish(&progress), Err(Error::ForeignBlock { .. })));
    let other = Multifidelity { name: "other", ..study };
    let mut fresh = study.begin().unwrap();
    study.advance(&mut fresh).unwrap();
    let foreign = other.block(one, fresh.missing()[0]).unwrap();
    assert!(matches!(fresh.insert(foreign), Err(Error::ForeignBlock { field: "name", .. })));
}

#[test]
fn bad_input_is_refused() {
    let constant = study(1e-3).run(|_, _| Ok(1.0));
    assert!(matches!(constant, Err(Error::NoVariance { .. })), "{constant:?}");
    let failing = study(1e-3).run(|_, _| Err::<f64, Failure>("no mesh".into()));
    assert!(failing.unwrap_err().to_string().contains("no mesh"));
    let nan = study(1e-3).run(|_, _| Ok(f64::NAN));
    assert!(matches!(nan, Err(Error::NonFiniteSample { .. })), "{nan:?}");
    let good = |m, sample| Ok(model(1, m, sample));
    assert!(matches!(study(0.0).run(good), Err(Error::NotPositive { .. })));
    assert!(matches!(study(1e-9).run(good), Err(Error::OverBudget { limit: 1e6, .. })));
    let small = Multifidelity { pilot: 7, ..study(1e-3) };
    assert!(matches!(small.run(good), Err(Error::TooFew { value: 7, limit: 8, .. })));
    let none = Multifidelity { costs: &[], ..study(1e-3) };
    assert!(matches!(none.run(good), Err(Error::TooFew { quantity: "models", .. })));
}
