//! Runs over points of the unit cube, random or of low discrepancy, and the indices of sensitivity from them.
//!
//! Nothing here knows levels or rare events.

pub(crate) mod cube;
pub(crate) mod designed;
pub(crate) mod joe_kuo;
pub(crate) mod points;
pub(crate) mod quantile;
pub(crate) mod sensitivity;
