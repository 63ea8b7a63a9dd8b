//! Registers of `f64` and `f32` under one name.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use pulp::Simd;
use sde_integrators::SimdLevel;

/// Which lanes a bond is whole in, a bit for each.
pub(crate) type Mask = u16;

/// The most lanes that a mask has.
pub(crate) const MOST_LANES: usize = 16;

/// What loops over lanes are made of. Products are not fused with sums, so that every level gives the same bits.
pub trait Vectors: Copy {
    /// One register.
    type V<S: Simd>: Copy;

    /// How many numbers a register holds.
    fn lanes<S: Simd>() -> usize;
    /// The same number in every lane.
    fn splat<S: Simd>(simd: S, value: Self) -> Self::V<S>;
    /// The numbers of a slice from a place on.
    fn load<S: Simd>(values: &[Self], at: usize) -> Self::V<S>;
    /// Into a slice from a place on.
    fn store<S: Simd>(value: Self::V<S>, values: &mut [Self], at: usize);
    /// `a + b`.
    fn plus<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// `a - b`.
    fn minus<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// `a b`.
    fn times<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// Whether registers know masks that are a bit for each lane, so that [`keep`](Self::keep) costs less than to ask whether
    /// it is needed.
    fn has_masks<S: Simd>() -> bool;
    /// The lanes of a mask, zero in the others.
    fn keep<S: Simd>(simd: S, mask: Mask, value: Self::V<S>) -> Self::V<S>;
    /// `1 - 1/sqrt(1 + w)` as `w/(sqrt(1 + w) (1 + sqrt(1 + w)))`, which loses no digits.
    fn closed_pull<S: Simd>(simd: S, w: Self::V<S>) -> Self::V<S>;
    /// The lesser of two in each lane.
    fn lesser<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// The greater of two in each lane, the second where the first is no number.
    fn greater<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// Whether in any lane `|w| >= limit`.
    fn any_beyond<S: Simd>(simd: S, w: Self::V<S>, limit: Self::V<S>) -> bool;
    /// In lanes where `|w| >= limit` the first, in others the second.
    fn beyond_or<S: Simd>(
        simd: S,
        w_and_limit: (Self::V<S>, Self::V<S>),
        beyond: Self::V<S>,
        within: Self::V<S>,
    ) -> Self::V<S>;
}

