//! Draws: the cipher, their addresses, their moments.

use std::collections::HashSet;

use sde_integrators::{Increment, Noise, Purpose, SimdLevel, WORDS_PER_PAIR};

fn first_block(seed: u64, realisation: u64) -> String {
    let mut stream = Noise::new(seed).stream(Purpose::Path, realisation);
    (0..8).map(|_| format!("{:016x}", stream.next_u64().swap_bytes())).collect::<Vec<_>>().concat()
}

/// Strombergson 2013, draft-strombergson-chacha-test-vectors-01, 8 rounds, key of 256 bits, first block of the key
/// stream: TC1 (key and IV zero), TC2 (first bit of the key), TC3 (first bit of the IV). Seed 0 for paths is the zero
/// key, the realisation is the IV.
#[test]
fn the_words_are_those_of_the_published_chacha8_vectors() {
    assert_eq!(
        first_block(0, 0),
        "3e00ef2f895f40d67f5bb8e81f09a5a12c840ec3ce9a7f3b181be188ef711a1e\
         984ce172b9216f419f445367456d5619314a42a3da86b001387bfdb80e0cfe42"
    );
    assert_eq!(
        first_block(1, 0),
        "cf5ee9a0494aa9613e05d5ed725b804b12f4a465ee635acc3a311de8740489ea\
         289d04f43c7518db56eb4433e498a1238cd8464d3763ddbb9222ee3bd8fae3c8"
    );
    assert_eq!(
        first_block(0, 1),
        "2b8f4bb3798306ca5130d47c4f8d4ed13aa0edccc1be6942090faeeca0d7599b\
         7ff0fe616bb25aa0153ad6fdc88b954903c22426d478b97b22b8f9b1db00cf06"
    );
}

/// Equal words of 64 bits by chance: 7e4 draws squared over 2^65, 1e-10.
#[test]
fn seeds_purposes_realisations_and_steps_never_share_words() {
    let mut seen = HashSet::new();
    for seed in [0, 1, 2, u64::MAX] {
        for purpose in Purpose::ALL {
            for realisation in [0, 1, 2, 3, 1 << 32, u64::MAX] {
                let mut stream = Noise::new(seed).stream(purpose, realisation);
                for word in 0..333 {
                    assert!(
                        seen.insert(stream.next_u64()),
                        "{seed} {purpose:?} {realisation} {word}"
                    );
                }
            }
        }
    }
    assert_eq!(seen.len(), 4 * Purpose::ALL.len() * 6 * 333);
}

fn random_access_is_sequential<const M: usize>() {
    let noise = Noise::new(11);
    let (mut path, mut jumping, dt) = (noise.path::<M>(5), noise.path::<M>(5), 0.02);
    let sequence: Vec<Increment<M>> = (0..200).map(|_| path.next_increment(dt)).collect();
    for (step, increment) in sequence.iter().enumerate().rev() {
        assert_eq!(jumping.increment_at(step as u64, dt), *increment);
    }
    let _ = jumping.increment_at(99, dt);
    assert_eq!(jumping.next_increment(dt), sequence[100]);
    // Normal number 8 M is the first of pair 4 M.
    for (purpose, deviation, expected) in [
        (Purpose::Path, dt.sqrt(), sequence[8].brownian[0]),
        (Purpose::PathArea, (dt / 12.0).sqrt(), sequence[8].space_time_area[0]),
    ] {
        let mut stream = noise.stream(purpose, 5);
        stream.seek(4 * WORDS_PER_PAIR * M as u128);
        let drawn = deviation * stream.next_normal_pair()[0];
        assert_eq!(drawn.to_bits(), expected.to_bits());
    }
}

#[test]
fn random_access_gives_the_values_of_the_sequence() {
    random_access_is_sequential::<1>();
    random_access_is_sequential::<2>();
    random_access_is_sequential::<3>();
    let late = Noise::new(0).path::<1>(0).increment_at(u64::MAX, 1.0);
    assert!(late.brownian[0].is_finite());
}

