//! The note as printed: the baseline.

use std::f64::consts::PI;

use crate::bodies::bonds::{Bond, Bonds};
use crate::bodies::nodes::Nodes;
use crate::dynamics::scheme::{Dynamics, Scheme};
use crate::error::{Error, positive};
use crate::mobility::Mobility;

/// The method of the source note, eq 1 to 4 to the letter, kept to be compared with.
///
/// - The constant of bonds is `c = 18 K/(pi delta^4)` in every dimension. It is that of three dimensions; a plate under plane
///   stress comes out `2 t/delta` times as stiff.
/// - Nodes are bonded where `|x_i - x_j| < delta`: at a horizon of whole spacings roundoff decides which are.
/// - The energy (eq 3) weighs each bond by the volume of one end. Seen from both its ends that is the mean of the volumes: the
///   stiffness of a bond is `c (V_i + V_j)/2`, where `c V_i V_j` is meant.
/// - `du = -C grad V/eta dt + sqrt(2 C) dB` (eq 4): a mobility `C/eta` at the temperature `eta`, which is viscosity and
///   temperature at once. Its steps are those of Euler and Maruyama; bond failure is checked at their ends.
///
/// Bonds break for good: "reversibly" in the text contradicts the maximum over the history in eq 2. See `docs/errata.md`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoteAsPrinted {
    /// `K` (stress).
    pub bulk_modulus: f64,
    /// `delta` (length).
    pub horizon: f64,
    /// `eta` (energy, as it comes out).
    pub eta: f64,
}

impl NoteAsPrinted {
    /// The bonds of the note.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a constant; [`Error::LooseNode`] for a node without a bond.
    pub fn bonds<const D: usize>(&self, nodes: &Nodes<D>) -> Result<Bonds, Error> {
        positive("bulk modulus", self.bulk_modulus)?;
        positive("horizon", self.horizon)?;
        let c = 18.0 * self.bulk_modulus / (PI * self.horizon.powi(4));
        let volumes = nodes.volumes();
        Bonds::within(nodes, self.horizon, self.horizon, |(i, j), length| {
            (length < self.horizon)
                .then_some(Bond { length, stiffness: 0.5 * c * (volumes[i] + volumes[j]) })
        })
    }

    /// The dynamics of the note, with a mobility `C/eta`.
    ///
    /// # Errors
    /// [`Error::Parameter`] for `eta`.
    pub fn dynamics(&self, mobility: Mobility) -> Result<Dynamics, Error> {
        positive("eta", self.eta)?;
        let (temperature, scheme) = (self.eta, Scheme::EulerMaruyama);
        Ok(Dynamics::Overdamped { mobility, temperature, scheme })
    }
}
