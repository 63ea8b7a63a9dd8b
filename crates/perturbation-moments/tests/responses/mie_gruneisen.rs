//! Mie-Grüneisen pressure with five random parameters.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use perturbation_moments::{Expansion, Response, Scalar};

/// State of the pressure, and the certain material data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MieGruneisenState {
    /// `rho0 c0^2`: initial density times the square of the bulk sound speed (Pa).
    pub(crate) bulk_modulus: f64,
    /// `mu = rho/rho0 - 1`, above -1.
    pub(crate) compression: f64,
    /// `e`: internal energy per initial volume (Pa).
    pub(crate) energy: f64,
}

/// Mie-Grüneisen pressure at a given state, as a function of its parameters `x = [S1, S2, S3, gamma0, a]`.
///
/// $$ p = \frac{\rho_0 c_0^2 \mu \left( 1 + (1 - \tfrac{\gamma_0}{2}) \mu - \tfrac{a}{2} \mu^2 \right)}
///             {\left( 1 - (S_1 - 1) \mu - S_2 \frac{\mu^2}{\mu + 1} - S_3 \frac{\mu^3}{(\mu + 1)^2} \right)^2}
///        + (\gamma_0 + a \mu) e, \quad \mu > 0; \qquad
///    p = \rho_0 c_0^2 \mu + (\gamma_0 + a \mu) e, \quad \mu \le 0 $$
///
/// All parameters are dimensionless. The pressure has a pole where the denominator is zero, at `S1 = 1 + 1/mu` for
/// `S2 = S3 = 0`: for a Gaussian `S1` its moments do not exist. See [`denominator`](Self::denominator).
///
/// Source: Chen et al. 2019, eq 10 and 31-33, correct in print.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MieGruneisen {
    state: MieGruneisenState,
    /// Coefficients of `S1 - 1`, `S2` and `S3` in the denominator.
    weights: [f64; 3],
}

impl MieGruneisen {
    /// Response at a state.
    #[inline(always)]
    pub(crate) fn new(state: MieGruneisenState) -> Self {
        let mu = state.compression;
        // Without a shock the denominator is one: with these weights zero, one formula holds for both signs.
        let ratio = mu / (1.0 + mu);
        let weights = if mu > 0.0 { [mu, mu * ratio, mu * ratio * ratio] } else { [0.0; 3] };
        Self { state, weights }
    }

    /// `1 - (S1 - 1) mu - ..`: the pressure has its pole where this is zero, outside the physical range.
    #[must_use]
    #[inline(always)]
    pub(crate) fn denominator<S: Scalar>(&self, x: &[S; 5]) -> S {
        let [w1, w2, w3] = self.weights;
        (x[0] * -w1 + (1.0 + w1)) - (x[1] * w2 + x[2] * w3)
    }

    /// Value, and the five first and five unmixed second derivatives, in closed form.
    #[must_use]
    #[inline(always)]
    pub(crate) fn diagonal(&self, x: &[f64; 5]) -> (f64, [f64; 5], [f64; 5]) {
        let MieGruneisenState { bulk_modulus, compression: mu, energy } = self.state;
        let [w1, w2, w3] = self.weights;
        // Operations without the division come first; only powers of the inverse follow.
        let cold = bulk_modulus * mu;
        let half = -0.5 * mu.max(0.0) * cold;
        let gruneisen = x[3] + x[4] * mu;
        let numerator = cold * self.polynomial() + half * gruneisen;
        let thermal = gruneisen * energy;
        let inverse = 1.0 / self.denominator(x);
        let square = inverse * inverse;
        let (twice, six) =
            ((2.0 * numerator) * (square * inverse), (6.0 * numerator) * (square * square));
        let by_gamma = half * square + energy;
        (
            numerator * square + thermal,
            [twice * w1, twice * w2, twice * w3, by_gamma, by_gamma * mu],
            [six * (w1 * w1), six * (w2 * w2), six * (w3 * w3), 0.0, 0.0],
        )
    }

    /// Value, gradient, Hessian and third derivatives, in closed form.
    #[must_use]
    pub(crate) fn expansion(&self, x: &[f64; 5]) -> Expansion<5> {
        let MieGruneisenState { bulk_modulus, compression: mu, energy } = self.state;
        let inverse = 1.0 / self.denominator(x);
        let half = if mu > 0.0 { -0.5 * mu } else { 0.0 };
        let numerator = self.polynomial() + half * (x[3] + x[4] * mu);
        // Linear in gamma0 and a: at most one derivative with respect to either, and (k+1)! D^-(2+k) of the
        // denominator.
        let derivative = |by: &[usize]| {
            let (mut cold, mut thermal) = (bulk_modulus * mu * inverse * inverse, energy);
            let (mut order, mut linear) = (0_u32, 0);
            for &i in by {
                if i < 3 {
                    cold *= f64::from(order + 2) * inverse * self.weights[i];
                    order += 1;
                } else {
                    linear += 1;
                    let weight = if i == 3 { 1.0 } else { mu };
                    (cold, thermal) = (cold * half * weight, thermal * weight);
                }
            }
            match (linear, order) {
                (0, 0) => cold * numerator + thermal * (x[3] + x[4] * mu),
                (0, _) => cold * numerator,
                (1, 0) => cold + thermal,
                (1, _) => cold,
                _ => 0.0,
            }
        };
        Expansion::from_derivatives(derivative)
    }

    /// The numerator without `gamma0` and `a`: `1 + mu` under compression, else one.
    #[inline(always)]
    fn polynomial(&self) -> f64 {
        1.0 + self.state.compression.max(0.0)
    }
}

impl Response<5> for MieGruneisen {
    #[inline(always)]
    fn value<S: Scalar>(&self, x: &[S; 5]) -> S {
        let MieGruneisenState { bulk_modulus, compression: mu, energy } = self.state;
        let gruneisen = x[3] + x[4] * mu;
        if mu > 0.0 {
            let slope = bulk_modulus * mu;
            let numerator = gruneisen * (-0.5 * mu * slope) + (1.0 + mu) * slope;
            numerator / self.denominator(x).squared() + gruneisen * energy
        } else {
            gruneisen * energy + bulk_modulus * mu
        }
    }
}
