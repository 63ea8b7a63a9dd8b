//! Candidates of a group of points, and the neighbours of each of its points.
//!
//! Points of one group (a cell, a leaf) have almost the same neighbourhood, so it is gathered once. The coordinates of
//! every candidate within reach of the group's box are stored contiguously in single precision. Then each point of the
//! group is compared with all of them, sixteen at a time.
//!
//! **Why the answer is exact in double precision.** Single precision rounds `u = (x - c)/R` to `û = u (1 + δ)`. Here
//! `|δ| <= 2^-24 (1 + 2^-20)` includes the few roundings in double precision, `c` is the centre of the cloud and `R`
//! its largest radius: the frame of [`Sorted`]. The group is within `G` of the centre, `|u_i| <= G`. A candidate at
//! distance `ρ` (in units of `R`) has `|u_j| <= G + ρ`. The error of the difference is `2^-24 (2G + ρ)`, that of the
//! subtraction `2^-24 ρ`. The relative error of the sum of `D` squares is `(D + 1) 2^-24`, half of which appears in
//! the distance. With a margin for second order the computed distance `ρ̂` satisfies
//!
//! ```text
//! |ρ̂ - ρ| <= 1.01 * 2^-24 (2G + (D + 5)/2 ρ),
//! ```
//!
//! With `a(ℓ) = 2^-22 (G + 2) + 2^-23 (D + 4) ℓ + 2^-60`, squares of bounds rounded too, `ρ̂² < (ℓ - a)²` proves
//! `ρ < ℓ`, and `ρ <= ℓ` proves `ρ̂² < (ℓ + a)²`. The formula of `NeighbourSearch` in double precision decides
//! candidates between both bounds: few, unless distances tie with the radius.
//!
//! The term `2^-60` covers underflow. A coordinate that overflows is infinitely far from every point of a group whose
//! own coordinates do not overflow. Images along periodic axes are displaced in single precision, which adds
//! `2^-22 L/R` to `a` for each period `L`.
//!
//! A group outside of the cloud's middle part, or with a radius for which `a` is not small, gets a frame of its own:
//! `c` is the centre of its box and `R` its own reach, and images are displaced in double precision. If the group is
//! wider than `2^20 R`, all of its pairs are decided in double precision; this occurs only in clouds thinner than
//! their cells.

use core::ops::Range;

use simd_lanes::{Lanes, MOST_LANES, Mask, Registers, Work};

use crate::aligned::Aligned;
use crate::candidates::{Candidates, Larger, Middle, Mine, Sight};
use crate::criterion::Criterion;
use crate::domain::square;
use crate::frame::{Bounds, Frame};
use crate::index::stored;
use crate::radii::Radii;
use crate::room::Room;
use crate::sorted::{Listed, Order, Rule, Sorted, Stretch};

/// Coordinate of padding: its square overflows to infinity, so every comparison rejects it.
const NOWHERE: f32 = 1e30;

/// Entries of the rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Entries {
    /// Indices of the points.
    Ids,
    /// Slots of the points.
    Slots,
}

/// Settings common to every group.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Question<'a, const D: usize> {
    pub(crate) points: &'a [[f64; D]],
    pub(crate) radii: Radii<'a>,
    pub(crate) listed: Listed,
    pub(crate) entries: Entries,
}

/// The candidates of one group.
#[derive(Debug, Clone)]
pub(crate) struct Neighbourhood<const D: usize> {
    /// Coordinates, padded with [`NOWHERE`].
    columns: [Aligned<f32>; D],
    /// Entry of each candidate.
    entries: Aligned<u32>,
    /// Bounds on the radius of each candidate, where the criterion uses them.
    lower: Aligned<f32>,
    upper: Aligned<f32>,
    /// The stretch that each candidate comes from, where it is needed.
    from: Aligned<u32>,
    stretches: Vec<Stretch<D>>,
    /// Number of stretches with points of the group itself, and of these points.
    own_stretches: usize,
    n_own: usize,
    len: usize,
}

impl<const D: usize> Default for Neighbourhood<D> {
    fn default() -> Self {
        Self {
            columns: core::array::from_fn(|_| Aligned::default()),
            entries: Aligned::default(),
            lower: Aligned::default(),
            upper: Aligned::default(),
            from: Aligned::default(),
            stretches: Vec::new(),
            own_stretches: 0,
            n_own: 0,
            len: 0,
        }
    }
}

