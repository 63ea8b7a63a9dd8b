//! A function of the distance over slices, by the widest registers that the machine has.

use lanes::dispatch;

use crate::error::Error;

/// `out[k] = f(√r_squared[k])`, by the operations of one call in their order, so the bits are the same.
///
/// The compiler vectorises the loop once for each width: it takes what does not vary out of the loop, which changes no
/// bits, and fuses no multiplication with an addition, which would. What is not inlined into the dispatched closure is not
/// compiled for its registers: pass `f` with `#[inline(always)]`. What `f` holds by reference might be what the loop writes,
/// and would be read again for every pair: pass `f` with `move`.
#[inline]
pub(crate) fn each(
    r_squared: &[f64],
    out: &mut [f64],
    f: impl Fn(f64) -> f64,
) -> Result<(), Error> {
    if r_squared.len() != out.len() {
        return Err(Error::LengthMismatch { given: out.len(), expected: r_squared.len() });
    }
    dispatch(
        #[inline(always)]
        move || {
            for (out, r_squared) in out.iter_mut().zip(r_squared) {
                *out = f(r_squared.sqrt());
            }
        },
    );
    Ok(())
}
