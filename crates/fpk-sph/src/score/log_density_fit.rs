//! The better estimator: a local quadratic through the logarithms of volume densities.

use std::ops::Range;

use neighbour_search::Criterion;
use smoothing_kernels::{Kernel, Lucy};

use super::cell_geometry::{determinant, lattice_jacobian};
use super::fit_points::Points;
use super::monomials::{Monomials, unknowns};
use super::normal_equations::LANES;
use super::polynomial_fit::{LeastSquares, Scratch};
use super::{Degree, Estimates, Fits, ScoreEstimator};
use crate::cloud::Cloud;
use crate::error::Error;
use crate::parallel::{Failed, fill, for_each_fit, n_fit_parts};

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

/// Several fits side by side, solved: that of particle `first + lane` is in `lane`.
struct Solved<'a> {
    first: usize,
    equations: &'a LeastSquares,
    /// One over the length in which the offsets of each fit are measured.
    scale: &'a [f64],
}

impl<K> LogDensityFit<K> {
    /// The square of a distance beyond the support, which fills registers.
    fn beyond<const D: usize>(&self, h: f64) -> f64
    where
        K: Kernel<D>,
    {
        (2.0 * self.kernel.support() * h).powi(2)
    }

    /// The volume of particle `i` by the kernel sum.
    fn kernel_volume<const D: usize>(&self, cloud: &Cloud<'_, D>, i: usize) -> Result<f64, Error>
    where
        K: Kernel<D>,
    {
        let h = cloud.smoothing_lengths[i];
        let mut sum = self.kernel.value(0.0, h);
        for near in cloud.neighbours.of(i).chunks(TOGETHER) {
            let (mut squares, mut weights) = ([self.beyond::<D>(h); TOGETHER], [0.0; TOGETHER]);
            for (square, &j) in squares.iter_mut().zip(near) {
                *square = cloud.offset(i, j as usize).1;
            }
            let n = near.len().next_multiple_of(LANES);
            self.kernel.values(&squares[..n], h, &mut weights[..n])?;
            sum += weights[..n].iter().sum::<f64>();
        }
        Ok(1.0 / sum)
    }

    /// The volume of particle `i`; none where it has no lattice cell.
    fn volume_at<const D: usize>(
        &self,
        cloud: &Cloud<'_, D>,
        i: usize,
    ) -> Result<Option<f64>, Error>
    where
        K: Kernel<D>,
    {
        match self.volume {
            VolumeEstimate::KernelSum => self.kernel_volume(cloud, i).map(Some),
            VolumeEstimate::DeformedLattice => {
                let edges = lattice_jacobian(cloud.positions, cloud.lattice, i);
                Ok(edges.map(|edges| determinant(&edges).abs()))
            }
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
        fill(log_density, |i| match self.volume_at(cloud, i) {
            Ok(Some(volume)) => (cloud.masses[i] / volume).ln(),
            Ok(None) | Err(_) => f64::NAN,
        });
        let Some(particle) = log_density.iter().position(|value| !value.is_finite()) else {
            return Ok(());
        };
        if self.volume_at(cloud, particle)?.is_none() {
            return Err(Error::NoLatticeCell { particle });
        }
        let (step, time, value) = (cloud.step, cloud.time, log_density[particle]);
        Err(Error::LeftStableRange { step, time, particle, quantity: "log density", value })
    }

    /// The fits around some particles, given the log densities of all: as many side by side as share a degree, each group of
    /// which is handed over solved.
    fn fit<const D: usize>(
        &self,
        cloud: &Cloud<'_, D>,
        log_density: &[f64],
        particles: Range<usize>,
        Scratch { points, equations }: &mut Scratch,
        mut take: impl FnMut(&Solved<'_>),
    ) -> Result<Fits, Failed>
    where
        K: Kernel<D>,
    {
        let at = |particle: usize| move |error: Error| Failed { particle, error };
        let tables_of =
            |i: usize| self.tables(cloud, i, cloud.neighbours.of(i).len() + 1).map_err(at(i));
        let (mut all, mut first) = (Fits::default(), particles.start);
        while first < particles.end {
            let tables = tables_of(first)?;
            let asked = self.tables(cloud, first, usize::MAX).map_err(at(first))?.n_unknowns;
            equations.clear(tables);
            let (mut scale, mut n) = ([0.0; LANES], 0);
            while n < LANES
                && first + n < particles.end
                && tables_of(first + n)?.n_unknowns == tables.n_unknowns
            {
                let i = first + n;
                scale[n] = self.collect(cloud, log_density, i, points).map_err(at(i))?;
                equations.sum(n, points);
                n += 1;
            }
            for determined in &equations.solve()[..n] {
                all = all.and(Fits::of(tables.n_unknowns, asked, *determined));
            }
            take(&Solved { first, equations, scale: &scale[..n] });
            first += n;
        }
        Ok(all)
    }

    /// The particle itself and its neighbours as the points of a fit, offsets in units of the support, which keeps moments
    /// near unity; returns one over the support.
    fn collect<const D: usize>(
        &self,
        cloud: &Cloud<'_, D>,
        log_density: &[f64],
        i: usize,
        points: &mut Points,
    ) -> Result<f64, Error>
    where
        K: Kernel<D>,
    {
        let neighbours = cloud.neighbours.of(i);
        let n = neighbours.len() + 1;
        points.reset(n);
        let (own, f_own) = (&cloud.positions[i], log_density[i]);
        let (offsets, values) = points.columns::<D>();
        // The particle itself is the first.
        (0..D).for_each(|k| offsets[k][0] = 0.0);
        values[0] = 0.0;
        for (t, &j) in (1..).zip(neighbours) {
            let y = &cloud.positions[j as usize];
            for k in 0..D {
                offsets[k][t] = y[k] - own[k];
            }
            values[t] = log_density[j as usize] - f_own;
        }
        let h = cloud.smoothing_lengths[i];
        let scale = 1.0 / (self.kernel.support() * h);
        // What is fitted is the departure from the Gaussian of the cloud, log psi + |y|^2 / 2.
        points.measure(cloud.whitened.then_some(&own[..]), scale);
        let (squares, weights) = points.squares_and_weights(self.beyond::<D>(h));
        self.kernel.values(squares, h, weights)?;
        Ok(scale)
    }

    /// The polynomial that `count` points (with the particle itself) can carry: of the degree asked for where there are
    /// [`POINTS_PER_UNKNOWN`], else of the highest degree for which there are. A particle that even the linear one is too
    /// much for keeps the score of the whitened Gaussian: its departure from it is taken as constant.
    fn tables<const D: usize>(
        &self,
        cloud: &Cloud<'_, D>,
        i: usize,
        count: usize,
    ) -> Result<&'static Monomials, Error> {
        // Without a Gaussian to depart from, a linear fit has the slope alone: the quadratic is kept while it is determined.
        let needed = if cloud.whitened { POINTS_PER_UNKNOWN } else { 1.0 };
        let carried = Monomials::carried_by::<D>(count, self.degree.value(), needed);
        let linear = || Monomials::of_degree::<D>(1).filter(|linear| count > linear.n_unknowns);
        let constant = || Monomials::of_degree::<D>(0).filter(|_| cloud.whitened);
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
        let mut scratch = Scratch::new::<D>(self.tables(cloud, 0, usize::MAX)?);
        let mut fits = Vec::with_capacity(n);
        let take = |solved: &Solved<'_>| {
            for (lane, scale) in solved.scale.iter().enumerate() {
                let i = solved.first + lane;
                let hessian = solved.equations.hessian::<D>(lane);
                let mut fit = LocalFit {
                    log_density: log_density[i],
                    gradient: solved.equations.gradient(lane).map(|g: f64| g * scale),
                    hessian: hessian.map(|row| row.map(|value| value * scale * scale)),
                };
                if cloud.whitened {
                    for k in 0..D {
                        fit.gradient[k] -= cloud.positions[i][k];
                        fit.hessian[k][k] -= 1.0;
                    }
                }
                fits.push(fit);
            }
        };
        self.fit(cloud, &log_density, 0..n, &mut scratch, take).map_err(|failed| failed.error)?;
        Ok(fits)
    }
}

/// Neighbours whose kernel is taken at once.
const TOGETHER: usize = 64;

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
            for near in cloud.neighbours.of(i).chunks(TOGETHER) {
                let (mut squares, mut along) = ([self.beyond::<D>(h); TOGETHER], [0.0; TOGETHER]);
                for (t, &j) in near.iter().enumerate() {
                    let (offset, square) = cloud.offset(i, j as usize);
                    let other = &velocities[j as usize];
                    squares[t] = square;
                    for k in 0..D {
                        along[t] += offset[k] * (other[k] - own[k]);
                    }
                }
                let (n, mut factors) = (near.len().next_multiple_of(LANES), [0.0; TOGETHER]);
                if self.kernel.gradient_factors(&squares[..n], h, &mut factors[..n]).is_err() {
                    return f64::NAN;
                }
                for t in 0..n {
                    parting -= factors[t] * along[t];
                    total -= factors[t] * squares[t];
                }
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
        let scratch = &mut out.carried.scratch;
        scratch.resize_with(n_fit_parts(cloud.n_particles()), || Scratch::new::<D>(tables));
        out.fits = for_each_fit(
            &mut out.score,
            &mut out.volume,
            scratch,
            |scratch, first, score, volume| {
                let particles = first..first + score.len();
                self.fit(cloud, log_density, particles, scratch, |solved| {
                    for (lane, scale) in solved.scale.iter().enumerate() {
                        let (i, at) = (solved.first + lane, solved.first + lane - first);
                        score[at] = solved.equations.gradient(lane).map(|g: f64| g * scale);
                        if cloud.whitened {
                            for k in 0..D {
                                score[at][k] -= cloud.positions[i][k];
                            }
                        }
                        volume[at] = 1.0 / solved.equations.weight(lane);
                    }
                })
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