impl<const D: usize> Neighbourhood<D> {
    /// Reserves memory for the largest possible number of candidates.
    fn grow(&mut self) {
        let slots: usize = self.stretches.iter().map(|stretch| stretch.slots.len()).sum();
        let needed = slots + 2 * MOST_LANES;
        if self.entries.len() < needed {
            let room = needed.next_power_of_two();
            for column in self.columns.iter_mut().chain([&mut self.lower, &mut self.upper]) {
                column.grow(room);
            }
            for column in [&mut self.entries, &mut self.from] {
                column.grow(room);
            }
        }
    }

    /// Finds the candidates of the group `targets`: its own points, their images, and all other points near it.
    fn choose(
        &mut self,
        order: &dyn Order<D>,
        targets: &Range<usize>,
        bounds: &Bounds<D>,
        question: &Question<'_, D>,
    ) {
        self.stretches.clear();
        let rule = Rule::of(question.radii);
        self.own_stretches =
            order.stretches(targets, bounds, rule, question.listed, &mut self.stretches);
        self.grow();
    }

    /// Gathers the candidates of the group `targets`; returns their frame.
    #[inline(always)]
    fn gather<R: Registers<f32>, S: Sight>(
        &mut self,
        registers: R,
        order: &dyn Order<D>,
        targets: &Range<usize>,
        question: &Question<'_, D>,
        sight: S,
    ) -> Frame<D> {
        let sorted = order.sorted();
        let narrow = sorted.narrow_bounds(targets.clone());
        let is_covered = sorted.frame.covers(&narrow);
        let bounds =
            if is_covered { sorted.widened(narrow) } else { exact_bounds(sorted, targets) };
        self.choose(order, targets, &bounds, question);
        let rule = Rule::of(question.radii);
        let typical = rule.limit(bounds.radius, bounds.radius);
        let frame = if is_covered && sorted.frame.resolves(typical) {
            self.select(registers, sorted, &narrow, question, sight);
            sorted.frame
        } else {
            self.place_anew(sorted, &bounds, question)
        };
        let own = &self.stretches[..self.own_stretches];
        self.n_own = own.iter().map(|stretch| stretch.slots.len()).sum();
        for column in &mut self.columns {
            column[self.len..self.len + MOST_LANES].fill(NOWHERE);
        }
        frame
    }

