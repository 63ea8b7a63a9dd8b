//! Numbers with their errors.

use sde_integrators::{Accumulator, Error, Estimate, Noise, Purpose, Uncertainty, reduce_blocks};

fn sample(n: usize) -> Vec<f64> {
    let mut values = vec![0.0; n];
    Noise::new(1).stream(Purpose::Field, 0).fill_normal(&mut values);
    values
}

/// A mean of 1e8 with a spread of 1: the sum of squares would lose all digits. Tolerance: `eps` times the mean, relative
/// to the spread.
#[test]
fn mean_and_variance_survive_a_large_offset_however_the_sample_is_cut() {
    let values = sample(1000);
    let direct_mean = values.iter().sum::<f64>() / 1000.0;
    let direct = values.iter().map(|x| (x - direct_mean).powi(2)).sum::<f64>() / 999.0;
    for cut in [0, 1, 7, 500, 999, 1000] {
        let (mut head, mut tail) = (Accumulator::default(), Accumulator::default());
        values[..cut].iter().for_each(|x| head.push(1e8 + x));
        values[cut..].iter().for_each(|x| tail.push(1e8 + x));
        head.merge(&tail);
        assert_eq!(head.count(), 1000);
        assert!((head.mean() - 1e8 - direct_mean).abs() < 1e-6);
        assert!((head.variance().unwrap() / direct - 1.0).abs() < 1e-7, "cut {cut}");
        let standard_error = head.estimate().unwrap().standard_error().unwrap();
        assert!((standard_error - (direct / 1000.0).sqrt()).abs() < 1e-8);
    }
}

#[test]
fn a_probability_has_the_error_of_wilsons_interval_or_the_rule_of_three() {
    let error =
        |hits, trials| Estimate::probability(hits, trials).unwrap().standard_error().unwrap();
    // Half the distance from 0.25 to the upper end, 0.5379, of Wilson's interval.
    assert!((error(3, 12) - 0.14393).abs() < 1e-4);
    assert_eq!(error(3, 12).to_bits(), error(9, 12).to_bits());
    // Of many hits that of the binomial distribution; of one in many trials 1 + sqrt(2) hits.
    assert!((error(300_000, 1_000_000) / (0.21_f64 / 1e6).sqrt() - 1.0).abs() < 1e-3);
    assert!((error(1, 1_000_000) * 1e6 / 2.414 - 1.0).abs() < 1e-3);
    assert_eq!(Estimate::share(0.25, 12.0), Estimate::probability(3, 12));
    for (value, trials) in [(-0.1, 12.0), (1.1, 12.0), (f64::NAN, 12.0), (0.5, 0.0)] {
        assert!(matches!(Estimate::share(value, trials), Err(Error::NotPositive { .. })));
    }
    let none = Estimate::probability(0, 300).unwrap();
    assert_eq!(none, Estimate { value: 0.0, uncertainty: Uncertainty::Bound(0.01) });
    let all = Estimate::probability(300, 300).unwrap();
    assert_eq!(all, Estimate { value: 1.0, uncertainty: Uncertainty::Bound(0.01) });
    // A true probability at the bound stays unseen in at most 5 % of the studies.
    assert!((1.0_f64 - 0.01).powi(300) < 0.05);
    assert_eq!(none.to_string(), "0 +- 1.00e-2 (bound)");
    assert_eq!(none.standard_error(), None);
}

#[test]
fn two_errors_contain_a_probability_in_nineteen_of_twenty_studies_of_it() {
    let n = 200;
    for expected in [0.3_f64, 1.0, 2.0, 4.0, 8.0, 30.0, 100.0, 170.0, 190.0] {
        let p = expected / f64::from(n);
        // Of 0 hits; each further count by the ratio of the binomial probabilities.
        let (mut of_count, mut inside) = ((1.0 - p).powi(n), 0.0);
        for hits in 0..=n {
            let found = Estimate::probability(hits.unsigned_abs().into(), 200).unwrap();
            let reach = match found.uncertainty {
                Uncertainty::StandardError(error) => 2.0 * error,
                Uncertainty::Bound(bound) => bound,
                Uncertainty::Unknown => 0.0,
            };
            inside += if (found.value - p).abs() <= reach { of_count } else { 0.0 };
            of_count *= f64::from(n - hits) / f64::from(hits + 1) * p / (1.0 - p);
        }
        assert!(inside > 0.95, "{expected}: {inside}");
    }
}

#[test]
fn an_estimate_without_a_sample_is_refused() {
    let too_few = Err(Error::TooFew { quantity: "values", value: 1, limit: 2 });
    let mut one = Accumulator::default();
    one.push(2.0);
    assert_eq!(one.estimate(), too_few);
    assert!(Estimate::probability(0, 0).is_err() && Estimate::probability(2, 1).is_err());
}

/// Joining ranges as text shows the shape of the tree.
#[test]
fn blocks_are_joined_in_a_tree_that_depends_on_their_number_alone() {
    let tree = |n: u64| {
        let leaf = |ids: std::ops::Range<u64>| Ok::<_, Error>(format!("{}-{}", ids.start, ids.end));
        reduce_blocks(n, leaf, |a, b| format!("({a} {b})")).unwrap()
    };
    assert_eq!(tree(0), None);
    assert_eq!(tree(5).unwrap(), "0-5");
    assert_eq!(tree(4097).unwrap(), "(0-4096 4096-4097)");
    assert_eq!(
        tree(5 * 4096).unwrap(),
        "(((0-4096 4096-8192) (8192-12288 12288-16384)) 16384-20480)"
    );
}

#[test]
fn the_error_of_the_lowest_block_wins() {
    for _ in 0..50 {
        let block =
            |ids: std::ops::Range<u64>| if ids.start >= 3 * 4096 { Err(ids.start) } else { Ok(()) };
        assert_eq!(reduce_blocks(40 * 4096, block, |(), ()| ()), Err(3 * 4096));
    }
}

/// Means of `exp(a z)` by 40 to 1,000 values: errors of a light tail are known. Of a heavy one those that are off by more than ten
/// errors are at most a third of what they are without caution.
#[test]
fn a_mean_that_one_value_decides_seldom_has_a_false_error() {
    for (a, is_light) in [(0.5, true), (2.0, false), (4.0, false)] {
        let exact = (0.5_f64 * a * a).exp();
        let (mut known, mut all, mut is_false) = (0, 0, [0; 2]);
        for n in [40, 200, 1_000] {
            for seed in 0..100 {
                let mut normals = vec![0.0; n];
                Noise::new(seed).stream(Purpose::MarkovChain, 0).fill_normal(&mut normals);
                let mut values = Accumulator::default();
                for z in normals {
                    values.push((a * z).exp());
                }
                let both = [values.estimate().unwrap(), values.cautious_estimate().unwrap()];
                all += 1;
                known += i32::from(both[1].standard_error().is_some());
                for (is_false, found) in is_false.iter_mut().zip(both) {
                    let off =
                        found.standard_error().map(|error| (found.value - exact).abs() / error);
                    *is_false += i32::from(off.is_some_and(|off| off > 10.0));
                }
            }
        }
        assert_eq!(10 * known > 9 * all, is_light, "{a}: {known} of {all}");
        assert!(3 * is_false[1] <= is_false[0], "{a}: {is_false:?}");
    }
}
