//! An experiment with random parameters, and what its responses do.

use perturbation_moments::{
    AlongDirections, Jet, LANES, Moments, RandomVector, SIGMA_POINT_DISTANCE, Scalar, SigmaPoints,
    Slopes,
};

use super::experiment::Experiment;
use super::keep::Keep;
use super::range;
use super::runs::Runs;
use super::switch::{Switch, SwitchWitness};
use crate::error::Error;
use crate::parallel::map_in_order;
use crate::record::gathered::{Plain, Schedule};
use crate::record::observation::Plan;
use crate::simulation::Simulation;

/// Which points of a star are run: `+` and `-` of each direction alternate.
const BOTH_SIDES: usize = 1;
const ONE_SIDE: usize = 2;

/// An experiment, the distribution of its parameters and a plan of outputs, with the reference run done.
#[derive(Debug)]
pub struct Study<'a, X, const D: usize, const N: usize> {
    pub(super) experiment: &'a X,
    pub(super) inputs: RandomVector<N>,
    pub(super) runs: Runs<'a, D>,
}

/// What the jets brought.
#[derive(Debug, Clone, PartialEq)]
pub struct Propagated<const N: usize> {
    /// Taylor moments of every response: [`Moments::mean_second_order`], [`Moments::variance_first_order`], and
    /// [`Moments::trust`], with mixed curvature from the probes.
    pub moments: Vec<Moments<N>>,
    /// How near each response's gauge was to a switch.
    pub switches: Vec<Switch>,
    /// Probes of the mixed second derivatives that were carried along, in lanes that the parameters leave free.
    pub n_probes: usize,
}

impl<'a, X: Experiment<D, N>, const D: usize, const N: usize> Study<'a, X, D, N> {
    /// Checks the laws, and runs the experiment at the centre of the parameters: the mean of normal, the median of lognormal
    /// ones. Every other run takes its steps.
    ///
    /// # Errors
    /// Those of the experiment at the centre and of the plan; [`Error::LikelyOutOfRange`].
    pub fn new(experiment: &'a X, inputs: RandomVector<N>, plan: Plan<D>) -> Result<Self, Error> {
        Self::of(experiment, inputs, plan, None)
    }

    /// As [`new`](Self::new), and every run but those of [`monte_carlo`](Self::monte_carlo) resumes where it was last kept,
    /// bitwise identically. It is kept at its end, and before where that is due. What a plan has gained since must begin after what was
    /// reached; what was kept of a longer plan serves a shorter one.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::NotKept`]; [`Error::OtherWindows`] for a standing that came by other stops;
    /// [`Error::ForeignSnapshot`] and [`Error::SnapshotNumber`] for one of another study; [`Error::MaterialNotStored`].
    pub fn kept_by(
        experiment: &'a X,
        inputs: RandomVector<N>,
        plan: Plan<D>,
        keep: &'a dyn Keep,
    ) -> Result<Self, Error> {
        Self::of(experiment, inputs, plan, Some(keep))
    }

    fn of(
        experiment: &'a X,
        inputs: RandomVector<N>,
        plan: Plan<D>,
        keep: Option<&'a dyn Keep>,
    ) -> Result<Self, Error> {
        let mut simulation = experiment.simulation(&inputs.centre())?;
        range::check(experiment, &inputs)?;
        let runs = Runs::begin(&mut simulation, plan, keep)?;
        Ok(Self { experiment, inputs, runs })
    }

    /// What is looked at.
    pub const fn plan(&self) -> &Plan<D> {
        &self.runs.plan
    }

    /// The law of the parameters.
    pub const fn inputs(&self) -> &RandomVector<N> {
        &self.inputs
    }

    /// The responses at the centre of the parameters.
    #[must_use]
    pub fn centre(&self) -> &[f64] {
        self.runs.centre()
    }

    /// The steps that all runs take.
    #[must_use]
    pub const fn schedule(&self) -> &Schedule {
        self.runs.schedule()
    }

    /// The responses at independent standard normals `t`.
    ///
    /// # Errors
    /// Those of the experiment and of the run.
    pub fn run(&self, t: &[f64; N]) -> Result<Vec<f64>, Error> {
        self.experiment.simulation(&self.inputs.point(t))?.replay(&self.runs.plan, self.schedule())
    }