    /// Takes the group's own points, and of the others those within reach of its box.
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "covered by the bounds of the frame")]
    fn select<R: Registers<f32>, S: Sight>(
        &mut self,
        registers: R,
        sorted: &Sorted<D>,
        (low, high, radius): &([f32; D], [f32; D], f64),
        question: &Question<'_, D>,
        sight: S,
    ) {
        let columns: [&[f32]; D] = core::array::from_fn(|axis| sorted.columns[axis].as_slice());
        let ids = match question.entries {
            Entries::Ids => sorted.ids.as_slice(),
            Entries::Slots => sorted.slots.as_slice(),
        };
        let (mut lows, mut highs) = ([registers.splat(0.0); D], [registers.splat(0.0); D]);
        for axis in 0..D {
            (lows[axis], highs[axis]) = (registers.splat(low[axis]), registers.splat(high[axis]));
        }
        let zero = registers.splat(0.0);
        let mine = registers.splat(sorted.frame.reach(Rule::of(question.radii).mine(*radius)));
        let is_periodic = sorted.domain.is_periodic();
        let Self { columns: placed, entries, lower: lowers, upper: uppers, from, .. } = self;
        let placed: [&mut [f32]; D] = placed.each_mut().map(|column| &mut **column);
        let (entries, from): (&mut [u32], &mut [u32]) = (entries, from);
        let (lowers, uppers): (&mut [f32], &mut [f32]) = (lowers, uppers);
        let mut len = 0;
        for (k, stretch) in self.stretches.iter().enumerate() {
            let Stretch { slots: Range { start, end }, shift } = stretch;
            let (is_own, end) = (k < self.own_stretches, *end);
            let mut at = *start;
            while at < end {
                let (mut x, mut apart) = (lows, zero);
                for axis in 0..D {
                    x[axis] = registers.load_at(columns[axis], at);
                    if is_periodic {
                        let shift = (shift[axis] * sorted.frame.scale) as f32;
                        x[axis] = x[axis] + registers.splat(shift);
                    }
                    let (below, above) = (lows[axis] - x[axis], x[axis] - highs[axis]);
                    let gap = below.max(above).max(zero);
                    apart = registers.mul_add(gap, gap, apart);
                }
                let mut limit = mine;
                if S::THEIRS {
                    limit = sight.of(mine, registers.load_at(&sorted.upper, at));
                }
                let within = apart.less(limit * limit).bits();
                let within = if is_own { u32::MAX } else { within };
                let in_stretch = first_bits((end - at).min(R::N));
                let mask = within & in_stretch;
                for axis in 0..D {
                    registers.compress(mask, x[axis], placed[axis], len);
                }
                if S::THEIRS {
                    let lower = registers.load_at(&sorted.lower, at);
                    registers.compress(mask, lower, lowers, len);
                    let upper = registers.load_at(&sorted.upper, at);
                    registers.compress(mask, upper, uppers, len);
                }
                if is_periodic {
                    from[len..len + MOST_LANES].fill(stored(k));
                }
                len += registers.compress_indices(mask, R::indices_at(ids, at), entries, len);
                at += R::N;
            }
        }
        self.len = len;
    }

    /// Takes all candidates and converts them to a frame of the group's own.
    #[cold]
    #[inline(never)]
    fn place_anew(
        &mut self,
        sorted: &Sorted<D>,
        bounds: &Bounds<D>,
        question: &Question<'_, D>,
    ) -> Frame<D> {
        let reach = Rule::of(question.radii).limit(bounds.radius, sorted.largest);
        let frame = Frame::new(bounds, reach, &sorted.domain, 2.0_f64.powi(-50));
        let mut len = 0;
        for (k, Stretch { slots, shift }) in self.stretches.iter().enumerate() {
            let places = frame.places(shift);
            for slot in slots.clone() {
                for (axis, &x) in sorted.points[slot].iter().enumerate() {
                    // Where single precision decides nothing, all candidates count as close.
                    let is_known = frame.fixed.is_finite();
                    self.columns[axis][len] = if is_known { places[axis].of(x) } else { 0.0 };
                }
                if let Some(&radius) = sorted.radii.get(slot) {
                    [self.lower[len], self.upper[len]] = frame.bounds(radius);
                }
                self.entries[len] = match question.entries {
                    Entries::Ids => sorted.ids[slot],
                    Entries::Slots => stored(slot),
                };
                self.from[len] = stored(k);
                len += 1;
            }
        }
        self.len = len;
        frame
    }

    /// All candidates, block by block.
    #[inline(always)]
    fn candidates<R: Registers<f32>>(&self) -> Candidates<'_, R, D> {
        let padded = self.len.next_multiple_of(R::N);
        Candidates {
            columns: core::array::from_fn(|axis| R::blocks(&self.columns[axis][..padded])),
            lower: R::blocks(&self.lower[..padded]),
            upper: R::blocks(&self.upper[..padded]),
            entries: R::index_blocks(&self.entries[..padded]),
            n_own: self.n_own.div_ceil(R::N).min(padded / R::N),
        }
    }

    /// Candidates from `at` on that may be listed under the `k`-th point of the group.
    ///
    /// This excludes the point itself, and in a half list the earlier points of the group.
    #[inline(always)]
    fn others(&self, k: usize, listed: Listed, at: usize) -> u32 {
        match listed {
            Listed::Full => !bit(k.wrapping_sub(at)),
            Listed::Half if self.own_stretches == 1 => {
                // The point and all earlier points.
                if k < at { u32::MAX } else { !first_bits(k + 1 - at) }
            }
            Listed::Half => self.others_with_images(k, at),
        }
    }

    /// The same in a period so short that a group meets its own images.
    #[cold]
    #[inline(never)]
    fn others_with_images(&self, k: usize, at: usize) -> u32 {
        let target = self.stretches.first().map_or(0, |targets| targets.slots.start + k);
        let own = self.stretches[..self.own_stretches].iter();
        let slots = own.flat_map(|stretch| stretch.slots.clone()).skip(at).take(MOST_LANES);
        let listed = slots.enumerate().filter(|&(_, slot)| slot > target);
        let of_others = !first_bits(self.n_own.saturating_sub(at));
        listed.fold(of_others, |mask, (candidate, _)| mask | bit(candidate))
    }

    /// Mask of the candidates `at + k` that are within reach of the point in `slot`, in double precision.
    #[cold]
    #[inline(never)]
    fn decide(
        &self,
        sorted: &Sorted<D>,
        question: &Question<'_, D>,
        at: usize,
        slot: usize,
        mask: u32,
    ) -> u32 {
        let i = sorted.ids[slot] as usize;
        let x_i = sorted.points[slot];
        let mut hits = 0;
        for k in (0..u32::BITS).filter(|k| mask >> k & 1 == 1) {
            let candidate = at + k as usize;
            if candidate >= self.len {
                break;
            }
            let j = match question.entries {
                Entries::Ids => self.entries[candidate],
                Entries::Slots => sorted.ids[self.entries[candidate] as usize],
            } as usize;
            let limit = question.radii.limit(i, j);
            let x_ij = sorted.domain.difference(&question.points[i], &question.points[j]);
            // Of several images of one point, the nearest.
            let is_nearest = !sorted.domain.is_periodic() || {
                let shift = &self.stretches[self.from[candidate] as usize].shift;
                let x_j = sorted.domain.wrap_all(&question.points[j]);
                sorted.domain.is_image(&x_i, &x_j, shift, &x_ij)
            };
            hits |= u32::from(is_nearest && square(&x_ij) <= limit * limit) << k;
        }
        hits
    }
}

