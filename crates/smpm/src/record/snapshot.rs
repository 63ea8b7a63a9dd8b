//! A simulation as columns of numbers, and back.

use std::io::{Read, Write};

use particle_store::{Attribute, ParticleStore};

use crate::error::Error;
use crate::number::CarriedNumber;
use crate::points::body::Body;

/// What a simulation holds besides its particles.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Clock {
    pub(crate) time: f64,
    pub(crate) n_steps: u64,
    pub(crate) supplied: f64,
    /// The longest step, body and particle that ask for it.
    pub(crate) limit: (f64, usize, usize),
    /// What gravity and planes have given.
    pub(crate) sums: Vec<f64>,
}

/// Columns of a body, in the order of memory.
pub(crate) struct Columns {
    /// The numbers of the particles.
    pub(crate) number: Vec<u32>,
    /// By number, then part, then particle.
    columns: Vec<Vec<f64>>,
}

impl Columns {
    fn of<S: CarriedNumber, const D: usize>(body: &Body<S, D>) -> Option<Self> {
        let number = body.particles.number.clone();
        let mut columns: Vec<Vec<f64>> = vec![];
        for place in 0..number.len() {
            let mut next = 0;
            let is_whole = body.show_numbers(place, &mut |value: &mut S| {
                for part in 0..S::PARTS {
                    if columns.len() == next {
                        columns.push(Vec::with_capacity(number.len()));
                    }
                    columns[next].push(value.part(part));
                    next += 1;
                }
            });
            if !is_whole {
                return None;
            }
        }
        Some(Self { number, columns })
    }

    fn put<S: CarriedNumber, const D: usize>(&self, body: &mut Body<S, D>) {
        body.particles.number.clone_from(&self.number);
        for place in 0..self.number.len() {
            let mut next = 0;
            let _ = body.visit_numbers(place, &mut |value: &mut S| {
                *value = S::from_parts(|part| self.columns[next + part][place]);
                next += S::PARTS;
            });
        }
        body.renumbered();
    }
}

/// The name of a column in the store.
fn name(column: usize, parts: usize) -> String {
    format!("number {} part {}", column / parts, column % parts)
}

/// Writes all bodies, one store after the other; the clock is in each.
pub(crate) fn write<S: CarriedNumber, const D: usize>(
    bodies: &[Body<S, D>],
    clock: &Clock,
    mut writer: impl Write,
) -> Result<(), Error> {
    let n_bodies = bodies.len();
    for (k, body) in bodies.iter().enumerate() {
        let Some(Columns { number, columns }) = Columns::of(body) else {
            return Err(Error::MaterialNotStored { body: k });
        };
        let mut store = ParticleStore::<D>::new(number.len());
        let Clock { time, n_steps, supplied, limit: (dt, of_body, particle), ref sums } = *clock;
        for (number, &sum) in sums.iter().enumerate() {
            store.set_attribute(&format!("sum {number}"), Attribute::Real(sum));
        }
        for (name, value) in [("time", time), ("supplied", supplied), ("longest step", dt)] {
            store.set_attribute(name, Attribute::Real(value));
        }
        let counts = [n_bodies, of_body, particle, S::PARTS].map(|count| count as u64);
        for (name, value) in ["n_bodies", "limiting body", "limiting particle", "parts"]
            .into_iter()
            .zip(counts)
            .chain([("n_steps", n_steps)])
        {
            store.set_attribute(name, Attribute::Count(value));
        }
        store.add("number", number).map_err(|error| Error::store(&error))?;
        for (column, values) in columns.into_iter().enumerate() {
            store.add(&name(column, S::PARTS), values).map_err(|error| Error::store(&error))?;
        }
        store.snapshot(&mut writer).map_err(|error| Error::store(&error))?;
    }
    Ok(())
}