macro_rules! vectors {
    ($real:ty, $unsigned:ty, $v:ident, $u:ident, $lanes:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident,
     $splat_u:ident, $and_u:ident, $equal_u:ident, $select:ident, $at_least:ident, $abs:ident, $min:ident,
     $max:ident, $sqrt:ident, $div:ident, $first:ident, $mask:ident) => {
        impl Vectors for $real {
            type V<S: Simd> = S::$v;

            #[inline(always)]
            fn lanes<S: Simd>() -> usize {
                S::$lanes
            }
            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> S::$v {
                simd.$splat(value)
            }
            #[inline(always)]
            fn load<S: Simd>(values: &[Self], at: usize) -> S::$v {
                let bytes: &[u8] = pulp::bytemuck::cast_slice(&values[at..at + S::$lanes]);
                pulp::bytemuck::pod_read_unaligned(bytes)
            }
            #[inline(always)]
            fn store<S: Simd>(value: S::$v, values: &mut [Self], at: usize) {
                let bytes = pulp::bytemuck::bytes_of(&value);
                values[at..at + S::$lanes].copy_from_slice(pulp::bytemuck::cast_slice(bytes));
            }
            #[inline(always)]
            fn plus<S: Simd>(simd: S, a: S::$v, b: S::$v) -> S::$v {
                simd.$add(a, b)
            }
            #[inline(always)]
            fn minus<S: Simd>(simd: S, a: S::$v, b: S::$v) -> S::$v {
                simd.$sub(a, b)
            }
            #[inline(always)]
            fn times<S: Simd>(simd: S, a: S::$v, b: S::$v) -> S::$v {
                simd.$mul(a, b)
            }
            #[inline(always)]
            fn has_masks<S: Simd>() -> bool {
                const { size_of::<S::$mask>() * 8 == S::$lanes }
            }
            #[inline(always)]
            fn keep<S: Simd>(simd: S, mask: Mask, value: S::$v) -> S::$v {
                const BITS: [$unsigned; MOST_LANES] = [
                    1 << 0,
                    1 << 1,
                    1 << 2,
                    1 << 3,
                    1 << 4,
                    1 << 5,
                    1 << 6,
                    1 << 7,
                    1 << 8,
                    1 << 9,
                    1 << 10,
                    1 << 11,
                    1 << 12,
                    1 << 13,
                    1 << 14,
                    1 << 15,
                ];
                // Where a mask is a bit for each lane, it is there already.
                if Self::has_masks::<S>() {
                    let bits = &mask.to_le_bytes()[..size_of::<S::$mask>()];
                    let lanes = pulp::bytemuck::checked::pod_read_unaligned(bits);
                    return simd.$select(lanes, value, simd.$splat(0.0));
                }
                let bits: S::$u =
                    *pulp::bytemuck::from_bytes(pulp::bytemuck::cast_slice(&BITS[..S::$lanes]));
                let set = simd.$and_u(simd.$splat_u(<$unsigned>::from(mask)), bits);
                simd.$select(simd.$equal_u(set, bits), value, simd.$splat(0.0))
            }
            #[inline(always)]
            fn closed_pull<S: Simd>(simd: S, w: S::$v) -> S::$v {
                let one = simd.$splat(1.0);
                let root = simd.$sqrt(simd.$add(one, w));
                simd.$div(w, simd.$mul(root, simd.$add(one, root)))
            }
            #[inline(always)]
            fn beyond_or<S: Simd>(
                simd: S,
                (w, limit): (S::$v, S::$v),
                beyond: S::$v,
                within: S::$v,
            ) -> S::$v {
                simd.$select(simd.$at_least(simd.$abs(w), limit), beyond, within)
            }
            #[inline(always)]
            fn lesser<S: Simd>(simd: S, a: S::$v, b: S::$v) -> S::$v {
                simd.$min(a, b)
            }
            #[inline(always)]
            fn greater<S: Simd>(simd: S, a: S::$v, b: S::$v) -> S::$v {
                simd.$max(a, b)
            }
            #[inline(always)]
            fn any_beyond<S: Simd>(simd: S, w: S::$v, limit: S::$v) -> bool {
                simd.$first(simd.$at_least(simd.$abs(w), limit)) < S::$lanes
            }
        }
    };
}

vectors!(
    f64,
    u64,
    f64s,
    u64s,
    F64_LANES,
    splat_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    splat_u64s,
    and_u64s,
    equal_u64s,
    select_f64s,
    greater_than_or_equal_f64s,
    abs_f64s,
    min_f64s,
    max_f64s,
    sqrt_f64s,
    div_f64s,
    first_true_m64s,
    m64s
);
vectors!(
    f32,
    u32,
    f32s,
    u32s,
    F32_LANES,
    splat_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    splat_u32s,
    and_u32s,
    equal_u32s,
    select_f32s,
    greater_than_or_equal_f32s,
    abs_f32s,
    min_f32s,
    max_f32s,
    sqrt_f32s,
    div_f32s,
    first_true_m32s,
    m32s
);

/// Runs work with the registers of a level.
pub(crate) fn dispatch<W: pulp::WithSimd>(level: SimdLevel, work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if level.name() == "avx512"
        && let Some(simd) = pulp::x86::V4::try_new()
    {
        return Simd::vectorize(simd, work);
    }
    dispatch_narrow(level, work)
}

/// The same with those of AVX2 at most: work that moves numbers between lanes gains nothing from wider ones.
pub(crate) fn dispatch_narrow<W: pulp::WithSimd>(level: SimdLevel, work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if matches!(level.name(), "avx2" | "avx512")
        && let Some(simd) = pulp::x86::V3::try_new()
    {
        return Simd::vectorize(simd, work);
    }
    let _ = level;
    Simd::vectorize(pulp::Scalar128b, work)
}
