//! The linear system with additive noise, in any dimension.

use sde_integrators::{Additive, Sde};

use crate::error::{Error, finite, not_negative};
use crate::linear_law::Transition;
use crate::matrix::Matrix;

/// Parameters of an [`OrnsteinUhlenbeck`] process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrnsteinUhlenbeckParameters<const D: usize> {
    /// `Theta`, rates of return (1 per unit of time), row by row.
    pub rates: [[f64; D]; D],
    /// `m`, the mean it returns to.
    pub mean: [f64; D],
    /// `G`, row per state, column per Brownian motion (state per square root of time).
    pub noise: [[f64; D]; D],
}

/// The Ornstein-Uhlenbeck process in `D` dimensions,
///
/// $$ dX = -\Theta (X - m) dt + G dB . $$
///
/// `D = G G^T/2`. From a normal law it is normal at all times, with mean and covariance in closed form
/// ([`mean_at`](Self::mean_at), [`covariance_at`](Self::covariance_at)).
///
/// Source: Uhlenbeck and Ornstein 1930; in `D` dimensions Risken 1996, section 6.5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrnsteinUhlenbeck<const D: usize> {
    parameters: OrnsteinUhlenbeckParameters<D>,
}

impl<const D: usize> OrnsteinUhlenbeck<D> {
    /// Checks the parameters. The rates may be those of an unstable system.
    ///
    /// # Errors
    /// [`Error::NotFinite`], naming the parameter.
    pub fn new(parameters: OrnsteinUhlenbeckParameters<D>) -> Result<Self, Error> {
        let OrnsteinUhlenbeckParameters { rates, mean, noise } = &parameters;
        for (name, values) in
            [("rates", rates.as_flattened()), ("mean", mean), ("noise", noise.as_flattened())]
        {
            for &value in values {
                finite(name, value)?;
            }
        }
        Ok(Self { parameters })
    }

    /// The parameters.
    pub fn parameters(&self) -> &OrnsteinUhlenbeckParameters<D> {
        &self.parameters
    }

    /// `E[X(t)]` from `E[X(0)]`.
    ///
    /// # Errors
    /// [`Error::Negative`], [`Error::NotFinite`] for `t`.
    pub fn mean_at(&self, t: f64, start: &[f64; D]) -> Result<[f64; D], Error> {
        let Transition { matrix, .. } = self.transition(t)?;
        let m = &self.parameters.mean;
        Ok(std::array::from_fn(|i| {
            m[i] + (0..D).map(|j| matrix[i][j] * (start[j] - m[j])).sum::<f64>()
        }))
    }

    /// The covariance of `X(t)` from that of `X(0)`:
    /// `exp(-Theta t) C exp(-Theta t)^T` and the integral of `exp(-Theta s) G G^T exp(-Theta s)^T`.
    ///
    /// # Errors
    /// As [`mean_at`](Self::mean_at).
    pub fn covariance_at(&self, t: f64, start: &[[f64; D]; D]) -> Result<[[f64; D]; D], Error> {
        Ok(self.transition(t)?.of_covariance(start))
    }

    /// The covariance that stays.
    ///
    /// # Errors
    /// [`Error::NoStationaryLaw`] where a mode does not decay.
    pub fn stationary_covariance(&self) -> Result<[[f64; D]; D], Error> {
        let (f, noise) = self.coefficients();
        Transition::stationary("the Ornstein-Uhlenbeck process", &f, &noise)
    }

    fn transition(&self, t: f64) -> Result<Transition<D>, Error> {
        not_negative("time", t)?;
        let (f, noise) = self.coefficients();
        Ok(Transition::over(&f, &noise, t))
    }

    /// `-Theta` and `G G^T`.
    fn coefficients(&self) -> (Matrix<D>, Matrix<D>) {
        let f = self.parameters.rates.map(|row| row.map(|value| -value));
        let diffusion = self.diffusion(0.0, &self.parameters.mean);
        (f, diffusion.map(|row| row.map(|value| 2.0 * value)))
    }
}

impl<const D: usize> Sde<D, D> for OrnsteinUhlenbeck<D> {
    type Noise = Additive;

    #[inline]
    fn drift(&self, _: f64, x: &[f64; D]) -> [f64; D] {
        let OrnsteinUhlenbeckParameters { rates, mean, .. } = &self.parameters;
        std::array::from_fn(|i| -(0..D).map(|j| rates[i][j] * (x[j] - mean[j])).sum::<f64>())
    }

    #[inline]
    fn noise(&self, _: f64, _: &[f64; D]) -> [[f64; D]; D] {
        self.parameters.noise
    }

    #[inline]
    fn linear_part(&self) -> Option<[[f64; D]; D]> {
        Some(self.coefficients().0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_dimension_has_the_textbook_law() {
        let parameters =
            OrnsteinUhlenbeckParameters { rates: [[0.7]], mean: [0.4], noise: [[0.9]] };
        let process = OrnsteinUhlenbeck::new(parameters).unwrap();
        for t in [0.0, 0.3, 5.0] {
            let decay = (-0.7_f64 * t).exp();
            let mean = 0.4 + decay * (2.0 - 0.4);
            let variance = decay * decay * 0.25 + 0.81 / 1.4 * (1.0 - decay * decay);
            assert!((process.mean_at(t, &[2.0]).unwrap()[0] - mean).abs() < 1e-14);
            assert!((process.covariance_at(t, &[[0.25]]).unwrap()[0][0] - variance).abs() < 1e-14);
        }
        let stays = process.stationary_covariance().unwrap()[0][0];
        assert!((stays - 0.81 / 1.4).abs() < 1e-14);
    }

    #[test]
    fn the_stationary_covariance_solves_the_lyapunov_equation() {
        let rates = [
            [1.0, 0.5, 0.0, 0.1],
            [-0.5, 1.5, 0.2, 0.0],
            [0.0, 0.3, 0.4, 0.0],
            [0.2, 0.0, 0.1, 2.0],
        ];
        let noise = [
            [0.5, 0.0, 0.0, 0.0],
            [0.1, 0.4, 0.0, 0.0],
            [0.0, 0.2, 0.3, 0.0],
            [0.0, 0.0, 0.1, 0.6],
        ];
        let parameters = OrnsteinUhlenbeckParameters { rates, mean: [0.0; 4], noise };
        let process = OrnsteinUhlenbeck::new(parameters).unwrap();
        let p = process.stationary_covariance().unwrap();
        let d = process.diffusion(0.0, &[0.0; 4]);
        for i in 0..4 {
            for j in 0..4 {
                let pulled: f64 =
                    (0..4).map(|k| rates[i][k] * p[k][j] + p[i][k] * rates[j][k]).sum();
                assert!((pulled - 2.0 * d[i][j]).abs() < 1e-13, "({i}, {j})");
            }
        }
    }

    #[test]
    fn numbers_that_are_none_and_a_time_before_the_start_are_refused() {
        let parameters =
            OrnsteinUhlenbeckParameters { rates: [[f64::NAN]], mean: [0.0], noise: [[1.0]] };
        assert!(matches!(
            OrnsteinUhlenbeck::new(parameters),
            Err(Error::NotFinite { name: "rates", .. })
        ));
        let parameters = OrnsteinUhlenbeckParameters { rates: [[-1.0]], ..parameters };
        let process = OrnsteinUhlenbeck::new(parameters).unwrap();
        assert!(process.covariance_at(-1.0, &[[1.0]]).is_err());
        assert!(matches!(process.stationary_covariance(), Err(Error::NoStationaryLaw { .. })));
    }
}
