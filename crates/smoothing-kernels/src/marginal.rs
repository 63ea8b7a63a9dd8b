//! Moments and marginals of any kernel, by a fixed quadrature.

use core::f64::consts::PI;

use crate::geometry::{integer_power, unit_sphere_surface};

/// Panels over the support.
///
/// A multiple of 2, 5 and 3, so that panels end at every knot of the cubic, quartic and quintic splines.
const N_PANELS: u16 = 60;

/// Nodes and weights of five-point Gauss-Legendre on [-1, 1]: DLMF table 3.5.2.
const RULE: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// `∫_a^b f`, exact for polynomials of degree 9.
fn gauss_legendre(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (centre, half) = (0.5 * (a + b), 0.5 * (b - a));
    half * RULE.iter().map(|(node, weight)| weight * f(centre + half * node)).sum::<f64>()
}

/// The functions of a kernel that moments and marginals use, named as in `Kernel`.
pub(crate) struct Radial<W, S> {
    pub(crate) support: f64,
    pub(crate) normalisation: f64,
    pub(crate) shape: W,
    pub(crate) shape_derivative_over_q: S,
}

/// `κ_D = S_D σ_D / D ∫ w(q) q^(D+1) dq`, since each of the `D` squared coordinates contributes equally to `q^2`.
pub(crate) fn second_moment<const D: usize, W, S>(kernel: &Radial<W, S>) -> f64
where
    W: Fn(f64) -> f64,
{
    radial_moment::<D, W, S>(kernel, 2) / D as f64
}

/// `∫ |x|^n W(|x|, 1) d^D x = S_D σ_D ∫ w(q) q^(D-1+n) dq`.
pub(crate) fn radial_moment<const D: usize, W, S>(kernel: &Radial<W, S>, n: usize) -> f64
where
    W: Fn(f64) -> f64,
{
    let width = kernel.support / f64::from(N_PANELS);
    let integral: f64 = (0..N_PANELS)
        .map(|panel| {
            let start = f64::from(panel) * width;
            let shell = |q| (kernel.shape)(q) * integer_power(q, D - 1 + n);
            gauss_legendre(start, start + width, shell)
        })
        .sum();
    unit_sphere_surface::<D>() * kernel.normalisation * integral
}

/// Marginal density at `c`, in units of `h`. With `ρ^2 = t^2 - c^2`, and integrated by parts,
///
/// $$ \sigma_D V_{D-1} \Bigl[ \int_c^s -w'(t)\, \rho^{D-1} dt + w(s^-)\, \rho(s)^{D-1} \Bigr] . $$
pub(crate) fn density<const D: usize, W, S>(kernel: &Radial<W, S>, c: f64) -> f64
where
    W: Fn(f64) -> f64,
    S: Fn(f64) -> f64,
{
    let c = c.abs();
    if D == 1 {
        return kernel.normalisation * (kernel.shape)(c);
    }
    let layers = layers(kernel, c, |_, rho| integer_power(rho, D - 1));
    kernel.normalisation * unit_ball_volume(D - 1) * layers
}

/// Probability that the coordinate is at most `c`, in units of `h`.
///
/// The kernel is a superposition of balls, and its part beyond `c` a superposition of caps.
pub(crate) fn distribution<const D: usize, W, S>(kernel: &Radial<W, S>, c: f64) -> f64
where
    W: Fn(f64) -> f64,
    S: Fn(f64) -> f64,
{
    let distance = c.abs();
    let caps = layers(kernel, distance, |t, rho| cap::<D>(t, distance, rho));
    let beyond = kernel.normalisation * unit_ball_volume(D - 1) * caps;
    if c < 0.0 { beyond } else { 1.0 - beyond }
}

/// `∫_c^s -w'(t) f(t, ρ) dt + w(s^-) f(s, ρ(s))`, integrated over `ρ = sqrt(t^2 - c^2)`.
///
/// In this variable the root at `t = c` is smooth: `dt = ρ dρ / t`.
fn layers<W, S>(kernel: &Radial<W, S>, c: f64, f: impl Fn(f64, f64) -> f64) -> f64
where
    W: Fn(f64) -> f64,
    S: Fn(f64) -> f64,
{
    let support = kernel.support;
    if c >= support {
        return 0.0;
    }
    let rho_of = |t: f64| ((t - c) * (t + c)).sqrt();
    let integrand = |rho: f64| {
        let t = c.hypot(rho);
        -(kernel.shape_derivative_over_q)(t) * rho * f(t, rho)
    };
    let mut sum = 0.0;
    let mut from = 0.0;
    for panel in 1..=N_PANELS {
        let end = support * (f64::from(panel) / f64::from(N_PANELS));
        if end > c {
            let to = rho_of(end);
            sum += gauss_legendre(from, to, integrand);
            from = to;
        }
    }
    // The last value before the edge: zero within roundoff, except for a truncated kernel.
    let step = (kernel.shape)(support * (1.0 - f64::EPSILON));
    // A NaN compares false with every panel, but it is in `c`, and so in the last term.
    sum + step * f(support, rho_of(support))
}

/// `∫_c^t (t^2 - y^2)^((D-1)/2) dy`: scaled volume of the cap of a ball of radius `t`.
///
/// The scale is the volume of the lower-dimensional unit ball.
///
/// The unit ball has one dimension less. With `n = D - 1`,
///
/// $$ J_n = \frac{n t^2 J_{n-2} - c\,\rho^n}{n + 1}, \quad J_0 = t - c, \quad
///    J_1 = \tfrac12 \Bigl(t^2 \arctan\frac{\rho}{c} - c \rho\Bigr), \quad \rho^2 = t^2 - c^2 . $$
fn cap<const D: usize>(t: f64, c: f64, rho: f64) -> f64 {
    let square = t * t;
    let (mut n, mut volume) =
        if D % 2 == 1 { (0, t - c) } else { (1, 0.5 * (square * rho.atan2(c) - c * rho)) };
    while n + 1 < D {
        n += 2;
        volume = (n as f64 * square * volume - c * integer_power(rho, n)) / (n + 1) as f64;
    }
    volume
}

/// Volume of the unit ball: `V_0 = 1`, `V_1 = 2`, `V_n = 2π/n V_(n-2)`.
fn unit_ball_volume(dimension: usize) -> f64 {
    let (mut n, mut volume) = if dimension.is_multiple_of(2) { (0, 1.0) } else { (1, 2.0) };
    while n < dimension {
        n += 2;
        volume *= 2.0 * PI / n as f64;
    }
    volume
}
