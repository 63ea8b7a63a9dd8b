//! Value and gradient of every kernel over a slice of radii.
//!
//! All kernels come from the table, so each evaluation is one virtual call. The first ratio compares Lucy's kernel,
//! known to the compiler as in a solver, with its hand-written formula, constants hoisted out of the loop. The second
//! compares one call for a whole slice, from squared distances, with a scalar call for each number.

#![expect(
    clippy::unwrap_used,
    reason = "slices of different lengths are a mistake of the benchmark"
)]

use std::f64::consts::PI;
use std::hint::black_box;

use benches::CpuTime;
use benches::ratios::{Ratios, Work};
use criterion::{Criterion, Throughput};
use smoothing_kernels::{
    CubicSpline, Kernel, Lucy, QuarticSpline, QuinticSpline, TruncatedGaussian, WendlandC2,
    WendlandC4, WendlandC6, all,
};

const N_PAIRS: usize = 4096;
const SMOOTHING_LENGTH: f64 = 0.7;

/// Pairs along a diagonal, at radii from 0 to 1.1 smoothing lengths in mixed order.
///
/// Some are beyond the support of Lucy's kernel, as in a neighbour list with a skin.
struct Pairs<const D: usize> {
    x_ij: Vec<[f64; D]>,
    r: Vec<f64>,
    r_squared: Vec<f64>,
}

impl<const D: usize> Pairs<D> {
    fn new() -> Self {
        // 1571 and 4096 have no common factor, so every radius occurs once.
        let r: Vec<f64> = (0..N_PAIRS)
            .map(|k| 1.1 * SMOOTHING_LENGTH * ((1571 * k) % N_PAIRS) as f64 / N_PAIRS as f64)
            .collect();
        let x_ij = r.iter().map(|r| [r / (D as f64).sqrt(); D]).collect();
        let r_squared = r.iter().map(|r| r * r).collect();
        Self { x_ij, r, r_squared }
    }
}

fn values<const D: usize>(kernel: &(impl Kernel<D> + ?Sized), pairs: &Pairs<D>, out: &mut [f64]) {
    let h = black_box(SMOOTHING_LENGTH);
    for (value, &r) in out.iter_mut().zip(&pairs.r) {
        *value = kernel.value(r, h);
    }
}

fn gradients<const D: usize>(
    kernel: &(impl Kernel<D> + ?Sized),
    pairs: &Pairs<D>,
    out: &mut [[f64; D]],
) {
    let h = black_box(SMOOTHING_LENGTH);
    for ((gradient, x_ij), &r) in out.iter_mut().zip(&pairs.x_ij).zip(&pairs.r) {
        *gradient = kernel.gradient(x_ij, r, h);
    }
}

/// Lucy's normalisation over `h^D`.
fn lucy_peak(dimension: usize, h: f64) -> f64 {
    if dimension == 2 { 5.0 / (PI * h * h) } else { 105.0 / (16.0 * PI * h * h * h) }
}

fn lucy_values_by_hand<const D: usize>(pairs: &Pairs<D>, out: &mut [f64]) {
    let h = black_box(SMOOTHING_LENGTH);
    let peak = lucy_peak(D, h);
    for (value, r) in out.iter_mut().zip(&pairs.r) {
        let q = r / h;
        let below = (1.0 - q).max(0.0);
        *value = peak * (1.0 + 3.0 * q) * below * below * below;
    }
}

fn lucy_gradients_by_hand<const D: usize>(pairs: &Pairs<D>, out: &mut [[f64; D]]) {
    let h = black_box(SMOOTHING_LENGTH);
    let factor = -12.0 * lucy_peak(D, h) / (h * h);
    for ((gradient, x_ij), r) in out.iter_mut().zip(&pairs.x_ij).zip(&pairs.r) {
        let below = (1.0 - r / h).max(0.0);
        *gradient = x_ij.map(|component| factor * below * below * component);
    }
}

fn dimension<const D: usize>(criterion: &mut Criterion<CpuTime>, ratios: &mut Ratios) {
    let pairs = Pairs::<D>::new();
    check_rival(&pairs);
    table(criterion, &pairs);

    let [mut ours, mut by_hand] = [(); 2].map(|()| vec![0.0; N_PAIRS]);
    ratios.measure(
        Work::new(format!("kernels/{D}-D value"), N_PAIRS, "Lucy inlined", || {
            values(&Lucy, &pairs, black_box(&mut ours));
        })
        .rival("Lucy by hand", || lucy_values_by_hand(&pairs, black_box(&mut by_hand)))
        .in_criterion(criterion),
    );
    let [mut ours, mut by_hand] = [(); 2].map(|()| vec![[0.0; D]; N_PAIRS]);
    ratios.measure(
        Work::new(format!("kernels/{D}-D gradient"), N_PAIRS, "Lucy inlined", || {
            gradients(&Lucy, &pairs, black_box(&mut ours));
        })
        .rival("Lucy by hand", || lucy_gradients_by_hand(&pairs, black_box(&mut by_hand)))
        .in_criterion(criterion),
    );
    slices(ratios, &pairs);
}

