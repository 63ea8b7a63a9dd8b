//! Remapping of the cloud onto a new lattice.

mod fresh_lattice;
mod interpolation;
mod policy;

pub use policy::{BEYOND_THE_CLOUD, Remapped, Remapping};

use self::fresh_lattice::FreshLattice;
use self::interpolation::Departure;
use crate::error::Error;
use crate::lattice::ParticleLattice;
use crate::metric::{Metric, Whitening, mean_and_covariance};
use crate::score::{lattice_jacobian, solve};
use crate::solver::Solver;
use crate::state::State;

impl<const D: usize> Solver<D> {
    /// Remaps the cloud onto a new lattice, whatever its unevenness; an error leaves the state unchanged.
    pub(crate) fn remap(&mut self, remapping: &Remapping) -> Result<Remapped, Error> {
        remapping.check()?;
        let Self { discretisation, state, evaluation, .. } = self;
        evaluation.estimate(discretisation, state, state.stage())?;
        self.remap_evaluated(remapping)
    }

    /// As [`Self::remap`], from the evaluation of the present state.
    pub(crate) fn remap_evaluated(&mut self, remapping: &Remapping) -> Result<Remapped, Error> {
        if self.discretisation.combination.metric != Metric::Whitened {
            return Err(Error::NotWhitened);
        }
        let (time, spacing) = (self.state.time, self.discretisation.lattice.spacing);
        let fresh = self.grow_lattice(remapping)?;
        let points: Vec<[f64; D]> =
            fresh.indices.iter().map(|k| k.map(|k| f64::from(k) * spacing)).collect();
        let before = self.state.masses.iter().sum::<f64>();
        let after = fresh.masses.iter().sum::<f64>();
        let (mean, covariance) = mean_and_covariance(&points, &fresh.masses);
        let report = Remapped {
            particles_before: self.n_particles(),
            particles_after: points.len(),
            particles_beyond: fresh.n_beyond,
            outermost_mass: fresh.outermost_mass,
            mass_change: after / before - 1.0,
            mean_change: mean.iter().fold(0.0, |most, c| c.abs().max(most)),
            covariance_change: distance_from_unity(&covariance),
        };
        report.check(time, remapping.most_change)?;
        let own = Whitening::of_covariance(mean, &covariance, (self.state.n_steps, time))?;
        let whitening = &self.evaluation.cloud.whitening;
        let positions = points.iter().map(|y| whitening.unwhiten(&own.whiten(y))).collect();
        let masses = fresh.masses.iter().map(|mass| mass * (before / after)).collect();
        self.start_on(ParticleLattice::new(fresh.indices, spacing), positions, masses)?;
        Ok(report)
    }

    /// The cells of the new lattice with their masses.
    fn grow_lattice(&self, remapping: &Remapping) -> Result<FreshLattice<D>, Error> {
        let Self { discretisation, evaluation, .. } = self;
        let departure = Departure::new(
            &discretisation.lattice,
            &evaluation.cloud.positions,
            &evaluation.estimates.density,
            &evaluation.estimates.score,
        )?;
        let reach = discretisation.combination.support_over_spacing;
        FreshLattice::grow(&departure, self.state.time, reach, remapping)
    }

    /// Replaces the particles by those of another lattice; an error leaves the state unchanged.
    fn start_on(
        &mut self,
        lattice: ParticleLattice<D>,
        positions: Vec<[f64; D]>,
        masses: Vec<f64>,
    ) -> Result<(), Error> {
        let (n, spacing) = (positions.len(), lattice.spacing);
        let reach = self.discretisation.combination.support_over_spacing;
        let h = reach * spacing / self.discretisation.estimator.support();
        let state = State {
            positions,
            masses,
            smoothing_lengths: vec![h; n],
            smoothing_ratios: vec![0.0; n],
            n_remaps: self.state.n_remaps + 1,
            time: self.state.time,
            n_steps: self.state.n_steps,
            // A scheme of two steps starts anew.
            previous: None,
        };
        let lattice_before = self.discretisation.lay(lattice)?;
        let state_before = std::mem::replace(&mut self.state, state);
        self.resize_buffers();
        if let Err(error) = self.start_smoothing_lengths(h, spacing) {
            self.state = state_before;
            self.discretisation.lay(lattice_before)?;
            self.resize_buffers();
            return Err(error);
        }
        Ok(())
    }

    /// The unevenness of the cloud of the last evaluation; infinite where a cell has no volume.
    pub(crate) fn unevenness(&self) -> f64 {
        let y = &self.evaluation.cloud.positions;
        let axes = &self.discretisation.lattice.axis_neighbours;
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
