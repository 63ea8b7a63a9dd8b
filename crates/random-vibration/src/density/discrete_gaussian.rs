//! Convolution of cell masses with a Gaussian.

/// Convolves a row of masses with a discrete Gaussian of the given variance in cells.
///
/// Mass that would leave the row stays in its outermost cells.
pub(crate) fn spread_gaussian(row: &mut [f64], variance: f64, scratch: &mut [f64]) {
    if variance >= 1.0 {
        sampled_gaussian(row, variance, scratch);
    } else if variance > 0.0 {
        // The variance of a random walk is its number of steps times twice the probability of a step to one side.
        let walks = (variance / MOST_WALK_VARIANCE).ceil();
        let chance = 0.5 * variance / walks;
        let mut done = 0.0;
        while done < walks {
            let n = row.len();
            for k in 0..n {
                let (left, right) = (row[k.saturating_sub(1)], row[(k + 1).min(n - 1)]);
                scratch[k] = row[k] + chance * (left - 2.0 * row[k] + right);
            }
            row.copy_from_slice(scratch);
            done += 1.0;
        }
    }
}

/// Variance of one walk: at a third its fourth cumulant is that of a Gaussian, `3 s^4 = s^2`.
const MOST_WALK_VARIANCE: f64 = 1.0 / 3.0;

fn sampled_gaussian(row: &mut [f64], variance: f64, scratch: &mut [f64]) {
    let n = row.len();
    // Beyond 9 deviations the weights are below 1e-17.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few cells")]
    let reach = ((9.0 * variance.sqrt()).ceil() as usize).min(n - 1);
    let mut weights: Vec<f64> =
        (0..=reach).map(|k| (-0.5 * (k * k) as f64 / variance).exp()).collect();
    let sum: f64 = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    for weight in &mut weights {
        *weight /= sum;
    }
    scratch.fill(0.0);
    for (k, &weight) in weights.iter().enumerate() {
        if k == 0 {
            scratch.iter_mut().zip(row.iter()).for_each(|(to, from)| *to = weight * from);
            continue;
        }
        for (to, from) in scratch[k..].iter_mut().zip(row.iter()) {
            *to += weight * from;
        }
        for (to, from) in scratch.iter_mut().zip(&row[k..]) {
            *to += weight * from;
        }
        let lost_right: f64 = row[n - k..].iter().sum();
        let lost_left: f64 = row[..k].iter().sum();
        scratch[n - 1] += weight * lost_right;
        scratch[0] += weight * lost_left;
    }
    row.copy_from_slice(scratch);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_spreads_a_row_by_its_variance_and_keeps_its_mass() {
        for variance in [0.05, 0.4, 0.99, 1.0, 3.7] {
            let (mut row, mut scratch) = (vec![0.0; 41], vec![0.0; 41]);
            row[20] = 2.0;
            spread_gaussian(&mut row, variance, &mut scratch);
            let moment = |power: i32| -> f64 {
                row.iter().enumerate().map(|(k, m)| m * (k as f64 - 20.0).powi(power)).sum()
            };
            assert!((moment(0) - 2.0).abs() < 1e-14);
            // Aliasing of a Gaussian sampled at a spacing of one deviation: 4 pi^2 exp(-2 pi^2).
            assert!((moment(2) / (2.0 * variance) - 1.0).abs() < 4e-7, "{variance}: {}", moment(2));
            // No mass is lost at the end of the row either.
            let mut end = vec![1.0, 0.0, 0.0, 0.0];
            spread_gaussian(&mut end, variance, &mut [0.0; 4]);
            assert!((end.iter().sum::<f64>() - 1.0).abs() < 1e-14 && end.iter().all(|&m| m >= 0.0));
        }
    }
}
