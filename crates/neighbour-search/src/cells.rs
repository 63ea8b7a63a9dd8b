//! Points sorted into the cells of a regular grid.

use crate::search::stored;
use crate::simd::LANES;

/// Cells allowed for each point, and a few for small clouds: what bounds the memory whatever the cloud.
const CELLS_PER_POINT: usize = 2;
const SPARE_CELLS: usize = 64;

/// Of a cloud with outliers, this part is left out at either end of an axis before the grid is laid.
const TRIMMED_PART: usize = 64;

/// Relative slack on a radius when cells are chosen: covers the roundings of the squared distance and its sum, below
/// `(D + 2)` units of 1.1e-16 each.
const SLACK: f64 = 1.0 + 1e-14;

/// A regular grid over a cloud, and the points in the order of its cells, those of a cell in their own order.
///
/// The cell of a coordinate, `floor((x - origin) / width)` held to the grid, is a monotone function of `x` in floating
/// point too. So whatever box the grid covers, points between two coordinates lie between their cells: points outside the
/// box are in the outermost cells, and the search stays exact.
#[derive(Debug, Clone)]
pub(crate) struct Cells<const D: usize> {
    /// How wide the cells were asked to be.
    edge: f64,
    origin: [f64; D],
    inverse_width: [f64; D],
    count: [usize; D],
    /// Points of cell `c` are `start[c]..start[c + 1]` in `points` and `ids`.
    start: Vec<u32>,
    /// Cell of each point, by its index.
    cell_of: Vec<u32>,
    /// Point of each slot, and `LANES` more of no account, so that eight can be read from any slot.
    ids: Vec<u32>,
    /// Coordinates of each slot, axis by axis, padded alike.
    columns: [Vec<f64>; D],
    sample: Vec<f64>,
}

impl<const D: usize> Default for Cells<D> {
    fn default() -> Self {
        Self {
            edge: 1.0,
            origin: [0.0; D],
            inverse_width: [0.0; D],
            count: [1; D],
            start: Vec::new(),
            cell_of: Vec::new(),
            ids: Vec::new(),
            columns: [const { Vec::new() }; D],
            sample: Vec::new(),
        }
    }
}

impl<const D: usize> Cells<D> {
    /// Indices of the points in the order of the cells, and padding.
    pub(crate) fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// Coordinates in the order of the cells along each axis, and padding.
    #[inline(always)]
    pub(crate) fn columns(&self) -> [&[f64]; D] {
        core::array::from_fn(|axis| self.columns[axis].as_slice())
    }

    /// How wide the cells were asked to be; they may be wider.
    pub(crate) fn edge(&self) -> f64 {
        self.edge
    }

    /// Number of points.
    pub(crate) fn n_points(&self) -> usize {
        self.cell_of.len()
    }

    /// Writes one value of each point in the order of the cells, and padding.
    pub(crate) fn gather(&self, values: &[f64], column: &mut Vec<f64>) {
        column.clear();
        column.extend(self.ids[..self.n_points()].iter().map(|&id| values[id as usize]));
        column.resize(self.ids.len(), 0.0);
    }

    /// Median of the radii: half of the points see farther than a cell.
    pub(crate) fn median(&mut self, values: &[f64]) -> f64 {
        self.sample.clear();
        self.sample.extend_from_slice(values);
        if self.sample.is_empty() {
            return 1.0;
        }
        let middle = self.sample.len() / 2;
        *self.sample.select_nth_unstable_by(middle, f64::total_cmp).1
    }

    /// Lays a grid of cells about `edge` wide and sorts the points into it. O(n) in time and memory.
    pub(crate) fn build(&mut self, points: &[[f64; D]], edge: f64) {
        self.edge = edge;
        self.lay(points, edge);
        let n_cells: usize = self.count.iter().product();
        self.start.clear();
        self.start.resize(n_cells + 1, 0);
        let mut cell_of = core::mem::take(&mut self.cell_of);
        cell_of.clear();
        cell_of.extend(points.iter().map(|x| stored(self.cell(x))));
        // Shifted by one, so that what is the cursor of a cell while placing is its end afterwards.
        let cursors = &mut self.start[1..];
        for &cell in &cell_of {
            cursors[cell as usize] += 1;
        }
        let mut total = 0;
        for cursor in cursors.iter_mut() {
            total += core::mem::replace(cursor, total);
        }
        self.ids.clear();
        self.ids.resize(points.len() + LANES, 0);
        for (id, &cell) in cell_of.iter().enumerate() {
            let cursor = &mut cursors[cell as usize];
            self.ids[*cursor as usize] = stored(id);
            *cursor += 1;
        }
        for (axis, column) in self.columns.iter_mut().enumerate() {
            column.clear();
            let slots = self.ids[..points.len()].iter();
            column.extend(slots.map(|&id| points[id as usize][axis]));
            column.resize(points.len() + LANES, 0.0);
        }
        self.cell_of = cell_of;
    }

