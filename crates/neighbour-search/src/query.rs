//! Questions about a place: who is within a radius of it, and who is nearest.

use core::ops::ControlFlow;

use crate::cell_grid::CellGrid;
use crate::domain::square;
use crate::error::Error;
use crate::frame::Bounds;
use crate::leaf_tree::LeafTree;
use crate::radii::{Radii, in_range};
use crate::search::check;
use crate::sorted::{Near as Order, Rule, for_each_image};

/// A point near a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Near<const D: usize> {
    /// The point.
    pub j: usize,
    /// The place less the point, of the nearest images, unit of length of the points.
    pub x_ij: [f64; D],
    /// `|x_ij|`.
    pub r: f64,
}

macro_rules! answers_about_places {
    ($search:ident, $order:ident, |$this:ident, $points:ident, $edge:ident| $build:expr) => {
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
            pub fn build(&mut self, $points: &[[f64; D]], $edge: f64) -> Result<(), Error> {
                // Any edge will do in a periodic space: only radii are held against the periods.
                Radii::Uniform($edge).check(0)?;
                check($points, Radii::Uniform(crate::MIN_RADIUS), self.$order.domain())?;
                let $this = self;
                $build
                Ok(())
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
                nearest(&self.$order, centre, k, found);
                Ok(())
            }
        }
    };
}
answers_about_places!(CellGrid, cells, |this, points, edge| {
    this.cells.build(points, Radii::Uniform(edge), edge);
});
answers_about_places!(LeafTree, leaves, |this, points, edge| {
    this.leaves.build(points, Radii::Uniform(edge));
});

fn within<const D: usize, B>(
    order: &impl Order<D>,
    centre: &[f64; D],
    radius: f64,
    mut visit: impl FnMut(Near<D>) -> ControlFlow<B>,
) -> ControlFlow<B> {
    let sorted = order.sorted();
    let place = sorted.domain.wrap_all(centre);
    let bounds = Bounds { low: place, high: place, radius };
    let mut flow = ControlFlow::Continue(());
    if sorted.n_points() == 0 {
        return flow;
    }
    for_each_image(sorted, &bounds, radius, |bounds, shift| {
        order.for_each_stretch(bounds, Rule::Uniform(radius), shift, |slots| {
            for slot in slots {
                if flow.is_break() {
                    return;
                }
                let near = near(order, centre, slot);
                if square(&near.x_ij) <= radius * radius
                    && sorted.domain.is_image(&place, &sorted.points[slot], shift, &near.x_ij)
                {
                    flow = visit(near);
                }
            }
        });
    });
    flow
}

fn nearest<const D: usize>(
    order: &impl Order<D>,
    centre: &[f64; D],
    k: usize,
    found: &mut Vec<Near<D>>,
) {
    let sorted = order.sorted();
    found.clear();
    let wanted = k.min(sorted.n_points());
    if wanted == 0 {
        return;
    }
    // Balls of twice the radius until one holds enough; where squares overflow or a ball meets its image, everyone.
    let mut radius = order.radius_for(&sorted.domain.wrap_all(centre), wanted);
    while found.len() < wanted && in_range(radius) && sorted.domain.check(radius).is_ok() {
        found.clear();
        let _: ControlFlow<()> = within(order, centre, radius, |near| {
            found.push(near);
            ControlFlow::Continue(())
        });
        radius *= 2.0;
    }
    if found.len() < wanted {
        found.clear();
        found.extend((0..sorted.n_points()).map(|slot| near(order, centre, slot)));
    }
    let nearer =
        |a: &Near<D>, b: &Near<D>| square(&a.x_ij).total_cmp(&square(&b.x_ij)).then(a.j.cmp(&b.j));
    found.select_nth_unstable_by(wanted - 1, nearer);
    found.truncate(wanted);
    found.sort_unstable_by(nearer);
}

#[inline]
fn near<const D: usize>(order: &impl Order<D>, centre: &[f64; D], slot: usize) -> Near<D> {
    let sorted = order.sorted();
    let x_ij = sorted.domain.difference(centre, &sorted.points[slot]);
    Near { j: sorted.ids[slot] as usize, x_ij, r: square(&x_ij).sqrt() }
}

fn check_place<const D: usize>(centre: &[f64; D]) -> Result<(), Error> {
    match centre.iter().enumerate().find(|(_, value)| !value.is_finite()) {
        Some((axis, &value)) => Err(Error::PlaceNotFinite { axis, value }),
        None => Ok(()),
    }
}
