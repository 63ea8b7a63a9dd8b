//! Value, five first and five unmixed second derivatives of two responses, compared with the value alone.
//!
//! Each response is evaluated at one state after the other, as a solver does from particle to particle, with the same
//! inputs. Results are hidden from the compiler, so that nothing is omitted and states are not combined. All run in
//! one dispatch to the widest registers. The value alone is the faster of two implementations. Rivals: the same
//! formula over num-dual's `Dual2_64`, once per input; 11-point central differences.

use std::hint::black_box;

use benches::CpuTime;
use criterion::measurement::Measurement;
use criterion::{BenchmarkGroup, Criterion, Throughput};
use num_dual::Dual2_64;
use perturbation_moments::{Jet, Response, Scalar};
use responses::{JohnsonCook, MieGruneisen, MieGruneisenState};
use simd_lanes::dispatch;

#[path = "../../crates/perturbation-moments/tests/responses/mod.rs"]
mod responses;

const N_STATES: usize = 1024;

type Derivatives = (f64, [f64; 5], [f64; 5]);
#[inline(always)]
#[allow(clippy::inline_always, reason = "compiled for the registers of the dispatched closure")]
fn by_num_dual(response: &impl Response<5>, x: &[f64; 5]) -> Derivatives {
    // Seeded here, visible to the compiler: it computes each exponential once for all five, and omits zeros.
    let mut out = (0.0, [0.0; 5], [0.0; 5]);
    for k in 0..5 {
        let mut seeded = x.map(Dual2_64::constant);
        seeded[k] = seeded[k].derivative();
        let y = response.value(&seeded);
        (out.0, out.1[k], out.2[k]) = (y.re, y.v1, y.v2);
    }
    out
}

#[inline(always)]
#[allow(clippy::inline_always, reason = "compiled for the registers of the dispatched closure")]
fn by_differences(response: &impl Response<5>, x: &[f64; 5]) -> Derivatives {
    let value: f64 = response.value(x);
    let mut out = (value, [0.0; 5], [0.0; 5]);
    for k in 0..5 {
        let h = 1e-3 * x[k];
        let (mut above, mut below) = (*x, *x);
        above[k] += h;
        below[k] -= h;
        let (above, below) = (response.value(&above), response.value(&below));
        out.1[k] = (above - below) / (2.0 * h);
        out.2[k] = (above - 2.0 * value + below) / (h * h);
    }
    out
}

/// Measures a function of each state, compiled for the widest registers.
fn each_state<S: Copy, X, T>(
    group: &mut BenchmarkGroup<'_, impl Measurement>,
    name: &str,
    (states, x): (&[S], &X),
    f: impl Fn(S, &X) -> T,
) {
    group.bench_function(name, |b| {
        b.iter(|| {
            dispatch(
                #[inline(always)]
                || {
                    let x = black_box(x);
                    for &state in states {
                        let y = f(state, x);
                        black_box(&y);
                    }
                },
            );
        });
    });
}

/// All contenders for one response; `closed` is its closed form.
fn compare<S: Copy, R: Response<5>>(
    group: &mut BenchmarkGroup<'_, impl Measurement>,
    states: &[S],
    x: &[f64; 5],
    response: impl Fn(S) -> R + Copy,
    closed: impl Fn(&R, &[f64; 5]) -> Derivatives + Copy,
) {
    let jets: [Jet; 5] = std::array::from_fn(|k| Jet::variable(x[k], k));
    for &state in states.iter().step_by(97) {
        let at = response(state);
        let differences = by_differences(&at, x);
        let rivals = [(closed(&at, x), 1e-12), (by_num_dual(&at, x), 1e-12), (differences, 1e-3)];
        check_rivals(&at.value(&jets), x, &rivals);
    }
    group.throughput(Throughput::Elements(states.len() as u64));
    each_state(
        group,
        "plain value",
        (states, x),
        #[inline(always)]
        |s, x| response(s).value(x),
    );
    each_state(
        group,
        "closed form",
        (states, x),
        #[inline(always)]
        |s, x| closed(&response(s), x),
    );
    each_state(
        group,
        "jet",
        (states, &jets),
        #[inline(always)]
        |s, x| response(s).value(x),
    );
    each_state(
        group,
        "num-dual, 5 x Dual2_64 (rival)",
        (states, x),
        #[inline(always)]
        |s, x| by_num_dual(&response(s), x),
    );
    each_state(
        group,
        "central differences, 11 points (rival)",
        (states, x),
        #[inline(always)]
        |s, x| by_differences(&response(s), x),
    );
}

/// Checks that the rivals compute the same derivatives.
fn check_rivals(ours: &Jet, x: &[f64; 5], rivals: &[(Derivatives, f64)]) {
    for (rival, tolerance) in rivals {
        let limit = tolerance * ours.value.abs();
        assert!((rival.0 - ours.value).abs() < limit, "{rival:?} against {ours:?}");
        for k in 0..5 {
            let first = x[k] * (ours.first[k] - rival.1[k]);
            let second = x[k] * x[k] * (ours.second[k] - rival.2[k]);
            assert!(first.abs() < limit && second.abs() < limit, "{rival:?} against {ours:?}");
        }
    }
}

/// A number in the interval for every state, in mixed order.
fn between(from: f64, to: f64, k: usize, stride: usize) -> f64 {
    from + (to - from) * ((stride * k) % N_STATES) as f64 / N_STATES as f64
}

/// Strain, relative rate, homologous temperature: all variants but the powers take their logarithms.
fn johnson_cook(criterion: &mut Criterion<CpuTime>) {
    let state =
        |k| [between(0.01, 1.0, k, 331), between(1e2, 1e5, k, 577), between(0.05, 0.9, k, 787)];
    let states: Vec<[f64; 3]> = (0..N_STATES).map(state).collect();
    let x = [792.0, 510.0, 0.014, 0.26, 1.03];
    let mut group = criterion.benchmark_group("moments/Johnson-Cook");
    compare(
        &mut group,
        &states,
        &x,
        #[inline(always)]
        |s: [f64; 3]| JohnsonCook::from_logarithms([s[0].ln(), s[1].ln(), s[2].ln()]),
        JohnsonCook::diagonal,
    );
    each_state(
        &mut group,
        "plain value by powf",
        (&states, &x),
        #[inline(always)]
        |[strain, rate, temperature], &[a, b, c, n, m]| {
            (a + b * strain.powf(n)) * (1.0 + c * rate.ln()) * (1.0 - temperature.powf(m))
        },
    );
    group.finish();
}

fn mie_gruneisen(criterion: &mut Criterion<CpuTime>) {
    let state = |k| MieGruneisenState {
        bulk_modulus: 1.634_572_086_3e11,
        compression: between(0.05, 0.5, k, 331),
        energy: between(2e8, 2e10, k, 577),
    };
    let states: Vec<MieGruneisenState> = (0..N_STATES).map(state).collect();
    let x = [1.49, 0.1, 0.05, 2.17, 0.46];
    let mut group = criterion.benchmark_group("moments/Mie-Gruneisen");
    compare(&mut group, &states, &x, MieGruneisen::new, MieGruneisen::diagonal);
    group.finish();
}

fn main() {
    let mut criterion = benches::criterion();
    johnson_cook(&mut criterion);
    mie_gruneisen(&mut criterion);
    criterion.final_summary();
}
