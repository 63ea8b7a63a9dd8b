//! Sorting of points into the leaves of a balanced tree.

use core::ops::Range;

use crate::criterion::MIN_RADIUS;
use crate::domain::{Domain, square};
use crate::error::Error;
use crate::frame::Bounds;
use crate::index::stored;
use crate::parallel;
use crate::radii::Radii;
use crate::search::check;
use crate::sorted::{Listed, Near, Order, Rule, Sorted, Stretch, stretches};

/// Points per leaf: as many as are compared at a time.
const LEAF: usize = 16;

/// Number of points below which one thread builds a subtree.
const GRAIN: usize = 4096;

/// Levels of the largest tree: 2^28 leaves of 2^32 points, and one for the path to either side.
const DEEPEST: usize = 32;

/// Relative tolerance of coordinate comparisons: see [`Domain::reach`].
const SLACK: f64 = 1.0 + 1e-14;

#[derive(Debug, Clone, Copy)]
struct Item<const D: usize> {
    x: [f64; D],
    id: u32,
}

/// A tree that halves its points along the widest axis of their box, down to leaves of 16.
///
/// A node of `m` leaves is followed by its left subtree, of `m/2` leaves, and then by its right one, so the index of a
/// node determines its position. Every node stores the box of its points and the largest of their radii.
#[derive(Debug, Clone)]
pub(crate) struct Leaves<const D: usize> {
    sorted: Sorted<D>,
    nodes: Vec<Bounds<D>>,
    items: Vec<Item<D>>,
}

impl<const D: usize> Default for Leaves<D> {
    fn default() -> Self {
        Self::new(Domain::unbounded())
    }
}

impl<const D: usize> Leaves<D> {
    /// An empty tree in a space.
    pub(crate) fn new(domain: Domain<D>) -> Self {
        let sorted = Sorted { domain, ..Sorted::default() };
        Self { sorted, nodes: Vec::new(), items: Vec::new() }
    }

    /// Builds the tree. It takes O(n log n) in time, O(n) in memory.
    fn halve(&mut self, points: &[[f64; D]], radii: Radii<'_>) {
        let Self { sorted, nodes, items } = self;
        let nowhere = Item { x: [0.0; D], id: 0 };
        items.resize(points.len(), nowhere);
        parallel::fill(items, |i| Item { x: sorted.domain.wrap_all(&points[i]), id: stored(i) });
        let n_leaves = points.len().div_ceil(LEAF);
        let empty = Bounds { low: [0.0; D], high: [0.0; D], radius: 0.0 };
        nodes.resize((2 * n_leaves).saturating_sub(1), empty);
        if n_leaves > 0 {
            divide(items, nodes, radii);
        }
        sorted.ids.resize(points.len(), 0);
        parallel::fill(&mut sorted.ids, |slot| items[slot].id);
        sorted.gather(points, radii, nodes.first().unwrap_or(&empty));
    }

    /// The space.
    pub(crate) fn domain(&self) -> &Domain<D> {
        &self.sorted.domain
    }

    /// Point of each slot.
    pub(crate) fn ids(&self) -> &[u32] {
        self.sorted.order()
    }
}

/// Sorts items into leaves and fills the nodes, both for one subtree.
fn divide<const D: usize>(items: &mut [Item<D>], nodes: &mut [Bounds<D>], radii: Radii<'_>) {
    let bounds = bounds_of(items, radii);
    let n_leaves = items.len().div_ceil(LEAF);
    let (node, below) = nodes.split_first_mut().expect("a subtree has a node");
    *node = bounds;
    if n_leaves == 1 {
        return;
    }
    let width = |axis: &usize| bounds.high[*axis] - bounds.low[*axis];
    let widest = (0..D).max_by(|a, b| width(a).total_cmp(&width(b))).unwrap_or(0);
    let n_left = n_leaves / 2;
    items.select_nth_unstable_by(n_left * LEAF, |a, b| a.x[widest].total_cmp(&b.x[widest]));
    let (left, right) = items.split_at_mut(n_left * LEAF);
    let (nodes_left, nodes_right) = below.split_at_mut(2 * n_left - 1);
    if left.len() < GRAIN {
        divide(left, nodes_left, radii);
        divide(right, nodes_right, radii);
    } else {
        parallel::join(|| divide(left, nodes_left, radii), || divide(right, nodes_right, radii));
    }
}

