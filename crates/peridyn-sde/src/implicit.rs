//! Linearly implicit steps.

use crate::body::{AtStrength, Body};
use crate::error::Error;
use crate::real::Real;
use crate::simulation::Simulation;
use crate::update::Which;

/// Iterations after which a system is given up.
const MOST_ITERATIONS: usize = 2000;

impl<T: Real, B: Body<T, D, L>, const D: usize, const L: usize> Simulation<T, B, D, L> {
    /// Solves `(1 + theta h L^T K L) y = h L^T F(u) + sqrt(2 kT h) z` and moves by `L y`: the same as
    /// `(1 + theta h M K) du = h M F(u) + sqrt(2 kT h) L z`, but symmetric.
    pub(crate) fn theta_step(&mut self, theta: f64) -> Result<(), Error> {
        self.evaluate(AtStrength::Break)?;
        let (dt, temperature) = (self.config.dt, self.config.dynamics.temperature());
        let [mut y, mut residual, mut p, mut image] =
            std::array::from_fn(|at| std::mem::take(&mut self.unknowns.work[at]));
        self.pulls(&mut residual)?;
        let (h, amplitude) = (T::of(dt), T::of((2.0 * temperature * dt).sqrt()));
        if temperature > 0.0 {
            self.kicks.draw(Which::Step(self.step), &mut p);
        } else {
            p.clear();
            p.resize(residual.len(), T::ZERO);
        }
        for (r, &z) in residual.iter_mut().zip(&p) {
            *r = h * *r + amplitude * z;
        }
        self.conjugate_gradients(theta, [&mut y, &mut residual, &mut p, &mut image])?;
        self.kicks.forth(&self.resistance, &mut y)?;
        for (u, &moved) in self.unknowns.u.iter_mut().zip(&y) {
            *u += moved;
        }
        self.unknowns.work = [y, residual, p, image];
        self.finish()
    }

    /// `L^T (F + loads - epsilon u)`.
    fn pulls(&mut self, out: &mut Vec<T>) -> Result<(), Error> {
        self.total_forces(self.time);
        out.clone_from(&self.unknowns.drift);
        self.kicks.back(&self.resistance, out)
    }

    /// From `y = 0`; `residual` comes as the right-hand side. Each lane has coefficients of its own, and stands still once it is
    /// solved, so that lanes do not know of each other.
    fn conjugate_gradients(
        &mut self,
        theta: f64,
        [y, residual, p, image]: [&mut Vec<T>; 4],
    ) -> Result<(), Error> {
        let limit = T::SOLVED;
        y.clear();
        y.resize(residual.len(), T::ZERO);
        p.clone_from(residual);
        let mut square = dots::<T, L>(residual, residual);
        let start = square;
        if start.iter().any(|square| !square.is_finite()) {
            // Of forces whose squares are no numbers there is nothing to solve, and nothing that would be nearer than any limit.
            let (step, residual) = (self.step + 1, f64::INFINITY);
            return Err(Error::NotSolved { step, residual, iterations: 0, limit });
        }
        for _ in 0..MOST_ITERATIONS {
            let open: [bool; L] =
                std::array::from_fn(|lane| square[lane] > limit * limit * start[lane]);
            if !open.contains(&true) {
                return Ok(());
            }
            self.implicit_image(theta, p, image)?;
            let curvature = dots::<T, L>(p, image);
            let alpha = ratios(open, square, curvature);
            along(y, p, alpha);
            along(residual, image, alpha.map(|a| -a));
            let next = dots::<T, L>(residual, residual);
            let beta = ratios(open, next, square);
            for (p, r) in p.as_chunks_mut::<L>().0.iter_mut().zip(residual.as_chunks::<L>().0) {
                for lane in 0..L {
                    p[lane] = r[lane] + T::of(beta[lane]) * p[lane];
                }
            }
            for lane in (0..L).filter(|&lane| open[lane]) {
                square[lane] = next[lane];
            }
        }
        let worst = (0..L).map(|lane| (square[lane] / start[lane]).sqrt()).fold(0.0, f64::max);
        let (step, iterations) = (self.step + 1, MOST_ITERATIONS);
        Err(Error::NotSolved { step, residual: worst, iterations, limit })
    }

    /// `(1 + theta h L^T (K + epsilon) L) p`.
    fn implicit_image(&mut self, theta: f64, p: &[T], image: &mut Vec<T>) -> Result<(), Error> {
        let moved = &mut self.unknowns.drift;
        moved.clear();
        moved.extend_from_slice(p);
        self.kicks.forth(&self.resistance, moved)?;
        image.resize(moved.len(), T::ZERO);
        self.body.linear_forces(moved, image)?;
        let epsilon = T::of(self.config.confinement);
        for (image, &moved) in image.iter_mut().zip(moved.iter()) {
            *image -= epsilon * moved;
        }
        self.kicks.back(&self.resistance, image)?;
        let factor = T::of(theta * self.config.dt);
        for (image, &p) in image.iter_mut().zip(p) {
            *image = p - factor * *image;
        }
        Ok(())
    }
}

/// Over lanes, `sum a b`.
pub(crate) fn dots<T: Real, const L: usize>(a: &[T], b: &[T]) -> [f64; L] {
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
fn along<T: Real, const L: usize>(a: &mut [T], b: &[T], factor: [f64; L]) {
    for (a, b) in a.as_chunks_mut::<L>().0.iter_mut().zip(b.as_chunks::<L>().0) {
        for lane in 0..L {
            a[lane] += T::of(factor[lane]) * b[lane];
        }
    }
}
