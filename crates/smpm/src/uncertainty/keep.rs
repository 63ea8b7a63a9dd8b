//! Saved runs: the state of a run as plain data, and where it is stored.

use std::error::Error as StdError;

use crate::error::Error;
use crate::number::CarriedNumber;
use crate::record::gathered::{Gathered, Schedule, Witness};
use crate::record::observation::{Located, Plan, Window, stops};
use crate::simulation::Simulation;

/// Stores the runs of a study, so that another study of the same experiment resumes them.
///
/// The crate touches no files and no clock: a store decides where saved runs go and how often, and distinguishes those of another
/// experiment, distribution or plan from its own. Several threads call it at once.
pub trait Keep: std::fmt::Debug + Sync {
    /// The run as it was last kept, if it was.
    ///
    /// # Errors
    /// An error of the store ends the study.
    fn load(&self, run: &str) -> Result<Option<SavedRun>, Box<dyn StdError + Send + Sync>>;

    /// Whether a run is to be kept now, of whose time a fraction is done. It is called after every step; at its end a run is kept
    /// in any case.
    fn is_due(&self, run: &str, done: f64) -> bool;

    /// Keeps a run in place of what was kept of it before.
    ///
    /// # Errors
    /// An error of the store ends the study.
    fn keep(&self, run: &str, saved: SavedRun) -> Result<(), Box<dyn StdError + Send + Sync>>;
}

/// A run under way or at its end: all that a bitwise identical continuation needs, with the same experiment and inputs. The plan
/// of the continuation may have more windows that begin later.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SavedRun {
    /// Begin and end of each window.
    windows: Vec<[f64; 2]>,
    /// By window: the parts of its sums, then the numbers of the witness.
    of_windows: Vec<Vec<f64>>,
    /// The numbers of the witness that belong to no one window.
    memory: Vec<f64>,
    /// The steps to each stop that the run has reached.
    steps: Vec<Vec<f64>>,
    /// The steps towards the next stop.
    taken: Vec<f64>,
    /// The snapshot of the simulation.
    snapshot: Vec<u8>,
}

impl SavedRun {
    /// Saves a run.
    fn of<S: CarriedNumber, T: CarriedNumber, const D: usize>(
        simulation: &Simulation<S, D>,
        gathered: &Gathered<T>,
        windows: &[Window],
        witness: &mut impl Witness<S, T, D>,
    ) -> Result<Self, Error> {
        let Gathered { values, steps, taken } = gathered;
        let of_window = |w: usize| {
            let sums = values.iter().skip(w).step_by(windows.len());
            let mut numbers: Vec<f64> =
                sums.flat_map(|sum| (0..T::PARTS).map(|part| sum.part(part))).collect();
            witness.visit_window(w, &mut |number| numbers.push(*number));
            numbers
        };
        let of_windows = (0..windows.len()).map(of_window).collect();
        let mut memory = vec![];
        witness.visit_memory(&mut |number| memory.push(*number));
        let mut snapshot = vec![];
        simulation.snapshot(&mut snapshot)?;
        let windows = windows.iter().map(|window| [window.from, window.to]).collect();
        let (steps, taken) = (steps.clone(), taken.clone());
        Ok(Self { windows, of_windows, memory, steps, taken, snapshot })
    }

    /// Cuts the run to a plan with these windows and stops; the number of each window of the plan among its own, if it has it.
    ///
    /// The steps to a stop follow from the stops before it, and from nothing else of a plan.
    fn cut_to(&mut self, windows: &[Window], to: &[f64]) -> Result<Vec<Option<usize>>, Error> {
        let ours = stops(self.windows.iter().flatten().copied());
        let other = || Error::OtherWindows { value: to.len(), limit: ours.len() };
        fits("windows", self.of_windows.len(), self.windows.len())?;
        let n_reached = self.steps.len();
        let Some(reached) = ours.get(..n_reached) else {
            return Err(foreign("stops", n_reached, ours.len()));
        };
        let n = n_reached.min(to.len());
        let is_under_way = !self.taken.is_empty();
        if reached[..n] != to[..n] || (is_under_way && n < to.len() && ours.get(n) != to.get(n)) {
            return Err(other());
        }
        let now = reached.last().copied().unwrap_or_default();
        // What begins now is read from the state of now.
        let is_ahead = |&Window { from, to }: &Window| {
            to > now && if is_under_way { from > now } else { from >= now }
        };
        let which = |window: &Window| {
            let is_it = |&[from, to]: &[f64; 2]| *window == Window { from, to };
            let known = self.windows.iter().position(is_it);
            if known.is_some() || is_ahead(window) { Ok(known) } else { Err(other()) }
        };
        let which = windows.iter().map(which).collect::<Result<_, _>>()?;
        if n == to.len() {
            self.steps.truncate(n);
            self.taken.clear();
        }
        Ok(which)
    }

