//! Responses as functions of any number of coefficients: those of random fields.

use std::collections::BTreeMap;
use std::ops::Range;

use perturbation_moments::{Jet, LANES, MonteCarlo};

use super::design::Design;
use super::field_moments::FieldMoments;
use super::keep::Keep;
use super::runs::Runs;
use super::sampled::Sampled;
use super::switch::{Switch, SwitchWitness};
use crate::error::{Error, positive};
use crate::number::Number;
use crate::parallel::map_in_order;
use crate::record::gathered::{Plain, Schedule};
use crate::record::observation::Plan;
use crate::simulation::Simulation;

/// A run as a function of any number of independent standard normals, such as the coefficients of the modes of random fields.
///
/// Bodies whose constants follow a field are made by [`Body::varying`](crate::Body::varying).
pub trait FieldExperiment<const D: usize>: Sync {
    /// How many coefficients it takes.
    fn n_coefficients(&self) -> usize;

    /// The simulation at its start, with these coefficients. Grid, places of particles and steps must not depend on them.
    ///
    /// # Errors
    /// Where the constants of a particle are out of range.
    fn simulation<S: Number>(&self, coefficients: &[S]) -> Result<Simulation<S, D>, Error>;
}

/// An experiment with random fields and a plan of outputs, with the reference run done: that with all coefficients zero.
///
/// Every other run takes the steps of the reference run.
#[derive(Debug)]
pub struct FieldStudy<'a, X, const D: usize> {
    experiment: &'a X,
    runs: Runs<'a, D>,
}

/// First and second derivatives of every response along directions in the space of the coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct AlongFields {
    /// By response, then direction: `dy/ds` and `d^2y/ds^2` at `xi = s d`.
    pub derivatives: Vec<Vec<[f64; 2]>>,
    /// How near each response's gauge was to a switch, by the directions together.
    pub switches: Vec<Switch>,
    /// Runs of jets that were needed: one for every eight directions.
    pub n_runs: usize,
}

/// Gradient and own curvatures of every response by the coefficients of the fields.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldGradient {
    /// Of every response.
    pub moments: Vec<FieldMoments>,
    /// How near each response's gauge was to a switch.
    pub switches: Vec<Switch>,
    /// Runs of jets: `n/8` for `n` coefficients, rounded up.
    pub n_runs: usize,
}

impl<'a, X: FieldExperiment<D>, const D: usize> FieldStudy<'a, X, D> {
    /// Runs the experiment with all coefficients zero; as [`Study::kept_by`](super::Study::kept_by), it and the runs with
    /// derivatives resume where they were last kept, if somebody keeps them.
    ///
    /// # Errors
    /// [`Error::EmptyPlan`] without coefficients; those of the experiment, of the plan and of the keeper.
    pub fn new(
        experiment: &'a X,
        plan: Plan<D>,
        keep: Option<&'a dyn Keep>,
    ) -> Result<Self, Error> {
        let n = experiment.n_coefficients();
        if n == 0 {
            return Err(Error::EmptyPlan { what: "coefficients of random fields" });
        }
        let mut simulation = experiment.simulation(&vec![0.0; n])?;
        Ok(Self { experiment, runs: Runs::begin(&mut simulation, plan, keep)? })
    }

    /// What is looked at.
    pub const fn plan(&self) -> &Plan<D> {
        &self.runs.plan
    }

    /// The responses with all coefficients zero.
    #[must_use]
    pub fn centre(&self) -> &[f64] {
        self.runs.centre()
    }

    /// The steps that all runs take.
    #[must_use]
    pub const fn schedule(&self) -> &Schedule {
        self.runs.schedule()
    }

    /// The responses of a realisation.
    ///
    /// # Errors
    /// [`Error::OtherCoefficients`] for another number of coefficients; those of the experiment and of the run.
    pub fn run(&self, coefficients: &[f64]) -> Result<Vec<f64>, Error> {
        self.check(coefficients.len())?;
        self.experiment.simulation(coefficients)?.replay(&self.runs.plan, self.schedule())
    }

