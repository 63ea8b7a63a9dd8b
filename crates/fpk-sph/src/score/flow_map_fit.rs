//! The estimator that follows the flow: local polynomials over the lattice that the particles started from.

use neighbour_search::Criterion;

use super::cell_geometry::determinant;
use super::log_density_fit::lattice_distances;
use super::monomials::{Monomials, unknowns};
use super::small_matrices::{eigen, solve_transposed};
use super::stencils::Stencils;
use super::{Degree, Estimates, LatticePlaces, LocalMap, ScoreEstimator};
use crate::cloud::Cloud;
use crate::error::Error;
use crate::parallel::fill;

/// Density and score from the flow map `y(X)`, where `X` are places on the lattice of the start. With the deformation
/// gradient `F = dy/dX`, in spacings, and masses that never change,
///
/// $$ \psi(y(X)) = \frac{\mu(X)}{\det F(X)}, \qquad
/// \nabla\log\psi = -y + F^{-T} \nabla_X \left( \log\psi + \tfrac12 |y|^2 \right), $$
///
/// in whitened coordinates. Both derivatives are those of local polynomials over the lattice neighbours, whose weights are
/// computed once: no search, no equations to solve in a step. What is differentiated is the departure from the cloud's
/// Gaussian, so a Gaussian is carried without error of space by any lattice.
///
/// * At the rim, where neighbours lie on one side, the departure's gradient is the mean of those further inside: one-sided
///   gradients of one-sided gradients let modes at the rim grow.
/// * Across a cell that the flow has made thinner than `thinnest` spacings, the departure's gradient is damped: the fit
///   degrades in the collapsed direction only, and the step does not collapse with it.
/// * A cell that is turned over, or smaller than [`SMALLEST_CELL`] of those around it, is not resolved: it takes its
///   departure and deformation from its neighbours. [`Estimates::unresolved`] counts such cells with their mass.
///
/// A total Lagrangian method; the source is this project.
#[derive(Debug, Clone, Default)]
pub struct FlowMapFit<const D: usize> {
    degree: usize,
    /// Spacing in the metric at the start.
    spacing: f64,
    /// Square of the length that the diffusion limit holds against, in spacings.
    resolved: f64,
    thinnest: f64,
    stencils: Stencils<D>,
}

/// Means over resolved cells, for one that is not.
struct Taken<const D: usize> {
    i: usize,
    departure: f64,
    deformation: [[f64; D]; D],
    volume: f64,
}

/// Trace of the diffusion matrix on the lattice times step times the steepest gradient's square is at most this times the
/// scheme's diffusion limit: 2.6 for Runge-Kutta 4, whose interval ends at 2.785. The cubic over 2.8 spacings in 2-D would
/// have 3.7 with its reach alone.
const WAVE_DAMPING: f64 = 10.4;

/// A cell smaller than this part of the mean of those around it is not resolved.
pub const SMALLEST_CELL: f64 = 0.135;

impl<const D: usize> FlowMapFit<D> {
    /// An estimator of the given degree that resolves cells down to `thinnest` spacings.
    #[must_use]
    pub fn new(degree: Degree, thinnest: f64) -> Self {
        Self { degree: degree.value(), thinnest, ..Self::default() }
    }

    /// `F` of every particle.
    fn deformations(&self, y: &[[f64; D]], deformation: &mut [[[f64; D]; D]]) {
        fill(deformation, |i| {
            let stencil = self.stencils.of(i);
            let mut f = [[0.0; D]; D];
            for (&j, weight) in stencil.members.iter().zip(&stencil.weights.gradient) {
                let y_j = &y[j as usize];
                for k in 0..D {
                    for l in 0..D {
                        f[k][l] += y_j[k] * weight[l];
                    }
                }
            }
            f
        });
    }

    /// Whether the cell of particle `i` is upright and no smaller than [`SMALLEST_CELL`] of those around it.
    fn is_resolved(&self, volume: &[f64], i: usize) -> bool {
        let stencil = self.stencils.of(i);
        let (mut mean, mut total) = (0.0, 0.0);
        for (&j, weight) in stencil.members.iter().zip(&stencil.weights.mean) {
            let v = volume[j as usize];
            if v > 0.0 {
                mean += weight * v;
                total += weight;
            }
        }
        volume[i] > 0.0 && volume[i] * total > SMALLEST_CELL * mean
    }

