//! The background grid: nodes in tiles, allocated where particles are.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use perturbation_moments::in_widest_registers;

use crate::body::Body;
use crate::boundary::Plane;
use crate::config::{Config, Contact};
use crate::contact::meet;
use crate::error::Error;
use crate::number::Number;
use crate::parallel::for_each_chunk;
use crate::tiles::{
    Directory, HALO, MOST_DEPTH, NONE, Tile, Tiles, block_edge, block_len, signed, tile_edge,
    tile_len, tile_of,
};

/// A node. While particles give: mass, momentum, force. While they take: mass, velocity, change of velocity over the step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node<S, const D: usize> {
    pub(crate) mass: S,
    pub(crate) motion: [S; D],
    pub(crate) change: [S; D],
}

impl<S: Number, const D: usize> Node<S, D> {
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        let zero = S::constant(0.0);
        Self { mass: zero, motion: [zero; D], change: [zero; D] }
    }

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        self.mass = self.mass + other.mass;
        for k in 0..D {
            self.motion[k] = self.motion[k] + other.motion[k];
            self.change[k] = self.change[k] + other.change[k];
        }
    }
}

/// The nodes of all tiles.
///
/// Particles of a tile write into the tile's own block, which has a halo; nodes then collect from the blocks that hold a copy
/// of them, always in the same order. No two threads write the same entry, and no bit depends on how many there are.
#[derive(Debug)]
pub(crate) struct Grid<S, const D: usize> {
    pub(crate) cell: f64,
    pub(crate) origin: [f64; D],
    planes: Vec<Plane>,
    tiles: Tiles<D>,
    /// A block for each tile, with its halo.
    blocks: Vec<Node<S, D>>,
    /// The nodes themselves: a set for each tile, no halo.
    nodes: Vec<Node<S, D>>,
    /// Fields of nodes: one that all bodies share, or one for each. Blocks and sets of a tile stand together.
    n_fields: usize,
    /// Coulomb's coefficient where bodies have their own fields.
    friction: Option<f64>,
    /// Like the blocks, the gradients of the masses of the bodies; empty where they share a field.
    outward: Vec<[S; D]>,
}

/// What the nodes do with what they were given.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Solve {
    /// The step; zero where velocities alone are asked for.
    pub(crate) dt: f64,
    /// Nodes lighter than this stand still: their acceleration would be a quotient of roundoff.
    pub(crate) smallest_mass: f64,
    /// Whether masses were given too; else they are those of the last time.
    pub(crate) with_mass: bool,
}

impl<S: Number, const D: usize> Grid<S, D> {
    pub(crate) fn new(config: &Config<D>, planes: Vec<Plane>, n_bodies: usize) -> Self {
        let (n_fields, friction) = match config.contact {
            Contact::Friction { coefficient } if n_bodies > 1 => (n_bodies, Some(coefficient)),
            _ => (1, None),
        };
        Self {
            cell: config.cell,
            origin: config.origin,
            planes,
            tiles: Tiles::none(),
            blocks: vec![],
            nodes: vec![],
            n_fields,
            friction,
            outward: vec![],
        }
    }

    /// The field of a body.
    pub(crate) fn field(&self, body: usize) -> usize {
        body.min(self.n_fields - 1)
    }

    /// Whether bodies have fields of their own.
    pub(crate) fn has_contact(&self) -> bool {
        self.friction.is_some()
    }

    /// Allocates the tiles that the particles see, and sorts the particles of every body by tile.
    pub(crate) fn allocate(&mut self, bodies: &mut [Body<S, D>]) -> Result<(), Error> {
        for body in &mut *bodies {
            body.binning.find_runs();
        }
        self.tiles.allocate(bodies.iter().map(|body| &body.binning), &self.planes)?;
        for body in bodies {
            let Tiles { directory, all, .. } = &self.tiles;
            body.binning.bin(all.len(), |tile| directory.number(tile));
        }
        let n_sets = self.tiles.all.len() * self.n_fields;
        self.blocks.resize(n_sets * block_len(D), Node::zero());
        self.nodes.resize(n_sets * tile_len(D), Node::zero());
        if self.has_contact() {
            self.outward.resize(n_sets * block_len(D), [S::constant(0.0); D]);
        }
        Ok(())
    }