    /// Repeats the reference run and shows it at the begins and ends of windows, to draw fields. Where it resumes another, it
    /// is not shown what that one has passed.
    ///
    /// # Errors
    /// Those of the experiment and of the run.
    pub fn mean_run_seen(&self, look: impl FnMut(f64, &Simulation<f64, D>)) -> Result<(), Error> {
        let mut simulation = self.experiment.simulation(&self.inputs.centre())?;
        let run = "reference run, shown".to_owned();
        self.runs.show(run, &mut simulation, look)
    }

    /// Moments by the derivatives that every particle and node carries: one run with jets for up to eight parameters, one
    /// more for every eight beyond. Parameters without deviation behind the last that has one take no lanes. Lanes that are left
    /// carry probes of the mixed second derivatives, along fixed signs.
    ///
    /// # Errors
    /// Those of the experiment and of the run; of [`Moments::along`] where a derivative has overflowed.
    pub fn propagated(&self) -> Result<Propagated<N>, Error> {
        self.propagated_seen(|_, _| ())
    }

    /// As [`propagated`](Self::propagated), and shows the run of every pass at the begins and ends of windows: what to draw
    /// fields from. Lane `k` of a jet is the derivative by the normal `8 pass + k`. Where a run resumes another, it is not shown
    /// what that one has passed.
    ///
    /// # Errors
    /// As [`propagated`](Self::propagated).
    pub fn propagated_seen(
        &self,
        mut look: impl FnMut(f64, &Simulation<Jet, D>),
    ) -> Result<Propagated<N>, Error> {
        let n = self.n_random();
        let n_passes = n.div_ceil(LANES).max(1);
        let probes = signs::<N>(n, LANES * n_passes - n);
        let (windows, n_gauges) = (&self.runs.plan.windows, self.runs.plan.gauges.len());
        let mut switches_so_far: Option<Vec<Vec<Switch>>> = None;
        let mut passes: Vec<Vec<Jet>> = Vec::with_capacity(n_passes);
        for pass in 0..n_passes {
            let jets = self.jets_of_pass(pass, &probes);
            let mut simulation = self.experiment.simulation(&jets)?;
            let witness = SwitchWitness::new(n_gauges, windows, n - LANES * pass, &mut look);
            let run = format!("run with derivatives {pass}");
            let (values, witness) = self.runs.follow(run, &mut simulation, &Plain, witness)?;
            passes.push(values);
            switches_so_far = Some(match switches_so_far {
                None => witness.at_windows,
                Some(earlier) => Switch::join(earlier, &witness.at_windows),
            });
        }
        let at_windows = switches_so_far.unwrap_or_default();
        let moments = self.moments_of(&passes, probes.len())?;
        let switch = |response| {
            let (gauge, _, window) = self.runs.plan.parts(response);
            at_windows[gauge][window]
        };
        let switches = (0..self.runs.plan.n_responses()).map(switch).collect();
        Ok(Propagated { moments, switches, n_probes: probes.len() })
    }

    /// The parameters up to the last one with a deviation: their directions take lanes of jets.
    pub(super) fn n_random(&self) -> usize {
        self.inputs.deviations().iter().rposition(|&deviation| deviation > 0.0).map_or(0, |k| k + 1)
    }

    /// The parameters as jets: lane `k` of all passes is direction `k`, or after the last random parameter a probe.
    fn jets_of_pass(&self, pass: usize, probes: &[[f64; N]]) -> [Jet; N] {
        let n = self.n_random();
        let mut jets = self.inputs.centre().map(Jet::constant);
        for lane in 0..LANES {
            // Where the inputs have the direction, whose probes follow their last parameter.
            let place = LANES * pass + lane;
            let place = if place < n { place } else { N + (place - n) };
            let of_inputs = self.inputs.jets_of_pass(place / LANES, probes);
            for (jet, from) in jets.iter_mut().zip(of_inputs) {
                jet.first[lane] = from.first[place % LANES];
                jet.second[lane] = from.second[place % LANES];
            }
        }
        jets
    }

    /// Taylor moments of every response, from the jets of each pass.
    pub(super) fn moments_of(
        &self,
        passes: &[Vec<Jet>],
        n_probes: usize,
    ) -> Result<Vec<Moments<N>>, Error> {
        let n = self.n_random();
        let of = |response: usize| {
            let value = passes[0][response].value;
            // By the places of the inputs: random parameters, certain ones, probes.
            let mut jets = vec![Jet::constant(value); (N + n_probes).div_ceil(LANES).max(1)];
            for from in 0..n + n_probes {
                let to = if from < n { from } else { N + (from - n) };
                let jet = &passes[from / LANES][response];
                jets[to / LANES].first[to % LANES] = jet.first[from % LANES];
                jets[to / LANES].second[to % LANES] = jet.second[from % LANES];
            }
            let known = AlongDirections::from_passes(&jets, n_probes)?;
            Ok(Moments::along(&self.inputs, &known)?)
        };
        (0..self.runs.plan.n_responses()).map(of).collect()
    }

