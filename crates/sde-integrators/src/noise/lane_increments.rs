//! Increments of paths in SIMD lanes, generated together.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::SimdLevel;

use crate::noise::chacha::key;
use crate::noise::normal::{BLOCK_NORMALS, ROW, normal_rows};
use crate::noise::streams::{Increment, Purpose};

/// Number of paths that an ensemble advances together, one per lane.
pub const LANES: usize = ROW;

/// The increments of [`LANES`] paths over one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaneIncrements<const M: usize> {
    /// `w`, per motion and lane (square root of time).
    pub brownian: [[f64; LANES]; M],
    /// `H`, per motion and lane (square root of time); zero where the method does not use it.
    pub space_time_area: [[f64; LANES]; M],
}

impl<const M: usize> LaneIncrements<M> {
    /// Zero noise.
    pub const ZERO: Self = Self { brownian: [[0.0; LANES]; M], space_time_area: [[0.0; LANES]; M] };

    /// The increment of one path. `lane` is below [`LANES`].
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, lane: usize) -> Increment<M> {
        let mut increment = Increment::ZERO;
        for m in 0..M {
            increment.brownian[m] = self.brownian[m][lane];
            increment.space_time_area[m] = self.space_time_area[m][lane];
        }
        increment
    }
}

/// Normals for one purpose in lanes, row by row, eight rows per block of the cipher.
#[derive(Debug, Clone)]
struct Rows {
    key: [u32; 8],
    normals: [[f64; LANES]; BLOCK_NORMALS],
}

impl Rows {
    fn new(seed: u64, purpose: Purpose) -> Self {
        Self { key: key(seed, purpose as u64), normals: [[0.0; LANES]; BLOCK_NORMALS] }
    }

    fn draw(&mut self, level: SimdLevel, streams: &[u64; LANES], block: u64) {
        normal_rows(level, &self.key, streams, &[block; LANES], &mut self.normals);
    }
}

/// The noise of [`LANES`] paths, step by step.
#[derive(Debug, Clone)]
pub(crate) struct LaneNoise<const M: usize> {
    level: SimdLevel,
    /// The realisation whose words a lane uses.
    streams: [u64; LANES],
    brownian: Rows,
    area: Rows,
    /// The row of the next normals.
    next: usize,
    /// The next block of the cipher.
    block: u64,
}

impl<const M: usize> LaneNoise<M> {
    pub(crate) fn new(level: SimdLevel, seed: u64, streams: [u64; LANES]) -> Self {
        let brownian = Rows::new(seed, Purpose::Path);
        let area = Rows::new(seed, Purpose::PathArea);
        Self { level, streams, brownian, area, next: 0, block: 0 }
    }

    /// The increments over the next step, with the standard deviations of `w` and of `H`.
    #[inline(always)]
    pub(crate) fn next<const USES_AREA: bool>(
        &mut self,
        deviation: f64,
        area_deviation: f64,
        increments: &mut LaneIncrements<M>,
    ) {
        for m in 0..M {
            let row = self.next;
            if row == 0 {
                self.brownian.draw(self.level, &self.streams, self.block);
                if USES_AREA {
                    self.area.draw(self.level, &self.streams, self.block);
                }
                self.block += 1;
            }
            let normals = &self.brownian.normals[row];
            for lane in 0..LANES {
                increments.brownian[m][lane] = deviation * normals[lane];
            }
            if USES_AREA {
                let normals = &self.area.normals[row];
                for lane in 0..LANES {
                    increments.space_time_area[m][lane] = area_deviation * normals[lane];
                }
            }
            self.next = (row + 1) % BLOCK_NORMALS;
        }
    }
}
