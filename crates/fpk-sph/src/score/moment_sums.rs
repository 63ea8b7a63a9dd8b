//! Moments of weighted points and their products with values, summed in registers.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::{Registers, SimdLevel, Work};

use super::aligned::Aligned;
use super::fit_points::Points;
use super::monomials::Monomials;
use super::normal_equations::LANES;

/// Points that are taken together: the monomials of a quadratic in three variables fill a third of the first-level cache,
/// those of a cubic all of it.
const TOGETHER: usize = 8 * LANES;

/// Sums of one fit over its points: [`LANES`] numbers for an entry, which are added last.
#[derive(Debug, Clone, Default)]
pub(super) struct Sums {
    pub(super) moments: Aligned,
    pub(super) right_sides: Aligned,
    /// `w_j u_j^a` of the points that are taken together, [`TOGETHER`] numbers for each monomial that is the parent of another.
    monomials: Aligned,
}

impl Sums {
    /// Computes the moments of the points and the sums of monomials times values; afterwards the first numbers of each buffer
    /// are the sums.
    pub(super) fn compute(&mut self, tables: &'static Monomials, points: &Points) {
        SimdLevel::best().run(Sum { tables, sums: self, points });
    }
}

/// [`Sums::compute`].
struct Sum<'a> {
    tables: &'static Monomials,
    sums: &'a mut Sums,
    points: &'a Points,
}

impl Work<f64> for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<f64>>(self, registers: R) {
        let Self { tables, sums: Sums { moments, right_sides, monomials }, points } = self;
        let &Monomials { n_unknowns, n_parents, n_moments, .. } = tables;
        moments.resize(LANES * n_moments.next_multiple_of(4));
        right_sides.resize(LANES * n_unknowns.next_multiple_of(4));
        moments[LANES * n_moments..].fill(0.0);
        right_sides[LANES * n_unknowns..].fill(0.0);
        monomials.resize(TOGETHER * n_parents.max(1));
        for first in (0..points.weights.len()).step_by(TOGETHER) {
            let here = first..points.weights.len().min(first + TOGETHER);
            let mut part = Part {
                registers,
                is_first: first == 0,
                values: &points.values[here.clone()],
                monomials,
                moments,
                right_sides,
            };
            part.add(0, &points.weights[here.clone()], None, true, true);
            for m in 1..n_moments {
                let along = &points.offsets[usize::from(tables.axis[m])][here.clone()];
                let parent = Some(usize::from(tables.parent[m]));
                if m < n_unknowns {
                    part.add(m, along, parent, true, true);
                } else if m < n_parents {
                    part.add(m, along, parent, true, false);
                } else {
                    part.add(m, along, parent, false, false);
                }
            }
        }
        add_lanes(registers, moments);
        add_lanes(registers, right_sides);
    }
}

/// Sums over some of the points.
struct Part<'a, R> {
    registers: R,
    is_first: bool,
    values: &'a [f64],
    monomials: &'a mut [f64],
    moments: &'a mut [f64],
    right_sides: &'a mut [f64],
}

impl<R: Registers<f64>> Part<'_, R> {
    /// Adds monomial `m`, its parent times `along`, or `along` itself without a parent. It is stored if it is a parent, and
    /// multiplied by the values if it is an unknown. The caller names both, so that each case is compiled by itself.
    #[inline(always)]
    fn add(
        &mut self,
        m: usize,
        along: &[f64],
        parent: Option<usize>,
        is_parent: bool,
        is_unknown: bool,
    ) {
        let registers = self.registers;
        let (before, own) = self.monomials.split_at_mut((TOGETHER * m).min(self.monomials.len()));
        let along = R::blocks(along);
        // Of one length, so that indices below it are checked once.
        let n = along.len();
        let values = &R::blocks(self.values)[..n];
        let parent = parent.map(|parent| &R::blocks(&before[TOGETHER * parent..])[..n]);
        for s in (0..LANES).step_by(R::N) {
            let (mut sum, mut right_side) = (registers.splat(0.0), registers.splat(0.0));
            if !self.is_first {
                sum = registers.load_at(self.moments, LANES * m + s);
                if is_unknown {
                    right_side = registers.load_at(self.right_sides, LANES * m + s);
                }
            }
            let mut block = s / R::N;
            while block < n {
                let mut value = registers.load(&along[block]);
                if let Some(parent) = parent {
                    value = value * registers.load(&parent[block]);
                }
                if is_parent {
                    registers.store_at(value, own, R::N * block);
                }
                sum = sum + value;
                if is_unknown {
                    right_side = right_side + value * registers.load(&values[block]);
                }
                block += LANES / R::N;
            }
            registers.store_at(sum, self.moments, LANES * m + s);
            if is_unknown {
                registers.store_at(right_side, self.right_sides, LANES * m + s);
            }
        }
    }
}

/// Adds the lanes of each entry and moves the sums to the front of the buffer. The number of entries is a multiple of four.
#[inline(always)]
fn add_lanes<R: Registers<f64>>(registers: R, sums: &mut [f64]) {
    for m in (0..sums.len() / LANES).step_by(4) {
        let mut four = [0.0; 4];
        for s in (0..LANES).step_by(R::N) {
            let row = |k: usize| registers.load_at(sums, LANES * (m + k) + s);
            let added = registers.sum_fours([row(0), row(1), row(2), row(3)]);
            for block in 0..R::N / 4 {
                registers.add_four(added, block, &mut four);
            }
        }
        sums[m..m + 4].copy_from_slice(&four);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_have_the_same_bits_at_every_level() {
        let point = |k: u32| {
            let t = f64::from(k);
            ([(0.7 * t).sin(), (1.3 * t).cos(), 0.1 * t - 2.0], 1.0 / (1.0 + t), (0.2 * t).exp())
        };
        // More than are taken together, and a part of a register.
        let points: Vec<_> = (0..75).map(point).collect();
        let mut columns = Points::of(&points.iter().map(|&(u, w, _)| (u, w)).collect::<Vec<_>>());
        for (value, (.., f)) in columns.values.iter_mut().zip(&points) {
            *value = *f;
        }
        for degree in [0, 1, 2, 3] {
            let tables = Monomials::of_degree::<3>(degree).unwrap();
            let at = |level: SimdLevel| {
                let mut sums = Sums::default();
                level.run(Sum { tables, sums: &mut sums, points: &columns });
                let n = (tables.n_moments, tables.n_unknowns);
                (sums.moments[..n.0].to_vec(), sums.right_sides[..n.1].to_vec())
            };
            let expected = at(SimdLevel::PORTABLE);
            assert!(expected.0.iter().all(|sum| sum.is_finite()));
            for level in SimdLevel::available() {
                assert_eq!(at(level), expected, "degree {degree}, {}", level.name());
            }
        }
    }
}
