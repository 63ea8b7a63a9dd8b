//! Cholesky factorisation of several small symmetric matrices side by side, one in each lane.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::{Lanes, Mask, Registers, SimdLevel, Work};

use super::aligned::Aligned;
use super::monomials::{MOST_UNKNOWNS, Monomials};

/// Fits that are solved together: one register of 512 bits, two of 256.
pub(crate) const LANES: usize = 8;

/// A number of each fit, for each unknown.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(crate) struct OfUnknowns(pub(crate) [[f64; LANES]; MOST_UNKNOWNS]);

impl OfUnknowns {
    pub(crate) const ZERO: Self = Self([[0.0; LANES]; MOST_UNKNOWNS]);
}

/// A pivot of the equilibrated normal matrix below which its monomial counts as a combination of those before it: the
/// relative error of what is solved is about `f64::EPSILON / 1e-11`, 2e-5 of the largest term.
pub(crate) const SMALLEST_PIVOT: f64 = 1e-11;

/// How well the points determined the polynomial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Determined {
    /// Smallest pivot that was kept, in `(0, 1]`: the square of the sine of the angle between a monomial and those before
    /// it.
    pub(crate) smallest_pivot: f64,
    /// Omitted monomials: the points do not distinguish them from those of lower degree.
    pub(crate) n_left_out: usize,
}

/// Normal matrices as their factors, a fit in each lane.
#[derive(Debug, Clone)]
pub(crate) struct NormalEquations {
    /// Unknowns.
    n: usize,
    /// Lower triangle of the equilibrated factor by rows. Its diagonal holds the reciprocal of the pivot's root, or zero
    /// where the monomial is left out.
    factor: Aligned,
    /// By which each unknown is equilibrated.
    scale: OfUnknowns,
}

/// Where row `i` of a lower triangle starts.
const fn row(i: usize) -> usize {
    i * (i + 1) / 2
}

impl NormalEquations {
    pub(crate) fn new() -> Self {
        Self { n: 0, factor: Aligned::default(), scale: OfUnknowns::ZERO }
    }

    /// Factorises the equilibrated matrices of the given moments. A monomial that the points do not distinguish from those
    /// before it is left out: on a surface the fit omits the normal direction and keeps the rest.
    pub(crate) fn factorise(&mut self, tables: &Monomials, moments: &[f64]) -> [Determined; LANES] {
        let Self { n, factor, scale } = self;
        *n = tables.n_unknowns;
        factor.resize(LANES * row(*n));
        for (entry, &m) in factor.chunks_exact_mut(LANES).zip(&tables.product) {
            let m = LANES * usize::from(m);
            entry.copy_from_slice(&moments[m..m + LANES]);
        }
        let (mut smallest, mut left_out) = ([1.0; LANES], [0.0; LANES]);
        SimdLevel::best().run(Factorise {
            n: *n,
            a: factor,
            scale: scale.0.as_flattened_mut(),
            smallest: &mut smallest,
            left_out: &mut left_out,
        });
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 36")]
        std::array::from_fn(|lane| Determined {
            smallest_pivot: smallest[lane],
            n_left_out: left_out[lane] as usize,
        })
    }

    /// Solves for another right side of each fit by the factors at hand.
    pub(crate) fn substitute(&self, b: &mut OfUnknowns) {
        SimdLevel::best().run(Substitute {
            n: self.n,
            a: &self.factor,
            scale: self.scale.0.as_flattened(),
            b: b.0.as_flattened_mut(),
        });
    }
}

/// All slices hold [`LANES`] numbers for an entry.
struct Factorise<'a> {
    n: usize,
    a: &'a mut [f64],
    scale: &'a mut [f64],
    smallest: &'a mut [f64; LANES],
    left_out: &'a mut [f64; LANES],
}

