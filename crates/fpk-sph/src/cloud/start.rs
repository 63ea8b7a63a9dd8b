//! Initial particles: a lattice over the initial distribution, and their masses.

use particle_store::Lattice;
use sde_integrators::GaussianMixture;

use crate::cloud::metric::{Metric, Whitening};
use crate::cloud::reach::{ball_reach, box_reach, outside_ball};
use crate::error::{Error, finite, positive};

/// The lattice on which the particles start, centred on the mean of the initial distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InitialLattice<const D: usize> {
    /// A box in standard deviations of the initial distribution (its covariance whitened), end points included.
    Box {
        /// Half the edge, in standard deviations; 4 in the paper. A lattice that ends at `r` standard deviations carries
        /// no mass beyond: about 6e-5 at 4, 2e-9 at 6, 3e-12 at 7 along each axis.
        reach: f64,
        /// Particles along each axis.
        count: [usize; D],
    },
    /// A ball in standard deviations of the initial distribution: for `D >= 3`, where most of a box is empty corners.
    Ball {
        /// Its radius, in standard deviations.
        reach: f64,
        /// The spacing, in standard deviations.
        spacing: f64,
    },
    /// A box in the state's own coordinates (Canor & Denoël 2013: +-0.6 x +-0.4 with 50 x 33 particles).
    Rectangle {
        /// Half the edges, in the units of the state.
        half_width: [f64; D],
        /// Particles along each axis.
        count: [usize; D],
    },
}

/// Reach of a box in standard deviations where none is asked for.
pub const DEFAULT_REACH: f64 = 6.0;

impl<const D: usize> InitialLattice<D> {
    /// A box of [`DEFAULT_REACH`] with `count` particles along each axis.
    #[must_use]
    pub fn box_of(count: usize) -> Self {
        Self::Box { reach: DEFAULT_REACH, count: [count; D] }
    }

    /// A box that goes far enough for probabilities down to the given one: of a normal distribution it leaves at most
    /// [`MOST_OUTSIDE`](crate::MOST_OUTSIDE) of it outside.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for the probability.
    pub fn box_down_to(smallest_probability: f64, count: [usize; D]) -> Result<Self, Error> {
        Ok(Self::Box { reach: box_reach(D, smallest_probability)?, count })
    }

    /// A ball that goes far enough for probabilities down to the given one, as [`Self::box_down_to`]. The
    /// rim of its lattice is ragged, so that up to a fifth more lies outside its cells.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for the probability.
    pub fn ball_down_to(smallest_probability: f64, spacing: f64) -> Result<Self, Error> {
        Ok(Self::Ball { reach: ball_reach(D, smallest_probability)?, spacing })
    }

    /// Part of an absolute moment of order `k` that a normal distribution has beyond the lattice.
    ///
    /// Beyond a ball of `r` standard deviations it is `Q_{D+k}(r)`, the upper tail of the chi distribution with `D + k` components;
    /// beyond a box, of the worst axis, `1 - (1 - Q_{1+k}(r)) (1 - Q_1(r))^{D-1}`. In a linear system the part stays what it is, since
    /// its flow maps ellipsoids to ellipsoids. `deviations` are those of the states at the start. A distribution of several components
    /// counts as one of the same covariance.
    #[must_use]
    pub fn moment_outside(&self, deviations: &[f64; D], order: u32) -> f64 {
        let order = order as usize;
        let of_box = |reaches: [f64; D]| {
            let least = reaches.into_iter().fold(f64::INFINITY, f64::min);
            let inside: f64 = reaches.iter().map(|&r| 1.0 - outside_ball(1, r)).product();
            let [of_moment, of_mass] = [1 + order, 1].map(|n| 1.0 - outside_ball(n, least));
            1.0 - inside * of_moment / of_mass
        };
        match *self {
            Self::Ball { reach, .. } => outside_ball(D + order, reach),
            Self::Box { reach, .. } => of_box([reach; D]),
            Self::Rectangle { half_width, .. } => {
                of_box(std::array::from_fn(|k| half_width[k] / deviations[k]))
            }
        }
    }

    /// What a normal distribution has of a moment beyond the lattice, over what it has within: `f/(1 - f)` of the
    /// [part](Self::moment_outside) `f` beyond it. It is the relative error of a moment of the particles.
    #[must_use]
    pub fn moment_lacking(&self, deviations: &[f64; D], order: u32) -> f64 {
        let part = self.moment_outside(deviations, order);
        part / (1.0 - part)
    }
}

impl InitialLattice<2> {
    /// The lattice of Canor & Denoël 2013, section 4.1: 1,650 particles in a rectangle with the edges 1.2 and 0.8, which
    /// is 4 standard deviations of its initial density. The counts along the edges are not given; 50 x 33 is nearly square.
    pub const CANOR_DENOEL_2013: Self = Self::Rectangle { half_width: [0.6, 0.4], count: [50, 33] };
}

