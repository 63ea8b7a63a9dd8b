//! How the grid solver is set up, and what it refuses.

use crate::remap::Axis;

/// How fine the grid is, and how far it goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridConfig {
    /// Cells along each axis.
    pub cells: usize,
    /// Half the edge of the square, in standard deviations along the widest direction.
    pub reach: f64,
    /// `2 pi/omega`: the period at which the oscillator turns exactly (time).
    pub period: f64,
    /// Steps per period at the least.
    pub steps_per_period: f64,
}

/// Fewest cells along an axis: two per standard deviation at a reach of 4.
const FEWEST_CELLS: usize = 16;
/// Most cells along an axis: the grid then takes half a gigabyte.
const MOST_CELLS: usize = 8_192;

/// Why there is no density.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum GridError {
    /// A parameter is out of its range.
    #[error("{name} is {value}; it must be {limit}")]
    OutOfRange {
        /// Which.
        name: &'static str,
        /// What was given.
        value: f64,
        /// What is allowed.
        limit: &'static str,
    },
    /// The scheme knows noise on the velocity alone.
    #[error("the noise has an entry {value} on the displacement at t = {time}; it must be 0")]
    NoiseOnDisplacement {
        /// When.
        time: f64,
        /// The entry.
        value: f64,
    },
    /// The scheme knows oscillators alone.
    #[error(
        "the drift of the displacement is {value} at t = {time}; it must be the velocity {limit}"
    )]
    NoOscillator {
        /// When.
        time: f64,
        /// What it is.
        value: f64,
        /// What it must be.
        limit: f64,
    },
    /// Time goes forward.
    #[error("the output time {value} is before the present time {limit}")]
    Time {
        /// What was asked.
        value: f64,
        /// The present time.
        limit: f64,
    },
    /// A moment of the density or a path is no number, or the width is zero.
    #[error(
        "at t = {time} the {what} of the density is {value}; it must be finite, and a variance positive"
    )]
    Collapsed {
        /// When.
        time: f64,
        /// Mean, variance or path.
        what: &'static str,
        /// The value.
        value: f64,
    },
}

/// First and second moments.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spread {
    pub(crate) mean: [f64; 2],
    pub(crate) qq: f64,
    pub(crate) qv: f64,
    pub(crate) vv: f64,
}

impl GridConfig {
    pub(crate) fn check(&self) -> Result<(), GridError> {
        let Self { cells, reach, period, steps_per_period } = *self;
        let refuse = |name, value, limit| Err(GridError::OutOfRange { name, value, limit });
        if !(FEWEST_CELLS..=MOST_CELLS).contains(&cells) {
            return refuse("cells", cells as f64, "from 16 to 8192");
        }
        for (name, value) in [("reach", reach), ("period", period)] {
            if !(value > 0.0 && value.is_finite()) {
                return refuse(name, value, "greater than 0 and finite");
            }
        }
        // A rotation by three shears must stay below half a turn.
        if !(steps_per_period >= 4.0 && steps_per_period.is_finite()) {
            return refuse("steps_per_period", steps_per_period, "at least 4 and finite");
        }
        Ok(())
    }

    pub(crate) fn frequency(&self) -> f64 {
        std::f64::consts::TAU / self.period
    }

    /// Axes that reach as far as asked along the widest direction, in the coordinates in which the oscillator turns.
    pub(crate) fn axes(&self, spread: &Spread, time: f64) -> Result<(Axis, Axis), GridError> {
        let omega = self.frequency();
        let Spread { mean, qq, qv, vv } = *spread;
        let (vv, qv) = (vv / (omega * omega), qv / omega);
        let largest = 0.5 * (qq + vv) + (0.25 * (qq - vv) * (qq - vv) + qv * qv).sqrt();
        for (what, value) in [("mean of q", mean[0]), ("mean of v", mean[1])] {
            if !value.is_finite() {
                return Err(GridError::Collapsed { time, what, value });
            }
        }
        if !(largest > 0.0 && largest.is_finite()) {
            return Err(GridError::Collapsed { time, what: "variance", value: largest });
        }
        let half = self.reach * largest.sqrt();
        Ok((Axis::new(mean[0], half, self.cells), Axis::new(mean[1], omega * half, self.cells)))
    }
}
