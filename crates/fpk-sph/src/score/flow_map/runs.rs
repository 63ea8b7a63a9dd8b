//! Runs: consecutive points of a lattice whose members are consecutive too. One set of weights serves a run, and its values
//! are loaded register by register.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::ops::Range;

use simd_lanes::{MOST_LANES, Registers};

use super::arrangement::Turn;
use super::stencils::{Stencil, Stencils};

/// Consecutive points with one pattern, whose members advance by one from point to point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) first: usize,
    pub(crate) len: usize,
}

/// The longest runs that make up the given points, single points included.
pub(crate) fn runs_of<const D: usize>(stencils: &Stencils<D>, points: Range<usize>) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for i in points {
        match runs.last_mut() {
            Some(run) if stencils.advances(i - 1) => run.len += 1,
            _ => runs.push(Run { first: i, len: 1 }),
        }
    }
    runs
}

/// `sum_j gradient_jl f_j` of the points of a run, one slice for each axis `l`.
///
/// `f` and the slices hold `C` numbers for each point, one point after the other.
#[inline(always)]
pub(crate) fn gradient<R: Registers<f64>, const D: usize, const C: usize>(
    registers: R,
    stencil: Stencil<'_, D>,
    f: &[f64],
    out: &mut [&mut [f64]; D],
) {
    let total = out[0].len();
    let mut at = 0;
    while at < total {
        let (from, length) = block(total, at, R::N);
        match length {
            4 => {
                let sums = gradient_at::<R, D, C, 4>(registers, stencil, f, from);
                store_turned(registers, stencil.turn, sums, out, from);
            }
            2 => {
                let sums = gradient_at::<R, D, C, 2>(registers, stencil, f, from);
                store_turned(registers, stencil.turn, sums, out, from);
            }
            _ => {
                let sums = gradient_at::<R, D, C, 1>(registers, stencil, f, from);
                store_turned(registers, stencil.turn, sums, out, from);
            }
        }
        at = from + length * R::N;
    }
}

/// How a run of `total` numbers is taken from `at` on: where the next registers start, and how many they are, 4, 2 or 1. The
/// last ones end with the run: they repeat numbers of those before.
#[inline(always)]
fn block(total: usize, at: usize, lanes: usize) -> (usize, usize) {
    let left = total - at;
    let length = match left {
        _ if left > 2 * lanes && total >= 4 * lanes => 4,
        _ if left > lanes && total >= 2 * lanes => 2,
        _ => 1,
    };
    (at.min(total.saturating_sub(length * lanes)), length)
}

/// `sum_j w_j f_j` of the points of a run, with the pattern's weights of a mean or of the polynomial's value.
///
/// `f` and `out` hold `C` numbers for each point, one point after the other.
#[inline(always)]
pub(crate) fn mean<R: Registers<f64>, const D: usize, const C: usize>(
    registers: R,
    stencil: Stencil<'_, D>,
    weights: &[f64],
    f: &[f64],
    out: &mut [f64],
) {
    let total = out.len();
    let mut at = 0;
    while at < total {
        let (from, length) = block(total, at, R::N);
        match length {
            4 => {
                store(
                    registers,
                    mean_at::<R, D, C, 4>(registers, stencil, weights, f, from),
                    out,
                    from,
                );
            }
            2 => {
                store(
                    registers,
                    mean_at::<R, D, C, 2>(registers, stencil, weights, f, from),
                    out,
                    from,
                );
            }
            _ => {
                store(
                    registers,
                    mean_at::<R, D, C, 1>(registers, stencil, weights, f, from),
                    out,
                    from,
                );
            }
        }
        at = from + length * R::N;
    }
}

/// The sums of [`gradient`] in `K` registers, `at` numbers after the start of the run.
#[inline(always)]
fn gradient_at<R: Registers<f64>, const D: usize, const C: usize, const K: usize>(
    registers: R,
    Stencil { members, weights, .. }: Stencil<'_, D>,
    f: &[f64],
    at: usize,
) -> [[R::Vector; K]; D] {
    let mut sums = [[registers.splat(0.0); K]; D];
    if weights.is_symmetric {
        let half = members.len() / 2;
        let pairs = members[half + 1..].iter().zip(members[..half].iter().rev());
        for ((&ahead, &behind), weight) in pairs.zip(&weights.gradient[half + 1..]) {
            let mut difference: [R::Vector; K] = load(registers, f, C * ahead as usize + at);
            let behind: [R::Vector; K] = load(registers, f, C * behind as usize + at);
            for k in 0..K {
                difference[k] = difference[k] - behind[k];
            }
            add(registers, weight, difference, &mut sums);
        }
    } else {
        for (&j, weight) in members.iter().zip(&weights.gradient) {
            add(registers, weight, load(registers, f, C * j as usize + at), &mut sums);
        }
    }
    sums
}