    /// Hands `visit` every range of slots whose cells a ball touches: one range for each row of cells along the first axis.
    #[inline(always)]
    pub(crate) fn for_each_range(
        &self,
        centre: &[f64; D],
        radius: f64,
        mut visit: impl FnMut(core::ops::Range<usize>),
    ) {
        let reach = radius * SLACK;
        let low: [usize; D] = core::array::from_fn(|a| self.along(centre[a] - reach, a));
        let high: [usize; D] = core::array::from_fn(|a| self.along(centre[a] + reach, a));
        let mut row = low;
        loop {
            let first = self.index(&row);
            let last = first + (high[0] - low[0]);
            visit(self.start[first] as usize..self.start[last + 1] as usize);
            // The next row: the second axis turns fastest.
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

    fn cell(&self, x: &[f64; D]) -> usize {
        self.index(&core::array::from_fn(|axis| self.along(x[axis], axis)))
    }

    /// Number of a cell; the first axis turns fastest.
    #[inline(always)]
    fn index(&self, cell: &[usize; D]) -> usize {
        (0..D).rev().fold(0, |index, axis| index * self.count[axis] + cell[axis])
    }

    /// Cell of a coordinate along an axis, held to the grid.
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

    /// Chooses box and cells: the whole cloud if that takes few enough cells, else the box without outliers, else wider
    /// cells.
    fn lay(&mut self, points: &[[f64; D]], edge: f64) {
        let allowed = points.len().saturating_mul(CELLS_PER_POINT).saturating_add(SPARE_CELLS);
        let allowed = allowed.min(u32::MAX as usize) as f64;
        let mut bounds = bounding_box(points);
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
            // A single cell needs no width, and the cloud may have none along this axis.
            self.inverse_width[axis] = if count > 1 { cells[axis] / (high - low) } else { 0.0 };
        }
    }

    /// Bounds along an axis without the outermost points, widened by half of what is left at either end.
    fn trimmed(&mut self, points: &[[f64; D]], axis: usize, [low, high]: [f64; 2]) -> [f64; 2] {
        let n = points.len();
        let cut = n / TRIMMED_PART;
        self.sample.clear();
        self.sample.extend(points.iter().map(|x| x[axis]));
        let first = *self.sample.select_nth_unstable_by(cut, f64::total_cmp).1;
        let last = *self.sample.select_nth_unstable_by(n - 1 - cut, f64::total_cmp).1;
        let margin = 0.5 * (last - first);
        [low.max(first - margin), high.min(last + margin)]
    }
}

/// Lowest and highest coordinate along each axis.
fn bounding_box<const D: usize>(points: &[[f64; D]]) -> [[f64; 2]; D] {
    let Some(first) = points.first() else { return [[0.0; 2]; D] };
    let mut bounds = first.map(|value| [value; 2]);
    for x in points {
        for (bounds, &value) in bounds.iter_mut().zip(x) {
            *bounds = [bounds[0].min(value), bounds[1].max(value)];
        }
    }
    bounds
}

/// Whole cells of at least `edge` along each axis: one at least, and no more along any axis than allowed in all.
fn cells_across<const D: usize>(bounds: &[[f64; 2]; D], edge: f64, allowed: f64) -> [f64; D] {
    bounds.map(|[low, high]| ((high - low) / edge).clamp(1.0, allowed).floor())
}

/// Widens the cells along the axes that have several until they are no more than allowed.
fn coarsen<const D: usize>(cells: &mut [f64; D], allowed: f64) {
    loop {
        let product: f64 = cells.iter().product();
        if product <= allowed {
            return;
        }
        let divided = cells.iter().filter(|&&count| count > 1.0).count();
        let factor = (product / allowed).powf(1.0 / divided as f64);
        for count in cells.iter_mut() {
            // The slack keeps a factor next to one from leaving every count as it is.
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
            cells.build(&points, 1.0);
            let n_cells: usize = cells.count.iter().product();
            assert!(n_cells <= 1001 * CELLS_PER_POINT + SPARE_CELLS, "{n_cells} cells");
            // The cloud itself stays divided: 18 cells across at most, 9 of them on the cloud.
            assert!(cells.count.iter().all(|&count| count >= 9), "{:?}", cells.count);
        }
    }

    #[test]
    fn sorting_is_stable_and_keeps_every_point() {
        let points = [[2.5], [0.5], [2.6], [0.4], [1.5]];
        let mut cells = Cells::default();
        cells.build(&points, 0.7);
        assert_eq!(cells.ids()[..cells.n_points()], [1, 3, 4, 0, 2]);
        assert_eq!(cells.columns()[0][2].to_bits(), 1.5_f64.to_bits());
    }

    #[test]
    fn ranges_of_a_ball_hold_every_point_in_it() {
        let points: Vec<[f64; 2]> =
            (0..100).map(|k| [f64::from(k % 10), f64::from(k / 10)]).collect();
        let mut cells = Cells::default();
        cells.build(&points, 1.0);
        let [x, y] = cells.columns();
        let mut found = 0;
        cells.for_each_range(&[4.0, 5.0], 2.0, |range| {
            let inside = |&k: &usize| (x[k] - 4.0).powi(2) + (y[k] - 5.0).powi(2) <= 4.0;
            found += range.filter(inside).count();
        });
        // Integer points within 2 of one of them: 1 + 4 + 4 + 4.
        assert_eq!(found, 13);
    }
}
