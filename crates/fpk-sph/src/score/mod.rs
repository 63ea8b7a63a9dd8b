//! Score estimators, which decide the method's accuracy: density and gradient of log density at the particles.
//!
//! | estimator | density | gradient | exact for | source |
//! |---|---|---|---|---|
//! | [`SummationDensity`] | `sum mu_j W_ij` | `sum mu_j grad W_ij` | nothing: kernel variance remains | Canor & Denoël 2013, eq 15, 19, 23 |
//! | [`FlowMapFit`] | `mu_i / det F_i` | weighted least squares of `log psi` over those near on the lattice, degree 2 to 4 | a Gaussian | this project |
//!
//! An estimator is given a [`Cloud`], and before it the lattice on which the particles start. It knows no system, no time
//! step and no raw coordinates.

mod cell_geometry;
mod cells;
mod flow_map;
mod monomials;
mod polynomial_fit;
pub(crate) mod settling;
mod small_matrices;
mod summation_density;

pub use flow_map::{FlowMapFit, SMALLEST_CELL};
pub(crate) use flow_map::{RIM, WAVE_DAMPING};
use neighbour_search::{Criterion, NeighbourList};
pub use summation_density::SummationDensity;

pub(crate) use cell_geometry::{determinant, lattice_jacobian};
pub(crate) use monomials::Monomials;
use polynomial_fit::Determined;
pub(crate) use polynomial_fit::LeastSquares;
pub(crate) use small_matrices::{inverse, solve, solve_transposed};

use crate::cloud::Cloud;
use crate::error::Error;
use crate::extremes::{last_greatest, last_greatest_but};

/// Output of an estimator: one entry per particle, in the coordinates of the metric. An estimator overwrites entries and
/// keeps their number.
#[derive(Debug, Clone)]
pub struct Estimates<const D: usize> {
    /// Gradient of log density.
    pub score: Vec<[f64; D]>,
    /// Density `psi_i > 0`.
    pub density: Vec<f64>,
    /// The volume `V_i` that the particle occupies in the eyes of the kernel: what sets its smoothing length,
    /// `h_i = h_0i (V_i / V_0i)^(1/D)` (Canor & Denoël 2013, eq 20).
    pub volume: Vec<f64>,
    /// The deformation gradient of the lattice cell, `dy/dX` in spacings, where the estimator has one; else as it was.
    pub deformation: Vec<[[f64; D]; D]>,
    /// Particles that the estimator could not resolve; zero before.
    pub unresolved: Unresolved,
    /// How well the neighbours determined the local fits; [`Fits::default`] before.
    pub fits: Fits,
    /// What an estimator holds between its passes.
    pub(crate) carried: Carried,
}

/// Numbers of each particle that the flow-map fit differentiates or averages over the lattice. Empty with other estimators.
#[derive(Debug, Clone, Default)]
pub(crate) struct Carried {
    /// `y` in blocks of four components.
    pub(crate) blocks: Vec<[f64; 4]>,
    /// `d`, the departure of the logarithm of the density from the cloud's Gaussian.
    pub(crate) departure: Vec<f64>,
    /// `v`, the volume of an upright cell, zero for one that is turned over.
    pub(crate) upright: Vec<f64>,
    /// `[d, d, d, v]`.
    pub(crate) fours: Vec<[f64; 4]>,
    /// Whether a member's cell is turned over.
    pub(crate) near_turned: Vec<bool>,
}

impl Carried {
    /// Makes room for `n` particles.
    pub(crate) fn resize(&mut self, n: usize) {
        self.departure.resize(n, 0.0);
        self.upright.resize(n, 0.0);
        self.fours.resize(n, [0.0; 4]);
        self.near_turned.resize(n, false);
    }
}

impl<const D: usize> Estimates<D> {
    /// Zeros for `n` particles.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            score: vec![[0.0; D]; n],
            density: vec![0.0; n],
            volume: vec![0.0; n],
            deformation: vec![[[0.0; D]; D]; n],
            unresolved: Unresolved::default(),
            fits: Fits::default(),
            carried: Carried::default(),
        }
    }

    /// Sets the counts to those before an estimate.
    pub(crate) fn restart(&mut self) {
        (self.unresolved, self.fits) = (Unresolved::default(), Fits::default());
    }
}

