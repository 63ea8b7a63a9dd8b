//! The neighbour list, and the visitor that hands out its pairs.

use crate::error::Error;
use crate::search::{difference, squared_distance, stored};

/// A point and one of its neighbours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair<const D: usize> {
    /// The point.
    pub i: usize,
    /// Its neighbour.
    pub j: usize,
    /// `x_i - x_j`, unit of length of the points.
    pub x_ij: [f64; D],
    /// `|x_ij|`.
    pub r: f64,
}

/// Neighbours of every point in compressed rows: 32-bit indices, one row per point, sorted.
///
/// Memory: 4 bytes per listed neighbour and 8 per point. A pair that is mutual is listed twice, once in either row.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct NeighbourList {
    /// Row `i` is `indices[offsets[i]..offsets[i + 1]]`; empty before the first build.
    offsets: Vec<usize>,
    indices: Vec<u32>,
}

impl NeighbourList {
    /// A list of no points.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there are no points. A list of points without neighbours is not empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of listed neighbours, over all points.
    #[must_use]
    pub fn n_pairs(&self) -> usize {
        self.indices.len()
    }

    /// Neighbours of point `i`, ascending, without `i` itself.
    ///
    /// # Panics
    ///
    /// If `i >= len()`, as a slice does.
    #[inline]
    #[must_use]
    pub fn of(&self, i: usize) -> &[u32] {
        &self.indices[self.offsets[i]..self.offsets[i + 1]]
    }

    /// All rows, in order of the points.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.offsets.windows(2).map(|ends| &self.indices[ends[0]..ends[1]])
    }

    /// Fewest neighbours of any point; 0 for a list of no points.
    #[must_use]
    pub fn min_count(&self) -> usize {
        self.rows().map(<[u32]>::len).min().unwrap_or(0)
    }

    /// Neighbours per point on average; 0 for a list of no points.
    #[must_use]
    pub fn mean_count(&self) -> f64 {
        if self.is_empty() { 0.0 } else { self.n_pairs() as f64 / self.len() as f64 }
    }

    /// Most neighbours of any point; 0 for a list of no points.
    #[must_use]
    pub fn max_count(&self) -> usize {
        self.rows().map(<[u32]>::len).max().unwrap_or(0)
    }

    /// Visits every listed pair, rows in order and neighbours ascending.
    ///
    /// The points may have moved since the list was built: distances are those of the points given here.
    ///
    /// # Errors
    ///
    /// [`Error::ListLength`] if there are not as many points as rows.
    #[inline]
    pub fn for_each_pair<const D: usize>(
        &self,
        points: &[[f64; D]],
        mut visit: impl FnMut(Pair<D>),
    ) -> Result<(), Error> {
        self.check_length(points.len())?;
        for i in 0..self.len() {
            self.visit_row(i, points, &mut visit);
        }
        Ok(())
    }

    /// Visits the pairs of point `i`, neighbours ascending.
    ///
    /// # Errors
    ///
    /// [`Error::ListLength`] if there are not as many points as rows.
    ///
    /// # Panics
    ///
    /// If `i >= len()`, as a slice does.
    #[inline]
    pub fn for_each_pair_of<const D: usize>(
        &self,
        i: usize,
        points: &[[f64; D]],
        mut visit: impl FnMut(Pair<D>),
    ) -> Result<(), Error> {
        self.check_length(points.len())?;
        self.visit_row(i, points, &mut visit);
        Ok(())
    }

    #[inline]
    fn visit_row<const D: usize>(
        &self,
        i: usize,
        points: &[[f64; D]],
        visit: &mut impl FnMut(Pair<D>),
    ) {
        let x_i = points[i];
        for &j in self.of(i) {
            let j = j as usize;
            let x_j = &points[j];
            let r = squared_distance(&x_i, x_j).sqrt();
            visit(Pair { i, j, x_ij: difference(&x_i, x_j), r });
        }
    }

    fn check_length(&self, points: usize) -> Result<(), Error> {
        let listed = self.len();
        if listed == points { Ok(()) } else { Err(Error::ListLength { listed, points }) }
    }

    /// Empties the list, to be filled with [`end_row`](Self::end_row).
    pub(crate) fn restart(&mut self) {
        self.indices.clear();
        self.offsets.clear();
        self.offsets.push(0);
    }

    pub(crate) fn push(&mut self, j: usize) {
        self.indices.push(stored(j));
    }

    pub(crate) fn end_row(&mut self) {
        self.offsets.push(self.indices.len());
    }

    /// Transposes `n` rows: row `j` becomes the ascending list of all `i` whose `row(i)` holds `j`.
    ///
    /// However the given rows are ordered, those of the transpose are sorted: points are taken in order.
    pub(crate) fn transpose<'a>(&mut self, n: usize, row: impl Fn(usize) -> &'a [u32]) {
        self.place(n, row, |i, j| [[j, i]]);
    }

    /// Transposes `n` rows of which every entry is mutual, so that a row is as long as its transpose: sorts them.
    pub(crate) fn transpose_symmetric<'a>(&mut self, n: usize, row: impl Fn(usize) -> &'a [u32]) {
        self.offsets.clear();
        self.offsets.push(0);
        let mut total = 0;
        // Shifted by one, so that what is the cursor of row j while placing is its end afterwards.
        for i in 0..n {
            self.offsets.push(total);
            total += row(i).len();
        }
        self.indices.resize(total, 0);
        let cursors = &mut self.offsets[1..];
        for i in 0..n {
            for &j in row(i) {
                place_one(&mut self.indices, &mut cursors[j as usize], stored(i));
            }
        }
    }

    /// Lists each entry `j` of `row(i)` both ways, `j` under `i` and `i` under `j`; rows come out unsorted.
    pub(crate) fn mutual<'a>(&mut self, n: usize, row: impl Fn(usize) -> &'a [u32]) {
        self.place(n, row, |i, j| [[i, j], [j, i]]);
    }

    /// Lists each entry `j` of `row(i)` once, the smaller of both under the larger; rows come out unsorted.
    pub(crate) fn under_larger<'a>(&mut self, n: usize, row: impl Fn(usize) -> &'a [u32]) {
        self.place(n, row, |i, j| [[i.max(j), i.min(j)]]);
    }

    /// Keeps what comes after the point itself: of a symmetric list, each pair once.
    pub(crate) fn keep_later(&mut self) {
        let mut kept = 0;
        let mut begin = 0;
        for i in 0..self.len() {
            let end = self.offsets[i + 1];
            let first = begin + self.indices[begin..end].partition_point(|&j| j as usize <= i);
            self.indices.copy_within(first..end, kept);
            kept += end - first;
            self.offsets[i + 1] = kept;
            begin = end;
        }
        self.indices.truncate(kept);
    }

    /// Counting sort: of each entry `j` of `row(i)` come entries `[row, index]`, placed in the order of `i`.
    fn place<'a, const K: usize>(
        &mut self,
        n: usize,
        row: impl Fn(usize) -> &'a [u32],
        entries: impl Fn(u32, u32) -> [[u32; 2]; K],
    ) {
        self.offsets.clear();
        self.offsets.resize(n + 1, 0);
        // Shifted by one, so that what is the cursor of row j while placing is its end afterwards.
        let cursors = &mut self.offsets[1..];
        for i in 0..n {
            for &j in row(i) {
                for [row, _] in entries(stored(i), j) {
                    cursors[row as usize] += 1;
                }
            }
        }
        let mut total = 0;
        for cursor in cursors.iter_mut() {
            total += core::mem::replace(cursor, total);
        }
        self.indices.resize(total, 0);
        for i in 0..n {
            for &j in row(i) {
                for [row, index] in entries(stored(i), j) {
                    place_one(&mut self.indices, &mut cursors[row as usize], index);
                }
            }
        }
    }
}

