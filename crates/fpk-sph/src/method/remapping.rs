//! Conditions and changes of a remapping.

use crate::error::{Error, positive};

/// Conditions for remeshing, extent of the new lattice, and permitted changes.
///
/// The unevenness of the cloud is the largest relative change of a cell's edges between adjacent lattice positions,
///
/// $$ \max_{i, j} \left| E_i^{-1} (E_j - E_i) \right|_F , $$
///
/// with the edges `E` of the deformed cells in whitened coordinates and `j` beside `i`. It is 0 for an affine flow, whose
/// Gaussian needs no remeshing, and about 1 where a cell is about to invert.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Remapping {
    /// The unevenness above which the cloud is remeshed before a step.
    pub most_uneven: f64,
    /// The lattice grows until its outermost layer carries less probability than this, or ends where the cloud ends: it goes
    /// beyond the last particle by [`BEYOND_THE_CLOUD`] spacings at most.
    pub outermost_mass: f64,
    /// Most relative change of the mass, and most change of an entry of the whitened mean and covariance, permitted
    /// before they are restored: beyond it the new lattice does not resolve the density. With a filter conditioned out, also most
    /// change of the explained variance of its output, over the variance of the output.
    pub most_change: f64,
    /// Largest number of particles on a new lattice.
    pub most_particles: usize,
}

/// Extent of a new lattice beyond the last particle, in spacings. Measured on Duffing's oscillator: with 0 the cloud
/// loses its rim, with 1.5 what is extrapolated grows from one lattice to the next.
pub const BEYOND_THE_CLOUD: f64 = 0.7;

/// Changes by a remeshing, before mass, mean and covariance are restored.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct Remapped {
    /// Particles before.
    pub particles_before: usize,
    /// Particles after.
    pub particles_after: usize,
    /// Particles outside the previous cloud.
    pub particles_beyond: usize,
    /// The probability that the outermost layer carries.
    pub outermost_mass: f64,
    /// Relative change of the mass.
    pub mass_change: f64,
    /// Largest change of an entry of the mean, in standard deviations.
    pub mean_change: f64,
    /// Largest change of an entry of the covariance in whitened coordinates.
    pub covariance_change: f64,
}

impl Remapping {
    /// What carries Duffing's and van der Pol's oscillator to their stationary laws (`fpk-sph/stationary-oscillators`).
    pub const MEASURED: Self =
        Self { most_uneven: 2.0, outermost_mass: 1e-8, most_change: 0.01, most_particles: 100_000 };

    /// Refuses numbers outside their range.
    pub(crate) fn check(&self) -> Result<(), Error> {
        positive("most_uneven", self.most_uneven)?;
        positive("outermost_mass", self.outermost_mass)?;
        positive("most_change", self.most_change)
    }
}

impl Remapped {
    /// Refuses changes above the limit.
    pub(crate) fn check(&self, time: f64, limit: f64) -> Result<(), Error> {
        for (quantity, value) in [
            ("mass", self.mass_change),
            ("mean", self.mean_change),
            ("covariance", self.covariance_change),
        ] {
            if value.is_nan() || value.abs() > limit {
                return Err(Error::RemappingChangesMass { time, quantity, value, limit });
            }
        }
        Ok(())
    }
}