/// The sums of [`mean`] in `K` registers, `at` numbers after the start of the run.
#[inline(always)]
fn mean_at<R: Registers<f64>, const D: usize, const C: usize, const K: usize>(
    registers: R,
    stencil: Stencil<'_, D>,
    weights: &[f64],
    f: &[f64],
    at: usize,
) -> [R::Vector; K] {
    let members = stencil.members;
    let mut sums = [[registers.splat(0.0); K]; 1];
    if stencil.weights.is_symmetric {
        let half = members.len() / 2;
        let own = load(registers, f, C * members[half] as usize + at);
        add(registers, &[weights[half]], own, &mut sums);
        let pairs = members[half + 1..].iter().zip(members[..half].iter().rev());
        for ((&ahead, &behind), &weight) in pairs.zip(&weights[half + 1..]) {
            let mut both: [R::Vector; K] = load(registers, f, C * ahead as usize + at);
            let behind: [R::Vector; K] = load(registers, f, C * behind as usize + at);
            for k in 0..K {
                both[k] = both[k] + behind[k];
            }
            add(registers, &[weight], both, &mut sums);
        }
    } else {
        for (&j, &weight) in members.iter().zip(weights) {
            add(registers, &[weight], load(registers, f, C * j as usize + at), &mut sums);
        }
    }
    sums[0]
}

/// Adds `w_l x` to each sum `l`.
#[inline(always)]
fn add<R: Registers<f64>, const D: usize, const K: usize>(
    registers: R,
    w: &[f64; D],
    x: [R::Vector; K],
    sums: &mut [[R::Vector; K]; D],
) {
    for l in 0..D {
        let weight = registers.splat(w[l]);
        for k in 0..K {
            sums[l][k] = sums[l][k] + weight * x[k];
        }
    }
}

/// The numbers from an index on in `K` registers, with zeros beyond the last.
#[inline(always)]
fn load<R: Registers<f64>, const K: usize>(registers: R, f: &[f64], at: usize) -> [R::Vector; K] {
    let mut vectors = [registers.splat(0.0); K];
    if let Some(here) = f.get(at..at + K * R::N) {
        for k in 0..K {
            vectors[k] = registers.load_at(here, k * R::N);
        }
    } else {
        for k in 0..K {
            vectors[k] = registers.load_at(&padded(f, at + k * R::N), 0);
        }
    }
    vectors
}

/// The numbers of a slice from an index on, and zeros.
#[cold]
fn padded(f: &[f64], at: usize) -> [f64; MOST_LANES] {
    let mut lanes = [0.0; MOST_LANES];
    let rest = &f[at.min(f.len())..f.len().min(at + MOST_LANES)];
    lanes[..rest.len()].copy_from_slice(rest);
    lanes
}

/// Stores sums along the axes of a class in the slices of the axes of the lattice.
#[inline(always)]
fn store_turned<R: Registers<f64>, const D: usize, const K: usize>(
    registers: R,
    turn: &Turn<D>,
    sums: [[R::Vector; K]; D],
    out: &mut [&mut [f64]; D],
    at: usize,
) {
    for l in 0..D {
        let (sign, mut turned) = (registers.splat(turn.sign[l]), sums[l]);
        for k in 0..K {
            turned[k] = sign * turned[k];
        }
        store(registers, turned, out[turn.axis[l]], at);
    }
}

/// Stores registers in a run of numbers, or as many as there are where a register is longer than the run.
#[inline(always)]
fn store<R: Registers<f64>, const K: usize>(
    registers: R,
    vectors: [R::Vector; K],
    out: &mut [f64],
    at: usize,
) {
    if out.len() >= K * R::N {
        let here = &mut out[at..at + K * R::N];
        for k in 0..K {
            registers.store_at(vectors[k], here, k * R::N);
        }
    } else {
        let mut lanes = [0.0; MOST_LANES];
        registers.store_at(vectors[0], &mut lanes, 0);
        out.copy_from_slice(&lanes[..out.len()]);
    }
}
