//! The state of a simulation: what a step changes.

use crate::error::Error;

/// What a step changes; all that a snapshot must hold.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct State<const D: usize> {
    pub(crate) time: f64,
    pub(crate) n_steps: u64,
    pub(crate) n_remaps: u64,
    pub(crate) positions: Vec<[f64; D]>,
    pub(crate) masses: Vec<f64>,
    /// `h_i`, in the coordinates of the metric.
    pub(crate) smoothing_lengths: Vec<f64>,
    /// `h_0i / V_0i^(1/D)`, the product that eq 20 keeps.
    pub(crate) smoothing_ratios: Vec<f64>,
    /// What a scheme of two steps remembers; none before its first.
    pub(crate) previous: Option<Previous<D>>,
}

/// Memory of a scheme of two steps.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Previous<const D: usize> {
    /// Rates without the linear part (Adams-Bashforth), one step ago.
    pub(crate) values: Vec<[f64; D]>,
    /// The step from there to the present state.
    pub(crate) dt: f64,
}

/// All coordinates, each with the number of its point.
fn coordinates<const D: usize>(points: &[[f64; D]]) -> impl Iterator<Item = (usize, f64)> {
    points.iter().enumerate().flat_map(|(i, point)| point.iter().map(move |&value| (i, value)))
}

impl<const D: usize> State<D> {
    /// Whether numbers out of a snapshot are such as a simulation has.
    pub(crate) fn check_restored(&self, places: &[[f64; D]]) -> Result<(), Error> {
        let fits = |quantity, particle, value: f64, is_right: bool, must| {
            let error = Error::SnapshotNumber { quantity, particle, value, must };
            if is_right { Ok(()) } else { Err(error) }
        };
        fits("time", 0, self.time, self.time.is_finite(), "finite")?;
        for (i, &mass) in self.masses.iter().enumerate() {
            fits("mass", i, mass, mass.is_finite(), "finite")?;
        }
        let before = self.previous.as_ref().map_or(&[][..], |previous| &previous.values);
        for (quantity, points) in [("position", &self.positions[..]), ("rate one step ago", before)]
        {
            for (i, value) in coordinates(points) {
                fits(quantity, i, value, value.is_finite(), "finite")?;
            }
        }
        for (i, value) in coordinates(places) {
            // No place is as far out as where indices end.
            let is_right = value.fract() == 0.0 && value.abs() < f64::from(i32::MAX);
            fits("place", i, value, is_right, "a whole number of 31 bits")?;
        }
        let dt = self.previous.as_ref().map_or(1.0, |previous| previous.dt);
        fits("previous_dt", 0, dt, dt > 0.0 && dt.is_finite(), "above 0 and finite")
    }

    /// Keeps rates for the step after one of length `dt`.
    pub(crate) fn remember_rates(&mut self, rates: &[[f64; D]], dt: f64) {
        match &mut self.previous {
            Some(previous) => {
                previous.values.copy_from_slice(rates);
                previous.dt = dt;
            }
            None => self.previous = Some(Previous { values: rates.to_vec(), dt }),
        }
    }
}
