//! What a run of a density scene shows: values with errors, `result.json`, answers, page, pictures.
//!
//! It computes no value and knows no solver.

pub(crate) mod answers;
pub(crate) mod charts;
pub(crate) mod findings;
pub(crate) mod motion;
pub(crate) mod observed;
pub(crate) mod pictures;
pub(crate) mod record;
