//! Memory aligned for full vectors.

/// Memory whose first entry is at the beginning of a cache line, so that no full vector crosses one.
#[derive(Debug, Default)]
pub(crate) struct Aligned<T> {
    memory: Vec<T>,
    offset: usize,
}

/// Bytes of a cache line.
const LINE: usize = 64;

impl<T: Copy + Default> Aligned<T> {
    /// Grows to at least `len` entries; the previous contents are lost.
    pub(crate) fn grow(&mut self, len: usize) {
        let line = LINE / size_of::<T>();
        if self.len() < len {
            self.memory.clear();
            self.memory.resize(len + line, T::default());
            // Where alignment is not possible, any offset is correct.
            self.offset = self.memory.as_ptr().align_offset(LINE).min(line);
        }
    }
}

impl<T: Copy + Default> Clone for Aligned<T> {
    /// Empty memory: its contents are irrelevant between two uses.
    fn clone(&self) -> Self {
        Self { memory: Vec::new(), offset: 0 }
    }
}

impl<T> core::ops::Deref for Aligned<T> {
    type Target = [T];
    #[inline(always)]
    fn deref(&self) -> &[T] {
        &self.memory[self.offset..]
    }
}

impl<T> core::ops::DerefMut for Aligned<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.memory[self.offset..]
    }
}
