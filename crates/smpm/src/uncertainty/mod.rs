//! Random material parameters: mean and variance of every response, by eight methods on the same scene.
//!
//! | method | runs for `N` parameters | what it is |
//! |---|---|---|
//! | [`Study::frozen`] | 1 | Chen et al. 2019: derivatives of the material's formulas at the local state. Wrong wherever the state itself depends on the parameters: a baseline |
//! | [`Study::propagated`] | 1, of jets | every particle and node carries the derivatives of its history |
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
//! A constant that varies in space has any number of random coefficients. [`FieldStudy`] samples them, or computes the gradient of every
//! response by all of them, eight in each run of jets.
//!
//! A study that is [kept](Study::kept_by) resumes after an interruption, bitwise identically, where each of its runs was last kept.

mod design;
mod experiment;
mod field_moments;
mod field_study;
mod frozen;
mod keep;
mod range;
mod runs;
mod sampled;
mod study;
mod switch;

pub use design::Design;
pub use experiment::Experiment;
pub use field_moments::FieldMoments;
pub use field_study::{AlongFields, FieldExperiment, FieldGradient, FieldStudy};
pub use frozen::{FrozenForm, FrozenMoments};
pub use keep::{Keep, Standing};
pub use range::MOST_CHANCE_OUT_OF_RANGE;
pub use sampled::{Exceedance, Sampled};
pub use study::{Propagated, Study};
pub use switch::Switch;
