//! Snapshots of a store, bitwise exact.

use std::io::{Read, Write};

use crate::bytes::{HashingReader, HashingWriter};
use crate::column::{Element, Values, of_any_kind};
use crate::error::Error;
use crate::store::{Attribute, Column, ParticleStore};
use crate::tensor::SymmetricTensor;

const MAGIC: [u8; 8] = *b"PARTSTOR";

/// Format version, incremented when the layout changes; older layouts are rejected.
const VERSION: u32 = 3;

/// Tags in the stream; the meaning of a tag never changes.
const REAL: u8 = 0;
const COUNT: u8 = 1;
const SCALAR: u8 = 0;
const POINT: u8 = 1;
const INTEGER: u8 = 2;
const INDEX: u8 = 3;
const TENSOR: u8 = 4;
const FLAG: u8 = 5;
const LABEL: u8 = 6;

impl<const D: usize> ParticleStore<D> {
    /// Writes ids, columns, attributes, generation and the next id; [`restore`](Self::restore) is bitwise exact.
    ///
    /// Little endian: `PARTSTOR`, version (u32), dimension (u32), then generation, next id and the numbers of
    /// particles, attributes and columns (u64 each). The attributes follow by name: tag (u8), name, 8 bytes; then the
    /// ids (u64). Then the columns in order: tag (u8), name, values. XXH64 of all preceding bytes (seed 0, u64) is
    /// last. A name is its length in bytes (u64) and UTF-8.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the writer fails.
    pub fn snapshot(&self, out: impl Write) -> Result<(), Error> {
        let mut out = HashingWriter::new(out);
        self.put(&mut out)?;
        out.finish()
    }

    /// Hash of the contents of a snapshot: bitwise identical stores have the same hash.
    ///
    /// It is XXH64: different stores collide accidentally once in 2^64; it is no protection against intent.
    #[must_use]
    pub fn content_hash(&self) -> u64 {
        let mut sink = HashingWriter::new(std::io::sink());
        // Writing to a sink cannot fail.
        let _ = self.put(&mut sink);
        sink.hash()
    }

    fn put<W: Write>(&self, out: &mut HashingWriter<W>) -> Result<(), Error> {
        out.put(MAGIC)?;
        out.put(VERSION)?;
        out.put(u32::try_from(D).unwrap_or(u32::MAX))?;
        out.put(self.generation)?;
        out.put(self.next_id)?;
        out.put(self.len() as u64)?;
        out.put(self.attributes.len() as u64)?;
        out.put(self.columns.len() as u64)?;
        for (name, value) in &self.attributes {
            let (tag, bits) = match value {
                Attribute::Real(value) => (REAL, value.to_bits()),
                Attribute::Count(value) => (COUNT, *value),
            };
            out.put(tag)?;
            out.put_text(name)?;
            out.put(bits)?;
        }
        out.put_all(&self.ids)?;
        for Column { name, values } in &self.columns {
            out.put(match values {
                Values::Scalar(_) => SCALAR,
                Values::Point(_) => POINT,
                Values::Integer(_) => INTEGER,
                Values::Index(_) => INDEX,
                Values::Tensor(_) => TENSOR,
                Values::Flag(_) => FLAG,
                Values::Label(_) => LABEL,
            })?;
            out.put_text(name)?;
            of_any_kind!(values, values => out.put_all(values)?);
        }
        Ok(())
    }

    /// Reads a snapshot and stops at its end.
    ///
    /// # Errors
    ///
    /// [`Error::NotASnapshot`], [`Error::UnsupportedVersion`], [`Error::DimensionMismatch`], [`Error::Truncated`],
    /// [`Error::Corrupt`] and [`Error::HashMismatch`] for an invalid snapshot or another dimension; [`Error::Io`] if
    /// the reader fails.
    pub fn restore(input: impl Read) -> Result<Self, Error> {
        let mut input = HashingReader::new(input);
        let found: [u8; 8] = input.take()?;
        if found != MAGIC {
            return Err(Error::NotASnapshot { found });
        }
        let found = input.take()?;
        if found != VERSION {
            return Err(Error::UnsupportedVersion { found, supported: VERSION });
        }
        let found = input.take()?;
        if usize::try_from(found) != Ok(D) {
            return Err(Error::DimensionMismatch { found, expected: D });
        }
        let [generation, next_id] = input.take()?;
        let [n_particles, n_attributes, n_columns]: [u64; 3] = input.take()?;
        let mut attributes = Vec::new();
        for _ in 0..n_attributes {
            attributes.push(take_attribute(&mut input)?);
        }
        let ids: Vec<u64> = input.take_all(n_particles)?;
        if ids.iter().any(|&id| id >= next_id) {
            return Err(Error::Corrupt { what: "an id is in use before it was given" });
        }
        let mut store = Self::of_ids(ids, next_id, generation);
        for (name, value) in attributes {
            if store.attributes.insert(name, value).is_some() {
                return Err(Error::Corrupt { what: "an attribute is named twice" });
            }
        }
        for _ in 0..n_columns {
            store.take_column(&mut input, n_particles)?;
        }
        input.finish()?;
        Ok(store)
    }

    fn take_column<R: Read>(&mut self, input: &mut HashingReader<R>, n: u64) -> Result<(), Error> {
        let tag: u8 = input.take()?;
        let name = input.take_text()?;
        match tag {
            SCALAR => self.add_restored(&name, input.take_all::<f64>(n)?),
            POINT => self.add_restored(&name, input.take_all::<[f64; D]>(n)?),
            INTEGER => self.add_restored(&name, input.take_all::<i64>(n)?),
            INDEX => self.add_restored(&name, input.take_all::<[i32; D]>(n)?),
            TENSOR => self.add_restored(&name, input.take_all::<SymmetricTensor>(n)?),
            FLAG => self.add_restored(&name, input.take_all::<u8>(n)?),
            LABEL => self.add_restored(&name, input.take_all::<u32>(n)?),
            _ => Err(Error::Corrupt { what: "a column is of no known kind" }),
        }
    }

    fn add_restored<T: Element<D>>(&mut self, name: &str, values: Vec<T>) -> Result<(), Error> {
        match self.add(name, values) {
            Ok(_) => Ok(()),
            Err(_) => Err(Error::Corrupt { what: "a column is named twice" }),
        }
    }
}

fn take_attribute<R: Read>(input: &mut HashingReader<R>) -> Result<(String, Attribute), Error> {
    let tag: u8 = input.take()?;
    let name = input.take_text()?;
    let bits: u64 = input.take()?;
    match tag {
        REAL => Ok((name, Attribute::Real(f64::from_bits(bits)))),
        COUNT => Ok((name, Attribute::Count(bits))),
        _ => Err(Error::Corrupt { what: "an attribute is of no known kind" }),
    }
}
