//! Records of runs, and their steps, for runs that are to take the same.

use crate::error::Error;
use crate::number::CarriedNumber;
use crate::record::observation::{Located, Plan, Quantity, Window};
use crate::simulation::Simulation;

/// The steps of a run between the instants at which it was looked at.
///
/// Steps follow the wave speed, which follows the parameters: runs that choose their own are not a smooth function of the
/// parameters. Jets, differences and samples repeat the steps of the reference run, so that all of them evaluate the same map.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    /// Begins and ends of windows, ascending, above zero (time).
    stops: Vec<f64>,
    /// The steps to each stop from the one before (time).
    steps: Vec<Vec<f64>>,
}

impl Schedule {
    /// How many steps it has in all.
    #[must_use]
    pub fn n_steps(&self) -> usize {
        self.steps.iter().map(Vec::len).sum()
    }

    /// The steps to each stop.
    pub(crate) fn steps(&self) -> &[Vec<f64>] {
        &self.steps
    }
}

/// The record of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Record<S> {
    /// The responses, in the order of the plan.
    pub values: Vec<S>,
    /// The steps that were taken.
    pub schedule: Schedule,
}

/// Sums of the windows and steps of a run under way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Gathered<T> {
    /// The sums of the windows, in the order of the plan.
    pub(crate) values: Vec<T>,
    /// The steps to each stop that it has come to.
    pub(crate) steps: Vec<Vec<f64>>,
    /// The steps towards the next stop.
    pub(crate) taken: Vec<f64>,
}

/// Observer of a run that is recorded.
pub(crate) trait Witness<S, T, const D: usize> {
    /// Before the first step: a resumed run takes the state of the run that gathered this.
    fn begin(
        &mut self,
        _plan: &Plan<D>,
        _simulation: &mut Simulation<S, D>,
    ) -> Result<Option<Gathered<T>>, Error> {
        Ok(None)
    }
    /// After every step.
    fn step(&mut self, _simulation: &Simulation<S, D>, _located: &[Located]) {}
    /// At an instant at which windows begin or end.
    fn stop(&mut self, _time: f64, _simulation: &Simulation<S, D>) {}
    /// After every step, at a stop after that.
    fn gathered(
        &mut self,
        _simulation: &Simulation<S, D>,
        _gathered: &Gathered<T>,
    ) -> Result<(), Error> {
        Ok(())
    }
    /// Calls with every number that it remembers of no one window: what is written there is remembered instead.
    fn visit_memory(&mut self, _visit: &mut dyn FnMut(&mut f64)) {}
    /// Calls with every number that it remembers of a window.
    fn visit_window(&mut self, _window: usize, _visit: &mut dyn FnMut(&mut f64)) {}
}

/// An observer that does nothing.
impl<S, T, const D: usize> Witness<S, T, D> for () {}

/// How a quantity is read at a gauge: in the numbers of the run, or in others.
pub(crate) trait Reader<S, T, const D: usize> {
    fn read(&self, run: &Simulation<S, D>, gauge: &Located, quantity: Quantity) -> T;
}

/// Reads quantities in the numbers of the run.
pub(crate) struct Plain;

impl<S: CarriedNumber, const D: usize> Reader<S, S, D> for Plain {
    fn read(&self, run: &Simulation<S, D>, gauge: &Located, quantity: Quantity) -> S {
        gauge.mean_over(|particle| quantity.read(&run.bodies()[gauge.body], particle))
    }
}

/// Sums up windows while a run goes on.
struct Windows<'a, T, R, const D: usize> {
    plan: &'a Plan<D>,
    located: &'a [Located],
    reader: &'a R,
    gathered: Gathered<T>,
}

impl<T: CarriedNumber, R, const D: usize> Windows<'_, T, R, D> {
    fn read<S: CarriedNumber>(&self, run: &Simulation<S, D>) -> Vec<T>
    where
        R: Reader<S, T, D>,
    {
        let quantities = &self.plan.quantities;
        let read = |gauge| quantities.iter().map(move |&q| self.reader.read(run, gauge, q));
        self.located.iter().flat_map(read).collect()
    }

    fn add(&mut self, seen: &[T], factor: impl Fn(&Window) -> Option<f64>) {
        for (w, window) in self.plan.windows.iter().enumerate() {
            let Some(factor) = factor(window) else { continue };
            for (entry, &value) in seen.iter().enumerate() {
                let sum = &mut self.gathered.values[entry * self.plan.windows.len() + w];
                *sum = *sum + value * factor;
            }
        }
    }

    fn instant<S: CarriedNumber>(&mut self, run: &Simulation<S, D>, time: f64)
    where
        R: Reader<S, T, D>,
    {
        let at = |window: &Window| (*window == Window::at(time)).then_some(1.0);
        if self.plan.windows.iter().any(|window| at(window).is_some()) {
            let seen = self.read(run);
            self.add(&seen, at);
        }
    }
}

