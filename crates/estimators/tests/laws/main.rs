//! Properties of the estimators, through their public interface.

mod control;
mod multilevel;
