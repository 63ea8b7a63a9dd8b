//! Coefficients of the stabilised Runge-Kutta-Chebyshev method of order 2.

/// Most stages of a step: an interval of 261 on the negative real axis.
pub(crate) const MOST_STAGES: usize = 20;
/// Fewest stages of a method of order 2.
const FEWEST_STAGES: usize = 2;
/// Damping of the stability polynomial, which keeps below `1 - 1/3` of it inside the interval.
const DAMPING: f64 = 2.0 / 13.0;

/// Coefficients of a step with `s` stages (Sommeijer, Shampine & Verwer 1998, eq 2.2-2.4).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chebyshev {
    pub(crate) stages: usize,
    w_0: f64,
    w_1: f64,
}

/// Factors of one stage, `Y_j` from `Y_0`, the two stages before it, and the rates of `Y_0` and of the stage before it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StageFactors {
    /// Of `Y_(j-1)`.
    pub(crate) mu: f64,
    /// Of `Y_(j-2)`.
    pub(crate) nu: f64,
    /// Of `dt F_(j-1)`.
    pub(crate) rate: f64,
    /// Of `dt F_0`.
    pub(crate) first_rate: f64,
    /// Time of `Y_(j-1)` since the start of the step, in steps.
    pub(crate) before: f64,
}

/// Values and first two derivatives of a Chebyshev polynomial.
#[derive(Debug, Clone, Copy)]
struct Polynomial([f64; 3]);

impl Polynomial {
    /// `T_j` at `x`, by the recurrence.
    fn at(j: usize, x: f64) -> Self {
        let (mut before, mut now) = ([1.0, 0.0, 0.0], [x, 1.0, 0.0]);
        if j == 0 {
            return Self(before);
        }
        for _ in 1..j {
            let next = [
                2.0 * x * now[0] - before[0],
                2.0 * (now[0] + x * now[1]) - before[1],
                2.0 * (2.0 * now[1] + x * now[2]) - before[2],
            ];
            (before, now) = (now, next);
        }
        Self(now)
    }
}

impl Chebyshev {
    /// The method with so many stages, at least two.
    pub(crate) fn with(stages: usize) -> Self {
        let stages = stages.max(FEWEST_STAGES);
        let w_0 = 1.0 + DAMPING / (stages as f64).powi(2);
        let Polynomial([_, first, second]) = Polynomial::at(stages, w_0);
        Self { stages, w_0, w_1: first / second }
    }

    /// The fewest stages whose interval covers a share of that of [`MOST_STAGES`].
    pub(crate) fn covering(share: f64) -> Self {
        let needed = share * Self::with(MOST_STAGES).real_interval();
        let fits = |method: &Self| method.real_interval() >= needed;
        let all = (FEWEST_STAGES..MOST_STAGES).map(Self::with);
        all.into_iter().find(fits).unwrap_or_else(|| Self::with(MOST_STAGES))
    }

    /// The interval of stability on the negative real axis, `(1 + w_0) T''/T'`, about `0.65 s^2`.
    pub(crate) fn real_interval(&self) -> f64 {
        (1.0 + self.w_0) / self.w_1
    }

    /// Factor of `dt F_0` in the first stage, `Y_1 = Y_0 + factor dt F_0`, which is also its time in steps.
    pub(crate) fn first(&self) -> f64 {
        self.b(1) * self.w_1
    }

    /// Factors of stage `j`, from 2 on.
    pub(crate) fn stage(&self, j: usize) -> StageFactors {
        let (b, rate_of) = (self.b(j), 2.0 * self.b(j) / self.b(j - 1));
        let Polynomial([value, ..]) = Polynomial::at(j - 1, self.w_0);
        let rate = rate_of * self.w_1;
        StageFactors {
            mu: rate_of * self.w_0,
            nu: -b / self.b(j - 2),
            rate,
            first_rate: -(1.0 - self.b(j - 1) * value) * rate,
            before: self.time(j - 1),
        }
    }

    fn b(&self, j: usize) -> f64 {
        let Polynomial([_, first, second]) = Polynomial::at(j.max(2), self.w_0);
        second / (first * first)
    }

    /// `c_j`, the time of stage `j` in steps.
    fn time(&self, j: usize) -> f64 {
        if j < 2 {
            return if j == 0 { 0.0 } else { self.first() };
        }
        let Polynomial([_, first, second]) = Polynomial::at(j, self.w_0);
        self.w_1 * second / first
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a step makes of `x' = z x`, `x(0) = 1`, with `dt = 1`.
    fn growth(method: &Chebyshev, z: f64) -> f64 {
        let (mut before, mut now) = (1.0, 1.0 + method.first() * z);
        for j in 2..=method.stages {
            let StageFactors { mu, nu, rate, first_rate, .. } = method.stage(j);
            let next = (1.0 - mu - nu) + mu * now + nu * before + rate * z * now + first_rate * z;
            (before, now) = (now, next);
        }
        now
    }

    #[test]
    fn the_polynomial_is_of_order_two_and_stays_below_one_up_to_the_end_of_its_interval() {
        for stages in [2, 3, 5, 10, MOST_STAGES] {
            let method = Chebyshev::with(stages);
            // exp(z) to second order: the third derivative is below that of the exponential.
            let z = -1e-3;
            assert!((growth(&method, z) - (1.0 + z + 0.5 * z * z)).abs() < 1e-9, "{stages}");
            let end = method.real_interval();
            for part in 1..=1000 {
                let z = -end * f64::from(part) / 1000.0;
                assert!(growth(&method, z).abs() <= 1.0 + 1e-12, "{stages} {z}");
            }
            // With an odd number of stages the polynomial is 0.4 at the end, and passes -1 further on.
            assert!(growth(&method, -1.3 * end).abs() > 1.0, "{stages}");
        }
    }

    #[test]
    fn more_stages_come_with_a_longer_step() {
        let most = Chebyshev::with(MOST_STAGES).real_interval();
        assert!((most / 400.0 - 0.653).abs() < 0.002, "{most}");
        for (interval, stages) in [(0.1, 2), (5.0, 3), (60.0, 10), (most, MOST_STAGES)] {
            let method = Chebyshev::covering(interval / most);
            assert_eq!(method.stages, stages);
            assert!(method.real_interval() >= interval * (1.0 - 1e-12));
        }
    }

    #[test]
    fn the_times_of_the_stages_rise_to_the_end_of_the_step() {
        let method = Chebyshev::with(7);
        let times: Vec<f64> = (0..=7).map(|j| method.time(j)).collect();
        assert!(times[0] == 0.0 && times.windows(2).all(|pair| pair[0] < pair[1]));
        assert!((times[7] - 1.0).abs() < 1e-12);
    }
}
