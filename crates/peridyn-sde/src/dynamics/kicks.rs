//! The noise that drives the nodes.

use sde_integrators::{LaneNormals, Noise, Purpose};

use crate::dynamics::resistance::Resistance;
use crate::error::Error;
use crate::real::Real;

/// Motions whose normals are made together, few enough for the nearest cache.
pub(crate) const CHUNK: usize = 256;

/// The Brownian motions that drive `L` realisations.
#[derive(Debug, Clone)]
pub(crate) struct Kicks<const L: usize> {
    path: LaneNormals<L>,
    /// The first of Leimkuhler and Matthews' method.
    first: LaneNormals<L>,
    n_motions: usize,
    normals: Vec<f64>,
    /// Argument and result of a factor that couples nodes.
    argument: Vec<f64>,
    image: Vec<f64>,
}

/// The kick of a step, or the one before the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Which {
    Step(u64),
    BeforeFirst,
}

impl<const L: usize> Kicks<L> {
    pub(crate) fn new(noise: Noise, realisations: [u64; L], n_motions: usize) -> Self {
        Self {
            path: LaneNormals::new(&noise, Purpose::Path, realisations),
            first: LaneNormals::new(&noise, Purpose::PathArea, realisations),
            n_motions,
            normals: vec![0.0; CHUNK * L],
            argument: Vec::new(),
            image: Vec::new(),
        }
    }

    /// The normals `z` themselves.
    pub(crate) fn draw<T: Real>(&mut self, which: Which, z: &mut Vec<T>) {
        let (lanes, step) = match which {
            Which::Step(step) => (&self.path, step),
            Which::BeforeFirst => (&self.first, 0),
        };
        z.resize(self.n_motions * L, T::ZERO);
        for (chunk, z) in z.chunks_mut(CHUNK * L).enumerate() {
            let range = chunk * CHUNK..chunk * CHUNK + z.len() / L;
            lanes.fill(step, self.n_motions, range, &mut self.normals);
            for (z, &normal) in z.iter_mut().zip(&self.normals) {
                *z = T::of(normal);
            }
        }
    }

    /// The normals of some motions of a step, at most [`CHUNK`] of them.
    pub(crate) fn normals(&mut self, step: u64, range: std::ops::Range<usize>) -> &[f64] {
        let length = range.len() * L;
        self.path.fill(step, self.n_motions, range, &mut self.normals);
        &self.normals[..length]
    }

    /// `L z`.
    pub(crate) fn kick<T: Real>(
        &mut self,
        resistance: &Resistance<T>,
        which: Which,
        kick: &mut Vec<T>,
    ) -> Result<(), Error> {
        self.draw(which, kick);
        self.forth(resistance, kick)
    }

    /// `z -> L z`, in place: of all motions to all unknowns.
    pub(crate) fn forth<T: Real>(
        &mut self,
        resistance: &Resistance<T>,
        values: &mut Vec<T>,
    ) -> Result<(), Error> {
        self.apply(resistance, values, Way::Forth)
    }

    /// `f -> L^T f`, in place.
    pub(crate) fn back<T: Real>(
        &mut self,
        resistance: &Resistance<T>,
        values: &mut Vec<T>,
    ) -> Result<(), Error> {
        self.apply(resistance, values, Way::Back)
    }

    fn apply<T: Real>(
        &mut self,
        resistance: &Resistance<T>,
        values: &mut Vec<T>,
        way: Way,
    ) -> Result<(), Error> {
        let (mobility, components) = match resistance {
            Resistance::Diagonal { factor, .. } => {
                scale::<T, L>(values, factor);
                return Ok(());
            }
            Resistance::Coupled { mobility, dimension } => (mobility, dimension * L),
        };
        self.argument.clear();
        self.argument.extend(values.iter().map(|value| value.to_f64()));
        match way {
            Way::Forth => {
                self.image.resize(mobility.n_nodes() * components, 0.0);
                mobility.apply_factor(components, &self.argument, &mut self.image)?;
            }
            Way::Back => {
                self.image.resize(self.n_motions * L, 0.0);
                mobility.apply_factor_transposed(components, &self.argument, &mut self.image)?;
            }
        }
        values.clear();
        values.extend(self.image.iter().map(|&value| T::of(value)));
        Ok(())
    }
}

/// Which way a factor is applied.
#[derive(Debug, Clone, Copy)]
enum Way {
    Forth,
    Back,
}

fn scale<T: Real, const L: usize>(values: &mut [T], factor: &[T]) {
    for (lanes, &factor) in values.as_chunks_mut::<L>().0.iter_mut().zip(factor) {
        for value in lanes {
            *value = *value * factor;
        }
    }
}
