//! Questions about a place: who is within a radius of it, and who is nearest.

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
            /// Sorts points, to be asked by [`for_each_within`](Self::for_each_within) and [`nearest`](Self::nearest). A list
            /// built by the same search puts its own points in their place.
            ///
            /// `edge` in the unit of the points, best near the radius of the questions: the width of a cell. It changes
            /// neither the answers nor a tree.
            ///
            /// # Errors
            ///
            /// Those of [`full_list`](crate::NeighbourSearch::full_list), [`Error::UniformRadius`] for the edge. What was
            /// built before is then as it was.
            pub fn build(&mut self, points: &[[f64; D]], edge: f64) -> Result<(), Error> {
                Radii::Uniform(edge).check(0)?;
                (searches().$order.build)(&mut self.$order, points, edge)
            }

            /// Number of points at the last build.
            #[must_use]
            pub fn n_points(&self) -> usize {
                self.$order.ids().len()
            }

            /// Visits every point at `r <= radius` of a place, in an order that points and search determine, until
            /// `visit` breaks. A point at the place itself is among them.
            ///
            /// `centre` and `radius` in the unit of the points. Decided by the same formula as a list; in a periodic space
            /// by the images of the points in the first period, which are rounded.
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

            /// Fills `found` with the `k` points nearest to a place, nearest first, those alike in order of their index;
            /// with all points if there are fewer. A point at the place itself is among them.
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
