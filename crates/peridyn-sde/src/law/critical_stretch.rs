//! Bonds that break at a stretch.

use super::BondLaw;

/// A bond carries `sigma = s` until its stretch has first reached its strength `s_0`, and nothing from then on (eq 2 of the
/// note, with the maximum over the history; Silling & Askari 2005). Compression does not break it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CriticalStretch;

impl BondLaw for CriticalStretch {
    /// Whether it is whole.
    type State = bool;

    fn start(&self) -> bool {
        true
    }

    fn cut(&self) -> bool {
        false
    }

    fn advance(&self, strength: f64, from: f64, to: f64, _dt: f64, whole: &mut bool) {
        *whole &= from.max(to) < strength;
    }

    fn tension(&self, _strength: f64, s: f64, whole: &bool) -> f64 {
        if *whole { s } else { 0.0 }
    }

    fn energy(&self, _strength: f64, s: f64, whole: &bool) -> f64 {
        if *whole { 0.5 * s * s } else { 0.0 }
    }

    fn damage(&self, _strength: f64, whole: &bool) -> f64 {
        f64::from(!*whole)
    }

    fn threshold(&self, strength: f64, whole: &bool) -> Option<f64> {
        whole.then_some(strength)
    }
}
