//! Conjugate gradients, lane by lane.

use crate::error::Error;
use crate::real::Real;

/// Iterations after which the solver gives up.
const MOST_ITERATIONS: usize = 2000;

/// A solver with its buffers.
#[derive(Debug, Default)]
pub(super) struct ConjugateGradients<T> {
    pub(super) solution: Vec<T>,
    /// The right-hand side, before a system is solved.
    pub(super) residual: Vec<T>,
    /// `p`.
    direction: Vec<T>,
    /// `A p`.
    image: Vec<T>,
}

impl<T: Real> ConjugateGradients<T> {
    /// Solves `A y = b` from `y = 0`, with `b` in `residual`; `apply(p, image)` computes `A p`. Each lane has coefficients of its
    /// own and stops changing once it is solved, so that lanes are independent.
    pub(super) fn solve<const L: usize>(
        &mut self,
        step: u64,
        mut apply: impl FnMut(&[T], &mut Vec<T>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let limit = T::SOLVED;
        let Self { solution, residual, direction, image } = self;
        solution.clear();
        solution.resize(residual.len(), T::ZERO);
        direction.clone_from(residual);
        let mut square = dots::<T, L>(residual, residual);
        let start = square;
        if start.iter().any(|square| !square.is_finite()) {
            // A right-hand side without a finite square has no solution within any tolerance.
            let (step, residual) = (step + 1, f64::INFINITY);
            return Err(Error::NotSolved { step, residual, iterations: 0, limit });
        }
        for _ in 0..MOST_ITERATIONS {
            let open: [bool; L] =
                std::array::from_fn(|lane| square[lane] > limit * limit * start[lane]);
            if !open.contains(&true) {
                return Ok(());
            }
            apply(direction, image)?;
            let curvature = dots::<T, L>(direction, image);
            let alpha = ratios(open, square, curvature);
            add_multiple(solution, direction, alpha);
            add_multiple(residual, image, alpha.map(|a| -a));
            let next = dots::<T, L>(residual, residual);
            let beta = ratios(open, next, square);
            let directions = direction.as_chunks_mut::<L>().0.iter_mut();
            for (p, r) in directions.zip(residual.as_chunks::<L>().0) {
                for lane in 0..L {
                    p[lane] = r[lane] + T::of(beta[lane]) * p[lane];
                }
            }
            for lane in (0..L).filter(|&lane| open[lane]) {
                square[lane] = next[lane];
            }
        }
        let worst = (0..L).map(|lane| (square[lane] / start[lane]).sqrt()).fold(0.0, f64::max);
        let (step, iterations) = (step + 1, MOST_ITERATIONS);
        Err(Error::NotSolved { step, residual: worst, iterations, limit })
    }
}

/// Over lanes, `sum a b`.
fn dots<T: Real, const L: usize>(a: &[T], b: &[T]) -> [f64; L] {
    let mut sums = [0.0; L];
    for (a, b) in a.as_chunks::<L>().0.iter().zip(b.as_chunks::<L>().0) {
        for lane in 0..L {
            sums[lane] += a[lane].to_f64() * b[lane].to_f64();
        }
    }
    sums
}

fn ratios<const L: usize>(open: [bool; L], a: [f64; L], b: [f64; L]) -> [f64; L] {
    std::array::from_fn(|lane| if open[lane] { a[lane] / b[lane] } else { 0.0 })
}

/// `a += factor b`.
fn add_multiple<T: Real, const L: usize>(a: &mut [T], b: &[T], factor: [f64; L]) {
    for (a, b) in a.as_chunks_mut::<L>().0.iter_mut().zip(b.as_chunks::<L>().0) {
        for lane in 0..L {
            a[lane] += T::of(factor[lane]) * b[lane];
        }
    }
}
