//! Bonds that soften.

use super::BondLaw;
use crate::error::{Error, positive};

/// Elastic up to the strength `s_0`, then a tension that falls on a line to zero at `s_f = ductility * s_0`; unloading goes back
/// to the origin. With the largest stretch `s_m` so far,
///
/// $$ \sigma = (1 - d) s, \qquad d = \frac{s_f (s_m - s_0)}{s_m (s_f - s_0)} \text{ for } s_0 < s_m < s_f . $$
///
/// Compression is elastic and whole as long as the bond is not broken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bilinear {
    ductility: f64,
}

impl Bilinear {
    /// `s_f/s_0`, above one.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a ratio of one or less, or one that is not finite.
    pub fn new(ductility: f64) -> Result<Self, Error> {
        positive("ductility", ductility)?;
        crate::error::between("ductility", ductility, 1.0, f64::INFINITY)?;
        Ok(Self { ductility })
    }

    fn lost(self, strength: f64, largest: f64) -> f64 {
        let last = self.ductility * strength;
        if largest <= strength {
            0.0
        } else if largest >= last {
            1.0
        } else {
            last * (largest - strength) / (largest * (last - strength))
        }
    }
}

impl BondLaw for Bilinear {
    /// The largest stretch so far.
    type State = f64;

    fn advance(&self, _strength: f64, from: f64, to: f64, _dt: f64, largest: &mut f64) {
        *largest = largest.max(from).max(to);
    }

    fn tension(&self, strength: f64, s: f64, largest: &f64) -> f64 {
        let lost = self.lost(strength, *largest);
        if s < 0.0 && lost < 1.0 { s } else { (1.0 - lost) * s }
    }

    fn energy(&self, strength: f64, s: f64, largest: &f64) -> f64 {
        0.5 * s * self.tension(strength, s, largest)
    }

    fn damage(&self, strength: f64, largest: &f64) -> f64 {
        self.lost(strength, *largest)
    }

    fn is_piecewise_linear(&self) -> bool {
        true
    }

    fn threshold(&self, strength: f64, largest: &f64) -> Option<f64> {
        (self.lost(strength, *largest) < 1.0).then(|| strength.max(*largest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tension_falls_on_a_line_and_unloads_to_the_origin() {
        let (law, strength) = (Bilinear::new(4.0).unwrap(), 1e-3);
        let (mut state, mut last, mut area) = (0.0, 0.0, 0.0);
        for step in 1..=5000_u32 {
            let s = 1e-6 * f64::from(step);
            let before = law.tension(strength, last, &state);
            law.advance(strength, last, s, 1.0, &mut state);
            let tension = law.tension(strength, s, &state);
            let expected = if s <= strength { s } else { (4.0 * strength - s).max(0.0) / 3.0 };
            assert!((tension - expected).abs() < 1e-17, "{s}");
            assert!((law.tension(strength, 0.5 * s, &state) - 0.5 * expected).abs() < 1e-17);
            area += 0.5 * (before + tension) * (s - last);
            last = s;
        }
        // The triangle of base s_f and height s_0.
        assert!((area / (0.5 * 4.0 * strength * strength) - 1.0).abs() < 1e-6);
        assert_eq!((law.damage(strength, &state), law.threshold(strength, &state)), (1.0, None));
        assert!(Bilinear::new(1.0).is_err() && Bilinear::new(f64::NAN).is_err());
    }
}