/// Every kernel through a pointer, compared with each other, because most have no rival.
fn table<const D: usize>(criterion: &mut Criterion<CpuTime>, pairs: &Pairs<D>) {
    let (mut value, mut gradient) = (vec![0.0; N_PAIRS], vec![[0.0; D]; N_PAIRS]);
    let mut group = criterion.benchmark_group(format!("kernels/{D}-D value by pointer"));
    group.throughput(Throughput::Elements(N_PAIRS as u64));
    for (name, kernel) in all::<D>() {
        group.bench_function(name, |b| b.iter(|| values(&*kernel, pairs, black_box(&mut value))));
    }
    group.finish();
    let mut group = criterion.benchmark_group(format!("kernels/{D}-D gradient by pointer"));
    group.throughput(Throughput::Elements(N_PAIRS as u64));
    for (name, kernel) in all::<D>() {
        group.bench_function(name, |b| {
            b.iter(|| gradients(&*kernel, pairs, black_box(&mut gradient)));
        });
    }
    group.finish();
}

/// Scalar calls, statically dispatched, and slice calls from squared distances over the kernel's own support.
///
/// Both read `r²` and write one number per pair.
fn slices<const D: usize>(ratios: &mut Ratios, pairs: &Pairs<D>) {
    let r_squared = &pairs.r_squared;
    slice_against_calls::<D>(ratios, "Lucy", &Lucy, r_squared);
    slice_against_calls::<D>(ratios, "CubicSpline", &CubicSpline, r_squared);
    slice_against_calls::<D>(ratios, "QuarticSpline", &QuarticSpline, r_squared);
    slice_against_calls::<D>(ratios, "QuinticSpline", &QuinticSpline, r_squared);
    slice_against_calls::<D>(ratios, "WendlandC2", &WendlandC2, r_squared);
    slice_against_calls::<D>(ratios, "WendlandC4", &WendlandC4, r_squared);
    slice_against_calls::<D>(ratios, "WendlandC6", &WendlandC6, r_squared);
    slice_against_calls::<D>(ratios, "TruncatedGaussian", &TruncatedGaussian, r_squared);
}

fn slice_against_calls<const D: usize>(
    ratios: &mut Ratios,
    name: &str,
    kernel: &impl Kernel<D>,
    r_squared: &[f64],
) {
    // Pairs extend a tenth beyond the edge, for any support.
    let h = SMOOTHING_LENGTH / kernel.support();
    against_calls(
        ratios,
        (format!("kernels/{D}-D values, {name}"), r_squared),
        |out| kernel.values(r_squared, black_box(h), out).unwrap(),
        |r| kernel.value(r, h),
    );
    against_calls(
        ratios,
        (format!("kernels/{D}-D gradient factors, {name}"), r_squared),
        |out| kernel.gradient_factors(r_squared, black_box(h), out).unwrap(),
        |r| kernel.gradient_factor(r, h),
    );
}

/// Checks that a slice call has the values of scalar calls within roundoff, and measures both.
fn against_calls(
    ratios: &mut Ratios,
    (name, r_squared): (String, &[f64]),
    slice: impl Fn(&mut [f64]),
    call: impl Fn(f64) -> f64,
) {
    let each = |out: &mut [f64]| {
        for (value, r_squared) in out.iter_mut().zip(r_squared) {
            *value = call(r_squared.sqrt());
        }
    };
    let [mut sliced, mut called] = [(); 2].map(|()| vec![0.0; N_PAIRS]);
    slice(&mut sliced);
    each(&mut called);
    assert_close(&sliced, &called);
    let work = Work::new(name, N_PAIRS, "slice", || slice(black_box(&mut sliced)));
    ratios.measure(work.rival("scalar calls", || each(black_box(&mut called))));
}

/// Checks that a rival computes the same values.
fn check_rival<const D: usize>(pairs: &Pairs<D>) {
    let roundoff = 1e-13 * lucy_peak(D, SMOOTHING_LENGTH);
    let [mut value, mut value_by_hand] = [(); 2].map(|()| vec![0.0; N_PAIRS]);
    let [mut gradient, mut gradient_by_hand] = [(); 2].map(|()| vec![[0.0; D]; N_PAIRS]);
    values(&Lucy, pairs, &mut value);
    gradients(&Lucy, pairs, &mut gradient);
    lucy_values_by_hand(pairs, &mut value_by_hand);
    lucy_gradients_by_hand(pairs, &mut gradient_by_hand);
    let gradients = gradient.iter().flatten().zip(gradient_by_hand.iter().flatten());
    for (ours, rival) in value.iter().zip(&value_by_hand).chain(gradients) {
        assert!((ours - rival).abs() < 100.0 * roundoff, "{ours} against {rival}");
    }
}

/// A difference within roundoff, about a hundred times the machine epsilon.
fn assert_close(ours: &[f64], rival: &[f64]) {
    let largest = rival.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    for (ours, rival) in ours.iter().zip(rival) {
        assert!((ours - rival).abs() < 1e-13 * largest, "{ours} against {rival}");
    }
}

fn main() {
    let mut criterion = benches::criterion();
    let mut ratios = Ratios::from_args("kernels");
    dimension::<2>(&mut criterion, &mut ratios);
    dimension::<3>(&mut criterion, &mut ratios);
    criterion.final_summary();
    ratios.print();
}
