//! Queries about a position: points within a radius, and nearest points.

use core::ops::ControlFlow;

use crate::cell_grid::CellGrid;
use crate::compiled::searches;
use crate::error::Error;
use crate::leaf_tree::LeafTree;
use crate::near::{Near, within};
use crate::radii::Radii;

macro_rules! answers_about_places {
    ($search:ident, $order:ident) => {
        impl<const D: usize> $search<D> {
            /// Sorts points for the queries [`for_each_within`](Self::for_each_within) and [`nearest`](Self::nearest).
            ///
            /// A list built by the same search replaces these points by its own. `edge` is the cell width in the unit
            /// of the points, best near the radius of the queries. It affects neither the results nor a tree.
            ///
            /// # Errors
            ///
            /// Those of [`full_list`](crate::NeighbourSearch::full_list), and [`Error::UniformRadius`] for the edge.
            /// The previous build is then unchanged.
            pub fn build(&mut self, points: &[[f64; D]], edge: f64) -> Result<(), Error> {
                Radii::Uniform(edge).check(0)?;
                (searches().$order.build)(&mut self.$order, points, edge)
            }

            /// Number of points in the last build.
            #[must_use]
            pub fn n_points(&self) -> usize {
                self.$order.ids().len()
            }

            /// Visits every point at `r <= radius` of a position until `visit` breaks.
            ///
            /// The order depends on points and search alone. A point at the position itself is included.
            ///
            /// `centre` and `radius` are in the unit of the points. The formula is that of a list. In a periodic space
            /// it is applied to the images of the points in the first period, which are rounded.
            ///
            /// # Errors
            ///
            /// [`Error::PlaceNotFinite`], [`Error::UniformRadius`] and [`Error::PeriodTooShort`].
            pub fn for_each_within<B>(
                &self,
                centre: &[f64; D],
                radius: f64,
                visit: impl FnMut(Near<D>) -> ControlFlow<B>,
            ) -> Result<ControlFlow<B>, Error> {
                check_place(centre)?;
                Radii::Uniform(radius).check(0)?;
                self.$order.domain().check(radius)?;
                Ok(within(&self.$order, centre, radius, visit))
            }

            /// Fills `found` with the `k` points nearest to a position, nearest first.
            ///
            /// Ties are in order of the index; with fewer points all are returned. A point at the position itself is
            /// included.
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
                (searches().$order.nearest)(&self.$order, centre, k, found);
                Ok(())
            }
        }
    };
}
answers_about_places!(CellGrid, cells);
answers_about_places!(LeafTree, leaves);

fn check_place<const D: usize>(centre: &[f64; D]) -> Result<(), Error> {
    match centre.iter().enumerate().find(|(_, value)| !value.is_finite()) {
        Some((axis, &value)) => Err(Error::PlaceNotFinite { axis, value }),
        None => Ok(()),
    }
}
