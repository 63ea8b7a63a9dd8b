//! The nodes of a step in one box, and what planes make of them.

use crate::boundary::Plane;
use crate::tile_size::MOST_NODES;

use crate::tiles::MOST_DEPTH;

/// A node that takes from another, each component times a sign.
#[derive(Debug, Clone, Copy)]
pub(super) struct Image<const D: usize> {
    pub(super) node: usize,
    pub(super) of: usize,
    pub(super) sign: [f64; D],
}

/// All nodes between the lowest and the highest that a particle sees.
#[derive(Debug)]
pub(super) struct NodeBox<const D: usize> {
    low: [i32; D],
    extent: [usize; D],
    pub(super) strides: [usize; D],
    pub(super) n_nodes: usize,
    /// Sums that nodes near mirrors collect from their images.
    pub(super) collected: Vec<Image<D>>,
    /// Nodes beyond mirrors, and where their velocities come from.
    pub(super) filled: Vec<Image<D>>,
    /// Nodes on which a plane acts, with their places.
    pub(super) constrained: Vec<(usize, [i32; D])>,
}

impl<const D: usize> NodeBox<D> {
    /// Of particles by their lowest nodes.
    pub(super) fn of<'a>(bases: impl Iterator<Item = &'a [i32; D]>, planes: &[Plane]) -> Self {
        let (mut low, mut high) = ([i32::MAX; D], [i32::MIN; D]);
        for base in bases {
            for k in 0..D {
                low[k] = low[k].min(base[k]);
                high[k] = high[k].max(base[k]);
            }
        }
        let (mut extent, mut strides, mut n_nodes) = ([0; D], [0; D], 1);
        for k in 0..D {
            let between = i64::from(high[k]) - i64::from(low[k]);
            extent[k] = usize::try_from(between).unwrap_or(0) + MOST_NODES;
            strides[k] = n_nodes;
            n_nodes *= extent[k];
        }
        let (collected, filled, constrained) = (vec![], vec![], vec![]);
        let mut nodes = Self { low, extent, strides, n_nodes, collected, filled, constrained };
        if !planes.is_empty() {
            nodes.find_images(planes);
        }
        nodes
    }

    /// The number of a node inside.
    #[inline]
    pub(super) fn index(&self, place: &[i32; D]) -> usize {
        self.find(place).unwrap_or(0)
    }

    fn find(&self, place: &[i32; D]) -> Option<usize> {
        let mut index = 0;
        for k in 0..D {
            let offset = usize::try_from(i64::from(place[k]) - i64::from(self.low[k])).ok()?;
            if offset >= self.extent[k] {
                return None;
            }
            index += offset * self.strides[k];
        }
        Some(index)
    }

    fn find_images(&mut self, planes: &[Plane]) {
        for node in 0..self.n_nodes {
            let place: [i32; D] = std::array::from_fn(|k| {
                let offset = node / self.strides[k] % self.extent[k];
                self.low[k] + i32::try_from(offset).unwrap_or(0)
            });
            if planes.iter().any(|plane| plane.beyond(place[plane.axis]) >= 0) {
                self.constrained.push((node, place));
            }
            self.collect(node, &place, planes);
            self.fill(node, place, planes);
        }
    }

    /// As in particle-to-grid: each image of a node may have images in the planes of further axes.
    fn collect(&mut self, node: usize, place: &[i32; D], planes: &[Plane]) {
        let mut near: [Option<&Plane>; D] = [None; D];
        for plane in planes.iter().filter(|plane| plane.mirrors()) {
            if (1..=MOST_DEPTH).contains(&-plane.beyond(place[plane.axis])) {
                near[plane.axis] = Some(plane);
            }
        }
        for chosen in 1..1_usize << D {
            let picked = |k: usize| chosen >> k & 1 == 1;
            if (0..D).any(|k| picked(k) && near[k].is_none()) {
                continue;
            }
            let (mut at, mut sign) = (*place, [1.0; D]);
            for plane in (0..D).filter(|&k| picked(k)).filter_map(|k| near[k]) {
                at[plane.axis] = plane.image(at[plane.axis]);
                sign = plane.mirrored(sign);
            }
            if let Some(of) = self.find(&at) {
                self.collected.push(Image { node, of, sign });
            }
        }
    }

    /// As in grid-to-particle: a corner is beyond a plane of each axis.
    fn fill(&mut self, node: usize, place: [i32; D], planes: &[Plane]) {
        let (mut at, mut sign, mut is_beyond) = (place, [1.0; D], false);
        for _ in 0..D {
            let behind = |plane: &&Plane| plane.mirrors() && plane.beyond(at[plane.axis]) > 0;
            let Some(plane) = planes.iter().find(behind) else { break };
            at[plane.axis] = plane.image(at[plane.axis]);
            sign = plane.mirrored(sign);
            is_beyond = true;
        }
        if is_beyond {
            // A node that no particle sees is at rest.
            let (of, sign) = self.find(&at).map_or((node, [0.0; D]), |of| (of, sign));
            self.filled.push(Image { node, of, sign });
        }
    }
}