    /// A realisation, shown at the begins and ends of windows, to draw fields.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_seen(
        &self,
        coefficients: &[f64],
        look: impl FnMut(f64, &Simulation<f64, D>),
    ) -> Result<(), Error> {
        self.check(coefficients.len())?;
        let mut simulation = self.experiment.simulation(coefficients)?;
        self.runs.show("realisation, shown".to_owned(), &mut simulation, look)
    }

    /// How many coefficients the experiment takes.
    #[must_use]
    pub fn n_coefficients(&self) -> usize {
        self.experiment.n_coefficients()
    }

    fn check(&self, value: usize) -> Result<(), Error> {
        let expected = self.experiment.n_coefficients();
        if value == expected { Ok(()) } else { Err(Error::OtherCoefficients { value, expected }) }
    }

    /// First and second derivatives along any directions, eight of them in each run of jets.
    ///
    /// # Errors
    /// [`Error::OtherCoefficients`] for a direction of another length; those of the experiment and of the runs.
    pub fn along(&self, name: &str, directions: &[Vec<f64>]) -> Result<AlongFields, Error> {
        directions.iter().try_for_each(|direction| self.check(direction.len()))?;
        let plan = &self.runs.plan;
        let (n_gauges, n_responses) = (plan.gauges.len(), plan.n_responses());
        let mut derivatives = vec![Vec::with_capacity(directions.len()); n_responses];
        let mut switches: Option<Vec<Vec<Switch>>> = None;
        let batches = directions.chunks(LANES);
        let n_runs = batches.len();
        for (batch, of_batch) in batches.enumerate() {
            let coefficient = |k: usize| {
                let slope =
                    |lane| of_batch.get(lane).map_or(0.0, |direction: &Vec<f64>| direction[k]);
                Jet::new(0.0, std::array::from_fn(slope))
            };
            let coefficients: Vec<Jet> =
                (0..self.experiment.n_coefficients()).map(coefficient).collect();
            let mut simulation = self.experiment.simulation(&coefficients)?;
            let mut look = |_: f64, _: &Simulation<Jet, D>| ();
            let witness = SwitchWitness::new(n_gauges, &plan.windows, of_batch.len(), &mut look);
            let run = format!("{name} {batch}");
            let (values, witness) = self.runs.follow(run, &mut simulation, &Plain, witness)?;
            for (of_response, jet) in derivatives.iter_mut().zip(&values) {
                of_response
                    .extend((0..of_batch.len()).map(|lane| [jet.first[lane], jet.second[lane]]));
            }
            switches = Some(match switches {
                None => witness.at_windows,
                Some(earlier) => Switch::join(earlier, &witness.at_windows),
            });
        }
        let at_windows = switches.unwrap_or_default();
        let switch = |response| {
            let (gauge, _, window) = plan.parts(response);
            at_windows.get(gauge).map_or(Switch::NONE, |of_gauge| of_gauge[window])
        };
        let switches = (0..n_responses).map(switch).collect();
        Ok(AlongFields { derivatives, switches, n_runs })
    }

    /// Slopes along any directions by one-sided differences of whole runs, `step` from the reference run: one run in numbers for
    /// each direction. A slope is wrong by half the step times the curvature. By response, then direction.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the step; [`Error::OtherCoefficients`] for a direction of another length; those of the experiment
    /// and of the runs.
    pub fn forward_differences(
        &self,
        step: f64,
        directions: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, Error> {
        let ends = self.ends(step, directions)?;
        let slope = |response: usize| {
            let of = |end: &Vec<f64>| (end[response] - self.centre()[response]) / step;
            ends.iter().map(of).collect()
        };
        Ok((0..self.runs.plan.n_responses()).map(slope).collect())
    }

    /// Slopes and curvatures along any directions by central differences, `step` to either side of the reference run: two runs
    /// in numbers for each direction. By response, then direction: `dy/ds` and `d^2y/ds^2`.
    ///
    /// # Errors
    /// As [`forward_differences`](Self::forward_differences).
    pub fn central_differences(
        &self,
        step: f64,
        directions: &[Vec<f64>],
    ) -> Result<Vec<Vec<[f64; 2]>>, Error> {
        let (above, below) = (self.ends(step, directions)?, self.ends(-step, directions)?);
        let of = |response: usize| {
            let centre = self.centre()[response];
            let both = above.iter().zip(&below).map(|(a, b)| (a[response], b[response]));
            both.map(|(a, b)| [(a - b) / (2.0 * step), (a - 2.0 * centre + b) / (step * step)])
                .collect()
        };
        Ok((0..self.runs.plan.n_responses()).map(of).collect())
    }

    /// The responses at the ends of steps along directions.
    fn ends(&self, step: f64, directions: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, Error> {
        positive("step of differences", step.abs())?;
        directions.iter().try_for_each(|direction| self.check(direction.len()))?;
        let run = |direction: &Vec<f64>| {
            let coefficients: Vec<f64> = direction.iter().map(|d| step * d).collect();
            self.run(&coefficients)
        };
        map_in_order(directions, &run).into_iter().collect()
    }

    /// The unit vectors of the coefficients.
    #[must_use]
    pub fn units(&self) -> Vec<Vec<f64>> {
        let n = self.experiment.n_coefficients();
        let unit = |k: usize| (0..n).map(|j| if j == k { 1.0 } else { 0.0 }).collect();
        (0..n).map(unit).collect()
    }

    /// The gradient of every response by all coefficients, with their own second derivatives: one run of jets for every eight
    /// coefficients.
    ///
    /// # Errors
    /// Those of the experiment and of the runs.
    pub fn gradient(&self) -> Result<FieldGradient, Error> {
        let AlongFields { derivatives, switches, n_runs } =
            self.along("run with derivatives of fields", &self.units())?;
        let moments = self.centre().iter().zip(derivatives);
        let moments = moments.map(|(&value, along)| FieldMoments::of(value, &along)).collect();
        Ok(FieldGradient { moments, switches, n_runs })
    }

    /// Runs a range of the samples of a judge, as [`Study::sampled_from`](super::Study::sampled_from) does: sample `r`
    /// has the coefficients of [`MonteCarlo::fill_normals`].
    ///
    /// # Errors
    /// Those of `seen`.
    pub fn monte_carlo_from<E>(
        &self,
        judge: MonteCarlo,
        range: Range<u64>,
        known: &BTreeMap<u64, Vec<f64>>,
        each: u64,
        mut seen: impl FnMut(&Sampled, u64) -> Result<(), E>,
    ) -> Result<Sampled, E> {
        let run = |realisation| self.run(&self.coefficients(judge.seed, realisation));
        Sampled::by(&run, Design::Random(judge), (range, each), known, &mut seen)
    }

    /// The coefficients of a sample.
    #[must_use]
    pub fn coefficients(&self, seed: u64, realisation: u64) -> Vec<f64> {
        let mut normals = vec![0.0; self.experiment.n_coefficients()];
        MonteCarlo { seed, n_samples: 0 }.fill_normals(realisation, &mut normals);
        normals
    }
}