    /// The lowest node of a tile's block.
    #[inline(always)]
    pub(crate) fn corner(&self, slot: usize) -> [i32; D] {
        self.tiles.all[slot].corner()
    }

    /// The block of a tile in a field.
    #[inline(always)]
    pub(crate) fn block(&self, slot: usize, field: usize) -> &[Node<S, D>] {
        &self.blocks[(slot * self.n_fields + field) * block_len(D)..][..block_len(D)]
    }

    /// Lets every tile's particles write into its cleared blocks, one for each field: `give(slot, corner, blocks)`.
    pub(crate) fn collect(&mut self, give: impl Fn(usize, [i32; D], &mut [Node<S, D>]) + Sync) {
        let tiles = &self.tiles.all;
        for_each_chunk(&mut self.blocks, self.n_fields * block_len(D), |slot, blocks| {
            if tiles[slot].occupied {
                blocks.fill(Node::zero());
                give(slot, tiles[slot].corner(), blocks);
            }
        });
    }

    /// The same for the gradients of masses.
    pub(crate) fn collect_outward(&mut self, give: impl Fn(usize, [i32; D], &mut [[S; D]]) + Sync) {
        let tiles = &self.tiles.all;
        for_each_chunk(&mut self.outward, self.n_fields * block_len(D), |slot, blocks| {
            if tiles[slot].occupied {
                blocks.fill([S::constant(0.0); D]);
                give(slot, tiles[slot].corner(), blocks);
            }
        });
    }

    /// Nodes collect what the blocks hold of them: mass, momentum, force, with the images at planes; then the velocity, its
    /// change over the step by the force and by contact, and what the planes make of them; then the blocks are filled with
    /// them again.
    pub(crate) fn solve(&mut self, solve: Solve) {
        let Self { cell, planes, tiles, blocks, nodes, n_fields, friction, outward, .. } = self;
        let Tiles { directory, all: tiles, .. } = &*tiles;
        let (planes, cell) = (&*planes, *cell);
        let (n_fields, friction) = (*n_fields, *friction);
        let given = Given { directory, tiles, planes, n_fields, blocks, outward };
        for_each_chunk(nodes, n_fields * tile_len(D), |slot, owned| {
            let tile = &tiles[slot];
            in_widest_registers(
                #[inline(always)]
                || {
                    for field in 0..n_fields {
                        let owned = &mut owned[field * tile_len(D)..][..tile_len(D)];
                        if tile.plain {
                            given.collect(tile, owned, field, solve.with_mass);
                        } else {
                            given.collect_at_planes(tile, owned, field, solve.with_mass);
                        }
                        for node in owned {
                            velocity_of(node, solve);
                        }
                    }
                    // Velocities that particles give once more hold what contact did to them.
                    if let Some(coefficient) = friction.filter(|_| solve.dt > 0.0) {
                        given.let_meet(tile, owned, coefficient);
                    }
                    if tile.plain {
                        for node in &mut *owned {
                            for k in 0..D {
                                node.motion[k] = node.motion[k] + node.change[k];
                            }
                        }
                    } else {
                        constrain(tile, owned, planes, (solve.dt, cell));
                    }
                },
            );
        });
        let owned = &*nodes;
        for_each_chunk(blocks, block_len(D), |set, block| {
            let tile = &tiles[set / n_fields];
            if !tile.occupied {
                return;
            }
            let fields = Fields { n_fields, field: set % n_fields };
            if tile.plain {
                fill(tile, owned, block, fields);
                return;
            }
            for (index, node) in block.iter_mut().enumerate() {
                let place = place_in_block::<D>(&tile.at, index);
                *node = seen_at(planes, directory, owned, fields, place);
            }
        });
    }

    /// Tiles that exist.
    pub(crate) fn n_tiles(&self) -> usize {
        self.tiles.all.len()
    }
}

