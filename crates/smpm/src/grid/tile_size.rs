//! How many nodes tiles and blocks have, and which of them a node belongs to.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

/// Most nodes that a particle sees along an axis.
pub(crate) const MOST_NODES: usize = 4;

/// Nodes of a block beyond its tile along each axis: a particle of the tile sees them.
pub(crate) const HALO: usize = MOST_NODES - 1;

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

pub(crate) const fn tile_len(dimension: usize) -> usize {
    power(tile_edge(dimension), dimension)
}

/// The tile that a node belongs to.
#[inline(always)]
pub(crate) fn tile_of<const D: usize>(node: &[i32; D]) -> [i32; D] {
    let mut tile = *node;
    for place in &mut tile {
        // Edges are powers of two: the quotient rounded down.
        *place >>= const { tile_edge(D).trailing_zeros() };
    }
    tile
}

/// The lowest node of a tile.
#[inline(always)]
pub(crate) fn corner_of<const D: usize>(tile: &[i32; D]) -> [i32; D] {
    let mut corner = *tile;
    for place in &mut corner {
        *place *= signed(tile_edge(D));
    }
    corner
}

/// A length within a block: far below the range of the type.
#[inline(always)]
pub(crate) fn signed(length: usize) -> i32 {
    i32::try_from(length).unwrap_or(i32::MAX)
}