    /// The steps must be those that the run is to take.
    fn check_steps(&self, schedule: Option<&Schedule>) -> Result<(), Error> {
        for (stop, steps) in self.steps.iter().enumerate() {
            let expected = schedule.map_or(steps, |schedule| &schedule.steps()[stop]);
            if steps.is_empty() || steps != expected {
                return Err(foreign("steps to a stop", steps.len(), expected.len().max(1)));
            }
        }
        if let Some(expected) = schedule.and_then(|it| it.steps().get(self.steps.len()))
            && (self.taken.len() >= expected.len() || !expected.starts_with(&self.taken))
        {
            return Err(foreign("steps towards a stop", self.taken.len(), expected.len()));
        }
        Ok(())
    }

    /// What the windows of a plan have gathered; the witness receives its earlier record.
    fn gathered<S, T: CarriedNumber, const D: usize>(
        self,
        plan: &Plan<D>,
        which: &[Option<usize>],
        witness: &mut impl Witness<S, T, D>,
    ) -> Result<Gathered<T>, Error> {
        let n_windows = plan.windows.len();
        let mut values = vec![T::constant(0.0); plan.n_responses()];
        for (w, of_window) in which.iter().enumerate() {
            let Some(mut numbers) = of_window.map(|known| self.of_windows[known].as_slice()) else {
                continue;
            };
            let mut n_noted = 0;
            witness.visit_window(w, &mut |_| n_noted += 1);
            let n_sums = T::PARTS * plan.gauges.len() * plan.quantities.len();
            fits("numbers of a window", numbers.len(), n_sums + n_noted)?;
            for sum in values.iter_mut().skip(w).step_by(n_windows) {
                *sum = T::from_parts(|part| numbers[part]);
                numbers = &numbers[T::PARTS..];
            }
            let mut noted = numbers.iter();
            witness.visit_window(w, &mut |number| number.clone_from(noted.next().unwrap_or(&0.0)));
        }
        let mut n_remembered = 0;
        witness.visit_memory(&mut |_| n_remembered += 1);
        fits("numbers that are remembered", self.memory.len(), n_remembered)?;
        let mut memory = self.memory.iter();
        witness.visit_memory(&mut |number| number.clone_from(memory.next().unwrap_or(&0.0)));
        Ok(Gathered { values, steps: self.steps, taken: self.taken })
    }
}

fn foreign(quantity: &'static str, found: usize, expected: usize) -> Error {
    Error::ForeignSnapshot { quantity, found, expected }
}

fn fits(quantity: &'static str, found: usize, expected: usize) -> Result<(), Error> {
    if found == expected { Ok(()) } else { Err(foreign(quantity, found, expected)) }
}

/// A witness that saves the run, if the study has a store.
pub(super) struct SavingWitness<'a, W> {
    pub(super) keep: Option<&'a dyn Keep>,
    /// The name of the run.
    pub(super) run: String,
    pub(super) windows: &'a [Window],
    /// The steps that it is to take, where they are known.
    pub(super) schedule: Option<&'a Schedule>,
    pub(super) n_stops: usize,
    pub(super) witness: W,
}

impl<W> SavingWitness<'_, W> {
    fn failed(&self, error: &(dyn StdError + Send + Sync)) -> Error {
        Error::NotKept { run: self.run.clone(), what: error.to_string() }
    }
}

impl<S: CarriedNumber, T: CarriedNumber, W: Witness<S, T, D>, const D: usize> Witness<S, T, D>
    for SavingWitness<'_, W>
{
    fn begin(
        &mut self,
        plan: &Plan<D>,
        simulation: &mut Simulation<S, D>,
    ) -> Result<Option<Gathered<T>>, Error> {
        let kept = self.keep.map_or(Ok(None), |keep| keep.load(&self.run));
        let Some(mut saved) = kept.map_err(|error| self.failed(error.as_ref()))? else {
            return Ok(None);
        };
        let which = saved.cut_to(&plan.windows, &plan.stops())?;
        saved.check_steps(self.schedule)?;
        if saved.steps.len() < self.n_stops {
            simulation.restore(saved.snapshot.as_slice())?;
            let n_steps: usize = saved.steps.iter().chain([&saved.taken]).map(Vec::len).sum();
            fits("steps", usize::try_from(simulation.n_steps()).unwrap_or(usize::MAX), n_steps)?;
        }
        Ok(Some(saved.gathered(plan, &which, &mut self.witness)?))
    }

    fn step(&mut self, simulation: &Simulation<S, D>, located: &[Located]) {
        self.witness.step(simulation, located);
    }

    fn stop(&mut self, time: f64, simulation: &Simulation<S, D>) {
        self.witness.stop(time, simulation);
    }

    fn gathered(
        &mut self,
        simulation: &Simulation<S, D>,
        gathered: &Gathered<T>,
    ) -> Result<(), Error> {
        let Some(keep) = self.keep else { return Ok(()) };
        let end = self.windows.iter().fold(0.0, |end: f64, window| end.max(window.to));
        let is_under_way = gathered.steps.len() < self.n_stops;
        if is_under_way && !keep.is_due(&self.run, simulation.time() / end) {
            return Ok(());
        }
        let saved = SavedRun::of(simulation, gathered, self.windows, &mut self.witness)?;
        keep.keep(&self.run, saved).map_err(|error| self.failed(error.as_ref()))
    }
}
