//! Sorting of points into the cells of a regular grid.

use core::ops::Range;

use crate::criterion::MIN_RADIUS;
use crate::domain::Domain;
use crate::error::Error;
use crate::frame::Bounds;
use crate::index::stored;
use crate::parallel;
use crate::radii::Radii;
use crate::search::check;
use crate::sorted::{Listed, Near, Order, Rule, Sorted, Stretch, stretches};

/// Cells allowed per point, and a few for small clouds: bounds the memory for every cloud.
const CELLS_PER_POINT: usize = 2;
const SPARE_CELLS: usize = 64;

/// For a cloud with outliers, this fraction is excluded at either end of an axis before the grid is placed.
const TRIMMED_PART: usize = 64;

/// Maximum number of sorting threads: each reads all points.
const MAX_SLABS: usize = 16;

/// A regular grid over a cloud, with the points in cell order and in their original order within a cell.
///
/// The cell of a coordinate is `floor((x - origin) / width)` clamped to the grid, a monotone function of `x` also in
/// floating point. So for any grid box, the cells of points between two coordinates lie between the cells of those
/// coordinates. Points outside the box are in the outermost cells, and the search stays exact.
#[derive(Debug, Clone)]
pub(crate) struct Cells<const D: usize> {
    sorted: Sorted<D>,
    /// Requested cell width.
    edge: f64,
    origin: [f64; D],
    extent: [f64; D],
    inverse_width: [f64; D],
    count: [usize; D],
    /// Points of cell `c` are in the slots `start[c]..start[c + 1]`.
    start: Vec<u32>,
    /// Cell of each point, by its index.
    cell_of: Vec<u32>,
    sample: Vec<f64>,
}

impl<const D: usize> Default for Cells<D> {
    fn default() -> Self {
        Self {
            sorted: Sorted::default(),
            edge: 1.0,
            origin: [0.0; D],
            extent: [0.0; D],
            inverse_width: [0.0; D],
            count: [1; D],
            start: Vec::new(),
            cell_of: Vec::new(),
            sample: Vec::new(),
        }
    }
}

impl<const D: usize> Cells<D> {
    /// Empty cells in a space.
    pub(crate) fn new(domain: Domain<D>) -> Self {
        let mut cells = Self::default();
        cells.sorted.domain = domain;
        cells
    }

    /// The space.
    pub(crate) fn domain(&self) -> &Domain<D> {
        &self.sorted.domain
    }

    /// Point of each slot.
    pub(crate) fn ids(&self) -> &[u32] {
        self.sorted.order()
    }

    /// Median of the radii: half of the points have a radius larger than a cell.
    fn median(&mut self, values: &[f64]) -> f64 {
        self.sample.clear();
        self.sample.extend_from_slice(values);
        if self.sample.is_empty() {
            return 1.0;
        }
        let middle = self.sample.len() / 2;
        *self.sample.select_nth_unstable_by(middle, f64::total_cmp).1
    }

    /// Places a grid of cells about `edge` wide and sorts the points into it. It takes O(n) in time and memory.
    pub(crate) fn lay_and_place(&mut self, points: &[[f64; D]], radii: Radii<'_>, edge: f64) {
        self.edge = edge;
        self.lay(points, edge);
        let mut cell_of = core::mem::take(&mut self.cell_of);
        cell_of.resize(points.len(), 0);
        parallel::fill_from(&mut cell_of, points, |x| {
            stored(self.cell(&self.sorted.domain.wrap_all(x)))
        });
        self.count_and_place(&cell_of);
        self.cell_of = cell_of;
        let far = core::array::from_fn(|axis| self.origin[axis] + self.extent[axis]);
        let bounds = Bounds { low: self.origin, high: far, radius: 0.0 };
        self.sorted.gather(points, radii, &bounds);
    }

    /// Counting sort. Every thread owns a range of cells and reads all points to find those in its cells.
    fn count_and_place(&mut self, cell_of: &[u32]) {
        let n_cells: usize = self.count.iter().product();
        self.start.clear();
        self.start.resize(n_cells + 1, 0);
        self.sorted.ids.resize(cell_of.len(), 0);
        let slabs = parallel::threads().min(MAX_SLABS).min(n_cells);
        let first_of = |slab: usize| slab * n_cells / slabs;
        let mut lengths: [[usize; 2]; MAX_SLABS] =
            core::array::from_fn(|slab| [first_of(slab + 1).saturating_sub(first_of(slab)), 0]);
        // Shifted by one: the write position of a cell becomes its end.
        let cursors = &mut self.start[1..];
        parallel::for_each_pair_of_stretches(
            (&mut *cursors, &mut self.sorted.ids),
            &lengths[..slabs],
            &|slab, counts, _: &mut [u32]| {
                let first = first_of(slab);
                for &cell in cell_of {
                    if let Some(count) = counts.get_mut((cell as usize).wrapping_sub(first)) {
                        *count += 1;
                    }
                }
            },
        );
        let mut total = 0;
        for (slab, length) in lengths[..slabs].iter_mut().enumerate() {
            let before = total;
            for cursor in &mut cursors[first_of(slab)..first_of(slab + 1)] {
                total += core::mem::replace(cursor, total);
            }
            length[1] = (total - before) as usize;
        }
        parallel::for_each_pair_of_stretches(
            (cursors, &mut self.sorted.ids),
            &lengths[..slabs],
            &|slab, cursors, ids: &mut [u32]| {
                let first = first_of(slab);
                let first_slot = cursors.first().map_or(0, |&slot| slot as usize);
                for (id, &cell) in cell_of.iter().enumerate() {
                    if let Some(cursor) = cursors.get_mut((cell as usize).wrapping_sub(first)) {
                        ids[*cursor as usize - first_slot] = stored(id);
                        *cursor += 1;
                    }
                }
            },
        );
    }

