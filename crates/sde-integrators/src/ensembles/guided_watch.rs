//! Observers of guided paths: the largest of some responses, or none.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use crate::ensembles::follow::{Lives, Watch};
use crate::ensembles::maximum::{Maximum, Response, larger};
use crate::noise::lane_increments::LANES;

/// An observer that knows the largest response of each lane.
pub(crate) trait Largest: Watch {
    /// Largest responses since the start of the group.
    fn largest(&self) -> [f64; LANES];
}

/// The largest of some responses.
pub(crate) struct Peaks<'a> {
    responses: Vec<Maximum<'a>>,
}

impl<'a> Peaks<'a> {
    pub(crate) fn new(responses: &'a [Response<'a>], seed: u64) -> Self {
        let maximum = |(index, response)| Maximum::new(response, seed, 0).with_bridges_of(index);
        Self { responses: responses.iter().enumerate().map(maximum).collect() }
    }
}

impl Watch for Peaks<'_> {
    const EVERY_STEP: bool = true;

    fn start(&mut self, first: u64, x: &[[f64; LANES]]) {
        for response in &mut self.responses {
            response.start(first, x);
        }
    }

    #[inline(always)]
    fn step(&mut self, time: (f64, f64), before: &[[f64; LANES]], after: &[[f64; LANES]]) {
        for response in &mut self.responses {
            response.step(time, before, after);
        }
    }

    fn output(&mut self, _: usize, _: f64, _: &[[f64; LANES]], _: &mut Lives) {}
}

impl Largest for Peaks<'_> {
    #[inline(always)]
    fn largest(&self) -> [f64; LANES] {
        let mut largest = [f64::NEG_INFINITY; LANES];
        for response in &self.responses {
            for lane in 0..LANES {
                largest[lane] = larger(largest[lane], response.running[lane]);
            }
        }
        largest
    }
}

/// Observes nothing, so that steps may be joined.
pub(crate) struct EndAlone;

impl Watch for EndAlone {
    const EVERY_STEP: bool = false;
    fn start(&mut self, _: u64, _: &[[f64; LANES]]) {}
    fn step(&mut self, _: (f64, f64), _: &[[f64; LANES]], _: &[[f64; LANES]]) {}
    fn output(&mut self, _: usize, _: f64, _: &[[f64; LANES]], _: &mut Lives) {}
}

impl Largest for EndAlone {
    fn largest(&self) -> [f64; LANES] {
        [f64::NEG_INFINITY; LANES]
    }
}
