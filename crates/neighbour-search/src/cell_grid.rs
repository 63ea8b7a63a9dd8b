//! Neighbours from a grid of cells.

use crate::cells::Cells;
use crate::error::Error;
use crate::list::NeighbourList;
use crate::radii::{Criterion, Radii};
use crate::search::{NeighbourSearch, check};
use crate::simd::{LANES, Lanes, Level, Work, eight};

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
/// `Gather`, `Max` and `Mean`), and about 60 bytes per point. In five and six dimensions, and where a few cells
/// hold most points, it tends towards brute force.
#[derive(Debug, Clone)]
pub struct CellGrid<const D: usize> {
    pub(crate) cells: Cells<D>,
    found: Found,
    scratch: NeighbourList,
    /// Radii in the order of the cells.
    own: Vec<f64>,
}

impl<const D: usize> Default for CellGrid<D> {
    fn default() -> Self {
        Self {
            cells: Cells::default(),
            found: Found::default(),
            scratch: NeighbourList::new(),
            own: Vec::new(),
        }
    }
}

impl<const D: usize> CellGrid<D> {
    /// A grid that has seen no points; its first build allocates.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }
}

impl<const D: usize> CellGrid<D> {
    /// Checks the input, sorts the points into cells as wide as what is typical of the radii, and these with them.
    fn sort(&mut self, points: &[[f64; D]], radii: Radii<'_>) -> Result<(), Error> {
        check(points, radii)?;
        let typical = match radii {
            Radii::Uniform(radius) => radius,
            Radii::PerPoint { radii, .. } => self.cells.median(radii),
        };
        self.cells.build(points, EDGE * typical);
        if let Radii::PerPoint { radii, .. } = radii {
            self.cells.gather(radii, &mut self.own);
        }
        Ok(())
    }
}

impl<const D: usize> NeighbourSearch<D> for CellGrid<D> {
    fn full_list(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        list: &mut NeighbourList,
    ) -> Result<(), Error> {
        self.sort(points, radii)?;
        let n = points.len();
        let Self { cells, found, scratch, own } = self;
        let own = own.as_slice();
        match radii {
            Radii::Uniform(radius) => {
                found.scan(cells, |_| radius, Sees);
                list.transpose_symmetric(n, |i| found.row(i));
            }
            Radii::PerPoint { criterion: Criterion::Gather, .. } => {
                found.scan(cells, |slot| own[slot], Sees);
                scratch.transpose(n, |i| found.row(i));
                list.transpose(n, |i| scratch.of(i));
            }
            Radii::PerPoint { criterion: Criterion::Scatter, .. } => {
                found.scan(cells, |slot| own[slot], Sees);
                list.transpose(n, |i| found.row(i));
            }
            Radii::PerPoint { criterion: Criterion::Max, .. } => {
                found.scan(cells, |slot| own[slot], SeesFarther { own });
                scratch.mutual(n, |i| found.row(i));
                list.transpose_symmetric(n, |i| scratch.of(i));
            }
            Radii::PerPoint { criterion: Criterion::Mean, .. } => {
                found.scan(cells, |slot| own[slot], MeanSees { own });
                scratch.mutual(n, |i| found.row(i));
                list.transpose_symmetric(n, |i| scratch.of(i));
            }
        }
        Ok(())
    }

    /// Written directly: half of the full list's memory, and no pass over the other half.
    fn half_list(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        list: &mut NeighbourList,
    ) -> Result<(), Error> {
        radii.check_symmetric()?;
        self.sort(points, radii)?;
        let n = points.len();
        let Self { cells, found, scratch, own } = self;
        let own = own.as_slice();
        match radii {
            Radii::Uniform(radius) => {
                found.scan(cells, |_| radius, SeesEarlier);
                list.transpose(n, |i| found.row(i));
                return Ok(());
            }
            Radii::PerPoint { criterion: Criterion::Mean, .. } => {
                found.scan(cells, |slot| own[slot], MeanSees { own });
            }
            Radii::PerPoint { .. } => found.scan(cells, |slot| own[slot], SeesFarther { own }),
        }
        scratch.under_larger(n, |i| found.row(i));
        list.transpose(n, |i| scratch.of(i));
        Ok(())
    }
}

