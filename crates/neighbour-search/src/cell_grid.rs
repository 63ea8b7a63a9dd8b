//! Neighbours from a grid of cells.

use crate::cells::Cells;
use crate::error::Error;
use crate::list::NeighbourList;
use crate::radii::{Criterion, Radii, mean};
use crate::search::{NeighbourSearch, check, squared_distance};

/// Width of a cell in radii.
const EDGE: f64 = 1.0;

/// Points in the cells of a regular grid, found through the cells that a point's own ball touches.
///
/// Points are sorted into cells by counting, first axis fastest, so that a row of cells is one stretch of memory. Cells
/// are as wide as the radius, the median radius where each point has its own. There are never more than a few cells per
/// point, whatever the cloud: outliers go to the outermost cells, and a cloud too thin for its radius gets wider ones.
///
/// Radii of one point may differ from another's by orders of magnitude: each scans its own ball. `Max` and `Mean` are
/// found by the point with the larger radius and listed both ways, so nobody scans with the largest radius of all.
/// Rows are sorted by transposing them, which takes points in order, and not by comparing.
///
/// Time: O(n + candidates), where the candidates are the points in the cells touched, about 9/π (2-D) and 6.4 (3-D)
/// times the neighbours in a uniform cloud. Memory: 4 bytes for each listed neighbour beside the list itself (8 for
/// `Gather`, `Max` and `Mean`), and about 50 bytes per point. In five and six dimensions, and where a few cells
/// hold most points, it tends towards brute force.
#[derive(Debug, Clone)]
pub struct CellGrid<const D: usize> {
    cells: Cells<D>,
    found: Found,
    scratch: NeighbourList,
}

impl<const D: usize> Default for CellGrid<D> {
    fn default() -> Self {
        Self { cells: Cells::default(), found: Found::default(), scratch: NeighbourList::new() }
    }
}

impl<const D: usize> CellGrid<D> {
    /// A grid that has seen no points; its first build allocates.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }
}

impl<const D: usize> NeighbourSearch<D> for CellGrid<D> {
    fn full_list(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        list: &mut NeighbourList,
    ) -> Result<(), Error> {
        check(points, radii)?;
        let n = points.len();
        let typical = match radii {
            Radii::Uniform(radius) => radius,
            Radii::PerPoint { radii, .. } => self.cells.median(radii),
        };
        self.cells.build(points, EDGE * typical);
        let Self { cells, found, scratch } = self;
        let (radii, criterion) = match radii {
            Radii::Uniform(radius) => {
                found.scan(cells, |_| radius, gathers);
                list.transpose(n, |i| found.row(i));
                return Ok(());
            }
            Radii::PerPoint { radii, criterion } => (radii, criterion),
        };
        let radius = |i: u32| radii[i as usize];
        match criterion {
            Criterion::Gather => {
                found.scan(cells, radius, gathers);
                scratch.transpose(n, |i| found.row(i));
            }
            Criterion::Scatter => {
                found.scan(cells, radius, gathers);
                list.transpose(n, |i| found.row(i));
                return Ok(());
            }
            Criterion::Max => {
                found.scan(cells, radius, |i, h_i, j, d2| {
                    d2 <= h_i * h_i && sees_farther(i, h_i, j, radius(j))
                });
                scratch.mutual(n, |i| found.row(i));
            }
            Criterion::Mean => {
                found.scan(cells, radius, |i, h_i, j, d2| {
                    let limit = mean(h_i, radius(j));
                    d2 <= limit * limit && sees_farther(i, h_i, j, radius(j))
                });
                scratch.mutual(n, |i| found.row(i));
            }
        }
        list.transpose(n, |i| scratch.of(i));
        Ok(())
    }
}

/// Whether `i` sees `j` with its own radius.
#[inline]
fn gathers(i: u32, h_i: f64, j: u32, d2: f64) -> bool {
    i != j && d2 <= h_i * h_i
}

/// Which of a pair finds it: the one that sees farther, and of two alike the one with the larger index.
#[inline]
fn sees_farther(i: u32, h_i: f64, j: u32, h_j: f64) -> bool {
    h_j < h_i || (h_j <= h_i && j < i)
}

/// What the scan found: rows in the order of the cells, unsorted.
#[derive(Debug, Clone, Default)]
struct Found {
    /// As long as it ever was; what is beyond the rows is of no account.
    indices: Vec<u32>,
    /// Where the row of each point begins and ends, by its index.
    ends: Vec<[usize; 2]>,
}

impl Found {
    #[inline]
    fn row(&self, i: usize) -> &[u32] {
        let [begin, end] = self.ends[i];
        &self.indices[begin..end]
    }

    /// Tests every point against the points in the cells that its ball touches.
    ///
    /// `radius(i)` is how far `i` looks; `hit(i, radius of i, j, squared distance)` decides, `i` itself included.
    #[inline]
    fn scan<const D: usize>(
        &mut self,
        cells: &Cells<D>,
        radius: impl Fn(u32) -> f64,
        hit: impl Fn(u32, f64, u32, f64) -> bool,
    ) {
        let (points, ids) = cells.in_order();
        self.ends.resize(points.len(), [0; 2]);
        let mut filled = 0;
        for (x_i, &i) in points.iter().zip(ids) {
            let h_i = radius(i);
            let begin = filled;
            cells.for_each_range(x_i, h_i, |range| {
                let (points, ids) = (&points[range.clone()], &ids[range]);
                if self.indices.len() < filled + ids.len() {
                    self.indices.resize(2 * filled + ids.len(), 0);
                }
                // Every candidate is written, and the next writes over it unless it was a hit: no branch to mispredict.
                let row = &mut self.indices[filled..filled + ids.len()];
                let mut hits = 0;
                for (x_j, &j) in points.iter().zip(ids) {
                    row[hits] = j;
                    hits += usize::from(hit(i, h_i, j, squared_distance(x_i, x_j)));
                }
                filled += hits;
            });
            self.ends[i as usize] = [begin, filled];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_build_of_the_same_size_allocates_nothing() {
        let points: Vec<[f64; 2]> =
            (0..400).map(|k| [f64::from(k % 20), f64::from(k / 20)]).collect();
        let turned: Vec<[f64; 2]> = points.iter().map(|x| [-x[1], x[0]]).collect();
        let radii = vec![2.5; 400];
        let (mut grid, mut list) = (CellGrid::new(), NeighbourList::new());
        for criterion in Criterion::ALL {
            let radii = Radii::PerPoint { radii: &radii, criterion };
            grid.full_list(&points, radii, &mut list).unwrap();
            let before = (
                grid.found.indices.as_ptr(),
                list.of(0).as_ptr(),
                grid.cells.in_order().0.as_ptr(),
            );
            grid.full_list(&turned, radii, &mut list).unwrap();
            let after = (
                grid.found.indices.as_ptr(),
                list.of(0).as_ptr(),
                grid.cells.in_order().0.as_ptr(),
            );
            assert_eq!(before, after);
        }
    }

    #[test]
    fn of_a_pair_exactly_one_sees_farther() {
        for (h_i, h_j) in [(1.0, 2.0), (2.0, 1.0), (1.0, 1.0)] {
            assert!(sees_farther(3, h_i, 5, h_j) != sees_farther(5, h_j, 3, h_i));
            assert!(!sees_farther(4, h_i, 4, h_i));
        }
    }
}
