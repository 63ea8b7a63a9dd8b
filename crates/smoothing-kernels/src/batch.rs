//! A kernel over slices, by the widest registers that the machine has.

use pulp::Arch;

use crate::error::Error;
use crate::kernel::Kernel;

/// `W(√r², h)` for every `r²`: the operations of [`Kernel::value`] in their order, so the bits are the same.
pub(crate) fn values<const D: usize, K: Kernel<D> + ?Sized>(
    kernel: &K,
    r_squared: &[f64],
    h: f64,
    values: &mut [f64],
) -> Result<(), Error> {
    each(
        r_squared,
        values,
        #[inline(always)]
        move |r| kernel.value(r, h),
    )
}

/// `(dW/dr) / r` for every `r²`, with the bits of [`Kernel::gradient_factor`].
pub(crate) fn gradient_factors<const D: usize, K: Kernel<D> + ?Sized>(
    kernel: &K,
    r_squared: &[f64],
    h: f64,
    factors: &mut [f64],
) -> Result<(), Error> {
    each(
        r_squared,
        factors,
        #[inline(always)]
        move |r| kernel.gradient_factor(r, h),
    )
}

/// The loop that the compiler vectorises, once for each width: it takes what does not vary out of the loop, which
/// changes no bits, and fuses no multiplication with an addition, which would. What is not inlined into the dispatched
/// closure is not compiled for its registers, hence the attributes; what it holds by reference might be what it writes,
/// and would be read again for every pair, hence `move`.
#[inline]
fn each(r_squared: &[f64], out: &mut [f64], f: impl Fn(f64) -> f64) -> Result<(), Error> {
    if r_squared.len() != out.len() {
        return Err(Error::LengthMismatch { given: out.len(), expected: r_squared.len() });
    }
    Arch::new().dispatch(
        #[inline(always)]
        move || {
            for (out, r_squared) in out.iter_mut().zip(r_squared) {
                *out = f(r_squared.sqrt());
            }
        },
    );
    Ok(())
}
