//! A fresh lattice over the present cloud.

mod fresh_lattice;
mod interpolation;

use sde_integrators::Sde;

use self::fresh_lattice::FreshLattice;
use self::interpolation::Departure;
use crate::error::{Error, positive};
use crate::lattice::ParticleLattice;
use crate::metric::{Metric, Whitening, mean_and_covariance};
use crate::score::{lattice_jacobian, solve};
use crate::simulation::{Simulation, State};
use crate::stage::Stage;
use crate::step::Stages;

/// When a fresh lattice is laid over the cloud, how far it goes, and what it may change.
///
/// The unevenness of the cloud is the largest relative change of a cell's edges from one place of the lattice to the next,
///
/// $$ \max_{i, j} \left| E_i^{-1} (E_j - E_i) \right|_F , $$
///
/// with the edges `E` of the deformed cells in whitened coordinates and `j` beside `i`. It is 0 for an affine flow, whose
/// Gaussian needs no fresh lattice, and about 1 where a cell is about to turn over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Remapping {
    /// The unevenness above which a fresh lattice is laid before a step.
    pub most_uneven: f64,
    /// The lattice grows until its outermost layer carries less probability than this, or ends where the cloud ends: it goes
    /// beyond the last particle by [`BEYOND_THE_CLOUD`] spacings at most.
    pub outermost_mass: f64,
    /// Most relative change of the mass, and most change of an entry of the whitened mean and covariance, that a fresh
    /// lattice may make before they are restored: beyond it the lattice does not resolve the density.
    pub most_change: f64,
    /// Most particles on a fresh lattice.
    pub most_particles: usize,
}

/// How far a fresh lattice goes beyond the last particle, in spacings. Measured on Duffing's oscillator: with 0 the cloud
/// loses its rim, with 1.5 what is extrapolated grows from one lattice to the next.
pub const BEYOND_THE_CLOUD: f64 = 0.7;

/// What a fresh lattice changed. Mass, mean and covariance are restored; the changes are those before that.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct Remapped {
    /// Particles before.
    pub particles_before: usize,
    /// Particles after.
    pub particles_after: usize,
    /// Particles that stand beyond the cloud as it was.
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

impl<S: Sde<D, M>, const D: usize, const M: usize> Simulation<S, D, M> {
    /// Lays a fresh lattice over the present cloud, whatever its unevenness:
    ///
    /// * a lattice in whitened coordinates, with the spacing of the start, over all cells that carry enough;
    /// * the logarithm of the density there, by moving least squares of its departure from the cloud's Gaussian over the
    ///   lattice as it was, up to half a spacing beyond the last particle, and linearly from there;
    /// * masses `psi dV`, rescaled to the mass of the cloud, and an affine map that restores its mean and covariance.
    ///
    /// A Gaussian is kept as it is, to roundoff.
    ///
    /// # Errors
    /// [`Error::NotPositive`] and [`Error::NotFinite`] for the parameters, [`Error::NotWhitened`],
    /// [`Error::FreshLatticeTooLarge`], [`Error::FreshLatticeChanges`], [`Error::TooFewParticles`], those of the metric and of
    /// the estimator. The simulation is then as it was.
    pub fn remap(&mut self, remapping: &Remapping) -> Result<Remapped, Error> {
        remapping.check()?;
        let Self { field, state, stage, .. } = self;
        stage.estimate(field, state, state.time, &state.positions)?;
        self.lay_fresh_lattice(remapping)
    }

    /// Fresh lattices laid so far.
    pub fn n_remaps(&self) -> u64 {
        self.state.n_remaps
    }