/// Momentum and force become velocity and its change.
#[inline(always)]
fn velocity_of<S: Number, const D: usize>(node: &mut Node<S, D>, solve: Solve) {
    if node.mass.value() <= solve.smallest_mass {
        *node = Node::zero();
        return;
    }
    let inverse = node.mass.recip();
    for k in 0..D {
        node.motion[k] = node.motion[k] * inverse;
    }
    if solve.dt > 0.0 {
        let inverse = inverse * solve.dt;
        for k in 0..D {
            node.change[k] = node.change[k] * inverse;
        }
    }
}

fn place<const D: usize>(tile: &[i32; D], index: usize, edge: usize) -> [i32; D] {
    let mut rest = index;
    std::array::from_fn(|k| {
        let local = rest % edge;
        rest /= edge;
        tile[k] * signed(edge) + signed(local)
    })
}

fn place_in_block<const D: usize>(tile: &[i32; D], index: usize) -> [i32; D] {
    let block = place::<D>(&[0; D], index, block_edge(D));
    std::array::from_fn(|k| tile[k] * signed(tile_edge(D)) + block[k])
}

/// Where a row of nodes, the first axis along it, begins in a box of nodes: `edge` along each axis, for the row `(j, k)`.
#[inline(always)]
fn row_start(edge: usize, (j, k): (usize, usize)) -> usize {
    (k * edge + j) * edge
}

/// Sets velocities where planes act.
fn constrain<S: Number, const D: usize>(
    tile: &Tile<D>,
    owned: &mut [Node<S, D>],
    planes: &[Plane],
    (dt, cell): (f64, f64),
) {
    for (index, node) in owned.iter_mut().enumerate() {
        let place = place::<D>(&tile.at, index % tile_len(D), tile_edge(D));
        // Mirrors hold before the step too: what the image takes from the momentum is no change.
        let mut before: [S; D] = node.motion;
        for plane in planes.iter().filter(|plane| plane.mirrors()) {
            plane.constrain(place[plane.axis], (dt, cell), &mut before);
        }
        let mut after: [S; D] = std::array::from_fn(|k| before[k] + node.change[k]);
        for plane in planes {
            plane.constrain(place[plane.axis], (dt, cell), &mut after);
        }
        for k in 0..D {
            node.change[k] = after[k] - before[k];
        }
        node.motion = after;
    }
}

/// Which of how many fields.
#[derive(Debug, Clone, Copy)]
struct Fields {
    n_fields: usize,
    field: usize,
}

impl Fields {
    /// The number of a tile's set in this field.
    fn set(self, slot: u32) -> usize {
        slot as usize * self.n_fields + self.field
    }
}

/// What particles gave, by blocks.
struct Given<'a, S, const D: usize> {
    directory: &'a Directory<D>,
    tiles: &'a [Tile<D>],
    planes: &'a [Plane],
    n_fields: usize,
    blocks: &'a [Node<S, D>],
    outward: &'a [[S; D]],
}