    /// What particle `i`, whose cell is not resolved, takes from those of its members that are.
    fn mean_of_resolved(
        &self,
        i: usize,
        cloud: &Cloud<'_, D>,
        out: &Estimates<D>,
    ) -> Result<Taken<D>, Error> {
        let stencil = self.stencils.of(i);
        let mut taken = Taken { i, departure: 0.0, deformation: [[0.0; D]; D], volume: 0.0 };
        let mut total = 0.0;
        for (&j, weight) in stencil.members.iter().zip(&stencil.weights.mean) {
            let j = j as usize;
            if out.density[j].is_nan() {
                continue;
            }
            total += weight;
            taken.departure += weight * out.density[j];
            taken.volume += weight * out.volume[j];
            for k in 0..D {
                for l in 0..D {
                    taken.deformation[k][l] += weight * out.deformation[j][k][l];
                }
            }
        }
        if total == 0.0 {
            let (step, time, value) = (cloud.step, cloud.time, out.volume[i]);
            let quantity = "cell volume";
            return Err(Error::LeftStableRange { step, time, particle: i, quantity, value });
        }
        taken.departure /= total;
        taken.volume /= total;
        taken.deformation = taken.deformation.map(|row| row.map(|value| value / total));
        Ok(taken)
    }

    /// `F^-T g`, damped across the cell where it is thinner than the thinnest.
    fn push_forward(&self, f: &[[f64; D]; D], g: &[f64; D]) -> [f64; D] {
        let least = self.thinnest * self.spacing;
        // det F is at most the smallest singular value times the Frobenius norm to the power D - 1, over a constant.
        let norm_squared: f64 = f.as_flattened().iter().map(|value| value * value).sum();
        let bound =
            determinant(f) / (norm_squared / (D.max(2) - 1) as f64).powf(0.5 * (D as f64 - 1.0));
        if bound > least {
            return solve_transposed(f, g);
        }
        // F F^T = sum_m s_m^2 v_m v_m^T and F^-T g = sum_m v_m (v_m . F g) / s_m^2.
        let (mut square, mut fg) = ([[0.0; D]; D], [0.0; D]);
        for k in 0..D {
            for l in 0..D {
                square[k][l] = (0..D).map(|m| f[k][m] * f[l][m]).sum();
                fg[k] += f[k][l] * g[l];
            }
        }
        let (values, vectors) = eigen(square);
        let mut out = [0.0; D];
        for m in 0..D {
            let along: f64 = (0..D).map(|k| vectors[k][m] * fg[k]).sum();
            for k in 0..D {
                out[k] += vectors[k][m] * along / values[m].max(least * least);
            }
        }
        out
    }

    /// Gradients of the departure with respect to `y`: by the local polynomial inside, from the inside outward at the rim.
    fn gradients(&self, departure: &[f64], deformation: &[[[f64; D]; D]], out: &mut [[f64; D]]) {
        fill(out, |i| {
            if self.stencils.at_rim(i) {
                [0.0; D]
            } else {
                self.push_forward(&deformation[i], &self.stencils.of(i).gradient_of(departure))
            }
        });
        for i in self.stencils.rim() {
            let stencil = self.stencils.of(i);
            let (mut mean, mut total) = ([0.0; D], 0.0);
            for (&j, weight) in stencil.members.iter().zip(&stencil.weights.mean) {
                let j = j as usize;
                if self.stencils.is_before(j, i) {
                    total += weight;
                    for k in 0..D {
                        mean[k] += weight * out[j][k];
                    }
                }
            }
            out[i] = mean.map(|value| value / total);
        }
    }
}

/// `|y|^2 / 2`: minus the logarithm of the unit Gaussian, but for a constant.
fn half_square<const D: usize>(y: &[f64; D]) -> f64 {
    0.5 * y.iter().map(|c| c * c).sum::<f64>()
}

impl<const D: usize> ScoreEstimator<D> for FlowMapFit<D> {
    fn support(&self) -> f64 {
        1.0
    }

    fn criterion(&self) -> Option<Criterion> {
        None
    }

    /// Refuses a neighbourhood that cannot carry the degree inside the lattice.
    fn check_resolution(&self, support_over_spacing: f64) -> Result<(), Error> {
        let count = lattice_distances::<D>(support_over_spacing).count() + 1;
        let carried = Monomials::<D>::carried_by(count, self.degree, 1.5);
        match Monomials::<D>::of_degree(self.degree) {
            None => Err(Error::DegreeTooHigh { degree: self.degree, dimension: D }),
            Some(asked) if carried.is_none_or(|found| found.n_unknowns < asked.n_unknowns) => {
                let limit = unknowns(D, self.degree) * 3 / 2;
                Err(Error::SupportTooSmall {
                    ratio: support_over_spacing,
                    count,
                    limit,
                    dimension: D,
                })
            }
            Some(_) => Ok(()),
        }
    }

    fn start(&mut self, lattice: &LatticePlaces<'_, D>) -> Result<(), Error> {
        self.spacing = lattice.spacing;
        self.stencils =
            Stencils::new(lattice.places, lattice.neighbours, lattice.reach, self.degree)?;
        let steepest = self.stencils.steepest_wave(lattice.places);
        self.resolved = lattice.reach.powi(2).min(WAVE_DAMPING / steepest.powi(2));
        Ok(())
    }

