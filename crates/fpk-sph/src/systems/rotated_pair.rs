//! Two independent scalar systems in rotated coordinates.

use sde_integrators::{NoiseClass, Sde};

use crate::error::{Error, finite};

/// `x = R y` of two independent scalar systems,
///
/// $$ dY_k = f_k(Y_k) dt + g_k(Y_k) dB_k, \qquad
///    R = \begin{pmatrix} \cos\varphi & -\sin\varphi \cr \sin\varphi & \cos\varphi \end{pmatrix}, $$
///
/// so that the density of `x` is the product of two that are known, while no entry of `D(x)` is zero or constant. Both
/// systems have the same class of noise. `div_x D = R div_y D`, because `R` is a rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotatedPair<A, B> {
    first: A,
    second: B,
    cos: f64,
    sin: f64,
}

impl<A, B> RotatedPair<A, B> {
    /// Two systems and the angle `phi` (rad).
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the angle.
    pub fn new(first: A, second: B, angle: f64) -> Result<Self, Error> {
        finite("angle", angle)?;
        let (sin, cos) = angle.sin_cos();
        Ok(Self { first, second, cos, sin })
    }

    /// `R y`.
    #[inline]
    pub fn rotate(&self, &[a, b]: &[f64; 2]) -> [f64; 2] {
        [self.cos * a - self.sin * b, self.sin * a + self.cos * b]
    }

    /// `R^T x`.
    #[inline]
    pub fn rotate_back(&self, &[a, b]: &[f64; 2]) -> [f64; 2] {
        [self.cos * a + self.sin * b, self.cos * b - self.sin * a]
    }
}

impl<A, B, N> Sde<2, 2> for RotatedPair<A, B>
where
    A: Sde<1, 1, Noise = N>,
    B: Sde<1, 1, Noise = N>,
    N: NoiseClass,
{
    type Noise = N;

    #[inline]
    fn drift(&self, t: f64, x: &[f64; 2]) -> [f64; 2] {
        let [a, b] = self.rotate_back(x);
        self.rotate(&[self.first.drift(t, &[a])[0], self.second.drift(t, &[b])[0]])
    }

    #[inline]
    fn noise(&self, t: f64, x: &[f64; 2]) -> [[f64; 2]; 2] {
        let [a, b] = self.rotate_back(x);
        let (g_a, g_b) = (self.first.noise(t, &[a])[0][0], self.second.noise(t, &[b])[0][0]);
        [[self.cos * g_a, -self.sin * g_b], [self.sin * g_a, self.cos * g_b]]
    }

    #[inline]
    fn diffusion_divergence(&self, t: f64, x: &[f64; 2]) -> [f64; 2] {
        let [a, b] = self.rotate_back(x);
        let divergence = [
            self.first.diffusion_divergence(t, &[a])[0],
            self.second.diffusion_divergence(t, &[b])[0],
        ];
        self.rotate(&divergence)
    }

    /// `R diag(a, b) R^T`; none where one of the two has none.
    #[inline]
    fn linear_part(&self) -> Option<[[f64; 2]; 2]> {
        let ([[a]], [[b]]) = (self.first.linear_part()?, self.second.linear_part()?);
        let beside = (a - b) * self.cos * self.sin;
        let (cos, sin) = (self.cos * self.cos, self.sin * self.sin);
        Some([[a * cos + b * sin, beside], [beside, a * sin + b * cos]])
    }
}

#[cfg(test)]
mod tests {
    use sde_integrators::check_diffusion_divergence;

    use super::*;
    use crate::systems::{CoxIngersollRoss, CoxIngersollRossParameters, GeometricBrownianMotion};

    #[test]
    fn the_divergence_is_that_of_the_rotated_noise() {
        let parameters = CoxIngersollRossParameters { rate: 0.8, mean: 1.2, volatility: 0.5 };
        let first = CoxIngersollRoss::new(parameters).unwrap();
        let second = GeometricBrownianMotion::new(0.1, 0.3).unwrap();
        let pair = RotatedPair::new(first, second, 0.6).unwrap();
        let states = [[1.0, 0.7], [1.5, 2.0]].map(|y| pair.rotate(&y));
        // Central differences, relative error 1e-10.
        assert!(check_diffusion_divergence(&pair, 0.0, &states) < 1e-9);
        for x in &states {
            let d = pair.diffusion(0.0, x);
            assert!(d[0][1].abs() > 1e-3, "the rotation couples the components: {d:?}");
        }
        // By the chain rule the drift of R y is R f(y).
        let drift = pair.rotate_back(&pair.drift(0.0, &states[0]));
        assert!((drift[0] - 0.8 * 0.2).abs() < 1e-14 && (drift[1] - 0.07).abs() < 1e-14);
    }
}