/// The point that looks for its neighbours.
#[derive(Clone, Copy)]
struct Seeker {
    id: u32,
    radius: f64,
}

/// Which of eight candidates a point lists.
trait Test: Copy {
    /// `slot` is that of the first, `d2` are their squared distances; the point itself may be among them.
    fn hits<L: Lanes>(
        self,
        lanes: L,
        i: Seeker,
        slot: usize,
        ids: &[u32; LANES],
        d2: L::Vector,
    ) -> u8;
}

/// Whether `i` sees `j` with its own radius.
#[derive(Clone, Copy)]
struct Sees;

impl Test for Sees {
    #[inline(always)]
    fn hits<L: Lanes>(
        self,
        lanes: L,
        i: Seeker,
        _: usize,
        ids: &[u32; LANES],
        d2: L::Vector,
    ) -> u8 {
        lanes.at_most(d2, lanes.splat(i.radius * i.radius)) & lanes.other(ids, i.id)
    }
}

/// Of a pair within reach, the one with the larger index finds the other.
#[derive(Clone, Copy)]
struct SeesEarlier;

impl Test for SeesEarlier {
    #[inline(always)]
    fn hits<L: Lanes>(
        self,
        lanes: L,
        i: Seeker,
        _: usize,
        ids: &[u32; LANES],
        d2: L::Vector,
    ) -> u8 {
        lanes.at_most(d2, lanes.splat(i.radius * i.radius)) & lanes.before(ids, i.id)
    }
}

/// Of a pair it is found by the one that sees farther, and of two alike by the one with the larger index.
#[derive(Clone, Copy)]
struct SeesFarther<'a> {
    /// Radii in the order of the cells.
    own: &'a [f64],
}

impl SeesFarther<'_> {
    #[inline(always)]
    fn farther<L: Lanes>(lanes: L, i: Seeker, h_j: L::Vector, ids: &[u32; LANES]) -> u8 {
        let h_i = lanes.splat(i.radius);
        lanes.below(h_j, h_i) | lanes.at_most(h_j, h_i) & lanes.before(ids, i.id)
    }
}

impl Test for SeesFarther<'_> {
    #[inline(always)]
    fn hits<L: Lanes>(
        self,
        lanes: L,
        i: Seeker,
        slot: usize,
        ids: &[u32; LANES],
        d2: L::Vector,
    ) -> u8 {
        let h_j = lanes.load(eight(self.own, slot));
        lanes.at_most(d2, lanes.splat(i.radius * i.radius)) & Self::farther(lanes, i, h_j, ids)
    }
}

/// Whether the mean of both radii reaches, found by the point that sees farther.
#[derive(Clone, Copy)]
struct MeanSees<'a> {
    /// Radii in the order of the cells.
    own: &'a [f64],
}

impl Test for MeanSees<'_> {
    #[inline(always)]
    fn hits<L: Lanes>(
        self,
        lanes: L,
        i: Seeker,
        slot: usize,
        ids: &[u32; LANES],
        d2: L::Vector,
    ) -> u8 {
        let h_j = lanes.load(eight(self.own, slot));
        // As `radii::mean` has it.
        let limit = lanes.mul(lanes.splat(0.5), lanes.add(lanes.splat(i.radius), h_j));
        lanes.at_most(d2, lanes.mul(limit, limit)) & SeesFarther::farther(lanes, i, h_j, ids)
    }
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

    /// Tests every point against the points in the cells that its ball touches; `radius(slot)` is how far it looks.
    fn scan<const D: usize>(
        &mut self,
        cells: &Cells<D>,
        radius: impl Fn(usize) -> f64,
        test: impl Test,
    ) {
        self.scan_at(Level::best(), cells, radius, test);
    }

    fn scan_at<const D: usize>(
        &mut self,
        level: Level,
        cells: &Cells<D>,
        radius: impl Fn(usize) -> f64,
        test: impl Test,
    ) {
        level.run(Scan { found: self, cells, radius, test });
    }
}

