//! Weighted sums over the members of all points of a lattice, by registers.
//!
//! Points in runs of lattice rows share weights that are constant along the run ([`runs`](super::runs)). The others,
//! mostly at the rim, share weights with those whose members are arranged alike ([`folded`](super::folded)).

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::ops::Range;

use simd_lanes::Registers;

use super::folded::Folded;
use super::runs::{self, Run, runs_of};
use super::stencils::Stencils;

/// Points that one thread takes at a time. Runs end where a part ends.
pub(crate) const PART: usize = 256;

/// A run shorter than this has its points folded. In one dimension none is: a point has few neighbours there.
const SHORTEST_RUN: usize = 4;

/// How the points of a lattice are taken, part by part. The order of every sum is that of this plan: results do not depend on
/// the width of the registers nor on the number of threads.
#[derive(Debug, Clone, Default)]
pub(crate) struct LatticeSums<const D: usize> {
    parts: Vec<Part>,
    runs: Vec<Run>,
    folded: Folded<D>,
}

/// The runs and the packs of folded points of a part, which starts at a point.
#[derive(Debug, Clone)]
struct Part {
    first: usize,
    runs: Range<usize>,
    packs: Range<usize>,
}

impl<const D: usize> LatticeSums<D> {
    /// The plan for the points of a lattice.
    pub(crate) fn new(stencils: &Stencils<D>, n: usize) -> Self {
        let shortest = if D == 1 { 1 } else { SHORTEST_RUN };
        let mut sums = Self { folded: Folded::new(stencils), ..Self::default() };
        for first in (0..n).step_by(PART) {
            let start = sums.runs.len();
            let mut single = Vec::new();
            for run in runs_of(stencils, first..n.min(first + PART)) {
                if run.len >= shortest {
                    sums.runs.push(run);
                } else {
                    single.extend(run.first..run.first + run.len);
                }
            }
            let packs = sums.folded.add(stencils, &single);
            sums.parts.push(Part { first, runs: start..sums.runs.len(), packs });
        }
        sums
    }

    /// Components in blocks, for [`Self::gradients`].
    pub(crate) fn blocks_of(f: &[[f64; D]], blocks: &mut Vec<[f64; 4]>) {
        Folded::blocks_of(f, blocks);
    }

    /// `columns[l][p][k] = sum_j gradient_jl f_jk` for the points `p` of a part; `f` has `D` components for each point, and
    /// `blocks` holds them in blocks.
    #[inline(always)]
    pub(crate) fn gradients<R: Registers<f64>>(
        &self,
        registers: R,
        stencils: &Stencils<D>,
        part: usize,
        (f, blocks): (&[[f64; D]], &[[f64; 4]]),
        columns: &mut [[[f64; D]; PART]; D],
    ) {
        let Part { first, runs, packs } = self.parts[part].clone();
        for run in &self.runs[runs] {
            let here = run.first - first..run.first - first + run.len;
            let mut out = columns.each_mut().map(|column| column[here.clone()].as_flattened_mut());
            let stencil = stencils.of(run.first);
            runs::gradient::<R, D, D>(registers, stencil, f.as_flattened(), &mut out);
        }
        self.folded.gradients(registers, packs, blocks, |i, gradient| {
            for l in 0..D {
                columns[l][i - first] = gradient[l];
            }
        });
    }

    /// `gradient[l][p] = sum_j gradient_jl d_j` and `mean[p] = sum_j mean_j v_j` for the points `p` of a part.
    #[inline(always)]
    pub(crate) fn gradients_and_means<R: Registers<f64>>(
        &self,
        registers: R,
        stencils: &Stencils<D>,
        part: usize,
        (d, v, fours): (&[f64], &[f64], &[[f64; 4]]),
        (gradient, mean): (&mut [[f64; PART]; D], &mut [f64; PART]),
    ) {
        let Part { first, runs, packs } = self.parts[part].clone();
        for run in &self.runs[runs] {
            let here = run.first - first..run.first - first + run.len;
            let mut out = gradient.each_mut().map(|gradient| &mut gradient[here.clone()]);
            let stencil = stencils.of(run.first);
            runs::gradient::<R, D, 1>(registers, stencil, d, &mut out);
            let weights = &stencil.weights.mean;
            runs::mean::<R, D, 1>(registers, stencil, weights, v, &mut mean[here]);
        }
        self.folded.four_sums(registers, packs, fours, |i, of_point, mean_of_point| {
            for l in 0..D {
                gradient[l][i - first] = of_point[l];
            }
            mean[i - first] = mean_of_point;
        });
    }

