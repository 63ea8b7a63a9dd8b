//! What a bond does when it is stretched, and what it remembers.

mod bilinear;
mod critical_stretch;
mod memory;
mod smooth_stretch;

use std::fmt::Debug;

pub use bilinear::Bilinear;
pub use critical_stretch::CriticalStretch;
pub use memory::Memory;
pub use smooth_stretch::SmoothStretch;

/// A law of bonds: how much of its stiffness a bond has left, by what has become of it.
///
/// The tension of a bond is `kappa sigma(s)` with its stiffness `kappa` and a stretch `sigma` that counts; its energy is
/// `kappa r` times the integral of `sigma`. Per bond there is a stretch `strength` at which it breaks, so that strength may
/// vary in space; a law that knows no such number leaves it aside.
pub trait BondLaw: Debug + Sync {
    /// What a bond remembers.
    type State: Copy + Debug + PartialEq + Send + Sync;

    /// A bond that nothing has happened to.
    fn start(&self) -> Self::State;

    /// A bond that is cut, as by a notch.
    fn cut(&self) -> Self::State;

    /// Takes a bond over a step of the length `dt` in which its stretch goes from `from` to `to` on a straight line.
    fn advance(&self, strength: f64, from: f64, to: f64, dt: f64, state: &mut Self::State);

    /// The stretch that counts for the tension, at the stretch `s`; of a step already taken.
    fn tension(&self, strength: f64, s: f64, state: &Self::State) -> f64;

    /// Its integral from zero to `s`, the energy of the bond over `kappa r`.
    fn energy(&self, strength: f64, s: f64, state: &Self::State) -> f64;

    /// How much of the bond is lost: 0 whole, 1 broken.
    fn damage(&self, strength: f64, state: &Self::State) -> f64;

    /// The stretch whose first passage changes the bond for good, if there is such.
    fn threshold(&self, strength: f64, state: &Self::State) -> Option<f64>;

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
