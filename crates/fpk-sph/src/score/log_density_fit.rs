//! The better estimator: a local quadratic through the logarithms of volume densities.

use neighbour_search::Criterion;
use smoothing_kernels::{Kernel, Lucy};

use super::cell_geometry::{determinant, lattice_jacobian};
use super::monomials::{Monomials, unknowns};
use super::polynomial_fit::{LANES, LeastSquares};
use super::{Degree, Estimates, Fits, ScoreEstimator};
use crate::cloud::Cloud;
use crate::error::Error;
use crate::parallel::{fill, for_each_fit};

/// How the volume of a particle is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VolumeEstimate {
    /// `V_i = 1 / sum_j W(r_ij, h_i)`, itself included. Needs no memory of the lattice; the outer layers, with
    /// neighbours on one side only, come out too large, by a factor of 2.2 at a corner once `h` has been iterated.
    KernelSum,
    /// `V_i = |det dx/dX| dX^D`, the volume of the lattice cell as the flow has deformed it, by finite differences over
    /// lattice neighbours. Right at the rim too and exact for an affine flow. A particle of which neither itself nor
    /// a lattice neighbour has one along some axis is an error.
    DeformedLattice,
}

/// Weighted least squares of log density: with the volume density `psi_i = mu_i / V_i`,
///
/// $$ \min_{c, g, H} \sum_j W(r_{ij}, h_i) \left( c + g \cdot u_j + \tfrac12 u_j \cdot H u_j - \log\psi_j \right)^2,
/// \qquad u_j = y_j - y_i, $$
///
/// over the particle and its neighbours; the score is `g`. Exact where `log psi` is quadratic and the volumes are
/// right, so a Gaussian is carried without error of space.
///
/// Needs `support_radius / spacing >= 2.4` in 2-D: 20 neighbours on the undisturbed lattice whose weight counts. Less is
/// refused: at 2.25 a run would degrade.
#[derive(Debug, Clone, Copy)]
pub struct LogDensityFit<K = Lucy> {
    /// The kernel, as weight and in the kernel sum.
    pub kernel: K,
    /// How volumes are found.
    pub volume: VolumeEstimate,
    /// Degree of the polynomial.
    pub degree: Degree,
}

/// The quadratic fitted around one particle, in the coordinates of the metric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalFit<const D: usize> {
    /// `log psi` at the particle by its volume, `log(mu_i / V_i)`.
    pub log_density: f64,
    /// Gradient of log density.
    pub gradient: [f64; D],
    /// Second derivatives of log density.
    pub hessian: [[f64; D]; D],
}

/// What a fit around a particle left besides its coefficients, with the sum of the weights that it met on the way.
struct Fitted {
    /// One over the length in which offsets were measured.
    scale: f64,
    kernel_sum: f64,
    fits: Fits,
}

