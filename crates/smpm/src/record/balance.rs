//! The balance of a run: what the bodies hold, and what gravity and planes have given to them.

use crate::number::CarriedNumber;
use crate::record::external::External;
use crate::record::gathered::Witness;
use crate::record::observation::Window;
use crate::simulation::{Ledger, Simulation};

/// The balance of a run at an instant.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct Balance<const D: usize> {
    /// The instant (time).
    pub time: f64,
    /// What the bodies hold.
    pub held: Ledger<D>,
    /// What has been given to them since the start.
    pub external: External<D>,
}

impl<const D: usize> Balance<D> {
    fn visit_numbers(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        let Ledger { mass, momentum, kinetic, internal, failed } = &mut self.held;
        [mass, kinetic, internal, failed].into_iter().for_each(&mut *visit);
        momentum.iter_mut().for_each(&mut *visit);
        self.external.visit_numbers(visit);
    }
}

impl<S: CarriedNumber, const D: usize> Simulation<S, D> {
    /// What the bodies hold now, and what has been given to them.
    pub fn balance(&self) -> Balance<D> {
        Balance { time: self.time(), held: self.ledger(), external: self.external().clone() }
    }
}

/// The balance at the start of a run and at the end of each window.
#[derive(Debug, Clone)]
pub(crate) struct Balances<const D: usize> {
    start: Balance<D>,
    at_ends: Vec<Balance<D>>,
}

impl<const D: usize> Balances<D> {
    /// Of a run at its start.
    pub(crate) fn new(simulation: &Simulation<f64, D>, windows: &[Window]) -> Self {
        let start = simulation.balance();
        let at = |window: &Window| Balance { time: window.to, ..start.clone() };
        Self { at_ends: windows.iter().map(at).collect(), start }
    }

    /// In the order of time, each instant once.
    pub(crate) fn in_order(self) -> Vec<Balance<D>> {
        let mut all = [vec![self.start], self.at_ends].concat();
        all.sort_by(|a, b| a.time.total_cmp(&b.time));
        all.dedup_by(|later, earlier| later.time <= earlier.time);
        all
    }
}

impl<T: CarriedNumber, const D: usize> Witness<f64, T, D> for Balances<D> {
    fn stop(&mut self, time: f64, simulation: &Simulation<f64, D>) {
        let is_now = |at: &&mut Balance<D>| at.time.to_bits() == time.to_bits();
        for at in self.at_ends.iter_mut().filter(is_now) {
            *at = simulation.balance();
        }
    }

    fn visit_window(&mut self, window: usize, visit: &mut dyn FnMut(&mut f64)) {
        self.at_ends[window].visit_numbers(visit);
    }
}
