//! Expectations over the increments of one step, without sampling.

use sde_integrators::Increment;

/// Nodes and weights of Gauss and Hermite's rule for a standard normal: exact for polynomials of degree `2 n - 1`.
///
/// The nodes are the roots of the Hermite polynomial, by Newton's method from the guesses of Press et al. 2007,
/// Numerical recipes, section 4.6.1.
#[must_use]
pub fn gauss_hermite(n: usize) -> Vec<(f64, f64)> {
    let size = n as f64;
    let mut rule: Vec<(f64, f64)> = Vec::with_capacity(n);
    let mut z = 0.0;
    for i in 0..n.div_ceil(2) {
        z = match i {
            0 => (2.0 * size + 1.0).sqrt() - 1.85575 * (2.0 * size + 1.0).powf(-1.0 / 6.0),
            1 => z - 1.14 * size.powf(0.426) / z,
            2 => 1.86 * z - 0.86 * rule[0].0 / std::f64::consts::SQRT_2,
            3 => 1.91 * z - 0.91 * rule[2].0 / std::f64::consts::SQRT_2,
            _ => 2.0 * z - rule[2 * i - 4].0 / std::f64::consts::SQRT_2,
        };
        let mut slope = 0.0;
        for _ in 0..50 {
            let (mut now, mut before) = (std::f64::consts::PI.powf(-0.25), 0.0);
            for j in 0..n {
                let j = j as f64;
                let next = z * (2.0 / (j + 1.0)).sqrt() * now - (j / (j + 1.0)).sqrt() * before;
                (before, now) = (now, next);
            }
            slope = (2.0 * size).sqrt() * before;
            let step = now / slope;
            z -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        let weight = 2.0 / (slope * slope) / std::f64::consts::PI.sqrt();
        rule.push((std::f64::consts::SQRT_2 * z, weight));
        rule.push((-std::f64::consts::SQRT_2 * z, weight));
    }
    rule.truncate(n);
    rule
}

/// The expectation of a function of the increment over a step of length `dt`, by the product rule in `w` and `H`.
pub fn expectation<E>(
    dt: f64,
    rule: &[(f64, f64)],
    mut value: impl FnMut(&Increment<1>) -> Result<f64, E>,
) -> Result<f64, E> {
    let mut sum = 0.0;
    for &(z, p) in rule {
        for &(y, r) in rule {
            let dw =
                Increment { brownian: [dt.sqrt() * z], space_time_area: [(dt / 12.0).sqrt() * y] };
            sum += p * r * value(&dw)?;
        }
    }
    Ok(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The even moments of a standard normal are 1, 1, 3, 15, 105, ..; tolerance: roundoff.
    #[test]
    fn the_rule_has_the_moments_of_a_normal() {
        for n in [1, 2, 5, 8, 12, 20] {
            let rule = gauss_hermite(n);
            assert_eq!(rule.len(), n);
            let mut expected = 1.0;
            for k in 0..n.min(8) {
                let degree = 2 * i32::try_from(k).unwrap();
                let moment: f64 = rule.iter().map(|(z, w)| w * z.powi(degree)).sum();
                assert!(
                    (moment / expected - 1.0).abs() < 1e-11,
                    "n {n}, degree {degree}: {moment}"
                );
                expected *= f64::from(degree + 1);
            }
        }
    }
}
