//! Configuration and errors of the grid solver.

use crate::density::remap::Axis;

/// Resolution and extent of the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridConfig {
    /// Cells along each axis.
    pub cells: usize,
    /// Half the edge of the square, in standard deviations along the widest direction.
    pub reach: f64,
    /// `2 pi/omega`: period at which the oscillator rotates exactly (time).
    pub period: f64,
    /// Minimum number of steps per period.
    pub steps_per_period: f64,
}

/// Fewest cells along an axis: two per standard deviation at a reach of 4.
const FEWEST_CELLS: usize = 16;
/// Most cells along an axis: the grid then takes half a gigabyte.
const MOST_CELLS: usize = 8_192;

/// Error of the grid solver.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum GridError {
    /// A parameter is out of its range.
    #[error("{name} is {value}; it must be {limit}")]
    OutOfRange {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The admissible range.
        limit: &'static str,
    },
    /// Noise acts on the displacement; the scheme supports noise on the velocity alone.
    #[error("the noise has an entry {value} on the displacement at t = {time}; it must be 0")]
    NoiseOnDisplacement {
        /// Time of the evaluation.
        time: f64,
        /// The entry.
        value: f64,
    },
    /// The system is no oscillator: `q' = v` does not hold.
    #[error(
        "the drift of the displacement is {value} at t = {time}; it must be the velocity {limit}"
    )]
    NoOscillator {
        /// Time of the evaluation.
        time: f64,
        /// The drift found.
        value: f64,
        /// The velocity, which it must equal.
        limit: f64,
    },
    /// An output time is before the current time.
    #[error("the output time {value} is before the current time {limit}")]
    Time {
        /// The requested time.
        value: f64,
        /// The current time.
        limit: f64,
    },
    /// A moment of the density or a path is not finite, or the width is zero.
    #[error(
        "at t = {time} the {what} of the density is {value}; it must be finite, and a variance positive"
    )]
    Collapsed {
        /// Time of the evaluation.
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
        // A rotation by three shears must be less than half a turn.
        if !(steps_per_period >= 4.0 && steps_per_period.is_finite()) {
            return refuse("steps_per_period", steps_per_period, "at least 4 and finite");
        }
        Ok(())
    }

    pub(crate) fn frequency(&self) -> f64 {
        std::f64::consts::TAU / self.period
    }

    /// Axes with the requested extent along the widest direction, in the coordinates in which the oscillator rotates.
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
