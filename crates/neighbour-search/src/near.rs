//! Queries around a position.

use core::ops::ControlFlow;

use crate::domain::square;
use crate::frame::Bounds;
use crate::radii::in_range;
use crate::sorted::{Near as Order, Rule, for_each_image};

/// A point near a position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Near<const D: usize> {
    /// The point.
    pub j: usize,
    /// The position minus the point, of the nearest images, unit of length of the points.
    pub x_ij: [f64; D],
    /// `|x_ij|`.
    pub r: f64,
}

/// Visits the points within a radius of a position until `visit` breaks.
pub(crate) fn within<const D: usize, B>(
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

/// The `k` points nearest to a position, nearest first.
pub(crate) fn nearest<const D: usize>(
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
    // Doubles the radius until the ball holds enough points; searches all points where squares overflow or a ball
    // meets its image.
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
