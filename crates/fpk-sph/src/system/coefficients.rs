//! Drift and diffusion of a system, evaluated for many particles in one call.
//!
//! The only code of a simulation that is compiled for each system: all else knows the dimension alone.

use sde_integrators::{NoiseClass, Sde};

use vibrating_systems::matrix::Matrix;

/// The coefficients of the Fokker-Planck equation over a cloud of particles.
pub(crate) trait Coefficients<const D: usize>: Sync {
    /// `v_i = f - div D - D s_i` (Canor & Denoël 2013, eq 12) with the scores `s = grad log psi`, at time `t`; all slices
    /// have an entry per particle, in the units of the state.
    fn velocity(&self, t: f64, x: &[[f64; D]], score: &[[f64; D]], v: &mut [[f64; D]]);

    /// `f` at every particle, the drift in Itô's sense.
    fn drift(&self, t: f64, x: &[[f64; D]], drift: &mut Vec<[f64; D]>);

    /// `D` at every particle; a single entry for all where the noise is additive.
    fn diffusion(&self, t: f64, x: &[[f64; D]], diffusion: &mut Vec<[[f64; D]; D]>);

    /// The columns of `g` at every particle, particle by particle.
    fn noise(&self, t: f64, x: &[[f64; D]], columns: &mut Vec<[f64; D]>);

    /// The linear part of the drift, where the system declares one.
    fn linear_part(&self) -> Option<Matrix<D>>;
}

/// Particles whose components are brought together, so that the loop over them is compiled for registers.
const CHUNK: usize = 64;

/// `f - div D - D s` at [`CHUNK`] particles or fewer; `shared` is the diffusion of all, where the noise is additive.
/// `columns` is scratch: positions, scores and velocities by components.
#[allow(clippy::inline_always, reason = "what is not inlined is not compiled for registers")]
#[inline(always)]
fn velocities<S: Sde<D, M>, const D: usize, const M: usize>(
    system: &S,
    t: f64,
    shared: &[[f64; D]; D],
    (x, score): (&[[f64; D]], &[[f64; D]]),
    v: &mut [[f64; D]],
    columns: &mut [[[f64; CHUNK]; D]; 3],
) {
    // Places beyond the last repeat it: a system is asked where particles are, and nowhere else.
    for p in 0..CHUNK {
        let from = p.min(v.len() - 1);
        for k in 0..D {
            (columns[0][k][p], columns[1][k][p]) = (x[from][k], score[from][k]);
        }
    }
    let [x, score, out] = columns;
    for p in 0..CHUNK {
        let (x, score) = (simd_lanes::from_fn(|k| x[k][p]), simd_lanes::from_fn(|k| score[k][p]));
        let v = velocity_at(system, t, shared, &x, &score);
        for k in 0..D {
            out[k][p] = v[k];
        }
    }
    for (p, v) in v.iter_mut().enumerate() {
        for k in 0..D {
            v[k] = out[k][p];
        }
    }
}

/// `f - div D - D s` at one particle; `shared` is the diffusion of all, where the noise is additive.
#[allow(clippy::inline_always, reason = "so that a loop over particles is compiled for registers")]
#[inline(always)]
fn velocity_at<S: Sde<D, M>, const D: usize, const M: usize>(
    system: &S,
    t: f64,
    shared: &[[f64; D]; D],
    x: &[f64; D],
    score: &[f64; D],
) -> [f64; D] {
    let mut v = system.drift(t, x);
    let mut diffusion = *shared;
    if S::Noise::STATE_DEPENDENT {
        diffusion = system.diffusion(t, x);
        for (value, divergence) in v.iter_mut().zip(&system.diffusion_divergence(t, x)) {
            *value -= divergence;
        }
    }
    for (value, row) in v.iter_mut().zip(&diffusion) {
        *value -= row.iter().zip(score).map(|(d, s)| d * s).sum::<f64>();
    }
    v
}

/// The coefficients of a system.
pub(crate) struct OfSystem<'a, S, const M: usize>(pub(crate) &'a S);

impl<S: Sde<D, M>, const D: usize, const M: usize> Coefficients<D> for OfSystem<'_, S, M> {
    fn velocity(&self, t: f64, x: &[[f64; D]], score: &[[f64; D]], v: &mut [[f64; D]]) {
        let Some(first) = x.first() else { return };
        // Additive noise spreads every particle alike: one diffusion matrix serves all.
        let shared = self.0.diffusion(t, first);
        let mut columns = [[[0.0; CHUNK]; D]; 3];
        simd_lanes::dispatch(
            #[inline(always)]
            || {
                for ((v, x), score) in
                    v.chunks_mut(CHUNK).zip(x.chunks(CHUNK)).zip(score.chunks(CHUNK))
                {
                    velocities(self.0, t, &shared, (x, score), v, &mut columns);
                }
            },
        );
    }

    fn drift(&self, t: f64, x: &[[f64; D]], drift: &mut Vec<[f64; D]>) {
        drift.clear();
        drift.extend(x.iter().map(|x| self.0.drift(t, x)));
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

    fn linear_part(&self) -> Option<Matrix<D>> {
        self.0.linear_part()
    }
}

#[cfg(test)]
mod tests {
    use sde_integrators::Additive;

    use super::*;

    /// Has no drift at zero or below.
    struct Positive;

    impl Sde<1, 1> for Positive {
        type Noise = Additive;
        fn drift(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
            assert!(x[0] > 0.0, "asked at {}", x[0]);
            [-x[0]]
        }
        fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
            [[1.0]]
        }
    }

    #[test]
    fn a_system_is_asked_where_particles_are_and_nowhere_else() {
        for n in [1, CHUNK - 1, CHUNK, CHUNK + 3] {
            let x: Vec<[f64; 1]> = (0..n).map(|i| [1.0 + i as f64]).collect();
            let mut v = vec![[0.0]; n];
            OfSystem(&Positive).velocity(0.0, &x, &vec![[0.0]; n], &mut v);
            assert!(v.iter().zip(&x).all(|(v, x)| v[0] + x[0] == 0.0), "{n} particles");
        }
    }
}
