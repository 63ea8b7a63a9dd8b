//! The linearly implicit step.

use super::conjugate_gradients::ConjugateGradients;
use crate::bodies::body::Body;
use crate::dynamics::kicks::Which;
use crate::dynamics::motion::Motion;
use crate::error::Error;
use crate::real::Real;

#[derive(Debug)]
pub(crate) struct Theta<T> {
    /// `theta`.
    implicitness: f64,
    /// `z`.
    normals: Vec<T>,
    /// `L p` of a direction `p` of the solver.
    displacements: Vec<T>,
    solver: ConjugateGradients<T>,
}

impl<T: Real> Theta<T> {
    pub(super) fn new(implicitness: f64) -> Self {
        let (normals, displacements) = (Vec::new(), Vec::new());
        Self { implicitness, normals, displacements, solver: ConjugateGradients::default() }
    }

    /// Solves `(1 + theta h L^T K L) y = h L^T F(u) + sqrt(2 kT h) z` and moves by `L y`: the same as
    /// `(1 + theta h M K) du = h M F(u) + sqrt(2 kT h) L z`, but symmetric.
    pub(super) fn step<const D: usize, const L: usize>(
        &mut self,
        motion: &mut Motion<T, D, L>,
        body: &mut dyn Body<T, D, L>,
    ) -> Result<(), Error> {
        motion.evaluate(body)?;
        self.right_hand_side(motion)?;
        let Self { implicitness: theta, displacements, solver, .. } = self;
        solver.solve::<L>(motion.step, |p, image| {
            implicit_image(*theta, motion, body, p, (&mut *displacements, image))
        })?;
        motion.kicks.forth(&motion.resistance, &mut solver.solution)?;
        for (u, &moved) in motion.u.iter_mut().zip(&solver.solution) {
            *u += moved;
        }
        motion.finish()
    }

    /// `h L^T (F + loads - epsilon u) + sqrt(2 kT h) z`, into the residual of the solver.
    fn right_hand_side<const D: usize, const L: usize>(
        &mut self,
        motion: &mut Motion<T, D, L>,
    ) -> Result<(), Error> {
        let (dt, temperature) = (motion.config.dt, motion.config.dynamics.temperature());
        let Self { normals, solver: ConjugateGradients { residual, .. }, .. } = self;
        motion.total_forces(motion.time);
        residual.clone_from(&motion.drift);
        motion.kicks.back(&motion.resistance, residual)?;
        let (h, amplitude) = (T::of(dt), T::of((2.0 * temperature * dt).sqrt()));
        if temperature > 0.0 {
            motion.kicks.draw(Which::Step(motion.step), normals);
        } else {
            normals.clear();
            normals.resize(residual.len(), T::ZERO);
        }
        for (r, &z) in residual.iter_mut().zip(&*normals) {
            *r = h * *r + amplitude * z;
        }
        Ok(())
    }
}

/// `(1 + theta h L^T (K + epsilon) L) p`, with `L p` in the first buffer, into the second.
fn implicit_image<T: Real, const D: usize, const L: usize>(
    theta: f64,
    motion: &mut Motion<T, D, L>,
    body: &mut dyn Body<T, D, L>,
    p: &[T],
    (displacements, image): (&mut Vec<T>, &mut Vec<T>),
) -> Result<(), Error> {
    let Motion { config, resistance, kicks, .. } = motion;
    displacements.clear();
    displacements.extend_from_slice(p);
    kicks.forth(resistance, displacements)?;
    image.resize(displacements.len(), T::ZERO);
    body.linear_forces(displacements, image)?;
    let epsilon = T::of(config.confinement);
    for (image, &displacement) in image.iter_mut().zip(displacements.iter()) {
        *image -= epsilon * displacement;
    }
    kicks.back(resistance, image)?;
    let factor = T::of(theta * config.dt);
    for (image, &p) in image.iter_mut().zip(p) {
        *image = p - factor * *image;
    }
    Ok(())
}
