//! Problems with a closed form or a trusted fine reference.

use sde_integrators::{Additive, DiagonalSde, Sde, SecondOrder, StratonovichSde};

/// `dX = (-sin 3X - 0.2 X) dt + 0.8 dW`: a drift that is nonlinear in the noisy variable, which distinguishes strong order 1.5
/// from 1.
#[derive(Debug, Clone, Copy)]
pub struct Sine;

impl Sde<1, 1> for Sine {
    type Noise = Additive;

    fn drift(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
        [-(3.0 * x[0]).sin() - 0.2 * x[0]]
    }

    fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[0.8]]
    }
}

/// `dX = (b/sqrt(1 + t) - X/(2 (1 + t))) dt + a b/sqrt(1 + t) dW` with `a = 0.8`, `b = 1`: noise that changes in
/// time. `X_t = X_0/sqrt(1 + t) + b (t + a W_t)/sqrt(1 + t)`. From the SciML collection (`prob_sde_additive`), with more noise: there
/// `a = 0.1`, `b = 0.05`, and the order without noise is what one sees.
#[derive(Debug, Clone, Copy)]
pub struct Ageing;

impl Ageing {
    const A: f64 = 0.8;
    const B: f64 = 1.0;

    /// The solution for a given path.
    #[must_use]
    pub fn exact(start: f64, t: f64, w: f64) -> f64 {
        (start + Self::B * (t + Self::A * w)) / (1.0 + t).sqrt()
    }
}

impl Sde<1, 1> for Ageing {
    type Noise = Additive;

    fn drift(&self, t: f64, x: &[f64; 1]) -> [f64; 1] {
        [Self::B / (1.0 + t).sqrt() - x[0] / (2.0 * (1.0 + t))]
    }

    fn noise(&self, t: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[Self::A * Self::B / (1.0 + t).sqrt()]]
    }
}

/// `dX = l X dt + m X dB`, geometric Brownian motion: `X_t = X_0 exp((l - m^2/2) t + m B_t)`.
#[derive(Debug, Clone, Copy)]
pub struct Geometric {
    /// `l`, per time.
    pub drift: f64,
    /// `m`, per square root of time.
    pub intensity: f64,
}

impl Geometric {
    /// The factor over a time in which the motion moves by `w`.
    #[must_use]
    pub fn factor(&self, t: f64, w: f64) -> f64 {
        ((self.drift - 0.5 * self.intensity * self.intensity) * t + self.intensity * w).exp()
    }
}

impl DiagonalSde<1> for Geometric {
    fn drift(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
        [self.drift * x[0]]
    }

    fn intensity(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
        [self.intensity * x[0]]
    }

    fn intensity_derivative(&self, _: f64, _: &[f64; 1]) -> [f64; 1] {
        [self.intensity]
    }
}

/// `dX = (X/2 + sqrt(X^2 + 1)) dt + sqrt(X^2 + 1) dB` from 0: `X_t = sinh(t + B_t)`.
#[derive(Debug, Clone, Copy)]
pub struct HyperbolicSine;

impl DiagonalSde<1> for HyperbolicSine {
    fn drift(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
        [0.5 * x[0] + x[0].hypot(1.0)]
    }

    fn intensity(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
        [x[0].hypot(1.0)]
    }

    fn intensity_derivative(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
        [x[0] / x[0].hypot(1.0)]
    }
}

/// Two populations, `dX_1 = (X_1 - X_1 X_2) dt + s_1 X_1 dB_1`, `dX_2 = (X_1 X_2 - X_2) dt + s_2 X_2 dB_2`: diagonal
/// noise in two states that the drift couples.
#[derive(Debug, Clone, Copy)]
pub struct Populations {
    /// `s_1` and `s_2`.
    pub intensity: [f64; 2],
}

impl DiagonalSde<2> for Populations {
    fn drift(&self, _: f64, &[prey, predator]: &[f64; 2]) -> [f64; 2] {
        [prey - prey * predator, prey * predator - predator]
    }

