//! Which instructions the loops over lanes are compiled for.

use std::fmt;

/// A level of vector instructions that this machine has.
///
/// Every level gives the same bits; they differ in speed. What runs without being told runs at [`best`](Self::best).
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
    /// What every machine of the target has, SSE2 on x86-64.
    pub const PORTABLE: Self = Self(Level::Portable);

    /// The levels of this machine, the widest last.
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

    /// The widest level of this machine.
    #[must_use]
    pub fn best() -> Self {
        Self::available().last().unwrap_or(Self::PORTABLE)
    }

    /// "portable", "avx2" or "avx512".
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

    /// Runs work compiled for the level, as far as the work is inlined into this call: what it calls should be
    /// `#[inline(always)]`.
    pub fn call<R>(self, work: impl FnOnce() -> R) -> R {
        self.run(Work(work))
    }

    /// Run a function that was compiled for the level, as far as it is inlined.
    pub(crate) fn run<F: pulp::NullaryFnOnce>(self, function: F) -> F::Output {
        match self.0 {
            Level::Portable => function.call(),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2(token) => token.vectorize(function),
            #[cfg(target_arch = "x86_64")]
            Level::Avx512(token) => token.vectorize(function),
        }
    }
}

struct Work<F>(F);

impl<R, F: FnOnce() -> R> pulp::NullaryFnOnce for Work<F> {
    type Output = R;

    #[allow(clippy::inline_always, reason = "it is compiled for the registers of the level")]
    #[inline(always)]
    fn call(self) -> R {
        self.0()
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
