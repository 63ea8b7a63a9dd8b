//! Groups of up to four particles of one cell, adjacent in memory, for the lanes of a register: they have the same nodes.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched work is not compiled for its registers"
)]

use simd_lanes::{Lanes, Registers};

use crate::grid::lattice::Lattice;
use crate::grid::tile_size::MOST_NODES;

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// Most particles of a group.
pub(crate) const LANES: usize = 4;

/// Groups that a transfer processes together, in one or two registers by their width: the order of the sums at the nodes does not
/// depend on the registers of the machine.
pub(crate) const PAIR: usize = 2;

/// Registers that a pair needs.
pub(crate) const fn parts<R: Registers<f64>>() -> usize {
    PAIR * LANES / R::N
}

/// A group: some of four consecutive particles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Group {
    /// The particle in the first lane, which may belong to another group.
    pub(crate) first: usize,
    /// The first lane of the group.
    pub(crate) lane: usize,
    /// The number of its particles; zero for the second group of an incomplete pair.
    pub(crate) len: usize,
}

impl Group {
    /// The group that begins with particle `begin` and ends before `end`. `nodes` are the lowest nodes of all particles, of which
    /// there are at least [`LANES`].
    #[inline(always)]
    pub(crate) fn at(nodes: &[usize], begin: usize, end: usize) -> Self {
        let first = begin.min(nodes.len() - LANES);
        let (lane, node) = (begin - first, nodes[begin]);
        // Without a branch, which would be mispredicted.
        let mut others = 0;
        for (l, &other) in nodes[first..first + LANES].iter().enumerate() {
            others |= u32::from(other != node) << l;
        }
        let together = (others >> lane | 1 << (LANES - lane)).trailing_zeros() as usize;
        Self { first, lane, len: together.min(end - begin) }
    }

    /// An empty group.
    #[inline(always)]
    pub(crate) fn none() -> Self {
        Self { first: 0, lane: 0, len: 0 }
    }

    /// The first particle of the group; for the second group of an incomplete pair, that of the first.
    #[inline(always)]
    pub(crate) fn particle(&self) -> usize {
        self.first + self.lane
    }

    /// Bit `l` is set if lane `l` belongs to the group.
    #[inline(always)]
    fn bits(&self) -> u32 {
        ((1 << self.len) - 1) << self.lane
    }
}

/// Mask of the lanes that belong to groups.
#[inline(always)]
pub(crate) fn lanes_of<R: Registers<f64>>(
    registers: R,
    groups: &[Group],
) -> <R::Vector as Lanes>::Mask {
    let mut bits = 0;
    for b in 0..R::N / LANES {
        bits |= groups[b].bits() << (LANES * b);
    }
    registers.mask(bits)
}

#[inline(always)]
fn four(column: &[f64], at: usize) -> &[f64; LANES] {
    column[at..at + LANES].first_chunk().expect("a slice of four")
}

/// Entries of a column, in lanes.
#[inline(always)]
pub(crate) fn numbers<R: Registers<f64>>(
    registers: R,
    column: &[f64],
    groups: &[Group],
) -> R::Vector {
    let mut fours = [four(column, groups[0].first); PAIR];
    for b in 1..R::N / LANES {
        fours[b] = four(column, groups[b].first);
    }
    registers.load_fours(&fours)
}

/// One number of each group in all its lanes.
#[inline(always)]
pub(crate) fn of_groups<R: Registers<f64>>(registers: R, numbers: [f64; PAIR]) -> R::Vector {
    let fours = [[numbers[0]; LANES], [numbers[1]; LANES]];
    registers.load_fours(&[&fours[0], &fours[1]])
}

/// The components of entries of a column, in lanes.
#[inline(always)]
pub(crate) fn components<R: Registers<f64>, const K: usize>(
    registers: R,
    column: &[[f64; K]],
    groups: &[Group],
) -> [R::Vector; K] {
    let mut components = [registers.splat(0.0); K];
    if K == 2 {
        let flat = column.as_flattened();
        let mut low = [four(flat, 2 * groups[0].first); PAIR];
        let mut high = [four(flat, 2 * groups[0].first + LANES); PAIR];
        for b in 1..R::N / LANES {
            low[b] = four(flat, 2 * groups[b].first);
            high[b] = four(flat, 2 * groups[b].first + LANES);
        }
        let [x, y] = registers.unzip_fours(registers.load_fours(&low), registers.load_fours(&high));
        (components[0], components[K - 1]) = (x, y);
        return components;
    }
    for k in 0..K {
        let mut lanes = [0.0; PAIR * LANES];
        for b in 0..R::N / LANES {
            let entries = &column[groups[b].first..groups[b].first + LANES];
            for lane in 0..LANES {
                lanes[LANES * b + lane] = entries[lane][k];
            }
        }
        components[k] = registers.load_at(&lanes, 0);
    }
    components
}

/// Values and slopes (per cell) of a shape function along one axis, from the lowest node of the particles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GroupAxis<V> {
    pub(crate) value: [V; MOST_NODES],
    pub(crate) slope: [V; MOST_NODES],
}

impl<V: Lanes<Number = f64>> GroupAxis<V> {
    /// Zeros, in as many lanes as a register has.
    #[inline(always)]
    pub(crate) fn none(register: V) -> Self {
        let zeros = [register.splat(0.0); MOST_NODES];
        Self { value: zeros, slope: zeros }
    }

