//! The runs of a plan: the reference run, and others that take its steps.

use super::keep::{Keep, SavingWitness};
use crate::error::Error;
use crate::number::CarriedNumber;
use crate::record::balance::{Balance, Balances};
use crate::record::gathered::{Plain, Reader, Record, Schedule, Witness};
use crate::record::observation::Plan;
use crate::simulation::Simulation;

/// A plan, the store of its runs, and the record of the reference run.
#[derive(Debug)]
pub(super) struct Runs<'a, const D: usize> {
    pub(super) plan: Plan<D>,
    keep: Option<&'a dyn Keep>,
    reference: Record<f64>,
    pub(super) balance: Vec<Balance<D>>,
}

impl<'a, const D: usize> Runs<'a, D> {
    /// Runs the reference, or resumes it where it was kept.
    pub(super) fn begin(
        simulation: &mut Simulation<f64, D>,
        plan: Plan<D>,
        keep: Option<&'a dyn Keep>,
    ) -> Result<Self, Error> {
        let (run, n_stops) = ("reference run".to_owned(), plan.stops().len());
        let windows = &plan.windows;
        let witness = Balances::new(simulation, windows);
        let mut kept = SavingWitness { keep, run, windows, schedule: None, n_stops, witness };
        let reference = simulation.record_by(&plan, None, &Plain, &mut kept)?;
        let balance = kept.witness.in_order();
        Ok(Self { plan, keep, reference, balance })
    }

    /// A run by the steps of the reference run, resumed where it was kept under its name, if it was.
    pub(super) fn follow<S: CarriedNumber, T: CarriedNumber, W: Witness<S, T, D>>(
        &self,
        run: String,
        simulation: &mut Simulation<S, D>,
        reader: &impl Reader<S, T, D>,
        witness: W,
    ) -> Result<(Vec<T>, W), Error> {
        let schedule = Some(self.schedule());
        let (keep, windows, n_stops) =
            (self.keep, &self.plan.windows, self.schedule().steps().len());
        let mut kept = SavingWitness { keep, run, windows, schedule, n_stops, witness };
        let record = simulation.record_by(&self.plan, schedule, reader, &mut kept)?;
        Ok((record.values, kept.witness))
    }

    /// A run by the steps of the reference run, shown at the begins and ends of windows.
    pub(super) fn show(
        &self,
        run: String,
        simulation: &mut Simulation<f64, D>,
        look: impl FnMut(f64, &Simulation<f64, D>),
    ) -> Result<(), Error> {
        struct Shown<F>(F);
        impl<F: FnMut(f64, &Simulation<f64, D>), const D: usize> Witness<f64, f64, D> for Shown<F> {
            fn stop(&mut self, time: f64, simulation: &Simulation<f64, D>) {
                (self.0)(time, simulation);
            }
        }
        self.follow(run, simulation, &Plain, Shown(look)).map(drop)
    }

    /// The responses of the reference run.
    pub(super) fn centre(&self) -> &[f64] {
        &self.reference.values
    }

    /// The steps of the reference run.
    pub(super) const fn schedule(&self) -> &Schedule {
        &self.reference.schedule
    }
}