impl<K> LogDensityFit<K> {
    /// The volume of particle `i` by the kernel sum.
    fn kernel_volume<const D: usize>(&self, cloud: &Cloud<'_, D>, i: usize) -> f64
    where
        K: Kernel<D>,
    {
        let h = cloud.smoothing_lengths[i];
        let value_at = |j: u32| self.kernel.value(cloud.offset(i, j as usize).1.sqrt(), h);
        let others: f64 = cloud.neighbours.of(i).iter().map(|&j| value_at(j)).sum();
        1.0 / (self.kernel.value(0.0, h) + others)
    }

    /// The volume of particle `i`; none where it has no lattice cell.
    fn volume_at<const D: usize>(&self, cloud: &Cloud<'_, D>, i: usize) -> Option<f64>
    where
        K: Kernel<D>,
    {
        match self.volume {
            VolumeEstimate::KernelSum => Some(self.kernel_volume(cloud, i)),
            VolumeEstimate::DeformedLattice => lattice_jacobian(cloud.positions, cloud.lattice, i)
                .map(|edges| determinant(&edges).abs()),
        }
    }

    /// `log(mu_i / V_i)` of every particle.
    fn log_densities<const D: usize>(
        &self,
        cloud: &Cloud<'_, D>,
        log_density: &mut [f64],
    ) -> Result<(), Error>
    where
        K: Kernel<D>,
    {
        // A particle without a volume is NaN here and named below.
        fill(log_density, |i| {
            self.volume_at(cloud, i).map_or(f64::NAN, |volume| (cloud.masses[i] / volume).ln())
        });
        let Some(particle) = log_density.iter().position(|value| !value.is_finite()) else {
            return Ok(());
        };
        if self.volume_at(cloud, particle).is_none() {
            return Err(Error::NoLatticeCell { particle });
        }
        let (step, time, value) = (cloud.step, cloud.time, log_density[particle]);
        Err(Error::LeftStableRange { step, time, particle, quantity: "log density", value })
    }

    /// The fit around particle `i`, given the log densities of all, in units of the reach that is returned.
    fn fit<const D: usize>(
        &self,
        cloud: &Cloud<'_, D>,
        log_density: &[f64],
        i: usize,
        equations: &mut LeastSquares<D>,
    ) -> Result<Fitted, Error>
    where
        K: Kernel<D>,
    {
        let neighbours = cloud.neighbours.of(i);
        let count = neighbours.len() + 1;
        let asked = self.tables(cloud, i, usize::MAX)?.n_unknowns;
        equations.clear(self.tables(cloud, i, count)?);
        let h = cloud.smoothing_lengths[i];
        // Offsets in units of the support keep the moments near unity whatever the scale.
        let scale = 1.0 / (self.kernel.support() * h);
        let (mut u, mut f) = ([[0.0; LANES]; D], [0.0; LANES]);
        let own = self.kernel.value(0.0, h);
        let mut weights = [0.0; LANES];
        weights[0] = own;
        equations.add(&u, &weights, &f);
        let mut kernel_sum = own;
        for block in neighbours.chunks(LANES) {
            let mut r_squared = [f64::INFINITY; LANES];
            for (lane, &j) in block.iter().enumerate() {
                let j = j as usize;
                let (offset, square) = cloud.offset(i, j);
                for k in 0..D {
                    u[k][lane] = offset[k] * scale;
                }
                f[lane] =
                    log_density[j] - log_density[i] + departure(cloud, j) - departure(cloud, i);
                r_squared[lane] = square;
            }
            let n = block.len();
            self.kernel.values(&r_squared[..n], h, &mut weights[..n])?;
            weights[n..].fill(0.0);
            kernel_sum += weights.iter().sum::<f64>();
            equations.add(&u, &weights, &f);
        }
        let fits = Fits::of(equations.n_unknowns(), asked, equations.solve());
        Ok(Fitted { scale, kernel_sum, fits })
    }

    /// The polynomial that `count` points (with the particle itself) can carry: of the degree asked for where there are
    /// [`POINTS_PER_UNKNOWN`], else of the highest degree for which there are. A particle that even the linear one is too
    /// much for keeps the score of the whitened Gaussian: its departure from it is taken as constant.
    fn tables<const D: usize>(
        &self,
        cloud: &Cloud<'_, D>,
        i: usize,
        count: usize,
    ) -> Result<&'static Monomials<D>, Error> {
        // Without a Gaussian to depart from, a linear fit has the slope alone: the quadratic is kept while it is determined.
        let needed = if cloud.whitened { POINTS_PER_UNKNOWN } else { 1.0 };
        let carried = Monomials::carried_by(count, self.degree.value(), needed);
        let linear = || Monomials::of_degree(1).filter(|linear| count > linear.n_unknowns);
        let constant = || Monomials::of_degree(0).filter(|_| cloud.whitened);
        carried.or_else(linear).or_else(constant).ok_or(Error::TooFewNeighbours {
            step: cloud.step,
            time: cloud.time,
            particle: i,
            count,
            limit: unknowns(D, 1) + 1,
        })
    }

    /// The fit around every particle, for observables that integrate the density.
    ///
    /// # Errors
    /// [`Error::TooFewNeighbours`], [`Error::LeftStableRange`] for the first such particle.
    pub fn local_fits<const D: usize>(
        &self,
        cloud: &Cloud<'_, D>,
    ) -> Result<Vec<LocalFit<D>>, Error>
    where
        K: Kernel<D>,
    {
        let n = cloud.n_particles();
        let mut log_density = vec![0.0; n];
        self.log_densities(cloud, &mut log_density)?;
        let mut equations = LeastSquares::new(self.tables(cloud, 0, usize::MAX)?);
        (0..n)
            .map(|i| {
                let Fitted { scale, .. } = self.fit(cloud, &log_density, i, &mut equations)?;
                let mut hessian = [[0.0; D]; D];
                if equations.n_unknowns() >= unknowns(D, 2) {
                    hessian = equations.hessian().map(|row| row.map(|value| value * scale * scale));
                }
                let mut gradient = equations.gradient().map(|g| g * scale);
                if cloud.whitened {
                    for k in 0..D {
                        gradient[k] -= cloud.positions[i][k];
                        hessian[k][k] -= 1.0;
                    }
                }
                Ok(LocalFit { log_density: log_density[i], gradient, hessian })
            })
            .collect()
    }
}

fn departure<const D: usize>(cloud: &Cloud<'_, D>, i: usize) -> f64 {
    if cloud.whitened { 0.5 * cloud.positions[i].iter().map(|y| y * y).sum::<f64>() } else { 0.0 }
}

/// Points per unknown below which a fit is of a lower degree.
const POINTS_PER_UNKNOWN: f64 = 3.0;

impl<K: Kernel<D>, const D: usize> ScoreEstimator<D> for LogDensityFit<K> {
    fn support(&self) -> f64 {
        self.kernel.support()
    }

