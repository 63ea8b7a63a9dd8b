//! Questions about a place: who is within a radius of it, and who is nearest.

use core::ops::ControlFlow;

use crate::cell_grid::CellGrid;
use crate::error::Error;
use crate::radii::{MAX_RADIUS, Radii};
use crate::search::{check, difference, squared_distance};

/// A point near a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Near<const D: usize> {
    /// The point.
    pub j: usize,
    /// The place less the point, unit of length of the points.
    pub x_ij: [f64; D],
    /// `|x_ij|`.
    pub r: f64,
}

impl<const D: usize> CellGrid<D> {
    /// Sorts points into cells about `edge` wide, to be asked by [`for_each_within`](Self::for_each_within) and
    /// [`nearest`](Self::nearest). A list built by the same grid puts its own points in their place.
    ///
    /// `edge` in the unit of the points, best near the radius of the questions; it does not change the answers.
    ///
    /// # Errors
    ///
    /// Those of [`full_list`](crate::NeighbourSearch::full_list), [`Error::UniformRadius`] for the edge. The grid is then
    /// as it was.
    pub fn build(&mut self, points: &[[f64; D]], edge: f64) -> Result<(), Error> {
        check(points, Radii::Uniform(edge))?;
        self.cells.build(points, edge);
        Ok(())
    }

    /// Number of points in the cells.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.cells.n_points()
    }

    /// Visits every point at `r <= radius` of a place, in an order that the points and the edge determine, until
    /// `visit` breaks. A point at the place itself is among them.
    ///
    /// `centre` and `radius` in the unit of the points. Decided by the same formula as a list.
    ///
    /// # Errors
    ///
    /// [`Error::PlaceNotFinite`] and [`Error::UniformRadius`].
    pub fn for_each_within<B>(
        &self,
        centre: &[f64; D],
        radius: f64,
        mut visit: impl FnMut(Near<D>) -> ControlFlow<B>,
    ) -> Result<ControlFlow<B>, Error> {
        check_place(centre)?;
        Radii::Uniform(radius).check(0)?;
        let mut flow = ControlFlow::Continue(());
        self.cells.for_each_range(centre, radius, |slots| {
            for slot in slots {
                if flow.is_break() {
                    return;
                }
                let near = self.near(centre, slot);
                if square(&near) <= radius * radius {
                    flow = visit(near);
                }
            }
        });
        Ok(flow)
    }

    /// Fills `found` with the `k` points nearest to a place, nearest first, those alike in order of their index; with all
    /// points if there are fewer. A point at the place itself is among them.
    ///
    /// # Errors
    ///
    /// [`Error::PlaceNotFinite`].
    pub fn nearest(
        &self,
        centre: &[f64; D],
        k: usize,
        found: &mut Vec<Near<D>>,
    ) -> Result<(), Error> {
        check_place(centre)?;
        found.clear();
        let wanted = k.min(self.n_points());
        if wanted == 0 {
            return Ok(());
        }
        // Balls of twice the radius until one holds enough. Beyond the largest radius squares overflow: then everyone.
        let mut radius = self.cells.edge();
        while found.len() < wanted && radius <= MAX_RADIUS {
            found.clear();
            self.cells.for_each_range(centre, radius, |slots| {
                let near = slots.map(|slot| self.near(centre, slot));
                found.extend(near.filter(|near| square(near) <= radius * radius));
            });
            radius *= 2.0;
        }
        if found.len() < wanted {
            found.clear();
            found.extend((0..self.n_points()).map(|slot| self.near(centre, slot)));
        }
        let nearer = |a: &Near<D>, b: &Near<D>| square(a).total_cmp(&square(b)).then(a.j.cmp(&b.j));
        found.select_nth_unstable_by(wanted - 1, nearer);
        found.truncate(wanted);
        found.sort_unstable_by(nearer);
        Ok(())
    }

    #[inline]
    fn near(&self, centre: &[f64; D], slot: usize) -> Near<D> {
        let columns = self.cells.columns();
        let x_j = core::array::from_fn(|axis| columns[axis][slot]);
        let r = squared_distance(centre, &x_j).sqrt();
        Near { j: self.cells.ids()[slot] as usize, x_ij: difference(centre, &x_j), r }
    }
}

/// The square that decides, with the bits of [`squared_distance`].
#[inline]
fn square<const D: usize>(near: &Near<D>) -> f64 {
    squared_distance(&near.x_ij, &[0.0; D])
}

fn check_place<const D: usize>(centre: &[f64; D]) -> Result<(), Error> {
    match centre.iter().enumerate().find(|(_, value)| !value.is_finite()) {
        Some((axis, &value)) => Err(Error::PlaceNotFinite { axis, value }),
        None => Ok(()),
    }
}
