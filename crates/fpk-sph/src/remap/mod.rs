//! Remapping of the cloud onto a new lattice: densities and what particles carry besides are interpolated from the particles,
//! and mass, mean and covariance are restored.
//!
//! It reads an evaluation of the solver and replaces its state and lattice. Whether and when the cloud is remapped is decided
//! by the step; no system is known here.

mod fresh_lattice;
mod interpolation;
pub(crate) mod rim_extrapolation;

use self::fresh_lattice::FreshLattice;
use self::interpolation::Departure;
use self::rim_extrapolation::RimExtrapolation;
use crate::cloud::lattice::ParticleLattice;
use crate::cloud::metric::{Metric, Whitening, mean_and_covariance};
use crate::error::Error;
use crate::method::remapping::{Remapped, Remapping};
use crate::parallel::fill;
use crate::score::{lattice_jacobian, solve};
use crate::solver::Solver;
use crate::system::linear_filter::FilterVector;
use crate::time::state::State;

/// Numbers that particles carry besides their masses, `n` each, particle by particle.
pub(crate) struct Carried<'a> {
    pub(crate) values: &'a [f64],
    pub(crate) n: usize,
}

/// These numbers on a new lattice, with what extrapolates them to its rim.
pub(crate) struct CarriedOn {
    pub(crate) values: Vec<f64>,
    pub(crate) rim: RimExtrapolation,
}

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
        let fresh = self.grow_lattice(&self.departure()?, remapping)?;
        let (fresh, report) = self.placed(fresh, remapping)?;
        self.start_on(fresh)?;
        Ok(report)
    }

    /// As [`Self::remap_evaluated`], with what the particles carry, which `check` sees with the masses before anything changes.
    pub(crate) fn remap_with(
        &mut self,
        remapping: &Remapping,
        carried: &Carried<'_>,
        check: impl FnOnce(&[f64], &[f64]) -> Result<(), Error>,
    ) -> Result<(Remapped, CarriedOn), Error> {
        let departure = self.departure()?;
        let (mut fresh, report) =
            self.placed(self.grow_lattice(&departure, remapping)?, remapping)?;
        let whitening = &self.evaluation.cloud.whitening;
        let mut found = vec![FilterVector::default(); fresh.positions.len()];
        fill(&mut found, |i| {
            let mut of_particle = FilterVector::default();
            let place = whitening.whiten(&fresh.positions[i]);
            departure.carried(&place, carried.values, carried.n, &mut of_particle);
            of_particle
        });
        let mut values: Vec<f64> = found.iter().flat_map(|of| &of[..carried.n]).copied().collect();
        fresh.lattice.find_neighbours(self.discretisation.combination.support_over_spacing)?;
        let rim = RimExtrapolation::new(&fresh.lattice)?;
        // What lies beyond the cloud lies at the rim.
        rim.apply(&mut values, carried.n);
        check(&values, &fresh.masses)?;
        self.start_on(fresh)?;
        Ok((report, CarriedOn { values, rim }))
    }

    /// The particles of a new lattice, with mass, mean and covariance restored.
    fn placed(
        &self,
        fresh: FreshLattice<D>,
        remapping: &Remapping,
    ) -> Result<(Placed<D>, Remapped), Error> {
        let (time, spacing) = (self.state.time, self.discretisation.lattice.spacing);
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
        let lattice = ParticleLattice::new(fresh.indices, spacing);
        Ok((Placed { lattice, positions, masses }, report))
    }

    /// The log density of the present evaluation.
    fn departure(&self) -> Result<Departure<'_, D>, Error> {
        let Self { discretisation, evaluation, .. } = self;
        if discretisation.combination.metric != Metric::Whitened {
            return Err(Error::NotWhitened);
        }
        Departure::new(
            &discretisation.lattice,
            &evaluation.cloud.positions,
            &evaluation.estimates.density,
            &evaluation.estimates.score,
        )
    }

    /// The cells of the new lattice with their masses.
    fn grow_lattice(
        &self,
        departure: &Departure<'_, D>,
        remapping: &Remapping,
    ) -> Result<FreshLattice<D>, Error> {
        let reach = self.discretisation.combination.support_over_spacing;
        FreshLattice::grow(departure, self.state.time, reach, remapping)
    }

    /// Replaces the particles by those of another lattice; an error leaves the state unchanged.
    fn start_on(&mut self, fresh: Placed<D>) -> Result<(), Error> {
        let Placed { lattice, positions, masses } = fresh;
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
        if let Err(error) = self.start_smoothing_lengths(h) {
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

/// Particles on a new lattice.
struct Placed<const D: usize> {
    lattice: ParticleLattice<D>,
    positions: Vec<[f64; D]>,
    masses: Vec<f64>,
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