/// Particles that an estimator could not resolve: cells that took density and score from others.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Unresolved {
    /// How many.
    pub particles: usize,
    /// The probability that they carry.
    pub mass: f64,
    /// The one of them that carries most, the lowest where several do.
    pub heaviest: Option<usize>,
}

impl Unresolved {
    /// Counts particle `i`; particles come in ascending order.
    pub(crate) fn add(&mut self, i: usize, masses: &[f64]) {
        self.particles += 1;
        self.mass += masses[i];
        if self.heaviest.is_none_or(|heaviest| masses[i] > masses[heaviest]) {
            self.heaviest = Some(i);
        }
    }
}

/// How well the neighbours of all particles determined their local fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fits {
    /// Particles with too few neighbours for the degree asked for: their fit is of a lower one.
    pub lowered: usize,
    /// Particles whose neighbours do not determine all monomials, as on a surface; the others are omitted.
    pub undetermined: usize,
    /// The smallest pivot that was kept, over all particles, in `(0, 1]`: the square of the sine of the angle between a
    /// monomial and those before it. The relative error of a fit is about `f64::EPSILON` over it. 1 without a fit.
    pub smallest_pivot: f64,
}

impl Default for Fits {
    fn default() -> Self {
        Self { lowered: 0, undetermined: 0, smallest_pivot: 1.0 }
    }
}

impl Fits {
    /// One fit of `n_unknowns` where `asked` were wanted.
    pub(crate) fn of(n_unknowns: usize, asked: usize, determined: Determined) -> Self {
        Self {
            lowered: usize::from(n_unknowns < asked),
            undetermined: usize::from(determined.n_left_out > 0),
            smallest_pivot: determined.smallest_pivot,
        }
    }

    /// Both together; the order does not matter.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            lowered: self.lowered + other.lowered,
            undetermined: self.undetermined + other.undetermined,
            smallest_pivot: self.smallest_pivot.min(other.smallest_pivot),
        }
    }
}

/// Degree of a local polynomial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Degree {
    /// 2.
    Quadratic,
    /// 3.
    Cubic,
    /// 4.
    Quartic,
}

impl Degree {
    /// The degree as a number.
    #[must_use]
    pub const fn value(self) -> usize {
        match self {
            Self::Quadratic => 2,
            Self::Cubic => 3,
            Self::Quartic => 4,
        }
    }
}

/// The lattice on which the particles start, for estimators that work there.
#[derive(Debug, Clone, Copy)]
pub struct LatticePlaces<'a, const D: usize> {
    /// Places in spacings, whole numbers; one per particle.
    pub places: &'a [[f64; D]],
    /// Neighbours within reach, the particle itself excluded, rows ascending.
    pub neighbours: &'a NeighbourList,
    /// The reach in spacings: `support_over_spacing` of the method.
    pub reach: f64,
    /// The spacing in the coordinates of the metric: the D-th root of a cell's volume.
    pub spacing: f64,
}

/// The flow map around a particle over its lattice cell, `y(u) = y_i + E u + u.K u / 2`, and the logarithm of the mass per
/// cell there, `log mu_i + slope.u + u.bend u / 2`; `u` in spacings, from -1/2 to 1/2 within the cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalMap<const D: usize> {
    /// `E`: columns are the edges of the cell, in the metric.
    pub edges: [[f64; D]; D],
    /// `K`: second derivatives of each component of `y`.
    pub curvature: [[[f64; D]; D]; D],
    /// Gradient of the logarithm of the mass.
    pub slope: [f64; D],
    /// Its second derivatives.
    pub bend: [[f64; D]; D],
    /// Whether the estimator resolves the cell.
    pub resolved: bool,
}

/// An estimator of density and score, `grad log psi`, from particles and their masses.
///
/// It is pure in the cloud: the same cloud gives bitwise identical results for any number of threads.
pub trait ScoreEstimator<const D: usize>: std::fmt::Debug + Send {
    /// End of the kernel's support in units of the smoothing length.
    fn support(&self) -> f64;