/// Reads what was written for bodies like these, with so many sums in the clock; they are changed only if all of it fits.
pub(crate) fn read<S: CarriedNumber, const D: usize>(
    bodies: &mut [Body<S, D>],
    n_sums: usize,
    mut reader: impl Read,
) -> Result<Clock, Error> {
    let mut all = vec![];
    let mut clock = None;
    for (k, body) in bodies.iter().enumerate() {
        let store =
            ParticleStore::<D>::restore(&mut reader).map_err(|error| Error::store(&error))?;
        // What a body like this one would write.
        let Some(expected) = Columns::of(body) else {
            return Err(Error::MaterialNotStored { body: k });
        };
        fits("bodies", count(&store, "n_bodies")?, bodies.len())?;
        fits("parts of a number", count(&store, "parts")?, S::PARTS)?;
        fits("particles", store.len(), expected.number.len())?;
        fits("columns", store.columns().len(), expected.columns.len() + 1)?;
        clock = Some(read_clock(&store, n_sums)?);
        all.push(read_columns(&store, expected.columns.len(), S::PARTS)?);
    }
    for (body, columns) in bodies.iter_mut().zip(&all) {
        columns.put(body);
    }
    clock.ok_or(Error::NoBody)
}

fn count<const D: usize>(store: &ParticleStore<D>, name: &'static str) -> Result<usize, Error> {
    match store.attribute(name) {
        Some(Attribute::Count(count)) => Ok(usize::try_from(count).unwrap_or(usize::MAX)),
        _ => Err(Error::ForeignSnapshot { quantity: name, found: 0, expected: 1 }),
    }
}

fn real<const D: usize>(store: &ParticleStore<D>, name: &'static str) -> Result<f64, Error> {
    match store.attribute(name) {
        Some(Attribute::Real(value)) => Ok(value),
        _ => Err(Error::ForeignSnapshot { quantity: name, found: 0, expected: 1 }),
    }
}

fn finite<const D: usize>(store: &ParticleStore<D>, name: &'static str) -> Result<f64, Error> {
    match real(store, name)? {
        value if value.is_finite() => Ok(value),
        value => Err(Error::SnapshotNumber { quantity: name, value }),
    }
}

fn fits(quantity: &'static str, found: usize, expected: usize) -> Result<(), Error> {
    if found == expected {
        Ok(())
    } else {
        Err(Error::ForeignSnapshot { quantity, found, expected })
    }
}

fn read_clock<const D: usize>(store: &ParticleStore<D>, n_sums: usize) -> Result<Clock, Error> {
    let sum = |number| match store.attribute(&format!("sum {number}")) {
        Some(Attribute::Real(sum)) if sum.is_finite() => Some(sum),
        _ => None,
    };
    let sums: Vec<f64> = (0..).map_while(sum).collect();
    fits("sums of gravity and planes", sums.len(), n_sums)?;
    Ok(Clock {
        sums,
        time: finite(store, "time")?,
        n_steps: count(store, "n_steps")? as u64,
        supplied: finite(store, "supplied")?,
        limit: (
            real(store, "longest step")?,
            count(store, "limiting body")?,
            count(store, "limiting particle")?,
        ),
    })
}

/// So many columns, and the numbers of the particles: each of them once.
fn read_columns<const D: usize>(
    store: &ParticleStore<D>,
    n_columns: usize,
    parts: usize,
) -> Result<Columns, Error> {
    let handle = store.handle::<u32>("number").map_err(|error| Error::store(&error))?;
    let number = store.get(handle).map_err(|error| Error::store(&error))?.to_vec();
    let mut seen = vec![false; number.len()];
    for &one in &number {
        match seen.get_mut(one as usize) {
            Some(seen) if !*seen => *seen = true,
            _ => fits("numbers of particles", one as usize, number.len())?,
        }
    }
    let columns = (0..n_columns)
        .map(|column| {
            let handle = store.handle::<f64>(&name(column, parts))?;
            Ok(store.get(handle)?.to_vec())
        })
        .collect::<Result<_, _>>()
        .map_err(|error| Error::store(&error))?;
    Ok(Columns { number, columns })
}
