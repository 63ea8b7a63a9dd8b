//! The kernel trait, and functions derived from it.

use core::fmt::Debug;

use crate::batch::each;
use crate::error::Error;
use crate::geometry::power;
use crate::marginal::{self, Radial};

/// Smallest `q` at which the ratio `shape'(q) / q` is evaluated.
///
/// The ratio has a limit at 0, from which it differs here by a relative 1e-8.
const SMALLEST_Q: f64 = 1e-8;

/// A radial smoothing kernel in `D` dimensions,
///
/// $$ W(r, h) = \frac{\sigma_D}{h^D}\, w(q), \qquad q = r / h, \qquad S_D\,\sigma_D \int_0^{s} w(q)\, q^{D-1} dq = 1. $$
///
/// Symbols: `r` the distance between two points, `h` the smoothing length (both in the unit of length of the points),
/// `w` the [`shape`](Self::shape), `s` the [`support`](Self::support) in units of `h`, `sigma_D` the
/// [`normalisation`](Self::normalisation), `S_D` the surface of the unit sphere
/// ([`unit_sphere_surface`](crate::unit_sphere_surface)).
/// Domain: `r >= 0`, `h > 0`, `q >= 0`. A NaN argument gives NaN. Four functions are required; the others are derived
/// from them. The trait is object-safe; solvers take a `K: Kernel<D>` and are compiled for each kernel.
pub trait Kernel<const D: usize>: Debug + Send + Sync {
    /// Support in units of `h`: `shape(q) = 0` for `q >= support`.
    #[must_use]
    fn support(&self) -> f64;

    /// Shape `w(q)`, without its normalisation.
    #[must_use]
    fn shape(&self, q: f64) -> f64;

    /// `w'(q)`.
    #[must_use]
    fn shape_derivative(&self, q: f64) -> f64;

    /// Normalisation `sigma_D`: the kernel integrates to one over `D`-dimensional space.
    #[must_use]
    fn normalisation(&self) -> f64;

    /// `w'(q) / q`, finite at 0 for a kernel with zero slope there.
    ///
    /// The default is the quotient, evaluated at `q = 1e-8` for smaller `q`. A kernel with a closed form overrides it
    /// and saves the division. For a kernel with a cusp at 0 the limit does not exist; the default is then large and
    /// finite, and the gradient of a point with itself is still zero.
    #[inline]
    #[must_use]
    fn shape_derivative_over_q(&self, q: f64) -> f64 {
        let q = if q < SMALLEST_Q { SMALLEST_Q } else { q };
        self.shape_derivative(q) / q
    }

    /// Support radius `support * h`: the radius for a neighbour search.
    #[inline]
    #[must_use]
    fn support_radius(&self, h: f64) -> f64 {
        self.support() * h
    }

    /// `W(r, h)`, per `D`-dimensional volume.
    #[inline]
    #[must_use]
    fn value(&self, r: f64, h: f64) -> f64 {
        self.normalisation() / power::<D>(h) * self.shape(r / h)
    }

    /// `dW/dr = sigma_D / h^(D+1) w'(q)`.
    #[inline]
    #[must_use]
    fn radial_derivative(&self, r: f64, h: f64) -> f64 {
        self.normalisation() / (power::<D>(h) * h) * self.shape_derivative(r / h)
    }

    /// `(dW/dr) / r = sigma_D / h^(D+2) w'(q)/q`: the gradient is this times `x_ij`.
    #[inline]
    #[must_use]
    fn gradient_factor(&self, r: f64, h: f64) -> f64 {
        self.normalisation() / (power::<D>(h) * (h * h)) * self.shape_derivative_over_q(r / h)
    }

    /// Gradient of `W(|x_i - x_j|, h)` with respect to the first point, with `x_ij = x_i - x_j` and `r = |x_ij|`.
    ///
    /// The gradient with respect to the second point is the negative. It is zero for coincident points.
    #[inline]
    #[must_use]
    fn gradient(&self, x_ij: &[f64; D], r: f64, h: f64) -> [f64; D] {
        let factor = self.gradient_factor(r, h);
        x_ij.map(|component| factor * component)
    }

    /// `dW/dh = -sigma_D / h^(D+1) (D w(q) + q w'(q))` at fixed `r`, for variable smoothing lengths.
    #[inline]
    #[must_use]
    fn smoothing_length_derivative(&self, r: f64, h: f64) -> f64 {
        let q = r / h;
        let bracket = D as f64 * self.shape(q) + q * self.shape_derivative(q);
        -self.normalisation() / (power::<D>(h) * h) * bracket
    }

    /// [`value`](Self::value) for every squared distance: `values[k] = W(√r_squared[k], h)`, bitwise identical.
    ///
    /// The loop is compiled once for each register width, and the widest of the machine is selected at run time. It
    /// vectorises for a kernel whose shape has no branch or call, such as the polynomials here. Nothing is allocated.
    /// For a trait object it is one virtual call per slice.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if the slices differ in length; then nothing is written.
    ///
    /// ```
    /// use smoothing_kernels::{Kernel, WendlandC2};
    ///
    /// let mut values = [0.0; 3];
    /// Kernel::<3>::values(&WendlandC2, &[0.0, 0.25, 9.0], 0.5, &mut values)?;
    /// assert_eq!(values[1], Kernel::<3>::value(&WendlandC2, 0.5, 0.5));
    /// assert_eq!(values[2], 0.0);
    /// # Ok::<(), smoothing_kernels::Error>(())
    /// ```
    fn values(&self, r_squared: &[f64], h: f64, values: &mut [f64]) -> Result<(), Error> {
        each(
            r_squared,
            values,
            #[inline(always)]
            move |r| self.value(r, h),
        )
    }

