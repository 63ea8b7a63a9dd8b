//! An experiment with random inputs, and what its responses do.

use perturbation_moments::{Jet, LANES, MonteCarlo, SIGMA_POINT_DISTANCE};

use super::experiment::Experiment;
use super::inputs::Inputs;
use super::keep::Keep;
use super::range;
use super::runs::Runs;
use super::series::Series;
use super::switch::{Switch, SwitchWitness};
use constitutive_models::positive;

use crate::error::Error;
use crate::parallel::map_in_order;
use crate::record::balance::Balance;
use crate::record::gathered::{Plain, Schedule};
use crate::record::observation::Plan;
use crate::simulation::Simulation;

/// Signs of a star along a direction, for one-sided and for central differences.
const ONE_SIDE: &[f64] = &[1.0];
const BOTH_SIDES: &[f64] = &[1.0, -1.0];

/// Shortest step of differences, in standard deviations. Roundoff of a run, some 1e-14 of a response, is 1e-4 of it in a second
/// difference over this step.
const LEAST_STEP: f64 = 1e-5;

/// Normals up to which different signs of all of them are tried as probes.
pub(super) const MOST_SIGNS: usize = 17;

/// An experiment, the distribution of its inputs and a plan of outputs, with the reference run done.
#[derive(Debug)]
pub struct Study<'a, X, const D: usize> {
    pub(super) experiment: &'a X,
    pub(super) inputs: Box<dyn Inputs>,
    pub(super) runs: Runs<'a, D>,
    torn: Vec<usize>,
}

/// Result of [`Study::propagated`].
#[derive(Debug, Clone, PartialEq)]
pub struct Propagated {
    /// The Taylor series of every response by the normals, with mixed curvature where there were probes.
    pub moments: Vec<Series>,
    /// How near each response's gauge was to a switch.
    pub switches: Vec<Switch>,
    /// Probes of the mixed second derivatives that were carried along, in lanes that the inputs leave free.
    pub n_probes: usize,
    /// Runs of jets: one for every eight inputs.
    pub n_runs: usize,
}

impl<'a, X: Experiment<D>, const D: usize> Study<'a, X, D> {
    /// Checks the distribution of the inputs, and runs the experiment at their centre: all normals zero, the mean of normal, the
    /// median of lognormal parameters. Every other run takes its steps.
    ///
    /// # Errors
    /// [`Error::EmptyPlan`] without inputs; those of the experiment at the centre and of the plan; [`Error::LikelyOutOfRange`].
    pub fn new(
        experiment: &'a X,
        inputs: impl Into<Box<dyn Inputs>>,
        plan: Plan<D>,
    ) -> Result<Self, Error> {
        Self::of(experiment, inputs.into(), plan, None)
    }

    /// As [`new`](Self::new), and every run but those of samples resumes where it was last kept, bitwise identically. It is kept
    /// at its end, and before where that is due. What a plan has gained since must begin after what was reached; what was kept of
    /// a longer plan serves a shorter one.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::NotKept`]; [`Error::OtherWindows`] for a saved run with other stops;
    /// [`Error::ForeignSnapshot`] and [`Error::SnapshotNumber`] for one of another study; [`Error::MaterialNotStored`].
    pub fn kept_by(
        experiment: &'a X,
        inputs: impl Into<Box<dyn Inputs>>,
        plan: Plan<D>,
        keep: &'a dyn Keep,
    ) -> Result<Self, Error> {
        Self::of(experiment, inputs.into(), plan, Some(keep))
    }

    fn of(
        experiment: &'a X,
        inputs: Box<dyn Inputs>,
        plan: Plan<D>,
        keep: Option<&'a dyn Keep>,
    ) -> Result<Self, Error> {
        if inputs.n_normals() == 0 {
            return Err(Error::EmptyPlan { what: "random inputs" });
        }
        let centre = inputs.point(&vec![0.0; inputs.n_normals()]);
        let mut simulation = experiment.simulation(&centre)?;
        range::check(experiment, &*inputs)?;
        let neighbours = simulation.neighbours();
        let runs = Runs::begin(&mut simulation, plan, keep)?;
        Ok(Self { experiment, inputs, runs, torn: simulation.torn(&neighbours) })
    }

    /// The plan of outputs.
    pub const fn plan(&self) -> &Plan<D> {
        &self.runs.plan
    }

    /// The responses at the centre of the inputs.
    #[must_use]
    pub fn centre(&self) -> &[f64] {
        self.runs.centre()
    }

    /// The balance of the run at the centre: at its start and at the end of every window.
    pub fn balance(&self) -> &[Balance<D>] {
        &self.runs.balance
    }

    /// Pairs of neighbours that the grid has torn at the end of the run at the centre, by body: [`Simulation::torn`].
    #[must_use]
    pub fn torn(&self) -> &[usize] {
        &self.torn
    }

    /// The steps that all runs take.
    #[must_use]
    pub const fn schedule(&self) -> &Schedule {
        self.runs.schedule()
    }

    /// The number of independent standard normals.
    #[must_use]
    pub fn n_normals(&self) -> usize {
        self.inputs.n_normals()
    }

