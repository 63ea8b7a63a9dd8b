//! The step BAOAB of inertial dynamics.

use crate::bodies::body::Body;
use crate::dynamics::kicks::Which;
use crate::dynamics::motion::Motion;
use crate::error::Error;
use crate::real::Real;

#[derive(Debug)]
pub(crate) struct Baoab<T> {
    friction: f64,
    temperature: f64,
    /// `z/sqrt(m)`.
    kick: Vec<T>,
}

impl<T: Real> Baoab<T> {
    pub(super) fn new(friction: f64, temperature: f64, n_unknowns: usize) -> Self {
        Self { friction, temperature, kick: vec![T::ZERO; n_unknowns] }
    }

    /// `v += h/2 F/m`, `u += h/2 v`, `v = c v + sqrt((1 - c^2) kT/m) z`, `u += h/2 v`, `v += h/2 F/m` with `c = exp(-gamma h)`.
    pub(super) fn step<const D: usize, const L: usize>(
        &mut self,
        motion: &mut Motion<T, D, L>,
        body: &mut dyn Body<T, D, L>,
    ) -> Result<(), Error> {
        let dt = motion.config.dt;
        let half = T::of(0.5 * dt);
        let kept = (-self.friction * dt).exp();
        // 1 - c^2 without cancellation.
        let amplitude = (-(-2.0 * self.friction * dt).exp_m1() * self.temperature).sqrt();
        motion.drift_at(motion.time)?;
        if amplitude > 0.0 {
            let which = Which::Step(motion.step);
            motion.kicks.kick(&motion.resistance, which, &mut self.kick)?;
        }
        let (kept, amplitude) = (T::of(kept), T::of(amplitude));
        let Motion { u, v, drift, level, .. } = &mut *motion;
        let kick = &self.kick;
        level.call(
            #[inline(always)]
            || {
                let moves = u.iter_mut().zip(v).zip(drift.iter().zip(kick));
                for ((u, v), (&drift, &kick)) in moves {
                    let before = *v + half * drift;
                    *v = kept * before + amplitude * kick;
                    *u += half * (before + *v);
                }
            },
        );
        motion.finish()?;
        motion.evaluate(body)?;
        motion.drift_at(motion.time_after())?;
        let Motion { v, drift, level, .. } = motion;
        level.call(
            #[inline(always)]
            || {
                for (v, &drift) in v.iter_mut().zip(&*drift) {
                    *v += half * drift;
                }
            },
        );
        Ok(())
    }
}
