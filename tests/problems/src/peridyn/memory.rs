//! Bonds that wear out, by an integration that shares nothing with their law but its equation.

use peridyn_sde::law::Memory;
use peridyn_sde::{BondLaw, Error};

/// `d alpha/dt = -lambda exp(k s) alpha^n (1 - alpha)^m`.
#[derive(Debug, Clone, Copy)]
pub struct Wear {
    /// `k`.
    pub sensitivity: f64,
    /// `lambda` (1/time).
    pub rate: f64,
    /// Exponent of what is left.
    pub n: f64,
    /// Exponent of what is lost.
    pub m: f64,
    /// `alpha(0)`.
    pub start: f64,
}

impl Wear {
    /// The law of the crate.
    ///
    /// # Errors
    /// Those of [`Memory::new`].
    pub fn law(&self) -> Result<Memory, Error> {
        Memory::new(self.sensitivity, self.rate, (self.n, self.m), self.start)
    }

    /// `d alpha/dt` at a stretch; of nothing left, for what is below zero.
    #[must_use]
    pub fn slope(&self, stretch: f64, alpha: f64) -> f64 {
        let alpha = alpha.max(0.0);
        let rate = -self.rate * (self.sensitivity * stretch).exp();
        rate * alpha.powf(self.n) * (1.0 - alpha).powf(self.m)
    }

    /// `alpha` at a time, by the classical Runge-Kutta method.
    #[must_use]
    pub fn integrated(&self, stretch: impl Fn(f64) -> f64, until: f64, steps: u32) -> f64 {
        let slope = |t: f64, a: f64| self.slope(stretch(t), a);
        let (dt, mut a) = (until / f64::from(steps), self.start);
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
}

/// `alpha` at a time, by steps of the law.
pub fn stepped(law: &Memory, stretch: impl Fn(f64) -> f64, until: f64, steps: u32) -> f64 {
    let (dt, mut state) = (until / f64::from(steps), 0.0);
    for step in 0..steps {
        let t = dt * f64::from(step);
        law.advance(1.0, stretch(t), stretch(t + dt), dt, &mut state);
    }
    1.0 - law.damage(1.0, &state)
}