    /// Calls `visit` with the slots of every row of cells along the first axis that a box intersects.
    #[inline(always)]
    pub(crate) fn for_each_row(
        &self,
        low: &[f64; D],
        high: &[f64; D],
        mut visit: impl FnMut(Range<usize>),
    ) {
        let low: [usize; D] = core::array::from_fn(|axis| self.along(low[axis], axis));
        let high: [usize; D] = core::array::from_fn(|axis| self.along(high[axis], axis));
        let mut row = low;
        loop {
            let first = self.index(&row);
            let last = first + (high[0] - low[0]);
            visit(self.start[first] as usize..self.start[last + 1] as usize);
            // The next row: the second axis is the fastest.
            let mut axis = 1;
            while axis < D && row[axis] == high[axis] {
                row[axis] = low[axis];
                axis += 1;
            }
            if axis >= D {
                return;
            }
            row[axis] += 1;
        }
    }

    #[inline(always)]
    fn cell(&self, x: &[f64; D]) -> usize {
        self.index(&core::array::from_fn(|axis| self.along(x[axis], axis)))
    }

    /// Index of a cell; the first axis is the fastest.
    #[inline(always)]
    fn index(&self, cell: &[usize; D]) -> usize {
        (0..D).rev().fold(0, |index, axis| index * self.count[axis] + cell[axis])
    }

    /// Cell of a coordinate along an axis, clamped to the grid.
    #[inline(always)]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates, as meant"
    )]
    fn along(&self, x: f64, axis: usize) -> usize {
        let cell = ((x - self.origin[axis]) * self.inverse_width[axis]) as usize;
        cell.min(self.count[axis] - 1)
    }

    /// Chooses box and cells.
    ///
    /// The box is the whole cloud if it needs few enough cells, else that without outliers; if necessary cells are
    /// wider.
    fn lay(&mut self, points: &[[f64; D]], edge: f64) {
        let allowed = points.len().saturating_mul(CELLS_PER_POINT).saturating_add(SPARE_CELLS);
        let allowed = allowed.min(u32::MAX as usize) as f64;
        let mut bounds = bounding_box(points, &self.sorted.domain);
        let mut cells = cells_across(&bounds, edge, allowed);
        if cells.iter().product::<f64>() > allowed {
            for (axis, bounds) in bounds.iter_mut().enumerate() {
                *bounds = self.trimmed(points, axis, *bounds);
            }
            cells = cells_across(&bounds, edge, allowed);
            coarsen(&mut cells, allowed);
        }
        for (axis, [low, high]) in bounds.into_iter().enumerate() {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "1..=allowed"
            )]
            let count = cells[axis] as usize;
            self.count[axis] = count;
            self.origin[axis] = low;
            self.extent[axis] = high - low;
            // A single cell needs no width, and the cloud may have zero extent along this axis.
            self.inverse_width[axis] = if count > 1 { cells[axis] / (high - low) } else { 0.0 };
        }
    }

    /// Bounds along an axis without the outermost points, extended by half of the remaining width at either end.
    fn trimmed(&mut self, points: &[[f64; D]], axis: usize, [low, high]: [f64; 2]) -> [f64; 2] {
        let n = points.len();
        let cut = n / TRIMMED_PART;
        self.sample.clear();
        let domain = &self.sorted.domain;
        self.sample.extend(points.iter().map(|x| domain.wrap(x[axis], axis)));
        let first = *self.sample.select_nth_unstable_by(cut, f64::total_cmp).1;
        let last = *self.sample.select_nth_unstable_by(n - 1 - cut, f64::total_cmp).1;
        let margin = 0.5 * (last - first);
        [low.max(first - margin), high.min(last + margin)]
    }
}

impl<const D: usize> Order<D> for Cells<D> {
    fn sorted(&self) -> &Sorted<D> {
        &self.sorted
    }

    #[inline(always)]
    fn group_of(&self, slot: usize) -> usize {
        self.cell_of[self.sorted.ids[slot] as usize] as usize
    }

