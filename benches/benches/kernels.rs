//! Value and gradient of every kernel over a slice of radii.
//!
//! The kernels come from the table, so each evaluation is one call through a pointer; `slice` is the same work by one
//! call for the whole slice, from squared distances. Beside them stand Lucy's kernel
//! known to the compiler, as a solver has it, and the rival: Lucy's formula written by hand, its constants taken out of
//! the loop.

use std::f64::consts::PI;
use std::hint::black_box;

use benches::CpuTime;
use criterion::{Criterion, Throughput};
use smoothing_kernels::{
    CubicSpline, Kernel, Lucy, QuarticSpline, QuinticSpline, TruncatedGaussian, WendlandC2,
    WendlandC4, WendlandC6, all,
};

const N_PAIRS: usize = 4096;
const SMOOTHING_LENGTH: f64 = 0.7;

/// Pairs along a diagonal, at radii from 0 to 1.1 smoothing lengths in mixed order: some lie beyond the edge of Lucy's
/// kernel, as in a neighbour list with a margin.
struct Pairs<const D: usize> {
    x_ij: Vec<[f64; D]>,
    r: Vec<f64>,
    r_squared: Vec<f64>,
}

impl<const D: usize> Pairs<D> {
    fn new() -> Self {
        // 1571 and 4096 have no common factor: every radius once.
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

fn dimension<const D: usize>(criterion: &mut Criterion<CpuTime>) {
    let pairs = Pairs::<D>::new();
    let (mut value, mut gradient) = (vec![0.0; N_PAIRS], vec![[0.0; D]; N_PAIRS]);
    check_rival(&pairs, &mut value, &mut gradient);

    let mut group = criterion.benchmark_group(format!("kernels/{D}d/value"));
    group.throughput(Throughput::Elements(N_PAIRS as u64));
    for (name, kernel) in all::<D>() {
        group.bench_function(name, |b| b.iter(|| values(&*kernel, &pairs, black_box(&mut value))));
    }
    group.bench_function("Lucy inlined", |b| {
        b.iter(|| values(&Lucy, &pairs, black_box(&mut value)));
    });
    group.bench_function("Lucy by hand (rival)", |b| {
        b.iter(|| lucy_values_by_hand(&pairs, black_box(&mut value)));
    });
    group.finish();

    slices(criterion, &pairs, &mut value);

    let mut group = criterion.benchmark_group(format!("kernels/{D}d/gradient"));
    group.throughput(Throughput::Elements(N_PAIRS as u64));
    for (name, kernel) in all::<D>() {
        group.bench_function(name, |b| {
            b.iter(|| gradients(&*kernel, &pairs, black_box(&mut gradient)));
        });
    }
    group.bench_function("Lucy inlined", |b| {
        b.iter(|| gradients(&Lucy, &pairs, black_box(&mut gradient)));
    });
    group.bench_function("Lucy by hand (rival)", |b| {
        b.iter(|| lucy_gradients_by_hand(&pairs, black_box(&mut gradient)));
    });
    group.finish();
}

/// From squared distances over the kernel's own support: the scalar calls, statically known, and the slice. Both read
/// `r²` and write one number per pair.
fn slices<const D: usize>(criterion: &mut Criterion<CpuTime>, pairs: &Pairs<D>, out: &mut [f64]) {
    slice_against_scalar(criterion, "Lucy", &Lucy, pairs, out);
    slice_against_scalar(criterion, "CubicSpline", &CubicSpline, pairs, out);
    slice_against_scalar(criterion, "QuarticSpline", &QuarticSpline, pairs, out);
    slice_against_scalar(criterion, "QuinticSpline", &QuinticSpline, pairs, out);
    slice_against_scalar(criterion, "WendlandC2", &WendlandC2, pairs, out);
    slice_against_scalar(criterion, "WendlandC4", &WendlandC4, pairs, out);
    slice_against_scalar(criterion, "WendlandC6", &WendlandC6, pairs, out);
    slice_against_scalar(criterion, "TruncatedGaussian", &TruncatedGaussian, pairs, out);
}

fn slice_against_scalar<const D: usize>(
    criterion: &mut Criterion<CpuTime>,
    name: &str,
    kernel: &impl Kernel<D>,
    pairs: &Pairs<D>,
    out: &mut [f64],
) {
    let r_squared = &pairs.r_squared;
    let mut group = criterion.benchmark_group(format!("kernels/{D}d/slice/{name}"));
    group.throughput(Throughput::Elements(N_PAIRS as u64));
    // As long as the pairs reach a tenth beyond the edge, whatever the support.
    let h = SMOOTHING_LENGTH / kernel.support();
    group.bench_function("values, scalar calls", |b| {
        b.iter(|| {
            let h = black_box(h);
            for (value, r_squared) in black_box(&mut *out).iter_mut().zip(r_squared) {
                *value = kernel.value(r_squared.sqrt(), h);
            }
        });
    });
    group.bench_function("values, slice", |b| {
        b.iter(|| kernel.values(r_squared, black_box(h), black_box(&mut *out)));
    });
    group.bench_function("gradient factors, scalar calls", |b| {
        b.iter(|| {
            let h = black_box(h);
            for (factor, r_squared) in black_box(&mut *out).iter_mut().zip(r_squared) {
                *factor = kernel.gradient_factor(r_squared.sqrt(), h);
            }
        });
    });
    group.bench_function("gradient factors, slice", |b| {
        b.iter(|| kernel.gradient_factors(r_squared, black_box(h), black_box(&mut *out)));
    });
    group.finish();
}

/// A rival that computes something else is none.
fn check_rival<const D: usize>(pairs: &Pairs<D>, value: &mut [f64], gradient: &mut [[f64; D]]) {
    let roundoff = 1e-13 * lucy_peak(D, SMOOTHING_LENGTH);
    let (mut value_by_hand, mut gradient_by_hand) = (value.to_vec(), gradient.to_vec());
    values(&Lucy, pairs, value);
    gradients(&Lucy, pairs, gradient);
    lucy_values_by_hand(pairs, &mut value_by_hand);
    lucy_gradients_by_hand(pairs, &mut gradient_by_hand);
    let gradients = gradient.iter().flatten().zip(gradient_by_hand.iter().flatten());
    for (ours, rival) in value.iter().zip(&value_by_hand).chain(gradients) {
        assert!((ours - rival).abs() < 100.0 * roundoff, "{ours} against {rival}");
    }
}

fn main() {
    let mut criterion = benches::criterion();
    dimension::<2>(&mut criterion);
    dimension::<3>(&mut criterion);
    criterion.final_summary();
}
