//! The square-root process of Cox, Ingersoll and Ross.

use sde_integrators::{General, Sde};

use crate::error::{Error, positive};

/// Parameters of a [`CoxIngersollRoss`] process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoxIngersollRossParameters {
    /// `kappa > 0`, rate of return (1 per unit of time).
    pub rate: f64,
    /// `theta > 0`, the mean it returns to.
    pub mean: f64,
    /// `sigma > 0`, noise per square root of the state.
    pub volatility: f64,
}

/// The Cox-Ingersoll-Ross process,
///
/// $$ dX = \kappa (\theta - X) dt + \sigma \sqrt{X} dB . $$
///
/// One state, positive where `2 kappa theta >= sigma^2` (Feller 1951), which is asked for. `D = sigma^2 x/2` depends on
/// it, `div D = sigma^2/2`. The law of `X(t)` is a multiple of a noncentral chi-squared.
///
/// Below zero, where only a numerical method brings it, the noise is zero and the drift that of `x = 0`: full truncation
/// (Lord, Koekkoek and van Dijk 2010).
///
/// Source: Cox, Ingersoll and Ross 1985, A theory of the term structure of interest rates, eq 17-18.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoxIngersollRoss {
    parameters: CoxIngersollRossParameters,
}

impl CoxIngersollRoss {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotPositive`]; [`Error::OutOfOrder`] where the process reaches zero.
    pub fn new(parameters: CoxIngersollRossParameters) -> Result<Self, Error> {
        let CoxIngersollRossParameters { rate, mean, volatility } = parameters;
        positive("rate", rate)?;
        positive("mean", mean)?;
        positive("volatility", volatility)?;
        let (value, limit) = (2.0 * rate * mean, volatility * volatility);
        if value < limit {
            let (name, other) = ("2 rate mean", "volatility^2");
            return Err(Error::OutOfOrder { name, value, other, limit });
        }
        Ok(Self { parameters })
    }

    /// The parameters.
    pub fn parameters(&self) -> &CoxIngersollRossParameters {
        &self.parameters
    }

    /// The density of `X(t)` at `x`, from `X(0) = start > 0`; zero for `x <= 0`. With
    /// `c = 2 kappa / (sigma^2 (1 - e^(-kappa t)))`, `2 c X(t)` is noncentral chi-squared with `4 kappa theta/sigma^2`
    /// degrees of freedom and noncentrality `2 c e^(-kappa t) start`: a Poisson mixture of gamma densities, summed outward
    /// from its largest term.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for `t` or `start`.
    pub fn transition_density(&self, start: f64, t: f64, x: f64) -> Result<f64, Error> {
        positive("start", start)?;
        positive("time", t)?;
        if x <= 0.0 {
            return Ok(0.0);
        }
        let CoxIngersollRossParameters { rate, mean, volatility } = self.parameters;
        let variance = volatility * volatility;
        let scale = 2.0 * rate / (variance * -(-rate * t).exp_m1());
        let shape = 2.0 * rate * mean / variance;
        // Poisson mean `u`; the gamma densities have unit scale at `y` and shapes `shape + j`.
        let (u, y) = (scale * start * (-rate * t).exp(), scale * x);
        // Terms u^j y^(shape + j - 1) / (j! Gamma(shape + j)): the ratio of neighbours is u y / (j (shape + j - 1)).
        let half = 0.5 * (shape - 1.0);
        let largest = ((half * half + u * y).sqrt() - half).floor().max(0.0);
        let log_term = largest * u.ln() + (shape + largest - 1.0) * y.ln()
            - ln_gamma(largest + 1.0)
            - ln_gamma(shape + largest);
        let ratio = |j: f64| u * y / (j * (shape + j - 1.0));
        let (mut sum, mut term, mut j) = (1.0, 1.0, largest);
        while term > NEGLIGIBLE {
            j += 1.0;
            term *= ratio(j);
            sum += term;
        }
        (term, j) = (1.0, largest);
        while term > NEGLIGIBLE && j > 0.0 {
            term /= ratio(j);
            j -= 1.0;
            sum += term;
        }
        Ok(scale * sum * (log_term - u - y).exp())
    }
}

/// A term below this part of the largest changes no digit, all together hardly one.
const NEGLIGIBLE: f64 = 1e-18;

/// `ln Gamma(x)` for `x > 0`, error below 1e-14 of one or of the value: Stirling's series beyond 10, below it by
/// `Gamma(x) = Gamma(x + 1)/x`.
fn ln_gamma(x: f64) -> f64 {
    let (mut y, mut product) = (x, 1.0);
    while y < 10.0 {
        product *= y;
        y += 1.0;
    }
    let z = 1.0 / (y * y);
    let series = (1.0 / 12.0
        - z * (1.0 / 360.0 - z * (1.0 / 1260.0 - z * (1.0 / 1680.0 - z * (1.0 / 1188.0)))))
        / y;
    (y - 0.5) * y.ln() - y + 0.5 * std::f64::consts::TAU.ln() + series - product.ln()
}

impl Sde<1, 1> for CoxIngersollRoss {
    type Noise = General;

    #[inline]
    fn drift(&self, _: f64, &[x]: &[f64; 1]) -> [f64; 1] {
        let CoxIngersollRossParameters { rate, mean, .. } = self.parameters;
        [rate * (mean - x.max(0.0))]
    }

    #[inline]
    fn noise(&self, _: f64, &[x]: &[f64; 1]) -> [[f64; 1]; 1] {
        [[self.parameters.volatility * x.max(0.0).sqrt()]]
    }

    #[inline]
    fn diffusion_divergence(&self, _: f64, &[x]: &[f64; 1]) -> [f64; 1] {
        let volatility = self.parameters.volatility;
        [if x > 0.0 { 0.5 * volatility * volatility } else { 0.0 }]
    }

    #[inline]
    fn linear_part(&self) -> Option<[[f64; 1]; 1]> {
        Some([[-self.parameters.rate]])
    }
}

#[cfg(test)]
mod tests {
    use sde_integrators::check_diffusion_divergence;

    use super::*;
    use crate::stationary::half_line;

    fn process() -> CoxIngersollRoss {
        let parameters = CoxIngersollRossParameters { rate: 0.8, mean: 1.2, volatility: 0.5 };
        CoxIngersollRoss::new(parameters).unwrap()
    }

    #[test]
    fn the_closed_divergence_is_that_of_the_noise() {
        assert!(check_diffusion_divergence(&process(), 0.0, &[[0.3], [2.0]]) < 1e-9);
    }

    #[test]
    fn the_transition_density_has_the_moments_of_the_equation() {
        let (kappa, theta, sigma, start) = (0.8_f64, 1.2, 0.5_f64, 0.4);
        for t in [0.01, 0.5, 6.0] {
            let moment = |a: i32| {
                half_line(0.0, 0.5, |x| {
                    x.powi(a) * process().transition_density(start, t, x).unwrap()
                })
            };
            // Mean and variance of Cox, Ingersoll and Ross 1985, eq 19.
            let decay = (-kappa * t).exp();
            let mean = start * decay + theta * (1.0 - decay);
            let variance = sigma * sigma / kappa
                * (start * (decay - decay * decay) + 0.5 * theta * (1.0 - decay) * (1.0 - decay));
            for (a, expected) in [(0, 1.0), (1, mean), (2, variance + mean * mean)] {
                // The rule resolves a narrow peak at t = 0.01 to 1e-6.
                let error = (moment(a) / expected - 1.0).abs();
                assert!(error < 1e-6, "moment {a} at {t}: {error:e}");
            }
        }
    }

    #[test]
    fn the_logarithm_of_gamma_is_that_of_factorials_and_of_one_half() {
        for (x, gamma) in
            [(1.0, 1.0), (5.0, 24.0), (0.5, std::f64::consts::PI.sqrt()), (12.0, 39916800.0)]
        {
            assert!((ln_gamma(x) - f64::ln(gamma)).abs() < 1e-13, "{x}");
        }
    }

    #[test]
    fn a_process_that_reaches_zero_is_refused() {
        let parameters = CoxIngersollRossParameters { rate: 0.5, mean: 0.5, volatility: 1.0 };
        let message = CoxIngersollRoss::new(parameters).unwrap_err().to_string();
        assert_eq!(message, "2 rate mean is 0.5; it must be greater than volatility^2, which is 1");
    }
}