fn bounds_of<const D: usize>(items: &[Item<D>], radii: Radii<'_>) -> Bounds<D> {
    let first = items.first().map_or([0.0; D], |item| item.x);
    let mut bounds = Bounds { low: first, high: first, radius: 0.0 };
    for item in items {
        for axis in 0..D {
            let x = item.x[axis];
            bounds.low[axis] = if x < bounds.low[axis] { x } else { bounds.low[axis] };
            bounds.high[axis] = if x > bounds.high[axis] { x } else { bounds.high[axis] };
        }
    }
    if let Radii::PerPoint { radii, .. } = radii {
        bounds.radius = items.iter().map(|item| radii[item.id as usize]).fold(0.0, f64::max);
    }
    bounds
}

impl<const D: usize> Order<D> for Leaves<D> {
    fn sorted(&self) -> &Sorted<D> {
        &self.sorted
    }

    #[inline(always)]
    fn group_of(&self, slot: usize) -> usize {
        slot / LEAF
    }

    #[inline(always)]
    fn group_end(&self, leaf: usize) -> usize {
        ((leaf + 1) * LEAF).min(self.sorted.n_points())
    }

    fn stretches(
        &self,
        targets: &Range<usize>,
        bounds: &Bounds<D>,
        rule: Rule,
        listed: Listed,
        found: &mut Vec<Stretch<D>>,
    ) -> usize {
        stretches(self, targets, bounds, rule, listed, found)
    }
}

impl<const D: usize> Near<D> for Leaves<D> {
    fn sort(&mut self, points: &[[f64; D]], radii: Radii<'_>) -> Result<(), Error> {
        check(points, radii, self.domain())?;
        self.halve(points, radii);
        Ok(())
    }

    fn build(&mut self, points: &[[f64; D]], edge: f64) -> Result<(), Error> {
        check(points, Radii::Uniform(MIN_RADIUS), self.domain())?;
        self.halve(points, Radii::Uniform(edge));
        Ok(())
    }

    #[inline(always)]
    fn for_each_stretch(
        &self,
        bounds: &Bounds<D>,
        rule: Rule,
        shift: &[f64; D],
        mut visit: impl FnMut(Range<usize>),
    ) {
        let n_points = self.sorted.n_points();
        let low: [f64; D] = core::array::from_fn(|axis| bounds.low[axis] - shift[axis]);
        let high: [f64; D] = core::array::from_fn(|axis| bounds.high[axis] - shift[axis]);
        let slack = self.sorted.domain.reach(0.0);
        // Node, first leaf and number of leaves still to be visited.
        let mut stack = [[0; 3]; DEEPEST];
        stack[0] = [0, 0, n_points.div_ceil(LEAF)];
        let mut height = usize::from(n_points > 0);
        let mut pending = 0..0;
        while height > 0 {
            height -= 1;
            let [at, first, n_leaves] = stack[height];
            let node = &self.nodes[at];
            let limit = rule.limit(bounds.radius, node.radius) * SLACK;
            let mut apart = 0.0;
            for axis in 0..D {
                let gap = (node.low[axis] - high[axis]).max(low[axis] - node.high[axis]);
                let gap = (gap - slack[axis]).max(0.0);
                apart += gap * gap;
            }
            if apart > limit * limit {
                continue;
            }
            if n_leaves == 1 {
                let slots = first * LEAF..((first + 1) * LEAF).min(n_points);
                if slots.start == pending.end {
                    pending.end = slots.end;
                } else {
                    visit(core::mem::replace(&mut pending, slots));
                }
            } else {
                let n_left = n_leaves / 2;
                stack[height] = [at + 2 * n_left, first + n_left, n_leaves - n_left];
                stack[height + 1] = [at + 1, first, n_left];
                height += 2;
            }
        }
        visit(pending);
    }

    /// Largest possible distance of a point in the smallest node around the position with enough points.
    fn radius_for(&self, place: &[f64; D], wanted: usize) -> f64 {
        let gap = |node: &Bounds<D>| {
            let along: [f64; D] = core::array::from_fn(|axis| {
                (node.low[axis] - place[axis]).max(place[axis] - node.high[axis]).max(0.0)
            });
            square(&along)
        };
        let (mut at, mut n_leaves) = (0, self.sorted.n_points().div_ceil(LEAF));
        // All leaves but the last hold 16 points.
        while n_leaves > 1 && (n_leaves / 2).saturating_sub(1) * LEAF >= wanted {
            let n_left = n_leaves / 2;
            let (left, right) = (at + 1, at + 2 * n_left);
            (at, n_leaves) = if gap(&self.nodes[left]) <= gap(&self.nodes[right]) {
                (left, n_left)
            } else {
                (right, n_leaves - n_left)
            };
        }
        let node = &self.nodes[at];
        let farthest: [f64; D] = core::array::from_fn(|axis| {
            (place[axis] - node.low[axis]).abs().max((node.high[axis] - place[axis]).abs())
        });
        (square(&farthest).sqrt() * SLACK).max(MIN_RADIUS)
    }
}
