//! Moments and probabilities of a normal distribution, and of a linear system over time.

use sde_integrators::normal_probability;

/// Mean and covariance.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Normal {
    pub(crate) mean: Vec<f64>,
    pub(crate) covariance: Vec<Vec<f64>>,
}

impl Normal {
    /// `E[x_1^a_1 .. x_n^a_n]` by Stein's identity, `E[x_i g] = m_i E[g] + sum_j P_ij E[dg/dx_j]`.
    pub(crate) fn raw_moment(&self, powers: &[u32]) -> f64 {
        let Some(i) = powers.iter().position(|&power| power > 0) else { return 1.0 };
        let mut rest = powers.to_vec();
        rest[i] -= 1;
        let of_mean = self.mean[i] * self.raw_moment(&rest);
        let slopes = (0..powers.len()).filter(|&j| rest[j] > 0).map(|j| {
            let mut slope = rest.clone();
            slope[j] -= 1;
            f64::from(rest[j]) * self.covariance[i][j] * self.raw_moment(&slope)
        });
        of_mean + slopes.sum::<f64>()
    }

    /// Mean and standard deviation of a weighted sum of the states.
    pub(crate) fn of_sum(&self, weights: &[f64]) -> (f64, f64) {
        let dot = |row: &[f64]| row.iter().zip(weights).map(|(x, w)| x * w).sum::<f64>();
        let variance: f64 = weights.iter().zip(&self.covariance).map(|(w, row)| w * dot(row)).sum();
        (dot(&self.mean), variance.sqrt())
    }

    /// `P(|w x| > T)`.
    pub(crate) fn exceedance(&self, weights: &[f64], threshold: f64) -> f64 {
        let (mean, deviation) = self.of_sum(weights);
        normal_probability((mean - threshold) / deviation)
            + normal_probability((-mean - threshold) / deviation)
    }
}

/// Rate of change of mean and covariance: drift at a state, and twice the diffusion.
pub(crate) trait Linear {
    /// `f(t, x)`, linear in `x`.
    fn drift(&self, t: f64, x: &[f64]) -> Vec<f64>;
    /// `2 D(t)`.
    fn noise(&self, t: f64) -> Vec<Vec<f64>>;
}

/// The distribution of a linear system at increasing times, by Runge-Kutta 4 with steps of at most `step` on
///
/// $$ \dot m = f(t, m), \qquad \dot P = A P + P A^T + 2 D(t) . $$
pub(crate) fn laws(system: &dyn Linear, start: &Normal, times: &[f64], step: f64) -> Vec<Normal> {
    let (mut now, mut t, mut laws) = (start.clone(), 0.0, Vec::new());
    for &end in times {
        let n = ((end - t) / step).ceil().max(1.0);
        let h = (end - t) / n;
        let mut done = 0.0;
        while done < n {
            let at = t + done * h;
            let k_1 = rate(system, at, &now);
            let k_2 = rate(system, at + 0.5 * h, &moved(&now, 0.5 * h, &k_1));
            let k_3 = rate(system, at + 0.5 * h, &moved(&now, 0.5 * h, &k_2));
            let k_4 = rate(system, at + h, &moved(&now, h, &k_3));
            for (part, k) in [(1.0, k_1), (2.0, k_2), (2.0, k_3), (1.0, k_4)] {
                now = moved(&now, h * part / 6.0, &k);
            }
            done += 1.0;
        }
        t = end;
        laws.push(now.clone());
    }
    laws
}

fn rate(system: &dyn Linear, t: f64, law: &Normal) -> Normal {
    let n = law.mean.len();
    let origin = system.drift(t, &vec![0.0; n]);
    let column = |k: usize| {
        let mut unit = vec![0.0; n];
        unit[k] = 1.0;
        let at = system.drift(t, &unit);
        at.iter().zip(&origin).map(|(a, b)| a - b).collect::<Vec<f64>>()
    };
    let columns: Vec<Vec<f64>> = (0..n).map(column).collect();
    let product =
        |i: usize, j: usize| -> f64 { (0..n).map(|k| columns[k][i] * law.covariance[k][j]).sum() };
    let mut covariance = system.noise(t);
    for (i, row) in covariance.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry += product(i, j) + product(j, i);
        }
    }
    Normal { mean: system.drift(t, &law.mean), covariance }
}

fn moved(law: &Normal, by: f64, rate: &Normal) -> Normal {
    let add = |(x, k): (&f64, &f64)| x + by * k;
    let row = |(row, rates): (&Vec<f64>, &Vec<f64>)| row.iter().zip(rates).map(add).collect();
    Normal {
        mean: law.mean.iter().zip(&rate.mean).map(add).collect(),
        covariance: law.covariance.iter().zip(&rate.covariance).map(row).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_a_normal_distribution_are_those_of_isserlis() {
        let law = Normal { mean: vec![0.0; 2], covariance: vec![vec![2.0, 0.5], vec![0.5, 1.0]] };
        assert!((law.raw_moment(&[4, 0]) - 12.0).abs() < 1e-13);
        assert!((law.raw_moment(&[2, 2]) - (2.0 + 2.0 * 0.25)).abs() < 1e-13);
        let shifted = Normal { mean: vec![1.0, 0.0], ..law };
        assert!((shifted.raw_moment(&[3, 0]) - 7.0).abs() < 1e-13);
    }

    #[test]
    fn relaxation_has_its_closed_form() {
        struct Decay;
        impl Linear for Decay {
            fn drift(&self, _: f64, x: &[f64]) -> Vec<f64> {
                vec![-2.0 * (x[0] - 1.0)]
            }
            fn noise(&self, _: f64) -> Vec<Vec<f64>> {
                vec![vec![3.0]]
            }
        }
        let start = Normal { mean: vec![0.0], covariance: vec![vec![0.1]] };
        let end = &laws(&Decay, &start, &[0.5, 1.0], 1e-3)[1];
        let left = (-2.0_f64).exp();
        assert!((end.mean[0] - (1.0 - left)).abs() < 1e-11);
        let variance = 0.1 * left * left + 0.75 * (1.0 - left * left);
        assert!((end.covariance[0][0] - variance).abs() < 1e-11);
    }
}
