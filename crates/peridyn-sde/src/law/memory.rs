//! Bonds that wear out.

use super::BondLaw;
use crate::error::{Error, between, not_negative, positive};

/// A bond carries `sigma = alpha s`, and what is left of it wears out by its stretch,
///
/// $$ \dot\alpha = -\lambda  e^{k s} \alpha^n (1 - \alpha)^m, \qquad \alpha(0) = \alpha_0 \in (0, 1) $$
///
/// (section 2.1 of the note; its eq 5 has `alpha` twice, its `lambda` nowhere). It wears out in compression and at rest too.
///
/// The equation is separable: `alpha` is a function of one number for each bond, the exposure
///
/// $$ \Theta = \int \lambda e^{k s} dt, \qquad \Delta\Theta = \lambda \Delta t \frac{e^{k s_1} - e^{k s_0}}{k (s_1 - s_0)} , $$
///
/// which a step adds to exactly where the stretch runs on a straight line. In the coordinate `y = ln(alpha/(1 - alpha))` it is
/// `d Theta/dy = -alpha^(1-n) (1-alpha)^(1-m)`, integrated once by Gauss's rule and inverted by Newton's method; for
/// `n = m = 1` both are closed forms. With `n < 1` the bond is gone after a finite exposure, with `n >= 1` never.
#[derive(Debug, Clone, PartialEq)]
pub struct Memory {
    sensitivity: f64,
    rate: f64,
    n: f64,
    m: f64,
    start: f64,
    /// Exposures at which `y` has gone down by whole steps from its start; none where a closed form serves.
    table: Vec<f64>,
}

/// The step of the table, in `y`.
const STEP: f64 = 0.125;
/// Below this the smaller of `alpha` and `1 - alpha` counts for nothing beside one in double precision.
const LEAST: f64 = -40.0;

