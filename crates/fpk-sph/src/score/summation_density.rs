//! The paper's estimator: summation density with the gradient of its kernels.

use neighbour_search::Criterion;
use smoothing_kernels::{Kernel, Lucy, power};

use super::{Estimates, ScoreEstimator};
use crate::cloud::Cloud;
use crate::error::Error;
use crate::parallel::is_shared;

/// Summation density (Canor & Denoël 2013, eq 15, 19 with the reciprocal average of eq 23):
///
/// $$ \langle\psi_i\rangle = \sum_j \mu_j W_{ij}, \quad \langle\nabla\psi_i\rangle = \sum_j \mu_j \nabla_i W_{ij},
/// \quad W_{ij} = \tfrac12 \left( W(r_{ij}, h_i) + W(r_{ij}, h_j) \right). $$
///
/// The sum includes the particle itself. It estimates the density smoothed by the kernel: for a Gaussian of standard
/// deviation `sigma` the score is too weak by `1 / (1 + kappa (h / sigma)^2)`, `kappa = 0.0893` for Lucy's kernel in 2-D.
#[derive(Debug, Clone, Copy, Default)]
pub struct SummationDensity<K = Lucy> {
    /// The kernel.
    pub kernel: K,
}

impl<K: Kernel<D>, const D: usize> ScoreEstimator<D> for SummationDensity<K> {
    fn support(&self) -> f64 {
        self.kernel.support()
    }

    fn criterion(&self) -> Option<Criterion> {
        Some(Criterion::Max)
    }

    fn estimate(&self, cloud: &Cloud<'_, D>, out: &mut Estimates<D>) -> Result<(), Error> {
        let normalisation = self.kernel.normalisation();
        for_each_particle(out, |i| {
            let h_i = cloud.smoothing_lengths[i];
            let mut psi =
                cloud.masses[i] * normalisation / power::<D>(h_i) * self.kernel.shape(0.0);
            let mut gradient = [0.0; D];
            for &j in cloud.neighbours.of(i) {
                let j = j as usize;
                let (x_ji, r_squared) = cloud.offset(i, j);
                let r = r_squared.sqrt();
                let (mut w, mut dw) = (0.0, 0.0);
                for h in [h_i, cloud.smoothing_lengths[j]] {
                    let scale = 0.5 * normalisation / power::<D>(h);
                    w += scale * self.kernel.shape(r / h);
                    dw += scale / h * self.kernel.shape_derivative(r / h);
                }
                psi += cloud.masses[j] * w;
                if r > 0.0 {
                    for k in 0..D {
                        // x_i - x_j = -x_ji.
                        gradient[k] -= cloud.masses[j] * dw * x_ji[k] / r;
                    }
                }
            }
            for value in &mut gradient {
                *value /= psi;
            }
            (gradient, psi, cloud.masses[i] / psi)
        });
        Ok(())
    }
}

/// `(score, density, volume)[i] = value(i)`.
fn for_each_particle<const D: usize>(
    out: &mut Estimates<D>,
    value: impl Fn(usize) -> ([f64; D], f64, f64) + Sync,
) {
    let write = |i: usize, score: &mut [f64; D], density: &mut f64, volume: &mut f64| {
        (*score, *density, *volume) = value(i);
    };
    #[cfg(feature = "rayon")]
    if is_shared(out.score.len()) {
        use crate::parallel::BLOCK;
        use rayon::prelude::*;
        return out
            .score
            .par_iter_mut()
            .zip(out.density.par_iter_mut())
            .zip(out.volume.par_iter_mut())
            .enumerate()
            .with_min_len(BLOCK)
            .for_each(|(i, ((score, density), volume))| write(i, score, density, volume));
    }
    for i in 0..out.score.len() {
        write(i, &mut out.score[i], &mut out.density[i], &mut out.volume[i]);
    }
}
