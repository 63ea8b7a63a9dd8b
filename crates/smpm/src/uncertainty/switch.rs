//! How near a gauge was to a switch between elastic and plastic.

use perturbation_moments::{Jet, LANES};

use crate::record::gathered::Witness;
use crate::record::observation::{Located, Window};
use crate::simulation::Simulation;

/// How near the particles of a gauge came to a switch between elastic and plastic: the least `abs f / sd(f)`, with the trial
/// overshoot `f` of the yield surface and its deviation by the first derivatives it carries.
///
/// Derivatives do not see what lies on the other side of a switch. Infinite where nothing yields or nothing is random.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Switch {
    /// At the last step of the window.
    pub at_end: f64,
    /// At any step up to the end of the window. Whatever has yielded once has passed through zero: this one warns of
    /// everything that is plastic.
    pub so_far: f64,
}

impl Switch {
    /// Below this many deviations a flag is raised.
    pub const LIMIT: f64 = 2.0;

    pub(super) const NONE: Self = Self { at_end: f64::INFINITY, so_far: f64::INFINITY };

    fn visit_numbers(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        visit(&mut self.at_end);
        visit(&mut self.so_far);
    }

    /// Of two passes over different parameters: variances add, `1/r^2 = 1/r_1^2 + 1/r_2^2`.
    pub(super) fn join(first: Vec<Vec<Self>>, second: &[Vec<Self>]) -> Vec<Vec<Self>> {
        let both = |a: f64, b: f64| 1.0 / a.recip().hypot(b.recip());
        let mut joined = first;
        for (a, b) in joined.iter_mut().flatten().zip(second.iter().flatten()) {
            *a = Self { at_end: both(a.at_end, b.at_end), so_far: both(a.so_far, b.so_far) };
        }
        joined
    }
}

/// Follows the overshoots of every gauge through a run with jets.
pub(super) struct SwitchWitness<'a, const D: usize> {
    windows: &'a [Window],
    /// Is shown the run at every begin and end of a window.
    look: &'a mut dyn FnMut(f64, &Simulation<Jet, D>),
    /// Lanes that are directions, not probes.
    n_directions: usize,
    now: Vec<Switch>,
    /// Of every gauge, by window.
    pub(super) at_windows: Vec<Vec<Switch>>,
}

impl<'a, const D: usize> SwitchWitness<'a, D> {
    pub(super) fn new(
        n_gauges: usize,
        windows: &'a [Window],
        n_directions: usize,
        look: &'a mut dyn FnMut(f64, &Simulation<Jet, D>),
    ) -> Self {
        Self {
            windows,
            look,
            n_directions: n_directions.min(LANES),
            now: vec![Switch::NONE; n_gauges],
            at_windows: vec![vec![Switch::NONE; windows.len()]; n_gauges],
        }
    }
}

impl<const D: usize> Witness<Jet, Jet, D> for SwitchWitness<'_, D> {
    fn step(&mut self, simulation: &Simulation<Jet, D>, located: &[Located]) {
        for (gauge, now) in located.iter().zip(&mut self.now) {
            let body = &simulation.bodies()[gauge.body];
            now.at_end = f64::INFINITY;
            for &(particle, _) in &gauge.particles {
                let f = body.observe(particle).overshoot;
                let square: f64 = f.first[..self.n_directions].iter().map(|d| d * d).sum();
                if square > 0.0 {
                    now.at_end = now.at_end.min(f.value.abs() / square.sqrt());
                }
            }
            now.so_far = now.so_far.min(now.at_end);
        }
    }

    fn stop(&mut self, time: f64, simulation: &Simulation<Jet, D>) {
        (self.look)(time, simulation);
        // Stops are exactly the ends of windows. A window that has ended receives no later step.
        let ends = |window: &Window| window.to.total_cmp(&time).is_eq();
        for (w, _) in self.windows.iter().enumerate().filter(|(_, window)| ends(window)) {
            for (at_windows, now) in self.at_windows.iter_mut().zip(&self.now) {
                at_windows[w] = *now;
            }
        }
    }

    fn visit_memory(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        self.now.iter_mut().for_each(|switch| switch.visit_numbers(visit));
    }

    fn visit_window(&mut self, window: usize, visit: &mut dyn FnMut(&mut f64)) {
        self.at_windows.iter_mut().for_each(|of| of[window].visit_numbers(visit));
    }
}
