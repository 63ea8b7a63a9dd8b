//! Lists and visits from an order of the points.

use simd_lanes::SimdLevel;

use crate::domain::square;
use crate::error::Error;
use crate::list::{CHUNK, NeighbourList};
use crate::neighbourhood::{Entries, Neighbourhood, Question, Scan};
use crate::parallel::Part;
use crate::radii::Radii;
use crate::room::Room;
use crate::row::Row;
use crate::sorted::{Listed, Order, Sorted};

/// Work data of a search.
#[derive(Debug, Clone)]
pub(crate) struct Rows<const D: usize> {
    level: SimdLevel,
    scratch: Vec<Neighbourhood<D>>,
    memory: Vec<u32>,
    ends: Vec<usize>,
    batch: Batch<D>,
}

impl<const D: usize> Default for Rows<D> {
    fn default() -> Self {
        let batch = Batch::default();
        Self {
            level: SimdLevel::best(),
            scratch: Vec::new(),
            memory: Vec::new(),
            ends: Vec::new(),
            batch,
        }
    }
}

impl<const D: usize> Rows<D> {
    /// Work data for a SIMD level.
    pub(crate) fn at(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }

    /// Fills `list` with the rows of every point. After an error it is empty.
    ///
    /// # Errors
    /// [`Error::TooManyNeighbours`].
    pub(crate) fn list(
        &mut self,
        order: &dyn Order<D>,
        points: &[[f64; D]],
        radii: Radii<'_>,
        listed: Listed,
        list: &mut NeighbourList,
    ) -> Result<(), Error> {
        let sorted = order.sorted();
        list.restart(points.len(), &sorted.domain, Some(sorted.order()));
        self.make_room(points.len().div_ceil(CHUNK));
        let question = Question { points, radii, listed, entries: Entries::Ids };
        let (level, room) = (self.level, Room::default());
        list.for_each_part(&mut self.scratch, |Part { chunk, indices, ends, scratch }| {
            let first = chunk * CHUNK;
            let slots = first..first + ends.len();
            level.run(Scan {
                order,
                question,
                slots,
                neighbourhood: scratch,
                memory: indices,
                ends,
                room: &room,
            });
        });
        room.check(points.len()).inspect_err(|_| *list = NeighbourList::new())
    }