/// Recorded once; they pin the layout of the words and the arithmetic of the normals, on every platform.
#[test]
fn golden_draws_keep_their_bits() {
    let increment = Noise::new(2013).path::<1>(77).increment_at(1000, 1.0);
    let [z_0, z_1] = Noise::new(0).stream(Purpose::Field, 3).next_normal_pair();
    let bits = [increment.brownian[0], increment.space_time_area[0], z_0, z_1].map(f64::to_bits);
    assert_eq!(bits, GOLDEN, "{bits:#x?}");
}

const GOLDEN: [u64; 4] =
    [0x3fb9_0104_5035_9f08, 0xbfb4_9a7f_b411_6855, 0x3fe6_7922_8590_a496, 0x3fc6_e8e1_f0da_694a];

/// |z| < 4 for each of the moments; the variances of the products are those of independent normals.
#[test]
fn increments_have_their_moments() {
    let (dt, n_paths, n_steps) = (0.25_f64, 2_000, 100);
    let names =
        ["w", "w^2", "w^3", "w^4", "H", "H^2", "w H", "w_1 w_2", "w of next step", "next path"];
    let variances = [1.0, 2.0, 15.0, 96.0, 1.0, 2.0, 1.0, 1.0, 1.0, 1.0];
    let mut sums = [0.0; 10];
    let noise = Noise::new(5);
    for realisation in 0..n_paths {
        let mut path = noise.path::<2>(realisation);
        let mut neighbour = noise.path::<2>(realisation + 1);
        let mut before = 0.0;
        for _ in 0..n_steps {
            let increment = path.next_increment(dt);
            let w = increment.brownian[0] / dt.sqrt();
            let other = increment.brownian[1] / dt.sqrt();
            let area = increment.space_time_area[0] / (dt / 12.0).sqrt();
            let next_path = neighbour.next_increment(dt).brownian[0] / dt.sqrt();
            let values = [
                w,
                w * w - 1.0,
                w.powi(3),
                w.powi(4) - 3.0,
                area,
                area * area - 1.0,
                w * area,
                w * other,
                w * before,
                w * next_path,
            ];
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += value;
            }
            before = w;
        }
    }
    let n = f64::from(n_steps) * n_paths as f64;
    for ((name, sum), variance) in names.iter().zip(sums).zip(variances) {
        let z = sum / (n * variance).sqrt();
        assert!(z.abs() < 4.0, "{name}: z = {z}");
    }
}

/// The share of normals below some quantiles; |z| < 4 of the binomial law. Phi: Abramowitz and Stegun, table 26.1.
#[test]
fn normals_have_their_distribution() {
    let quantiles = [
        (-3.0, 0.001349898),
        (-1.0, 0.158655254),
        (0.0, 0.5),
        (0.5, 0.691462461),
        (2.0, 0.977249868),
    ];
    let mut stream = Noise::new(9).stream(Purpose::Field, 0);
    let mut normals = vec![0.0; 400_001];
    stream.fill_normal(&mut normals);
    let n = normals.len() as f64;
    for (x, probability) in quantiles {
        let below = normals.iter().filter(|z| **z < x).count() as f64;
        let z = (below / n - probability) / (probability * (1.0 - probability) / n).sqrt();
        assert!(z.abs() < 4.0, "below {x}: z = {z}");
    }
}

/// `int W` over the whole is that over both halves, the second raised by the end of the first: within roundoff.
#[test]
fn increments_of_halves_join_to_that_of_the_whole() {
    let h = 0.5;
    let integral =
        |i: &Increment<2>, m: usize, h: f64| h * (0.5 * i.brownian[m] + i.space_time_area[m]);
    let mut path = Noise::new(3).path::<2>(0);
    for _ in 0..100 {
        let (first, second) = (path.next_increment(0.5 * h), path.next_increment(0.5 * h));
        let whole = Increment::from_halves(&first, &second);
        for m in 0..2 {
            let sum = integral(&first, m, 0.5 * h)
                + 0.5 * h * first.brownian[m]
                + integral(&second, m, 0.5 * h);
            assert!((integral(&whole, m, h) - sum).abs() < 1e-15);
            assert!((whole.brownian[m] - first.brownian[m] - second.brownian[m]).abs() < 1e-15);
        }
    }
}