    /// For particles at `s` (in cells) with the lowest node `lowest`, a whole number.
    #[inline(always)]
    pub(crate) fn of<const NODES: usize>(s: V, lowest: V) -> Self {
        match NODES {
            3 => Self::quadratic(s - lowest),
            _ => Self::cubic(s - (lowest + s.splat(1.0))),
        }
    }

    /// At `f` from 1/2 to 3/2 behind the lowest node.
    #[inline(always)]
    fn quadratic(f: V) -> Self {
        let (zero, half, middle) = (f.splat(0.0), f.splat(0.5), f.splat(0.75));
        let (left, centre, right) = (f.splat(1.5) - f, f - f.splat(1.0), f - half);
        Self {
            value: [left * left * half, middle - centre * centre, right * right * half, zero],
            slope: [f - f.splat(1.5), centre * f.splat(-2.0), right, zero],
        }
    }

    /// At `f` from 0 to 1 behind the second node.
    #[inline(always)]
    fn cubic(f: V) -> Self {
        let (one, half, sixth) = (f.splat(1.0), f.splat(0.5), f.splat(1.0 / 6.0));
        let (two, three, four, six) = (f.splat(2.0), f.splat(3.0), f.splat(4.0), f.splat(6.0));
        let middle = f.splat(1.5);
        let rest = one - f;
        let (f2, r2) = (f * f, rest * rest);
        Self {
            value: [
                r2 * rest * sixth,
                (f2 * f * three - f2 * six + four) * sixth,
                (r2 * rest * three - r2 * six + four) * sixth,
                f2 * f * sixth,
            ],
            slope: [
                r2 * f.splat(-0.5),
                f2 * middle - f * two,
                f.splat(0.0) - (r2 * middle - rest * two),
                f2 * half,
            ],
        }
    }
}

/// `N + c N''` at the nodes along the radius, of particles at `s` (in cells) with the lowest node `lowest`, a whole number.
#[inline(always)]
pub(crate) fn hoop_weights<V: Lanes<Number = f64>, const NODES: usize>(
    axis: &GroupAxis<V>,
    (s, lowest): (V, V),
    curvature: f64,
) -> [V; MOST_NODES] {
    let (one, two, three) = (s.splat(1.0), s.splat(2.0), s.splat(3.0));
    let second = if NODES == 3 {
        [one, s.splat(-2.0), one, s.splat(0.0)]
    } else {
        let f = s - (lowest + one);
        let rest = one - f;
        [rest, three * f - two, three * rest - two, f]
    };
    let mut weights = axis.value;
    for i in 0..NODES {
        weights[i] = weights[i] + s.splat(curvature) * second[i];
    }
    weights
}

impl<const D: usize> Lattice<D> {
    /// The places of groups along the radius, in cells, and their lowest nodes.
    #[inline(always)]
    pub(crate) fn group_radii<R: Registers<f64>>(
        &self,
        registers: R,
        radius: R::Vector,
        (groups, bases): (&[Group], &[[i32; D]]),
    ) -> (R::Vector, R::Vector) {
        let s = (radius - registers.splat(self.origin[0])) * registers.splat(self.per_cell);
        let lowest = [groups[0], groups[R::N / LANES - 1]]
            .map(|group| f64::from(bases[group.particle()][0]));
        (s, of_groups(registers, lowest))
    }

    /// The shape function of groups of particles at `x` along all axes, from their lowest nodes `bases` on.
    #[inline(always)]
    pub(crate) fn group_axes<R: Registers<f64>, const NODES: usize>(
        &self,
        registers: R,
        x: &[R::Vector; D],
        (groups, bases): (&[Group], &[[i32; D]]),
    ) -> [GroupAxis<R::Vector>; D] {
        let per_cell = registers.splat(self.per_cell);
        let mut axes = [GroupAxis::none(per_cell); D];
        let mut lowest = [&bases[groups[0].particle()]; PAIR];
        for b in 1..R::N / LANES {
            lowest[b] = &bases[groups[b].particle()];
        }
        for k in 0..D {
            let s = (x[k] - registers.splat(self.origin[k])) * per_cell;
            let base = of_groups(registers, [f64::from(lowest[0][k]), f64::from(lowest[1][k])]);
            axes[k] = GroupAxis::of::<NODES>(s, base);
        }
        axes
    }
}

/// Factor of the axes beyond the first in the shape function at a row of nodes, and its slopes (per cell) along these axes.
#[inline(always)]
pub(crate) fn group_outer<V: Lanes<Number = f64>, const D: usize>(
    axes: &[GroupAxis<V>; D],
    (j, k): (usize, usize),
) -> (V, [V; D]) {
    let one = axes[0].value[0].splat(1.0);
    let mut slope = [one; D];
    if D == 1 {
        return (one, slope);
    }
    let (value_y, slope_y) = (axes[D.min(2) - 1].value[j], axes[D.min(2) - 1].slope[j]);
    if D == 2 {
        slope[1] = slope_y;
        return (value_y, slope);
    }
    let (value_z, slope_z) = (axes[D - 1].value[k], axes[D - 1].slope[k]);
    slope[1] = slope_y * value_z;
    slope[2] = value_y * slope_z;
    (value_y * value_z, slope)
}