/// Gauss's rule with ten points on (-1, 1): abscissas and weights of the half above zero.
const GAUSS: [(f64, f64); 5] = [
    (0.148_874_338_981_631_22, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_35),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

impl Memory {
    /// `k >= 0` the sensitivity to stretch, `lambda > 0` a rate (over time), the exponents `n > 0` and `m > 0`, and
    /// `alpha(0)`, between zero and one: from one on nothing would ever happen, and zero is broken.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a number outside of these limits.
    pub fn new(sensitivity: f64, rate: f64, (n, m): (f64, f64), start: f64) -> Result<Self, Error> {
        not_negative("sensitivity k", sensitivity)?;
        positive("rate lambda", rate)?;
        positive("exponent n", n)?;
        positive("exponent m", m)?;
        between("alpha at the start", start, 0.0, 1.0)?;
        let mut law = Self { sensitivity, rate, n, m, start, table: vec![] };
        if (n - 1.0).abs() + (m - 1.0).abs() > 0.0 {
            let (mut y, mut exposure) = (law.logit(), 0.0);
            law.table.push(exposure);
            while y > LEAST {
                exposure += law.exposure_between(y - STEP, y);
                y -= STEP;
                law.table.push(exposure);
            }
        }
        Ok(law)
    }

    fn logit(&self) -> f64 {
        (self.start / (1.0 - self.start)).ln()
    }

    /// `-d Theta/dy`.
    fn slope(&self, y: f64) -> f64 {
        // ln alpha and ln(1 - alpha), without cancellation.
        let (left, lost) = (-(-y).exp().ln_1p(), -y.exp().ln_1p());
        ((1.0 - self.n) * left + (1.0 - self.m) * lost).exp()
    }

    fn exposure_between(&self, low: f64, high: f64) -> f64 {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let pair = |&(x, weight): &(f64, f64)| {
            weight * (self.slope(middle - half * x) + self.slope(middle + half * x))
        };
        half * GAUSS.iter().map(pair).sum::<f64>()
    }

    /// `alpha` after an exposure.
    #[must_use]
    pub fn left(&self, exposure: f64) -> f64 {
        let logistic = |y: f64| 1.0 / (1.0 + (-y).exp());
        if exposure == f64::INFINITY {
            return 0.0;
        }
        let Some((&last, _)) = self.table.split_last() else {
            return logistic(self.logit() - exposure);
        };
        let y_at = |index: usize| self.logit() - STEP * index as f64;
        if exposure >= last {
            // 1 - alpha is one: alpha^(1-n) changes by (n - 1) of the exposure.
            let (y, further) = (y_at(self.table.len() - 1), exposure - last);
            if (self.n - 1.0).abs() <= 0.0 {
                return (y - further).exp();
            }
            let power = ((1.0 - self.n) * y).exp() + (self.n - 1.0) * further;
            return if power > 0.0 { power.powf(1.0 / (1.0 - self.n)) } else { 0.0 };
        }
        let index = self.table.partition_point(|&passed| passed <= exposure) - 1;
        let (high, rest) = (y_at(index), exposure - self.table[index]);
        let width = self.table[index + 1] - self.table[index];
        let mut y = high - STEP * rest / width;
        // The integrand changes by a small part over a step of the table: Newton's method doubles its digits at once.
        for _ in 0..6 {
            let miss = self.exposure_between(y, high) - rest;
            let change = miss / self.slope(y);
            y += change;
            if change.abs() < 1e-15 {
                break;
            }
        }
        logistic(y)
    }
}

/// `(e^b - e^a)/(b - a)`.
fn mean_exponential(a: f64, b: f64) -> f64 {
    let difference = b - a;
    if difference == 0.0 { a.exp() } else { a.exp() * (difference.exp_m1() / difference) }
}

impl BondLaw for Memory {
    /// The exposure.
    type State = f64;

    fn advance(&self, _strength: f64, from: f64, to: f64, dt: f64, exposure: &mut f64) {
        let k = self.sensitivity;
        // From the larger end down, so that no infinite exponential meets a zero.
        let mean = mean_exponential(k * from.max(to), k * from.min(to));
        *exposure += self.rate * dt * mean;
    }

    fn tension(&self, _strength: f64, s: f64, exposure: &f64) -> f64 {
        self.left(*exposure) * s
    }

    fn energy(&self, _strength: f64, s: f64, exposure: &f64) -> f64 {
        0.5 * self.left(*exposure) * s * s
    }

    fn damage(&self, _strength: f64, exposure: &f64) -> f64 {
        1.0 - self.left(*exposure)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runge-Kutta of fourth order in `alpha` itself, many small steps: shares nothing with the law but its equation.
    fn integrated(law: &Memory, stretch: impl Fn(f64) -> f64, until: f64, steps: u32) -> f64 {
        let slope = |t: f64, a: f64| {
            let a = a.max(0.0);
            -law.rate * (law.sensitivity * stretch(t)).exp() * a.powf(law.n) * (1.0 - a).powf(law.m)
        };
        let (dt, mut a) = (until / f64::from(steps), law.start);
        for step in 0..steps {
            let t = dt * f64::from(step);
            let k1 = slope(t, a);
            let k2 = slope(t + 0.5 * dt, a + 0.5 * dt * k1);
            let k3 = slope(t + 0.5 * dt, a + 0.5 * dt * k2);
            let k4 = slope(t + dt, a + dt * k3);
            a += dt / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
        }
        a.max(0.0)
    }

    fn run(law: &Memory, stretch: impl Fn(f64) -> f64, until: f64, steps: u32) -> f64 {
        let (dt, mut state) = (until / f64::from(steps), 0.0);
        for step in 0..steps {
            let t = dt * f64::from(step);
            law.advance(1.0, stretch(t), stretch(t + dt), dt, &mut state);
        }
        1.0 - law.damage(1.0, &state)
    }

    const EXPONENTS: [(f64, f64); 5] = [(1.0, 1.0), (2.0, 2.0), (0.5, 1.0), (1.0, 2.0), (3.0, 0.5)];

    #[test]
    fn ramps_holds_and_unloading_are_exact_in_one_step_each() {
        // Up to 2e-3 in one unit of time, held for one, down in one.
        let stretch = |t: f64| 2e-3 * t.min(1.0) - 2e-3 * (t - 2.0).clamp(0.0, 1.0);
        for exponents in EXPONENTS {
            let law = Memory::new(800.0, 0.3, exponents, 0.9).unwrap();
            for (until, steps) in [(1.0, 1), (2.0, 2), (3.0, 3)] {
                // Fourth order leaves 1e-17, 90,000 steps of 1e-16 some 1e-14.
                let exact = integrated(&law, stretch, until, 30_000 * steps);
                let ours = run(&law, stretch, until, steps);
                assert!((ours - exact).abs() < 1e-13, "{exponents:?} to {until}: {ours} {exact}");
            }
        }
    }

    #[test]
    fn a_curved_stretch_is_of_second_order() {
        let stretch = |t: f64| 2e-3 * (1.3 * t).sin();
        for exponents in EXPONENTS {
            let law = Memory::new(800.0, 0.3, exponents, 0.9).unwrap();
            let exact = integrated(&law, stretch, 2.0, 40_000);
            let error = |steps| (run(&law, stretch, 2.0, steps) - exact).abs();
            let order = (error(40) / error(80)).log2();
            assert!((order - 2.0).abs() < 2e-3, "{exponents:?}: {order}");
        }
    }

    #[test]
    fn the_ramp_of_the_reference_is_met() {
        // d alpha/dt = -exp(2e4 s) alpha (1 - alpha), s = 1e-3 t, from 0.99.
        let law = Memory::new(2e4, 1.0, (1.0, 1.0), 0.99).unwrap();
        let reference = [
            (0.064_742_857_142_857_14, 0.988_599_094_784_562_1),
            (0.2266, 0.499_476_664_660_529_5),
        ];
        for (t, alpha) in reference {
            let ours = run(&law, |t| 1e-3 * t, t, 1);
            assert!((ours / alpha - 1.0).abs() < 1e-12, "{ours} {alpha}");
        }
    }

    #[test]
    fn a_bond_is_gone_after_a_finite_exposure_only_below_the_exponent_one() {
        let gone = |exponents| {
            let law = Memory::new(0.0, 1.0, exponents, 0.99).unwrap();
            [5.9, 6.1, 1e3].map(|exposure| law.left(exposure) > 0.0)
        };
        // 5.99 for n = 1/2, m = 1.
        assert_eq!(gone((0.5, 1.0)), [true, false, false]);
        assert_eq!(gone((2.0, 2.0)), [true; 3]);
        let law = Memory::new(0.0, 1.0, (2.0, 2.0), 0.99).unwrap();
        let mut last = law.left(0.0);
        assert!((last - 0.99).abs() < 1e-15);
        for step in 1..4000_i32 {
            let left = law.left(1e-3 * 1.02_f64.powi(step));
            assert!(left <= last && left > 0.0, "{step}: {left} {last}");
            last = left;
        }
        assert!(law.left(f64::INFINITY) <= 0.0);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert!(Memory::new(1.0, 1.0, (1.0, 1.0), 1.0).is_err());
        assert!(Memory::new(1.0, 1.0, (1.0, 1.0), 0.0).is_err());
        assert!(Memory::new(-1.0, 1.0, (1.0, 1.0), 0.5).is_err());
        assert!(Memory::new(1.0, 1.0, (0.0, 1.0), 0.5).is_err());
        assert!(Memory::new(1.0, f64::NAN, (1.0, 1.0), 0.5).is_err());
    }
}
