//! Buffers aligned to a cache line: a load or store of a register across two lines takes twice as long.

use std::ops::{Deref, DerefMut};

/// Bytes of a cache line, and its number of `f64`.
const LINE: usize = 64;
const NUMBERS: usize = LINE / size_of::<f64>();

/// A buffer of `f64` aligned to a cache line.
#[derive(Debug, Default)]
pub(crate) struct Aligned {
    numbers: Vec<f64>,
    start: usize,
    len: usize,
}

impl Aligned {
    /// Makes room for `n` numbers, which are left as they are or zero.
    pub(crate) fn resize(&mut self, n: usize) {
        if self.start + n > self.numbers.len() {
            self.numbers = vec![0.0; n + n / 2 + NUMBERS];
            // Where the offset is unknown, the buffer is that of the vector: right, and slower.
            self.start = self.numbers.as_ptr().align_offset(LINE);
            if self.start > NUMBERS {
                self.start = 0;
            }
        }
        self.len = n;
    }
}

impl Clone for Aligned {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.resize(self.len);
        copy.copy_from_slice(self);
        copy
    }
}

impl Deref for Aligned {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.numbers[self.start..self.start + self.len]
    }
}

impl DerefMut for Aligned {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.numbers[self.start..self.start + self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_aligned_and_has_the_length_asked_for() {
        let mut buffer = Aligned::default();
        assert!(buffer.is_empty());
        for n in [3, 40, 7, 41, 200] {
            buffer.resize(n);
            assert_eq!((buffer.len(), buffer.as_ptr().addr() % LINE), (n, 0), "{n} numbers");
            buffer.fill(1.0);
        }
    }
}
