//! A function of the distance over slices, on the widest registers of the machine.

use simd_lanes::dispatch;

use crate::error::Error;

/// `out[k] = f(√r_squared[k])`, bitwise identical to single calls.
///
/// The compiler vectorises the loop once for each width. It hoists invariants out of the loop, which preserves the
/// results, and fuses no multiplication with an addition, which would change them. Only functions inlined into the
/// dispatched closure are compiled for its registers: pass `f` with `#[inline(always)]`. Data that `f` holds by
/// reference could alias the output and would be reloaded for every pair: pass `f` with `move`.
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
