//! Registers of every level compared with scalars.

use simd_lanes::{Float, Lanes, MOST_LANES, Mask, Registers, SimdLevel, Work};

/// One formula with every operation on two operands, over numbers and registers.
#[allow(clippy::inline_always, reason = "compiled for the registers of a level")]
#[inline(always)]
fn results<N: Lanes>(a: N, b: N) -> [N; 15] {
    let (less, at_least) = (a.less(b), a.at_least(b));
    [
        a + b,
        a - b,
        a * b,
        a / b,
        a.sqrt(),
        a.abs(),
        a.min(b),
        a.max(b),
        N::select(less, a, b * a),
        N::select(at_least, b, a * a),
        a * b + a,
        a.exp(),
        a.ln(),
        (a * b).exp(),
        (a / b).ln(),
    ]
}

/// Bit pattern of a number; NaN has many, which IEEE 754 leaves open.
trait Bits: Float {
    fn bits(self) -> u64;
    fn of(value: f64) -> Self;
}

impl Bits for f64 {
    fn bits(self) -> u64 {
        if self.is_nan() { Self::NAN.to_bits() } else { self.to_bits() }
    }
    fn of(value: f64) -> Self {
        value
    }
}

impl Bits for f32 {
    fn bits(self) -> u64 {
        (if self.is_nan() { Self::NAN } else { self }).to_bits().into()
    }
    #[expect(clippy::cast_possible_truncation, reason = "the nearest number, or infinite")]
    fn of(value: f64) -> Self {
        value as Self
    }
}

/// Ordinary numbers, both zeros, subnormal ones of both types, and those at the ends of their ranges.
const VALUES: [f64; MOST_LANES] = [
    0.0,
    -0.0,
    1.0,
    f64::NAN,
    2.0 / 3.0,
    f64::INFINITY,
    1e-40,
    1.0,
    -1.1,
    3e38,
    5e-324,
    0.3,
    f64::NEG_INFINITY,
    7.7,
    -1e-20,
    -f64::MAX,
];
const IDS: [u32; MOST_LANES] =
    [0, 1, u32::MAX, 1 << 31, 7, 7, (1 << 31) - 1, 3, 9, 4, 8, 2, 5, 6, 10, 11];

struct Agrees<T>(std::marker::PhantomData<T>);

impl<T: Bits> Work<T> for Agrees<T> {
    type Output = ();

    fn run<R: Registers<T>>(self, registers: R) {
        assert!(R::N <= MOST_LANES && MOST_LANES.is_multiple_of(R::N));
        let values = VALUES.map(T::of);
        for at in (0..MOST_LANES).step_by(R::N) {
            for other in 0..MOST_LANES {
                agree_at(registers, &values, at, other);
            }
            compress_at(registers, &values, at);
        }
        fours(registers);
    }
}

/// Transposes and sums blocks of four lanes of four rows, which differ in every entry.
fn fours<T: Bits, R: Registers<T>>(registers: R) {
    let mut rows = [[T::default(); MOST_LANES]; 4];
    for (i, row) in rows.iter_mut().enumerate() {
        for (k, entry) in row.iter_mut().enumerate() {
            // Their sums are rounded, so that another order of summation gives other bits.
            *entry = T::of(1.0 / (1 + MOST_LANES * i + k) as f64);
        }
    }
    let vectors = [0, 1, 2, 3].map(|i| registers.load_at(&rows[i], 0));
    let stored = |vector: R::Vector| {
        let mut stored = [T::default(); MOST_LANES];
        registers.store_at(vector, &mut stored, 0);
        stored.map(Bits::bits)
    };
    let (transposed, sums) =
        (registers.transpose_fours(vectors).map(stored), stored(registers.sum_fours(vectors)));
    let places: Vec<&[T; 4]> = (0..R::N / 4)
        .map(|block| rows[block % 4][3 * block..].first_chunk().expect("a slice of four"))
        .collect();
    let (loaded, spread) =
        (stored(registers.load_fours(&places)), registers.spread_fours(&places).map(stored));
    let unzipped = registers.unzip_fours(vectors[0], vectors[1]).map(stored);
    let [first, second] = registers.unzip_fours(vectors[0], vectors[1]);
    assert_eq!(registers.zip_fours(first, second).map(stored), [0, 1].map(|i| stored(vectors[i])));
    for lane in 0..R::N {
        let (block, k) = (lane / 4 * 4, lane % 4);
        assert_eq!(loaded[lane], places[block / 4][k].bits());
        assert_eq!(registers.four(vectors[2], block / 4)[k].bits(), rows[2][lane].bits());
        let mut total = *places[0];
        registers.add_four(vectors[1], block / 4, &mut total);
        assert_eq!(total[k].bits(), (places[0][k] + rows[1][lane]).bits());
        for i in 0..2 {
            assert_eq!(unzipped[i][lane], rows[k / 2][block + 2 * (k % 2) + i].bits());
        }
        for i in 0..4 {
            assert_eq!(spread[i][lane], places[block / 4][i].bits());
        }
        for i in 0..4 {
            assert_eq!(transposed[k][block + i], rows[i][lane].bits(), "row {i}, lane {lane}");
        }
        let of = &rows[k][block..block + 4];
        let sum = (of[0] + of[1]) + (of[2] + of[3]);
        assert_eq!(sums[lane], sum.bits(), "the sum of block {block} of row {k}");
    }
}