    /// [`gradient_factor`](Self::gradient_factor) for every squared distance, bitwise identical.
    ///
    /// The gradient of pair `k` is `factors[k]` times its `x_ij`. For the rest it is as [`values`](Self::values).
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if the slices differ in length; then nothing is written.
    fn gradient_factors(
        &self,
        r_squared: &[f64],
        h: f64,
        factors: &mut [f64],
    ) -> Result<(), Error> {
        each(
            r_squared,
            factors,
            #[inline(always)]
            move |r| self.gradient_factor(r, h),
        )
    }

    /// Second moment of one coordinate for `h = 1`,
    ///
    /// $$ \kappa_D = \int x_1^2\, W(|x|, 1)\, d^D x = \frac{S_D \sigma_D}{D} \int_0^s w(q)\, q^{D+1} dq , $$
    ///
    /// so that smoothing adds `kappa h^2` to a variance, and `kappa h^2 / 2` times the Laplacian to a field.
    ///
    /// It is computed by Gauss-Legendre quadrature with 300 values of the shape, so compute it once. The error is
    /// roundoff for the kernels here and for any kernel that is smooth between multiples of a sixtieth of its support.
    ///
    /// ```
    /// use smoothing_kernels::{Kernel, Lucy};
    ///
    /// assert!((Kernel::<2>::second_moment(&Lucy) - 5.0 / 56.0).abs() < 1e-15);
    /// ```
    #[must_use]
    fn second_moment(&self) -> f64 {
        marginal::second_moment::<D, _, _>(&radial(self))
    }

    /// Marginal density of one coordinate at `x`: `W` integrated over the other `D - 1`, per unit of length.
    ///
    /// In one dimension it is the kernel itself. It is computed by Gauss-Legendre quadrature with at most 300 slopes
    /// of the shape; the absolute error is below `1e-10 / h` for the kernels here. It is even in `x` and zero beyond
    /// the support.
    ///
    /// ```
    /// use smoothing_kernels::{Kernel, Lucy};
    ///
    /// // In three dimensions it is 2π σ ∫_x^1 w(t) t dt; at 0 that is 2π 105/(16π) / 10.
    /// let peak = Kernel::<3>::marginal_density(&Lucy, 0.0, 1.0);
    /// assert!((peak - 105.0 / 80.0).abs() < 1e-10);
    /// ```
    #[must_use]
    fn marginal_density(&self, x: f64, h: f64) -> f64 {
        marginal::density::<D, _, _>(&radial(self), x / h) / h
    }

    /// Marginal distribution function: probability that one coordinate is at most `x`.
    ///
    /// It is the integral of [`marginal_density`](Self::marginal_density) up to `x`.
    ///
    /// It converts a sum over particles to the probability of a half-space. It increases from 0 to 1, with one half at
    /// 0; the absolute error is below 1e-10 for the kernels here, at the cost of the density.
    ///
    /// ```
    /// use smoothing_kernels::{Kernel, Lucy};
    ///
    /// // In one dimension: 1 - ∫_x^1 5/4 (1 + 3q)(1 - q)^3 dq, and beyond 1/2 lies 7/128.
    /// let below = Kernel::<1>::marginal_distribution(&Lucy, 0.5, 1.0);
    /// assert!((below - (1.0 - 7.0 / 128.0)).abs() < 1e-10);
    /// ```
    #[must_use]
    fn marginal_distribution(&self, x: f64, h: f64) -> f64 {
        marginal::distribution::<D, _, _>(&radial(self), x / h)
    }
}

pub(crate) fn radial<const D: usize, K: Kernel<D> + ?Sized>(
    kernel: &K,
) -> Radial<impl Fn(f64) -> f64, impl Fn(f64) -> f64> {
    Radial {
        support: kernel.support(),
        normalisation: kernel.normalisation(),
        shape: |q| kernel.shape(q),
        shape_derivative_over_q: |q| kernel.shape_derivative_over_q(q),
    }
}

/// Implements the trait for pointers to a kernel.
macro_rules! forward {
    ($($pointer:ty),*) => {$(
        impl<const D: usize, K: Kernel<D> + ?Sized> Kernel<D> for $pointer {
            #[inline]
            fn support(&self) -> f64 {
                (**self).support()
            }
            #[inline]
            fn shape(&self, q: f64) -> f64 {
                (**self).shape(q)
            }
            #[inline]
            fn shape_derivative(&self, q: f64) -> f64 {
                (**self).shape_derivative(q)
            }
            #[inline]
            fn normalisation(&self) -> f64 {
                (**self).normalisation()
            }
            #[inline]
            fn shape_derivative_over_q(&self, q: f64) -> f64 {
                (**self).shape_derivative_over_q(q)
            }
            // Forwarded, so that the loop is compiled for the kernel itself.
            fn values(&self, r_squared: &[f64], h: f64, values: &mut [f64]) -> Result<(), Error> {
                (**self).values(r_squared, h, values)
            }
            fn gradient_factors(
                &self,
                r_squared: &[f64],
                h: f64,
                factors: &mut [f64],
            ) -> Result<(), Error> {
                (**self).gradient_factors(r_squared, h, factors)
            }
        }
    )*};
}
forward!(&K, Box<K>);