/// Many at once or one pair after the other, from any word on, at every level of instructions: bitwise identical.
#[test]
fn a_field_of_normals_is_its_pairs() {
    for start in [0, 4, 12, 16, 36, 6] {
        for n in [1, 7, 63, 64, 65, 128, 129, 1_000, 1_001] {
            let mut pairs = Noise::new(8).stream(Purpose::Field, 3);
            pairs.seek(start);
            let expected: Vec<f64> =
                (0..n / 2 + n % 2).flat_map(|_| pairs.next_normal_pair()).collect();
            for level in SimdLevel::available() {
                let mut field = Noise::new(8).stream(Purpose::Field, 3).at_level(level);
                field.seek(start);
                let mut normals = vec![0.0; n];
                field.fill_normal(&mut normals);
                let bits = |values: &[f64]| values.iter().map(|z| z.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&normals), bits(&expected[..n]), "{start} {n} {level}");
                assert_eq!(field.next_u64(), pairs.clone().next_u64(), "{start} {n} {level}");
            }
        }
    }
}

/// Kolmogorov and Smirnov: `sqrt(n) sup |F_n - Phi|` exceeds 1.95 with a probability of 2 exp(-2 1.95^2) = 0.1 %.
/// Three samples of 1e5: the increments, the areas, and the sums of two increments over sqrt(2).
#[test]
fn increments_follow_the_normal_law() {
    let mut samples: [Vec<f64>; 3] = Default::default();
    for realisation in 0..100 {
        let mut path = Noise::new(31).path::<2>(realisation);
        for _ in 0..1_000 {
            let increment = path.next_increment(1.0);
            let [first, second] = increment.brownian;
            samples[0].push(first);
            samples[1].push(increment.space_time_area[1] * 12.0_f64.sqrt());
            samples[2].push((first + second) / 2.0_f64.sqrt());
        }
    }
    for (k, sample) in samples.iter_mut().enumerate() {
        let distance = kolmogorov_smirnov(sample);
        assert!(distance < 1.95, "sample {k}: {distance}");
        // The statistic can fail: a variance of 1.03 moves the law by 0.7 % at one deviation.
        let mut wrong: Vec<f64> = sample.iter().map(|z| 1.015 * z).collect();
        assert!(kolmogorov_smirnov(&mut wrong) > 0.9);
        let mut wrong: Vec<f64> = sample.iter().map(|z| z + 0.01).collect();
        assert!(kolmogorov_smirnov(&mut wrong) > distance.min(0.7));
    }
}

fn kolmogorov_smirnov(sample: &mut [f64]) -> f64 {
    sample.sort_unstable_by(f64::total_cmp);
    let n = sample.len() as f64;
    let largest = sample.iter().enumerate().fold(0.0_f64, |largest, (k, &z)| {
        let probability = normal_distribution(z);
        let (below, above) = (k as f64 / n, (k + 1) as f64 / n);
        largest.max((probability - below).abs()).max((above - probability).abs())
    });
    n.sqrt() * largest
}

/// `Phi(z)` by Marsaglia 2004, Evaluating the normal distribution: a series with positive terms, error about 1e-16.
fn normal_distribution(z: f64) -> f64 {
    let (mut term, mut sum, mut k) = (z, z, 1.0);
    while term.abs() > 1e-17 * sum.abs() && k < 400.0 {
        k += 2.0;
        term *= z * z / k;
        sum += term;
    }
    0.5 + sum * (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt()
}
