//! Blocks of tiles and the nodes that they share: what particle-to-grid has summed in the blocks is collected from them, and they
//! are filled again.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::grid::boundary::Plane;
use crate::grid::contact::{Friction, MOST_GAP, Surface, meet};
use crate::grid::node::Node;
use crate::grid::tile_size::{
    HALO, block_edge, block_len, corner_of, signed, tile_edge, tile_len, tile_of,
};
use crate::grid::tiles::{Directory, MOST_DEPTH, NONE, Tile};
use crate::number::CarriedNumber;

/// At a node the surfaces of so many bodies are summed once; those of further bodies again for each pair.
const KEPT: usize = 4;

/// A node of a box by its number: the place of node `index` of box `tile`, of so many nodes along each axis.
pub(crate) fn place<const D: usize>(tile: &[i32; D], index: usize, edge: usize) -> [i32; D] {
    let mut rest = index;
    std::array::from_fn(|k| {
        let local = rest % edge;
        rest /= edge;
        tile[k] * signed(edge) + signed(local)
    })
}

/// The same of a tile's block.
pub(crate) fn place_in_block<const D: usize>(tile: &[i32; D], index: usize) -> [i32; D] {
    let block = place::<D>(&[0; D], index, block_edge(D));
    std::array::from_fn(|k| tile[k] * signed(tile_edge(D)) + block[k])
}

/// Where a row of nodes, the first axis along it, begins in a box of nodes: `edge` along each axis, for the row `(j, k)`.
#[inline(always)]
fn row_start(edge: usize, (j, k): (usize, usize)) -> usize {
    (k * edge + j) * edge
}

/// Which of how many fields.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fields {
    pub(crate) n_fields: usize,
    pub(crate) field: usize,
}

impl Fields {
    /// The number of a tile's set in this field.
    fn set(self, slot: u32) -> usize {
        slot as usize * self.n_fields + self.field
    }
}

/// What particle-to-grid has summed, by blocks.
pub(crate) struct BlockSums<'a, S, const D: usize> {
    pub(crate) directory: &'a Directory<D>,
    pub(crate) tiles: &'a [Tile<D>],
    pub(crate) planes: &'a [Plane],
    pub(crate) n_fields: usize,
    pub(crate) blocks: &'a [Node<S, D>],
    pub(crate) masses: &'a [S],
    pub(crate) surfaces: &'a [Surface<S, D>],
    /// The field of a rigid body.
    pub(crate) rigid: Option<usize>,
}

