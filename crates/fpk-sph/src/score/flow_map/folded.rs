//! Points whose neighbours are arranged alike but for reflections and permutations of the axes: they share one set of
//! weights, several points in a register.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::ops::Range;

use simd_lanes::{MOST_LANES, Registers};

use super::arrangement::Turn;
use super::pattern::Pattern;
use super::stencils::Stencils;

/// Points of a lattice, each with its members in the order of its class.
#[derive(Debug, Clone, Default)]
pub(crate) struct Folded<const D: usize> {
    classes: Vec<Class<D>>,
    points: Vec<Point<D>>,
    /// Members of the points of a pack, side by side.
    members: Vec<[u32; PACK]>,
    packs: Vec<Pack>,
}

/// Points that are taken together: as many as give two registers of 512 bits.
const PACK: usize = 4;

/// The weights of one arrangement of members, in the orientation of the class.
#[derive(Debug, Clone)]
struct Class<const D: usize> {
    gradient: Vec<[f64; D]>,
    value: Vec<[f64; 1]>,
    /// Weights of the gradient along three axes and of the mean, then those along the other axes, for [`Folded::four_sums`].
    fours: Vec<[[f64; 4]; 2]>,
}

/// A point, and how its arrangement is turned into that of its class.
#[derive(Debug, Clone, Copy)]
struct Point<const D: usize> {
    i: usize,
    turn: Turn<D>,
}

/// Points of one class, at most [`PACK`]; the members of the last are repeated where there are fewer.
#[derive(Debug, Clone)]
struct Pack {
    class: usize,
    points: Range<usize>,
    members: Range<usize>,
}

/// Most blocks of four lanes in a register.
const MOST_FOURS: usize = MOST_LANES / 4;

impl<const D: usize> Folded<D> {
    /// No points yet, and the classes of all.
    pub(crate) fn new(stencils: &Stencils<D>) -> Self {
        let classes = stencils.classes().iter().map(Class::of).collect();
        Self { classes, ..Self::default() }
    }

    /// Adds points in packs of one class; returns the packs.
    pub(crate) fn add(&mut self, stencils: &Stencils<D>, points: &[usize]) -> Range<usize> {
        let first = self.packs.len();
        let mut of_class: Vec<_> = points.iter().map(|&i| (stencils.class_of(i), i)).collect();
        of_class.sort_unstable();
        let same_class = of_class.chunk_by(|a, b| a.0 == b.0);
        for pack in same_class.flat_map(|points| points.chunks(PACK)) {
            let (class, points, members) = (pack[0].0, self.points.len(), self.members.len());
            let in_pack = |p: usize| stencils.of(pack[p.min(pack.len() - 1)].1);
            self.points.extend(pack.iter().map(|&(_, i)| Point { i, turn: *stencils.of(i).turn }));
            let of_points: [&[u32]; PACK] = std::array::from_fn(|p| in_pack(p).members);
            let n_members = of_points[0].len();
            self.members.extend((0..n_members).map(|t| of_points.map(|members| members[t])));
            let (points, members) = (points..self.points.len(), members..self.members.len());
            self.packs.push(Pack { class, points, members });
        }
        first..self.packs.len()
    }

    /// Number of classes among the points added.
    #[cfg(test)]
    pub(crate) fn n_classes(&self) -> usize {
        self.packs.iter().map(|pack| pack.class).collect::<std::collections::BTreeSet<_>>().len()
    }

    /// Blocks of four components of each point, for [`Self::gradients`]: `ceil(D / 4)` for each.
    pub(crate) fn blocks_of(f: &[[f64; D]], blocks: &mut Vec<[f64; 4]>) {
        blocks.resize(f.len() * D.div_ceil(4), [0.0; 4]);
        for block in 0..D.div_ceil(4) {
            let blocks = blocks.iter_mut().skip(block).step_by(D.div_ceil(4));
            for (f, out) in f.iter().zip(blocks) {
                *out =
                    simd_lanes::from_fn(|k| if 4 * block + k < D { f[4 * block + k] } else { 0.0 });
            }
        }
    }

    /// `found(point, sums)` with `sums[l][k] = sum_j gradient_jl f_jk` along the axes of the lattice, for the points of
    /// some packs; `blocks` holds the components of `f`.
    #[inline(always)]
    pub(crate) fn gradients<R: Registers<f64>>(
        &self,
        registers: R,
        packs: Range<usize>,
        blocks: &[[f64; 4]],
        mut found: impl FnMut(usize, [[f64; D]; D]),
    ) {
        let block_of = |j: usize, block: usize| &blocks[D.div_ceil(4) * j + block];
        for pack in &self.packs[packs] {
            let weights = &self.classes[pack.class].gradient;
            self.splat_sums(registers, pack, weights, block_of, |point, sums| {
                let mut turned = [[0.0; D]; D];
                for l in 0..D {
                    for k in 0..D {
                        turned[point.turn.axis[l]][k] = point.turn.sign[l] * sums[l][k];
                    }
                }
                found(point.i, turned);
            });
        }
    }

