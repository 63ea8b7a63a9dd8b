//! Properties of the estimators, through their public interface.

#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    clippy::unnecessary_wraps,
    clippy::trivially_copy_pass_by_ref,
    reason = "a failed test may panic; exact values are exact; signatures are those of the interface"
)]

mod control;
mod cube;
mod designed;
mod multilevel;
mod polynomial;
mod quantal_response;
mod quantiles;
mod tails;