    fn estimate(&self, cloud: &Cloud<'_, D>, out: &mut Estimates<D>) -> Result<(), Error> {
        let (y, masses) = (cloud.positions, cloud.masses);
        self.deformations(y, &mut out.deformation);
        fill(&mut out.volume, |i| determinant(&out.deformation[i]));
        // The departure of what is not resolved is NaN until its neighbours have given theirs.
        let volume = &out.volume;
        fill(&mut out.density, |i| {
            if self.is_resolved(volume, i) {
                (masses[i] / volume[i]).ln() + half_square(&y[i])
            } else {
                f64::NAN
            }
        });
        out.fits = self.stencils.fits;
        let mut unresolved = Vec::new();
        for i in 0..y.len() {
            if out.density[i].is_nan() {
                unresolved.push(self.mean_of_resolved(i, cloud, out)?);
                out.unresolved.add(i, masses);
            }
        }
        for Taken { i, departure, deformation, volume } in unresolved {
            (out.density[i], out.deformation[i], out.volume[i]) = (departure, deformation, volume);
        }
        self.gradients(&out.density, &out.deformation, &mut out.score);
        for (score, y) in out.score.iter_mut().zip(y) {
            for k in 0..D {
                score[k] -= y[k];
            }
        }
        fill(&mut out.density, |i| masses[i] / out.volume[i]);
        Ok(())
    }

    /// `trace(F^-1 D F^-T)` over the square of a length on the lattice, with cells no thinner than the thinnest. A wave
    /// decays at the rate of that trace times the square of what the gradient makes of it, which must stay within the
    /// stability interval of the scheme: the length is the reach, or less where the gradient is steeper.
    fn spread(&self, diffusion: &[[f64; D]; D], _: f64, deformation: &[[f64; D]; D]) -> f64 {
        let trace: f64 = (0..D).map(|k| diffusion[k][k]).sum();
        let transposed = std::array::from_fn(|k| std::array::from_fn(|l| deformation[l][k]));
        // A = F^-1 D, then trace(A F^-T) = trace(F^-1 A^T).
        let mut half = [[0.0; D]; D];
        for l in 0..D {
            let column = std::array::from_fn(|k| diffusion[k][l]);
            let solved = solve_transposed(&transposed, &column);
            for k in 0..D {
                half[k][l] = solved[k];
            }
        }
        let across: f64 = (0..D).map(|k| solve_transposed(&transposed, &half[k])[k]).sum();
        let most = trace / (self.thinnest * self.spacing).powi(2);
        across.min(most).max(0.0) / self.resolved
    }

    fn settle(&self, x: &mut [[f64; D]], before: &mut [[f64; D]], part: f64) {
        before.copy_from_slice(x);
        let before = &*before;
        fill(x, |i| {
            let stencil = self.stencils.of(i);
            let mut fitted = [0.0; D];
            for (&j, weight) in stencil.members.iter().zip(&stencil.weights.value) {
                for k in 0..D {
                    fitted[k] += weight * before[j as usize][k];
                }
            }
            std::array::from_fn(|k| before[i][k] + part * (fitted[k] - before[i][k]))
        });
    }

    fn local_maps(&self, cloud: &Cloud<'_, D>) -> Option<Vec<LocalMap<D>>> {
        let log_mass: Vec<f64> = cloud.masses.iter().map(|mu| mu.ln()).collect();
        let map = |i: usize| {
            let stencil = self.stencils.of(i);
            let mut map = LocalMap {
                edges: [[0.0; D]; D],
                curvature: [[[0.0; D]; D]; D],
                slope: stencil.gradient_of(&log_mass),
                bend: [[0.0; D]; D],
                resolved: true,
            };
            for (p, &j) in stencil.members.iter().enumerate() {
                let (j, hessian) = (j as usize, &stencil.weights.hessian[p]);
                for k in 0..D {
                    for l in 0..D {
                        map.edges[k][l] += cloud.positions[j][k] * stencil.weights.gradient[p][l];
                        map.bend[k][l] += log_mass[j] * hessian[k][l];
                        for m in 0..D {
                            map.curvature[m][k][l] += cloud.positions[j][m] * hessian[k][l];
                        }
                    }
                }
            }
            map
        };
        let mut maps: Vec<_> = (0..cloud.n_particles()).map(map).collect();
        let volume: Vec<f64> = maps.iter().map(|map| determinant(&map.edges)).collect();
        for (i, map) in maps.iter_mut().enumerate() {
            map.resolved = self.is_resolved(&volume, i);
        }
        Some(maps)
    }
}
