//! Euler and Maruyama's step, and Leimkuhler and Matthews'.

use crate::bodies::body::Body;
use crate::dynamics::kicks::{CHUNK, Which};
use crate::dynamics::motion::Motion;
use crate::dynamics::resistance::Resistance;
use crate::error::Error;
use crate::real::Real;

#[derive(Debug)]
pub(crate) struct Euler<T> {
    /// Whether the noise is the mean of two steps, as in Leimkuhler and Matthews' method.
    averages: bool,
    /// `L z` of this step; used where the mobility couples nodes.
    kick: Vec<T>,
    /// `L z` of the step before; empty until it is needed.
    last_kick: Vec<T>,
}

impl<T: Real> Euler<T> {
    pub(super) fn new(averages: bool, n_unknowns: usize) -> Self {
        Self { averages, kick: vec![T::ZERO; n_unknowns], last_kick: Vec::new() }
    }

    /// `u += h M F(u) + sqrt(2 kT h) L z`, with `z` the mean of two steps for Leimkuhler and Matthews' method.
    pub(super) fn step<const D: usize, const L: usize>(
        &mut self,
        motion: &mut Motion<T, D, L>,
        body: &mut dyn Body<T, D, L>,
    ) -> Result<(), Error> {
        motion.evaluate(body)?;
        let temperature = motion.config.dynamics.temperature();
        let mut amplitude = (2.0 * temperature * motion.config.dt).sqrt();
        if self.averages {
            amplitude *= 0.5;
            self.draw_last_kick(motion)?;
        }
        if let Resistance::Diagonal { .. } = motion.resistance {
            motion.total_forces(motion.time);
            self.move_uncoupled(motion, amplitude);
        } else {
            motion.drift_at(motion.time)?;
            motion.draw(&mut self.kick)?;
            self.move_coupled(motion, amplitude);
        }
        motion.finish()
    }

    /// Draws the kick of the step before, where it is not kept.
    fn draw_last_kick<const D: usize, const L: usize>(
        &mut self,
        motion: &mut Motion<T, D, L>,
    ) -> Result<(), Error> {
        if self.last_kick.is_empty() {
            let which = motion.step.checked_sub(1).map_or(Which::BeforeFirst, Which::Step);
            motion.kicks.kick(&motion.resistance, which, &mut self.last_kick)?;
        }
        Ok(())
    }

    /// A step of a mobility that is a number at each unknown, in one pass: normals are used while they are in the cache.
    fn move_uncoupled<const D: usize, const L: usize>(
        &mut self,
        motion: &mut Motion<T, D, L>,
        amplitude: f64,
    ) {
        let averages = self.averages;
        let Motion { config, resistance, kicks, level, u, drift, step, .. } = motion;
        let Resistance::Diagonal { values, factor } = &*resistance else { return };
        let (h, is_noisy) = (T::of(config.dt), amplitude > 0.0);
        let amplitude = T::of(amplitude);
        for first in (0..values.len()).step_by(CHUNK) {
            let range = first..values.len().min(first + CHUNK);
            let lanes = range.start * L..range.end * L;
            let normals = if is_noisy { kicks.normals(*step, range.clone()) } else { &[] };
            let (values, factor) = (&values[range.clone()], &factor[range]);
            let forces = drift[lanes.clone()].as_chunks::<L>().0;
            let last = if averages { &mut self.last_kick[lanes.clone()] } else { &mut [] };
            let last = last.as_chunks_mut::<L>().0;
            let (u, z) = (u[lanes].as_chunks_mut::<L>().0, normals.as_chunks::<L>().0);
            level.call(
                #[inline(always)]
                || {
                    for m in 0..u.len() {
                        let mut kick = [T::ZERO; L];
                        if is_noisy {
                            kick = std::array::from_fn(|lane| T::of(z[m][lane]) * factor[m]);
                        }
                        if averages {
                            let this = kick;
                            for lane in 0..L {
                                kick[lane] += last[m][lane];
                            }
                            last[m] = this;
                        }
                        for lane in 0..L {
                            let drift = forces[m][lane] * values[m];
                            u[m][lane] += h * drift + amplitude * kick[lane];
                        }
                    }
                },
            );
        }
    }

    /// A step of a mobility that couples nodes, whose drift and kick are computed.
    fn move_coupled<const D: usize, const L: usize>(
        &mut self,
        motion: &mut Motion<T, D, L>,
        amplitude: f64,
    ) {
        let (h, amplitude) = (T::of(motion.config.dt), T::of(amplitude));
        if self.averages {
            for (last, kick) in self.last_kick.iter_mut().zip(&mut self.kick) {
                let this = *kick;
                *kick += *last;
                *last = this;
            }
        }
        for (u, (&drift, &kick)) in motion.u.iter_mut().zip(motion.drift.iter().zip(&self.kick)) {
            *u += h * drift + amplitude * kick;
        }
    }
}
