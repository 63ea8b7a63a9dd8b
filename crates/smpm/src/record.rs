//! A run that is looked at, and its steps, for runs that are to take the same.

use crate::error::Error;
use crate::number::Number;
use crate::observation::{Located, Plan, Quantity, Window};
use crate::simulation::Simulation;

/// The steps of a run between the instants at which it was looked at.
///
/// Steps follow the wave speed, which follows the parameters: runs that choose their own are not a smooth function of the
/// parameters. Jets, differences and samples take the steps of the mean run, so that they all see the same map.
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
}

/// What a run has shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Record<S> {
    /// The responses, in the order of the plan.
    pub values: Vec<S>,
    /// The steps that were taken.
    pub schedule: Schedule,
}

/// Who looks on while a run is recorded.
pub(crate) trait Witness<S, const D: usize> {
    /// After every step.
    fn step(&mut self, _simulation: &Simulation<S, D>, _located: &[Located]) {}
    /// At an instant at which windows begin or end.
    fn stop(&mut self, _time: f64, _simulation: &Simulation<S, D>) {}
}

/// Nobody.
impl<S, const D: usize> Witness<S, D> for () {}

/// Stops of a plan: all its edges but zero, ascending.
fn stops(windows: &[Window]) -> Vec<f64> {
    let mut stops: Vec<f64> =
        windows.iter().flat_map(|w| [w.from, w.to]).filter(|&time| time > 0.0).collect();
    stops.sort_by(f64::total_cmp);
    stops.dedup();
    stops
}

/// How a quantity is read at a gauge: in the numbers of the run, or in others.
pub(crate) trait Reader<S, T, const D: usize> {
    fn read(&self, run: &Simulation<S, D>, gauge: &Located, quantity: Quantity) -> T;
}

/// As it stands.
struct Plain;

impl<S: Number, const D: usize> Reader<S, S, D> for Plain {
    fn read(&self, run: &Simulation<S, D>, gauge: &Located, quantity: Quantity) -> S {
        gauge.mean_over(|particle| quantity.read(&run.bodies()[gauge.body], particle))
    }
}

/// Sums up windows while a run goes on.
struct Windows<'a, T, R, const D: usize> {
    plan: &'a Plan<D>,
    located: &'a [Located],
    reader: &'a R,
    values: Vec<T>,
}

impl<T: Number, R, const D: usize> Windows<'_, T, R, D> {
    fn read<S: Number>(&self, run: &Simulation<S, D>) -> Vec<T>
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
                let sum = &mut self.values[entry * self.plan.windows.len() + w];
                *sum = *sum + value * factor;
            }
        }
    }

    fn instant<S: Number>(&mut self, run: &Simulation<S, D>, time: f64)
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

impl<S: Number, const D: usize> Simulation<S, D> {
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

    /// As [`replay`](Self::replay), with a witness.
    pub(crate) fn replay_before(
        &mut self,
        plan: &Plan<D>,
        schedule: &Schedule,
        witness: &mut impl Witness<S, D>,
    ) -> Result<Vec<S>, Error> {
        Ok(self.record_by(plan, Some(schedule), &Plain, witness)?.values)
    }

    pub(crate) fn record_by<T: Number>(
        &mut self,
        plan: &Plan<D>,
        schedule: Option<&Schedule>,
        reader: &impl Reader<S, T, D>,
        witness: &mut impl Witness<S, D>,
    ) -> Result<Record<T>, Error> {
        if self.n_steps() > 0 {
            return Err(Error::NotAtStart { value: self.n_steps() });
        }
        let located = plan.resolve(self)?;
        let stops = stops(&plan.windows);
        if let Some(schedule) = schedule.filter(|schedule| schedule.stops != stops) {
            let (value, limit) = (stops.len(), schedule.stops.len());
            return Err(Error::OtherWindows { value, limit });
        }
        let values = vec![T::constant(0.0); plan.n_responses()];
        let mut windows = Windows { plan, located: &located, reader, values };
        windows.instant(self, 0.0);
        let (mut before, mut steps) = (0.0, Vec::with_capacity(stops.len()));
        for (number, &stop) in stops.iter().enumerate() {
            let averaged = |window: &Window| window.from <= before && window.to >= stop;
            let share = |window: &Window, dt: f64| {
                averaged(window).then(|| 0.5 * dt / (window.to - window.from))
            };
            let any = plan.windows.iter().any(averaged);
            let given = schedule.map(|schedule| schedule.steps[number].as_slice());
            let mut seen = if any { windows.read(self) } else { vec![] };
            let mut taken = Vec::new();
            loop {
                let (dt, last) = match given {
                    Some(given) => (given[taken.len()], taken.len() + 1 == given.len()),
                    None => self.step_towards(stop),
                };
                let _ = self.step_of(dt)?;
                taken.push(dt);
                if any {
                    windows.add(&seen, |window| share(window, dt));
                    seen = windows.read(self);
                    windows.add(&seen, |window| share(window, dt));
                }
                witness.step(self, &located);
                if last {
                    break;
                }
            }
            windows.instant(self, stop);
            witness.stop(stop, self);
            steps.push(taken);
            before = stop;
        }
        Ok(Record { values: windows.values, schedule: Schedule { stops, steps } })
    }
}
