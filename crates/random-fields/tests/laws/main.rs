//! Properties of random fields, through their public interface.

#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    reason = "a failed test may panic; exact values are exact"
)]

mod conditioned;
mod eigenvalues;
mod gaussian_field;
mod marginal;
mod random_field;
mod refusals;
mod sampled;