/// Particles at the start.
#[derive(Debug)]
pub(crate) struct Start<const D: usize> {
    pub(crate) positions: Vec<[f64; D]>,
    pub(crate) masses: Vec<f64>,
    /// Places on the lattice, in spacings.
    pub(crate) indices: Vec<[i32; D]>,
    /// Volume of a lattice cell in the units of the state.
    pub(crate) cell_volume: f64,
}

/// Fewest particles along an axis that can carry a gradient of a density and its one-sided differences.
const FEWEST_PER_AXIS: usize = 3;

impl<const D: usize> Start<D> {
    /// `mu_i = psi_0(x_i) dV` on the lattice (Canor & Denoël 2013, section 3.2).
    pub(crate) fn new(
        law: &GaussianMixture<D>,
        lattice: &InitialLattice<D>,
    ) -> Result<Self, Error> {
        const { assert!(D >= 1 && D <= 6, "the state has one to six components") };
        let (map, lattice) = match *lattice {
            InitialLattice::Box { reach, count } => {
                positive("reach", reach)?;
                (sigma_map(law)?, Lattice::box_lattice([reach; D], count)?)
            }
            InitialLattice::Ball { reach, spacing } => {
                positive("reach", reach)?;
                positive("spacing", spacing)?;
                (sigma_map(law)?, Lattice::ball_lattice(reach, spacing)?)
            }
            InitialLattice::Rectangle { half_width, count } => {
                for value in half_width {
                    positive("half_width", value)?;
                }
                (Whitening::shifted(law.mean()), Lattice::box_lattice(half_width, count)?)
            }
        };
        let limit = FEWEST_PER_AXIS.pow(u32::try_from(D).unwrap_or(u32::MAX));
        if lattice.points.len() < limit {
            return Err(Error::TooFewParticles {
                count: lattice.points.len(),
                limit,
                dimension: D,
            });
        }
        let start = Self::on(&map, lattice, law);
        finite("the sum of the masses on the lattice", start.masses.iter().sum())?;
        Ok(start)
    }

    fn on(map: &Whitening<D>, lattice: Lattice<D>, law: &GaussianMixture<D>) -> Self {
        let cell_volume = lattice.cell_volume() * map.determinant();
        let positions: Vec<[f64; D]> = lattice.points.iter().map(|y| map.unwhiten(y)).collect();
        let masses = positions.iter().map(|x| law.density(x) * cell_volume).collect();
        Self { positions, masses, indices: lattice.indices, cell_volume }
    }
}

/// From standard deviations of the law to the state.
fn sigma_map<const D: usize>(law: &GaussianMixture<D>) -> Result<Whitening<D>, Error> {
    Whitening::of_covariance(law.mean(), &law.covariance(), (0, 0.0))
}

/// The D-th root of the lattice's cell volume, in the coordinates of the metric.
pub(crate) fn initial_spacing<const D: usize>(
    start: &Start<D>,
    metric: Metric,
) -> Result<f64, Error> {
    let map = Whitening::of(metric, &start.positions, &start.masses, (0, 0.0))?;
    Ok((start.cell_volume / map.determinant()).powf(1.0 / D as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_moment_has_outside_is_its_integral_beyond() {
        // E[r^2; r > R] / E[r^2] = (1 + R^2/2) exp(-R^2/2) in the plane.
        let ball = InitialLattice::<2>::Ball { reach: 3.0, spacing: 0.5 };
        let exact = (1.0 + 4.5) * (-4.5_f64).exp();
        assert!((ball.moment_outside(&[1.0, 2.0], 2) / exact - 1.0).abs() < 1e-12);
        assert!((ball.moment_lacking(&[1.0, 2.0], 2) / exact * (1.0 - exact) - 1.0).abs() < 1e-12);
        // Along one axis E[x^2; |x| > R] = Q_1 + 2 R phi(R).
        let line = InitialLattice::<1>::Box { reach: 2.0, count: [9] };
        let density = (-2.0_f64).exp() / std::f64::consts::TAU.sqrt();
        let exact = outside_ball(1, 2.0) + 4.0 * density;
        assert!((line.moment_outside(&[1.0], 2) / exact - 1.0).abs() < 1e-12);
        let rectangle = InitialLattice::<2>::Rectangle { half_width: [2.0, 8.0], count: [9, 9] };
        let inside = (1.0 - exact) * (1.0 - outside_ball(1, 4.0));
        assert!((rectangle.moment_outside(&[1.0, 2.0], 2) - (1.0 - inside)).abs() < 1e-12);
    }
}