impl<T: CarriedNumber, R, const D: usize> Windows<'_, T, R, D> {
    /// Runs to a stop from where the run is, which may be between the stop before it and this one.
    fn run_to<S: CarriedNumber>(
        &mut self,
        run: &mut Simulation<S, D>,
        (stops, number): (&[f64], usize),
        given: Option<&[f64]>,
        witness: &mut impl Witness<S, T, D>,
    ) -> Result<(), Error>
    where
        R: Reader<S, T, D>,
    {
        let (before, stop) = (number.checked_sub(1).map_or(0.0, |last| stops[last]), stops[number]);
        let averaged = |window: &Window| window.from <= before && window.to >= stop;
        let share = |window: &Window, dt: f64| {
            averaged(window).then(|| 0.5 * dt / (window.to - window.from))
        };
        let any = self.plan.windows.iter().any(averaged);
        let mut seen = if any { self.read(run) } else { vec![] };
        loop {
            let n_taken = self.gathered.taken.len();
            let (dt, last) = match given {
                Some(given) => (given[n_taken], n_taken + 1 == given.len()),
                None => run.step_towards(stop),
            };
            let _ = run.step_of(dt)?;
            self.gathered.taken.push(dt);
            if any {
                self.add(&seen, |window| share(window, dt));
                seen = self.read(run);
                self.add(&seen, |window| share(window, dt));
            }
            witness.step(run, self.located);
            if last {
                break;
            }
            witness.gathered(run, &self.gathered)?;
        }
        self.instant(run, stop);
        witness.stop(stop, run);
        Ok(())
    }
}

impl<S: CarriedNumber, const D: usize> Simulation<S, D> {
    /// Runs to the end of the last window of a plan; a window with a span is averaged by the trapezoidal rule over the steps.
    /// The simulation must be at its start. Gauges are found there, and go with the material.
    ///
    /// # Errors
    /// Those of the plan ([`Error::GaugeOutsideBody`], [`Error::WindowOrder`] and others), and of
    /// [`step_of`](Self::step_of).
    pub fn record(&mut self, plan: &Plan<D>) -> Result<Record<S>, Error> {
        self.record_by(plan, None, &Plain, &mut ())
    }

    /// As [`record`](Self::record), with the steps of an earlier run of the same plan.
    ///
    /// # Errors
    /// As [`record`](Self::record); [`Error::OtherWindows`] for a schedule of another plan; [`Error::Courant`] where one of its
    /// steps is too long here.
    pub fn replay(&mut self, plan: &Plan<D>, schedule: &Schedule) -> Result<Vec<S>, Error> {
        Ok(self.record_by(plan, Some(schedule), &Plain, &mut ())?.values)
    }

    pub(crate) fn record_by<T: CarriedNumber>(
        &mut self,
        plan: &Plan<D>,
        schedule: Option<&Schedule>,
        reader: &impl Reader<S, T, D>,
        witness: &mut impl Witness<S, T, D>,
    ) -> Result<Record<T>, Error> {
        if self.n_steps() > 0 {
            return Err(Error::NotAtStart { value: self.n_steps() });
        }
        let located = plan.resolve(self)?;
        let stops = plan.stops();
        if let Some(schedule) = schedule.filter(|schedule| schedule.stops != stops) {
            let (value, limit) = (stops.len(), schedule.stops.len());
            return Err(Error::OtherWindows { value, limit });
        }
        let past = witness.begin(plan, self)?;
        let is_new = past.is_none();
        let gathered = past.unwrap_or_else(|| Gathered {
            values: vec![T::constant(0.0); plan.n_responses()],
            steps: Vec::with_capacity(stops.len()),
            taken: vec![],
        });
        let mut windows = Windows { plan, located: &located, reader, gathered };
        if is_new {
            windows.instant(self, 0.0);
        }
        for number in windows.gathered.steps.len()..stops.len() {
            let given = schedule.map(|schedule| schedule.steps[number].as_slice());
            windows.run_to(self, (&stops, number), given, witness)?;
            let taken = std::mem::take(&mut windows.gathered.taken);
            windows.gathered.steps.push(taken);
            witness.gathered(self, &windows.gathered)?;
        }
        let Gathered { values, steps, .. } = windows.gathered;
        Ok(Record { values, schedule: Schedule { stops, steps } })
    }
}
