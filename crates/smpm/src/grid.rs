//! The background grid: nodes in tiles, allocated where particles are.

use crate::boundary::Plane;
use crate::error::Error;
use crate::number::Number;
use crate::parallel::for_each_large;
use crate::shape::MOST_NODES;

/// Nodes of a block beyond its tile along each axis: a particle of the tile sees them.
const HALO: usize = MOST_NODES - 1;

/// An image is at most this far from its plane, in cells.
const MOST_DEPTH: i32 = 2;

/// Most tiles that the directory spans, with or without particles: 64 million entries of 4 bytes.
const MOST_TILES: usize = 1 << 26;

/// No tile here.
const NONE: u32 = u32::MAX;

/// Nodes of a tile along an axis.
pub(crate) const fn tile_edge(dimension: usize) -> usize {
    match dimension {
        1 => 16,
        2 => 8,
        _ => 4,
    }
}

/// Nodes of a block along an axis.
pub(crate) const fn block_edge(dimension: usize) -> usize {
    tile_edge(dimension) + HALO
}

const fn power(base: usize, exponent: usize) -> usize {
    let (mut value, mut k) = (1, 0);
    while k < exponent {
        value *= base;
        k += 1;
    }
    value
}

/// Nodes of a block.
pub(crate) const fn block_len(dimension: usize) -> usize {
    power(block_edge(dimension), dimension)
}

const fn tile_len(dimension: usize) -> usize {
    power(tile_edge(dimension), dimension)
}

/// A node. While particles give: mass, momentum, force. While they take: mass, velocity, change of velocity over the step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node<S, const D: usize> {
    pub(crate) mass: S,
    pub(crate) motion: [S; D],
    pub(crate) change: [S; D],
}

impl<S: Number, const D: usize> Node<S, D> {
    fn zero() -> Self {
        let zero = S::constant(0.0);
        Self { mass: zero, motion: [zero; D], change: [zero; D] }
    }

    #[inline]
    fn add(&mut self, other: &Self) {
        self.mass = self.mass + other.mass;
        for k in 0..D {
            self.motion[k] = self.motion[k] + other.motion[k];
            self.change[k] = self.change[k] + other.change[k];
        }
    }
}

/// Which tiles exist, and where each is kept.
#[derive(Debug, Default)]
struct Directory<const D: usize> {
    low: Vec<i32>,
    extent: Vec<usize>,
    slots: Vec<u32>,
}

impl<const D: usize> Directory<D> {
    /// Spans the tiles from `low` to `high`, all absent.
    fn span(&mut self, low: [i32; D], high: [i32; D]) -> Result<(), Error> {
        let mut total = 1_usize;
        self.low = low.to_vec();
        self.extent.clear();
        for k in 0..D {
            let extent = usize::try_from(i64::from(high[k]) - i64::from(low[k]) + 1).unwrap_or(0);
            self.extent.push(extent);
            total = total.saturating_mul(extent);
        }
        if total > MOST_TILES {
            return Err(Error::GridTooLarge { tiles: total, limit: MOST_TILES });
        }
        self.slots.clear();
        self.slots.resize(total, NONE);
        Ok(())
    }

    fn index(&self, tile: &[i32; D]) -> Option<usize> {
        let mut index = 0;
        for k in (0..D).rev() {
            let offset = usize::try_from(i64::from(tile[k]) - i64::from(self.low[k])).ok()?;
            if offset >= self.extent[k] {
                return None;
            }
            index = index * self.extent[k] + offset;
        }
        Some(index)
    }

    fn slot(&self, tile: &[i32; D]) -> Option<usize> {
        let slot = self.number(tile);
        (slot != NONE).then_some(slot as usize)
    }

    /// The slot of a tile, or [`NONE`].
    fn number(&self, tile: &[i32; D]) -> u32 {
        self.index(tile).map_or(NONE, |index| self.slots[index])
    }
}

