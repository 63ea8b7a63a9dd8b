//! What the material made of the particles of a body, in columns: a transfer reads only those that it needs, and registers load
//! particles that are adjacent in memory.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::ops::Range;

use crate::grid::binning::permute_by;
use crate::number::CarriedNumber;
use constitutive_models::tensor::Symmetric;

/// What the material made of one particle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Condition<S> {
    /// Cauchy stress without the bulk viscosity.
    pub(crate) stress: Symmetric<S>,
    /// The bulk viscosity, a pressure.
    pub(crate) viscosity: S,
    /// `V/V_0`.
    pub(crate) volume: S,
    /// Speed of a longitudinal wave.
    pub(crate) wave_speed: S,
    /// `tr L` of the last step.
    pub(crate) rate: f64,
}

/// Columns of numbers `S`: six of the stress, viscosity, volume, wave speed.
const COLUMNS: usize = 9;

/// Numbers `f64` of a page. If all columns began at the same place of a page, they would share one set of the nearest cache, which
/// holds fewer lines than there are columns.
const PAGE: usize = 512;
/// Numbers by which each column begins further on in its page: five lines.
const SHIFT: usize = 40;

/// Numbers from the beginning of a column to that of the next.
fn stride_of(n_particles: usize) -> usize {
    if n_particles < PAGE {
        return n_particles;
    }
    (n_particles - SHIFT).next_multiple_of(PAGE) + SHIFT
}

/// What the material made of every particle of a body.
#[derive(Debug)]
pub(crate) struct Conditions<S> {
    /// All columns but the last, one after the other.
    numbers: Vec<S>,
    rate: Vec<f64>,
}

/// Columns of a run of particles, to be read.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Columns<'a, S> {
    pub(crate) stress: [&'a [S]; 6],
    pub(crate) viscosity: &'a [S],
    pub(crate) volume: &'a [S],
    pub(crate) wave_speed: &'a [S],
    pub(crate) rate: &'a [f64],
}

/// The same, to be written.
#[derive(Debug)]
pub(crate) struct ColumnsMut<'a, S> {
    pub(crate) stress: [&'a mut [S]; 6],
    pub(crate) viscosity: &'a mut [S],
    pub(crate) volume: &'a mut [S],
    pub(crate) wave_speed: &'a mut [S],
    pub(crate) rate: &'a mut [f64],
}

impl<S: CarriedNumber> Conditions<S> {
    /// Of particles in the order of memory.
    pub(crate) fn of(particles: impl ExactSizeIterator<Item = Condition<S>>) -> Self {
        let n = particles.len();
        let numbers = vec![S::constant(0.0); COLUMNS * stride_of(n)];
        let mut conditions = Self { numbers, rate: vec![0.0; n] };
        let mut columns = conditions.columns_mut();
        for (i, condition) in particles.enumerate() {
            columns.set(i, condition);
        }
        conditions
    }

    pub(crate) fn columns(&self) -> Columns<'_, S> {
        let (n, stride) = (self.rate.len(), stride_of(self.rate.len()));
        let column = |k: usize| &self.numbers[k * stride..k * stride + n];
        Columns {
            stress: std::array::from_fn(column),
            viscosity: column(6),
            volume: column(7),
            wave_speed: column(8),
            rate: &self.rate,
        }
    }

    pub(crate) fn columns_mut(&mut self) -> ColumnsMut<'_, S> {
        let (n, stride) = (self.rate.len(), stride_of(self.rate.len()));
        let mut columns = self.numbers.chunks_mut(stride.max(1));
        let mut next = || columns.next().and_then(|column| column.get_mut(..n)).unwrap_or_default();
        ColumnsMut {
            stress: std::array::from_fn(|_| next()),
            viscosity: next(),
            volume: next(),
            wave_speed: next(),
            rate: &mut self.rate,
        }
    }

    /// Brings particle `order[i]` to place `i`.
    pub(crate) fn permute(&mut self, order: &[u32], done: &mut Vec<bool>) {
        let mut columns = self.columns_mut();
        permute_by(&mut columns, order, done, ColumnsMut::get, ColumnsMut::set);
    }
}

impl<S: CarriedNumber> Columns<'_, S> {
    /// A range of the particles.
    #[inline(always)]
    pub(crate) fn part(&self, range: Range<usize>) -> Self {
        let mut part = *self;
        for column in &mut part.stress {
            *column = &column[range.clone()];
        }
        part.viscosity = &self.viscosity[range.clone()];
        part.volume = &self.volume[range.clone()];
        part.wave_speed = &self.wave_speed[range.clone()];
        part.rate = &self.rate[range];
        part
    }

    /// One particle.
    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> Condition<S> {
        Condition {
            stress: Symmetric(self.stress.map(|column| column[i])),
            viscosity: self.viscosity[i],
            volume: self.volume[i],
            wave_speed: self.wave_speed[i],
            rate: self.rate[i],
        }
    }
}

impl<S: CarriedNumber> ColumnsMut<'_, S> {
    /// The first so many particles, and the others.
    pub(crate) fn halves(&mut self, middle: usize) -> (ColumnsMut<'_, S>, ColumnsMut<'_, S>) {
        let mut further: [&mut [S]; 6] = Default::default();
        let mut first: [&mut [S]; 6] = Default::default();
        for (k, column) in self.stress.iter_mut().enumerate() {
            (first[k], further[k]) = column.split_at_mut(middle);
        }
        let viscosity = self.viscosity.split_at_mut(middle);
        let volume = self.volume.split_at_mut(middle);
        let wave_speed = self.wave_speed.split_at_mut(middle);
        let rate = self.rate.split_at_mut(middle);
        (
            ColumnsMut {
                stress: first,
                viscosity: viscosity.0,
                volume: volume.0,
                wave_speed: wave_speed.0,
                rate: rate.0,
            },
            ColumnsMut {
                stress: further,
                viscosity: viscosity.1,
                volume: volume.1,
                wave_speed: wave_speed.1,
                rate: rate.1,
            },
        )
    }

    /// A range of the particles.
    #[inline(always)]
    pub(crate) fn part(&mut self, range: Range<usize>) -> ColumnsMut<'_, S> {
        ColumnsMut {
            stress: self.stress.each_mut().map(|column| &mut column[range.clone()]),
            viscosity: &mut self.viscosity[range.clone()],
            volume: &mut self.volume[range.clone()],
            wave_speed: &mut self.wave_speed[range.clone()],
            rate: &mut self.rate[range],
        }
    }

    pub(crate) fn columns(&self) -> Columns<'_, S> {
        Columns {
            stress: self.stress.each_ref().map(|column| &**column),
            viscosity: self.viscosity,
            volume: self.volume,
            wave_speed: self.wave_speed,
            rate: self.rate,
        }
    }

    /// One particle.
    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> Condition<S> {
        self.columns().get(i)
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, condition: Condition<S>) {
        let Condition { stress, viscosity, volume, wave_speed, rate } = condition;
        for k in 0..6 {
            self.stress[k][i] = stress.0[k];
        }
        (self.viscosity[i], self.volume[i]) = (viscosity, volume);
        (self.wave_speed[i], self.rate[i]) = (wave_speed, rate);
    }
}

impl<S: CarriedNumber> Condition<S> {
    pub(crate) fn visit_numbers(&mut self, visit: &mut dyn FnMut(&mut S)) {
        let Self { stress, viscosity, volume, wave_speed, rate } = self;
        let mut number = S::constant(*rate);
        let others = [viscosity, volume, wave_speed, &mut number];
        stress.0.iter_mut().chain(others).for_each(visit);
        *rate = number.value();
    }
}