/// The scan, for every level of instructions.
struct Scan<'a, const D: usize, R, T> {
    found: &'a mut Found,
    cells: &'a Cells<D>,
    radius: R,
    test: T,
}

impl<const D: usize, R: Fn(usize) -> f64, T: Test> Work for Scan<'_, D, R, T> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { found: Found { indices, ends }, cells, radius, test } = self;
        let (columns, ids) = (cells.columns(), cells.ids());
        let n = cells.n_points();
        ends.resize(n, [0; 2]);
        let mut filled = 0;
        for slot in 0..n {
            let i = Seeker { id: ids[slot], radius: radius(slot) };
            let x_i: [f64; D] = core::array::from_fn(|axis| columns[axis][slot]);
            let begin = filled;
            cells.for_each_range(&x_i, i.radius, |range| {
                // Eight are written at a time, however few of them are hits.
                if indices.len() < filled + range.len() + LANES {
                    indices.resize(2 * filled + range.len() + LANES, 0);
                }
                let mut first = range.start;
                while first < range.end {
                    let mut d2 = lanes.splat(0.0);
                    for axis in 0..D {
                        let x_j = lanes.load(eight(columns[axis], first));
                        let along = lanes.sub(lanes.splat(x_i[axis]), x_j);
                        d2 = lanes.add(d2, lanes.mul(along, along));
                    }
                    let ids = eight(ids, first);
                    let in_range = 0xff_u8 >> LANES.saturating_sub(range.end - first);
                    let hits = test.hits(lanes, i, first, ids, d2) & in_range;
                    if let Some(out) = indices[filled..].first_chunk_mut() {
                        lanes.compress(hits, ids, out);
                    }
                    filled += hits.count_ones() as usize;
                    first += LANES;
                }
            });
            ends[i.id as usize] = [begin, filled];
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
            let before =
                (grid.found.indices.as_ptr(), list.of(0).as_ptr(), grid.cells.ids().as_ptr());
            grid.full_list(&turned, radii, &mut list).unwrap();
            let after =
                (grid.found.indices.as_ptr(), list.of(0).as_ptr(), grid.cells.ids().as_ptr());
            assert_eq!(before, after);
        }
    }

    #[test]
    fn every_level_of_this_machine_finds_the_same_rows() {
        // Multiples of a turn by the golden angle: no two distances alike, but for the duplicates of the last fifth.
        let points: Vec<[f64; 3]> = (0..500)
            .map(|k| f64::from(if k < 400 { k } else { k - 150 }))
            .map(|k| [(2.4 * k).cos(), (2.4 * k).sin(), 0.005 * k])
            .collect();
        let radii: Vec<f64> = (0..500).map(|k| 0.1 + 0.05 * f64::from(k % 7)).collect();
        let (mut cells, mut own) = (Cells::default(), Vec::new());
        cells.build(&points, 0.2);
        cells.gather(&radii, &mut own);
        let own = own.as_slice();
        let rows = |level, test: usize| {
            let (mut found, radius) = (Found::default(), |slot: usize| own[slot]);
            match test {
                0 => found.scan_at(level, &cells, radius, Sees),
                1 => found.scan_at(level, &cells, radius, SeesFarther { own }),
                _ => found.scan_at(level, &cells, radius, MeanSees { own }),
            }
            (0..500).map(|i| found.row(i).to_vec()).collect::<Vec<_>>()
        };
        for test in 0..3 {
            let portable = rows(Level::Portable, test);
            assert!(portable.iter().flatten().count() > 1000);
            for level in Level::all() {
                assert_eq!(rows(level, test), portable, "{level:?}");
            }
        }
    }
}