/// Who stands in which tile: particles of one body by the slot of their tile.
#[derive(Debug, Default)]
pub(crate) struct Binning {
    /// The slot of each particle's tile.
    pub(crate) slot: Vec<u32>,
    /// Particles by slot, ascending within each.
    order: Vec<u32>,
    /// Where the particles of a slot begin in `order`.
    starts: Vec<u32>,
}

impl Binning {
    /// The particles of a tile.
    pub(crate) fn of(&self, slot: usize) -> &[u32] {
        &self.order[self.starts[slot] as usize..self.starts[slot + 1] as usize]
    }

    fn sort(&mut self, n_slots: usize) {
        self.starts.clear();
        self.starts.resize(n_slots + 1, 0);
        for &slot in &self.slot {
            self.starts[slot as usize + 1] += 1;
        }
        for k in 0..n_slots {
            self.starts[k + 1] += self.starts[k];
        }
        let mut next = self.starts.clone();
        self.order.resize(self.slot.len(), 0);
        for (particle, &slot) in (0_u32..).zip(&self.slot) {
            let place = &mut next[slot as usize];
            self.order[*place as usize] = particle;
            *place += 1;
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
    directory: Directory<D>,
    tiles: Vec<[i32; D]>,
    /// One block for each tile, with its halo.
    pub(crate) blocks: Vec<Node<S, D>>,
    /// The nodes themselves: one set for each tile, no halo.
    nodes: Vec<Node<S, D>>,
}

impl<S: Number, const D: usize> Grid<S, D> {
    pub(crate) fn new(cell: f64, origin: [f64; D], planes: Vec<Plane>) -> Self {
        let directory = Directory { low: vec![], extent: vec![], slots: vec![] };
        Self { cell, origin, planes, directory, tiles: vec![], blocks: vec![], nodes: vec![] }
    }

    /// Allocates the tiles that the particles see, and sorts the particles of every body by tile. `bases[b][p]` is the lowest
    /// node that a particle sees.
    pub(crate) fn allocate<'a>(
        &mut self,
        bodies: impl Iterator<Item = (&'a [[i32; D]], &'a mut Binning)>,
    ) -> Result<(), Error> {
        let edge = i32::try_from(tile_edge(D)).unwrap_or(i32::MAX);
        let tile_of = |base: &[i32; D]| base.map(|node| node.div_euclid(edge));
        let mut bodies: Vec<_> = bodies.collect();
        let (mut low, mut high) = ([i32::MAX; D], [i32::MIN; D]);
        for base in bodies.iter().flat_map(|(bases, _)| bases.iter()) {
            for k in 0..D {
                low[k] = low[k].min(base[k]);
                high[k] = high[k].max(base[k]);
            }
        }
        // One more tile above: halos belong to it.
        let (low, mut high) = (tile_of(&low), tile_of(&high));
        for k in 0..D {
            high[k] += 1;
        }
        self.directory.span(low, high)?;
        for base in bodies.iter().flat_map(|(bases, _)| bases.iter()) {
            let tile = tile_of(base);
            if self.directory.slot(&tile).is_some_and(|slot| slot == 0) {
                continue;
            }
            if let Some(index) = self.directory.index(&tile) {
                self.directory.slots[index] = 0;
            }
        }
        self.number_tiles(low);
        for (bases, binning) in &mut bodies {
            binning.slot.clear();
            binning.slot.extend(bases.iter().map(|base| self.directory.number(&tile_of(base))));
            binning.sort(self.tiles.len());
        }
        self.blocks.resize(self.tiles.len() * block_len(D), Node::zero());
        self.nodes.resize(self.tiles.len() * tile_len(D), Node::zero());
        Ok(())
    }

    /// Numbers the tiles that were marked and those that hold their halos, in the order of the directory.
    fn number_tiles(&mut self, low: [i32; D]) {
        let directory = &mut self.directory;
        let marked: Vec<usize> =
            (0..directory.slots.len()).filter(|&index| directory.slots[index] != NONE).collect();
        for index in marked {
            for bits in 1..1_usize << D {
                let (mut neighbour, mut stride) = (index, 1);
                for k in 0..D {
                    neighbour += stride * (bits >> k & 1);
                    stride *= directory.extent[k];
                }
                directory.slots[neighbour] = 0;
            }
        }
        self.tiles.clear();
        for index in 0..directory.slots.len() {
            if directory.slots[index] == NONE {
                continue;
            }
            directory.slots[index] = u32::try_from(self.tiles.len()).unwrap_or(NONE);
            let mut rest = index;
            self.tiles.push(std::array::from_fn(|k| {
                let offset = rest % directory.extent[k];
                rest /= directory.extent[k];
                low[k] + i32::try_from(offset).unwrap_or(0)
            }));
        }
    }

    /// The lowest node of a tile's block.
    pub(crate) fn corner(&self, slot: usize) -> [i32; D] {
        let edge = i32::try_from(tile_edge(D)).unwrap_or(i32::MAX);
        self.tiles[slot].map(|tile| tile * edge)
    }

    /// Lets every tile's particles write into its cleared block: `give(slot, block)`.
    pub(crate) fn collect(&mut self, give: impl Fn(usize, [i32; D], &mut [Node<S, D>]) + Sync) {
        let corners: Vec<_> = (0..self.tiles.len()).map(|slot| self.corner(slot)).collect();
        let mut blocks: Vec<_> = self.blocks.chunks_mut(block_len(D)).collect();
        for_each_large(&mut blocks, |slot, block| {
            block.fill(Node::zero());
            give(slot, corners[slot], block);
        });
    }

    /// Nodes collect what the blocks hold of them: mass, momentum, force, with the images at planes; then the velocity, its
    /// change over `dt` by the force, and what the planes make of them; then the blocks are filled with them again.
    ///
    /// Nodes lighter than `smallest_mass` stand still: their acceleration would be a quotient of roundoff.
    pub(crate) fn solve(&mut self, dt: f64, smallest_mass: f64) {
        let Self { cell, planes, directory, tiles, blocks, nodes, .. } = self;
        let (planes, directory, tiles, cell) = (&*planes, &*directory, &*tiles, *cell);
        let edge = tile_edge(D);
        let collected = &*blocks;
        let mut owned: Vec<_> = nodes.chunks_mut(tile_len(D)).collect();
        for_each_large(&mut owned, |slot, owned| {
            for (index, node) in owned.iter_mut().enumerate() {
                let place = place::<D>(&tiles[slot], index, edge);
                *node = with_images(planes, place, |at| sum_at(directory, collected, at));
                velocity_of(node, dt, smallest_mass);
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
        });
        let owned = &*nodes;
        let mut filled: Vec<_> = blocks.chunks_mut(block_len(D)).collect();
        for_each_large(&mut filled, |slot, block| {
            for (index, node) in block.iter_mut().enumerate() {
                let place = place_in_block::<D>(&tiles[slot], index);
                *node = seen_at(planes, directory, owned, place);
            }
        });
    }

    /// Tiles that exist.
    pub(crate) fn n_tiles(&self) -> usize {
        self.tiles.len()
    }
}

/// Momentum and force become velocity and its change.
fn velocity_of<S: Number, const D: usize>(node: &mut Node<S, D>, dt: f64, smallest_mass: f64) {
    if node.mass.value() <= smallest_mass {
        *node = Node::zero();
        return;
    }
    let inverse = node.mass.recip();
    for k in 0..D {
        node.motion[k] = node.motion[k] * inverse;
        node.change[k] = node.change[k] * inverse * dt;
    }
}

fn place<const D: usize>(tile: &[i32; D], index: usize, edge: usize) -> [i32; D] {
    let (mut rest, edge_i32) = (index, i32::try_from(edge).unwrap_or(i32::MAX));
    std::array::from_fn(|k| {
        let local = rest % edge;
        rest /= edge;
        tile[k] * edge_i32 + i32::try_from(local).unwrap_or(0)
    })
}

fn place_in_block<const D: usize>(tile: &[i32; D], index: usize) -> [i32; D] {
    let edge = i32::try_from(tile_edge(D)).unwrap_or(i32::MAX);
    let block = place::<D>(&[0; D], index, block_edge(D));
    std::array::from_fn(|k| tile[k] * edge + block[k])
}

/// What all blocks hold of a node, in the order of the tiles below it.
fn sum_at<S: Number, const D: usize>(
    directory: &Directory<D>,
    blocks: &[Node<S, D>],
    place: [i32; D],
) -> Node<S, D> {
    let (edge, wide) = (tile_edge(D), block_edge(D));
    let edge_i32 = i32::try_from(edge).unwrap_or(i32::MAX);
    let tile = place.map(|node| node.div_euclid(edge_i32));
    let local: [usize; D] =
        std::array::from_fn(|k| usize::try_from(place[k].rem_euclid(edge_i32)).unwrap_or(0));
    let mut sum = Node::zero();
    for bits in 0..1_usize << D {
        let below = |k: usize| bits >> k & 1 == 1;
        if (0..D).any(|k| below(k) && local[k] >= HALO) {
            continue;
        }
        let from = std::array::from_fn(|k| if below(k) { tile[k] - 1 } else { tile[k] });
        let Some(slot) = directory.slot(&from) else { continue };
        let mut index = 0;
        for k in (0..D).rev() {
            index = index * wide + local[k] + if below(k) { edge } else { 0 };
        }
        sum.add(&blocks[slot * block_len(D) + index]);
    }
    sum
}

/// What a node holds with the images of what stands beyond mirrors.
fn with_images<S: Number, const D: usize>(
    planes: &[Plane],
    place: [i32; D],
    sum: impl Fn([i32; D]) -> Node<S, D>,
) -> Node<S, D> {
    let mut total = sum(place);
    // Each image of a node may have images in the planes that follow: at an edge there are three, at a corner seven.
    let mut images = vec![];
    for (number, plane) in planes.iter().enumerate() {
        let depth = -plane.beyond(place[plane.axis]);
        if plane.mirrors() && (1..=MOST_DEPTH).contains(&depth) {
            images.push(number);
        }
    }
    for chosen in 1..1_usize << images.len() {
        let mut at = place;
        for (k, &number) in images.iter().enumerate() {
            if chosen >> k & 1 == 1 {
                at[planes[number].axis] = planes[number].image(at[planes[number].axis]);
            }
        }
        let mut image = sum(at);
        for (k, &number) in images.iter().enumerate() {
            if chosen >> k & 1 == 1 {
                image.motion = planes[number].mirrored(image.motion);
                image.change = planes[number].mirrored(image.change);
            }
        }
        total.add(&image);
    }
    total
}

/// A node as a particle sees it: beyond a mirror, the image of the one on this side.
fn seen_at<S: Number, const D: usize>(
    planes: &[Plane],
    directory: &Directory<D>,
    nodes: &[Node<S, D>],
    place: [i32; D],
) -> Node<S, D> {
    let behind = planes.iter().find(|plane| plane.mirrors() && plane.beyond(place[plane.axis]) > 0);
    if let Some(plane) = behind {
        let mut at = place;
        at[plane.axis] = plane.image(at[plane.axis]);
        let mut node = seen_at(planes, directory, nodes, at);
        node.motion = plane.mirrored(node.motion);
        node.change = plane.mirrored(node.change);
        return node;
    }
    let edge = tile_edge(D);
    let edge_i32 = i32::try_from(edge).unwrap_or(i32::MAX);
    let tile = place.map(|node| node.div_euclid(edge_i32));
    let Some(slot) = directory.slot(&tile) else { return Node::zero() };
    let mut index = 0;
    for k in (0..D).rev() {
        index = index * edge + usize::try_from(place[k].rem_euclid(edge_i32)).unwrap_or(0);
    }
    nodes[slot * tile_len(D) + index]
}
