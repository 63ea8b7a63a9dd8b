//! The neighbour list and its pair visitor.

use core::ops::Range;

use crate::domain::{Domain, square};
use crate::error::Error;
use crate::index::stored;
use crate::parallel::{self, Part};

/// Number of rows in one chunk of memory, written by one thread.
pub(crate) const CHUNK: usize = 1024;

/// Largest dimension of a search.
pub(crate) const MAX_DIMENSION: usize = 6;

/// A point and one of its neighbours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair<const D: usize> {
    /// The point.
    pub i: usize,
    /// Its neighbour.
    pub j: usize,
    /// `x_i - x_j` of the nearest images, unit of length of the points.
    pub x_ij: [f64; D],
    /// `|x_ij|`.
    pub r: f64,
}

/// Neighbours of every point in compressed rows: 32-bit indices, one row per point.
///
/// The search determines the order of entries in a row from points and radii; the number of threads does not affect
/// it. [`sort_rows`](Self::sort_rows) sorts each row in ascending order, which makes full lists of all searches equal.
///
/// Memory: 4 bytes per listed neighbour and 12 per point. Rows are stored in the order of the search, a thousand in a
/// chunk, so they are not moved after the search. A full list holds a mutual pair twice.
#[derive(Debug, Clone, Default)]
pub struct NeighbourList {
    /// Position of each point's row; empty if rows are in the order of the points.
    slot_of: Vec<u32>,
    /// End of each row in its chunk.
    ends: Vec<usize>,
    /// Entries of a thousand rows each; chunks are never freed, and contents beyond the last row are irrelevant.
    chunks: Vec<Vec<u32>>,
    /// Period along each axis, or zero.
    periods: [f64; MAX_DIMENSION],
}

impl PartialEq for NeighbourList {
    /// Whether rows hold the same entries in the same order, in the same space.
    fn eq(&self, other: &Self) -> bool {
        self.rows().eq(other.rows()) && self.periods == other.periods
    }
}

impl NeighbourList {
    /// A list without points.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there are no points. A list of points without neighbours is not empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of listed neighbours, over all points.
    #[must_use]
    pub fn n_pairs(&self) -> usize {
        self.ends.chunks(CHUNK).filter_map(<[usize]>::last).sum()
    }

    /// Neighbours of point `i`, without `i` itself.
    ///
    /// # Panics
    ///
    /// If `i >= len()`, as a slice does.
    #[inline]
    #[must_use]
    pub fn of(&self, i: usize) -> &[u32] {
        let slot = if self.slot_of.is_empty() { i } else { self.slot_of[i] as usize };
        &self.chunks[slot / CHUNK][row(&self.ends, slot)]
    }

    /// All rows, in order of the points.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.len()).map(|i| self.of(i))
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

    /// The list in compressed sparse rows: row `i` is `indices[offsets[i]..offsets[i + 1]]`.
    #[must_use]
    pub fn to_compressed_rows(&self) -> (Vec<usize>, Vec<u32>) {
        let mut offsets = Vec::with_capacity(self.len() + 1);
        let mut indices = Vec::with_capacity(self.n_pairs());
        offsets.push(0);
        for row in self.rows() {
            indices.extend_from_slice(row);
            offsets.push(indices.len());
        }
        (offsets, indices)
    }

    /// Sorts the entries of every row in ascending order.
    pub fn sort_rows(&mut self) {
        let mut nothing = vec![(); self.chunks.len()];
        self.for_each_part(&mut nothing, |Part { indices, ends, .. }| {
            for slot in 0..ends.len() {
                indices[row(ends, slot)].sort_unstable();
            }
        });
    }