    #[inline(always)]
    fn group_end(&self, cell: usize) -> usize {
        self.start[cell + 1] as usize
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

impl<const D: usize> Near<D> for Cells<D> {
    fn sort(&mut self, points: &[[f64; D]], radii: Radii<'_>) -> Result<(), Error> {
        check(points, radii, self.domain())?;
        let typical = match radii {
            Radii::Uniform(radius) => radius,
            Radii::PerPoint { radii, .. } => self.median(radii),
        };
        self.lay_and_place(points, radii, typical);
        Ok(())
    }

    fn build(&mut self, points: &[[f64; D]], edge: f64) -> Result<(), Error> {
        // Any edge is valid in a periodic space: only radii are compared with the periods.
        check(points, Radii::Uniform(MIN_RADIUS), self.domain())?;
        self.lay_and_place(points, Radii::Uniform(edge), edge);
        Ok(())
    }

    #[inline(always)]
    fn for_each_stretch(
        &self,
        bounds: &Bounds<D>,
        rule: Rule,
        shift: &[f64; D],
        visit: impl FnMut(Range<usize>),
    ) {
        let reach = self.sorted.domain.reach(rule.limit(bounds.radius, self.sorted.largest));
        let low = core::array::from_fn(|axis| bounds.low[axis] - shift[axis] - reach[axis]);
        let high = core::array::from_fn(|axis| bounds.high[axis] - shift[axis] + reach[axis]);
        self.for_each_row(&low, &high, visit);
    }

    fn radius_for(&self, _: &[f64; D], _: usize) -> f64 {
        self.edge
    }
}

/// Lowest and highest coordinate along each axis.
fn bounding_box<const D: usize>(points: &[[f64; D]], domain: &Domain<D>) -> [[f64; 2]; D] {
    let Some(first) = points.first() else { return [[0.0; 2]; D] };
    let mut bounds = domain.wrap_all(first).map(|value| [value; 2]);
    for x in points {
        for (bounds, value) in bounds.iter_mut().zip(domain.wrap_all(x)) {
            *bounds = [bounds[0].min(value), bounds[1].max(value)];
        }
    }
    bounds
}

/// Number of cells of at least `edge` along each axis: at least one, and along no axis more than the total allowed.
fn cells_across<const D: usize>(bounds: &[[f64; 2]; D], edge: f64, allowed: f64) -> [f64; D] {
    bounds.map(|[low, high]| ((high - low) / edge).clamp(1.0, allowed).floor())
}

/// Widens the cells along axes with several cells until their number is allowed.
fn coarsen<const D: usize>(cells: &mut [f64; D], allowed: f64) {
    loop {
        let product: f64 = cells.iter().product();
        if product <= allowed {
            return;
        }
        let divided = cells.iter().filter(|&&count| count > 1.0).count();
        let factor = (product / allowed).powf(1.0 / divided as f64);
        for count in cells.iter_mut() {
            // The tolerance prevents a factor near one from leaving every count unchanged.
            *count = (*count / (factor * 1.001)).floor().max(1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_bounded_by_points_whatever_the_outlier() {
        for far in [1e3, 1e12, 1e300] {
            let mut points: Vec<[f64; 3]> = Vec::new();
            for k in 0..1000 {
                points.push([f64::from(k % 10), f64::from(k / 10 % 10), f64::from(k / 100)]);
            }
            points.push([far; 3]);
            let mut cells = Cells::default();
            cells.lay_and_place(&points, Radii::Uniform(1.0), 1.0);
            let n_cells: usize = cells.count.iter().product();
            assert!(n_cells <= 1001 * CELLS_PER_POINT + SPARE_CELLS, "{n_cells} cells");
            // The cloud itself stays divided: at most 18 cells across, 9 of them in the cloud.
            assert!(cells.count.iter().all(|&count| count >= 9), "{:?}", cells.count);
        }
    }

    #[test]
    fn sorting_is_stable_and_keeps_every_point() {
        let points = [[2.5], [0.5], [2.6], [0.4], [1.5]];
        let mut cells = Cells::default();
        cells.lay_and_place(&points, Radii::Uniform(0.7), 0.7);
        assert_eq!(cells.ids(), [1, 3, 4, 0, 2]);
        // From the middle, in units of 0.7.
        let expected: [f64; 5] = [-1.0, -1.1, 0.0, 1.0, 1.1].map(|x| x / 0.7);
        let found = &cells.sorted.columns[0];
        assert!(
            found.iter().zip(expected).all(|(&a, b)| (f64::from(a) - b).abs() < 1e-6),
            "{found:?}"
        );
    }

    #[test]
    fn ranges_of_a_ball_hold_every_point_in_it() {
        let points: Vec<[f64; 2]> =
            (0..100).map(|k| [f64::from(k % 10), f64::from(k / 10)]).collect();
        let mut cells = Cells::default();
        cells.lay_and_place(&points, Radii::Uniform(1.0), 1.0);
        let mut found = 0;
        cells.for_each_row(&[2.0, 3.0], &[6.0, 7.0], |slots| {
            let inside = |&slot: &usize| {
                let [x, y] = points[cells.sorted.ids[slot] as usize];
                (x - 4.0).powi(2) + (y - 5.0).powi(2) <= 4.0
            };
            found += slots.filter(inside).count();
        });
        // Integer points within 2 of one of them: 1 + 4 + 4 + 4.
        assert_eq!(found, 13);
    }
}