/// The box of a group, and the largest of its radii.
#[cold]
#[inline(never)]
fn exact_bounds<const D: usize>(sorted: &Sorted<D>, targets: &Range<usize>) -> Bounds<D> {
    let first = sorted.points[targets.start];
    let mut bounds = Bounds { low: first, high: first, radius: 0.0 };
    for slot in targets.clone() {
        for (axis, x) in sorted.points[slot].into_iter().enumerate() {
            bounds.low[axis] = bounds.low[axis].min(x);
            bounds.high[axis] = bounds.high[axis].max(x);
        }
        bounds.radius = sorted.radii.get(slot).map_or(0.0, |&radius| radius.max(bounds.radius));
    }
    bounds
}

/// A mask with one bit, or zero if there is no such bit.
#[inline(always)]
fn bit(k: usize) -> u32 {
    if k < 32 { 1 << k } else { 0 }
}

/// A mask of the lowest bits.
#[inline(always)]
fn first_bits(count: usize) -> u32 {
    if count >= 32 { u32::MAX } else { (1 << count) - 1 }
}

/// Builds the rows of some slots, group by group, contiguously in `memory`.
pub(crate) struct Scan<'a, const D: usize> {
    pub(crate) order: &'a dyn Order<D>,
    pub(crate) question: Question<'a, D>,
    pub(crate) slots: Range<usize>,
    pub(crate) neighbourhood: &'a mut Neighbourhood<D>,
    pub(crate) memory: &'a mut Vec<u32>,
    /// End of the row of each slot.
    pub(crate) ends: &'a mut [usize],
    /// What the rows of all scans may hold.
    pub(crate) room: &'a Room,
}

impl<const D: usize> Work<f32> for Scan<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<f32>>(self, registers: R) {
        match Rule::of(self.question.radii) {
            Rule::Uniform(_) | Rule::PerPoint(Criterion::Gather) => self.scan(registers, Mine),
            // A point with radius zero searches as far as the other points' radii.
            Rule::PerPoint(Criterion::Max | Criterion::Scatter) => self.scan(registers, Larger),
            Rule::PerPoint(Criterion::Mean) => self.scan(registers, Middle),
        }
    }
}

impl<const D: usize> Scan<'_, D> {
    #[inline(always)]
    fn scan<R: Registers<f32>, S: Sight>(self, registers: R, sight: S) {
        let Self { order, question, slots, neighbourhood, memory, ends, room } = self;
        let (rule, sorted) = (Rule::of(question.radii), order.sorted());
        let (mut filled, mut slot) = (0, slots.start);
        let mut group = if slots.is_empty() { 0 } else { order.group_of(slot) };
        while slot < slots.end && !room.is_exceeded() {
            let targets = slot..order.group_end(group).min(slots.end);
            group += 1;
            if targets.is_empty() {
                continue;
            }
            let frame = neighbourhood.gather(registers, order, &targets, &question, sight);
            let shared = frame.bounds(rule.mine(0.0));
            let candidates = neighbourhood.candidates::<R>();
            for (k, slot) in targets.clone().enumerate() {
                let needed = filled + neighbourhood.len + 2 * MOST_LANES;
                if memory.len() < needed {
                    if !room.takes(needed, needed - memory.len()) {
                        return;
                    }
                    memory.resize(needed, 0);
                }
                let own = sorted.radii.get(slot);
                let bounds = own.map_or(shared, |&radius| frame.bounds(rule.mine(radius)));
                let x_i = core::array::from_fn(|axis| neighbourhood.columns[axis][k]);
                let others = |first| neighbourhood.others(k, question.listed, first);
                let close =
                    |first, mask| neighbourhood.decide(sorted, &question, first, slot, mask);
                let out = (memory.as_mut_slice(), filled);
                filled = candidates.row(registers, (x_i, bounds), sight, others, close, out);
                ends[slot - slots.start] = filled;
            }
            slot = targets.end;
        }
    }
}
