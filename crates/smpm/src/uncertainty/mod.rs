//! Random inputs: mean and variance of every response, by eight methods on the same experiment. The inputs are parameters of
//! materials ([`RandomVector`](perturbation_moments::RandomVector)), or any number of [`Coefficients`] of random fields.
//!
//! | method | runs for `N` inputs | what it is |
//! |---|---|---|
//! | [`Study::frozen`] | 1 | Chen et al. 2019: derivatives of the material's formulas at the local state. Wrong wherever the state itself depends on the parameters: a baseline |
//! | [`Study::propagated`] | `N/8`, of jets | every particle and node carries the derivatives of its history |
//! | [`Study::finite_difference`] | `2N + 1` | central differences of whole runs |
//! | [`Study::forward_difference`] | `N + 1` | one-sided differences of whole runs: the variance by the fewest runs, no second-order mean |
//! | [`Study::sigma_points`] | `2N + 1` | three deviations wide: notices a switch |
//! | [`Study::monte_carlo`] | as many as asked for | independent samples, raw and with a Taylor surrogate as control variate |
//! | [`Study::sampled`] by [`Design::QuasiRandom`] | as many as asked for | replicas of scrambled Sobol' points, raw and with the same control variate: a smaller error where the response is smooth |
//! | [`Study::sampled`] by [`Design::SobolIndices`] | `n R (N + 2)` | which parameter causes how much of the variance |
//!
//! Derivatives are by independent standard normals `t`, with the parameters $x = x(L t)$ of a
//! [`RandomVector`](perturbation_moments::RandomVector), so that correlation and lognormal laws are in them.
//!
//! [`Study::series_errors`] measures the errors of differences by up to eight runs that they have not used.
//!
//! A room may know the grid, bodies and records of a run only through [`Simulation`](crate::Simulation); it touches no files and
//! no clock.
//!
//! A study that is [kept](Study::kept_by) resumes after an interruption, bitwise identically, where each of its runs was last kept.

mod design;
mod experiment;
mod frozen;
mod inputs;
mod keep;
mod range;
mod residual;
mod runs;
mod sampled;
mod series;
mod study;
mod switch;

pub use design::Design;
pub use experiment::{Experiment, exactly};
pub use frozen::FrozenForm;
pub use inputs::{Coefficients, Inputs};
pub use keep::{Keep, SavedRun};
pub use range::MOST_CHANCE_OUT_OF_RANGE;
pub use residual::SeriesError;
pub use sampled::{MOST_FAILED, Sampled, exceedance_of_normal};
pub use series::Series;
pub use study::{Propagated, Study};
pub use switch::Switch;
