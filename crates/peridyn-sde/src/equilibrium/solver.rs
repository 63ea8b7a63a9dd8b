//! Preconditioned conjugate gradients.

use crate::error::Error;

/// How a solution ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stop {
    /// After so many iterations.
    Solved(usize),
    /// The residual that is left.
    Stalled(f64),
    /// A direction without stiffness.
    Singular,
}

/// A direction whose stiffness over the largest is less has none: roundoff of sums of some hundred forces.
const NO_STIFFNESS: f64 = 1e-14;

/// Buffers of the solver.
#[derive(Debug, Default)]
pub(super) struct Solver {
    /// The residual, before a system is solved.
    pub(super) residual: Vec<f64>,
    preconditioned: Vec<f64>,
    direction: Vec<f64>,
    image: Vec<f64>,
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(super) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

impl Solver {
    /// Adds `A^-1 r` to `x`, until the residual `r` is at most `limit`; `stiffness` is about the largest eigenvalue of `A`.
    pub(super) fn solve(
        &mut self,
        x: &mut [f64],
        (limit, most): (f64, usize),
        stiffness: f64,
        mut precondition: impl FnMut(&[f64], &mut [f64]),
        mut apply: impl FnMut(&[f64], &mut [f64]) -> Result<(), Error>,
    ) -> Result<Stop, Error> {
        let Self { residual, preconditioned, direction, image } = self;
        for buffer in [&mut *preconditioned, direction, image] {
            buffer.clear();
            buffer.resize(residual.len(), 0.0);
        }
        let (mut last, mut iteration) = (1.0, 0);
        loop {
            let left = norm(residual);
            if left <= limit {
                return Ok(Stop::Solved(iteration));
            }
            if iteration == most || !left.is_finite() {
                return Ok(Stop::Stalled(left));
            }
            precondition(residual, preconditioned);
            let next = dot(residual, preconditioned);
            let beta = if iteration == 0 { 0.0 } else { next / last };
            last = next;
            for (p, z) in direction.iter_mut().zip(&*preconditioned) {
                *p = z + beta * *p;
            }
            apply(direction, image)?;
            let curvature = dot(direction, image);
            let none = NO_STIFFNESS * stiffness * dot(direction, direction);
            if curvature.is_nan() || curvature <= none {
                return Ok(Stop::Singular);
            }
            let alpha = next / curvature;
            for ((x, r), (p, a)) in
                x.iter_mut().zip(residual.iter_mut()).zip(direction.iter().zip(&*image))
            {
                *x += alpha * p;
                *r -= alpha * a;
            }
            iteration += 1;
        }
    }
}
