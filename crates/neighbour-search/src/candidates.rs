//! One point against all candidates of its group.

use crate::simd::Lanes;

/// Whose bounds decide about a candidate.
pub(crate) trait Sight: Copy {
    /// Whether those of the candidates matter.
    const THEIRS: bool;
    fn of<L: Lanes>(self, lanes: L, mine: L::Vector, theirs: L::Vector) -> L::Vector;
}

macro_rules! sight {
    ($name:ident, $theirs:literal, ($lanes:ident, $mine:ident, $other:ident) => $value:expr) => {
        #[derive(Debug, Clone, Copy)]
        pub(crate) struct $name;
        impl Sight for $name {
            const THEIRS: bool = $theirs;
            #[inline(always)]
            fn of<L: Lanes>(self, $lanes: L, $mine: L::Vector, $other: L::Vector) -> L::Vector {
                $value
            }
        }
    };
}
sight!(Mine, false, (_lanes, mine, _theirs) => mine);
sight!(Larger, true, (lanes, mine, theirs) => lanes.max(mine, theirs));
sight!(Middle, true, (lanes, mine, theirs) => {
    lanes.mul(lanes.splat(0.5), lanes.add(mine, theirs))
});

/// Coordinates, bounds and entries of all candidates, equally many of each.
pub(crate) struct Candidates<'a, L: Lanes, const D: usize> {
    pub(crate) columns: [&'a [L::Floats]; D],
    pub(crate) lower: &'a [L::Floats],
    pub(crate) upper: &'a [L::Floats],
    pub(crate) entries: &'a [L::Ids],
    /// Blocks with points of the group's own.
    pub(crate) n_own: usize,
}

impl<L: Lanes, const D: usize> Candidates<'_, L, D> {
    /// Appends what is listed under a point of the group to `out` from `filled` on; returns where it ends. Which candidates
    /// of a block may be listed is asked of `others(first)`, and who of a mask is, of `close(first, mask)`.
    #[inline(always)]
    pub(crate) fn row<S: Sight>(
        &self,
        lanes: L,
        (x_i, bounds): ([f32; D], [f32; 2]),
        sight: S,
        others: impl Fn(usize) -> u32,
        close: impl Fn(usize, u32) -> u32,
        (out, mut filled): (&mut [u32], usize),
    ) -> usize {
        let mut x = [lanes.splat(0.0); D];
        for axis in 0..D {
            x[axis] = lanes.splat(x_i[axis]);
        }
        let bounds = [lanes.splat(bounds[0]), lanes.splat(bounds[1])];
        for block in 0..self.n_own {
            let [certain, possible] = self.within(lanes, block, &x, bounds, sight);
            let others = others(block * L::N);
            let (mut listed, unsure) = (certain & others, (possible ^ certain) & others);
            if unsure != 0 {
                listed |= close(block * L::N, unsure);
            }
            filled += lanes.compress(listed, &self.entries[block], out, filled);
        }
        for block in self.n_own..self.entries.len() {
            let [certain, possible] = self.within(lanes, block, &x, bounds, sight);
            let mut listed = certain;
            if certain != possible {
                listed |= close(block * L::N, possible ^ certain);
            }
            filled += lanes.compress(listed, &self.entries[block], out, filled);
        }
        filled
    }

    /// Masks of the candidates of a block that are surely within reach of `x_i`, and of those that may be.
    #[inline(always)]
    fn within<S: Sight>(
        &self,
        lanes: L,
        block: usize,
        x_i: &[L::Vector; D],
        [lower, upper]: [L::Vector; 2],
        sight: S,
    ) -> [u32; 2] {
        let along = lanes.sub(x_i[0], lanes.load(&self.columns[0][block]));
        let mut d2 = lanes.mul(along, along);
        for axis in 1..D {
            let along = lanes.sub(x_i[axis], lanes.load(&self.columns[axis][block]));
            d2 = lanes.mul_add(along, along, d2);
        }
        let (mut lower, mut upper) = (lower, upper);
        if S::THEIRS {
            lower = sight.of(lanes, lower, lanes.load(&self.lower[block]));
            upper = sight.of(lanes, upper, lanes.load(&self.upper[block]));
        }
        [lanes.below(d2, lanes.mul(lower, lower)), lanes.below(d2, lanes.mul(upper, upper))]
    }
}
