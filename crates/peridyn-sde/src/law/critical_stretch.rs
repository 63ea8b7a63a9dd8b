//! Bonds that break at a stretch.

use super::BondLaw;

/// A bond carries `sigma = s` until its stretch has first reached its strength `s_0`, and nothing from then on (eq 2 of the
/// note, with the maximum over the history; Silling & Askari 2005). Compression does not break it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CriticalStretch;

impl BondLaw for CriticalStretch {
    /// Whether it is broken.
    type State = bool;

    fn advance(&self, strength: f64, from: f64, to: f64, _dt: f64, broken: &mut bool) {
        let holds = from.max(to) < strength;
        *broken |= !holds;
    }

    fn tension(&self, _strength: f64, s: f64, broken: &bool) -> f64 {
        if *broken { 0.0 } else { s }
    }

    fn energy(&self, _strength: f64, s: f64, broken: &bool) -> f64 {
        if *broken { 0.0 } else { 0.5 * s * s }
    }

    fn damage(&self, _strength: f64, broken: &bool) -> f64 {
        f64::from(*broken)
    }

    fn is_piecewise_linear(&self) -> bool {
        true
    }

    fn threshold(&self, strength: f64, broken: &bool) -> Option<f64> {
        (!*broken).then_some(strength)
    }
}
