//! What every particle carries besides the state of its material.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::ops::Range;

use crate::config::{Config, Geometry, Transfer};
use crate::grid::binning::{Binning, permute};
use crate::number::{CarriedNumber, is_finite};
use crate::points::fill::Fill;
use constitutive_models::Fault;

/// Particles that go through a pass together: what nodes and material make of them stays in the nearest cache.
pub(crate) const BATCH: usize = 64;

/// What every particle carries besides the state of its material, in the order of memory. A column that no step of the
/// configuration needs is empty.
#[derive(Debug)]
pub(crate) struct Particles<S, const D: usize> {
    pub(crate) position: Vec<[S; D]>,
    pub(crate) velocity: Vec<[S; D]>,
    /// By how much the step moves it at its end.
    pub(crate) displacement: Vec<[S; D]>,
    /// APIC's matrix.
    pub(crate) affine: Vec<[[S; D]; D]>,
    pub(crate) mass: Vec<S>,
    /// Its volume in the reference state; per radian where axisymmetric.
    pub(crate) reference_volume: Vec<f64>,
    /// Its number.
    pub(crate) number: Vec<u32>,
    /// The force of the loads on it in the step; empty where there are none. Snapshots do not hold it.
    pub(crate) force: Vec<[f64; D]>,
}

/// A run of particles; columns that are empty are so in every chunk.
#[derive(Debug)]
pub(crate) struct Chunk<'a, S, const D: usize> {
    pub(crate) position: &'a mut [[S; D]],
    pub(crate) velocity: &'a mut [[S; D]],
    pub(crate) displacement: &'a mut [[S; D]],
    pub(crate) affine: &'a mut [[[S; D]; D]],
    pub(crate) mass: &'a [S],
    pub(crate) reference_volume: &'a [f64],
    pub(crate) number: &'a [u32],
    /// The lowest node that it sees.
    pub(crate) base: &'a [[i32; D]],
    /// Where in the blocks of the grid this node is.
    pub(crate) node: &'a [usize],
}

/// Both parts of a column, of one that may be empty too.
fn halves<T>(column: &mut [T], middle: usize) -> (&mut [T], &mut [T]) {
    column.split_at_mut(middle.min(column.len()))
}

/// Two chunks of one: columns that are written, then those that are only read.
macro_rules! halves {
    ($chunk:ident at $middle:ident: $($written:ident),+; $($read:ident),+) => {{
        $(let $written = halves($chunk.$written, $middle);)+
        $(let $read = $chunk.$read.split_at($middle);)+
        (
            Chunk { $($written: $written.0,)+ $($read: $read.0,)+ },
            Chunk { $($written: $written.1,)+ $($read: $read.1,)+ },
        )
    }};
}

/// A range of a chunk, likewise.
macro_rules! part {
    ($chunk:ident in $range:ident: $($written:ident),+; $($read:ident),+) => {
        Chunk {
            $($written: $chunk.$written.get_mut($range.clone()).unwrap_or_default(),)+
            $($read: &$chunk.$read[$range.clone()],)+
        }
    };
}

impl<S, const D: usize> Chunk<'_, S, D> {
    pub(crate) fn len(&self) -> usize {
        self.position.len()
    }

    /// The first so many particles, and the others.
    pub(crate) fn halves(&mut self, middle: usize) -> (Chunk<'_, S, D>, Chunk<'_, S, D>) {
        halves!(self at middle:
            position, velocity, displacement, affine;
            mass, reference_volume, number, base, node)
    }

    /// A range of the particles.
    pub(crate) fn part(&mut self, range: Range<usize>) -> Chunk<'_, S, D> {
        part!(self in range:
            position, velocity, displacement, affine;
            mass, reference_volume, number, base, node)
    }
}

impl<S: CarriedNumber, const D: usize> Particles<S, D> {
    /// Particles at rest at the places of a fill, or all with one velocity.
    pub(crate) fn of(fill: &Fill<D>, velocity: [f64; D], density: &dyn Fn(usize) -> S) -> Self {
        let (n, volume) = (fill.positions.len(), fill.spacing.iter().product::<f64>());
        Self {
            position: fill.positions.iter().map(|place| place.map(S::constant)).collect(),
            velocity: vec![velocity.map(S::constant); n],
            displacement: vec![[S::constant(0.0); D]; n],
            affine: vec![],
            mass: (0..n).map(|particle| density(particle) * volume).collect(),
            reference_volume: vec![volume; n],
            number: (0_u32..).take(n).collect(),
            force: vec![],
        }
    }