impl Work<f64> for Factorise<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<f64>>(self, registers: R) {
        let Self { n, a, scale, smallest, left_out } = self;
        let (zero, one) = (registers.splat(0.0), registers.splat(1.0));
        let limit = registers.splat(SMALLEST_PIVOT);
        for s in (0..LANES).step_by(R::N) {
            let at = |entry: usize| LANES * entry + s;
            for i in 0..n {
                let diagonal = registers.load_at(a, at(row(i) + i));
                let root = one / diagonal.sqrt();
                let scaled = R::Vector::select(zero.less(diagonal), root, zero);
                registers.store_at(scaled, scale, at(i));
            }
            let (mut least, mut omitted) = (one, zero);
            // Row by row: row i of the factor needs the rows before it only.
            for i in 0..n {
                let scale_i = registers.load_at(scale, at(i));
                let mut pivot = R::Vector::select(zero.less(scale_i), one, zero);
                for j in 0..i {
                    let mut entry = registers.load_at(a, at(row(i) + j))
                        * scale_i
                        * registers.load_at(scale, at(j));
                    for k in 0..j {
                        let (a_ik, a_jk) = (at(row(i) + k), at(row(j) + k));
                        entry = entry - registers.load_at(a, a_ik) * registers.load_at(a, a_jk);
                    }
                    entry = entry * registers.load_at(a, at(row(j) + j));
                    pivot = pivot - entry * entry;
                    registers.store_at(entry, a, at(row(i) + j));
                }
                let is_kept = limit.less(pivot);
                let root = R::Vector::select(is_kept, one / pivot.sqrt(), zero);
                registers.store_at(root, a, at(row(i) + i));
                least = R::Vector::select(is_kept.and(pivot.less(least)), pivot, least);
                omitted = omitted + R::Vector::select(is_kept, zero, one);
            }
            registers.store_at(least, smallest, s);
            registers.store_at(omitted, left_out, s);
        }
    }
}

/// All slices hold [`LANES`] numbers for an entry.
struct Substitute<'a> {
    n: usize,
    a: &'a [f64],
    scale: &'a [f64],
    b: &'a mut [f64],
}

impl Work<f64> for Substitute<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<f64>>(self, registers: R) {
        let Self { n, a, scale, b } = self;
        for s in (0..LANES).step_by(R::N) {
            let at = |entry: usize| LANES * entry + s;
            for i in 0..n {
                let mut value = registers.load_at(b, at(i)) * registers.load_at(scale, at(i));
                for j in 0..i {
                    let a_ij = registers.load_at(a, at(row(i) + j));
                    value = value - a_ij * registers.load_at(b, at(j));
                }
                value = value * registers.load_at(a, at(row(i) + i));
                registers.store_at(value, b, at(i));
            }
            for i in (0..n).rev() {
                let mut value = registers.load_at(b, at(i));
                for k in i + 1..n {
                    let a_ki = registers.load_at(a, at(row(k) + i));
                    value = value - a_ki * registers.load_at(b, at(k));
                }
                value = value * registers.load_at(a, at(row(i) + i));
                registers.store_at(value, b, at(i));
            }
            for i in 0..n {
                let value = registers.load_at(b, at(i)) * registers.load_at(scale, at(i));
                registers.store_at(value, b, at(i));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_have_the_same_bits_at_every_level_and_a_dependent_unknown_is_left_out() {
        // A matrix V^T V of rank n in even lanes; in odd ones the last column of V is the sum of the others.
        const N: usize = 5;
        let v = |lane: usize, k: usize, i: usize| {
            let of = |i: usize| (0.37 * ((1 + lane + 3 * k) * (2 + i)) as f64).sin();
            if i == N - 1 && lane % 2 == 1 { (0..N - 1).map(of).sum() } else { of(i) }
        };
        let mut a = Vec::new();
        for i in 0..N {
            for j in 0..=i {
                let of_lane = |lane| (0..9).map(|k| v(lane, k, i) * v(lane, k, j)).sum::<f64>();
                a.extend((0..LANES).map(of_lane));
            }
        }
        let at = |level: SimdLevel| {
            let (mut a, mut scale) = (a.clone(), vec![0.0; LANES * N]);
            let (mut smallest, mut left_out) = ([1.0; LANES], [0.0; LANES]);
            level.run(Factorise {
                n: N,
                a: &mut a,
                scale: &mut scale,
                smallest: &mut smallest,
                left_out: &mut left_out,
            });
            let mut b = vec![1.0; LANES * N];
            level.run(Substitute { n: N, a: &a, scale: &scale, b: &mut b });
            (a, b, smallest, left_out)
        };
        let expected = at(SimdLevel::PORTABLE);
        for level in SimdLevel::available() {
            assert_eq!(at(level), expected, "{}", level.name());
        }
        let (_, b, smallest, left_out) = expected;
        for lane in 0..LANES {
            assert_eq!(left_out[lane] > 0.5, lane % 2 == 1, "lane {lane}");
            assert!(smallest[lane] > SMALLEST_PIVOT);
            // The residual of the first equations is roundoff over the smallest pivot.
            let entry = |i: usize, j: usize| a[LANES * (row(i.max(j)) + i.min(j)) + lane];
            for i in 0..N - lane % 2 {
                let sum: f64 = (0..N).map(|j| entry(i, j) * b[LANES * j + lane]).sum();
                assert!((sum - 1.0).abs() < 1e-10, "lane {lane}, equation {i}: {sum}");
            }
        }
    }
}