    fn intensity(&self, _: f64, x: &[f64; 2]) -> [f64; 2] {
        [self.intensity[0] * x[0], self.intensity[1] * x[1]]
    }

    fn intensity_derivative(&self, _: f64, _: &[f64; 2]) -> [f64; 2] {
        self.intensity
    }
}

/// `q'' + 0.5 q' + q + q^3 = 0.8 W`, Duffing's oscillator.
#[derive(Debug, Clone, Copy)]
pub struct Duffing;

impl SecondOrder<1, 1> for Duffing {
    fn natural_frequency(&self) -> [f64; 1] {
        [1.0]
    }

    fn linear_damping(&self) -> [f64; 1] {
        [0.5]
    }

    fn remaining_acceleration(&self, _: f64, &[q]: &[f64; 1], _: &[f64; 1]) -> [f64; 1] {
        [-q * q * q]
    }

    fn remaining_flow(&self, _: f64, dt: f64, &[q]: &[f64; 1], v: &mut [f64; 1]) {
        v[0] -= dt * q * q * q;
    }

    fn noise_intensity(&self, _: f64) -> [[f64; 1]; 1] {
        [[0.8]]
    }
}

/// `q'' + 2 xi omega q' + omega^2 q = s W`.
#[derive(Debug, Clone, Copy)]
pub struct Oscillator {
    /// `omega`.
    pub frequency: f64,
    /// `xi`.
    pub damping_ratio: f64,
    /// `s`.
    pub intensity: f64,
}

impl Oscillator {
    /// The stationary `E[v^2] = s^2/(4 xi omega)`; `E[q^2]` is this over `omega^2`, `E[q v]` is zero.
    #[must_use]
    pub fn velocity_variance(&self) -> f64 {
        self.intensity * self.intensity / (4.0 * self.damping_ratio * self.frequency)
    }
}

impl SecondOrder<1, 1> for Oscillator {
    fn natural_frequency(&self) -> [f64; 1] {
        [self.frequency]
    }

    fn linear_damping(&self) -> [f64; 1] {
        [2.0 * self.damping_ratio * self.frequency]
    }

    fn remaining_acceleration(&self, _: f64, _: &[f64; 1], _: &[f64; 1]) -> [f64; 1] {
        [0.0]
    }

    fn remaining_flow(&self, _: f64, _: f64, _: &[f64; 1], _: &mut [f64; 1]) {}

    fn noise_intensity(&self, _: f64) -> [[f64; 1]; 1] {
        [[self.intensity]]
    }
}

/// `dX = -X^3 dt + sigma dB`, on which explicit methods explode.
#[derive(Debug, Clone, Copy)]
pub struct Cubic {
    /// `sigma`.
    pub intensity: f64,
}

impl Cubic {
    /// The stationary `E X^2` for `sigma = sqrt(2)`: `2 Gamma(3/4)/Gamma(1/4)`.
    pub const STATIONARY_SECOND_MOMENT: f64 = 0.675_978_240_067_285;
}

impl Sde<1, 1> for Cubic {
    type Noise = Additive;

    fn drift(&self, _: f64, &[x]: &[f64; 1]) -> [f64; 1] {
        [-x * x * x]
    }

    fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[self.intensity]]
    }
}

/// `dX = 0.3 X o dB` in the sense of Stratonovich: `X_t = X_0 exp(0.3 B_t)`.
#[derive(Debug, Clone, Copy)]
pub struct StratonovichGrowth;

impl StratonovichSde<1, 1> for StratonovichGrowth {
    fn drift(&self, _: f64, _: &[f64; 1]) -> [f64; 1] {
        [0.0]
    }

    fn noise(&self, _: f64, x: &[f64; 1]) -> [[f64; 1]; 1] {
        [[0.3 * x[0]]]
    }
}