impl<S: CarriedNumber, const D: usize> BlockSums<'_, S, D> {
    /// What all blocks hold of the nodes of a tile, row by row, in the order of the tiles below.
    #[inline(always)]
    pub(crate) fn collect(
        &self,
        tile: &Tile<D>,
        owned: &mut [Node<S, D>],
        mut masses: Option<&mut [S]>,
        field: usize,
    ) {
        let fields = Fields { n_fields: self.n_fields, field };
        let (edge, wide) = (tile_edge(D), block_edge(D));
        for row in 0..tile_len(D) / edge {
            let (j, k) = (row % edge, row / edge);
            let here = row * edge..(row + 1) * edge;
            owned[here.clone()].fill(Node::zero());
            if let Some(masses) = &mut masses {
                masses[here.clone()].fill(S::constant(0.0));
            }
            for bits in 0..1_usize << D {
                let (beyond_j, beyond_k) = (bits >> 1 & 1, bits >> 2 & 1);
                if tile.below[bits] == NONE
                    || (beyond_j == 1 && j >= HALO)
                    || (beyond_k == 1 && k >= HALO)
                {
                    continue;
                }
                let block = fields.set(tile.below[bits]) * block_len(D);
                let start = block + row_start(wide, (j + beyond_j * edge, k + beyond_k * edge));
                let masses = masses.as_mut().map(|masses| &mut masses[here.clone()]);
                // Lengths that the compiler knows.
                if bits & 1 == 1 {
                    self.add(start + edge, HALO, &mut owned[here.clone()], masses);
                } else {
                    self.add(start, tile_edge(D), &mut owned[here.clone()], masses);
                }
            }
        }
    }

    /// Adds what the blocks hold of so many nodes in a row.
    #[inline(always)]
    fn add(&self, start: usize, n: usize, owned: &mut [Node<S, D>], masses: Option<&mut [S]>) {
        let (owned, of_block) = (&mut owned[..n], &self.blocks[start..start + n]);
        for i in 0..n {
            owned[i].add(&of_block[i]);
        }
        if let Some(masses) = masses {
            let (masses, of_block) = (&mut masses[..n], &self.masses[start..start + n]);
            for i in 0..n {
                masses[i] = masses[i] + of_block[i];
            }
        }
    }

    /// Adds to what [`collect`](Self::collect) has found the images that planes show of the nodes of a tile.
    pub(crate) fn add_images(
        &self,
        tile: &Tile<D>,
        owned: &mut [Node<S, D>],
        mut masses: Option<&mut [S]>,
        field: usize,
    ) {
        let is_near = |plane: &Plane| {
            let (least, most) = plane.range_beyond(&corner_of(&tile.at), tile_edge(D));
            plane.mirrors() && least < 0 && most >= -MOST_DEPTH
        };
        if !self.planes.iter().any(is_near) {
            return;
        }
        for (index, node) in owned.iter_mut().enumerate() {
            let place = place::<D>(&tile.at, index, tile_edge(D));
            let shows = |plane: &Plane, depth| plane.mirrors() && (1..=MOST_DEPTH).contains(&depth);
            for_each_image(self.planes, place, shows, |at, mirrors| {
                if mirrors.iter().all(Option::is_none) {
                    return;
                }
                let (mut image, mass) = self.sum_at(at, field);
                for plane in mirrors.into_iter().flatten() {
                    *image.momentum_mut() = plane.mirrored(*image.momentum());
                    *image.force_mut() = plane.mirrored(*image.force());
                }
                node.add(&image);
                if let Some(masses) = &mut masses {
                    masses[index] = masses[index] + mass;
                }
            });
        }
    }

    /// Applies contact to all pairs of bodies at the nodes of a tile that bodies fill, in the order of their numbers.
    #[inline(always)]
    pub(crate) fn let_meet(
        &self,
        tile: &Tile<D>,
        owned: &mut [Node<S, D>],
        masses: &[S],
        friction: Friction,
    ) {
        for index in 0..tile_len(D) {
            let bears = |field: usize| masses[field * tile_len(D) + index].value() > 0.0;
            if (0..self.n_fields).filter(|&field| bears(field)).count() < 2 {
                continue;
            }
            let place = place::<D>(&tile.at, index, tile_edge(D));
            let mut kept = [Surface::none(); KEPT];
            for (field, surface) in kept.iter_mut().enumerate().take(self.n_fields) {
                *surface = self.surface_at(place, field);
            }
            let surface = |field: usize| {
                kept.get(field).copied().unwrap_or_else(|| self.surface_at(place, field))
            };
            // The volume that bodies leave empty around the node is the gap between them.
            let fill = |field: usize| surface(field).fill.value();
            let is_full = (0..self.n_fields).map(fill).sum::<f64>() >= 1.0 - MOST_GAP;
            if !is_full && self.rigid.is_none() {
                continue;
            }
            for second in (1..self.n_fields).filter(|&field| bears(field)) {
                let (low, high) = owned.split_at_mut(second * tile_len(D));
                for first in (0..second).filter(|&field| bears(field)) {
                    let rigid = [first, second].map(|field| self.rigid == Some(field));
                    let surfaces = [&surface(first), &surface(second)];
                    let Some([of_a, of_b]) = Surface::in_contact(surfaces, is_full, rigid) else {
                        continue;
                    };
                    let (a, b) = (first * tile_len(D) + index, second * tile_len(D) + index);
                    // A mass beside which that of others is roundoff.
                    let weigh = |is_rigid: bool, mass: S| if is_rigid { mass * 1e18 } else { mass };
                    let (mass_a, mass_b) = (weigh(rigid[0], masses[a]), weigh(rigid[1], masses[b]));
                    meet((&mut low[a], mass_a, &of_a), (&mut high[index], mass_b, &of_b), friction);
                }
            }
        }
    }

    /// The surface of a body at a node, as if every plane were a mirror: what is beyond a plane is no gap. A node on a plane is
    /// its own image.
    fn surface_at(&self, place: [i32; D], field: usize) -> Surface<S, D> {
        let mut surface = Surface::none();
        let shows = |_: &Plane, depth: i32| depth.abs() <= MOST_DEPTH;
        for_each_image(self.planes, place, shows, |at, mirrors| {
            self.for_each_copy(at, field, |copy| {
                let part = &self.surfaces[copy];
                surface.fill = surface.fill + part.fill;
                for k in 0..D {
                    let part = part.outward[k];
                    let part = if mirrors[k].is_some() { -part } else { part };
                    surface.outward[k] = surface.outward[k] + part;
                }
            });
        });
        surface
    }

    /// What all blocks hold of a node, in the order of the tiles below it, and of its mass.
    pub(crate) fn sum_at(&self, place: [i32; D], field: usize) -> (Node<S, D>, S) {
        let (mut sum, mut mass) = (Node::zero(), S::constant(0.0));
        self.for_each_copy(place, field, |copy| {
            sum.add(&self.blocks[copy]);
            mass = mass + self.masses[copy];
        });
        (sum, mass)
    }

    /// Calls with the place of every copy of a node in the blocks.
    fn for_each_copy(&self, place: [i32; D], field: usize, mut visit: impl FnMut(usize)) {
        let (edge, wide) = (tile_edge(D), block_edge(D));
        let fields = Fields { n_fields: self.n_fields, field };
        let tile = tile_of(&place);
        let local: [usize; D] = std::array::from_fn(|k| {
            usize::try_from(place[k] - tile[k] * signed(edge)).unwrap_or(0)
        });
        for bits in 0..1_usize << D {
            let below = |k: usize| bits >> k & 1 == 1;
            if (0..D).any(|k| below(k) && local[k] >= HALO) {
                continue;
            }
            let from = std::array::from_fn(|k| if below(k) { tile[k] - 1 } else { tile[k] });
            let slot = self.directory.number(&from);
            if slot == NONE || !self.tiles[slot as usize].occupied {
                continue;
            }
            let mut index = 0;
            for k in (0..D).rev() {
                index = index * wide + local[k] + if below(k) { edge } else { 0 };
            }
            visit(fields.set(slot) * block_len(D) + index);
        }
    }
}