    /// The independent standard normals of a sample.
    #[must_use]
    pub fn normals(&self, seed: u64, realisation: u64) -> Vec<f64> {
        let mut normals = vec![0.0; self.n_normals()];
        MonteCarlo { seed, n_samples: 0 }.fill_normals(realisation, &mut normals);
        normals
    }

    pub(super) fn simulation_at(&self, normals: &[f64]) -> Result<Simulation<f64, D>, Error> {
        let (value, expected) = (normals.len(), self.n_normals());
        if value != expected {
            return Err(Error::OtherInputs { value, expected });
        }
        self.experiment.simulation(&self.inputs.point(normals))
    }

    /// The responses at independent standard normals.
    ///
    /// # Errors
    /// [`Error::OtherInputs`] for another number of them; those of the experiment and of the run.
    pub fn run(&self, normals: &[f64]) -> Result<Vec<f64>, Error> {
        self.simulation_at(normals)?.replay(&self.runs.plan, self.schedule())
    }

    /// A run at independent standard normals, shown at the begins and ends of windows, to draw fields. Where it resumes another,
    /// it is not shown what that one has passed.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_seen(
        &self,
        normals: &[f64],
        look: impl FnMut(f64, &Simulation<f64, D>),
    ) -> Result<(), Error> {
        self.runs.show("run, shown".to_owned(), &mut self.simulation_at(normals)?, look)
    }

    /// Taylor series by the derivatives that every particle and node carries: one run with jets for every eight normals. Inputs
    /// without deviation behind the last that has one take no lanes. Lanes that are left carry probes of the mixed second
    /// derivatives, along fixed signs, for up to 17 normals.
    ///
    /// # Errors
    /// Those of the experiment and of the runs; [`Error::Moments`] where a derivative has overflowed.
    pub fn propagated(&self) -> Result<Propagated, Error> {
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
        look: impl FnMut(f64, &Simulation<Jet, D>),
    ) -> Result<Propagated, Error> {
        let (n, all) = (self.inputs.n_random(), self.n_normals());
        let mut directions: Vec<Vec<f64>> = (0..n).map(|k| unit(all, k)).collect();
        let n_lanes = LANES * n.div_ceil(LANES).max(1);
        let pad = |mut signs: Vec<f64>| {
            signs.resize(all, 0.0);
            signs
        };
        directions.extend(signs(n, n_lanes - n).into_iter().map(pad));
        let (passes, switches) = self.along(&directions, look)?;
        let (n_probes, n_runs) = (directions.len() - n, passes.len());
        let mut moments = self.series(&passes, n_probes)?;
        if n_runs > 1 {
            // The derivatives are of several runs with jets; the value is that of the reference run, whose steps all take.
            for (series, &centre) in moments.iter_mut().zip(self.centre()) {
                series.value = centre;
            }
        }
        Ok(Propagated { moments, switches, n_probes, n_runs })
    }

    /// Runs of jets along directions, eight in each, and how near each response's gauge was to a switch, by the normals that are
    /// random.
    fn along(
        &self,
        directions: &[Vec<f64>],
        mut look: impl FnMut(f64, &Simulation<Jet, D>),
    ) -> Result<(Vec<Vec<Jet>>, Vec<Switch>), Error> {
        let plan = &self.runs.plan;
        let mut switches: Option<Vec<Vec<Switch>>> = None;
        let mut passes = Vec::new();
        for pass in 0..directions.len().div_ceil(LANES).max(1) {
            let of_pass = directions.chunks(LANES).nth(pass).unwrap_or_default();
            let mut simulation = self.experiment.simulation(&self.inputs.jets(of_pass))?;
            let n_lanes = self.inputs.n_random().saturating_sub(LANES * pass);
            let witness = SwitchWitness::new(plan.gauges.len(), &plan.windows, n_lanes, &mut look);
            let run = format!("run with derivatives {pass}");
            let (values, witness) = self.runs.follow(run, &mut simulation, &Plain, witness)?;
            passes.push(values);
            switches = Some(match switches {
                None => witness.at_windows,
                Some(earlier) => Switch::join(earlier, &witness.at_windows),
            });
        }
        let at_windows = switches.unwrap_or_default();
        let switch = |response| {
            let (gauge, _, window) = plan.parts(response);
            at_windows[gauge][window]
        };
        Ok((passes, (0..plan.n_responses()).map(switch).collect()))
    }

    /// Taylor series of every response from the jets of each pass: lane by lane the normals that are random, then probes.
    pub(super) fn series(
        &self,
        passes: &[Vec<Jet>],
        n_probes: usize,
    ) -> Result<Vec<Series>, Error> {
        let (n, all) = (self.inputs.n_random(), self.n_normals());
        let of = |response: usize| {
            let (mut gradient, mut curvature) = (vec![0.0; all], vec![0.0; all]);
            for k in 0..n {
                let jet = &passes[k / LANES][response];
                (gradient[k], curvature[k]) = (jet.first[k % LANES], jet.second[k % LANES]);
            }
            let trace: f64 = curvature.iter().sum();
            let probe = |k: usize| passes[k / LANES][response].second[k % LANES] - trace;
            let squares: f64 = (n..n + n_probes).map(|k| probe(k).powi(2)).sum();
            let mixed_squares = (n_probes > 0).then(|| 0.5 * squares / n_probes as f64);
            let value = passes[0][response].value;
            Series { value, gradient, curvature, mixed_squares }.checked()
        };
        (0..self.runs.plan.n_responses()).map(of).collect()
    }

    /// Taylor series by central differences of `2N` whole runs, `step` to either side of the reference run; an input without
    /// deviation costs none. [`series_errors`](Self::series_errors) measures the errors of its moments by up to eight more.
    ///
    /// # Errors
    /// [`Error::ShortStep`], [`Error::Parameter`] for the step; those of the experiment and of a run.
    pub fn finite_difference(&self, step: f64) -> Result<Vec<Series>, Error> {
        let ends = self.star(step, BOTH_SIDES)?;
        let of = |(response, &value): (usize, &f64)| {
            let pair = |k: usize| (ends[2 * k][response], ends[2 * k + 1][response]);
            let normals = 0..self.n_normals();
            let slope = |k| (pair(k).0 - pair(k).1) / (2.0 * step);
            let curvature = |k| ((pair(k).0 - value) + (pair(k).1 - value)) / (step * step);
            let (gradient, curvature) =
                (normals.clone().map(slope).collect(), normals.map(curvature).collect());
            Series { value, gradient, curvature, mixed_squares: None }.checked()
        };
        self.centre().iter().enumerate().map(of).collect()
    }

    /// Taylor series of first order by one-sided differences of `N` whole runs, `step` from the reference run: the variance by the
    /// fewest runs; no second-order mean. A slope is wrong by half the step times the curvature, and by jumps of the response over
    /// the step: [`series_errors`](Self::series_errors) measures both.
    ///
    /// # Errors
    /// As [`finite_difference`](Self::finite_difference).
    pub fn forward_difference(&self, step: f64) -> Result<Vec<Series>, Error> {
        let ends = self.star(step, ONE_SIDE)?;
        let of = |(response, &value): (usize, &f64)| {
            let gradient = ends.iter().map(|end| (end[response] - value) / step).collect();
            Series { value, gradient, curvature: Vec::new(), mixed_squares: None }.checked()
        };
        self.centre().iter().enumerate().map(of).collect()
    }

    /// The runs at the centre and at $\pm\sqrt3$ deviations along each direction, as a series: its [`mean`](Series::mean), and its
    /// [`surrogate_variance`](Series::surrogate_variance) for the variance. An input without deviation costs no run.
    ///
    /// # Errors
    /// Those of the experiment and of a run: at three deviations an input may be out of range.
    pub fn sigma_points(&self) -> Result<Vec<Series>, Error> {
        self.finite_difference(SIGMA_POINT_DISTANCE)
    }

    /// All responses at the ends of steps along each normal, at both sides or one.
    fn star(&self, distance: f64, sides: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
        positive("step of differences", distance)?;
        if distance < LEAST_STEP {
            return Err(Error::ShortStep { value: distance, limit: LEAST_STEP });
        }
        let n = self.n_normals();
        let ends: Vec<(usize, f64)> =
            (0..n).flat_map(|k| sides.iter().map(move |side| (k, side * distance))).collect();
        let centre = self.inputs.point(&vec![0.0; n]);
        let run = |&(k, distance): &(usize, f64)| {
            let mut normals = vec![0.0; n];
            normals[k] = distance;
            let inputs = self.inputs.point(&normals);
            let is_centre = |(x, centre): (&f64, &f64)| x.total_cmp(centre).is_eq();
            if inputs.iter().zip(&centre).all(is_centre) {
                // Along an input that is certain.
                return Ok(self.centre().to_vec());
            }
            let mut simulation = self.experiment.simulation(&inputs)?;
            let name = format!("run at {distance} along {k}");
            self.runs.follow(name, &mut simulation, &Plain, ()).map(|(values, ())| values)
        };
        map_in_order(&ends, &run).into_iter().collect()
    }
}

/// The `k`-th unit vector of `n` normals.
pub(super) fn unit(n: usize, k: usize) -> Vec<f64> {
    (0..n).map(|j| f64::from(u8::from(j == k))).collect()
}

/// Different directions of signs of the first normals, the first always `+`: all that there are, or as many as asked for.
pub(super) fn signs(n_normals: usize, n: usize) -> Vec<Vec<f64>> {
    if n_normals == 0 || n_normals > MOST_SIGNS {
        return Vec::new();
    }
    let n_different = 1_usize << (n_normals - 1);
    // An odd step visits each of a power of two once; this one goes to and fro.
    let step = n_different / 2 + 1 - (n_different / 2) % 2;
    let pattern = |index: usize| (index * step + n_different / 3) % n_different;
    let sign = |bits: usize, k: usize| if k > 0 && bits >> (k - 1) & 1 == 1 { -1.0 } else { 1.0 };
    (0..n.min(n_different))
        .map(|index| (0..n_normals).map(|k| sign(pattern(index), k)).collect())
        .collect()
}