/// Compares the operations on the numbers from an index on, each with one operand.
fn agree_at<T: Bits, R: Registers<T>>(
    registers: R,
    values: &[T; MOST_LANES],
    at: usize,
    other: usize,
) {
    let bit = |test: &dyn Fn(T) -> bool| {
        (0..R::N).fold(0, |mask, k| mask | u32::from(test(values[at + k])) << k)
    };
    let (a, b) = (registers.load_at(values, at), registers.splat(values[other]));
    let pivot = values[other];
    for (mask, expected) in
        [(a.less(b), bit(&|x| x < pivot)), (a.at_least(b), bit(&|x| x >= pivot))]
    {
        assert_eq!((mask.bits(), mask.any()), (expected, expected != 0));
        assert_eq!(mask.all(), expected == bit(&|_| true));
        assert_eq!(mask.not().bits(), bit(&|_| true) & !expected);
    }
    let (less, at_least) = (a.less(b), b.at_least(a));
    assert_eq!(less.and(at_least).bits(), bit(&|x| x < pivot && pivot >= x));
    assert_eq!(
        less.or(at_least.not()).bits(),
        bit(&|x| x.partial_cmp(&pivot) != Some(std::cmp::Ordering::Equal))
    );
    for lane in 0..R::N {
        let found = a.lane(u32::try_from(lane).expect("few lanes"));
        assert_eq!(found.bits(), values[at + lane].bits());
    }
    let single: Vec<_> = (0..R::N).map(|k| results(values[at + k], pivot)).collect();
    let swapped: Vec<_> = (0..R::N).map(|k| results(pivot, values[at + k])).collect();
    for (found, expected) in [(results(a, b), single), (results(b, a), swapped)] {
        for (operation, found) in found.into_iter().enumerate() {
            let mut stored = [T::default(); MOST_LANES + 1];
            registers.store_at(found, &mut stored, 1);
            for lane in 0..R::N {
                let (found, expected) = (stored[1 + lane], expected[lane][operation]);
                let of = (values[at + lane], pivot);
                assert_eq!(found.bits(), expected.bits(), "operation {operation} of {of:?}");
            }
        }
    }
    // Small integers are exact, fused or not.
    let fused = registers.mul_add(a.splat(T::of(3.0)), a.splat(T::of(5.0)), a.splat(T::of(2.0)));
    assert_eq!(fused.at_least(a.splat(T::of(17.0))).bits(), bit(&|_| true));
    assert!(!a.splat(T::of(17.0)).less(fused).any());
}

/// Compresses the numbers from an index on with every mask.
fn compress_at<T: Bits, R: Registers<T>>(registers: R, values: &[T; MOST_LANES], at: usize) {
    let (vector, ids) = (registers.load(R::block_at(values, at)), R::indices_at(&IDS, at));
    for bits in 0..1_u32 << R::N {
        let beyond = if R::N < 16 { 1 << R::N } else { 0 };
        assert_eq!(registers.mask(bits | beyond).bits(), bits);
        let kept: Vec<usize> = (0..R::N).filter(|k| bits >> k & 1 == 1).map(|k| at + k).collect();
        let mut out = [0; MOST_LANES];
        assert_eq!(registers.compress_indices(bits, ids, &mut out, 0), kept.len());
        assert!(kept.iter().map(|&k| IDS[k]).eq(out[..kept.len()].iter().copied()));
        let mut out = [T::default(); MOST_LANES];
        registers.compress(bits, vector, &mut out, 0);
        let out = out[..kept.len()].iter().map(|value| value.bits());
        assert!(kept.iter().map(|&k| values[k].bits()).eq(out));
    }
}

/// Counts the lanes of the registers that the work receives.
struct CountLanes;

impl<T: Float> Work<T> for CountLanes {
    type Output = usize;

    fn run<R: Registers<T>>(self, registers: R) -> usize {
        assert_eq!(R::blocks(&[T::default(); 3 * MOST_LANES + 1]).len() * R::N, 3 * MOST_LANES);
        registers.apart(CountApart)
    }
}

/// Counts them in a separate function.
struct CountApart;

impl<T: Float> Work<T> for CountApart {
    type Output = usize;

    fn run<R: Registers<T>>(self, _: R) -> usize {
        R::N
    }
}

#[test]
fn every_level_of_this_machine_has_the_bits_of_single_numbers() {
    assert_eq!(SimdLevel::available().next(), Some(SimdLevel::PORTABLE));
    assert_eq!(SimdLevel::available().last(), Some(SimdLevel::best()));
    for level in SimdLevel::available() {
        level.run(Agrees::<f32>(std::marker::PhantomData));
        level.run(Agrees::<f64>(std::marker::PhantomData));
        level.run_narrow(Agrees::<f32>(std::marker::PhantomData));
        level.run_narrow(Agrees::<f64>(std::marker::PhantomData));
    }
}

#[test]
fn registers_of_f32_have_twice_the_lanes_and_narrow_ones_are_those_of_avx2() {
    for level in SimdLevel::available() {
        let lanes = (level.run::<f32, _>(CountLanes), level.run::<f64, _>(CountLanes));
        assert_eq!(lanes, if level.name() == "avx512" { (16, 8) } else { (8, 4) });
        let narrow =
            (level.run_narrow::<f32, _>(CountLanes), level.run_narrow::<f64, _>(CountLanes));
        assert_eq!(narrow, (8, 4));
    }
}

#[test]
fn minimum_and_maximum_take_the_second_where_no_number_is_the_lesser_or_greater() {
    for (a, b) in [(f64::NAN, 1.0), (1.0, f64::NAN), (0.0, -0.0), (-0.0, 0.0)] {
        assert_eq!(Bits::bits(Lanes::min(a, b)), Bits::bits(b));
        assert_eq!(Bits::bits(Lanes::max(a, b)), Bits::bits(b));
    }
}
