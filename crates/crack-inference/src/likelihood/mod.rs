//! The likelihood of observed plates: Gaussian in their summaries, emulated over the parameters from ensembles at the points of a design.
//!
//! Nothing here knows priors or samplers.

pub(crate) mod emulator;
pub(crate) mod gaussian;
pub(crate) mod lack_of_fit;
pub(crate) mod mixture;
mod polynomial;
mod regressions;