    fn criterion(&self) -> Option<Criterion> {
        Some(Criterion::Gather)
    }

    /// Counts the neighbours of an undisturbed lattice whose weight is at least a thousandth of the particle's own: those
    /// that the fit sees. 20 in 2-D, from a ratio of 2.4 on.
    fn check_resolution(&self, support_over_spacing: f64) -> Result<(), Error> {
        let (ratio, limit, dimension) = (support_over_spacing, fewest_neighbours(D), D);
        let spacing_in_h = <K as Kernel<D>>::support(&self.kernel) / ratio;
        let least = SMALLEST_WEIGHT * self.kernel.shape(0.0);
        let count = lattice_distances::<D>(ratio)
            .filter(|r| self.kernel.shape(r * spacing_in_h) >= least)
            .count();
        if count < limit {
            Err(Error::SupportTooSmall { ratio, count, limit, dimension })
        } else {
            Ok(())
        }
    }

    /// `D_y / R^2`, times 2.6 from the cubic on: its gradient is that much steeper.
    fn spread(&self, diffusion: &[[f64; D]; D], radius: f64, _: &[[f64; D]; D]) -> f64 {
        let trace: f64 = (0..D).map(|k| diffusion[k][k]).sum();
        let steepness = if self.degree == Degree::Quadratic { 1.0 } else { CUBIC_STEEPNESS };
        steepness * trace / radius.powi(2)
    }

