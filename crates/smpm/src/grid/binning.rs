//! The tile of each particle, and the order in memory that follows from it.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatch_narrowed closure is not compiled for its registers"
)]

use std::ops::Range;

use simd_lanes::dispatch_narrow;

use crate::grid::tile_size::{
    block_edge, block_len, corner_of, signed, tile_edge, tile_len, tile_of,
};

/// Particles are put in order when more than one in this many is next to one of another tile without need.
const DISORDER: usize = 8;

/// The same for a particle of another cell, counted every [`CELL_CHECK`] steps. Sorting costs about as much for each particle as one
/// more group in lanes. The order lasts 4 steps if one particle in 20 changes its cell in a step, and 25 if one in 300 does.
const CELL_DISORDER: usize = 8;
const CELL_CHECK: u64 = 4;

/// Particles that are adjacent in memory and in one tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Run<const D: usize> {
    pub(crate) tile: [i32; D],
    slot: u32,
    begin: usize,
    end: usize,
}

impl<const D: usize> Run<D> {
    /// Its particles, by their places in memory.
    pub(crate) fn range(&self) -> Range<usize> {
        self.begin..self.end
    }
}

/// Particles of one body by the slot of their tile. In memory they are nearly in the order of their tiles, so that runs are few, and
/// what can be done for a run at once is.
#[derive(Debug, Default)]
pub(crate) struct Binning<const D: usize> {
    /// The lowest node that each particle sees.
    pub(crate) bases: Vec<[i32; D]>,
    /// Where in the blocks of the grid this node is.
    pub(crate) nodes: Vec<usize>,
    /// In the order of memory.
    pub(crate) runs: Vec<Run<D>>,
    /// Runs by slot, ascending within each; where particles are put in order, the particles.
    order: Vec<u32>,
    /// Where those of a slot begin in `order`.
    starts: Vec<u32>,
    /// Where the next one of a slot, or of a cell, goes.
    next: Vec<u32>,
    /// Particles whose neighbour in memory is in another tile, beyond the unavoidable number.
    breaks: usize,
    /// By slot, a bit for each cell that has particles: a buffer of the count.
    cells: Vec<u64>,
}

