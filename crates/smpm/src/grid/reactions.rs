//! Momentum that the planes of the grid give to the bodies.

use crate::grid::blocks::{BlockSums, Fields, image_seen_at, place};
use crate::grid::boundary::Plane;
use crate::grid::node::Node;
use crate::grid::tile_size::{tile_edge, tile_len};
use crate::grid::tiles::{MOST_DEPTH, Tile};
use crate::number::CarriedNumber;

impl Plane {
    /// Whether it changes the momentum at a node: on it or beyond it, and for a mirror where the node has an image.
    fn acts_at(&self, node: i32) -> bool {
        let beyond = self.beyond(node);
        beyond >= if self.mirrors() { -MOST_DEPTH } else { 0 }
    }
}

impl<S: CarriedNumber, const D: usize> BlockSums<'_, S, D> {
    /// Adds the impulse of each plane at the nodes of a tile: what particles take from a node, less the impulse of their own forces,
    ///
    /// $$ R = \sum_i \left( M_i \Delta v_i - \Delta t F_i \right), \qquad M_i = \sum_p m_p N_i, \quad F_i = \sum_p f_p N_i $$
    ///
    /// with sums over particles without images, so that nodes beyond a mirror count by themselves. Where APIC replaces the velocity,
    /// $M_i v_i$ less the momentum before the step takes the place of $M_i \Delta v_i$. A node where no plane acts adds zero. At an edge
    /// a component goes to the plane that is normal to it, else to the first that acts along itself.
    pub(crate) fn add_reactions(
        &self,
        tile: &Tile<D>,
        nodes: &[Node<S, D>],
        (dt, affine): (f64, bool),
        reactions: &mut [[f64; D]],
    ) {
        for index in 0..tile_len(D) {
            let at = place::<D>(&tile.at, index, tile_edge(D));
            let acts = |plane: &Plane| plane.acts_at(at[plane.axis]);
            if !self.planes.iter().any(acts) {
                continue;
            }
            let of: [Option<usize>; D] = std::array::from_fn(|k| {
                let normal = self.planes.iter().position(|plane| plane.axis == k && acts(plane));
                normal.or_else(|| self.planes.iter().position(|it| it.acts_along() && acts(it)))
            });
            for field in (0..self.n_fields).filter(|&field| self.rigid != Some(field)) {
                let (given, mass) = self.sum_at(at, field);
                let mass = mass.value();
                if mass <= 0.0 {
                    continue;
                }
                let fields = Fields { n_fields: self.n_fields, field };
                let taken = image_seen_at(self.planes, (self.directory, nodes, fields), at);
                for k in 0..D {
                    let Some(plane) = of[k] else { continue };
                    let change = if affine {
                        mass * taken.velocity()[k].value() - given.momentum()[k].value()
                    } else {
                        mass * taken.velocity_change()[k].value()
                    };
                    reactions[plane][k] += change - dt * given.force()[k].value();
                }
            }
        }
    }
}