    /// Which pairs it needs, found anew at every evaluation; none where it works on the lattice, whose
    /// neighbours it then has in [`Cloud::neighbours`].
    fn criterion(&self) -> Option<Criterion>;

    /// Prepares for the particles of a new lattice. The default does nothing.
    ///
    /// # Errors
    /// Where the lattice does not carry the estimator, which must then be as it was.
    fn start(&mut self, lattice: &LatticePlaces<'_, D>) -> Result<(), Error> {
        let _ = lattice;
        Ok(())
    }

    /// Refuses a resolution at which it is known to fail, whatever the flow. Provided: none is refused.
    ///
    /// # Errors
    /// [`Error::SupportTooSmall`].
    fn check_resolution(&self, support_over_spacing: f64) -> Result<(), Error> {
        let _ = support_over_spacing;
        Ok(())
    }

    /// How fast a diffusion matrix (in the metric) spreads a particle against what the estimator resolves (per unit of
    /// time): what the diffusion limit holds against the step. Provided: `D_y / R^2` with the trace `D_y` and the support
    /// radius `R`.
    fn spread(&self, diffusion: &[[f64; D]; D], radius: f64, deformation: &[[f64; D]; D]) -> f64 {
        let _ = deformation;
        (0..D).map(|k| diffusion[k][k]).sum::<f64>() / radius.powi(2)
    }

    /// The [`spread`](Self::spread) of particles from `first` on. `diffusion` has an entry for each particle, or one for all.
    #[allow(clippy::inline_always, reason = "what is not inlined is not compiled for registers")]
    #[inline(always)]
    fn spreads(
        &self,
        first: usize,
        diffusion: &[[[f64; D]; D]],
        radii: &[f64],
        deformation: &[[[f64; D]; D]],
        spreads: &mut [f64],
    ) {
        let here = first..first + spreads.len();
        let (radii, deformation) = (&radii[here.clone()], &deformation[here.clone()]);
        if let [shared] = diffusion {
            for (p, spread) in spreads.iter_mut().enumerate() {
                *spread = self.spread(shared, radii[p], &deformation[p]);
            }
        } else {
            for (p, diffusion) in diffusion[here].iter().enumerate() {
                spreads[p] = self.spread(diffusion, radii[p], &deformation[p]);
            }
        }
    }

    /// The particle that spreads fastest, the last of several, and its [`spread`](Self::spread). `diffusion` has an entry
    /// for each particle, or one for all.
    fn fastest_spread(
        &self,
        diffusion: &[[[f64; D]; D]],
        radii: &[f64],
        deformation: &[[[f64; D]; D]],
    ) -> (usize, f64) {
        last_greatest(
            radii.len(),
            #[inline(always)]
            |first, spreads| self.spreads(first, diffusion, radii, deformation, spreads),
        )
    }

    /// As [`fastest_spread`](Self::fastest_spread), without the fastest particles whose `weights` together are at most
    /// `neglected`.
    fn fastest_spread_but(
        &self,
        diffusion: &[[[f64; D]; D]],
        radii: &[f64],
        deformation: &[[[f64; D]; D]],
        weights: &[f64],
        neglected: f64,
    ) -> (usize, f64) {
        last_greatest_but(
            weights,
            neglected,
            #[inline(always)]
            |first, spreads| self.spreads(first, diffusion, radii, deformation, spreads),
        )
    }

    /// Takes out of the positions what the estimator does not see, by the given part in `[0, 1]`: that of a step with the
    /// time constant of [`Settling::UNIFORM`](crate::Settling::UNIFORM). `before` is scratch of the same length. Provided:
    /// nothing is taken out.
    fn settle(&self, x: &mut [[f64; D]], before: &mut [[f64; D]], part: f64) {
        let _ = (x, before, part);
    }

    /// The flow map around every particle, where the estimator follows it. Provided: it does not.
    fn local_maps(&self, cloud: &Cloud<'_, D>) -> Option<Vec<LocalMap<D>>> {
        let _ = cloud;
        None
    }

    /// Score, density and volume of every particle.
    ///
    /// # Errors
    /// Where the neighbours do not determine the estimate, naming step, time and particle.
    fn estimate(&self, cloud: &Cloud<'_, D>, out: &mut Estimates<D>) -> Result<(), Error>;
}