    /// `fitted[p][k] = sum_j value_j f_jk` for the points `p` of a part; `f` has `D` components for each point.
    #[inline(always)]
    pub(crate) fn values<R: Registers<f64>>(
        &self,
        registers: R,
        stencils: &Stencils<D>,
        part: usize,
        f: &[[f64; D]],
        fitted: &mut [[f64; D]],
    ) {
        let Part { first, runs, packs } = self.parts[part].clone();
        for run in &self.runs[runs] {
            let here = run.first - first..run.first - first + run.len;
            let out = fitted[here].as_flattened_mut();
            let stencil = stencils.of(run.first);
            let weights = &stencil.weights.value;
            runs::mean::<R, D, D>(registers, stencil, weights, f.as_flattened(), out);
        }
        self.folded.values(registers, packs, f.as_flattened(), |i, value| {
            fitted[i - first] = value;
        });
    }
}

#[cfg(test)]
mod tests {
    use neighbour_search::{CellGrid, NeighbourList, NeighbourSearch, Radii};
    use particle_store::Lattice;
    use simd_lanes::{SimdLevel, Work};

    use super::*;

    /// All sums of a part over the same numbers.
    struct All<'a, const D: usize>(&'a Stencils<D>, &'a LatticeSums<D>, usize, &'a Numbers<D>);

    /// Numbers of each point: components, and a scalar twice.
    struct Numbers<const D: usize> {
        f: Vec<[f64; D]>,
        blocks: Vec<[f64; 4]>,
        d: Vec<f64>,
        v: Vec<f64>,
        fours: Vec<[f64; 4]>,
    }

    /// Sums of each point of a part: gradients of components, of a scalar, its mean, values.
    struct Sums<const D: usize> {
        columns: Box<[[[f64; D]; PART]; D]>,
        gradient: Box<[[f64; PART]; D]>,
        mean: [f64; PART],
        fitted: Vec<[f64; D]>,
    }

    impl<const D: usize> Work<f64> for All<'_, D> {
        type Output = Sums<D>;

        #[inline(always)]
        fn run<R: Registers<f64>>(self, registers: R) -> Sums<D> {
            let Self(stencils, sums, part, Numbers { f, blocks, d, v, fours }) = self;
            let n = PART.min(f.len() - part * PART);
            let mut out = Sums {
                columns: Box::new([[[0.0; D]; PART]; D]),
                gradient: Box::new([[0.0; PART]; D]),
                mean: [0.0; PART],
                fitted: vec![[0.0; D]; n],
            };
            sums.gradients(registers, stencils, part, (f, blocks), &mut out.columns);
            let scalars = (&mut *out.gradient, &mut out.mean);
            sums.gradients_and_means(registers, stencils, part, (d, v, fours), scalars);
            sums.values(registers, stencils, part, f, &mut out.fitted);
            out
        }
    }

    fn numbers<const D: usize>(n: usize) -> Numbers<D> {
        let number = |seed: usize| (seed as f64 * 0.7).sin() + 0.3 * (seed as f64 * 0.11).cos();
        let f: Vec<[f64; D]> = (0..n).map(|i| std::array::from_fn(|k| number(D * i + k))).collect();
        let d: Vec<f64> = (0..n).map(|i| number(7 * i + 3)).collect();
        let v: Vec<f64> = (0..n).map(|i| 1.5 + number(5 * i + 1)).collect();
        let fours = d.iter().zip(&v).map(|(&d, &v)| [d, d, d, v]).collect();
        let mut blocks = Vec::new();
        LatticeSums::blocks_of(&f, &mut blocks);
        Numbers { f, blocks, d, v, fours }
    }

    /// Compares all sums at all levels with sums over the members, one by one; returns the share of points in runs and the
    /// number of arrangements and classes of the others.
    fn sums_agree<const D: usize>(lattice: &Lattice<D>, reach: f64, degree: usize) -> Plan {
        let places: Vec<[f64; D]> = lattice.indices.iter().map(|i| i.map(f64::from)).collect();
        let mut list = NeighbourList::new();
        CellGrid::new().full_list(&places, Radii::Uniform(reach), &mut list).unwrap();
        list.sort_rows();
        let stencils = Stencils::new(&places, &list, reach, degree).unwrap();
        let n = places.len();
        let sums = LatticeSums::new(&stencils, n);
        let numbers = numbers::<D>(n);
        for part in 0..n.div_ceil(PART) {
            let portable = SimdLevel::PORTABLE.run(All(&stencils, &sums, part, &numbers));
            for level in SimdLevel::available() {
                let same = level.run(All(&stencils, &sums, part, &numbers));
                assert!(
                    same.columns == portable.columns
                        && same.gradient == portable.gradient
                        && same.mean.map(f64::to_bits) == portable.mean.map(f64::to_bits)
                        && same.fitted == portable.fitted,
                    "{level}, part {part}"
                );
            }
            for p in 0..portable.fitted.len() {
                compare(&stencils, &numbers, part * PART + p, &portable, p);
            }
        }
        Plan::of(&stencils, &sums, n)
    }

    /// Compares the sums of point `i`, entry `p` of its part, with those over its members.
    fn compare<const D: usize>(
        stencils: &Stencils<D>,
        numbers: &Numbers<D>,
        i: usize,
        found: &Sums<D>,
        p: usize,
    ) {
        let stencil = stencils.of(i);
        // Roundoff of the fits that give the weights, `EPSILON` over the smallest pivot, of numbers of order 1.
        let roundoff = 200.0 * f64::EPSILON / stencils.fits.smallest_pivot;
        let near = |found: f64, expected: f64, sum: &str| {
            let error = (found - expected).abs();
            assert!(error < roundoff, "{D}-D, {sum} of point {i}: {error:e}, {roundoff:e}");
        };
        let over_members = |weight: &dyn Fn(usize) -> f64, value: &dyn Fn(usize) -> f64| -> f64 {
            let members = stencil.members.iter().enumerate();
            members.map(|(t, &j)| weight(t) * value(j as usize)).sum()
        };
        let weights = stencil.weights;
        for l in 0..D {
            for k in 0..D {
                let expected = over_members(&|t| stencil.gradient(t)[l], &|j| numbers.f[j][k]);
                near(found.columns[l][p][k], expected, "gradient of a component");
            }
            let expected = over_members(&|t| stencil.gradient(t)[l], &|j| numbers.d[j]);
            near(found.gradient[l][p], expected, "gradient");
            let expected = over_members(&|t| weights.value[t], &|j| numbers.f[j][l]);
            near(found.fitted[p][l], expected, "value");
        }
        near(found.mean[p], over_members(&|t| weights.mean[t], &|j| numbers.v[j]), "mean");
    }

    /// How the points of a lattice are taken.
    #[derive(Debug)]
    struct Plan {
        share_in_runs: f64,
        n_arrangements: usize,
        n_classes: usize,
    }

    impl Plan {
        fn of<const D: usize>(stencils: &Stencils<D>, sums: &LatticeSums<D>, n: usize) -> Self {
            let in_runs: usize = sums.runs.iter().map(|run| run.len).sum();
            let run_of = |i: usize| {
                sums.runs.iter().any(|run| (run.first..run.first + run.len).contains(&i))
            };
            let single = (0..n).filter(|&i| !run_of(i));
            let arrangements: std::collections::BTreeSet<_> = single
                .map(|i| (stencils.class_of(i), stencils.of(i).turn))
                .map(|(class, turn)| (class, turn.axis, turn.sign.map(|sign| sign < 0.0)))
                .collect();
            Self {
                share_in_runs: in_runs as f64 / n as f64,
                n_arrangements: arrangements.len(),
                n_classes: sums.folded.n_classes(),
            }
        }
    }

    #[test]
    fn sums_are_those_over_the_members_at_every_level_on_any_lattice() {
        let line = sums_agree(&Lattice::box_lattice([1.0], [40]).unwrap(), 3.2, 3);
        assert!(line.share_in_runs > 0.999 && line.n_classes == 0, "{line:?}");
        let plane = sums_agree(&Lattice::box_lattice([1.0; 2], [21, 21]).unwrap(), 2.8, 3);
        // The corners and sides of a square of 4 sides and 2 diagonals.
        assert!(
            plane.share_in_runs > 0.8 && plane.n_classes < plane.n_arrangements / 3,
            "{plane:?}"
        );
        sums_agree(&Lattice::<2>::ball_lattice(5.0, 0.37).unwrap(), 2.8, 3);
        let ball = sums_agree(&Lattice::<3>::ball_lattice(5.0, 0.6).unwrap(), 2.8, 3);
        // 48 turns bring a ball onto itself.
        assert!(ball.share_in_runs > 0.2 && ball.n_classes < ball.n_arrangements / 8, "{ball:?}");
        sums_agree(&Lattice::<4>::ball_lattice(3.0, 1.0).unwrap(), 2.8, 3);
        sums_agree(&Lattice::<5>::ball_lattice(2.5, 1.0).unwrap(), 2.3, 2);
        sums_agree(&Lattice::<6>::ball_lattice(2.3, 1.0).unwrap(), 2.3, 2);
    }

    #[test]
    fn a_lattice_without_symmetry_or_long_rows_is_taken_all_the_same() {
        // The places of a remapped cloud: sorted with the last axis fastest, a hole and a ragged rim.
        let mut indices: Vec<[i32; 2]> = Vec::new();
        for x in -9..9_i32 {
            for y in -7..11_i32 {
                let is_hole = (x - 3).pow(2) + (y - 2).pow(2) < 5;
                if !is_hole && x * x + x * y + 2 * y * y < 120 {
                    indices.push([x, y]);
                }
            }
        }
        let points = indices.iter().map(|index| index.map(f64::from)).collect();
        let plan = sums_agree(&Lattice { points, indices, spacing: [1.0; 2] }, 2.8, 3);
        assert!(plan.share_in_runs < 0.7 && plan.share_in_runs > 0.1, "{plan:?}");
    }
}
