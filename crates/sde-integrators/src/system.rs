//! Stochastic differential equations: drift, noise, and noise class.

/// State dependence of a system's noise. The trait is sealed.
///
/// A method that is valid only for one class requires it in its bound, so an invalid combination does not compile.
pub trait NoiseClass: sealed::Sealed {
    /// Whether `g` may depend on `x`. Otherwise `div D` is zero and `D` is the same for every particle.
    const STATE_DEPENDENT: bool;
}

/// General noise `g(t, x)`, with any state dependence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct General;

/// Additive noise `g(t)`, independent of the state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Additive;

impl NoiseClass for General {
    const STATE_DEPENDENT: bool = true;
}
impl NoiseClass for Additive {
    const STATE_DEPENDENT: bool = false;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::General {}
    impl Sealed for super::Additive {}
}

/// An Ito stochastic differential equation,
///
/// $$ dX = f(t, X) dt + g(t, X) dB, $$
///
/// with `D` states and `M` independent Brownian motions (Canor & Denoël 2013, eq 1).
///
/// One declaration serves every solver: the diffusion matrix and its divergence are derived from `g`, never declared
/// separately.
pub trait Sde<const D: usize, const M: usize>: Sync {
    /// Class of the noise: [`Additive`] or [`General`].
    type Noise: NoiseClass;

    /// `f(t, x)`, per unit of time.
    fn drift(&self, t: f64, x: &[f64; D]) -> [f64; D];

    /// `g(t, x)`, row per state, column per Brownian motion, per square root of time.
    fn noise(&self, t: f64, x: &[f64; D]) -> [[f64; M]; D];

    /// `D = g g^T / 2` (Canor & Denoël 2013, below eq 3).
    fn diffusion(&self, t: f64, x: &[f64; D]) -> [[f64; D]; D] {
        let g = self.noise(t, x);
        let mut diffusion = [[0.0; D]; D];
        for (row, g_i) in diffusion.iter_mut().zip(&g) {
            for (entry, g_j) in row.iter_mut().zip(&g) {
                *entry = 0.5 * g_i.iter().zip(g_j).map(|(a, b)| a * b).sum::<f64>();
            }
        }
        diffusion
    }

    /// `(div D)_i = sum_j dD_ij/dx_j` (Canor & Denoël 2013, eq 12; eq 17 drops it, see `docs/errata.md`).
    ///
    /// The default is zero for additive noise, and central differences of `g g^T / 2` otherwise (relative error about
    /// 1e-10). A system with a closed form overrides it; [`check_diffusion_divergence`] compares the two.
    fn diffusion_divergence(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        if Self::Noise::STATE_DEPENDENT { difference_divergence(self, t, x) } else { [0.0; D] }
    }

    /// A constant matrix `A` (per unit of time) such that `f(t, x) = A x + r(t, x)` with a milder `r`: no fast oscillation,
    /// no stiff decay.
    ///
    /// Exponential integrators, such as the Lawson schemes of `fpk-sph`, take the flow `exp(A t)` exactly. `drift` contains
    /// the part. The default declares none.
    fn linear_part(&self) -> Option<[[f64; D]; D]> {
        None
    }
}

/// Central differences of the diffusion matrix.
fn difference_divergence<S, const D: usize, const M: usize>(
    system: &S,
    t: f64,
    x: &[f64; D],
) -> [f64; D]
where
    S: Sde<D, M> + ?Sized,
{
    let mut divergence = [0.0; D];
    for j in 0..D {
        let step = f64::EPSILON.cbrt() * x[j].abs().max(1.0);
        let (mut above, mut below) = (*x, *x);
        above[j] += step;
        below[j] -= step;
        let (d_above, d_below) = (system.diffusion(t, &above), system.diffusion(t, &below));
        for (i, value) in divergence.iter_mut().enumerate() {
            *value += (d_above[i][j] - d_below[i][j]) / (above[j] - below[j]);
        }
    }
    divergence
}

/// Largest difference between a system's `div D` and central differences of its `g`, over the given states.
#[must_use]
pub fn check_diffusion_divergence<S, const D: usize, const M: usize>(
    system: &S,
    t: f64,
    states: &[[f64; D]],
) -> f64
where
    S: Sde<D, M>,
{
    let mut largest = 0.0_f64;
    for x in states {
        let (given, differences) =
            (system.diffusion_divergence(t, x), difference_divergence(system, t, x));
        for (a, b) in given.iter().zip(&differences) {
            let difference = (a - b).abs();
            if difference.is_nan() {
                return f64::NAN;
            }
            largest = largest.max(difference);
        }
    }
    largest
}

/// A second-order mechanical system with `N` degrees of freedom and noise that acts on the velocities,
///
/// $$ \ddot q_k + c_k \dot q_k + \omega_k^2 q_k = r_k(t, q, \dot q) + \sum_m s_{km}(t) W_m . $$
///
/// It separates the linear part for splitting methods. As an [`Sde`] its state is `(q_1.., v_1..)`.
pub trait SecondOrder<const N: usize, const M: usize>: Sync {
    /// `omega_k >= 0`, the circular frequencies of the linear part (rad per unit of time).
    fn natural_frequency(&self) -> [f64; N];

    /// `c_k >= 0`, the linear damping; `2 xi omega` for a damping ratio `xi` (1 per unit of time).
    fn linear_damping(&self) -> [f64; N];

    /// `r(t, q, v)`, the remaining acceleration.
    fn remaining_acceleration(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> [f64; N];

    /// The exact flow over `dt` of `dv/dt = r(t, q, v)` at frozen `t` and `q`.
    fn remaining_flow(&self, t: f64, dt: f64, q: &[f64; N], v: &mut [f64; N]);

    /// `s(t)`, such that `dv = .. + s dB`: row per degree of freedom, column per Brownian motion.
    fn noise_intensity(&self, t: f64) -> [[f64; M]; N];

    /// The total acceleration without the noise, `r - c v - omega^2 q`.
    #[inline]
    fn acceleration(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> [f64; N] {
        let (omega, c) = (self.natural_frequency(), self.linear_damping());
        let mut acceleration = self.remaining_acceleration(t, q, v);
        for k in 0..N {
            acceleration[k] -= c[k] * v[k] + omega[k] * omega[k] * q[k];
        }
        acceleration
    }
}

/// The linear part of a second-order system as a matrix over `(q_1.., v_1..)`, with `D = 2 N`: rows `(0, 1)` and
/// `(-omega_k^2, -c_k)`. It serves [`Sde::linear_part`].
#[must_use]
pub fn linear_part_of<S, const N: usize, const D: usize, const M: usize>(
    system: &S,
) -> [[f64; D]; D]
where
    S: SecondOrder<N, M> + ?Sized,
{
    const { assert!(D == 2 * N, "the state is not one of displacements and velocities") };
    let (omega, c) = (system.natural_frequency(), system.linear_damping());
    let mut part = [[0.0; D]; D];
    for k in 0..N {
        part[k][N + k] = 1.0;
        part[N + k][k] = -omega[k] * omega[k];
        part[N + k][N + k] = -c[k];
    }
    part
}
