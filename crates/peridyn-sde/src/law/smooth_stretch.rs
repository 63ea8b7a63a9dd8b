//! Bonds that break at a stretch, smoothly.

use super::BondLaw;
use crate::error::{Error, between};

/// As a bond that breaks at its strength `s_0`, but with a tension that has a continuous slope (the remark to eq 2 of the note):
/// up to `(1 - w) s_0` elastic, from there to `(1 + w) s_0` times
///
/// $$ g(x) = 1 - 3 x^2 + 2 x^3, \qquad x = \frac{s - (1 - w) s_0}{2 w s_0}, $$
///
/// zero beyond. A bond that has passed `(1 + w) s_0` is broken for good; before, it goes back the way it came.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmoothStretch {
    width: f64,
}

impl SmoothStretch {
    /// Half the width `w` of the fall over the strength, between zero and one.
    ///
    /// # Errors
    /// [`Error::OutOfRange`].
    pub fn new(width: f64) -> Result<Self, Error> {
        between("width of the fall", width, 0.0, 1.0)?;
        Ok(Self { width })
    }

    /// Position of a stretch within the decrease, and length of the decrease.
    fn fall(self, strength: f64, s: f64) -> (f64, f64) {
        let length = 2.0 * self.width * strength;
        (((s - (1.0 - self.width) * strength) / length).clamp(0.0, 1.0), length)
    }
}

impl BondLaw for SmoothStretch {
    /// Whether it is broken.
    type State = bool;

    fn advance(&self, strength: f64, from: f64, to: f64, _dt: f64, broken: &mut bool) {
        let holds = from.max(to) < (1.0 + self.width) * strength;
        *broken |= !holds;
    }

    fn tension(&self, strength: f64, s: f64, broken: &bool) -> f64 {
        if *broken {
            return 0.0;
        }
        let (x, _) = self.fall(strength, s);
        s * (1.0 - x * x * (3.0 - 2.0 * x))
    }

    fn energy(&self, strength: f64, s: f64, broken: &bool) -> f64 {
        if *broken {
            return 0.0;
        }
        let (x, length) = self.fall(strength, s);
        let begin = (1.0 - self.width) * strength;
        if s <= begin {
            return 0.5 * s * s;
        }
        // int_0^x (begin + length y) g(y) length dy.
        let g = x - x.powi(3) + 0.5 * x.powi(4);
        let y_g = x * x * (0.5 - 0.75 * x * x + 0.4 * x.powi(3));
        0.5 * begin * begin + length * (begin * g + length * y_g)
    }

    fn damage(&self, _strength: f64, broken: &bool) -> f64 {
        f64::from(*broken)
    }

    fn threshold(&self, strength: f64, broken: &bool) -> Option<f64> {
        (!*broken).then_some((1.0 + self.width) * strength)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tension_is_the_slope_of_the_energy_and_has_a_slope_itself() {
        let (law, strength, delta) = (SmoothStretch::new(0.25).unwrap(), 1e-2, 1e-7);
        let mut last = None;
        for step in -20..160_i32 {
            let s = 1e-4 * f64::from(step);
            let difference =
                law.energy(strength, s + delta, &false) - law.energy(strength, s - delta, &false);
            let tension = law.tension(strength, s, &false);
            assert!((difference / (2.0 * delta) - tension).abs() < 1e-9, "{s}");
            let slope = (law.tension(strength, s + delta, &false)
                - law.tension(strength, s - delta, &false))
                / (2.0 * delta);
            // The steepest second derivative is about 6 s_0/(2 w s_0)^2 = 2400: a jump of the slope would be larger.
            assert!(last.is_none_or(|before: f64| (slope - before).abs() < 0.3), "{s}: {slope}");
            last = Some(slope);
        }
        let mut broken = false;
        law.advance(strength, 0.0, 1.24e-2, 1.0, &mut broken);
        assert!(!broken);
        law.advance(strength, 1.24e-2, 1.26e-2, 1.0, &mut broken);
        assert!(broken && law.tension(strength, 0.0, &broken) == 0.0);
        assert!(SmoothStretch::new(0.0).is_err() && SmoothStretch::new(f64::NAN).is_err());
    }
}
