//! Normals of fields in SIMD lanes.

use std::ops::Range;

use simd_lanes::{Registers, SimdLevel, Work};

use crate::noise::chacha::key;
use crate::noise::normal::{BLOCK_NORMALS, normal_blocks};
use crate::noise::streams::{Noise, Purpose};

/// Blocks of the cipher generated together, over all lanes.
const BLOCKS: usize = 32;

/// Normals that drive `L` realisations of a field, one per lane.
///
/// Step `k` and motion `m` of `M` take normal `k M + m` of the realisation's stream, as a path of a small state does.
///
/// ```
/// use sde_integrators::{LaneNormals, Noise, Purpose};
///
/// let noise = Noise::new(7);
/// let lanes = LaneNormals::new(&noise, Purpose::Path, [3, 4]);
/// let mut normals = [0.0; 10];
/// lanes.fill(0, 5, 0..5, &mut normals);
/// let mut alone = noise.stream(Purpose::Path, 4);
/// assert_eq!([normals[1], normals[3]], alone.next_normal_pair());
/// ```
#[derive(Debug, Clone)]
pub struct LaneNormals<const L: usize> {
    key: [u32; 8],
    realisations: [u64; L],
    level: SimdLevel,
}

impl<const L: usize> LaneNormals<L> {
    /// Normals of realisations for a purpose. `L` is 1, 2, 4, 8, 16 or 32; another number does not compile.
    #[must_use]
    pub fn new(noise: &Noise, purpose: Purpose, realisations: [u64; L]) -> Self {
        const { assert!(BLOCKS.is_multiple_of(L), "lanes divide the blocks made together") };
        let key = key(noise.seed(), purpose as u64);
        Self { key, realisations, level: SimdLevel::best() }
    }

    /// Writes the normals of the motions in `range`, of `n_motions` in all, at a step.
    ///
    /// Lane `l` of motion `m` goes to `normals[(m - range.start) L + l]`. Further entries of `normals` are unchanged.
    pub fn fill(&self, step: u64, n_motions: usize, range: Range<usize>, normals: &mut [f64]) {
        let first = u128::from(step) * n_motions as u128 + range.start as u128;
        let wanted = range.len().min(normals.len() / L);
        self.level.run(Fill { lanes: self, first, normals: &mut normals[..wanted * L] });
    }
}

struct Fill<'a, const L: usize> {
    lanes: &'a LaneNormals<L>,
    /// Number of the first normal.
    first: u128,
    normals: &'a mut [f64],
}

#[allow(clippy::cast_possible_truncation, reason = "a counter of blocks wraps at 2^64")]
const fn low(x: u128) -> u64 {
    x as u64
}

impl<const L: usize> Work<f64> for Fill<'_, L> {
    type Output = ();

    #[allow(clippy::inline_always, reason = "it is compiled for the registers of the level")]
    #[inline(always)]
    fn run<R: Registers<f64>>(self, _: R) {
        let LaneNormals { key, realisations, .. } = self.lanes;
        let streams: [u64; BLOCKS] = std::array::from_fn(|at| realisations[at % L]);
        let (out, _) = self.normals.as_chunks_mut::<L>();
        let mut rows = [[0.0; BLOCKS]; BLOCK_NORMALS];
        let mut block = low(self.first / BLOCK_NORMALS as u128);
        // Normals of the first block that precede those requested.
        let mut skip = (self.first % BLOCK_NORMALS as u128) as usize;
        let mut done = 0;
        while done < out.len() {
            let counters = std::array::from_fn(|at| block.wrapping_add((at / L) as u64));
            normal_blocks(key, &streams, &counters, &mut rows);
            for column in 0..BLOCKS / L {
                for row in &rows[skip..] {
                    let Some(normals) = out.get_mut(done) else { return };
                    normals.copy_from_slice(&row[column * L..(column + 1) * L]);
                    done += 1;
                }
                skip = 0;
            }
            block = block.wrapping_add((BLOCKS / L) as u64);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_that_of_the_streams<const L: usize>() {
        let noise = Noise::new(11);
        let realisations = std::array::from_fn(|lane| 5 + 3 * lane as u64);
        let lanes = LaneNormals::<L>::new(&noise, Purpose::Path, realisations);
        let n_motions = 77;
        for (step, range) in [(0, 0..77), (3, 0..77), (4, 13..60), (9, 76..77), (2, 5..5)] {
            let mut normals = vec![0.0; range.len() * L];
            lanes.fill(step, n_motions, range.clone(), &mut normals);
            for (lane, &realisation) in realisations.iter().enumerate() {
                let mut all = vec![0.0; (usize::try_from(step).unwrap() + 1) * n_motions];
                noise.stream(Purpose::Path, realisation).fill_normal(&mut all);
                let of_step = &all[all.len() - n_motions..][range.clone()];
                for (m, expected) in of_step.iter().enumerate() {
                    assert_eq!(normals[m * L + lane].to_bits(), expected.to_bits());
                }
            }
        }
    }

    #[test]
    fn every_lane_has_the_normals_of_its_own_stream() {
        is_that_of_the_streams::<1>();
        is_that_of_the_streams::<8>();
        is_that_of_the_streams::<16>();
    }
}
