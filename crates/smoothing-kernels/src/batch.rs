//! A function of the distance over slices, by the widest registers that the machine has.

use pulp::Arch;

use crate::error::Error;

/// `f(√r²)` for every `r²`, with the bits of single calls.
///
/// The loop that the compiler vectorises, once for each width: it takes what does not vary out of the loop, which
/// changes no bits, and fuses no multiplication with an addition, which would. What is not inlined into the dispatched
/// closure is not compiled for its registers, so `f` is `#[inline(always)]`; what it holds by reference might be what it
/// writes, and would be read again for every pair, so `f` is a `move` closure.
#[inline]
pub(crate) fn each(
    r_squared: &[f64],
    out: &mut [f64],
    f: impl Fn(f64) -> f64,
) -> Result<(), Error> {
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