    /// The rate at which the kernel sum keeps its value, `sum_j W(r_ij, h_i) = (h_0i / h_i)^D sum_j W_0ij`:
    ///
    /// $$ \frac{d \log h_i}{dt} = \frac{\sum_j w_{ij}\, \dot r_{ij} / r_{ij}}{\sum_j w_{ij}}, \qquad
    /// w_{ij} = - r_{ij} \frac{\partial W}{\partial r}(r_{ij}, h_i) . $$
    fn smoothing_rates(&self, cloud: &Cloud<'_, D>, velocities: &[[f64; D]], rates: &mut Vec<f64>) {
        rates.resize(cloud.n_particles(), 0.0);
        fill(rates, |i| {
            let (h, own) = (cloud.smoothing_lengths[i], &velocities[i]);
            let (mut parting, mut total) = (0.0, 0.0);
            for &j in cloud.neighbours.of(i) {
                let (offset, square) = cloud.offset(i, j as usize);
                let weight = -self.kernel.gradient_factor(square.sqrt(), h);
                let other = &velocities[j as usize];
                for k in 0..D {
                    parting += weight * offset[k] * (other[k] - own[k]);
                }
                total += weight * square;
            }
            if total > 0.0 { parting / total } else { 0.0 }
        });
    }

    fn fewest_mean_neighbours(&self) -> f64 {
        0.75 * fewest_neighbours(D) as f64
    }

    fn estimate(&self, cloud: &Cloud<'_, D>, out: &mut Estimates<D>) -> Result<(), Error> {
        self.log_densities(cloud, &mut out.density)?;
        let log_density = &out.density;
        let tables = self.tables(cloud, 0, usize::MAX)?;
        out.fits = for_each_fit(
            &mut out.score,
            &mut out.volume,
            || LeastSquares::new(tables),
            |equations, i| {
                let Fitted { scale, kernel_sum, fits } =
                    self.fit(cloud, log_density, i, equations)?;
                let mut gradient = equations.gradient().map(|g| g * scale);
                if cloud.whitened {
                    for k in 0..D {
                        gradient[k] -= cloud.positions[i][k];
                    }
                }
                Ok((gradient, 1.0 / kernel_sum, fits))
            },
        )?;
        for value in &mut out.density {
            *value = value.exp();
        }
        for i in 0..cloud.n_particles() {
            if cloud.neighbours.of(i).len() < unknowns(D, 1) {
                out.unresolved.add(i, cloud.masses);
            }
        }
        Ok(())
    }
}

/// A wave on a square lattice decays at the rate `D_y g(theta) sin(theta)`, with `g` what the fit's gradient and `sin` what
/// the volume's differences make of it. The largest of that, in units of `D_y / R^2`, is 5.4 for the quadratic over 2.5
/// spacings, for which the limit was measured, and 14 for the cubic over 3.5; the quartic has the gradient of the cubic.
const CUBIC_STEEPNESS: f64 = 2.6;

/// Weight of a neighbour, relative to the particle's own, below which the fit does not see it.
const SMALLEST_WEIGHT: f64 = 1e-3;

/// Neighbours on the undisturbed lattice that the fit needs, itself excluded. Measured in 2-D and 3-D: 20 and 45 hold,
/// fewer degrade; elsewhere three points per unknown.
fn fewest_neighbours(dimension: usize) -> usize {
    match dimension {
        1 => 4,
        2 => 20,
        3 => 45,
        _ => 3 * unknowns(dimension, 2),
    }
}

/// Lengths of the points of the unit lattice up to `reach`, the origin excluded.
pub(super) fn lattice_distances<const D: usize>(reach: f64) -> impl Iterator<Item = f64> {
    // More than 64 spacings make no difference to a count against tens.
    let half = (1..=64).take_while(|&k| f64::from(k) <= reach).last().unwrap_or(0);
    let edge = 2 * half + 1;
    let total = (0..D).fold(1_i32, |product, _| product.saturating_mul(edge));
    (0..total).filter_map(move |index| {
        let (mut rest, mut square) = (index, 0);
        for _ in 0..D {
            let coordinate = rest % edge - half;
            square += coordinate * coordinate;
            rest /= edge;
        }
        let distance = f64::from(square).sqrt();
        (square > 0 && distance <= reach).then_some(distance)
    })
}

impl Default for LogDensityFit<Lucy> {
    fn default() -> Self {
        Self { kernel: Lucy, volume: VolumeEstimate::DeformedLattice, degree: Degree::Quadratic }
    }
}
