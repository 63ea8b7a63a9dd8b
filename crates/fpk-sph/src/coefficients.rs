//! Drift and diffusion of a system, evaluated for many particles in one call.
//!
//! The only code of a simulation that is compiled for each system: all else knows the dimension alone.

use sde_integrators::{NoiseClass, Sde};

/// The coefficients of the Fokker-Planck equation over a cloud of particles.
pub(crate) trait Coefficients<const D: usize>: Sync {
    /// `v_i = f - div D - D s_i` (Canor & Denoël 2013, eq 12) with the scores `s = grad log psi`, at time `t`; all slices
    /// have an entry per particle, in the units of the state.
    fn velocity(&self, t: f64, x: &[[f64; D]], score: &[[f64; D]], v: &mut [[f64; D]]);

    /// `D` at every particle; a single entry for all where the noise is additive.
    fn diffusion(&self, t: f64, x: &[[f64; D]], diffusion: &mut Vec<[[f64; D]; D]>);

    /// The columns of `g` at every particle, particle by particle.
    fn noise(&self, t: f64, x: &[[f64; D]], columns: &mut Vec<[f64; D]>);
}

/// The coefficients of a system.
pub(crate) struct OfSystem<'a, S, const M: usize>(pub(crate) &'a S);

impl<S: Sde<D, M>, const D: usize, const M: usize> Coefficients<D> for OfSystem<'_, S, M> {
    fn velocity(&self, t: f64, x: &[[f64; D]], score: &[[f64; D]], v: &mut [[f64; D]]) {
        let Some(first) = x.first() else { return };
        // Additive noise spreads every particle alike: one diffusion matrix serves all.
        let shared = (!S::Noise::STATE_DEPENDENT).then(|| self.0.diffusion(t, first));
        for ((v, x), score) in v.iter_mut().zip(x).zip(score) {
            let diffusion = shared.unwrap_or_else(|| self.0.diffusion(t, x));
            *v = self.0.drift(t, x);
            if S::Noise::STATE_DEPENDENT {
                for (value, divergence) in v.iter_mut().zip(&self.0.diffusion_divergence(t, x)) {
                    *value -= divergence;
                }
            }
            for (value, row) in v.iter_mut().zip(&diffusion) {
                *value -= row.iter().zip(score).map(|(d, s)| d * s).sum::<f64>();
            }
        }
    }

    fn diffusion(&self, t: f64, x: &[[f64; D]], diffusion: &mut Vec<[[f64; D]; D]>) {
        let distinct = if S::Noise::STATE_DEPENDENT { x.len() } else { x.len().min(1) };
        diffusion.clear();
        diffusion.extend(x[..distinct].iter().map(|x| self.0.diffusion(t, x)));
    }

    fn noise(&self, t: f64, x: &[[f64; D]], columns: &mut Vec<[f64; D]>) {
        columns.clear();
        for x in x {
            let g = self.0.noise(t, x);
            columns.extend((0..M).map(|m| -> [f64; D] { std::array::from_fn(|k| g[k][m]) }));
        }
    }
}