    /// `found(point, sums)` with `sums[k] = sum_j value_j f_jk`, for the points of some packs; `f` has `D` components for
    /// each point.
    #[inline(always)]
    pub(crate) fn values<R: Registers<f64>>(
        &self,
        registers: R,
        packs: Range<usize>,
        f: &[f64],
        mut found: impl FnMut(usize, [f64; D]),
    ) {
        let end = padded_end::<D>(f);
        let block_of = |j: usize, block: usize| four_at(f, D * j + 4 * block, &end);
        for pack in &self.packs[packs] {
            let weights = &self.classes[pack.class].value;
            self.splat_sums(registers, pack, weights, block_of, |point, [sums]| {
                found(point.i, simd_lanes::from_fn(|k| sums[k]));
            });
        }
    }

    /// `sums[n][k] = sum_j w_jn f_jk` of the points of a pack. Blocks of four lanes hold components of `f`, one point in each
    /// block.
    #[inline(always)]
    fn splat_sums<'a, R: Registers<f64>, const N: usize>(
        &self,
        registers: R,
        pack: &Pack,
        weights: &[[f64; N]],
        block_of: impl Fn(usize, usize) -> &'a [f64; 4],
        mut found: impl FnMut(&Point<D>, [[f64; 8]; N]),
    ) {
        // A register holds one or two points.
        let wide = R::N / 4;
        let mut sums = [[[registers.splat(0.0); N]; 2]; PACK];
        for (members, weight) in self.members[pack.members.clone()].iter().zip(weights) {
            for r in 0..PACK / wide {
                for block in 0..D.div_ceil(4) {
                    let mut fours = [&[0.0; 4]; MOST_FOURS];
                    for p in 0..wide {
                        fours[p] = block_of(members[wide * r + p] as usize, block);
                    }
                    let values = registers.load_fours(&fours[..wide]);
                    for n in 0..N {
                        sums[r][block][n] = sums[r][block][n] + registers.splat(weight[n]) * values;
                    }
                }
            }
        }
        for (at, point) in self.points[pack.points.clone()].iter().enumerate() {
            let mut of_point = [[0.0; 8]; N];
            for n in 0..N {
                for block in 0..D.div_ceil(4) {
                    let four = registers.four(sums[at / wide][block][n], at % wide);
                    of_point[n][4 * block..4 * block + 4].copy_from_slice(&four);
                }
            }
            found(point, of_point);
        }
    }

    /// `found(point, gradient, mean)` with `sum_j gradient_jl d_j` along the axes of the lattice and `sum_j mean_j v_j`,
    /// for the points of some packs; `carried` holds `[d, d, d, v]` of each point.
    #[inline(always)]
    pub(crate) fn four_sums<R: Registers<f64>>(
        &self,
        registers: R,
        packs: Range<usize>,
        carried: &[[f64; 4]],
        mut found: impl FnMut(usize, [f64; D], f64),
    ) {
        let wide = R::N / 4;
        for Pack { class, points, members } in &self.packs[packs] {
            let weights = &self.classes[*class].fours;
            let mut sums = [[registers.splat(0.0); 2]; PACK];
            for (members, weight) in self.members[members.clone()].iter().zip(weights) {
                for r in 0..PACK / wide {
                    let mut fours = [&[0.0; 4]; MOST_FOURS];
                    for p in 0..wide {
                        fours[p] = &carried[members[wide * r + p] as usize];
                    }
                    let values = registers.load_fours(&fours[..wide]);
                    for block in 0..D.div_ceil(3) {
                        let same = [&weight[block]; MOST_FOURS];
                        let weight = registers.load_fours(&same[..wide]);
                        sums[r][block] = sums[r][block] + weight * values;
                    }
                }
            }
            for (at, Point { i, turn }) in self.points[points.clone()].iter().enumerate() {
                let mut fours = [[0.0; 4]; 2];
                for block in 0..D.div_ceil(3) {
                    fours[block] = registers.four(sums[at / wide][block], at % wide);
                }
                let of_class = simd_lanes::from_fn(|l| fours[l / 3][l % 3]);
                found(*i, turn.back(&of_class), fours[0][3]);
            }
        }
    }
}

impl<const D: usize> Class<D> {
    fn of(pattern: &Pattern<D>) -> Self {
        let four = |(gradient, mean): (&[f64; D], &f64)| {
            let mut fours = [[0.0; 4]; 2];
            for l in 0..D {
                fours[l / 3][l % 3] = gradient[l];
            }
            fours[0][3] = *mean;
            fours
        };
        Self {
            gradient: pattern.gradient.clone(),
            value: pattern.value.iter().map(|&value| [value]).collect(),
            fours: pattern.gradient.iter().zip(&pattern.mean).map(four).collect(),
        }
    }
}

/// The components of the last point that do not fill a block of four lanes, and zeros.
#[inline(always)]
fn padded_end<const D: usize>(f: &[f64]) -> [f64; 4] {
    let mut end = [0.0; 4];
    let rest = &f[f.len() - D % 4..];
    end[..rest.len()].copy_from_slice(rest);
    end
}

/// Four numbers from an index on; `end` where there are not as many.
#[inline(always)]
fn four_at<'a>(f: &'a [f64], at: usize, end: &'a [f64; 4]) -> &'a [f64; 4] {
    f.get(at..at + 4).and_then(<[f64]>::first_chunk).unwrap_or(end)
}