/// Particles have numbers of 32 bits.
fn short(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

impl<const D: usize> Binning<D> {
    pub(crate) fn of(n_particles: usize) -> Self {
        let (bases, nodes) = (vec![[0; D]; n_particles], vec![0; n_particles]);
        Self { bases, nodes, ..Self::default() }
    }

    /// The particles of a tile, run by run.
    pub(crate) fn runs_of(&self, slot: usize) -> impl Iterator<Item = Range<usize>> {
        let members = self.starts[slot] as usize..self.starts[slot + 1] as usize;
        self.order[members].iter().map(|&run| self.runs[run as usize].range())
    }

    /// Finds the runs, without their slots.
    pub(crate) fn find_runs(&mut self) {
        self.runs.clear();
        let mut begin = 0;
        while begin < self.bases.len() {
            let (tile, end) =
                (tile_of(&self.bases[begin]), begin + run_length(&self.bases[begin..]));
            self.runs.push(Run { tile, slot: 0, begin, end });
            begin = end;
        }
    }

    /// Sorts the runs by slot, and finds the lowest node of each particle in the blocks: that of the tile in slot `k` is number
    /// `block_of(k)` of them.
    pub(crate) fn bin(
        &mut self,
        n_slots: usize,
        slot_of: impl Fn(&[i32; D]) -> u32,
        block_of: impl Fn(usize) -> usize,
    ) {
        self.begin_counts(n_slots);
        for run in &mut self.runs {
            run.slot = slot_of(&run.tile);
            self.starts[run.slot as usize + 1] += 1;
        }
        let Self { runs, nodes, bases, .. } = self;
        dispatch_narrow(
            #[inline(always)]
            || {
                for run in &*runs {
                    let (corner, first) = (corner_of(&run.tile), block_of(run.slot as usize));
                    let first = first * block_len(D);
                    for (node, base) in nodes[run.range()].iter_mut().zip(&bases[run.range()]) {
                        *node = first + offset(base, &corner);
                    }
                }
            },
        );
        self.cells.resize(n_slots, 0);
        let needed = self.starts.iter().filter(|&&count| count > 0).count();
        self.breaks = self.runs.len() - needed;
        self.begin_order(n_slots, self.runs.len());
        for (number, run) in (0_u32..).zip(&self.runs) {
            let next = &mut self.next[run.slot as usize];
            self.order[*next as usize] = number;
            *next += 1;
        }
    }

    /// No counts yet.
    fn begin_counts(&mut self, n_keys: usize) {
        self.starts.clear();
        self.starts.resize(n_keys + 1, 0);
    }

    /// From counts, one place up, to where those of each key begin.
    fn begin_order(&mut self, n_keys: usize, n_entries: usize) {
        for k in 0..n_keys {
            self.starts[k + 1] += self.starts[k];
        }
        self.next.clear();
        self.next.extend_from_slice(&self.starts);
        self.order.resize(n_entries, 0);
    }

    /// Whether so many particles have left their neighbours in memory that a new order is worth its cost.
    pub(crate) fn is_disordered(&self) -> bool {
        self.breaks * DISORDER > self.bases.len()
    }

    /// Whether so many have left those of their cell that the groups in lanes are too small. It depends on the present positions
    /// and the step number alone, so a restored run sorts its particles at the same steps.
    pub(crate) fn cells_are_disordered(&mut self, step: u64) -> bool {
        if !step.is_multiple_of(CELL_CHECK) {
            return false;
        }
        let Self { cells, runs, bases, nodes, .. } = self;
        cells.fill(0);
        let mut pieces = 0;
        for run in &*runs {
            let (mut last, occupied) = (usize::MAX, &mut cells[run.slot as usize]);
            for (base, &node) in bases[run.range()].iter().zip(&nodes[run.range()]) {
                if node != last {
                    last = node;
                    pieces += 1;
                    *occupied |= 1 << cell_in_tile(base);
                }
            }
        }
        let needed: u32 = cells.iter().map(|occupied| occupied.count_ones()).sum();
        (pieces - needed as usize) * CELL_DISORDER > bases.len()
    }

    /// The order in memory by tile and, within it, by cell: entry `i` is who comes to place `i`. To be binned anew after it.
    pub(crate) fn by_cell(&mut self) -> &[u32] {
        let n_slots = self.starts.len() - 1;
        let n_keys = n_slots * tile_len(D);
        self.begin_counts(n_keys);
        for run in &self.runs {
            for base in &self.bases[run.range()] {
                self.starts[cell_of(run, base) + 1] += 1;
            }
        }
        self.begin_order(n_keys, self.bases.len());
        for run in &self.runs {
            for (particle, base) in run.range().zip(&self.bases[run.range()]) {
                let next = &mut self.next[cell_of(run, base)];
                self.order[*next as usize] = short(particle);
                *next += 1;
            }
        }
        &self.order
    }
}

/// Number of particles, from the first on, in the tile of the first. It compares them in groups.
fn run_length<const D: usize>(bases: &[[i32; D]]) -> usize {
    const GROUP: usize = 8;
    let stays = |group: &[[i32; D]]| {
        // Edges are powers of two: nodes of one tile differ in the lowest bits alone.
        let mut difference = 0;
        for base in group {
            for k in 0..D {
                difference |= base[k] ^ bases[0][k];
            }
        }
        (0..signed(tile_edge(D))).contains(&difference)
    };
    let together = GROUP * bases.chunks_exact(GROUP).take_while(|group| stays(group)).count();
    let others = bases[together..].chunks(1).take_while(|one| stays(one)).count();
    together + others
}

/// The number of a particle's cell.
fn cell_of<const D: usize>(run: &Run<D>, base: &[i32; D]) -> usize {
    run.slot as usize * tile_len(D) + cell_in_tile(base)
}

/// The same within its tile, below 64.
fn cell_in_tile<const D: usize>(base: &[i32; D]) -> usize {
    const { assert!(tile_len(D) <= 64) };
    let mut local = 0;
    for &node in base.iter().rev() {
        let along = node.rem_euclid(signed(tile_edge(D)));
        local = local * tile_edge(D) + along.unsigned_abs() as usize;
    }
    local
}

/// Where in its block the lowest node of a particle is.
#[inline(always)]
fn offset<const D: usize>(base: &[i32; D], corner: &[i32; D]) -> usize {
    let mut index = 0;
    for k in (0..D).rev() {
        index = index * block_edge(D) + base[k].abs_diff(corner[k]) as usize;
    }
    index
}

/// Brings entry `order[i]` to place `i` for every `i`, in place, along the cycles of the permutation. `done` is a buffer.
pub(crate) fn permute<T: Copy>(entries: &mut [T], order: &[u32], done: &mut Vec<bool>) {
    if !entries.is_empty() {
        permute_by(entries, order, done, |entries, i| entries[i], |entries, i, e| entries[i] = e);
    }
}

/// The same of entries that are read and written by functions.
pub(crate) fn permute_by<E: ?Sized, T>(
    entries: &mut E,
    order: &[u32],
    done: &mut Vec<bool>,
    read: impl Fn(&E, usize) -> T,
    write: impl Fn(&mut E, usize, T),
) {
    done.clear();
    done.resize(order.len(), false);
    for start in 0..order.len() {
        if done[start] {
            continue;
        }
        let (first, mut place) = (read(entries, start), start);
        loop {
            done[place] = true;
            let from = order[place] as usize;
            if from == start {
                write(entries, place, first);
                break;
            }
            let entry = read(entries, from);
            write(entries, place, entry);
            place = from;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_permutation_in_place_is_a_gather() {
        let order = [3, 0, 2, 1, 5, 4];
        let entries = [10, 11, 12, 13, 14, 15];
        let mut moved = entries;
        permute(&mut moved, &order, &mut vec![]);
        assert_eq!(moved, order.map(|from| entries[from as usize]));
    }
}
