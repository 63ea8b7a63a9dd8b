//! Exact solution of the Riemann problem between two stiffened gases (Toro 2009, chapter 4; for stiffened gases with the
//! pressure shifted by `p_inf`, Menikoff and Plohr 1989).

use crate::case::CaseError;

/// One side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gas {
    /// Mass per volume.
    pub(crate) density: f64,
    /// Velocity.
    pub(crate) velocity: f64,
    /// Pressure.
    pub(crate) pressure: f64,
    /// `gamma`.
    pub(crate) exponent: f64,
    /// `p_inf`.
    pub(crate) stiffness: f64,
}

/// Density, velocity and pressure at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct State {
    /// Mass per volume.
    pub(crate) density: f64,
    /// Velocity.
    pub(crate) velocity: f64,
    /// Pressure.
    pub(crate) pressure: f64,
}

/// Two sides and what is between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Riemann {
    sides: [Gas; 2],
    /// Pressure at the contact.
    pub(crate) pressure: f64,
    /// Velocity of the contact.
    pub(crate) velocity: f64,
}

impl Gas {
    fn sound_speed(&self) -> f64 {
        (self.exponent * (self.pressure + self.stiffness) / self.density).sqrt()
    }

    /// Change of velocity across the wave that leads to the pressure `p`, and its derivative.
    fn wave(&self, p: f64) -> (f64, f64) {
        let (g, here, there) = (self.exponent, self.pressure + self.stiffness, p + self.stiffness);
        if p > self.pressure {
            let a = 2.0 / ((g + 1.0) * self.density);
            let b = (g - 1.0) / (g + 1.0) * here;
            let root = (a / (there + b)).sqrt();
            ((p - self.pressure) * root, root * (1.0 - 0.5 * (p - self.pressure) / (there + b)))
        } else {
            let c = self.sound_speed();
            let power = 0.5 * (g - 1.0) / g;
            let ratio = there / here;
            (
                2.0 * c / (g - 1.0) * (ratio.powf(power) - 1.0),
                ratio.powf(-0.5 * (g + 1.0) / g) / (self.density * c),
            )
        }
    }
}

impl Riemann {
    /// Solves for the contact by Newton's method.
    pub(crate) fn new(left: Gas, right: Gas) -> Result<Self, CaseError> {
        let jump = right.velocity - left.velocity;
        let least = -left.stiffness.min(right.stiffness);
        let mut p = 0.5 * (left.pressure + right.pressure);
        for _ in 0..100 {
            let ((f_l, d_l), (f_r, d_r)) = (left.wave(p), right.wave(p));
            let next = p - (f_l + f_r + jump) / (d_l + d_r);
            let next = if next > least { next } else { 0.5 * (p + least) };
            let settled = (next - p).abs() <= 1e-14 * (next - least).abs();
            p = next;
            if settled {
                let velocity =
                    0.5 * (left.velocity + right.velocity + right.wave(p).0 - left.wave(p).0);
                return Ok(Self { sides: [left, right], pressure: p, velocity });
            }
        }
        Err("the pressure at the contact does not settle".into())
    }

    /// The state at `x/t`, the contact having been at zero.
    #[must_use]
    pub(crate) fn at(&self, slope: f64) -> State {
        let right = slope > self.velocity;
        let gas = self.sides[usize::from(right)];
        // As seen from the left: the other side is mirrored.
        let sign = if right { -1.0 } else { 1.0 };
        let (s, u, u_star) = (sign * slope, sign * gas.velocity, sign * self.velocity);
        let g = gas.exponent;
        let (here, there) = (gas.pressure + gas.stiffness, self.pressure + gas.stiffness);
        let outside =
            State { density: gas.density, velocity: gas.velocity, pressure: gas.pressure };
        let ratio = there / here;
        if self.pressure > gas.pressure {
            let c = gas.sound_speed();
            let shock = u - c * (0.5 * (g + 1.0) / g * ratio + 0.5 * (g - 1.0) / g).sqrt();
            if s < shock {
                return outside;
            }
            let k = (g - 1.0) / (g + 1.0);
            let density = gas.density * (ratio + k) / (k * ratio + 1.0);
            return State { density, velocity: self.velocity, pressure: self.pressure };
        }
        let c = gas.sound_speed();
        let c_star = c * ratio.powf(0.5 * (g - 1.0) / g);
        if s < u - c {
            outside
        } else if s > u_star - c_star {
            let density = gas.density * ratio.powf(1.0 / g);
            State { density, velocity: self.velocity, pressure: self.pressure }
        } else {
            let share = 2.0 / (g + 1.0) + (g - 1.0) / ((g + 1.0) * c) * (u - s);
            let velocity = 2.0 / (g + 1.0) * (c + 0.5 * (g - 1.0) * u + s);
            State {
                density: gas.density * share.powf(2.0 / (g - 1.0)),
                velocity: sign * velocity,
                pressure: here * share.powf(2.0 * g / (g - 1.0)) - gas.stiffness,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gas(density: f64, pressure: f64, exponent: f64, stiffness: f64) -> Gas {
        Gas { density, velocity: 0.0, pressure, exponent, stiffness }
    }

    #[test]
    fn sod_and_a_gas_against_water() {
        let sod = Riemann::new(gas(1.0, 1.0, 1.4, 0.0), gas(0.125, 0.1, 1.4, 0.0)).unwrap();
        assert!((sod.pressure - 0.303_130_178_050_647_35).abs() < 1e-13);
        assert!((sod.velocity - 0.927_452_620_048_95).abs() < 1e-12);
        assert!((sod.at(0.9).density - 0.426_319_428_178_495_7).abs() < 1e-12);
        assert!((sod.at(1.7).density - 0.265_573_711_705_307_36).abs() < 1e-12);
        assert!((sod.at(1.8).pressure - 0.1).abs() < 1e-16);
        let mixed = Riemann::new(gas(1.63, 0.0838, 2.7, 0.0), gas(1.0, 1e-6, 4.4, 0.006)).unwrap();
        assert!((mixed.pressure - 0.035_994_989_688_246_6).abs() < 1e-13);
        assert!((mixed.velocity - 0.102_386_225_600_639_3).abs() < 1e-12);
    }

    #[test]
    fn states_join_at_the_ends_of_a_fan() {
        let sod = Riemann::new(gas(1.0, 1.0, 1.4, 0.0), gas(0.125, 0.1, 1.4, 0.0)).unwrap();
        for edge in [-1.183_215_956_619_923_2, -0.070_272_812_561_183_45] {
            let (below, above) = (sod.at(edge - 1e-9), sod.at(edge + 1e-9));
            assert!((below.pressure - above.pressure).abs() < 1e-7);
            assert!((below.velocity - above.velocity).abs() < 1e-7);
        }
    }
}
