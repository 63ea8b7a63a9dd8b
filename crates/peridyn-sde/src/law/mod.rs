//! Constitutive laws of bonds: tension and energy under a stretch, and the history that changes both.

mod bilinear;
mod critical_stretch;
mod memory;

use std::fmt::Debug;

pub use bilinear::Bilinear;
pub use critical_stretch::CriticalStretch;
pub use memory::Memory;

/// A constitutive law of bonds: the tension under a stretch, its energy, and how the history of a bond changes both.
///
/// The tension of a bond is `kappa sigma(s)` with its stiffness `kappa` and the effective stretch `sigma`; its energy is
/// `kappa r` times the integral of `sigma`. Every bond has a stretch `strength` at which it breaks, so that strength may vary
/// in space; a law without such a number ignores it.
///
/// A law describes intact bonds. A bond that is cut, as by a notch, carries no tension under any law:
/// [`Network`](crate::Network) keeps track of it.
pub trait BondLaw: Debug + Sync {
    /// The history of a bond. Its default is that of an undamaged bond.
    type State: Copy + Debug + Default + PartialEq + Send + Sync;

    /// Advances the history of a bond over a step of the length `dt`, in which the stretch goes from `from` to `to` on a
    /// straight line.
    fn advance(&self, strength: f64, from: f64, to: f64, dt: f64, state: &mut Self::State);

    /// The effective stretch `sigma` at the stretch `s`, with the history up to there.
    fn tension(&self, strength: f64, s: f64, state: &Self::State) -> f64;

    /// The integral of `sigma` from zero to `s`: the energy of the bond over `kappa r`.
    fn energy(&self, strength: f64, s: f64, state: &Self::State) -> f64;

    /// The damage: 0 undamaged, 1 broken.
    fn damage(&self, strength: f64, state: &Self::State) -> f64;

    /// The stretch whose first passage changes the bond for good, which the bridge test looks for between the ends of steps.
    ///
    /// Unless a law says otherwise there is none, and [`advance`](Self::advance) at the ends of steps decides alone.
    fn threshold(&self, _strength: f64, _state: &Self::State) -> Option<f64> {
        None
    }

    /// Whether a pulled bond has the tension `(1 - damage) s` up to the [`threshold`](Self::threshold), with a damage that depends
    /// on the largest stretch alone: what a quasi-static equilibrium needs. No, unless a law says otherwise.
    fn is_piecewise_linear(&self) -> bool {
        false
    }

    /// `d sigma/ds` at rest: what the step is checked against, and what an implicit step takes the bond for.
    ///
    /// Unless a law says otherwise, the steeper of both sides over a stretch of a millionth, or of a millionth of the strength
    /// where that is less. A law that is steeper elsewhere than at rest is checked at rest alone.
    fn slope(&self, strength: f64, state: &Self::State) -> f64 {
        let s = 1e-6 * strength.min(1.0);
        let at_rest = self.tension(strength, 0.0, state);
        let [pulled, pushed] = [s, -s].map(|s| (self.tension(strength, s, state) - at_rest) / s);
        if pulled.abs() >= pushed.abs() { pulled } else { pushed }
    }
}