    /// As [`Self::remap`], from the evaluation of the present state that `stage` holds.
    pub(crate) fn lay_fresh_lattice(&mut self, remapping: &Remapping) -> Result<Remapped, Error> {
        let Self { field, state, stage, .. } = self;
        if field.combination.metric != Metric::Whitened {
            return Err(Error::NotWhitened);
        }
        let (time, spacing) = (state.time, field.lattice.spacing);
        let reach = field.combination.support_over_spacing;
        let departure =
            Departure::new(&field.lattice, &stage.whitened, &stage.density, &stage.score)?;
        let FreshLattice { indices, mut masses, outermost_mass, n_beyond } =
            FreshLattice::grow(&departure, time, reach, remapping)?;
        let points: Vec<[f64; D]> =
            indices.iter().map(|k| k.map(|k| f64::from(k) * spacing)).collect();
        let (before, after) = (state.masses.iter().sum::<f64>(), masses.iter().sum::<f64>());
        let (mean, covariance) = mean_and_covariance(&points, &masses);
        let report = Remapped {
            particles_before: state.positions.len(),
            particles_after: points.len(),
            particles_beyond: n_beyond,
            outermost_mass,
            mass_change: after / before - 1.0,
            mean_change: mean.iter().fold(0.0, |most, c| c.abs().max(most)),
            covariance_change: distance_from_unity(&covariance),
        };
        report.check(time, remapping.most_change)?;
        for mass in &mut masses {
            *mass *= before / after;
        }
        let own = Whitening::of_covariance(mean, &covariance, (state.n_steps, time))?;
        let n = points.len();
        let h = reach * spacing / field.estimator.support();
        let fresh = State {
            positions: points.iter().map(|y| stage.whitening.unwhiten(&own.whiten(y))).collect(),
            masses,
            smoothing_lengths: vec![h; n],
            smoothing_ratios: vec![0.0; n],
            n_remaps: state.n_remaps + 1,
            time,
            n_steps: state.n_steps,
            // Leap-frog starts anew.
            previous: None,
        };
        self.take(fresh, ParticleLattice::new(indices, spacing), h)?;
        Ok(report)
    }

    /// Takes a state on a fresh lattice; after an error all is as it was.
    fn take(&mut self, state: State<D>, lattice: ParticleLattice<D>, h: f64) -> Result<(), Error> {
        let spacing = lattice.spacing;
        let lattice_before = self.field.lay(lattice)?;
        let state_before = std::mem::replace(&mut self.state, state);
        self.fit_buffers();
        if let Err(error) = self.start_smoothing_lengths(h, spacing) {
            self.state = state_before;
            self.field.lay(lattice_before)?;
            self.fit_buffers();
            return Err(error);
        }
        Ok(())
    }

    /// Buffers for as many particles as the state holds.
    pub(crate) fn fit_buffers(&mut self) {
        let n = self.state.positions.len();
        if self.stage.whitened.len() != n {
            let work = self.stage.work;
            (self.stage, self.stages) = (Stage::new(n), Stages::new(n));
            self.stage.work = work;
        }
    }

    /// The unevenness of the cloud that `stage` holds; infinite where a cell has no volume.
    pub(crate) fn unevenness(&self) -> f64 {
        let (y, axes) = (&self.stage.whitened, &self.field.lattice.axis_neighbours);
        let edges = |i: usize| lattice_jacobian(y, axes, i);
        let change = |from: &[[f64; D]; D], to: &[[f64; D]; D]| {
            let mut square = 0.0;
            for axis in 0..D {
                let along = solve(from, &std::array::from_fn(|k| to[k][axis] - from[k][axis]));
                square += along.iter().map(|c| c * c).sum::<f64>();
            }
            if square.is_nan() { f64::INFINITY } else { square.sqrt() }
        };
        let mut most = 0.0_f64;
        for (i, beside) in axes.iter().enumerate() {
            let Some(own) = edges(i) else { continue };
            for &j in beside.iter().flatten().flatten() {
                if let Some(other) = edges(j as usize) {
                    most = most.max(change(&own, &other));
                }
            }
        }
        most
    }
}

impl Remapped {
    fn check(&self, time: f64, limit: f64) -> Result<(), Error> {
        for (quantity, value) in [
            ("mass", self.mass_change),
            ("mean", self.mean_change),
            ("covariance", self.covariance_change),
        ] {
            if value.is_nan() || value.abs() > limit {
                return Err(Error::FreshLatticeChanges { time, quantity, value, limit });
            }
        }
        Ok(())
    }
}

/// The largest entry of `A - 1`.
fn distance_from_unity<const D: usize>(matrix: &[[f64; D]; D]) -> f64 {
    let mut most = 0.0_f64;
    for k in 0..D {
        for l in 0..D {
            let unit = if k == l { 1.0 } else { 0.0 };
            most = most.max((matrix[k][l] - unit).abs());
        }
    }
    most
}
