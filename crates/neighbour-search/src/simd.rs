//! Many candidates at a time: the widest instructions that the machine has, found at run time, and a portable path.
//!
//! Squared distances are in single precision here and decide nothing that is close: see `neighbourhood`. Every level
//! therefore lists the same candidates in the same order, whether it fuses a product with a sum or not.
//! There is no `unsafe`: `pulp` hands out its tokens only where the instructions exist.

/// Most candidates that any level tests at a time, and what buffers are padded by.
pub(crate) const PAD: usize = 16;

/// What a level of instructions does with `N` candidates. Bit `k` of a mask is candidate `k`.
pub(crate) trait Lanes: Copy {
    /// Candidates at a time, at most [`PAD`].
    const N: usize;
    type Vector: Copy;
    /// `N` values, and `N` ids.
    type Floats;
    type Ids;
    fn floats(values: &[f32]) -> &[Self::Floats];
    fn ids(ids: &[u32]) -> &[Self::Ids];
    fn floats_at(values: &[f32], at: usize) -> &Self::Floats;
    fn ids_at(ids: &[u32], at: usize) -> &Self::Ids;
    fn splat(self, value: f32) -> Self::Vector;
    fn load(self, values: &Self::Floats) -> Self::Vector;
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a b + c`, rounded once or twice.
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a < b`.
    fn below(self, a: Self::Vector, b: Self::Vector) -> u32;
    /// Writes the ids in the mask to the front of `N` entries, what is behind them there being of no account, and returns
    /// how many they are.
    fn compress(self, mask: u32, ids: &Self::Ids, out: &mut [u32], to: usize) -> usize;
    /// As [`compress`](Self::compress), of a vector.
    fn compress_vector(self, mask: u32, vector: Self::Vector, out: &mut [f32], to: usize);
}

/// A loop over lanes, to be compiled once for each level.
pub(crate) trait Work {
    fn run<L: Lanes>(self, lanes: L);
}

/// A level of instructions.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Level {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
    #[cfg(target_arch = "x86_64")]
    Avx512(pulp::x86::V4),
}

impl Level {
    /// The levels that this machine has, the widest last.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        #[cfg(target_arch = "x86_64")]
        let wider = [
            pulp::x86::V3::try_new().map(Level::Avx2),
            pulp::x86::V4::try_new().map(Level::Avx512),
        ];
        #[cfg(not(target_arch = "x86_64"))]
        let wider = [];
        core::iter::once(Level::Portable).chain(wider.into_iter().flatten())
    }

    /// The widest.
    pub(crate) fn best() -> Self {
        Self::all().last().unwrap_or(Level::Portable)
    }

    #[inline]
    pub(crate) fn run(self, work: impl Work) {
        match self {
            Level::Portable => work.run(Portable::new()),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2(token) => token.vectorize(OnLanes { lanes: token, work }),
            #[cfg(target_arch = "x86_64")]
            Level::Avx512(token) => token.vectorize(OnLanes { lanes: token, work }),
        }
    }
}

#[cfg(target_arch = "x86_64")]
struct OnLanes<L, W> {
    lanes: L,
    work: W,
}

#[cfg(target_arch = "x86_64")]
impl<L: Lanes, W: Work> pulp::NullaryFnOnce for OnLanes<L, W> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.work.run(self.lanes);
    }
}

#[inline(always)]
fn first<T, const N: usize>(slice: &[T], at: usize) -> &[T; N] {
    slice[at..at + N].first_chunk().expect("a slice of N")
}

#[inline(always)]
fn first_mut<T, const N: usize>(slice: &mut [T], at: usize) -> &mut [T; N] {
    slice[at..at + N].first_chunk_mut().expect("a slice of N")
}

/// Slices as so many values at a time.
macro_rules! views {
    ($n:expr) => {
        type Floats = [f32; $n];
        type Ids = [u32; $n];

        #[inline(always)]
        fn floats(values: &[f32]) -> &[Self::Floats] {
            values.as_chunks().0
        }
        #[inline(always)]
        fn ids(ids: &[u32]) -> &[Self::Ids] {
            ids.as_chunks().0
        }
        #[inline(always)]
        fn floats_at(values: &[f32], at: usize) -> &Self::Floats {
            first(values, at)
        }
        #[inline(always)]
        fn ids_at(ids: &[u32], at: usize) -> &Self::Ids {
            first(ids, at)
        }
    };
}

/// Instructions that every machine has.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Portable {
    /// Every x86-64 has it, and it makes a mask of four comparisons at once.
    #[cfg(target_arch = "x86_64")]
    sse: pulp::core_arch::x86::Sse,
}

impl Portable {
    fn new() -> Self {
        Self {
            #[cfg(target_arch = "x86_64")]
            sse: pulp::core_arch::x86::Sse::try_new().expect("every x86-64 has SSE"),
        }
    }
}

/// Candidates at a time where the compiler chooses the registers.
const PORTABLE: usize = 8;

#[inline(always)]
fn each(value: impl Fn(usize) -> f32) -> [f32; PORTABLE] {
    core::array::from_fn(value)
}

