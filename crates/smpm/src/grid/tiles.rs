//! The tiles of nodes, and the neighbours of each.

use crate::error::Error;
use crate::grid::binning::Binning;
use crate::grid::boundary::Plane;
use crate::grid::tile_size::{block_edge, corner_of, signed, tile_edge};

/// An image is at most this far from its plane, in cells.
pub(crate) const MOST_DEPTH: i32 = 2;

/// Most tiles that the directory spans, with or without particles: 64 million entries of 4 bytes.
const MOST_TILES: usize = 1 << 26;

/// No tile here.
pub(crate) const NONE: u32 = u32::MAX;
/// Marks before tiles are numbered: the tile has particles, or only the halo of one that has.
const OCCUPIED: u32 = 0;
pub(crate) const HALO_ONLY: u32 = 1;

/// Which tiles exist, and where each is kept.
#[derive(Debug)]
pub(crate) struct Directory<const D: usize> {
    low: [i32; D],
    extent: [usize; D],
    slots: Vec<u32>,
}

impl<const D: usize> Directory<D> {
    /// Spans the tiles from `low` to `high`, all absent.
    fn span(&mut self, low: [i32; D], high: [i32; D]) -> Result<(), Error> {
        let mut total = 1_usize;
        self.low = low;
        for k in 0..D {
            let extent = usize::try_from(i64::from(high[k]) - i64::from(low[k]) + 1).unwrap_or(0);
            self.extent[k] = extent;
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

    /// The slot of a tile, or [`NONE`].
    pub(crate) fn number(&self, tile: &[i32; D]) -> u32 {
        self.index(tile).map_or(NONE, |index| self.slots[index])
    }
}

/// Nodes of blocks and halos around it still have numbers.
const FARTHEST_NODE: i32 = i32::MAX / 2;

/// Neighbours that share nodes with a tile's block, itself among them: bit `k` of their number says whether they are one
/// tile further along axis `k`.
const NEIGHBOURS: usize = 8;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Tile<const D: usize> {
    pub(crate) at: [i32; D],
    /// Whether it has particles; else it only holds the halo of those below.
    pub(crate) occupied: bool,
    /// Whether no plane acts on its nodes or those of its halo.
    pub(crate) plain: bool,
    /// Slots of the tiles below that have particles, or [`NONE`].
    pub(crate) below: [u32; NEIGHBOURS],
    /// Slots of the tiles above, or [`NONE`].
    pub(crate) above: [u32; NEIGHBOURS],
}

impl<const D: usize> Tile<D> {
    fn is_plain(&self, planes: &[Plane]) -> bool {
        let (low, reach) = (corner_of(&self.at), signed(block_edge(D)) - 1);
        planes.iter().all(|plane| {
            let low = low[plane.axis];
            plane.beyond(low).max(plane.beyond(low + reach)) < -MOST_DEPTH
        })
    }
}

/// The tiles with particles, and those that hold their halos.
#[derive(Debug)]
pub(crate) struct Tiles<const D: usize> {
    pub(crate) directory: Directory<D>,
    /// By slot.
    pub(crate) all: Vec<Tile<D>>,
    /// Places in the directory of the tiles with particles.
    occupied: Vec<usize>,
}

impl<const D: usize> Tiles<D> {
    pub(crate) fn none() -> Self {
        let directory = Directory { low: [0; D], extent: [0; D], slots: vec![] };
        Self { directory, all: vec![], occupied: vec![] }
    }

    /// Finds the tiles that particles see, by their runs.
    pub(crate) fn allocate<'a>(
        &mut self,
        bodies: impl Iterator<Item = &'a Binning<D>> + Clone,
        planes: &[Plane],
    ) -> Result<(), Error> {
        let (mut low, mut high) = ([i32::MAX; D], [i32::MIN; D]);
        for run in bodies.clone().flat_map(|binning| &binning.runs) {
            for k in 0..D {
                low[k] = low[k].min(run.tile[k]);
                high[k] = high[k].max(run.tile[k]);
            }
        }
        let farthest_tile = FARTHEST_NODE / signed(tile_edge(D));
        if low.iter().chain(&high).any(|tile| tile.abs() >= farthest_tile) {
            check_places(&bodies)?;
        }
        // One more tile above: halos belong to it.
        let high = high.map(|tile| tile + 1);
        self.directory.span(low, high)?;
        self.occupied.clear();
        for run in bodies.flat_map(|binning| &binning.runs) {
            if let Some(index) = self.directory.index(&run.tile)
                && self.directory.slots[index] == NONE
            {
                self.directory.slots[index] = OCCUPIED;
                self.occupied.push(index);
            }
        }
        self.number(low, planes);
        Ok(())
    }

    /// Numbers the tiles that were marked and those that hold their halos, in the order of the directory.
    fn number(&mut self, low: [i32; D], planes: &[Plane]) {
        let Self { directory, all: tiles, occupied } = self;
        for &index in &*occupied {
            for bits in 1..1_usize << D {
                let (mut neighbour, mut stride) = (index, 1);
                for k in 0..D {
                    neighbour += stride * (bits >> k & 1);
                    stride *= directory.extent[k];
                }
                if directory.slots[neighbour] == NONE {
                    directory.slots[neighbour] = HALO_ONLY;
                }
            }
        }
        tiles.clear();
        for index in 0..directory.slots.len() {
            let mark = directory.slots[index];
            if mark == NONE {
                continue;
            }
            directory.slots[index] = u32::try_from(tiles.len()).unwrap_or(NONE);
            let mut rest = index;
            let at = std::array::from_fn(|k| {
                let offset = rest % directory.extent[k];
                rest /= directory.extent[k];
                low[k] + i32::try_from(offset).unwrap_or(0)
            });
            let none = [NONE; NEIGHBOURS];
            let mut tile =
                Tile { at, occupied: mark == OCCUPIED, plain: false, below: none, above: none };
            tile.plain = tile.is_plain(planes);
            tiles.push(tile);
        }
        for slot in 0..tiles.len() {
            for bits in 0..1_usize << D {
                let along = |step: i32| {
                    let at = tiles[slot].at;
                    directory.number(&std::array::from_fn(|k| {
                        at[k] + if bits >> k & 1 == 1 { step } else { 0 }
                    }))
                };
                let (below, above) = (along(-1), along(1));
                if below != NONE && tiles[below as usize].occupied {
                    tiles[slot].below[bits] = below;
                }
                tiles[slot].above[bits] = above;
            }
        }
    }
}

/// Refuses particles whose lowest node is too far away for halos around it to have numbers.
fn check_places<'a, const D: usize>(
    bodies: &(impl Iterator<Item = &'a Binning<D>> + Clone),
) -> Result<(), Error> {
    for k in 0..D {
        let (mut low, mut high) = (i32::MAX, i32::MIN);
        for base in bodies.clone().flat_map(|binning| &binning.bases) {
            low = low.min(base[k]);
            high = high.max(base[k]);
        }
        // A place too far away for a number ends up at the ends of the type.
        let farthest = if i64::from(high) > -i64::from(low) { high } else { low };
        if i64::from(farthest).abs() > i64::from(FARTHEST_NODE) {
            return Err(Error::FarFromOrigin { node: farthest, limit: FARTHEST_NODE });
        }
    }
    Ok(())
}
