//! Values as little-endian bytes, hashed on input and output.

use std::hash::Hasher;
use std::io::{ErrorKind, Read, Write};

use twox_hash::XxHash64;

use crate::error::Error;
use crate::tensor::SymmetricTensor;

/// Values moved between buffer and stream at a time.
const CHUNK: usize = 1024;

/// Largest number of values allocated from an unverified length.
const BELIEVED: usize = 1 << 16;

/// A value with a fixed number of bytes. Floating-point numbers keep every bit, including NaN.
pub trait Bytes: Copy {
    /// Number of bytes.
    const SIZE: usize;
    /// Writes the first `SIZE` bytes.
    fn put(self, out: &mut [u8]);
    /// Reads the first `SIZE` bytes.
    fn take(bytes: &[u8]) -> Self;
}

macro_rules! little_endian {
    ($($number:ty),*) => {$(
        impl Bytes for $number {
            const SIZE: usize = size_of::<$number>();
            fn put(self, out: &mut [u8]) {
                out[..Self::SIZE].copy_from_slice(&self.to_le_bytes());
            }
            fn take(bytes: &[u8]) -> Self {
                let mut own = [0; size_of::<$number>()];
                own.copy_from_slice(&bytes[..Self::SIZE]);
                Self::from_le_bytes(own)
            }
        }
    )*};
}
little_endian!(u8, u32, u64, i32, i64, f64);

impl<T: Bytes, const D: usize> Bytes for [T; D] {
    const SIZE: usize = D * T::SIZE;
    fn put(self, out: &mut [u8]) {
        for (value, out) in self.into_iter().zip(out.chunks_exact_mut(T::SIZE)) {
            value.put(out);
        }
    }
    fn take(bytes: &[u8]) -> Self {
        core::array::from_fn(|k| T::take(&bytes[k * T::SIZE..]))
    }
}

impl Bytes for SymmetricTensor {
    const SIZE: usize = <[f64; 6]>::SIZE;
    fn put(self, out: &mut [u8]) {
        self.0.put(out);
    }
    fn take(bytes: &[u8]) -> Self {
        Self(<[f64; 6]>::take(bytes))
    }
}

/// Writes values and hashes the written bytes.
#[derive(Debug)]
pub(crate) struct HashingWriter<W> {
    inner: W,
    hash: XxHash64,
    buffer: Vec<u8>,
}

impl<W: Write> HashingWriter<W> {
    pub(crate) fn new(inner: W) -> Self {
        Self { inner, hash: XxHash64::default(), buffer: Vec::new() }
    }

    pub(crate) fn put<T: Bytes>(&mut self, value: T) -> Result<(), Error> {
        self.put_all(&[value])
    }

    pub(crate) fn put_all<T: Bytes>(&mut self, values: &[T]) -> Result<(), Error> {
        for chunk in values.chunks(CHUNK) {
            self.buffer.resize(chunk.len() * T::SIZE, 0);
            for (value, bytes) in chunk.iter().zip(self.buffer.chunks_exact_mut(T::SIZE)) {
                value.put(bytes);
            }
            self.hash.write(&self.buffer);
            self.inner.write_all(&self.buffer)?;
        }
        Ok(())
    }

    /// Writes a text after its length.
    pub(crate) fn put_text(&mut self, text: &str) -> Result<(), Error> {
        self.put(text.len() as u64)?;
        self.put_all(text.as_bytes())
    }

    pub(crate) fn hash(&self) -> u64 {
        self.hash.finish()
    }

    /// Writes the hash of all preceding bytes, and flushes.
    pub(crate) fn finish(mut self) -> Result<(), Error> {
        let hash = self.hash();
        self.put(hash)?;
        Ok(self.inner.flush()?)
    }
}

/// Reads values and hashes the bytes read.
#[derive(Debug)]
pub(crate) struct HashingReader<R> {
    inner: R,
    hash: XxHash64,
    buffer: Vec<u8>,
}

impl<R: Read> HashingReader<R> {
    pub(crate) fn new(inner: R) -> Self {
        Self { inner, hash: XxHash64::default(), buffer: Vec::new() }
    }

    pub(crate) fn take<T: Bytes>(&mut self) -> Result<T, Error> {
        self.fill(T::SIZE)?;
        Ok(T::take(&self.buffer))
    }

    /// Reads `count` values. Memory grows with the data present, not with the stated count.
    pub(crate) fn take_all<T: Bytes>(&mut self, count: u64) -> Result<Vec<T>, Error> {
        let mut left = usize::try_from(count).map_err(|_| Error::Truncated)?;
        let mut values = Vec::with_capacity(left.min(BELIEVED));
        while left > 0 {
            let now = left.min(CHUNK);
            self.fill(now * T::SIZE)?;
            values.extend(self.buffer.chunks_exact(T::SIZE).map(T::take));
            left -= now;
        }
        Ok(values)
    }

    pub(crate) fn take_text(&mut self) -> Result<String, Error> {
        let length = self.take()?;
        String::from_utf8(self.take_all(length)?)
            .map_err(|_| Error::Corrupt { what: "a name is not UTF-8" })
    }

    /// Compares the hash of all preceding bytes with the stored one.
    pub(crate) fn finish(mut self) -> Result<(), Error> {
        let computed = self.hash.finish();
        let stored = self.take()?;
        if stored == computed { Ok(()) } else { Err(Error::HashMismatch { stored, computed }) }
    }

    fn fill(&mut self, length: usize) -> Result<(), Error> {
        self.buffer.resize(length, 0);
        self.inner.read_exact(&mut self.buffer).map_err(|error| match error.kind() {
            ErrorKind::UnexpectedEof => Error::Truncated,
            _ => Error::Io(error),
        })?;
        self.hash.write(&self.buffer);
        Ok(())
    }
}
