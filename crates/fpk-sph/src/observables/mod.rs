//! What is asked of a density: moments, probabilities of exceedance and of first passage, marginals, entropy.
//!
//! Three estimators of `P(y(x) > T)`, for a demand `y` and a threshold `T`; a general limit state `g(x) > 0` is the
//! demand `g` with the threshold 0:
//!
//! | estimator | error | tail | source |
//! |---|---|---|---|
//! | [`Simulation::exceedance_indicator`] | a staircase in `T`: up to one layer of particles, 0.07 in log10 at spacing 0.3 sigma | ends with the last particle | Canor & Denoël 2013, eq 25 |
//! | [`Simulation::exceedance_log_interpolated`] | smooth in `T`, else as the indicator | ends with the last particle | this project |
//! | [`CellIntegral::exceedance`] | that of the flow map; exact for a Gaussian | goes on beyond the last particle by the fit | this project |
//!
//! The density at any point: [`DensityField`].
//!
//! First passage up to a time, two ways:
//!
//! | estimator | what | cost | source |
//! |---|---|---|---|
//! | [`FirstPassage`] | the probability, by an absorbing boundary; any limit state, many thresholds at once | a tenth to a half of the steps it watches | this project |
//! | [`CellIntegral::crossing_rate`] with [`OutcrossingBound`] | an upper bound and the expected number of crossings; the demand must have a rate | a cell integral at every time recorded | Rice 1944 |
//!
//! A probability comes with what it rests on, or as a bound where no more is known: [`Probability`].
//!
//! An observable reads a simulation between its steps and changes nothing of it.
//!
//! [`Simulation::exceedance_indicator`]: crate::Simulation::exceedance_indicator
//! [`Simulation::exceedance_log_interpolated`]: crate::Simulation::exceedance_log_interpolated

mod absorption;
mod exchange;
mod first_passage;
mod moments;
mod survival;

pub use crate::density::cell_integral::{CellIntegral, Exceedance, TAIL_SPACINGS};
pub use crate::density::density_field::{DensityField, FIELD_REACH};
pub use crate::density::probability::Probability;
pub use first_passage::OutcrossingBound;
pub use survival::FirstPassage;