/// Fills the block of a tile from the nodes of its own and of the tiles above.
pub(crate) fn fill<S: CarriedNumber, const D: usize>(
    tile: &Tile<D>,
    owned: &[Node<S, D>],
    block: &mut [Node<S, D>],
    fields: Fields,
) {
    let (edge, wide) = (tile_edge(D), block_edge(D));
    for row in 0..block_len(D) / wide {
        let (j, k) = (row % wide, row / wide);
        let outer = 2 * usize::from(j >= edge) + 4 * usize::from(k >= edge);
        let start = row_start(edge, (j % edge, k % edge));
        let out = &mut block[row * wide..][..wide];
        let (here, beyond) = out.split_at_mut(edge);
        for (part, bits) in [(here, outer), (beyond, outer + 1)] {
            match tile.above[bits] {
                NONE => part.fill(Node::zero()),
                slot => {
                    let from = fields.set(slot) * tile_len(D) + start;
                    part.copy_from_slice(&owned[from..from + part.len()]);
                }
            }
        }
    }
}

/// Calls with a node and with the images of it that planes show, and by which plane along each axis.
fn for_each_image<'a, const D: usize>(
    planes: &'a [Plane],
    place: [i32; D],
    shows: impl Fn(&Plane, i32) -> bool,
    mut visit: impl FnMut([i32; D], [Option<&'a Plane>; D]),
) {
    // Each image of a node may have images in the planes that follow: at an edge there are three, at a corner seven.
    let mut near: [Option<&Plane>; D] = [None; D];
    for plane in planes {
        let depth = -plane.beyond(place[plane.axis]);
        if shows(plane, depth) {
            near[plane.axis] = Some(plane);
        }
    }
    for chosen in 0..1_usize << D {
        if (0..D).any(|k| chosen >> k & 1 == 1 && near[k].is_none()) {
            continue;
        }
        let mirrors: [_; D] = std::array::from_fn(|k| near[k].filter(|_| chosen >> k & 1 == 1));
        let at =
            std::array::from_fn(|k| mirrors[k].map_or(place[k], |plane| plane.image(place[k])));
        visit(at, mirrors);
    }
}

/// Nodes of a block beyond a mirror: a particle sees the image of the one on this side.
pub(crate) fn fill_images<S: CarriedNumber, const D: usize>(
    planes: &[Plane],
    (directory, tile): (&Directory<D>, &Tile<D>),
    nodes: &[Node<S, D>],
    block: &mut [Node<S, D>],
    fields: Fields,
) {
    let reaches = |plane: &Plane| {
        plane.mirrors() && plane.range_beyond(&corner_of(&tile.at), block_edge(D)).1 > 0
    };
    if !planes.iter().any(reaches) {
        return;
    }
    for (index, node) in block.iter_mut().enumerate() {
        let at = place_in_block(&tile.at, index);
        if planes.iter().any(|plane| is_behind(plane, &at)) {
            *node = image_seen_at(planes, (directory, nodes, fields), at);
        }
    }
}

/// Whether a place is beyond a mirror.
fn is_behind<const D: usize>(plane: &Plane, at: &[i32; D]) -> bool {
    plane.mirrors() && plane.beyond(at[plane.axis]) > 0
}

/// The node that particles see at a place: beyond a mirror the image of the one on this side.
pub(crate) fn image_seen_at<S: CarriedNumber, const D: usize>(
    planes: &[Plane],
    (directory, nodes, fields): (&Directory<D>, &[Node<S, D>], Fields),
    mut at: [i32; D],
) -> Node<S, D> {
    let mut mirrors = [None; D];
    // A corner is beyond a plane of each axis.
    for mirror in &mut mirrors {
        *mirror = planes.iter().find(|plane| is_behind(plane, &at));
        if let Some(plane) = mirror {
            at[plane.axis] = plane.image(at[plane.axis]);
        }
    }
    let mut node = node_at(directory, nodes, fields, at);
    for plane in mirrors.into_iter().rev().flatten() {
        *node.velocity_mut() = plane.mirrored(*node.velocity());
        *node.velocity_change_mut() = plane.mirrored(*node.velocity_change());
    }
    node
}

/// A node by its place.
fn node_at<S: CarriedNumber, const D: usize>(
    directory: &Directory<D>,
    nodes: &[Node<S, D>],
    fields: Fields,
    place: [i32; D],
) -> Node<S, D> {
    let (edge, tile) = (tile_edge(D), tile_of(&place));
    let slot = directory.number(&tile);
    if slot == NONE {
        return Node::zero();
    }
    let mut index = 0;
    for k in (0..D).rev() {
        index = index * edge + usize::try_from(place[k] - tile[k] * signed(edge)).unwrap_or(0);
    }
    nodes[fields.set(slot) * tile_len(D) + index]
}