    /// Moments by central differences of `2N` whole runs, `step` deviations to either side of the reference run; a parameter
    /// without deviation costs none.
    ///
    /// # Errors
    /// Those of the experiment and of a run; of [`AlongDirections::from_star`] for the step.
    pub fn finite_difference(&self, step: f64) -> Result<Vec<Moments<N>>, Error> {
        let table = self.star(step, BOTH_SIDES)?;
        let of = |response: usize| {
            let values: Vec<f64> = table.iter().map(|run| run[response]).collect();
            let known = AlongDirections::from_star(step, &values)?;
            Ok(Moments::along(&self.inputs, &known)?)
        };
        (0..self.runs.plan.n_responses()).map(of).collect()
    }

    /// First-order moments by one-sided differences of `N` whole runs, `step` deviations from the reference run: the variance by
    /// the fewest runs; no second-order mean. A slope is wrong by half the step times the curvature.
    ///
    /// # Errors
    /// As [`finite_difference`](Self::finite_difference).
    pub fn forward_difference(&self, step: f64) -> Result<Vec<Moments<N>>, Error> {
        let table = self.star(step, ONE_SIDE)?;
        let of = |response: usize| {
            let values: Vec<f64> = table.iter().map(|run| run[response]).collect();
            let slopes = Slopes::from_half_star(step, &values)?;
            Ok(Moments::from_slopes(&self.inputs, &slopes)?)
        };
        (0..self.runs.plan.n_responses()).map(of).collect()
    }

    /// Moments by the runs at the centre and at $\pm\sqrt3$ deviations along each direction; a parameter without deviation
    /// costs none.
    ///
    /// # Errors
    /// Those of the experiment and of a run: at three deviations a parameter may be out of range.
    pub fn sigma_points(&self) -> Result<Vec<SigmaPoints<N>>, Error> {
        let table = self.star(SIGMA_POINT_DISTANCE, BOTH_SIDES)?;
        let of = |response: usize| {
            let values: Vec<f64> = table.iter().map(|run| run[response]).collect();
            Ok(SigmaPoints::from_values(&values)?)
        };
        (0..self.runs.plan.n_responses()).map(of).collect()
    }

    /// All responses at every `stride`-th point of a star, the reference run first.
    fn star(&self, distance: f64, stride: usize) -> Result<Vec<Vec<f64>>, Error> {
        let points = AlongDirections::<N>::star(distance);
        let mut table = vec![self.centre().to_vec()];
        let numbered: Vec<(usize, &[f64; N])> =
            points.iter().enumerate().skip(1).step_by(stride).collect();
        let run = |(point, t): &(usize, &[f64; N])| {
            let parameters = self.inputs.point(t);
            let is_centre = |(x, centre): (&f64, f64)| x.total_cmp(&centre).is_eq();
            if parameters.iter().zip(self.inputs.centre()).all(is_centre) {
                // Along a parameter that is certain.
                return Ok(self.centre().to_vec());
            }
            let mut simulation = self.experiment.simulation(&parameters)?;
            let name = format!("point {point} at {distance} deviations");
            self.runs.follow(name, &mut simulation, &Plain, ()).map(|(values, ())| values)
        };
        for run in map_in_order(&numbered, &run) {
            table.push(run?);
        }
        Ok(table)
    }
}

/// Different directions of signs of the first parameters, the first always `+`: all that there are, or as many as asked for.
fn signs<const N: usize>(n_parameters: usize, n: usize) -> Vec<[f64; N]> {
    let n_different = if n_parameters == 0 { 0 } else { 1_usize << (n_parameters - 1).min(16) };
    // An odd step visits each of a power of two once; this one goes to and fro.
    let step = n_different / 2 + 1 - (n_different / 2) % 2;
    let pattern = |index: usize| (index * step + n_different / 3) % n_different;
    (0..n.min(n_different))
        .map(|index| {
            let bits = pattern(index);
            std::array::from_fn(|k| if k > 0 && bits >> (k - 1) & 1 == 1 { -1.0 } else { 1.0 })
        })
        .collect()
}
