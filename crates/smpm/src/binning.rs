//! Who stands in which tile, and the order in memory that follows from it.

use crate::tiles::{block_edge, tile_edge, tile_len, tile_of};

/// Particles are put in order when more than one in this many stands next to one of another tile without need.
const DISORDER: usize = 8;

/// A run of particles in one tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Run<const D: usize> {
    pub(crate) tile: [i32; D],
    n_particles: usize,
}

/// Particles of one body by the slot of their tile.
#[derive(Debug, Default)]
pub(crate) struct Binning<const D: usize> {
    /// The lowest node that each particle sees.
    pub(crate) bases: Vec<[i32; D]>,
    /// The slot of each particle's tile.
    pub(crate) slot: Vec<u32>,
    /// Particles that stand next to each other in memory and in one tile.
    pub(crate) runs: Vec<Run<D>>,
    /// Particles by slot, ascending within each.
    order: Vec<u32>,
    /// Where the particles of a slot begin in `order`.
    starts: Vec<u32>,
    /// Where the next particle of a slot, or of a cell, goes.
    next: Vec<u32>,
    /// Particles whose neighbour in memory stands in another tile, beyond what there must be.
    breaks: usize,
}

impl<const D: usize> Binning<D> {
    pub(crate) fn of(n_particles: usize) -> Self {
        Self { bases: vec![[0; D]; n_particles], ..Self::default() }
    }

    /// The particles of a tile.
    pub(crate) fn members(&self, slot: usize) -> &[u32] {
        &self.order[self.starts[slot] as usize..self.starts[slot + 1] as usize]
    }

    /// Finds the runs of particles in one tile. In memory particles are nearly in the order of their tiles, so that there are few,
    /// and what follows is done for a run at once.
    pub(crate) fn find_runs(&mut self) {
        self.runs.clear();
        for base in &self.bases {
            let tile = tile_of(base);
            match self.runs.last_mut() {
                Some(run) if run.tile == tile => run.n_particles += 1,
                _ => self.runs.push(Run { tile, n_particles: 1 }),
            }
        }
    }

    /// Sorts the particles by slot.
    pub(crate) fn bin(&mut self, n_slots: usize, slot_of: impl Fn(&[i32; D]) -> u32) {
        self.slot.clear();
        self.starts.clear();
        self.starts.resize(n_slots + 1, 0);
        for &Run { tile, n_particles } in &self.runs {
            let slot = slot_of(&tile);
            self.slot.resize(self.slot.len() + n_particles, slot);
            // Particles have numbers of 32 bits.
            self.starts[slot as usize + 1] += u32::try_from(n_particles).unwrap_or(u32::MAX);
        }
        let needed = self.starts.iter().filter(|&&count| count > 0).count();
        self.breaks = self.runs.len() - needed;
        self.begin_order(n_slots);
        let mut first = 0_u32;
        for run in &self.runs {
            let next = &mut self.next[self.slot[first as usize] as usize];
            let order = &mut self.order[*next as usize..][..run.n_particles];
            for place in order {
                *place = first;
                first += 1;
                *next += 1;
            }
        }
    }

    /// Particles in the order of `key`, whose counts stand in `starts`, one place up.
    fn distribute(&mut self, n_keys: usize, key: impl Fn(&Self, usize) -> usize) {
        self.begin_order(n_keys);
        for (particle, number) in (0_u32..).take(self.slot.len()).enumerate() {
            let key = key(self, particle);
            let place = &mut self.next[key];
            self.order[*place as usize] = number;
            *place += 1;
        }
    }

    /// From counts, one place up, to where the particles of each key begin.
    fn begin_order(&mut self, n_keys: usize) {
        for k in 0..n_keys {
            self.starts[k + 1] += self.starts[k];
        }
        self.next.clear();
        self.next.extend_from_slice(&self.starts);
        self.order.resize(self.slot.len(), 0);
    }

    /// Whether so many particles have left their neighbours in memory that a new order is worth its cost.
    pub(crate) fn is_disordered(&self) -> bool {
        self.breaks * DISORDER > self.slot.len()
    }

    /// The order in memory by tile and, within it, by cell: entry `i` is who comes to place `i`. To be binned anew after it.
    pub(crate) fn by_cell(&mut self) -> &[u32] {
        let n_slots = self.starts.len() - 1;
        let n_keys = n_slots * tile_len(D);
        self.starts.clear();
        self.starts.resize(n_keys + 1, 0);
        for particle in 0..self.slot.len() {
            let key = self.cell_of(particle);
            self.starts[key + 1] += 1;
        }
        self.distribute(n_keys, Self::cell_of);
        &self.order
    }

    fn cell_of(&self, particle: usize) -> usize {
        let mut local = 0;
        for &node in self.bases[particle].iter().rev() {
            let edge = tile_edge(D);
            let along = node.rem_euclid(i32::try_from(edge).unwrap_or(i32::MAX));
            local = local * edge + along.unsigned_abs() as usize;
        }
        self.slot[particle] as usize * tile_len(D) + local
    }

    /// Where in its block the lowest node of a particle is.
    #[allow(clippy::inline_always, reason = "part of a loop inside a dispatched closure")]
    #[inline(always)]
    pub(crate) fn offset(base: &[i32; D], corner: &[i32; D]) -> usize {
        let mut index = 0;
        for k in (0..D).rev() {
            index = index * block_edge(D) + base[k].abs_diff(corner[k]) as usize;
        }
        index
    }
}

/// Brings entry `order[i]` to place `i` for every `i`, in place, along the cycles of the permutation. `done` is a buffer.
pub(crate) fn permute<T: Copy>(entries: &mut [T], order: &[u32], done: &mut Vec<bool>) {
    if entries.is_empty() {
        return;
    }
    done.clear();
    done.resize(order.len(), false);
    for start in 0..order.len() {
        if done[start] {
            continue;
        }
        let (first, mut place) = (entries[start], start);
        loop {
            done[place] = true;
            let from = order[place] as usize;
            if from == start {
                entries[place] = first;
                break;
            }
            entries[place] = entries[from];
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
