//! Begin of a step.

use crate::time::state::Previous;
use vibrating_systems::matrix::Matrix;

/// Begin of a step, and its length.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Begin<'a, const D: usize> {
    pub(crate) t: f64,
    pub(crate) x: &'a [[f64; D]],
    /// Memory of a scheme of two steps.
    pub(crate) previous: Option<&'a Previous<D>>,
    /// `A`, the linear part of the drift; zero where the system declares none.
    pub(crate) linear: Matrix<D>,
    pub(crate) dt: f64,
}