#[inline]
fn place_one(indices: &mut [u32], cursor: &mut usize, index: u32) {
    indices[*cursor] = index;
    *cursor += 1;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transpose_sorts_rows_and_turns_them_over() {
        let rows: [&[u32]; 3] = [&[2, 1], &[2], &[1]];
        let mut list = NeighbourList::new();
        list.transpose(3, |i| rows[i]);
        assert_eq!(list.rows().collect::<Vec<_>>(), [&[][..], &[0, 2], &[0, 1]]);
    }

    #[test]
    fn mutual_lists_every_entry_in_both_rows() {
        let rows: [&[u32]; 3] = [&[2], &[0], &[]];
        let mut list = NeighbourList::new();
        list.mutual(3, |i| rows[i]);
        assert_eq!(list.rows().collect::<Vec<_>>(), [&[2, 1][..], &[0], &[0]]);
        assert_eq!((list.min_count(), list.max_count(), list.n_pairs()), (1, 2, 4));
        assert!((list.mean_count() - 4.0 / 3.0).abs() < f64::EPSILON);
    }

    #[test]
    fn list_of_no_points_counts_nothing() {
        let list = NeighbourList::new();
        assert!(list.is_empty());
        assert_eq!((list.min_count(), list.max_count(), list.n_pairs()), (0, 0, 0));
        assert!(list.mean_count().abs() == 0.0);
    }

    #[test]
    fn visitor_refuses_points_of_another_number() {
        let mut list = NeighbourList::new();
        list.transpose(2, |_| &[]);
        let refused = list.for_each_pair(&[[0.0]], |_| ());
        assert_eq!(refused, Err(Error::ListLength { listed: 2, points: 1 }));
    }
}
