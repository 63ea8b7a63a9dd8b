//! Properties of the estimators, through their public interface.

mod control;
mod cube;
mod multifidelity;
mod multilevel;