/// Every value is written, and the next writes over it unless it was in the mask: no branch to mispredict.
#[inline(always)]
fn to_front<T: Copy>(mask: u32, values: &[T; PORTABLE], out: &mut [T; PORTABLE]) -> usize {
    let mut end = 0;
    for k in 0..PORTABLE {
        out[end & (PORTABLE - 1)] = values[k];
        end += (mask >> k & 1) as usize;
    }
    end
}

impl Lanes for Portable {
    const N: usize = PORTABLE;
    type Vector = [f32; PORTABLE];
    views!(PORTABLE);
    #[inline(always)]
    fn splat(self, value: f32) -> Self::Vector {
        [value; PORTABLE]
    }
    #[inline(always)]
    fn load(self, values: &Self::Floats) -> Self::Vector {
        *values
    }
    #[inline(always)]
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        each(|k| a[k] + b[k])
    }
    #[inline(always)]
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        each(|k| a[k] - b[k])
    }
    #[inline(always)]
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        each(|k| a[k] * b[k])
    }
    #[inline(always)]
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        each(|k| a[k] * b[k] + c[k])
    }
    #[inline(always)]
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        each(|k| if a[k] > b[k] { a[k] } else { b[k] })
    }
    #[inline(always)]
    #[cfg(target_arch = "x86_64")]
    #[expect(clippy::cast_sign_loss, reason = "the bits of a movemask")]
    fn below(self, a: Self::Vector, b: Self::Vector) -> u32 {
        let (a, b): ([_; 2], [_; 2]) = (pulp::cast(a), pulp::cast(b));
        let half = |k: usize| self.sse._mm_movemask_ps(self.sse._mm_cmplt_ps(a[k], b[k])) as u32;
        half(0) | half(1) << 4
    }
    #[inline(always)]
    #[cfg(not(target_arch = "x86_64"))]
    fn below(self, a: Self::Vector, b: Self::Vector) -> u32 {
        (0..PORTABLE).fold(0, |mask, k| mask | u32::from(a[k] < b[k]) << k)
    }
    #[inline(always)]
    fn compress(self, mask: u32, ids: &Self::Ids, out: &mut [u32], to: usize) -> usize {
        to_front(mask, ids, first_mut(out, to))
    }
    #[inline(always)]
    fn compress_vector(self, mask: u32, vector: Self::Vector, out: &mut [f32], to: usize) {
        to_front(mask, &vector, first_mut(out, to));
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use core::arch::x86_64::{__m256, __m256i, __m512, _CMP_LT_OQ};

    use pulp::cast;
    use pulp::x86::{V3, V4};

    use super::{Lanes, first, first_mut};

    /// For every mask of eight, which lanes go to the front.
    static FRONT: [[u32; 8]; 256] = front();

    const fn front() -> [[u32; 8]; 256] {
        let mut table = [[0; 8]; 256];
        let mut mask = 0;
        while mask < 256 {
            let (mut lane, mut end) = (0, 0);
            while lane < 8 {
                if mask >> lane & 1 == 1 {
                    table[mask][end] = lane;
                    end += 1;
                }
                lane += 1;
            }
            mask += 1;
        }
        table
    }

    #[inline(always)]
    #[expect(clippy::cast_sign_loss, reason = "the bits of a movemask")]
    fn bits(mask: i32) -> u32 {
        mask as u32
    }

    impl Lanes for V3 {
        const N: usize = 8;
        type Vector = __m256;
        views!(8);
        #[inline(always)]
        fn splat(self, value: f32) -> Self::Vector {
            cast([value; 8])
        }
        #[inline(always)]
        fn load(self, values: &Self::Floats) -> Self::Vector {
            cast(*values)
        }
        #[inline(always)]
        fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx._mm256_add_ps(a, b)
        }
        #[inline(always)]
        fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx._mm256_sub_ps(a, b)
        }
        #[inline(always)]
        fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx._mm256_mul_ps(a, b)
        }
        #[inline(always)]
        fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
            self.fma._mm256_fmadd_ps(a, b, c)
        }
        #[inline(always)]
        fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx._mm256_max_ps(a, b)
        }
        #[inline(always)]
        fn below(self, a: Self::Vector, b: Self::Vector) -> u32 {
            bits(self.avx._mm256_movemask_ps(self.avx._mm256_cmp_ps::<_CMP_LT_OQ>(a, b)))
        }
        #[inline(always)]
        fn compress(self, mask: u32, ids: &Self::Ids, out: &mut [u32], to: usize) -> usize {
            let front: __m256i = cast(FRONT[(mask & 0xff) as usize]);
            let ids = cast(*ids);
            *first_mut::<u32, 8>(out, to) = cast(self.avx2._mm256_permutevar8x32_epi32(ids, front));
            mask.count_ones() as usize
        }
        #[inline(always)]
        fn compress_vector(self, mask: u32, vector: Self::Vector, out: &mut [f32], to: usize) {
            let front: __m256i = cast(FRONT[(mask & 0xff) as usize]);
            *first_mut::<f32, 8>(out, to) = cast(self.avx2._mm256_permutevar8x32_ps(vector, front));
        }
    }

    impl Lanes for V4 {
        const N: usize = 16;
        type Vector = __m512;
        views!(16);
        #[inline(always)]
        fn splat(self, value: f32) -> Self::Vector {
            cast([value; 16])
        }
        #[inline(always)]
        fn load(self, values: &Self::Floats) -> Self::Vector {
            cast(*values)
        }
        #[inline(always)]
        fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx512f._mm512_add_ps(a, b)
        }
        #[inline(always)]
        fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx512f._mm512_sub_ps(a, b)
        }
        #[inline(always)]
        fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx512f._mm512_mul_ps(a, b)
        }
        #[inline(always)]
        fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
            self.avx512f._mm512_fmadd_ps(a, b, c)
        }
        #[inline(always)]
        fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx512f._mm512_max_ps(a, b)
        }
        #[inline(always)]
        fn below(self, a: Self::Vector, b: Self::Vector) -> u32 {
            self.avx512f._mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b).into()
        }
        #[inline(always)]
        #[expect(clippy::cast_possible_truncation, reason = "sixteen lanes, sixteen bits")]
        fn compress(self, mask: u32, ids: &Self::Ids, out: &mut [u32], to: usize) -> usize {
            let ids = cast(*ids);
            // To a register and out whole: compressing into memory is slow on some machines.
            *first_mut::<u32, 16>(out, to) =
                cast(self.avx512f._mm512_maskz_compress_epi32(mask as u16, ids));
            mask.count_ones() as usize
        }
        #[inline(always)]
        #[expect(clippy::cast_possible_truncation, reason = "sixteen lanes, sixteen bits")]
        fn compress_vector(self, mask: u32, vector: Self::Vector, out: &mut [f32], to: usize) {
            *first_mut::<f32, 16>(out, to) =
                cast(self.avx512f._mm512_maskz_compress_ps(mask as u16, vector));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALUES: [f32; PAD] = [
        0.0,
        -0.0,
        1.0,
        f32::NAN,
        2.0,
        f32::INFINITY,
        1e-38,
        1.0,
        -1.0,
        1e30,
        3.0,
        0.5,
        -2.0,
        7.0,
        0.25,
        -1e30,
    ];
    const IDS: [u32; PAD] =
        [0, 1, u32::MAX, 1 << 31, 7, 7, (1 << 31) - 1, 3, 9, 4, 8, 2, 5, 6, 10, 11];

    struct Agrees;

    impl Work for Agrees {
        fn run<L: Lanes>(self, lanes: L) {
            assert!(L::N <= PAD && PAD.is_multiple_of(L::N));
            for at in (0..PAD).step_by(L::N) {
                let (values, ids) = (lanes.load(L::floats_at(&VALUES, at)), L::ids_at(&IDS, at));
                let bit = |test: &dyn Fn(usize) -> bool| {
                    (0..L::N).fold(0, |mask, k| mask | u32::from(test(at + k)) << k)
                };
                for pivot in VALUES {
                    let a = lanes.splat(pivot);
                    assert_eq!(lanes.below(values, a), bit(&|k| VALUES[k] < pivot));
                    let sum = lanes.sub(lanes.add(lanes.mul(values, values), a), values);
                    let expected = |k: usize| VALUES[k] * VALUES[k] + pivot - VALUES[k] < 1.5;
                    assert_eq!(lanes.below(sum, lanes.splat(1.5)), bit(&expected));
                    // Small whole numbers are exact, fused or not.
                    let fused = lanes.mul_add(lanes.splat(3.0), lanes.splat(5.0), values);
                    let expected = |k: usize| 15.0 + VALUES[k] < 17.0;
                    assert_eq!(lanes.below(fused, lanes.splat(17.0)), bit(&expected));
                    if pivot.is_finite() {
                        let larger = lanes.max(lanes.splat(pivot), lanes.splat(0.75));
                        let expected = if pivot.max(0.75) < 1.0 { bit(&|_| true) } else { 0 };
                        assert_eq!(lanes.below(larger, lanes.splat(1.0)), expected);
                    }
                }
                for mask in 0..1_u32 << L::N {
                    let mut out = [0; PAD];
                    let count = lanes.compress(mask, ids, &mut out, 0);
                    assert_eq!(count, mask.count_ones() as usize);
                    let kept = (0..L::N).filter(|k| mask >> k & 1 == 1).map(|k| IDS[at + k]);
                    assert!(kept.eq(out[..mask.count_ones() as usize].iter().copied()));
                    let mut out = [0.0; PAD];
                    lanes.compress_vector(mask, values, &mut out, 0);
                    let kept = (0..L::N).filter(|k| mask >> k & 1 == 1).map(|k| VALUES[at + k]);
                    let out = out[..mask.count_ones() as usize].iter();
                    assert!(kept.map(f32::to_bits).eq(out.map(|value| value.to_bits())));
                }
            }
        }
    }

    #[test]
    fn every_level_of_this_machine_does_as_scalar_code_does() {
        assert!(matches!(Level::all().next(), Some(Level::Portable)));
        Level::all().for_each(|level| level.run(Agrees));
    }
}
