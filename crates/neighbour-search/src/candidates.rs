//! Comparison of one point with all candidates of its group.

use simd_lanes::{Lanes, Mask, Registers};

/// Whose radius bounds decide about a candidate.
pub(crate) trait Sight: Copy {
    /// Whether the bounds of the candidates are used.
    const THEIRS: bool;
    fn of<V: Lanes<Number = f32>>(self, mine: V, theirs: V) -> V;
}

macro_rules! sight {
    ($name:ident, $theirs:literal, ($mine:ident, $other:ident) => $value:expr) => {
        #[derive(Debug, Clone, Copy)]
        pub(crate) struct $name;
        impl Sight for $name {
            const THEIRS: bool = $theirs;
            #[inline(always)]
            fn of<V: Lanes<Number = f32>>(self, $mine: V, $other: V) -> V {
                $value
            }
        }
    };
}
sight!(Mine, false, (mine, _theirs) => mine);
sight!(Larger, true, (mine, theirs) => mine.max(theirs));
sight!(Middle, true, (mine, theirs) => mine.splat(0.5) * (mine + theirs));

/// Coordinates, radius bounds and entries of all candidates, in equal numbers.
pub(crate) struct Candidates<'a, R: Registers<f32>, const D: usize> {
    pub(crate) columns: [&'a [R::Block]; D],
    pub(crate) lower: &'a [R::Block],
    pub(crate) upper: &'a [R::Block],
    pub(crate) entries: &'a [R::Indices],
    /// Blocks that contain points of the group itself.
    pub(crate) n_own: usize,
}

impl<R: Registers<f32>, const D: usize> Candidates<'_, R, D> {
    /// Appends the neighbours of a point of the group to `out` from `filled` on; returns the new end.
    ///
    /// `others(first)` selects which candidates of a block may be listed; `close(first, mask)` selects those of a mask
    /// within reach.
    #[inline(always)]
    pub(crate) fn row<S: Sight>(
        &self,
        registers: R,
        (x_i, bounds): ([f32; D], [f32; 2]),
        sight: S,
        others: impl Fn(usize) -> u32,
        close: impl Fn(usize, u32) -> u32,
        (out, mut filled): (&mut [u32], usize),
    ) -> usize {
        let mut x = [registers.splat(0.0); D];
        for axis in 0..D {
            x[axis] = registers.splat(x_i[axis]);
        }
        let bounds = [registers.splat(bounds[0]), registers.splat(bounds[1])];
        for block in 0..self.n_own {
            let [certain, possible] = self.within(registers, block, &x, bounds, sight);
            let others = others(block * R::N);
            let (mut listed, unsure) = (certain & others, (possible ^ certain) & others);
            if unsure != 0 {
                listed |= close(block * R::N, unsure);
            }
            filled += registers.compress_indices(listed, &self.entries[block], out, filled);
        }
        for block in self.n_own..self.entries.len() {
            let [certain, possible] = self.within(registers, block, &x, bounds, sight);
            let mut listed = certain;
            if certain != possible {
                listed |= close(block * R::N, possible ^ certain);
            }
            filled += registers.compress_indices(listed, &self.entries[block], out, filled);
        }
        filled
    }

    /// Masks of the candidates of a block that are certainly within reach of `x_i`, and of those that may be.
    #[inline(always)]
    fn within<S: Sight>(
        &self,
        registers: R,
        block: usize,
        x_i: &[R::Vector; D],
        [lower, upper]: [R::Vector; 2],
        sight: S,
    ) -> [u32; 2] {
        let along = x_i[0] - registers.load(&self.columns[0][block]);
        let mut d2 = along * along;
        for axis in 1..D {
            let along = x_i[axis] - registers.load(&self.columns[axis][block]);
            d2 = registers.mul_add(along, along, d2);
        }
        let (mut lower, mut upper) = (lower, upper);
        if S::THEIRS {
            lower = sight.of(lower, registers.load(&self.lower[block]));
            upper = sight.of(upper, registers.load(&self.upper[block]));
        }
        [d2.less(lower * lower).bits(), d2.less(upper * upper).bits()]
    }
}