    /// Makes the column that steps with APIC need.
    pub(crate) fn prepare(&mut self, config: &Config<D>) {
        if config.transfer == Transfer::Apic {
            self.affine.resize(self.position.len(), [[S::constant(0.0); D]; D]);
        }
    }

    /// All of them.
    pub(crate) fn chunk<'a>(&'a mut self, binning: &'a Binning<D>) -> Chunk<'a, S, D> {
        Chunk {
            position: &mut self.position,
            velocity: &mut self.velocity,
            displacement: &mut self.displacement,
            affine: &mut self.affine,
            mass: &self.mass,
            reference_volume: &self.reference_volume,
            number: &self.number,
            base: &binning.bases,
            node: &binning.nodes,
        }
    }

    /// Brings particle `order[i]` to place `i`.
    pub(crate) fn permute(&mut self, order: &[u32], done: &mut Vec<bool>) {
        permute(&mut self.position, order, done);
        permute(&mut self.velocity, order, done);
        permute(&mut self.displacement, order, done);
        permute(&mut self.affine, order, done);
        permute(&mut self.mass, order, done);
        permute(&mut self.reference_volume, order, done);
        permute(&mut self.number, order, done);
    }
}

impl<S: CarriedNumber, const D: usize> Chunk<'_, S, D> {
    /// Moves the particles: `x += dt sum_i v_i N_i`. Returns whether all of them are then inside the limits; [`Self::check`]
    /// names those that are not.
    #[inline(always)]
    pub(crate) fn advance(&mut self, config: &Config<D>) -> bool {
        for (x, by) in self.position.iter_mut().zip(&*self.displacement) {
            for k in 0..D {
                x[k] = x[k] + by[k];
            }
        }
        let mut are_finite = true;
        for x in &*self.position {
            for k in 0..D {
                are_finite &= is_finite(x[k].value());
            }
        }
        let mut is_allowed = true;
        if config.geometry == Geometry::Axisymmetric {
            for x in &*self.position {
                is_allowed &= x[0].value() > 0.0;
            }
        }
        are_finite && is_allowed
    }

    /// Whether a particle is where it may be, as long as it may be.
    pub(crate) fn check(&self, i: usize, config: &Config<D>) -> Result<(), Fault> {
        let x = &self.position[i];
        if let Some(value) = x.iter().map(|x| x.value()).find(|&value| !is_finite(value)) {
            return Err(Fault { quantity: "position", value, must: "finite" });
        }
        if config.geometry == Geometry::Axisymmetric && x[0].value() <= 0.0 {
            return Err(Fault { quantity: "radius", value: x[0].value(), must: "above 0" });
        }
        Ok(())
    }
}

/// What snapshots hold of a particle besides its material; columns that the configuration leaves out are `None`.
pub(crate) struct ParticleNumbers<S, const D: usize> {
    position: [S; D],
    velocity: [S; D],
    affine: Option<[[S; D]; D]>,
    mass: S,
    reference_volume: f64,
}

impl<S: CarriedNumber, const D: usize> ParticleNumbers<S, D> {
    pub(crate) fn of(particles: &Particles<S, D>, place: usize) -> Self {
        Self {
            position: particles.position[place],
            velocity: particles.velocity[place],
            affine: particles.affine.get(place).copied(),
            mass: particles.mass[place],
            reference_volume: particles.reference_volume[place],
        }
    }

    pub(crate) fn put(self, particles: &mut Particles<S, D>, place: usize) {
        particles.position[place] = self.position;
        particles.velocity[place] = self.velocity;
        if let Some(matrix) = self.affine {
            particles.affine[place] = matrix;
        }
        particles.mass[place] = self.mass;
        particles.reference_volume[place] = self.reference_volume;
    }

    pub(crate) fn visit_numbers(&mut self, visit: &mut dyn FnMut(&mut S)) {
        let mut volume = S::constant(self.reference_volume);
        let affine = self.affine.iter_mut().flat_map(|matrix| matrix.as_flattened_mut());
        let points = self.position.iter_mut().chain(&mut self.velocity).chain(affine);
        points.chain([&mut self.mass, &mut volume]).for_each(visit);
        self.reference_volume = volume.value();
    }
}