impl<S: Number, const D: usize> Given<'_, S, D> {
    /// What all blocks hold of the nodes of a tile, row by row, in the order of the tiles below.
    #[inline(always)]
    fn collect(&self, tile: &Tile<D>, owned: &mut [Node<S, D>], field: usize, with_mass: bool) {
        let fields = Fields { n_fields: self.n_fields, field };
        let (edge, wide) = (tile_edge(D), block_edge(D));
        for row in 0..tile_len(D) / edge {
            let (j, k) = (row % edge, row / edge);
            let out = &mut owned[row * edge..][..edge];
            for node in &mut *out {
                let mass = if with_mass { S::constant(0.0) } else { node.mass };
                *node = Node { mass, ..Node::zero() };
            }
            for bits in 0..1_usize << D {
                let (beyond_j, beyond_k) = (bits >> 1 & 1, bits >> 2 & 1);
                if tile.below[bits] == NONE
                    || (beyond_j == 1 && j >= HALO)
                    || (beyond_k == 1 && k >= HALO)
                {
                    continue;
                }
                let block = &self.blocks[fields.set(tile.below[bits]) * block_len(D)..];
                let start = row_start(wide, (j + beyond_j * edge, k + beyond_k * edge));
                let from = if bits & 1 == 1 {
                    &block[start + edge..start + wide]
                } else {
                    &block[start..start + edge]
                };
                for (node, given) in out.iter_mut().zip(from) {
                    node.add(given);
                }
            }
        }
    }

    /// The same where planes act.
    fn collect_at_planes(
        &self,
        tile: &Tile<D>,
        owned: &mut [Node<S, D>],
        field: usize,
        with_mass: bool,
    ) {
        for (index, node) in owned.iter_mut().enumerate() {
            let place = place::<D>(&tile.at, index, tile_edge(D));
            let mass = node.mass;
            *node = Node::zero();
            for_each_image(self.planes, place, |at, mirrors| {
                let mut image = self.sum_at(at, field);
                for plane in mirrors.into_iter().flatten() {
                    image.motion = plane.mirrored(image.motion);
                    image.change = plane.mirrored(image.change);
                }
                node.add(&image);
            });
            if !with_mass {
                node.mass = mass;
            }
        }
    }

    /// Lets all pairs of bodies meet at the nodes of a tile, in the order of their numbers.
    #[inline(always)]
    fn let_meet(&self, tile: &Tile<D>, owned: &mut [Node<S, D>], coefficient: f64) {
        for index in 0..tile_len(D) {
            for second in 1..self.n_fields {
                let (low, high) = owned.split_at_mut(second * tile_len(D));
                let b = &mut high[index];
                if b.mass.value() <= 0.0 {
                    continue;
                }
                for first in 0..second {
                    let a = &mut low[first * tile_len(D) + index];
                    if a.mass.value() <= 0.0 {
                        continue;
                    }
                    let place = place::<D>(&tile.at, index, tile_edge(D));
                    meet((a, self.outward_at(place, first)), b, coefficient);
                }
            }
        }
    }

    /// The gradient of the mass of a body at a node, with its images.
    fn outward_at(&self, place: [i32; D], field: usize) -> [S; D] {
        let mut outward = [S::constant(0.0); D];
        for_each_image(self.planes, place, |at, mirrors| {
            self.for_each_copy(at, field, |copy| {
                for k in 0..D {
                    let part = self.outward[copy][k];
                    outward[k] = outward[k] + if mirrors[k].is_some() { -part } else { part };
                }
            });
        });
        outward
    }

    /// What all blocks hold of a node, in the order of the tiles below it.
    fn sum_at(&self, place: [i32; D], field: usize) -> Node<S, D> {
        let mut sum = Node::zero();
        self.for_each_copy(place, field, |copy| sum.add(&self.blocks[copy]));
        sum
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
fn fill<S: Number, const D: usize>(
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

/// Calls with a node and with the images of it that mirrors show, and by which mirror along each axis.
fn for_each_image<'a, const D: usize>(
    planes: &'a [Plane],
    place: [i32; D],
    mut visit: impl FnMut([i32; D], [Option<&'a Plane>; D]),
) {
    // Each image of a node may have images in the planes that follow: at an edge there are three, at a corner seven.
    let mut near: [Option<&Plane>; D] = [None; D];
    for plane in planes {
        let depth = -plane.beyond(place[plane.axis]);
        if plane.mirrors() && (1..=MOST_DEPTH).contains(&depth) {
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

/// A node as a particle sees it: beyond a mirror, the image of the one on this side.
fn seen_at<S: Number, const D: usize>(
    planes: &[Plane],
    directory: &Directory<D>,
    nodes: &[Node<S, D>],
    fields: Fields,
    place: [i32; D],
) -> Node<S, D> {
    let behind = planes.iter().find(|plane| plane.mirrors() && plane.beyond(place[plane.axis]) > 0);
    if let Some(plane) = behind {
        let mut at = place;
        at[plane.axis] = plane.image(at[plane.axis]);
        let mut node = seen_at(planes, directory, nodes, fields, at);
        node.motion = plane.mirrored(node.motion);
        node.change = plane.mirrored(node.change);
        return node;
    }
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