    /// Visits every listed pair, rows in order of the points.
    ///
    /// The points may have moved since the build: distances are those of the points given here, in the space of the
    /// build.
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
        let domain = self.domain();
        for i in 0..self.len() {
            self.visit_row(i, &domain, points, &mut visit);
        }
        Ok(())
    }

    /// Visits the pairs of point `i`.
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
        self.visit_row(i, &self.domain(), points, &mut visit);
        Ok(())
    }

    #[inline]
    fn visit_row<const D: usize>(
        &self,
        i: usize,
        domain: &Domain<D>,
        points: &[[f64; D]],
        visit: &mut impl FnMut(Pair<D>),
    ) {
        let x_i = points[i];
        for &j in self.of(i) {
            let j = j as usize;
            let x_ij = domain.difference(&x_i, &points[j]);
            visit(Pair { i, j, x_ij, r: square(&x_ij).sqrt() });
        }
    }

    fn domain<const D: usize>(&self) -> Domain<D> {
        Domain::of(core::array::from_fn(|axis| {
            self.periods.get(axis).copied().filter(|&period| period > 0.0)
        }))
    }

    fn check_length(&self, points: usize) -> Result<(), Error> {
        let listed = self.len();
        if listed == points { Ok(()) } else { Err(Error::ListLength { listed, points }) }
    }

    /// Fills the list from a user-defined search: `row(i, found)` appends the neighbours of point `i`.
    ///
    /// # Errors
    ///
    /// [`Error::NotAPoint`] for an entry that is at least `n_points`. The list is then empty.
    pub fn fill<const D: usize>(
        &mut self,
        n_points: usize,
        domain: &Domain<D>,
        mut row: impl FnMut(usize, &mut Vec<u32>),
    ) -> Result<(), Error> {
        self.restart(n_points, domain, None);
        for (slot, end) in self.ends.iter_mut().enumerate() {
            let indices = &mut self.chunks[slot / CHUNK];
            if slot.is_multiple_of(CHUNK) {
                indices.clear();
            }
            let begin = indices.len();
            row(slot, indices);
            *end = indices.len();
            if let Some(&j) = indices[begin..].iter().find(|&&j| j as usize >= n_points) {
                self.ends.clear();
                return Err(Error::NotAPoint { i: slot, j, points: n_points });
            }
        }
        Ok(())
    }

    /// Reserves a number of rows, in the order of `ids` or of the points.
    pub(crate) fn restart<const D: usize>(
        &mut self,
        n_points: usize,
        domain: &Domain<D>,
        ids: Option<&[u32]>,
    ) {
        self.slot_of.clear();
        if let Some(ids) = ids {
            self.slot_of.resize(n_points, 0);
            for (slot, &id) in ids.iter().enumerate() {
                self.slot_of[id as usize] = stored(slot);
            }
        }
        self.ends.clear();
        self.ends.resize(n_points, 0);
        self.chunks.resize_with(n_points.div_ceil(CHUNK).max(self.chunks.len()), Vec::new);
        self.periods = [0.0; MAX_DIMENSION];
        for (period, of_axis) in self.periods.iter_mut().zip(domain.periods()) {
            *period = of_axis.unwrap_or(0.0);
        }
    }

    /// Calls `work` for every chunk of rows, with one `scratch` for each chunk.
    pub(crate) fn for_each_part<S: Send>(
        &mut self,
        scratch: &mut [S],
        work: impl Fn(Part<'_, S>) + Sync + Send,
    ) {
        parallel::for_each_part(&mut self.chunks, &mut self.ends, CHUNK, scratch, work);
    }

    /// Keeps the entries after their own point: each pair of a symmetric list once.
    pub(crate) fn keep_later(&mut self) {
        let Self { slot_of, ends, chunks, .. } = self;
        let mut id_of: Vec<u32> = (0..stored(ends.len())).collect();
        for (id, &slot) in slot_of.iter().enumerate() {
            id_of[slot as usize] = stored(id);
        }
        for ((indices, ends), ids) in
            chunks.iter_mut().zip(ends.chunks_mut(CHUNK)).zip(id_of.chunks(CHUNK))
        {
            let (mut begin, mut kept) = (0, 0);
            for (end, &id) in ends.iter_mut().zip(ids) {
                for at in begin..*end {
                    indices[kept] = indices[at];
                    kept += usize::from(indices[at] > id);
                }
                begin = core::mem::replace(end, kept);
            }
        }
    }
}

/// Entries of a row in its chunk.
#[inline]
fn row(ends: &[usize], slot: usize) -> Range<usize> {
    let begin = if slot.is_multiple_of(CHUNK) { 0 } else { ends[slot - 1] };
    begin..ends[slot]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(rows: &[&[u32]]) -> NeighbourList {
        let mut list = NeighbourList::new();
        let domain = Domain::<1>::unbounded();
        list.fill(rows.len(), &domain, |i, found| found.extend_from_slice(rows[i])).unwrap();
        list
    }

    #[test]
    fn rows_of_several_chunks_are_found_again() {
        let rows: Vec<Vec<u32>> = (0..3000).map(|i| (0..i % 5).collect()).collect();
        let rows: Vec<&[u32]> = rows.iter().map(Vec::as_slice).collect();
        let list = list(&rows);
        assert_eq!(list.rows().collect::<Vec<_>>(), rows);
        assert_eq!((list.min_count(), list.max_count(), list.n_pairs()), (0, 4, 6000));
        assert!((list.mean_count() - 2.0).abs() < f64::EPSILON);
        let (offsets, indices) = list.to_compressed_rows();
        assert_eq!((offsets.len(), offsets[3000], indices.len()), (3001, 6000, 6000));
        assert_eq!(indices[offsets[1999]..offsets[2000]], [0, 1, 2, 3]);
    }

    #[test]
    fn rows_are_found_where_the_search_put_them() {
        let mut list = NeighbourList::new();
        list.restart(3, &Domain::<2>::unbounded(), Some(&[2, 0, 1]));
        list.for_each_part(&mut [()], |Part { indices, ends, .. }| {
            indices.extend([1, 0, 2, 1]);
            ends.copy_from_slice(&[2, 3, 4]);
        });
        assert_eq!(list.rows().collect::<Vec<_>>(), [&[2][..], &[1], &[1, 0]]);
        list.sort_rows();
        assert_eq!(list.of(2), [0, 1]);
        list.keep_later();
        assert_eq!(list.rows().collect::<Vec<_>>(), [&[2][..], &[], &[]]);
    }

    #[test]
    fn entry_that_is_no_point_is_refused() {
        let mut list = NeighbourList::new();
        let refused = list.fill(2, &Domain::<1>::unbounded(), |i, found| found.push(1 + stored(i)));
        assert_eq!(refused, Err(Error::NotAPoint { i: 1, j: 2, points: 2 }));
        assert!(list.is_empty());
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
        let refused = list(&[&[], &[]]).for_each_pair(&[[0.0]], |_| ());
        assert_eq!(refused, Err(Error::ListLength { listed: 2, points: 1 }));
    }

    #[test]
    fn pairs_are_those_of_the_nearest_images() {
        let mut list = NeighbourList::new();
        let ring = Domain::periodic([Some(8.0)]).unwrap();
        list.fill(2, &ring, |i, found| found.push(1 - stored(i))).unwrap();
        let mut along = Vec::new();
        list.for_each_pair(&[[0.5], [7.0]], |pair| along.push(pair.x_ij[0])).unwrap();
        assert_eq!(along, [1.5, -1.5]);
    }
}
