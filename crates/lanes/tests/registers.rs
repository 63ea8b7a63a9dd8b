//! Registers of every level against scalar code.

use lanes::{MOST_LANES, Registers, SimdLevel, Work};

const VALUES: [f32; MOST_LANES] = [
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
const IDS: [u32; MOST_LANES] =
    [0, 1, u32::MAX, 1 << 31, 7, 7, (1 << 31) - 1, 3, 9, 4, 8, 2, 5, 6, 10, 11];

struct Agrees;

impl Work for Agrees {
    type Output = ();

    fn run<R: Registers<f32>>(self, registers: R) {
        assert!(R::N <= MOST_LANES && MOST_LANES.is_multiple_of(R::N));
        for at in (0..MOST_LANES).step_by(R::N) {
            let (values, ids) = (registers.load(R::block_at(&VALUES, at)), R::indices_at(&IDS, at));
            let bit = |test: &dyn Fn(usize) -> bool| {
                (0..R::N).fold(0, |mask, k| mask | u32::from(test(at + k)) << k)
            };
            for pivot in VALUES {
                let a = registers.splat(pivot);
                assert_eq!(registers.less(values, a), bit(&|k| VALUES[k] < pivot));
                let sum = registers.sub(registers.add(registers.mul(values, values), a), values);
                let expected = |k: usize| VALUES[k] * VALUES[k] + pivot - VALUES[k] < 1.5;
                assert_eq!(registers.less(sum, registers.splat(1.5)), bit(&expected));
                // Small whole numbers are exact, fused or not.
                let fused = registers.mul_add(registers.splat(3.0), registers.splat(5.0), values);
                let expected = |k: usize| 15.0 + VALUES[k] < 17.0;
                assert_eq!(registers.less(fused, registers.splat(17.0)), bit(&expected));
                if pivot.is_finite() {
                    let larger = registers.max(registers.splat(pivot), registers.splat(0.75));
                    let expected = if pivot.max(0.75) < 1.0 { bit(&|_| true) } else { 0 };
                    assert_eq!(registers.less(larger, registers.splat(1.0)), expected);
                }
            }
            for mask in 0..1_u32 << R::N {
                let mut out = [0; MOST_LANES];
                let count = registers.compress_indices(mask, ids, &mut out, 0);
                assert_eq!(count, mask.count_ones() as usize);
                let kept = (0..R::N).filter(|k| mask >> k & 1 == 1).map(|k| IDS[at + k]);
                assert!(kept.eq(out[..mask.count_ones() as usize].iter().copied()));
                let mut out = [0.0; MOST_LANES];
                registers.compress(mask, values, &mut out, 0);
                let kept = (0..R::N).filter(|k| mask >> k & 1 == 1).map(|k| VALUES[at + k]);
                let out = out[..mask.count_ones() as usize].iter();
                assert!(kept.map(f32::to_bits).eq(out.map(|value| value.to_bits())));
            }
        }
    }
}

#[test]
fn every_level_of_this_machine_does_as_scalar_code_does() {
    assert_eq!(SimdLevel::available().next(), Some(SimdLevel::PORTABLE));
    assert_eq!(SimdLevel::available().last(), Some(SimdLevel::best()));
    SimdLevel::available().for_each(|level| level.run(Agrees));
}
