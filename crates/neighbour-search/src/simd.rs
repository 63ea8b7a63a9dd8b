//! Eight candidates at a time: the widest instructions that the machine has, found at run time, and a portable path.
//!
//! Every level computes the same formula in the same order, without fused operations, and so gives the same bits.
//! There is no `unsafe` here: `pulp` hands out its tokens only where the instructions exist.

/// Candidates tested at a time.
pub(crate) const LANES: usize = 8;

/// What a level of instructions does with eight candidates. Bit `k` of a mask is candidate `k`.
pub(crate) trait Lanes: Copy {
    type Vector: Copy;
    fn splat(self, value: f64) -> Self::Vector;
    fn load(self, values: &[f64; LANES]) -> Self::Vector;
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a <= b`.
    fn at_most(self, a: Self::Vector, b: Self::Vector) -> u8;
    /// `a < b`.
    fn below(self, a: Self::Vector, b: Self::Vector) -> u8;
    /// `ids < id`.
    fn before(self, ids: &[u32; LANES], id: u32) -> u8;
    /// `ids != id`.
    fn other(self, ids: &[u32; LANES], id: u32) -> u8;
    /// Writes the ids in the mask to the front of `out`; what is behind them there is of no account.
    fn compress(self, mask: u8, ids: &[u32; LANES], out: &mut [u32; LANES]);
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

    pub(crate) fn run(self, work: impl Work) {
        match self {
            Level::Portable => work.run(Portable),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2(token) => token.vectorize(OnLanes { lanes: token, work }),
            #[cfg(target_arch = "x86_64")]
            Level::Avx512(token) => token.vectorize(OnLanes { lanes: token, work }),
        }
    }
}

/// Eight values of a slice that is padded to hold them.
#[inline(always)]
pub(crate) fn eight<T>(slice: &[T], at: usize) -> &[T; LANES] {
    slice[at..at + LANES].first_chunk().expect("a slice of eight")
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

/// Instructions that every machine has.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Portable;

#[inline(always)]
fn mask(test: impl Fn(usize) -> bool) -> u8 {
    (0..LANES).fold(0, |mask, k| mask | u8::from(test(k)) << k)
}

#[inline(always)]
fn each(value: impl Fn(usize) -> f64) -> [f64; LANES] {
    core::array::from_fn(value)
}

impl Lanes for Portable {
    type Vector = [f64; LANES];

    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        [value; LANES]
    }
    #[inline(always)]
    fn load(self, values: &[f64; LANES]) -> Self::Vector {
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
    fn at_most(self, a: Self::Vector, b: Self::Vector) -> u8 {
        mask(|k| a[k] <= b[k])
    }
    #[inline(always)]
    fn below(self, a: Self::Vector, b: Self::Vector) -> u8 {
        mask(|k| a[k] < b[k])
    }
    #[inline(always)]
    fn before(self, ids: &[u32; LANES], id: u32) -> u8 {
        mask(|k| ids[k] < id)
    }
    #[inline(always)]
    fn other(self, ids: &[u32; LANES], id: u32) -> u8 {
        mask(|k| ids[k] != id)
    }
    #[inline(always)]
    fn compress(self, mask: u8, ids: &[u32; LANES], out: &mut [u32; LANES]) {
        // Every id is written, and the next writes over it unless it was in the mask: no branch to mispredict.
        let mut end = 0;
        for k in 0..LANES {
            out[end & (LANES - 1)] = ids[k];
            end += usize::from(mask >> k & 1);
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use core::arch::x86_64::{__m256d, __m256i, __m512d, _CMP_LE_OQ, _CMP_LT_OQ};

    use pulp::cast;
    use pulp::x86::{V3, V4};

    use super::{LANES, Lanes};

    /// For every mask, which lanes go to the front.
    static FRONT: [[u32; LANES]; 256] = front();

    const fn front() -> [[u32; LANES]; 256] {
        let mut table = [[0; LANES]; 256];
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

    /// The low bits of a movemask.
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 8 bits")]
    fn bits(mask: i32) -> u8 {
        mask as u8
    }

    #[inline(always)]
    fn both(half: impl Fn(usize) -> __m256d) -> [__m256d; 2] {
        [half(0), half(1)]
    }

    impl Lanes for V3 {
        type Vector = [__m256d; 2];

        #[inline(always)]
        fn splat(self, value: f64) -> Self::Vector {
            [cast([value; 4]); 2]
        }
        #[inline(always)]
        fn load(self, values: &[f64; LANES]) -> Self::Vector {
            cast(*values)
        }
        #[inline(always)]
        fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            both(|k| self.avx._mm256_add_pd(a[k], b[k]))
        }
        #[inline(always)]
        fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            both(|k| self.avx._mm256_sub_pd(a[k], b[k]))
        }
        #[inline(always)]
        fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            both(|k| self.avx._mm256_mul_pd(a[k], b[k]))
        }
        #[inline(always)]
        fn at_most(self, a: Self::Vector, b: Self::Vector) -> u8 {
            let [low, high] = both(|k| self.avx._mm256_cmp_pd::<_CMP_LE_OQ>(a[k], b[k]));
            bits(self.avx._mm256_movemask_pd(low) | self.avx._mm256_movemask_pd(high) << 4)
        }
        #[inline(always)]
        fn below(self, a: Self::Vector, b: Self::Vector) -> u8 {
            let [low, high] = both(|k| self.avx._mm256_cmp_pd::<_CMP_LT_OQ>(a[k], b[k]));
            bits(self.avx._mm256_movemask_pd(low) | self.avx._mm256_movemask_pd(high) << 4)
        }
        #[inline(always)]
        fn before(self, ids: &[u32; LANES], id: u32) -> u8 {
            // The instruction compares with a sign, so the highest bit is turned over.
            const SIGN: u32 = 1 << 31;
            let ids = self.avx2._mm256_xor_si256(cast(*ids), cast([SIGN; LANES]));
            let before = self.avx2._mm256_cmpgt_epi32(cast([id ^ SIGN; LANES]), ids);
            bits(self.avx._mm256_movemask_ps(self.avx._mm256_castsi256_ps(before)))
        }
        #[inline(always)]
        fn other(self, ids: &[u32; LANES], id: u32) -> u8 {
            let same = self.avx2._mm256_cmpeq_epi32(cast(*ids), cast([id; LANES]));
            !bits(self.avx._mm256_movemask_ps(self.avx._mm256_castsi256_ps(same)))
        }
        #[inline(always)]
        fn compress(self, mask: u8, ids: &[u32; LANES], out: &mut [u32; LANES]) {
            let front: __m256i = cast(FRONT[usize::from(mask)]);
            *out = cast(self.avx2._mm256_permutevar8x32_epi32(cast(*ids), front));
        }
    }

    impl Lanes for V4 {
        type Vector = __m512d;

        #[inline(always)]
        fn splat(self, value: f64) -> Self::Vector {
            cast([value; LANES])
        }
        #[inline(always)]
        fn load(self, values: &[f64; LANES]) -> Self::Vector {
            cast(*values)
        }
        #[inline(always)]
        fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx512f._mm512_add_pd(a, b)
        }
        #[inline(always)]
        fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx512f._mm512_sub_pd(a, b)
        }
        #[inline(always)]
        fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx512f._mm512_mul_pd(a, b)
        }
        #[inline(always)]
        fn at_most(self, a: Self::Vector, b: Self::Vector) -> u8 {
            self.avx512f._mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b)
        }
        #[inline(always)]
        fn below(self, a: Self::Vector, b: Self::Vector) -> u8 {
            self.avx512f._mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b)
        }
        #[inline(always)]
        fn before(self, ids: &[u32; LANES], id: u32) -> u8 {
            self.avx512f._mm256_cmplt_epu32_mask(cast(*ids), cast([id; LANES]))
        }
        #[inline(always)]
        fn other(self, ids: &[u32; LANES], id: u32) -> u8 {
            self.avx512f._mm256_cmpneq_epu32_mask(cast(*ids), cast([id; LANES]))
        }
        #[inline(always)]
        fn compress(self, mask: u8, ids: &[u32; LANES], out: &mut [u32; LANES]) {
            *out = cast(self.avx512f._mm256_maskz_compress_epi32(mask, cast(*ids)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Agrees;

    impl Work for Agrees {
        fn run<L: Lanes>(self, lanes: L) {
            let values = [0.0, -0.0, 1.0, f64::NAN, 2.0, f64::INFINITY, 1e-300, 1.0];
            let ids = [0, 1, u32::MAX, 1 << 31, 7, 7, (1 << 31) - 1, 3];
            let (v, p) = (lanes.load(&values), Portable);
            for pivot in values {
                let (a, b) = (lanes.splat(pivot), p.splat(pivot));
                assert_eq!(lanes.at_most(v, a), p.at_most(values, b));
                assert_eq!(lanes.below(v, a), p.below(values, b));
                let ours = lanes.sub(lanes.add(lanes.mul(v, v), a), v);
                let portable = p.sub(p.add(p.mul(values, values), b), values);
                assert_eq!(lanes.at_most(ours, a), p.at_most(portable, b));
            }
            for id in ids {
                assert_eq!(lanes.before(&ids, id), p.before(&ids, id));
                assert_eq!(lanes.other(&ids, id), p.other(&ids, id));
            }
            for mask in 0..=u8::MAX {
                let (mut ours, mut portable) = ([0; LANES], [0; LANES]);
                lanes.compress(mask, &ids, &mut ours);
                p.compress(mask, &ids, &mut portable);
                let n = mask.count_ones() as usize;
                assert_eq!(ours[..n], portable[..n]);
            }
        }
    }

    #[test]
    fn every_level_of_this_machine_does_as_the_portable_one() {
        assert!(matches!(Level::all().next(), Some(Level::Portable)));
        Level::all().for_each(|level| level.run(Agrees));
    }
}
