//! The seam where the method's accuracy is decided: density and gradient of log density at the particles.
//!
//! | estimator | density | gradient | exact for | source |
//! |---|---|---|---|---|
//! | [`SummationDensity`] | `sum mu_j W_ij` | `sum mu_j grad W_ij` | nothing: kernel variance remains | Canor & Denoël 2013, eq 15, 19, 23 |
//! | [`LogDensityFit`] | `mu_i / V_i` | weighted least squares of `log psi`, degree 2 | a Gaussian, where the volumes are right | this project |

mod cell_geometry;
mod log_density_fit;
mod quadratic_fit;
mod summation_density;

pub use log_density_fit::{LocalFit, LogDensityFit, VolumeEstimate};
use neighbour_search::Criterion;
pub use summation_density::SummationDensity;

pub(crate) use cell_geometry::{determinant, lattice_jacobian};

use crate::cloud::Cloud;
use crate::error::Error;

/// Where an estimator writes; each slice holds one entry per particle, in the coordinates of the metric.
#[derive(Debug)]
pub struct Estimates<'a, const D: usize> {
    /// Gradient of log density.
    pub score: &'a mut [[f64; D]],
    /// Density `psi_i > 0`.
    pub density: &'a mut [f64],
    /// The volume `V_i` that the particle occupies in the eyes of the kernel: what sets its smoothing length,
    /// `h_i = h_0i (V_i / V_0i)^(1/D)` (Canor & Denoël 2013, eq 20).
    pub volume: &'a mut [f64],
}

/// An estimator of density and score, `grad log psi`, from particles and their masses.
///
/// It is pure in the cloud: the same cloud gives the same bits, for any number of threads.
pub trait ScoreEstimator<const D: usize>: std::fmt::Debug + Send {
    /// End of the kernel's support in units of the smoothing length.
    fn support(&self) -> f64;

    /// Which pairs it needs.
    fn criterion(&self) -> Criterion;

    /// Refuses a resolution at which it is known to fail, whatever the flow. Provided: none is refused.
    ///
    /// # Errors
    /// [`Error::SupportTooSmall`].
    fn check_resolution(&self, support_over_spacing: f64) -> Result<(), Error> {
        let _ = support_over_spacing;
        Ok(())
    }

    /// The mean number of neighbours, the particle itself included, below which a run has left its stable range.
    /// Provided: none.
    fn fewest_mean_neighbours(&self) -> f64 {
        0.0
    }

    /// Score, density and volume of every particle.
    ///
    /// # Errors
    /// Where the neighbours do not determine the estimate, naming step, time and particle.
    fn estimate(&self, cloud: &Cloud<'_, D>, out: &mut Estimates<'_, D>) -> Result<(), Error>;
}
