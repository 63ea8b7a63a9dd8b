//! A pass over the particles: from the nodes, through the material, to their new places, batch by batch.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use simd_lanes::dispatch_narrow;

use crate::config::Config;
use crate::grid::background::Grid;
use crate::number::CarriedNumber;
use crate::parallel::join;
use crate::points::body::Body;
use crate::points::conditions::Columns;
use crate::points::material_points::{MaterialUpdate, Strain};
use crate::points::particles::{BATCH, Chunk};
use crate::points::summary::{Summary, look};
use crate::transfer::particle_motion::{GridToParticle, Pass};
use crate::transfer::transfers::grid_to_particle;
use crate::transfer::velocity_gradients::VelocityGradients;

/// Particles of a thread's share at least, a multiple of a batch.
const SHARE: usize = 1024;

/// A pass with all that it needs to know.
#[derive(Debug)]
pub(crate) struct ParticlePass<'a, S, const D: usize> {
    grid: &'a Grid<S, D>,
    config: &'a Config<D>,
    pass: Pass,
    transfer: GridToParticle<D>,
    strain: Strain,
}

impl<'a, S: CarriedNumber, const D: usize> ParticlePass<'a, S, D> {
    /// A pass of a step of `dt` that ends at `time`.
    pub(crate) fn of(
        grid: &'a Grid<S, D>,
        config: &'a Config<D>,
        pass: Pass,
        (dt, time): (f64, f64),
    ) -> Self {
        let Config { cell, viscosity, .. } = *config;
        Self {
            grid,
            config,
            pass,
            transfer: GridToParticle::of(grid.lattice, config, pass, dt),
            strain: Strain { dt, time, cell, viscosity },
        }
    }

    /// Over all particles of a body.
    pub(crate) fn over(&self, body: &mut Body<S, D>) -> Summary<D> {
        let mut summary = Summary::none();
        let pass = Self { transfer: self.transfer.of_body(body), ..*self };
        let (mut chunk, points) = body.for_pass();
        points.pass(&mut |points| summary = pass.in_halves(&mut chunk, points));
        summary
    }

    /// In halves down to a share: the sums have a shape that the number of particles alone decides.
    fn in_halves(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        points: &mut dyn MaterialUpdate<S>,
    ) -> Summary<D> {
        let n = chunk.len();
        if n <= SHARE {
            return self.over_share(chunk, points);
        }
        let middle = (n / 2).next_multiple_of(BATCH);
        let (mut low, mut high) = chunk.halves(middle);
        let (mut one, mut two) = (Summary::none(), Summary::none());
        points.split(middle, &mut |low_points, high_points| {
            join(&mut || one = self.in_halves(&mut low, low_points), &mut || {
                two = self.in_halves(&mut high, high_points);
            });
        });
        one.and(two)
    }

    fn over_share(
        &self,
        share: &mut Chunk<'_, S, D>,
        points: &mut dyn MaterialUpdate<S>,
    ) -> Summary<D> {
        let mut summary = Summary::none();
        let mut velocity_gradients = VelocityGradients::zero();
        for begin in (0..share.len()).step_by(BATCH) {
            let batch = begin..share.len().min(begin + BATCH);
            let mut chunk = share.part(batch.clone());
            grid_to_particle(&self.transfer, self.grid, &mut chunk, &mut velocity_gradients);
            if self.pass == Pass::Velocity {
                continue;
            }
            let (range, numbers) = (batch.clone(), chunk.number);
            let fault = points.update(range, self.strain, &velocity_gradients, numbers);
            if let Some((number, fault)) = fault {
                summary.fail(number, fault);
            }
            let conditions = points.conditions().part(batch.clone());
            self.move_batch(&mut chunk, &conditions, &mut summary);
            points.add_energies(batch, chunk.reference_volume, &mut summary.internal);
        }
        summary
    }

    /// Moves the particles of a batch to the end of the step, and observes them there.
    #[inline(never)]
    fn move_batch(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        conditions: &Columns<'_, S>,
        summary: &mut Summary<D>,
    ) {
        let is_pushed = self.grid.rigid().is_some();
        let has_momentum = self.config.gravity.map(|along| along != 0.0 || is_pushed);
        let is_everywhere = dispatch_narrow(
            #[inline(always)]
            || {
                look(chunk, conditions, (self.config, has_momentum), summary);
                chunk.advance(self.config)
            },
        );
        if !is_everywhere {
            for i in 0..chunk.len() {
                if let Err(fault) = chunk.check(i, self.config) {
                    summary.fail(chunk.number[i], fault);
                }
            }
        }
    }
}