    /// Calls `visit` with every row, in the order of the slots, after finding a stretch of rows at a time.
    ///
    /// # Errors
    /// [`Error::TooManyNeighbours`], after the rows of earlier stretches.
    pub(crate) fn visit(
        &mut self,
        order: &dyn Order<D>,
        points: &[[f64; D]],
        radii: Radii<'_>,
        visit: &mut dyn FnMut(Row<'_, D>),
    ) -> Result<(), Error> {
        self.make_room(1);
        let Self { level, scratch, memory, ends, batch } = self;
        let Some(neighbourhood) = scratch.first_mut() else { return Ok(()) };
        let (sorted, listed, room) = (order.sorted(), Listed::Full, Room::default());
        let question = Question { points, radii, listed, entries: Entries::Slots };
        ends.resize(CHUNK, 0);
        for first in (0..points.len()).step_by(CHUNK) {
            let slots = first..points.len().min(first + CHUNK);
            let ends = &mut ends[..slots.len()];
            let neighbourhood = &mut *neighbourhood;
            let slots_of = slots.clone();
            let scan =
                Scan { order, question, slots: slots_of, neighbourhood, memory, ends, room: &room };
            level.run(scan);
            room.check(points.len())?;
            let mut begin = 0;
            for (slot, &mut end) in slots.zip(ends) {
                batch.fill(sorted, points, slot, &memory[begin..end]);
                begin = end;
                visit(Row {
                    i: sorted.ids[slot] as usize,
                    j: &batch.ids,
                    x_ij: core::array::from_fn(|axis| batch.x_ij[axis].as_slice()),
                    squared_distances: &batch.squared_distances,
                });
            }
        }
        Ok(())
    }

    fn make_room(&mut self, chunks: usize) {
        if self.scratch.len() < chunks {
            self.scratch.resize_with(chunks, Neighbourhood::default);
        }
    }
}

/// Common implementation of every search that sorts its points into an order.
macro_rules! lists_rows {
    ($search:ident, $order:ident, $groups:literal) => {
        impl<const D: usize> $search<D> {
            /// The same search restricted to instructions that every machine supports.
            ///
            /// The lists are the same; use it for comparison.
            #[must_use]
            pub fn with_portable_instructions(self) -> Self {
                Self { rows: Rows::at(simd_lanes::SimdLevel::PORTABLE), ..self }
            }

            #[doc = concat!("The order of the ", $groups, ": `order()[slot]` is the point in that slot at the last build.")]
            ///
            /// Data in this order are as close in memory as the points are in space, which makes loops over pairs
            /// several times faster.
            #[must_use]
            pub fn order(&self) -> &[u32] {
                self.$order.ids()
            }
        }

        impl<const D: usize> $crate::NeighbourSearch<D> for $search<D> {
            fn full_list(
                &mut self,
                points: &[[f64; D]],
                radii: Radii<'_>,
                list: &mut $crate::NeighbourList,
            ) -> Result<(), Error> {
                let search = (&mut self.$order, &mut self.rows);
                (searches().$order.list)(search, points, radii, $crate::sorted::Listed::Full, list)
            }

            /// Implemented directly: half of the full list's memory and candidates.
            fn half_list(
                &mut self,
                points: &[[f64; D]],
                radii: Radii<'_>,
                list: &mut $crate::NeighbourList,
            ) -> Result<(), Error> {
                radii.check_symmetric()?;
                let search = (&mut self.$order, &mut self.rows);
                (searches().$order.list)(search, points, radii, $crate::sorted::Listed::Half, list)
            }

            #[doc = concat!("Without a list, in the order of the ", $groups, ".")]
            fn for_each_row(
                &mut self,
                points: &[[f64; D]],
                radii: Radii<'_>,
                visit: &mut dyn FnMut($crate::Row<'_, D>),
            ) -> Result<(), Error> {
                let search = (&mut self.$order, &mut self.rows);
                (searches().$order.visit)(search, points, radii, visit)
            }
        }
    };
}
pub(crate) use lists_rows;

/// Coordinates of a row.
#[derive(Debug, Clone)]
struct Batch<const D: usize> {
    ids: Vec<u32>,
    x_ij: [Vec<f64>; D],
    squared_distances: Vec<f64>,
}

impl<const D: usize> Default for Batch<D> {
    fn default() -> Self {
        let x_ij = [const { Vec::new() }; D];
        Self { ids: Vec::new(), x_ij, squared_distances: Vec::new() }
    }
}

impl<const D: usize> Batch<D> {
    #[inline(always)]
    fn fill(&mut self, sorted: &Sorted<D>, points: &[[f64; D]], slot: usize, row: &[u32]) {
        let n = row.len();
        self.ids.clear();
        self.ids.extend(row.iter().map(|&slot| sorted.ids[slot as usize]));
        for column in self.x_ij.iter_mut().chain([&mut self.squared_distances]) {
            column.resize(n, 0.0);
        }
        let Self { ids, x_ij, squared_distances } = self;
        let mut put = |k: usize, difference: [f64; D]| {
            for axis in 0..D {
                x_ij[axis][k] = difference[axis];
            }
            squared_distances[k] = square(&difference);
        };
        if sorted.domain.is_periodic() {
            // Stored points are images; the coordinates returned come from the points themselves.
            let x_i = &points[sorted.ids[slot] as usize];
            for (k, &id) in ids.iter().enumerate() {
                put(k, sorted.domain.difference(x_i, &points[id as usize]));
            }
        } else {
            let x_i = &sorted.points[slot];
            for (k, &slot) in row.iter().enumerate() {
                let x_j = &sorted.points[slot as usize];
                put(k, core::array::from_fn(|axis| x_i[axis] - x_j[axis]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::Cells;
    use crate::criterion::Criterion;

    #[test]
    fn every_level_of_this_machine_lists_the_same_rows_in_the_same_order() {
        // Multiples of a turn by the golden angle, with duplicates at the end.
        let points: Vec<[f64; 3]> = (0..500)
            .map(|k| f64::from(if k < 400 { k } else { k - 150 }))
            .map(|k| [(2.4 * k).cos(), (2.4 * k).sin(), 0.005 * k])
            .collect();
        let own: Vec<f64> = (0..500).map(|k| 0.1 + 0.05 * f64::from(k % 7)).collect();
        let per_point = Criterion::ALL.map(|criterion| Radii::PerPoint { radii: &own, criterion });
        for radii in [Radii::Uniform(0.3)].into_iter().chain(per_point) {
            let mut cells = Cells::default();
            cells.lay_and_place(&points, radii, 0.3);
            let mut portable = NeighbourList::new();
            Rows::at(SimdLevel::PORTABLE)
                .list(&cells, &points, radii, Listed::Full, &mut portable)
                .unwrap();
            assert!(portable.n_pairs() > 1000);
            for level in SimdLevel::available() {
                let mut list = NeighbourList::new();
                Rows::at(level).list(&cells, &points, radii, Listed::Full, &mut list).unwrap();
                assert_eq!(list, portable, "{level:?}");
            }
        }
    }
}
