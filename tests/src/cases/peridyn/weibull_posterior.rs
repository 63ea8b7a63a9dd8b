//! Weibull's two parameters from strengths, with their uncertainty, and what they predict of bodies of another volume.

use sde_integrators::{Noise, Purpose};

/// Points along each parameter.
const POINTS: usize = 81;

/// The posterior on a grid of the logarithms of both parameters, flat there.
///
/// $$ p(b, m | s) \propto \prod_i \frac{m}{b} \left( \frac{s_i}{b} \right)^{m-1} e^{-(s_i/b)^m} $$
pub(super) struct WeibullPosterior {
    /// Scale, modulus and probability of each point.
    points: Vec<(f64, f64, f64)>,
}

/// Mean and standard deviation.
pub(super) type Moments = (f64, f64);

impl WeibullPosterior {
    /// From the strengths of some bodies. The grid is six standard errors wide to both sides, by those of large samples: `0.78/sqrt(n)`
    /// of the logarithm of the modulus and `1.05/(m sqrt(n))` of that of the scale (Lawless 2003, section 5.2).
    pub(super) fn new(strengths: &[f64]) -> Self {
        let n = strengths.len() as f64;
        let logarithms: Vec<f64> = strengths.iter().map(|s| s.ln()).collect();
        let mean = logarithms.iter().sum::<f64>() / n;
        let deviation =
            (logarithms.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        // The deviation of a logarithm is pi/(sqrt(6) m), its mean ln b - 0.5772/m.
        let modulus = std::f64::consts::PI / (6.0_f64.sqrt() * deviation);
        let scale = mean + 0.577_215_664_901_532_9 / modulus;
        let at = |k: usize| 2.0 * k as f64 / (POINTS - 1) as f64 - 1.0;
        let mut points = Vec::with_capacity(POINTS * POINTS);
        for i in 0..POINTS {
            let m = modulus * (6.0 * 0.78 / n.sqrt() * at(i)).exp();
            for j in 0..POINTS {
                let ln_b = scale + 6.0 * 1.05 / (modulus * n.sqrt()) * at(j);
                let of = |l: &f64| m.ln() + m * (l - ln_b) - (m * (l - ln_b)).exp();
                points.push((ln_b.exp(), m, logarithms.iter().map(of).sum::<f64>()));
            }
        }
        let most = points.iter().map(|p| p.2).fold(f64::NEG_INFINITY, f64::max);
        for point in &mut points {
            point.2 = (point.2 - most).exp();
        }
        let total: f64 = points.iter().map(|p| p.2).sum();
        for point in &mut points {
            point.2 /= total;
        }
        Self { points }
    }

    pub(super) fn modulus(&self) -> Moments {
        self.moments(|p| p.1)
    }

    pub(super) fn scale(&self) -> Moments {
        self.moments(|p| p.0)
    }

    fn moments(&self, of: impl Fn(&(f64, f64, f64)) -> f64) -> Moments {
        let mean: f64 = self.points.iter().map(|p| p.2 * of(p)).sum();
        let variance: f64 = self.points.iter().map(|p| p.2 * (of(p) - mean).powi(2)).sum();
        (mean, variance.sqrt())
    }

    /// The probability that a body of `ratio` times the volume is weaker: the average over the posterior.
    pub(super) fn below(&self, strength: f64, ratio: f64) -> f64 {
        let of = |&(b, m, p): &(f64, f64, f64)| -p * f64::exp_m1(-ratio * (strength / b).powf(m));
        self.points.iter().map(of).sum()
    }

    /// The strength that a share of such bodies is below, by bisection.
    pub(super) fn quantile(&self, share: f64, ratio: f64) -> f64 {
        let (mut low, mut high) = (0.0, 10.0 * self.scale().0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.below(middle, ratio) < share {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// Scale and modulus at a uniform number.
    pub(super) fn draw(&self, uniform: f64) -> (f64, f64) {
        let mut sum = 0.0;
        for &(b, m, p) in &self.points {
            sum += p;
            if sum > uniform {
                return (b, m);
            }
        }
        self.points.last().map_or((f64::NAN, f64::NAN), |p| (p.0, p.1))
    }

    /// Data sets of `n` bodies of `ratio` times the volume, each of parameters of its own: what repetitions of the test would give.
    pub(super) fn repetitions(
        &self,
        n_sets: u64,
        n: usize,
        ratio: f64,
        seed: u64,
    ) -> Vec<Vec<f64>> {
        let set = |number: u64| {
            let mut stream = Noise::new(seed).stream(Purpose::InitialDistribution, number);
            let (b, m) = self.draw(stream.next_uniform());
            let mut one = || b * (-(-stream.next_uniform()).ln_1p() / ratio).powf(m.recip());
            (0..n).map(|_| one()).collect()
        };
        (0..n_sets).map(set).collect()
    }
}
