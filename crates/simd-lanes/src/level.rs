//! SIMD levels, and work compiled for each of them.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::fmt;

use crate::numbers::Lanes;
use crate::portable::Portable;
use crate::registers::{Registers, Work};
#[cfg(target_arch = "x86_64")]
use crate::x86::On;

/// A SIMD level that this machine supports.
///
/// All levels give bitwise identical results and differ only in speed. Every function that takes a level defaults to
/// [`best`](Self::best).
#[derive(Clone, Copy)]
pub struct SimdLevel(Level);

#[derive(Clone, Copy)]
enum Level {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
    #[cfg(target_arch = "x86_64")]
    Avx512(pulp::x86::V4),
}

impl SimdLevel {
    /// Instructions that every machine of the target supports: SSE2 on x86-64, NEON on AArch64.
    pub const PORTABLE: Self = Self(Level::Portable);

    /// Levels that this machine supports, the widest last.
    pub fn available() -> impl Iterator<Item = Self> {
        #[cfg(target_arch = "x86_64")]
        let wider = [
            pulp::x86::V3::try_new().map(Level::Avx2),
            pulp::x86::V4::try_new().map(Level::Avx512),
        ];
        #[cfg(not(target_arch = "x86_64"))]
        let wider = [];
        std::iter::once(Level::Portable).chain(wider.into_iter().flatten()).map(Self)
    }

    /// The widest level that this machine supports.
    #[inline]
    #[must_use]
    pub fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(token) = pulp::x86::V4::try_new() {
            return Self(Level::Avx512(token));
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(token) = pulp::x86::V3::try_new() {
            return Self(Level::Avx2(token));
        }
        Self::PORTABLE
    }

    /// Name of the level: "portable", "avx2" or "avx512".
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self.0 {
            Level::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Level::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Level::Avx512(_) => "avx512",
        }
    }

    /// Runs work compiled for this level.
    ///
    /// Functions that the work calls are compiled for the level only if they are inlined: mark them
    /// `#[inline(always)]`.
    #[inline]
    pub fn run<T: Float, W: Work<T>>(self, work: W) -> W::Output {
        T::run_at(self, work)
    }

    /// Runs work as [`run`](Self::run) does, with AVX2 at most.
    ///
    /// Use it for work that moves numbers between lanes, which gains nothing from wider registers. It is compiled for
    /// no wider level.
    #[inline]
    pub fn run_narrow<T: Float, W: Work<T>>(self, work: W) -> W::Output {
        T::run_narrow_at(self, work)
    }

    /// Runs a closure compiled for this level, as [`dispatch`] does for the widest level.
    ///
    /// Pass a closure that consumes none of its captures to [`dispatch`] instead, which calls it by reference.
    #[inline]
    pub fn call<R>(self, work: impl FnOnce() -> R) -> R {
        self.run(Once(work))
    }
}

/// Runs a closure compiled for the widest registers of this machine, selected at run time.
///
/// Code inlined into the closure is compiled for AVX-512, AVX2 and the portable level: mark the closure and the
/// functions it calls `#[inline(always)]`. A call costs a few nanoseconds, so pass a whole loop, not one evaluation.
///
/// ```
/// let x = [0.25, 1.0, 4.0];
/// let mut y = [0.0; 3];
/// simd_lanes::dispatch(
///     #[inline(always)]
///     || {
///         for (y, x) in y.iter_mut().zip(x) {
///             *y = simd_lanes::power(x, 0.5);
///         }
///     },
/// );
/// assert_eq!(y, [0.5, 1.0, 2.0]);
/// ```
#[inline]
pub fn dispatch<R>(work: impl FnMut() -> R) -> R {
    SimdLevel::best().run(Repeatable(work))
}

/// Dispatches as [`dispatch`] does, with registers of at most four `f64` (AVX2).
///
/// Use it for loops over a few numbers at a time: for AVX-512 the compiler would fill registers by gather
/// instructions, which take longer than the arithmetic.
#[inline]
pub fn dispatch_narrow<R>(work: impl FnMut() -> R) -> R {
    // Not through `SimdLevel`: each level would compile the closure again.
    #[cfg(target_arch = "x86_64")]
    if let Some(token) = pulp::x86::V3::try_new() {
        return token.vectorize(On::new(token, Repeatable(work)));
    }
    Repeatable(work).run(Portable::new())
}

/// Element type of a register: `f64` or `f32`.
pub trait Float:
    Lanes<Number = Self, Mask = bool> + PartialOrd + Default + fmt::Debug + Send + Sync + 'static
{
    /// Runs work at a level; callers use [`SimdLevel::run`].
    #[doc(hidden)]
    fn run_at<W: Work<Self>>(level: SimdLevel, work: W) -> W::Output;
    /// Runs work at a level, AVX2 at most; callers use [`SimdLevel::run_narrow`].
    #[doc(hidden)]
    fn run_narrow_at<W: Work<Self>>(level: SimdLevel, work: W) -> W::Output;
}

macro_rules! float {
    ($real:ty) => {
        impl Float for $real {
            #[inline]
            fn run_at<W: Work<Self>>(level: SimdLevel, work: W) -> W::Output {
                match level.0 {
                    Level::Portable => work.run(Portable::new()),
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx2(token) => token.vectorize(On::new(token, work)),
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx512(token) => token.vectorize(On::new(token, work)),
                }
            }

            #[inline]
            fn run_narrow_at<W: Work<Self>>(level: SimdLevel, work: W) -> W::Output {
                match level.0 {
                    Level::Portable => work.run(Portable::new()),
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx2(token) => token.vectorize(On::new(token, work)),
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx512(token) => {
                        let narrow: pulp::x86::V3 = *token;
                        narrow.vectorize(On::new(narrow, work))
                    }
                }
            }
        }
    };
}
float!(f64);
float!(f32);

struct Once<F>(F);

impl<R, F: FnOnce() -> R> Work<f64> for Once<F> {
    type Output = R;

    #[inline(always)]
    fn run<V: Registers<f64>>(self, _: V) -> R {
        self.0()
    }
}

/// Wraps a closure that is called by reference.
///
/// Calling a closure by value goes through a compiler shim. The shim is not inlined when it has two callers, and is
/// then compiled for the narrowest registers.
struct Repeatable<F>(F);

impl<R, F: FnMut() -> R> Work<f64> for Repeatable<F> {
    type Output = R;

    #[inline(always)]
    fn run<V: Registers<f64>>(mut self, _: V) -> R {
        (self.0)()
    }
}

impl PartialEq for SimdLevel {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for SimdLevel {}

impl fmt::Debug for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SimdLevel({})", self.name())
    }
}

impl fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
