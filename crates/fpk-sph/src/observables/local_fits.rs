//! Local fits of the density around every particle, whatever the method.

use crate::discretisation::Discretisation;
use crate::error::Error;
use crate::evaluation::{Evaluation, WhitenedCloud};
use crate::method::Method;
use crate::metric::Metric;
use crate::score::{LocalFit, LocalMap, LogDensityFit, ScoreEstimator};
use crate::solver::Solver;
use crate::state::State;

impl<const D: usize> Solver<D> {
    /// The flow map around every particle, where the estimator follows it.
    pub(super) fn local_maps(&self) -> Result<Option<(WhitenedCloud<D>, Vec<LocalMap<D>>)>, Error> {
        let Self { discretisation, state, .. } = self;
        if discretisation.estimator.criterion().is_some() {
            return Ok(None);
        }
        let Evaluation { cloud, .. } = self.prepared(discretisation, state)?;
        let maps =
            discretisation.estimator.local_maps(&cloud.view(discretisation, state, state.time));
        Ok(maps.map(|maps| (cloud, maps)))
    }

    /// Local fits of log density in whitened coordinates, whatever the method: with the method's own smoothing lengths
    /// where it whitens, else with lengths that hold as many neighbours as the method's support at the start.
    pub(super) fn local_fits(&self) -> Result<(WhitenedCloud<D>, Vec<LocalFit<D>>), Error> {
        let fit = LogDensityFit::default();
        let combination = Method::LogDensityFit.combination();
        let lattice = self.discretisation.lattice.clone();
        let discretisation = Discretisation { estimator: Box::new(fit), combination, lattice };
        let mut state = self.state.clone();
        if self.discretisation.combination.metric == Metric::Isotropic {
            let support = <LogDensityFit as ScoreEstimator<D>>::support(&fit);
            state.whitened_smoothing_lengths(
                &discretisation.lattice.axis_neighbours,
                combination.support_over_spacing / support,
            )?;
        }
        let Evaluation { cloud, .. } = self.prepared(&discretisation, &state)?;
        let fits = fit.local_fits(&cloud.view(&discretisation, &state, state.time))?;
        Ok((cloud, fits))
    }

    /// The input of an estimator at the given state.
    fn prepared(
        &self,
        discretisation: &Discretisation<D>,
        state: &State<D>,
    ) -> Result<Evaluation<D>, Error> {
        let mut evaluation = Evaluation::new(self.n_particles());
        evaluation.prepare(discretisation, state, state.stage())?;
        Ok(evaluation)
    }
}
