//! The laws that a kernel of one's own must keep.

use crate::error::Error;
use crate::kernel::{Kernel, radial};
use crate::marginal::radial_moment;

/// Places of the shape that are looked at, in the middles of equal parts of the support: no spline changes piece there.
const N_PLACES: u16 = 200;

/// Largest error of the integral. Quadrature is exact within roundoff for what is smooth between sixtieths of the support.
const OF_INTEGRAL: f64 = 1e-8;

/// Largest error of a slope, as a part of the steepest one. Central differences are off by a few 1e-9 of it.
const OF_SLOPE: f64 = 1e-6;

/// Checks that a kernel keeps what the solvers rely on: call it in a test of a kernel of your own.
///
/// - The support is positive and finite, and shape and slope are zero from it on.
/// - The slope is that of the shape: central differences, within 1e-6 of the steepest slope.
/// - [`shape_derivative_over_q`](Kernel::shape_derivative_over_q) times `q` is the slope, likewise.
/// - The kernel integrates to one over `D` dimensions within 1e-8.
///
/// Signs are not looked at: kernels of higher order are negative somewhere. A jump at the edge of the support, as of a cut
/// Gaussian, is admitted.
///
/// ```
/// use smoothing_kernels::{Kernel, WendlandC2, check_kernel};
///
/// check_kernel::<3, _>(&WendlandC2)?;
/// # Ok::<(), smoothing_kernels::Error>(())
/// ```
///
/// # Errors
/// [`Error::KernelSupport`]; [`Error::KernelLaw`] for the first law that is broken, with the place, the value and what it must be.
pub fn check_kernel<const D: usize, K: Kernel<D> + ?Sized>(kernel: &K) -> Result<(), Error> {
    let support = kernel.support();
    let require = |law, q: f64, value: f64, expected: f64, limit: f64| {
        // NaN is within no limit.
        if (value - expected).abs() <= limit {
            return Ok(());
        }
        Err(Error::KernelLaw { law, dimension: D, q, value, expected, limit })
    };
    if !(support > 0.0 && support.is_finite()) {
        return Err(Error::KernelSupport { value: support });
    }
    for q in [support, 1.5 * support, 1e3 * support] {
        require("the shape beyond the support", q, kernel.shape(q), 0.0, 0.0)?;
        require("the slope beyond the support", q, kernel.shape_derivative(q), 0.0, 0.0)?;
    }
    let part = support / f64::from(N_PLACES);
    let places = || (0..N_PLACES).map(|k| (f64::from(k) + 0.5) * part);
    let steepest = places().map(|q| kernel.shape_derivative(q).abs()).fold(0.0, f64::max);
    let (step, limit) = (1e-3 * part, OF_SLOPE * steepest);
    for q in places() {
        let slope = kernel.shape_derivative(q);
        let difference = (kernel.shape(q + step) - kernel.shape(q - step)) / (2.0 * step);
        require("the slope", q, slope, difference, limit)?;
        let quotient = kernel.shape_derivative_over_q(q);
        require("the slope over q, times q,", q, q * quotient, slope, limit)?;
    }
    let integral = radial_moment::<D, _, _>(&radial(kernel), 0);
    require("the integral", support, integral, 1.0, OF_INTEGRAL)
}
